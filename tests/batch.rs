//! Vectorised motions compared with single motions (second method), with the golden files, and bit
//! by bit with the same motions among others (invariant).

mod common;

use common::golden::{distance, table, weak};
use rayon::prelude::*;
use vibro_impact::simulator::{DoubleDouble, Event, Loads, Pause, Snapshot, advance_together};
use vibro_impact::{Error, Parameters, Simulator, State};

fn start(place: f64) -> State {
    State { x: [0.0, place, 0.0], v: [0.0, 0.5, 0.0] }
}

fn motion(p: &Parameters, place: f64, time: f64) -> Simulator {
    Simulator::new(p, &start(place), time).expect("valid").without_energy_accounts()
}

/// Motions of all kinds: impacts, rest, chatter, no impacts at all; elastic and plastic stops;
/// without coupling, without damping, of other drive frequencies and none; accounts kept, loads.
fn motions() -> Vec<Simulator> {
    let mut all = Vec::new();
    let systems =
        [(0.75, 1.5), (0.0, 3.0), (0.6, 0.1), (0.9, 4.0), (0.3, 2.0), (1.0, 1.0), (0.2, 3.0), (0.5, 4.6)];
    for (i, (kappa, drive)) in systems.into_iter().enumerate() {
        let p = weak(kappa, drive);
        for place in [0.9, -0.4, 1.0] {
            let s = Simulator::new(&p, &start(place), 0.1 * i as f64).expect("valid");
            all.push(if i == 2 && place == 0.9 { s } else { s.without_energy_accounts() });
        }
        for p in [
            Parameters { coupling_stiffness: 0.0, ..p },
            Parameters { box_damping: 0.0, secondary_damping: 0.0, ..p },
            Parameters { drive_frequency: 0.35, drive_phase: 1.0, ..p },
            Parameters { drive_frequency: 3.1, drive_phase: -2.0, ..p },
            Parameters { drive_frequency: 0.0, drive_phase: 0.3, ..p },
        ] {
            all.push(motion(&p, 0.2, -3.0));
        }
    }
    let mut derivatives = [[0.0; 4]; 3];
    derivatives[1] = [0.02, 0.001, 0.0, 0.0];
    all[4].set_loads(&Loads { derivatives }).expect("valid");
    all
}

fn impacts(s: &Simulator) -> (u64, u64) {
    (s.impacts().upper, s.impacts().lower)
}

/// Growth of a small change of the velocities until `end`.
fn growth(simulator: &Simulator, end: f64) -> f64 {
    const CHANGE: f64 = 1e-9;
    let State { x, mut v } = simulator.state();
    for (v, sign) in v.iter_mut().zip([1.0, -1.0, 1.0]) {
        *v += sign * CHANGE;
    }
    let mut changed = simulator.with_state(&State { x, v }, simulator.time()).expect("valid");
    let mut same = simulator.clone();
    let _ = changed.set_loads(&same.loads());
    for s in [&mut same, &mut changed] {
        s.advance_to(end).expect("it arrives");
    }
    distance(&same.state(), &changed.state(), 1.0, 1.0) / CHANGE
}

/// Rounding of some hundred sub-steps with positions up to a few gaps, to be multiplied by the
/// growth.
const ROUNDING: f64 = 1e-12;
/// Largest growth of small differences in comparisons of two computations of a motion.
const MAX_GROWTH: f64 = 1e4;

#[test]
fn second_method_together_as_one_by_one() {
    let (first, mut together, mut alone) = (motions(), motions(), motions());
    let mut compared = [0; 4];
    for (end, compared) in [1.0, 13.0, 60.0, 126.0].into_iter().zip(&mut compared) {
        // Growth from the start and the previous end: a difference in between may have decayed.
        let begun = alone.clone();
        let results = advance_together(&mut together, |_| end);
        for (i, ((alone, together), result)) in alone.iter_mut().zip(&together).zip(results).enumerate() {
            assert_eq!(result, alone.advance_to(end));
            assert_eq!(together.time(), end);
            let growth = growth(&first[i], end).max(growth(&begun[i], end));
            if growth < MAX_GROWTH {
                *compared += 1;
                let d = distance(&alone.state(), &together.state(), 1.0, 1.0);
                assert!(d < ROUNDING * growth.max(1.0), "motion {i} at {end}: {d:e}, growth {growth:e}");
                assert_eq!(impacts(alone), impacts(together), "motion {i} at {end}");
                assert_eq!(alone.contact(), together.contact(), "motion {i} at {end}");
                let (a, t) = (alone.impacts(), together.impacts());
                let d = (a.total_impulse - t.total_impulse).abs().max((a.last_time - t.last_time).abs());
                let d = d.max((a.box_impulse - t.box_impulse).abs());
                let lost = (alone.energy_accounts().impact - together.energy_accounts().impact).abs();
                assert!(
                    d.max(lost) < ROUNDING * 1e2 * growth.max(1.0),
                    "motion {i} at {end}: {d:e} {lost:e}"
                );
            }
        }
    }
    println!("{compared:?} of {}", together.len());
    assert!(compared[3] > 20, "{compared:?}");
}

