//! Closed-form modes and the start on the exact orbit.

use super::*;
use crate::component::settings::SolutionMode;
use vibro_impact::simulator::AdvanceOutcome;
use vibro_impact::steady::exact_orbit;

fn closed(mode: f64) -> Instance {
    let mut fmu = instance();
    set(&mut fmu, "mode", mode).unwrap();
    initialize(fmu)
}

#[test]
fn steady_values_are_those_of_the_design() {
    let mut fmu = initialized();
    for (name, value) in
        [("steady.A3", 1.030523031), ("steady.impulse", 0.1597276346), ("steady.spectralRadius", 0.912416827)]
    {
        let digits = 1e-9;
        let got = get(&mut fmu, name);
        assert!((got - value).abs() < digits, "{name}: {got}");
    }
    for name in ["exists", "stable"] {
        assert_eq!(get(&mut fmu, &format!("steady.{name}")), 1.0, "{name}");
    }
}

#[test]
fn a_run_started_on_the_orbit_stays_on_it_and_equals_the_played_one() {
    let mut fmu = instance();
    set(&mut fmu, "startOnOrbit", 1.0).unwrap();
    let mut simulated = initialize(fmu);
    let mut played = closed(3.0);
    for i in 0..40 {
        for fmu in [&mut simulated, &mut played] {
            step(fmu, f64::from(i) * 1.7, 1.7).unwrap();
        }
        for name in ["box.s", "box.v", "box.a", "block.s", "block.v", "secondary.s", "secondary.a", "stop.s"]
        {
            let (a, b) = (get(&mut simulated, name), get(&mut played, name));
            assert!((a - b).abs() < 1e-11, "{name} at step {i}: {a} {b}");
        }
        for name in [
            "impacts.upper",
            "impacts.lower",
            "impacts.lastTime",
            "impacts.lastSpeed",
            "impacts.impulse",
            "energy.mechanical",
            "energy.input",
            "energy.damped",
            "energy.impact",
        ] {
            let (a, b) = (get(&mut simulated, name), get(&mut played, name));
            assert!((a - b).abs() < 1e-10, "{name} at step {i}: {a} {b}");
        }
    }
}

#[test]
fn multiple_scales_repeat_after_a_period_and_move_as_their_derivatives_say() {
    let mut fmu = closed(2.0);
    let period = std::f64::consts::TAU / 1.04;
    step(&mut fmu, 0.0, 0.3).unwrap();
    let names = ["box.s", "box.v", "block.s", "secondary.v", "stop.s"];
    let first = names.map(|name| get(&mut fmu, name));
    let point = vibro_impact::steady::multiple_scales::fixed_points(&vibro_impact::Groups::basic())
        .unwrap()
        .unwrap()
        .upper;
    let expected = point.motion_at_drive(1.04 * 0.3);
    assert!((first[0] - expected.x[0]).abs() < 1e-14);
    assert!((first[3] - 1.04 * expected.dx[2]).abs() < 1e-14);
    step(&mut fmu, 0.3, period).unwrap();
    for (name, first) in names.into_iter().zip(first) {
        assert!((get(&mut fmu, name) - first).abs() < 1e-13, "{name}");
    }
    assert_eq!(get(&mut fmu, "impacts.upper") + get(&mut fmu, "impacts.lower"), 2.0);
    let time = get(&mut fmu, "time");
    let (before, h) = (get(&mut fmu, "box.v"), 1e-6);
    let mut derivative = [0.0; 2];
    let references = [reference("box.v"), reference("box.a")];
    fmu.output_derivatives(&references, &[1, 1], |i, v| derivative[i] = v).unwrap();
    let acceleration = get(&mut fmu, "box.a");
    step(&mut fmu, time, h).unwrap();
    assert!(((get(&mut fmu, "box.v") - before) / h - derivative[0]).abs() < 1e-5);
    assert!(((get(&mut fmu, "box.a") - acceleration) / h - derivative[1]).abs() < 1e-5);
}

