//! What the functions of FMI 2.0 mean for the component. Whether a function may be called in the present state is checked
//! in one place, before any of these: [`guard`](Instance::guard), which the C interface calls.

use super::description;
use super::problem::{Outcome, Problem};
use super::states::{Function, Stage};
use super::status::{self, StatusKind};
use crate::component::log::Categories;
use crate::component::saved_state::SavedState;
use crate::component::variables::{Base, Bases};
use crate::component::{self, Handled, Interface, Protocol, StepReason};
use crate::ffi::Fault;
use crate::ffi::handles::Handles;
use crate::messages::{self, Logger, Sink};

/// Types of `fmi2GetReal` and `fmi2SetReal` (FMI 2.0, 2.1.7).
pub const REAL: Bases = Bases::REAL;
/// Types of `fmi2GetInteger` and `fmi2SetInteger`: enumerations are read and set as Integers.
pub const INTEGER: Bases = Bases::new("Integer", &[Base::Integer, Base::Enumeration]);
/// Types of `fmi2GetBoolean` and `fmi2SetBoolean`.
pub const BOOLEAN: Bases = Bases::new("Boolean", &[Base::Boolean]);
/// Types of `fmi2GetString` and `fmi2SetString`: there are none.
pub const STRING: Bases = Bases::new("String", &[]);

/// One instance.
#[derive(Debug)]
pub struct Instance {
    /// What it is an instance of.
    pub component: component::Instance,
    enabled: Categories,
    states: Handles<SavedState>,
}

impl Instance {
    /// `fmi2Instantiate` (FMI 2.0, 2.1.5).
    ///
    /// # Errors
    /// When the name is blank or the GUID is not this FMU's.
    pub fn new(name: &str, interface: Interface, guid: &str, logging_on: bool) -> Outcome<Self> {
        if name.trim().is_empty() {
            return Err(Fault::Text {
                argument: "instanceName",
                value: name.to_owned(),
                allowed: "text with at least one character that is no white space".to_owned(),
            }
            .into());
        }
        let own = description::guid();
        if guid != own {
            return Err(Fault::Text { argument: "fmuGUID", value: guid.to_owned(), allowed: own }.into());
        }
        let protocol = Protocol { numbering: description::NUMBERING, ..Protocol::default() };
        Ok(Self {
            component: component::Instance::of_protocol(interface, protocol),
            enabled: status::enabled_at_start(logging_on),
            states: Handles::default(),
        })
    }

    /// Which log categories are enabled.
    pub fn enabled(&self) -> Categories {
        self.enabled
    }

    /// Refuses `function` in a state in which it is not allowed (FMI 2.0, 3.2.3 and 4.2.4).
    ///
    /// # Errors
    /// [`Problem::State`].
    #[inline]
    pub fn guard(&self, function: Function) -> Outcome {
        let (interface, stage) = (self.component.interface(), Stage::of(self.component.phase()));
        if function.allowed(interface, stage) {
            return Ok(());
        }
        Err(Problem::State { function, stage, interface })
    }

    /// `fmi2SetDebugLogging` (FMI 2.0, 2.1.5); no names means all categories.
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

    /// `fmi2EnterInitializationMode` (FMI 2.0, 2.1.6).
    ///
    /// # Errors
    /// [`Problem::Sequence`] without an experiment.
    pub fn enter_initialization_mode(&mut self) -> Outcome {
        if !self.component.has_experiment() {
            return Err(Problem::Sequence { what: "fmi2SetupExperiment must be called before" });
        }
        self.component.enter_initialization();
        Ok(())
    }

    /// `fmi2ExitInitializationMode` (FMI 2.0, 2.1.6).
    ///
    /// # Errors
    /// As [`exit_initialization`](component::Instance::exit_initialization).
    pub fn exit_initialization_mode(&mut self, sink: &mut dyn Sink) -> Outcome {
        let mut log =
            Logger { sink, enabled: self.enabled, function: Function::ExitInitializationMode.name() };
        Ok(self.component.exit_initialization(&mut log)?)
    }

