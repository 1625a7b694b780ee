//! Integration by a host's own solver: time and continuous states.

use super::events::Present;
use super::initial::forces;
use super::{Engine, Instance, Interface, Outcome, Problem};
use crate::component::continuous::Continuous;
use crate::component::structure::{DERIVATIVES, EVENT_INDICATORS, STATES};
use fmi_doors::Model as _;
use vibro_impact::model::Model;
use vibro_impact::simulator;

impl Instance {
    /// The continuous states.
    ///
    /// # Errors
    /// In initialization when the start is not possible.
    pub fn continuous_states(&self) -> Outcome<[f64; 6]> {
        self.with_continuous(STATES, |continuous| {
            let simulator::State { x, v } = continuous.state();
            [x[0], x[1], x[2], v[0], v[1], v[2]]
        })
    }

    /// Their time derivatives.
    ///
    /// # Errors
    /// In initialization when the start is not possible; [`Problem::Overflow`].
    pub fn state_derivatives(&self) -> Outcome<[f64; 6]> {
        self.with_continuous(DERIVATIVES, Continuous::derivatives)
    }

    /// Distances to both stops in flight, pressing acceleration in rest: an event is where one
    /// becomes negative.
    ///
    /// # Errors
    /// In initialization when the start is not possible; [`Problem::Overflow`].
    pub fn event_indicators(&self) -> Outcome<[f64; EVENT_INDICATORS]> {
        self.with_continuous(["an event indicator"; EVENT_INDICATORS], Continuous::indicators)
    }

    /// Nominal values of the continuous states, by the parameters as they are set: the gap, and the
    /// gap times the drive's frequency. Each is positive and finite.
    pub fn nominals(&self) -> [f64; 6] {
        let parameters = &self.settings.parameters;
        let positive = |value: f64| value.clamp(f64::MIN_POSITIVE, f64::MAX);
        let length = positive(parameters.stop_gap);
        let frequency = parameters.drive_frequency.abs();
        // A drive that stands still leaves the system's own rates.
        let own = || Model::new(parameters).map_or(1.0, |model| model.rate);
        let speed = positive(length * if frequency > 0.0 { frequency } else { own() });
        [length, length, length, speed, speed, speed]
    }

    /// Whether the nominal values differ from those at the last event, which are from now on the
    /// present ones. Of interest to a host's solver alone.
    pub(super) fn nominals_changed(&mut self) -> bool {
        if self.life.interface != Interface::ModelExchange {
            return false;
        }
        let now = self.nominals();
        let before = self.nominals_told.replace(now);
        before.is_some_and(|before| before != now)
    }

    pub(super) fn continuous_mut(&mut self) -> Outcome<&mut Continuous> {
        match &mut self.engine {
            Engine::Continuous(continuous) => Ok(continuous),
            _ => Err(Problem::sequence("the instance is not initialized")),
        }
    }

    /// Evaluates numbers of the model; in initialization at the start. None of them is ever not
    /// finite.
    fn with_continuous<const N: usize>(
        &self,
        names: [&'static str; N],
        evaluate: impl FnOnce(&Continuous) -> [f64; N],
    ) -> Outcome<[f64; N]> {
        let values = match self.present()? {
            Present::Continuous(continuous) => evaluate(&continuous),
            _ => {
                let (simulator, _) = self.initial_simulator(&self.settings)?;
                evaluate(&Continuous::start(&simulator, forces(&self.settings))?)
            }
        };
        match values.iter().position(|value| !value.is_finite()) {
            None => Ok(values),
            Some(i) => Err(Problem::Overflow { name: names[i], value: values[i], time: self.time() }),
        }
    }
}
