//! All elements of a machine in one list, and all its signals in another.
//!
//! Columns, FMU variables, checks and sketches do not depend on kinds of elements. This module has
//! the common properties of all elements: name, section of the file, elongation, quantities,
//! signals. `CONTRIBUTING.md` lists the requirements of a new kind.

mod inputs;

use crate::description::{
    Arms, Block, Body, BodyKind, Contact, Damper, Description, Dimension, Freewheel, Friction, Integrated,
    Link, Load, Matrix, Modal, Series, Signal, Source, Spring, Stop, StopLaw, Tangent,
};
use crate::formula::Formula;
use crate::what::What;
use std::borrow::Cow;
use std::ops::Range;

/// An element of a machine.
///
///
/// ```
/// use vibro_machine::elements::Action;
/// use vibro_machine::file::{no_records, parse};
///
/// let text = r#"
///     name = "Hammer"
///     body.ram = { mass = 1.0 }
///     load.push = { on = "ram", constant = 5.0 }
///     stop.anvil = { between = ["ground", "ram"], gap = 0.1, restitution = 0.3 }
/// "#;
/// let machine = parse(text, "hammer.toml", &no_records)?;
/// let all: Vec<_> = machine.elements().map(|own| (own.dotted(), own.action())).collect();
/// let (stop, load) = ("stop.anvil".to_owned(), "load.push".to_owned());
/// assert_eq!(all, [(stop, Action::Hitting), (load, Action::Driving)]);
/// # Ok::<(), vibro_machine::Refusal>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Element<'a> {
    /// A spring with its dashpot.
    Spring(&'a Spring),
    /// A dashpot without a spring.
    Damper(&'a Damper),
    /// Stiffness and damping of a body in modal coordinates.
    Modal(&'a Modal),
    /// Stiffness, damping and gyroscopic forces of a body with matrices.
    Matrix(&'a Matrix),
    /// A one-sided contact.
    Stop(&'a Stop),
    /// Coulomb friction.
    Friction(&'a Friction),
    /// A contact with a normal stiffness, and friction along one or two tangents.
    Contact(&'a Contact),
    /// A freewheel.
    Freewheel(&'a Freewheel),
    /// A rigid link.
    Link(&'a Link),
    /// A force or torque on a body.
    Load(&'a Load),
    /// A signal that blocks read.
    Source(&'a Source),
    /// A linear block.
    Block(&'a Block),
}

/// How the force of an element follows from the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// A single function of elongation and rate: linear, unless the element is
    /// [curved](Element::is_curved).
    Linear,
    /// A linear function of elongation and rate in each state of the element.
    Switching,
    /// A constraint force while a contact is closed; impacts when it closes.
    Hitting,
    /// A given friction level while slipping, a constraint force while sticking.
    Rubbing,
    /// A normal force while a contact is closed; along each tangent a spring with a slider.
    Pressing,
    /// Forces among the coordinates of one body.
    Flexing,
    /// A constraint force at all times.
    Tying,
    /// A signal of time, or an output of a block.
    Driving,
    /// No force: a signal that blocks read.
    Giving,
    /// No force: a block.
    Computing,
}

/// Sections of a file that hold elements, each with its plural, in the order of every list of
/// elements.
pub const SECTIONS: [(&str, &str); 12] = [
    ("spring", "springs"),
    ("damper", "dampers"),
    ("modal", "modal bodies"),
    ("matrix", "bodies with matrices"),
    ("stop", "stops"),
    ("friction", "frictions"),
    ("contact", "contacts"),
    ("freewheel", "freewheels"),
    ("link", "links"),
    ("load", "loads"),
    ("signal", "signals"),
    ("block", "blocks"),
];

impl<'a> Element<'a> {
    /// Name, unique among the elements of a machine.
    pub fn name(self) -> &'a str {
        match self {
            Self::Spring(spring) => &spring.name,
            Self::Damper(damper) => &damper.name,
            Self::Modal(modal) => &modal.name,
            Self::Matrix(matrix) => &matrix.name,
            Self::Stop(stop) => &stop.name,
            Self::Friction(friction) => &friction.name,
            Self::Contact(contact) => &contact.name,
            Self::Freewheel(wheel) => &wheel.name,
            Self::Link(link) => &link.name,
            Self::Load(load) => &load.name,
            Self::Source(source) => &source.name,
            Self::Block(block) => &block.name,
        }
    }

    /// Section of the file.
    pub fn section(self) -> &'static str {
        match self {
            Self::Spring(_) => "spring",
            Self::Damper(_) => "damper",
            Self::Modal(_) => "modal",
            Self::Matrix(_) => "matrix",
            Self::Stop(_) => "stop",
            Self::Friction(_) => "friction",
            Self::Contact(_) => "contact",
            Self::Freewheel(_) => "freewheel",
            Self::Link(_) => "link",
            Self::Load(_) => "load",
            Self::Source(_) => "signal",
            Self::Block(_) => "block",
        }
    }

    /// Section and name, such as `stop.upper`.
    pub fn dotted(self) -> String {
        format!("{}.{}", self.section(), self.name())
    }

    /// Arms of the elongation, for a contact along its normal; `None` for a load (which acts on
    /// one coordinate), a body with many coordinates, a signal or a block.
    pub fn arms(self) -> Option<&'a Arms> {
        match self {
            Self::Spring(spring) => Some(&spring.arms),
            Self::Damper(damper) => Some(&damper.arms),
            Self::Stop(stop) => Some(&stop.arms),
            Self::Friction(friction) => Some(&friction.arms),
            Self::Contact(contact) => Some(&contact.normal),
            Self::Freewheel(wheel) => Some(&wheel.arms),
            Self::Link(link) => Some(&link.arms),
            Self::Load(_) | Self::Modal(_) | Self::Matrix(_) => None,
            Self::Source(_) | Self::Block(_) => None,
        }
    }

    /// All arms: of the elongation, and of a contact's tangents.
    pub fn all_arms(self) -> impl Iterator<Item = &'a Arms> {
        self.arms().into_iter().chain(self.tangents().iter().map(|tangent| &tangent.arms))
    }

    /// The tangents of a contact; empty for other elements.
    pub fn tangents(self) -> &'a [Tangent] {
        if let Self::Contact(contact) = self { &contact.tangents } else { &[] }
    }

    /// Dimension of force and elongation.
    pub fn dimension(self, machine: &Description) -> Dimension {
        let of_body = |load: &Load| machine.bodies.get(load.body).map(|body| body.dimension);
        match self {
            Self::Load(load) => of_body(load).unwrap_or(Dimension::Translation),
            _ => self.arms().map_or(Dimension::Translation, |arms| arms.dimension),
        }
    }

    /// How the force follows from the state.
    pub fn action(self) -> Action {
        match self {
            Self::Spring(spring) if spring.points.len() > 2 || spring.stepped.is_some() => Action::Switching,
            Self::Spring(_) | Self::Damper(_) => Action::Linear,
            Self::Stop(Stop { law: StopLaw::Rigid { .. }, .. }) | Self::Freewheel(_) => Action::Hitting,
            Self::Stop(Stop { law: StopLaw::Compliant { .. }, .. }) => Action::Switching,
            Self::Modal(_) | Self::Matrix(_) => Action::Flexing,
            Self::Friction(_) => Action::Rubbing,
            Self::Contact(_) => Action::Pressing,
            Self::Link(_) => Action::Tying,
            Self::Load(_) => Action::Driving,
            Self::Source(_) => Action::Giving,
            Self::Block(_) => Action::Computing,
        }
    }

    /// Whether the force is a curve of the elongation or of its rate, at least in one state.
    pub fn is_curved(self) -> bool {
        match self {
            Self::Spring(spring) => spring.is_curved(),
            Self::Damper(damper) => damper.is_curved(),
            Self::Stop(stop) => stop.contact.is_some(),
            Self::Friction(friction) => friction.stribeck.is_some(),
            _ => false,
        }
    }

    /// Whether this is a friction whose force depends on its rate while it slips.
    pub fn rubs_by_rate(self) -> bool {
        matches!(self, Self::Friction(own) if own.stribeck.is_some() || own.viscous.is_some())
    }

    /// The formula in the force.
    pub(crate) fn formula(self) -> Option<Cow<'a, Formula>> {
        match self {
            Self::Spring(spring) => spring.formula(),
            Self::Damper(damper) => damper.force.as_ref().map(Cow::Borrowed),
            _ => None,
        }
    }

    /// Indices of the bodies that are the coordinates of this element; empty if it has none.
    pub fn coordinates(self) -> Range<usize> {
        match self {
            Self::Modal(own) => own.first..own.first + own.frequencies.len(),
            Self::Matrix(own) => own.first..own.first + own.given.mass.nrows(),
            _ => 0..0,
        }
    }

    /// The dashpot or slider in series with a spring.
    pub fn series(self) -> Option<&'a Series> {
        if let Self::Spring(spring) = self { spring.series.as_ref() } else { None }
    }

    /// The element's springs with an inner place, in series with a dashpot or slider or along a
    /// contact's tangents: the index of each among two, `None` for the only one.
    pub fn branches(self) -> impl Iterator<Item = Option<usize>> + Clone {
        let count = self.tangents().len() + usize::from(self.series().is_some());
        (0..count).map(move |k| (count > 1).then_some(k))
    }

    /// Signals, each with the key after the element's dotted name; this key is empty for loads and
    /// sources.
    pub fn signals(self) -> Vec<(&'static str, &'a Signal)> {
        match self {
            Self::Friction(Friction { follows: Some(_), .. }) => Vec::new(),
            Self::Friction(friction) => {
                let largest = friction.static_force.as_ref().map(|level| (".static", level));
                std::iter::once((".force", &friction.force)).chain(largest).collect()
            }
            Self::Block(_) => Vec::new(),
            Self::Load(load) => vec![("", &load.force)],
            Self::Source(source) => vec![("", &source.signal)],
            Self::Spring(Spring { stepped, .. }) | Self::Stop(Stop { stepped, .. }) => {
                stepped.iter().map(|signal| (".stiffness", signal)).collect()
            }
            Self::Damper(_)
            | Self::Modal(_)
            | Self::Matrix(_)
            | Self::Contact(_)
            | Self::Freewheel(_)
            | Self::Link(_) => Vec::new(),
        }
    }
}

/// A signal of a machine.
#[derive(Clone, Debug)]
pub struct NamedSignal<'a> {
    /// Dotted name, such as `body.table.motion`, `load.shaker`, `friction.belt.static`.
    pub name: String,
    /// The signal.
    pub signal: &'a Signal,
    /// Dimension of its values.
    pub dimension: Dimension,
    /// Order of the coordinate's derivative that a body's motion prescribes; `None` otherwise.
    pub motion: Option<usize>,
}

impl NamedSignal<'_> {
    /// SI unit of the values; `1` for a signal that blocks read.
    pub fn unit(&self) -> &'static str {
        let what = self.motion.map_or(What::F, |order| [What::S, What::V, What::A][order.min(2)]);
        if self.name.starts_with("signal.") { "1" } else { what.unit(self.dimension) }
    }
}

