//! Curves of bifurcations and of touches in two parameters (docs/theory.md, section 14).

mod equations;
pub(super) mod start;

pub use self::start::LocusStart;

use self::equations::{Condition, Locus};
use self::start::{Normal, first_point};
use super::curve::{CurvePoint, axis, correct, meet, tangent};
use super::family::Family;
use super::obstacle::Obstacle;
use nalgebra::DVector;
use std::f64::consts::PI;
use vibro_analysis::{Error, Result as Outcome};

/// First, least and longest step, in rad and curve units of the parameters (fifths of their
/// ranges).
const STEPS: [f64; 3] = [5e-3, 1e-5, 0.05];
/// Largest number of points in one direction.
const MOST_POINTS: usize = 600;
/// Largest correction of a step relative to its length, and least cosine of the angle by which the
/// tangent turns in a step.
const CORRECTION: f64 = 0.3;
const COSINE: f64 = 0.9;
/// Points after which a curve may have closed, and distance from its first point, in steps, at
/// which it counts as closed.
const SHORTEST_LOOP: usize = 10;
const CLOSED: f64 = 0.1;

/// Angle of multipliers, rad, from 1 or -1 within which a curve that cannot be continued ends at
/// that resonance. At the resonance itself one of the equations is satisfied identically, so that
/// only a step across the resonance detects it.
const RESONANT: f64 = 1e-2;

/// A point of a curve in two parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct LocusPoint {
    /// The two parameters.
    pub values: [f64; 2],
    /// Phases of the drive at the impacts, rad.
    pub phases: Vec<f64>,
    /// For Neimark-Sacker points the angle of the multipliers, rad.
    pub angle: Option<f64>,
    /// Type of end, if the point is one.
    pub end: Option<LocusEnd>,
}

/// End of a curve in two parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LocusEnd {
    /// EP: the end of the range of a parameter.
    Range,
    /// GR: beyond it the block would pass a stop, or an impact would have no speed.
    Touch,
    /// CP: a cusp, at which both parameters reverse their direction.
    Cusp,
    /// R1 or R2: the multipliers of a Neimark-Sacker point meet at 1 or -1.
    Resonance(i8),
    /// MX: continuation failed.
    NoConvergence,
    /// The curve is closed.
    Closed,
}

impl LocusEnd {
    /// The two letters of the label.
    pub fn name(self) -> &'static str {
        match self {
            Self::Range => "EP",
            Self::Touch => "GR",
            Self::Cusp => "CP",
            Self::Resonance(1) => "R1",
            Self::Resonance(_) => "R2",
            Self::NoConvergence => "MX",
            Self::Closed => "closed",
        }
    }
}

/// The curve in the two parameters of a family on which the orbit has the bifurcation of a start,
/// in both directions from it.
///
/// ```
/// use vibro_orbits::{Family, Label, LocusStart, OrbitWord, Span, locus};
/// use vibro_analysis::{ParameterSet, find_group};
///
/// // Where the symmetric motion breaks its symmetry, over force and restitution coefficient.
/// let (force, kappa) = (find_group("f10")?, find_group("kappa")?);
/// let spans = (Span::new(force, 1.9, 2.2)?, Span::new(kappa, 0.7, 0.8)?);
/// let family = Family::over_two(&ParameterSet::basic(), spans.0, spans.1)?;
/// let word = OrbitWord::new("U", -1, 1)?;
/// let (phases, values) = (vec![4.49692], [2.03959, 0.75]); // as special-points.csv has them
/// let start = LocusStart { label: Label::BranchPoint, word, phases, values };
/// let curve = locus(&family, &start)?;
/// let near = |a: f64, b: f64| (a - b).abs() < 1e-2;
/// assert!(curve.iter().any(|p| near(p.values[0], 2.04) && near(p.values[1], 0.75)));
/// # Ok::<(), vibro_analysis::Error>(())
/// ```
///
/// # Errors
/// [`Error::Form`] if the label defines no curve or if the start is outside the ranges;
/// [`Error::NoOrbit`] if there is no such point near the start.
pub fn locus(family: &Family, start: &LocusStart) -> Outcome<Vec<LocusPoint>> {
    let [first, second] = family.spans() else {
        let text = format!("{} parameters", family.spans().len());
        return Err(Error::Form { text, expected: "a family over two parameters" });
    };
    if !(first.contains(start.values[0]) && second.contains(start.values[1])) {
        let text =
            format!("{}={},{}={}", first.name.name(), start.values[0], second.name.name(), start.values[1]);
        return Err(Error::Form { text, expected: "a start within the ranges of both parameters" });
    }
    let system = family.system(&start.values)?;
    let failed = |obstacle: Obstacle| obstacle.error(&system, &start.word);
    if start.word.closing() < 0 && !family.is_symmetric() {
        return Err(failed(Obstacle::Asymmetric));
    }
    let normal = Normal::of(family, start)?;
    let (locus, u) = first_point(family, &normal).map_err(failed)?;
    let both = axis(u.len(), u.len() - 1) + axis(u.len(), u.len() - 2);
    let along = tangent(&locus, &u, &both).map_err(failed)?;
    let (forward, end) = follow(&locus, &u, along.clone());
    let (backward, begin) =
        if end == LocusEnd::Closed { (Vec::new(), LocusEnd::Closed) } else { follow(&locus, &u, -along) };
    let mut points: Vec<LocusPoint> = backward.into_iter().rev().collect();
    points.push(point(&locus, &u, None));
    points.extend(forward);
    // If no step succeeds in a direction, the start itself is the end in that direction.
    let last = points.len() - 1;
    points[0].end = Some(begin);
    points[last].end = Some(end);
    Ok(points)
}

