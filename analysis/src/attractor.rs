//! What a settled motion is: its period, its impacts, the states by which it is recognized, and its
//! class.
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
/// The longest period that is recognized, in drive periods: four of them fit into what is observed.
pub const LONGEST: u32 = 32;
/// A state has returned when no coordinate differs by more (units of L and L ω10). What is left of
/// a transient after hundreds of periods is less, except next to a bifurcation.
pub const RETURN: f64 = 1e-5;
/// States of one attractor that were reached in different ways agree to this; those of two
/// attractors differ by more.
pub(crate) const SAME: f64 = 1e-3;

/// One drive period of an observed motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ObservedPeriod {
    pub(crate) state: StroboscopicState,
    /// The order of its impacts, as a number.
    pub(crate) pattern: u64,
    /// Impacts at the upper and at the lower stop.
    impacts: [u32; 2],
    /// Whether the block is held at a stop in the course of it, or throughout.
    rests: bool,
}

/// A settled motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Attractor {
    /// Its period in drive periods, where it has one up to [`LONGEST`].
    pub period: Option<u32>,
    /// Whether its states come nearer to a return from one eighth of the record to the next: a
    /// transient that has not died out.
    pub approaching: bool,
    /// Impacts per drive period at the upper and at the lower stop.
    pub impacts: [f64; 2],
    /// Whether the block rests at a stop in the course of it, or throughout, as a load may hold it.
    pub rests: bool,
    /// States at whole drive periods, one for each period (one in all where it has none).
    pub states: Vec<StroboscopicState>,
    /// The same for its mirror image; none under constant loads.
    pub mirror_states: Vec<StroboscopicState>,
    /// Root mean squares of x1, x2, x3 at whole and half drive periods, units of L.
    pub sizes: [f64; 3],
    /// The means by which it is compared with others, where it has no period.
    pub statistics: Option<Statistics>,
}

/// What two attractors are to each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relation {
    /// They are the same.
    Same,
    /// Each is the mirror image of the other.
    Mirror,
    /// They are neither.
    Different,
    /// Neither has a period, and their windows are too short to tell whether they are one.
    Undecided,
}

/// The kind of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum MotionClass {
    /// Returns after so many drive periods.
    Periodic(u32),
    /// Never returns, two exponents are zero.
    QuasiPeriodic,
    /// λ1 > 0.
    Chaotic,
    /// Has negative exponents, so it is periodic, but it has not yet come to its period or has one
    /// over [`LONGEST`].
    Settling,
    /// Nothing is decided: it has no period up to [`LONGEST`] as far as it was followed, and no
    /// exponent whose sign is certain.
    NotSettled,
}

impl MotionClass {
    /// Its name in tables: `1T`, `2T`, `quasi-periodic`, `chaotic`.
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

    /// Whether following a motion further would tell no more of it: not where it is settling or not
    /// settled.
    pub fn is_decided(self) -> bool {
        !matches!(self, Self::Settling | Self::NotSettled)
    }

    /// Whether it need not be looked at once more either: what seems quasi-periodic may have been
    /// leaving an orbit that is hardly unstable, and have come to another while its exponent was
    /// counted.
    pub(crate) fn is_final(self) -> bool {
        self.is_decided() && self != Self::QuasiPeriodic
    }

    /// The class of an attractor, with the largest exponent beside the drive phase's zero where it
    /// is known.
    pub fn by_largest(attractor: &Attractor, largest: Option<&LargestExponent>, p: &Parameters) -> Self {
        let sign = largest.map(|exponent| exponent.sign(p));
        match Self::by_sign(attractor.period, sign, attractor.approaching) {
            // Where all is damped a motion without events has one limit, unless a stop is in its
            // way.
            Self::NotSettled if attractor.approaching && attractor.is_free() && limit_keeps_clear(p) => {
                Self::Settling
            }
            class => class,
        }
    }

    /// The class by a motion's period, the sign of its largest exponent, and whether its states
    /// come nearer to a return.
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

    /// The class of an attractor, with its spectrum in units of ω10 where there is one.
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

/// Observes a settled motion over [`OBSERVED`] periods from a whole drive period on.
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

/// States at whole and half drive periods, and what happened between them.
#[derive(Clone, Debug)]
pub(crate) struct StroboscopicRecord {
    pub(crate) periods: Vec<ObservedPeriod>,
    /// The mirror images of the states at half periods.
    halves: Vec<StroboscopicState>,
    impacts: [u32; 2],
    /// Whether the block has been at a stop in this period, and whether it is now.
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
    /// Forgets all but whether the block is at a stop now, and keeps the memory.
    pub(crate) fn clear(&mut self) {
        self.periods.clear();
        self.halves.clear();
        (self.impacts, self.rests, self.pattern) = ([0; 2], self.held, 1);
    }

    /// Begins with a block that is in this contact.
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

    /// Whether [`OBSERVED`] periods have been recorded, in which a period is recognized.
    pub(crate) fn is_complete(&self) -> bool {
        self.periods.len() >= OBSERVED as usize
    }

