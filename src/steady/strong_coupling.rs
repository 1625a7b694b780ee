//! Strong coupling and comparable masses (paper, section 5) in closed form (docs/theory.md,
//! section 8; not in the paper).
//!
//! If β² = k23/(m2 ω10²) and μ13 = m1/m3 are of order one, the block swings on its spring between
//! the stops: the modified sawtooth Z*, docs/theory.md (59), takes the place of the sawtooth, and
//! X3 moves the block. A quantity with the phasor z is Im(z e^{is}), where s is the phase since
//! the impact at the upper stop. In phasors the impact law and the balance of harmonics give a
//! quadratic in C, (63) and (64). At β = 0 this is [`multiple_scales`](super::multiple_scales).
//!
//! All three tests have a closed form or a small matrix:
//! - geometric: |W| ≤ 1 by (68), and νC > 0, so that the block moves *into* the stop. For 1 < β < 2
//!   that means C < 0.
//! - fixed point: the eigenvalues of the slow flow of the phasors, (65) and (66).
//! - periodic motion: the half-cycle map of the block with U and X3 held, (67).

use super::multiple_scales::{sawtooth, sawtooth_slope};
use super::{
    Admissibility, Bifurcation, EIGENVALUE_SWEEPS, IMPEDANCE_ROUNDING, PENETRATION_ROUNDING, Quadratic,
    Roots, SteadyMotion, check_groups, eigenvalue_pair, inverse_mass_factors, largest, spectral_radius,
};
use crate::error::{Error, Result};
use crate::parameters::Groups;
use nalgebra::{Complex, Matrix2, Matrix4};
use std::f64::consts::{FRAC_PI_2, PI};
use vibro_numerics::bernstein::{DEGREE, Polynomial, RATE_STEP, add_sine, raise_to_maximum, stays_within};

/// Distance of β from a positive integer below which groups are refused, because C would lose more
/// than half of its digits.
const INTEGER_DISTANCE: f64 = 1e-7;

/// Limit of β up to which the sawtooth Z replaces the modified sawtooth Z*. The two differ by
/// terms of order β², which are under round-off.
const SAWTOOTH_BETA: f64 = 1e-8;

/// Upper limit of β; the approximation assumes that β is of order one.
const LARGEST_BETA: f64 = 1e3;

/// Modified sawtooth Z*(s) = sin(β (π/2) Z(s))/sin(β π/2) of period 2π, docs/theory.md (59), and
/// its derivative. At a kink the derivative is the value just after it. For β = 0 it is the
/// sawtooth Z. It is singular at even β > 0.
pub fn modified_sawtooth(beta: f64, s: f64) -> (f64, f64) {
    let (z, slope) = (sawtooth(s), sawtooth_slope(s));
    if beta < SAWTOOTH_BETA {
        return (z, slope);
    }
    let size = (beta * FRAC_PI_2).sin();
    let (sin, cos) = (beta * FRAC_PI_2 * z).sin_cos();
    (sin / size, beta * FRAC_PI_2 * slope * cos / size)
}

/// Closed form of one parameter set, with all quantities that do not depend on the root.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrongCoupling {
    groups: Groups,
    beta: f64,
    /// ν of docs/theory.md (60).
    nu: f64,
    /// ρ* of docs/theory.md (60).
    rho: f64,
    /// q of docs/theory.md (60).
    q: f64,
    /// c₁ of docs/theory.md (60).
    c1: f64,
    /// ξ of docs/theory.md (62): the phasor of X3 per C.
    xi: Complex<f64>,
    /// f̂ e^{iδ} = αC + α₀ with the phase δ of the force at the upper impact, docs/theory.md (64).
    quadratic: Quadratic,
}

/// Steady state with its three tests. Amplitudes are in units of L, phases in rad, eigenvalues per
/// unit of the slow time τ1 = ετ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrongPoint {
    /// C, the factor of Z*. In an admissible state it has the sign of ν.
    pub c: f64,
    /// B, the amplitude of U.
    pub b: f64,
    /// A3, the amplitude of X3.
    pub a3: f64,
    /// δ, the phase of the force when the block meets the upper stop, in (-π, π].
    pub drive_phase: f64,
    /// Phasor y of U since the upper impact, docs/theory.md (63): U = Im(u e^{is}).
    pub u: Complex<f64>,
    /// Phasor y₃ of X3, docs/theory.md (62): X3 = Im(x3 e^{is}).
    pub x3: Complex<f64>,
    /// The three tests.
    pub admissibility: Admissibility,
    /// Eigenvalues of the slow flow's Jacobian.
    pub eigenvalues: [Complex<f64>; 4],
    /// Half-cycle multipliers of impact phase and block speed.
    pub multipliers: [Complex<f64>; 2],
    model: StrongCoupling,
}

