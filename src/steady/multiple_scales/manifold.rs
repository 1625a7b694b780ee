//! The slow invariant manifold: U and W of the sawtooth form that satisfy the impact law (paper,
//! section 3.1; docs/theory.md, section 6), and their range of admissibility (section 7).

use crate::error::{Error, Result};
use crate::parameters::RESTITUTION;
use std::f64::consts::{PI, TAU};
use vibro_numerics::roots::brent;

/// Upper end of the search for C_Gmax. C_Gmax is largest at κ = 1, where it is about 8.235.
const C_GMAX_BRACKET: f64 = 10.0;

/// Accuracy of C_Gmax, which the geometric test itself does not use.
const C_GMAX_TOLERANCE: f64 = 1e-14;

/// Sawtooth Z(s) = (2/π) asin(cos s) of period 2π, docs/theory.md (31): 1 at s = 0, falling
/// linearly to -1 at π.
pub fn sawtooth(s: f64) -> f64 {
    let s = s.rem_euclid(TAU);
    if s <= PI { 1.0 - 2.0 * s / PI } else { 2.0 * s / PI - 3.0 }
}

/// dZ/ds; at a kink, the value just after it.
pub fn sawtooth_slope(s: f64) -> f64 {
    if s.rem_euclid(TAU) < PI { -2.0 / PI } else { 2.0 / PI }
}

/// Branch of the manifold over B, docs/theory.md (37); the two meet at C_min.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Branch {
    /// C < C_min.
    Left,
    /// C ≥ C_min.
    Right,
}

/// Slow invariant manifold B² = (C-1)² + ρ² C², docs/theory.md (35), for a restitution coefficient
/// κ. All quantities have unit 1 (amplitudes in units of L).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Manifold {
    kappa: f64,
    rho: f64,
}

impl Manifold {
    /// Manifold for κ.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless 0 ≤ κ ≤ 1.
    pub fn new(kappa: f64) -> Result<Self> {
        RESTITUTION.check("kappa", kappa)?;
        Ok(Self { kappa, rho: 2.0 / PI * (1.0 - kappa) / (1.0 + kappa) })
    }

    /// Restitution coefficient κ.
    pub fn kappa(&self) -> f64 {
        self.kappa
    }

    /// ρ = (2/π)(1-κ)/(1+κ), docs/theory.md (34).
    pub fn rho(&self) -> f64 {
        self.rho
    }

    /// C at the manifold's minimum, 1/(1+ρ²): docs/theory.md (36).
    pub fn c_min(&self) -> f64 {
        1.0 / (1.0 + self.rho * self.rho)
    }

    /// Least B, ρ/√(1+ρ²): docs/theory.md (36).
    pub fn b_min(&self) -> f64 {
        self.rho / (1.0 + self.rho * self.rho).sqrt()
    }

    /// B as a function of C, docs/theory.md (35).
    pub fn b(&self, c: f64) -> f64 {
        (c - 1.0).hypot(self.rho * c)
    }

    /// C on a branch over B, docs/theory.md (37); `None` for B < B_min.
    pub fn c(&self, branch: Branch, b: f64) -> Option<f64> {
        let square = 1.0 + self.rho * self.rho;
        let root = (square * b * b - self.rho * self.rho).sqrt();
        match branch {
            _ if root.is_nan() => None,
            Branch::Left => Some((1.0 - root) / square),
            Branch::Right => Some((1.0 + root) / square),
        }
    }

    /// Branch on which C lies.
    pub fn branch(&self, c: f64) -> Branch {
        if c < self.c_min() { Branch::Left } else { Branch::Right }
    }

    /// Phase Φ of the impact after the zero of U, B sin Φ = C - 1 and B cos Φ = -ρ C:
    /// docs/theory.md (34); in (-π, π].
    pub fn impact_phase(&self, c: f64) -> f64 {
        (c - 1.0).atan2(-self.rho * c)
    }

    /// m = B dB/dC = (1+ρ²) C - 1, docs/theory.md (38): zero at C_min, negative on the left
    /// branch.
    pub(super) fn slope(&self, c: f64) -> f64 {
        (1.0 + self.rho * self.rho) * c - 1.0
    }

    /// W at a phase s ∈ [0, π] after the impact at the upper stop, docs/theory.md (39).
    pub fn w(&self, c: f64, s: f64) -> f64 {
        c * sawtooth(s) - (c - 1.0) * s.cos() + self.rho * c * s.sin()
    }

