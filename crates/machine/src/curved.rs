//! Curved forces: polynomials φ(x) = c₂ x² + … + c₅ x⁵ of an elongation or of its rate, and
//! formulas, which are chains of [operations](Operation) (docs/assembly-law.md, section 20).
//!
//! The value of each operation is a coordinate of the augmented state, after the signals. The
//! arguments of an operation are rows on this state, which may contain the values of earlier
//! operations. Every force, contact force and watched functional of a machine with curved forces
//! is then a row on this state, as in a machine with straight laws. In a mode z' = A z holds with
//! constant A for all coordinates except the operations; the rate of an operation's value follows
//! from its derivatives. The flow is a power series ([`CurveSeries`]) whose remainder is bounded
//! (`Remainder`).

mod edge;
mod majorant;
mod operation;
mod recurrence;
mod remainder;
mod series;

pub use edge::Piece;
pub use operation::Operation;
pub use recurrence::TERMS;
pub(crate) use remainder::{ArgumentTerms, CurveTerms, Remainder};
pub use series::{CurveSeries, CurveSizes, LAST_ORDER, NEAR};

use crate::functional::Functional;
use crate::part::Part;

/// Lowest power of a curve; lower powers are stiffness, damping and preload.
pub const LOWEST: usize = 2;
/// Factor of the dissipation in the contact force of Hunt and Crossley.
pub const HUNT_CROSSLEY: f64 = 1.5;
/// Number of powers: 2 to 5.
pub const POWERS: usize = 4;

/// A polynomial φ(x) = Σ cₘ xᵐ without constant and linear terms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
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
}

/// An operation of a curved force.
#[derive(Clone, Debug)]
pub struct Curved {
    /// The first argument: for a polynomial an elongation e or its rate e'.
    pub argument: Functional,
    /// The second argument of a product; a row without terms for other operations.
    pub second: Functional,
    /// φ. A polynomial is in N or N m; its coefficient of xᵐ has the unit of φ divided by the m-th
    /// power of the unit of x: m, rad, m/s or rad/s.
    pub operation: Operation,
    /// Index of φ in the augmented state.
    pub place: usize,
    /// Whether the argument of a polynomial is a rate: φ then dissipates; otherwise it stores
    /// energy.
    pub is_of_rate: bool,
    /// The part of an element to which the operation belongs.
    pub owner: Part,
}

impl Curved {
    /// Values of the arguments at a state.
    #[inline(always)]
    pub fn arguments(&self, z: &[f64]) -> [f64; 2] {
        [self.argument.at(z), self.second.at(z)]
    }

    /// Sizes of the arguments, given the sizes of the coordinates.
    #[inline(always)]
    pub fn argument_sizes(&self, sizes: &[f64]) -> [f64; 2] {
        [self.argument.size(sizes), self.second.size(sizes)]
    }

    /// φ as a polynomial, if it is one.
    pub fn polynomial(&self) -> Option<Polynomial> {
        if let Operation::Polynomial(force) = self.operation { Some(force) } else { None }
    }

    /// Writes φ into the augmented state, from its coordinates, rates and earlier operations.
    #[inline(always)]
    pub fn fill(&self, z: &mut [f64]) {
        z[self.place] = self.operation.value(self.arguments(z));
    }

    /// Writes the variation of φ into a variation of the state `z`.
    #[inline(always)]
    pub fn vary(&self, z: &[f64], variation: &mut [f64]) {
        let slopes = self.operation.slopes(self.arguments(z));
        let mut sum = slopes[0] * self.argument.at(variation);
        if self.operation.is_of_two() {
            sum += slopes[1] * self.second.at(variation);
        }
        variation[self.place] = sum;
    }

    /// Size for the relative rounding error of φ: the size of φ, plus the sizes of its derivatives
    /// times the sums of the sizes of the terms of its arguments.
    #[inline(always)]
    pub fn size(&self, z: &[f64], sizes: &[f64]) -> f64 {
        let (value, slopes) = self.operation.sizes(self.arguments(z));
        let own = value + slopes[0] * self.argument.size(sizes);
        if self.operation.is_of_two() { own + slopes[1] * self.second.size(sizes) } else { own }
    }
}

#[cfg(test)]
mod tests;
