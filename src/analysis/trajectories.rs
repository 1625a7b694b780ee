//! Many independent motions at once.

use super::error::Result;
use crate::parameters::Parameters;
use crate::simulator::{Simulator, State, advance_together};
use rayon::prelude::*;

/// Where a motion starts, at time 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// The system.
    pub parameters: Parameters,
    /// Its state.
    pub state: State,
}

/// Motions that go together on one thread.
const TOGETHER: usize = 16;

/// Leads motions over whole drive periods, on all threads; `done` hears of each. The results are in the order of the
/// starts and do not depend on the number of threads. Since the periods are whole, a motion may be continued from its
/// result at time 0.
///
/// This is the one place through which sweeps of independent motions go: neighbours with one drive period go
/// [together](advance_together), those of one system share its tables.
pub fn lead(starts: &[Start], periods: u32, done: &(dyn Fn() + Sync)) -> Vec<Result<State>> {
    let alike = |a: &Start, b: &Start| a.parameters.period() == b.parameters.period();
    let groups: Vec<&[Start]> = starts.chunk_by(alike).flat_map(|g| g.chunks(TOGETHER)).collect();
    let led: Vec<Vec<Result<State>>> =
        groups.into_par_iter().map(|group| together(group, periods, done)).collect();
    led.into_iter().flatten().collect()
}

fn together(group: &[Start], periods: u32, done: &dyn Fn()) -> Vec<Result<State>> {
    let mut simulators: Vec<Simulator> = Vec::with_capacity(group.len());
    let mut refused: Vec<Option<crate::Error>> = Vec::with_capacity(group.len());
    for start in group {
        let made = match simulators.last().filter(|s| *s.parameters() == start.parameters) {
            Some(like) => like.another(&start.state, 0.0),
            None => Simulator::new(&start.parameters, &start.state, 0.0).map(Simulator::without_ledger),
        };
        refused.push(made.map(|simulator| simulators.push(simulator)).err());
    }
    let end = group.first().map_or(0.0, |s| f64::from(periods) * s.parameters.period());
    let ends = advance_together(&mut simulators, end);
    let mut arrived =
        simulators.iter().zip(ends).map(|(simulator, end)| Ok(end.map(|()| simulator.state())?));
    let result = |error: Option<crate::Error>| {
        done();
        // Every start that was not refused has its simulator.
        error.map_or_else(|| arrived.next().unwrap_or_else(|| unreachable!()), |e| Err(e.into()))
    };
    refused.into_iter().map(result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::{Groups, Scales};

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
        let led = lead(&starts, 40, &|| ());
        assert_eq!(led.len(), starts.len());
        for (start, led) in starts.iter().zip(led) {
            let one = Simulator::new(&start.parameters, &start.state, 0.0).and_then(|s| {
                let mut s = s.without_ledger();
                s.advance_to(40.0 * start.parameters.period())?;
                Ok(s.state())
            });
            match (one, led) {
                (Ok(one), Ok(led)) => assert_eq!(one, led),
                (Err(one), Err(led)) => assert_eq!(one.to_string(), led.to_string()),
                (one, led) => panic!("{one:?} {led:?}"),
            }
        }
    }
}
