//! The functions of FMI 2.0 as calls of the component. Before each of them the C interface calls
//! [`guard`](Instance::guard), which alone checks the function against the present state.

use super::problem::{CallProblem, Outcome};
use super::states::{self, Function, Stage};
use super::status::{self, StatusKind};
use super::types::FmiEventInfo;
use crate::component::Component;
use crate::events::StepOutcome;
use crate::instance;
use crate::instantiation::{Instantiation, Version};
use crate::life::EventHandling;
use crate::messages::Sink;
use crate::problem::Refused;
use crate::values::{Base, Bases};
use std::ops::{Deref, DerefMut};

/// Types of `fmi2GetReal` and `fmi2SetReal` (FMI 2.0, 2.1.7).
pub const REAL: Bases = Bases::REAL;
/// Types of `fmi2GetInteger` and `fmi2SetInteger`: enumerations are read and set as Integers.
pub const INTEGER: Bases = Bases::new("Integer", &[Base::Integer, Base::Enumeration]);
/// Types of `fmi2GetBoolean` and `fmi2SetBoolean`.
pub const BOOLEAN: Bases = Bases::new("Boolean", &[Base::Boolean]);
/// Types of `fmi2GetString` and `fmi2SetString`: none.
pub const STRING: Bases = Bases::new("String", &[]);

/// One instance.
#[derive(Debug)]
pub struct Instance<C: Component> {
    common: instance::CommonInstance<C>,
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
    /// `fmi2Instantiate` (FMI 2.0, 2.1.5) for a `fmi2Type`.
    ///
    /// # Errors
    /// If the name is blank, `kind` is not a value of `fmi2Type`, or the component refuses.
    pub fn new(
        name: &str,
        kind: i32,
        (token, resources): (&str, Option<&str>),
        logging_on: bool,
    ) -> Outcome<C, Self> {
        let interface = states::interface(kind).map_err(common)?;
        let request = Instantiation {
            version: Version::Fmi2,
            interface,
            handling: EventHandling::default(),
            name,
            token,
            resources,
        };
        Ok(Self { common: instance::CommonInstance::new(&request, status::enabled_at_start(logging_on))? })
    }

    /// Refuses `function` if the present state forbids it (FMI 2.0, 3.2.3 and 4.2.4).
    ///
    /// # Errors
    /// [`CallProblem::State`].
    #[inline]
    pub fn guard(&self, function: Function) -> Outcome<C> {
        let life = self.component.life();
        let (interface, stage) = (life.interface, Stage::of(life.phase));
        if function.allowed(interface, stage) {
            return Ok(());
        }
        Err(CallProblem::State { function, stage, interface, early: C::EARLY_END })
    }

    /// `fmi2EnterInitializationMode` (FMI 2.0, 2.1.6).
    ///
    /// # Errors
    /// [`CallProblem::Sequence`] without an experiment.
    pub fn enter_initialization_mode(&mut self) -> Outcome<C> {
        if self.component.life().experiment.is_none() {
            return Err(CallProblem::Sequence { what: "fmi2SetupExperiment must be called before" });
        }
        self.component.enter_initialization();
        Ok(())
    }

    /// `fmi2ExitInitializationMode` (FMI 2.0, 2.1.6).
    ///
    /// # Errors
    /// As [`exit_initialization`](Component::exit_initialization).
    pub fn exit_initialization_mode(&mut self, sink: &mut dyn Sink) -> Outcome<C> {
        let mut log = self.log(sink, Function::ExitInitializationMode.name());
        Ok(self.component.exit_initialization(&mut log)?)
    }

    /// `fmi2NewDiscreteStates` (FMI 2.0, 3.2.2): returns the changes.
    ///
    /// # Errors
    /// As [`handle_events`](Component::handle_events).
    pub fn new_discrete_states(&mut self, sink: &mut dyn Sink) -> Outcome<C, FmiEventInfo> {
        let mut log = self.log(sink, Function::NewDiscreteStates.name());
        let changed = self.component.handle_events(&mut log)?;
        Ok(FmiEventInfo::after_event(changed, self.component.next_event_time()))
    }

