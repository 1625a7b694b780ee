//! Directional derivatives compared with differences.

use super::*;

const KNOWNS: [&str; 9] =
    ["box.f", "block.f", "secondary.f", "box.s", "block.s", "secondary.s", "box.v", "block.v", "secondary.v"];
const SEED: [f64; 9] = [0.7, -0.3, 0.2, 0.5, -0.4, 0.9, -0.8, 0.6, 0.1];

fn references(names: &[&str]) -> Vec<u32> {
    names.iter().map(|name| reference(name)).collect()
}

/// Names of all Real outputs that every description has.
fn outputs() -> Vec<&'static str> {
    let every = VARIABLES.iter().filter(|v| v.edition == Edition::Every);
    let real = every.filter(|v| v.causality == Causality::Output && v.base() == Base::Real);
    real.map(|v| v.name).collect()
}

fn derivative(fmu: &mut Instance, unknowns: &[&str], knowns: &[&str], seed: &[f64]) -> Vec<f64> {
    let mut values = vec![f64::NAN; unknowns.len()];
    let (u, k) = (references(unknowns), references(knowns));
    fmu.directional_derivative(&u, &k, seed, |i, value| values[i] = value).unwrap();
    values
}

/// A host that handles events, with a description that has parameters and time as knowns.
fn with_events() -> Protocol {
    let handling = EventHandling { event_mode: true, early_return: true };
    Protocol { edition: Edition::Extended, handling, ..Protocol::default() }
}

fn exchange(prepare: impl Fn(&mut Instance)) -> Instance {
    let mut fmu = Instance::new(Interface::ModelExchange);
    prepare(&mut fmu);
    let mut fmu = initialize(fmu);
    fmu.handle_events(&mut Messages::default()).unwrap();
    fmu.enter_continuous().unwrap();
    fmu
}

/// All outputs of a Model Exchange instance at perturbed states and loads.
fn sampled(fmu: &mut Instance, step: f64) -> Vec<f64> {
    let saved = fmu.save();
    for (name, seed) in KNOWNS.iter().zip(SEED) {
        let value = get(fmu, name);
        set(fmu, name, value + step * seed).unwrap();
    }
    let values = outputs().iter().map(|name| get(fmu, name)).collect();
    fmu.restore(&saved).unwrap();
    values
}

fn against_differences(fmu: &mut Instance) {
    let names = outputs();
    let exact = derivative(fmu, &names, &KNOWNS, &SEED);
    // The outputs are polynomials of degree 2 in states and loads, and so is the quadrature of the
    // damped energy: no truncation.
    let (plus, minus) = (sampled(fmu, 0.125), sampled(fmu, -0.125));
    for (i, name) in names.iter().enumerate() {
        let difference = (plus[i] - minus[i]) / 0.25;
        assert!((exact[i] - difference).abs() < 1e-12, "{name}: {} {difference}", exact[i]);
    }
}

#[test]
fn model_exchange_in_flight_and_in_rest() {
    let mut flight = exchange(|fmu| {
        set(fmu, "block.s", 0.3).unwrap();
        set(fmu, "box.v", 0.4).unwrap();
    });
    against_differences(&mut flight);
    flight.set_time(0.3).unwrap(); // an open interval of the damped energy
    against_differences(&mut flight);
    let mut rest = exchange(|fmu| {
        set(fmu, "block.s", 1.0).unwrap();
        set(fmu, "block.f", 0.2).unwrap();
    });
    assert_eq!(get(&mut rest, "stop.state"), 2.0);
    // λ is clipped at zero where the stop would pull, so the load presses the block on the stop.
    set(&mut rest, "block.f", 2.0).unwrap();
    against_differences(&mut rest);
}

