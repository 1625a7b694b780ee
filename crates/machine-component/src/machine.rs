//! An instance of a described machine.

mod derivatives;
mod events;
mod exchange;
mod hybrid;
mod last_step;
mod model;
mod moving;

pub(crate) use derivatives::OUTPUT_ORDER;
pub(crate) use moving::{SavedMoving, Shown};

use crate::plan::Plan;
use crate::problem::MachineProblem;
use crate::table::{Quantity, Role, VariableTable};
use fmi_doors::{Interface, Life, Model, Phase, Problem};
use last_step::{LastStep, StepMatrices};
use moving::Moving;
use std::f64::consts::TAU;
use std::fmt;
use std::sync::Arc;
use vibro_machine::signals::Input;
use vibro_machine::{Motion, Owner};

/// An instance of a described machine: parameters, inputs and a motion.
pub struct Machine {
    plan: Arc<Plan>,
    life: Life,
    /// Values of all parameters.
    values: Vec<f64>,
    /// Value added to each parameter. It is nonzero only for phases, rad, so that an oscillation
    /// remains continuous when its frequency changes during the motion.
    phases: Vec<f64>,
    /// Whether parameters were set that the motion has not taken over.
    changed: bool,
    /// Value and derivatives of each input that were set and that the motion has not taken over.
    pending: Vec<Option<Input>>,
    /// The motion, after initialization.
    moving: Option<Moving>,
    /// The motion with all pending changes; made on demand.
    ahead: Option<Moving>,
    /// Values that change only at events, shown to the host until it has handled the events of the
    /// last step.
    latched: Option<Shown>,
    /// The last step.
    last_step: Option<LastStep>,
    /// Derivatives over the last step, once requested.
    matrices: Option<StepMatrices>,
}

impl fmt::Debug for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { plan, life, .. } = self;
        f.debug_struct("Machine").field("name", &plan.name()).field("life", life).finish_non_exhaustive()
    }
}

impl Machine {
    /// Creates an instance of a machine, with all variables at their start.
    pub fn new(plan: Arc<Plan>, life: Life) -> Self {
        let values: Vec<f64> = plan.table.parameters.iter().map(|parameter| parameter.value).collect();
        let (phases, pending) = (vec![0.0; values.len()], vec![None; plan.table.inputs.len()]);
        let (moving, ahead, latched, last_step, matrices) = (None, None, None, None, None);
        let changed = false;
        Self { plan, life, values, phases, changed, pending, moving, ahead, latched, last_step, matrices }
    }

    /// Returns the present values of all parameters, with the added phases.
    fn numbers(&self) -> Vec<f64> {
        self.values.iter().zip(&self.phases).map(|(value, phase)| value + phase).collect()
    }

    /// Returns the motion from the start, with all values that were set.
    fn start(&self) -> Result<Moving, MachineProblem> {
        let numbers = self.numbers();
        let assembly = self.plan.machine(&numbers, false)?;
        let (time, own) = (self.life.start_time(), assembly.clone());
        let reads_inputs = assembly.has_samples() && self.pending.iter().any(Option::is_some);
        let motion = if reads_inputs {
            let inputs = self.pending.iter().enumerate();
            let inputs: Vec<_> = inputs.filter_map(|(i, input)| Some((i, (*input)?))).collect();
            Motion::starting_under(own, time, &inputs)?
        } else {
            Motion::starting_at(own, time)?
        };
        let mut moving = Moving::new(motion, numbers);
        moving.set_inputs(&self.pending)?;
        if self.life.interface == Interface::ModelExchange {
            if assembly.states() != self.plan.assembly.states() {
                let what = "lever arms with which the coordinates of other bodies are the states";
                return Err(Problem::NotOffered { what }.into());
            }
            moving.begin_course()?;
        }
        Ok(moving)
    }

    /// Whether values were set that the motion has not taken over.
    fn is_set(&self) -> bool {
        self.changed || self.pending.iter().any(Option::is_some)
    }

    /// Passes pending values to a motion.
    fn give(&self, moving: &mut Moving) -> Result<(), MachineProblem> {
        if self.changed {
            let numbers = self.numbers();
            moving.change(self.plan.machine(&numbers, true)?, numbers)?;
        }
        Ok(moving.set_inputs(&self.pending)?)
    }

