//! Steady states in closed form: the symmetric motion with two impacts per drive period.
//!
//! | module | what it holds | valid for |
//! |---|---|---|
//! | [`multiple_scales`] | the paper's sections 3–4 | ε → 0, weak coupling (k23 of order ε²) |
//! | [`strong_coupling`] | the paper's section 5, in closed form | ε → 0, k23 of order ε |
//! | [`exact_orbit`] | the exact orbit of the full system | any parameters |
//! | [`continuation`] | branches of any of these in one parameter | – |
//!
//! Nothing here calls the simulator: each is the other's oracle.
//!
//! ```
//! use vibro_impact::{Groups, Parameters, steady};
//!
//! let approximate = steady::multiple_scales::fixed_points(&Groups::basic())?.expect("two roots").upper;
//! let exact = steady::exact_orbit::solve(&Parameters::default())?.upper.expect("an orbit");
//! assert!(approximate.admissibility.all() && exact.is_stable());
//! assert!((approximate.a3 / exact.amplitudes()[2] - 1.0).abs() < 0.08); // as the paper says for ε = 0.1
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

use crate::error::{Error, Result};
use crate::parameters::Groups;
use nalgebra::Complex;
use quadratic::circle_roots;

/// Half-width of the angle around ±π/2 within which a complex pair on the unit circle is called a period
/// doubling, rad. Such a crossing has codimension two, so only a pair this near is told from its neighbours.
pub const QUARTER_TURN_TOLERANCE: f64 = 1e-6;

/// The three independent tests of an approximate steady state (paper 3.2, model.md section 4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Admissibility {
    /// The block leaves the stop it meets and never passes either: |W| ≤ 1 over the cycle.
    pub geometric: bool,
    /// Stable fixed point: all eigenvalues of the slow flow's Jacobian have negative real parts.
    pub fixed_point: bool,
    /// Stable periodic motion: all half-cycle multipliers of impact phase and block speed lie inside the unit circle.
    pub periodic_motion: bool,
}

impl Admissibility {
    /// Whether all three tests hold.
    pub fn all(self) -> bool {
        self.geometric && self.fixed_point && self.periodic_motion
    }
}

/// What happens when a multiplier μ of the half-cycle map crosses the unit circle (model.md section 6).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Bifurcation {
    /// μ = 1: two symmetric orbits meet and vanish.
    SaddleNode,
    /// μ = -1: the orbit keeps its period, but its two impacts become unequal.
    SymmetryBreaking,
    /// μ = ±i: the full cycle has the double multiplier -1. A symmetric orbit meets it only where two conditions
    /// hold at once; its usual way to period doubling leads over [`Self::SymmetryBreaking`].
    PeriodDoubling,
    /// Another complex pair of modulus one.
    NeimarkSacker,
}

impl Bifurcation {
    /// The bifurcation that a multiplier of the half-cycle map announces, by its direction in the complex plane.
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

/// An approximate motion at one phase: dimensionless displacements (unit L) and their derivatives with
/// respect to the phase; multiply these by Ω1 for d/dτ, by ω1 for d/dt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
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

/// Refuses groups outside the range in which the approximations mean anything.
fn check_groups(groups: &Groups) -> Result<()> {
    const ANY: (f64, f64, &str) = (f64::MIN, f64::MAX, "a finite number");
    const NOT_NEGATIVE: (f64, f64, &str) = (0.0, f64::MAX, "a finite number >= 0");
    let g = groups;
    let table = [
        ("epsilon", g.epsilon, (0.0, 1.0, "0 <= epsilon <= 1")),
        ("kappa", g.kappa, (0.0, 1.0, "0 <= kappa <= 1")),
        ("f10", g.f10, ANY),
        ("sigma1", g.sigma1, ANY),
        ("gamma1", g.gamma1, NOT_NEGATIVE),
        ("beta2", g.beta2, NOT_NEGATIVE),
        ("sigma30", g.sigma30, ANY),
        ("gamma3", g.gamma3, NOT_NEGATIVE),
        ("mu13", g.mu13, (f64::MIN_POSITIVE, f64::MAX, "a finite number > 0")),
    ];
    for (name, value, (min, max, allowed)) in table {
        if !(min..=max).contains(&value) {
            return Err(Error::OutOfRange { name, value, allowed });
        }
    }
    Ok(())
}

/// Eigenvalues of a real 2 × 2 matrix from its trace and determinant, the larger real part first.
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
