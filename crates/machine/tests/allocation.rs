//! A motion in steady operation allocates nothing, neither between events nor at events of a
//! single element. The test has its own process, because it replaces the allocator.
#![allow(unsafe_code)] // `GlobalAlloc` is an unsafe trait

mod common;

#[path = "../../../tests/common/allocations.rs"]
mod allocations;

use allocations::{BYTES, COUNT};
use common::*;
use vibro_machine::description::*;
use vibro_machine::motion::EventKind;

/// A box on a mount, driven by a load and at its base; a block between a rigid stop and a buffer.
fn damper() -> Description {
    Description {
        bodies: vec![
            body("box", 4.0, 0.0, 0.0),
            body("block", 1.0, 0.0, 3.0),
            prescribed("base", sine(0.1, 1.0, 0.0), 0.0),
        ],
        springs: vec![spring(&[(2, -1.0), (0, 1.0)], 400.0, 2.0), spring(&[(0, -1.0), (1, 1.0)], 1.0, 0.0)],
        stops: vec![
            rigid("wall", &[(0, -1.0), (1, 1.0)], 0.3, 0.9),
            compliant("buffer", &[(1, -1.0), (0, 1.0)], 0.3, 2e4, 5.0, DampingLimit::NoPull),
        ],
        loads: vec![Load { name: "drive".into(), body: 0, force: sine(60.0, 2.0, 0.0) }],
        ..Description::default()
    }
}

/// A sled on a belt, held by a spring and an elastic stop: stick-slip motion.
fn sled() -> Description {
    Description {
        bodies: vec![body("sled", 1.0, 0.0, 0.4), prescribed("belt", Signal::default(), 0.4)],
        springs: vec![spring(&[(0, 1.0)], 100.0, 0.05)],
        stops: vec![compliant("elastic", &[(0, 1.0)], 0.02, 300.0, 0.2, DampingLimit::Elastogap)],
        frictions: vec![Friction {
            static_force: Some(constant(6.0)),
            ..friction(&[(0, 1.0), (1, -1.0)], 2.0)
        }],
        ..Description::default()
    }
}

/// Follows a machine for 30 s; requires 20 events of each of these kinds, and no allocation.
fn follow(machine: Description, kinds: &[fn(&EventKind) -> bool]) {
    let mut motion = motion(machine);
    // Until this time all modes and all transitions between them have occurred.
    motion.advance_to(60.0).unwrap();
    let mut counts = [0; 4];
    let before = COUNT.get();
    let advanced = motion.advance_observed(90.0, &mut |event| {
        counts.iter_mut().zip(kinds).for_each(|(count, is)| *count += usize::from(is(&event.kind)));
    });
    let taken = COUNT.get() - before;
    advanced.unwrap();
    assert!(counts.iter().take(kinds.len()).all(|&count| count >= 20), "{counts:?}");
    assert_eq!(taken, 0, "{counts:?}");
}

#[test]
fn a_motion_in_steady_operation_takes_no_memory() {
    follow(
        damper(),
        &[
            |kind| matches!(kind, EventKind::Impact { .. }),
            |kind| matches!(kind, EventKind::Press { .. }),
            |kind| matches!(kind, EventKind::Free { .. }),
        ],
    );
    follow(
        sled(),
        &[
            |kind| matches!(kind, EventKind::Press { .. }),
            |kind| matches!(kind, EventKind::Free { .. }),
            |kind| matches!(kind, EventKind::Stick { .. }),
            |kind| matches!(kind, EventKind::Slip { .. }),
        ],
    );
}

/// Bytes that a machine and its motion take per oscillator, for many uncoupled oscillators or for
/// a chain of them.
fn bytes_of_each(count: usize, is_chain: bool) -> usize {
    let mut d = Description::default();
    for i in 0..count {
        d.bodies.push(body(&format!("b{i}"), 1.0, 0.0, 1.0));
        let hung = is_chain.then(|| i.checked_sub(1)).flatten().map(|before| (before, -1.0));
        let terms: Vec<(usize, f64)> = hung.into_iter().chain([(i, 1.0)]).collect();
        d.springs.push(spring(&terms, 100.0 + i as f64, 0.1));
    }
    let before = BYTES.get();
    let mut motion = motion(d);
    motion.advance_to(1e-2).unwrap();
    (0..count).for_each(|i| assert!(motion.body(i)[1].is_finite()));
    (BYTES.get() - before) / count
}

#[test]
fn invariant_each_of_many_oscillators_takes_the_same_memory() {
    for is_chain in [false, true] {
        let [few, many] = [100, 800].map(|count| bytes_of_each(count, is_chain));
        // Lists of all entries would take eight times as much; sorted lists the ratio of the
        // logarithms.
        assert!(many < 2 * few, "{few} {many}");
    }
}
