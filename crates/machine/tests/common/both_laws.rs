//! Random motions whose events are each handled in two ways from one state: directly, as an event
//! of a single element, and by the general law.

use super::{motion, unaccounted};
use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, TestRng, TestRunner};
use vibro_machine::Motion;
use vibro_machine::description::Description;
use vibro_machine::mode::Mode;
use vibro_machine::motion::{Event, Reached};

/// Limits on the length of motions, and tolerance between the results of both ways.
pub struct BothLaws {
    /// Largest number of events.
    pub events: usize,
    /// End time, s.
    pub end: f64,
    /// Largest permitted difference of the two states, relative to the largest coordinate.
    pub rounding: f64,
}

/// An event handled in both ways.
pub struct Handled<'a> {
    /// The motion after the event.
    pub direct: &'a Motion,
    /// The motion after the event, by the general law.
    pub general: &'a Motion,
    /// The mode before the event.
    pub before: &'a Mode,
    /// The observed events.
    pub observed: &'a [Event],
}

impl BothLaws {
    /// Simulates a machine from its start and calls `look` after each event. Both ways must refuse
    /// the same events, observe events of the same kinds, and reach the same mode and state.
    pub fn follow(
        &self,
        start: Motion,
        mut look: impl FnMut(Handled) -> Result<(), TestCaseError>,
    ) -> Result<(), TestCaseError> {
        let mut direct = start;
        let mut general = direct.clone().by_general_law();
        for _ in 0..self.events {
            match direct.advance_before_event(self.end, &mut |_| ()) {
                Ok(Reached::Event) => {}
                Ok(Reached::End) | Err(_) => break,
            }
            general.restore(&direct.save());
            let before = direct.mode().clone();
            let [mut here, mut there] = [Vec::new(), Vec::new()];
            let results = [
                direct.apply_event(&mut |event| here.push(event.clone())),
                general.apply_event(&mut |event| there.push(event.clone())),
            ];
            prop_assert_eq!(&results[0], &results[1]);
            if results[0].is_err() {
                break;
            }
            prop_assert_eq!(direct.mode(), general.mode(), "at {}", direct.time());
            let kinds =
                |all: &[Event]| all.iter().map(|e| std::mem::discriminant(&e.kind)).collect::<Vec<_>>();
            prop_assert_eq!(kinds(&here), kinds(&there));
            let size = direct.state().amax();
            let off = (direct.state() - general.state()).amax();
            prop_assert!(off <= self.rounding * size, "{off:e} of {size:e} at {}", direct.time());
            look(Handled { direct: &direct, general: &general, before: &before, observed: &here })?;
        }
        Ok(())
    }
}

/// The energy balance of a motion.
pub struct Balance {
    begin: f64,
    /// The largest energy so far, at least 1 J.
    pub largest: f64,
}

impl Balance {
    /// Starts at a motion's current state.
    pub fn new(m: &Motion) -> Self {
        Self { begin: unaccounted(m), largest: 1.0 }
    }

    /// Requires that the accounts explain the energy, up to a fraction of the largest energy.
    pub fn check(&mut self, m: &Motion, part: f64) -> Result<(), TestCaseError> {
        let (kinetic, stored) = m.kinetic_and_stored();
        self.largest = self.largest.max(kinetic).max(stored.abs());
        let (off, largest) = (unaccounted(m) - self.begin, self.largest);
        prop_assert!(off.abs() < part * largest, "{off:e} of {largest} at {}", m.time());
        Ok(())
    }
}

/// Runs a test on a number of random machines, the same ones in each run. In one of tens of
/// thousands of machines a value lies at the threshold below which it counts as zero, and the two
/// ways decide differently.
pub fn on_machines(
    machines: &impl Strategy<Value = Description>,
    cases: u32,
    test: impl Fn(Motion) -> Result<(), TestCaseError>,
) {
    let config = ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    runner.run(machines, |machine| test(motion(machine))).unwrap();
}
