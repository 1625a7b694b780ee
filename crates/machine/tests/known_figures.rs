//! The machines of examples/assembly against the figures in their files, and every kind of element
//! and signal against closed forms.

use crate::common::*;
use std::path::Path;
use std::sync::Arc;
use vibro_machine::file::read;
use vibro_machine::motion::{Event, EventKind};
use vibro_machine::{Assembly, Motion};

/// Figures of fifteen digits after hundreds of roundings.
const FIGURE: f64 = 2e-13;
/// Roundings of numbers of order one.
const ROUNDING: f64 = 1e-13;

fn example(name: &str) -> Motion {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/assembly")).join(name);
    start(read(&path).unwrap_or_else(|e| panic!("{e}")))
}

fn start(description: vibro_machine::Description) -> Motion {
    Motion::new(Arc::new(Assembly::new(description).unwrap())).unwrap()
}

fn events(m: &mut Motion, end: f64) -> Vec<Event> {
    let mut all = Vec::new();
    m.advance_observed(end, &mut |event| all.push(event.clone())).unwrap();
    all
}

fn times(all: &[Event], kind: impl Fn(&EventKind) -> bool) -> Vec<f64> {
    all.iter().filter(|event| kind(&event.kind)).map(|event| event.time).collect()
}

fn near(found: f64, exact: f64, tolerance: f64) {
    assert!((found - exact).abs() <= tolerance * exact.abs().max(1.0), "{found} {exact}");
}

#[test]
fn others_models_translational_elastogap() {
    let mut m = example("msl_elastogap.toml");
    m.advance_to(5.0).unwrap();
    near(m.body(0)[0], -0.707885294079811, FIGURE);
}

#[test]
fn others_models_rotational_backlash() {
    let mut m = example("msl_backlash.toml");
    m.advance_to(1.0).unwrap();
    near(m.body(0)[0], -0.155581413573608, 10.0 * FIGURE);
}

#[test]
fn others_models_brake() {
    let mut m = example("msl_brake.toml");
    let all = events(&mut m, 2.0);
    near(times(&all, |k| matches!(k, EventKind::Stick { .. }))[0], 1.1, FIGURE);
    near(m.body(0)[0], 0.6, FIGURE);
    assert_eq!(m.body(0)[1], 0.0);
}

#[test]
fn others_models_sdnd106() {
    let mut m = example("aster_sdnd106.toml");
    let all = events(&mut m, 0.4);
    let slip = times(&all, |k| matches!(k, EventKind::Slip { .. }));
    let stick = times(&all, |k| matches!(k, EventKind::Stick { .. }));
    near(slip[0], 0.0351240736552036, FIGURE);
    near(stick[0], 0.314923275447487, FIGURE);
}

#[test]
fn closed_form_bouncing_ball() {
    let mut m = example("bouncing_ball.toml");
    let all = events(&mut m, 9.0);
    near(times(&all, |k| matches!(k, EventKind::Close { .. }))[0], 8.57894917872889, FIGURE);
}

#[test]
fn closed_form_den_hartog() {
    let mut m = example("den_hartog.toml");
    // Friction damps the transient of the undamped oscillator: after hundreds of periods the
    // amplitude is steady.
    let period = std::f64::consts::TAU / 1.5;
    m.advance_to(600.0 * period).unwrap();
    let mut largest = 0.0f64;
    for k in 1..=400 {
        m.advance_to((600.0 + k as f64 / 400.0) * period).unwrap();
        largest = largest.max(m.body(0)[0].abs());
    }
    // The largest of 400 samples is below the amplitude by up to (π/400)²/2 of it.
    assert!((largest - 0.721110255092798).abs() < 1e-4, "{largest}");
}

