//! An instance of a described machine.

mod component;
mod events;

use crate::plan::Plan;
use crate::problem::MachineProblem;
use crate::table::{Energy, Quantity, Role};
use crate::units::{friction_state, stop_state};
use fmi_doors::{Life, Phase, Problem};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::Arc;
use vibro_assembly::signals::Input;
use vibro_assembly::{Assembly, Motion};

/// A motion, and what its energy is held against.
#[derive(Clone)]
struct Moving {
    motion: Motion,
    /// The mechanical energy that it would have without work and losses, J. A prescribed motion that is set anew may stretch
    /// springs at once; what that adds is taken into it.
    origin: f64,
}

impl Moving {
    fn new(motion: Motion) -> Self {
        let mut moving = Self { motion, origin: 0.0 };
        moving.origin = moving.unaccounted();
        moving
    }

    /// Mechanical energy less work plus losses.
    fn unaccounted(&self) -> f64 {
        let (kinetic, stored) = self.motion.kinetic_and_stored();
        kinetic + stored - self.motion.energy().balance()
    }

    /// Sets the inputs that were given.
    fn set_inputs(&mut self, inputs: &[Option<Input>]) -> Result<(), vibro_assembly::Error> {
        let residual = self.unaccounted() - self.origin;
        for (i, input) in inputs.iter().enumerate() {
            match input {
                Some(input) if *input != self.motion.input(i) => self.motion.set_input(i, *input)?,
                _ => {}
            }
        }
        self.origin = self.unaccounted() - residual;
        Ok(())
    }

    /// Stops' states, impacts and last impulses, and frictions' states.
    fn discrete(&self) -> Shown {
        let mode = self.motion.mode();
        let stop = |(i, state)| {
            let (impacts, impulse) = self.motion.impacts(i);
            (stop_state(state), impacts as f64, impulse)
        };
        Shown {
            stops: mode.stops.iter().copied().enumerate().map(stop).collect(),
            frictions: mode.frictions.iter().copied().map(friction_state).collect(),
        }
    }

    fn energy(&self, energy: Energy) -> f64 {
        let accounts = self.motion.energy();
        let (kinetic, stored) = self.motion.kinetic_and_stored();
        let work = || accounts.loads.iter().fold(accounts.motions, |sum, x| sum + *x).value();
        match energy {
            Energy::Kinetic => kinetic,
            Energy::Stored => stored,
            Energy::Work => work(),
            Energy::Lost => work() - accounts.balance(),
            Energy::Residual => self.unaccounted() - self.origin,
        }
    }
}

/// What changes at events only, as a host sees it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Shown {
    /// By stop: state, impacts, last impulse.
    stops: Vec<(f64, f64, f64)>,
    /// By friction.
    frictions: Vec<f64>,
}

impl Shown {
    /// Whether it is of as many stops and frictions.
    fn has_the_shape_of(&self, other: &Self) -> bool {
        self.stops.len() == other.stops.len() && self.frictions.len() == other.frictions.len()
    }
}

/// An instance of a described machine: parameters, inputs and a motion.
pub struct Machine {
    plan: Arc<Plan>,
    life: Life,
    /// Values of all parameters.
    values: Vec<f64>,
    /// What was set of each input and not yet taken over by the motion: value and derivatives.
    pending: Vec<Option<Input>>,
    /// The motion, once initialization has ended.
    moving: Option<Moving>,
    /// The motion as it is with all that was set; made when it is asked for.
    ahead: Option<Moving>,
    /// What changes at events only, as it is shown until the host has handled the events of the last step.
    latched: Option<Shown>,
}

impl fmt::Debug for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { plan, life, .. } = self;
        f.debug_struct("Machine").field("name", &plan.name()).field("life", life).finish_non_exhaustive()
    }
}

impl Machine {
    /// A new instance of a machine, all variables at their start.
    pub fn new(plan: Arc<Plan>, life: Life) -> Self {
        let values = plan.table.parameters.iter().map(|parameter| parameter.value).collect();
        let pending = vec![None; plan.table.inputs.len()];
        Self { plan, life, values, pending, moving: None, ahead: None, latched: None }
    }

    /// The machine with the parameters' present values.
    fn assembly(&self) -> Result<Arc<Assembly>, MachineProblem> {
        let start = self.plan.table.parameters.iter().map(|parameter| parameter.value);
        if start.eq(self.values.iter().copied()) {
            return Ok(self.plan.assembly.clone());
        }
        Ok(Arc::new(Assembly::new(self.plan.machine(&self.values)?)?))
    }

