//! Machines of many bodies: computing a start takes seconds at most.

use crate::common::*;
use std::time::{Duration, Instant};
use vibro_machine::description::*;
use vibro_machine::mode::StopState;

/// Time limit for `check` of a long row, about ten times its duration on a busy computer.
const PATIENCE: Duration = Duration::from_secs(5);

/// Blocks in a row, each lying on the one before it, the first one on the ground.
fn pile(count: usize) -> Description {
    let mut d = Description { gravity: 10.0, ..Description::default() };
    for i in 0..count {
        d.bodies.push(heavy(&format!("b{i}"), 1.0, -1.0, 0.0, 0.0));
        let terms = if i == 0 { vec![(0, -1.0)] } else { vec![(i - 1, 1.0), (i, -1.0)] };
        d.stops.push(rigid(&format!("s{i}"), &terms, 0.0, 0.5));
    }
    d
}

#[test]
fn closed_form_a_pile_of_blocks_bears_its_weight_in_time() {
    let count = 200;
    for starts_at_rest in [false, true] {
        let start = Instant::now();
        let m = motion(Description { starts_at_rest, ..pile(count) });
        let lasted = start.elapsed();
        for i in 0..count {
            let borne = 10.0 * (count - i) as f64;
            assert_eq!(m.mode().stops[i], StopState::Closed);
            assert!((m.stop(i)[2] - borne).abs() < 1e-11 * borne * count as f64, "{i}: {:?}", m.stop(i));
        }
        assert!(lasted < PATIENCE, "{starts_at_rest}: {lasted:?}");
    }
}

#[test]
fn closed_form_rows_of_blocks_that_touch_start_in_time() {
    // At rest the contacts are undecided. When one block is thrown at the others, momentum and
    // order are preserved, and energy as restitution requires.
    let count = 200;
    for (speed, restitution) in [(0.0, 0.5), (1.0, 1.0), (1.0, 0.5)] {
        let mut d = Description::default();
        for i in 0..count {
            d.bodies.push(body(&format!("b{i}"), 1.0, 0.0, if i == 0 { speed } else { 0.0 }));
            if i > 0 {
                d.stops.push(rigid(&format!("s{i}"), &[(i - 1, 1.0), (i, -1.0)], 0.0, restitution));
            }
        }
        let start = Instant::now();
        let m = motion(d);
        let lasted = start.elapsed();
        let rates: Vec<f64> = (0..count).map(|i| m.body(i)[1]).collect();
        assert!((rates.iter().sum::<f64>() - speed).abs() < 1e-12, "{rates:?}");
        let energy = rates.iter().map(|v| v * v).sum::<f64>() + 2.0 * m.energy().impacts.value();
        assert!((energy - speed * speed).abs() < 1e-12, "{energy}");
        assert!(rates.windows(2).all(|v| v[0] <= v[1] + 1e-12), "{rates:?}");
        assert!(lasted < PATIENCE, "{speed}: {lasted:?}");
        println!("{speed} {restitution}: {lasted:?}");
    }
}