#[test]
fn without_a_steady_state_initialization_fails_with_the_range() {
    for (mode, what) in [(2.0, "multiple scales"), (3.0, "exact two-impact orbit")] {
        let mut fmu = instance();
        set(&mut fmu, "mode", mode).unwrap();
        set(&mut fmu, "drive.amplitude", 0.01).unwrap();
        fmu.set_experiment(None, 0.0, None).unwrap();
        fmu.enter_initialization();
        let error = fmu.exit_initialization(&mut Messages::default()).unwrap_err().to_string();
        assert!(
            error.starts_with("drive.amplitude = 0.01 N: must be at least ") && error.contains(what),
            "{error}"
        );
        assert_eq!(fmu.phase(), Phase::Initialization);
        // From the amplitude named in the message, there is a steady state.
        let words: Vec<_> = error.split_whitespace().collect();
        let place = words.iter().position(|word| *word == "least").unwrap() + 1;
        let from: f64 = words[place].parse().unwrap();
        set(&mut fmu, "drive.amplitude", from * (1.0 - 1e-9)).unwrap();
        assert!(fmu.exit_initialization(&mut Messages::default()).is_err(), "{error}");
        set(&mut fmu, "drive.amplitude", from * (1.0 + 1e-9)).unwrap();
        fmu.exit_initialization(&mut Messages::default()).unwrap();
    }
}

#[test]
fn what_would_not_be_seen_is_played_with_a_warning() {
    for (mode, text) in [(2.0, "the two-impact motion is unstable"), (3.0, "it is unstable")] {
        let mut fmu = instance();
        set(&mut fmu, "mode", mode).unwrap();
        set(&mut fmu, "drive.amplitude", 0.25).unwrap();
        fmu.set_experiment(None, 0.0, None).unwrap();
        fmu.enter_initialization();
        let mut messages = Messages::default();
        fmu.exit_initialization(&mut messages).unwrap();
        let (category, message) = &messages.0[0];
        assert_eq!(*category, Category::Warnings);
        assert!(message.contains(text), "{message}");
    }
}

#[test]
fn loads_are_refused_where_a_closed_form_is_played() {
    let mut fmu = closed(3.0);
    let error = set(&mut fmu, "box.f", 0.1).unwrap_err().to_string();
    assert_eq!(error, "box.f = 0.1: expected 0 in a closed-form mode");
    set(&mut fmu, "box.f", 0.0).unwrap();
    assert!(fmu.set_input_derivatives(&[reference("box.f")], &[1], &[0.1]).is_err());
    let mut fmu = instance();
    set(&mut fmu, "mode", 2.0).unwrap();
    set(&mut fmu, "block.f", 0.1).unwrap();
    fmu.set_experiment(None, 0.0, None).unwrap();
    fmu.enter_initialization();
    assert!(fmu.exit_initialization(&mut Messages::default()).is_err());
}

#[test]
fn a_tunable_change_plays_another_steady_state_and_keeps_the_accounts() {
    let mut fmu = closed(3.0);
    step(&mut fmu, 0.0, 10.0).unwrap();
    let impacts = get(&mut fmu, "impacts.upper") + get(&mut fmu, "impacts.lower");
    set(&mut fmu, "drive.amplitude", 0.16).unwrap();
    set(&mut fmu, "drive.frequency", 1.05).unwrap();
    step(&mut fmu, 10.0, 1e-12).unwrap();
    assert_eq!(get(&mut fmu, "impacts.upper") + get(&mut fmu, "impacts.lower"), impacts);
    step(&mut fmu, 10.0, 50.0).unwrap();
    let parameters =
        vibro_impact::Parameters { drive_amplitude: 0.16, drive_frequency: 1.05, ..Default::default() };
    let orbit = exact_orbit::solve(&parameters).unwrap().upper.unwrap();
    // The drive's phase continued from 1.04 · 10.
    let state = orbit.state(1.04 * 10.0 + 1.05 * 50.0);
    assert!((get(&mut fmu, "block.s") - state.x[1]).abs() < 1e-12);
    let balance = ["energy.input", "energy.damped", "energy.impact"].map(|name| get(&mut fmu, name));
    let start =
        exact_orbit::solve(&vibro_impact::Parameters::default()).unwrap().upper.unwrap().initial_state();
    let energy = |s: &vibro_impact::State, p: &vibro_impact::Parameters| {
        0.5 * (s.v[0] * s.v[0]
            + p.block_mass * s.v[1] * s.v[1]
            + p.secondary_mass * s.v[2] * s.v[2]
            + s.x[0] * s.x[0]
            + p.secondary_stiffness * s.x[2] * s.x[2]
            + p.coupling_stiffness * (s.x[1] - s.x[2]).powi(2))
    };
    let gained = energy(&state, &parameters) - energy(&start, &vibro_impact::Parameters::default());
    assert!((balance[0] - balance[1] - balance[2] - gained).abs() < 1e-11, "{balance:?} {gained}");
    // Parameters without a steady state are refused, and the run can continue without them.
    set(&mut fmu, "drive.amplitude", 0.01).unwrap();
    assert!(step(&mut fmu, 60.0, 1.0).is_err());
    set(&mut fmu, "drive.amplitude", 0.16).unwrap();
    step(&mut fmu, 60.0, 1.0).unwrap();
}

