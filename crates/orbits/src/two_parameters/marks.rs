//! Special points of codimension two, located between two points of a curve.

use super::LocusEnd;
use super::TwoParameters;
use crate::curve::{CurvePoint, correct};
use nalgebra::DVector;
use vibro_numerics::sorting::sort_by;

/// Largest number of steps of a bracketing search.
const STEPS: usize = 40;
/// Width of a bracket at which a search ends, as a fraction of the step.
const WIDTH: f64 = 1e-11;
/// Zero tolerance at a located point, relative to the values at the ends of the bracket. A
/// function that jumps stays above it.
const ZERO: f64 = 1e-6;
/// Distance of a point with singular equations from the two points that interpolate it, as a
/// fraction of the step.
const APART: f64 = 1e-5;
/// Largest value of a continuous function at these two points, relative to its values at the ends
/// of the bracket: a hundred times the value of a linear function.
const JUMP: f64 = 1e-3;
/// Remaining fractions of the distance to a fold-pitchfork point, for its extrapolation.
const PARTS: [f64; 3] = [0.5, 0.25, 0.125];
/// Remaining distance to a fold-pitchfork point, in curve units, that a curve may be unable to
/// pass: the longest step.
const REMAINS: f64 = 0.05;

/// A point of a curve, with the values of the functions that vanish at special points.
#[derive(Clone, Debug)]
pub(super) struct Marked {
    pub point: CurvePoint,
    products: Option<[f64; 2]>,
    tests: Vec<(LocusEnd, f64)>,
}

impl Marked {
    pub fn new(locus: &impl TwoParameters, point: CurvePoint) -> Self {
        let (products, tests) = (locus.products(&point.u), locus.tests_on_curve(&point.u));
        Self { point, products, tests }
    }

    /// Component of the products in the direction of another point's products.
    fn along(&self, other: &Self) -> Option<f64> {
        let ([a, b], [c, d]) = (self.products?, other.products?);
        Some((a * c + b * d) / c.hypot(d))
    }

    /// The signed speed of the parameters along a fold curve; they move perpendicular to the
    /// products.
    fn speed(&self) -> Option<f64> {
        let ([a, b], n) = (self.products?, self.point.tangent.len());
        Some((a * self.point.tangent[n - 1] - b * self.point.tangent[n - 2]) / a.hypot(b))
    }

    fn test(&self, kind: LocusEnd) -> Option<f64> {
        if kind == LocusEnd::Cusp {
            return self.speed();
        }
        self.tests.iter().find(|(own, _)| *own == kind).map(|(_, value)| *value)
    }

    /// The special points between two points of a curve that are one step apart, in order.
    pub fn between(
        &self,
        locus: &impl TwoParameters,
        next: &Self,
        step: f64,
    ) -> Vec<(DVector<f64>, LocusEnd)> {
        if self.is_mirrored(next) {
            let point = self.meeting(locus, next, step);
            return point.map(|u| (u, LocusEnd::FoldPitchfork)).into_iter().collect();
        }
        let kinds = self.tests.iter().map(|(kind, _)| *kind).chain([LocusEnd::Cusp]);
        let mut found: Vec<(f64, DVector<f64>, LocusEnd)> = kinds
            .filter_map(|kind| {
                let (h, u) = self.locate(locus, next, step, kind)?;
                Some((h, u, kind))
            })
            .collect();
        sort_by(&mut found, |a, b| a.0.total_cmp(&b.0));
        found.into_iter().map(|(_, u, kind)| (u, kind)).collect()
    }

    /// Whether a fold curve passes a symmetric orbit between two points. Beyond it, the curve
    /// contains the mirror images of its orbits, at the same parameters.
    fn is_mirrored(&self, next: &Self) -> bool {
        next.along(self).is_some_and(|along| along < 0.0)
    }

    fn at(&self, locus: &impl TwoParameters, h: f64) -> Option<Self> {
        let own = &self.point;
        let point = correct(locus, &(&own.u + &own.tangent * h), &own.tangent).ok()?;
        Some(Self::new(locus, point))
    }

