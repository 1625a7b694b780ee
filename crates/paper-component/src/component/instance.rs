//! One component as a safe object with methods to set, initialize, step or integrate, read, save
//! and restore it.
//!
//! Each method checks all its arguments before it changes anything: a refused call leaves the
//! component unchanged. The FMI layer (the door) checks the order of calls. The component knows
//! only [`Phase`]s, which determine the variables that may be set.

mod access;
mod arrival;
mod dependencies;
mod derivative;
mod events;
mod exchange;
mod given;
mod hybrid;
mod initial;
mod last_step;
mod model;
mod prediction;

#[cfg(test)]
mod tests;

use super::closed_form::ClosedForm;
use super::continuous::Continuous;
use super::event_state::EventState;
use super::problem::{ComponentProblem, Outcome};
use super::protocol::Protocol;
use super::saved_state::{EngineState, SavedState};
use super::settings::{Derived, Settings, SolutionMode};
use super::steady;
use super::values::{OutputValues, Prediction, StepMatrices, Tick};
use super::variables::{Access, Edition, Numbering, VARIABLES};
use events::Present;
use fmi_doors::{Interface, Life, Phase};
use last_step::LastStep;
use vibro_impact::simulator::Simulator;

/// The motion and its method of computation.
#[derive(Debug)]
enum Engine {
    /// No motion: not initialized yet.
    None,
    /// Event-driven co-simulation.
    Simulation(Box<Simulator>),
    /// Co-simulation that plays a steady state.
    Closed(Box<ClosedForm>),
    /// Model Exchange.
    Continuous(Box<Continuous>),
}

/// One component.
#[derive(Debug)]
pub struct Instance {
    life: Life,
    numbering: Numbering,
    edition: Edition,
    /// Start values of the settings.
    initial: Settings,
    settings: Settings,
    engine: Engine,
    /// Loads whose derivatives were set since the last step. Setting the value of such a load
    /// keeps its derivatives.
    slopes_set: [bool; 3],
    /// Whether parameters or loads were set since the last step.
    parameters_set: bool,
    loads_set: bool,
    events: EventState,
    /// Values of the outputs; outdated while stale.
    values: OutputValues,
    values_stale: bool,
    derived: Derived,
    derived_stale: bool,
    /// The prediction of the next event, once it has been requested.
    prediction: Option<Prediction>,
    /// The last step, kept for a replay, and its derivatives once they have been requested.
    last_step: Option<LastStep>,
    step_matrices: Option<StepMatrices>,
    /// Values of the clock of impacts.
    tick: Tick,
    /// Nominal values of the states last reported to the host.
    nominals_told: Option<[f64; 6]>,
    /// Physical parameters set by the host, one bit each in the order of `FIELDS`.
    given: u16,
}

impl Instance {
    /// A component with all variables at their start values.
    pub fn new(interface: Interface) -> Self {
        Self::of_protocol(interface, Protocol::default())
    }

    /// A component with the start values, numbering and event handling of `protocol`.
    pub fn of_protocol(interface: Interface, protocol: Protocol) -> Self {
        let Protocol { numbering, handling, start, edition } = protocol;
        Self {
            life: Life::new(interface, handling),
            numbering,
            edition,
            initial: start,
            settings: start,
            engine: Engine::None,
            slopes_set: [false; 3],
            parameters_set: false,
            loads_set: false,
            events: EventState::default(),
            values: OutputValues::default(),
            values_stale: true,
            derived: Derived::default(),
            derived_stale: true,
            prediction: None,
            last_step: None,
            step_matrices: None,
            tick: Tick::default(),
            nominals_told: None,
            given: 0,
        }
    }

    /// The present settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Present phase.
    pub fn phase(&self) -> Phase {
        self.life.phase
    }

    /// Snapshot of all data that the component needs to continue.
    pub fn save(&self) -> SavedState {
        SavedState {
            interface: self.life.interface,
            phase: self.life.phase,
            settings: self.settings,
            experiment: self.life.experiment,
            slopes_set: self.slopes_set,
            parameters_set: self.parameters_set,
            loads_set: self.loads_set,
            events: self.events,
            tick: self.tick,
            nominals_told: self.nominals_told,
            stop_by_default: self.initial.stop_at_impact,
            given: self.given,
            engine: match &self.engine {
                Engine::None => EngineState::None,
                Engine::Simulation(simulator) => EngineState::Simulation(simulator.snapshot()),
                Engine::Closed(form) => EngineState::Closed(form.data()),
                Engine::Continuous(continuous) => EngineState::Continuous(continuous.data()),
            },
        }
    }

    /// Adapts a state saved by a host with another event handling. Without an event mode, pending
    /// events are dropped, and an event that is due is handled in the next step.
    fn meet_own_protocol(&mut self) {
        if self.life.interface == Interface::CoSimulation && !self.life.handling.event_mode {
            self.events = EventState::default();
            self.tick.active = false;
        }
    }

    /// Marks the values computed from the motion as outdated.
    fn invalidate(&mut self) {
        self.values_stale = true;
        self.prediction = None;
        self.step_matrices = None;
    }

    /// Brings the values up to date. In initialization they are evaluated at the start.
    fn refresh_values(&mut self) -> Outcome {
        if !self.values_stale {
            return Ok(());
        }
        self.values = self.present_values()?;
        self.values_stale = false;
        Ok(())
    }

    /// Present values of the outputs; before initialization, the values at the start.
    ///
    /// # Errors
    /// [`ComponentProblem::Overflow`] if a value is not finite; outputs are always finite.
    fn present_values(&self) -> Outcome<OutputValues> {
        let mut values = match self.present()? {
            Present::Simulation(simulator) => OutputValues::of(&simulator),
            Present::Closed(form) => form.values(),
            Present::Continuous(continuous) => continuous.values(),
            Present::None => self.initial_values(&self.settings)?,
        };
        if let Some(shown) = &self.events.latched {
            shown.put(&mut values);
        }
        finite(values)
    }

    /// Updates the values derived from the parameters, but only after parameters were set, since
    /// steady states are expensive.
    fn refresh_derived(&mut self) {
        if self.derived_stale {
            self.derived = steady::derived(&self.settings.parameters);
            self.derived_stale = false;
        }
    }
}

/// The values, if all are finite.
fn finite(values: OutputValues) -> Outcome<OutputValues> {
    if values.is_finite() { Ok(values) } else { Err(overflow(&values)) }
}

/// Names the first output that is not finite.
#[cold]
fn overflow(values: &OutputValues) -> ComponentProblem {
    let readings = VARIABLES.iter().filter_map(|variable| match variable.access {
        Access::Output(reading) | Access::Start { now: reading, .. } => {
            Some((variable.name, (reading.value)(values)))
        }
        _ => None,
    });
    let found = readings.into_iter().find(|(_, value)| !value.is_finite());
    let (name, value) = found.unwrap_or(("the motion", f64::INFINITY));
    ComponentProblem::Overflow { name, value, time: values.time }
}
