//! Attractor of a settled motion: its period, its impacts, the states by which it is recognized,
//! and its class.
//!
//! The machine without constant loads is symmetric: if x(t) is a motion, so is -x(t + T/2), where T
//! is the drive's period. Two attractors that are each other's mirror image are therefore
//! distinguished from two different ones. Under constant loads there are no mirror images.

use super::error::Result;
use super::free_limit::{is_damped, limit_keeps_clear};
pub use super::largest_exponent::ZERO_EXPONENT;
use super::largest_exponent::{ExponentSign, LargestExponent, zero_exponent};
use super::lyapunov::Spectrum;
use super::statistics::{Blocks, Likeness, Statistics};
use super::stroboscopic::{StroboscopicState, dimensionless};
use serde::{Deserialize, Serialize};
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{Contact, Event, Simulator};

/// Drive periods over which a motion is observed.
pub const OBSERVED: u32 = 128;
/// Longest period that is recognized, in drive periods. Four of it fit into [`OBSERVED`].
pub const LONGEST: u32 = 32;
/// Largest change of a coordinate (units of L and L ω10) in a return. The remainder of a transient
/// after hundreds of periods is less, except next to a bifurcation.
pub const RETURN: f64 = 1e-5;
/// Largest distance of states of one attractor reached in different ways. States of two attractors
/// are farther apart.
pub(crate) const SAME: f64 = 1e-3;

/// One drive period of an observed motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ObservedPeriod {
    pub(crate) state: StroboscopicState,
    /// Sequence of the impacts, encoded as a number.
    pub(crate) pattern: u64,
    /// Impacts at the upper and at the lower stop.
    impacts: [u32; 2],
    /// Whether the block is held at a stop in part of the period or throughout.
    rests: bool,
}

/// A settled motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Attractor {
    /// Period in drive periods, where there is one up to [`LONGEST`].
    pub period: Option<u32>,
    /// Whether returns come nearer from each eighth of the record to the next: a transient that has
    /// not died out.
    pub approaching: bool,
    /// Impacts per drive period at the upper and at the lower stop.
    pub impacts: [f64; 2],
    /// Whether the block rests at a stop in part of a period or throughout, as a load may hold it.
    pub rests: bool,
    /// States at whole drive periods over one period; a single state where there is no period.
    pub states: Vec<StroboscopicState>,
    /// States of the mirror image at whole drive periods; none under constant loads.
    pub mirror_states: Vec<StroboscopicState>,
    /// Root mean squares of x1, x2, x3 at whole and half drive periods, units of L.
    pub sizes: [f64; 3],
    /// Means by which a motion without a period is compared with others.
    pub statistics: Option<Statistics>,
}

/// Relation of two attractors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relation {
    /// They are the same.
    Same,
    /// Each is the mirror image of the other.
    Mirror,
    /// They are neither.
    Different,
    /// Neither has a period, and their windows are too short to tell whether they are the same.
    Undecided,
}

/// Class of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum MotionClass {
    /// Repeats after this number of drive periods.
    Periodic(u32),
    /// Never repeats; two exponents are zero.
    QuasiPeriodic,
    /// λ1 > 0.
    Chaotic,
    /// Periodic by its negative exponents, but not yet on its period or with one over [`LONGEST`].
    Settling,
    /// Undecided: no period up to [`LONGEST`] as far as it was followed, and no exponent of certain
    /// sign.
    NotSettled,
}

impl MotionClass {
    /// Name in tables: `1T`, `2T`, `quasi-periodic`, `chaotic`.
    pub fn name(self) -> String {
        match self {
            Self::Periodic(n) => format!("{n}T"),
            Self::QuasiPeriodic => "quasi-periodic".into(),
            Self::Chaotic => "chaotic".into(),
            Self::Settling => "periodic, settling".into(),
            Self::NotSettled => "not settled".into(),
        }
    }

    /// Whether it is periodic.
    pub fn is_periodic(self) -> bool {
        matches!(self, Self::Periodic(_) | Self::Settling)
    }

    /// Whether following the motion further would not change the class; false where it is settling
    /// or not settled.
    pub fn is_decided(self) -> bool {
        !matches!(self, Self::Settling | Self::NotSettled)
    }

    /// Whether the class needs no second look either. A motion that seems quasi-periodic may have
    /// been leaving a slightly unstable orbit, and have reached another while its exponent was
    /// counted.
    pub(crate) fn is_final(self) -> bool {
        self.is_decided() && self != Self::QuasiPeriodic
    }

    /// The class of an attractor. `largest` is the largest exponent besides the drive phase's zero,
    /// where it is known.
    pub fn by_largest(attractor: &Attractor, largest: Option<&LargestExponent>, p: &Parameters) -> Self {
        let sign = largest.map(|exponent| exponent.sign(p));
        match Self::by_sign(attractor.period, sign, attractor.approaching) {
            // Where everything is damped a motion without events has one limit, unless a stop is in
            // its way.
            Self::NotSettled if attractor.approaching && attractor.is_free() && limit_keeps_clear(p) => {
                Self::Settling
            }
            class => class,
        }
    }

