//! Values fixed by a mode stay fixed over 1e5 steps and over 1e4 s: forces of slipping sliders,
//! (inner) coordinates of held sliders and contacts, outputs between samples and at limits.

use crate::blocks::column;
use crate::common::*;
use vibro_machine::Motion;

/// Rows of a run with many.
const ROWS: u32 = 100_000;
/// The spacing of doubles at 1e4 m is 1.8e-12 m: rounding of a sum of a few such numbers.
const FAR: f64 = 2e-11;
/// Rounding of a coordinate of a few mm under forces of a few N over 1e5 rows.
const NEAR: f64 = 1e-16 * ROWS as f64;

/// The transients decay as exp(-5 t) or faster: after this time, s, they are below rounding.
const SETTLED: f64 = 9.0;

/// Advances in rows of equal length and passes each row to `look`.
fn in_rows(m: &mut Motion, end: f64, rows: u32, mut look: impl FnMut(&Motion)) {
    let begin = m.time();
    for i in 1..=rows {
        m.advance_to(begin + (end - begin) * f64::from(i) / f64::from(rows)).unwrap();
        look(m);
    }
}

/// Runs a machine in many rows over 100 s and in few over 1e4 s; passes each row to `look`.
fn both_ways(text: &str, mut look: impl FnMut(&Motion)) {
    for (end, rows) in [(100.0, ROWS), (1e4, 100)] {
        let mut m = moving(text).with_table_memory(usize::MAX);
        in_rows(&mut m, end, rows, &mut look);
    }
}

const BELT: &str = r#"
    name = "Belt"
    body.belt = { motion = { rate = "1 m/s" } }
    body.block = { mass = "2 kg" }
    spring.hold = { between = ["ground", "block"], stiffness = "5 kN/m", damping = "20 N s/m" }
    spring.bristle = { between = ["block", "belt"], stiffness = "1e7 N/m", slip = "10 N" }
"#;

/// A block on a belt behind a bristle of 1e7 N/m stops where its spring of 5 kN/m carries the slip
/// force: 10 N / 5 kN/m = 2 mm.
#[test]
fn closed_form_a_slider_slips_at_its_level_whatever_the_rows() {
    let mut lost = 0.0;
    both_ways(BELT, |m| {
        if m.time() < SETTLED {
            lost = 0.0;
            return;
        }
        assert_eq!(column(m, "bristle.f"), 10.0);
        near(column(m, "block.s"), 2e-3, NEAR);
        near(column(m, "bristle.e") - column(m, "bristle.slider"), 1e-6, FAR);
        let now = m.energy().branches[0].value();
        assert!(now >= lost, "{now} after {lost}");
        lost = now;
    });
    // A saved state contains the force bit for bit, and continues with it.
    let mut m = moving(BELT);
    m.advance_to(123.456).unwrap();
    let mut on = Motion::resumed(m.assembly().clone(), &m.save()).unwrap();
    assert_eq!(column(&on, "bristle.f"), 10.0);
    on.advance_to(124.0).unwrap();
    assert_eq!(column(&on, "bristle.f"), 10.0);
}

/// The same machine next to other machines, so that no tables are kept.
#[test]
fn closed_form_a_slider_slips_at_its_level_without_tables() {
    let mut m = motion(machine(&with_company(BELT)));
    m.advance_to(SETTLED).unwrap();
    in_rows(&mut m, SETTLED + 1.0, 1000, |m| {
        assert_eq!(column(m, "bristle.f"), 10.0);
        near(column(m, "block.s"), 2e-3, NEAR);
    });
}

/// At most 1e-9 N acts on 1 kg for 1 s, although the spring's force has a rounding of 1e-7 N at
/// the position of the mass.
#[test]
fn closed_form_a_slider_of_almost_no_force_takes_almost_nothing() {
    let mut m = moving(
        r#"
        name = "Free"
        body.m = { mass = 1.0, start = { v = 1.0 } }
        spring.j = { between = ["ground", "m"], stiffness = 1e9, slip = 1e-9 }
    "#,
    );
    let (rows, mut lost) = (1000, 0.0);
    in_rows(&mut m, 1.0, rows, |m| {
        let now = m.energy().branches[0].value();
        assert!(now >= lost);
        lost = now;
    });
    near(column(&m, "m.v"), 1.0 - 1e-9, 1e-16 * f64::from(rows));
    near(lost, 1e-9, 1e-15);
}

/// A held slider's inner coordinate keeps its bits while the block shakes on its bristle.
#[test]
fn invariant_a_held_slider_keeps_its_place() {
    let text = r#"
        name = "Held"
        body.belt = { motion = { rate = "1 m/s" } }
        body.block = { mass = 2.0, start = { s = 0.02, v = 1.0 } }
        spring.bristle = { between = ["belt", "block"], stiffness = 1e5, damping = 4.0, slip = 1e3, slider = 0.0137 }
        load.push = { on = "block", amplitude = 100.0, frequency = 0.37 }
    "#;
    both_ways(text, |m| assert_eq!(column(m, "bristle.slider"), 0.0137));
}

