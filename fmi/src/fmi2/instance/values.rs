//! Getting and setting values (FMI 2.0, 2.1.7 and 2.2.7).

use super::{Engine, Instance, Outcome};
use crate::fmi2::problem::Problem;
use crate::fmi2::settings::Settings;
use crate::fmi2::states::{Function, State};
use crate::fmi2::variables::{
    Access, Base, Causality, READERS, Reader, VARIABLES, Variable, WRITERS, Writer,
};
use vibro_impact::parameters::Parameters;

/// What loads may be while a closed form is played.
pub(super) const NO_LOADS: &str = "0 in a closed-form mode";
/// Highest order of input derivatives.
const INPUT_ORDER: i32 = 3;
/// Highest order of output derivatives: the displacements' fifth is known, so velocities and accelerations have three.
const OUTPUT_ORDER: i32 = 3;

impl Base {
    fn name(self) -> &'static str {
        match self {
            Self::Real => "Real",
            Self::Integer => "Integer",
            Self::Boolean => "Boolean",
            Self::String => "String",
        }
    }

    fn getter(self) -> Function {
        match self {
            Self::Real => Function::GetReal,
            Self::Integer => Function::GetInteger,
            Self::Boolean => Function::GetBoolean,
            Self::String => Function::GetString,
        }
    }

    fn setter(self) -> Function {
        match self {
            Self::Real => Function::SetReal,
            Self::Integer => Function::SetInteger,
            Self::Boolean => Function::SetBoolean,
            Self::String => Function::SetString,
        }
    }
}

/// The variable of that reference and base type.
#[inline]
pub(super) fn look_up(reference: u32, base: Base) -> Outcome<&'static Variable> {
    match VARIABLES.get(reference as usize) {
        Some(variable) if variable.base() == base => Ok(variable),
        found => Err(no_such(reference, base, found)),
    }
}

#[cold]
fn no_such(reference: u32, base: Base, found: Option<&Variable>) -> Problem {
    let found = match found {
        Some(variable) => format!("{} is {}", variable.name, variable.base().name()),
        None => format!("allowed is 0 to {}", VARIABLES.len() - 1),
    };
    Problem::Reference { reference, base: base.name(), found }
}

impl Instance {
    /// `fmi2GetReal`, `fmi2GetInteger`, `fmi2GetBoolean`, `fmi2GetString` (FMI 2.0, 2.1.7): hands value `i` to `write`.
    ///
    /// # Errors
    /// Before anything is written: a reference that is not of this base type, or, in Initialization Mode, a start that is
    /// not possible.
    #[inline]
    pub fn get(&mut self, base: Base, references: &[u32], mut write: impl FnMut(usize, f64)) -> Outcome {
        self.guard(base.getter())?;
        let initialized = !matches!(self.engine, Engine::None);
        let mut needs = 0;
        for &reference in references {
            match READERS.get(reference as usize) {
                Some(reader) if reader.base == base => needs |= reader.needs,
                _ => return Err(no_such(reference, base, VARIABLES.get(reference as usize))),
            }
        }
        let moves = needs & Reader::MOTION != 0 || initialized && needs & Reader::START != 0;
        if moves && self.motion_stale {
            self.refresh_motion()?;
        }
        if needs & Reader::DERIVED != 0 && self.derived_stale {
            self.refresh_derived();
        }
        for (i, &reference) in references.iter().enumerate() {
            let value = match READERS[reference as usize].access {
                Access::Motion(get) => get(&self.motion),
                Access::Start { now, .. } if initialized => now(&self.motion),
                Access::Setting { get, .. } | Access::Start { get, .. } => get(&self.settings),
                Access::Derived(get) => get(&self.derived),
            };
            write(i, value);
        }
        Ok(())
    }

