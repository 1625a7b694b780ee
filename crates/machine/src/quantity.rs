//! Quantities of bodies and elements: columns of a motion, outputs of an FMU, measures of studies.

use crate::description::{Block, Body, Description};
use crate::elements::{Action, Element};
pub use crate::what::What;

/// Owner of a quantity: a body or an element.
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
    /// Name, such as `BODY.s` or `ELEMENT.f`; unique in a machine.
    pub name: String,
    /// Meaning in words.
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

impl Block {
    /// Name of a quantity of the block.
    pub(crate) fn name_of(&self, what: What) -> String {
        let (own, states, outputs) = (&self.name, self.start.len(), self.outputs.len());
        match what {
            What::Output(j) => format!("{own}.{}", self.outputs[j]),
            What::State(k) if k < states => format!("{own}.x[{k}]"),
            What::State(k) if k < states + outputs => format!("{own}.{}.held", self.outputs[k - states]),
            What::State(k) => {
                let (turn, j) = ((k - states) / outputs - 1, (k - states) % outputs);
                format!("{own}.{}.next[{turn}]", self.outputs[j])
            }
            What::StateRate(k) => format!("{}.rate", self.name_of(What::State(k))),
            _ => own.clone(),
        }
    }
}

impl Description {
    /// All quantities: s, v, a of each body that is not a [coordinate](Body::is_inner) of a body
    /// with many coordinates; then the quantities of each element.
    pub fn quantities(&self) -> impl Iterator<Item = Quantity> {
        let bodies = (0..self.bodies.len()).filter(|&i| !self.bodies[i].is_inner());
        let bodies = bodies.flat_map(|i| What::OF_BODIES.map(|what| Quantity::of_body(i, what)));
        bodies.chain(self.elements().enumerate().flat_map(|(i, element)| {
            element.quantities().into_iter().map(move |what| Quantity::of_element(i, what))
        }))
    }

    /// All quantities in the order of [`quantities`](Self::quantities), with their names.
    ///
    ///
    /// ```
    /// use vibro_machine::file::{no_records, parse};
    ///
    /// let text = r#"
    ///     name = "Wheel"
    ///     body.wheel = { inertia = 0.1 }
    ///     spring.shaft = { between = ["ground", "wheel"], stiffness = 40.0 }
    /// "#;
    /// let machine = parse(text, "wheel.toml", &no_records)?;
    /// let named = machine.named_quantities();
    /// let names: Vec<_> = named.iter().map(|own| (own.name.as_str(), own.unit)).collect();
    /// assert_eq!(names[..3], [("wheel.s", "rad"), ("wheel.v", "rad/s"), ("wheel.a", "rad/s2")]);
    /// assert_eq!(names[3..], [("shaft.e", "rad"), ("shaft.rate", "rad/s"), ("shaft.f", "N.m")]);
    /// # Ok::<(), vibro_machine::Refusal>(())
    /// ```
    pub fn named_quantities(&self) -> Vec<NamedQuantity> {
        let elements: Vec<Element> = self.elements().collect();
        self.quantities().map(|quantity| self.named(quantity, &elements)).collect()
    }

    /// Quantities of a body that is a [coordinate](Body::is_inner) of a body with many
    /// coordinates, with their names; empty for other bodies.
    pub fn inner_quantities(&self, body: usize) -> Vec<NamedQuantity> {
        let is_inner = self.bodies.get(body).is_some_and(Body::is_inner);
        let whats = What::OF_BODIES.iter().filter(|_| is_inner);
        whats.map(|&what| self.named(Quantity::of_body(body, what), &[])).collect()
    }

    /// Names of the values that blocks keep, in the order of the first-order states.
    pub(crate) fn names_of_blocks(&self) -> Vec<String> {
        let of = |own: &Block| {
            let count = own.start.len() + own.kept();
            (0..count).map(|k| own.name_of(What::State(k))).collect::<Vec<_>>()
        };
        self.blocks.iter().flat_map(of).collect()
    }

