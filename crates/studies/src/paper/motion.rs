//! Simulated motion for comparison with theory: settled, sampled and cut at impacts, with
//! amplitudes and maxima.

use vibro_impact::error::Result;
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{AdvanceOutcome, Event, Pause, Simulator, State};

/// Samples per drive period. Cubic interpolation between them is accurate to about 1e-8 of the
/// amplitudes.
const PER_PERIOD: u32 = 128;

/// State of a motion at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instant {
    /// Drive periods since the record began.
    pub time: f64,
    /// Phase of the drive, rad.
    pub phase: f64,
    /// The state, SI.
    pub state: State,
}

/// Motion between two impacts: instants in order, the first one after an impact, the last one
/// before the next impact. The first flight of a record begins, and the last one ends, without
/// impact.
pub type Flight = Vec<Instant>;

/// A simulator advanced from a state over `periods` drive periods to let the transient die out.
///
/// # Errors
/// As [`Simulator::new`] and [`Simulator::advance_to`].
pub fn settled_simulator(parameters: &Parameters, start: &State, periods: f64) -> Result<Simulator> {
    let mut simulator = Simulator::new(parameters, start, 0.0)?.without_energy_accounts();
    simulator.advance_to(periods * parameters.period())?;
    Ok(simulator)
}

/// Samples the next drive periods, cut at impacts.
///
/// # Errors
/// As [`Simulator::advance_until`].
pub fn record_flights(simulator: &mut Simulator, periods: u32) -> Result<Vec<Flight>> {
    let p = *simulator.parameters();
    let (begin, period) = (simulator.time(), p.period());
    let instant = |simulator: &Simulator, state| {
        let time = simulator.time();
        Instant { time: (time - begin) / period, phase: p.drive_frequency * time + p.drive_phase, state }
    };
    let mut flights = vec![vec![instant(simulator, simulator.state())]];
    for i in 1..=periods * PER_PERIOD {
        let end = begin + period * f64::from(i) / f64::from(PER_PERIOD);
        loop {
            let mut last = None;
            let now = simulator.time();
            let reason = simulator.advance_until(
                end,
                Pause::AfterImpact,
                Some(&mut |e| {
                    if let Event::Impact { side, impulse, .. } = e {
                        last = Some(f64::from(*side) * impulse);
                    }
                }),
            );
            // The last impact was at the end itself: a step of zero length is refused, and nothing
            // remains to be done.
            let reason = reason.or_else(|e| if now >= end { Ok(AdvanceOutcome::End) } else { Err(e) })?;
            let after = simulator.state();
            match (reason, last) {
                (AdvanceOutcome::Impact, Some(push)) => {
                    let mut before = after;
                    before.v[0] -= push / p.box_mass;
                    before.v[1] += push / p.block_mass;
                    let (before, after) = (instant(simulator, before), instant(simulator, after));
                    flights.last_mut().into_iter().for_each(|f: &mut Flight| f.push(before));
                    flights.push(vec![after]);
                }
                _ => {
                    let now = instant(simulator, after);
                    flights.last_mut().into_iter().for_each(|f| f.push(now));
                    break;
                }
            }
        }
    }
    Ok(flights)
}

/// Local maxima of q·x over a record, m, smooth or at an impact.
pub fn maxima(flights: &[Flight], parameters: &Parameters, q: [f64; 3]) -> Vec<f64> {
    let dot = |a: &[f64; 3]| q[0] * a[0] + q[1] * a[1] + q[2] * a[2];
    let mut found = Vec::new();
    let mut before: Option<f64> = None;
    for flight in flights {
        if let (Some(rate), Some(first)) = (before, flight.first())
            && rate > 0.0
            && dot(&first.state.v) <= 0.0
        {
            found.push(dot(&first.state.x));
        }
        for pair in flight.windows(2) {
            let h = (pair[1].time - pair[0].time) * parameters.period();
            let [(x0, v0), (x1, v1)] = [0, 1].map(|i| (dot(&pair[i].state.x), dot(&pair[i].state.v)));
            if v0 > 0.0 && v1 <= 0.0 {
                found.push(hermite_top(x0, v0 * h, x1, v1 * h));
            }
        }
        before = flight.last().map(|i| dot(&i.state.v));
    }
    found
}

/// Largest |q·x| over a record, m.
pub fn amplitude(flights: &[Flight], parameters: &Parameters, q: [f64; 3]) -> f64 {
    let ends = flights.iter().flat_map(|f| [f.first(), f.last()]).flatten();
    let sizes = ends.map(|i| (q[0] * i.state.x[0] + q[1] * i.state.x[1] + q[2] * i.state.x[2]).abs());
    let tops = maxima(flights, parameters, q).into_iter().chain(maxima(flights, parameters, q.map(|c| -c)));
    sizes.chain(tops).fold(0.0, f64::max)
}

/// Maximum on [0, 1] of the cubic with these values and slopes at its ends; its slope must pass
/// zero from above.
fn hermite_top(x0: f64, v0: f64, x1: f64, v1: f64) -> f64 {
    let (c2, c3) = (3.0 * (x1 - x0) - 2.0 * v0 - v1, v0 + v1 - 2.0 * (x1 - x0));
    let (mut low, mut high) = (0.0, 1.0);
    // The slope is quadratic and changes its sign once here, so bisection finds the zero.
    for _ in 0..50 {
        let t: f64 = 0.5 * (low + high);
        if v0 + t * (2.0 * c2 + 3.0 * t * c3) > 0.0 { low = t } else { high = t }
    }
    x0 + low * (v0 + low * (c2 + low * c3))
}

#[cfg(test)]
mod tests {
    use super::*;
    use vibro_impact::steady::exact_orbit;

    #[test]
    fn settled_motion_has_the_amplitudes_of_the_exact_orbit() {
        let p = Parameters::default();
        let orbit = exact_orbit::solve(&p).unwrap().upper.unwrap();
        let start = State { x: [0.0; 3], v: [0.3, 0.2, 0.0] };
        let mut simulator = settled_simulator(&p, &start, 400.0).unwrap();
        let flights = record_flights(&mut simulator, 2).unwrap();
        assert_eq!(flights.len(), 5, "two impacts a period");
        for (body, expected) in orbit.amplitudes().into_iter().enumerate() {
            let q = [0, 1, 2].map(|i| f64::from(u8::from(i == body)));
            let found = amplitude(&flights, &p, q);
            assert!((found - expected).abs() < 1e-7 * expected, "body {body}: {found} {expected}");
        }
        let tops = maxima(&flights, &p, [0.0, 1.0, 0.0]);
        assert_eq!(tops.len(), 2);
    }
}
