//! Steady states in closed form: the symmetric motion with two impacts per drive period.
//!
//! | module | content | valid for |
//! |---|---|---|
//! | [`multiple_scales`] | the paper's sections 3–4; docs/theory.md, sections 6 and 7 | ε → 0, weak coupling (k23 of order ε²) |
//! | [`strong_coupling`] | the paper's section 5 in closed form; docs/theory.md, section 8 | ε → 0, k23 of order ε |
//! | [`exact_orbit`] | the exact orbit of the full system; docs/theory.md, sections 9 and 10 | any parameters |
//! | [`continuation`] | branches of any of these in one parameter | – |
//!
//! This module never calls the simulator and the simulator never calls this module, so that each
//! tests the other.
//!
//! ```
//! use vibro_impact::{Groups, Parameters, steady};
//!
//! let points = steady::multiple_scales::fixed_points(&Groups::basic())?;
//! let approximate = points.expect("two roots").upper;
//! let exact = steady::exact_orbit::solve(&Parameters::default())?.upper.expect("an orbit");
//! assert!(approximate.admissibility.all() && exact.is_stable());
//! // The paper's error for ε = 0.1.
//! assert!((approximate.a3 / exact.amplitudes()[2] - 1.0).abs() < 0.08);
//! # Ok::<(), vibro_impact::Error>(())
//! ```

pub mod continuation;
pub mod exact_orbit;
pub mod multiple_scales;
mod quadratic;
pub mod strong_coupling;

#[cfg(test)]
mod tests;

pub use quadratic::{Roots, Sheet};

use crate::error::Result;
use crate::parameters::{GROUPS, Groups, Range};
use nalgebra::Complex;
use quadratic::Quadratic;

/// Half-width of the angle about ±π/2 within which a crossing of the unit circle by a complex pair
/// is called a period doubling, rad. It is narrow because such a crossing has codimension two.
pub const QUARTER_TURN_TOLERANCE: f64 = 1e-6;

/// Penetration of a stop, in units of L, up to which it counts as round-off. The error of a flight
/// is a few 1e-15 per Taylor piece.
pub const PENETRATION_ROUNDING: f64 = 1e-12;

/// Ratio of an impedance to the sum of its terms at or below which the impedance counts as zero.
const IMPEDANCE_ROUNDING: f64 = 1e-14;

/// Largest number of QR sweeps for the eigenvalues of a matrix. A few suffice; with NaN the sweeps
/// would not end.
const EIGENVALUE_SWEEPS: usize = 300;

/// Results of the three independent tests of an approximate steady state (paper, section 3.2;
/// docs/theory.md, section 7).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Admissibility {
    /// Geometric test: the block leaves the stop that it meets and never passes a stop, |W| ≤ 1
    /// over the cycle, docs/theory.md (48) and (68).
    pub geometric: bool,
    /// Stable fixed point: all eigenvalues of the slow flow's Jacobian have negative real parts,
    /// docs/theory.md (51) and (66).
    pub fixed_point: bool,
    /// Stable periodic motion: all half-cycle multipliers of impact phase and block speed lie
    /// inside the unit circle, docs/theory.md (55) and (67).
    pub periodic_motion: bool,
}

impl Admissibility {
    /// Whether all three tests hold.
    pub fn all(self) -> bool {
        self.geometric && self.fixed_point && self.periodic_motion
    }
}

/// Bifurcation at which a multiplier μ of the half-cycle map crosses the unit circle
/// (docs/theory.md, table in section 10).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Bifurcation {
    /// μ = 1: two symmetric orbits meet and vanish.
    SaddleNode,
    /// μ = -1: the orbit keeps its period, but its two impacts become unequal.
    SymmetryBreaking,
    /// μ = ±i: the full cycle has the double multiplier -1. A symmetric orbit meets it only where
    /// two conditions hold at once; it usually breaks its symmetry first
    /// ([`Self::SymmetryBreaking`]).
    PeriodDoubling,
    /// Another complex pair of modulus one.
    NeimarkSacker,
}

