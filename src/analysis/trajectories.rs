//! Many independent motions at once.

use super::error::Result;
use crate::parameters::Parameters;
use crate::simulator::{Simulator, State};
use rayon::prelude::*;

/// Where a motion starts, at time 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// The system.
    pub parameters: Parameters,
    /// Its state.
    pub state: State,
}

/// Leads motions over whole drive periods, on all threads; `done` hears of each. The results are in the order of the
/// starts and do not depend on the number of threads. Since the periods are whole, a motion may be continued from its
/// result at time 0.
///
/// This is the one place through which sweeps of independent motions go.
pub fn lead(starts: &[Start], periods: u32, done: &(dyn Fn() + Sync)) -> Vec<Result<State>> {
    let one = |start: &Start| {
        let mut simulator = Simulator::new(&start.parameters, &start.state, 0.0)?.without_ledger();
        simulator.advance_to(f64::from(periods) * start.parameters.period())?;
        done();
        Ok(simulator.state())
    };
    starts.par_iter().map(one).collect()
}
