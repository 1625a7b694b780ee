//! The variables of a machine by value reference, in the order of its file.
//!
//! | names | causality |
//! |---|---|
//! | `time` | independent |
//! | dotted names of the file, such as `stop.upper.gap` | parameter |
//! | `load.NAME.input`, `body.NAME.motion.input`, `friction.NAME.force.input`, `friction.NAME.static.input` | input |
//! | `BODY.s`, `.v`, `.a`; `ELEMENT.e`, `.rate`, `.f`; `LOAD.f` | output |
//! | `SPRING.slider`, `SPRING.slider.rate` of springs in series | output |
//! | `STOP.state`, `FRICTION.state`, `SPRING.state` of sliders (enumerations); `STOP.impacts`, `STOP.impulse` of rigid stops | output |
//! | `SIGNAL`, `BLOCK.OUTPUT`; a block's states `BLOCK.x[0]`, `BLOCK.OUTPUT.held`, `.rate` | output |
//! | `SPRING.line` of springs by points | output |
//! | `energy.kinetic`, `.stored`, `.work`, `.lost`, `.residual` | output |
//! | `step.transition`, `step.response`, `step.parameters`: matrices, in FMI 3.0 with arrays | local |
//! | `STOP.indicator` or, of compliant ones, `STOP.indicator.edge`, `.force`; `FRICTION.indicator.up`, `.down`, `.level` | local |
//! | `SPRING.indicator.points[1]` of its corners; `SPRING.indicator.up`, `.down` of sliders | local |
//!
//! Names of bodies are unique, so are those of elements, and the suffixes of both differ: no two
//! variables share a name.

use fmi_doors::{Base, Bases, Problem};
use vibro_assembly::description::{Dimension, Series, SeriesLaw, Stop, StopLaw};
use vibro_assembly::{Description, Element, Owner, Parameter, What};

/// The source of a variable's value, by the places of bodies and elements in the description.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Time.
    Time,
    /// A parameter, by its index.
    Parameter(usize),
    /// An input, by its index.
    Input(usize),
    /// A quantity of a body or an element.
    Column(vibro_assembly::Quantity),
    /// The state of a stop.
    StopState(usize),
    /// The number of a stop's impacts so far.
    Impacts(usize),
    /// The impulse of a stop's last impact.
    Impulse(usize),
    /// The state of a friction.
    FrictionState(usize),
    /// The number of corners that a spring has passed, by its place among the springs.
    Line(usize),
    /// The state of a slider in series with a spring, by the spring's place among those in series.
    SliderState(usize),
    /// A part of the energy balance.
    Energy(Energy),
    /// An event indicator, by its index.
    Indicator(usize),
    /// Derivatives of the states at the end of the last step with respect to those at its start.
    Transition,
    /// Derivatives of the states at the end of the last step with respect to the inputs.
    Response,
    /// Derivatives of the states at the end of the last step with respect to tunable parameters.
    ByParameters,
}

impl Quantity {
    /// A body's coordinate (`order` 0), its rate (1) or its acceleration (2).
    pub fn of_body(body: usize, order: usize) -> Self {
        Self::Column(vibro_assembly::Quantity::of_body(body, [What::S, What::V, What::A][order.min(2)]))
    }

    /// The body and the order of a body's quantity, the inverse of [`of_body`](Self::of_body).
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
    /// Energy stored in springs, compliant stops and weight.
    Stored,
    /// Work of loads and prescribed motions since the start.
    Work,
    /// Energy lost in dashpots, stops and friction since the start.
    Lost,
    /// What steps of stiffness have put in since the start.
    Switched,
    /// Mechanical energy less its value by work and losses: rounding.
    Residual,
}

/// The role of a variable, from which causality and variability follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Time.
    Independent,
    /// A number of the file that may be set before the motion begins.
    Parameter,
    /// A number of the file that may be set at events, too.
    Tunable,
    /// An addition to a signal, set by the host.
    Input,
    /// A result of the motion that changes at any time.
    Output,
    /// A result of the motion that changes at events only.
    Discrete,
    /// An event indicator, for a host's solver.
    Local,
    /// A matrix of derivatives over the last step.
    Sensitivity,
}

