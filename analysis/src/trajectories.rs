//! Many independent motions at once.

use super::error::Result;
use rayon::prelude::*;
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{Simulator, State, advance_together};

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
/// starts and depend neither on the number of threads nor on a start's neighbours. Since the periods are whole, a motion may be continued from its
/// result at time 0.
///
/// This is the one place through which sweeps of independent motions go: neighbours go [together](advance_together), those of
/// one system share its tables.
pub fn propagate(starts: &[Start], periods: u32, done: &(dyn Fn() + Sync)) -> Vec<Result<State>> {
    let some = |starts: &[Start]| {
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
    starts.par_chunks(TOGETHER).flat_map_iter(some).collect()
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
        /// Round-off, which the two ways differ in, and what the impacts of the periods led make of it, in chaos too.
        const ROUNDING: f64 = 1e-9;
        const PERIODS: u32 = 10;
        let led = propagate(&starts, PERIODS, &|| ());
        assert_eq!(led.len(), starts.len());
        for (start, led) in starts.iter().zip(led) {
            // In other company the same bits.
            let alone = propagate(std::slice::from_ref(start), PERIODS, &|| ()).remove(0);
            assert_eq!(led.as_ref().ok(), alone.as_ref().ok());
            let one = Simulator::new(&start.parameters, &start.state, 0.0).and_then(|s| {
                let mut s = s.without_energy_accounts();
                s.advance_to(f64::from(PERIODS) * start.parameters.period())?;
                Ok(s.state())
            });
            match (one, led) {
                (Ok(one), Ok(led)) => {
                    let pairs = one.x.iter().chain(&one.v).zip(led.x.iter().chain(&led.v));
                    let d = pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
                    assert!(d < ROUNDING, "{start:?}: {d:e}");
                }
                (Err(one), Err(led)) => assert_eq!(one.to_string(), led.to_string()),
                (one, led) => panic!("{one:?} {led:?}"),
            }
        }
    }
}