#[test]
fn co_simulation_agrees_with_model_exchange() {
    let prepare = |fmu: &mut Instance| {
        set(fmu, "block.s", 0.3).unwrap();
        set(fmu, "box.v", 0.4).unwrap();
    };
    let mut host = exchange(prepare);
    let mut fmu = instance();
    prepare(&mut fmu);
    let mut fmu = initialize(fmu);
    let names: Vec<_> = outputs().into_iter().filter(|n| !n.starts_with("energy.")).collect();
    let a = derivative(&mut fmu, &names, &KNOWNS, &SEED);
    assert_eq!(a, derivative(&mut host, &names, &KNOWNS, &SEED));
    let b = derivative(&mut fmu, &["energy.mechanical", "energy.damped"], &KNOWNS, &SEED);
    assert!((b[0] - derivative(&mut host, &["energy.mechanical"], &KNOWNS, &SEED)[0]).abs() < 1e-15);
    assert_eq!(b[1], 0.0); // accumulated values do not vary
}

#[test]
fn initialization_mode_by_parameters_and_start_values() {
    let mut fmu = instance();
    set(&mut fmu, "block.s", 0.3).unwrap();
    set(&mut fmu, "secondary.s", -0.2).unwrap();
    set(&mut fmu, "box.v", 0.4).unwrap();
    fmu.set_experiment(None, 2.0, None).unwrap();
    fmu.enter_initialization();
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-10, "{a} {b}");
    // box.a = (F10 sin(ω t + φ) - c1 v1 - k1 x1)/m1
    let d = |fmu: &mut Instance, known| derivative(fmu, &["box.a"], &[known], &[1.0])[0];
    let a = get(&mut fmu, "box.a");
    let cos = 0.15 * (1.04_f64 * 2.0).cos();
    near(d(&mut fmu, "box.c"), -0.4);
    near(d(&mut fmu, "box.m"), -a);
    near(d(&mut fmu, "drive.phase"), cos);
    near(d(&mut fmu, "drive.frequency"), 2.0 * cos);
    near(d(&mut fmu, "box.s"), -1.0);
    near(d(&mut fmu, "box.f"), 1.0);
    near(d(&mut fmu, "box.k"), 0.0);
    near(derivative(&mut fmu, &["coupling.f"], &["coupling.k"], &[2.0])[0], 1.0);
    near(derivative(&mut fmu, &["groups.epsilon"], &["block.m"], &[1.0])[0], 1.0);
    // One-sided at the end of a range.
    set(&mut fmu, "box.c", 0.0).unwrap();
    near(d(&mut fmu, "box.c"), -0.4);
    near(derivative(&mut fmu, &["groups.f10"], &["drive.amplitude"], &[1.0])[0], 10.0);
    let mut impulse = |restitution: f64| {
        set(&mut fmu, "stop.restitution", restitution).unwrap();
        get(&mut fmu, "steady.impulse")
    };
    const H: f64 = 1e-4; // the one-sided second-order difference has an error of about H²
    let expected = (impulse(1.0 - 2.0 * H) - 4.0 * impulse(1.0 - H) + 3.0 * impulse(1.0)) / (2.0 * H);
    let got = derivative(&mut fmu, &["steady.impulse"], &["stop.restitution"], &[1.0])[0];
    assert!(
        expected.abs() > 1e-4 && (got - expected).abs() < 1e-5 * expected.abs().max(1.0),
        "{got} {expected}"
    );
    assert_eq!(derivative(&mut fmu, &["box.a"], &["box.m"], &[0.0]), [0.0]);
    assert_eq!(derivative(&mut fmu, &["box.a"], &[], &[]), [0.0]);
}