    /// States of a block with their names, such as `pid.x[0]`. A sampled block also has the output
    /// that acts, `pid.u.held`, and delayed outputs, `pid.u.next[0]`. If `rates` is true, each
    /// state is followed by its rate.
    pub fn quantities_of_block(&self, block: usize, rates: bool) -> Vec<NamedQuantity> {
        let elements: Vec<Element> = self.elements().collect();
        let element = elements.len() - self.blocks.len() + block;
        let count = self.blocks[block].start.len() + self.blocks[block].kept();
        let of = |k: usize| {
            let whats = [What::State(k), What::StateRate(k)].into_iter().take(1 + usize::from(rates));
            whats.map(|what| self.named(Quantity::of_element(element, what), &elements)).collect::<Vec<_>>()
        };
        (0..count).flat_map(of).collect()
    }

    /// The sampled block whose samples alone change this quantity (a state or output), if any.
    pub fn sampled_block(&self, quantity: Quantity) -> Option<&Block> {
        let Owner::Element(element) = quantity.owner else { return None };
        let is_kept = matches!(quantity.what, What::State(_) | What::StateRate(_) | What::Output(_));
        let first = self.elements().count() - self.blocks.len();
        let block = self.blocks.get(element.checked_sub(first)?)?;
        Some(block).filter(|own| is_kept && own.sampling.is_some())
    }

    fn named(&self, quantity: Quantity, elements: &[Element]) -> NamedQuantity {
        let (name, dimension, element) = match quantity.owner {
            Owner::Body(i) => (self.bodies[i].name.as_str(), self.bodies[i].dimension, None),
            Owner::Element(i) => (elements[i].name(), elements[i].dimension(self), Some(elements[i])),
        };
        let what = quantity.what;
        let name = match element {
            Some(Element::Source(_)) => name.to_owned(),
            Some(Element::Block(block)) => block.name_of(what),
            _ => format!("{name}.{}", what.word()),
        };
        NamedQuantity { name, meaning: meaning(what, element), unit: what.unit(dimension), quantity }
    }
}

impl Element<'_> {
    /// Quantities of the element; each is a column, an FMU variable and a measure of studies.
    pub fn quantities(self) -> Vec<What> {
        match self.action() {
            Action::Tying | Action::Flexing => Vec::new(),
            Action::Driving => vec![What::F],
            Action::Giving => vec![What::Value],
            Action::Computing => self.outputs().map(What::Output).collect(),
            Action::Pressing => {
                let tangents = self.branches();
                let tangents = tangents.flat_map(|k| [What::TangentE(k), What::TangentF(k), What::Slider(k)]);
                [What::E, What::Rate, What::F].into_iter().chain(tangents).collect()
            }
            _ if self.series().is_some() => vec![What::E, What::Rate, What::F, What::Slider(None)],
            _ => vec![What::E, What::Rate, What::F],
        }
    }

    /// Indices of a block's outputs; empty for other elements.
    fn outputs(self) -> std::ops::Range<usize> {
        if let Self::Block(block) = self { 0..block.outputs.len() } else { 0..0 }
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
        What::TangentE(None) => "Elongation along the tangent",
        What::TangentE(Some(0)) => "Elongation along the first tangent",
        What::TangentE(Some(_)) => "Elongation along the second tangent",
        What::TangentF(None) => "Force against the elongation along the tangent",
        What::TangentF(Some(0)) => "Force against the elongation along the first tangent",
        What::TangentF(Some(_)) => "Force against the elongation along the second tangent",
        What::Slider(None) => "Inner place between spring and partner",
        What::Slider(Some(0)) => "Place of the slider along the first tangent",
        What::Slider(Some(_)) => "Place of the slider along the second tangent",
        What::SliderRate(None) => "Rate of the inner place",
        What::SliderRate(Some(0)) => "Rate of the slider along the first tangent",
        What::SliderRate(Some(_)) => "Rate of the slider along the second tangent",
        What::Value => "Value of the signal",
        What::Output(_) => "Output of the block",
        What::State(_) => "State of the block",
        What::StateRate(_) => "Rate of the state",
    }
}
