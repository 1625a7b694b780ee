//! Local maxima of a displacement (x1, x2, x3, w or a weighted sum of x1, x2, x3), as reported by
//! the simulator.
//!
//! The flow gives the maxima, not samples: smooth maxima and corners at impacts, which reverse the
//! rate. In the motion with two symmetric impacts per period every maximum of x2 is such a corner.
//! A maximum of w that lasts, while the block rests at the upper stop, counts once, at its end.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;
use vibro_impact::model::Augmented;
pub use vibro_impact::simulator::Maximum;
use vibro_impact::simulator::{Contact, Event, MotionQueue, Plan, Reports, Simulator, State, advance_queue};

/// A displacement: a coordinate, or a weighted sum of coordinates.
///
/// ```
/// use vibro_studies::paper::maxima::Displacement;
///
/// assert_eq!(Displacement::W.weights(), [-1.0, 1.0, 0.0]); // w = x2 - x1
/// assert_eq!("x1".parse::<Displacement>()?, Displacement::X1);
/// # Ok::<(), vibro_studies::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Displacement {
    /// x1, the box.
    X1,
    /// x2, the block.
    #[default]
    X2,
    /// x3, the secondary oscillator.
    X3,
    /// w = x2 - x1, the block in the box.
    W,
    /// a x1 + b x2 + c x3 with the weights a, b, c.
    Sum([f64; 3]),
}

impl Displacement {
    /// Coordinates with names.
    pub const NAMED: [Self; 4] = [Self::X1, Self::X2, Self::X3, Self::W];

    /// Weights of x1, x2 and x3.
    pub fn weights(self) -> [f64; 3] {
        match self {
            Self::X1 => [1.0, 0.0, 0.0],
            Self::X2 => [0.0, 1.0, 0.0],
            Self::X3 => [0.0, 0.0, 1.0],
            Self::W => [-1.0, 1.0, 0.0],
            Self::Sum(weights) => weights,
        }
    }

    /// Name in tables, in units of L: `X1`, `X2`, `X3`, `W` or `sum`.
    pub fn name(self) -> &'static str {
        ["X1", "X2", "X3", "W", "sum"][self.index()]
    }

    /// Symbol in pictures, in units of L.
    pub fn symbol(self) -> &'static str {
        ["X₁", "X₂", "X₃", "W", "aX₁ + bX₂ + cX₃"][self.index()]
    }

    fn index(self) -> usize {
        match self {
            Self::X1 => 0,
            Self::X2 => 1,
            Self::X3 => 2,
            Self::W => 3,
            Self::Sum(_) => 4,
        }
    }
}

impl std::str::FromStr for Displacement {
    type Err = Error;

    /// Parses `x1`, `x2`, `x3` or `w`, in upper or lower case.
    fn from_str(text: &str) -> Result<Self> {
        let named = Self::NAMED.into_iter().find(|d| d.name().eq_ignore_ascii_case(text.trim()));
        named.ok_or_else(|| Error::Form { text: text.into(), expected: "one of x1, x2, x3, w" })
    }
}

impl std::fmt::Display for Displacement {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.name().to_lowercase())
    }
}

/// Record of one drive period.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PeriodRecord {
    /// State at the end.
    pub state: State,
    /// Local maxima of the requested displacement, in order.
    pub maxima: Vec<Maximum>,
    /// Impacts in order; true for the upper stop.
    pub impacts: Vec<bool>,
    /// Whether the block rested at a stop at any time.
    pub rests: bool,
}

/// Calls `visit` with a record of each of the next drive periods of a motion without loads,
/// including the maxima of a displacement. The record is reused, so `visit` must copy the data it
/// needs. Energy accounts end here.
///
/// # Errors
/// As [`Simulator::advance_until`], and [`vibro_impact::Error::OutOfRange`] under loads.
pub fn record_periods(
    simulator: &mut Simulator,
    of: Displacement,
    periods: u32,
    visit: &mut dyn FnMut(&PeriodRecord),
) -> vibro_impact::Result<()> {
    let (origin, step) = (simulator.time(), simulator.parameters().period());
    let reports = Reports { origin, step, first: 1, maxima_of: Some(of.weights()) };
    let plan = Plan { simulator: 0, end: origin + step * f64::from(periods), reports: Some(reports) };
    let mut queue = Periods {
        plan: Some(plan),
        reports,
        resting: simulator.contact() != Contact::Flight,
        period: PeriodRecord::default(),
        later: Vec::new(),
        visit,
        result: Ok(()),
    };
    advance_queue(std::slice::from_mut(simulator), &mut queue);
    queue.result
}

/// One motion, with its reports divided into periods.
struct Periods<'a> {
    plan: Option<Plan>,
    reports: Reports,
    resting: bool,
    period: PeriodRecord,
    /// Maxima reported before the end of a period that belong to the next one.
    later: Vec<Maximum>,
    visit: &'a mut dyn FnMut(&PeriodRecord),
    result: vibro_impact::Result<()>,
}

