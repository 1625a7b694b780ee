//! A motion in steady operation takes no memory, neither between its events nor at those of one element. Alone in its process, since it has
//! an allocator of its own.
#![allow(unsafe_code)] // an allocator is one

mod common;

use common::*;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use vibro_assembly::description::*;
use vibro_assembly::motion::EventKind;

thread_local! {
    /// Allocations of a test's own thread: the harness allocates in others meanwhile.
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: hands everything on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.set(COUNT.get() + 1);
        // SAFETY: as the caller vouches.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as the caller vouches.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// A box on a mount, driven at its base, with a block between a rigid stop and a buffer, and a sled that a belt drags along by friction
/// against a spring and an elastic stop: impacts, presses, sticking and slipping come again and again, and prescribed bodies do work.
fn machine() -> Description {
    Description {
        bodies: vec![
            body("box", 4.0, 0.0, 0.0),
            body("block", 1.0, 0.0, 3.0),
            body("sled", 1.0, 0.0, 0.4),
            prescribed("belt", Signal::default(), 0.4),
            prescribed("base", sine(0.1, 1.0, 0.0), 0.0),
        ],
        springs: vec![
            spring(&[(4, -1.0), (0, 1.0)], 400.0, 2.0),
            spring(&[(0, -1.0), (1, 1.0)], 1.0, 0.0),
            spring(&[(2, 1.0)], 100.0, 0.05),
        ],
        stops: vec![
            rigid("wall", &[(0, -1.0), (1, 1.0)], 0.3, 0.9),
            compliant("buffer", &[(1, -1.0), (0, 1.0)], 0.3, 2e4, 5.0, DampingLimit::NoPull),
            compliant("elastic", &[(2, 1.0)], 0.02, 300.0, 0.2, DampingLimit::Elastogap),
        ],
        frictions: vec![Friction {
            static_force: Some(constant(6.0)),
            ..friction(&[(2, 1.0), (3, -1.0)], 2.0)
        }],
        loads: vec![Load { name: "drive".into(), body: 0, force: sine(60.0, 2.0, 0.0) }],
        ..Description::default()
    }
}

#[test]
fn a_motion_in_steady_operation_takes_no_memory() {
    let mut motion = motion(machine());
    // In this time every mode that will be met has been met.
    motion.advance_to(1000.0).unwrap();
    let mut counts = [0; 6];
    let before = COUNT.get();
    let advanced = motion.advance_observed(1030.0, &mut |event| {
        let kind = match event.kind {
            EventKind::Impact { .. } => 0,
            EventKind::Press { stop: 1, .. } => 1,
            EventKind::Free { stop: 1 } => 2,
            EventKind::Stick { .. } => 3,
            EventKind::Slip { .. } => 4,
            EventKind::Press { stop: 2, .. } => 5,
            _ => return,
        };
        counts[kind] += 1;
    });
    let taken = COUNT.get() - before;
    advanced.unwrap();
    assert!(counts.iter().all(|&count| count >= 20), "{counts:?}");
    assert_eq!(taken, 0, "{counts:?}");
}
