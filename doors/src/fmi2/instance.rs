//! What the functions of FMI 2.0 mean for the component. Whether a function may be called in the present state is checked
//! in one place, before any of these: [`guard`](Instance::guard), which the C interface calls.

use super::problem::{Outcome, Problem};
use super::states::{self, Function, Stage};
use super::status::{self, StatusKind};
use super::types::FmiEventInfo;
use crate::component::Component;
use crate::events::StepReason;
use crate::ffi::Fault;
use crate::ffi::handles::Handles;
use crate::instantiation::{Instantiation, Version};
use crate::life::EventHandling;
use crate::log::Categories;
use crate::messages::{self, Logger, Sink};
use crate::values::{Base, Bases};

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
pub struct Instance<C: Component> {
    /// What it is an instance of.
    pub component: C,
    enabled: Categories,
    states: Handles<C::State>,
}

impl<C: Component> Instance<C> {
    /// `fmi2Instantiate` (FMI 2.0, 2.1.5) for a `fmi2Type`.
    ///
    /// # Errors
    /// When the name is blank, the type is none, or the component refuses.
    pub fn new(
        name: &str,
        kind: i32,
        (guid, resources): (&str, Option<&str>),
        logging_on: bool,
    ) -> Outcome<C, Self> {
        let interface = states::interface(kind).map_err(common)?;
        if name.trim().is_empty() {
            return Err(Fault::Text {
                argument: "instanceName",
                value: name.to_owned(),
                allowed: "text with at least one character that is no white space".to_owned(),
            }
            .into());
        }
        let component = C::instantiate(&Instantiation {
            version: Version::Fmi2,
            interface,
            handling: EventHandling::default(),
            name,
            token: guid,
            resources,
        })?;
        Ok(Self { component, enabled: status::enabled_at_start(logging_on), states: Handles::default() })
    }

    /// Lets the component tell what is worth knowing about the way in which it was made.
    pub fn tell(&self, sink: &mut dyn Sink) {
        let mut log = Logger { sink, enabled: self.enabled, function: "fmi2Instantiate" };
        self.component.tell_at_instantiation(&mut log);
    }

    /// More elements than this in one call are taken for a mistake.
    #[inline]
    pub fn max_count(&self) -> usize {
        C::MAX_COUNT
    }

