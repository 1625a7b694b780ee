//! Integration by a host's own solver: time and continuous states.

use super::events::Present;
use super::initial::forces;
use super::{Engine, Instance, Outcome, Phase, Problem};
use crate::component::continuous::{Continuous, check_states};
use crate::component::structure::EVENT_INDICATORS;
use vibro_impact::simulator;

impl Instance {
    /// The host's solver goes on from here.
    pub fn enter_continuous(&mut self) {
        self.phase = Phase::Continuous;
    }

    /// Accepts a step of the host's solver: the energy accounts are carried on. Returns whether the host has passed over an
    /// event.
    ///
    /// # Errors
    /// [`Problem::Sequence`] before initialization.
    pub fn complete_integrator_step(&mut self) -> Outcome<bool> {
        let continuous = self.continuous_mut()?;
        continuous.accept();
        let missed = continuous.missed_event();
        self.invalidate();
        Ok(missed)
    }

    /// Sets the time; at an event only to the present time, as some hosts do.
    ///
    /// # Errors
    /// [`Problem::Value`] for a time that is not finite, or at an event another than the present; one too large to resolve.
    pub fn set_time(&mut self, time: f64) -> Outcome {
        let refuse = |allowed| Err(Problem::Value { name: "time", value: time, allowed });
        if !time.is_finite() {
            return refuse("a finite number");
        }
        if self.phase == Phase::Event && time != self.continuous_mut()?.time() {
            return refuse("the present time in Event Mode");
        }
        self.continuous_mut()?.set_time(time)?;
        self.invalidate();
        Ok(())
    }

    /// Sets the continuous states, in the order of [`STATES`](crate::component::structure::STATES).
    ///
    /// # Errors
    /// [`Problem::Value`] for one that is not finite; nothing has changed then.
    pub fn set_continuous_states(&mut self, states: &[f64; 6]) -> Outcome {
        let state = check_states(states)?;
        self.continuous_mut()?.set_state(state);
        self.invalidate();
        Ok(())
    }

    /// The continuous states.
    ///
    /// # Errors
    /// In initialization when the start is not possible.
    pub fn continuous_states(&self) -> Outcome<[f64; 6]> {
        self.with_continuous(|continuous| {
            let simulator::State { x, v } = continuous.state();
            [x[0], x[1], x[2], v[0], v[1], v[2]]
        })
    }

    /// Their time derivatives.
    ///
    /// # Errors
    /// In initialization when the start is not possible.
    pub fn state_derivatives(&self) -> Outcome<[f64; 6]> {
        self.with_continuous(Continuous::derivatives)
    }

    /// Distances to both stops in flight, pressing acceleration in rest: an event is where one becomes negative.
    ///
    /// # Errors
    /// In initialization when the start is not possible.
    pub fn event_indicators(&self) -> Outcome<[f64; EVENT_INDICATORS]> {
        self.with_continuous(Continuous::indicators)
    }

    /// Nominal values of the continuous states, all 1, as `rows::state` declares them.
    pub fn nominals(&self) -> [f64; 6] {
        [1.0; 6]
    }

    fn continuous_mut(&mut self) -> Outcome<&mut Continuous> {
        match &mut self.engine {
            Engine::Continuous(continuous) => Ok(continuous),
            _ => Err(Problem::Sequence { what: "the instance is not initialized" }),
        }
    }

    /// Evaluates the model; in initialization at the start.
    fn with_continuous<T>(&self, evaluate: impl FnOnce(&Continuous) -> T) -> Outcome<T> {
        match self.present()? {
            Present::Continuous(continuous) => Ok(evaluate(&continuous)),
            _ => {
                let (simulator, _) = self.initial_simulator(&self.settings)?;
                Ok(evaluate(&Continuous::start(&simulator, forces(&self.settings))?))
            }
        }
    }
}
