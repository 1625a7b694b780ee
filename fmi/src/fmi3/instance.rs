//! What the functions of FMI 3.0 mean for the component. Whether a function may be called in the present state is checked
//! in one place, before any of these: [`guard`](Instance::guard), which the C interface calls.

use super::description;
use super::problem::{Outcome, Problem};
use super::states::{Function, Stage};
use super::types::{DiscreteStates, StepEnd};
use crate::component::log::Categories;
use crate::component::saved_state::SavedState;
use crate::component::settings::SolutionMode;
use crate::component::variables::{Base, Bases, Edition};
use crate::component::{self, EventHandling, Interface, Phase, Protocol};
use crate::ffi::Fault;
use crate::ffi::handles::Handles;
use crate::ffi::pointers::check_count;
use crate::messages::{self, Logger, Sink, Status};

/// Variables of the type `Float64` (FMI 3.0.2, 2.4.7).
pub const FLOAT64: Bases = Bases::new("Float64", &[Base::Real]);
/// Variables of the type `Int32`.
pub const INT32: Bases = Bases::new("Int32", &[Base::Integer]);
/// Variables that `fmi3GetInt64` and `fmi3SetInt64` access: enumerations.
pub const INT64: Bases = Bases::new("Int64 or Enumeration", &[Base::Enumeration]);
/// Variables of the type `Boolean`.
pub const BOOLEAN: Bases = Bases::new("Boolean", &[Base::Boolean]);
/// Variables of the type `Clock`.
pub const CLOCK: Bases = Bases::new("Clock", &[Base::Clock]);

/// By how much an announced event must be later than the present, relative to max(1, |t|): fmusim takes one that is nearer for
/// one in the past, and stops.
const LATER: f64 = 1e-9;

/// Types of which there is no variable.
pub const fn none(name: &'static str) -> Bases {
    Bases::new(name, &[])
}

/// The inputs that a host intends to set inside a step, by body.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Required {
    pub(super) inputs: [bool; 3],
}

/// What the host may do while its callback runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Update {
    /// `intermediateUpdateTime`, s.
    pub time: f64,
    /// `intermediateVariableSetRequested`; otherwise `intermediateVariableGetAllowed` and `intermediateStepFinished`.
    pub set_requested: bool,
    /// `canReturnEarly`.
    pub can_return_early: bool,
}

/// One instance.
#[derive(Debug)]
pub struct Instance {
    /// What it is an instance of.
    pub component: component::Instance,
    enabled: Categories,
    states: Handles<SavedState>,
    /// Which description it is of.
    edition: Edition,
    /// What the host intends to set and get inside a step.
    pub(super) required: Required,
    /// What it may do now, while its callback runs.
    pub(super) update: Option<Update>,
    /// The function whose error has terminated it, if one has.
    failed: Option<Function>,
}

impl Instance {
    /// `fmi3InstantiateModelExchange` and `fmi3InstantiateCoSimulation` (FMI 3.0.2, 2.3.1).
    ///
    /// # Errors
    /// When the name is blank or the token is not this FMU's.
    pub fn new(
        name: &str,
        interface: Interface,
        token: &str,
        handling: EventHandling,
        enabled: Categories,
    ) -> Outcome<Self> {
        if name.trim().is_empty() {
            return Err(Fault::Text {
                argument: "instanceName",
                value: name.to_owned(),
                allowed: "text with at least one character that is no white space".to_owned(),
            }
            .into());
        }
        let Some(edition) = description::edition_of(token) else {
            return Err(Fault::Text {
                argument: "instantiationToken",
                value: token.to_owned(),
                allowed: description::instantiation_token(description::MAIN),
            }
            .into());
        };
        let protocol = Protocol {
            numbering: description::numbering(edition),
            handling,
            start: description::start_settings(),
            edition,
        };
        Ok(Self {
            component: component::Instance::of_protocol(interface, protocol),
            enabled,
            states: Handles::default(),
            edition,
            required: Required::default(),
            update: None,
            failed: None,
        })
    }

    /// Which log categories are enabled.
    pub fn enabled(&self) -> Categories {
        self.enabled
    }

    /// Where it is in the standard's state machine.
    pub fn stage(&self) -> Stage {
        match (Stage::of(self.component.phase()), self.update) {
            (Stage::StepMode, Some(_)) => Stage::IntermediateUpdateMode,
            (stage, _) => stage,
        }
    }

