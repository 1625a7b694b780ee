//! Start of a curve in two parameters: the special point in the shortest word of its orbit, moved
//! onto the curve.

use super::equations::{Condition, Locus};
use crate::curve::{axis, meet};
use crate::label::Label;
use crate::obstacle::Obstacle;
use crate::paper::cycle::{Cycle, Functional};
use crate::paper::family::Family;
use crate::paper::flights;
use crate::paper::free;
use crate::paper::grazing::Touch;
use crate::paper::orbit::{canonical, eigenvalues, newton, same_phases};
use crate::paper::switching::FlightTouch;
use crate::stop_word::OrbitWord;
use crate::stop_word::REPETITION;
use crate::two_parameters::Border;
use nalgebra::{Complex, DVector};
use vibro_studies::{Error, Result as Outcome};

/// Largest approach speed of a touch, units of ω1 L. At a located touch it is zero except for
/// rounding.
const NO_SPEED: f64 = 1e-6;
/// Largest distance of a touching extremum from its stop, units of L.
const NO_DISTANCE: f64 = 1e-6;
/// Tolerances for equal starts: phases (rad) and parameters (in curve units).
const SAME: f64 = 1e-6;
/// Largest change of a phase, rad, from a start to its point on the curve.
const NEAR: f64 = 0.2;
/// Tolerance for the contact error of a start from the same machine, units of L.
const MISS: f64 = 0.05;

/// A starting point of a curve in two parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct LocusStart {
    /// Type of all points of the curve: LP, BP, PD, NS, GR or CH.
    pub label: Label,
    /// The word of the orbit or a repetition of it, as for a branch at its birth. At a touch, the
    /// word with or without the touching impact.
    pub word: OrbitWord,
    /// Phases of the impacts near the point.
    pub phases: Vec<f64>,
    /// The two parameters.
    pub values: [f64; 2],
}

impl LocusStart {
    /// This special point in the shortest word of its orbit; its curve is followed in this word.
    /// At a touch this is the shortest word that lists the touch.
    ///
    /// # Errors
    /// As [`locus`](super::locus).
    pub fn shortest(&self, family: &Family) -> Outcome<Self> {
        let Normal { word, phases, values, kind } = Normal::of(family, self)?;
        let label = match kind {
            LocusCondition::Real(factor) if factor > 0.0 => Label::Fold,
            LocusCondition::Real(_) if word.closing() < 0 => Label::BranchPoint,
            LocusCondition::Real(_) => Label::PeriodDoubling,
            LocusCondition::Pair => Label::NeimarkSacker,
            LocusCondition::Touch(_) => self.label,
        };
        Ok(Self { label, word, phases, values })
    }

    /// Whether another start is the same special point. A point where two branches meet is a
    /// special point of both.
    ///
    /// # Errors
    /// The errors of [`locus`](super::locus) for both starts.
    pub fn is_same(&self, other: &Self, family: &Family) -> Outcome<bool> {
        let [own, their] = [Normal::of(family, self)?, Normal::of(family, other)?];
        let mirror = family.is_symmetric();
        let [a, b] = [&own, &their].map(|n| canonical(&n.word, &n.phases, mirror));
        let near = own.values.iter().zip(&their.values).zip(family.spans());
        let near = near.into_iter().all(|((a, b), span)| (a - b).abs() < SAME * span.unit());
        Ok(own.kind == their.kind && near && a.0 == b.0 && same_phases(&a.0, &a.1, &b.1, mirror, SAME))
    }
}

/// Condition along a curve, by type.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LocusCondition {
    /// A multiplier ±1.
    Real(f64),
    /// A pair of multipliers on the unit circle.
    Pair,
    /// An impact of the word with zero approach speed.
    Touch(usize),
}

/// A start in the shortest word of its orbit; at a touch in the shortest word that lists it once.
///
/// At its birth, a branch from a doubling has a word repeated twice, with the multiplier 1 instead
/// of -1. At a touch, the words of several branches meet. Only the shortest one with the touch has
/// equations that are regular whatever the symmetry of the orbit.
#[derive(Debug)]
pub(crate) struct Normal {
    pub word: OrbitWord,
    pub phases: Vec<f64>,
    pub values: [f64; 2],
    pub kind: LocusCondition,
}

impl Normal {
    /// The normal form of a start.
    ///
    /// # Errors
    /// [`Error::Form`] if the label does not define a curve of the word; [`Error::NoOrbit`] if the
    /// phases do not belong to an orbit of the machine.
    pub fn of(family: &Family, start: &LocusStart) -> Outcome<Self> {
        let LocusStart { label, word, phases, values } = start;
        let form = || {
            let text = format!("{label} of the word {word}");
            Error::Form {
                text,
                expected: "one of LP, BP, PD, NS, GR, CH, with as many phases as the word has letters",
            }
        };
        let touches = matches!(label, Label::Grazing | Label::Chatter);
        if phases.len() != word.len() || (word.is_empty() && !touches) {
            return Err(form());
        }
        let system = family.system(values)?;
        if touches {
            return Self::touching(family, start).map_err(|obstacle| obstacle.error(&system, word));
        }
        let (word, phases) = word.reduced(phases, family.is_symmetric(), REPETITION);
        let kind = match label {
            Label::Fold => LocusCondition::Real(1.0),
            Label::BranchPoint if word.closing() < 0 => LocusCondition::Real(-1.0),
            Label::PeriodDoubling if word.closing() > 0 => LocusCondition::Real(-1.0),
            Label::NeimarkSacker => LocusCondition::Pair,
            _ => return Err(form()),
        };
        Ok(Self { word, phases, values: *values, kind })
    }