fn point(locus: &Locus, u: &DVector<f64>, end: Option<LocusEnd>) -> LocusPoint {
    let values = locus.family.values(u);
    let angle = matches!(locus.condition, Condition::Complex(_)).then(|| u[locus.n()]);
    LocusPoint { values: [values[0], values[1]], phases: u.as_slice()[..locus.n()].to_vec(), angle, end }
}

/// Follows a curve in one direction to its end; the first point is left out.
fn follow(locus: &Locus, start: &DVector<f64>, along: DVector<f64>) -> (Vec<LocusPoint>, LocusEnd) {
    let [mut step, least, longest] = STEPS;
    let mut points = Vec::new();
    let mut last = CurvePoint { u: start.clone(), tangent: along.clone(), steps: 0 };
    let mut locus = Locus { family: locus.family, word: locus.word, condition: locus.condition.clone() };
    while points.len() < MOST_POINTS {
        match advance(&locus, &last, step) {
            Ok((next, end)) => {
                let way = &next.u - &last.u;
                let from = start - &last.u;
                let part = from.dot(&way) / way.norm_squared();
                let closes = points.len() > SHORTEST_LOOP
                    && (0.0..=1.0).contains(&part)
                    && (from - &way * part).norm() < CLOSED * way.norm()
                    && next.tangent.dot(&along) > COSINE;
                let end = if closes { Some(LocusEnd::Closed) } else { end };
                points.push(point(&locus, &next.u, end));
                if let Some(end) = end.filter(|e| *e != LocusEnd::Cusp) {
                    return (points, end);
                }
                step = if next.steps <= 4 { (1.4 * step).min(longest) } else { step };
                if let Ok(condition) = locus.adapted(&next.u) {
                    locus.condition = condition;
                }
                last = next;
            }
            Err(_) if step > least => step *= 0.5,
            Err(Obstacle::Order) => return (points, LocusEnd::Touch),
            Err(_) => return (points, resonance(&locus, &last.u).unwrap_or(LocusEnd::NoConvergence)),
        }
    }
    (points, LocusEnd::NoConvergence)
}

/// The resonance at which a curve of Neimark-Sacker points ends, if its last point is near one.
fn resonance(locus: &Locus, u: &DVector<f64>) -> Option<LocusEnd> {
    let angle = matches!(locus.condition, Condition::Complex(_)).then(|| u[locus.n()])?;
    if angle < RESONANT {
        Some(LocusEnd::Resonance(1))
    } else if angle > PI - RESONANT {
        Some(LocusEnd::Resonance(-1))
    } else {
        None
    }
}

/// One step of continuation. The error is `Obstacle::Order` if the point reached within the ranges
/// is not an orbit of the machine.
fn advance(locus: &Locus, last: &CurvePoint, step: f64) -> Result<(CurvePoint, Option<LocusEnd>), Obstacle> {
    let predicted = &last.u + &last.tangent * step;
    let columns = predicted.len();
    for (k, span) in locus.family.spans().iter().enumerate() {
        let index = columns - 2 + k;
        let value = predicted[index] * span.unit();
        if span.contains(value) {
            continue;
        }
        let bound = (if value < span.from { span.from } else { span.to }) / span.unit();
        let part = ((bound - last.u[index]) / (predicted[index] - last.u[index])).clamp(0.0, 1.0);
        let guess = &last.u + &last.tangent * (step * part);
        let hold = |u: &DVector<f64>| Ok((u[index] - bound, axis(columns, index)));
        let u = meet(locus, &guess, hold)?;
        if (&u - &guess).norm() > CORRECTION * step || !locus.is_orbit(&u)? {
            return Err(Obstacle::NoConvergence);
        }
        return Ok((CurvePoint { u, tangent: last.tangent.clone(), steps: 3 }, Some(LocusEnd::Range)));
    }
    let next = correct(locus, &predicted, &last.tangent)?;
    let turned = next.tangent.dot(&last.tangent) < COSINE;
    if turned || (&next.u - &predicted).norm() > CORRECTION * step {
        return Err(Obstacle::NoConvergence);
    }
    if !locus.is_orbit(&next.u)? {
        return Err(Obstacle::Order);
    }
    let n = locus.n();
    if matches!(locus.condition, Condition::Complex(_)) && !(0.0..PI).contains(&next.u[n]) {
        let end = LocusEnd::Resonance(if next.u[n] < 0.0 { 1 } else { -1 });
        return Ok((next, Some(end)));
    }
    let turns = |k: usize| next.tangent[columns - k] * last.tangent[columns - k] < 0.0;
    let end = (turns(1) && turns(2)).then_some(LocusEnd::Cusp);
    Ok((next, end))
}
