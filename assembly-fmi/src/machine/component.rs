//! A described machine as the doors want it.

use super::{Machine, Moving};
use crate::plan::Plan;
use crate::problem::MachineProblem;
use crate::saved_state::{SavedState, refused};
use crate::table::{Quantity, Role};
use fmi_doors::log::Log;
use fmi_doors::{
    Advance, Base, Bases, Component, EarlyEnd, Handled, Instantiation, Interface, Life, Named, Phase, Problem,
};
use std::sync::Arc;
use vibro_assembly::Motion;

/// Highest order of derivatives of inputs.
const INPUT_ORDER: i32 = 3;

impl Component for Machine {
    type Problem = MachineProblem;
    type State = SavedState;
    type Pieces = ();

    const EARLY_END: EarlyEnd = EarlyEnd { event: "event", because: "since the host handles events" };

    fn instantiate(request: &Instantiation<'_>) -> Result<Self, MachineProblem> {
        if request.interface == Interface::ModelExchange {
            return Err(Problem::NotOffered { what: "Model Exchange" }.into());
        }
        Ok(Self::new(Arc::new(Plan::asked_for(request)?), request.life()))
    }

    fn life(&self) -> &Life {
        &self.life
    }

    fn life_mut(&mut self) -> &mut Life {
        &mut self.life
    }

    fn set_experiment(
        &mut self,
        tolerance: Option<f64>,
        start: f64,
        stop: Option<f64>,
    ) -> Result<(), MachineProblem> {
        self.life.experiment = Some(fmi_doors::Experiment::new(tolerance, start, stop)?);
        self.ahead = None;
        Ok(())
    }

    fn exit_initialization(&mut self, _: &mut dyn Log) -> Result<(), MachineProblem> {
        self.present()?;
        self.moving = self.ahead.take();
        self.pending.fill(None);
        self.life.begin();
        Ok(())
    }

    fn reset(&mut self) {
        *self = Self::new(self.plan.clone(), Life::new(self.life.interface, self.life.handling));
    }

    fn time(&self) -> f64 {
        self.moving.as_ref().map_or_else(|| self.life.start_time(), |moving| moving.motion.time())
    }

    fn variable(&self, reference: u32) -> Result<Named<'_>, MachineProblem> {
        let row = self.plan.table.row(reference, Bases::ANY)?;
        let continuous_input = row.role == Role::Input;
        Ok(Named { name: row.name.as_str().into(), continuous_input, intermediate_update: false })
    }

    fn get(
        &mut self,
        bases: Bases,
        references: &[u32],
        mut write: impl FnMut(usize, f64),
    ) -> Result<(), MachineProblem> {
        let plan = self.plan.clone();
        let mut moves = false;
        for &reference in references {
            moves |= matches!(plan.table.row(reference, bases)?.role, Role::Output | Role::Discrete);
        }
        if moves {
            self.present()?;
        }
        for (i, &reference) in references.iter().enumerate() {
            write(i, self.value(plan.table.row(reference, bases)?.quantity));
        }
        Ok(())
    }

    fn set(
        &mut self,
        bases: Bases,
        references: &[u32],
        read: impl Fn(usize) -> f64,
    ) -> Result<(), MachineProblem> {
        for (i, &reference) in references.iter().enumerate() {
            self.check(reference, bases, read(i))?;
        }
        for (i, &reference) in references.iter().enumerate() {
            let quantity = self.check(reference, bases, read(i))?;
            self.put(quantity, read(i));
        }
        Ok(())
    }

    fn set_input_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &[f64],
    ) -> Result<(), MachineProblem> {
        let real = Bases::new("Real", &[Base::Real]);
        let mut pending = self.pending.clone();
        for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
            let row = self.plan.table.row(reference, real)?;
            let Quantity::Input(i) = row.quantity else {
                let (phase, allowed) = (self.life.phase.words(), "derivatives of inputs");
                return Err(Problem::NotSettable { name: row.name.clone().into(), phase, allowed }.into());
            };
            if !(1..=INPUT_ORDER).contains(&order) {
                let what = format!("order of the derivative of {}", row.name);
                return Err(Problem::value(what, f64::from(order), "1, 2 or 3").into());
            }
            if !value.is_finite() {
                let what = format!("derivative of {}", row.name);
                return Err(Problem::value(what, value, "a finite number").into());
            }
            let present = self.value(row.quantity);
            pending[i].get_or_insert([present, 0.0, 0.0, 0.0])[order as usize] = value;
        }
        (self.pending, self.ahead) = (pending, None);
        Ok(())
    }

    fn enter_event(&mut self) -> Result<(), MachineProblem> {
        self.life.phase = Phase::Event;
        self.latched = None;
        Ok(())
    }

    fn handle_events(&mut self, log: &mut dyn Log) -> Result<Handled, MachineProblem> {
        self.handle(log)
    }

    /// The next knot of a signal; impacts and the like are not known before.
    fn next_event_time(&mut self) -> Option<f64> {
        let motion = &self.moving.as_ref()?.motion;
        motion.assembly().system().signals.next_knot(motion.time())
    }

    fn advance(&mut self, point: f64, size: f64, log: &mut dyn Log) -> Result<Advance, MachineProblem> {
        self.go(point, size, log)
    }

    fn save(&self) -> Result<SavedState, MachineProblem> {
        let moving = self.moving.as_ref().map(|moving| (moving.motion.save(), moving.origin));
        Ok(SavedState {
            life: self.life,
            values: self.values.clone(),
            pending: self.pending.clone(),
            moving,
            latched: self.latched.clone(),
        })
    }

    fn restore(&mut self, saved: &SavedState) -> Result<(), MachineProblem> {
        let mut next = Self::new(self.plan.clone(), self.life);
        next.life.take_over(&saved.life)?;
        if saved.values.len() != self.values.len() || saved.pending.len() != self.pending.len() {
            return Err(refused("it is of another machine").into());
        }
        next.values.clone_from(&saved.values);
        next.pending.clone_from(&saved.pending);
        if let Some((hybrid, origin)) = &saved.moving {
            let same = self.moving.as_ref().filter(|_| next.values == self.values);
            let mut motion = match same {
                Some(moving) => moving.motion.clone(),
                None => Motion::starting_at(next.assembly()?, next.life.start_time())?,
            };
            if !hybrid.fits(motion.assembly()) {
                return Err(refused("its motion is not one of this machine").into());
            }
            motion.restore(hybrid);
            next.moving = Some(Moving { motion, origin: *origin });
            let fits = |shown: &&crate::machine::Shown| {
                next.moving.as_ref().is_some_and(|moving| moving.discrete().has_the_shape_of(shown))
            };
            let latched = saved.latched.as_ref().filter(|_| next.life.handling.event_mode);
            next.latched = latched.filter(fits).cloned();
        }
        *self = next;
        Ok(())
    }

    fn serialize(&self, saved: &SavedState) -> Result<Vec<u8>, MachineProblem> {
        Ok(saved.to_bytes(self.plan.token())?)
    }

    fn deserialize(&self, bytes: &[u8]) -> Result<SavedState, MachineProblem> {
        let saved = SavedState::from_bytes(bytes, self.plan.token())?;
        // Whether it fits shows when it is restored, which changes nothing where it does not.
        let mut trial = Self::new(self.plan.clone(), self.life);
        trial.restore(&SavedState {
            life: Life { interface: self.life.interface, ..saved.life },
            ..saved.clone()
        })?;
        Ok(saved)
    }
}