    /// Returns the motion after it has taken over pending values.
    fn ahead_of(&self, moving: &Moving) -> Result<Moving, MachineProblem> {
        let mut ahead = moving.clone();
        // A pending event is handled before values that were set at the same time.
        if ahead.is_on_course() {
            ahead.handle(&mut |_| ())?;
        }
        self.give(&mut ahead)?;
        Ok(ahead)
    }

    /// Returns the present motion with all pending values.
    fn present(&mut self) -> Result<&Moving, MachineProblem> {
        if self.ahead.is_none() {
            match &self.moving {
                None => self.ahead = Some(self.start()?),
                // While an event is pending, values that were set are not applied: the host sees
                // the state before the event, and later the state after it.
                Some(moving) if self.is_set() && !moving.is_event_due() => {
                    self.ahead = Some(self.ahead_of(moving)?);
                }
                Some(_) => {}
            }
        }
        let none = || Problem::Sequence { what: "the instance is not initialized".into() };
        Ok(self.ahead.as_ref().or(self.moving.as_ref()).ok_or_else(none)?)
    }

    /// Returns the value of a quantity. For quantities of the motion, call
    /// [`present`](Self::present) first.
    fn value(&self, quantity: Quantity) -> f64 {
        let moving = self.ahead.as_ref().or(self.moving.as_ref());
        match quantity {
            Quantity::Time => self.time(),
            Quantity::Parameter(i) => self.values[i],
            Quantity::Following(i) => self.following(i),
            Quantity::Input(i) => match (&self.pending[i], &self.moving) {
                (Some(input), _) => input[0],
                (None, Some(moving)) => moving.motion.input(i)[0],
                (None, None) => 0.0,
            },
            _ => moving.map_or(0.0, |moving| self.of_motion(moving, quantity)),
        }
    }

    /// Returns the value of a quantity, with zero unsigned. Error if it is not finite, for example
    /// after a host's solver has diverged.
    fn finite_value(&self, quantity: Quantity, name: &str) -> Result<f64, Problem> {
        let value = self.value(quantity) + 0.0;
        let allowed = match quantity {
            Quantity::Following(_) => "a finite number; its expression of named parameters does not give one",
            _ => "a finite number; states or inputs are too large",
        };
        if value.is_finite() { Ok(value) } else { Err(Problem::value(name.to_owned(), value, allowed)) }
    }

    /// Returns a number that follows from the present values of named parameters.
    fn following(&self, i: usize) -> f64 {
        let VariableTable { parameters, following, .. } = &self.plan.table;
        // Named parameters come last.
        let value = |name: &str| Some(self.values[parameters.iter().rposition(|own| own.name == name)?]);
        self.plan.assembly.description.named.value_with(&following[i].name, value)
    }

    fn of_motion(&self, moving: &Moving, quantity: Quantity) -> f64 {
        match (&self.latched, quantity) {
            (Some(shown), Quantity::StopState(i)) => shown.stops[i].0,
            (Some(shown), Quantity::Impacts(i)) => shown.stops[i].1,
            (Some(shown), Quantity::Impulse(i)) => shown.stops[i].2,
            (Some(shown), Quantity::FrictionState(i)) => shown.frictions[i],
            (Some(shown), Quantity::Line(i)) => shown.lines[i],
            (Some(shown), Quantity::SliderState(i)) => shown.sliders[i],
            (Some(shown), Quantity::Column(vibro_machine::Quantity { owner: Owner::Element(i), what })) => {
                let place = self.plan.assembly.system().place_by_samples(i, what);
                place.map_or_else(|| moving.value(quantity), |place| shown.samples[place])
            }
            _ => moving.value(quantity),
        }
    }

