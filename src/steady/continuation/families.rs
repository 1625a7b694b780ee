//! The three kinds of steady states as families: roots, test functions and bifurcations.

use super::super::exact_orbit::{ExactOrbit, OrbitFamily};
use super::super::multiple_scales::{FixedPoint, MultipleScales};
use super::super::strong_coupling::{StrongCoupling, StrongPoint};
use super::super::{Bifurcation, Roots, Sheet};
use super::Family;
use crate::error::Result;
use nalgebra::Complex;

/// Distance from the unit circle, or relative distance from the imaginary axis, within which a
/// located pair counts as on it. A location is accurate to 1e-12. Near a double multiplier,
/// multipliers move with the square root of the parameter, that is, by 1e-6.
const ON_CIRCLE: f64 = 1e-5;

/// t_SB of docs/theory.md (81), Π(1+μ) over the half-cycle multipliers: zero where the symmetry
/// breaks.
fn symmetry_breaking_test(multipliers: &[Complex<f64>]) -> f64 {
    multipliers.iter().map(|m| m + 1.0).product::<Complex<f64>>().re
}

/// Real part of the product of `factor` over all pairs. For the factor 1-μᵢμⱼ it is t_NS of
/// docs/theory.md (81), zero where a complex pair is on the unit circle. For the factor λᵢ+λⱼ it
/// is zero where a complex pair of eigenvalues is on the imaginary axis.
fn product_over_pairs(
    values: &[Complex<f64>],
    factor: impl Fn(Complex<f64>, Complex<f64>) -> Complex<f64>,
) -> f64 {
    let mut product = Complex::new(1.0, 0.0);
    for (i, &a) in values.iter().enumerate() {
        for &b in &values[i + 1..] {
            product *= factor(a, b);
        }
    }
    product.re
}

/// Bifurcation of the complex multiplier nearest the unit circle, if it is on the circle.
fn complex_on_circle(multipliers: &[Complex<f64>]) -> Option<Bifurcation> {
    let complex = multipliers.iter().filter(|m| m.im != 0.0);
    let nearest = complex.min_by(|a, b| (a.norm() - 1.0).abs().total_cmp(&(b.norm() - 1.0).abs()))?;
    ((nearest.norm() - 1.0).abs() < ON_CIRCLE).then(|| Bifurcation::of(*nearest))
}

/// Whether a multiplier is at `target`, 1 or -1, within the square root of [`ON_CIRCLE`], since
/// near a double multiplier it moves with the square root of the parameter.
fn has_multiplier_at(multipliers: &[Complex<f64>], target: f64) -> bool {
    multipliers.iter().any(|m| (m - target).norm() < ON_CIRCLE.sqrt())
}

impl Family for OrbitFamily {
    type Solution = ExactOrbit;

    fn discriminant(&self) -> f64 {
        self.discriminant()
    }

    fn root(&self, sheet: Sheet) -> Option<f64> {
        self.impulses().map(|r| r.get(sheet))
    }

    fn solution(&self, sheet: Sheet) -> Result<Option<ExactOrbit>> {
        self.orbit(sheet)
    }

    fn is_stable(solution: &ExactOrbit) -> bool {
        solution.is_stable()
    }

    fn is_clear(solution: &ExactOrbit) -> bool {
        solution.is_clear()
    }

    /// A multiplier 1 needs no test, since it occurs only at the fold.
    fn tests(solution: &ExactOrbit) -> [f64; 3] {
        let m = solution.multipliers();
        [symmetry_breaking_test(&m), product_over_pairs(&m, |a, b| 1.0 - a * b), 1.0]
    }

    fn confirm(solution: &ExactOrbit, index: usize) -> Option<Bifurcation> {
        let m = solution.multipliers();
        match index {
            0 => has_multiplier_at(&m, -1.0).then_some(Bifurcation::SymmetryBreaking),
            _ => complex_on_circle(&m),
        }
    }
}

