//! Model Exchange by both versions, with a host that uses only the C interface.

mod sets;

use crate::host::*;
use crate::*;
use fmi_doors::fmi3::abi::FmiInstance;
use std::ffi::CString;
use std::ptr::{null, null_mut};
use vibro_machine_component::{FILE, Plan};

/// An instance of FMI 3.0 for Model Exchange.
fn made(folder: &str, plan: &Plan, messages: &mut Vec<String>) -> FmiInstance {
    let path = CString::new(resources(folder, plan).to_str().unwrap()).unwrap();
    let token = CString::new(plan.token()).unwrap();
    let environment = std::ptr::from_mut(messages).cast();
    let (name, log) = (c"a".as_ptr(), Some(keep as _));
    unsafe { fmi3InstantiateModelExchange(name, token.as_ptr(), path.as_ptr(), 0, 1, environment, log) }
}

/// The calls of a host's solver.
struct Host {
    c: FmiInstance,
    states: usize,
    indicators: usize,
}

impl Host {
    fn begin(c: FmiInstance) -> Self {
        let (mut states, mut indicators) = (0, 0);
        unsafe {
            assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), OK);
            assert_eq!(fmi3GetNumberOfContinuousStates(c, &mut states), OK);
            assert_eq!(fmi3GetNumberOfEventIndicators(c, &mut indicators), OK);
            assert_eq!(fmi3ExitInitializationMode(c), OK);
        }
        let host = Self { c, states, indicators };
        host.handle();
        host
    }

    /// Handles an event. Returns whether states have changed, and the time of the next event, if
    /// known.
    fn handle(&self) -> (bool, Option<f64>) {
        let (mut changed, mut defined, mut next) = (0, 0, 0.0);
        let (mut again, mut end, mut nominals) = (0, 0, 0);
        unsafe {
            let (again, end, nominals) = (&mut again, &mut end, &mut nominals);
            let (defined, next) = (&mut defined, &mut next);
            assert_eq!(
                fmi3UpdateDiscreteStates(self.c, again, end, nominals, &mut changed, defined, next),
                OK
            );
            assert_eq!(fmi3EnterContinuousTimeMode(self.c), OK);
        }
        (changed != 0, (defined != 0).then_some(next))
    }

    fn states(&self) -> Vec<f64> {
        let mut x = vec![0.0; self.states];
        unsafe { assert_eq!(fmi3GetContinuousStates(self.c, x.as_mut_ptr(), self.states), OK) };
        x
    }

    /// Returns the derivatives at a point, and the smallest indicator.
    fn at(&self, time: f64, x: &[f64]) -> (Vec<f64>, f64) {
        let (mut slope, mut z) = (vec![0.0; self.states], vec![0.0; self.indicators]);
        unsafe {
            assert_eq!(fmi3SetTime(self.c, time), OK);
            assert_eq!(fmi3SetContinuousStates(self.c, x.as_ptr(), self.states), OK);
            assert_eq!(fmi3GetContinuousStateDerivatives(self.c, slope.as_mut_ptr(), self.states), OK);
            assert_eq!(fmi3GetEventIndicators(self.c, z.as_mut_ptr(), self.indicators), OK);
        }
        (slope, z.into_iter().fold(f64::INFINITY, f64::min))
    }

    /// Accepts a point; returns whether an event has to be handled there.
    fn accept(&self) -> bool {
        let (mut event, mut end) = (0, 0);
        unsafe { assert_eq!(fmi3CompletedIntegratorStep(self.c, 1, &mut event, &mut end), OK) };
        event != 0
    }
}

