//! Kinds of a machine's numbers: meaning, units and allowed range. The file reader and the setting
//! of parameters share them, so that both refuse a number for the same reason.

use crate::curved::LOWEST;
use crate::description::Dimension;
use vibro_numerics::Range;
use vibro_numerics::quantities::{quantity_in, split, symbols};

/// A kind of number.
#[derive(Clone, Copy, Debug)]
pub struct NumberKind {
    /// Meaning in words.
    pub meaning: &'static str,
    /// SI units for translation and for rotation.
    pub units: [&'static str; 2],
    /// Range of allowed values; `not_zero` and `least` restrict it further.
    pub range: Range,
    /// Whether zero is refused even within the range.
    pub not_zero: bool,
    /// Least absolute value other than zero: it keeps quotients finite and sub-steps long enough.
    pub least: f64,
    /// Whether a file may give the number in a unit of any dimension; its value is taken in SI.
    pub any_unit: bool,
    /// Advice after the refusal of a number outside its range; may be empty.
    pub advice: &'static str,
    /// Alternative to the number in a message, after its allowed values; may be empty.
    pub or: &'static str,
}

/// Least stiffness and damping of springs in series, whose quotient is a rate.
const LEAST: f64 = 1e-150;
/// Largest exponent of a force: the powers of displacements stay finite.
const MOST_EXPONENT: f64 = 20.0;
/// Least frequency, Hz, and least duration, s.
const LEAST_FREQUENCY: f64 = 1e-12;
const LEAST_TIME: f64 = 1e-9;

const fn kind(
    meaning: &'static str,
    translation: &'static str,
    rotation: &'static str,
    range: Range,
) -> NumberKind {
    NumberKind {
        meaning,
        units: [translation, rotation],
        range,
        not_zero: false,
        least: 0.0,
        any_unit: false,
        advice: "",
        or: "",
    }
}

const fn at_least(least: f64, kind: NumberKind) -> NumberKind {
    NumberKind { least, ..kind }
}

const fn advised(kind: NumberKind, advice: &'static str) -> NumberKind {
    NumberKind { advice, ..kind }
}

const fn between(min: f64, max: f64, allowed: &'static str) -> Range {
    Range { min, max, open_min: false, allowed }
}

pub const GRAVITY: NumberKind = advised(
    kind("Acceleration of gravity", "m/s2", "m/s2", Range::NOT_NEGATIVE),
    "it is the size of the acceleration; `gravity` of each body, from -1 to 1, gives its direction",
);
pub const INERTIA: NumberKind = kind("Mass or moment of inertia", "kg", "kg.m2", Range::POSITIVE);
pub const COSINE: NumberKind = advised(
    kind("Cosine of the angle to gravity", "1", "1", between(-1.0, 1.0, "a number from -1 to 1")),
    "the cosine of the angle between s and gravity, such as -1 if s points upwards; the acceleration is \
     `gravity` at the top of the file",
);
pub const POSITION: NumberKind = kind("Coordinate", "m", "rad", Range::FINITE);
pub const START: NumberKind = kind("Coordinate at time 0", "m", "rad", Range::FINITE);
pub const RATE: NumberKind = kind("Rate of the even motion", "m/s", "rad/s", Range::FINITE);
pub const START_RATE: NumberKind = kind("Rate at time 0", "m/s", "rad/s", Range::FINITE);
pub const STIFFNESS: NumberKind = kind("Stiffness", "N/m", "N.m/rad", Range::NOT_NEGATIVE);
pub const SPRING_STIFFNESS: NumberKind =
    advised(STIFFNESS, "a negative stiffness requires a curve, such as `cubic`, a `force` or `points`");
/// A part of a stiffness that steps in time.
pub const STEPPED: NumberKind = kind("Stiffness", "N/m", "N.m/rad", Range::FINITE);
/// The stiffness of a spring with a curve, which may fall at e = 0.
pub const CURVED_STIFFNESS: NumberKind = kind("Stiffness at e = 0", "N/m", "N.m/rad", Range::FINITE);
/// Keys and kinds of the coefficients of a spring's curve.
pub const CURVE: [(&str, NumberKind); 4] = [
    ("quadratic", kind("Coefficient of the square of e", "N/m2", "N.m/rad2", Range::FINITE)),
    ("cubic", kind("Coefficient of the cube of e", "N/m3", "N.m/rad3", Range::FINITE)),
    ("quartic", kind("Coefficient of the fourth power of e", "N/m4", "N.m/rad4", Range::FINITE)),
    ("quintic", kind("Coefficient of the fifth power of e", "N/m5", "N.m/rad5", Range::FINITE)),
];
/// The damping of a dashpot with a curve.
pub const CURVED_DAMPING: NumberKind = kind("Viscous damping at e' = 0", "N.s/m", "N.m.s/rad", Range::FINITE);
pub const CUBIC_DAMPING: NumberKind =
    kind("Coefficient of the cube of e'", "N.s3/m3", "N.m.s3/rad3", Range::FINITE);
/// The stiffness of a spring across the motion.
pub const ACROSS_STIFFNESS: NumberKind = kind("Stiffness", "N/m", "N.m/rad", Range::POSITIVE);
pub const OFFSET: NumberKind = kind("Length of the spring at e = 0", "m", "m", Range::POSITIVE);
pub const FREE_LENGTH: NumberKind = kind("Length without force", "m", "m", Range::NOT_NEGATIVE);
/// A parameter in a formula.
pub const OF_FORMULA: NumberKind = kind("Parameter of a formula", "1", "1", Range::FINITE);
pub const SERIES_STIFFNESS: NumberKind = advised(
    at_least(LEAST, kind("Stiffness", "N/m", "N.m/rad", Range::POSITIVE)),
    "a spring with `slip` or `series_damping` requires a stiffness",
);
pub const SERIES_DAMPING: NumberKind =
    at_least(LEAST, kind("Viscous damping", "N.s/m", "N.m.s/rad", Range::POSITIVE));
pub const SLIP: NumberKind = kind("Force at which the slider slips", "N", "N.m", Range::POSITIVE);
pub const SLIDER: NumberKind = kind("Inner place at time 0", "m", "rad", Range::FINITE);
pub const DAMPING: NumberKind = kind("Viscous damping", "N.s/m", "N.m.s/rad", Range::NOT_NEGATIVE);
pub const DASHPOT: NumberKind = advised(
    kind("Viscous damping", "N.s/m", "N.m.s/rad", Range::POSITIVE),
    "a damping of 0 or less requires `quadratic`, `cubic`, `coefficient` or `force`",
);
/// Coefficient of the square of e', with its sign.
pub const QUADRATIC_DAMPING: NumberKind =
    kind("Coefficient of e' abs(e')", "N.s2/m2", "N.m.s2/rad2", Range::FINITE);
/// Dissipation of a contact by Hunt and Crossley.
pub const DISSIPATION: NumberKind = kind("Dissipation of the contact", "s/m", "s/rad", Range::NOT_NEGATIVE);
/// Exponent of a force.
pub const EXPONENT: NumberKind =
    kind("Exponent of the force", "1", "1", between(1.0, MOST_EXPONENT, "a number from 1 to 20"));
pub const PRELOAD: NumberKind = kind("Force at e = 0", "N", "N.m", Range::FINITE);
pub const POINT: NumberKind = kind("Elongation of a point of the force", "m", "rad", Range::FINITE);
pub const POINT_FORCE: NumberKind = kind("Force at a point", "N", "N.m", Range::FINITE);
pub const GAP: NumberKind = kind("Elongation at which the stop closes", "m", "rad", Range::FINITE);
pub const NORMAL_STIFFNESS: NumberKind =
    at_least(LEAST, kind("Normal stiffness", "N/m", "N/m", Range::POSITIVE));
pub const TANGENTIAL_STIFFNESS: NumberKind =
    at_least(LEAST, kind("Tangential stiffness", "N/m", "N/m", Range::POSITIVE));
pub const CONTACT_PRELOAD: NumberKind = advised(
    kind("Normal force at e = 0", "N", "N", Range::FINITE),
    "a force that varies in time is a [load.NAME]",
);
pub const RESTITUTION: NumberKind =
    kind("Restitution coefficient", "1", "1", between(0.0, 1.0, "a number from 0 to 1"));
pub const FORCE: NumberKind = kind("Force or torque", "N", "N.m", Range::FINITE);
pub const STRIBECK: NumberKind =
    kind("Speed at which friction falls from its static level", "m/s", "rad/s", Range::POSITIVE);
/// Viscous damping of a friction.
pub const VISCOUS: NumberKind =
    kind("Viscous damping of the friction", "N.s/m", "N.m.s/rad", Range::NOT_NEGATIVE);
pub const LEVEL: NumberKind = kind("Level of friction", "N", "N.m", Range::NOT_NEGATIVE);
pub const COEFFICIENT: NumberKind = kind("Coefficient of friction", "1", "1", Range::NOT_NEGATIVE);
/// The coefficient of friction of a contact, which enters the stiffness of the slip.
pub const FRICTION_OF_CONTACT: NumberKind =
    kind("Coefficient of friction", "1", "1", between(0.0, 1e6, "a number from 0 to 1e6"));
pub const FREQUENCY: NumberKind = at_least(LEAST_FREQUENCY, kind("Frequency", "Hz", "Hz", Range::POSITIVE));
pub const NATURAL: NumberKind =
    at_least(LEAST_FREQUENCY, kind("Natural frequency", "Hz", "Hz", Range::NOT_NEGATIVE));
pub const RATIO: NumberKind = kind("Damping ratio", "1", "1", Range::NOT_NEGATIVE);
pub const MODAL_MASS: NumberKind = kind("Modal mass", "kg", "kg", Range::POSITIVE);
pub const SHARE: NumberKind = kind("Share of gravity", "1", "1", Range::FINITE);
pub const INNER_START: NumberKind = kind("Coordinate or rate at time 0", "1", "1", Range::FINITE);
pub const PHASE: NumberKind = kind("Phase at time 0", "rad", "rad", Range::FINITE);
pub const TIME: NumberKind = kind("Time", "s", "s", Range::FINITE);
pub const SWEPT: NumberKind =
    at_least(LEAST_FREQUENCY, kind("Frequency of a sweep's end", "Hz", "Hz", Range::NOT_NEGATIVE));
pub const DURATION: NumberKind = at_least(LEAST_TIME, kind("Duration of a sweep", "s", "s", Range::POSITIVE));
pub const PERIOD: NumberKind =
    at_least(LEAST_TIME, kind("Period of steps and record", "s", "s", Range::POSITIVE));
pub const DRIVEN_RATE: NumberKind = kind("Rate", "m/s", "rad/s", Range::FINITE);
pub const ACCELERATION: NumberKind = kind("Acceleration", "m/s2", "rad/s2", Range::FINITE);
/// A value of a signal that blocks read.
pub const SIGNAL: NumberKind =
    NumberKind { any_unit: true, ..kind("Value of a signal", "1", "1", Range::FINITE) };
pub const COEFFICIENT_OF_BLOCK: NumberKind = kind("Coefficient of a block", "1", "1", Range::FINITE);
pub const BLOCK_START: NumberKind = kind("State of a block at time 0", "1", "1", Range::FINITE);
pub const OUTPUT_LIMIT: NumberKind = kind("Limit of an output", "1", "1", Range::FINITE);
pub const SAMPLE: NumberKind = at_least(LEAST_TIME, kind("Time between samples", "s", "s", Range::POSITIVE));
pub const DELAY: NumberKind = kind("Time until outputs act", "s", "s", Range::NOT_NEGATIVE);
pub const FACTOR: NumberKind = kind("Force or torque per unit of the output", "N", "N.m", Range::FINITE);
const QUANTUM: NumberKind = kind("Step to which an input is rounded", "1", "1", Range::POSITIVE);

/// Kind of the step to which a block's input is rounded, given the input's SI unit.
pub const fn quantum(unit: &'static str) -> NumberKind {
    NumberKind { units: [unit, unit], ..QUANTUM }
}

/// A value of a record that has a scale.
pub const PLAIN: NumberKind = kind("Value of a record", "1", "1", Range::FINITE);

/// Kind of a record's scale, given the kind of its signal's values.
pub const fn scale_of(values: NumberKind) -> NumberKind {
    NumberKind { meaning: "Factor of a record's values", ..values }
}

/// Kind of a named parameter, given the SI unit of its value.
pub const fn named(unit: &'static str) -> NumberKind {
    kind("Named parameter", unit, unit, Range::FINITE)
}

/// Kind of a contact's stiffness, given the exponent of its force.
pub fn stiffness_of_power(exponent: f64) -> NumberKind {
    NumberKind { units: units_of_power(exponent), ..STIFFNESS }
}

/// Kind of the coefficient of a power of an elongation, or with `of_rate` of its rate.
pub fn coefficient_of_power(exponent: f64, of_rate: bool) -> NumberKind {
    if !of_rate {
        return kind_of("Coefficient of a power of e", units_of_power(exponent));
    }
    let units = match exponent {
        1.0 => DAMPING.units,
        2.0 => QUADRATIC_DAMPING.units,
        3.0 => CUBIC_DAMPING.units,
        _ => ["N.sp/mp", "N.m.sp/radp"],
    };
    kind_of("Coefficient of a power of e'", units)
}

const fn kind_of(meaning: &'static str, units: [&'static str; 2]) -> NumberKind {
    kind(meaning, units[0], units[1], Range::FINITE)
}

