//! Many independent motions in one call.

mod lanes;
pub(crate) mod vectors;

use self::lanes::{LaneMotion, Lanes};
use super::{Simulator, check_time};
use crate::error::{Error, Result};
use crate::numerics::double_double::DoubleDouble;

/// Advances each simulator to its `end` (s), as [`Simulator::advance_to`] does; on machines with AVX2 or AVX-512 the motions
/// lie side by side in the vectors: one or two take longer than by `advance_to`, from some three on all together take less
/// time than one after another, and eight or more less than half, unless rest takes up much of the motions. Those that keep
/// their energy accounts or are under loads go one by one. Results in the simulators' order.
///
/// A motion ends as accurately as one by one, impacts proved in the same way, but not on the same bits: the arithmetic is
/// ordered otherwise, and the last digits that differ grow as all do in a motion with impacts. It does not depend on the other
/// motions, their order or their number.
pub fn advance_together(simulators: &mut [Simulator], end: impl Fn(&Simulator) -> f64) -> Vec<Result<()>> {
    let mut results: Vec<Result<()>> = simulators.iter().map(|s| s.check_end(end(s))).collect();
    let mut waiting = Vec::new();
    for (simulator, result) in simulators.iter_mut().zip(&mut results).rev() {
        if result.is_err() {
            continue;
        }
        if simulator.keeps_energy_accounts || simulator.loaded() {
            *result = simulator.advance_to(end(simulator));
        } else {
            simulator.apply_due_event(None);
            let (advance, end) = (simulator.begin_advance(), DoubleDouble::new(end(simulator)));
            waiting.push(LaneMotion { simulator, advance, end, result });
        }
    }
    pulp::Arch::new().dispatch(Lanes { waiting });
    results
}

impl Simulator {
    /// As an advance to `end` checks it.
    fn check_end(&self, end: f64) -> Result<()> {
        if end.is_finite() && end >= self.time() {
            return check_time(self.model.rate, end);
        }
        Err(Error::Step { time: self.time(), end })
    }
}
