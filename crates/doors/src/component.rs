//! Life cycle and steps of a component for the doors: the same for every [`Hybrid`].

use crate::events::{Handled, StepOutcome};
use crate::hybrid::{AtEvent, Hybrid, steps};
use crate::life::{EventHandling, Experiment, Interface, Phase};
use crate::log::Log;
use crate::problem::Problem;

/// Life cycle and steps of a component, the type that an FMU instantiates. Each door checks
/// whether a call is possible in the present state.
///
/// Every [`Hybrid`] is a component; no type implements this trait itself.
pub trait Component: Hybrid {
    /// `fmi2SetupExperiment`, and the experiment arguments of `fmi3EnterInitializationMode`.
    ///
    /// # Errors
    /// As [`Experiment::new`].
    fn set_experiment(
        &mut self,
        tolerance: Option<f64>,
        start: f64,
        stop: Option<f64>,
    ) -> Result<(), Self::Problem> {
        self.life_mut().experiment = Some(Experiment::new(tolerance, start, stop)?);
        Ok(())
    }

    /// `fmi2EnterInitializationMode`, `fmi3EnterInitializationMode`: from now on outputs show the
    /// values at the start.
    fn enter_initialization(&mut self) {
        self.life_mut().phase = Phase::Initialization;
        self.forget();
    }

    /// `fmi2ExitInitializationMode`, `fmi3ExitInitializationMode`: the motion begins.
    ///
    /// # Errors
    /// If start values or parameters are not possible; the component stays in initialization.
    fn exit_initialization(&mut self, log: &mut dyn Log) -> Result<(), Self::Problem> {
        self.start(log)?;
        self.life_mut().begin();
        if self.life().phase == Phase::Event {
            self.begin_event();
        }
        Ok(())
    }

    /// `fmi2Terminate`, `fmi3Terminate`.
    fn terminate(&mut self) {
        self.end(false);
        self.life_mut().phase = Phase::Terminated;
    }

    /// An error has ended the simulation (FMI 3.0.2, 2.3.1). Nothing else changes. If an event had
    /// been shown but not carried out, its values are no longer shown.
    fn fail(&mut self) {
        self.end(true);
        self.life_mut().phase = Phase::Terminated;
    }

    /// `fmi2EnterEventMode`, `fmi3EnterEventMode`: the host starts to handle events, even if no
    /// event is due.
    ///
    /// # Errors
    /// As [`Hybrid::accept`].
    fn enter_event(&mut self) -> Result<(), Self::Problem> {
        if self.life().interface == Interface::ModelExchange {
            self.accept()?;
        }
        self.life_mut().phase = Phase::Event;
        self.begin_event();
        Ok(())
    }

    /// `fmi2NewDiscreteStates`, `fmi3UpdateDiscreteStates`: carries out everything that is due at
    /// the present time in one call, and returns the changes.
    ///
    /// # Errors
    /// If a value that was set is not possible; nothing has changed then.
    fn handle_events(&mut self, log: &mut dyn Log) -> Result<Handled, Self::Problem> {
        self.carry_out(log)
    }

    /// `fmi3EnterStepMode`, `fmi3EnterContinuousTimeMode`: the motion continues.
    ///
    /// # Errors
    /// As [`Hybrid::go_on`].
    fn leave_event(&mut self, log: &mut dyn Log) -> Result<(), Self::Problem> {
        self.go_on(Some(log))?;
        self.life_mut().go_on();
        Ok(())
    }

    /// `fmi3DoStep`: a step from the present time towards `point + size`, with the event handling
    /// agreed with the host ([`EventHandling`]). The step begins at the component's time; `point`
    /// may differ from it by rounding ([`Life::check_step`](crate::Life::check_step)).
    /// # Errors
    /// If the step was not carried out; the component is then unchanged.
    #[inline]
    fn step_as_agreed(
        &mut self,
        point: f64,
        size: f64,
        log: &mut dyn Log,
    ) -> Result<StepOutcome, Self::Problem> {
        let at_event = AtEvent::of(self.life().handling, self.ends_at_events());
        steps::whole_step(self, (point, size), at_event, log)
    }

    /// `fmi2DoStep`: a step as [`step_as_agreed`](Self::step_as_agreed), but for a host without
    /// event mode that accepts steps that end early. After such a step the phase is
    /// [`Phase::StoppedEarly`], and the next step may begin there.
    ///
    /// # Errors
    /// As [`step_as_agreed`](Self::step_as_agreed).
    #[inline]
    fn step_without_event_mode(
        &mut self,
        point: f64,
        size: f64,
        log: &mut dyn Log,
    ) -> Result<StepOutcome, Self::Problem> {
        let handling = EventHandling { event_mode: false, early_return: true };
        let at_event = AtEvent::of(handling, self.ends_at_events());
        let outcome = steps::whole_step(self, (point, size), at_event, log)?;
        if outcome.early {
            self.life_mut().phase = Phase::StoppedEarly;
        }
        Ok(outcome)
    }

    /// `fmi2EnterContinuousTimeMode`: the host's solver continues from here.
    ///
    /// # Errors
    /// As [`Hybrid::go_on`].
    fn enter_continuous(&mut self) -> Result<(), Self::Problem> {
        self.go_on(None)?;
        self.life_mut().phase = Phase::Continuous;
        Ok(())
    }

    /// `fmi2CompletedIntegratorStep`, `fmi3CompletedIntegratorStep`: whether the host must enter
    /// Event Mode.
    ///
    /// # Errors
    /// As [`Hybrid::accept`].
    fn complete_integrator_step(&mut self) -> Result<bool, Self::Problem> {
        self.accept()
    }

    /// `fmi2SetTime`, `fmi3SetTime`: at an event only the present time is accepted; some hosts set
    /// it there.
    ///
    /// # Errors
    /// If the time is not possible.
    fn set_time(&mut self, time: f64) -> Result<(), Self::Problem> {
        let refuse = |allowed| Err(Problem::value("time", time, allowed).into());
        if !time.is_finite() {
            return refuse("a finite number");
        }
        if self.life().phase == Phase::Event && time != self.time() {
            return refuse("the present time in Event Mode");
        }
        self.put_time(time)
    }
}

impl<H: Hybrid> Component for H {}
