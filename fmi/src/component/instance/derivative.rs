//! Directional derivatives.

use super::events::Present;
use super::initial::forces;
use super::{Engine, Instance, Outcome, Problem};
use crate::component::continuous::Continuous;
use crate::component::settings::{Derived, Settings, SolutionMode};
use crate::component::steady;
use crate::component::structure::EXTENDED_DERIVATIVES;
use crate::component::values::{OutputValues, Varied};
use crate::component::variables::{Access, Bases, Causality, Edition, Initial, Variability, Variable};
use crate::component::variation::{Direction, variation};
use vibro_impact::model::Model;
use vibro_impact::parameters::FIELDS;
use vibro_impact::simulator::{self, Contact};

/// Step of the differences in initialization, relative to the known value: the fourth-order formula leaves about its
/// fourth power of truncation and 1e-16 over it of rounding.
const STEP: f64 = 1e-3;
/// A shorter step in parts of that: it leaves 1e-10 of rounding.
const SHORTER: f64 = 1e-3;

/// Values at the perturbed starts.
type Sample = (OutputValues, Derived);

impl Instance {
    /// The derivative of unknowns along `seed` in the space of knowns. Once there is a motion: of Real outputs and state
    /// derivatives with respect to inputs and continuous states, and in an extended description to tunable parameters and time,
    /// exactly (of a closed form with respect to parameters by differences of fourth order). Before: of calculated outputs and
    /// parameters with respect to inputs and Reals whose initial value is exact, by such differences.
    ///
    /// # Errors
    /// A reference that is no unknown or known here, a seed that is not finite; nothing is written then.
    pub fn directional_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        mut write: impl FnMut(usize, f64),
    ) -> Outcome {
        let initial = matches!(self.engine, Engine::None);
        for &reference in unknowns {
            let variable = self.look_up(reference, Bases::REAL)?;
            let derived = initial && variable.causality == Causality::CalculatedParameter;
            if !(variable.causality == Causality::Output || derived || is_derivative(variable)) {
                return Err(no(variable, "outputs and derivatives of states as unknowns"));
            }
        }
        for (&reference, &value) in knowns.iter().zip(seed) {
            let variable = self.look_up(reference, Bases::REAL)?;
            let start = matches!(variable.access, Access::Start { .. });
            let exact = initial && variable.initial == Some(Initial::Exact);
            let further = !initial && self.edition > Edition::Every && is_further_known(variable);
            if !(variable.causality == Causality::Input || start || exact || further) {
                let allowed = match (initial, self.edition) {
                    (true, _) => "inputs and what has a start value as knowns",
                    (false, Edition::Every) => "inputs and continuous states as knowns",
                    (false, _) => "inputs, continuous states, tunable parameters and time as knowns",
                };
                return Err(no(variable, allowed));
            }
            if !value.is_finite() {
                return Err(Problem::value(variable.name, value, "a finite seed"));
            }
        }
        if initial {
            let samples = self.differences(knowns, seed)?;
            for (i, &reference) in unknowns.iter().enumerate() {
                write(i, difference(self.look_up(reference, Bases::REAL)?, &samples));
            }
        } else {
            let values = self.varied(knowns, seed)?;
            let samples = self.samples_of_form(knowns, seed)?;
            for (i, &reference) in unknowns.iter().enumerate() {
                let variable = self.look_up(reference, Bases::REAL)?;
                write(i, rate(variable, &values) + difference(variable, &samples));
            }
        }
        Ok(())
    }

    /// What the outputs read at the present point, and how it varies along the seed.
    fn varied(&self, knowns: &[u32], seed: &[f64]) -> Outcome<OutputValues<Varied>> {
        // Settings serve as the vector of states, loads and parameters.
        let mut direction = Settings { start: simulator::State::default(), ..Settings::default() };
        for field in &FIELDS {
            (field.set)(&mut direction.parameters, 0.0);
        }
        let mut time = 0.0;
        for (&reference, &value) in knowns.iter().zip(seed) {
            let variable = self.look_up(reference, Bases::REAL)?;
            match variable.causality {
                Causality::Independent => time += value,
                _ => add(&mut direction, variable, value),
            }
        }
        let forces = forces(&direction);
        let along = Direction { state: direction.start, forces, parameters: direction.parameters, time };
        let rates = match self.present()? {
            Present::Simulation(simulator) => {
                let (p, model) = (simulator.parameters(), Model::new(simulator.parameters())?);
                let drive = simulator.drive_phase().sin_cos();
                variation(&model, p, simulator.contact(), &simulator.state(), drive, &along)
            }
            Present::Continuous(continuous) => continuous.variation(&along),
            // A closed form follows time, and parameters by `samples_of_form`.
            Present::Closed(_) if time != 0.0 => self.jets()?.rates(time),
            Present::Closed(_) | Present::None => OutputValues::default(),
        };
        Ok(self.present_values()?.varied(&rates))
    }

    /// Of a closed form that parameters of the seed change, weighted samples; else none.
    fn samples_of_form(&self, knowns: &[u32], seed: &[f64]) -> Outcome<Vec<(f64, Sample)>> {
        if !matches!(self.engine, Engine::Closed(_)) {
            return Ok(Vec::new());
        }
        let (mut parameters, mut along) = (Vec::new(), Vec::new());
        for (&reference, &value) in knowns.iter().zip(seed) {
            if self.look_up(reference, Bases::REAL)?.causality == Causality::Parameter {
                parameters.push(reference);
                along.push(value);
            }
        }
        self.differences(&parameters, &along)
    }

    /// Weighted samples whose sum is the derivative: central differences, or one-sided where a range ends, or where an impact of a closed
    /// form lies between, which jumps: beside it samples on one side have it on the same side.
    fn differences(&self, knowns: &[u32], seed: &[f64]) -> Outcome<Vec<(f64, Sample)>> {
        const FORMULAS: [&[(f64, f64)]; 3] = [
            &[(-2.0, 1.0 / 12.0), (-1.0, -2.0 / 3.0), (1.0, 2.0 / 3.0), (2.0, -1.0 / 12.0)],
            &[(0.0, -25.0 / 12.0), (1.0, 4.0), (2.0, -3.0), (3.0, 4.0 / 3.0), (4.0, -0.25)],
            &[(0.0, 25.0 / 12.0), (-1.0, -4.0), (-2.0, 3.0), (-3.0, -4.0 / 3.0), (-4.0, 0.25)],
        ];
        let contact = match self.settings.mode {
            _ if knowns.is_empty() => Contact::Flight,
            SolutionMode::EventDriven => self.initial_simulator(&self.settings)?.0.contact(),
            _ => Contact::Flight,
        };
        let mut step = f64::INFINITY;
        for (&reference, &value) in knowns.iter().zip(seed).filter(|(_, value)| **value != 0.0) {
            let variable = self.look_up(reference, Bases::REAL)?;
            let size = read(&self.settings, variable).abs();
            step = step.min(STEP * if size > 0.0 { size } else { 1.0 } / value.abs());
        }
        if step == f64::INFINITY {
            return Ok(Vec::new());
        }
        let mut outcome = Ok(Vec::new());
        // Shorter ones where neither side is free of impacts.
        let attempts =
            [step, SHORTER * step].into_iter().flat_map(|step| FORMULAS.map(|formula| (formula, step)));
        for (formula, step) in attempts {
            outcome = formula
                .iter()
                .map(|&(place, weight)| {
                    let mut settings = self.settings;
                    for (&reference, &value) in knowns.iter().zip(seed) {
                        add(&mut settings, self.look_up(reference, Bases::REAL)?, place * step * value);
                    }
                    settings.parameters.validate()?;
                    Ok((weight / step, self.sample(&settings, contact)?))
                })
                .collect();
            if outcome.is_ok() {
                break;
            }
        }
        outcome
    }

    fn sample(&self, settings: &Settings, contact: Contact) -> Outcome<Sample> {
        if let Present::Closed(form) = self.present()? {
            let (side, mut form) = (form.last_side(), form.into_owned());
            form.set_parameters(&settings.parameters)?;
            if form.last_side() != side {
                return Err(Problem::sequence("an impact is as near as a difference is wide"));
            }
            return Ok((form.values(), Derived::default()));
        }
        let values = if settings.mode == SolutionMode::EventDriven && !settings.start_on_orbit {
            // The contact is held: a start at a stop must not change sides.
            let (p, time) = (&settings.parameters, self.start_time());
            Continuous::at(p, settings.start, time, contact, forces(settings))?.values()
        } else {
            self.initial_values(settings)?
        };
        Ok((values, steady::derived(&settings.parameters)))
    }
}