/// Both steady states, by C; `None` if the quadratic has no real root.
///
/// # Errors
/// As [`StrongCoupling::new`] and [`StrongCoupling::solutions`].
pub fn solve(groups: &Groups) -> Result<Option<Roots<StrongPoint>>> {
    StrongCoupling::new(groups)?.solutions()
}

impl StrongCoupling {
    /// Closed form for a set of groups.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if a group is outside its range or NaN; [`Error::Undefined`] if β is
    /// within 1e-7 of 1, 2, 3, … (the block resonates with a harmonic of its impacts), if β is
    /// above 1000, or if X3 is undamped and at resonance.
    pub fn new(groups: &Groups) -> Result<Self> {
        check_groups(groups)?;
        let g = *groups;
        let beta = g.beta2.sqrt();
        let undefined = |name, value, allowed| {
            Err(Error::Undefined { name, value, needed_by: "strong-coupling approximation", allowed })
        };
        if beta > LARGEST_BETA || (beta > 0.5 && (beta - beta.round()).abs() < INTEGER_DISTANCE) {
            return undefined("beta", beta, "0 <= beta <= 1000, not an integer other than 0");
        }
        let (nu, c1) = slopes(beta);
        let rho = nu * (1.0 - g.kappa) / (1.0 + g.kappa);
        // β² - 1 as a product, which is accurate near β = 1.
        let off = (beta - 1.0) * (beta + 1.0);
        let (q, coupling) = (g.beta2 / off, g.mu13 * g.beta2);
        let impedance = Complex::new(g.sigma30 - 2.0 * g.sigma1 - coupling / off, g.gamma3);
        let xi = match coupling {
            0.0 => Complex::new(0.0, 0.0),
            _ => Complex::new(0.0, coupling * c1) / impedance,
        };
        let terms = g.sigma30.abs() + 2.0 * g.sigma1.abs() + (coupling / off).abs();
        if coupling > 0.0 && impedance.norm() <= IMPEDANCE_ROUNDING * terms {
            return undefined("gamma3", g.gamma3, "gamma3 > 0 where the secondary oscillator resonates");
        }
        let s = Complex::new(-2.0 * g.sigma1, g.gamma1);
        let per_c = Complex::new(-rho, 1.0) + q * xi;
        let alpha0 = Complex::new(s.im, -s.re);
        let quadratic = Quadratic {
            alpha: s * per_c - Complex::new(0.0, 4.0 / PI * nu),
            alpha0,
            force: g.f10,
            constant: alpha0.norm_sqr() - g.f10 * g.f10,
        };
        Ok(Self { groups: g, beta, nu, rho, q, c1, xi, quadratic })
    }

    /// β = √(k23/m2)/ω10.
    pub fn beta(&self) -> f64 {
        self.beta
    }

    /// ν = β cot(βπ/2), docs/theory.md (60): half the jump of Z*' at a kink, negative for 1 < β <
    /// 2.
    pub fn nu(&self) -> f64 {
        self.nu
    }

    /// ρ* = ν(1-κ)/(1+κ), docs/theory.md (60).
    pub fn rho(&self) -> f64 {
        self.rho
    }

    /// Slow invariant manifold, docs/theory.md (63): |u - q x3| = √((C-1)² + ρ*²C²) as a function
    /// of C.
    pub fn manifold(&self, c: f64) -> f64 {
        (c - 1.0).hypot(self.rho * c)
    }

    /// Coefficients (a, b, c) of the quadratic a C² + b C + c = 0, docs/theory.md (44) and (64).
    pub fn quadratic(&self) -> (f64, f64, f64) {
        self.quadratic.coefficients()
    }

    /// Discriminant b² - 4ac of the quadratic: zero at the fold, negative without a solution.
    pub fn discriminant(&self) -> f64 {
        self.quadratic.discriminant()
    }

