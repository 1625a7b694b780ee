//! The functions of FMI 3.0 as calls of the component. Before each of them the C interface calls
//! [`guard`](Instance::guard), which alone checks the function against the present state.

use super::problem::{CallProblem, Outcome};
use super::states::{Function, Stage};
use super::types::DiscreteStates;
use crate::component::Component;
use crate::events::StepOutcome;
use crate::ffi::pointers::check_count;
use crate::instance;
use crate::instantiation::{Instantiation, Version};
use crate::life::{EventHandling, Interface, Phase};
use crate::log::Categories;
use crate::messages::{Sink, Status};
use crate::values::{Base, Bases};
use std::ops::{Deref, DerefMut};

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

/// Smallest time from now to an announced event, relative to max(1, |t|). fmusim takes a nearer
/// event for a past one, and stops.
const LATER: f64 = 1e-9;

/// Types without variables.
pub const fn none(name: &'static str) -> Bases {
    Bases::new(name, &[])
}

/// Arguments of the host's callback; these determine the calls that the host may make in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Update {
    /// `intermediateUpdateTime`, s.
    pub time: f64,
    /// `intermediateVariableSetRequested`. If false, `intermediateVariableGetAllowed` and
    /// `intermediateStepFinished` are true.
    pub set_requested: bool,
    /// `canReturnEarly`.
    pub can_return_early: bool,
}

/// One instance.
#[derive(Debug)]
pub struct Instance<C: Component> {
    pub(super) common: instance::CommonInstance<C>,
    /// The inputs that the host intends to set inside a step.
    pub(super) required: Vec<u32>,
    /// The update in progress while the host's callback runs.
    #[doc(hidden)]
    pub update: Option<Update>,
    /// The function whose error has terminated the instance, if any.
    failed: Option<Function>,
}

impl<C: Component> Deref for Instance<C> {
    type Target = instance::CommonInstance<C>;

    fn deref(&self) -> &Self::Target {
        &self.common
    }
}

impl<C: Component> DerefMut for Instance<C> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.common
    }
}

impl<C: Component> Instance<C> {
    /// `fmi3InstantiateModelExchange` and `fmi3InstantiateCoSimulation` (FMI 3.0.2, 2.3.1).
    ///
    /// # Errors
    /// If the name is blank, or the component refuses.
    pub fn new(
        name: &str,
        interface: Interface,
        (token, resources): (&str, Option<&str>),
        handling: EventHandling,
        enabled: Categories,
    ) -> Outcome<C, Self> {
        let version = Version::Fmi3;
        let request = Instantiation { version, interface, handling, name, token, resources };
        Ok(Self {
            common: instance::CommonInstance::new(&request, enabled)?,
            required: Vec::new(),
            update: None,
            failed: None,
        })
    }

    /// Present state of the standard's state machine.
    pub fn stage(&self) -> Stage {
        match (Stage::of(self.component.life().phase), self.update) {
            (Stage::StepMode, Some(_)) => Stage::IntermediateUpdateMode,
            (stage, _) => stage,
        }
    }

    /// Refuses `function` if the present state forbids it (FMI 3.0.2, 2.3, 3.2 and 4.2).
    ///
    /// # Errors
    /// [`CallProblem::State`].
    #[inline]
    pub fn guard(&self, function: Function) -> Outcome<C> {
        let (interface, stage) = (self.component.life().interface, self.stage());
        if function.allowed(interface, stage) {
            return Ok(());
        }
        let failed = self.failed.filter(|_| stage == Stage::Terminated);
        Err(CallProblem::State { stage, interface, failed })
    }

    /// Updates the state after a function has returned `status`: after an error the instance is
    /// Terminated (FMI 3.0.2, 2.3.1).
    pub fn after(&mut self, function: Function, status: Status) {
        match status {
            Status::Error if !matches!(self.component.life().phase, Phase::Broken | Phase::Terminated) => {
                self.failed = Some(function);
                self.component.fail();
            }
            Status::Fatal => self.break_down(),
            _ => {}
        }
    }

    /// `fmi3Terminate` (FMI 3.0.2, 2.3.4).
    ///
    /// # Errors
    /// None.
    pub fn terminate(&mut self) -> Outcome<C> {
        self.failed = None;
        self.component.terminate();
        Ok(())
    }

    /// `fmi3Reset` (FMI 3.0.2, 2.3.1).
    ///
    /// # Errors
    /// None.
    pub fn reset(&mut self) -> Outcome<C> {
        self.component.reset();
        Ok(())
    }

    /// `fmi3EnterInitializationMode` (FMI 3.0.2, 2.3.2).
    ///
    /// # Errors
    /// As [`set_experiment`](Component::set_experiment).
    pub fn enter_initialization_mode(
        &mut self,
        tolerance: Option<f64>,
        start: f64,
        stop: Option<f64>,
    ) -> Outcome<C> {
        self.component.set_experiment(tolerance, start, stop)?;
        self.component.enter_initialization();
        Ok(())
    }

