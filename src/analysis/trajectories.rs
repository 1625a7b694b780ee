//! Many independent motions at once.

use super::error::Result;
use crate::parameters::Parameters;
use crate::simulator::{Simulator, State, advance_together};
use rayon::prelude::*;

/// Motions that one thread leads at a time.
const TOGETHER: usize = 16;

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
    let some = |starts: &[Start]| {
        let mut simulators: Vec<Simulator> = Vec::with_capacity(starts.len());
        let mut started = Vec::with_capacity(starts.len());
        for Start { parameters, state } in starts {
            let new = match simulators.last() {
                Some(last) if last.parameters() == parameters => last.another(state, 0.0),
                _ => Simulator::new(parameters, state, 0.0).map(Simulator::without_ledger),
            };
            started.push(new.map(|simulator| {
                simulators.push(simulator);
                simulators.len() - 1
            }));
        }
        let end = |s: &Simulator| f64::from(periods) * s.parameters().period();
        let outcomes = advance_together(&mut simulators, end);
        let state = |started: crate::Result<usize>| {
            let index = started?;
            done();
            outcomes[index].clone()?;
            Ok(simulators[index].state())
        };
        started.into_iter().map(state).collect::<Vec<Result<State>>>()
    };
    starts.par_chunks(TOGETHER).flat_map_iter(some).collect()
}
