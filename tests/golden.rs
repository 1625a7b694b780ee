//! The simulator compared with golden files computed in 60 digits by the scripts in `tests/data`.

mod common;

use common::golden::{distance, standard, table};
use vibro_impact::simulator::{Contact, Event, Pause};
use vibro_impact::{Simulator, State};
use vibro_numerics::double_double::DoubleDouble;

/// Rounding of w after a flight of up to one and a half periods, with states of order one.
const GAP_ROUNDING: f64 = 2e-14;

#[test]
fn golden_every_graze_is_found_at_its_time_and_none_invented() {
    find_every_graze(1, GAP_ROUNDING);
}

/// Short communication steps use other branches of the simulator than long ones.
#[test]
fn golden_every_graze_is_found_in_short_communication_steps() {
    for parts in [7, 60, 333] {
        // Each step adds a rounding of the coordinates, of order one, at random.
        find_every_graze(parts, GAP_ROUNDING * (1.0 + 0.1 * f64::from(parts).sqrt()));
    }
}

/// Compares the grazing set with the simulator in `parts` communication steps, within rounding.
fn find_every_graze(parts: u32, gap_rounding: f64) {
    let rows = table("grazing.csv");
    assert!(rows.len() > 300);
    let mut contacts = 0;
    for row in &rows {
        let id = format!(
            "row {} ({} {} depth {})",
            row.text("id"),
            row.text("set"),
            row.text("kind"),
            row.text("depth")
        );
        let (start, end) = (row.get("t0"), row.get("t_end"));
        let mut simulator = Simulator::new(&row.parameters(), &row.state(""), start).unwrap();
        let mut seen = Vec::new();
        for part in 1..=parts {
            let to =
                if part == parts { end } else { start + (end - start) * f64::from(part) / f64::from(parts) };
            simulator
                .advance_observed(to, &mut |e| {
                    if let Event::Impact { time, side, speed, .. } = *e {
                        seen.push((time, f64::from(side), speed));
                    }
                })
                .unwrap();
        }
        let expected = usize::from(row.text("contact") == "1");
        assert_eq!(seen.len(), expected, "{id}: {seen:?}");
        let mut loosened = 1.0;
        if let Some(&(time, side, speed)) = seen.first() {
            contacts += 1;
            let exact = row.get("speed");
            assert_eq!(side, row.get("side"), "{id}");
            // Rounding of the time as a double, and rounding of w over the approach speed.
            let late = (time - start) - row.get("delay");
            let bound = 4.0 * f64::EPSILON * time.abs() + gap_rounding / exact;
            assert!(late.abs() < bound, "{id}: {late:e}, allowed {bound:e}");
            assert!((speed - exact).abs() < gap_rounding * (1.0 + 10.0 / exact), "{id}: {speed} {exact}");
            loosened += 10.0 / exact;
        }
        let d = distance(&simulator.state(), &row.state("e_"), 1.0, 1.0);
        assert!(d < gap_rounding * loosened * 10.0, "{id}: {d:e}");
    }
    assert!(contacts > 250, "{contacts}");
}

#[test]
fn golden_standard_work_over_twenty_periods() {
    /// Error of a rounding that 50 impacts amplify, some of them nearly grazing.
    const TARGET: f64 = 5e-11;
    let (p, start) = standard();
    let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
    let mut impacts = Vec::new();
    let mut worst: f64 = 0.0;
    for row in table("standard_double_periods.csv") {
        let begin = simulator.time();
        let end = row.get("t");
        simulator
            .advance_until(
                DoubleDouble::sum(begin, end - begin),
                Pause::Never,
                Some(&mut |e| {
                    if let Event::Impact { time, side, speed, .. } = *e {
                        impacts.push((time, f64::from(side), speed));
                    }
                }),
            )
            .unwrap();
        worst = worst.max(distance(&simulator.state(), &row.state(""), 1.0, 1.0));
        assert_eq!(impacts.len() as f64, row.get("impacts"));
    }
    let rows = table("standard_double_impacts.csv");
    assert_eq!((impacts.len(), rows.len()), (50, 50));
    for (row, (time, side, speed)) in rows.iter().zip(impacts) {
        assert_eq!(side, row.get("side"));
        worst = worst.max((time - row.get("t")).abs()).max((speed - row.get("speed")).abs());
    }
    println!("largest error over 20 periods: {worst:e}");
    assert!(worst < TARGET, "{worst:e}");
}