#[test]
fn closed_form_impact_on_spring_and_pair() {
    let mut m = example("impact_on_spring.toml");
    let free = times(&events(&mut m, 0.2), |k| matches!(k, EventKind::Free { .. }));
    let press =
        times(&events(&mut example("impact_on_spring.toml"), 0.2), |k| matches!(k, EventKind::Press { .. }));
    let first = press.first().copied().filter(|&t| t < free[0]).unwrap_or(0.0);
    near(free[0] - first, 0.0312600152681233, FIGURE);
    let mut m = example("impact_pair.toml");
    let all = events(&mut m, 60.0);
    // The start value has ten digits.
    let speeds: Vec<f64> = all
        .iter()
        .filter_map(|e| if let EventKind::Impact { speed, .. } = e.kind { Some(speed) } else { None })
        .collect();
    for speed in &speeds[4..] {
        assert!((speed - 4.0 / 3.0 * 1.50557395311726).abs() < 1e-8, "{speeds:?}");
    }
}

#[test]
fn closed_form_column_and_balls() {
    let mut m = example("bead_column.toml");
    m.advance_to(5.0).unwrap();
    near(m.stop(0)[2], 0.981, FIGURE);
    let mut m = example("three_balls.toml");
    m.advance_to(5.0).unwrap();
    for (i, v) in [-1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0].into_iter().enumerate() {
        near(m.body(i)[1], v, FIGURE);
    }
}

/// A mass under a load, from rest.
fn pulled(load: &str) -> Motion {
    moving(&format!("name = \"P\"\n[body.a]\nmass = 2.0\n[load.l]\non = \"a\"\n{load}\n"))
}

#[test]
fn closed_form_signals() {
    // Steps add heights; each is an event.
    let mut m = pulled("constant = 4.0\nsteps = [[0.5, 2.0], [1.0, -6.0]]");
    let all = events(&mut m, 2.0);
    assert_eq!(times(&all, |k| matches!(k, EventKind::Knot)), [0.5, 1.0]);
    // a = 2, then 3, then 0: v = 1 + 1.5, s = 0.25 + (0.5 + 0.375) + 2.5.
    near(m.body(0)[1], 2.5, ROUNDING);
    near(m.body(0)[0], 0.25 + 0.5 + 0.375 + 2.5, ROUNDING);
    // A piecewise linear record: force 6 t up to 1 s, then constant.
    let mut m = pulled("table = [[0.0, 0.0], [1.0, 6.0]]");
    m.advance_to(2.0).unwrap();
    near(m.body(0)[0], 0.5 + 1.5 + 1.5, ROUNDING);
    // A cubic record through three points of a line is that line.
    let mut m = pulled("table = [[0.0, 0.0], [0.5, 3.0], [1.0, 6.0]]\ninterpolation = \"cubic\"");
    m.advance_to(1.0).unwrap();
    near(m.body(0)[0], 0.5, ROUNDING);
    // An input with derivatives: 2 + 12 t + 24 t²/2.
    let mut m = pulled("input = true");
    m.set_input(0, [2.0, 12.0, 24.0, 0.0]).unwrap();
    m.advance_to(1.0).unwrap();
    near(m.body(0)[0], 0.5 * (1.0 + 2.0 + 1.0), ROUNDING);
    // Several harmonics: s'' = Σ A sin(ω t + φ)/m.
    let mut m = pulled(
        "harmonics = [{ amplitude = 2.0, frequency = \"3 rad/s\" }, { amplitude = 4.0, frequency = \"2 rad/s\", phase = 1.5 }]",
    );
    m.advance_to(1.5).unwrap();
    let part = |a: f64, w: f64, f: f64, t: f64| {
        a / 2.0 * (t * f.cos() / w + (f.sin() - (w * t + f).sin()) / (w * w))
    };
    near(m.body(0)[0], part(2.0, 3.0, 0.0, 1.5) + part(4.0, 2.0, 1.5, 1.5), ROUNDING);
}

