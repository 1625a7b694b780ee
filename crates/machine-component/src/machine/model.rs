//! Variables, continuous states and saved states of a described machine.

use super::{Machine, Moving};
use crate::plan::Plan;
use crate::problem::MachineProblem;
use crate::problem::refused;
use crate::saved_state::SavedState;
use crate::table::{Quantity, Role};
use fmi_doors::{Base, Bases, EarlyEnd, Instantiation, Interface, Life, Model, Named, Problem};
use std::sync::Arc;

/// Highest order of derivatives of inputs.
const INPUT_ORDER: i32 = 3;

impl Model for Machine {
    type Problem = MachineProblem;
    type State = SavedState;

    const EARLY_END: EarlyEnd = EarlyEnd { event: "event", because: "since the host handles events" };

    fn instantiate(request: &Instantiation<'_>) -> Result<Self, MachineProblem> {
        Ok(Self::new(Arc::new(Plan::asked_for(request)?), request.life()))
    }

    fn life(&self) -> &Life {
        &self.life
    }

    fn life_mut(&mut self) -> &mut Life {
        &mut self.life
    }

    fn reset(&mut self) {
        *self = Self::new(self.plan.clone(), Life::new(self.life.interface, self.life.handling));
    }

    fn time(&self) -> f64 {
        self.moving.as_ref().map_or_else(|| self.life.start_time(), |moving| moving.motion.time())
    }

    fn variable(&self, reference: u32) -> Result<Named<'_>, MachineProblem> {
        let row = self.plan.table.row(reference, Bases::ANY)?;
        Ok(Named {
            name: row.name.as_str().into(),
            continuous_input: row.role == Role::Input,
            intermediate_update: row.is_seen_within_steps(),
        })
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
            let role = plan.table.row(reference, bases)?.role;
            moves |= matches!(role, Role::Output | Role::Discrete | Role::Local | Role::Sensitivity);
        }
        if moves {
            self.present()?;
        }
        let mut values = Vec::with_capacity(references.len());
        for &reference in references {
            let row = plan.table.row(reference, bases)?;
            match row.quantity {
                Quantity::Transition => values.extend_from_slice(&self.step_matrices().transition),
                Quantity::Response => values.extend_from_slice(&self.step_matrices().response),
                Quantity::ByParameters => values.extend_from_slice(self.step_by_parameters()),
                quantity => values.push(self.finite_value(quantity, &row.name)?),
            }
        }
        values.into_iter().enumerate().for_each(|(place, value)| write(place, value));
        Ok(())
    }

    fn set(
        &mut self,
        bases: Bases,
        references: &[u32],
        read: impl Fn(usize) -> f64,
    ) -> Result<(), MachineProblem> {
        let mut changes = Vec::new();
        for (i, &reference) in references.iter().enumerate() {
            if let Quantity::Parameter(place) = self.check(reference, bases, read(i))? {
                changes.push((place, read(i)));
            }
        }
        if self.moving.is_some() && !changes.is_empty() {
            self.change(&changes)?;
        }
        for (i, &reference) in references.iter().enumerate() {
            match self.plan.table.row(reference, bases)?.quantity {
                Quantity::Parameter(_) if self.moving.is_some() => {}
                quantity => self.put(quantity, read(i)),
            }
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

    fn output_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        write: impl FnMut(usize, f64),
    ) -> Result<(), MachineProblem> {
        self.time_derivatives(references, orders, write)
    }

    fn directional_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        write: impl FnMut(usize, f64),
    ) -> Result<(), MachineProblem> {
        self.derivatives_along(unknowns, knowns, seed, write)
    }

    /// The next knot of a signal or sample of a block; state events such as impacts are not known.
    fn next_event_time(&mut self) -> Option<f64> {
        let Moving { motion, course, .. } = self.moving.as_ref()?;
        if let Some(course) = course {
            return motion.next_knot_on(course);
        }
        motion.next_time_event()
    }

    fn number_of_event_indicators(&self) -> usize {
        self.plan.table.indicators.len()
    }

    fn set_continuous_states(&mut self, states: &[f64]) -> Result<(), MachineProblem> {
        self.put_states(states)
    }

    fn continuous_states(&self) -> Result<impl AsRef<[f64]>, MachineProblem> {
        self.finite("a state", self.plan.continuous(&self.seen()?.motion.states()))
    }

    fn state_derivatives(&self) -> Result<impl AsRef<[f64]>, MachineProblem> {
        self.finite("a derivative", self.plan.continuous(&self.seen()?.motion.state_derivatives()))
    }

    fn event_indicators(&self) -> Result<impl AsRef<[f64]>, MachineProblem> {
        self.finite("an event indicator", self.seen()?.motion.indicators())
    }

    fn nominals(&self) -> impl AsRef<[f64]> {
        &self.plan.nominals
    }

    fn save(&self) -> Result<SavedState, MachineProblem> {
        Ok(SavedState {
            life: self.life,
            values: self.values.clone(),
            phases: self.phases.clone(),
            changed: self.changed,
            pending: self.pending.clone(),
            moving: self.moving.as_ref().map(Moving::save),
            latched: self.latched.clone(),
        })
    }

    fn restore(&mut self, saved: &SavedState) -> Result<(), MachineProblem> {
        let mut next = Self::new(self.plan.clone(), self.life);
        next.life.take_over(&saved.life)?;
        if saved.life.phase.has_motion().is_some_and(|motion| motion != saved.moving.is_some()) {
            return Err(refused("its phase does not match its motion").into());
        }
        let count = self.values.len();
        if [saved.values.len(), saved.phases.len()] != [count; 2] || saved.pending.len() != self.pending.len()
        {
            return Err(refused("it is from another machine").into());
        }
        next.values.clone_from(&saved.values);
        next.phases.clone_from(&saved.phases);
        next.changed = saved.changed;
        next.pending.clone_from(&saved.pending);
        if let Some(saved_moving) = &saved.moving {
            let on_course = next.life.interface == Interface::ModelExchange;
            if on_course != saved_moving.course.is_some() {
                return Err(refused("its motion is of another interface type").into());
            }
            next.moving = Some(Moving::resumed(self.moving.as_ref(), &self.plan, saved_moving)?);
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
        Ok(saved.to_bytes(&self.plan.machine_token())?)
    }

    fn deserialize(&self, bytes: &[u8]) -> Result<SavedState, MachineProblem> {
        let saved = SavedState::from_bytes(bytes, &self.plan.machine_token())?;
        // Restoring a trial instance checks whether the state fits.
        let mut trial = Self::new(self.plan.clone(), self.life);
        trial.restore(&SavedState {
            life: Life { interface: self.life.interface, ..saved.life },
            ..saved.clone()
        })?;
        Ok(saved)
    }
}