    /// Both steady states, by C; `None` if the quadratic has no real root.
    ///
    /// # Errors
    /// [`Error::NoConvergence`] if the eigenvalues of the slow flow are not found.
    pub fn solutions(&self) -> Result<Option<Roots<StrongPoint>>> {
        let Some(roots) = self.quadratic.roots() else { return Ok(None) };
        Ok(Some(Roots { lower: self.steady_state(roots.lower)?, upper: self.steady_state(roots.upper)? }))
    }

    /// Steady state at the root C of the quadratic.
    fn steady_state(&self, c: f64) -> Result<StrongPoint> {
        let g = &self.groups;
        let force = self.quadratic.balance(c) * if g.f10 < 0.0 { -1.0 } else { 1.0 };
        let u = c * (Complex::new(-self.rho, 1.0) + self.q * self.xi) - Complex::new(0.0, 1.0);
        let eigenvalues = self.eigenvalues(c)?;
        let multipliers = self.multipliers(c);
        let mut point = StrongPoint {
            c,
            b: u.norm(),
            a3: (self.xi * c).norm(),
            drive_phase: force.im.atan2(force.re),
            u,
            x3: self.xi * c,
            admissibility: Admissibility {
                geometric: false,
                fixed_point: eigenvalues.iter().all(|e| e.re < 0.0),
                periodic_motion: multipliers.iter().all(|m| m.norm_sqr() < 1.0),
            },
            eigenvalues,
            multipliers,
            model: *self,
        };
        point.admissibility.geometric = self.nu * c > 0.0 && point.is_clear();
        Ok(point)
    }

    /// Jacobian of the slow flow of (Re u, Im u, Re x3, Im x3) in the frame of the impact's phase,
    /// docs/theory.md (65) and (66).
    fn jacobian(&self, c: f64) -> Matrix4<f64> {
        let (g, rho, q) = (&self.groups, self.rho, self.q);
        let coupling = g.mu13 * g.beta2;
        // The matrix P of docs/theory.md (66): C and δ follow the impact law.
        let slope = (1.0 + rho * rho) * c - 1.0;
        let p = Matrix2::new(rho * c, 1.0 - c, c, rho * c) / -slope;
        let complex = |re: f64, im: f64| Matrix2::new(re, -im, im, re);
        let off = (self.beta - 1.0) * (self.beta + 1.0);
        let own = -(g.sigma1 - 0.5 * g.sigma30 + 0.5 * coupling / off);
        let (drive, swing) = (2.0 / PI * self.nu, 0.5 * coupling * self.c1);
        let mut jacobian = Matrix4::zeros();
        jacobian.fixed_view_mut::<2, 2>(0, 0).copy_from(&(complex(-0.5 * g.gamma1, -g.sigma1) + p * drive));
        jacobian.fixed_view_mut::<2, 2>(0, 2).copy_from(&(p * (-q * drive)));
        jacobian.fixed_view_mut::<2, 2>(2, 0).copy_from(&(p * swing));
        jacobian.fixed_view_mut::<2, 2>(2, 2).copy_from(&(complex(-0.5 * g.gamma3, own) - p * (q * swing)));
        jacobian
    }

    /// Eigenvalues of the slow flow at the root C.
    fn eigenvalues(&self, c: f64) -> Result<[Complex<f64>; 4]> {
        let jacobian = self.jacobian(c);
        let lost = Error::NoConvergence { what: "eigenvalues of the slow flow" };
        if jacobian.iter().any(|x| !x.is_finite()) {
            return Err(lost);
        }
        // The sweeps compare entries with the diagonal. If the diagonal is zero, as without
        // dampers and losses, the sweeps do not end, and a shift of the diagonal makes them end.
        let found = [0.0, jacobian.norm()].into_iter().find_map(|by| {
            let moved = jacobian + Matrix4::identity() * by;
            let values = moved.try_schur(f64::EPSILON, EIGENVALUE_SWEEPS)?.complex_eigenvalues();
            Some(values.map(|value| value - by))
        });
        Ok(found.ok_or(lost)?.into())
    }

