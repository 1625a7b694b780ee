//! The slow flow, its Jacobian and its eigenvalues: docs/theory.md (40), (41), (50) and (51).

use super::super::eigenvalue_pair;
use super::{Branch, MultipleScales, SAWTOOTH_HARMONIC};
use crate::error::{Error, Result};
use nalgebra::{Complex, Matrix4};

/// State of the slow flow: amplitudes in units of L, phases in rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlowState {
    /// B.
    pub b: f64,
    /// ψ.
    pub psi: f64,
    /// A3.
    pub a3: f64,
    /// ψ3.
    pub psi3: f64,
}

/// Terms shared by the slow flow and its Jacobian: C on the branch, its slope C_B = B/m,
/// docs/theory.md (38), and χ, (41).
struct SharedTerms {
    c: f64,
    c_b: f64,
    chi: f64,
}

impl MultipleScales {
    fn shared_terms(&self, branch: Branch, state: &SlowState) -> Result<SharedTerms> {
        let out =
            |name, value, allowed| Err(Error::Undefined { name, value, needed_by: "slow flow", allowed });
        let finite = [state.b, state.psi, state.a3, state.psi3].iter().all(|x| x.is_finite());
        let c = self.manifold.c(branch, state.b).filter(|_| finite && state.b > 0.0);
        let Some(c) = c else {
            return out("B", state.b, "finite values and B >= rho/sqrt(1 + rho^2), B > 0");
        };
        if state.a3 == 0.0 {
            return out("A3", state.a3, "A3 other than 0");
        }
        let chi = state.psi - state.psi3 + self.manifold.impact_phase(c);
        Ok(SharedTerms { c, c_b: state.b / self.manifold.slope(c), chi })
    }

    /// Right-hand side of the slow flow, docs/theory.md (40) and (41): (B', ψ', A3', ψ3') per unit
    /// of τ1, with C on the given branch.
    ///
    /// # Errors
    /// [`Error::Undefined`] if B is below B_min, or if B = 0 or A3 = 0, where amplitude and phase
    /// are singular as coordinates.
    pub fn slow_flow(&self, branch: Branch, state: &SlowState) -> Result<[f64; 4]> {
        let SharedTerms { c, chi, .. } = self.shared_terms(branch, state)?;
        let (g, rho, a) = (&self.groups, self.manifold.rho(), self.coupling);
        let b = state.b;
        Ok([
            0.5 * (-g.gamma1 * b - SAWTOOTH_HARMONIC * rho * c * c / b + g.f10 * state.psi.sin()),
            g.sigma1
                + 0.5 * SAWTOOTH_HARMONIC * c * (c - 1.0) / (b * b)
                + g.f10 * state.psi.cos() / (2.0 * b),
            0.5 * (-g.gamma3 * state.a3 + SAWTOOTH_HARMONIC * a * c * chi.cos()),
            g.sigma1 - 0.5 * (g.sigma30 + a) + 0.5 * SAWTOOTH_HARMONIC * a * (c / state.a3) * chi.sin(),
        ])
    }

    /// Jacobian of the slow flow, docs/theory.md (50), with rows and columns in the order B, ψ, A3,
    /// ψ3.
    ///
    /// # Errors
    /// As [`Self::slow_flow`].
    pub fn jacobian(&self, branch: Branch, state: &SlowState) -> Result<Matrix4<f64>> {
        let SharedTerms { c, c_b, chi } = self.shared_terms(branch, state)?;
        let (g, rho, a) = (&self.groups, self.manifold.rho(), self.coupling);
        let (b, a3) = (state.b, state.a3);
        let (sin, cos) = state.psi.sin_cos();
        let (sin_chi, cos_chi) = chi.sin_cos();
        let half = 0.5 * SAWTOOTH_HARMONIC;
        let phase_b = -rho * c_b / (b * b); // dΦ/dB
        let (pull, turn) = (half * a * c * cos_chi, half * a * c * sin_chi);
        Ok(Matrix4::new(
            -0.5 * g.gamma1 - half * rho * (2.0 * c * c_b / b - c * c / (b * b)),
            0.5 * g.f10 * cos,
            0.0,
            0.0,
            half * ((2.0 * c - 1.0) * c_b / (b * b) - 2.0 * c * (c - 1.0) / (b * b * b))
                - g.f10 * cos / (2.0 * b * b),
            -g.f10 * sin / (2.0 * b),
            0.0,
            0.0,
            half * a * (c_b * cos_chi - c * sin_chi * phase_b),
            -turn,
            -0.5 * g.gamma3,
            turn,
            half * a / a3 * (c_b * sin_chi + c * cos_chi * phase_b),
            pull / a3,
            -turn / (a3 * a3),
            -pull / a3,
        ))
    }

    /// Eigenvalues at the fixed point with amplitude C in closed form, docs/theory.md (51). At
    /// C_min they are infinite.
    pub(super) fn eigenvalues(&self, c: f64) -> [Complex<f64>; 4] {
        let (g, m) = (&self.groups, self.manifold.slope(c));
        let quadratic = &self.quadratic;
        let trace = -g.gamma1 - SAWTOOTH_HARMONIC * self.manifold.rho() * c / m;
        let determinant = (quadratic.alpha.norm_sqr() * c + quadratic.product().re) / (4.0 * m);
        let [first, second] = eigenvalue_pair(trace, determinant);
        let turn = 0.5 * (g.sigma30 - 2.0 * g.sigma1 + self.coupling);
        let third = Complex::new(-0.5 * g.gamma3, turn);
        [first, second, third, third.conj()]
    }
}
