//! One component as a safe object: it is set, initialized, stepped or integrated, read, saved and
//! restored.
//!
//! Each method checks everything it was given and only then changes anything: a refused call leaves
//! the component as it was. Which call is allowed in which state of which protocol is the door's to
//! say; the component knows [`Phase`]s, which decide on what may be set.

mod access;
mod advance;
mod arrival;
mod dependencies;
mod derivative;
mod events;
mod exchange;
mod given;
mod initial;
mod last_step;
mod pieces;
mod prediction;
mod step;

#[cfg(test)]
mod tests;

use super::closed_form::ClosedForm;
use super::continuous::Continuous;
use super::event_state::EventState;
use super::log::{Category, Log};
use super::problem::{Outcome, Problem};
use super::protocol::Protocol;
use super::saved_state::{EngineState, SavedState};
use super::settings::{Derived, Settings, SolutionMode};
use super::steady;
use super::values::{OutputValues, Prediction, StepMatrices, Tick};
use super::variables::{Access, Edition, Numbering, VARIABLES};
use events::Present;
use fmi_doors::{EventHandling, Experiment, Interface, Life, Phase};
use last_step::LastStep;
use vibro_impact::simulator::Simulator;

pub use pieces::Pieces;

/// What moves.
#[derive(Debug)]
enum Engine {
    /// Not initialized yet.
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
    /// What settings start from.
    initial: Settings,
    settings: Settings,
    engine: Engine,
    /// Which loads had their derivatives set since the last step: a value set after them does not
    /// clear them.
    slopes_set: [bool; 3],
    /// Whether parameters or loads were set since the last step.
    parameters_set: bool,
    loads_set: bool,
    events: EventState,
    /// What the outputs read; not up to date while stale.
    values: OutputValues,
    values_stale: bool,
    derived: Derived,
    derived_stale: bool,
    /// The event that is to come, once it was asked for.
    prediction: Option<Prediction>,
    /// The last step, to be looked at again, and its derivatives once they were asked for.
    last_step: Option<LastStep>,
    step_matrices: Option<StepMatrices>,
    /// What the clock of impacts shows.
    tick: Tick,
    /// Nominal values of the states that the host was told last.
    nominals_told: Option<[f64; 6]>,
    /// Which physical parameters the host has set, one bit each in the order of `FIELDS`.
    given: u16,
}

impl Instance {
    /// A component with all variables at their start values.
    pub fn new(interface: Interface) -> Self {
        Self::of_protocol(interface, Protocol::default())
    }

    /// The same in a protocol's own terms.
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

    /// Its dealings with the host.
    pub fn life(&self) -> &Life {
        &self.life
    }

    /// The same, to be changed.
    pub fn life_mut(&mut self) -> &mut Life {
        &mut self.life
    }

    /// Which description it is of.
    pub fn edition(&self) -> Edition {
        self.edition
    }

    /// How it is used.
    pub fn interface(&self) -> Interface {
        self.life.interface
    }

    /// What is set.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Present phase.
    pub fn phase(&self) -> Phase {
        self.life.phase
    }

    /// Puts the component into any phase, to visit every cell of a door's state machine.
    #[cfg(test)]
    pub(crate) fn force(&mut self, phase: Phase) {
        self.life.phase = phase;
    }

    /// Marks the component unusable after a panic.
    pub fn break_down(&mut self) {
        self.life.phase = Phase::Broken;
    }

    /// When to begin, and the time past which no step may go; `tolerance` is only checked: the flow
    /// is exact.
    ///
    /// # Errors
    /// As [`Experiment::new`].
    pub fn set_experiment(&mut self, tolerance: Option<f64>, start: f64, stop: Option<f64>) -> Outcome {
        self.life.experiment = Some(Experiment::new(tolerance, start, stop)?);
        Ok(())
    }

    /// From now on outputs show the start that the settings describe.
    pub fn enter_initialization(&mut self) {
        self.life.phase = Phase::Initialization;
        self.invalidate();
    }

    /// Ends initialization: builds what moves.
    ///
    /// # Errors
    /// When the start values or the parameters are not possible; the component stays in
    /// initialization.
    pub fn exit_initialization(&mut self, log: &mut dyn Log) -> Outcome {
        let (engine, objections) = self.initial_engine()?;
        match &engine {
            Engine::Simulation(simulator) => drop(finite(OutputValues::of(simulator))?),
            Engine::Closed(form) => drop(finite(form.values())?),
            Engine::Continuous(continuous) => drop(finite(continuous.values())?),
            Engine::None => {}
        }
        if log.wants(Category::Warnings) {
            let half = given::half_a_machine(&self.settings.parameters, self.given);
            objections.into_iter().chain(half).for_each(|text| log.log(Category::Warnings, &text));
        }
        self.nominals_told = Some(self.nominals());
        self.engine = engine;
        self.taken_over();
        if self.life.interface == Interface::ModelExchange || self.life.handling.event_mode {
            self.begin_event();
        } else {
            self.life.phase = Phase::Step;
        }
        Ok(())
    }