    /// The motion from the start, with all that was set.
    fn start(&self) -> Result<Moving, MachineProblem> {
        let motion = Motion::starting_at(self.assembly()?, self.life.start_time())?;
        let mut moving = Moving::new(motion);
        moving.set_inputs(&self.pending)?;
        Ok(moving)
    }

    /// The motion as it is with all that was set.
    fn present(&mut self) -> Result<&Moving, MachineProblem> {
        if self.ahead.is_none() {
            match &self.moving {
                None => self.ahead = Some(self.start()?),
                Some(moving) if self.pending.iter().any(Option::is_some) => {
                    let mut ahead = moving.clone();
                    ahead.set_inputs(&self.pending)?;
                    self.ahead = Some(ahead);
                }
                Some(_) => {}
            }
        }
        let none = || Problem::Sequence { what: "the instance is not initialized".into() };
        Ok(self.ahead.as_ref().or(self.moving.as_ref()).ok_or_else(none)?)
    }

    /// The value of a quantity; what moves has been asked for by [`present`](Self::present) before.
    fn value(&self, quantity: Quantity) -> f64 {
        let moving = self.ahead.as_ref().or(self.moving.as_ref());
        match quantity {
            Quantity::Time => fmi_doors::Component::time(self),
            Quantity::Parameter(i) => self.values[i],
            Quantity::Input(i) => match (&self.pending[i], &self.moving) {
                (Some(input), _) => input[0],
                (None, Some(moving)) => moving.motion.input(i)[0],
                (None, None) => 0.0,
            },
            _ => moving.map_or(0.0, |moving| self.of_motion(moving, quantity)),
        }
    }

    fn of_motion(&self, moving: &Moving, quantity: Quantity) -> f64 {
        let motion = &moving.motion;
        let shown = |get: fn(&Shown, usize) -> f64, i| match &self.latched {
            Some(shown) => get(shown, i),
            None => get(&moving.discrete(), i),
        };
        let value = match quantity {
            Quantity::Body(i, k) => motion.body(i)[k],
            Quantity::Spring(i, k) => motion.spring(i)[k],
            Quantity::Stop(i, k) => motion.stop(i)[k],
            Quantity::Friction(i, k) => motion.friction(i)[k],
            Quantity::Load(i) => motion.load(i),
            Quantity::Energy(energy) => moving.energy(energy),
            Quantity::StopState(i) => shown(|s, i| s.stops[i].0, i),
            Quantity::Impacts(i) => shown(|s, i| s.stops[i].1, i),
            Quantity::Impulse(i) => shown(|s, i| s.stops[i].2, i),
            Quantity::FrictionState(i) => shown(|s, i| s.frictions[i], i),
            Quantity::Time | Quantity::Parameter(_) | Quantity::Input(_) => 0.0,
        };
        value + 0.0 // zero without a sign
    }

    /// Whether a value may be set now.
    fn check(&self, reference: u32, bases: fmi_doors::Bases, value: f64) -> Result<Quantity, Problem> {
        let row = self.plan.table.row(reference, bases)?;
        let name = || row.name.clone();
        let early = matches!(self.life.phase, Phase::Instantiated | Phase::Initialization);
        match (row.role, row.quantity) {
            (Role::Parameter, Quantity::Parameter(i)) if early => {
                let range = self.plan.table.parameters[i].range();
                if !range.contains(value) {
                    return Err(Problem::value(name(), value, range.allowed));
                }
            }
            (Role::Input, _) if value.is_finite() => {}
            (Role::Input, _) => return Err(Problem::value(name(), value, "a finite number")),
            _ => {
                let allowed = "parameters until initialization ends, and inputs";
                let (name, phase) = (name().into(), self.life.phase.words());
                return Err(Problem::NotSettable { name, phase, allowed });
            }
        }
        Ok(row.quantity)
    }

    /// Takes a value over that was checked.
    fn put(&mut self, quantity: Quantity, value: f64) {
        match quantity {
            Quantity::Parameter(i) => self.values[i] = value,
            Quantity::Input(i) => self.pending[i] = Some([value, 0.0, 0.0, 0.0]),
            _ => {}
        }
        self.ahead = None;
    }
}