/// A very small value, and a start at a late time, do not make a derivative less accurate.
#[test]
fn closed_form_derivatives_at_values_of_any_size_and_at_late_starts() {
    let at_start = |(name, value): (&str, f64), time: f64, known: &str| {
        let mut fmu = instance();
        set(&mut fmu, name, value).unwrap();
        fmu.set_experiment(None, time, None).unwrap();
        fmu.enter_initialization();
        derivative(&mut fmu, &["box.a"], &[known], &[1.0])[0]
    };
    let near = |a: f64, b: f64, what: &str| assert!((a - b).abs() < 1e-8, "{what}: {a} {b}");
    let cos = |time: f64| 0.15 * (1.04 * time).cos();
    for value in [0.0, 1e-9, 1e-12, 1e-17] {
        near(at_start(("box.s", value), 1.0, "box.s"), -1.0, "box.s");
        near(at_start(("box.f", value), 1.0, "box.f"), 1.0, "box.f");
        near(at_start(("drive.phase", value), 1.0, "drive.phase"), cos(1.0), "drive.phase");
    }
    for turned in [1e3, 8264.8, 1e5, 1e6] {
        // The phase itself is rounded to a millionth of the step there.
        let (got, expected) =
            (at_start(("drive.phase", turned), 1.0, "drive.phase"), 0.15 * (turned + 1.04).cos());
        assert!((got - expected).abs() < 1e-6, "drive.phase {turned}: {got} {expected}");
    }
    for time in [0.0, 1.0, 1e2, 1e3, 1e4] {
        let known = "drive.frequency";
        near(at_start(("box.s", 0.0), time, known) / time.max(1.0), time.min(1.0) * cos(time), known);
    }
}

/// A secondary oscillator or a damper that is much faster than the drive does not increase the
/// steps for the drive's parameters.
#[test]
fn second_method_derivatives_by_the_drive_beside_a_part_that_is_much_faster() {
    let fast = [
        [("secondary.m", 9.966e-4), ("secondary.k", 4025.0), ("secondary.c", 53.85), ("box.c", 0.001187)],
        [("secondary.m", 3.557e-5), ("secondary.k", 6047.0), ("secondary.c", 0.0), ("box.c", 0.002027)],
    ];
    for (part, force, frequency) in [(fast[0], 0.2011, 1.05207), (fast[1], 0.2076, 0.9635)] {
        for (known, value) in [("drive.frequency", frequency), ("drive.amplitude", force)] {
            let mut fmu = instance();
            for (name, value) in part {
                set(&mut fmu, name, value).unwrap();
            }
            set(&mut fmu, "coupling.k", 0.0).unwrap();
            set(&mut fmu, "drive.amplitude", force).unwrap();
            set(&mut fmu, "drive.frequency", frequency).unwrap();
            fmu.set_experiment(None, 0.0, None).unwrap();
            fmu.enter_initialization();
            let got = derivative(&mut fmu, &["steady.phase"], &[known], &[1.0])[0];
            const H: f64 = 1e-5;
            let [before, after] = [value - H, value + H].map(|value| {
                set(&mut fmu, known, value).unwrap();
                get(&mut fmu, "steady.phase")
            });
            let expected = (after - before) / (2.0 * H);
            assert!((got - expected).abs() < 1e-4 * expected.abs(), "{known}: {got} {expected}");
        }
    }
}

/// If a parameter is 0, a closed form's derivative uses the machine's own scale, in any units.
#[test]
fn second_method_derivatives_of_a_closed_form_by_a_parameter_that_is_0() {
    let names = ["box.s", "block.s", "box.v", "stop.v"];
    for scale in [1.0, 1e-6] {
        for known in ["secondary.c", "coupling.k"] {
            let masses = ["box.m", "block.m", "secondary.m"].map(|name| (name, [1.0, 0.1, 0.1]));
            let mut start: Vec<(&str, f64)> =
                masses.iter().enumerate().map(|(i, (name, m))| (*name, m[i] * scale)).collect();
            for (name, value) in [
                ("box.k", 1.0),
                ("box.c", 0.1),
                ("secondary.k", 0.1),
                ("secondary.c", 0.0015),
                ("coupling.k", 0.006),
                ("drive.amplitude", 0.27),
                (known, 0.0),
            ] {
                start.push((name, value * scale));
            }
            start.extend([("drive.frequency", 1.0244), ("mode", 3.0)]);
            let mut fmu = stepping(with_events(), &start);
            fmu.step_as_agreed(0.0, 0.5, &mut Silence).unwrap();
            fmu.enter_event().unwrap();
            fmu.handle_events(&mut Silence).unwrap();
            let got = derivative(&mut fmu, &names, &[known], &[scale]);
            const H: f64 = 1e-6;
            let [none, once, twice] = [0.0, H, 2.0 * H].map(|value| {
                set(&mut fmu, known, value * scale).unwrap();
                names.map(|name| get(&mut fmu, name))
            });
            for i in 0..names.len() {
                let expected = (4.0 * once[i] - 3.0 * none[i] - twice[i]) / (2.0 * H);
                let close = (got[i] - expected).abs() < 1e-5 * (1.0 + expected.abs());
                assert!(close, "{known} {scale} {}: {} {expected}", names[i], got[i]);
            }
        }
    }
}