    /// `fmi2NewDiscreteStates` (FMI 2.0, 3.2.2): returns what has changed.
    ///
    /// # Errors
    /// As [`handle_events`](component::Instance::handle_events).
    pub fn new_discrete_states(&mut self, sink: &mut dyn Sink) -> Outcome<Handled> {
        let mut log = Logger { sink, enabled: self.enabled, function: Function::NewDiscreteStates.name() };
        Ok(self.component.handle_events(&mut log)?)
    }

    /// `fmi2DoStep` (FMI 2.0, 4.2.2).
    ///
    /// # Errors
    /// [`Problem::Impact`] (status Discard) when `stopAtImpact` ends the step early; else as
    /// [`step`](component::Instance::step).
    #[inline]
    pub fn do_step(&mut self, point: f64, size: f64, sink: &mut dyn Sink) -> Outcome {
        let mut log = Logger { sink, enabled: self.enabled, function: Function::DoStep.name() };
        let outcome = self.component.step(point, size, &mut log)?;
        match outcome.reason {
            StepReason::EndReached => Ok(()),
            StepReason::Impact => Err(Problem::Impact { time: outcome.time }),
        }
    }

    /// `fmi2CancelStep` (FMI 2.0, 4.2.2): steps are synchronous, so there is never one to cancel.
    ///
    /// # Errors
    /// Always.
    pub fn cancel_step(&mut self) -> Outcome {
        Err(Problem::Sequence { what: "steps are synchronous: there is none to cancel" })
    }

    /// `fmi2GetRealStatus` (FMI 2.0, 4.2.3).
    ///
    /// # Errors
    /// [`Problem::StatusNotAvailable`] for all but the last successful time.
    pub fn real_status(&self, kind: StatusKind) -> Outcome<f64> {
        match kind {
            StatusKind::LastSuccessfulTime => Ok(self.component.time()),
            _ => Err(kind.not_available()),
        }
    }

    /// `fmi2GetBooleanStatus` (FMI 2.0, 4.2.3).
    ///
    /// # Errors
    /// [`Problem::StatusNotAvailable`] for all but `fmi2Terminated`, which is never so.
    pub fn boolean_status(&self, kind: StatusKind) -> Outcome<bool> {
        match kind {
            StatusKind::Terminated => Ok(false),
            _ => Err(kind.not_available()),
        }
    }

    /// `fmi2GetFMUstate` (FMI 2.0, 2.1.8): saves into the place of `handle`, or a new one where that is zero.
    ///
    /// # Errors
    /// For a handle that is neither zero nor this instance's.
    pub fn save(&mut self, handle: usize) -> Outcome<usize> {
        Ok(self.states.keep(self.component.save(), handle)?)
    }

    /// `fmi2SetFMUstate` (FMI 2.0, 2.1.8).
    ///
    /// # Errors
    /// For a handle that is not this instance's, and as [`restore`](component::Instance::restore).
    pub fn restore(&mut self, handle: usize) -> Outcome {
        Ok(self.component.restore(self.states.get(handle)?)?)
    }

    /// `fmi2FreeFMUstate` (FMI 2.0, 2.1.8).
    ///
    /// # Errors
    /// For a handle that is not this instance's.
    pub fn free(&mut self, handle: usize) -> Outcome {
        Ok(self.states.free(handle)?)
    }

    /// `fmi2SerializeFMUstate` (FMI 2.0, 2.1.8).
    ///
    /// # Errors
    /// For a handle that is not this instance's.
    pub fn serialized(&self, handle: usize) -> Outcome<Vec<u8>> {
        Ok(self.states.get(handle)?.serialize()?)
    }

    /// `fmi2DeSerializeFMUstate` (FMI 2.0, 2.1.8): into the place of `handle` where that is this instance's, else a new one.
    ///
    /// # Errors
    /// As [`deserialize`](SavedState::deserialize).
    pub fn deserialize(&mut self, serialized: &[u8], handle: usize) -> Outcome<usize> {
        Ok(self.states.keep_new(SavedState::deserialize(serialized)?, handle)?)
    }
}
