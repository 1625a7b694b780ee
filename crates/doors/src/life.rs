//! Interface type, lifecycle phase and event handling of a component.

use crate::problem::Problem;
use serde::{Deserialize, Serialize};

/// Use of a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Interface {
    /// The host provides the solver.
    ModelExchange,
    /// The component steps itself.
    CoSimulation,
}

impl Interface {
    /// Name for messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::ModelExchange => "Model Exchange",
            Self::CoSimulation => "Co-Simulation",
        }
    }
}

/// Lifecycle phase of a component, independent of the FMI version.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    /// Just created or reset.
    Instantiated,
    /// The start values are set and read.
    Initialization,
    /// At an event, between two pieces of a motion.
    Event,
    /// A host's solver integrates.
    Continuous,
    /// At a communication point.
    Step,
    /// At the event at which a step ended early. The next step may begin here, or the host may
    /// restore a state saved earlier.
    StoppedEarly,
    /// The simulation is over; outputs can still be read.
    Terminated,
    /// A panic has left the component in an unknown state.
    Broken,
}

impl Phase {
    /// Whether a motion exists in this phase; `None` if the phase alone does not decide.
    pub fn has_motion(self) -> Option<bool> {
        match self {
            Self::Instantiated | Self::Initialization => Some(false),
            Self::Event | Self::Continuous | Self::Step | Self::StoppedEarly => Some(true),
            Self::Terminated | Self::Broken => None,
        }
    }

    /// Description for messages.
    pub fn words(self) -> &'static str {
        match self {
            Self::Instantiated => "before initialization",
            Self::Initialization => "in initialization",
            Self::Event => "at an event",
            Self::Continuous => "between events",
            Self::Step => "at a communication point",
            Self::StoppedEarly => "where the step ended early",
            Self::Terminated => "after the end",
            Self::Broken => "after an internal error",
        }
    }
}

/// Start time and, if known, stop time of a simulation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Experiment {
    /// Start, s.
    pub start: f64,
    /// Stop, s, if known.
    pub stop: Option<f64>,
}

impl Experiment {
    /// Checks the host's arguments and makes an experiment.
    ///
    /// # Errors
    /// [`Problem::Value`] if a number is not finite, the tolerance is negative, or the stop is
    /// before the start.
    pub fn new(tolerance: Option<f64>, start: f64, stop: Option<f64>) -> Result<Self, Problem> {
        match tolerance {
            Some(value) if !(value.is_finite() && value >= 0.0) => {
                return Err(Problem::value("tolerance", value, "a finite number >= 0"));
            }
            _ => {}
        }
        if !start.is_finite() {
            return Err(Problem::value("startTime", start, "a finite number"));
        }
        match stop {
            Some(value) if !(value.is_finite() && value >= start) => {
                return Err(Problem::value("stopTime", value, "a finite number not before startTime"));
            }
            _ => {}
        }
        Ok(Self { start, stop })
    }
}

/// Event handling by a host, agreed when the component is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct EventHandling {
    /// The host handles events itself. Values that change at events only are updated when the host
    /// handles the event.
    pub event_mode: bool,
    /// The host accepts steps that end early.
    pub early_return: bool,
}

/// Largest difference between a master's time and the component's time, relative to max(1, |t|).
/// Masters sum step sizes and drift by about 1e-14 per step, which stays below this tolerance for
/// 1e5 steps. A larger difference is an error.
pub const TIME_TOLERANCE: f64 = 1e-9;

/// Lifecycle data that every component keeps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Life {
    /// Use of the component.
    pub interface: Interface,
    /// Event handling by its host.
    pub handling: EventHandling,
    /// Present phase.
    pub phase: Phase,
    /// Start and stop time, once they are given.
    pub experiment: Option<Experiment>,
}

impl Life {
    /// Lifecycle data of a new component.
    pub fn new(interface: Interface, handling: EventHandling) -> Self {
        Self { interface, handling, phase: Phase::Instantiated, experiment: None }
    }

    /// Start time, s; 0 if none was given.
    pub fn start_time(&self) -> f64 {
        self.experiment.unwrap_or_default().start
    }

    /// Enters the phase at the beginning of a motion: an event if the host handles events,
    /// otherwise a communication point.
    pub fn begin(&mut self) {
        let event = self.interface == Interface::ModelExchange || self.handling.event_mode;
        self.phase = if event { Phase::Event } else { Phase::Step };
    }

    /// Enters the phase of the motion after an event.
    pub fn go_on(&mut self) {
        self.phase = match self.interface {
            Interface::CoSimulation => Phase::Step,
            Interface::ModelExchange => Phase::Continuous,
        };
    }

