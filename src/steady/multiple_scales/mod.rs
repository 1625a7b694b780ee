//! Multiple scales with the sawtooth function (paper sections 3–4, model.md section 4).
//!
//! With η = Ω1 τ - ψ and Z the sawtooth, the steady state is U ≈ B sin η, X2 ≈ (1-ε+ε²) C Z(η-Φ),
//! X1 ≈ B sin η - (ε-ε²) C Z(η-Φ), X3 ≈ A3 sin(Ω1 τ - ψ3). Each fixed point of the slow flow is a root of a C² + b C + c = 0
//! (29)–(31). The error is O(ε) in every amplitude.
//!
//! Past the paper: on the manifold the second test has a closed form too. With m = (1+ρ²)C - 1 the block (B, ψ) of
//! the Jacobian has the trace -γ̂1 - (8/π²) ρ C/m and the determinant (aC + b/2)/(4m), and the block (A3, ψ3) the
//! eigenvalues -γ̂3/2 ± i(σ̂30 - 2σ̂1 + α̂23)/2. On the right branch, then, exactly the upper root is stable.

mod manifold;
mod motion;
mod slow_flow;

pub use manifold::{Branch, Manifold, sawtooth, sawtooth_slope};
pub use slow_flow::SlowState;

use super::circle_roots;
use super::{Admissibility, Bifurcation, Roots, check_groups, eigenvalue_pair};
use crate::error::{Error, Result};
use crate::parameters::Groups;
use nalgebra::Complex;
use std::f64::consts::PI;

/// 8/π²: the first Fourier coefficient of the sawtooth.
const C8: f64 = 8.0 / (PI * PI);

/// A resistance this much smaller than its terms is zero but for rounding.
const RESONANCE: f64 = 1e-14;

/// The slow flow of one parameter set, with everything that does not depend on the root prepared. The coupling
/// α̂23 is taken as μ13 β², which equals [`Groups::alpha23`] for the paper's m3 = m2 and stays right for other m3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MultipleScales {
    groups: Groups,
    manifold: Manifold,
    /// α̂23 as the secondary oscillator feels it.
    alpha23: f64,
    /// f̂ e^{iδ} = αC + α₀ where δ is the phase of the force at the upper impact.
    alpha: Complex<f64>,
    alpha0: Complex<f64>,
    /// A3/C (31).
    a3_per_c: f64,
}

/// One fixed point of the slow flow, with its three tests. Amplitudes in units of L, phases in rad, eigenvalues
/// in units of the slow time τ1 = ετ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedPoint {
    /// C, the amplitude of the block's sawtooth.
    pub c: f64,
    /// B, the amplitude of U.
    pub b: f64,
    /// A3, the amplitude of X3.
    pub a3: f64,
    /// Φ: the block meets the upper stop at η = Φ.
    pub impact_phase: f64,
    /// δ = Φ + ψ: phase of the force when the block meets the upper stop, in (-π, π].
    pub drive_phase: f64,
    /// ψ: η = Ω1 τ - ψ.
    pub psi: f64,
    /// ψ3: X3 = A3 sin(Ω1 τ - ψ3).
    pub psi3: f64,
    /// The branch of the manifold.
    pub branch: Branch,
    /// The three tests.
    pub admissibility: Admissibility,
    /// Eigenvalues of the slow flow's Jacobian: of the block (B, ψ), then of (A3, ψ3).
    pub eigenvalues: [Complex<f64>; 4],
    /// Half-cycle multipliers of the periodic motion: the eigenvalues of D.
    pub multipliers: [Complex<f64>; 2],
    epsilon: f64,
}

/// For which amplitude f̂10 ≥ 0 of the force the quadratic has solutions, everything else held. Unit 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceRange {
    /// The fold: real roots from here on.
    pub real_from: f64,
    /// A root C > 0 from here on, without end.
    pub positive_from: f64,
    /// Two roots C > 0 up to here; equal to `positive_from` when there is never more than one.
    pub two_until: f64,
    /// The interval in which a root passes all three tests, if there is one; its lower end is excluded.
    pub admissible: Option<(f64, f64)>,
}

/// Both fixed points of the slow flow, by C; `None` when the quadratic has no real root.
///
/// # Errors
/// As [`MultipleScales::new`].
pub fn fixed_points(groups: &Groups) -> Result<Option<Roots<FixedPoint>>> {
    Ok(MultipleScales::new(groups)?.fixed_points())
}

impl MultipleScales {
    /// Prepares the slow flow of the groups.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a group outside its range (NaN too); [`Error::Undefined`] when γ̂3 = 0 and
    /// σ̂30 - 2σ̂1 + α̂23 = 0, where A3 has no bound.
    pub fn new(groups: &Groups) -> Result<Self> {
        check_groups(groups)?;
        let g = *groups;
        let manifold = Manifold::new(g.kappa)?;
        let rho = manifold.rho();
        let alpha23 = g.mu13 * g.beta2;
        let detuning = g.sigma30 - 2.0 * g.sigma1 + alpha23;
        let resistance = g.gamma3.hypot(detuning);
        let terms = g.sigma30.abs() + 2.0 * g.sigma1.abs() + alpha23;
        if alpha23 > 0.0 && resistance <= RESONANCE * terms {
            return Err(Error::Undefined {
                name: "gamma3",
                value: g.gamma3,
                needed_by: "amplitude A3 at resonance",
                allowed: "gamma3 > 0 where sigma30 - 2 sigma1 + alpha23 = 0",
            });
        }
        let s = Complex::new(-2.0 * g.sigma1, g.gamma1);
        Ok(Self {
            groups: g,
            manifold,
            alpha23,
            alpha: s * Complex::new(-rho, 1.0) - Complex::new(0.0, C8),
            alpha0: Complex::new(s.im, -s.re),
            a3_per_c: if alpha23 == 0.0 { 0.0 } else { C8 * alpha23 / resistance },
        })
    }

