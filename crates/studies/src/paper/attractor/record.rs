//! Record of a motion over drive periods, the data for recognizing its attractor.

use super::{Attractor, distance};
use crate::class::{LONGEST, OBSERVED, RETURN, comes_nearer, least_period};
use crate::paper::free_limit::{is_damped, limit_keeps_clear};
use crate::paper::statistics::Blocks;
use crate::paper::stroboscopic::StroboscopicState;
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{Contact, Event};

/// One drive period of an observed motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ObservedPeriod {
    pub(crate) state: StroboscopicState,
    /// Sequence of the impacts, encoded as a number.
    pub(crate) pattern: u64,
    /// Impacts at the upper and at the lower stop.
    pub(super) impacts: [u32; 2],
    /// Whether the block is held at a stop in part of the period or throughout.
    pub(super) rests: bool,
}

/// States at whole and half drive periods, and the impacts and rests between them.
#[derive(Clone, Debug)]
pub(crate) struct StroboscopicRecord {
    pub(crate) periods: Vec<ObservedPeriod>,
    /// Mirror images of the states at half periods.
    halves: Vec<StroboscopicState>,
    impacts: [u32; 2],
    /// Whether the block has been at a stop in this period, and whether it is at one now.
    rests: bool,
    held: bool,
    pattern: u64,
}

impl Default for StroboscopicRecord {
    fn default() -> Self {
        let observed = OBSERVED as usize;
        let (periods, halves) = (Vec::with_capacity(observed), Vec::with_capacity(observed));
        Self { periods, halves, impacts: [0; 2], rests: false, held: false, pattern: 1 }
    }
}

impl StroboscopicRecord {
    /// Forgets the record but not whether the block is at a stop now; keeps the memory.
    pub(crate) fn clear(&mut self) {
        self.periods.clear();
        self.halves.clear();
        (self.impacts, self.rests, self.pattern) = ([0; 2], self.held, 1);
    }

    /// Begins with the block in the given contact.
    pub(crate) fn begin(&mut self, contact: Contact) {
        self.held = contact != Contact::Flight;
        self.clear();
    }

    pub(crate) fn event(&mut self, event: &Event) {
        match *event {
            Event::Impact { side, .. } => {
                let upper = side > 0;
                self.impacts[usize::from(!upper)] += 1;
                self.pattern = appended(self.pattern, upper);
            }
            Event::Rest { .. } => (self.rests, self.held) = (true, true),
            Event::Release { .. } => (self.rests, self.held) = (true, false),
        }
    }

    /// The state after `number` half periods, counted from 1.
    pub(crate) fn sample(&mut self, number: u32, state: StroboscopicState) {
        if number % 2 == 1 {
            self.halves.push(state.map(|x| -x));
        } else {
            let Self { impacts, rests, pattern, .. } = *self;
            self.periods.push(ObservedPeriod { state, pattern, impacts, rests });
            (self.impacts, self.rests, self.pattern) = ([0; 2], self.held, 1);
        }
    }

    /// Whether [`OBSERVED`] periods are recorded, so that a period can be recognized.
    pub(crate) fn is_complete(&self) -> bool {
        self.periods.len() >= OBSERVED as usize
    }

    /// The attractor of the recorded periods. Its period requires [`OBSERVED`] of them.
    pub(crate) fn attractor(&self, p: &Parameters) -> Attractor {
        let found = if self.is_complete() { period(&self.periods) } else { None };
        // Without contact the motion is linear, and its one limit has the drive's period. A longer
        // period is a slow oscillation that nearly returns, and so is any period where the limit
        // is beyond the stops.
        let touches = self.periods.iter().any(|s| s.impacts != [0; 2] || s.rests);
        let free = |period| period == 1 && (limit_keeps_clear(p) || !is_damped(p));
        self.attractor_of(p, found.filter(|n| touches || free(*n)))
    }