/// Test functions of an approximation, from its two half-cycle multipliers and its four slow
/// eigenvalues.
fn slow_tests(multipliers: &[Complex<f64>; 2], eigenvalues: &[Complex<f64>; 4]) -> [f64; 3] {
    let saddle: Complex<f64> = multipliers.iter().map(|m| 1.0 - m).product();
    [symmetry_breaking_test(multipliers), saddle.re, product_over_pairs(eigenvalues, |a, b| a + b)]
}

/// Bifurcation at a zero of one of [`slow_tests`].
fn slow_confirm(
    multipliers: &[Complex<f64>; 2],
    eigenvalues: &[Complex<f64>; 4],
    index: usize,
) -> Option<Bifurcation> {
    let on_axis = |e: &Complex<f64>| e.im != 0.0 && e.re.abs() < ON_CIRCLE * e.norm();
    match index {
        0 => has_multiplier_at(multipliers, -1.0).then_some(Bifurcation::SymmetryBreaking),
        1 => has_multiplier_at(multipliers, 1.0).then_some(Bifurcation::SaddleNode),
        _ => eigenvalues.iter().any(on_axis).then_some(Bifurcation::NeimarkSacker),
    }
}

impl Family for MultipleScales {
    type Solution = FixedPoint;

    fn discriminant(&self) -> f64 {
        self.discriminant()
    }

    fn root(&self, sheet: Sheet) -> Option<f64> {
        self.fixed_points().map(|r| r.get(sheet).c)
    }

    fn solution(&self, sheet: Sheet) -> Result<Option<FixedPoint>> {
        Ok(self.fixed_points().map(|r| r.get(sheet)).filter(|p| p.c > 0.0))
    }

    fn is_stable(solution: &FixedPoint) -> bool {
        solution.admissibility.all()
    }

    fn is_clear(solution: &FixedPoint) -> bool {
        solution.admissibility.geometric
    }

    fn tests(solution: &FixedPoint) -> [f64; 3] {
        slow_tests(&solution.multipliers, &solution.eigenvalues)
    }

    fn confirm(solution: &FixedPoint, index: usize) -> Option<Bifurcation> {
        slow_confirm(&solution.multipliers, &solution.eigenvalues, index)
    }
}

impl StrongCoupling {
    /// Solution of a sheet, and its C with a sign: positive if the block moves into the stop that
    /// it meets (νC > 0). The sheets are ordered by this signed C, so that they are not exchanged
    /// where ν changes its sign.
    fn inward(&self, sheet: Sheet) -> Result<Option<(f64, StrongPoint)>> {
        let sign = if self.nu() < 0.0 { -1.0 } else { 1.0 };
        let order = |r: Roots<StrongPoint>| {
            if sign < 0.0 { Roots { lower: r.upper, upper: r.lower } } else { r }
        };
        Ok(self.solutions()?.map(|r| order(r).get(sheet)).map(|p| (sign * p.c, p)))
    }
}

impl Family for StrongCoupling {
    type Solution = StrongPoint;

    fn discriminant(&self) -> f64 {
        self.discriminant()
    }

    fn root(&self, sheet: Sheet) -> Option<f64> {
        self.inward(sheet).ok().flatten().map(|(c, _)| c)
    }

    fn solution(&self, sheet: Sheet) -> Result<Option<StrongPoint>> {
        Ok(self.inward(sheet)?.filter(|(c, _)| *c > 0.0).map(|(_, p)| p))
    }

    fn is_stable(solution: &StrongPoint) -> bool {
        solution.admissibility.all()
    }

    fn is_clear(solution: &StrongPoint) -> bool {
        solution.admissibility.geometric
    }

    fn tests(solution: &StrongPoint) -> [f64; 3] {
        slow_tests(&solution.multipliers, &solution.eigenvalues)
    }

    fn confirm(solution: &StrongPoint, index: usize) -> Option<Bifurcation> {
        slow_confirm(&solution.multipliers, &solution.eigenvalues, index)
    }
}