    /// What the motion is, after [`OBSERVED`] periods.
    pub(crate) fn attractor(&self, p: &Parameters) -> Attractor {
        let found = if self.is_complete() { period(&self.periods) } else { None };
        // Without contact the motion is linear, and its one limit has the drive's period: a longer
        // one is a slow swing that nearly returns, and so is any where the limit is beyond the
        // stops.
        let touches = self.periods.iter().any(|s| s.impacts != [0; 2] || s.rests);
        let free = |period| period == 1 && (limit_keeps_clear(p) || !is_damped(p));
        self.attractor_of(p, found.filter(|n| touches || free(*n)))
    }

    /// What the motion is, given its period, of which at least one has been recorded.
    pub(crate) fn attractor_of(&self, p: &Parameters, period: Option<u32>) -> Attractor {
        let Self { periods, halves, .. } = self;
        let kept = period.unwrap_or(1) as usize;
        // Of a periodic motion only the last period is counted, so that a transient that died out
        // during the observation is left out.
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
        // Without impacts a damped motion that has not reached its limit is on its way there, if
        // that is clear of the stops.
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

    /// The largest distance between a state and the one `period` drive periods later, over the last
    /// of them that were recorded.
    pub(crate) fn return_distance(&self, period: u32) -> f64 {
        let lag = period as usize;
        farthest_return(&self.periods[self.periods.len().saturating_sub(2 * lag)..], lag)
    }

    /// The nearest return over the whole record: the least, of all lags up to [`LONGEST`], of the
    /// largest distance after that lag. None where as many periods at the end are free: returns
    /// fall between bursts of impacts.
    pub(crate) fn nearest_return(&self) -> Option<f64> {
        let longest = LONGEST as usize;
        let touches = self.periods.iter().rev().take(longest).any(|s| s.impacts != [0; 2] || s.rests);
        let lags = (1..=longest).take_while(|lag| *lag < self.periods.len());
        touches.then(|| lags.map(|lag| farthest_return(&self.periods, lag)).fold(f64::INFINITY, f64::min))
    }

    /// The largest distance between a state and the mirror image of the one half an odd `period`
    /// before it, over the last period.
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

/// The order of some impacts, as a number, with one more at its end.
pub(crate) fn appended(pattern: u64, upper: bool) -> u64 {
    pattern.wrapping_mul(3).wrapping_add(1 + u64::from(upper))
}

/// The least n for which, over the last four times n drive periods, states return after n periods
/// and the order of impacts repeats.
fn period(periods: &[ObservedPeriod]) -> Option<u32> {
    least_period(periods, |a, b| a.pattern == b.pattern && distance(&a.state, &b.state) < RETURN)
}

/// The least n up to [`LONGEST`] for which, over the last four times n returns, each is the same as
/// that n before.
pub(crate) fn least_period<R>(returns: &[R], same: impl Fn(&R, &R) -> bool) -> Option<u32> {
    (1..=LONGEST).take_while(|&n| 4 * n as usize <= returns.len()).find(|&n| {
        let lag = n as usize;
        let last = &returns[returns.len() - 4 * lag..];
        last[lag..].iter().zip(last).all(|(a, b)| same(a, b))
    })
}

/// The largest distance between a state and the one a lag of periods later.
fn farthest_return(periods: &[ObservedPeriod], lag: usize) -> f64 {
    let pairs = periods.iter().zip(periods.iter().skip(lag));
    pairs.map(|(a, b)| distance(&a.state, &b.state)).fold(0.0, f64::max)
}

/// Whether for some lag the largest distance between a state and the one that many periods later
/// falls from each eighth of the record to the next.
fn approaches(periods: &[ObservedPeriod]) -> bool {
    nears(periods, |a, b| distance(&a.state, &b.state))
}

/// The same of any returns and their distances.
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
        // It ends with the first eighth that does not fall.
        most.all(|most| std::mem::replace(&mut before, most) > most)
    })
}

/// The largest difference between coordinates of two states; of displacements over 10⁵, in parts of
/// 10⁻⁵ of the largest, and so of speeds, since 10⁻⁷ of a unit is no more than their rounding over
/// a period of several impacts: so are speeds in units of L ω10 where the box has a spring of next
/// to no stiffness.
pub fn distance(a: &StroboscopicState, b: &StroboscopicState) -> f64 {
    const LARGE: f64 = 1e5;
    let of = |[a, b]: [&[f64]; 2]| {
        let largest = a.iter().filter(|x| x.is_finite()).fold(LARGE, |largest, x| x.abs().max(largest));
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / (largest / LARGE)
    };
    of([&a[..3], &b[..3]]).max(of([&a[3..], &b[3..]]))
}

impl Attractor {
    /// Whether it passes through a state at a whole drive period.
    pub fn passes(&self, state: &StroboscopicState) -> bool {
        self.states.iter().any(|own| distance(own, state) < SAME)
    }

    /// Whether the block never touches a stop, nor is held at one.
    pub fn is_free(&self) -> bool {
        self.impacts == [0.0; 2] && !self.rests
    }

    /// What another attractor is to this one. Two without a period are compared by their
    /// [means](Statistics::likeness). Two without impacts count as the same: the flow without
    /// impacts is linear and has one limit, where springs hold and dampers reach every body.
    /// Elsewhere its limits are a family, one for each start, and it is the family that is one.
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

    /// Takes the window of another motion on it, or on its mirror image, into its means.
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

    /// Whether it is its own mirror image, as far as it has come: where the motion is still
    /// [settling](MotionClass::Settling), that is not decided.
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

/// What two motions without a period are to each other. That one is like both another and its
/// mirror image says that the other is its own mirror image.
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
