//! Quantities of bodies and elements: columns of a motion, outputs of an FMU, measures of studies.

use crate::description::{Body, Description, Dimension};
use crate::elements::{Action, Element};

/// Kind of a quantity of a body or an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum What {
    /// A body's coordinate.
    S,
    /// The rate of a body's coordinate.
    V,
    /// A body's acceleration.
    A,
    /// An element's elongation.
    E,
    /// The rate of an element's elongation.
    Rate,
    /// An element's force, which resists its elongation; a load's force on its body.
    F,
    /// The inner place of a spring in series, in the unit of its elongation.
    Slider,
    /// The rate of this inner place: a derivative of FMUs, no column.
    SliderRate,
}

impl What {
    /// All kinds of columns.
    pub const ALL: [Self; 7] = [Self::S, Self::V, Self::A, Self::E, Self::Rate, Self::F, Self::Slider];

    /// The kinds that bodies have.
    pub const OF_BODIES: [Self; 3] = [Self::S, Self::V, Self::A];

    /// The last part of a quantity's name.
    pub fn word(self) -> &'static str {
        match self {
            Self::S => "s",
            Self::V => "v",
            Self::A => "a",
            Self::E => "e",
            Self::Rate => "rate",
            Self::F => "f",
            Self::Slider => "slider",
            Self::SliderRate => "slider.rate",
        }
    }

    /// SI unit.
    pub fn unit(self, dimension: Dimension) -> &'static str {
        let units = match self {
            Self::S | Self::E | Self::Slider => ["m", "rad"],
            Self::V | Self::Rate | Self::SliderRate => ["m/s", "rad/s"],
            Self::A => ["m/s2", "rad/s2"],
            Self::F => ["N", "N.m"],
        };
        units[usize::from(dimension == Dimension::Rotation)]
    }
}

/// Body or element that a quantity belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Owner {
    /// Index in [`Description::bodies`].
    Body(usize),
    /// Index in [`Description::elements`].
    Element(usize),
}

/// A quantity of a machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Quantity {
    /// Body or element.
    pub owner: Owner,
    /// Kind.
    pub what: What,
}

/// A quantity with name, meaning and unit.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedQuantity {
    /// `BODY.s`, `ELEMENT.f` and so on; unique in a machine.
    pub name: String,
    /// Its meaning in words.
    pub meaning: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Owner and kind.
    pub quantity: Quantity,
}

impl Quantity {
    /// A quantity of the body with this index.
    pub fn of_body(body: usize, what: What) -> Self {
        Self { owner: Owner::Body(body), what }
    }

    /// A quantity of the element with this index in [`Description::elements`].
    pub fn of_element(element: usize, what: What) -> Self {
        Self { owner: Owner::Element(element), what }
    }
}

impl Description {
    /// All quantities: s, v, a of each body that is no [coordinate](Body::is_inner) of a body with
    /// many, then those of each element.
    pub fn quantities(&self) -> impl Iterator<Item = Quantity> {
        let bodies = (0..self.bodies.len()).filter(|&i| !self.bodies[i].is_inner());
        let bodies = bodies.flat_map(|i| What::OF_BODIES.map(|what| Quantity::of_body(i, what)));
        bodies.chain(self.elements().enumerate().flat_map(|(i, element)| {
            element.quantities().iter().map(move |&what| Quantity::of_element(i, what))
        }))
    }

    /// All quantities in the order of [`quantities`](Self::quantities), with their names.
    pub fn named_quantities(&self) -> Vec<NamedQuantity> {
        let elements: Vec<Element> = self.elements().collect();
        self.quantities().map(|quantity| self.named(quantity, &elements)).collect()
    }

    /// The quantities of a body that is a [coordinate](Body::is_inner) of one with many, with their
    /// names; none of others.
    pub fn inner_quantities(&self, body: usize) -> Vec<NamedQuantity> {
        let is_inner = self.bodies.get(body).is_some_and(Body::is_inner);
        let whats = What::OF_BODIES.iter().filter(|_| is_inner);
        whats.map(|&what| self.named(Quantity::of_body(body, what), &[])).collect()
    }

    fn named(&self, quantity: Quantity, elements: &[Element]) -> NamedQuantity {
        let (name, dimension, element) = match quantity.owner {
            Owner::Body(i) => (self.bodies[i].name.as_str(), self.bodies[i].dimension, None),
            Owner::Element(i) => (elements[i].name(), elements[i].dimension(self), Some(elements[i])),
        };
        let what = quantity.what;
        let name = format!("{name}.{}", what.word());
        NamedQuantity { name, meaning: meaning(what, element), unit: what.unit(dimension), quantity }
    }
}

impl Element<'_> {
    /// Its quantities, each a column, an FMU variable and a measure of studies.
    pub fn quantities(self) -> &'static [What] {
        match self.action() {
            Action::Tying | Action::Flexing => &[],
            Action::Driving => &[What::F],
            _ if self.series().is_some() => &[What::E, What::Rate, What::F, What::Slider],
            _ => &[What::E, What::Rate, What::F],
        }
    }
}

/// The meaning of a quantity in words.
pub fn meaning(what: What, element: Option<Element>) -> &'static str {
    match what {
        What::S => "Coordinate",
        What::V => "Rate of the coordinate",
        What::A => "Acceleration",
        What::E => "Elongation",
        What::Rate => "Rate of the elongation",
        What::F if element.is_some_and(|e| e.action() == Action::Driving) => "Force or torque",
        What::F => "Force against the elongation",
        What::Slider => "Inner place between spring and partner",
        What::SliderRate => "Rate of the inner place",
    }
}