    /// `fmi2SetReal`, `fmi2SetInteger`, `fmi2SetBoolean`, `fmi2SetString` (FMI 2.0, 2.1.7): takes value `i` from `read`.
    /// All are checked before the first is set.
    ///
    /// # Errors
    /// A wrong reference, a variable that cannot be set now, a value outside its range; nothing has changed then.
    #[inline]
    pub fn set(&mut self, base: Base, references: &[u32], read: impl Fn(usize) -> f64) -> Outcome {
        self.guard(base.setter())?;
        let when = self.when();
        let closed = matches!(self.engine, Engine::Closed(_));
        for (i, &reference) in references.iter().enumerate() {
            let value = read(i);
            let plain = |writer: &Writer| writer.takes(base, when, value) && !(closed && writer.input);
            if !WRITERS.get(reference as usize).is_some_and(plain) {
                self.check_set(reference, base, value)?;
            }
        }
        let before = self.interface.applies_at_once().then_some((self.settings, self.parameters_set));
        for (i, &reference) in references.iter().enumerate() {
            self.assign(&WRITERS[reference as usize], read(i));
        }
        if let (Some((settings, parameters_set)), Engine::Continuous(continuous)) = (before, &mut self.engine)
        {
            if self.parameters_set
                && let Err(error) = continuous.set_parameters(&self.settings.parameters)
            {
                (self.settings, self.parameters_set) = (settings, parameters_set);
                return Err(error.into());
            }
            self.parameters_set = false;
            continuous.set_forces(self.settings.loads.derivatives.map(|load| load[0]));
            self.motion_stale = true;
        }
        Ok(())
    }

    /// A closer look at one set.
    #[cold]
    fn check_set(&self, reference: u32, base: Base, value: f64) -> Outcome {
        let variable = look_up(reference, base)?;
        self.check_settable(reference, variable)?;
        if !variable.accepts(value) {
            return Err(Problem::Value { name: variable.name, value, allowed: variable.allowed });
        }
        self.check_load(variable, value)
    }

    /// A closed form is a motion without loads.
    fn check_load(&self, variable: &Variable, value: f64) -> Outcome {
        if variable.causality == Causality::Input && value != 0.0 && matches!(self.engine, Engine::Closed(_))
        {
            return Err(Problem::Value { name: variable.name, value, allowed: NO_LOADS });
        }
        Ok(())
    }

    #[inline]
    fn assign(&mut self, variable: &Writer, value: f64) {
        if let (Engine::Continuous(continuous), Access::Start { set, .. }) =
            (&mut self.engine, variable.access)
        {
            // A continuous state, set one by one (FMI 2.0, 3.2.3, condition 5).
            let mut settings = Settings { start: continuous.state(), ..self.settings };
            set(&mut settings, value);
            continuous.set_state(settings.start);
            return;
        }
        let (Access::Setting { set, .. } | Access::Start { set, .. }) = variable.access else { return };
        let settings = &mut self.settings;
        if variable.input {
            let slopes = (self.slopes_set != [false; 3]).then_some(settings.loads.derivatives);
            set(settings, value);
            // Derivatives set for this communication point hold whichever of the two calls comes first.
            if let Some(slopes) = slopes {
                for body in (0..3).filter(|body| self.slopes_set[*body]) {
                    settings.loads.derivatives[body][1..].copy_from_slice(&slopes[body][1..]);
                }
            }
            self.loads_set = true;
        } else {
            set(settings, value);
            self.parameters_set = true;
            self.derived_stale = true;
        }
        if matches!(self.engine, Engine::None) {
            self.motion_stale = true;
        }
    }

    /// The present state's bit of [`Writer`].
    fn when(&self) -> u8 {
        match self.state {
            State::Instantiated | State::InitializationMode => Writer::INITIAL,
            State::ContinuousTimeMode => Writer::CONTINUOUS,
            _ => Writer::EVENT,
        }
    }

    fn check_settable(&self, reference: u32, variable: &Variable) -> Outcome {
        let when = self.when();
        if WRITERS[reference as usize].settable(when) {
            return Ok(());
        }
        let allowed = match when {
            Writer::INITIAL => "parameters, start values and inputs",
            Writer::CONTINUOUS => "inputs and continuous states",
            _ => "inputs and tunable parameters",
        };
        Err(Problem::NotSettable { name: variable.name, state: self.state, allowed })
    }

