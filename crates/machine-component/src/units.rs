//! Units, display units, declared types and enumerations of the variables.

use crate::table::NO_UNIT;
use fmi_doors::description::{Item, Type, TypeKind, Unit};
use std::f64::consts::{PI, TAU};
use vibro_machine::mode::{FrictionState, SliderState, StopState};

/// A unit and its declared type.
pub(crate) struct Declared {
    /// The unit's name.
    pub unit: &'static str,
    /// Exponents of kg, m, s and rad.
    exponents: [i32; 4],
    /// Display units, and the factor from the SI unit to each.
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
    declared("N/m2", [1, -1, -2, 0], &[], "StiffnessOfSquare", ""),
    declared("N.m/rad2", [1, 2, -2, -2], &[], "RotationalStiffnessOfSquare", ""),
    declared("N/m3", [1, -2, -2, 0], &[], "StiffnessOfCube", ""),
    declared("N.m/rad3", [1, 2, -2, -3], &[], "RotationalStiffnessOfCube", ""),
    declared("N/m4", [1, -3, -2, 0], &[], "StiffnessOfFourthPower", ""),
    declared("N.m/rad4", [1, 2, -2, -4], &[], "RotationalStiffnessOfFourthPower", ""),
    declared("N/m5", [1, -4, -2, 0], &[], "StiffnessOfFifthPower", ""),
    declared("N.m/rad5", [1, 2, -2, -5], &[], "RotationalStiffnessOfFifthPower", ""),
    declared("N.s3/m3", [1, -2, 1, 0], &[], "DampingOfCube", ""),
    declared("N.m.s3/rad3", [1, 2, 1, -3], &[], "RotationalDampingOfCube", ""),
    declared("N.s2/m2", [1, -1, 0, 0], &[], "DampingOfSquare", ""),
    declared("N.m.s2/rad2", [1, 2, 0, -2], &[], "RotationalDampingOfSquare", ""),
    declared("s/m", [0, -1, 1, 0], &[], "InverseVelocity", ""),
    declared("s/rad", [0, 0, 1, -1], &[], "InverseAngularVelocity", ""),
    declared("N.s", [1, 1, -1, 0], &[("mN.s", 1e3)], "Impulse", "Impulse"),
    declared("N.m.s", [1, 2, -1, 0], &[], "AngularImpulse", "AngularImpulse"),
    declared("J", [1, 2, -2, 0], &[("mJ", 1e3)], "Energy", "Energy"),
    declared("Hz", [0, 0, -1, 0], &[("kHz", 1e-3)], "Frequency", "Frequency"),
    declared("1/m", [0, -1, 0, 0], &[], "InverseLength", "InverseLength"),
    declared("1/s", [0, 0, -1, 0], &[], "Rate", "Frequency"),
    declared(POWER, [0, 0, 0, 0], &[], "PowerCoefficient", ""),
    declared("1", [0, 0, 0, 0], &[], "Number", "DimensionlessRatio"),
    declared(NO_UNIT, [0, 0, 0, 0], &[], "Sensitivity", ""),
];

/// Units that FMI cannot declare, as their exponents are not integers; the last letter of the
/// others is the exponent of a file.
const POWERS: [&str; 8] =
    ["N/m1.5", "N/m2.5", POWER, "N.m/rad1.5", "N.m/rad2.5", "N.m/radp", "N.sp/mp", "N.m.sp/radp"];
/// The unit under which [`POWERS`] are listed.
const POWER: &str = "N/mp";

const NUMBER: usize = DECLARED.len() - 2;

/// Units whose first display unit is the default.
const SHOWN: [&str; 2] = ["m", "rad"];

