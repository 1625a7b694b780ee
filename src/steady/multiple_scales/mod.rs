//! Multiple scales with the sawtooth function (paper, sections 3 and 4; docs/theory.md, sections 6
//! and 7).
//!
//! Let η = Ω1 τ - ψ and let Z be the sawtooth. The steady state is U ≈ B sin η, X2 ≈ (1-ε+ε²) C
//! Z(η-Φ), X1 ≈ B sin η - (ε-ε²) C Z(η-Φ), X3 ≈ A3 sin(Ω1 τ - ψ3), docs/theory.md (32) and (33).
//! Each fixed point of the slow flow is a root of a C² + b C + c = 0 (44). The error is O(ε) in
//! every amplitude.
//!
//! Beyond the paper, the eigenvalues of the slow flow have a closed form (51). It shows that on
//! the right branch of the manifold, with damping, only the upper root of the quadratic is a
//! stable fixed point.

mod manifold;
mod motion;
mod slow_flow;

pub use manifold::{Branch, Manifold, sawtooth, sawtooth_slope};
pub use slow_flow::SlowState;

use super::{
    Admissibility, Bifurcation, IMPEDANCE_ROUNDING, Quadratic, Roots, check_groups, eigenvalue_pair,
    inverse_mass_factors, largest, spectral_radius,
};
use crate::error::{Error, Result};
use crate::parameters::Groups;
use nalgebra::Complex;
use std::f64::consts::PI;

/// First Fourier coefficient of the sawtooth, 8/π²: docs/theory.md (31).
const SAWTOOTH_HARMONIC: f64 = 8.0 / (PI * PI);

/// Slow flow of one parameter set, with all quantities that do not depend on the root. The weak
/// coupling is α̂ = μ13 β², docs/theory.md (26). It equals [`Groups::alpha23`] for the paper's m3
/// = m2 and is also correct for other m3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MultipleScales {
    groups: Groups,
    manifold: Manifold,
    /// α̂ = μ13 β²: weak coupling, relative to the secondary oscillator.
    coupling: f64,
    /// f̂ e^{iδ} = αC + α₀ with the phase δ of the force at the upper impact, docs/theory.md (43).
    quadratic: Quadratic,
    /// A3/C, docs/theory.md (45).
    a3_per_c: f64,
}

/// Fixed point of the slow flow, with its three tests. Amplitudes are in units of L, phases in
/// rad, eigenvalues per unit of the slow time τ1 = ετ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedPoint {
    /// C, the amplitude of the block's sawtooth.
    pub c: f64,
    /// B, the amplitude of U.
    pub b: f64,
    /// A3, the amplitude of X3.
    pub a3: f64,
    /// Φ: the block meets the upper stop at η = Φ, docs/theory.md (35).
    pub impact_phase: f64,
    /// δ = Φ + ψ: phase of the force when the block meets the upper stop, in (-π, π].
    pub drive_phase: f64,
    /// ψ: η = Ω1 τ - ψ.
    pub psi: f64,
    /// ψ3: X3 = A3 sin(Ω1 τ - ψ3).
    pub psi3: f64,
    /// Branch of the manifold.
    pub branch: Branch,
    /// The three tests.
    pub admissibility: Admissibility,
    /// Eigenvalues of the slow flow's Jacobian: first of (B, ψ), then of (A3, ψ3), docs/theory.md
    /// (51).
    pub eigenvalues: [Complex<f64>; 4],
    /// Half-cycle multipliers of the periodic motion: the eigenvalues of D, docs/theory.md (53).
    pub multipliers: [Complex<f64>; 2],
    epsilon: f64,
}

/// Amplitudes f̂10 ≥ 0 of the force at which the quadratic has solutions; the other groups are
/// fixed. Unit 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceRange {
    /// Smallest amplitude with real roots: the fold.
    pub real_from: f64,
    /// Smallest amplitude with a root C > 0. A largest amplitude does not exist.
    pub positive_from: f64,
    /// Largest amplitude with two roots C > 0; equal to `positive_from` if there is never more
    /// than one.
    pub two_until: f64,
    /// Interval of amplitudes at which a root passes all three tests, if there is one. Its lower
    /// end is excluded.
    pub admissible: Option<(f64, f64)>,
}