    /// Number of continuous states.
    #[inline]
    pub fn number_of_states(&self) -> usize {
        self.component.number_of_continuous_states()
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
    pub fn guard(&self, function: Function) -> Outcome<C> {
        let life = self.component.life();
        let (interface, stage) = (life.interface, Stage::of(life.phase));
        if function.allowed(interface, stage) {
            return Ok(());
        }
        Err(Problem::State { function, stage, interface, early: C::EARLY_END })
    }

    /// `fmi2SetDebugLogging` (FMI 2.0, 2.1.5); no names means all categories.
    ///
    /// # Errors
    /// [`Fault::Text`] for an unknown category; nothing has changed then.
    pub fn set_debug_logging<S: AsRef<str>>(
        &mut self,
        on: bool,
        categories: impl IntoIterator<Item = Outcome<C, S>>,
    ) -> Outcome<C> {
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
    pub fn enter_initialization_mode(&mut self) -> Outcome<C> {
        if self.component.life().experiment.is_none() {
            return Err(Problem::Sequence { what: "fmi2SetupExperiment must be called before" });
        }
        self.component.enter_initialization();
        Ok(())
    }

    /// `fmi2ExitInitializationMode` (FMI 2.0, 2.1.6).
    ///
    /// # Errors
    /// As [`exit_initialization`](Component::exit_initialization).
    pub fn exit_initialization_mode(&mut self, sink: &mut dyn Sink) -> Outcome<C> {
        let mut log =
            Logger { sink, enabled: self.enabled, function: Function::ExitInitializationMode.name() };
        Ok(self.component.exit_initialization(&mut log)?)
    }

    /// `fmi2NewDiscreteStates` (FMI 2.0, 3.2.2): returns what has changed.
    ///
    /// # Errors
    /// As [`handle_events`](Component::handle_events).
    pub fn new_discrete_states(&mut self, sink: &mut dyn Sink) -> Outcome<C, FmiEventInfo> {
        let mut log = Logger { sink, enabled: self.enabled, function: Function::NewDiscreteStates.name() };
        let changed = self.component.handle_events(&mut log)?;
        Ok(FmiEventInfo::after_event(changed, self.component.next_event_time()))
    }

    /// `fmi2DoStep` (FMI 2.0, 4.2.2).
    ///
    /// # Errors
    /// [`Problem::Stopped`] (status Discard) when the step ended early; else as [`step`](Component::step).
    #[inline]
    pub fn do_step(&mut self, point: f64, size: f64, sink: &mut dyn Sink) -> Outcome<C> {
        let mut log = Logger { sink, enabled: self.enabled, function: Function::DoStep.name() };
        let outcome = self.component.step(point, size, &mut log)?;
        match outcome.reason {
            StepReason::EndReached => Ok(()),
            StepReason::Stopped => Err(Problem::Stopped { time: outcome.time, early: C::EARLY_END }),
        }
    }

    /// `fmi2CancelStep` (FMI 2.0, 4.2.2): steps are synchronous, so there is never one to cancel.
    ///
    /// # Errors
    /// Always.
    pub fn cancel_step(&mut self) -> Outcome<C> {
        Err(Problem::Sequence { what: "steps are synchronous: there is none to cancel" })
    }

    /// `fmi2GetRealStatus` (FMI 2.0, 4.2.3).
    ///
    /// # Errors
    /// [`Problem::StatusNotAvailable`] for all but the last successful time.
    pub fn real_status(&self, kind: i32) -> Outcome<C, f64> {
        match StatusKind::from_number(kind).map_err(common)? {
            StatusKind::LastSuccessfulTime => Ok(self.component.time()),
            _ => self.no_status(kind),
        }
    }

    /// `fmi2GetBooleanStatus` (FMI 2.0, 4.2.3).
    ///
    /// # Errors
    /// [`Problem::StatusNotAvailable`] for all but `fmi2Terminated`, which is never so.
    pub fn boolean_status(&self, kind: i32) -> Outcome<C, bool> {
        match StatusKind::from_number(kind).map_err(common)? {
            StatusKind::Terminated => Ok(false),
            _ => self.no_status(kind),
        }
    }

    /// The answer to one who asks for a status with the wrong function, or for one of asynchronous steps (FMI 2.0, 4.2.3).
    ///
    /// # Errors
    /// Always.
    pub fn no_status<T>(&self, kind: i32) -> Outcome<C, T> {
        let kind = StatusKind::from_number(kind).map_err(common)?;
        Err(Problem::StatusNotAvailable { what: kind.not_available() })
    }

    /// `fmi2GetFMUstate` (FMI 2.0, 2.1.8): saves into the place of `handle`, or a new one where that is zero.
    ///
    /// # Errors
    /// For a handle that is neither zero nor this instance's.
    pub fn save(&mut self, handle: usize) -> Outcome<C, usize> {
        if handle == 0 {
            return Ok(self.states.keep(self.component.save()?, 0)?);
        }
        self.component.save_into(self.states.get_mut(handle)?)?;
        Ok(handle)
    }

    /// `fmi2SetFMUstate` (FMI 2.0, 2.1.8).
    ///
    /// # Errors
    /// For a handle that is not this instance's, and as [`restore`](Component::restore).
    pub fn restore(&mut self, handle: usize) -> Outcome<C> {
        Ok(self.component.restore(self.states.get(handle)?)?)
    }

    /// `fmi2FreeFMUstate` (FMI 2.0, 2.1.8).
    ///
    /// # Errors
    /// For a handle that is not this instance's.
    pub fn free(&mut self, handle: usize) -> Outcome<C> {
        Ok(self.states.free(handle)?)
    }

    /// `fmi2SerializeFMUstate` (FMI 2.0, 2.1.8).
    ///
    /// # Errors
    /// For a handle that is not this instance's.
    pub fn serialized(&self, handle: usize) -> Outcome<C, Vec<u8>> {
        Ok(self.component.serialize(self.states.get(handle)?)?)
    }

    /// `fmi2DeSerializeFMUstate` (FMI 2.0, 2.1.8): into the place of `handle` where that is this instance's, else a new one.
    ///
    /// # Errors
    /// As [`deserialize`](Component::deserialize).
    pub fn deserialize(&mut self, serialized: &[u8], handle: usize) -> Outcome<C, usize> {
        Ok(self.states.keep_new(self.component.deserialize(serialized)?, handle)?)
    }

    /// `fmi2SetupExperiment` (FMI 2.0, 2.1.6).
    ///
    /// # Errors
    /// As [`set_experiment`](Component::set_experiment).
    pub fn setup_experiment(&mut self, tolerance: Option<f64>, start: f64, stop: Option<f64>) -> Outcome<C> {
        Ok(self.component.set_experiment(tolerance, start, stop)?)
    }

    /// `fmi2Terminate` (FMI 2.0, 2.1.6).
    ///
    /// # Errors
    /// None.
    pub fn terminate(&mut self) -> Outcome<C> {
        self.component.terminate();
        Ok(())
    }

    /// `fmi2Reset` (FMI 2.0, 2.1.6).
    ///
    /// # Errors
    /// None.
    pub fn reset(&mut self) -> Outcome<C> {
        self.component.reset();
        Ok(())
    }

    /// `fmi2EnterEventMode` (FMI 2.0, 3.2.2).
    ///
    /// # Errors
    /// As [`enter_event`](Component::enter_event).
    pub fn enter_event_mode(&mut self) -> Outcome<C> {
        Ok(self.component.enter_event()?)
    }

    /// `fmi2EnterContinuousTimeMode` (FMI 2.0, 3.2.2).
    ///
    /// # Errors
    /// None.
    pub fn enter_continuous_time_mode(&mut self) -> Outcome<C> {
        self.component.enter_continuous();
        Ok(())
    }

    /// `fmi2CompletedIntegratorStep` (FMI 2.0, 3.2.2): whether the host must enter Event Mode.
    ///
    /// # Errors
    /// As [`complete_integrator_step`](Component::complete_integrator_step).
    pub fn completed_integrator_step(&mut self) -> Outcome<C, bool> {
        Ok(self.component.complete_integrator_step()?)
    }

    /// `fmi2SetTime` (FMI 2.0, 3.2.1).
    ///
    /// # Errors
    /// As [`set_time`](Component::set_time).
    pub fn set_time(&mut self, time: f64) -> Outcome<C> {
        Ok(self.component.set_time(time)?)
    }

    /// `fmi2SetContinuousStates` (FMI 2.0, 3.2.1).
    ///
    /// # Errors
    /// As [`set_continuous_states`](Component::set_continuous_states).
    pub fn set_continuous_states(&mut self, states: &[f64]) -> Outcome<C> {
        Ok(self.component.set_continuous_states(states)?)
    }

    /// `fmi2GetContinuousStates` (FMI 2.0, 3.2.2).
    ///
    /// # Errors
    /// As [`continuous_states`](Component::continuous_states).
    pub fn continuous_states(&self) -> Outcome<C, impl AsRef<[f64]>> {
        Ok(self.component.continuous_states()?)
    }

    /// `fmi2GetDerivatives` (FMI 2.0, 3.2.2).
    ///
    /// # Errors
    /// As [`state_derivatives`](Component::state_derivatives).
    pub fn derivatives(&self) -> Outcome<C, impl AsRef<[f64]>> {
        Ok(self.component.state_derivatives()?)
    }

    /// `fmi2GetEventIndicators` (FMI 2.0, 3.2.2).
    ///
    /// # Errors
    /// As [`event_indicators`](Component::event_indicators).
    pub fn event_indicators(&self) -> Outcome<C, impl AsRef<[f64]>> {
        Ok(self.component.event_indicators()?)
    }

    /// `fmi2GetNominalsOfContinuousStates` (FMI 2.0, 3.2.2).
    pub fn nominals(&self) -> impl AsRef<[f64]> {
        self.component.nominals()
    }

    /// `fmi2SetRealInputDerivatives` (FMI 2.0, 4.2.1).
    ///
    /// # Errors
    /// As [`set_input_derivatives`](Component::set_input_derivatives).
    pub fn set_real_input_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &[f64],
    ) -> Outcome<C> {
        Ok(self.component.set_input_derivatives(references, orders, values)?)
    }

    /// `fmi2GetRealOutputDerivatives` (FMI 2.0, 4.2.1).
    ///
    /// # Errors
    /// As [`output_derivatives`](Component::output_derivatives).
    pub fn real_output_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        write: impl FnMut(usize, f64),
    ) -> Outcome<C> {
        Ok(self.component.output_derivatives(references, orders, write)?)
    }

