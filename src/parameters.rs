//! SI parameters, the dimensionless groups of the paper (section 2) and the way between them.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// The physical parameters, SI units. `Default` is the data set BASIC (model.md section 8, a reconstruction)
/// in unit scales: m1 = 1 kg, k1 = 1 N/m, L = 1 m, so that SI and dimensionless numbers coincide.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// Mass of the box m1, kg.
    pub box_mass: f64,
    /// Stiffness k1 of the box's spring to ground, N/m.
    pub box_stiffness: f64,
    /// Damping c1 of the box's damper to ground, N·s/m.
    pub box_damping: f64,
    /// Mass of the block m2, kg.
    pub block_mass: f64,
    /// Mass of the secondary oscillator m3, kg.
    pub secondary_mass: f64,
    /// Stiffness k3 of the secondary oscillator's spring to ground, N/m.
    pub secondary_stiffness: f64,
    /// Damping c3 of the secondary oscillator's damper to ground, N·s/m.
    pub secondary_damping: f64,
    /// Stiffness k23 of the spring between block and secondary oscillator, N/m.
    pub coupling_stiffness: f64,
    /// Gap L on either side of the centred block, m.
    pub stop_gap: f64,
    /// Restitution coefficient κ, 1.
    pub stop_restitution: f64,
    /// Amplitude F10 of the harmonic force on the box, N.
    pub drive_amplitude: f64,
    /// Angular frequency ω1 of that force, rad/s.
    pub drive_frequency: f64,
    /// Phase of that force at time 0, rad: F10 sin(ω1 t + phase).
    pub drive_phase: f64,
}

/// One physical parameter: its name, unit, meaning, range and accessors. The variable table and the
/// command line are made from these.
#[derive(Clone, Copy, Debug)]
pub struct Field {
    /// Structured name, e.g. `box.m`.
    pub name: &'static str,
    /// Field name of [`Parameters`], e.g. `box_mass`.
    pub field: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// What it is.
    pub description: &'static str,
    /// Allowed range in words.
    pub allowed: &'static str,
    /// Smallest allowed value (exclusive where `open_min`).
    pub min: f64,
    /// Largest allowed value.
    pub max: f64,
    /// Whether `min` itself is refused.
    pub open_min: bool,
    /// Reads the field.
    pub get: fn(&Parameters) -> f64,
    /// Writes the field.
    pub set: fn(&mut Parameters, f64),
}

macro_rules! field {
    ($name:literal, $field:ident, $unit:literal, $allowed:literal, $min:expr, $max:expr, $open:literal, $text:literal) => {
        Field {
            name: $name,
            field: stringify!($field),
            unit: $unit,
            description: $text,
            allowed: $allowed,
            min: $min,
            max: $max,
            open_min: $open,
            get: |p| p.$field,
            set: |p, value| p.$field = value,
        }
    };
}

const POSITIVE: f64 = f64::INFINITY;