/// A closed form is a motion without loads: before its start and later, nothing varies with them.
#[test]
fn a_closed_form_does_not_vary_with_loads() {
    for mode in [2.0, 3.0] {
        let mut fmu = instance();
        set(&mut fmu, "mode", mode).unwrap();
        fmu.set_experiment(None, 0.0, None).unwrap();
        fmu.enter_initialization();
        for initialized in [false, true] {
            if initialized {
                fmu.exit_initialization(&mut Silence).unwrap();
            }
            let rates = derivative(&mut fmu, &["box.a", "block.v"], &KNOWNS[..3], &[1.0, -2.0, 0.5]);
            assert_eq!(rates, [0.0, 0.0], "{mode}");
        }
    }
}

#[test]
fn wrong_unknowns_and_knowns_are_refused() {
    let mut fmu = initialized();
    for (unknown, known, seed) in [
        ("box.k", "box.f", 1.0),
        ("groups.epsilon", "box.f", 1.0),
        ("box.a", "box.k", 1.0),
        ("box.a", "time", 1.0),
        ("box.a", "box.a", 1.0),
        ("box.a", "box.f", f64::NAN),
    ] {
        let (u, k) = (references(&[unknown]), references(&[known]));
        assert!(fmu.directional_derivative(&u, &k, &[seed], |_, _| panic!()).is_err(), "{unknown} {known}");
    }
}

/// `ModelStructure/Outputs` lists a known if and only if an output's derivative with respect to it
/// is not zero.
#[test]
fn dependencies_are_those_of_the_derivatives() {
    let mut flight = exchange(|fmu| {
        for (name, value) in
            [("box.s", 0.1), ("block.s", 0.3), ("box.v", 0.4), ("block.v", -0.2), ("secondary.s", 0.1)]
        {
            set(fmu, name, value).unwrap();
        }
        set(fmu, "secondary.v", 0.5).unwrap();
        set(fmu, "secondary.f", 0.1).unwrap();
    });
    flight.set_time(0.3).unwrap(); // an open interval of the energies
    let mut rest = exchange(|fmu| {
        // The body moves, so that a factor of velocity has an effect.
        for (name, value) in [("block.s", 1.0), ("block.f", 2.0), ("box.v", 0.1), ("block.v", 0.1)] {
            set(fmu, name, value).unwrap();
        }
    });
    assert_eq!(get(&mut rest, "stop.state"), 2.0);
    let names = outputs();
    let listed = structure::outputs(Edition::Every);
    for known in KNOWNS {
        let mut seen = vec![false; names.len()];
        for fmu in [&mut flight, &mut rest] {
            let column = derivative(fmu, &names, &[known], &[1.0]);
            seen.iter_mut().zip(column).for_each(|(seen, value)| *seen |= value != 0.0);
        }
        let known_place = place(known);
        for (name, seen) in names.iter().zip(seen) {
            let unknown = listed.iter().find(|u| u.place == place(name)).unwrap();
            let says = unknown.dependencies.iter().any(|(i, _)| *i == known_place);
            assert_eq!(says, seen, "{name} by {known}");
        }
    }
}

