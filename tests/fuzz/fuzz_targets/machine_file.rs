//! Any text as a machine's file: it is refused with a message, or gives an instance that moves and
//! whose values are finite numbers.
//!
//! Begun from the examples:
//! ```text
//! cargo +nightly fuzz run --fuzz-dir tests/fuzz machine_file examples/assembly -- \
//!     -only_ascii=1 -timeout=60
//! ```
#![no_main]
#![allow(missing_docs)]

use fmi_doors::log::{Category, Log};
use fmi_doors::{Bases, Component, EventHandling, Interface, Life, Model};
use libfuzzer_sys::fuzz_target;
use std::sync::Arc;
use vibro_machine_component::{FILE, Machine, Plan};

/// Largest size of a file; longer files do not test more.
const LONGEST: usize = 4096;
/// Steps, s: some in which little happens, and some in which the work must be limited.
const STEPS: [f64; 4] = [1e-6, 1e-3, 0.03, 0.1];

struct Silent;

impl Log for Silent {
    fn wants(&self, _: Category) -> bool {
        false
    }
    fn log(&mut self, _: Category, _: &str) {}
}

fuzz_target!(|text: &str| {
    if text.len() > LONGEST {
        return;
    }
    let plan = match Plan::new(text.to_owned(), FILE) {
        Ok(plan) => plan,
        Err(problem) => {
            assert!(!problem.to_string().is_empty());
            return;
        }
    };
    let plan = Arc::new(plan.with_arrays());
    let mut machine = Machine::new(plan.clone(), Life::new(Interface::CoSimulation, EventHandling::default()));
    machine.enter_initialization();
    if machine.exit_initialization(&mut Silent).is_err() {
        return;
    }
    let references: Vec<u32> = (1..=plan.table.rows.len() as u32).collect();
    for size in STEPS {
        let time = machine.time();
        // A refused step does not move the instance.
        if machine.step_as_agreed(time, size, &mut Silent).is_err() {
            assert_eq!(machine.time(), time);
        }
        let numbers = machine.get(Bases::ANY, &references, |_, value| assert!(value.is_finite()));
        assert!(numbers.is_ok());
    }
});
