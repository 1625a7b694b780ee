//! The physical parameters by name: unit, meaning, range and accessors.

use super::{Parameters, Range, entry};
use crate::error::Result;

/// A physical parameter. The FMU's parameters, and the parameter names that the command line
/// accepts, are made from these entries.
#[derive(Clone, Copy, Debug)]
pub struct Field {
    /// Structured name, e.g. `box.m`.
    pub name: &'static str,
    /// Field name of [`Parameters`], e.g. `box_mass`.
    pub field: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Description, a noun phrase.
    pub description: &'static str,
    /// Allowed values.
    pub range: Range,
    /// Reads the field.
    pub get: fn(&Parameters) -> f64,
    /// Writes the field.
    pub set: fn(&mut Parameters, f64),
}

macro_rules! field {
    ($name:literal, $field:ident, $unit:literal, $range:expr, $text:literal) => {
        entry!(Field, $name, $field, $range, $text, field: stringify!($field), unit: $unit)
    };
}

/// Range of the restitution coefficient, from plastic to elastic impacts.
const RESTITUTION: Range =
    Range { min: 0.0, max: 1.0, open_min: false, allowed: "0 <= stop.restitution <= 1" };

/// All physical parameters except the constant loads ([`LOADS`]), in the order of the fields of
/// [`Parameters`]. The FMU's value references follow this order.
#[rustfmt::skip]
pub const FIELDS: [Field; 13] = [
    field!("box.m", box_mass, "kg", Range::POSITIVE, "Mass of the box (m1)"),
    field!("box.k", box_stiffness, "N/m", Range::NOT_NEGATIVE, "Stiffness between box and ground (k1)"),
    field!("box.c", box_damping, "N.s/m", Range::NOT_NEGATIVE, "Viscous damping between box and ground (c1)"),
    field!("block.m", block_mass, "kg", Range::POSITIVE, "Mass of the block inside the box (m2)"),
    field!("secondary.m", secondary_mass, "kg", Range::POSITIVE, "Mass of the secondary oscillator (m3)"),
    field!("secondary.k", secondary_stiffness, "N/m", Range::NOT_NEGATIVE, "Stiffness between secondary oscillator and ground (k3)"),
    field!("secondary.c", secondary_damping, "N.s/m", Range::NOT_NEGATIVE, "Viscous damping between secondary oscillator and ground (c3)"),
    field!("coupling.k", coupling_stiffness, "N/m", Range::NOT_NEGATIVE, "Stiffness between block and secondary oscillator (k23)"),
    field!("stop.gap", stop_gap, "m", Range::POSITIVE, "Gap L on either side of the centred block"),
    field!("stop.restitution", stop_restitution, "1", RESTITUTION, "Restitution coefficient of the stops (kappa)"),
    field!("drive.amplitude", drive_amplitude, "N", Range::FINITE, "Amplitude of the harmonic force on the box (F10)"),
    field!("drive.frequency", drive_frequency, "rad/s", Range::NOT_NEGATIVE, "Angular frequency of the harmonic force (omega1)"),
    field!("drive.phase", drive_phase, "rad", Range::FINITE, "Phase of the harmonic force at time 0"),
];

macro_rules! load {
    ($name:literal, $body:literal, $text:literal) => {
        Field {
            name: $name,
            field: "constant_loads",
            unit: "N",
            description: $text,
            range: Range::FINITE,
            get: |parameters| parameters.constant_loads[$body],
            set: |parameters, value| parameters.constant_loads[$body] = value,
        }
    };
}

/// Constant loads on the three bodies. The FMU does not have them as variables; it has the inputs
/// `box.f`, `block.f`, `secondary.f` instead.
pub const LOADS: [Field; 3] = [
    load!("load.box", 0, "Constant force on the box"),
    load!("load.block", 1, "Constant force on the block"),
    load!("load.secondary", 2, "Constant force on the secondary oscillator"),
];

impl Field {
    /// Checks a value against the range.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange), which names this field, if the value is
    /// outside the range, NaN or infinite.
    pub fn check(&self, value: f64) -> Result<()> {
        Ok(self.range.check(self.name, value)?)
    }
}