    /// Largest |W| over the cycle, for C > 0: docs/theory.md (48).
    ///
    /// Since W(s) + W(π-s) = 2ρC sin s ≥ 0, the maximum is at least as large in size as any
    /// minimum. For C ≤ 1, or B ≤ 2C/π, W falls monotonically from 1 to -1.
    pub fn w_max(&self, c: f64) -> f64 {
        let b = self.b(c);
        let q = 2.0 * c / (PI * b);
        if c <= 1.0 || q >= 1.0 || q.is_nan() {
            return 1.0;
        }
        // W' = -2C/π - B cos(s + Φ) falls through zero where s + Φ = π + acos q.
        let s = PI + q.acos() - self.impact_phase(c);
        (c * (1.0 - 2.0 * s / PI) + b * (1.0 - q * q).sqrt()).max(1.0)
    }

    /// Geometric test: whether a motion of amplitude C keeps to |W| ≤ 1 and meets the stops from
    /// inside.
    pub fn is_geometric(&self, c: f64) -> bool {
        c > 0.0 && self.w_max(c) <= 1.0
    }

    /// Upper limit of C by the geometric test, by Brent's method. It is 1 at κ = 0, about 6.07 at
    /// κ = 0.75.
    ///
    /// Where the largest W equals 1, it rises with C, so there is only one such C. The search
    /// starts at the C of docs/theory.md (49).
    pub fn c_gmax(&self) -> f64 {
        let excess = |c: f64| {
            let b = self.b(c);
            let q = (2.0 * c / (PI * b)).min(1.0);
            let s = PI + q.acos() - self.impact_phase(c);
            c * (1.0 - 2.0 * s / PI) + b * (1.0 - q * q).sqrt() - 1.0
        };
        // Below this C, W falls monotonically; just above it the maximum is still under 1.
        let turning = 1.0 / (1.0 - (4.0 / (PI * PI) - self.rho * self.rho).max(0.0).sqrt());
        if self.kappa == 0.0 {
            return 1.0;
        }
        brent(excess, turning, C_GMAX_BRACKET, C_GMAX_TOLERANCE).unwrap_or(turning)
    }

    /// C at which a half-cycle multiplier of the periodic motion is +1 (saddle-node),
    /// docs/theory.md (56): C_min.
    pub fn c_smin(&self) -> f64 {
        self.c_min()
    }

    /// C at which a half-cycle multiplier is -1 (symmetry breaking), docs/theory.md (56):
    /// π²/(π²-4) for every κ.
    pub fn c_smax(&self) -> f64 {
        PI * PI / (PI * PI - 4.0)
    }

    /// Matrix D of the half-cycle map of perturbations of impact phase (first row) and block speed
    /// (second row) for fixed U, docs/theory.md (53); the paper's section 3.3 to leading order in
    /// ε.
    ///
    /// # Errors
    /// [`Error::Undefined`] at C = 0, where the block does not move.
    pub fn transition(&self, c: f64) -> Result<[[f64; 2]; 2]> {
        if c == 0.0 || !c.is_finite() {
            return Err(Error::Undefined {
                name: "C",
                value: c,
                needed_by: "transition matrix D",
                allowed: "a finite C other than 0",
            });
        }
        let k = 1.0 + self.kappa;
        let b = PI * PI / 4.0 * k / c;
        Ok([[self.kappa, -b], [k * (c - 1.0) * self.kappa, self.kappa - k * (c - 1.0) * b]])
    }

