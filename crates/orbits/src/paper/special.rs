//! Location of special points.

use super::cycle::Cycle;
use super::family::{ContactEquations, Family};
use super::orbit::eigenvalues;
use crate::curve::{gradient, meet};
use crate::obstacle::Obstacle;
use crate::paper::sample::{DOUBLING, test};
use crate::stop_word::OrbitWord;
use crate::test_functions::{SignedLog, is_on_circle};
use nalgebra::DVector;

/// Tolerance, rad, for the rounding between two equal halves of an orbit.
const BIRTH: f64 = 1e-9;

/// Step of the difference quotients of a test function. It affects how fast its zero converges,
/// not the result.
const DIFFERENCE: f64 = 1e-6;

/// Whether a complex pair of multipliers is on the unit circle.
pub(super) fn is_torus(family: &Family, word: &OrbitWord, u: &DVector<f64>) -> Result<bool, Obstacle> {
    let system = family.system_at(u)?;
    let cycle = Cycle::new(&system, word, &u.as_slice()[..word.len()])?;
    Ok(eigenvalues(cycle.monodromy()).is_some_and(|m| is_on_circle(&m)))
}

/// A test function at a point of a curve in units of `unit`.
pub(super) fn scaled_test(
    family: &Family,
    word: &OrbitWord,
    index: usize,
    unit: SignedLog,
    u: &DVector<f64>,
) -> Result<f64, Obstacle> {
    let system = family.system_at(u)?;
    let cycle = Cycle::new(&system, word, &u.as_slice()[..word.len()])?;
    Ok(test(&cycle, index).ok_or(Obstacle::NoConvergence)?.relative_to(unit))
}

/// Phases in the second half of a doubled orbit minus phases in its first half and half the span;
/// zero if both halves are equal.
fn halves(word: &OrbitWord, u: &DVector<f64>) -> DVector<f64> {
    let h = word.len() / 2;
    DVector::from_fn(h, |i, _| u[h + i] - u[i] - 0.5 * word.span())
}

/// A point on the tangent, beyond the birth of the doubled branch and at the same distance from
/// the birth as the given point. At the birth both halves of the orbit are equal. `None` if the
/// birth is not ahead within the distance `within`, if the halves are already equal, or if the
/// word is not doubled.
pub(super) fn beyond_birth(
    word: &OrbitWord,
    u: &DVector<f64>,
    tangent: &DVector<f64>,
    within: f64,
) -> Option<DVector<f64>> {
    word.folded()?;
    let own = halves(word, u);
    let rate = halves(word, &(u + tangent)) - &own;
    let arc = -own.norm_squared() / own.dot(&rate);
    (own.norm() > BIRTH && (0.0..within).contains(&arc)).then(|| u + tangent * (2.0 * arc))
}

/// The point where a doubled branch is born from another one, if a step passes it. At this point
/// both halves of the orbit are equal. Beyond it the path would pass its own orbits again, with
/// their halves exchanged.
pub(super) fn primary(
    family: &Family,
    word: &OrbitWord,
    last: &DVector<f64>,
    next: &DVector<f64>,
) -> Result<Option<(OrbitWord, DVector<f64>)>, Obstacle> {
    let Some(folded) = word.folded().filter(|f| f.closing() > 0 || family.is_symmetric()) else {
        return Ok(None);
    };
    let [a, b] = [last, next].map(|u| halves(word, u));
    // The last point has equal halves if the branch was born there; this step then passes nothing.
    // The next point has equal halves if the corrector ended on the other branch.
    let passes = a.dot(&b) < 0.0 || b.norm() < BIRTH;
    if !passes || a.norm() < BIRTH {
        return Ok(None);
    }
    let part = a.norm() / (a.norm() + b.norm());
    let at = last + (next - last) * part;
    let (h, n) = (folded.len(), word.len());
    let guess =
        DVector::from_fn(h + 1, |i, _| if i < h { 0.5 * (at[i] + at[h + i] - folded.span()) } else { at[n] });
    let unit = {
        let system = family.system_at(&guess)?;
        let cycle = Cycle::new(&system, &folded, &guess.as_slice()[..h])?;
        // The scale is taken from another test function, since this one is nearly zero here.
        let log = test(&cycle, crate::paper::sample::UNIT).ok_or(Obstacle::NoConvergence)?.log;
        SignedLog { sign: 1.0, log }
    };
    let function = |u: &DVector<f64>| scaled_test(family, &folded, DOUBLING, unit, u);
    let condition = |u: &DVector<f64>| Ok((function(u)?, gradient(u, DIFFERENCE, function)?));
    let u = meet(&ContactEquations { family, word: &folded }, &guess, condition)?;
    if (&u - &guess).norm() > (next - last).norm() {
        return Err(Obstacle::NoConvergence);
    }
    Ok(Some((folded, u)))
}
