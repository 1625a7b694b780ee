//! Flight between impacts in units of L and of the drive's phase (docs/theory.md, section 9):
//! Taylor pieces, exact to round-off, and the transition matrices made from them.

use crate::error::{Error, Result};
use crate::parameters::Parameters;
use nalgebra::{Complex, Matrix2, Matrix4, Vector2, Vector4};
use std::f64::consts::PI;
use vibro_numerics::bernstein::{DEGREE, Polynomial, RATE_STEP, evaluate};

/// A state (x1, x2, x3, v1, v2, v3) in units of L and ω1 L.
pub type Vector6 = nalgebra::Vector6<f64>;

/// Largest number of Taylor pieces in half a period. If a mode is so much faster than the drive
/// that it needs more, the work would be too large and the orbit too sensitive.
const MOST_PIECES: u32 = 1 << 16;

/// Resonance limit of the response, in units of L per unit of impulse or force. Above it
/// cancellation leaves the amplitudes fewer than four digits.
const LARGEST_RESPONSE: f64 = 1e12;

/// 1/((k+1)(k+2)).
const INVERSE: [f64; DEGREE + 1] = {
    let mut table = [0.0; DEGREE + 1];
    let mut k = 0;
    while k <= DEGREE {
        table[k] = 1.0 / ((k + 1) * (k + 2)) as f64;
        k += 1;
    }
    table
};

/// Coefficients of the flight, docs/theory.md (69), where a prime is a derivative with respect to
/// the drive's phase θ and lengths are in L:
///
/// ```text
/// x1'' = -k1 x1 - c1 x1' + F sin θ
/// x2'' = -k2 (x2 - x3)
/// x3'' = -k3 x3 - c3 x3' - k32 (x3 - x2)
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flight {
    /// κ₁ of docs/theory.md (69).
    pub k1: f64,
    /// d₁.
    pub c1: f64,
    /// κ₂.
    pub k2: f64,
    /// κ₃.
    pub k3: f64,
    /// d₃.
    pub c3: f64,
    /// κ₃₂.
    pub k32: f64,
    /// F.
    pub force: f64,
    /// ε = m2/m1.
    pub epsilon: f64,
    /// Restitution coefficient.
    pub kappa: f64,
    /// Bound on the rates of the modes and of the drive, in units of ω1.
    pub rate: f64,
    /// Taylor pieces in half a period, a power of two.
    pub pieces: u32,
    /// Changes of v1 and v2 at an impact per unit of w'⁻, docs/theory.md (27).
    pub(super) kick: [f64; 2],
}

/// Transition matrix exp(A Δ) of free flight over a span Δ of the phase, as two blocks, since in
/// flight the box and the other two bodies do not act on each other.
///
/// ```
/// use vibro_impact::{Parameters, steady::exact_orbit::{Flight, Vector6}};
///
/// let flight = Flight::new(&Parameters::default())?;
/// let state = Vector6::new(0.1, 0.2, 0.3, 0.4, 0.5, 0.6);
/// let twice = flight.transition(0.7).apply(&flight.transition(0.7).apply(&state));
/// assert!((flight.transition(1.4).apply(&state) - twice).norm() < 1e-14);
/// # Ok::<(), vibro_impact::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Transition {
    /// Matrix of the box, on (x1, v1).
    pub one: Matrix2<f64>,
    /// Matrix of block and secondary oscillator, on (x2, x3, v2, v3).
    pub pair: Matrix4<f64>,
}

impl Transition {
    /// State a span later, without the drive.
    #[inline]
    pub fn apply(&self, s: &Vector6) -> Vector6 {
        let one = self.one * Vector2::new(s[0], s[3]);
        let pair = self.pair * Vector4::new(s[1], s[2], s[4], s[5]);
        Vector6::new(one[0], pair[0], pair[1], one[1], pair[2], pair[3])
    }
}

/// Flight over half a period and its periodic response to alternating unit impulses,
/// docs/theory.md (72).
#[derive(Clone, Copy, Debug)]
pub(super) struct HalfPeriod {
    /// M = exp(πA).
    pub map: Transition,
    /// G⁺ = (I+M)⁻¹ g.
    pub after: Vector6,
}