    fn touching(family: &Family, start: &LocusStart) -> Result<Self, Obstacle> {
        let LocusStart { word, phases, values, .. } = start;
        let contact = if word.is_empty() {
            free::contact(family, values)?
        } else {
            FlightTouch::of(family, &touch(family, word, phases, values)?)
        };
        let touch = contact.longer(family, 1).into_iter().next().ok_or(Obstacle::Order)?;
        let phases = touch.u.as_slice()[..touch.longer.len()].to_vec();
        Ok(Self { word: touch.longer, phases, values: *values, kind: LocusCondition::Touch(touch.index) })
    }
}

/// The touch of an orbit: impacts of its word at zero speed, or the extremum at a stop that its
/// word does not list.
fn touch(family: &Family, word: &OrbitWord, phases: &[f64], values: &[f64]) -> Result<Touch, Obstacle> {
    let system = family.system(values)?;
    let cycle = Cycle::new(&system, word, phases)?;
    let u = family.point(phases, values);
    let speed = |i: &usize| cycle.speed(*i).abs();
    let slowest = (0..word.len()).min_by(|a, b| speed(a).total_cmp(&speed(b))).ok_or(Obstacle::Order)?;
    let listed = || {
        let also = (0..word.len()).filter(|i| *i != slowest && speed(i) < NO_SPEED).collect();
        Touch { longer: word.clone(), index: slowest, u: u.clone(), also, from_longer: true }
    };
    if speed(&slowest) < NO_SPEED {
        return Ok(listed());
    }
    let extrema = (0..word.len()).flat_map(|flight| {
        let (z, phase) = (cycle.departure(flight), phases[flight]);
        let span = cycle.arrival(flight) - phase;
        [1i8, -1].into_iter().flat_map(move |side| {
            let s = f64::from(side);
            let maxima = flights::maxima(cycle.system, z, phase, span, [-s, s, 0.0]);
            maxima.into_iter().map(move |(phase, value)| ((value - 1.0).abs(), flight + 1, side, phase))
        })
    });
    let nearest = extrema.collect::<Vec<_>>().into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    Ok(match nearest.filter(|n| n.0 < NO_DISTANCE) {
        Some((_, index, side, phase)) => {
            let (longer, u) = (word.inserted(index, side), u.insert_row(index, phase));
            Touch { longer, index, u, also: Vec::new(), from_longer: false }
        }
        // Neither is found: the start is a guess, and its slowest impact is taken as the touch.
        None => listed(),
    })
}

/// The point of the curve near a start, with the second parameter fixed.
///
/// A located special point is itself the guess: it is not first moved to an orbit at its
/// parameters. Beyond a fold no orbit exists, and the rounded parameters of the fold may lie
/// beyond it; the equations of the curve are regular there. A rougher guess is first moved to the
/// orbit at its parameters.
pub(crate) fn first_point<'a>(
    family: &'a Family,
    normal: &'a Normal,
) -> Result<(Locus<'a>, DVector<f64>), Obstacle> {
    let own = near(family, normal, &normal.phases).and_then(|(locus, u)| {
        // A distant point is another special point, reached from phases of another machine.
        let moved = normal.phases.iter().zip(u.iter()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        if moved < NEAR { Ok((locus, u)) } else { Err(Obstacle::NoConvergence) }
    });
    own.or_else(|first| {
        let system = family.system(&normal.values)?;
        let missed = Cycle::new(&system, &normal.word, &normal.phases)?;
        if missed.residual.iter().any(|r| r.abs() > MISS) {
            return Err(Obstacle::OtherMachine);
        }
        let phases = newton(&system, &normal.word, &normal.phases).map_err(|_| first)?;
        near(family, normal, &phases)
    })
}

/// The point of the curve from phases near it.
fn near<'a>(
    family: &'a Family,
    normal: &'a Normal,
    phases: &[f64],
) -> Result<(Locus<'a>, DVector<f64>), Obstacle> {
    let word = &normal.word;
    let system = family.system(&normal.values)?;
    let cycle = Cycle::new(&system, word, phases)?;
    let mut u = family.point(phases, &normal.values);
    let condition = match normal.kind {
        LocusCondition::Touch(index) => Condition::Touch(index),
        LocusCondition::Pair => {
            let multipliers = eigenvalues(cycle.monodromy()).ok_or(Obstacle::NoConvergence)?;
            let pairs = multipliers.into_iter().filter(|m| m.im > 0.0);
            let nearest = pairs.min_by(|a, b| (a.norm() - 1.0).abs().total_cmp(&(b.norm() - 1.0).abs()));
            let angle = nearest.ok_or(Obstacle::NoConvergence)?.arg();
            u = u.insert_row(word.len(), angle);
            let matrix = cycle.complex_derivative(Complex::cis(angle)).ok_or(Obstacle::Singular)?;
            Condition::Complex(Border::of(matrix).ok_or(Obstacle::NoConvergence)?)
        }
        LocusCondition::Real(factor) => {
            let matrix = cycle.derivative(Functional::Gap, factor).ok_or(Obstacle::Singular)?;
            Condition::Real(factor, Border::of(matrix).ok_or(Obstacle::NoConvergence)?)
        }
    };
    let mut locus = Locus { family, word, condition };
    let last = u.len() - 1;
    let held = u[last];
    let hold = |u: &DVector<f64>| Ok((u[last] - held, axis(u.len(), last)));
    let u = meet(&locus, &u, hold)?;
    locus.condition = locus.adapted(&u)?;
    Ok((locus, u))
}
