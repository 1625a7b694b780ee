//! The exact symmetric orbit with two impacts per period, at any mass ratio (model.md section 6; past the paper).
//!
//! Such an orbit repeats itself with the opposite sign after half a period: s(t + π/ω1) = -s(t). Its impulsive part
//! starts from p G⁺, G⁺ = (I+Φ)⁻¹ g with Φ = exp(Aπ/ω1) and g the velocities of a unit impulse; the force adds
//! H sin. The impact law then leaves a quadratic in the impulse p, and the phase δ of the force at the impact. There
//! is no small parameter and no truncation but that of double precision.

mod flight;
mod orbit;

pub use orbit::ExactOrbit;

use super::circle_roots;
use super::{Roots, Sheet};
use crate::error::{Error, Result};
use crate::parameters::Parameters;
use flight::{Flight, HalfPeriod};
use nalgebra::Complex;

/// The quadratic of one parameter set, with everything that does not depend on the root prepared.
#[derive(Clone, Copy, Debug)]
pub struct OrbitFamily {
    parameters: Parameters,
    flight: Flight,
    half: HalfPeriod,
    /// w = Im(response e^{i(θ)}) of the force alone: -H of the box.
    response: Complex<f64>,
    /// w and (w'⁺ + κ w'⁻)/(1+κ) at the impact per unit of impulse: Gw and R.
    reach: f64,
    rate: f64,
}

/// Both orbits of a parameter set, by their impulse p; a root with p ≤ 0 is no orbit and `None`.
///
/// # Errors
/// As [`OrbitFamily::new`] and [`OrbitFamily::orbit`].
pub fn solve(parameters: &Parameters) -> Result<Roots<Option<ExactOrbit>>> {
    OrbitFamily::new(parameters)?.orbits()
}

impl OrbitFamily {
    /// Prepares the quadratic. Loads on the bodies are zero.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] as [`Parameters::validate`]; [`Error::Undefined`] for ω1 = 0, for the undamped box at
    /// resonance and for an undamped mode at an odd multiple of ω1; [`Error::PrecisionLost`] for a mode more than about
    /// 15,000 times faster than the drive.
    pub fn new(parameters: &Parameters) -> Result<Self> {
        let flight = Flight::new(parameters)?;
        let half = flight.half_period(parameters)?;
        let response = -flight.harmonic(parameters)?;
        let kappa = flight.kappa;
        let g = half.after;
        let after = g[4] - g[3];
        // G⁻ = G⁺ - g, and g turns w' by -(1+ε).
        let before = after + 1.0 + flight.epsilon;
        let (reach, rate) = (g[1] - g[0], (after + kappa * before) / (1.0 + kappa));
        Ok(Self { parameters: *parameters, flight, half, response, reach, rate })
    }

    /// Coefficients of a p² + b p + c = 0 for the impulse p in units of m2 ω1 L.
    pub fn quadratic(&self) -> (f64, f64, f64) {
        let square = self.reach * self.reach + self.rate * self.rate;
        (square, -2.0 * self.reach, 1.0 - self.response.norm_sqr())
    }

    /// Discriminant b² - 4ac of the quadratic: zero at the fold, negative without solutions.
    pub fn discriminant(&self) -> f64 {
        let reach = self.reach.hypot(self.rate) * self.response.norm();
        4.0 * (reach - self.rate.abs()) * (reach + self.rate.abs())
    }

    /// The impulses of both roots in N·s, of either sign; `None` when the quadratic has no real root.
    pub fn impulses(&self) -> Option<Roots<f64>> {
        let unit = self.unit_of_impulse();
        self.roots().map(|r| Roots { lower: unit * r.lower, upper: unit * r.upper })
    }

    fn roots(&self) -> Option<Roots<f64>> {
        // |p G - i|² = |Hw|² with G = rate + i reach.
        let (square, twice, constant) = self.quadratic();
        circle_roots(square, 0.5 * twice, self.rate, constant, self.response.norm())
    }

    fn unit_of_impulse(&self) -> f64 {
        let p = &self.parameters;
        p.block_mass * p.drive_frequency * p.stop_gap
    }

    /// Both orbits; a root with p ≤ 0 is no orbit and `None`.
    ///
    /// # Errors
    /// As [`Self::orbit`].
    pub fn orbits(&self) -> Result<Roots<Option<ExactOrbit>>> {
        Ok(Roots { lower: self.orbit(Sheet::Lower)?, upper: self.orbit(Sheet::Upper)? })
    }

    /// The orbit of one root; `None` when the quadratic has no real root or this one has p ≤ 0.
    ///
    /// # Errors
    /// [`Error::NoConvergence`] when the eigenvalues of the half-cycle map are not found.
    pub fn orbit(&self, sheet: Sheet) -> Result<Option<ExactOrbit>> {
        let Some(p) = self.roots().map(|r| r.get(sheet)).filter(|&p| p > 0.0) else {
            return Ok(None);
        };
        // Hw e^{iδ} = Q + iP
        let turn = Complex::new(-p * self.rate, 1.0 - p * self.reach) / self.response;
        if !turn.norm().is_finite() {
            return Ok(None); // no force, no phase
        }
        ExactOrbit::new(self, sheet, p, turn.arg()).map(Some)
    }
}

/// Names the parameter that would have to change when eigenvalues fail.
fn no_eigenvalues() -> Error {
    Error::NoConvergence { what: "eigenvalues of the half-cycle map" }
}