#[test]
fn closed_form_a_ball_by_a_hosts_solver() {
    let plan = plan("bouncing_ball.toml", unchanged);
    let mut messages = Vec::new();
    let host = Host::begin(made("exchanged", &plan, &mut messages));
    assert_eq!((host.states, host.indicators), (2, 1));
    // A second-order method is exact for a parabola: the impact is at sqrt(2 h/g), with speed
    // sqrt(2 g h).
    let (g, mut time, mut bounces) = (9.81f64, 0.0, 0);
    let mut state = null_mut();
    while bounces < 3 {
        let x = host.states();
        let h = (x[1].mul_add(x[1], 2.0 * g * (1.0 - x[0])).sqrt() - x[1]) / g;
        // Slightly beyond the stop, where a root search ends.
        let h = h * (1.0 + 1e-10);
        let (slope, _) = host.at(time, &x);
        let next = [x[0] + h * (slope[0] + 0.5 * h * slope[1]), x[1] + h * slope[1]];
        time += h;
        assert!(host.at(time, &next).1 <= 0.0);
        assert!(host.accept());
        unsafe {
            assert_eq!(fmi3EnterEventMode(host.c), OK);
            if bounces == 1 {
                assert_eq!(fmi3GetFMUState(host.c, &mut state), OK);
            }
        }
        assert_eq!(host.handle(), (true, None));
        bounces += 1;
        let after = host.states();
        // Overshoot of an event.
        let expected = -(2.0 * g).sqrt() * 0.9f64.powi(bounces);
        assert!(after[0] == 1.0 && (after[1] - expected).abs() < 1e-8, "{after:?} {expected}");
        assert!(host.at(time, &after).1 > 0.0);
    }
    // A state saved before an event's law continues identically.
    let third = host.states();
    unsafe {
        assert_eq!(fmi3SetFMUState(host.c, state), OK);
        assert_eq!(host.handle(), (true, None));
        assert!(host.states()[1] < third[1]);
        let mut value = f64::NAN;
        let residual = plan.table.reference("energy.residual").unwrap();
        assert_eq!(fmi3GetFloat64(host.c, &residual, 1, &mut value, 1), OK);
        assert!(value.abs() < 1e-9, "{value}");
        assert_eq!(fmi3FreeFMUState(host.c, &mut state), OK);
        fmi3FreeInstance(host.c);
    }
}

#[test]
fn closed_form_a_knot_is_a_time_event_and_its_left_side_is_the_solvers() {
    let text =
        "name = \"Sled\"\n[body.sled]\nmass = 4.0\n[load.push]\non = \"sled\"\nsteps = [[0.25, 8.0]]\n";
    let plan = Plan::new(text.into(), FILE).unwrap();
    let mut messages = Vec::new();
    let c = made("knot", &plan, &mut messages);
    unsafe {
        assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi3ExitInitializationMode(c), OK);
    }
    let host = Host { c, states: 2, indicators: 0 };
    assert_eq!(host.handle(), (false, Some(0.25)));
    // At the knot the load jumps only when the event is handled.
    assert_eq!(host.at(0.25, &[0.0, 0.0]).0, [0.0, 0.0]);
    assert!(host.accept());
    unsafe { assert_eq!(fmi3EnterEventMode(c), OK) };
    // States are reported as changed, so that the solver restarts: fmusim would continue with its
    // old step data otherwise.
    assert_eq!(host.handle(), (true, None));
    assert_eq!(host.at(0.25, &[0.0, 0.0]).0, [0.0, 2.0]);
    // An input is set between events, a tunable parameter at an event.
    let mass = plan.table.reference("body.sled.mass").unwrap();
    unsafe {
        assert_eq!(fmi3SetFloat64(c, &mass, 1, &8.0, 1), ERROR, "{messages:?}");
        assert!(
            messages.last().unwrap().contains("body.sled.mass cannot be set between events"),
            "{messages:?}"
        );
        fmi3FreeInstance(c);
    }
}

#[test]
fn closed_form_by_fmi_2_with_an_input_and_a_changed_mass() {
    let text = "name = \"Sled\"\n[body.sled]\nmass = 4.0\n[load.push]\non = \"sled\"\ninput = true\n";
    let plan = Plan::new(text.into(), FILE).unwrap();
    let uri = CString::new(format!("file://{}", resources("exchange2", &plan).display())).unwrap();
    let token = CString::new(plan.token()).unwrap();
    let reference = |name: &str| plan.table.reference(name).unwrap();
    unsafe {
        let c = fmi2Instantiate(c"a".as_ptr(), 0, token.as_ptr(), uri.as_ptr(), null(), 0, 0);
        assert!(!c.is_null());
        assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi2EnterInitializationMode(c), OK);
        assert_eq!(fmi2SetReal(c, &reference("load.push.input"), 1, &2.0), OK);
        let mut slope = [f64::NAN; 2];
        assert_eq!(fmi2GetDerivatives(c, slope.as_mut_ptr(), 2), OK);
        assert_eq!(slope, [0.0, 0.5]);
        assert_eq!(fmi2ExitInitializationMode(c), OK);
        assert_eq!(fmi2EnterContinuousTimeMode(c), OK);
        assert_eq!(fmi2SetTime(c, 0.5), OK);
        assert_eq!(fmi2SetContinuousStates(c, [3.0, 1.0].as_ptr(), 2), OK);
        assert_eq!(fmi2SetReal(c, &reference("load.push.input"), 1, &6.0), OK);
        assert_eq!(fmi2GetDerivatives(c, slope.as_mut_ptr(), 2), OK);
        assert_eq!(slope, [1.0, 1.5]);
        assert_eq!(fmi2EnterEventMode(c), OK);
        assert_eq!(fmi2SetReal(c, &reference("body.sled.mass"), 1, &3.0), OK);
        assert_eq!(fmi2EnterContinuousTimeMode(c), OK);
        assert_eq!(fmi2GetDerivatives(c, slope.as_mut_ptr(), 2), OK);
        assert_eq!(slope, [1.0, 2.0]);
        let mut x = [0.0; 2];
        assert_eq!(fmi2GetContinuousStates(c, x.as_mut_ptr(), 2), OK);
        assert_eq!(x, [3.0, 1.0]);
        assert_eq!(fmi2SetContinuousStates(c, [f64::NAN, 1.0].as_ptr(), 2), ERROR);
        assert_eq!(fmi2GetContinuousStates(c, x.as_mut_ptr(), 2), OK);
        assert_eq!(x, [3.0, 1.0]);
        fmi2FreeInstance(c);
    }
}

