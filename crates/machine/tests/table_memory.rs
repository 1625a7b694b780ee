//! The tables of a motion's modes stay within their memory limit, however a mode is entered.

use crate::common::*;
use vibro_machine::Motion;
use vibro_machine::description::*;
use vibro_machine::motion::Reached;

/// Independent bodies, each with a spring, a buffer and friction; all combinations are modes.
fn independent(count: usize) -> Description {
    let mut d = Description::default();
    for i in 0..count {
        d.bodies.push(body(&format!("b{i}"), 1.0, 0.0, 1.0));
        d.springs.push(spring(&[(i, 1.0)], 100.0 + 37.0 * i as f64, 0.01));
        d.stops.push(compliant(&format!("s{i}"), &[(i, 1.0)], 0.02, 500.0, 1.0, DampingLimit::NoPull));
        d.frictions.push(friction(&[(i, 1.0)], 0.1));
    }
    d
}

/// The largest memory after any event, and the times of the events.
fn follow(mut motion: Motion, end: f64) -> (usize, Vec<f64>) {
    let (mut most, mut times) = (0, Vec::new());
    while motion.advance_to_event(end, &mut |event| times.push(event.time)).unwrap() == Reached::Event {
        most = most.max(motion.table_memory());
    }
    (most, times)
}

#[test]
fn invariant_tables_stay_within_their_memory_on_every_way() {
    let machine = || motion(independent(8));
    let one = machine().table_memory();
    let (free, times) = follow(machine(), 2.0);
    assert!(free > 100 * one, "{free} {one}: too few modes for this test");
    // A mode's powers and contacts enlarge its tables; at an event the tables of two modes exist.
    let (given, event) = (20 * one, 4 * one);
    for general in [false, true] {
        let limited = machine().with_table_memory(given);
        let limited = if general { limited.by_general_law() } else { limited };
        let (most, same) = follow(limited, 2.0);
        assert!(most <= given + event, "{most} of {given}");
        assert!(most > given / 2, "{most} of {given}");
        assert_eq!(times.len(), same.len());
        assert!(general || times == same);
    }
}

#[test]
fn invariant_states_that_are_restored_do_not_fill_the_memory() {
    let (mut first, mut states) = (motion(independent(8)), Vec::new());
    while first.advance_to_event(1.0, &mut |_| ()).unwrap() == Reached::Event {
        states.push(first.save());
    }
    let one = motion(independent(8)).table_memory();
    let mut other = motion(independent(8)).with_table_memory(20 * one);
    for state in &states {
        other.restore(state);
        assert!(other.table_memory() <= 24 * one, "{} of {one}", other.table_memory());
    }
    assert!(states.len() > 100, "{}", states.len());
}