    /// Refuses `function` in a state in which it is not allowed (FMI 3.0.2, 2.3, 3.2 and 4.2).
    ///
    /// # Errors
    /// [`Problem::State`].
    #[inline]
    pub fn guard(&self, function: Function) -> Outcome {
        let (interface, stage) = (self.component.interface(), self.stage());
        if function.allowed(interface, stage) {
            return Ok(());
        }
        let failed = self.failed.filter(|_| stage == Stage::Terminated);
        Err(Problem::State { stage, interface, failed })
    }

    /// What a status of a function leaves behind: after an error the instance is Terminated (FMI 3.0.2, 2.3.1).
    pub fn after(&mut self, function: Function, status: Status) {
        match status {
            Status::Error if self.component.phase() != Phase::Broken => {
                if self.component.phase() != Phase::Terminated {
                    self.failed = Some(function);
                }
                self.component.terminate();
            }
            Status::Fatal => self.component.break_down(),
            _ => {}
        }
    }

    /// Which description it is of.
    pub fn edition(&self) -> Edition {
        self.edition
    }

    pub(super) fn log<'a>(&self, sink: &'a mut dyn Sink, function: Function) -> Logger<'a> {
        Logger { sink, enabled: self.enabled, function: function.name() }
    }

    /// `fmi3Terminate` (FMI 3.0.2, 2.3.4).
    pub fn terminate(&mut self) {
        self.failed = None;
        self.component.terminate();
    }

    /// `fmi3SetDebugLogging` (FMI 3.0.2, 2.3.1); no names means all categories.
    ///
    /// # Errors
    /// [`Fault::Text`] for an unknown category; nothing has changed then.
    pub fn set_debug_logging<S: AsRef<str>>(
        &mut self,
        on: bool,
        categories: impl IntoIterator<Item = Outcome<S>>,
    ) -> Outcome {
        let (mut enabled, mut any) = (self.enabled, false);
        for name in categories {
            any = true;
            enabled = messages::with_category(enabled, name?.as_ref(), on)?;
        }
        let all = if on { Categories::ALL } else { Categories::NONE };
        self.enabled = if any { enabled } else { all };
        Ok(())
    }

    /// `fmi3EnterInitializationMode` (FMI 3.0.2, 2.3.2).
    ///
    /// # Errors
    /// As [`set_experiment`](component::Instance::set_experiment).
    pub fn enter_initialization_mode(
        &mut self,
        tolerance: Option<f64>,
        start: f64,
        stop: Option<f64>,
    ) -> Outcome {
        self.component.set_experiment(tolerance, start, stop)?;
        self.component.enter_initialization();
        Ok(())
    }

    /// `fmi3ExitInitializationMode` (FMI 3.0.2, 2.3.3).
    ///
    /// # Errors
    /// [`Problem::Sequence`] for a closed form in Model Exchange; else as
    /// [`exit_initialization`](component::Instance::exit_initialization).
    pub fn exit_initialization_mode(&mut self, sink: &mut dyn Sink) -> Outcome {
        let closed = self.component.settings().mode != SolutionMode::EventDriven;
        if closed && self.component.interface() == Interface::ModelExchange {
            let what = "mode must be 1 (EventDriven) in Model Exchange: a closed form has no derivatives to integrate";
            return Err(Problem::Sequence { what });
        }
        let mut log = self.log(sink, Function::ExitInitializationMode);
        Ok(self.component.exit_initialization(&mut log)?)
    }

    /// `fmi3Get{VariableType}` (FMI 3.0.2, 2.2.6.2): hands value `i` to `write`.
    ///
    /// # Errors
    /// For another number of values than the variables have; else as [`get`](component::Instance::get).
    #[inline]
    pub fn get(
        &mut self,
        bases: Bases,
        references: &[u32],
        count: usize,
        mut write: impl FnMut(usize, f64),
    ) -> Outcome {
        self.check_get()?;
        let mut written = 0;
        self.component.get(bases, references, |i, value| {
            written = i + 1;
            write(i, value);
        })?;
        Ok(check_count("nValues", count, written)?)
    }

    /// `fmi3Set{VariableType}` (FMI 3.0.2, 2.2.6.2): takes value `i` from `read`.
    ///
    /// # Errors
    /// For another number of values than the variables have; else as [`set`](component::Instance::set).
    #[inline]
    pub fn set(
        &mut self,
        bases: Bases,
        references: &[u32],
        count: usize,
        read: impl Fn(usize) -> f64,
    ) -> Outcome {
        check_count("nValues", count, references.len())?;
        self.check_set(references)?;
        Ok(self.component.set(bases, references, read)?)
    }

    /// `fmi3EnterEventMode` (FMI 3.0.2, 3.2.1 and 4.2.1).
    ///
    /// # Errors
    /// [`Problem::Sequence`] in Co-Simulation where `eventModeUsed` is false.
    pub fn enter_event_mode(&mut self) -> Outcome {
        if !self.component.event_handling().event_mode {
            return Err(Problem::Sequence { what: "eventModeUsed was false at the instantiation" });
        }
        Ok(self.component.enter_event()?)
    }

    /// `fmi3UpdateDiscreteStates` (FMI 3.0.2, 2.3.5).
    ///
    /// # Errors
    /// As [`handle_events`](component::Instance::handle_events).
    pub fn update_discrete_states(&mut self, sink: &mut dyn Sink) -> Outcome<DiscreteStates> {
        let mut log = self.log(sink, Function::UpdateDiscreteStates);
        let changed = self.component.handle_events(&mut log)?;
        Ok(DiscreteStates { changed, next_event_time: self.next_event_time() })
    }

    /// `nextEventTime`: that of the next impact, rest or release in Co-Simulation, where it is later than the present also for a
    /// host that compares times with a tolerance. In Model Exchange events are the host's to find.
    fn next_event_time(&mut self) -> Option<f64> {
        if self.component.interface() == Interface::ModelExchange {
            return None;
        }
        let (now, prediction) = (self.component.time(), self.component.prediction());
        let later = prediction.time > now + LATER * now.abs().max(1.0);
        (prediction.known && later).then_some(prediction.time)
    }

    /// `fmi3EnterStepMode` (FMI 3.0.2, 2.3.5) and `fmi3EnterContinuousTimeMode`.
    ///
    /// # Errors
    /// As [`leave_event`](component::Instance::leave_event).
    pub fn leave_event_mode(&mut self, function: Function, sink: &mut dyn Sink) -> Outcome {
        let mut log = self.log(sink, function);
        Ok(self.component.leave_event(&mut log)?)
    }

    /// `fmi3DoStep` (FMI 3.0.2, 4.2.1).
    ///
    /// # Errors
    /// As [`advance`](component::Instance::advance).
    #[inline]
    pub fn do_step(&mut self, point: f64, size: f64, sink: &mut dyn Sink) -> Outcome<StepEnd> {
        let mut log = self.log(sink, Function::DoStep);
        let component::Advance { time, event, early } = self.component.advance(point, size, &mut log)?;
        Ok(StepEnd { event_handling_needed: event, early_return: early, last_successful_time: time })
    }

    /// `fmi3GetFMUState` (FMI 3.0.2, 2.2.6.4): saves into the place of `handle`, or a new one where that is zero.
    ///
    /// # Errors
    /// For a handle that is neither zero nor this instance's.
    pub fn save(&mut self, handle: usize) -> Outcome<usize> {
        Ok(self.states.keep(self.component.save(), handle)?)
    }

    /// `fmi3SetFMUState` (FMI 3.0.2, 2.2.6.4).
    ///
    /// # Errors
    /// For a handle that is not this instance's, and as [`restore`](component::Instance::restore).
    pub fn restore(&mut self, handle: usize) -> Outcome {
        Ok(self.component.restore(self.states.get(handle)?)?)
    }

    /// `fmi3FreeFMUState` (FMI 3.0.2, 2.2.6.4).
    ///
    /// # Errors
    /// For a handle that is not this instance's.
    pub fn free(&mut self, handle: usize) -> Outcome {
        Ok(self.states.free(handle)?)
    }

    /// `fmi3SerializeFMUState` (FMI 3.0.2, 2.2.6.4).
    ///
    /// # Errors
    /// For a handle that is not this instance's.
    pub fn serialized(&self, handle: usize) -> Outcome<Vec<u8>> {
        Ok(self.states.get(handle)?.serialize()?)
    }

    /// `fmi3DeserializeFMUState` (FMI 3.0.2, 2.2.6.4): into the place of `handle` where that is this instance's, else a new one.
    ///
    /// # Errors
    /// As [`deserialize`](SavedState::deserialize).
    pub fn deserialize(&mut self, serialized: &[u8], handle: usize) -> Outcome<usize> {
        Ok(self.states.keep_new(SavedState::deserialize(serialized)?, handle)?)
    }
}