impl Description {
    /// Index of the first freewheel among the stops of the law. Stops, contacts, levels of
    /// stiffnesses, corners and limits precede it.
    pub fn first_freewheel(&self) -> usize {
        let levels = crate::stepped::further(self);
        self.stops.len() + self.contacts.len() + levels + self.corners() + self.limits_of_outputs().len()
    }

    /// Number of corners of springs with points.
    pub fn corners(&self) -> usize {
        self.springs.iter().map(|spring| spring.points.len().saturating_sub(2)).sum()
    }

    /// All elements, in the order of [`SECTIONS`] and within a section in the order of the file.
    pub fn elements(&self) -> impl Iterator<Item = Element<'_>> + Clone {
        let springs = self.springs.iter().map(Element::Spring);
        let stops = self.stops.iter().map(Element::Stop);
        let frictions = self.frictions.iter().map(Element::Friction);
        let contacts = self.contacts.iter().map(Element::Contact);
        let wheels = self.freewheels.iter().map(Element::Freewheel);
        let links = self.links.iter().map(Element::Link);
        let springs = springs.chain(self.dampers.iter().map(Element::Damper));
        let springs = springs.chain(self.modals.iter().map(Element::Modal));
        let springs = springs.chain(self.matrices.iter().map(Element::Matrix));
        let rigid = wheels.chain(links);
        let loads = self.loads.iter().map(Element::Load);
        let computed = self.sources.iter().map(Element::Source).chain(self.blocks.iter().map(Element::Block));
        springs.chain(stops).chain(frictions).chain(contacts).chain(rigid).chain(loads).chain(computed)
    }

    /// Whether the stiffness of any element steps in time.
    pub fn steps_stiffness(&self) -> bool {
        crate::stepped::all(self).next().is_some()
    }

    /// Counts of the bodies and of the elements of each section, with plurals.
    pub fn counts(&self) -> Vec<(usize, &'static str)> {
        let of = |&(section, plural): &(&str, &'static str)| {
            (self.elements().filter(|element| element.section() == section).count(), plural)
        };
        let own = |body: &&Body| !body.is_inner() && !matches!(body.kind, BodyKind::Node(_));
        let bodies = self.bodies.iter().filter(own).count();
        std::iter::once((bodies, "bodies")).chain(SECTIONS.iter().map(of)).collect()
    }

    /// All signals in the order of the inputs: motions of bodies, loads, signals of the other
    /// elements.
    pub fn signals(&self) -> impl Iterator<Item = NamedSignal<'_>> {
        let motions = self.bodies.iter().filter_map(|body| {
            let (key, signal, order) = match &body.kind {
                BodyKind::Prescribed { motion, .. } => (String::new(), motion, 0),
                BodyKind::Integrated(Integrated { level, signal, .. }) => {
                    (format!(".{}", level.key()), signal, level.order())
                }
                BodyKind::Free(_) | BodyKind::Node(_) => return None,
            };
            let name = format!("body.{}.motion{key}", body.name);
            Some(NamedSignal { name, signal, dimension: body.dimension, motion: Some(order) })
        });
        let is_load = |element: &Element| element.action() == Action::Driving;
        let loads = self.elements().filter(is_load);
        let others = self.elements().filter(move |element| !is_load(element));
        motions.chain(loads.chain(others).flat_map(|element| {
            let (dotted, dimension) = (element.dotted(), element.dimension(self));
            element.signals().into_iter().map(move |(key, signal)| NamedSignal {
                name: format!("{dotted}{key}"),
                signal,
                dimension,
                motion: None,
            })
        }))
    }
}
