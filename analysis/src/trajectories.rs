//! Many independent motions at once, on all threads and several to a thread.

use super::error::Result;
use rayon::prelude::*;
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{Simulator, State, advance_together};

/// Motions that one thread advances together.
const TOGETHER: usize = 16;

/// Where a motion starts, at time 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// The system.
    pub parameters: Parameters,
    /// Its state.
    pub state: State,
}

/// Advances motions over `periods` whole drive periods, on all threads, and calls `done` after each. The results are in the
/// order of the starts and depend neither on the number of threads nor on the other starts. Since the periods are whole, a
/// motion may be continued from its result at time 0.
///
/// Starts that are neighbours in the list are [advanced together](advance_together), and neighbours of one system share its
/// tables.
///
/// # Errors
/// Each start has a result of its own: what [`Simulator::new`] or [`Simulator::advance_until`] refuses.
pub fn propagate(starts: &[Start], periods: u32, done: &(dyn Fn() + Sync)) -> Vec<Result<State>> {
    let together = |starts: &[Start]| {
        let mut simulators: Vec<Simulator> = Vec::with_capacity(starts.len());
        let mut started = Vec::with_capacity(starts.len());
        for Start { parameters, state } in starts {
            let new = match simulators.last() {
                Some(last) if last.parameters() == parameters => last.with_state(state, 0.0),
                _ => Simulator::new(parameters, state, 0.0).map(Simulator::without_energy_accounts),
            };
            started.push(new.map(|simulator| {
                simulators.push(simulator);
                simulators.len() - 1
            }));
        }
        let end = |s: &Simulator| f64::from(periods) * s.parameters().period();
        let outcomes = advance_together(&mut simulators, end);
        let state = |started: vibro_impact::Result<usize>| {
            let index = started?;
            done();
            outcomes[index].clone()?;
            Ok(simulators[index].state())
        };
        started.into_iter().map(state).collect::<Vec<Result<State>>>()
    };
    starts.par_chunks(TOGETHER).flat_map_iter(together).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use vibro_impact::parameters::{Groups, Scales};

    #[test]
    fn second_method_together_as_one_by_one() {
        // Several systems, one of another drive period, and starts that are refused among them.
        let mut starts = Vec::new();
        for (i, (f10, sigma1)) in [(0.6, 0.4), (2.48, 0.4), (3.6, 0.4), (1.5, 0.2)].into_iter().enumerate() {
            let groups = Groups { f10, sigma1, ..Groups::basic() };
            let parameters = groups.to_parameters(Scales::default()).unwrap();
            for k in 0..11 {
                let x2 = if k == 5 { 1.5 } else { 0.0 };
                let state = State { x: [0.0, x2, 0.0], v: [0.1 * i as f64, 0.2 * f64::from(k), 0.0] };
                starts.push(Start { parameters, state });
            }
        }
        /// The two ways differ in round-off, which the impacts of ten periods amplify, in chaos too.
        const ROUNDING: f64 = 1e-9;
        const PERIODS: u32 = 10;
        let ends = propagate(&starts, PERIODS, &|| ());
        assert_eq!(ends.len(), starts.len());
        for (start, end) in starts.iter().zip(ends) {
            // With other neighbours the bits are the same.
            let single = propagate(std::slice::from_ref(start), PERIODS, &|| ()).remove(0);
            assert_eq!(end.as_ref().ok(), single.as_ref().ok());
            let one = Simulator::new(&start.parameters, &start.state, 0.0).and_then(|s| {
                let mut s = s.without_energy_accounts();
                s.advance_to(f64::from(PERIODS) * start.parameters.period())?;
                Ok(s.state())
            });
            match (one, end) {
                (Ok(one), Ok(end)) => {
                    let pairs = one.x.iter().chain(&one.v).zip(end.x.iter().chain(&end.v));
                    let d = pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
                    assert!(d < ROUNDING, "{start:?}: {d:e}");
                }
                (Err(one), Err(end)) => assert_eq!(one.to_string(), end.to_string()),
                (one, end) => panic!("{one:?} {end:?}"),
            }
        }
    }
}
