//! One instance of the FMU as a safe state machine (FMI 2.0, 2.1.5, 2.1.6, 3.2.3 and 4.2.4).
//!
//! Each method is one function of the standard: it looks up in [`states`](super::states) whether it may be called, checks
//! everything it was given, and only then changes anything. A refused call leaves the instance as it was.

mod derivative;
mod exchange;
mod initial;
mod memory;
mod step;
mod values;

#[cfg(test)]
mod tests;

use super::closed_form::ClosedForm;
use super::continuous::Continuous;
use super::description;
use super::logging::{Category, Enabled, Log, Status};
use super::problem::Problem;
use super::settings::{Derived, Motion, Settings};
use super::states::{Function, Interface, State};
use serde::{Deserialize, Serialize};
use vibro_impact::simulator::Simulator;

pub use exchange::EventInfo;
pub use memory::FmuState;
pub use step::StatusKind;

/// Outcome of a call.
pub type Outcome<T = ()> = Result<T, Problem>;

/// What `fmi2SetupExperiment` said (FMI 2.0, 2.1.6). The tolerance is only checked: the flow is exact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Experiment {
    start: f64,
    stop: Option<f64>,
}

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

/// One instance.
#[derive(Debug)]
pub struct Instance {
    /// The GUID's number, which saved states carry.
    origin: [u8; 16],
    interface: Interface,
    state: State,
    settings: Settings,
    experiment: Option<Experiment>,
    engine: Engine,
    /// Which loads had their derivatives set since the last step: a value set after them does not clear them.
    slopes_set: [bool; 3],
    /// Whether parameters or loads were set since the last step.
    parameters_set: bool,
    loads_set: bool,
    motion: Motion,
    motion_stale: bool,
    derived: Derived,
    derived_stale: bool,
    enabled: Enabled,
    /// States given out to the host; boxed, since their addresses are their handles.
    #[allow(clippy::vec_box)]
    kept: Vec<Box<FmuState>>,
}

impl Instance {
    /// `fmi2Instantiate` (FMI 2.0, 2.1.5).
    ///
    /// # Errors
    /// When the name is blank or the GUID is not this FMU's.
    pub fn new(name: &str, interface: Interface, guid: &str, logging_on: bool) -> Outcome<Self> {
        if name.trim().is_empty() {
            return Err(Problem::Text {
                argument: "instanceName",
                value: name.to_owned(),
                allowed: "text with at least one character that is no white space".to_owned(),
            });
        }
        let hash = description::fingerprint_hash();
        let own = description::format_guid(hash);
        if guid != own {
            return Err(Problem::Text { argument: "fmuGUID", value: guid.to_owned(), allowed: own });
        }
        Ok(Self {
            origin: hash.to_le_bytes(),
            interface,
            state: State::Instantiated,
            settings: Settings::default(),
            experiment: None,
            engine: Engine::None,
            slopes_set: [false; 3],
            parameters_set: false,
            loads_set: false,
            motion: Motion::default(),
            motion_stale: true,
            derived: Derived::default(),
            derived_stale: true,
            enabled: Enabled::at_start(logging_on),
            kept: Vec::new(),
        })
    }

    /// Interface type.
    pub fn interface(&self) -> Interface {
        self.interface
    }

    /// Present state.
    pub fn state(&self) -> State {
        self.state
    }

    /// Which log categories are enabled.
    pub fn enabled(&self) -> Enabled {
        self.enabled
    }

    /// Puts the instance into any state, to visit every cell of the state machines.
    #[cfg(test)]
    pub(crate) fn force(&mut self, state: State) {
        self.state = state;
    }

    /// Marks the instance unusable after a panic.
    pub fn break_down(&mut self) {
        self.state = State::Fatal;
    }

    /// Refuses `function` in a state in which it is not allowed.
    ///
    /// # Errors
    /// [`Problem::State`].
    pub fn guard(&self, function: Function) -> Outcome {
        if function.allowed(self.interface, self.state) {
            return Ok(());
        }
        Err(Problem::State { function, state: self.state, interface: self.interface })
    }

    /// `fmi2SetDebugLogging` (FMI 2.0, 2.1.5); no names means all categories.
    ///
    /// # Errors
    /// [`Problem::Text`] for an unknown category; nothing has changed then.
    pub fn set_debug_logging<S: AsRef<str>>(
        &mut self,
        on: bool,
        categories: impl IntoIterator<Item = Outcome<S>>,
    ) -> Outcome {
        self.guard(Function::SetDebugLogging)?;
        let (mut enabled, mut any) = (self.enabled, false);
        for name in categories {
            let name = name?;
            let name = name.as_ref();
            any = true;
            enabled = enabled.with(name, on).ok_or_else(|| Problem::Text {
                argument: "category",
                value: name.to_owned(),
                allowed: description::LOG_CATEGORIES.map(|category| category.name).join(", "),
            })?;
        }
        self.enabled = if any { enabled } else { Enabled::all(on) };
        Ok(())
    }

