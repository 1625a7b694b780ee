//! Many independent motions in one call.

use super::Simulator;
use super::lanes::{Lanes, Motion};
use crate::error::{Error, Result};
use crate::extended::Extended;

/// Advances each simulator to its `end` (s), as [`Simulator::advance_to`] does and with the same bits; several motions are
/// under way at a time, so that all together take less time than one after another. Those that keep their energy accounts
/// or are under loads go one by one. Results in the simulators' order.
pub fn advance_together(simulators: &mut [Simulator], end: impl Fn(&Simulator) -> f64) -> Vec<Result<()>> {
    let mut results: Vec<Result<()>> = simulators.iter().map(|s| s.check_end(end(s))).collect();
    let mut waiting = Vec::new();
    for (simulator, result) in simulators.iter_mut().zip(&mut results).rev() {
        if result.is_err() {
            continue;
        }
        if simulator.keeps_ledger || simulator.loaded() {
            *result = simulator.advance_to(end(simulator));
        } else {
            let (course, end) = (simulator.depart(), Extended::new(end(simulator)));
            waiting.push(Motion { simulator, course, end, result });
        }
    }
    pulp::Arch::new().dispatch(Lanes { waiting });
    results
}

impl Simulator {
    /// As an advance to `end` checks it.
    fn check_end(&self, end: f64) -> Result<()> {
        if end.is_finite() && end >= self.time() {
            return Ok(());
        }
        Err(Error::Step { time: self.time(), end })
    }
}