/// All physical parameters, in the order of the contract.
#[rustfmt::skip]
pub const FIELDS: [Field; 13] = [
    field!("box.m", box_mass, "kg", "a finite number > 0", 0.0, POSITIVE, true, "Mass of the box (m1)"),
    field!("box.k", box_stiffness, "N/m", "a finite number >= 0", 0.0, POSITIVE, false, "Stiffness between box and ground (k1)"),
    field!("box.c", box_damping, "N.s/m", "a finite number >= 0", 0.0, POSITIVE, false, "Viscous damping between box and ground (c1)"),
    field!("block.m", block_mass, "kg", "a finite number > 0", 0.0, POSITIVE, true, "Mass of the block inside the box (m2)"),
    field!("secondary.m", secondary_mass, "kg", "a finite number > 0", 0.0, POSITIVE, true, "Mass of the secondary oscillator (m3)"),
    field!("secondary.k", secondary_stiffness, "N/m", "a finite number >= 0", 0.0, POSITIVE, false, "Stiffness between secondary oscillator and ground (k3)"),
    field!("secondary.c", secondary_damping, "N.s/m", "a finite number >= 0", 0.0, POSITIVE, false, "Viscous damping between secondary oscillator and ground (c3)"),
    field!("coupling.k", coupling_stiffness, "N/m", "a finite number >= 0", 0.0, POSITIVE, false, "Stiffness between block and secondary oscillator (k23)"),
    field!("stop.gap", stop_gap, "m", "a finite number > 0", 0.0, POSITIVE, true, "Gap L on either side of the centred block"),
    field!("stop.restitution", stop_restitution, "1", "0 <= stop.restitution <= 1", 0.0, 1.0, false, "Restitution coefficient of the stops (kappa)"),
    field!("drive.amplitude", drive_amplitude, "N", "a finite number", f64::NEG_INFINITY, POSITIVE, false, "Amplitude of the harmonic force on the box (F10)"),
    field!("drive.frequency", drive_frequency, "rad/s", "a finite number >= 0", 0.0, POSITIVE, false, "Angular frequency of the harmonic force (omega1)"),
    field!("drive.phase", drive_phase, "rad", "a finite number", f64::NEG_INFINITY, POSITIVE, false, "Phase of the harmonic force at time 0"),
];

impl Field {
    /// Checks a value against the range.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] naming this field, for NaN and infinities too.
    pub fn check(&self, value: f64) -> Result<()> {
        let low = if self.open_min { value > self.min } else { value >= self.min };
        if value.is_finite() && low && value <= self.max {
            return Ok(());
        }
        Err(Error::OutOfRange { name: self.name, value, allowed: self.allowed })
    }
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            box_mass: 1.0,
            box_stiffness: 1.0,
            box_damping: 0.1,
            block_mass: 0.1,
            secondary_mass: 0.1,
            secondary_stiffness: 0.1,
            secondary_damping: 0.006,
            coupling_stiffness: 0.006,
            stop_gap: 1.0,
            stop_restitution: 0.75,
            drive_amplitude: 0.15,
            drive_frequency: 1.04,
            drive_phase: 0.0,
        }
    }
}

impl Parameters {
    /// Checks every field against its range.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for the first field outside its range.
    pub fn validate(&self) -> Result<()> {
        FIELDS.iter().try_for_each(|field| field.check((field.get)(self)))
    }

    /// Drive period 2π/ω1 in s (infinite for a constant force).
    pub fn period(&self) -> f64 {
        std::f64::consts::TAU / self.drive_frequency
    }

    /// Natural frequency ω10 = √(k1/m1) of the box, rad/s; it scales time.
    pub fn box_frequency(&self) -> f64 {
        (self.box_stiffness / self.box_mass).sqrt()
    }

    /// The scales that make this set dimensionless: m1, k1 and L.
    pub fn scales(&self) -> Scales {
        Scales { mass: self.box_mass, stiffness: self.box_stiffness, length: self.stop_gap }
    }

    /// The dimensionless groups (model.md section 2, paper (5) and (7)–(8)).
    ///
    /// # Errors
    /// [`Error::OutOfRange`] as [`validate`](Self::validate); [`Error::Undefined`] when k1 = 0, since ω10 scales time.
    pub fn groups(&self) -> Result<Groups> {
        self.validate()?;
        if self.box_stiffness == 0.0 {
            return Err(Error::Undefined {
                name: "box.k",
                value: 0.0,
                needed_by: "dimensionless form",
                allowed: "box.k > 0",
            });
        }
        let omega10 = self.box_frequency();
        let epsilon = self.block_mass / self.box_mass;
        let square = omega10 * omega10;
        let beta2 = self.coupling_stiffness / (self.block_mass * square);
        Ok(Groups {
            epsilon,
            kappa: self.stop_restitution,
            f10: self.drive_amplitude / (self.box_stiffness * self.stop_gap * epsilon),
            sigma1: (self.drive_frequency / omega10 - 1.0) / epsilon,
            gamma1: self.box_damping / (self.box_mass * omega10 * epsilon),
            alpha23: beta2 / epsilon,
            beta2,
            sigma30: (self.secondary_stiffness / (self.secondary_mass * square) - 1.0) / epsilon,
            gamma3: self.secondary_damping / (self.secondary_mass * omega10 * epsilon),
            mu13: self.box_mass / self.secondary_mass,
        })
    }
}