#[test]
fn closed_form_the_jacobian_of_a_spring() {
    let text = "name = \"Osc\"\n[body.b]\nmass = 2.0\n[spring.k]\nbetween = [\"ground\", \"b\"]\nstiffness = 50.0\ndamping = 1.0\n";
    let plan = Plan::new(text.into(), FILE).unwrap();
    let mut messages = Vec::new();
    let c = made("jacobian", &plan, &mut messages);
    let host = Host::begin(c);
    host.at(0.0, &[0.25, -1.0]);
    let reference = |name: &str| plan.table.reference(name).unwrap();
    let (unknowns, knowns) = ([reference("b.v"), reference("b.a")], [reference("b.s"), reference("b.v")]);
    let mut along = [0.0; 2];
    for (seed, expected) in [([1.0, 0.0], [0.0, -25.0]), ([0.0, 1.0], [1.0, -0.5])] {
        unsafe {
            let (u, k, out) = (unknowns.as_ptr(), knowns.as_ptr(), along.as_mut_ptr());
            assert_eq!(
                fmi3GetDirectionalDerivative(c, u, 2, k, 2, seed.as_ptr(), 2, out, 2),
                OK,
                "{messages:?}"
            );
        }
        // Rounding of a division by the mass through its Cholesky factor.
        assert!(
            along.iter().zip(expected).all(|(a, b): (&f64, f64)| (a - b).abs() <= 1e-15 * b.abs()),
            "{along:?}"
        );
    }
    unsafe { fmi3FreeInstance(c) };
}

/// Sets a variable at an event.
fn set(host: &Host, plan: &Plan, name: &str, value: f64) {
    let reference = plan.table.reference(name).unwrap();
    assert_eq!(unsafe { fmi3SetFloat64(host.c, &reference, 1, &value, 1) }, OK, "{name}");
}

/// The friction of a brake whose level is only an input equals the host's value.
#[test]
fn closed_form_a_brake_that_a_host_presses_acts_at_once() {
    let text = "name = \"Brake\"\n[body.sled]\nmass = 2.0\nstart = { v = 3.0 }\n\
                [friction.brake]\nbetween = [\"ground\", \"sled\"]\nforce = { input = true }\n";
    let plan = Plan::new(text.into(), FILE).unwrap();
    let mut messages = Vec::new();
    let host = Host::begin(made("brake", &plan, &mut messages));
    unsafe { assert_eq!(fmi3EnterEventMode(host.c), OK) };
    set(&host, &plan, "friction.brake.force.input", 4.0);
    assert_eq!(host.handle(), (true, None));
    assert_eq!(host.at(0.5, &[1.5, 3.0]).0, [3.0, -2.0]);
    // Between events an indicator shows that the brake is released, and pressed again.
    for (level, slope) in [(-1.0, 0.0), (2.0, -1.0)] {
        set(&host, &plan, "friction.brake.force.input", level);
        assert!(host.at(1.0, &[2.0, 3.0]).1 <= 0.0, "{level}");
        assert!(host.accept());
        unsafe { assert_eq!(fmi3EnterEventMode(host.c), OK) };
        assert_eq!(host.handle(), (true, None));
        assert_eq!(host.at(1.0, &[2.0, 3.0]).0, [3.0, slope]);
    }
    unsafe { fmi3FreeInstance(host.c) };
}