    /// The class from the period, the sign of the largest exponent, and whether returns come
    /// nearer.
    pub(crate) fn by_sign(period: Option<u32>, sign: Option<ExponentSign>, approaching: bool) -> Self {
        match (period, sign) {
            (Some(n), _) => Self::Periodic(n),
            (None, Some(ExponentSign::Positive)) => Self::Chaotic,
            (None, Some(ExponentSign::Negative)) => Self::Settling,
            (None, Some(ExponentSign::Zero)) if !approaching => Self::QuasiPeriodic,
            (None, Some(ExponentSign::Zero)) => Self::Settling,
            (None, Some(ExponentSign::Undecided) | None) => Self::NotSettled,
        }
    }

    /// The class of an attractor. `spectrum` is its spectrum in units of ω10, where there is one.
    pub fn of(attractor: &Attractor, spectrum: Option<&Spectrum>, p: &Parameters) -> Self {
        let zero = zero_exponent(p) / p.box_frequency();
        match (attractor.period, spectrum.map(|s| (s.exponents[0], s.exponents[1], s.deviation))) {
            (Some(n), _) => Self::Periodic(n),
            (None, None) => Self::NotSettled,
            (None, Some((first, _, deviation))) if (first - zero).abs() < deviation => Self::NotSettled,
            (None, Some((first, ..))) if first > zero => Self::Chaotic,
            (None, Some((_, second, _))) if second > -zero && !attractor.approaching => Self::QuasiPeriodic,
            _ => Self::Settling,
        }
    }
}