impl Declared {
    /// Returns the declaration of a unit; for an unknown unit, the declaration of pure numbers.
    pub fn of(unit: &str) -> &'static Self {
        let unit = if POWERS.contains(&unit) { POWER } else { unit };
        DECLARED.iter().find(|declared| declared.unit == unit).unwrap_or(&DECLARED[NUMBER])
    }

    /// Returns the `Unit` element; `None` for matrices, whose elements have different units, and for
    /// units with exponents that are not integers.
    pub fn unit(&self) -> Option<Unit> {
        if [NO_UNIT, POWER].contains(&self.unit) {
            return None;
        }
        let [kg, m, s, rad] = self.exponents;
        let display = self.display.iter().map(|(name, factor)| ((*name).into(), *factor));
        let exponents = [kg, m, s, 0, 0, 0, 0, rad];
        Some(Unit { name: self.unit.into(), exponents, display: display.collect() })
    }

    /// The `SimpleType` or `Float64Type` element.
    pub fn declared_type(&self) -> Type {
        if [NO_UNIT, POWER].contains(&self.unit) {
            let kind = TypeKind::Real { quantity: None, unit: None, display_unit: None };
            let description = match self.unit {
                POWER => "Coefficient of a power, in SI: its unit has an exponent that is not an integer",
                _ => "Derivatives; each element has the SI unit of its row over that of its column",
            };
            let description = description.into();
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

/// Names and descriptions of the states of stops; the value is the index, counted from 1.
const STOP_STATES: [(&str, &str); 7] = [
    ("Open", "A rigid stop that does not touch"),
    ("Closed", "A rigid stop that is kept at its gap"),
    ("Below", "A compliant stop that does not touch"),
    ("Pressed", "A compliant stop with its spring's and its dashpot's force"),
    ("Free", "A compliant stop beyond its gap whose force would pull: there is none"),
    ("Capped", "A compliant stop whose dashpot's share is as large as its spring's"),
    ("Rebounding", "A compliant stop that rebounds with its spring's force alone"),
];

/// Names and descriptions of the states of friction elements; the value is the index, counted from
/// 1.
const FRICTION_STATES: [(&str, &str); 4] = [
    ("Off", "Its level is not positive"),
    ("SlippingUp", "The elongation grows"),
    ("SlippingDown", "The elongation falls"),
    ("Sticking", "The elongation stays"),
];

/// Returns the enumeration value of a stop's state.
pub(crate) fn stop_state(state: StopState) -> f64 {
    match state {
        StopState::Open => 1.0,
        StopState::Closed => 2.0,
        // A stop with stepped stiffness has the state of its part at the present level.
        StopState::Below | StopState::Off => 3.0,
        StopState::Pressed => 4.0,
        StopState::Free => 5.0,
        StopState::Capped => 6.0,
        StopState::Rebounding => 7.0,
    }
}

/// Returns the enumeration value of a friction element's state.
pub(crate) fn friction_state(state: FrictionState) -> f64 {
    match state {
        FrictionState::Off => 1.0,
        FrictionState::Up => 2.0,
        FrictionState::Down => 3.0,
        FrictionState::Stuck | FrictionState::HeldUp | FrictionState::HeldDown => 4.0,
    }
}

/// Returns the enumeration value of a slider's state, among the states of friction elements.
pub(crate) fn slider_state(state: SliderState) -> f64 {
    match state {
        SliderState::Off => 1.0,
        SliderState::Up => 2.0,
        SliderState::Down => 3.0,
        SliderState::Held => 4.0,
    }
}

/// Type name of the states of stops.
pub(crate) const STOP_STATE: &str = "StopState";
/// Type name of the states of friction elements.
pub(crate) const FRICTION_STATE: &str = "FrictionState";

/// Returns the declared enumeration types. `rebounds`: whether stops may have the last state,
/// `Rebounding`.
pub(crate) fn enumerations(rebounds: bool) -> [Type; 2] {
    let states = if rebounds { &STOP_STATES[..] } else { &STOP_STATES[..STOP_STATES.len() - 1] };
    let items = |states: &[(&'static str, &'static str)]| {
        let item = |(i, (name, text)): (usize, &(&'static str, &'static str))| Item {
            name: (*name).into(),
            value: i as i32 + 1,
            description: (*text).into(),
        };
        TypeKind::Enumeration(states.iter().enumerate().map(item).collect())
    };
    [
        Type { name: STOP_STATE.into(), description: "State of a stop".into(), kind: items(states) },
        Type {
            name: FRICTION_STATE.into(),
            description: "State of a friction or a slider".into(),
            kind: items(&FRICTION_STATES),
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use vibro_numerics::quantities::quantity_in;

    /// The states' names in the engine are the names of the enumeration.
    #[test]
    fn invariant_the_value_of_a_state_is_the_place_of_its_name() {
        let [stops, frictions] = enumerations(true).map(|declared| match declared.kind {
            TypeKind::Enumeration(items) => items,
            _ => panic!("{}", declared.name),
        });
        let name = |items: &[Item], value: f64| {
            let found: Vec<&Item> = items.iter().filter(|item| f64::from(item.value) == value).collect();
            assert_eq!(found.len(), 1, "{value}");
            found[0].name.to_string()
        };
        use StopState::{Below, Capped, Closed, Free, Open, Pressed, Rebounding};
        for state in [Open, Closed, Below, Pressed, Free, Capped, Rebounding] {
            assert_eq!(name(&stops, stop_state(state)), format!("{state:?}"));
        }
        use FrictionState::{Down, HeldDown, HeldUp, Off, Stuck, Up};
        for (state, expected) in [
            (Off, "Off"),
            (Up, "SlippingUp"),
            (Down, "SlippingDown"),
            (Stuck, "Sticking"),
            (HeldUp, "Sticking"),
            (HeldDown, "Sticking"),
        ] {
            assert_eq!(name(&frictions, friction_state(state)), expected);
        }
        assert_eq!((stops.len(), frictions.len()), (7, 4));
    }

    #[test]
    fn second_method_display_units_are_as_large_as_files_have_them() {
        let mut read = 0;
        for declared in DECLARED {
            for (name, factor) in declared.display {
                let written = name
                    .replace("rev/min", "rpm")
                    .replace("s2", "s²")
                    .replace("cm2", "cm²")
                    .replace('.', " ");
                let plain = name.replace("rev/min", "rpm").replace('.', " ");
                let Some(one) =
                    [plain, written].iter().find_map(|unit| quantity_in(declared.unit, &format!("1 {unit}")))
                else {
                    continue;
                };
                read += 1;
                assert!((one.value * factor - 1.0).abs() < 1e-12, "{name}: {} {factor}", one.value);
            }
        }
        assert!(read >= 12, "{read}");
        let shown = |unit: &str| match Declared::of(unit).declared_type().kind {
            TypeKind::Real { display_unit, .. } => display_unit.map(|unit| unit.to_string()),
            _ => None,
        };
        assert_eq!(
            (shown("m").as_deref(), shown("rad").as_deref(), shown("N"), shown("")),
            (Some("mm"), Some("deg"), None, None)
        );
        assert_eq!((Declared::of("kg").unit, Declared::of("no unit").unit), ("kg", "1"));
        assert!(Declared::of(NO_UNIT).unit().is_none());
    }
}
