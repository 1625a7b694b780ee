//! Kinds of the numbers of a machine: meaning, units and allowed range. File and parameter table
//! share them, so that a number is refused for one reason wherever it comes from.

use crate::description::Dimension;
use vibro_impact::parameters::Range;
use vibro_impact::quantities::symbols;

/// A kind of number.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// Its meaning in words.
    pub meaning: &'static str,
    /// SI units for translation and for rotation.
    pub units: [&'static str; 2],
    /// Allowed values; see `not_zero`.
    pub range: Range,
    /// Whether zero is refused even if the range contains it.
    pub not_zero: bool,
}

const fn kind(
    meaning: &'static str,
    translation: &'static str,
    rotation: &'static str,
    range: Range,
) -> Kind {
    Kind { meaning, units: [translation, rotation], range, not_zero: false }
}

const fn between(min: f64, max: f64, allowed: &'static str) -> Range {
    Range { min, max, open_min: false, allowed }
}

pub const GRAVITY: Kind = kind("Acceleration of gravity", "m/s2", "m/s2", Range::NOT_NEGATIVE);
pub const INERTIA: Kind = kind("Mass or moment of inertia", "kg", "kg.m2", Range::POSITIVE);
pub const COSINE: Kind =
    kind("Cosine of the angle to gravity", "1", "1", between(-1.0, 1.0, "a number from -1 to 1"));
pub const POSITION: Kind = kind("Coordinate", "m", "rad", Range::FINITE);
pub const START: Kind = kind("Coordinate at time 0", "m", "rad", Range::FINITE);
pub const RATE: Kind = kind("Rate of the even motion", "m/s", "rad/s", Range::FINITE);
pub const START_RATE: Kind = kind("Rate at time 0", "m/s", "rad/s", Range::FINITE);
pub const STIFFNESS: Kind = kind("Stiffness", "N/m", "N.m/rad", Range::NOT_NEGATIVE);
pub const DAMPING: Kind = kind("Viscous damping", "N.s/m", "N.m.s/rad", Range::NOT_NEGATIVE);
pub const DASHPOT: Kind = kind("Viscous damping", "N.s/m", "N.m.s/rad", Range::POSITIVE);
pub const PRELOAD: Kind = kind("Force at e = 0", "N", "N.m", Range::FINITE);
pub const GAP: Kind = kind("Elongation at which the stop closes", "m", "rad", Range::FINITE);
pub const RESTITUTION: Kind =
    kind("Restitution coefficient", "1", "1", between(0.0, 1.0, "a number from 0 to 1"));
pub const FORCE: Kind = kind("Force or torque", "N", "N.m", Range::FINITE);
pub const LEVEL: Kind = kind("Level of friction", "N", "N.m", Range::NOT_NEGATIVE);
pub const FREQUENCY: Kind = kind("Frequency", "Hz", "Hz", Range::POSITIVE);
pub const PHASE: Kind = kind("Phase at time 0", "rad", "rad", Range::FINITE);
pub const TIME: Kind = kind("Time", "s", "s", Range::FINITE);

const fn arm(unit: &'static str) -> Kind {
    let mut arm = kind("Lever arm", unit, unit, Range::any("a finite number other than 0"));
    arm.not_zero = true;
    arm
}

const PLAIN_ARM: Kind = arm("1");
const LENGTH_ARM: Kind = arm("m");
const INVERSE_ARM: Kind = arm("1/m");

/// The arm of a body's coordinate in an elongation.
pub fn arm_of(body: Dimension, elongation: Dimension) -> Kind {
    match (body, elongation) {
        (Dimension::Rotation, Dimension::Translation) => LENGTH_ARM,
        (Dimension::Translation, Dimension::Rotation) => INVERSE_ARM,
        _ => PLAIN_ARM,
    }
}

impl Kind {
    /// Its SI unit.
    pub fn unit(&self, dimension: Dimension) -> &'static str {
        self.units[usize::from(dimension == Dimension::Rotation)]
    }

    /// Whether a value in SI units is allowed.
    pub fn contains(&self, value: f64) -> bool {
        self.range.contains(value) && !(self.not_zero && value == 0.0)
    }

    /// The values and units allowed in a file, in words.
    pub fn allowed(&self, dimension: Dimension) -> String {
        let units: Vec<_> = symbols(self.unit(dimension)).collect();
        match units[0] {
            "1" => format!("allowed is {}", self.range.allowed),
            _ => format!("allowed is {}, in {}", self.range.allowed, units.join(", ")),
        }
    }
}
