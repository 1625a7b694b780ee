//! Directional derivatives.

use super::events::Present;
use super::initial::forces;
use super::{ComponentProblem, Engine, Instance, Outcome};
use crate::component::closed_form::ClosedForm;
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

/// Step of differences, relative to the scale of a known ([`measure`](Instance::measure)). The
/// truncation error of the fourth-order formula is about the fourth power of the ratio of the step
/// to the relative width of a resonance; the rounding error is about 1e-16 divided by the step.
const STEP: f64 = 1e-4;
/// Smallest scale of a stiffness or a damping, relative to mass·rate² or mass·rate: a resonance is
/// narrow if these are small.
const LEAST: f64 = 0.1;
/// Smallest rate in these products, relative to the fastest rate.
const SLOWEST: f64 = 1e-2;
/// Smallest scale of the drive's frequency, relative to the fastest rate, and of its amplitude,
/// relative to the forces on the box. A slow drive's steady state hardly depends on fast modes.
const FAINT: (f64, f64) = (1e-6, 1e-3);
/// Limit on the change of the drive's phase since time 0, rad, if its frequency changes by the
/// scale of the frequency.
const TURN: f64 = 10.0;
/// Attempts at a difference: the factor of the step, and the distance in time of the samples from
/// now, in periods. If impacts lie within the step on both sides, a shorter step is tried, with a
/// rounding error of 1e-10. If that fails, the derivative is extrapolated from later or earlier
/// samples.
const ATTEMPTS: [(f64, f64); 6] =
    [(1.0, 0.0), (1e-2, 0.0), (1e-2, 1e-5), (1e-2, -1e-5), (1e-2, 1e-3), (1e-2, -1e-3)];

/// Values at the perturbed starts.
type Sample = (OutputValues, Derived);