    /// `fmi2DoStep` (FMI 2.0, 4.2.2).
    ///
    /// # Errors
    /// [`CallProblem::Stopped`] (status Discard) if the step ended early; otherwise as
    /// [`step_as_agreed`](Component::step_as_agreed).
    #[inline]
    pub fn do_step(&mut self, point: f64, size: f64, sink: &mut dyn Sink) -> Outcome<C> {
        let mut log = self.log(sink, Function::DoStep.name());
        match self.component.step_without_event_mode(point, size, &mut log)? {
            StepOutcome { time, early: true, .. } => Err(CallProblem::Stopped { time, early: C::EARLY_END }),
            _ => Ok(()),
        }
    }

    /// `fmi2CancelStep` (FMI 2.0, 4.2.2): steps are synchronous, so none can be cancelled.
    ///
    /// # Errors
    /// Always.
    pub fn cancel_step(&mut self) -> Outcome<C> {
        Err(CallProblem::Sequence { what: "steps are synchronous: there is no step to cancel" })
    }

    /// `fmi2GetRealStatus` (FMI 2.0, 4.2.3).
    ///
    /// # Errors
    /// [`CallProblem::StatusNotAvailable`] for all kinds except the last successful time.
    pub fn real_status(&self, kind: i32) -> Outcome<C, f64> {
        match StatusKind::from_number(kind).map_err(common)? {
            StatusKind::LastSuccessfulTime => Ok(self.component.time()),
            _ => self.no_status(kind),
        }
    }

    /// `fmi2GetBooleanStatus` (FMI 2.0, 4.2.3).
    ///
    /// # Errors
    /// [`CallProblem::StatusNotAvailable`] for all kinds except `fmi2Terminated`, which is false.
    pub fn boolean_status(&self, kind: i32) -> Outcome<C, bool> {
        match StatusKind::from_number(kind).map_err(common)? {
            StatusKind::Terminated => Ok(false),
            _ => self.no_status(kind),
        }
    }

    /// The error for a status that is read with the wrong function, or that only asynchronous
    /// steps have (FMI 2.0, 4.2.3).
    ///
    /// # Errors
    /// Always.
    pub fn no_status<T>(&self, kind: i32) -> Outcome<C, T> {
        let kind = StatusKind::from_number(kind).map_err(common)?;
        Err(CallProblem::StatusNotAvailable { what: kind.not_available() })
    }

    /// `fmi2Get…` (FMI 2.0, 2.1.7).
    ///
    /// # Errors
    /// As [`get`](crate::Model::get).
    #[inline(always)]
    pub fn get(&mut self, bases: Bases, references: &[u32], write: impl FnMut(usize, f64)) -> Outcome<C> {
        Ok(self.component.get(bases, references, write)?)
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
        write: &mut dyn FnMut(usize, f64),
    ) -> Outcome<C> {
        self.get(bases, references, write)
    }

    /// `fmi2Set…` (FMI 2.0, 2.1.7).
    ///
    /// # Errors
    /// As [`set`](crate::Model::set).
    #[inline(always)]
    pub fn set(&mut self, bases: Bases, references: &[u32], read: impl Fn(usize) -> f64) -> Outcome<C> {
        Ok(self.component.set(bases, references, read)?)
    }

    /// [`set`](Self::set) for rarely used types, compiled once for all of them.
    ///
    /// # Errors
    /// As [`set`](Self::set).
    #[inline(never)]
    pub fn set_any(&mut self, bases: Bases, references: &[u32], read: &dyn Fn(usize) -> f64) -> Outcome<C> {
        self.set(bases, references, read)
    }
}

/// Makes a problem a refusal by the component.
fn common<P: crate::problem::Refusal>(problem: crate::problem::Problem) -> CallProblem<P> {
    Refused::Component(P::from(problem)).into()
}
