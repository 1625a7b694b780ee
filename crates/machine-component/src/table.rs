//! The variables of a machine by value reference, in the order of its file. Names by causality:
//!
//! - independent: `time`
//! - parameter: dotted names of the file, such as `stop.upper.gap`; named parameters
//! - calculatedParameter: numbers and named parameters that follow by expressions
//! - input: `load.NAME.input`, `body.NAME.motion.input`, `friction.NAME.force.input`,
//!   `friction.NAME.static.input`
//! - output: `BODY.s`, `.v`, `.a`; `ELEMENT.e`, `.rate`, `.f`; `LOAD.f`; for springs in series
//!   `SPRING.slider`, `SPRING.slider.rate`; the enumerations `STOP.state`, `FRICTION.state` and,
//!   for sliders, `SPRING.state`; for rigid stops `STOP.impacts`, `STOP.impulse`; for freewheels
//!   the same three; `SIGNAL`; `BLOCK.OUTPUT`; `BLOCK.x[0]` with `.rate`; for sampled blocks,
//!   discrete: `BLOCK.x[0]`, `BLOCK.OUTPUT.held`, `BLOCK.OUTPUT.next[0]`; for springs by points
//!   `SPRING.line`; `energy.kinetic`, `.stored`, `.work`, `.lost`, `.switched`, `.residual`
//! - local: the matrices `step.transition`, `step.response`, `step.parameters`, in FMI 3.0 with
//!   arrays; `STOP.indicator` or, for compliant stops, `STOP.indicator.edge`, `.force`;
//!   `FRICTION.indicator.up`, `.down`, `.level`; for corners `SPRING.indicator.points[1]`; for
//!   limits `BLOCK.OUTPUT.indicator.lower`, `.upper`; for freewheels `WHEEL.indicator`; for
//!   sliders `SPRING.indicator.up`, `.down`
//!
//! Bodies have unique names, elements have unique names, and the suffixes of both differ. So no
//! two variables share a name.

mod indicators;
mod quantity;

pub use quantity::{Energy, Quantity};

use fmi_doors::{Base, Bases, Problem};
use vibro_machine::description::{Block, Dimension, SeriesLaw, Stop, StopLaw};
use vibro_machine::following::Following;
use vibro_machine::quantity::NamedQuantity;
use vibro_machine::{Description, Element, Owner, Parameter, What};

/// The role of a variable, which determines its causality and variability.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Time.
    Independent,
    /// A number of the file that may be set before the motion begins.
    Parameter,
    /// A number of the file that may also be set at events.
    Tunable,
    /// A number that follows from named parameters by an expression, and cannot be set.
    Calculated,
    /// An addition to a signal, set by the host.
    Input,
    /// A result of the motion that changes at any time.
    Output,
    /// A result of the motion that changes only at events.
    Discrete,
    /// An event indicator, for a host's solver.
    Local,
    /// A matrix of derivatives over the last step.
    Sensitivity,
}

/// A variable.
#[derive(Clone, Debug)]
pub struct VariableRow {
    /// Name of the variable.
    pub name: String,
    /// Description.
    pub meaning: String,
    /// SI unit; `1` for dimensionless numbers and counts.
    pub unit: &'static str,
    /// Data type.
    pub base: Base,
    /// Role.
    pub role: Role,
    /// Source of the value.
    pub quantity: Quantity,
    /// Rows and columns of a matrix; empty for a scalar.
    pub dimensions: Vec<usize>,
}

impl VariableRow {
    /// Whether hosts may read or set the variable within a step (`intermediateUpdate`).
    pub fn is_seen_within_steps(&self) -> bool {
        matches!(self.role, Role::Input | Role::Output)
    }
}