    /// Trace of D, 2κ - (1+κ)²(π²/4)(C-1)/C, docs/theory.md (54); its determinant is κ².
    pub(super) fn transition_trace(&self, c: f64) -> f64 {
        let k = 1.0 + self.kappa;
        2.0 * self.kappa - k * k * (PI * PI / 4.0) * (c - 1.0) / c
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tolerance for closed forms: a few roundings.
    const ROUNDING: f64 = 1e-14;
    /// Tolerance: half a unit of the last digit of the golden ρ.
    const GOLDEN_RHO: f64 = 5e-7;
    /// Tolerance: half a unit of the last digit of the golden C_min.
    const GOLDEN_C_MIN: f64 = 5e-6;
    /// Tolerance: half a unit of the last digit of the golden C_Smax.
    const GOLDEN_C_SMAX: f64 = 5e-5;
    /// Tolerance: half a unit of the last digit of the golden C_Gmax and its B.
    const GOLDEN_C_MAX: f64 = 5e-3;
    /// Tolerance for C_Gmax at κ = 1, found by minimising on a grid.
    const GOLDEN_C_ELASTIC: f64 = 1e-8;
    /// Tolerance for a maximum by dense sampling, whose error is of the order of the step squared.
    const SAMPLING: f64 = 1e-6;

    #[test]
    fn golden_manifold_values() {
        assert!((Manifold::new(0.0).unwrap().rho() - 2.0 / PI).abs() < ROUNDING);
        assert_eq!(Manifold::new(1.0).unwrap().rho(), 0.0);
        let manifold = Manifold::new(0.75).unwrap();
        assert!((manifold.rho() - 0.090946).abs() < GOLDEN_RHO);
        assert!((manifold.c_min() - 0.99180).abs() < GOLDEN_C_MIN);
        assert!((manifold.c_smax() - 1.6815).abs() < GOLDEN_C_SMAX);
        assert!((manifold.c_gmax() - 6.07).abs() < GOLDEN_C_MAX);
        assert!((manifold.b(manifold.c_gmax()) - 5.10).abs() < GOLDEN_C_MAX);
    }

    #[test]
    fn closed_form_branches_invert_the_manifold() {
        for kappa in [0.0, 0.3, 0.75, 1.0] {
            let manifold = Manifold::new(kappa).unwrap();
            for c in [-0.5, 0.1, 0.6, 1.1, 2.0, 5.0] {
                let back = manifold.c(manifold.branch(c), manifold.b(c)).unwrap();
                assert!((back - c).abs() < ROUNDING, "kappa {kappa}, C {c}: {back}");
            }
            assert!((manifold.b(manifold.c_min()) - manifold.b_min()).abs() < ROUNDING);
            assert!(kappa == 1.0 || manifold.c(Branch::Right, 0.99 * manifold.b_min()).is_none());
        }
    }

    #[test]
    fn second_method_geometric_limit_by_sampling() {
        for kappa in [0.05, 0.3, 0.75, 1.0] {
            let manifold = Manifold::new(kappa).unwrap();
            let limit = manifold.c_gmax();
            for c in [0.05, 0.5, 1.0, 1.3, 0.999 * limit, 1.001 * limit, 1.5 * limit] {
                let samples = (0..=20_000).map(|i| manifold.w(c, PI * f64::from(i) / 20_000.0));
                let sampled = samples.fold(0.0_f64, |m, w| m.max(w.abs()));
                assert!((manifold.w_max(c) - sampled).abs() < SAMPLING, "kappa {kappa}, C {c}");
                assert_eq!(manifold.is_geometric(c), c < limit, "kappa {kappa}, C {c}");
            }
        }
        // The limit for κ = 1 by minimising (1 - cos s)/(1 - 2s/π - cos s) on a grid.
        assert!((Manifold::new(1.0).unwrap().c_gmax() - 8.235007738).abs() < GOLDEN_C_ELASTIC);
        let plastic = Manifold::new(0.0).unwrap();
        assert_eq!(plastic.c_gmax(), 1.0);
        assert!(plastic.is_geometric(0.9999) && !plastic.is_geometric(1.001));
    }

    #[test]
    fn invariant_impact_law_on_the_manifold() {
        let manifold = Manifold::new(0.6).unwrap();
        for c in [0.4, 1.2, 3.0] {
            let (b, phase) = (manifold.b(c), manifold.impact_phase(c));
            assert!((c - b * phase.sin() - 1.0).abs() < ROUNDING);
            let (before, after) = (2.0 / PI * c - b * phase.cos(), -2.0 / PI * c - b * phase.cos());
            assert!((after + 0.6 * before).abs() < ROUNDING);
        }
    }

    #[test]
    fn closed_form_of_the_limits_of_periodic_motion() {
        for kappa in [0.0, 0.4, 0.75, 0.95] {
            let manifold = Manifold::new(kappa).unwrap();
            for (c, multiplier) in [(manifold.c_smin(), 1.0), (manifold.c_smax(), -1.0)] {
                let d = manifold.transition(c).unwrap();
                let (trace, determinant) = (d[0][0] + d[1][1], d[0][0] * d[1][1] - d[0][1] * d[1][0]);
                assert!((determinant - kappa * kappa).abs() < ROUNDING);
                assert!((trace - manifold.transition_trace(c)).abs() < ROUNDING);
                assert!((1.0 - multiplier * trace + determinant).abs() < ROUNDING);
            }
        }
        let resting = Manifold::new(0.5).unwrap().transition(0.0);
        assert!(matches!(resting, Err(Error::Undefined { name: "C", .. })));
    }

    #[test]
    fn restitution_out_of_range_is_an_error() {
        for kappa in [-0.1, 1.1, f64::NAN] {
            assert!(matches!(Manifold::new(kappa), Err(Error::OutOfRange { name: "kappa", .. })));
        }
    }
}