    /// Checks whether a value may be set now.
    fn check(&self, reference: u32, bases: fmi_doors::Bases, value: f64) -> Result<Quantity, Problem> {
        let row = self.plan.table.row(reference, bases)?;
        let name = || row.name.clone();
        let early = matches!(self.life.phase, Phase::Instantiated | Phase::Initialization);
        let between = matches!(self.life.phase, Phase::Event | Phase::Step | Phase::StoppedEarly);
        match (row.role, row.quantity) {
            (Role::Parameter | Role::Tunable, Quantity::Parameter(i))
                if early || (between && row.role == Role::Tunable) =>
            {
                let range = self.plan.table.parameters[i].range();
                if !range.contains(value) {
                    return Err(Problem::value(name(), value, range.allowed));
                }
            }
            (Role::Input, _) if value.is_finite() => {}
            // Some hosts set states one by one instead of all together.
            (_, quantity) if self.state_of(quantity).is_some() && self.life.phase == Phase::Continuous => {
                if !value.is_finite() {
                    return Err(Problem::value(name(), value, "a finite number"));
                }
            }
            (Role::Input, _) => return Err(Problem::value(name(), value, "a finite number")),
            _ => {
                let allowed = match (early, between) {
                    (true, _) => "parameters and inputs",
                    (_, true) => "tunable parameters and inputs",
                    _ if self.life.phase == Phase::Continuous => "inputs and continuous states",
                    _ => "inputs",
                };
                let name = match row.quantity {
                    Quantity::Following(i) => self.plan.table.following_in_words(i).into(),
                    _ => name().into(),
                };
                let phase = self.life.phase.words();
                return Err(Problem::NotSettable { name, phase, allowed });
            }
        }
        Ok(row.quantity)
    }

    /// Returns the index of a quantity among the states of a host's solver, if it is one.
    fn state_of(&self, quantity: Quantity) -> Option<usize> {
        let Quantity::Column(quantity) = quantity else { return None };
        self.plan.states.iter().position(|[state, _]| *state == quantity)
    }

    /// Takes over a checked value.
    fn put(&mut self, quantity: Quantity, value: f64) {
        let at_event = self.life.phase == Phase::Event;
        let state = self.state_of(quantity);
        match (quantity, &mut self.moving) {
            (Quantity::Column(_), Some(moving)) => {
                let place = state.map(|state| self.plan.places[state]);
                moving.set_states(place.as_slice(), &[value]);
            }
            (Quantity::Parameter(i), _) => self.put_parameter(i, value),
            (Quantity::Input(i), Some(moving)) if moving.is_on_course() && !(at_event && moving.jumps()) => {
                moving.set_input_on_course(i, value)
            }
            (Quantity::Input(i), _) => self.pending[i] = Some([value, 0.0, 0.0, 0.0]),
            _ => {}
        }
        self.ahead = None;
    }

    fn put_parameter(&mut self, i: usize, value: f64) {
        let before = std::mem::replace(&mut self.values[i], value);
        let Some(moving) = &self.moving else { return };
        self.changed |= before != value;
        // The parameters list a harmonic's phase just after its frequency. The oscillation
        // continues from its present phase.
        if self.plan.table.parameters[i].name.ends_with(".frequency") {
            let turns = (before - value) * moving.motion.time();
            self.phases[i + 1] = (self.phases[i + 1] + TAU * turns.fract()) % TAU;
        }
    }

    /// Sets parameters during the motion, all or none; it is checked at once whether they agree
    /// with one another and with the present state.
    fn change(&mut self, values: &[(usize, f64)]) -> Result<(), MachineProblem> {
        let before = (self.values.clone(), self.phases.clone(), self.changed);
        values.iter().for_each(|&(i, value)| self.put(Quantity::Parameter(i), value));
        let problem = match self.moving.as_ref().map(|moving| self.ahead_of(moving)) {
            Some(Ok(ahead)) => {
                let due = self.moving.as_ref().is_some_and(Moving::is_event_due);
                self.ahead = Some(ahead).filter(|_| !due);
                return Ok(());
            }
            Some(Err(problem)) => problem,
            None => return Ok(()),
        };
        (self.values, self.phases, self.changed) = before;
        self.ahead = None;
        Err(match problem {
            MachineProblem::Motion(problem) => {
                let name = |i: usize| &self.plan.table.parameters[i].name;
                let set: Vec<_> = values.iter().map(|&(i, value)| format!("{} = {value}", name(i))).collect();
                MachineProblem::Change { set: set.join(", "), problem }
            }
            other => other,
        })
    }
}