/// At a point that a solver has just accepted, no damping has occurred yet, but it begins.
#[test]
fn second_method_the_damped_energy_varies_with_time_at_an_accepted_point_too() {
    const STEP: f64 = 1e-3; // s
    /// Tolerance: truncation error of a central difference, for powers of 0.1 W.
    const SAME: f64 = 1e-6;
    let protocol = Protocol { edition: Edition::Extended, ..Protocol::default() };
    let mut fmu = Instance::of_protocol(Interface::ModelExchange, protocol);
    for (name, value) in [("box.v", 0.4), ("secondary.v", 0.5), ("block.s", 0.3)] {
        set(&mut fmu, name, value).unwrap();
    }
    let mut fmu = initialize(fmu);
    fmu.handle_events(&mut Silence).unwrap();
    fmu.enter_continuous().unwrap();
    for accepted in [true, false] {
        if !accepted {
            fmu.set_time(0.01).unwrap();
        }
        let names = ["energy.damped", "energy.input"];
        let exact = derivative(&mut fmu, &names, &["time"], &[1.0]);
        let now = fmu.time();
        let mut at = |time: f64| {
            fmu.set_time(time).unwrap();
            names.map(|name| get(&mut fmu, name))
        };
        let (later, before) = (at(now + STEP), at(now - STEP));
        at(now);
        for i in 0..2 {
            let quotient = (later[i] - before[i]) / (2.0 * STEP);
            assert!(
                quotient > 0.01 && (quotient - exact[i]).abs() < SAME,
                "{} {quotient} {}",
                names[i],
                exact[i]
            );
        }
    }
}

/// Next to an impact of a closed form differences do not cross the impact: the derivatives belong
/// to the motion on this side, and change continuously with time.
#[test]
fn second_method_derivatives_of_a_closed_form_do_not_reach_over_an_impact() {
    /// Tolerance between two moments 10 ms apart, for derivatives of order one.
    const SAME: f64 = 0.1;
    let protocol = with_events();
    let known = ["box.k", "stop.restitution", "drive.amplitude", "drive.frequency"];
    for mode in [2.0, 3.0] {
        let mut fmu = stepping(protocol, &[("mode", mode), ("stopAtImpact", 1.0)]);
        for known in [known, known, known].concat() {
            let now = fmu.time();
            fmu.step_as_agreed(now, 100.0, &mut Silence).unwrap();
            fmu.enter_event().unwrap();
            fmu.handle_events(&mut Silence).unwrap();
            let at_impact = derivative(&mut fmu, &["block.v", "box.v", "block.s"], &[known], &[1.0]);
            let mut later = Instance::of_protocol(Interface::CoSimulation, protocol);
            later.restore(&fmu.save()).unwrap();
            later.leave_event(&mut Silence).unwrap();
            let now = later.time();
            for step in 0..10 {
                later.step_as_agreed(now + 1e-3 * f64::from(step), 1e-3, &mut Silence).unwrap();
                let then = derivative(&mut later, &["block.v", "box.v", "block.s"], &[known], &[1.0]);
                for (a, b) in at_impact.iter().zip(&then) {
                    assert!((a - b).abs() < SAME * (1.0 + a.abs()), "{known} {mode}: {at_impact:?} {then:?}");
                }
            }
            fmu.leave_event(&mut Silence).unwrap();
        }
    }
}

