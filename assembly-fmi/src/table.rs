//! The variables of a machine by value reference, in the order of its file.
//!
//! | names | causality |
//! |---|---|
//! | `time` | independent |
//! | dotted names of the file, such as `stop.upper.gap` | parameter |
//! | `load.NAME.input`, `body.NAME.motion.input`, `friction.NAME.force.input`, `friction.NAME.static.input` | input |
//! | `BODY.s`, `.v`, `.a`; `ELEMENT.e`, `.rate`, `.f`; `LOAD.f` | output |
//! | `STOP.state`, `FRICTION.state` (enumerations); `STOP.impacts`, `STOP.impulse` of rigid stops | output |
//! | `energy.kinetic`, `.stored`, `.work`, `.lost`, `.residual` | output |
//! | `step.transition`, `step.response`: matrices, in FMI 3.0 with arrays | local |
//! | `STOP.indicator` or, of compliant ones, `STOP.indicator.edge`, `.force`; `FRICTION.indicator.up`, `.down`, `.level` | local |
//!
//! Variable names are unique: names of bodies are unique, so are those of elements, and their
//! suffixes differ.

use fmi_doors::{Base, Bases, Problem};
use vibro_assembly::description::{Dimension, Stop, StopLaw};
use vibro_assembly::elements::NamedSignal;
use vibro_assembly::{Description, Element, Owner, Parameter, What};

/// Source of a variable's value, with indices of bodies and elements in the description.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Time.
    Time,
    /// A parameter, by its index.
    Parameter(usize),
    /// An input, by its index.
    Input(usize),
    /// A column of the motion.
    Column(vibro_assembly::Quantity),
    /// The state of a stop.
    StopState(usize),
    /// Number of a stop's impacts so far.
    Impacts(usize),
    /// The impulse of a stop's last impact.
    Impulse(usize),
    /// The state of a friction.
    FrictionState(usize),
    /// A part of the energy balance.
    Energy(Energy),
    /// An event indicator, by its index.
    Indicator(usize),
    /// The derivatives of the states at the end of the last step by those at its begin.
    Transition,
    /// The derivatives of the states at the end of the last step by the inputs.
    Response,
}

impl Quantity {
    /// A body's coordinate (order 0), rate (1) or acceleration (2 or more).
    pub fn of_body(body: usize, order: usize) -> Self {
        Self::Column(vibro_assembly::Quantity::of_body(body, [What::S, What::V, What::A][order.min(2)]))
    }

    /// Body and order of a body's quantity; `None` for others.
    pub fn as_body(self) -> Option<(usize, usize)> {
        let Self::Column(vibro_assembly::Quantity { owner: Owner::Body(body), what }) = self else {
            return None;
        };
        Some((body, What::OF_BODIES.iter().position(|own| *own == what)?))
    }
}

/// A part of the energy balance, J.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Energy {
    /// Kinetic energy.
    Kinetic,
    /// Potential energy of springs, compliant stops and weight.
    Stored,
    /// Work of loads and prescribed motions since the start.
    Work,
    /// Losses in dashpots, stops and friction since the start.
    Lost,
    /// Mechanical energy minus its value by work and losses: rounding.
    Residual,
}

/// Role of a variable: who sets it, and when it changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Time.
    Independent,
    /// A number of the file that may be set only before the motion begins.
    Parameter,
    /// A number of the file that may be set at events, too.
    Tunable,
    /// An input, which is added to a signal.
    Input,
    /// A result that changes continuously.
    Output,
    /// A result that changes at events only.
    Discrete,
    /// A result for the host's solver: an event indicator.
    Local,
    /// A matrix of derivatives over the last step.
    Sensitivity,
}

/// A variable.
#[derive(Clone, Debug)]
pub struct Row {
    /// Its name.
    pub name: String,
    /// Its meaning in words.
    pub meaning: String,
    /// SI unit; `1` for whole numbers.
    pub unit: &'static str,
    /// Its type.
    pub base: Base,
    /// Its role.
    pub role: Role,
    /// Source of its value.
    pub quantity: Quantity,
    /// Rows and columns of a matrix; empty for a scalar.
    pub dimensions: Vec<usize>,
}