    /// `fmi2GetDirectionalDerivative` (FMI 2.0, 2.1.9).
    ///
    /// # Errors
    /// As [`directional_derivative`](Component::directional_derivative).
    pub fn directional_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        write: impl FnMut(usize, f64),
    ) -> Outcome<C> {
        Ok(self.component.directional_derivative(unknowns, knowns, seed, write)?)
    }

    /// `fmi2Get…` (FMI 2.0, 2.1.7).
    ///
    /// # Errors
    /// As [`get`](Component::get).
    #[inline(always)]
    pub fn get(&mut self, bases: Bases, references: &[u32], write: impl FnMut(usize, f64)) -> Outcome<C> {
        Ok(self.component.get(bases, references, write)?)
    }

    /// The same for the types that are seldom asked for, compiled once for all of them.
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
    /// As [`set`](Component::set).
    #[inline(always)]
    pub fn set(&mut self, bases: Bases, references: &[u32], read: impl Fn(usize) -> f64) -> Outcome<C> {
        Ok(self.component.set(bases, references, read)?)
    }

    /// The same for the types that are seldom set, compiled once for all of them.
    ///
    /// # Errors
    /// As [`set`](Self::set).
    #[inline(never)]
    pub fn set_any(&mut self, bases: Bases, references: &[u32], read: &dyn Fn(usize) -> f64) -> Outcome<C> {
        self.set(bases, references, read)
    }
}

/// What is refused in the component's name.
fn common<P: crate::problem::Refusal>(problem: crate::problem::Problem) -> Problem<P> {
    Problem::Component(problem.into())
}