    /// The zero of a test function between two points, with its distance from the first point.
    fn locate(
        &self,
        locus: &impl TwoParameters,
        next: &Self,
        step: f64,
        kind: LocusEnd,
    ) -> Option<(f64, DVector<f64>)> {
        let (mut from, mut to) = ((0.0, self.test(kind)?), (step, next.test(kind)?));
        let changes_sign = from.1 * to.1 < 0.0;
        if !changes_sign {
            return None;
        }
        let size = from.1.abs().max(to.1.abs());
        // The Illinois rule: false position halves the value at an end that stays.
        let mut side = 0;
        for _ in 0..STEPS {
            let h = (from.0 * to.1 - to.0 * from.1) / (to.1 - from.1);
            let Some(at) = self.at(locus, h) else {
                return self.across(locus, (h, APART * step), kind, JUMP * size);
            };
            let value = at.test(kind)?;
            if value == 0.0 || (to.0 - from.0).abs() < WIDTH * step || value.abs() < WIDTH * size {
                return (value.abs() <= ZERO * size).then_some((h, at.point.u));
            }
            if value * from.1 < 0.0 {
                to = (h, value);
                from.1 *= if side == 1 { 0.5 } else { 1.0 };
                side = 1;
            } else {
                from = (h, value);
                to.1 *= if side == -1 { 0.5 } else { 1.0 };
                side = -1;
            }
        }
        None
    }

    /// A zero of a test function at which the equations are singular, for example because the
    /// orbit does not depend on the parameters. It is interpolated between a point on either side,
    /// and returned with its distance from the first. Small values there exclude a jump.
    fn across(
        &self,
        locus: &impl TwoParameters,
        (h, apart): (f64, f64),
        kind: LocusEnd,
        small: f64,
    ) -> Option<(f64, DVector<f64>)> {
        let (before, after) = (self.at(locus, h - apart)?, self.at(locus, h + apart)?);
        let (from, to) = (before.test(kind)?, after.test(kind)?);
        if from * to >= 0.0 || from.abs().max(to.abs()) > small {
            return None;
        }
        let part = from / (from - to);
        let way = &after.point.u - &before.point.u;
        Some((h + apart * (2.0 * part - 1.0), before.point.u + way * part))
    }

    /// The symmetric orbit between two points of a fold curve. The equations are singular there,
    /// because the pitchfork curve solves them too, so the point is extrapolated.
    fn meeting(&self, locus: &impl TwoParameters, next: &Self, step: f64) -> Option<DVector<f64>> {
        let (from, to) = (self.along(self)?, next.along(self)?);
        let way = step * from / (from - to);
        let near = PARTS.iter().filter_map(|part| self.at(locus, way * (1.0 - part)));
        let all: Vec<Self> = std::iter::once(self.clone()).chain(near).collect();
        extrapolated(&all)
    }
}

/// The fold-pitchfork point ahead of a fold curve's last points, where the curve can no longer be
/// followed.
pub(super) fn ahead(points: &[Marked]) -> Option<DVector<f64>> {
    let [.., before, last] = points else { return None };
    let (near, far) = (last.along(last)?, before.along(last)?);
    let step = (&last.point.u - &before.point.u).norm();
    let remains = step * near / (far - near);
    if !(0.0..REMAINS).contains(&remains) {
        return None;
    }
    extrapolated(points)
}

/// The point at which the products are zero, from the last three points of a fold curve. Both
/// parameters are even functions of the products, since an orbit's mirror image has the same
/// parameters.
fn extrapolated(points: &[Marked]) -> Option<DVector<f64>> {
    let own = &points[points.len().saturating_sub(3)..];
    let last = own.last()?;
    let along: Vec<f64> = own.iter().map(|point| point.along(last)).collect::<Option<_>>()?;
    let at_zero = |x: &[f64]| {
        let weight = |k: usize| -> f64 {
            let others = (0..x.len()).filter(|j| *j != k);
            others.map(|j| x[j] / (x[j] - x[k])).product()
        };
        let sum = |mut sum: DVector<f64>, k: usize| {
            sum.axpy(weight(k), &own[k].point.u, 1.0);
            sum
        };
        (0..x.len()).fold(DVector::zeros(last.point.u.len()), sum)
    };
    let mut u = at_zero(&along);
    let even = at_zero(&along.iter().map(|x| x * x).collect::<Vec<_>>());
    let n = u.len();
    u.rows_mut(n - 2, 2).copy_from(&even.rows(n - 2, 2));
    (own.len() > 1 && u.iter().all(|x| x.is_finite())).then_some(u)
}
