//! The smooth modes and the impact law (docs/theory.md (5) to (17)).
//!
//! The coordinates are `x1, w = x2 - x1, x3`. The relative displacement w is itself a coordinate.
//! So it is exact to the last bit at a stop, however far the box has drifted, and resting contact
//! is `w = ±L, w' = 0` without projection.

use crate::error::{Error, Result};
use crate::parameters::Parameters;

mod saltation;

pub use saltation::Saltation;

/// Number of coordinates of the augmented state `[x1, w, x3, x1', w', x3', cos θ, sin θ]`.
pub const COORDINATES: usize = 8;
/// Index of the box's displacement x1.
pub const BOX: usize = 0;
/// Index of the relative displacement w.
pub const RELATIVE: usize = 1;
/// Index of the secondary oscillator's displacement x3.
pub const SECONDARY: usize = 2;
/// Index of x1'.
pub const BOX_RATE: usize = 3;
/// Index of w'.
pub const RELATIVE_RATE: usize = 4;
/// Index of x3'.
pub const SECONDARY_RATE: usize = 5;
/// Index of cos θ.
pub const DRIVE_COS: usize = 6;
/// Index of sin θ.
pub const DRIVE_SIN: usize = 7;
/// Augmented state; with it each mode is an autonomous linear system.
pub type Augmented = [f64; COORDINATES];
/// Forces f1, f2, f3 as value and time derivatives 1…3.
pub type Forces = [[f64; 4]; 3];

/// Linear system of motion between events.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SmoothMode {
    /// The block is free.
    Flight,
    /// Box and block move as one body.
    Rest,
}

/// The equations of motion divided by the masses; time unit s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// k1/m1, 1/s².
    pub k1: f64,
    /// c1/m1, 1/s.
    pub c1: f64,
    /// F10/m1, m/s².
    pub drive: f64,
    /// k23/m2, 1/s².
    pub k2: f64,
    /// k3/m3, 1/s².
    pub k3: f64,
    /// c3/m3, 1/s.
    pub c3: f64,
    /// k23/m3, 1/s².
    pub k32: f64,
    /// 1/m1, 1/m2, 1/m3, 1/kg.
    pub inverse_mass: [f64; 3],
    /// m1/(m1+m2): the box's share of the mass of box and block. It is stored because `1 -
    /// block_share` has few correct digits for a heavy block.
    pub box_share: f64,
    /// m2/(m1+m2) = m_r/m1: the block's share of the mass of box and block.
    pub block_share: f64,
    /// m_r = m1 m2/(m1+m2), kg (docs/theory.md (10)).
    pub reduced_mass: f64,
    /// ω1, rad/s.
    pub omega: f64,
    /// L, m: the gap on either side of the centred block.
    pub gap: f64,
    /// κ.
    pub restitution: f64,
    /// Constant loads on the three bodies, N. Like all loads they are passed to
    /// [`acceleration`](Self::acceleration) and are not part of the matrices.
    pub constant_loads: [f64; 3],
    /// Bound r on the rates of both modes and of the drive, 1/s: a weighted maximum norm of the
    /// bodies' matrices, and at least ω1. The contributions of drive and loads are bounded
    /// separately (docs/numerics.md, section 1).
    pub rate: f64,
}

/// Results of an impact, docs/theory.md (10) to (12).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// Approach speed |w'⁻|, m/s.
    pub speed: f64,
    /// Impulse p, N s.
    pub impulse: f64,
    /// Energy lost, J.
    pub lost: f64,
}

/// Accelerations in a smooth mode, m/s².
#[derive(Clone, Copy, Debug)]
pub struct Acceleration {
    /// x1'', w'', x3''.
    pub coordinates: [f64; 3],
    /// Free relative acceleration a_w: w'' without contact.
    pub free: f64,
}

/// Factors of the impact law, docs/theory.md (10) to (12).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpactFactors {
    /// Change of the box's velocity in the direction of the stop, divided by the approach speed.
    pub kick: f64,
    /// Impulse divided by the approach speed, kg.
    pub impulse: f64,
    /// Energy lost divided by the square of the approach speed, kg.
    pub loss: f64,
}

/// Largest ratio of the system's rate to the drive frequency. At a larger ratio the accumulated
/// round-off of a drive period's many sub-steps would cost digits.
const MAX_RATE_RATIO: f64 = 1e7;
/// Lower limit of the rate, 1/s, which keeps the sub-step finite. A slower system does not move
/// noticeably within minutes.
const MIN_RATE: f64 = 1e-3;
/// Largest value of 1/m, 1/L, the drive's acceleration, and L times the rate. Products of larger
/// values may overflow. The limit on 1/m and 1/L also prevents underflow of products with m and L.
const MAX_PRODUCT: f64 = 1e100;
/// Largest rate (1/s) and mass (kg). Above it the energies of the largest speeds and the fifth
/// derivatives of the largest displacements overflow.
const MAX_RATE: f64 = 1e40;

impl Model {
    /// Constant loads with their derivatives, if there are any.
    pub fn constant_forces(&self) -> Option<Forces> {
        (self.constant_loads != [0.0; 3]).then(|| self.constant_loads.map(|f| [f, 0.0, 0.0, 0.0]))
    }