impl Row {
    /// Whether hosts may read or set it within a step (`intermediateUpdate`).
    pub fn is_seen_within_steps(&self) -> bool {
        matches!(self.role, Role::Input | Role::Output)
    }
}

/// The variables of a machine.
#[derive(Debug)]
pub struct Table {
    /// The variables, at the index value reference - 1.
    pub rows: Vec<Row>,
    /// The parameters, in the order of their rows.
    pub parameters: Vec<Parameter>,
    /// The value references of the inputs, in order.
    pub inputs: Vec<u32>,
    /// The value references of the event indicators, in order.
    pub indicators: Vec<u32>,
}

/// The unit for a dimension, of those for translation and for rotation.
fn of(dimension: Dimension, units: [&'static str; 2]) -> &'static str {
    units[usize::from(dimension == Dimension::Rotation)]
}

/// Unit of matrices whose elements have different units.
pub(crate) const NO_UNIT: &str = "";
const IMPULSE: [&str; 2] = ["N.s", "N.m.s"];

impl Table {
    /// The variables of a machine.
    pub fn new(machine: &Description) -> Self {
        let parameters = machine.parameters();
        let mut table = Self { rows: Vec::new(), parameters, inputs: Vec::new(), indicators: Vec::new() };
        table.push("time".into(), "Time", "s", Role::Independent, Quantity::Time);
        for place in 0..table.parameters.len() {
            let Parameter { name, meaning, unit, .. } = table.parameters[place].clone();
            let role = if is_tunable(&name) { Role::Tunable } else { Role::Parameter };
            table.push(name, meaning, unit, role, Quantity::Parameter(place));
        }
        let inputs = machine.signals().filter(|named| named.signal.input);
        for (place, NamedSignal { name, dimension, is_motion, .. }) in inputs.enumerate() {
            let unit = if is_motion { What::S.unit(dimension) } else { What::F.unit(dimension) };
            let name = format!("{name}.input");
            table.push(name, "Added to the signal", unit, Role::Input, Quantity::Input(place));
            table.inputs.push(table.rows.len() as u32);
        }
        table.columns(machine);
        table.energies();
        table.indicators(machine);
        table
    }

    fn push(&mut self, name: String, meaning: &str, unit: &'static str, role: Role, quantity: Quantity) {
        let base = match quantity {
            Quantity::Impacts(_) => Base::Integer,
            Quantity::StopState(_) | Quantity::FrictionState(_) => Base::Enumeration,
            _ => Base::Real,
        };
        self.rows.push(Row {
            name,
            meaning: meaning.into(),
            unit,
            base,
            role,
            quantity,
            dimensions: Vec::new(),
        });
    }

    /// Adds the columns of the motion, and after each element's columns its discrete variables.
    fn columns(&mut self, machine: &Description) {
        let mut columns = machine.named_quantities().into_iter().peekable();
        let mut push_those_of = |table: &mut Self, owner: Owner| {
            while let Some(column) = columns.next_if(|column| column.quantity.owner == owner) {
                let quantity = Quantity::Column(column.quantity);
                table.push(column.name, column.meaning, column.unit, Role::Output, quantity);
            }
        };
        (0..machine.bodies.len()).for_each(|i| push_those_of(self, Owner::Body(i)));
        let (mut stops, mut frictions) = (0, 0);
        for (i, element) in machine.elements().enumerate() {
            push_those_of(self, Owner::Element(i));
            match element {
                Element::Stop(stop) => {
                    self.stop(stop, stops);
                    stops += 1;
                }
                Element::Friction(friction) => {
                    let (name, state) = (&friction.name, Quantity::FrictionState(frictions));
                    self.push(format!("{name}.state"), "State of the friction", "1", Role::Discrete, state);
                    frictions += 1;
                }
                _ => {}
            }
        }
    }

    fn stop(&mut self, stop: &Stop, i: usize) {
        let mut push = |what: &str, meaning: &str, unit, quantity| {
            self.push(format!("{}.{what}", stop.name), meaning, unit, Role::Discrete, quantity);
        };
        push("state", "State of the stop", "1", Quantity::StopState(i));
        if let StopLaw::Rigid { .. } = stop.law {
            push("impacts", "Impacts so far", "1", Quantity::Impacts(i));
            let unit = of(stop.arms.dimension, IMPULSE);
            push("impulse", "Impulse of the last impact", unit, Quantity::Impulse(i));
        }
    }

    fn energies(&mut self) {
        for (what, meaning, energy) in [
            ("kinetic", "Kinetic energy", Energy::Kinetic),
            ("stored", "Energy in springs, compliant stops and weight", Energy::Stored),
            ("work", "Work of loads and prescribed motions since the start", Energy::Work),
            ("lost", "Lost in dashpots, stops and friction since the start", Energy::Lost),
            ("residual", "Energy that work and losses do not account for: rounding", Energy::Residual),
        ] {
            self.push(format!("energy.{what}"), meaning, "J", Role::Output, Quantity::Energy(energy));
        }
    }

    /// Adds the event indicators in the engine's order.
    fn indicators(&mut self, machine: &Description) {
        let mut push = |name: String, meaning: &str| {
            let place = self.indicators.len();
            self.push(name, meaning, "1", Role::Local, Quantity::Indicator(place));
            self.indicators.push(self.rows.len() as u32);
        };
        for stop in &machine.stops {
            let name = format!("{}.indicator", stop.name);
            match stop.law {
                StopLaw::Rigid { .. } => push(name, "Negative where the stop is to close or to open"),
                StopLaw::Compliant { .. } => {
                    push(
                        format!("{name}.edge"),
                        "Negative where the stop is met or left, or its force capped",
                    );
                    push(format!("{name}.force"), "Negative where the force ends or begins");
                }
            }
        }
        for friction in &machine.frictions {
            let name = format!("{}.indicator", friction.name);
            push(format!("{name}.up"), "Negative where slipping ends, or begins upwards");
            push(format!("{name}.down"), "Negative where slipping begins downwards");
            push(format!("{name}.level"), "Negative where friction begins or ceases to act");
        }
    }

    /// Adds the matrices of derivatives over a step, for a machine with `states` states. They are
    /// optional, since several importers cannot read arrays.
    pub(crate) fn add_matrices(&mut self, states: usize) {
        const ROWS: &str = "Derivatives of the states (coordinates, then rates, in the order of the model structure) at the end of the \
                            last step";
        let inputs = 4 * self.inputs.len();
        let mut push = |name: &str, meaning: String, columns: usize, quantity: Quantity| {
            if columns > 0 {
                let text = format!("{ROWS} by {meaning}, through all its events, in SI units");
                self.push(name.into(), &text, NO_UNIT, Role::Sensitivity, quantity);
                self.rows.iter_mut().rev().take(1).for_each(|row| row.dimensions = vec![states, columns]);
            }
        };
        push("step.transition", "those at its begin".into(), states, Quantity::Transition);
        let meaning =
            "value and derivatives 1 to 3, at its begin, of each input (four columns for each in turn)";
        push("step.response", meaning.into(), inputs, Quantity::Response);
    }

    /// The value reference of a name, if any.
    pub fn reference(&self, name: &str) -> Option<u32> {
        self.rows.iter().position(|row| row.name == name).map(|place| place as u32 + 1)
    }

    /// The value reference of a quantity's variable, if any.
    pub(crate) fn reference_of(&self, quantity: Quantity) -> Option<u32> {
        self.rows.iter().position(|row| row.quantity == quantity).map(|place| place as u32 + 1)
    }

    /// The variable of a value reference, which must have one of these types.
    ///
    /// # Errors
    /// [`Problem::Reference`] for an unknown reference or another type.
    pub fn row(&self, reference: u32, bases: Bases) -> Result<&Row, Problem> {
        let row = self.rows.get((reference as usize).wrapping_sub(1));
        if let Some(row) = row.filter(|row| bases.contains(row.base)) {
            return Ok(row);
        }
        let found = match row {
            Some(row) => format!("{} is {}", row.name, row.base.name()),
            None => format!("allowed are those of the model description, from 1 to {}", self.rows.len()),
        };
        Err(Problem::Reference { reference, wanted: bases.name, found })
    }
}

/// Whether a parameter may be set during a motion: neither a start value nor an arm, which
/// determines the coordinates.
fn is_tunable(name: &str) -> bool {
    !name.contains(".start.") && !name.contains(".arms.")
}