/// Both fixed points of the slow flow, by C; `None` if the quadratic has no real root.
///
/// # Errors
/// As [`MultipleScales::new`].
pub fn fixed_points(groups: &Groups) -> Result<Option<Roots<FixedPoint>>> {
    Ok(MultipleScales::new(groups)?.fixed_points())
}

impl MultipleScales {
    /// Slow flow for a set of groups.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if a group is outside its range or NaN; [`Error::Undefined`] if γ̂3 =
    /// 0 and σ̂30 - 2σ̂1 + α̂ = 0, where A3 is unbounded.
    pub fn new(groups: &Groups) -> Result<Self> {
        check_groups(groups)?;
        let g = *groups;
        let manifold = Manifold::new(g.kappa)?;
        let rho = manifold.rho();
        let coupling = g.mu13 * g.beta2;
        let detuning = g.sigma30 - 2.0 * g.sigma1 + coupling;
        let impedance = g.gamma3.hypot(detuning);
        let terms = g.sigma30.abs() + 2.0 * g.sigma1.abs() + coupling;
        if coupling > 0.0 && impedance <= IMPEDANCE_ROUNDING * terms {
            return Err(Error::Undefined {
                name: "gamma3",
                value: g.gamma3,
                needed_by: "amplitude A3 at resonance",
                allowed: "gamma3 > 0 where sigma30 - 2 sigma1 + alpha23 = 0",
            });
        }
        let s = Complex::new(-2.0 * g.sigma1, g.gamma1);
        let alpha0 = Complex::new(s.im, -s.re);
        Ok(Self {
            groups: g,
            manifold,
            coupling,
            quadratic: Quadratic {
                alpha: s * Complex::new(-rho, 1.0) - Complex::new(0.0, SAWTOOTH_HARMONIC),
                alpha0,
                force: g.f10,
                constant: alpha0.norm_sqr() - g.f10 * g.f10,
            },
            a3_per_c: if coupling == 0.0 { 0.0 } else { SAWTOOTH_HARMONIC * coupling / impedance },
        })
    }

    /// Slow invariant manifold.
    pub fn manifold(&self) -> &Manifold {
        &self.manifold
    }

    /// Dimensionless groups.
    pub fn groups(&self) -> &Groups {
        &self.groups
    }

    /// Coefficients (a, b, c) of the quadratic a C² + b C + c = 0, docs/theory.md (42) and (44).
    pub fn quadratic(&self) -> (f64, f64, f64) {
        self.quadratic.coefficients()
    }

    /// Discriminant b² - 4ac of the quadratic: zero at the fold, negative without a solution.
    pub fn discriminant(&self) -> f64 {
        self.quadratic.discriminant()
    }

    /// Both fixed points, by C; `None` if the quadratic has no real root. Allocates nothing.
    pub fn fixed_points(&self) -> Option<Roots<FixedPoint>> {
        let roots = self.quadratic.roots()?;
        Some(Roots { lower: self.fixed_point(roots.lower), upper: self.fixed_point(roots.upper) })
    }