#[test]
fn second_method_settled_orbits_and_their_impacts() {
    /// Rounding of the last periods, because a stable motion forgets its start.
    const END: f64 = 1e-11;
    let settle = [(0.75, 1.5), (0.6, 1.2), (0.5, 1.5), (0.2, 1.5), (0.0, 3.0), (0.3, 2.5)];
    let mut alone: Vec<Simulator> =
        settle.iter().map(|&(kappa, drive)| motion(&weak(kappa, drive), 0.9, 0.0)).collect();
    let mut together = alone.clone();
    let total = |s: &Simulator| s.impacts().upper + s.impacts().lower;
    let mut counts = Vec::new();
    for periods in [1000.0, 1100.0] {
        let end = |s: &Simulator| periods * s.parameters().period();
        assert!(advance_together(&mut together, end).iter().all(Result::is_ok));
        for s in &mut alone {
            s.advance_to(end(s)).expect("it arrives");
        }
        counts.push(together.iter().zip(&alone).map(|(t, a)| [total(t), total(a)]).collect::<Vec<_>>());
    }
    for (i, (alone, together)) in alone.iter().zip(&together).enumerate() {
        let (a, t) = (alone.state(), together.state());
        // Another transient may end on the mirror image of the orbit, half a period later.
        let mirror = State { x: t.x.map(|x| -x), v: t.v.map(|v| -v) };
        let mut later = alone.clone();
        later.advance_to(1100.5 * alone.parameters().period()).expect("it arrives");
        let d = distance(&a, &t, 1.0, 1.0).min(distance(&later.state(), &mirror, 1.0, 1.0));
        assert!(d < END, "{:?}: {d:e}", settle[i]);
        let [together, alone] = [0, 1].map(|way| counts[1][i][way] - counts[0][i][way]);
        assert_eq!(together, alone, "{:?}", settle[i]);
    }
}

#[test]
fn golden_standard_work_together() {
    /// Error of a rounding that 50 impacts amplify, some of them nearly grazing.
    const TARGET: f64 = 5e-11;
    let p = weak(0.75, 1.5);
    let mut all: Vec<Simulator> = (0..21).map(|i| motion(&p, 0.9 - 0.01 * f64::from(i % 3), 0.0)).collect();
    let mut worst: f64 = 0.0;
    for row in table("standard_double_periods.csv").chunks(4).map(|rows| &rows[rows.len() - 1]) {
        assert!(advance_together(&mut all, |_| row.get("t")).iter().all(Result::is_ok));
        for s in all.iter().step_by(3) {
            worst = worst.max(distance(&s.state(), &row.state(""), 1.0, 1.0));
            let (upper, lower) = impacts(s);
            assert_eq!((upper + lower) as f64, row.get("impacts"));
        }
    }
    println!("largest error over 20 periods: {worst:e}");
    assert!(worst < TARGET, "{worst:e}");
}

/// Name, motion and end of each row of a golden file; the end is so long after the row's event
/// that the event is not in the last sub-steps.
fn golden_rows(name: &str) -> Vec<(String, Simulator, f64)> {
    let rows = table(name);
    let start = |row: &common::golden::Row| {
        let p = row.parameters();
        let s = Simulator::new(&p, &row.state(""), row.get("t0")).expect("valid").without_energy_accounts();
        let fastest = [
            p.drive_frequency.powi(2),
            (p.box_stiffness + p.coupling_stiffness) / p.box_mass,
            p.coupling_stiffness / p.block_mass,
            (p.secondary_stiffness + p.coupling_stiffness) / p.secondary_mass,
        ];
        // More than two sub-steps.
        let later = 6.0 / fastest.into_iter().fold(0.0, f64::max).sqrt();
        (format!("{name} row {}", row.text("id")), s, row.get("t_end") + later)
    };
    rows.iter().map(start).collect()
}

