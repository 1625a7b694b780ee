//! Checks whether a variable may be set now, and the time derivatives of outputs.

use super::events::Present;
use super::{ComponentProblem, Engine, Instance, Interface, Outcome, Phase};
use crate::component::jets::{Jet, MotionJet, jets};
use crate::component::settings::Settings;
use crate::component::values::OutputValues;
use crate::component::variables::{Access, Bases, Causality, Numbering, Set, Variable, WRITERS, Writer};

/// Valid loads while a closed form is played.
pub(super) const NO_LOADS: &str = "0 in a closed-form mode";

#[cold]
pub(super) fn no_such(numbering: Numbering, reference: u32, bases: Bases) -> ComponentProblem {
    let found = match numbering.variable(reference) {
        Some(variable) => format!("{} is {}", variable.name, variable.base().name()),
        None => {
            let (first, last) = numbering.range();
            format!("expected a value reference of the model description, from {first} to {last}")
        }
    };
    fmi_doors::Problem::Reference { reference, wanted: bases.name, found }.into()
}

impl Instance {
    /// The variable with a value reference.
    ///
    /// # Errors
    /// [`Reference`](fmi_doors::Problem::Reference) if no variable has the reference.
    pub(super) fn variable_of(&self, reference: u32) -> Outcome<&'static Variable> {
        self.look_up(reference, Bases::ANY)
    }

    /// The variable with a value reference; it must have one of the types.
    #[inline]
    pub(super) fn look_up(&self, reference: u32, bases: Bases) -> Outcome<&'static Variable> {
        match self.numbering.variable(reference) {
            Some(variable) if bases.contains(variable.base()) => Ok(variable),
            _ => Err(no_such(self.numbering, reference, bases)),
        }
    }

    /// Full check of one value to be set.
    #[cold]
    pub(super) fn check_set(&self, reference: u32, bases: Bases, value: f64) -> Outcome {
        let variable = self.look_up(reference, bases)?;
        self.check_settable(&WRITERS[self.numbering.place(reference)], variable)?;
        if !variable.accepts(value) {
            return Err(ComponentProblem::value(variable.name, value, variable.allowed()));
        }
        self.check_load(variable, value)
    }

    /// A closed form is a motion without loads.
    pub(super) fn check_load(&self, variable: &Variable, value: f64) -> Outcome {
        if variable.causality == Causality::Input && value != 0.0 && matches!(self.engine, Engine::Closed(_))
        {
            return Err(ComponentProblem::value(variable.name, value, NO_LOADS));
        }
        Ok(())
    }

    #[inline]
    pub(super) fn assign(&mut self, variable: &Writer, value: f64) {
        let set = match (&mut self.engine, variable.set) {
            (Engine::Continuous(continuous), Set::Start(set)) => {
                // One continuous state of a solver, set individually.
                let mut settings = Settings { start: continuous.state(), ..self.settings };
                set(&mut settings, value);
                continuous.set_state(settings.start);
                return;
            }
            (_, Set::Setting(set) | Set::Start(set)) => set,
            (_, Set::Never) => return,
        };
        let settings = &mut self.settings;
        if variable.input {
            let slopes = (self.slopes_set != [false; 3]).then_some(settings.loads.derivatives);
            set(settings, value);
            // Derivatives set for this communication point apply in any order of the calls.
            if let Some(slopes) = slopes {
                for body in (0..3).filter(|body| self.slopes_set[*body]) {
                    settings.loads.derivatives[body][1..].copy_from_slice(&slopes[body][1..]);
                }
            }
            self.loads_set = true;
        } else {
            set(settings, value);
            self.given |= variable.given;
            self.parameters_set = true;
            self.derived_stale = true;
        }
        self.prediction = None;
        if matches!(self.engine, Engine::None) || self.life.phase == Phase::Event {
            self.invalidate();
        }
    }

    /// The bit of the present phase in [`Writer`].
    pub(super) fn when(&self) -> u8 {
        match self.life.phase {
            Phase::Instantiated | Phase::Initialization => Writer::INITIAL,
            Phase::Continuous => Writer::CONTINUOUS,
            Phase::Event
                if self.life.interface == Interface::ModelExchange && self.life.handling.event_mode =>
            {
                Writer::EVENT | Writer::UNCHANGED_STATES
            }
            _ => Writer::EVENT,
        }
    }

    fn check_settable(&self, writer: &Writer, variable: &Variable) -> Outcome {
        let when = self.when();
        if writer.settable(when) {
            return Ok(());
        }
        let allowed = match when {
            Writer::INITIAL => "parameters, start values and inputs",
            Writer::CONTINUOUS => "inputs and continuous states",
            _ => "inputs and tunable parameters",
        };
        let (name, phase) = (variable.name.into(), words(self.life.phase));
        Err(fmi_doors::Problem::NotSettable { name, phase, allowed }.into())
    }

    /// Jets (truncated Taylor series in time) of the quantities that outputs read.
    pub(super) fn jets(&self) -> Outcome<OutputValues<Jet>> {
        let (motion, parameters, loads, theta, values) = match self.present()? {
            Present::Simulation(s) => {
                let loads = s.loads().derivatives;
                (s.derivatives(), *s.parameters(), loads, s.drive_phase(), OutputValues::of(&s))
            }
            Present::Closed(form) => {
                (form.derivatives(), *form.parameters(), [[0.0; 4]; 3], form.theta(), form.values())
            }
            Present::None | Present::Continuous(_) => {
                return Err(ComponentProblem::sequence("the instance is not initialized"));
            }
        };
        Ok(jets(&MotionJet {
            values: &values,
            motion: &motion,
            parameters: &parameters,
            loads: &loads,
            theta,
        }))
    }
}

/// Description of a phase; a step ends early only at an impact.
fn words(phase: Phase) -> &'static str {
    match phase {
        Phase::StoppedEarly => "at the impact at which the step ended",
        phase => phase.words(),
    }
}

/// The reading of the time derivatives of a variable.
pub(super) fn jet_of(variable: &Variable) -> Outcome<fn(&OutputValues<Jet>) -> Jet> {
    let reading = match variable.access {
        Access::Output(reading) | Access::Start { now: reading, .. }
            if variable.causality == Causality::Output =>
        {
            reading.jet
        }
        _ => None,
    };
    reading.ok_or(ComponentProblem::NoDerivative {
        name: variable.name,
        allowed: "derivatives of continuous outputs",
    })
}

pub(super) fn check_order(variable: &Variable, order: i32, highest: i32, allowed: &'static str) -> Outcome {
    if (1..=highest).contains(&order) {
        return Ok(());
    }
    let what = format!("order of a derivative of {}", variable.name);
    Err(fmi_doors::Problem::value(what, f64::from(order), allowed).into())
}
