//! What an instance starts from (FMI 2.0, 2.1.6).

use super::values::NO_LOADS;
use super::{Engine, Instance, Outcome};
use crate::fmi2::closed_form::ClosedForm;
use crate::fmi2::continuous::Continuous;
use crate::fmi2::problem::Problem;
use crate::fmi2::settings::{Mode, Motion, Settings};
use crate::fmi2::states::Interface;
use vibro_impact::simulator::{Simulator, State};

impl Instance {
    /// Start time.
    pub(super) fn start_time(&self) -> f64 {
        self.experiment.unwrap_or_default().start
    }

    /// What will move, with what speaks against a steady state that is played or started on.
    ///
    /// # Errors
    /// When start values, parameters or mode are not possible.
    pub(super) fn initial_engine(&self) -> Outcome<(Engine, Option<String>)> {
        let settings = &self.settings;
        if settings.mode == Mode::EventDriven {
            let (simulator, objections) = self.initial_simulator(settings)?;
            let engine = match self.interface {
                Interface::CoSimulation => Engine::Simulation(Box::new(simulator)),
                Interface::ModelExchange => {
                    Engine::Continuous(Box::new(Continuous::start(&simulator, forces(settings))?))
                }
            };
            return Ok((engine, objections));
        }
        if self.interface == Interface::ModelExchange {
            return Err(Problem::Value {
                name: "mode",
                value: f64::from(settings.mode.number()),
                allowed: "1 (EventDriven) in Model Exchange: a closed form has no derivatives to integrate",
            });
        }
        let form = self.initial_form(settings)?;
        let objections = form.solution().objections();
        Ok((Engine::Closed(Box::new(form)), objections))
    }

    /// The motion at the start.
    pub(super) fn initial_motion(&self, settings: &Settings) -> Outcome<Motion> {
        match settings.mode {
            Mode::EventDriven => Ok(Motion::of(&self.initial_simulator(settings)?.0)),
            _ => Ok(self.initial_form(settings)?.motion()),
        }
    }

    /// A simulator at the start, with the loads that act there.
    pub(super) fn initial_simulator(&self, settings: &Settings) -> Outcome<(Simulator, Option<String>)> {
        let (start, objections) = self.initial_state(settings)?;
        let mut simulator = Simulator::new(&settings.parameters, &start, self.start_time())?;
        simulator.set_loads(&settings.loads)?;
        Ok((simulator, objections))
    }

    /// The start values, or the exact orbit at the drive's initial phase.
    fn initial_state(&self, settings: &Settings) -> Outcome<(State, Option<String>)> {
        if !settings.start_on_orbit {
            return Ok((settings.start, None));
        }
        let form = ClosedForm::new(Mode::ExactOrbit, &settings.parameters, self.start_time())?;
        Ok((form.motion().state, form.solution().objections()))
    }

    fn initial_form(&self, settings: &Settings) -> Outcome<ClosedForm> {
        const NAMES: [&str; 3] = ["box.f", "block.f", "secondary.f"];
        for (name, load) in NAMES.into_iter().zip(&settings.loads.derivatives) {
            if let Some(&value) = load.iter().find(|value| **value != 0.0) {
                return Err(Problem::Value { name, value, allowed: NO_LOADS });
            }
        }
        ClosedForm::new(settings.mode, &settings.parameters, self.start_time())
    }
}

/// The loads now.
pub(super) fn forces(settings: &Settings) -> [f64; 3] {
    settings.loads.derivatives.map(|load| load[0])
}