impl Bifurcation {
    /// Bifurcation that a multiplier of the half-cycle map indicates, from the multiplier's
    /// argument.
    pub fn of(multiplier: Complex<f64>) -> Self {
        let angle = multiplier.im.abs().atan2(multiplier.re);
        if multiplier.im == 0.0 {
            if multiplier.re >= 0.0 { Self::SaddleNode } else { Self::SymmetryBreaking }
        } else if (angle - std::f64::consts::FRAC_PI_2).abs() < QUARTER_TURN_TOLERANCE {
            Self::PeriodDoubling
        } else {
            Self::NeimarkSacker
        }
    }
}

/// Approximate steady motion at one phase: dimensionless displacements (unit L) and their
/// derivatives with respect to the phase. A derivative times Ω1 is d/dτ; a derivative times ω1 L
/// is in m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteadyMotion {
    /// U = X1 + ε X2.
    pub u: f64,
    /// W = X2 - X1, of leading order: |W| = 1 at the impacts.
    pub w: f64,
    /// X1, X2, X3.
    pub x: [f64; 3],
    /// dU.
    pub du: f64,
    /// dW; just after the impact at an impact.
    pub dw: f64,
    /// dX1, dX2, dX3; just after the impact at an impact.
    pub dx: [f64; 3],
}

impl SteadyMotion {
    /// Motion from the leading-order values and slopes of U, X2 and X3, docs/theory.md (29).
    fn new(epsilon: f64, (u, du): (f64, f64), (x2, dx2): (f64, f64), (x3, dx3): (f64, f64)) -> Self {
        let (block, box_share) = inverse_mass_factors(epsilon);
        Self {
            u,
            w: x2 - u,
            x: [u - box_share * x2, block * x2, x3],
            du,
            dw: dx2 - du,
            dx: [du - box_share * dx2, block * dx2, dx3],
        }
    }
}

/// 1/(1+ε) and ε/(1+ε) to second order, 1 - ε + ε² and ε - ε²: docs/theory.md (29).
fn inverse_mass_factors(epsilon: f64) -> (f64, f64) {
    (1.0 - epsilon + epsilon * epsilon, epsilon - epsilon * epsilon)
}

/// Checks that groups are in the valid ranges of the approximations. These are the ranges of
/// [`GROUPS`] with two exceptions: ε may be zero, the limit of the approximations, and `alpha23`
/// is not read, since `beta2` describes the same quantity.
fn check_groups(groups: &Groups) -> Result<()> {
    for group in GROUPS.iter().filter(|group| group.name != "alpha23") {
        let range = match group.name {
            "epsilon" => Range { open_min: false, allowed: "0 <= epsilon <= 1", ..group.range },
            _ => group.range,
        };
        range.check(group.name, (group.get)(groups))?;
    }
    Ok(())
}

/// Largest modulus of two multipliers.
fn spectral_radius([first, second]: [Complex<f64>; 2]) -> f64 {
    first.norm().max(second.norm())
}

/// The multiplier with the larger modulus, the first if both are equal.
fn largest([first, second]: [Complex<f64>; 2]) -> Complex<f64> {
    if first.norm_sqr() >= second.norm_sqr() { first } else { second }
}

/// Eigenvalues of a real 2 × 2 matrix from its trace and determinant, the larger real part first.
/// If both are real, the one of larger modulus is computed first, without cancellation, and the
/// other from the determinant.
fn eigenvalue_pair(trace: f64, determinant: f64) -> [Complex<f64>; 2] {
    let half = 0.5 * trace;
    let discriminant = half * half - determinant;
    if discriminant < 0.0 {
        let imaginary = (-discriminant).sqrt();
        return [Complex::new(half, imaginary), Complex::new(half, -imaginary)];
    }
    let far = half + discriminant.sqrt().copysign(half);
    let near = if far == 0.0 { 0.0 } else { determinant / far };
    [Complex::new(far.max(near), 0.0), Complex::new(far.min(near), 0.0)]
}