#[test]
fn golden_standard_work_after_two_thousand_periods() {
    /// Error at the end: the motion is stable, so that only the rounding of 2000 periods as a
    /// double remains, 1e-12 s.
    const END: f64 = 1e-11;
    let (p, start) = standard();
    let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
    simulator.advance_to(2000.0 * p.period()).unwrap();
    // From a certificate in interval arithmetic.
    let certified = State {
        x: [-0.4253110842429075, 0.2872634800253607, 0.4900836440556809],
        v: [-0.7166788315354791, -1.2876764920670574, -0.3927812190837065],
    };
    let direct = distance(&simulator.state(), &certified, 1.0, 1.0);
    // The transient amplifies rounding by 10⁹ between periods 20 and 60: with another mathematical
    // library the motion may settle on the mirror image of the orbit, x → -x half a period later.
    simulator.advance_to(2000.5 * p.period()).unwrap();
    let State { x, v } = simulator.state();
    let mirror = State { x: x.map(|x| -x), v: v.map(|v| -v) };
    let d = direct.min(distance(&mirror, &certified, 1.0, 1.0));
    assert!(d < END, "{d:e}");
    let impacts = simulator.impacts();
    /// Largest difference of the number of impacts between two transients.
    const TRANSIENT: u64 = 50;
    assert!((impacts.upper + impacts.lower).abs_diff(5979) <= TRANSIENT, "{impacts:?}");
}

#[test]
fn golden_every_chatter_ends_in_rest_and_lets_go_at_its_time() {
    /// Error of an instant relative to the time scale √(L/a), about 1. Chatter is closed at speeds
    /// of 1e-8, so that its end is accurate to the square of that over 1 - κ; a root of the
    /// contact force is accurate to its own rounding.
    const INSTANT: f64 = 1e-12;
    /// Error of displacements over the gap and of velocities: the omitted chatter is under half a
    /// unit in the last place, and up to 150 impacts add their rounding.
    const STATE: f64 = 1e-12;
    let rows = table("chatter.csv");
    assert!(rows.len() > 100);
    let (mut worst_rest, mut worst_release, mut worst_state) = (0.0f64, 0.0f64, 0.0f64);
    for row in &rows {
        let id = format!("row {} ({} {})", row.text("id"), row.text("set"), row.text("kind"));
        let (p, t0) = (row.parameters(), row.get("t0"));
        let mut simulator = Simulator::new(&p, &row.state(""), t0).unwrap();
        let (mut rest, mut release, mut first) = (None, None, None);
        simulator
            .advance_observed(row.get("t_end"), &mut |e| match *e {
                Event::Impact { time, speed, .. } => first = first.or(Some((time, speed))),
                Event::Rest { time, side } => {
                    assert_eq!(f64::from(side), row.get("side"), "{id}");
                    assert!(rest.replace(time).is_none(), "{id}: rests twice");
                }
                Event::Release { time, .. } => assert!(release.replace(time).is_none(), "{id}"),
            })
            .unwrap();
        // Rate of the system, since the time scales of the rows differ.
        let rate = p.drive_frequency.max((p.box_stiffness / p.box_mass).sqrt());
        let late = |time: f64, column: &str| ((time - t0 - row.get(column)) * rate).abs();
        if row.text("kind") != "start" {
            let (_, speed) = first.expect("an impact");
            assert!((speed / row.get("first_speed") - 1.0).abs() < STATE * 1e2, "{id}");
            worst_rest = worst_rest.max(late(rest.unwrap_or_else(|| panic!("{id}: no rest")), "rest"));
        }
        assert_eq!(release.is_some(), row.maybe("release").is_some(), "{id}");
        if let Some(time) = release {
            worst_release = worst_release.max(late(time, "release"));
        }
        assert_eq!(simulator.contact() != Contact::Flight, row.get("mode") == 1.0, "{id}");
        let d = distance(&simulator.state(), &row.state("e_"), p.stop_gap, p.stop_gap * rate);
        worst_state = worst_state.max(d);
        let scale = p.drive_amplitude.abs().max(1e-300);
        assert!((simulator.contact_force() - row.get("force")).abs() < STATE * 1e2 * scale, "{id}");
    }
    println!("largest errors: rest {worst_rest:e}, release {worst_release:e}, state {worst_state:e}");
    assert!(worst_rest < INSTANT && worst_release < INSTANT && worst_state < STATE);
}