    /// As just made.
    pub fn reset(&mut self) {
        let (numbering, edition) = (self.numbering, self.edition);
        let protocol = Protocol { numbering, handling: self.life.handling, start: self.initial, edition };
        *self = Self::of_protocol(self.life.interface, protocol);
    }

    /// Present time, s; before initialization ends, the start.
    pub fn time(&self) -> f64 {
        match &self.engine {
            Engine::Simulation(simulator) => simulator.time(),
            Engine::Closed(form) => form.time(),
            Engine::Continuous(continuous) => continuous.time(),
            Engine::None => self.start_time(),
        }
    }

    /// Everything it needs to continue from here.
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

    /// Goes back to a saved state, or takes over that of another component; also where it was never
    /// initialized. Continuing gives the same bits as not having left.
    ///
    /// # Errors
    /// [`SavedState`](fmi_doors::Problem::SavedState) for one of the other interface type, or in a
    /// phase that does not go with what moves; [`Problem::Model`] for one that is not possible.
    /// Nothing has changed then.
    pub fn restore(&mut self, saved: &SavedState) -> Outcome {
        let mut life = self.life;
        let SavedState { interface, phase, experiment, .. } = *saved;
        life.take_over(&Life { interface, phase, experiment, ..life })?;
        saved.check()?;
        match (&mut self.engine, &saved.engine) {
            (engine, EngineState::None) => *engine = Engine::None,
            (Engine::Simulation(simulator), EngineState::Simulation(snapshot)) => {
                simulator.restore(snapshot)?;
            }
            (engine, EngineState::Simulation(snapshot)) => {
                // Any valid simulator does: the snapshot brings its own parameters and state.
                let standard = Settings::default();
                let mut simulator = Simulator::new(&standard.parameters, &standard.start, 0.0)?;
                simulator.restore(snapshot)?;
                *engine = Engine::Simulation(Box::new(simulator));
            }
            (Engine::Closed(form), EngineState::Closed(data)) => form.restore(*data)?,
            (engine, EngineState::Closed(data)) => {
                *engine = Engine::Closed(Box::new(ClosedForm::of(*data)?));
            }
            (Engine::Continuous(continuous), EngineState::Continuous(data)) => continuous.restore(*data)?,
            (engine, EngineState::Continuous(data)) => {
                *engine = Engine::Continuous(Box::new(Continuous::of(*data)?));
            }
        }
        self.life = life;
        self.derived_stale |= self.settings.parameters != saved.settings.parameters;
        self.settings = saved.settings;
        if saved.settings.stop_at_impact == saved.stop_by_default {
            self.settings.stop_at_impact = self.initial.stop_at_impact;
        }
        self.slopes_set = saved.slopes_set;
        self.parameters_set = saved.parameters_set;
        self.loads_set = saved.loads_set;
        self.last_step = None;
        self.events = saved.events;
        self.tick = saved.tick;
        self.nominals_told = saved.nominals_told;
        self.given = saved.given;
        self.invalidate();
        self.meet_own_protocol();
        Ok(())
    }

    /// Of a state that a host with another handling of events has saved: where this one has no
    /// phase of events, nothing of one is left, and an event that is due comes with its next step.
    fn meet_own_protocol(&mut self) {
        if self.life.interface == Interface::CoSimulation && !self.life.handling.event_mode {
            self.events = EventState::default();
            self.tick.active = false;
        }
    }

    /// What was computed of the motion no longer holds.
    fn invalidate(&mut self) {
        self.values_stale = true;
        self.prediction = None;
        self.step_matrices = None;
    }

    /// Brings the values up to date. In initialization that evaluates the start.
    fn refresh_values(&mut self) -> Outcome {
        if !self.values_stale {
            return Ok(());
        }
        self.values = self.present_values()?;
        self.values_stale = false;
        Ok(())
    }

    /// What the outputs read now; of nothing that moves yet, the start.
    ///
    /// # Errors
    /// [`Problem::Overflow`] when one is not finite: no output ever is.
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

    /// Brings what follows from the parameters up to date; only after parameters were set, since
    /// steady states take a while to compute.
    fn refresh_derived(&mut self) {
        if self.derived_stale {
            self.derived = steady::derived(&self.settings.parameters);
            self.derived_stale = false;
        }
    }
}

/// The values, each of them finite.
fn finite(values: OutputValues) -> Outcome<OutputValues> {
    if values.is_finite() { Ok(values) } else { Err(overflow(&values)) }
}

/// Names the first output that is not finite.
#[cold]
fn overflow(values: &OutputValues) -> Problem {
    let readings = VARIABLES.iter().filter_map(|variable| match variable.access {
        Access::Output(reading) | Access::Start { now: reading, .. } => {
            Some((variable.name, (reading.value)(values)))
        }
        _ => None,
    });
    let found = readings.into_iter().find(|(_, value)| !value.is_finite());
    let (name, value) = found.unwrap_or(("the motion", f64::INFINITY));
    Problem::Overflow { name, value, time: values.time }
}