    /// `fmi2SetupExperiment` (FMI 2.0, 2.1.6).
    ///
    /// # Errors
    /// [`Problem::Value`] for a tolerance that is not positive, a start that is not finite, a stop before the start.
    pub fn setup_experiment(&mut self, tolerance: Option<f64>, start: f64, stop: Option<f64>) -> Outcome {
        self.guard(Function::SetupExperiment)?;
        let refuse = |name, value, allowed| Err(Problem::Value { name, value, allowed });
        match tolerance {
            Some(value) if !(value.is_finite() && value >= 0.0) => {
                return refuse("tolerance", value, "a finite number >= 0");
            }
            _ => {}
        }
        if !start.is_finite() {
            return refuse("startTime", start, "a finite number");
        }
        match stop {
            Some(value) if !(value.is_finite() && value >= start) => {
                return refuse("stopTime", value, "a finite number not before startTime");
            }
            _ => {}
        }
        self.experiment = Some(Experiment { start, stop });
        Ok(())
    }

    /// `fmi2EnterInitializationMode` (FMI 2.0, 2.1.6).
    ///
    /// # Errors
    /// [`Problem::Sequence`] without an experiment.
    pub fn enter_initialization_mode(&mut self) -> Outcome {
        self.guard(Function::EnterInitializationMode)?;
        if self.experiment.is_none() {
            return Err(Problem::Sequence { what: "fmi2SetupExperiment must be called before" });
        }
        self.state = State::InitializationMode;
        self.motion_stale = true;
        Ok(())
    }

    /// `fmi2ExitInitializationMode` (FMI 2.0, 2.1.6): builds what moves.
    ///
    /// # Errors
    /// When the start values or the parameters are not possible; the instance stays in Initialization Mode.
    pub fn exit_initialization_mode(&mut self, log: &mut dyn Log) -> Outcome {
        self.guard(Function::ExitInitializationMode)?;
        let (engine, objections) = self.initial_engine()?;
        if let Some(objections) = objections
            && self.enabled.contains(Category::Warning)
        {
            log.log(Status::Warning, Category::Warning, &format!("fmi2ExitInitializationMode: {objections}"));
        }
        self.engine = engine;
        (self.parameters_set, self.loads_set) = (false, false);
        self.slopes_set = [false; 3];
        self.motion_stale = true;
        self.state = match self.interface {
            Interface::CoSimulation => State::StepComplete,
            Interface::ModelExchange => State::EventMode,
        };
        Ok(())
    }

    /// `fmi2Terminate` (FMI 2.0, 2.1.6).
    ///
    /// # Errors
    /// [`Problem::State`].
    pub fn terminate(&mut self) -> Outcome {
        self.guard(Function::Terminate)?;
        self.state = State::Terminated;
        Ok(())
    }

    /// `fmi2Reset` (FMI 2.0, 2.1.6): as just instantiated; log categories stay as set.
    ///
    /// # Errors
    /// [`Problem::State`].
    pub fn reset(&mut self) -> Outcome {
        self.guard(Function::Reset)?;
        self.state = State::Instantiated;
        self.settings = Settings::default();
        self.experiment = None;
        self.engine = Engine::None;
        self.slopes_set = [false; 3];
        (self.parameters_set, self.loads_set) = (false, false);
        (self.motion_stale, self.derived_stale) = (true, true);
        Ok(())
    }

    /// Brings `motion` up to date. In Initialization Mode that evaluates the start.
    fn refresh_motion(&mut self) -> Outcome {
        if !self.motion_stale {
            return Ok(());
        }
        self.motion = match &self.engine {
            Engine::Simulation(simulator) => Motion::of(simulator),
            Engine::Closed(form) => form.motion(),
            Engine::Continuous(continuous) => continuous.motion(),
            Engine::None => self.initial_motion(&self.settings)?,
        };
        self.motion_stale = false;
        Ok(())
    }

    /// Brings `derived` up to date; only after parameters were set, since steady states take a while to compute.
    fn refresh_derived(&mut self) {
        if self.derived_stale {
            self.derived = Derived::of(&self.settings.parameters);
            self.derived_stale = false;
        }
    }
}
