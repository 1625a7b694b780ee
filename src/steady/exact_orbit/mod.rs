//! The exact symmetric orbit with two impacts per period, at any mass ratio (docs/theory.md,
//! sections 9 and 10; not in the paper).
//!
//! Such an orbit repeats itself with the opposite sign after half a period: s(t + π/ω1) = -s(t).
//! Its impulsive part starts from p G⁺, where G⁺ is the periodic response to alternating unit
//! impulses, docs/theory.md (72); the force adds the harmonic response H, (71). The impact law
//! then gives a quadratic in the impulse p, (74), and the phase δ of the force at the impact,
//! (75). The theory has no small parameter, and double precision is the only truncation.

mod clearance;
mod flight;
mod impact;
mod orbit;

pub use clearance::Clearance;
pub use flight::{Flight, Transition, Vector6};
pub use orbit::{ExactOrbit, OrbitWalk, eigenvalues};

use super::{Quadratic, Roots, Sheet};
use crate::error::{Error, Result};
use crate::parameters::Parameters;
use flight::HalfPeriod;
use nalgebra::Complex;

/// The two orbits of one parameter set, with all quantities that do not depend on the root.
#[derive(Clone, Copy, Debug)]
pub struct OrbitFamily {
    parameters: Parameters,
    flight: Flight,
    half: HalfPeriod,
    /// H_w of docs/theory.md (71): under the force alone w = Im(response e^{iθ}).
    response: Complex<f64>,
    /// G_w of docs/theory.md (73): w at the impact per unit of impulse.
    gap_answer: f64,
    /// R of docs/theory.md (73): (w'⁺ + κ w'⁻)/(1+κ) at the impact per unit of impulse.
    rate_answer: f64,
}

/// Both orbits of a parameter set, ordered by their impulse p. `None` for a root with p ≤ 0, which
/// does not belong to an orbit.
///
/// # Errors
/// As [`OrbitFamily::new`] and [`OrbitFamily::orbit`].
pub fn solve(parameters: &Parameters) -> Result<Roots<Option<ExactOrbit>>> {
    OrbitFamily::new(parameters)?.orbits()
}

impl OrbitFamily {
    /// Quadratic of a parameter set. No loads act on the bodies.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] as [`Parameters::validate`]; [`Error::Undefined`] if ω1 = 0, if the
    /// box is undamped and at resonance, or if an undamped mode is at an odd multiple of ω1;
    /// [`Error::PrecisionLost`] if a mode is more than about 15,000 times faster than the drive.
    pub fn new(parameters: &Parameters) -> Result<Self> {
        parameters.check_symmetric()?;
        let flight = Flight::new(parameters)?;
        let half = flight.half_period(parameters)?;
        let response = -flight.harmonic(parameters)?;
        let kappa = flight.kappa;
        let g = half.after;
        let after = g[4] - g[3];
        // G⁻ = G⁺ - g, and g changes w' by -(1+ε).
        let before = after + 1.0 + flight.epsilon;
        let (gap_answer, rate_answer) = (g[1] - g[0], (after + kappa * before) / (1.0 + kappa));
        Ok(Self { parameters: *parameters, flight, half, response, gap_answer, rate_answer })
    }

    /// Coefficients (a, b, c) of a p² + b p + c = 0 for the impulse p in units of m2 ω1 L,
    /// docs/theory.md (74).
    pub fn quadratic(&self) -> (f64, f64, f64) {
        self.circle().coefficients()
    }

    /// Discriminant b² - 4ac of the quadratic, docs/theory.md (76): zero at the fold, negative
    /// without a solution.
    pub fn discriminant(&self) -> f64 {
        self.circle().discriminant()
    }

    /// Impulses of both roots in N·s, of either sign; `None` if the quadratic has no real root.
    pub fn impulses(&self) -> Option<Roots<f64>> {
        let unit = self.unit_of_impulse();
        self.circle().roots().map(|r| Roots { lower: unit * r.lower, upper: unit * r.upper })
    }

    /// Equation (73) of docs/theory.md as `|p (R + i G_w) - i|² = |H_w|²`.
    fn circle(&self) -> Quadratic {
        Quadratic {
            alpha: Complex::new(self.rate_answer, self.gap_answer),
            alpha0: Complex::new(0.0, -1.0),
            force: self.response.norm(),
            constant: 1.0 - self.response.norm_sqr(),
        }
    }

    fn unit_of_impulse(&self) -> f64 {
        let p = &self.parameters;
        p.block_mass * p.drive_frequency * p.stop_gap
    }

    /// Both orbits; `None` for a root with p ≤ 0, which does not belong to an orbit.
    ///
    /// # Errors
    /// As [`Self::orbit`].
    pub fn orbits(&self) -> Result<Roots<Option<ExactOrbit>>> {
        Ok(Roots { lower: self.orbit(Sheet::Lower)?, upper: self.orbit(Sheet::Upper)? })
    }

    /// Orbit of one root; `None` if the quadratic has no real root or this one has p ≤ 0.
    ///
    /// # Errors
    /// [`Error::NoConvergence`] if the eigenvalues of the half-cycle map are not found.
    pub fn orbit(&self, sheet: Sheet) -> Result<Option<ExactOrbit>> {
        let Some(p) = self.circle().roots().map(|r| r.get(sheet)).filter(|&p| p > 0.0) else {
            return Ok(None);
        };
        // e^{iδ} of docs/theory.md (73).
        let turn = Complex::new(-p * self.rate_answer, 1.0 - p * self.gap_answer) / self.response;
        if !turn.norm().is_finite() {
            return Ok(None); // without force there is no phase
        }
        ExactOrbit::new(self, sheet, p, turn.arg()).map(Some)
    }
}

/// Error if the QR sweeps for the half-cycle map do not end.
fn no_eigenvalues() -> Error {
    Error::NoConvergence { what: "eigenvalues of the half-cycle map" }
}