#[test]
fn closed_form_a_buffer_that_a_jump_of_its_base_takes_away_has_no_force() {
    let text = "name = \"Base\"\n[body.base]\nmotion = { input = true }\ndimension = \"translation\"\n\
                [body.b]\nmass = 1.0\nstart = { s = 0.11, v = 1.0 }\n\
                [stop.p]\nbetween = [\"base\", \"b\"]\ngap = 0.1\nstiffness = 100.0\ndamping = 20.0\n";
    let plan = Plan::new(text.into(), FILE).unwrap();
    let mut messages = Vec::new();
    let host = Host::begin(made("jumping base", &plan, &mut messages));
    let x = host.states();
    let near = |slope: &[f64], a: f64| (slope[1] - a).abs() < 1e-12;
    assert!(near(&host.at(0.0, &x).0, -21.0));
    for update in [true, false] {
        // The base jumps 4 cm away from the buffer, whose linear force would still push; and back.
        for (place, a) in [(0.05, 0.0), (0.0, -21.0)] {
            unsafe { assert_eq!(fmi3EnterEventMode(host.c), OK) };
            set(&host, &plan, "body.base.motion.input", place);
            if update {
                assert_eq!(host.handle(), (true, None));
            } else {
                unsafe { assert_eq!(fmi3EnterContinuousTimeMode(host.c), OK) };
            }
            assert!(near(&host.at(0.0, &x).0, a), "{update} {place}");
        }
    }
    unsafe { fmi3FreeInstance(host.c) };
}

/// Values set at an event act after it, in any order, with or without an update, and through a
/// saved state.
#[test]
fn closed_form_a_parameter_and_an_input_of_one_event() {
    let text = "name = \"Sled\"\n[body.sled]\nmass = 4.0\n[load.push]\non = \"sled\"\ninput = true\n";
    let plan = Plan::new(text.into(), FILE).unwrap();
    let mut messages = Vec::new();
    let host = Host::begin(made("both", &plan, &mut messages));
    let mut mass = 4.0;
    for (update, saved) in [(true, false), (false, false), (true, true), (false, true)] {
        unsafe { assert_eq!(fmi3EnterEventMode(host.c), OK) };
        mass *= 2.0;
        set(&host, &plan, "body.sled.mass", mass);
        set(&host, &plan, "load.push.input", 8.0);
        let mut state = null_mut();
        unsafe {
            if saved {
                assert_eq!(fmi3GetFMUState(host.c, &mut state), OK);
                assert_eq!(fmi3SetFMUState(host.c, state), OK);
                assert_eq!(fmi3FreeFMUState(host.c, &mut state), OK);
            }
            if !update {
                assert_eq!(fmi3EnterContinuousTimeMode(host.c), OK);
            }
        }
        if update {
            assert_eq!(host.handle(), (true, None));
        }
        // Reading changes nothing.
        let mut a = f64::NAN;
        let reference = plan.table.reference("sled.a").unwrap();
        assert_eq!(unsafe { fmi3GetFloat64(host.c, &reference, 1, &mut a, 1) }, OK);
        let slope = host.at(1.0, &[0.5, mass]).0;
        assert_eq!((slope, a), (vec![mass, 8.0 / mass], 8.0 / mass), "{update} {saved}");
    }
    unsafe { fmi3FreeInstance(host.c) };
}

/// An event's law precedes the values set at it, and uses the old parameters.
#[test]
fn closed_form_a_parameter_that_is_set_at_an_impact() {
    let plan = plan("bouncing_ball.toml", unchanged);
    let mut messages = Vec::new();
    let host = Host::begin(made("set at an impact", &plan, &mut messages));
    let g = 9.81f64;
    let (time, speed) = ((2.0 / g).sqrt() * (1.0 + 1e-10), (2.0 * g).sqrt());
    assert!(host.at(time, &[1.0 + 1e-10 * 2.0, speed]).1 <= 0.0);
    assert!(host.accept());
    unsafe { assert_eq!(fmi3EnterEventMode(host.c), OK) };
    set(&host, &plan, "body.ball.mass", 0.5);
    assert_eq!(host.handle(), (true, None));
    let after = host.states();
    assert!(after[0] == 1.0 && (after[1] + 0.9 * speed).abs() < 1e-15 * speed, "{after:?}");
    unsafe { fmi3FreeInstance(host.c) };
}

