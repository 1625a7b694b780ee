//! A motion in steady operation takes no memory, neither between its events nor at those of one
//! element. Alone in its process, since it has an allocator of its own.
#![allow(unsafe_code)] // an allocator is one

mod common;

#[path = "../../tests/common/allocations.rs"]
mod allocations;

use allocations::COUNT;
use common::*;
use vibro_assembly::description::*;
use vibro_assembly::motion::EventKind;

/// A box on a mount, driven by a load and at its base, with a block between a rigid stop and a
/// buffer.
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

/// A sled that a belt drags along by friction against a spring and an elastic stop: it sticks and
/// slips.
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

/// Follows a machine for 30 s; each of some kinds of events must come 20 times, and nothing be
/// allocated.
fn follow(machine: Description, kinds: &[fn(&EventKind) -> bool]) {
    let mut motion = motion(machine);
    // In this time every mode has been met, and from each those that follow it.
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
