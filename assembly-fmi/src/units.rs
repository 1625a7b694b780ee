//! Units, display units, declared types and enumerations of the variables.

use crate::table::NO_UNIT;
use fmi_doors::description::{Item, Type, TypeKind, Unit};
use std::f64::consts::{PI, TAU};
use vibro_assembly::mode::{FrictionState, StopState};

/// A unit with its only declared type.
pub(crate) struct Declared {
    /// Name of the unit.
    pub unit: &'static str,
    /// Exponents of kg, m, s and rad.
    exponents: [i32; 4],
    /// Display units, each with the factor from the SI unit.
    display: &'static [(&'static str, f64)],
    name: &'static str,
    quantity: &'static str,
}

const fn declared(
    unit: &'static str,
    exponents: [i32; 4],
    display: &'static [(&'static str, f64)],
    name: &'static str,
    quantity: &'static str,
) -> Declared {
    Declared { unit, exponents, display, name, quantity }
}

/// The units of all variables.
#[rustfmt::skip]
pub(crate) const DECLARED: &[Declared] = &[
    declared("s", [0, 0, 1, 0], &[("ms", 1e3)], "Time", "Time"),
    declared("m", [0, 1, 0, 0], &[("mm", 1e3)], "Length", "Length"),
    declared("m/s", [0, 1, -1, 0], &[("mm/s", 1e3)], "Velocity", "Velocity"),
    declared("m/s2", [0, 1, -2, 0], &[("mm/s2", 1e3)], "Acceleration", "Acceleration"),
    declared("rad", [0, 0, 0, 1], &[("deg", 180.0 / PI)], "Angle", "Angle"),
    declared("rad/s", [0, 0, -1, 1], &[("rev/min", 60.0 / TAU)], "AngularVelocity", "AngularVelocity"),
    declared("rad/s2", [0, 0, -2, 1], &[], "AngularAcceleration", "AngularAcceleration"),
    declared("kg", [1, 0, 0, 0], &[("g", 1e3)], "Mass", "Mass"),
    declared("kg.m2", [1, 2, 0, 0], &[("g.cm2", 1e7)], "Inertia", "MomentOfInertia"),
    declared("N", [1, 1, -2, 0], &[("kN", 1e-3)], "Force", "Force"),
    declared("N.m", [1, 2, -2, 0], &[("N.mm", 1e3)], "Torque", "Torque"),
    declared("N/m", [1, 0, -2, 0], &[("N/mm", 1e-3)], "Stiffness", "TranslationalSpringConstant"),
    declared("N.m/rad", [1, 2, -2, -1], &[], "RotationalStiffness", "RotationalSpringConstant"),
    declared("N.s/m", [1, 0, -1, 0], &[], "Damping", "TranslationalDampingConstant"),
    declared("N.m.s/rad", [1, 2, -1, -1], &[], "RotationalDamping", "RotationalDampingConstant"),
    declared("N.s", [1, 1, -1, 0], &[("mN.s", 1e3)], "Impulse", "Impulse"),
    declared("N.m.s", [1, 2, -1, 0], &[], "AngularImpulse", "AngularImpulse"),
    declared("J", [1, 2, -2, 0], &[("mJ", 1e3)], "Energy", "Energy"),
    declared("Hz", [0, 0, -1, 0], &[("kHz", 1e-3)], "Frequency", "Frequency"),
    declared("1/m", [0, -1, 0, 0], &[], "InverseLength", "InverseLength"),
    declared("1", [0, 0, 0, 0], &[], "Number", "DimensionlessRatio"),
    declared(NO_UNIT, [0, 0, 0, 0], &[], "Sensitivity", ""),
];

const NUMBER: usize = DECLARED.len() - 2;

/// Units whose types have their first display unit as default.
const SHOWN: [&str; 2] = ["m", "rad"];

impl Declared {
    /// The declaration of a unit; that of `1` for an unknown unit.
    pub fn of(unit: &str) -> &'static Self {
        DECLARED.iter().find(|declared| declared.unit == unit).unwrap_or(&DECLARED[NUMBER])
    }

    /// The unit for a model description; `None` for matrices, whose elements have different units.
    pub fn unit(&self) -> Option<Unit> {
        if self.unit == NO_UNIT {
            return None;
        }
        let [kg, m, s, rad] = self.exponents;
        let display = self.display.iter().map(|(name, factor)| ((*name).into(), *factor));
        let exponents = [kg, m, s, 0, 0, 0, 0, rad];
        Some(Unit { name: self.unit.into(), exponents, display: display.collect() })
    }

    /// The type for a model description.
    pub fn declared_type(&self) -> Type {
        if self.unit == NO_UNIT {
            let kind = TypeKind::Real { quantity: None, unit: None, display_unit: None };
            let description =
                "Derivatives; each element has the SI unit of its row over that of its column".into();
            return Type { name: self.name.into(), description, kind };
        }
        let mut declared = Type::real(self.name, self.quantity, self.unit);
        if let TypeKind::Real { display_unit, .. } = &mut declared.kind {
            let usual = self.display.first().filter(|_| SHOWN.contains(&self.unit));
            *display_unit = usual.map(|(name, _)| (*name).into());
        }
        declared
    }
}

/// Names and meanings of a stop's states; values count from 1.
const STOP_STATES: [(&str, &str); 6] = [
    ("Open", "A rigid stop that does not touch"),
    ("Closed", "A rigid stop that is kept at its gap"),
    ("Below", "A compliant stop that does not touch"),
    ("Pressed", "A compliant stop with its spring's and its dashpot's force"),
    ("Free", "A compliant stop beyond its gap whose force would pull: there is none"),
    ("Capped", "A compliant stop whose dashpot's share is as large as its spring's"),
];

/// Names and meanings of a friction's states; values count from 1.
const FRICTION_STATES: [(&str, &str); 4] = [
    ("Off", "Its level is not positive"),
    ("SlippingUp", "The elongation grows"),
    ("SlippingDown", "The elongation falls"),
    ("Sticking", "The elongation stays"),
];

/// The value of a stop's state.
pub(crate) fn stop_state(state: StopState) -> f64 {
    match state {
        StopState::Open => 1.0,
        StopState::Closed => 2.0,
        StopState::Below => 3.0,
        StopState::Pressed => 4.0,
        StopState::Free => 5.0,
        StopState::Capped => 6.0,
    }
}

/// The value of a friction's state.
pub(crate) fn friction_state(state: FrictionState) -> f64 {
    match state {
        FrictionState::Off => 1.0,
        FrictionState::Up => 2.0,
        FrictionState::Down => 3.0,
        FrictionState::Stuck | FrictionState::HeldUp | FrictionState::HeldDown => 4.0,
    }
}

/// Name of the enumeration of stop states.
pub(crate) const STOP_STATE: &str = "StopState";
/// Name of the enumeration of friction states.
pub(crate) const FRICTION_STATE: &str = "FrictionState";

/// The declared enumerations.
pub(crate) fn enumerations() -> [Type; 2] {
    let items = |states: &[(&'static str, &'static str)]| {
        let item = |(i, (name, text)): (usize, &(&'static str, &'static str))| Item {
            name: (*name).into(),
            value: i as i32 + 1,
            description: (*text).into(),
        };
        TypeKind::Enumeration(states.iter().enumerate().map(item).collect())
    };
    [
        Type { name: STOP_STATE.into(), description: "State of a stop".into(), kind: items(&STOP_STATES) },
        Type {
            name: FRICTION_STATE.into(),
            description: "State of a friction".into(),
            kind: items(&FRICTION_STATES),
        },
    ]
}