/// Units of a force divided by a power of a displacement.
fn units_of_power(exponent: f64) -> [&'static str; 2] {
    match exponent {
        1.0 => STIFFNESS.units,
        1.5 => ["N/m1.5", "N.m/rad1.5"],
        2.5 => ["N/m2.5", "N.m/rad2.5"],
        _ => {
            let known = CURVE.iter().zip(LOWEST..).find(|own| own.1 as f64 == exponent);
            known.map_or(["N/mp", "N.m/radp"], |own| own.0.1.units)
        }
    }
}

const fn arm(unit: &'static str) -> NumberKind {
    let mut arm = kind("Lever arm", unit, unit, Range::any("a finite number other than 0"));
    arm.not_zero = true;
    arm
}

const PLAIN_ARM: NumberKind = arm("1");
const LENGTH_ARM: NumberKind = arm("m");
const INVERSE_ARM: NumberKind = arm("1/m");

/// The kind of a body's arm in an elongation, by both dimensions.
pub fn arm_of(body: Dimension, elongation: Dimension) -> NumberKind {
    match (body, elongation) {
        (Dimension::Rotation, Dimension::Translation) => LENGTH_ARM,
        (Dimension::Translation, Dimension::Rotation) => INVERSE_ARM,
        _ => PLAIN_ARM,
    }
}

