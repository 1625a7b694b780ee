//! Parameters: errors, and changes during the motion.

use crate::host::*;
use crate::*;
use vibro_machine_component::{FILE, Plan};

#[test]
fn parameters_that_are_no_machine_are_refused_by_name_and_nothing_is_lost() {
    let plan = plan("bouncing_ball.toml", unchanged);
    let ball = Instance::of("refused", &plan, false);
    assert_eq!(ball.set("stop.floor.restitution", 1.5), DISCARD);
    let last = || ball.messages.last().unwrap().clone();
    assert!(last().ends_with("stop.floor.restitution = 1.5: expected a number from 0 to 1"), "{}", last());
    // A start beyond the stop is refused only when initialization ends, because start and gap may
    // be set in either order.
    assert_eq!(ball.set("body.ball.start.s", 2.0), OK);
    unsafe {
        assert_eq!(fmi3EnterInitializationMode(ball.c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi3ExitInitializationMode(ball.c), DISCARD);
        assert!(last().contains("floor"), "{}", last());
        assert_eq!(ball.set("stop.floor.gap", 3.0), OK);
        assert_eq!(ball.get("ball.s"), 2.0);
        assert_eq!(fmi3ExitInitializationMode(ball.c), OK, "{}", last());
    }
    // In 0.4 s the ball falls less than a metre.
    ball.step(0.0, 0.4);
    assert!((ball.get("ball.s") - (2.0 + 0.5 * 9.81 * 0.16)).abs() < 1e-14);
    assert_eq!(ball.set("body.ball.start.s", 0.0), ERROR);
    assert!(last().contains("body.ball.start.s cannot be set at a communication point"), "{}", last());
}

#[test]
fn closed_form_parameters_that_change_under_way() {
    // Rounding over a flight of one second.
    const ROUNDING: f64 = 1e-14;
    let plan = plan("bouncing_ball.toml", unchanged);
    let ball = Instance::of("tuned", &plan, false);
    ball.begin();
    ball.step(0.0, 0.25);
    let (s, v) = (ball.get("ball.s"), ball.get("ball.v"));
    assert_eq!(ball.set("gravity", 1.62), OK);
    assert_eq!([ball.get("ball.s"), ball.get("ball.v")], [s, v]);
    assert!((ball.get("ball.a") - 1.62).abs() < 1e-15);
    // A state saved before the change acts continues identically, in another instance too.
    let (mut state, mut size) = (std::ptr::null_mut(), 0);
    let other = Instance::of("tuned", &plan, false);
    unsafe {
        assert_eq!(fmi3GetFMUState(ball.c, &mut state), OK);
        assert_eq!(fmi3SerializedFMUStateSize(ball.c, state, &mut size), OK);
        let mut bytes = vec![0; size];
        assert_eq!(fmi3SerializeFMUState(ball.c, state, bytes.as_mut_ptr(), size), OK);
        let mut read = std::ptr::null_mut();
        assert_eq!(
            fmi3DeserializeFMUState(other.c, bytes.as_ptr(), size, &mut read),
            OK,
            "{:?}",
            other.messages
        );
        assert_eq!(fmi3SetFMUState(other.c, read), OK);
        assert_eq!(fmi3FreeFMUState(other.c, &mut read), OK);
        assert_eq!(fmi3FreeFMUState(ball.c, &mut state), OK);
    }
    for ball in [&ball, &other] {
        ball.step(0.25, 0.125);
        let t = 0.125;
        assert!((ball.get("ball.s") - (s + v * t + 0.81 * t * t)).abs() < ROUNDING);
        assert_eq!(ball.get("gravity"), 1.62);
        assert!(ball.get("energy.residual").abs() < ROUNDING, "{}", ball.get("energy.residual"));
        ball.step(0.375, 2.0);
    }
    assert_eq!(ball.get("ball.s").to_bits(), other.get("ball.s").to_bits());
    assert!(ball.whole("floor.impacts") > 0);
}

#[test]
fn a_change_that_does_not_go_with_the_state_is_refused_by_name_and_nothing_is_lost() {
    let plan = plan("bouncing_ball.toml", unchanged);
    let ball = Instance::of("untuned", &plan, true);
    ball.begin();
    ball.handle();
    ball.step(0.0, 0.25);
    let last = || ball.messages.last().unwrap().clone();
    unsafe { assert_eq!(fmi3EnterEventMode(ball.c), OK) };
    let before = ball.get("ball.s");
    // The ball is below such a floor.
    assert_eq!(ball.set("stop.floor.gap", 0.1), DISCARD);
    assert!(last().contains("stop.floor.gap = 0.1: stop.floor at t = 0.25 s: e - gap = "), "{}", last());
    assert_eq!(ball.set("body.ball.mass", -1.0), DISCARD);
    assert!(last().ends_with("body.ball.mass = -1: expected a finite number > 0"), "{}", last());
    assert_eq!(
        [ball.get("stop.floor.gap"), ball.get("body.ball.mass"), ball.get("ball.s")],
        [1.0, 0.02, before]
    );
    assert_eq!(ball.set("stop.floor.gap", 2.0), OK);
    assert!(ball.handle().0);
    ball.step(0.25, 0.35);
    // Still falling from 0 to 2 m.
    assert!((ball.get("ball.s") - 0.5 * 9.81 * 0.36).abs() < 1e-14 && ball.whole("floor.impacts") == 0);
}

#[test]
fn closed_form_a_frequency_that_changes_keeps_the_phase() {
    let text = "name = \"Cam\"\n[body.cam]\nmotion = { amplitude = 1.0, frequency = 1.0 }\n[body.b]\nmass = 1.0\n\
                [spring.s]\nbetween = [\"cam\", \"b\"]\nstiffness = 1.0\n";
    let plan = Plan::new(text.into(), FILE).unwrap();
    let cam = Instance::of("sweep", &plan, false);
    cam.begin();
    let (mut time, mut turns) = (0.0, 0.0);
    for frequency in [1.0, 2.5, 0.75, 4.0, 1.0] {
        let before = cam.get("cam.s");
        assert_eq!(cam.set("body.cam.motion.frequency", frequency), OK);
        assert!((cam.get("cam.s") - before).abs() < 1e-14, "{} {before}", cam.get("cam.s"));
        assert_eq!(cam.get("body.cam.motion.phase"), 0.0);
        cam.step(time, 0.3);
        (time, turns) = (time + 0.3, turns + 0.3 * frequency);
        let expected = (std::f64::consts::TAU * turns).sin();
        assert!((cam.get("cam.s") - expected).abs() < 1e-13, "{time}: {} {expected}", cam.get("cam.s"));
    }
}
