//! Units, display units and declared types of the variables.

use std::f64::consts::{PI, TAU};

/// A display unit: `display = factor * value`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplayUnit {
    /// Name, e.g. `mm`.
    pub name: &'static str,
    /// Factor from the unit to this display unit.
    pub factor: f64,
}

/// A unit and its exponents of the SI base units. Every unit here is coherent, so factor is 1 and
/// offset is 0. Exponents of A, K, mol and cd are always zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Name, e.g. `N.s/m`.
    pub name: &'static str,
    /// Exponent of kg.
    pub kg: i32,
    /// Exponent of m.
    pub m: i32,
    /// Exponent of s.
    pub s: i32,
    /// Exponent of rad.
    pub rad: i32,
    /// Display units for the user's choice.
    pub display: &'static [DisplayUnit],
}

const fn unit(
    name: &'static str,
    kg: i32,
    m: i32,
    s: i32,
    rad: i32,
    display: &'static [DisplayUnit],
) -> Unit {
    Unit { name, kg, m, s, rad, display }
}

const fn display(name: &'static str, factor: f64) -> DisplayUnit {
    DisplayUnit { name, factor }
}

/// Every unit a variable uses.
#[rustfmt::skip]
pub const UNITS: &[Unit] = &[
    unit("s", 0, 0, 1, 0, &[display("ms", 1e3)]),
    unit("m", 0, 1, 0, 0, &[display("mm", 1e3)]),
    unit("m/s", 0, 1, -1, 0, &[display("mm/s", 1e3)]),
    unit("m/s2", 0, 1, -2, 0, &[display("mm/s2", 1e3)]),
    unit("kg", 1, 0, 0, 0, &[display("g", 1e3)]),
    unit("N", 1, 1, -2, 0, &[display("mN", 1e3)]),
    unit("N/m", 1, 0, -2, 0, &[display("N/mm", 1e-3)]),
    unit("N.s/m", 1, 0, -1, 0, &[]),
    unit("N.s", 1, 1, -1, 0, &[display("mN.s", 1e3)]),
    unit("J", 1, 2, -2, 0, &[display("mJ", 1e3)]),
    unit("rad", 0, 0, 0, 1, &[display("deg", 180.0 / PI)]),
    unit("rad/s", 0, 0, -1, 1, &[display("Hz", 1.0 / TAU), display("rev/min", 60.0 / TAU)]),
    unit("1", 0, 0, 0, 0, &[]),
];

/// A declared Real type.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RealType {
    /// Its name.
    pub name: &'static str,
    /// Physical quantity, if it is the same for all elements.
    pub quantity: Option<&'static str>,
    /// Name of its [`Unit`], if it is the same for all elements.
    pub unit: Option<&'static str>,
    /// Default display unit.
    pub display_unit: Option<&'static str>,
    /// Description.
    pub description: &'static str,
}

/// One item of an enumeration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Item {
    /// Its name.
    pub name: &'static str,
    /// Its value; items count from 1 without gaps.
    pub value: i32,
    /// Meaning.
    pub description: &'static str,
}

/// A declared enumeration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EnumerationType {
    /// Its name.
    pub name: &'static str,
    /// Description.
    pub description: &'static str,
    /// Its items.
    pub items: &'static [Item],
    /// Text of the items, for messages.
    pub allowed: &'static str,
}

const fn real(
    name: &'static str,
    quantity: &'static str,
    unit: &'static str,
    display_unit: Option<&'static str>,
    description: &'static str,
) -> RealType {
    RealType { name, quantity: Some(quantity), unit: Some(unit), display_unit, description }
}