/// The three scales of the dimensionless form: m1, k1 and L.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scales {
    /// m1 in kg.
    pub mass: f64,
    /// k1 in N/m.
    pub stiffness: f64,
    /// L in m.
    pub length: f64,
}

impl Default for Scales {
    fn default() -> Self {
        Self { mass: 1.0, stiffness: 1.0, length: 1.0 }
    }
}

/// The dimensionless groups of the paper, all of unit 1; hats are dropped from the names.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Groups {
    /// ε = m2/m1.
    pub epsilon: f64,
    /// Restitution coefficient κ.
    pub kappa: f64,
    /// f̂10 = F10/(k1 L ε).
    pub f10: f64,
    /// σ̂1 in Ω1 = ω1/ω10 = 1 + ε σ̂1.
    pub sigma1: f64,
    /// γ̂1 = c1/(m1 ω10 ε).
    pub gamma1: f64,
    /// α̂23 = β²/ε. Redundant with `beta2`, which is the one converted back.
    pub alpha23: f64,
    /// β² = k23/(m2 ω10²).
    pub beta2: f64,
    /// σ̂30 in Ω30² = k3/(m3 ω10²) = 1 + ε σ̂30.
    pub sigma30: f64,
    /// γ̂3 = c3/(m3 ω10 ε).
    pub gamma3: f64,
    /// μ13 = m1/m3.
    pub mu13: f64,
}

impl Groups {
    /// The weak-coupling set of the paper's sections 2–4: m3 = m2 (μ13 = 1/ε) and β² = ε α̂23.
    #[allow(clippy::too_many_arguments)]
    pub fn weak(
        epsilon: f64,
        kappa: f64,
        f10: f64,
        sigma1: f64,
        gamma1: f64,
        alpha23: f64,
        sigma30: f64,
        gamma3: f64,
    ) -> Self {
        let (beta2, mu13) = (epsilon * alpha23, 1.0 / epsilon);
        Self { epsilon, kappa, f10, sigma1, gamma1, alpha23, beta2, sigma30, gamma3, mu13 }
    }

    /// The data set BASIC (model.md section 8): a reconstruction, not the paper's own.
    pub fn basic() -> Self {
        Self::weak(0.1, 0.75, 1.5, 0.4, 1.0, 0.6, 0.0, 0.6)
    }

    /// The physical parameters with these groups in the given scales, drive phase zero.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] when a resulting field is outside its range.
    pub fn to_parameters(&self, scales: Scales) -> Result<Parameters> {
        let Scales { mass: m1, stiffness: k1, length } = scales;
        let omega10 = (k1 / m1).sqrt();
        let (m2, m3) = (self.epsilon * m1, m1 / self.mu13);
        let parameters = Parameters {
            box_mass: m1,
            box_stiffness: k1,
            box_damping: self.gamma1 * m1 * omega10 * self.epsilon,
            block_mass: m2,
            secondary_mass: m3,
            secondary_stiffness: (1.0 + self.epsilon * self.sigma30) * m3 * omega10 * omega10,
            secondary_damping: self.gamma3 * m3 * omega10 * self.epsilon,
            coupling_stiffness: self.beta2 * m2 * omega10 * omega10,
            stop_gap: length,
            stop_restitution: self.kappa,
            drive_amplitude: self.f10 * k1 * length * self.epsilon,
            drive_frequency: (1.0 + self.epsilon * self.sigma1) * omega10,
            drive_phase: 0.0,
        };
        parameters.validate()?;
        Ok(parameters)
    }
}
