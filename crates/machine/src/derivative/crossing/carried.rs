//! Carries derivatives over an event, given the derivative δt of its time.

use super::super::columns::Columns;
use super::super::jump::share;
use super::super::lost::{Cause, Lost};
use super::super::samples::actions;
use super::Crossing;
use crate::mode::Contact;
use crate::motion::Impulse;
use crate::signals::StepTime;
use nalgebra::DVector;

/// Adds `factor` × `rates` ⊗ `later`.
fn add_outer(deltas: &mut Columns, factor: f64, rates: &DVector<f64>, later: &[f64]) {
    for (own, rate) in deltas.numbers.chunks_exact_mut(later.len()).zip(rates.iter()) {
        let factor = factor * rate;
        own.iter_mut().zip(later).for_each(|(delta, later)| *delta += factor * later);
    }
}

impl Crossing<'_> {
    /// Carries the derivative over impacts of uncoupled stops, each with its own δt.
    pub(super) fn one_by_one(&self, p: usize, times: &[(Contact, f64)], delta: &mut DVector<f64>) {
        let system = &self.machine.system;
        let mut alone = Columns::zeros(delta.len(), 1);
        alone.put(0, delta);
        for impulse in &Impulse::one_by_one(system, self.events, self.impulses) {
            let own = |time: &&(Contact, f64)| impulse.stops.iter().any(|&i| time.0 == Contact::Stop(i));
            let mut later = vec![0.0; alone.width];
            later[1] = times.iter().find(own).map_or(0.0, |time| time.1);
            let [was, is] = [0, 1].map(|k| self.before.mode.rates(&impulse.states[k]));
            add_outer(&mut alone, 1.0, &was, &later);
            impulse.carry(system, &self.machine.tangents[p..=p], &mut alone);
            add_outer(&mut alone, -1.0, &is, &later);
        }
        delta.copy_from(&alone.column(0));
    }

    /// Carries columns over an event with a single δt: δ⁺ = J (δ + f⁻ δt) + dJ z - f⁺ δt. `later`
    /// has the δt of each column. The result of a column in `apart` is not used.
    pub(super) fn at_once(
        &self,
        mut later: Vec<f64>,
        deltas: &mut Columns,
        lost: &mut [Option<Lost>],
        apart: &[usize],
    ) {
        let machine = self.machine;
        if self.due.is_none() {
            for p in (0..lost.len()).filter(|p| !apart.contains(p)) {
                if lost[p].is_none() {
                    let mut delta = deltas.column(p);
                    match self.at_knot(p, later[p + 1], &mut delta) {
                        Ok(left) => later[p + 1] = left,
                        Err(found) => lost[p] = Some(found),
                    }
                    deltas.put(p, &delta);
                }
            }
        } else {
            add_outer(deltas, 1.0, self.before.rates, &later);
        }
        let tangents = &machine.tangents;
        self.impulses.iter().for_each(|impulse| impulse.carry(&machine.system, tangents, deltas));
        add_outer(deltas, -1.0, self.after.rates, &later);
    }

    /// Applies the change of the signals, and of bodies that links tie to prescribed bodies,
    /// before impacts. Returns the δt for everything after it.
    pub(super) fn at_knot(&self, p: usize, later: f64, delta: &mut DVector<f64>) -> Result<f64, Lost> {
        let (machine, tangent, time) = (self.machine, &self.machine.tangents[p], self.before.time);
        if self.is_sample() {
            machine.sample(p, (time, &actions(self.events)), self.before.z, delta)?;
            return Ok(0.0);
        }
        let knots: Vec<_> = tangent.signals.all_later(time).collect();
        let count = machine.system.signals.knots_at(time);
        // Knots with the same delay delay the event like a single knot.
        let alike = knots.len() == count && knots.iter().all(|knot| knot.later == later);
        if count > 1 && !knots.is_empty() && !alike {
            return knots.iter().try_for_each(|knot| self.some_of_many_knots(knot, delta)).map(|()| 0.0);
        }
        let was = delta.clone();
        machine.fill(p, time, self.after.z, delta);
        let mut step = &*delta - &was;
        step.axpy(later, &(self.after.rates - self.before.rates), 1.0);
        delta.axpy(later, self.before.rates, 1.0);
        let one = machine.system.signals.one;
        let mut signals = delta.rows_range_mut(one..);
        signals.axpy(later, &(self.after.rates - self.before.rates).rows_range(one..), 1.0);
        let moved = self.after.z - self.before.z;
        share(&machine.system, tangent, &moved, &step, delta);
        if machine.system.has_motions {
            let mut jump = &*delta - was;
            jump.axpy(-later, self.before.rates, 1.0);
            machine.stretch(p, &moved, &jump, delta);
        }
        Ok(later)
    }

    /// Treats a step at a time with several knots: δt delays only the height of this step.
    fn some_of_many_knots(&self, knot: &StepTime, delta: &mut DVector<f64>) -> Result<(), Lost> {
        let (machine, own) = (self.machine, self.machine.system.states());
        if machine.system.has_motions || self.before.mode.mode != self.after.mode.mode {
            let element = format!("the step at {} s", self.before.time);
            return Err(Lost { time: self.before.time, element, cause: Cause::Together });
        }
        let mut step = DVector::zeros(delta.len());
        step[knot.place] = knot.height;
        let rates = self.after.mode.rates(&step);
        delta.rows_mut(0, own).axpy(-knot.later, &rates.rows(0, own), 1.0);
        Ok(())
    }
}