/// A block stuck on a belt and a block pressed against a wall on it keep their relative
/// coordinates, a stiff spring to the belt its force, and a wheel in its freewheel its angle.
#[test]
fn invariant_held_contacts_keep_their_places() {
    let text = r#"
        name = "Carried"
        body.belt = { motion = { rate = "0.7 m/s" } }
        body.stuck = { mass = 2.0, start = { s = 1e-3, v = 0.7 } }
        body.pressed = { mass = 2.0, start = { s = 3e-3, v = 0.7 } }
        body.rider = { mass = 1.0, start = { v = 0.7 } }
        friction.sole = { between = ["belt", "stuck"], force = 1e4 }
        spring.bristle = { between = ["belt", "stuck"], stiffness = 1e6 }
        load.push = { on = "stuck", amplitude = 3.0, frequency = 0.1 }
        stop.wall = { between = ["belt", "pressed"], gap = 3e-3, restitution = 0.5 }
        load.press = { on = "pressed", constant = 3.0 }
        friction.seat = { between = ["pressed", "rider"], force = 1e3 }
        body.shaft = { inertia = 2.0, start = { v = 0.7 } }
        body.drum = { inertia = 1.0, start = { v = 0.7 } }
        freewheel.clutch = { between = ["drum", "shaft"] }
        spring.parallel = { between = ["drum", "shaft"], stiffness = 1e6 }
        load.torque = { on = "shaft", constant = 0.7 }
        damper.oil = { between = ["ground", "drum"], damping = 1.0 }
    "#;
    both_ways(text, |m| {
        for (e, place) in [("sole.e", 1e-3), ("wall.e", 3e-3), ("seat.e", -3e-3), ("parallel.e", 0.0)] {
            near(column(m, e), place, FAR);
        }
        near(column(m, "bristle.f"), 1e3, 1e6 * FAR);
        for rate in ["sole.rate", "wall.rate", "seat.rate", "parallel.rate"] {
            near(column(m, rate), 0.0, 1e-15);
        }
    });
}

/// A slipping friction force is exactly its level. An output between samples is the sample; at its
/// limit it is the limit, however far its state winds up, and so is the load that follows it.
#[test]
fn invariant_levels_limits_and_samples_hold() {
    let text = r#"
        name = "Levels"
        body.belt = { motion = { rate = "1 m/s" } }
        body.block = { mass = 2.0 }
        spring.hold = { between = ["ground", "block"], stiffness = 5e3, damping = 20.0 }
        friction.sole = { between = ["belt", "block"], force = 10.0 }
        body.driven = { mass = 1.0 }
        spring.k = { between = ["ground", "driven"], stiffness = 1e3, damping = 20.0 }
        signal.one = { constant = 1.0 }
        load.drive = { on = "driven", from = "wound.y", factor = "3 N" }
        [block.wound]
        inputs = ["one"]
        states = 1
        a = [[0.0]]
        b = [[0.7]]
        c = [[1.0]]
        outputs = ["y"]
        limits = { y = [-0.1, 0.1] }
        [block.slow]
        inputs = ["one", "block.s"]
        states = 1
        a = [[1.0]]
        b = [[1.0, 0.3]]
        c = [[1.0]]
        outputs = ["y"]
        sample = "7 s"
    "#;
    let (mut held, mut number) = (0.0, 0);
    both_ways(text, |m| {
        let sample = (m.time() / 7.0 + 1e-9).floor() as i64;
        let y = column(m, "slow.y");
        if m.time() > SETTLED {
            assert!(sample != number || y == held, "{y} {held}");
            assert_eq!(column(m, "sole.f").abs(), 10.0);
            near(column(m, "block.s"), 2e-3, NEAR);
            assert_eq!(column(m, "wound.y"), 0.1);
            near(column(m, "drive.f"), 0.3, 1e-16);
            near(column(m, "driven.s"), 3e-4, NEAR);
        }
        (held, number) = (y, sample);
    });
}

/// A plate that steps leaves a stuck block behind: no finite force could move it along.
#[test]
fn closed_form_a_plate_that_steps_leaves_behind_what_sticks_to_it() {
    let mut m = moving(
        r#"
        name = "Plate"
        body.plate = { motion = { steps = [[0.5, 0.1]] } }
        body.block = { mass = 2.0, start = { s = 0.03 } }
        friction.sole = { between = ["plate", "block"], force = 10.0 }
    "#,
    );
    for (time, e) in [(0.25, 0.03), (0.75, -0.07), (1.0, -0.07)] {
        m.advance_to(time).unwrap();
        assert_eq!(column(&m, "block.s"), 0.03);
        near(column(&m, "sole.e"), e, 1e-16);
    }
}