    /// The slow invariant manifold.
    pub fn manifold(&self) -> &Manifold {
        &self.manifold
    }

    /// The groups.
    pub fn groups(&self) -> &Groups {
        &self.groups
    }

    /// Coefficients (a, b, c) of the quadratic a C² + b C + c = 0 (30).
    pub fn quadratic(&self) -> (f64, f64, f64) {
        let f = self.groups.f10;
        let cross = (self.alpha * self.alpha0.conj()).re;
        (self.alpha.norm_sqr(), 2.0 * cross, self.alpha0.norm_sqr() - f * f)
    }

    /// Discriminant b² - 4ac of the quadratic: zero at the fold, negative without solutions.
    pub fn discriminant(&self) -> f64 {
        let reach = self.alpha.norm() * self.groups.f10.abs();
        let turn = (self.alpha * self.alpha0.conj()).im.abs();
        4.0 * (reach - turn) * (reach + turn)
    }

    /// Both fixed points, by C; `None` when the quadratic has no real root. Allocates nothing.
    pub fn fixed_points(&self) -> Option<Roots<FixedPoint>> {
        let (a, b, c) = self.quadratic();
        let turn = (self.alpha * self.alpha0.conj()).im;
        let roots = circle_roots(a, 0.5 * b, turn, c, self.groups.f10)?;
        Some(Roots { lower: self.at(roots.lower), upper: self.at(roots.upper) })
    }

    /// The point of the manifold at C as if the force were just right for it.
    fn at(&self, c: f64) -> FixedPoint {
        let g = &self.groups;
        let m = &self.manifold;
        let force = self.alpha * c + self.alpha0;
        let sign = if g.f10 < 0.0 { -1.0 } else { 1.0 };
        let drive_phase = (sign * force.im).atan2(sign * force.re);
        let impact_phase = m.impact_phase(c);
        let detuning = g.sigma30 - 2.0 * g.sigma1 + self.alpha23;
        let eigenvalues = self.eigenvalues(c);
        let multipliers = eigenvalue_pair(m.transition_trace(c), m.kappa() * m.kappa());
        FixedPoint {
            c,
            b: m.b(c),
            a3: self.a3_per_c * c.abs(),
            impact_phase,
            drive_phase,
            psi: drive_phase - impact_phase,
            // χ = ψ - ψ3 + Φ; a negative C turns the phase round.
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

    /// The force f̂10 ≥ 0 that holds the motion at amplitude C: |αC + α₀|.
    pub fn force(&self, c: f64) -> f64 {
        (self.alpha * c + self.alpha0).norm()
    }

    /// The ranges of f̂10 with solutions and with an admissible one, all other groups held (model.md section 9).
    ///
    /// # Errors
    /// [`Error::Undefined`] where α = 0 (κ = 1, γ̂1 = 0, σ̂1 = -4/π²): the force does not decide the amplitude.
    pub fn force_range(&self) -> Result<ForceRange> {
        let size = self.alpha.norm();
        if size == 0.0 {
            return Err(Error::Undefined {
                name: "sigma1",
                value: self.groups.sigma1,
                needed_by: "range of f10",
                allowed: "sigma1 other than -4/pi^2 when kappa = 1 and gamma1 = 0",
            });
        }
        let product = self.alpha * self.alpha0.conj();
        let fold = product.im.abs() / size;
        let vertex = -product.re / (size * size);
        let zero = self.alpha0.norm(); // C = 0
        let m = &self.manifold;
        let (low, high) = (vertex.max(m.c_smin()), m.c_smax().min(m.c_gmax()));
        let damped = self.groups.gamma3 > 0.0 && m.kappa() < 1.0;
        let (positive_from, two_until) = if vertex > 0.0 { (fold, zero) } else { (zero, zero) };
        Ok(ForceRange {
            real_from: fold,
            positive_from,
            two_until,
            admissible: (damped && low < high).then(|| (self.force(low), self.force(high))),
        })
    }
}

impl FixedPoint {
    /// Amplitude of X1, its largest |value| over a cycle, in units of L.
    pub fn a1(&self) -> f64 {
        // X1 = B sin θ - eC(1 - 2s/π), θ = s + Φ, over s ∈ [0, π]; turning points where B cos θ = -2eC/π.
        let e = self.epsilon - self.epsilon * self.epsilon;
        let (b, c, phase) = (self.b, self.c, self.impact_phase);
        let mut best = (b * phase.sin() - e * c).abs();
        let q = -2.0 * e * c / (PI * b);
        if q.abs() <= 1.0 {
            for theta in [q.acos(), -q.acos()] {
                let s = (theta - phase).rem_euclid(2.0 * PI);
                if s <= PI {
                    best = best.max((b * theta.sin() - e * c * (1.0 - 2.0 * s / PI)).abs());
                }
            }
        }
        best
    }

    /// Amplitude of X2, (1-ε+ε²) |C|, in units of L.
    pub fn a2(&self) -> f64 {
        (1.0 - self.epsilon + self.epsilon * self.epsilon) * self.c.abs()
    }

    /// Largest modulus of the half-cycle multipliers.
    pub fn spectral_radius(&self) -> f64 {
        self.multipliers[0].norm().max(self.multipliers[1].norm())
    }

    /// The bifurcation that the largest multiplier announces.
    pub fn bifurcation(&self) -> Bifurcation {
        let [first, second] = self.multipliers;
        Bifurcation::of(if first.norm_sqr() >= second.norm_sqr() { first } else { second })
    }
}