/// The variables of a machine.
#[derive(Debug)]
pub struct VariableTable {
    /// The variables; the value reference is the index plus 1.
    pub rows: Vec<VariableRow>,
    /// The parameters, in the order of their rows.
    pub parameters: Vec<Parameter>,
    /// Numbers and parameters that follow by expressions, in the order of the rows.
    pub following: Vec<Following>,
    /// The value references of the inputs, in order.
    pub inputs: Vec<u32>,
    /// The value references of the event indicators.
    pub indicators: Vec<u32>,
}

/// Returns the unit for a dimension.
fn of(dimension: Dimension, units: [&'static str; 2]) -> &'static str {
    units[usize::from(dimension == Dimension::Rotation)]
}

/// Largest number of entries of `step.parameters`; a larger machine does not have it.
const MOST_BY_PARAMETERS: usize = 1_000_000;

/// Largest number of names in the description of a named parameter: about a line of a host's
/// window.
const MOST_NAMED: usize = 4;

/// Unit of matrices, whose elements have different units.
pub(crate) const NO_UNIT: &str = "";
const IMPULSE: [&str; 2] = ["N.s", "N.m.s"];

impl VariableTable {
    /// Creates the variables of a machine.
    pub fn new(machine: &Description) -> Self {
        let parameters = machine.parameters();
        let (following, indicators) = (machine.following(), Vec::new());
        let mut table = Self { rows: Vec::new(), parameters, following, inputs: Vec::new(), indicators };
        table.push("time".into(), "Time", "s", Role::Independent, Quantity::Time);
        for place in 0..table.parameters.len() {
            let Parameter { name, meaning, unit, .. } = table.parameters[place].clone();
            let role = if is_tunable(machine, &name) { Role::Tunable } else { Role::Parameter };
            let meaning = meaning + &what_follows(&machine.named.numbers_of(&name));
            table.push(name, meaning, unit, role, Quantity::Parameter(place));
        }
        for place in 0..table.following.len() {
            let Following { name, unit, meaning, expression, .. } = table.following[place].clone();
            let meaning = format!("{meaning}, by the expression `{expression}`");
            table.push(name, meaning, unit, Role::Calculated, Quantity::Following(place));
        }
        let inputs = machine.signals().filter(|named| named.signal.input);
        for (place, signal) in inputs.enumerate() {
            let (name, unit) = (format!("{}.input", signal.name), signal.unit());
            table.push(name, "Added to the signal", unit, Role::Input, Quantity::Input(place));
            table.inputs.push(table.rows.len() as u32);
        }
        table.columns(machine);
        table.energies(machine);
        table.indicators(machine);
        table
    }

    fn push(
        &mut self,
        name: String,
        meaning: impl Into<String>,
        unit: &'static str,
        role: Role,
        quantity: Quantity,
    ) {
        let base = match quantity {
            Quantity::Impacts(_) | Quantity::Line(_) => Base::Integer,
            Quantity::StopState(_) | Quantity::FrictionState(_) | Quantity::SliderState(_) => {
                Base::Enumeration
            }
            _ => Base::Real,
        };
        self.rows.push(VariableRow {
            name,
            meaning: meaning.into(),
            unit,
            base,
            role,
            quantity,
            dimensions: Vec::new(),
        });
    }

    /// Adds the quantities of bodies and elements; each element's quantities are followed by its
    /// state and impacts.
    fn columns(&mut self, machine: &Description) {
        let mut columns = machine.named_quantities().into_iter().peekable();
        let mut push_those_of = |table: &mut Self, owner: Owner| {
            while let Some(column) = columns.next_if(|column| column.quantity.owner == owner) {
                table.column(machine, column);
            }
        };
        for i in 0..machine.bodies.len() {
            push_those_of(self, Owner::Body(i));
            // States of a solver.
            for own in machine.inner_quantities(i) {
                self.column(machine, own);
            }
        }
        let (mut stops, mut contacts, mut frictions, mut sliders) = (0, 0, 0, 0);
        let (mut wheels, mut blocks) = (machine.first_freewheel(), 0);
        for (i, element) in machine.elements().enumerate() {
            push_those_of(self, Owner::Element(i));
            match element {
                Element::Spring(spring) if spring.points.len() > 2 => {
                    let name = format!("{}.line", spring.name);
                    let meaning = "Line of the force that acts, counted from 0 at the least elongation";
                    self.push(name, meaning, "1", Role::Discrete, Quantity::Line(i));
                }
                Element::Stop(stop) => {
                    self.stop(stop, stops);
                    stops += 1;
                }
                Element::Friction(friction) => {
                    let (name, state) = (&friction.name, Quantity::FrictionState(frictions));
                    self.push(format!("{name}.state"), "State of the friction", "1", Role::Discrete, state);
                    frictions += 1;
                }
                Element::Freewheel(wheel) => {
                    self.rigid(&wheel.name, "State of the freewheel", wheel.arms.dimension, wheels);
                    wheels += 1;
                }
                Element::Spring(spring) if spring.series.is_some() => {
                    let what = What::SliderRate(None);
                    let name = format!("{}.{}", spring.name, what.word());
                    let unit = what.unit(spring.arms.dimension);
                    let quantity = vibro_machine::Quantity::of_element(i, what);
                    let meaning = vibro_machine::quantity::meaning(what, Some(element));
                    self.push(name, meaning, unit, Role::Output, Quantity::Column(quantity));
                    if slides(element) {
                        let (name, state) = (&spring.name, Quantity::SliderState(sliders));
                        self.push(format!("{name}.state"), "State of the slider", "1", Role::Discrete, state);
                    }
                    sliders += 1;
                }
                Element::Contact(contact) => {
                    for k in element.branches() {
                        self.slider_of_contact((i, element), k, sliders);
                        sliders += 1;
                    }
                    let state = Quantity::StopState(machine.stops.len() + contacts);
                    let name = format!("{}.state", contact.name);
                    self.push(name, "State of the contact", "1", Role::Discrete, state);
                    contacts += 1;
                }
                Element::Block(_) => {
                    let rates = machine.blocks[blocks].sampling.is_none();
                    for own in machine.quantities_of_block(blocks, rates) {
                        self.column(machine, own);
                    }
                    blocks += 1;
                }
                _ => {}
            }
        }
    }

    /// Adds the rate of a contact's slider, and the slider's state; `k` is the index of one of two
    /// tangents.
    fn slider_of_contact(&mut self, (i, element): (usize, Element), k: Option<usize>, slider: usize) {
        let what = What::SliderRate(k);
        let name = format!("{}.{}", element.name(), what.word());
        let quantity = Quantity::Column(vibro_machine::Quantity::of_element(i, what));
        let meaning = vibro_machine::quantity::meaning(what, Some(element));
        self.push(name, meaning, what.unit(Dimension::Translation), Role::Output, quantity);
        let name = format!("{}.{}.state", element.name(), What::Slider(k).word());
        let state = Quantity::SliderState(slider);
        self.push(name, "State of the slider", "1", Role::Discrete, state);
    }

    /// Adds a quantity; a quantity of a sampled block is discrete.
    fn column(&mut self, machine: &Description, own: NamedQuantity) {
        let (role, meaning) = match machine.sampled_block(own.quantity) {
            Some(block) => (Role::Discrete, format!("{}{}", own.meaning, when_sampled(block))),
            None => (Role::Output, own.meaning.to_owned()),
        };
        self.push(own.name, meaning, own.unit, role, Quantity::Column(own.quantity));
    }

    fn stop(&mut self, stop: &Stop, i: usize) {
        if let StopLaw::Rigid { .. } = stop.law {
            return self.rigid(&stop.name, "State of the stop", stop.arms.dimension, i);
        }
        let name = format!("{}.state", stop.name);
        self.push(name, "State of the stop", "1", Role::Discrete, Quantity::StopState(i));
    }

    /// Adds state and impacts of a rigid stop or a freewheel.
    fn rigid(&mut self, name: &str, state: &str, dimension: Dimension, i: usize) {
        let mut push = |what: &str, meaning: &str, unit, quantity| {
            self.push(format!("{name}.{what}"), meaning, unit, Role::Discrete, quantity);
        };
        push("state", state, "1", Quantity::StopState(i));
        push("impacts", "Impacts so far", "1", Quantity::Impacts(i));
        push("impulse", "Impulse of the last impact", of(dimension, IMPULSE), Quantity::Impulse(i));
    }

    fn energies(&mut self, machine: &Description) {
        let all = [
            ("kinetic", "Kinetic energy", Energy::Kinetic),
            ("stored", "Energy in springs, compliant stops and weight", Energy::Stored),
            ("work", "Work of loads and prescribed motions since the start", Energy::Work),
            ("lost", "Lost in dashpots, stops and friction since the start", Energy::Lost),
            ("switched", "Put in by steps of stiffness since the start", Energy::Switched),
            ("residual", "Energy that work and losses do not account for: rounding", Energy::Residual),
        ];
        let is_there = |energy| energy != Energy::Switched || machine.steps_stiffness();
        for (what, meaning, energy) in all.into_iter().filter(|own| is_there(own.2)) {
            self.push(format!("energy.{what}"), meaning, "J", Role::Output, Quantity::Energy(energy));
        }
    }

    /// Adds the matrices of derivatives over a step, for a machine with this number of states.
    pub(crate) fn add_matrices(&mut self, states: usize) {
        const ROWS: &str = "Derivatives of the states (coordinates, rates, inner places, in the order of the model structure) at the end of the \
                            last step";
        let inputs = 4 * self.inputs.len();
        let tunable = self.tunable().count();
        let mut push = |name: &str, meaning: String, columns: usize, quantity: Quantity| {
            if columns > 0 {
                let text = format!("{ROWS} by {meaning}, through all its events, in SI units");
                self.push(name.into(), text, NO_UNIT, Role::Sensitivity, quantity);
                self.rows.iter_mut().rev().take(1).for_each(|row| row.dimensions = vec![states, columns]);
            }
        };
        push("step.transition", "those at its begin".into(), states, Quantity::Transition);
        let meaning =
            "value and derivatives 1 to 3, at its begin, of each input (four columns for each in turn)";
        push("step.response", meaning.into(), inputs, Quantity::Response);
        let meaning = "each tunable parameter, in the order of the model description, set at its begin; 0 where there is none, as after a touch";
        let columns = Some(tunable).filter(|tunable| states * tunable <= MOST_BY_PARAMETERS).unwrap_or(0);
        push("step.parameters", meaning.into(), columns, Quantity::ByParameters);
    }

    /// Returns the tunable parameters, by index in [`parameters`](Self::parameters).
    pub(crate) fn tunable(&self) -> impl Iterator<Item = usize> {
        self.rows.iter().filter(|row| row.role == Role::Tunable).filter_map(|row| match row.quantity {
            Quantity::Parameter(i) => Some(i),
            _ => None,
        })
    }

    /// Returns the value reference of a name.
    pub fn reference(&self, name: &str) -> Option<u32> {
        self.rows.iter().position(|row| row.name == name).map(|place| place as u32 + 1)
    }

    /// Names a number that follows from named parameters, with its expression, for a message.
    pub(crate) fn following_in_words(&self, i: usize) -> String {
        let Following { name, expression, .. } = &self.following[i];
        format!("{name}, which follows from named parameters by the expression `{expression}`,")
    }

    /// Returns the role of the variable with a name.
    pub(crate) fn role(&self, name: &str) -> Option<Role> {
        Some(self.rows[self.reference(name)? as usize - 1].role)
    }

    /// Returns the value reference of the variable with this source.
    pub(crate) fn reference_of(&self, quantity: Quantity) -> Option<u32> {
        self.rows.iter().position(|row| row.quantity == quantity).map(|place| place as u32 + 1)
    }

    /// Returns the variable of a value reference, which must have one of the types.
    ///
    /// # Errors
    /// [`Problem::Reference`].
    pub fn row(&self, reference: u32, bases: Bases) -> Result<&VariableRow, Problem> {
        let row = self.rows.get((reference as usize).wrapping_sub(1));
        if let Some(row) = row.filter(|row| bases.contains(row.base)) {
            return Ok(row);
        }
        let found = match row {
            Some(row) => format!("{} is {}", row.name, row.base.name()),
            None => {
                format!("expected a value reference of the model description, from 1 to {}", self.rows.len())
            }
        };
        Err(Problem::Reference { reference, wanted: bases.name, found })
    }
}

/// Lists the numbers that follow from a named parameter, for its description; empty if none do.
fn what_follows(numbers: &[&str]) -> String {
    let named = numbers.iter().take(MOST_NAMED).copied().collect::<Vec<_>>().join(", ");
    match numbers.len() {
        0 => String::new(),
        count if count > MOST_NAMED => format!("; sets {named} and {} more", count - MOST_NAMED),
        _ => format!("; sets {named}"),
    }
}

/// Describes when a sampled block is sampled and when its outputs act.
fn when_sampled(block: &Block) -> String {
    let Some(sampling) = &block.sampling else { return String::new() };
    let name = &block.name;
    let mut text = format!("; sampled at multiples of `block.{name}.sample` ({} s)", sampling.period);
    if sampling.delay > 0.0 {
        text += &format!(", outputs act `block.{name}.delay` ({} s) later", sampling.delay);
    }
    text
}

/// Whether a spring's partner is a slider: in series, or along the tangents of a contact.
pub(crate) fn slides(element: Element) -> bool {
    match element {
        Element::Contact(contact) => !contact.tangents.is_empty(),
        _ => element.series().is_some_and(|series| matches!(series.law, SeriesLaw::Slider { .. })),
    }
}

/// Ends of the names of start values of inner places.
pub(crate) const SLIDERS: [&str; 3] = [".slider", ".slider[0]", ".slider[1]"];

/// Whether a number is a start value of a body, of a block, of a spring in series or of a contact.
pub(crate) fn is_start(name: &str) -> bool {
    let is_branch = name.starts_with("spring.") || name.starts_with("contact.");
    let is_slider = is_branch && SLIDERS.iter().any(|end| name.ends_with(end));
    let is_block = name.starts_with("block.") && name.contains(".start[");
    name.contains(".start.") || is_block || (is_slider && !name.contains(".arms."))
}

/// Whether a parameter may be set after the motion has begun. Excluded are start values, lever
/// arms (on which the choice of coordinates depends), exponents, periods, and the course of sweeps. A
/// frequency is excluded if its phase, which must change with it, follows from a named parameter.
/// A named parameter is tunable if all numbers that follow from it are, and none is a frequency.
fn is_tunable(machine: &Description, name: &str) -> bool {
    let is_swept = |name: &str| {
        name.contains(".sweep") && [".from", ".to", ".duration"].iter().any(|end| name.ends_with(end))
    };
    let is_sampled = |name: &str| {
        name.starts_with("block.") && [".sample", ".delay"].iter().any(|end| name.ends_with(end))
    };
    let is_time = |name: &str| name.ends_with(".repeat") || is_swept(name) || is_sampled(name);
    let is_origin = |name: &str| name.ends_with(".motion.s") || name.ends_with(".motion.v");
    let is_start = |name: &str| is_start(name) || is_origin(name);
    let is_fixed = |name: &str| name.contains(".arms.") || name.ends_with(".exponent") || is_time(name);
    let is_free = |name: &str| !is_start(name) && !is_fixed(name);
    let phase = name.strip_suffix(".frequency").map(|of| format!("{of}.phase"));
    let follows = machine.named.numbers_of(name);
    is_free(name)
        && phase.is_none_or(|phase| machine.parameter(&phase).is_ok())
        && follows.iter().all(|name| is_free(name) && !name.ends_with(".frequency"))
}