#[test]
fn a_played_state_comes_back_bit_by_bit() {
    for mode in [2.0, 3.0] {
        let mut fmu = closed(mode);
        step(&mut fmu, 0.0, 3.3).unwrap();
        set(&mut fmu, "drive.frequency", 1.06).unwrap();
        step(&mut fmu, 3.3, 4.4).unwrap();
        let saved = fmu.save();
        let bytes = saved.serialize().unwrap();
        step(&mut fmu, 3.3 + 4.4, 5.5).unwrap();
        let straight = motion(&mut fmu);
        let mut fresh = instance();
        restore_bytes(&mut fresh, &bytes).unwrap();
        step(&mut fresh, 3.3 + 4.4, 5.5).unwrap();
        assert_eq!(motion(&mut fresh), straight);
        fmu.restore(&saved).unwrap();
        step(&mut fmu, 3.3 + 4.4, 5.5).unwrap();
        assert_eq!(motion(&mut fmu), straight);
    }
}

/// At a time that no motion can have, impacts cannot be counted one by one: a step from there
/// would never end.
#[test]
fn a_played_state_of_a_damaged_time_is_refused() {
    let mut fmu = closed(2.0);
    step(&mut fmu, 0.0, 3.25).unwrap();
    set(&mut fmu, "drive.frequency", 1.06).unwrap();
    step(&mut fmu, 3.25, 4.5).unwrap();
    let payload = postcard::to_stdvec(&fmu.save()).unwrap();
    let mut altered = 0;
    for time in [3.25f64, 7.75] {
        for place in 0..payload.len() - 8 {
            if payload[place..place + 8] != time.to_le_bytes() {
                continue;
            }
            for wrong in [-1e34, 1e300, f64::NAN] {
                let mut damaged = payload.clone();
                damaged[place..place + 8].copy_from_slice(&f64::to_le_bytes(wrong));
                let damaged: SavedState = postcard::from_bytes(&damaged).unwrap();
                for component in [&mut instance(), &mut fmu] {
                    let refused = component.restore(&damaged);
                    assert!(refused.is_err(), "{time} at {place}: {wrong}");
                }
            }
            altered += 1;
        }
    }
    assert_eq!(altered, 3, "when it came into force, for the drive too, and the present");
    assert_eq!(fmu.time(), 7.75);
}

#[test]
fn played_impacts_stop_a_step_and_are_logged() {
    let mut form =
        ClosedForm::new(SolutionMode::ExactOrbit, &vibro_impact::Parameters::default(), 0.0).unwrap();
    let mut times = Vec::new();
    while times.len() < 20 {
        let now = form.time();
        assert!(matches!(form.advance(now, 100.0, true, None), Ok((AdvanceOutcome::Impact, _))));
        times.push(form.time());
        assert_eq!(form.values().impacts.last_time, form.time());
    }
    let now = form.time();
    assert!(form.advance(now, 1e300, false, None).is_err() && form.time() == now);
    assert!(ClosedForm::new(SolutionMode::ExactOrbit, &vibro_impact::Parameters::default(), 1e300).is_err());
    for pair in times.windows(2) {
        assert!((pair[1] - pair[0] - std::f64::consts::PI / 1.04).abs() < 1e-12, "{pair:?}");
    }
    let mut fmu = closed(3.0);
    let mut messages = Messages::default();
    fmu.step_without_event_mode(0.0, times[19] + 1e-9, &mut messages).unwrap();
    assert_eq!(messages.0.len(), 20);
}

/// However near to an impact a closed form starts, no impact has happened at the start.
#[test]
fn a_played_motion_has_no_impacts_at_its_start() {
    for mode in [2.0, 3.0] {
        let mut fmu = instance();
        let exact = exact_orbit::solve(&vibro_impact::Parameters::default()).unwrap().upper.unwrap();
        let phase = if mode == 3.0 { exact.drive_phase() } else { get(&mut fmu, "steady.phase") };
        for side in [0.0, std::f64::consts::PI] {
            for off in -12..12 {
                let mut fmu = instance();
                set(&mut fmu, "mode", mode).unwrap();
                set(&mut fmu, "drive.phase", phase + side + f64::from(off) * 2.0 * f64::EPSILON).unwrap();
                let mut fmu = initialize(fmu);
                for name in
                    ["impacts.upper", "impacts.lower", "impacts.impulse", "energy.impact", "energy.input"]
                {
                    assert_eq!(get(&mut fmu, name), 0.0, "{name} in mode {mode} at {off}");
                }
                step(&mut fmu, 0.0, std::f64::consts::PI / 1.04).unwrap();
                assert_eq!(get(&mut fmu, "impacts.upper") + get(&mut fmu, "impacts.lower"), 1.0, "at {off}");
            }
        }
    }
}

