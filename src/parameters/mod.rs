//! SI parameters, the dimensionless groups of the paper (section 2) and the conversions between
//! them (docs/theory.md, sections 1 and 4).
//!
//! [`FIELDS`] and [`GROUPS`] list both sets by name, with ranges and accessors; input, tables and
//! documentation are made from these lists. [`LOADS`] lists the constant loads, which are zero
//! unless set; the FMU has inputs in their place.

mod fields;
mod groups;

pub use fields::{FIELDS, Field, LOADS};
pub(crate) use groups::RESTITUTION;
pub use groups::{GROUPS, Group, Groups, check_together};
pub use vibro_numerics::Range;

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// Entry of [`FIELDS`] or [`GROUPS`] for a field of a struct: its name, range, description and
/// accessors, and the further fields of the entry's type.
macro_rules! entry {
    ($type:ident, $name:expr, $field:ident, $range:expr, $text:literal, $($other:ident: $value:expr),+) => {
        $type {
            name: $name,
            description: $text,
            range: $range,
            get: |quantities| quantities.$field,
            set: |quantities, value| quantities.$field = value,
            $($other: $value),+
        }
    };
}
use entry;

/// Physical parameters, SI units. `Default` is the default data set (docs/theory.md, end of
/// section 4: partly a reconstruction) in unit scales: m1 = 1 kg, k1 = 1 N/m, L = 1 m, so that SI
/// and dimensionless numbers coincide. For a real machine all parameters must be set:
/// [`left_at_default`](Self::left_at_default) lists parameters that may have been forgotten.
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
    /// Angular frequency ω1 of the harmonic force, rad/s.
    pub drive_frequency: f64,
    /// Phase of the harmonic force at time 0, rad: F10 sin(ω1 t + phase).
    pub drive_phase: f64,
    /// Constant forces on box, block and secondary oscillator, N: gravity, a tilt of the machine,
    /// or a gap that is not centred (docs/theory.md (97)). Other loads add to them. Constant
    /// forces break the symmetry of the machine, so the closed forms of symmetric motions refuse
    /// them.
    pub constant_loads: [f64; 3],
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
            constant_loads: [0.0; 3],
        }
    }
}

impl Parameters {
    /// Checks every field against its range.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for the first field outside its range.
    pub fn validate(&self) -> Result<()> {
        FIELDS.iter().chain(&LOADS).try_for_each(|field| field.check((field.get)(self)))
    }

    /// Parameters with the value of the default machine if others differ from it. Such parameters
    /// may have been forgotten in `Parameters { box_mass: 12.0, ..Parameters::default() }`; their
    /// values then belong to a machine of 1 kg, 1 N/m and a gap of 1 m. The default may also be
    /// intended, such as a restitution of 0.75. The drive's phase and the constant loads, whose
    /// default is zero, are not listed. The list is empty for the default machine itself.
    ///
    /// ```
    /// use vibro_impact::Parameters;
    ///
    /// let default = Parameters::default();
    /// let p = Parameters { box_mass: 12.0, box_stiffness: 48e3, stop_gap: 0.015, ..default };
    /// let forgotten: Vec<&str> = p.left_at_default().iter().map(|field| field.name).collect();
    /// assert!(forgotten.contains(&"drive.amplitude") && !forgotten.contains(&"box.m"));
    /// assert!(Parameters::default().left_at_default().is_empty());
    /// ```
    pub fn left_at_default(&self) -> Vec<&'static Field> {
        let default = Self::default();
        let of_machine = || FIELDS.iter().filter(|field| field.name != "drive.phase");
        let same = |field: &&'static Field| (field.get)(self) == (field.get)(&default);
        if of_machine().all(|field| same(&field)) { Vec::new() } else { of_machine().filter(same).collect() }
    }

    /// Whether the machine is symmetric, that is, has no constant loads. The mirror image of a
    /// motion, shifted by half a drive period, is then also a motion.
    pub fn is_symmetric(&self) -> bool {
        self.constant_loads == [0.0; 3]
    }

    /// Checks that the machine is symmetric, as closed forms require.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] with the first constant load that is not zero.
    pub fn check_symmetric(&self) -> Result<()> {
        match LOADS.iter().find(|load| (load.get)(self) != 0.0) {
            None => Ok(()),
            Some(load) => Err(Error::OutOfRange {
                name: load.name,
                value: (load.get)(self),
                allowed: "0; closed forms and theories do not include constant loads",
            }),
        }
    }

    /// Drive period 2π/ω1 in s (infinite for a constant force).
    pub fn period(&self) -> f64 {
        std::f64::consts::TAU / self.drive_frequency
    }

    /// Natural frequency ω10 = √(k1/m1) of the box, rad/s, the scale of time.
    pub fn box_frequency(&self) -> f64 {
        (self.box_stiffness / self.box_mass).sqrt()
    }

    /// Scales of the dimensionless form: m1, k1 and L.
    pub fn scales(&self) -> Scales {
        Scales { mass: self.box_mass, stiffness: self.box_stiffness, length: self.stop_gap }
    }

    /// Dimensionless groups, docs/theory.md (20) to (22).
    ///
    /// # Errors
    /// [`Error::OutOfRange`] as [`validate`](Self::validate); [`Error::Undefined`] for k1 = 0,
    /// since ω10 scales time.
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

/// Scales of the dimensionless form: m1, k1 and L.
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