    /// Fixed point at amplitude C. Requires a root of the quadratic: only the phase of αC + α₀ is
    /// used, not its modulus.
    fn fixed_point(&self, c: f64) -> FixedPoint {
        let g = &self.groups;
        let m = &self.manifold;
        let force = self.quadratic.balance(c);
        let sign = if g.f10 < 0.0 { -1.0 } else { 1.0 };
        let drive_phase = (sign * force.im).atan2(sign * force.re);
        let impact_phase = m.impact_phase(c);
        let detuning = g.sigma30 - 2.0 * g.sigma1 + self.coupling;
        let eigenvalues = self.eigenvalues(c);
        let multipliers = eigenvalue_pair(m.transition_trace(c), m.kappa() * m.kappa());
        FixedPoint {
            c,
            b: m.b(c),
            a3: self.a3_per_c * c.abs(),
            impact_phase,
            drive_phase,
            psi: drive_phase - impact_phase,
            // docs/theory.md (45); a negative C turns the phase by π.
            psi3: drive_phase - detuning.atan2(g.gamma3) + if c < 0.0 { PI } else { 0.0 },
            branch: m.branch(c),
            admissibility: Admissibility {
                geometric: m.is_geometric(c),
                fixed_point: eigenvalues.iter().all(|e| e.re < 0.0),
                periodic_motion: c > m.c_smin() && c < m.c_smax() && m.kappa() < 1.0,
            },
            eigenvalues,
            multipliers,
            epsilon: g.epsilon,
        }
    }

    /// Force f̂10 = |αC + α₀| ≥ 0 that maintains the motion at amplitude C: docs/theory.md (46).
    pub fn force(&self, c: f64) -> f64 {
        self.quadratic.balance(c).norm()
    }

    /// Ranges of f̂10 with solutions and with an admissible solution, for fixed other groups:
    /// docs/theory.md (46) with the limits (49) and (56) of C.
    ///
    /// # Errors
    /// [`Error::Undefined`] if α = 0 (κ = 1, γ̂1 = 0, σ̂1 = -4/π²), where the force does not
    /// determine the amplitude.
    pub fn force_range(&self) -> Result<ForceRange> {
        let size = self.quadratic.alpha.norm();
        if size == 0.0 {
            return Err(Error::Undefined {
                name: "sigma1",
                value: self.groups.sigma1,
                needed_by: "range of f10",
                allowed: "sigma1 other than -4/pi^2 when kappa = 1 and gamma1 = 0",
            });
        }
        let product = self.quadratic.product();
        let fold = product.im.abs() / size;
        let c_fold = -product.re / (size * size);
        let at_zero = self.quadratic.alpha0.norm(); // C = 0
        let m = &self.manifold;
        let (low, high) = (c_fold.max(m.c_smin()), m.c_smax().min(m.c_gmax()));
        let damped = self.groups.gamma3 > 0.0 && m.kappa() < 1.0;
        let (positive_from, two_until) = if c_fold > 0.0 { (fold, at_zero) } else { (at_zero, at_zero) };
        Ok(ForceRange {
            real_from: fold,
            positive_from,
            two_until,
            admissible: (damped && low < high).then(|| (self.force(low), self.force(high))),
        })
    }
}

impl FixedPoint {
    /// Largest |X1| over a cycle, in units of L: docs/theory.md (47).
    pub fn a1(&self) -> f64 {
        // X1 = B sin η - eC(1 - 2s/π) with e = ε - ε² and η = s + Φ over s ∈ [0, π] has extrema
        // where B cos η = -2eC/π.
        let (_, e) = inverse_mass_factors(self.epsilon);
        let (b, c, phase) = (self.b, self.c, self.impact_phase);
        let mut best = (b * phase.sin() - e * c).abs();
        let q = -2.0 * e * c / (PI * b);
        if q.abs() <= 1.0 {
            for eta in [q.acos(), -q.acos()] {
                let s = (eta - phase).rem_euclid(2.0 * PI);
                if s <= PI {
                    best = best.max((b * eta.sin() - e * c * (1.0 - 2.0 * s / PI)).abs());
                }
            }
        }
        best
    }

    /// Largest |X2| over a cycle, (1-ε+ε²) |C|, in units of L: docs/theory.md (47).
    pub fn a2(&self) -> f64 {
        inverse_mass_factors(self.epsilon).0 * self.c.abs()
    }

    /// Largest modulus of the half-cycle multipliers.
    pub fn spectral_radius(&self) -> f64 {
        spectral_radius(self.multipliers)
    }

    /// Bifurcation that the largest multiplier indicates.
    pub fn bifurcation(&self) -> Bifurcation {
        Bifurcation::of(largest(self.multipliers))
    }
}