    /// Takes over phase and experiment of a saved state. In Co-Simulation without event mode, a
    /// state that was saved at an event becomes a state at a communication point.
    ///
    /// # Errors
    /// [`Problem::SavedState`] if the state is of the other interface type, or of a phase without
    /// saved states, as in damaged bytes. Then nothing has changed.
    pub fn take_over(&mut self, saved: &Self) -> Result<(), Problem> {
        if saved.interface != self.interface {
            let (its, own) = (saved.interface.name(), self.interface.name());
            let what = format!("it is of {its}, this instance is of {own}").into();
            return Err(Problem::SavedState { what });
        }
        let foreign: &[Phase] = match self.interface {
            Interface::CoSimulation => &[Phase::Continuous],
            Interface::ModelExchange => &[Phase::Step, Phase::StoppedEarly],
        };
        if foreign.contains(&saved.phase) || saved.phase == Phase::Broken {
            return Err(Problem::SavedState { what: "nothing is saved in its phase".into() });
        }
        (self.phase, self.experiment) = (saved.phase, saved.experiment);
        let stepping = self.interface == Interface::CoSimulation && !self.handling.event_mode;
        if stepping && self.phase == Phase::Event {
            self.phase = Phase::Step;
        }
        Ok(())
    }

    /// Refuses a step that does not begin at `own`, the component's time, up to rounding; a step
    /// whose length is not positive; and a step past the stop time.
    ///
    /// # Errors
    /// [`Problem::Value`], [`Problem::Time`], [`Problem::StopTime`].
    #[inline]
    pub fn check_step(&self, point: f64, size: f64, own: f64) -> Result<(), Problem> {
        if !point.is_finite() {
            return Err(Problem::value("currentCommunicationPoint", point, "a finite number"));
        }
        if !(size > 0.0 && size.is_finite()) {
            return Err(Problem::value("communicationStepSize", size, "a finite number > 0"));
        }
        if (point - own).abs() > TIME_TOLERANCE * point.abs().max(1.0) {
            return Err(Problem::Time { given: point, own });
        }
        let end = point + size;
        match self.experiment.and_then(|experiment| experiment.stop) {
            Some(stop) if end > stop + TIME_TOLERANCE * stop.abs().max(1.0) => {
                Err(Problem::StopTime { end, stop })
            }
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_that_cannot_be_made_are_refused_by_name() {
        let mut life = Life::new(Interface::CoSimulation, EventHandling::default());
        life.experiment = Some(Experiment::new(None, 0.0, Some(2.0)).unwrap());
        for (point, size, text) in [
            (f64::NAN, 1.0, "currentCommunicationPoint = NaN: expected a finite number"),
            (1.0, 0.0, "communicationStepSize = 0: expected a finite number > 0"),
            (1.1, 0.5, "currentCommunicationPoint = 1.1 s, but the instance is at t = 1 s"),
            (1.0, 1.5, "step to t = 2.5 s: must end by the stop time 2 s"),
        ] {
            let problem = life.check_step(point, size, 1.0).unwrap_err().to_string();
            assert!(problem.starts_with(text), "{problem}");
        }
        assert_eq!(life.check_step(1.0 + 1e-10, 1.0, 1.0), Ok(()));
        assert_eq!(life.check_step(1.0, 1.0 + 1e-12, 1.0), Ok(()));
    }

    /// Damaged bytes may contain any phase. A phase that the interface type does not have would
    /// leave an instance that allows no call.
    #[test]
    fn saved_states_of_phases_that_there_are_not_are_refused() {
        for (interface, phases) in [
            (Interface::ModelExchange, &[Phase::Step, Phase::StoppedEarly, Phase::Broken][..]),
            (Interface::CoSimulation, &[Phase::Continuous, Phase::Broken]),
        ] {
            let fresh = Life::new(interface, EventHandling::default());
            for &phase in phases {
                let mut life = fresh;
                let problem = life.take_over(&Life { phase, ..fresh }).unwrap_err().to_string();
                assert_eq!(problem, "saved state refused: nothing is saved in its phase");
                assert_eq!(life, fresh);
            }
        }
    }

    #[test]
    fn experiments_that_cannot_be_are_refused_by_name() {
        for (tolerance, start, stop, text) in [
            (Some(-1.0), 0.0, None, "tolerance = -1"),
            (Some(f64::NAN), 0.0, None, "tolerance = NaN"),
            (None, 0.0, Some(f64::NAN), "stopTime = NaN"),
            (None, f64::INFINITY, None, "startTime = inf"),
            (None, 1.0, Some(0.5), "stopTime = 0.5: expected a finite number not before startTime"),
        ] {
            let problem = Experiment::new(tolerance, start, stop).unwrap_err().to_string();
            assert!(problem.starts_with(text), "{problem}");
        }
    }
}