/// Whether a variable is the derivative of a state and nothing else.
fn is_derivative(variable: &Variable) -> bool {
    EXTENDED_DERIVATIVES.contains(&variable.name)
}

/// Whether a variable is a known beside inputs and states: time and what may be tuned.
fn is_further_known(variable: &Variable) -> bool {
    let tunable = variable.causality == Causality::Parameter && variable.variability == Variability::Tunable;
    tunable || variable.causality == Causality::Independent
}

fn no(variable: &Variable, allowed: &'static str) -> Problem {
    Problem::NoDerivative { name: variable.name, allowed }
}

fn read(settings: &Settings, variable: &Variable) -> f64 {
    match variable.access {
        Access::Setting { get, .. } | Access::Start { get, .. } => get(settings),
        _ => 0.0,
    }
}

fn add(settings: &mut Settings, variable: &Variable, value: f64) {
    if let Access::Setting { get, set } | Access::Start { get, set, .. } = variable.access {
        let sum = get(settings) + value;
        set(settings, sum);
    }
}

/// The derivative of a variable from what varies; what changes at events only, and what is set, does not.
fn rate(variable: &Variable, values: &OutputValues<Varied>) -> f64 {
    match variable.access {
        Access::Output(reading) | Access::Start { now: reading, .. } => {
            reading.varied.map_or(0.0, |varied| varied(values).rate)
        }
        _ => 0.0,
    }
}

/// The derivative of a variable from weighted samples.
fn difference(variable: &Variable, samples: &[(f64, Sample)]) -> f64 {
    let values = samples.iter().map(|(weight, (values, derived))| {
        weight
            * match variable.access {
                Access::Output(reading) | Access::Start { now: reading, .. } => (reading.value)(values),
                Access::Derived(get) => get(derived),
                _ => 0.0,
            }
    });
    values.sum()
}