/// A variable.
#[derive(Clone, Debug)]
pub struct VariableRow {
    /// Its name.
    pub name: String,
    /// Description.
    pub meaning: String,
    /// SI unit; `1` of whole numbers.
    pub unit: &'static str,
    /// Its type.
    pub base: Base,
    /// Role.
    pub role: Role,
    /// Source of its value.
    pub quantity: Quantity,
    /// Rows and columns of a matrix; empty for a scalar.
    pub dimensions: Vec<usize>,
}

impl VariableRow {
    /// Whether hosts may read or set it within a step (`intermediateUpdate`).
    pub fn is_seen_within_steps(&self) -> bool {
        matches!(self.role, Role::Input | Role::Output)
    }
}

/// The variables of a machine.
#[derive(Debug)]
pub struct VariableTable {
    /// The variables; the value reference is the place plus 1.
    pub rows: Vec<VariableRow>,
    /// The parameters, in the order of their rows.
    pub parameters: Vec<Parameter>,
    /// The value references of the inputs, in order.
    pub inputs: Vec<u32>,
    /// The value references of the event indicators.
    pub indicators: Vec<u32>,
}

/// The one of two units that belongs to a dimension.
fn of(dimension: Dimension, units: [&'static str; 2]) -> &'static str {
    units[usize::from(dimension == Dimension::Rotation)]
}

/// Most numbers of `step.parameters`; a larger machine has none.
const MOST_BY_PARAMETERS: usize = 1_000_000;

/// The unit of matrices, whose elements have different units.
pub(crate) const NO_UNIT: &str = "";
const IMPULSE: [&str; 2] = ["N.s", "N.m.s"];

impl VariableTable {
    /// The variables of a machine.
    pub fn new(machine: &Description) -> Self {
        let parameters = machine.parameters();
        let mut table = Self { rows: Vec::new(), parameters, inputs: Vec::new(), indicators: Vec::new() };
        table.push("time".into(), "Time", "s", Role::Independent, Quantity::Time);
        for place in 0..table.parameters.len() {
            let Parameter { name, meaning, unit, .. } = table.parameters[place].clone();
            let role = if is_tunable(machine, &name) { Role::Tunable } else { Role::Parameter };
            // Structured names of FMI write both places of a matrix's number in one bracket.
            table.push(name.replace("][", ","), meaning, unit, role, Quantity::Parameter(place));
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

    fn push(&mut self, name: String, meaning: &str, unit: &'static str, role: Role, quantity: Quantity) {
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

    /// Adds the quantities of bodies and elements, each element's followed by its state and
    /// impacts.
    fn columns(&mut self, machine: &Description) {
        let mut columns = machine.named_quantities().into_iter().peekable();
        let mut push_those_of = |table: &mut Self, owner: Owner| {
            while let Some(column) = columns.next_if(|column| column.quantity.owner == owner) {
                let quantity = Quantity::Column(column.quantity);
                table.push(column.name, column.meaning, column.unit, Role::Output, quantity);
            }
        };
        for i in 0..machine.bodies.len() {
            push_those_of(self, Owner::Body(i));
            // States of a solver.
            for own in machine.inner_quantities(i) {
                self.push(own.name, own.meaning, own.unit, Role::Output, Quantity::Column(own.quantity));
            }
        }
        let (mut stops, mut frictions, mut sliders) = (0, 0, 0);
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
                    let what = What::SliderRate;
                    let name = format!("{}.{}", spring.name, what.word());
                    let unit = what.unit(spring.arms.dimension);
                    let quantity = vibro_assembly::Quantity::of_element(i, what);
                    let meaning = vibro_assembly::quantity::meaning(what, Some(element));
                    self.push(name, meaning, unit, Role::Output, Quantity::Column(quantity));
                    if slides(&spring.series) {
                        let (name, state) = (&spring.name, Quantity::SliderState(sliders));
                        self.push(format!("{name}.state"), "State of the slider", "1", Role::Discrete, state);
                    }
                    sliders += 1;
                }
                Element::Block(_) => {
                    for own in machine.quantities_of_block(blocks, true) {
                        let quantity = Quantity::Column(own.quantity);
                        self.push(own.name, own.meaning, own.unit, Role::Output, quantity);
                    }
                    blocks += 1;
                }
                _ => {}
            }
        }
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

    /// Adds the event indicators in the order of `Motion::indicators`.
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
        for spring in &machine.springs {
            for corner in 1..spring.points.len().saturating_sub(1) {
                let name = format!("{}.indicator.points[{corner}]", spring.name);
                push(name, "Negative where the corner is to be passed");
            }
        }
        for (place, is_upper) in machine.limits_of_outputs() {
            let side = if is_upper { "upper" } else { "lower" };
            let name = format!("{}.indicator.{side}", machine.name_of_output(place));
            push(name, "Negative where the output comes to the limit or leaves it");
        }
        for wheel in &machine.freewheels {
            let name = format!("{}.indicator", wheel.name);
            push(name, "Negative where the freewheel is to engage or to let go");
        }
        for friction in &machine.frictions {
            let name = format!("{}.indicator", friction.name);
            push(format!("{name}.up"), "Negative where slipping ends, or begins upwards");
            push(format!("{name}.down"), "Negative where slipping begins downwards");
            push(format!("{name}.level"), "Negative where friction begins or ceases to act");
        }
        for spring in machine.springs.iter().filter(|spring| slides(&spring.series)) {
            let name = format!("{}.indicator", spring.name);
            push(format!("{name}.up"), "Negative where slipping ends, or begins upwards");
            push(format!("{name}.down"), "Negative where slipping begins downwards");
        }
    }

    /// Adds the matrices of derivatives over a step, for a machine with so many states.
    pub(crate) fn add_matrices(&mut self, states: usize) {
        const ROWS: &str = "Derivatives of the states (coordinates, rates, inner places, in the order of the model structure) at the end of the \
                            last step";
        let inputs = 4 * self.inputs.len();
        let tunable = self.tunable().count();
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
        let meaning = "each tunable parameter, in the order of the model description, set at its begin; 0 where there is none, as after a touch";
        let columns = Some(tunable).filter(|tunable| states * tunable <= MOST_BY_PARAMETERS).unwrap_or(0);
        push("step.parameters", meaning.into(), columns, Quantity::ByParameters);
    }

    /// The tunable parameters, by place among [`parameters`](Self::parameters).
    pub(crate) fn tunable(&self) -> impl Iterator<Item = usize> {
        self.rows.iter().filter(|row| row.role == Role::Tunable).filter_map(|row| match row.quantity {
            Quantity::Parameter(i) => Some(i),
            _ => None,
        })
    }

    /// The value reference of a name.
    pub fn reference(&self, name: &str) -> Option<u32> {
        self.rows.iter().position(|row| row.name == name).map(|place| place as u32 + 1)
    }

    /// The value reference of the variable with this source.
    pub(crate) fn reference_of(&self, quantity: Quantity) -> Option<u32> {
        self.rows.iter().position(|row| row.quantity == quantity).map(|place| place as u32 + 1)
    }

    /// The variable of a value reference, which must have one of the types.
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
            None => format!("allowed are those of the model description, from 1 to {}", self.rows.len()),
        };
        Err(Problem::Reference { reference, wanted: bases.name, found })
    }
}