    /// Attractor of a motion with the given period. At least one period is recorded.
    pub(crate) fn attractor_of(&self, p: &Parameters, period: Option<u32>) -> Attractor {
        let Self { periods, halves, .. } = self;
        let kept = period.unwrap_or(1) as usize;
        // Only the last period of a periodic motion is counted, to leave out a transient that died
        // out during the observation.
        let settled = period.unwrap_or(periods.len() as u32);
        let last = periods.len() - settled as usize;
        let mut sizes = [0.0; 3];
        for state in periods[last..].iter().map(|s| &s.state).chain(&halves[last..]) {
            for (size, x) in sizes.iter_mut().zip(state) {
                *size += x * x / f64::from(2 * settled);
            }
        }
        let counts = [0, 1].map(|side| periods[last..].iter().map(|s| s.impacts[side]).sum::<u32>());
        let rests = periods[last..].iter().any(|s| s.rests);
        // A damped motion without impacts that is not at its limit is on its way there, if the
        // limit is clear of the stops.
        let dies_out = counts == [0; 2] && !rests && is_damped(p) && limit_keeps_clear(p);
        Attractor {
            period,
            approaching: period.is_none() && (dies_out || approaches(periods)),
            impacts: counts.map(|c| f64::from(c) / f64::from(settled)),
            rests,
            states: periods[periods.len() - kept..].iter().map(|s| s.state).collect(),
            mirror_states: if p.is_symmetric() { halves[halves.len() - kept..].to_vec() } else { Vec::new() },
            sizes: sizes.map(f64::sqrt),
            statistics: period.is_none().then(|| {
                let mut blocks = Blocks::default();
                self.add_to(&mut blocks);
                blocks.statistics()
            }),
        }
    }

    /// Largest distance between a state and the state `period` drive periods later, for the last
    /// `period` recorded states.
    pub(crate) fn return_distance(&self, period: u32) -> f64 {
        let lag = period as usize;
        farthest_return(&self.periods[self.periods.len().saturating_sub(2 * lag)..], lag)
    }

    /// The nearest return over the whole record: the smallest, over lags up to [`LONGEST`], of the
    /// largest distance after a lag. `None` if the last [`LONGEST`] periods are free of impacts
    /// and rests: returns then fall between bursts of impacts.
    pub(crate) fn nearest_return(&self) -> Option<f64> {
        let longest = LONGEST as usize;
        let touches = self.periods.iter().rev().take(longest).any(|s| s.impacts != [0; 2] || s.rests);
        let lags = (1..=longest).take_while(|lag| *lag < self.periods.len());
        touches.then(|| lags.map(|lag| farthest_return(&self.periods, lag)).fold(f64::INFINITY, f64::min))
    }

    /// Largest distance, over the last period, between a state and the mirror image of the state
    /// half a period before it. `period` is odd.
    pub(crate) fn mirror_distance(&self, period: u32) -> f64 {
        let (first, half) = (self.periods.len().saturating_sub(period as usize), period as usize / 2);
        let images = &self.halves[first.saturating_sub(half)..];
        let pairs = self.periods[first..].iter().zip(images);
        pairs.map(|(own, image)| distance(&own.state, image)).fold(0.0, f64::max)
    }

    /// Adds the recorded periods to a window of the motion.
    pub(crate) fn add_to(&self, blocks: &mut Blocks) {
        self.periods.iter().zip(&self.halves).for_each(|(whole, half)| blocks.add(&whole.state, half));
    }
}

/// The code of an impact sequence with one more impact at its end.
pub(crate) fn appended(pattern: u64, upper: bool) -> u64 {
    pattern.wrapping_mul(3).wrapping_add(1 + u64::from(upper))
}

/// The least n for which, over the last 4 n drive periods, states return after n periods and the
/// sequence of impacts repeats.
pub(super) fn period(periods: &[ObservedPeriod]) -> Option<u32> {
    least_period(periods, |a, b| a.pattern == b.pattern && distance(&a.state, &b.state) < RETURN)
}

/// Largest distance between a state and the one a lag of periods later.
fn farthest_return(periods: &[ObservedPeriod], lag: usize) -> f64 {
    let pairs = periods.iter().zip(periods.iter().skip(lag));
    pairs.map(|(a, b)| distance(&a.state, &b.state)).fold(0.0, f64::max)
}

/// Whether for some lag the largest distance between a state and the one that many periods later
/// falls from each eighth of the record to the next.
pub(super) fn approaches(periods: &[ObservedPeriod]) -> bool {
    comes_nearer(periods, |a, b| distance(&a.state, &b.state))
}