    /// `fmi2SetRealInputDerivatives` (FMI 2.0, 4.2.1), orders 1 to 3, at the coming step's start.
    ///
    /// # Errors
    /// A reference that is no input, an order outside 1…3, a value that is not finite; nothing has changed then.
    pub fn set_real_input_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &[f64],
    ) -> Outcome {
        self.guard(Function::SetRealInputDerivatives)?;
        let body = |variable: &Variable| {
            ["box.f", "block.f", "secondary.f"].iter().position(|n| *n == variable.name)
        };
        for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
            let variable = look_up(reference, Base::Real)?;
            if body(variable).is_none() {
                return Err(Problem::NotSettable {
                    name: variable.name,
                    state: self.state,
                    allowed: "derivatives of inputs",
                });
            }
            check_order(order, INPUT_ORDER, "1, 2 or 3")?;
            if !value.is_finite() {
                return Err(Problem::Value { name: variable.name, value, allowed: "a finite derivative" });
            }
            self.check_load(variable, value)?;
        }
        for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
            let variable = &VARIABLES[reference as usize];
            if let Some(body) = body(variable) {
                let load = &mut self.settings.loads.derivatives[body];
                if !self.slopes_set[body] {
                    self.slopes_set[body] = true;
                    load[1..].fill(0.0);
                }
                load[order as usize] = value;
                self.loads_set = true;
            }
        }
        if matches!(self.engine, Engine::None) {
            self.motion_stale = true;
        }
        Ok(())
    }

    /// `fmi2GetRealOutputDerivatives` (FMI 2.0, 4.2.1), orders 1 to 3 of continuous outputs at the present time. Those of
    /// the motion and of what follows from it linearly are exact; others are refused.
    ///
    /// # Errors
    /// A reference that is no output of the motion, an order outside 1…3; nothing is written then.
    pub fn get_real_output_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        mut write: impl FnMut(usize, f64),
    ) -> Outcome {
        self.guard(Function::GetRealOutputDerivatives)?;
        for (&reference, &order) in references.iter().zip(orders) {
            let variable = look_up(reference, Base::Real)?;
            if path(variable).is_none() {
                return Err(Problem::NotSettable {
                    name: variable.name,
                    state: self.state,
                    allowed: "reading derivatives of displacements, velocities, accelerations, stop.s, stop.v and coupling.f",
                });
            }
            check_order(order, OUTPUT_ORDER, "1, 2 or 3")?;
        }
        let derivatives = self.path_derivatives()?;
        let parameters = self.motion_parameters();
        for (i, (&reference, &order)) in references.iter().zip(orders).enumerate() {
            if let Some(path) = path(&VARIABLES[reference as usize]) {
                write(i, path.derivative(&derivatives, &parameters, order as usize));
            }
        }
        Ok(())
    }

    fn path_derivatives(&mut self) -> Outcome<[[f64; 6]; 3]> {
        match &self.engine {
            Engine::Simulation(simulator) => Ok(simulator.derivatives()),
            Engine::Closed(form) => Ok(form.derivatives()),
            Engine::None | Engine::Continuous(_) => {
                Err(Problem::Sequence { what: "the instance is not initialized" })
            }
        }
    }

    /// The parameters the motion at the present time was made with.
    pub(super) fn motion_parameters(&self) -> Parameters {
        match &self.engine {
            Engine::Simulation(simulator) => *simulator.parameters(),
            Engine::Closed(form) => *form.parameters(),
            Engine::Continuous(continuous) => *continuous.parameters(),
            Engine::None => self.settings.parameters,
        }
    }
}

fn check_order(order: i32, highest: i32, allowed: &'static str) -> Outcome {
    if (1..=highest).contains(&order) {
        return Ok(());
    }
    Err(Problem::Value { name: "order", value: f64::from(order), allowed })
}

/// An output as a combination of displacements or their derivatives.
#[derive(Clone, Copy)]
enum Path {
    /// Derivative `order` of a body's displacement.
    Body { body: usize, order: usize },
    /// Derivative `order` of x2 - x1.
    Gap { order: usize },
    /// k23 (x2 - x3).
    Coupling,
}

impl Path {
    fn derivative(self, d: &[[f64; 6]; 3], parameters: &Parameters, order: usize) -> f64 {
        match self {
            Self::Body { body, order: base } => d[body][base + order],
            Self::Gap { order: base } => d[1][base + order] - d[0][base + order],
            Self::Coupling => parameters.coupling_stiffness * (d[1][order] - d[2][order]),
        }
    }
}

fn path(variable: &Variable) -> Option<Path> {
    let (group, member) = variable.name.split_once('.')?;
    let order = match member {
        "s" => 0,
        "v" => 1,
        "a" => 2,
        _ => return (variable.name == "coupling.f").then_some(Path::Coupling),
    };
    match group {
        "box" => Some(Path::Body { body: 0, order }),
        "block" => Some(Path::Body { body: 1, order }),
        "secondary" => Some(Path::Body { body: 2, order }),
        "stop" if order < 2 => Some(Path::Gap { order }),
        _ => None,
    }
}
