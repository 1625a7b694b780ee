//! Values set at events and between them, in Model Exchange.

use super::*;

/// A host's solver leaves a moving closed stop slightly off its gap, on either side. This is
/// neither a violation nor an opening.
#[test]
fn closed_form_a_parameter_that_is_set_on_a_moving_base() {
    let text = "name = \"Shaken\"\ngravity = 10.0\n[body.base]\nmotion = { amplitude = 0.1, frequency = 0.5, phase = 0.5 }\n\
                dimension = \"translation\"\n[body.box]\nmass = 2.0\ngravity = -1.0\nstart = { s = 0.5 }\n\
                [stop.floor]\nbetween = [\"box\", \"base\"]\ngap = 0.0\nrestitution = 0.0\n";
    let plan = Plan::new(text.into(), FILE).unwrap();
    let mut messages = Vec::new();
    let host = Host::begin(made("moving base", &plan, &mut messages));
    // Rounding of doubles near 0.1 and of forces near 1 N.
    const ROUNDING: f64 = 1e-15;
    let base = |time: f64| {
        let w = std::f64::consts::PI;
        let (sine, cosine) = (w * time + 0.5).sin_cos();
        [0.1 * sine, 0.1 * w * cosine, -0.1 * w * w * sine]
    };
    // The box falls onto the base, and stays.
    let [place, rate, _] = base(1.0);
    host.at(1.0, &[place - 1e-9, rate - 1.0]);
    unsafe { assert_eq!(fmi3EnterEventMode(host.c), OK) };
    assert!(host.handle().0);
    for (time, off) in [(1.1, 1e-8), (1.2, -1e-8)] {
        let [place, rate, a] = base(time);
        host.at(time, &[place + off, rate + off]);
        assert!(!host.accept());
        unsafe { assert_eq!(fmi3EnterEventMode(host.c), OK) };
        set(&host, &plan, "body.box.mass", 2.0 + time);
        host.handle();
        let x = host.states();
        assert!((x[0] - place).abs() < ROUNDING && (x[1] - rate).abs() < ROUNDING, "{off} {x:?}");
        assert!((host.at(time, &x).0[1] - a).abs() < 100.0 * ROUNDING, "{off}");
    }
    unsafe { fmi3FreeInstance(host.c) };
}

/// An impossible value is refused when the event ends, and has no effect after it is corrected.
#[test]
fn by_fmi_2_an_event_does_not_end_with_what_is_not_possible() {
    let text = "name = \"Base\"\n[body.base]\nmotion = { input = true }\ndimension = \"translation\"\n\
                [body.b]\nmass = 1.0\nstart = { s = 0.3, v = -1.0 }\n\
                [stop.p]\nbetween = [\"b\", \"base\"]\ngap = 0.0\nrestitution = 0.5\n";
    let plan = Plan::new(text.into(), FILE).unwrap();
    let uri = CString::new(format!("file://{}", resources("impossible2", &plan).display())).unwrap();
    let token = CString::new(plan.token()).unwrap();
    let input = plan.table.reference("body.base.motion.input").unwrap();
    unsafe {
        let c = fmi2Instantiate(c"a".as_ptr(), 0, token.as_ptr(), uri.as_ptr(), null(), 0, 0);
        assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi2EnterInitializationMode(c), OK);
        assert_eq!(fmi2ExitInitializationMode(c), OK);
        // 0.2 m inside the body.
        assert_eq!(fmi2SetReal(c, &input, 1, &0.5), OK);
        assert_eq!(fmi2EnterContinuousTimeMode(c), ERROR);
        assert_eq!(fmi2SetContinuousStates(c, [1.0, 1.0].as_ptr(), 2), ERROR);
        assert_eq!(fmi2SetReal(c, &input, 1, &0.1), OK);
        assert_eq!(fmi2EnterContinuousTimeMode(c), OK);
        for x in [[0.2, -1.0], [0.15, -0.5]] {
            assert_eq!(fmi2SetContinuousStates(c, x.as_ptr(), 2), OK);
            let (mut is, mut slope, mut e) = ([f64::NAN; 2], [f64::NAN; 2], f64::NAN);
            assert_eq!(fmi2GetReal(c, &plan.table.reference("p.e").unwrap(), 1, &mut e), OK);
            assert_eq!(fmi2GetContinuousStates(c, is.as_mut_ptr(), 2), OK);
            assert_eq!(fmi2GetDerivatives(c, slope.as_mut_ptr(), 2), OK);
            assert_eq!((is, slope, e), (x, [x[1], 0.0], 0.1 - x[0]));
        }
        fmi2FreeInstance(c);
    }
}

