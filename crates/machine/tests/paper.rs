//! The 3-DOF machine as an assembly compared with the 3-DOF core; they share only the root finder.

use crate::common::*;
use vibro_impact::simulator::{Event, Pause};
use vibro_impact::{Parameters, Simulator, State};
use vibro_machine::description::*;
use vibro_machine::motion::EventKind;

/// Rounding of the hundreds of sub-steps in twenty periods, amplified tenfold by impacts.
const AGREEMENT: f64 = 1e-12;
/// Perturbations of a start by some roundings, which measure the effect of rounding on a motion,
/// because the end of chatter depends on rounding.
const ROUNDINGS: [f64; 4] = [-5e-15, -1e-15, 1e-15, 5e-15];
/// Accepted difference between the two motions, relative to the largest deviation of the four
/// perturbed motions.
const APART: f64 = 3.0;

fn machine(p: &Parameters, start: &State) -> Description {
    let [box_s, block_s, secondary_s] = start.x;
    let [box_v, block_v, secondary_v] = start.v;
    Description {
        bodies: vec![
            body("box", p.box_mass, box_s, box_v),
            body("block", p.block_mass, block_s, block_v),
            body("secondary", p.secondary_mass, secondary_s, secondary_v),
        ],
        springs: vec![
            Spring { name: "mount".into(), ..spring(&[(0, 1.0)], p.box_stiffness, p.box_damping) },
            Spring {
                name: "second".into(),
                ..spring(&[(2, 1.0)], p.secondary_stiffness, p.secondary_damping)
            },
            Spring { name: "coupling".into(), ..spring(&[(1, -1.0), (2, 1.0)], p.coupling_stiffness, 0.0) },
        ],
        stops: vec![
            rigid("upper", &[(0, -1.0), (1, 1.0)], p.stop_gap, p.stop_restitution),
            rigid("lower", &[(0, 1.0), (1, -1.0)], p.stop_gap, p.stop_restitution),
        ],
        loads: vec![Load {
            name: "drive".into(),
            body: 0,
            force: sine(p.drive_amplitude, p.drive_frequency / std::f64::consts::TAU, p.drive_phase),
        }],
        ..Description::default()
    }
}

fn compare(p: &Parameters, start: &State, periods: f64, tolerance: f64) {
    let mut core = Simulator::new(p, start, 0.0).unwrap();
    let off = |by: f64| State { x: [start.x[0], start.x[1] + by, start.x[2]], ..*start };
    let mut others = ROUNDINGS.map(|by| Simulator::new(p, &off(by), 0.0).unwrap());
    let (fixed, mut tolerance) = (tolerance, tolerance);
    let mut m = motion(machine(p, start));
    let mut own = Vec::new();
    let mut theirs = Vec::new();
    for k in 1..=(periods as usize * 4) {
        let end = 0.25 * k as f64 * p.period();
        m.advance_observed(end, &mut |e| {
            if let EventKind::Impact { stop, speed, .. } = e.kind {
                own.push((e.time, stop, speed));
            }
        })
        .unwrap();
        core.advance_until(
            end,
            Pause::Never,
            Some(&mut |e: &Event| {
                if let Event::Impact { time, side, speed, .. } = *e {
                    theirs.push((time, usize::from(side < 0), speed));
                }
            }),
        )
        .unwrap();
        let state = core.state();
        for other in &mut others {
            other.advance_to(end).unwrap();
            let moved = other.state();
            let way = |i: usize| (moved.x[i] - state.x[i]).abs().max((moved.v[i] - state.v[i]).abs());
            tolerance = tolerance.max(fixed + APART * way(0).max(way(1)).max(way(2)));
        }
        for i in 0..3 {
            let [s, v, _] = m.body(i);
            assert!(
                (s - state.x[i]).abs() < tolerance && (v - state.v[i]).abs() < tolerance,
                "{k} {i} {:e} {:e}",
                s - state.x[i],
                v - state.v[i]
            );
        }
    }
    // Chatter ends at different bounce heights; only faster impacts are compared.
    let loud = |all: &[(f64, usize, f64)]| all.iter().filter(|i| i.2 > 1e-4).cloned().collect::<Vec<_>>();
    let (own, theirs) = (loud(&own), loud(&theirs));
    assert!(theirs.len() > 10, "{theirs:?}");
    assert_eq!(own.len(), theirs.len());
    for (a, b) in own.iter().zip(&theirs) {
        assert!(
            a.1 == b.1 && (a.0 - b.0).abs() < 10.0 * tolerance && (a.2 - b.2).abs() < 10.0 * tolerance,
            "{a:?} {b:?}"
        );
    }
}

#[test]
fn second_method_the_papers_machine() {
    let p = Parameters::default();
    let start = State { x: [0.0, 0.9, 0.0], v: [0.0, 0.5, 0.0] };
    compare(&p, &start, 20.0, AGREEMENT);
}

#[test]
fn second_method_chatter_and_rest() {
    let p = Parameters { stop_restitution: 0.4, drive_amplitude: 0.4, ..Parameters::default() };
    let start = State { x: [0.0, 0.2, 0.0], v: [0.3, 0.5, 0.0] };
    compare(&p, &start, 20.0, 1e2 * AGREEMENT);
    let p = Parameters { stop_restitution: 0.0, ..Parameters::default() };
    compare(&p, &start, 20.0, AGREEMENT);
}