impl Flight {
    /// Flight for a set of parameters.
    ///
    /// # Errors
    /// As [`Parameters::validate`]; [`Error::Undefined`] if the drive frequency is zero;
    /// [`Error::PrecisionLost`] if a mode is more than about 15,000 times faster than the drive.
    pub fn new(p: &Parameters) -> Result<Self> {
        p.validate()?;
        let w = p.drive_frequency;
        if w == 0.0 {
            return Err(Error::Undefined {
                name: "drive.frequency",
                value: w,
                needed_by: "exact orbit",
                allowed: "drive.frequency > 0",
            });
        }
        let (m1, m2, m3) = (p.box_mass, p.block_mass, p.secondary_mass);
        let mut flight = Self {
            k1: p.box_stiffness / m1 / w / w,
            c1: p.box_damping / m1 / w,
            k2: p.coupling_stiffness / m2 / w / w,
            k3: p.secondary_stiffness / m3 / w / w,
            c3: p.secondary_damping / m3 / w,
            k32: p.coupling_stiffness / m3 / w / w,
            force: p.drive_amplitude / m1 / p.stop_gap / w / w,
            epsilon: m2 / m1,
            kappa: p.stop_restitution,
            rate: 1.0,
            pieces: 1,
            kick: [0.0; 2],
        };
        let k = (1.0 + flight.kappa) / (1.0 + flight.epsilon);
        flight.kick = [k * flight.epsilon, -k];
        // Bounds on the norm of A with velocities scaled by the root of the stiffness; the drive
        // itself has the rate 1.
        let box_rate = flight.k1.sqrt() + flight.c1;
        let pair_rate = (flight.k2 + flight.k3 + flight.k32).sqrt() + flight.c3;
        let rate = box_rate.max(pair_rate).max(1.0);
        let limit = f64::from(MOST_PIECES) * RATE_STEP / PI;
        let numbers = [rate, flight.force, flight.epsilon];
        if rate > limit || numbers.iter().any(|x| !x.is_finite()) {
            return Err(Error::PrecisionLost {
                what: "rate of the fastest mode over drive.frequency",
                value: rate,
                limit,
            });
        }
        flight.rate = rate;
        flight.pieces = flight.doubled_pieces(PI);
        Ok(flight)
    }

    /// Necessary number of Taylor pieces for a span of the phase: the smallest sufficient power of
    /// two.
    fn doubled_pieces(&self, span: f64) -> u32 {
        let mut pieces = 1;
        while span * self.rate > RATE_STEP * f64::from(pieces) && pieces < 1 << 31 {
            pieces *= 2;
        }
        pieces
    }

    /// Smallest number of equal Taylor pieces of a span of the phase, each exact to round-off.
    pub fn least_pieces(&self, span: f64) -> u32 {
        (span * self.rate / RATE_STEP).ceil().max(1.0) as u32
    }

    /// exp(A Δ) over a span Δ ≥ 0 of the phase, exact to round-off: one Taylor piece, squared
    /// repeatedly.
    pub fn transition(&self, span: f64) -> Transition {
        if span == 0.0 {
            // A piece of length zero has no rates, because these are derivatives divided by the
            // length.
            return Transition { one: Matrix2::identity(), pair: Matrix4::identity() };
        }
        let pieces = self.doubled_pieces(span);
        let h = span / f64::from(pieces);
        let free = |i: usize, j: Option<usize>| {
            let mut s = Vector6::zeros();
            s[i] = 1.0;
            j.into_iter().for_each(|j| s[j] = 1.0);
            Self::state(&self.piece(&s, 0.0, h, 0.0), 1.0, h)
        };
        // One piece gives a column of the box and one of the other two bodies, which do not act on
        // each other in flight.
        let columns = [free(0, Some(1)), free(2, None), free(3, Some(4)), free(5, None)];
        let mut one = Matrix2::new(columns[0][0], columns[2][0], columns[0][3], columns[2][3]);
        let mut pair = Matrix4::from_fn(|row, column| columns[column][[1, 2, 4, 5][row]]);
        for _ in 0..pieces.trailing_zeros() {
            one *= one;
            pair *= pair;
        }
        Transition { one, pair }
    }

    /// Length of one Taylor piece of half a period.
    pub fn step(&self) -> f64 {
        PI / f64::from(self.pieces)
    }