impl Instance {
    /// The derivative of unknowns along `seed` in the space of knowns. After initialization the
    /// unknowns are Real outputs and state derivatives; the knowns are inputs and continuous
    /// states, and in an extended description also tunable parameters and time. These derivatives
    /// are exact, except for a closed form with respect to parameters, where they are fourth-order
    /// differences. Before the end of initialization the unknowns are calculated outputs and
    /// parameters; the knowns are inputs and Reals whose initial value is exact. These derivatives
    /// are fourth-order differences.
    ///
    /// # Errors
    /// If a reference is not an unknown or a known here, a seed or a derivative is not finite, or
    /// an intermediate value overflows, for example with seeds near the largest doubles. Then
    /// nothing is written.
    pub(super) fn derivative_along(
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
                    (true, _) => "inputs and variables with a start value as knowns",
                    (false, Edition::Every) => "inputs and continuous states as knowns",
                    (false, _) => "inputs, continuous states, tunable parameters and time as knowns",
                };
                return Err(no(variable, allowed));
            }
            if !value.is_finite() {
                return Err(ComponentProblem::value(variable.name, value, "a finite seed"));
            }
        }
        let (values, samples) = match initial {
            true => (None, self.differences(knowns, seed)?),
            false => (Some(self.varied(knowns, seed)?), self.samples_of_form(knowns, seed)?),
        };
        let along = |variable: &Variable| match &values {
            None => difference(variable, &samples),
            Some(values) => rate(variable, values) + difference(variable, &samples),
        };
        for &reference in unknowns {
            let variable = self.look_up(reference, Bases::REAL)?;
            let value = along(variable);
            if !value.is_finite() {
                return Err(ComponentProblem::Derivative { name: variable.name, value });
            }
        }
        for (i, &reference) in unknowns.iter().enumerate() {
            write(i, along(self.look_up(reference, Bases::REAL)?));
        }
        Ok(())
    }

    /// Values of the outputs at the present point, with their derivatives along the seed.
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
            // The derivative of a closed form with respect to parameters comes from
            // `samples_of_form`.
            Present::Closed(_) if time != 0.0 => self.jets()?.rates(time),
            Present::Closed(_) | Present::None => OutputValues::default(),
        };
        Ok(self.present_values()?.varied(&rates))
    }

    /// Weighted samples of a closed form if the seed changes parameters; otherwise empty.
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

    /// Weighted samples whose sum is the derivative. The formula is a central difference. It is
    /// one-sided if a range ends within the step, or if an impact of a closed form lies between
    /// the samples, since the values jump there. If neither side is possible, the derivative is
    /// extrapolated from two times slightly away from the impact.
    fn differences(&self, knowns: &[u32], seed: &[f64]) -> Outcome<Vec<(f64, Sample)>> {
        const FORMULAS: [&[(f64, f64)]; 3] = [
            &[(-2.0, 1.0 / 12.0), (-1.0, -2.0 / 3.0), (1.0, 2.0 / 3.0), (2.0, -1.0 / 12.0)],
            &[(0.0, -25.0 / 12.0), (1.0, 4.0), (2.0, -3.0), (3.0, 4.0 / 3.0), (4.0, -0.25)],
            &[(0.0, 25.0 / 12.0), (-1.0, -4.0), (-2.0, 3.0), (-3.0, -4.0 / 3.0), (-4.0, 0.25)],
        ];
        let mut along = Vec::new();
        for (&reference, &value) in knowns.iter().zip(seed).filter(|(_, value)| **value != 0.0) {
            let variable = self.look_up(reference, Bases::REAL)?;
            // A closed form is a motion without loads.
            if self.settings.mode == SolutionMode::EventDriven || variable.causality != Causality::Input {
                along.push((variable, value));
            }
        }
        if along.is_empty() {
            return Ok(Vec::new());
        }
        let contact = match self.settings.mode {
            SolutionMode::EventDriven => self.initial_simulator(&self.settings)?.0.contact(),
            _ => Contact::Flight,
        };
        let full = along.iter().map(|(variable, value)| STEP * self.measure(variable) / value.abs());
        let full = full.fold(f64::INFINITY, f64::min);
        let mut refused = None;
        let attempts = match self.settings.mode {
            SolutionMode::EventDriven if self.settings.start_on_orbit => 2,
            SolutionMode::EventDriven => 1,
            _ => ATTEMPTS.len(),
        };
        for (step, away) in &ATTEMPTS[..attempts] {
            let (step, away) = (step * full, away * self.settings.parameters.period());
            for formula in FORMULAS {
                let sampled = formula.iter().map(|&(place, weight)| {
                    let mut settings = self.settings;
                    for (variable, value) in &along {
                        add(&mut settings, variable, place * step * value);
                    }
                    settings.parameters.validate()?;
                    let moments: &[_] = if away == 0.0 { &[(0.0, 1.0)] } else { &[(1.0, 2.0), (2.0, -1.0)] };
                    let samples = moments.iter().map(|(times, part)| {
                        Ok((part * weight / step, self.sample(&settings, contact, times * away)?))
                    });
                    samples.collect::<Outcome<Vec<_>>>()
                });
                match sampled.collect::<Outcome<Vec<_>>>() {
                    Ok(samples) => return Ok(samples.into_iter().flatten().collect()),
                    Err(problem) => refused = Some(problem),
                }
            }
        }
        Err(refused.unwrap_or_else(|| ComponentProblem::sequence("there is nothing to differentiate")))
    }

    /// Scale of a known: its absolute value, but at least a reference value of the same dimension
    /// from this machine. The scale of an angle is one radian, whatever its value.
    fn measure(&self, variable: &Variable) -> f64 {
        let (p, at_start) = (&self.settings.parameters, matches!(self.engine, Engine::None));
        let fastest = Model::new(p).map_or(1.0, |model| model.rate);
        let drive = p.drive_frequency;
        let rate = drive.max(SLOWEST * fastest);
        let mass = p.box_mass.min(p.block_mass).min(p.secondary_mass);
        let least = match variable.unit() {
            Some("m") => p.stop_gap,
            Some("m/s") => p.stop_gap * fastest,
            Some("N") if variable.causality == Causality::Parameter => {
                FAINT.1 * (p.box_stiffness + p.box_mass * drive * drive) * p.stop_gap
            }
            Some("N") => mass * fastest * fastest * p.stop_gap,
            Some("N/m") => LEAST * mass * rate * rate,
            Some("N.s/m") => LEAST * mass * rate,
            Some("rad/s") => FAINT.0 * fastest,
            Some("rad") => return 1.0,
            Some("1") => 1.0,
            _ => 0.0,
        };
        let size = read(&self.settings, variable).abs().max(least);
        let turns = variable.unit() == Some("rad/s") && at_start;
        let size = if turns { size.min(TURN / self.life.start_time().abs()) } else { size };
        if size > 0.0 && size.is_finite() { size } else { 1.0 }
    }

    /// The closed form that is played or, in initialization, at the start.
    fn form(&self) -> Outcome<Option<ClosedForm>> {
        match self.present()? {
            Present::Closed(form) => Ok(Some(form.into_owned())),
            Present::None if self.settings.mode != SolutionMode::EventDriven => {
                Ok(Some(self.initial_form(&self.settings)?))
            }
            _ => Ok(None),
        }
    }

    /// Values with other settings; for a closed form at the time `away` (s) from now.
    fn sample(&self, settings: &Settings, contact: Contact, away: f64) -> Outcome<Sample> {
        if let Some(form) = self.form()? {
            let (side, initial) = (form.counted_side(), matches!(self.engine, Engine::None));
            let mut there = if initial { self.initial_form(settings)? } else { form };
            if !initial {
                there.set_parameters(&settings.parameters)?;
            }
            if away != 0.0 {
                there.shift(away);
            }
            if there.counted_side() != side {
                return Err(over_an_impact());
            }
            let derived = if initial { steady::derived(&settings.parameters) } else { Derived::default() };
            return Ok((there.values(), derived));
        }
        let values = if settings.mode == SolutionMode::EventDriven && !settings.start_on_orbit {
            // The contact is held: a start at a stop must not change sides.
            let (p, time) = (&settings.parameters, self.life.start_time());
            Continuous::at(p, settings.start, time, contact, forces(settings))?.values()
        } else {
            let orbit = |s: &Settings| {
                ClosedForm::new(SolutionMode::ExactOrbit, &s.parameters, self.life.start_time())
            };
            if orbit(settings)?.counted_side() != orbit(&self.settings)?.counted_side() {
                return Err(over_an_impact());
            }
            self.initial_values(settings)?
        };
        Ok((values, steady::derived(&settings.parameters)))
    }
}

/// The error for samples on both sides of a jump.
fn over_an_impact() -> ComponentProblem {
    ComponentProblem::sequence("an impact is as near as a difference is wide")
}

/// Whether a variable exists only as the derivative of a state.
fn is_derivative(variable: &Variable) -> bool {
    EXTENDED_DERIVATIVES.contains(&variable.name)
}

/// Whether a variable is a further known besides inputs and states: time or a tunable parameter.
fn is_further_known(variable: &Variable) -> bool {
    let tunable = variable.causality == Causality::Parameter && variable.variability == Variability::Tunable;
    tunable || variable.causality == Causality::Independent
}

fn no(variable: &Variable, allowed: &'static str) -> ComponentProblem {
    ComponentProblem::NoDerivative { name: variable.name, allowed }
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

/// Derivative of a variable, from the varied values; 0 for variables that are set or change only
/// at events.
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