/// Both kinds of step: past the events, and ending at events.
#[test]
fn a_step_over_any_number_of_played_impacts_lists_a_thousand_and_counts_the_others() {
    for ends_at_events in [false, true] {
        let mut fmu = closed(3.0);
        let mut messages = Messages::default();
        if ends_at_events {
            fmu.step_as_agreed(0.0, 1e9, &mut messages).unwrap();
        } else {
            fmu.step_without_event_mode(0.0, 1e9, &mut messages).unwrap();
        }
        let impacts = get(&mut fmu, "impacts.upper") + get(&mut fmu, "impacts.lower");
        assert!(impacts > 3e8, "{impacts}");
        assert_eq!(messages.0.len(), 1001, "{ends_at_events}");
        assert!(messages.0[999].1.starts_with("impact on the"), "{}", messages.0[999].1);
        let rest =
            format!("{} more impacts up to t = 1000000000 s are not listed one by one", impacts - 1000.0);
        assert_eq!(messages.0[1000].1, rest);
    }
}

/// After a plastic impact box and block have one velocity; before it they approach with the
/// reported speed. Rounding of the relative velocity does not decide which of the two is shown.
#[test]
fn closed_form_both_limits_of_a_plastic_impact_are_shown() {
    /// Tolerance: rounding of speeds of order one, m/s.
    const SAME: f64 = 1e-9;
    for mode in [2.0, 3.0] {
        let plastic =
            [("mode", mode), ("stop.restitution", 0.0), ("drive.amplitude", 0.2), ("stopAtImpact", 1.0)];
        let mut fmu = with_handling(true, true, &plastic);
        for _ in 0..40 {
            let now = fmu.time();
            assert!(fmu.step_as_agreed(now, 100.0, &mut Silence).unwrap().event);
            let before = get(&mut fmu, "stop.v").abs();
            fmu.enter_event().unwrap();
            let after = get(&mut fmu, "stop.v");
            fmu.handle_events(&mut Silence).unwrap();
            assert_eq!(get(&mut fmu, "stop.v"), after);
            let speed = get(&mut fmu, "impacts.lastSpeed");
            assert!(speed > 0.1 && (before - speed).abs() < SAME && after.abs() < SAME, "{before} {after}");
            fmu.leave_event(&mut Silence).unwrap();
        }
    }
}

/// An impact is not logged if it is not carried out because parameters set at it do not have a
/// steady state.
#[test]
fn an_impact_of_a_refused_update_is_logged_when_it_is_carried_out() {
    let mut fmu = with_handling(true, true, &[("mode", 3.0), ("stopAtImpact", 1.0)]);
    fmu.step_as_agreed(0.0, 100.0, &mut Silence).unwrap();
    fmu.enter_event().unwrap();
    let (mut messages, amplitude) = (Messages::default(), get(&mut fmu, "drive.amplitude"));
    set(&mut fmu, "drive.amplitude", 1e-6).unwrap();
    assert!(fmu.handle_events(&mut messages).is_err());
    assert!(messages.0.is_empty(), "{:?}", messages.0);
    set(&mut fmu, "drive.amplitude", amplitude).unwrap();
    fmu.handle_events(&mut messages).unwrap();
    assert_eq!(messages.0.len(), 1, "{:?}", messages.0);
}

/// The side of the last impact is not kept for a host that does not handle events: a restored
/// state is saved again as the same state.
#[test]
fn a_steady_state_is_saved_again_as_it_was_restored() {
    for mode in [2.0, 3.0] {
        let mut fmu = closed(mode);
        for step in 0..40 {
            let time = fmu.time();
            fmu.step_as_agreed(time, 0.37, &mut Silence).unwrap();
            let saved = fmu.save();
            let mut other = instance();
            other.restore(&saved).unwrap();
            assert!(other.save() == saved, "mode {mode}, step {step}");
        }
    }
}