#[test]
fn closed_form_links_and_prescribed_bodies() {
    // A drum on a gear of ratio 3 under a torque: one coordinate with J = 2 + 9 · 0.5.
    let mut m = moving(
        "name = \"G\"\n[body.wheel]\ninertia = 2.0\n[body.drum]\ninertia = 0.5\n\
         [link.gear]\narms = { wheel = 3.0, drum = -1.0 }\n[load.motor]\non = \"wheel\"\nconstant = 13.0\n",
    );
    m.advance_to(1.0).unwrap();
    near(m.body(0)[0], 1.0, ROUNDING);
    near(m.body(1)[0], 3.0, ROUNDING);
    near(m.body(1)[2], 6.0, ROUNDING);
    let (kinetic, _) = m.kinetic_and_stored();
    near(kinetic, 13.0, ROUNDING);
    near(m.energy().balance(), 13.0, ROUNDING);
    // A base at constant speed pulls a mass by a spring: s = v (t - sin(ω t)/ω).
    let mut m = moving(
        "name = \"B\"\n[body.base]\nmotion = { rate = \"2 m/s\" }\n[body.a]\nmass = 1.0\n\
         [spring.k]\nbetween = [\"base\", \"a\"]\nstiffness = 9.0\n",
    );
    m.advance_to(2.0).unwrap();
    near(m.body(1)[0], 2.0 * (2.0 - 6.0f64.sin() / 3.0), ROUNDING);
    let (kinetic, stored) = m.kinetic_and_stored();
    near(m.energy().motions.value(), kinetic + stored, 10.0 * ROUNDING);
    // A prescribed body moves a linked mass: the work of the motion is the kinetic energy.
    let mut m = moving(
        "name = \"L\"\n[body.cam]\nmotion = { amplitude = 0.5, frequency = \"2 rad/s\", rate = 1.0 }\n[body.follower]\nmass = 3.0\n\
         start = { v = 2.0 }\n[body.tip]\nmass = 1.0\n[link.rod]\nbetween = [\"cam\", \"follower\"]\n\
         [spring.k]\nbetween = [\"follower\", \"tip\"]\nstiffness = 5.0\n",
    );
    let (kinetic, stored) = m.kinetic_and_stored();
    m.advance_to(1.0).unwrap();
    near(m.body(1)[0], 1.0 + 0.5 * 2.0f64.sin(), ROUNDING);
    let (k, s) = m.kinetic_and_stored();
    near(m.energy().motions.value(), k + s - kinetic - stored, 10.0 * ROUNDING);
}

#[test]
fn jams_and_jumps_end_by_name() {
    let mut m = moving(
        "name = \"J\"\n[body.press]\nmotion = { rate = 1.0 }\n[body.a]\nmass = 1.0\n[stop.front]\nbetween = [\"a\", \"press\"]\n\
         gap = 0.2\nrestitution = 0.5\n[stop.wall]\nbetween = [\"ground\", \"a\"]\ngap = 0.1\nrestitution = 0.0\n",
    );
    let jam = m.advance_to(1.0).unwrap_err().to_string();
    assert!(
        jam.contains("jammed at t = 0.3") && jam.contains("stop.front") && jam.contains("stop.wall"),
        "{jam}"
    );
    let mut m = moving(
        "name = \"V\"\n[body.press]\nmotion = { steps = [[0.5, 1.0]] }\n[body.a]\nmass = 1.0\n[stop.front]\nbetween = [\"a\", \"press\"]\n\
         gap = 0.2\nrestitution = 0.5\n",
    );
    let jump = m.advance_to(1.0).unwrap_err().to_string();
    assert!(jump.starts_with("stop.front at t = 0.5 s: e - gap = 0.8"), "{jump}");
}

#[test]
fn invariant_split_steps_and_saved_states() {
    for name in ["two_blocks.toml", "percussion_drill.toml", "valve_train.toml"] {
        let (mut whole, mut split) = (example(name), example(name));
        whole.advance_to(0.5).unwrap();
        for k in 1..=7 {
            split.advance_to(0.5 * k as f64 / 7.0).unwrap();
            let saved = split.save();
            split.advance_to(0.6).unwrap();
            split.restore(&saved);
        }
        for i in 0..whole.assembly().description.bodies.len() {
            let (a, b) = (whole.body(i), split.body(i));
            // Dozens of impacts amplify the rounding differences of other sub-steps.
            assert!((a[0] - b[0]).abs() < 1e-9 && (a[1] - b[1]).abs() < 1e-6, "{name} {i} {a:?} {b:?}");
        }
    }
}
