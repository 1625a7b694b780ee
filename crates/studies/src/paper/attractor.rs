//! Attractor of a settled motion: its period, its impacts, the states that identify it, and its
//! class.
//!
//! The machine without constant loads is symmetric: if x(t) is a motion, so is -x(t + T/2), where
//! T is the drive's period. A pair of mirror images is therefore distinguished from a pair of
//! different attractors. Constant loads exclude mirror images.

mod record;

pub(crate) use record::{StroboscopicRecord, appended};

use super::free_limit::limit_keeps_clear;
use super::largest_exponent::zero_exponent;
use super::lyapunov::Spectrum;
use super::statistics::{Likeness, Statistics};
use super::stroboscopic::{StroboscopicState, dimensionless};
use crate::class::SAME;
use crate::class::{MotionClass, OBSERVED, Relation};
use crate::error::Result;
use crate::exponent::LargestExponent;
use serde::{Deserialize, Serialize};
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::Simulator;

/// A settled motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Attractor {
    /// Period in drive periods, if a short one was found.
    pub period: Option<u32>,
    /// Whether a motion without a period comes closer to one: the distances between returns
    /// decrease from each eighth of the record to the next, or a motion without impacts is damped.
    pub approaching: bool,
    /// Impacts per drive period at the upper and at the lower stop.
    pub impacts: [f64; 2],
    /// Whether the block rests at a stop for part of a period or, held by a load, always.
    pub rests: bool,
    /// States at whole drive periods over one period; a single state for a motion without a
    /// period.
    pub states: Vec<StroboscopicState>,
    /// States of the mirror image at whole drive periods; none under constant loads.
    pub mirror_states: Vec<StroboscopicState>,
    /// Root mean squares of x1, x2, x3 at whole and half drive periods, units of L.
    pub sizes: [f64; 3],
    /// Means used to compare a motion without a period with others.
    pub statistics: Option<Statistics>,
}

impl MotionClass {
    /// The class of an attractor. `largest` is the largest exponent without the zero exponent of
    /// the drive phase, if it is known.
    pub fn by_largest(attractor: &Attractor, largest: Option<&LargestExponent>, p: &Parameters) -> Self {
        let sign = largest.map(|exponent| exponent.sign(p));
        match Self::by_sign(attractor.period, sign, attractor.approaching) {
            // In a damped machine all motions without events tend to one limit, if that limit
            // stays clear of the stops.
            Self::NotSettled if attractor.approaching && attractor.is_free() && limit_keeps_clear(p) => {
                Self::Settling
            }
            class => class,
        }
    }

    /// The class of an attractor. `spectrum` is its spectrum in units of ω10, if available.
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

/// Largest difference between coordinates of two states. If the largest displacement exceeds 10⁵,
/// the unit of the displacements' differences is 10⁻⁵ of it; speeds are treated in the same way.
/// The rounding of such values over a period of several impacts is at least 10⁻⁷ of a unit. Speeds
/// in units of L ω10 are so large if the box's spring has almost no stiffness.
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

    /// Whether the block never touches a stop and is never held at one.
    pub fn is_free(&self) -> bool {
        self.impacts == [0.0; 2] && !self.rests
    }

    /// Relation of another attractor to this one. Two without a period are compared by their
    /// [means](Statistics::likeness). Two attractors without impacts count as the same: if springs
    /// and dampers act on every body, the flow without impacts has one limit. Otherwise its limits
    /// form a family with one limit for each start, and the family counts as one attractor.
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

    /// Whether the attractor is known to be its own mirror image. While the motion is still
    /// [settling](MotionClass::Settling) the result is uncertain.
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

/// Relation of two motions without a period. If `a` is like both `b` and the mirror image of `b`,
/// then `b` is its own mirror image.
fn by_means(a: &Statistics, b: &Statistics) -> Relation {
    match (a.likeness(b), a.likeness(&b.mirrored())) {
        (Likeness::Same, _) => Relation::Same,
        // If `a` may be its own mirror image, `b` may be equal to `a`.
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