impl MotionQueue for Periods<'_> {
    fn next(
        &mut self,
        _lane: usize,
        _simulators: &mut [Simulator],
        ended: Option<vibro_impact::Result<()>>,
    ) -> Option<Plan> {
        self.result = ended.unwrap_or(Ok(()));
        self.period.rests = self.resting;
        self.plan.take()
    }

    fn sample(&mut self, _lane: usize, number: u32, state: &State) -> ControlFlow<(), u32> {
        let end = self.reports.origin + f64::from(number) * self.reports.step;
        let first_later = self.period.maxima.partition_point(|m| m.time <= end);
        self.later.extend(self.period.maxima.drain(first_later..));
        self.period.state = *state;
        (self.visit)(&self.period);
        self.period.maxima.clear();
        self.period.maxima.append(&mut self.later);
        self.period.impacts.clear();
        self.period.rests = self.resting;
        ControlFlow::Continue(number + 1)
    }

    fn event(&mut self, _lane: usize, event: &Event, _after: &Augmented) -> Option<u32> {
        match *event {
            Event::Impact { side, .. } => self.period.impacts.push(side > 0),
            Event::Rest { .. } => self.resting = true,
            Event::Release { .. } => self.resting = false,
        }
        self.period.rests |= self.resting;
        None
    }

    fn maximum(&mut self, _lane: usize, maximum: &Maximum) {
        self.period.maxima.push(*maximum);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::motion::settled_simulator;
    use crate::paper::stroboscopic::moving_block;
    use vibro_impact::Parameters;
    use vibro_impact::steady::exact_orbit;

    /// Tolerance for the remaining transient, as a fraction of L.
    const SETTLED: f64 = 1e-9;
    /// Tolerance for cubic interpolation between 128 samples a period (see `motion`).
    const INTERPOLATION: f64 = 1e-7;

    fn at(f10: f64, kappa: f64) -> Parameters {
        let groups = vibro_impact::Groups { f10, kappa, ..vibro_impact::Groups::basic() };
        groups.to_parameters(vibro_impact::Scales::default()).unwrap()
    }

    #[test]
    fn second_method_the_exact_orbits_amplitude_at_a_corner() {
        let p = Parameters::default();
        let orbit = exact_orbit::solve(&p).unwrap().upper.unwrap();
        let mut simulator = settled_simulator(&p, &moving_block(&p), 600.0).unwrap();
        record_periods(&mut simulator, Displacement::X2, 3, &mut |period| {
            assert_eq!(period.impacts.len(), 2);
            let [top] = period.maxima[..] else { panic!("{:?}", period.maxima) };
            assert!(top.corner && (top.value - orbit.amplitudes()[1]).abs() < SETTLED, "{top:?}");
        })
        .unwrap();
    }

    #[test]
    fn second_method_maxima_by_interpolated_samples() {
        // In chaos, with many impacts, and with rest; only a few periods, since chaos amplifies
        // the rounding of the samples' steps.
        const PERIODS: u32 = 6;
        for (f10, kappa) in [(0.6, 0.75), (3.6, 0.75), (4.5, 0.9), (3.0, 0.0), (2.0, 0.3)] {
            let p = at(f10, kappa);
            let simulator = settled_simulator(&p, &moving_block(&p), 50.0).unwrap();
            let flights = crate::paper::motion::record_flights(&mut simulator.clone(), PERIODS).unwrap();
            let sum = Displacement::Sum([0.7, -0.2, 1.3]);
            for of in [Displacement::X1, Displacement::X2, Displacement::X3, sum] {
                let (mut simulator, mut exact) = (simulator.clone(), Vec::new());
                record_periods(&mut simulator, of, PERIODS, &mut |p| exact.extend(p.maxima.clone())).unwrap();
                let sampled = crate::paper::motion::maxima(&flights, &p, of.weights());
                assert_eq!(exact.len(), sampled.len(), "{of}: f10 = {f10}, kappa = {kappa}");
                for (top, sample) in exact.iter().zip(sampled) {
                    assert!(
                        (top.value - sample).abs() < INTERPOLATION,
                        "{of}, f10 = {f10}: {top:?} {sample}"
                    );
                }
            }
        }
    }

    #[test]
    fn second_method_the_exact_orbits_amplitudes_of_all_coordinates() {
        let p = Parameters::default();
        let orbit = exact_orbit::solve(&p).unwrap().upper.unwrap();
        let simulator = settled_simulator(&p, &moving_block(&p), 600.0).unwrap();
        for of in Displacement::NAMED.into_iter().chain([Displacement::Sum([0.5, 1.0, -2.0])]) {
            let mut most = f64::NEG_INFINITY;
            record_periods(&mut simulator.clone(), of, 2, &mut |period| {
                most = period.maxima.iter().map(|m| m.value).fold(most, f64::max);
            })
            .unwrap();
            let expected = orbit.amplitude_of(of.weights());
            assert!((most - expected).abs() < SETTLED, "{of}: {most} {expected}");
        }
    }

    #[test]
    fn invariant_w_is_at_its_maximum_at_each_impact_and_at_the_end_of_each_rest_at_the_upper_stop() {
        for (f10, kappa) in [(0.6, 0.75), (3.6, 0.75), (3.0, 0.0), (2.0, 0.3)] {
            let p = at(f10, kappa);
            let simulator = settled_simulator(&p, &moving_block(&p), 50.0).unwrap();
            let (mut tops, mut upper) = (Vec::new(), 0u32);
            record_periods(&mut simulator.clone(), Displacement::W, 20, &mut |period| {
                tops.extend(period.maxima.iter().map(|m| m.value));
            })
            .unwrap();
            let end = simulator.time() + 20.0 * p.period();
            let mut plain = simulator.clone();
            plain
                .advance_observed(end, &mut |event| match *event {
                    // The impact that ends in rest is followed by a rest, and the maximum counts
                    // at its end.
                    vibro_impact::simulator::Event::Impact { side: 1, .. } => upper += 1,
                    vibro_impact::simulator::Event::Rest { side: 1, .. } => upper -= 1,
                    vibro_impact::simulator::Event::Release { side: 1, .. } => upper += 1,
                    _ => {}
                })
                .unwrap();
            let at_stop = tops.iter().filter(|top| **top == p.stop_gap).count();
            // A period may begin or end in rest.
            assert!(upper > 10 && at_stop.abs_diff(upper as usize) <= 1, "{f10}: {at_stop} of {upper}");
            assert!(tops.iter().all(|top| *top <= p.stop_gap));
        }
    }

    /// At a release the rate of w is rounding. At the lower stop this is not a maximum, and no
    /// turning point is found twice.
    #[test]
    fn invariant_a_release_from_the_lower_stop_is_no_maximum_of_w() {
        let mut releases = 0;
        for k in 0..24 {
            let p = at(0.4 + 0.15 * f64::from(k), 0.3);
            let p = Parameters { constant_loads: [0.1, -0.02, 0.05], ..p };
            let simulator = settled_simulator(&p, &moving_block(&p), 20.0).unwrap();
            let (mut before, end) = (f64::NEG_INFINITY, simulator.time() + 20.0 * p.period());
            record_periods(&mut simulator.clone(), Displacement::W, 20, &mut |period| {
                for top in &period.maxima {
                    assert!(top.value > -p.stop_gap && top.time > before, "{k}: {top:?} after {before}");
                    before = top.time;
                }
            })
            .unwrap();
            let count = &mut |event: &Event| {
                releases += usize::from(matches!(event, Event::Release { side: -1, .. }))
            };
            simulator.clone().advance_observed(end, count).unwrap();
        }
        assert!(releases > 50, "{releases}");
    }

    #[test]
    fn closed_form_of_a_free_block() {
        // Without a spring the block's speed is constant in flight: every maximum is a corner at
        // the upper stop, where the box carries it.
        let groups = vibro_impact::Groups { beta2: 0.0, alpha23: 0.0, ..vibro_impact::Groups::basic() };
        let p = groups.to_parameters(vibro_impact::Scales::default()).unwrap();
        let mut simulator = settled_simulator(&p, &moving_block(&p), 40.0).unwrap();
        let mut count = 0;
        record_periods(&mut simulator, Displacement::X2, 20, &mut |period| {
            count += period.maxima.len();
            assert!(period.maxima.iter().all(|m| m.corner), "{:?}", period.maxima);
        })
        .unwrap();
        assert!(count >= 20);
    }

    #[test]
    fn closed_form_of_a_small_swing_between_the_stops() {
        // Without drive and stops x2 is the sum of two undamped modes. Here only one of them
        // moves: block and secondary oscillator as a symmetric pair, with k3 = 0.
        let groups = vibro_impact::Groups { f10: 0.0, gamma3: 0.0, ..vibro_impact::Groups::basic() };
        let mut p = groups.to_parameters(vibro_impact::Scales::default()).unwrap();
        p.secondary_stiffness = 0.0;
        let rate = (2.0 * p.coupling_stiffness / p.block_mass).sqrt();
        let start = State { x: [0.0, 0.3, -0.3], v: [0.0; 3] };
        let mut simulator = Simulator::new(&p, &start, 0.0).unwrap().without_energy_accounts();
        let mut tops = Vec::new();
        record_periods(&mut simulator, Displacement::X2, 20, &mut |period| {
            tops.extend(period.maxima.clone())
        })
        .unwrap();
        assert!(tops.len() >= 5);
        // The first one may be the start itself.
        for top in &tops[1..] {
            let turns = top.time * rate / std::f64::consts::TAU;
            assert!((turns - turns.round()).abs() < 1e-9 && (top.value - 0.3).abs() < 1e-12, "{top:?}");
        }
    }
}
