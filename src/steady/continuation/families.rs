//! The three quadratics as families: their roots, tests and names of bifurcations.

use super::super::exact_orbit::{ExactOrbit, OrbitFamily};
use super::super::multiple_scales::{FixedPoint, MultipleScales};
use super::super::strong_coupling::{StrongCoupling, StrongPoint};
use super::super::{Bifurcation, Roots, Sheet};
use super::Family;
use crate::error::Result;
use nalgebra::Complex;

/// Distance from the unit circle (or, relatively, the imaginary axis) within which a located pair counts as on it. A
/// location is good to 1e-12, and multipliers near a double one move with the square root of the parameter.
const ON_CIRCLE: f64 = 1e-5;

/// Tests of half-cycle multipliers: Π(μ+1) for symmetry breaking, Π(1-μᵢμⱼ) over pairs for a complex pair on
/// the circle.
fn breaking(multipliers: &[Complex<f64>]) -> f64 {
    multipliers.iter().map(|m| m + 1.0).product::<Complex<f64>>().re
}

fn pairs(values: &[Complex<f64>], factor: impl Fn(Complex<f64>, Complex<f64>) -> Complex<f64>) -> f64 {
    let mut product = Complex::new(1.0, 0.0);
    for (i, &a) in values.iter().enumerate() {
        for &b in &values[i + 1..] {
            product *= factor(a, b);
        }
    }
    product.re
}

/// The complex multiplier nearest the unit circle, if it is on it.
fn complex_on_circle(multipliers: &[Complex<f64>]) -> Option<Bifurcation> {
    let complex = multipliers.iter().filter(|m| m.im != 0.0);
    let nearest = complex.min_by(|a, b| (a.norm() - 1.0).abs().total_cmp(&(b.norm() - 1.0).abs()))?;
    ((nearest.norm() - 1.0).abs() < ON_CIRCLE).then(|| Bifurcation::of(*nearest))
}

fn near(multipliers: &[Complex<f64>], target: f64) -> bool {
    multipliers.iter().any(|m| (m - target).norm() < ON_CIRCLE.sqrt())
}

impl Family for OrbitFamily {
    type State = ExactOrbit;

    fn discriminant(&self) -> f64 {
        self.discriminant()
    }

    fn root(&self, sheet: Sheet) -> Option<f64> {
        self.impulses().map(|r| r.get(sheet))
    }

    fn state(&self, sheet: Sheet) -> Result<Option<ExactOrbit>> {
        self.orbit(sheet)
    }

    fn is_stable(state: &ExactOrbit) -> bool {
        state.is_stable()
    }

    fn is_clear(state: &ExactOrbit) -> bool {
        state.is_clear()
    }

    /// A multiplier 1 occurs at the fold alone, so it needs no test.
    fn tests(state: &ExactOrbit) -> [f64; 3] {
        let m = state.multipliers();
        [breaking(&m), pairs(&m, |a, b| 1.0 - a * b), 1.0]
    }

    fn confirm(state: &ExactOrbit, index: usize) -> Option<Bifurcation> {
        let m = state.multipliers();
        match index {
            0 => near(&m, -1.0).then_some(Bifurcation::SymmetryBreaking),
            _ => complex_on_circle(&m),
        }
    }
}

/// Tests of an approximation: its two half-cycle multipliers and its four slow eigenvalues.
fn slow_tests(multipliers: &[Complex<f64>; 2], eigenvalues: &[Complex<f64>; 4]) -> [f64; 3] {
    let saddle: Complex<f64> = multipliers.iter().map(|m| 1.0 - m).product();
    [breaking(multipliers), saddle.re, pairs(eigenvalues, |a, b| a + b)]
}

fn slow_confirm(
    multipliers: &[Complex<f64>; 2],
    eigenvalues: &[Complex<f64>; 4],
    index: usize,
) -> Option<Bifurcation> {
    let on_axis = |e: &Complex<f64>| e.im != 0.0 && e.re.abs() < ON_CIRCLE * e.norm();
    match index {
        0 => near(multipliers, -1.0).then_some(Bifurcation::SymmetryBreaking),
        1 => near(multipliers, 1.0).then_some(Bifurcation::SaddleNode),
        _ => eigenvalues.iter().any(on_axis).then_some(Bifurcation::NeimarkSacker),
    }
}

impl Family for MultipleScales {
    type State = FixedPoint;

    fn discriminant(&self) -> f64 {
        self.discriminant()
    }

    fn root(&self, sheet: Sheet) -> Option<f64> {
        self.fixed_points().map(|r| r.get(sheet).c)
    }

    fn state(&self, sheet: Sheet) -> Result<Option<FixedPoint>> {
        Ok(self.fixed_points().map(|r| r.get(sheet)).filter(|p| p.c > 0.0))
    }

    fn is_stable(state: &FixedPoint) -> bool {
        state.admissibility.all()
    }

    fn is_clear(state: &FixedPoint) -> bool {
        state.admissibility.geometric
    }

    fn tests(state: &FixedPoint) -> [f64; 3] {
        slow_tests(&state.multipliers, &state.eigenvalues)
    }

    fn confirm(state: &FixedPoint, index: usize) -> Option<Bifurcation> {
        slow_confirm(&state.multipliers, &state.eigenvalues, index)
    }
}

impl StrongCoupling {
    /// C of a root, negative where the block would move away from the stop it meets; of two such roots the sheets are
    /// ordered by |C|, so that they do not change places where ν does its sign.
    fn inward(&self, sheet: Sheet) -> Result<Option<(f64, StrongPoint)>> {
        let sign = if self.nu() < 0.0 { -1.0 } else { 1.0 };
        let order = |r: Roots<StrongPoint>| {
            if sign < 0.0 { Roots { lower: r.upper, upper: r.lower } } else { r }
        };
        Ok(self.solutions()?.map(|r| order(r).get(sheet)).map(|p| (sign * p.c, p)))
    }
}

impl Family for StrongCoupling {
    type State = StrongPoint;

    fn discriminant(&self) -> f64 {
        self.discriminant()
    }

    fn root(&self, sheet: Sheet) -> Option<f64> {
        self.inward(sheet).ok().flatten().map(|(c, _)| c)
    }

    fn state(&self, sheet: Sheet) -> Result<Option<StrongPoint>> {
        Ok(self.inward(sheet)?.filter(|(c, _)| *c > 0.0).map(|(_, p)| p))
    }

    fn is_stable(state: &StrongPoint) -> bool {
        state.admissibility.all()
    }

    fn is_clear(state: &StrongPoint) -> bool {
        state.admissibility.geometric
    }

    fn tests(state: &StrongPoint) -> [f64; 3] {
        slow_tests(&state.multipliers, &state.eigenvalues)
    }

    fn confirm(state: &StrongPoint, index: usize) -> Option<Bifurcation> {
        slow_confirm(&state.multipliers, &state.eigenvalues, index)
    }
}