/// Whether a spring's partner is a slider.
pub(crate) fn slides(series: &Option<Series>) -> bool {
    series.is_some_and(|series| matches!(series.law, SeriesLaw::Slider { .. }))
}

/// Whether a number is a start value: of a body, or the inner place of a spring in series.
pub(crate) fn is_start(name: &str) -> bool {
    let is_slider = name.starts_with("spring.") && name.ends_with(".slider");
    let is_block = name.starts_with("block.") && name.contains(".start[");
    name.contains(".start.") || is_block || (is_slider && !name.contains(".arms."))
}

/// Whether a parameter may be set after the motion has begun: neither a start value nor a lever
/// arm, on which the choice of coordinates depends, nor a period or what says the course of a
/// sweep, nor a frequency whose phase, which goes on from where it is, follows from a named
/// parameter. A named one where all that follows may be.
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
    let is_free = |name: &str| !is_start(name) && !name.contains(".arms.") && !is_time(name);
    let phase = name.strip_suffix(".frequency").map(|of| format!("{of}.phase"));
    let follows = machine.named.numbers_of(name);
    is_free(name)
        && phase.is_none_or(|phase| machine.parameter(&phase).is_ok())
        && follows.iter().all(|name| is_free(name) && !name.ends_with(".frequency"))
}