    /// x1, x2, x3 over [phase, phase + h] as polynomials in t ∈ [0, 1], from the state `s` at
    /// `phase`, with the force `force` sin θ; [`least_pieces`](Self::least_pieces) limits h. The
    /// coefficients follow order by order from the equations of motion, as in docs/theory.md (8).
    pub fn piece(&self, s: &Vector6, phase: f64, h: f64, force: f64) -> [Polynomial; 3] {
        let (sin, cos) = if force == 0.0 { (0.0, 0.0) } else { phase.sin_cos() };
        let h2 = h * h;
        let (mut wave, mut next_wave) = (force * sin * h2, force * cos * h * h2);
        let mut x = [[0.0; DEGREE + 1]; 3];
        for i in 0..3 {
            x[i][0] = s[i];
            x[i][1] = s[i + 3] * h;
        }
        let (k1, c1) = (self.k1 * h2, self.c1 * h);
        let (k2, k3, c3, k32) = (self.k2 * h2, self.k3 * h2, self.c3 * h, self.k32 * h2);
        for k in 0..DEGREE - 1 {
            let order = (k + 1) as f64;
            let stretch = x[1][k] - x[2][k];
            x[0][k + 2] = (wave - k1 * x[0][k] - c1 * order * x[0][k + 1]) * INVERSE[k];
            x[1][k + 2] = -k2 * stretch * INVERSE[k];
            x[2][k + 2] = (k32 * stretch - k3 * x[2][k] - c3 * order * x[2][k + 1]) * INVERSE[k];
            (wave, next_wave) = (next_wave, -h2 * wave * INVERSE[k]);
        }
        x
    }

    /// State at t ∈ [0, 1] of a piece of length h.
    pub fn state(x: &[Polynomial; 3], t: f64, h: f64) -> Vector6 {
        let [(x1, v1), (x2, v2), (x3, v3)] = [0, 1, 2].map(|i| evaluate(&x[i], t));
        Vector6::new(x1, x2, x3, v1 / h, v2 / h, v3 / h)
    }

    /// M = exp(πA) and the periodic response to unit impulses of alternating sign, docs/theory.md
    /// (72).
    ///
    /// # Errors
    /// [`Error::Undefined`] if an undamped mode has an odd number of cycles per drive period.
    pub(super) fn half_period(&self, p: &Parameters) -> Result<HalfPeriod> {
        let map = self.transition(PI);
        let first = (Matrix2::identity() + map.one).lu().solve(&Vector2::new(0.0, self.epsilon));
        let rest = (Matrix4::identity() + map.pair).lu().solve(&Vector4::new(0.0, 0.0, -1.0, 0.0));
        let bounded = |x: &f64| x.abs() < LARGEST_RESPONSE;
        match (first, rest) {
            (Some(b), Some(r)) if b.iter().chain(r.iter()).all(bounded) => {
                Ok(HalfPeriod { map, after: Vector6::new(b[0], r[0], r[1], b[1], r[2], r[3]) })
            }
            _ => Err(Error::Undefined {
                name: "drive.frequency",
                value: p.drive_frequency,
                needed_by: "exact orbit",
                allowed: "no undamped mode at an odd multiple of drive.frequency",
            }),
        }
    }

    /// H of docs/theory.md (71), amplitude and phase of the box under the force alone:
    /// x1 = Im(H e^{iθ}). The other two bodies do not move.
    ///
    /// # Errors
    /// [`Error::Undefined`] if the box is undamped and at resonance.
    pub fn harmonic(&self, p: &Parameters) -> Result<Complex<f64>> {
        let impedance = Complex::new(self.k1 - 1.0, self.c1);
        let response = Complex::new(self.force, 0.0) / impedance;
        if impedance.norm() * LARGEST_RESPONSE > 1.0 && response.norm().is_finite() {
            return Ok(response);
        }
        Err(Error::Undefined {
            name: "box.c",
            value: p.box_damping,
            needed_by: "exact orbit at the box's resonance",
            allowed: "box.c > 0 where drive.frequency = sqrt(box.k/box.m)",
        })
    }

    /// Derivative of a state in flight with respect to the phase, where the drive's force is
    /// `force`.
    pub fn rate_of(&self, s: &Vector6, force: f64) -> Vector6 {
        let stretch = s[1] - s[2];
        let a1 = force - self.k1 * s[0] - self.c1 * s[3];
        let a3 = self.k32 * stretch - self.k3 * s[2] - self.c3 * s[5];
        Vector6::new(s[3], s[4], s[5], a1, -self.k2 * stretch, a3)
    }
}