    /// Half-cycle multipliers at the root C, docs/theory.md (67).
    fn multipliers(&self, c: f64) -> [Complex<f64>; 2] {
        let (kappa, beta) = (self.groups.kappa, self.beta);
        let k = 1.0 + kappa;
        let x3 = self.xi.im * c;
        let x2 = c + self.q * x3;
        let acceleration = self.groups.beta2 * (x3 - x2) + x2 - 1.0;
        let span = if beta < SAWTOOTH_BETA { PI } else { (PI * beta).sin() / beta };
        let trace = 2.0 * kappa * (PI * beta).cos() - k * k * acceleration / (2.0 * self.nu * c) * span;
        eigenvalue_pair(trace, kappa * kappa)
    }
}

/// ν = β cot(βπ/2) and c₁ = (4/π) ν/(1-β²), docs/theory.md (60), without cancellation at β = 0 and
/// β = 1.
fn slopes(beta: f64) -> (f64, f64) {
    let x = beta * FRAC_PI_2;
    if beta == 0.0 {
        return (2.0 / PI, 8.0 / (PI * PI));
    }
    let t = beta - 1.0;
    if t.abs() < 0.5 {
        let tangent = (t * FRAC_PI_2).tan();
        return (-beta * tangent, 4.0 / PI * beta * tangent / (t * (1.0 + beta)));
    }
    let nu = beta / x.tan();
    (nu, -4.0 / PI * nu / (t * (1.0 + beta)))
}

impl StrongPoint {
    /// U, W, X1, X2, X3 and their derivatives at the phase s (rad) since the impact at the upper
    /// stop.
    pub fn motion(&self, s: f64) -> SteadyMotion {
        let (z, dz) = modified_sawtooth(self.model.beta, s);
        let turn = Complex::cis(s);
        let (u, x3) = (self.u * turn, self.x3 * turn);
        // docs/theory.md (61).
        let block = (self.c * z + self.model.q * x3.im, self.c * dz + self.model.q * x3.re);
        SteadyMotion::new(self.model.groups.epsilon, (u.im, u.re), block, (x3.im, x3.re))
    }

    /// Motion at the phase Ω1 τ of the drive (rad), where the force is f̂10 sin(Ω1 τ).
    pub fn motion_at_drive(&self, drive_phase: f64) -> SteadyMotion {
        self.motion(drive_phase - self.drive_phase)
    }

    /// C Z* + Im(z e^{is}) as polynomials over the half period after the upper impact.
    fn pieces(&self, c: f64, z: Complex<f64>) -> impl Iterator<Item = Polynomial> + use<> {
        let beta = self.model.beta;
        let count = (PI * beta.max(1.0) / RATE_STEP).ceil();
        let h = PI / count;
        // At most a few thousand pieces, since β ≤ 1000.
        (0..count as u32).map(move |i| {
            let s = f64::from(i) * h;
            let mut p = [0.0; DEGREE + 1];
            if beta < SAWTOOTH_BETA {
                p[0] = c * (1.0 - 2.0 * s / PI);
                p[1] = -2.0 * c * h / PI;
            } else {
                let x = beta * FRAC_PI_2;
                add_sine(&mut p, c / x.sin(), -beta * h, x - beta * s);
            }
            add_sine(&mut p, z.im, h, s + FRAC_PI_2);
            add_sine(&mut p, z.re, h, s);
            p
        })
    }

    /// Whether |W| ≤ 1 over the cycle up to round-off, proved by Bernstein bounds: docs/theory.md
    /// (68).
    fn is_clear(&self) -> bool {
        let limit = 1.0 + PENETRATION_ROUNDING;
        self.pieces(self.c, self.model.q * self.x3 - self.u).all(|w| stays_within(&w, -limit, limit))
    }

    /// Largest |C Z* + Im(z e^{is})| over a cycle.
    fn amplitude(&self, c: f64, z: Complex<f64>) -> f64 {
        let mut best = 0.0;
        self.pieces(c, z).for_each(|p| raise_to_maximum(&p, &mut best));
        best
    }

    /// Largest |X1| over a cycle, in units of L: an exact extremum.
    pub fn a1(&self) -> f64 {
        let (_, box_share) = inverse_mass_factors(self.model.groups.epsilon);
        self.amplitude(-box_share * self.c, self.u - box_share * self.model.q * self.x3)
    }

    /// Largest |X2| over a cycle, in units of L: an exact extremum.
    pub fn a2(&self) -> f64 {
        let (block, _) = inverse_mass_factors(self.model.groups.epsilon);
        block * self.amplitude(self.c, self.model.q * self.x3)
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
