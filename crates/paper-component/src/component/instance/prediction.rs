//! The prediction of the next event.

use super::{Engine, Instance, Interface, Outcome, SolutionMode};
use crate::component::closed_form::ClosedForm;
use crate::component::values::Prediction;
use fmi_doors::Model as _;
use vibro_impact::model::Model;
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{Event, Simulator};

/// Length of the predicted interval, in drive periods. Motions near the two-impact orbit have four
/// impacts in it.
const PERIODS: f64 = 2.0;
/// Largest length of the predicted interval, in units of the system's fastest time constant. It
/// applies if the drive is very slow or does not move, and bounds the cost of the search.
const TIME_CONSTANTS: f64 = 1e4;

impl Instance {
    /// The next event with the inputs and parameters set now.
    pub fn prediction(&mut self) -> Prediction {
        self.refresh_prediction();
        self.prediction.unwrap_or_default()
    }

    /// Brings the prediction up to date.
    pub(super) fn refresh_prediction(&mut self) {
        if self.prediction.is_none() {
            self.prediction = Some(self.predict());
        }
    }

    /// The next impact, rest or release with the inputs and parameters set now. There is no
    /// prediction in Model Exchange, where the host's solver computes the motion, or if the future
    /// motion cannot be computed.
    fn predict(&self) -> Prediction {
        let now = self.time();
        let horizon = now + span(&self.settings.parameters);
        match self.next_event(horizon) {
            Ok(Some(time)) if time <= horizon => Prediction { time: time.max(now), known: true },
            _ => Prediction { time: horizon, known: false },
        }
    }

    fn next_event(&self, horizon: f64) -> Outcome<Option<f64>> {
        if self.life.interface == Interface::ModelExchange {
            return Ok(None);
        }
        match &self.engine {
            Engine::Simulation(simulator) if self.changes().any() => {
                let mut ahead = (**simulator).clone();
                self.changes().put(&mut ahead)?;
                time_of_next(&ahead, horizon)
            }
            Engine::Simulation(simulator) => time_of_next(simulator, horizon),
            Engine::Closed(form) => time_of_impact((**form).clone(), &self.settings.parameters),
            Engine::None if self.settings.mode == SolutionMode::EventDriven => {
                time_of_next(&self.initial_simulator(&self.settings)?.0, horizon)
            }
            Engine::None => {
                let form = ClosedForm::new(self.settings.mode, &self.settings.parameters, self.time())?;
                Ok(Some(form.next_impact()))
            }
            Engine::Continuous(_) => Ok(None),
        }
    }
}

fn time_of_next(simulator: &Simulator, horizon: f64) -> Outcome<Option<f64>> {
    Ok(simulator.next_event(horizon)?.map(|event| match event {
        Event::Impact { time, .. } | Event::Rest { time, .. } | Event::Release { time, .. } => time,
    }))
}

fn time_of_impact(mut form: ClosedForm, parameters: &Parameters) -> Outcome<Option<f64>> {
    form.set_parameters(parameters)?;
    Ok(Some(form.next_impact()))
}

/// Length of the predicted interval, s: a finite number > 0.
fn span(parameters: &Parameters) -> f64 {
    let fastest = Model::new(parameters).map_or(1.0, |model| model.rate);
    // A frequency of -0 counts as 0.
    (PERIODS * parameters.period().abs()).min(TIME_CONSTANTS / fastest)
}