/// Observes a settled motion over [`OBSERVED`] periods, beginning at a whole drive period.
///
/// # Errors
/// As [`Simulator::advance_until`].
pub fn observe(simulator: &mut Simulator) -> Result<Attractor> {
    let p = *simulator.parameters();
    let (begin, length) = (simulator.time(), p.period());
    let mut record = StroboscopicRecord::default();
    record.begin(simulator.contact());
    for i in 1..=2 * OBSERVED {
        let end = begin + 0.5 * f64::from(i) * length;
        simulator.advance_observed(end, &mut |event| record.event(event))?;
        record.sample(i, dimensionless(&p, &simulator.state()));
    }
    Ok(record.attractor(&p))
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

    /// The attractor after [`OBSERVED`] periods.
    pub(crate) fn attractor(&self, p: &Parameters) -> Attractor {
        let found = if self.is_complete() { period(&self.periods) } else { None };
        // Without contact the motion is linear, and its one limit has the drive's period. A longer
        // period is a slow oscillation that nearly returns, and so is any period where the limit is
        // beyond the stops.
        let touches = self.periods.iter().any(|s| s.impacts != [0; 2] || s.rests);
        let free = |period| period == 1 && (limit_keeps_clear(p) || !is_damped(p));
        self.attractor_of(p, found.filter(|n| touches || free(*n)))
    }

    /// The attractor of a motion with the given period, of which at least one is recorded.
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

    /// Largest distance between a state and the one `period` drive periods later, over the last
    /// `period` recorded.
    pub(crate) fn return_distance(&self, period: u32) -> f64 {
        let lag = period as usize;
        farthest_return(&self.periods[self.periods.len().saturating_sub(2 * lag)..], lag)
    }

    /// The nearest return over the whole record: for each lag up to [`LONGEST`] the largest distance
    /// after that lag, and of these the least. `None` where as many periods at the end are free of
    /// impacts: returns then fall between bursts of impacts.
    pub(crate) fn nearest_return(&self) -> Option<f64> {
        let longest = LONGEST as usize;
        let touches = self.periods.iter().rev().take(longest).any(|s| s.impacts != [0; 2] || s.rests);
        let lags = (1..=longest).take_while(|lag| *lag < self.periods.len());
        touches.then(|| lags.map(|lag| farthest_return(&self.periods, lag)).fold(f64::INFINITY, f64::min))
    }

    /// Largest distance, over the last period, between a state and the mirror image of the one half
    /// an odd `period` before it.
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
fn period(periods: &[ObservedPeriod]) -> Option<u32> {
    least_period(periods, |a, b| a.pattern == b.pattern && distance(&a.state, &b.state) < RETURN)
}

/// The least n up to [`LONGEST`] for which each of the last 4 n returns is the same as the one n
/// before.
pub(crate) fn least_period<R>(returns: &[R], same: impl Fn(&R, &R) -> bool) -> Option<u32> {
    (1..=LONGEST).take_while(|&n| 4 * n as usize <= returns.len()).find(|&n| {
        let lag = n as usize;
        let last = &returns[returns.len() - 4 * lag..];
        last[lag..].iter().zip(last).all(|(a, b)| same(a, b))
    })
}

/// Largest distance between a state and the one a lag of periods later.
fn farthest_return(periods: &[ObservedPeriod], lag: usize) -> f64 {
    let pairs = periods.iter().zip(periods.iter().skip(lag));
    pairs.map(|(a, b)| distance(&a.state, &b.state)).fold(0.0, f64::max)
}

/// Whether for some lag the largest distance between a state and the one that many periods later
/// falls from each eighth of the record to the next.
fn approaches(periods: &[ObservedPeriod]) -> bool {
    nears(periods, |a, b| distance(&a.state, &b.state))
}

/// [`approaches`] for any kind of return with its distance.
pub(crate) fn nears<R>(returns: &[R], distance: impl Fn(&R, &R) -> f64) -> bool {
    const EIGHTHS: usize = 8;
    (1..=LONGEST as usize).take_while(|lag| lag + EIGHTHS <= returns.len()).any(|lag| {
        let (later, earlier) = (&returns[lag..], &returns[..returns.len() - lag]);
        let eighth = later.len().div_ceil(EIGHTHS);
        let gap = |(a, b): (&R, &R)| distance(a, b);
        let mut most = later
            .chunks(eighth)
            .zip(earlier.chunks(eighth))
            .map(|(later, earlier)| later.iter().zip(earlier).map(gap).fold(0.0, f64::max));
        let mut before = f64::INFINITY;
        // Ends with the first eighth that does not fall.
        most.all(|most| std::mem::replace(&mut before, most) > most)
    })
}

/// Largest difference between coordinates of two states. Displacements over 10⁵, and speeds with
/// them, are compared in parts of 10⁻⁵ of the largest: 10⁻⁷ of a unit is no more than their
/// rounding over a period of several impacts. Speeds in units of L ω10 are so large where the box
/// has a spring of almost no stiffness.
pub fn distance(a: &StroboscopicState, b: &StroboscopicState) -> f64 {
    const LARGE: f64 = 1e5;
    let of = |[a, b]: [&[f64]; 2]| {
        let largest = a.iter().filter(|x| x.is_finite()).fold(LARGE, |largest, x| x.abs().max(largest));
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / (largest / LARGE)
    };
    of([&a[..3], &b[..3]]).max(of([&a[3..], &b[3..]]))
}

impl Attractor {
    /// Whether the attractor contains a state at a whole drive period.
    pub fn passes(&self, state: &StroboscopicState) -> bool {
        self.states.iter().any(|own| distance(own, state) < SAME)
    }

    /// Whether the block never touches a stop and is not held at one.
    pub fn is_free(&self) -> bool {
        self.impacts == [0.0; 2] && !self.rests
    }

    /// Relation of another attractor to this one. Two without a period are compared by their
    /// [means](Statistics::likeness). Two without impacts count as the same: where springs hold and
    /// dampers reach every body the flow without impacts has one limit; elsewhere its limits form a
    /// family with one for each start, which counts as one.
    pub fn relation(&self, other: &Self) -> Relation {
        if self.is_free() && other.is_free() {
            return Relation::Same;
        }
        if self.period != other.period {
            return Relation::Different;
        }
        if let (Some(own), Some(of)) = (&self.statistics, &other.statistics) {
            return by_means(own, of);
        }
        let covers = |points: &[StroboscopicState]| {
            points.iter().all(|p| self.states.iter().any(|q| distance(p, q) < SAME))
        };
        if covers(&other.states) {
            Relation::Same
        } else if !other.mirror_states.is_empty() && covers(&other.mirror_states) {
            Relation::Mirror
        } else {
            Relation::Different
        }
    }

    /// Pools the means of another motion on this attractor, or on its mirror image, with its own.
    pub(crate) fn pool(&mut self, other: &Self, mirrored: bool) {
        let (Some(own), Some(of)) = (self.statistics, other.statistics) else { return };
        let pooled = own.pooled(&if mirrored { of.mirrored() } else { of });
        let part = f64::from(of.periods) / f64::from(pooled.periods.max(1));
        let [upper, lower] = other.impacts;
        let impacts = if mirrored { [lower, upper] } else { [upper, lower] };
        for (own, of) in self.impacts.iter_mut().zip(impacts) {
            *own += part * (of - *own);
        }
        self.rests |= other.rests;
        self.sizes = pooled.sizes();
        self.statistics = Some(pooled);
    }

    /// Whether the attractor is its own mirror image as far as it is known; undecided while the
    /// motion is still [settling](MotionClass::Settling).
    pub fn is_symmetric(&self) -> bool {
        if self.mirror_states.is_empty() {
            return false;
        }
        let image =
            Self { states: self.mirror_states.clone(), mirror_states: self.states.clone(), ..self.clone() };
        match &self.statistics {
            Some(own) => own.likeness(&own.mirrored()) == Likeness::Same,
            None => self.relation(&image) == Relation::Same,
        }
    }
}

/// Relation of two motions without a period. If one is like both the other and its mirror image,
/// the other is its own mirror image.
fn by_means(a: &Statistics, b: &Statistics) -> Relation {
    match (a.likeness(b), a.likeness(&b.mirrored())) {
        (Likeness::Same, _) => Relation::Same,
        // A motion that is its own mirror image has no other one.
        (Likeness::Undecided, Likeness::Same) if a.likeness(&a.mirrored()) != Likeness::Different => {
            Relation::Undecided
        }
        (_, Likeness::Same) => Relation::Mirror,
        (Likeness::Different, Likeness::Different) => Relation::Different,
        _ => Relation::Undecided,
    }
}

#[cfg(test)]
mod tests;