impl NumberKind {
    /// The SI unit for a dimension.
    pub fn unit(&self, dimension: Dimension) -> &'static str {
        self.units[usize::from(dimension == Dimension::Rotation)]
    }

    /// Whether a value in SI units is allowed.
    pub fn contains(&self, value: f64) -> bool {
        let too_small = value != 0.0 && value.abs() < self.least;
        self.range.contains(value) && !(self.not_zero && value == 0.0) && !too_small
    }

    /// The allowed values in a file, in words.
    pub fn allowed(&self, dimension: Dimension) -> String {
        let allowed = self.range.allowed.replace("finite ", "");
        let units: Vec<_> = symbols(self.unit(dimension)).collect();
        match units[0] {
            "1" if self.any_unit => format!("expected {allowed}, with or without a unit{}", self.or),
            "1" => format!("expected {allowed}{}", self.or),
            si => format!("expected {allowed} in {si}, or with a unit: {}{}", units.join(", "), self.or),
        }
    }

    /// The fault of a value in SI units that is refused.
    pub fn fault(&self, value: f64, dimension: Dimension) -> String {
        let Range { min, max, open_min, allowed } = self.range;
        if !value.is_finite() {
            return "must be a finite number".into();
        }
        if self.range.contains(value) && value != 0.0 {
            let unit = Some(self.unit(dimension)).filter(|unit| *unit != "1");
            let unit = unit.map_or(String::new(), |unit| format!(" {unit}"));
            let zero = if self.contains(0.0) { "0, or " } else { "" };
            return format!("must be {zero}at least {:e}{unit}", self.least);
        }
        let fault = match (min == 0.0 && max.is_infinite(), open_min) {
            (true, true) => "must be greater than 0".into(),
            (true, false) => "must not be negative".into(),
            _ if self.not_zero => "must not be 0".into(),
            _ => format!("expected {allowed}"),
        };
        let colon = if self.advice.is_empty() { "" } else { ": " };
        format!("{fault}{colon}{}", self.advice)
    }

    /// The fault of a text that is refused.
    pub fn fault_of(&self, text: &str, dimension: Dimension) -> String {
        let (text, si) = (text.trim(), self.unit(dimension));
        if let Some(found) = quantity_in(si, text) {
            return self.fault(found.value, dimension);
        }
        let with_point = text.replacen(',', ".", 1);
        if quantity_in(si, &with_point).is_some() {
            return format!("write a decimal point: \"{with_point}\"");
        }
        let units: Vec<_> = symbols(si).collect();
        match split(text) {
            Some(_) if si == "1" => format!("cannot have a unit; {}", self.allowed(dimension)),
            Some((_, unit)) => {
                let one_of = if units.len() > 1 { "one of " } else { "" };
                format!("cannot be in `{unit}`; expected {one_of}{}", units.join(", "))
            }
            None => self.allowed(dimension),
        }
    }
}

/// Some words as a list: "a, b or c".
pub(crate) fn one_of<T: AsRef<str>>(words: &[T]) -> String {
    let words: Vec<&str> = words.iter().map(AsRef::as_ref).collect();
    match words.split_last() {
        Some((last, before)) if !before.is_empty() => format!("{} or {last}", before.join(", ")),
        _ => words.concat(),
    }
}