#[test]
fn second_method_grazes_and_chatter_of_the_golden_files() {
    /// Error relative to the gap, after two and a half periods and up to 150 impacts.
    const STATE: f64 = 1e-12;
    let (mut compared, mut worst) = (0, 0.0f64);
    for name in ["grazing.csv", "chatter.csv"] {
        let rows = golden_rows(name);
        let ends: Vec<f64> = rows.iter().map(|row| row.2).collect();
        let mut together: Vec<Simulator> = rows.iter().map(|row| row.1.clone()).collect();
        // The end of the row that has this start; all starts differ.
        let end = |s: &Simulator| {
            let same = |row: &&(String, Simulator, f64)| row.1.snapshot() == s.snapshot();
            rows.iter().find(same).expect("a row").2
        };
        assert!(advance_together(&mut together, end).iter().all(Result::is_ok));
        for (((id, start, _), together), end) in rows.iter().zip(&together).zip(ends) {
            let mut alone = start.clone();
            let mut slowest = f64::INFINITY;
            alone
                .advance_observed(end, &mut |e| {
                    if let Event::Impact { speed, .. } = *e {
                        slowest = slowest.min(speed);
                    }
                })
                .expect("it arrives");
            assert_eq!(impacts(&alone), impacts(together), "{id}");
            assert_eq!(alone.contact(), together.contact(), "{id}");
            let growth = growth(start, end);
            if growth < MAX_GROWTH {
                let p = start.parameters();
                let rate = p.drive_frequency.max((p.box_stiffness / p.box_mass).sqrt());
                let d = distance(&alone.state(), &together.state(), p.stop_gap, p.stop_gap * rate);
                let bound = STATE * growth.max(1.0);
                worst = worst.max(d / bound);
                assert!(d < bound, "{id}: {d:e}, growth {growth:e}, slowest impact {slowest:e}");
                compared += 1;
            }
        }
    }
    println!("{compared} compared, largest difference over what is allowed {worst:e}");
    assert!(compared > 450, "{compared}");
}

#[test]
fn invariant_a_motion_depends_on_nothing_but_itself() {
    let end = |s: &Simulator| s.time().max(0.0) + 90.0 + 7.0 * s.parameters().stop_restitution;
    let first = motions();
    let mut expected = first.clone();
    let results = advance_together(&mut expected, end);
    let expected: Vec<Snapshot> = expected.iter().map(Simulator::snapshot).collect();
    let count = first.len();
    for (step, group) in [(1, 1), (5, 2), (11, 3), (17, 5), (23, 16), (29, 40), (count - 1, count)] {
        // A step that is coprime to the number of motions visits all of them.
        let order: Vec<usize> = (0..count).map(|i| (i * step + 3) % count).collect();
        assert_eq!(order.iter().collect::<std::collections::HashSet<_>>().len(), count, "{step}");
        let mut shuffled: Vec<Simulator> = order.iter().map(|&i| first[i].clone()).collect();
        let threads = rayon::ThreadPoolBuilder::new().num_threads(1 + step % 3).build().expect("threads");
        let others: Vec<_> = threads
            .install(|| shuffled.par_chunks_mut(group).flat_map_iter(|g| advance_together(g, end)).collect());
        for ((&i, s), result) in order.iter().zip(&shuffled).zip(others) {
            assert_eq!(result, results[i]);
            assert_eq!(s.snapshot(), expected[i], "motion {i} in groups of {group}");
        }
    }
    // A motion with shared tables is bit-identical to one with its own.
    let shared = first[0].with_state(&first[1].state(), first[1].time()).expect("valid");
    assert_eq!(shared.parameters(), first[1].parameters());
    let mut pair = [shared, first[40].clone()];
    advance_together(&mut pair, end);
    assert_eq!(pair[0].snapshot(), expected[1]);
}