/// A diverged solver gets an error by name; nothing is written, and from other states the motion
/// continues.
#[test]
fn values_that_are_no_finite_numbers_are_refused_by_name() {
    let plan = plan("bouncing_ball.toml", unchanged);
    let mut messages = Vec::new();
    let host = Host::begin(made("not finite values", &plan, &mut messages));
    let references = ["ball.v", "energy.kinetic"].map(|name| plan.table.reference(name).unwrap());
    for (v, status) in [(1e200, DISCARD), (2.0, OK)] {
        host.at(0.1, &[0.5, v]);
        let mut values = [7.0; 2];
        assert_eq!(unsafe { fmi3GetFloat64(host.c, references.as_ptr(), 2, values.as_mut_ptr(), 2) }, status);
        let expected = if status == OK { [v, 0.5 * 0.02 * v * v] } else { [7.0; 2] };
        assert_eq!(values, expected);
    }
    let message = messages.last().unwrap();
    assert!(message.contains("energy.kinetic = inf: expected a finite number"), "{message}");
    unsafe { fmi3FreeInstance(host.c) };
}

/// Derivatives of states and the Jacobian of a machine with formulas in closed form. A state at
/// which a formula is not defined is refused by name, and from other states the motion continues.
#[test]
fn closed_form_derivatives_of_formulas() {
    // Rounding of sums of a few terms.
    const ROUNDING: f64 = 1e-14;
    let plan = Plan::new(include_str!("../common/formulas.toml").into(), FILE).unwrap();
    let mut messages = Vec::new();
    let host = Host::begin(made("formulas", &plan, &mut messages));
    let reference = |name: &str| plan.table.reference(name).unwrap();
    let (s, v, x, w) = (1.2f64, -0.7f64, 0.3f64, 0.9f64);
    host.at(0.1, &[s, x, v, w]);
    let length = (0.04f64 + x * x).sqrt();
    let lateral = 60.0 * (length - 0.25) * x / length;
    let turn = 4.905 * 0.5 * s.sin() + 0.02 * v.powi(3) / (1.0 + s * s) + 0.02 * (3.0 * v).atan();
    let pull = 40.0 * x - 0.1 / (1.0 - x).powi(2) + lateral;
    let exact = [v, w, -turn / 0.2, (0.5 - pull) / 0.4];
    let mut own = [0.0; 4];
    unsafe {
        assert_eq!(fmi3GetContinuousStateDerivatives(host.c, own.as_mut_ptr(), 4), OK, "{messages:?}");
    }
    for (own, exact) in own.iter().zip(exact) {
        assert!((own - exact).abs() <= ROUNDING * exact.abs(), "{own} {exact}");
    }
    // By both coordinates, the rate of the arm, and the parameter c.
    let by_s = 4.905 * 0.5 * s.cos() - 0.02 * v.powi(3) * 2.0 * s / (1.0 + s * s).powi(2);
    let by_v = 0.06 * v * v / (1.0 + s * s) + 0.06 / (1.0 + 9.0 * v * v);
    let by_x = 40.0 - 0.2 / (1.0 - x).powi(3) + 60.0 * (1.0 - 0.25 * 0.04 / length.powi(3));
    let by_c = v.powi(3) / (1.0 + s * s) + (3.0 * v).atan();
    let rows = [
        ("arm.s", [-by_s / 0.2, 0.0]),
        ("arm.v", [-by_v / 0.2, 0.0]),
        ("mass.s", [0.0, -by_x / 0.4]),
        ("c", [-by_c / 0.2, 0.0]),
    ];
    for (name, exact) in rows {
        let (unknowns, known) = ([reference("arm.a"), reference("mass.a")], reference(name));
        let mut along = [f64::NAN; 2];
        let status = unsafe {
            fmi3GetDirectionalDerivative(
                host.c,
                unknowns.as_ptr(),
                2,
                &known,
                1,
                &1.0,
                1,
                along.as_mut_ptr(),
                2,
            )
        };
        assert_eq!(status, OK, "{messages:?}");
        for (own, exact) in along.iter().zip(exact) {
            assert!((own - exact).abs() <= ROUNDING * exact.abs(), "{name}: {own} {exact}");
        }
    }
    unsafe {
        assert_eq!(fmi3SetTime(host.c, 0.2), OK);
        assert_eq!(fmi3SetContinuousStates(host.c, [s, 1.0, v, w].as_ptr(), 4), OK);
        assert_eq!(fmi3GetContinuousStateDerivatives(host.c, own.as_mut_ptr(), 4), DISCARD);
        let message = messages.last().unwrap();
        assert!(message.contains("a derivative"), "{message}");
        host.at(0.2, &[s, x, v, w]);
        assert_eq!(fmi3GetContinuousStateDerivatives(host.c, own.as_mut_ptr(), 4), OK, "{messages:?}");
        fmi3FreeInstance(host.c);
    }
}