/// Before the law of an impact getters show the limit before it, and derivatives belong to that
/// limit.
#[test]
fn second_method_derivatives_before_the_law_of_an_impact_are_those_before_it() {
    /// Tolerance between the impact and 1 ms before, for derivatives of order one.
    const SAME: f64 = 0.02;
    let names = ["box.s", "block.v", "box.v", "stop.v"];
    for mode in [2.0, 3.0] {
        for known in ["box.k", "stop.restitution", "drive.amplitude", "drive.frequency", "drive.phase"] {
            let mut fmu = stepping(with_events(), &[("mode", mode), ("stopAtImpact", 1.0)]);
            for _ in 0..3 {
                let (now, next) = (fmu.time(), get(&mut fmu, "impacts.nextTime"));
                fmu.step_as_agreed(now, next - 1e-3 - now, &mut Silence).unwrap();
                let earlier = derivative(&mut fmu, &names, &[known], &[1.0]);
                let now = fmu.time();
                assert!(fmu.step_as_agreed(now, 1.0, &mut Silence).unwrap().event);
                let at_impact = derivative(&mut fmu, &names, &[known], &[1.0]);
                for (a, b) in at_impact.iter().zip(&earlier) {
                    let close = (a - b).abs() < SAME * (1.0 + a.abs());
                    assert!(close, "{known} {mode}: {at_impact:?} {earlier:?}");
                }
                fmu.enter_event().unwrap();
                fmu.handle_events(&mut Silence).unwrap();
                fmu.leave_event(&mut Silence).unwrap();
            }
        }
    }
}

/// At an impact there is also a derivative with respect to a parameter at the end of its range,
/// before and after the start of a motion.
#[test]
fn second_method_derivatives_at_an_impact_at_the_end_of_a_range() {
    /// Tolerance between the impact and 10 ms later, for derivatives of order one.
    const SAME: f64 = 0.1;
    let protocol = with_events();
    let unknowns = ["block.v", "box.v", "block.s"];
    for (name, value) in [("stop.restitution", 1.0), ("secondary.c", 0.0), ("coupling.k", 0.006)] {
        let values = [("mode", 3.0), ("stopAtImpact", 1.0), (name, value)];
        let mut start = Instance::of_protocol(Interface::CoSimulation, protocol);
        values.iter().for_each(|(name, value)| set(&mut start, name, *value).unwrap());
        let mut fmu = stepping(protocol, &values);
        let impact = fmu.step_as_agreed(0.0, 100.0, &mut Silence).unwrap().time;
        fmu.enter_event().unwrap();
        fmu.handle_events(&mut Silence).unwrap();
        let at_impact = derivative(&mut fmu, &unknowns, &[name], &[1.0]);
        fmu.leave_event(&mut Silence).unwrap();
        fmu.step_as_agreed(impact, 0.01, &mut Silence).unwrap();
        let later = derivative(&mut fmu, &unknowns, &[name], &[1.0]);
        let close = |a: &f64, b: &f64| (a - b).abs() < SAME * (1.0 + a.abs());
        assert!(at_impact.iter().zip(&later).all(|(a, b)| close(a, b)), "{name}: {at_impact:?} {later:?}");
        // In initialization right after an impact, and later.
        let [near, far] = [1e-3, 1e-2].map(|after| {
            start.set_experiment(None, impact + after, None).unwrap();
            start.enter_initialization();
            derivative(&mut start, &unknowns, &[name], &[1.0])
        });
        assert!(near.iter().zip(&far).all(|(a, b)| close(a, b)), "{name}: {near:?} {far:?}");
    }
}

/// A seed near the largest doubles, before the motion and during it: no derivative is NaN or
/// infinite, and nothing is written.
#[test]
fn derivatives_beyond_doubles_are_refused_by_name() {
    for (mut fmu, unknown, known) in
        [(instance(), "stop.v", "block.m"), (initialized(), "secondary.a", "secondary.f")]
    {
        let (unknowns, knowns) = (references(&[unknown]), references(&[known]));
        let mut written = 0;
        let outcome = fmu.directional_derivative(&unknowns, &knowns, &[1e308], |_, _| written += 1);
        let refusal = outcome.unwrap_err().to_string();
        assert!(refusal.starts_with(&format!("derivative of {unknown} = ")), "{refusal}");
        assert!(refusal.contains("expected a finite number"), "{refusal}");
        assert_eq!(written, 0);
        assert!(derivative(&mut fmu, &[unknown], &[known], &[1.0])[0].is_finite());
    }
}
