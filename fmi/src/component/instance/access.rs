//! Getting and setting values, and the time derivatives of inputs and outputs.

use super::events::Present;
use super::{Engine, Instance, Interface, Outcome, Phase, Problem};
use crate::component::jets::{Course, Jet, jets};
use crate::component::settings::Settings;
use crate::component::values::OutputValues;
use crate::component::variables::{
    Access, Bases, Causality, Get, Numbering, READERS, Reader, Set, Variable, WRITERS, Writer,
};

/// What loads may be while a closed form is played.
pub(super) const NO_LOADS: &str = "0 in a closed-form mode";
/// Highest order of input derivatives.
const INPUT_ORDER: i32 = 3;
/// Highest order of output derivatives: the displacements' fifth is known, so accelerations have
/// three.
const OUTPUT_ORDER: i32 = 3;

#[cold]
fn no_such(numbering: Numbering, reference: u32, bases: Bases) -> Problem {
    let found = match numbering.variable(reference) {
        Some(variable) => format!("{} is {}", variable.name, variable.base().name()),
        None => {
            let (first, last) = numbering.range();
            format!("allowed are those of the model description, from {first} to {last}")
        }
    };
    fmi_doors::Problem::Reference { reference, wanted: bases.name, found }.into()
}

impl Instance {
    /// The variable of that reference, which must have one of the types.
    #[inline]
    pub(super) fn look_up(&self, reference: u32, bases: Bases) -> Outcome<&'static Variable> {
        match self.numbering.variable(reference) {
            Some(variable) if bases.contains(variable.base()) => Ok(variable),
            _ => Err(no_such(self.numbering, reference, bases)),
        }
    }

    /// The variable of that reference.
    ///
    /// # Errors
    /// [`Reference`](fmi_doors::Problem::Reference) when there is none.
    pub fn variable(&self, reference: u32) -> Outcome<&'static Variable> {
        self.look_up(reference, Bases::ANY)
    }

    /// Hands value `i` to `write`: those of the variables in their order, of an array in row-major
    /// order.
    ///
    /// # Errors
    /// Before anything is written: a reference that is not of these types, or, in initialization, a
    /// start that is not possible.
    #[inline]
    pub fn get(&mut self, bases: Bases, references: &[u32], mut write: impl FnMut(usize, f64)) -> Outcome {
        let numbering = self.numbering;
        let initialized = !matches!(self.engine, Engine::None);
        let mut needs = 0;
        for &reference in references {
            match READERS.get(numbering.place(reference)) {
                Some(reader) if bases.contains(reader.base) => needs |= reader.needs,
                _ => return Err(no_such(numbering, reference, bases)),
            }
        }
        let moves = needs & Reader::MOTION != 0 || initialized && needs & Reader::START != 0;
        if moves && self.values_stale {
            self.refresh_values()?;
        }
        if needs & Reader::DERIVED != 0 && self.derived_stale {
            self.refresh_derived();
        }
        if needs & Reader::PREDICTION != 0 {
            self.refresh_prediction();
        }
        if needs & Reader::STEP != 0 {
            self.refresh_step_matrices();
        }
        let mut i = 0;
        for &reference in references {
            let value = match READERS[numbering.place(reference)].get {
                Get::Output(get) => get(&self.values),
                Get::Start(_, now) if initialized => now(&self.values),
                Get::Setting(get) | Get::Start(get, _) => get(&self.settings),
                Get::Derived(get) => get(&self.derived),
                Get::Prediction(get) => get(&self.prediction.unwrap_or_default()),
                Get::Tick(get) => get(&self.present_tick()),
                Get::Elements(size, get) => {
                    (0..size).for_each(|k| write(i + k, get(&self.values, k)));
                    i += size;
                    continue;
                }
                Get::Step(size, get) => {
                    (0..size).for_each(|k| write(i + k, get(&self.step_matrices.unwrap_or_default(), k)));
                    i += size;
                    continue;
                }
            };
            write(i, value);
            i += 1;
        }
        Ok(())
    }

    /// Takes the value of variable `i` from `read`. All are checked before the first is set.
    ///
    /// # Errors
    /// A wrong reference, a variable that cannot be set now, a value outside its range; nothing has
    /// changed then.
    #[inline]
    pub fn set(&mut self, bases: Bases, references: &[u32], read: impl Fn(usize) -> f64) -> Outcome {
        let numbering = self.numbering;
        let when = self.when();
        let closed = matches!(self.engine, Engine::Closed(_));
        for (i, &reference) in references.iter().enumerate() {
            let value = read(i);
            let plain = |writer: &Writer| writer.takes(bases, when, value) && !(closed && writer.input);
            if !WRITERS.get(numbering.place(reference)).is_some_and(plain) {
                self.check_set(reference, bases, value)?;
            }
        }
        // A host's solver sees a set at once, not with the next step.
        let before = match &self.engine {
            Engine::Continuous(continuous) => {
                let set = (self.parameters_set, self.loads_set, self.given);
                Some((self.settings, set, self.events, continuous.state()))
            }
            _ => None,
        };
        self.events.carried_out &= references.is_empty();
        for (i, &reference) in references.iter().enumerate() {
            self.assign(&WRITERS[numbering.place(reference)], read(i));
        }
        if let (Some((settings, set, events, state)), Engine::Continuous(continuous)) =
            (before, &mut self.engine)
        {
            if self.parameters_set
                && let Err(error) = continuous.set_parameters(&self.settings.parameters)
            {
                (self.settings, self.events) = (settings, events);
                (self.parameters_set, self.loads_set, self.given) = set;
                continuous.set_state(state);
                self.invalidate();
                return Err(error.into());
            }
            self.parameters_set = false;
            continuous.set_forces(self.settings.loads.derivatives.map(|load| load[0]));
            self.invalidate();
        }
        Ok(())
    }

    /// A closer look at one set.
    #[cold]
    fn check_set(&self, reference: u32, bases: Bases, value: f64) -> Outcome {
        let variable = self.look_up(reference, bases)?;
        self.check_settable(&WRITERS[self.numbering.place(reference)], variable)?;
        if !variable.accepts(value) {
            return Err(Problem::value(variable.name, value, variable.allowed()));
        }
        self.check_load(variable, value)
    }

    /// A closed form is a motion without loads.
    fn check_load(&self, variable: &Variable, value: f64) -> Outcome {
        if variable.causality == Causality::Input && value != 0.0 && matches!(self.engine, Engine::Closed(_))
        {
            return Err(Problem::value(variable.name, value, NO_LOADS));
        }
        Ok(())
    }

    #[inline]
    fn assign(&mut self, variable: &Writer, value: f64) {
        let set = match (&mut self.engine, variable.set) {
            (Engine::Continuous(continuous), Set::Start(set)) => {
                // A continuous state, set one by one.
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
            // Derivatives set for this communication point hold whichever of the two calls comes
            // first.
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

    /// The present phase's bit of [`Writer`].
    fn when(&self) -> u8 {
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

    /// Time derivatives of inputs, orders 1 to 3, at the coming step's start.
    ///
    /// # Errors
    /// A reference that is no input, an order outside 1…3, a value that is not finite; nothing has
    /// changed then.
    pub fn set_input_derivatives(&mut self, references: &[u32], orders: &[i32], values: &[f64]) -> Outcome {
        for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
            let variable = self.look_up(reference, Bases::REAL)?;
            if variable.body.is_none() {
                return Err(Problem::NoDerivative { name: variable.name, allowed: "those of inputs" });
            }
            check_order(variable, order, INPUT_ORDER, "1, 2 or 3")?;
            if !value.is_finite() {
                return Err(Problem::value(variable.name, value, "a finite derivative"));
            }
            self.check_load(variable, value)?;
        }
        for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
            if let Some(body) = self.look_up(reference, Bases::REAL)?.body {
                let load = &mut self.settings.loads.derivatives[body];
                if !self.slopes_set[body] {
                    self.slopes_set[body] = true;
                    load[1..].fill(0.0);
                }
                load[order as usize] = value;
                self.loads_set = true;
            }
        }
        self.prediction = None;
        if matches!(self.engine, Engine::None) {
            self.invalidate();
        }
        Ok(())
    }

    /// Time derivatives of continuous outputs, orders 1 to 3, at the present time, exact inside a
    /// smooth piece of the motion: at an event those before it, or those after it where that is
    /// what is read.
    ///
    /// # Errors
    /// A reference that is no continuous output, an order outside 1…3, [`Problem::Overflow`] for a
    /// derivative that is not finite; nothing is written then.
    pub fn output_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        mut write: impl FnMut(usize, f64),
    ) -> Outcome {
        for (&reference, &order) in references.iter().zip(orders) {
            let variable = self.look_up(reference, Bases::REAL)?;
            jet_of(variable)?;
            check_order(variable, order, OUTPUT_ORDER, "1, 2 or 3")?;
        }
        let jets = self.jets()?;
        let derivative = |instance: &Self, reference: u32, order: i32| -> Outcome<f64> {
            let variable = instance.look_up(reference, Bases::REAL)?;
            let value = jet_of(variable)?(&jets).0[order as usize];
            if value.is_finite() {
                return Ok(value);
            }
            Err(Problem::Overflow { name: variable.name, value, time: instance.time() })
        };
        for (&reference, &order) in references.iter().zip(orders) {
            derivative(self, reference, order)?;
        }
        for (i, (&reference, &order)) in references.iter().zip(orders).enumerate() {
            write(i, derivative(self, reference, order)?);
        }
        Ok(())
    }

    /// The time derivatives of all that the outputs read.
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
                return Err(Problem::sequence("the instance is not initialized"));
            }
        };
        Ok(jets(&Course { values: &values, motion: &motion, parameters: &parameters, loads: &loads, theta }))
    }
}

/// A phase in words: a step ends early at impacts alone.
fn words(phase: Phase) -> &'static str {
    match phase {
        Phase::StoppedEarly => "at the impact at which the step ended",
        phase => phase.words(),
    }
}

/// How the time derivatives of a variable are read.
fn jet_of(variable: &Variable) -> Outcome<fn(&OutputValues<Jet>) -> Jet> {
    let reading = match variable.access {
        Access::Output(reading) | Access::Start { now: reading, .. }
            if variable.causality == Causality::Output =>
        {
            reading.jet
        }
        _ => None,
    };
    reading.ok_or(Problem::NoDerivative { name: variable.name, allowed: "those of continuous outputs" })
}

fn check_order(variable: &Variable, order: i32, highest: i32, allowed: &'static str) -> Outcome {
    if (1..=highest).contains(&order) {
        return Ok(());
    }
    let what = format!("order of a derivative of {}", variable.name);
    Err(fmi_doors::Problem::value(what, f64::from(order), allowed).into())
}