/// Work and losses of a step after an input set between events, for motion from rest against a
/// dashpot.
#[test]
fn closed_form_losses_after_an_input_that_is_set_between_events() {
    // Error of a polynomial of degree 5 instead of the exponential: (0.1 / 2)^6 / 6! of 1 J.
    const POLYNOMIAL: f64 = 1e-9;
    let text = "name = \"Braked\"\n[body.sled]\nmass = 1.0\n[load.push]\non = \"sled\"\ninput = true\n\
                [spring.oil]\nbetween = [\"ground\", \"sled\"]\nstiffness = 0.0\ndamping = 1.0\n";
    let plan = Plan::new(text.into(), FILE).unwrap();
    let mut messages = Vec::new();
    let host = Host::begin(made("braked", &plan, &mut messages));
    set(&host, &plan, "load.push.input", 10.0);
    let t = 0.1f64;
    let gone = -(-t).exp_m1();
    let place = 10.0 * (t - gone);
    host.at(t, &[place, 10.0 * gone]);
    let read = |name: &str| {
        let (reference, mut value) = (plan.table.reference(name).unwrap(), f64::NAN);
        assert_eq!(unsafe { fmi3GetFloat64(host.c, &reference, 1, &mut value, 1) }, OK);
        value
    };
    let lost = 100.0 * (t - 2.0 * gone - 0.5 * (-2.0 * t).exp_m1());
    assert!((read("energy.lost") - lost).abs() < POLYNOMIAL, "{} {lost}", read("energy.lost"));
    assert!((read("energy.work") - 10.0 * place).abs() < POLYNOMIAL);
    assert!(read("energy.residual").abs() < POLYNOMIAL);
    unsafe { fmi3FreeInstance(host.c) };
}

/// CasADi sets states one by one; other variables, and states at an event, are refused by name.
#[test]
fn second_method_states_that_are_set_by_value_references_are_those_set_together() {
    let text = "name = \"Geared\"\n[body.a]\nmass = 2.0\n[body.b]\nmass = 1.0\n[link.l]\narms = { a = 1.0, b = -0.25 }\n\
                [spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 50.0\ndamping = 1.0\n";
    let plan = Plan::new(text.into(), FILE).unwrap();
    let mut messages = Vec::new();
    let host = Host::begin(made("one by one", &plan, &mut messages));
    let state = &plan.assembly.description.bodies[plan.assembly.states()[0]].name;
    let other = if state == "a" { "b" } else { "a" };
    let together = host.at(0.25, &[0.5, -2.0]).0;
    host.at(0.25, &[0.0, 0.0]);
    set(&host, &plan, &format!("{state}.v"), -2.0);
    set(&host, &plan, &format!("{state}.s"), 0.5);
    let (mut slope, mut states) = ([f64::NAN; 2], [f64::NAN; 2]);
    unsafe {
        assert_eq!(fmi3GetContinuousStates(host.c, states.as_mut_ptr(), 2), OK);
        assert_eq!(fmi3GetContinuousStateDerivatives(host.c, slope.as_mut_ptr(), 2), OK);
    }
    assert_eq!((states, slope.to_vec()), ([0.5, -2.0], together));
    let refused = |name: &str, value: f64| {
        let reference = plan.table.reference(name).unwrap();
        unsafe { fmi3SetFloat64(host.c, &reference, 1, &value, 1) }
    };
    assert_eq!(refused(&format!("{state}.s"), f64::NAN), DISCARD);
    unsafe {
        assert_eq!(fmi3GetContinuousStates(host.c, states.as_mut_ptr(), 2), OK);
        assert_eq!(states, [0.5, -2.0]);
        assert_eq!(fmi3EnterEventMode(host.c), OK);
    }
    assert_eq!(refused(&format!("{state}.s"), 0.75), ERROR);
    let last = messages.last().unwrap();
    assert!(last.contains(&format!("{state}.s cannot be set at an event")), "{messages:?}");
    unsafe { fmi3FreeInstance(host.c) };
    let host = Host::begin(made("one by one", &plan, &mut messages));
    let reference = plan.table.reference(&format!("{other}.s")).unwrap();
    assert_eq!(unsafe { fmi3SetFloat64(host.c, &reference, 1, &0.5, 1) }, ERROR);
    let last = messages.last().unwrap();
    assert!(last.ends_with("between events: only inputs and continuous states can be set"), "{messages:?}");
    unsafe { fmi3FreeInstance(host.c) };
}