    /// `fmi3ExitInitializationMode` (FMI 3.0.2, 2.3.3).
    ///
    /// # Errors
    /// As [`exit_initialization`](Component::exit_initialization).
    pub fn exit_initialization_mode(&mut self, sink: &mut dyn Sink) -> Outcome<C> {
        let mut log = self.log(sink, Function::ExitInitializationMode.name());
        Ok(self.component.exit_initialization(&mut log)?)
    }

    /// `fmi3Get{VariableType}` (FMI 3.0.2, 2.2.7.2): hands value `i` to `write`.
    ///
    /// # Errors
    /// If the number of values differs from the variables' number of values; otherwise as
    /// [`get`](crate::Model::get).
    #[inline]
    pub fn get(
        &mut self,
        bases: Bases,
        references: &[u32],
        count: usize,
        mut write: impl FnMut(usize, f64),
    ) -> Outcome<C> {
        self.check_get()?;
        let mut written = 0;
        self.component.get(bases, references, |i, value| {
            written = i + 1;
            write(i, value);
        })?;
        Ok(check_count("nValues", count, written)?)
    }

    /// [`get`](Self::get) for rarely used types, compiled once for all of them.
    ///
    /// # Errors
    /// As [`get`](Self::get).
    #[inline(never)]
    pub fn get_any(
        &mut self,
        bases: Bases,
        references: &[u32],
        count: usize,
        write: &mut dyn FnMut(usize, f64),
    ) -> Outcome<C> {
        self.get(bases, references, count, write)
    }

    /// `fmi3Set{VariableType}` (FMI 3.0.2, 2.2.7.2): takes value `i` from `read`.
    ///
    /// # Errors
    /// If the number of values differs from the variables' number of values; otherwise as
    /// [`set`](crate::Model::set).
    #[inline]
    pub fn set(
        &mut self,
        bases: Bases,
        references: &[u32],
        count: usize,
        read: impl Fn(usize) -> f64,
    ) -> Outcome<C> {
        check_count("nValues", count, references.len())?;
        self.check_set(references)?;
        Ok(self.component.set(bases, references, read)?)
    }

    /// [`set`](Self::set) for rarely used types, compiled once for all of them.
    ///
    /// # Errors
    /// As [`set`](Self::set).
    #[inline(never)]
    pub fn set_any(
        &mut self,
        bases: Bases,
        references: &[u32],
        count: usize,
        read: &dyn Fn(usize) -> f64,
    ) -> Outcome<C> {
        self.set(bases, references, count, read)
    }

    /// `fmi3EnterEventMode` (FMI 3.0.2, 3.2.1 and 4.2.1).
    ///
    /// # Errors
    /// [`CallProblem::Sequence`] in Co-Simulation if `eventModeUsed` is false.
    pub fn enter_event_mode(&mut self) -> Outcome<C> {
        if !self.component.life().handling.event_mode {
            return Err(CallProblem::Sequence { what: "eventModeUsed was false at the instantiation" });
        }
        Ok(self.component.enter_event()?)
    }

    /// `fmi3UpdateDiscreteStates` (FMI 3.0.2, 2.3.5).
    ///
    /// # Errors
    /// As [`handle_events`](Component::handle_events).
    pub fn update_discrete_states(&mut self, sink: &mut dyn Sink) -> Outcome<C, DiscreteStates> {
        let mut log = self.log(sink, Function::UpdateDiscreteStates.name());
        let changed = self.component.handle_events(&mut log)?;
        Ok(DiscreteStates { changed, next_event_time: self.next_event_time() })
    }

    /// `nextEventTime`: the time of the next event, if it is later than now by more than the
    /// tolerance with which hosts compare times.
    fn next_event_time(&mut self) -> Option<f64> {
        let time = self.component.next_event_time()?;
        let now = self.component.time();
        (time > now + LATER * now.abs().max(1.0)).then_some(time)
    }

    /// `fmi3EnterStepMode` (FMI 3.0.2, 2.3.5) and `fmi3EnterContinuousTimeMode`.
    ///
    /// # Errors
    /// As [`leave_event`](Component::leave_event).
    pub fn leave_event_mode(&mut self, function: Function, sink: &mut dyn Sink) -> Outcome<C> {
        let mut log = self.log(sink, function.name());
        Ok(self.component.leave_event(&mut log)?)
    }

    /// `fmi3DoStep` (FMI 3.0.2, 4.2.1).
    ///
    /// # Errors
    /// As [`step_as_agreed`](Component::step_as_agreed).
    #[inline]
    pub fn do_step(&mut self, point: f64, size: f64, sink: &mut dyn Sink) -> Outcome<C, StepOutcome> {
        let mut log = self.log(sink, Function::DoStep.name());
        Ok(self.component.step_as_agreed(point, size, &mut log)?)
    }
}
