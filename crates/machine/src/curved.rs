//! Curved forces: polynomials φ(x) = c₂ x² + … + c₅ x⁵ of an elongation or of its rate
//! (docs/assembly-law.md, section 20).
//!
//! The value of each curved force is a coordinate of the augmented state, after the signals. Every
//! force, contact force and watched functional of a machine with curved forces is then a row on
//! this state, as in a machine with straight laws. In a mode z' = A z holds with constant A for
//! all coordinates except the curved forces; the rate of a curved force follows from φ. The flow
//! is a power series ([`CurveSeries`]) whose remainder is bounded (`Remainder`).

mod remainder;
mod series;

pub(crate) use remainder::{CurveTerms, Remainder};
pub use series::{CurveSeries, CurveSizes, TERMS};

use crate::functional::Functional;

/// Lowest power of a curve; lower powers are stiffness, damping and preload.
pub const LOWEST: usize = 2;
/// Number of powers: 2 to 5.
pub const POWERS: usize = 4;

/// A polynomial φ(x) = Σ cₘ xᵐ without constant and linear terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polynomial {
    /// Coefficients of x², x³, x⁴, x⁵.
    pub coefficients: [f64; POWERS],
}

impl Polynomial {
    /// φ(x).
    #[inline(always)]
    pub fn value(&self, x: f64) -> f64 {
        let [c2, c3, c4, c5] = self.coefficients;
        x * x * (c2 + x * (c3 + x * (c4 + x * c5)))
    }

    /// φ'(x).
    #[inline(always)]
    pub fn derivative(&self, x: f64) -> f64 {
        let [c2, c3, c4, c5] = self.coefficients;
        x * (2.0 * c2 + x * (3.0 * c3 + x * (4.0 * c4 + x * 5.0 * c5)))
    }

    /// φ''(x).
    pub fn second_derivative(&self, x: f64) -> f64 {
        let [c2, c3, c4, c5] = self.coefficients;
        2.0 * c2 + x * (6.0 * c3 + x * (12.0 * c4 + x * 20.0 * c5))
    }

    /// The integral of φ from 0 to x.
    pub fn integral(&self, x: f64) -> f64 {
        let [c2, c3, c4, c5] = self.coefficients;
        x * x * x * (c2 / 3.0 + x * (c3 / 4.0 + x * (c4 / 5.0 + x * c5 / 6.0)))
    }

    /// The polynomial with the coefficients' absolute values: it bounds φ and its derivatives.
    #[inline(always)]
    pub fn majorant(&self) -> Self {
        Self { coefficients: self.coefficients.map(f64::abs) }
    }

    /// Smallest x > 0 at which one of the terms reaches a given size.
    pub(crate) fn reaching(&self, size: f64) -> f64 {
        let root = |(i, c): (usize, &f64)| (size / c.abs()).powf(1.0 / (i + LOWEST) as f64);
        let all = self.coefficients.iter().enumerate().filter(|(_, c)| **c != 0.0).map(root);
        all.fold(f64::INFINITY, f64::min)
    }
}

/// A curved force.
#[derive(Clone, Debug)]
pub struct Curved {
    /// x: an elongation e or its rate e'.
    pub argument: Functional,
    /// φ, N or N m. The coefficient of xᵐ has the unit of φ divided by the m-th power of the unit
    /// of x: m, rad, m/s or rad/s.
    pub force: Polynomial,
    /// Index of φ in the augmented state.
    pub place: usize,
    /// Whether x is a rate: φ then dissipates; otherwise it stores energy.
    pub is_of_rate: bool,
    /// Slope φ' at the amplitude that the start and the loads suggest, N/m or N s/m. It gives the
    /// mode a time scale, and no bound depends on it.
    pub slope: f64,
}

impl Curved {
    /// Writes φ into the augmented state, from its coordinates and rates.
    #[inline(always)]
    pub fn fill(&self, z: &mut [f64]) {
        z[self.place] = self.force.value(self.argument.at(z));
    }

    /// Writes the variation of φ into a variation of the state `z`.
    #[inline(always)]
    pub fn vary(&self, z: &[f64], variation: &mut [f64]) {
        let slope = self.force.derivative(self.argument.at(z));
        variation[self.place] = slope * self.argument.at(variation);
    }

    /// Size to which the rounding error of φ is relative: the sum of the sizes of the terms of φ,
    /// plus the slope of the majorant times the sum of the sizes of the terms of x.
    #[inline(always)]
    pub fn size(&self, z: &[f64], sizes: &[f64]) -> f64 {
        let (x, majorant) = (self.argument.at(z).abs(), self.force.majorant());
        majorant.value(x) + majorant.derivative(x) * self.argument.size(sizes)
    }
}