#[test]
fn second_method_impacts_without_end_are_reported() {
    // A constant force of a hundred gaps times the fastest rate squared presses the box against an
    // elastic block, whose bounces are just too high to count as closed.
    let p = Parameters {
        stop_restitution: 1.0,
        box_stiffness: 0.0,
        coupling_stiffness: 0.0,
        drive_frequency: 0.0,
        drive_phase: std::f64::consts::FRAC_PI_2,
        drive_amplitude: -100.0,
        ..Parameters::default()
    };
    let pressed = State { x: [0.0, 1.0, 0.0], v: [0.0, -3e-5, 0.0] };
    let mut alone = Simulator::new(&p, &pressed, 0.0).expect("valid").without_energy_accounts();
    let mut together = [alone.clone(), motion(&weak(0.75, 1.5), 0.9, 0.0)];
    let results = advance_together(&mut together, |_| 30.0);
    assert!(matches!(alone.advance_to(30.0), Err(Error::WorkLimit { .. })));
    assert!(matches!(results[0], Err(Error::WorkLimit { .. })), "{results:?}");
    // Lanes check the limit every 64 sub-steps.
    for simulator in [&together[0], &alone] {
        assert!(simulator.impacts().upper > 900_000 && simulator.relative_motion().0 <= 1.0);
    }
    assert_eq!((&results[1], together[1].time()), (&Ok(()), 30.0));
}

#[test]
fn one_that_fails_leaves_the_others_alone() {
    let mut late = Simulator::new(&weak(0.75, 1.5), &start(0.9), 50.0).expect("valid");
    let before = late.snapshot();
    let mut all = vec![late.clone().without_energy_accounts(), motions().remove(0)];
    let results = advance_together(&mut all, |_| 20.0);
    assert_eq!(results[0], Err(Error::Step { time: 50.0, end: 20.0 }));
    assert_eq!(results[1], Ok(()));
    assert_eq!(all[0].snapshot(), before);
    assert_eq!(all[1].time(), 20.0);
    assert!(
        late.advance_to(f64::NAN).is_err()
            && [f64::NAN, 1e300]
                .iter()
                .all(|&end| advance_together(&mut all, |_| end).iter().all(Result::is_err))
    );
    assert!(advance_together(&mut [], |_| 1.0).is_empty());
}
#[test]
fn second_method_another_of_the_same_system_is_a_new_one() {
    let p = weak(0.75, 1.5);
    let mut first = Simulator::new(&p, &start(0.9), 0.0).expect("valid");
    first.advance_to(30.0).expect("it arrives");
    first.set_loads(&Loads { derivatives: [[0.1; 4]; 3] }).expect("valid");
    let mut other = first.with_state(&start(-0.2), 3.0).expect("valid");
    let mut new = Simulator::new(&p, &start(-0.2), 3.0).expect("valid");
    assert_eq!(other.snapshot(), new.snapshot());
    other.advance_to(60.0).expect("it arrives");
    new.advance_to(60.0).expect("it arrives");
    assert_eq!(other.snapshot(), new.snapshot());
    assert_eq!(*other.work_counters(), *new.work_counters());
    // A change of the other's tables does not affect the first.
    let before = first.clone();
    other.set_parameters(&weak(0.5, 2.0)).expect("valid");
    first.advance_to(60.0).expect("it arrives");
    let mut again = before;
    again.advance_to(60.0).expect("it arrives");
    assert_eq!(first.snapshot(), again.snapshot());
    assert!(matches!(first.with_state(&start(1.5), 0.0), Err(Error::Penetration { .. })));
    assert!(matches!(
        first.with_state(&start(0.5), f64::INFINITY),
        Err(Error::OutOfRange { name: "time", .. })
    ));
}

/// A motion that enters the lanes while w still rounds to the stop that the block has just left
/// has the same impacts and losses as alone.
#[test]
fn second_method_motions_handed_over_right_after_an_impact() {
    /// Relative difference of the losses, over twelve seconds with some impacts.
    const SAME: f64 = 1e-9;
    let p = Parameters { stop_restitution: 0.7, ..Parameters::default() };
    for n in 0..100 {
        let start = State { x: [0.0, 0.9 - 0.016 * f64::from(n), 0.0], v: [0.0, 0.5, 0.0] };
        let mut one = Simulator::new(&p, &start, 0.0).unwrap().without_energy_accounts();
        one.advance_to_impact(400.0).unwrap();
        let (time, gone) = (one.time(), DoubleDouble::sum(one.time(), 1e-17));
        one.advance_until(gone, Pause::Never, None).unwrap();
        let mut alone = one.clone();
        alone.advance_to(time + 12.0).unwrap();
        let mut handed_over = [one];
        advance_together(&mut handed_over, |_| time + 12.0)[0].as_ref().unwrap();
        let [a, b] = [&alone, &handed_over[0]].map(impacts);
        assert_eq!(a, b, "{n}");
        let [a, b] = [&alone, &handed_over[0]].map(Simulator::impact_loss);
        assert!((a - b).abs() <= SAME * a, "{n}: {a} {b}");
    }
}