/// Declares the Real types as constants, and the list [`REAL_TYPES`] of all of them.
macro_rules! real_types {
    ($($(#[$doc:meta])* $name:ident = $value:expr;)*) => {
        $($(#[$doc])* pub const $name: RealType = $value;)*

        /// Every declared Real type, in the order of the description.
        pub const REAL_TYPES: &[RealType] = &[$($name),*];
    };
}

real_types! {
    /// Time.
    TIME = real("Time", "Time", "s", None, "Time");
    /// Displacement.
    POSITION = real("Position", "Length", "m", Some("mm"), "Displacement from the unstressed position");
    /// Velocity.
    VELOCITY = real("Velocity", "Velocity", "m/s", None, "Velocity");
    /// Acceleration.
    ACCELERATION = real("Acceleration", "Acceleration", "m/s2", None, "Acceleration");
    /// Mass.
    MASS = real("Mass", "Mass", "kg", None, "Mass");
    /// Force.
    FORCE = real("Force", "Force", "N", None, "Force");
    /// Stiffness.
    STIFFNESS = real("Stiffness", "TranslationalSpringConstant", "N/m", None, "Stiffness of a linear spring");
    /// Damping.
    DAMPING = real("Damping", "TranslationalDampingConstant", "N.s/m", None, "Coefficient of a viscous damper");
    /// Impulse.
    IMPULSE = real("Impulse", "Impulse", "N.s", None, "Impulse of an impact");
    /// Energy.
    ENERGY = real("Energy", "Energy", "J", None, "Energy");
    /// Angle.
    ANGLE = real("Angle", "Angle", "rad", Some("deg"), "Angle");
    /// Angular frequency.
    ANGULAR_FREQUENCY = real("AngularFrequency", "AngularVelocity", "rad/s", Some("Hz"), "Angular frequency");
    /// Dimensionless number.
    NUMBER = real("Number", "DimensionlessRatio", "1", None, "Dimensionless number");

    /// Derivatives of states with respect to states or loads; the units differ from element to
    /// element.
    SENSITIVITY = RealType {
        name: "Sensitivity",
        quantity: None,
        unit: None,
        display_unit: None,
        description: "Derivatives with respect to states or loads; each element has the SI unit of its row over that of its column",
    };
}

/// Method that gives the motion (variable `mode`).
pub const MODE: EnumerationType = EnumerationType {
    name: "Mode",
    description: "How the motion is obtained",
    allowed: "1 (EventDriven), 2 (MultipleScales) or 3 (ExactOrbit)",
    items: &[
        Item {
            name: "EventDriven",
            value: 1,
            description: "Simulation: exact flow between events, every impact located",
        },
        Item {
            name: "MultipleScales",
            value: 2,
            description: "Closed-form steady state by multiple scales with a sawtooth, to leading order in epsilon",
        },
        Item {
            name: "ExactOrbit",
            value: 3,
            description: "Closed-form periodic orbit with two impacts per drive period, exact at any epsilon",
        },
    ],
};

/// State of contact (variable `stop.state`).
pub const CONTACT: EnumerationType = EnumerationType {
    name: "ContactState",
    description: "Whether the block flies or rests against a stop",
    allowed: "1 (Flight), 2 (RestUpper) or 3 (RestLower)",
    items: &[
        Item { name: "Flight", value: 1, description: "The block is free between the stops" },
        Item { name: "RestUpper", value: 2, description: "The block rests against the upper stop" },
        Item { name: "RestLower", value: 3, description: "The block rests against the lower stop" },
    ],
};

/// Stop of an impact (variable `impacts.clocked.side`).
pub const SIDE: EnumerationType = EnumerationType {
    name: "Side",
    description: "Stop of an impact",
    allowed: "1 (Lower), 2 (None) or 3 (Upper)",
    items: &[
        Item { name: "Lower", value: 1, description: "The lower stop" },
        Item { name: "None", value: 2, description: "There was no impact" },
        Item { name: "Upper", value: 3, description: "The upper stop" },
    ],
};

/// Every declared enumeration.
pub const ENUMERATION_TYPES: &[EnumerationType] = &[MODE, CONTACT, SIDE];

/// The unit with a name.
pub fn find(name: &str) -> Option<&'static Unit> {
    UNITS.iter().find(|unit| unit.name == name)
}
