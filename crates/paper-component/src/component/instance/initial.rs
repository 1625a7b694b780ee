//! The start of an instance.

use super::access::NO_LOADS;
use super::{ComponentProblem, Engine, Instance, Interface, Outcome};
use crate::component::closed_form::ClosedForm;
use crate::component::continuous::Continuous;
use crate::component::settings::{Settings, SolutionMode};
use crate::component::structure::input_of;
use crate::component::values::OutputValues;
use crate::component::variables::Edition;
use vibro_impact::simulator::{Simulator, State};

impl Instance {
    /// The motion at the start, with objections to a steady state that is used for it.
    ///
    /// # Errors
    /// If start values, parameters or mode are not possible.
    pub(super) fn initial_engine(&self) -> Outcome<(Engine, Option<String>)> {
        let settings = &self.settings;
        if settings.mode == SolutionMode::EventDriven {
            let (simulator, objections) = self.initial_simulator(settings)?;
            let engine = match self.life.interface {
                Interface::CoSimulation => Engine::Simulation(Box::new(simulator)),
                Interface::ModelExchange => {
                    Engine::Continuous(Box::new(Continuous::start(&simulator, forces(settings))?))
                }
            };
            return Ok((engine, objections));
        }
        if self.life.interface == Interface::ModelExchange {
            const ALLOWED: &str =
                "1 (EventDriven) in Model Exchange: a closed form has no derivatives to integrate";
            // In later descriptions the refusal is an error of the call, not of a value.
            return Err(match self.edition {
                Edition::Every => ComponentProblem::value("mode", f64::from(settings.mode.number()), ALLOWED),
                _ => fmi_doors::Problem::Sequence { what: format!("mode must be {ALLOWED}").into() }.into(),
            });
        }
        let form = self.initial_form(settings)?;
        let objections = form.solution().objections();
        Ok((Engine::Closed(Box::new(form)), objections))
    }

    /// Values of the outputs at the start.
    pub(super) fn initial_values(&self, settings: &Settings) -> Outcome<OutputValues> {
        match settings.mode {
            SolutionMode::EventDriven => Ok(OutputValues::of(&self.initial_simulator(settings)?.0)),
            _ => Ok(self.initial_form(settings)?.values()),
        }
    }

    /// A simulator at the start, with the loads that act there.
    pub(super) fn initial_simulator(&self, settings: &Settings) -> Outcome<(Simulator, Option<String>)> {
        let (start, objections) = self.initial_state(settings)?;
        let mut simulator = Simulator::new(&settings.parameters, &start, self.life.start_time())?;
        simulator.set_loads(&settings.loads)?;
        Ok((simulator, objections))
    }

    /// The start values, or the exact orbit at the drive's initial phase.
    fn initial_state(&self, settings: &Settings) -> Outcome<(State, Option<String>)> {
        if !settings.start_on_orbit {
            return Ok((settings.start, None));
        }
        let form = ClosedForm::new(SolutionMode::ExactOrbit, &settings.parameters, self.life.start_time())?;
        Ok((form.values().state(), form.solution().objections()))
    }

    pub(super) fn initial_form(&self, settings: &Settings) -> Outcome<ClosedForm> {
        for (body, load) in settings.loads.derivatives.iter().enumerate() {
            if let Some(&value) = load.iter().find(|value| **value != 0.0) {
                let name = input_of(body).map_or("a load", |input| input.name);
                return Err(ComponentProblem::value(name, value, NO_LOADS));
            }
        }
        ClosedForm::new(settings.mode, &settings.parameters, self.life.start_time())
    }
}

/// Present loads.
pub(super) fn forces(settings: &Settings) -> [f64; 3] {
    settings.loads.derivatives.map(|load| load[0])
}