    /// Equations of motion for a set of parameters.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a parameter outside its range; [`Error::PrecisionLost`] if a
    /// rate, a mass, the gap or the drive is so large or so small, or the rates so far from the
    /// drive's frequency, that double precision does not resolve the motion.
    pub fn new(p: &Parameters) -> Result<Self> {
        p.validate()?;
        let (m1, m2, m3) = (p.box_mass, p.block_mass, p.secondary_mass);
        let mut model = Self {
            k1: p.box_stiffness / m1,
            c1: p.box_damping / m1,
            drive: p.drive_amplitude / m1,
            k2: p.coupling_stiffness / m2,
            k3: p.secondary_stiffness / m3,
            c3: p.secondary_damping / m3,
            k32: p.coupling_stiffness / m3,
            inverse_mass: [1.0 / m1, 1.0 / m2, 1.0 / m3],
            box_share: m1 / (m1 + m2),
            block_share: m2 / (m1 + m2),
            reduced_mass: m1 * (m2 / (m1 + m2)),
            omega: p.drive_frequency,
            gap: p.stop_gap,
            restitution: p.stop_restitution,
            constant_loads: p.constant_loads,
            rate: 0.0,
        };
        model.rate = model.norm().max(model.omega).max(MIN_RATE);
        let [one, two, three] = model.inverse_mass;
        let gap = [1.0 / model.gap, model.gap * model.rate.max(1.0)];
        let powers = [model.rate, m1, m2, m3];
        let products = [model.drive, one, two, three, gap[0], gap[1]];
        for (what, numbers, limit) in [
            ("largest of sqrt(k/m), c/m, drive.frequency and the masses", &powers[..], MAX_RATE),
            (
                "largest of 1/m, drive.amplitude/box.m, 1/stop.gap and stop.gap times the fastest rate",
                &products[..],
                MAX_PRODUCT,
            ),
        ] {
            let value = numbers.iter().fold(0.0f64, |most, n| most.max(n.abs()));
            if value > limit {
                return Err(Error::PrecisionLost { what, value, limit });
            }
        }
        let ratio = model.rate / model.omega;
        if model.omega > 0.0 && ratio > MAX_RATE_RATIO {
            return Err(Error::PrecisionLost {
                what: "fastest rate of the system (sqrt(k/m) + c/m) over drive.frequency",
                value: ratio,
                limit: MAX_RATE_RATIO,
            });
        }
        Ok(model)
    }

    /// Bound on the norm of both modes' matrices, 1/s. The norm is the maximum norm with w
    /// weighted by 1/α and the velocities by 1/r, where r is the bound. The result is the smallest
    /// bound for several α. In rest, the row of box and block is the mass-weighted mean of their
    /// rows in flight.
    fn norm(&self) -> f64 {
        let norm = |alpha: f64| {
            let block = (self.k1 + 2.0 * self.k2) / alpha + self.k2;
            let secondary = self.k3 + (2.0 + alpha) * self.k32;
            let joint =
                self.k1.max(self.k2 * (2.0 + alpha) * self.block_share + self.k1 * (1.0 - self.block_share));
            joint.max(block).max(secondary).sqrt() + self.c1.max(self.c1 / alpha).max(self.c3)
        };
        [1.0, 2.0, 4.0, 8.0, 16.0].into_iter().map(norm).fold(f64::INFINITY, f64::min)
    }

    /// Accelerations in `mode`, linear in state and loads (docs/theory.md (6), (7), (13)). `f` are
    /// the loads on the three bodies in N, if any act.
    #[inline(always)]
    pub fn acceleration(&self, mode: SmoothMode, z: &Augmented, f: Option<[f64; 3]>) -> Acceleration {
        let stretch = (z[BOX] - z[SECONDARY]) + z[RELATIVE]; // x2 - x3
        let mut a1 = (self.drive * z[DRIVE_SIN] - self.k1 * z[BOX]) - self.c1 * z[BOX_RATE];
        let mut a2 = -(self.k2 * stretch);
        let mut a3 = (self.k32 * stretch - self.k3 * z[SECONDARY]) - self.c3 * z[SECONDARY_RATE];
        if let Some(f) = f {
            a1 += f[0] * self.inverse_mass[0];
            a2 += f[1] * self.inverse_mass[1];
            a3 += f[2] * self.inverse_mass[2];
        }
        let free = a2 - a1;
        let coordinates = match mode {
            SmoothMode::Flight => [a1, free, a3],
            // Mass-weighted mean, computed as the heavier body's acceleration and a correction. If
            // it were computed as the lighter body's acceleration and a correction, both terms
            // would be large and nearly cancel.
            SmoothMode::Rest if self.block_share > 0.5 => [a2 - self.box_share * free, 0.0, a3],
            SmoothMode::Rest => [a1 + self.block_share * free, 0.0, a3],
        };
        Acceleration { coordinates, free }
    }

    /// Applies the impact law at stop `side` (+1 or -1), docs/theory.md (10) to (12), to the
    /// velocities.
    #[inline(always)]
    pub fn impact(&self, z: &mut Augmented, side: f64) -> Impact {
        let speed = side * z[RELATIVE_RATE];
        let ImpactFactors { kick, impulse, loss } = self.impact_factors();
        z[BOX_RATE] += side * kick * speed;
        z[RELATIVE_RATE] *= -self.restitution;
        Impact { speed, impulse: impulse * speed, lost: loss * speed * speed }
    }

    /// Factors of the impact law.
    #[inline(always)]
    pub fn impact_factors(&self) -> ImpactFactors {
        let Self { restitution: kappa, reduced_mass, .. } = *self;
        ImpactFactors {
            kick: (1.0 + kappa) * self.block_share,
            impulse: (1.0 + kappa) * reduced_mass,
            loss: 0.5 * (1.0 - kappa * kappa) * reduced_mass,
        }
    }

    /// Applies the inelastic merge into resting contact, docs/theory.md (17), which conserves
    /// momentum. Returns the energy lost, J.
    #[inline(always)]
    pub fn merge(&self, z: &mut Augmented) -> f64 {
        let slip = z[RELATIVE_RATE];
        z[BOX_RATE] += self.block_share * slip;
        z[RELATIVE_RATE] = 0.0;
        0.5 * self.reduced_mass * slip * slip
    }
}
