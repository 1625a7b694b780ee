//! Directional derivatives (FMI 2.0, 2.1.9).

use super::initial::forces;
use super::values::look_up;
use super::{Engine, Instance, Outcome};
use crate::fmi2::continuous::Continuous;
use crate::fmi2::problem::Problem;
use crate::fmi2::settings::{Derived, Mode, Motion, Settings};
use crate::fmi2::states::Function;
use crate::fmi2::variables::{Access, Base, Causality, Initial, Variable};
use crate::fmi2::variation::variation;
use vibro_impact::model::Model;
use vibro_impact::simulator::{self, Contact};

/// Step of the differences in Initialization Mode, relative to the known value: the fourth-order formula leaves about its
/// fourth power of truncation and 1e-16 over it of rounding.
const STEP: f64 = 1e-3;

/// Values at the perturbed starts.
type Sample = (Motion, Derived);

impl Instance {
    /// `fmi2GetDirectionalDerivative` (FMI 2.0, 2.1.9). At communication points, in Event and Continuous-Time Mode: of Real
    /// outputs and state derivatives with respect to inputs and continuous states, exactly. In Initialization Mode: of
    /// calculated outputs and parameters with respect to inputs and Reals with `initial = exact`, by differences of fourth
    /// order.
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
        self.guard(Function::GetDirectionalDerivative)?;
        let initial = matches!(self.engine, Engine::None);
        for &reference in unknowns {
            let variable = look_up(reference, Base::Real)?;
            let derived = initial && variable.causality == Causality::CalculatedParameter;
            if !(variable.causality == Causality::Output || derived) {
                return Err(no(variable, self, "outputs as unknowns"));
            }
        }
        for (&reference, &value) in knowns.iter().zip(seed) {
            let variable = look_up(reference, Base::Real)?;
            let start = matches!(variable.access, Access::Start { .. });
            let exact = initial && variable.initial == Some(Initial::Exact);
            if !(variable.causality == Causality::Input || start || exact) {
                return Err(no(variable, self, "inputs and continuous states as knowns"));
            }
            if !value.is_finite() {
                return Err(Problem::Value { name: variable.name, value, allowed: "a finite seed" });
            }
        }
        let variation = if initial { self.differences(knowns, seed)? } else { self.varied(knowns, seed)? };
        for (i, &reference) in unknowns.iter().enumerate() {
            write(i, value_of(look_up(reference, Base::Real)?, &variation));
        }
        Ok(())
    }

    /// The exact variation at the present point.
    fn varied(&self, knowns: &[u32], seed: &[f64]) -> Outcome<Vec<(f64, Sample)>> {
        // Settings serve as the vector of states and loads.
        let mut direction = Settings { start: simulator::State::default(), ..Settings::default() };
        for (&reference, &value) in knowns.iter().zip(seed) {
            let variable = look_up(reference, Base::Real)?;
            add(&mut direction, variable, value);
        }
        let (dx, df) = (&direction.start, forces(&direction));
        let motion = match &self.engine {
            Engine::Simulation(simulator) => {
                let model = Model::new(simulator.parameters())?;
                variation(&model, simulator.parameters(), simulator.contact(), &simulator.state(), dx, df)
            }
            Engine::Continuous(continuous) => continuous.variation(dx, df),
            // A closed form follows time alone.
            Engine::Closed(_) | Engine::None => Motion::default(),
        };
        Ok(vec![(1.0, (motion, Derived::default()))])
    }

    /// Weighted samples whose sum is the derivative: central differences, or one-sided where a range ends.
    fn differences(&self, knowns: &[u32], seed: &[f64]) -> Outcome<Vec<(f64, Sample)>> {
        const FORMULAS: [&[(f64, f64)]; 3] = [
            &[(-2.0, 1.0 / 12.0), (-1.0, -2.0 / 3.0), (1.0, 2.0 / 3.0), (2.0, -1.0 / 12.0)],
            &[(0.0, -25.0 / 12.0), (1.0, 4.0), (2.0, -3.0), (3.0, 4.0 / 3.0), (4.0, -0.25)],
            &[(0.0, 25.0 / 12.0), (-1.0, -4.0), (-2.0, 3.0), (-3.0, -4.0 / 3.0), (-4.0, 0.25)],
        ];
        let contact = match self.settings.mode {
            Mode::EventDriven => self.initial_simulator(&self.settings)?.0.contact(),
            _ => Contact::Flight,
        };
        let mut step = f64::INFINITY;
        for (&reference, &value) in knowns.iter().zip(seed).filter(|(_, value)| **value != 0.0) {
            let variable = look_up(reference, Base::Real)?;
            let size = read(&self.settings, variable).abs();
            step = step.min(STEP * if size > 0.0 { size } else { 1.0 } / value.abs());
        }
        if step == f64::INFINITY {
            return Ok(Vec::new());
        }
        let mut outcome = Ok(Vec::new());
        for formula in FORMULAS {
            outcome = formula
                .iter()
                .map(|&(place, weight)| {
                    let mut settings = self.settings;
                    for (&reference, &value) in knowns.iter().zip(seed) {
                        add(&mut settings, look_up(reference, Base::Real)?, place * step * value);
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
        let motion = if settings.mode == Mode::EventDriven && !settings.start_on_orbit {
            // The contact is held: a start at a stop must not change sides.
            let (p, time) = (&settings.parameters, self.start_time());
            Continuous::frozen(p, settings.start, time, contact, forces(settings))?.motion()
        } else {
            self.initial_motion(settings)?
        };
        Ok((motion, Derived::of(&settings.parameters)))
    }
}

fn no(variable: &Variable, instance: &Instance, allowed: &'static str) -> Problem {
    Problem::NotSettable { name: variable.name, state: instance.state, allowed }
}

fn read(settings: &Settings, variable: &Variable) -> f64 {
    match variable.access {
        Access::Setting { get, .. } | Access::Start { get, .. } => get(settings),
        Access::Motion(_) | Access::Derived(_) => 0.0,
    }
}

fn add(settings: &mut Settings, variable: &Variable, value: f64) {
    if let Access::Setting { get, set } | Access::Start { get, set, .. } = variable.access {
        let sum = get(settings) + value;
        set(settings, sum);
    }
}

fn value_of(variable: &Variable, samples: &[(f64, Sample)]) -> f64 {
    let values = samples.iter().map(|(weight, (motion, derived))| {
        weight
            * match variable.access {
                Access::Motion(get) | Access::Start { now: get, .. } => get(motion),
                Access::Derived(get) => get(derived),
                Access::Setting { .. } => 0.0,
            }
    });
    values.sum()
}
