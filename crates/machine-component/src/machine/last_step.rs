//! The last step, kept so that its derivatives can be computed on demand: a step itself takes no
//! longer.

use super::Machine;
use super::moving::Moving;
use std::sync::Arc;
use vibro_machine::motion::{Hybrid, Reached};
use vibro_machine::signals::Input;
use vibro_machine::{Assembly, Differentiated, Error, Motion};

/// Relative tolerance for the times of a replay. If a host ended a step between events, the replay
/// has other sub-steps.
const SAME_TIME: f64 = 8.0 * f64::EPSILON;

/// Beginning of the last step, the inputs it took over, and its intended end.
#[derive(Clone)]
pub(super) struct LastStep {
    pub(super) assembly: Arc<Assembly>,
    pub(super) begin: Hybrid,
    pub(super) inputs: Vec<Option<Input>>,
    pub(super) end: f64,
}

/// Derivatives of the states at the end of a step; each matrix is stored row by row.
#[derive(Clone, Default)]
pub(super) struct StepMatrices {
    /// Derivatives with respect to the states at the step's beginning.
    pub(super) transition: Vec<f64>,
    /// Derivatives with respect to each input's value and time derivatives 1 to 3 at the
    /// beginning.
    pub(super) response: Vec<f64>,
    /// Derivatives with respect to the tunable parameters, once requested.
    by_parameters: Option<Vec<f64>>,
}

impl Machine {
    /// Returns the derivatives over the last step, including the law of an event at its end once
    /// the host sees the values after it. Before the first step, and after a saved state was
    /// restored, they are the derivatives over a step of length zero.
    pub(super) fn step_matrices(&mut self) -> &mut StepMatrices {
        let found = self.matrices.take().or_else(|| self.find_matrices());
        self.matrices.insert(found.unwrap_or_default())
    }

    fn find_matrices(&self) -> Option<StepMatrices> {
        let states = self.plan.size;
        let columns = match (&self.last_step, &self.moving) {
            (Some(step), Some(reached)) if !reached.is_on_course() => replay(step, reached).ok()?,
            _ => (0..states + 4 * self.pending.len())
                .map(|k| (0..states).map(|i| f64::from(u8::from(i == k))).collect())
                .collect(),
        };
        let (of_states, of_inputs) = columns.split_at(states);
        let by_rows = |columns: &[Vec<f64>]| -> Vec<f64> {
            (0..states).flat_map(|i| columns.iter().map(move |column| number(column[i]))).collect()
        };
        let (transition, response) = (by_rows(of_states), by_rows(of_inputs));
        Some(StepMatrices { transition, response, by_parameters: None })
    }

    /// Returns the derivatives over the last step with respect to the tunable parameters, row by
    /// row. A parameter changes at the beginning of the step, where the states keep their values.
    /// Zeros without a step, and if no derivative exists.
    pub(super) fn step_by_parameters(&mut self) -> &[f64] {
        let own = self.step_matrices().by_parameters.take();
        let found = own.unwrap_or_else(|| self.find_by_parameters());
        self.step_matrices().by_parameters.insert(found)
    }

    fn find_by_parameters(&self) -> Vec<f64> {
        let states = self.plan.size;
        let zeros = || vec![vec![0.0; states]; self.plan.table.tunable().count()];
        let columns = self.columns_by_parameters().unwrap_or_else(zeros);
        (0..states).flat_map(|i| columns.iter().map(move |column| number(column[i]))).collect()
    }

    /// Returns a column for each tunable parameter; `None` without a step.
    fn columns_by_parameters(&self) -> Option<Vec<Vec<f64>>> {
        let (step, reached) = (self.last_step.as_ref()?, self.moving.as_ref()?);
        let begin = step.motion(reached).ok()?;
        let time = begin.time();
        let directions: Vec<_> = self.plan.table.tunable().map(|i| self.direction(i, time)).collect();
        let names: Vec<&str> = directions.iter().flatten().map(|term| term.0).collect();
        let varied = replay_varied(begin, &names, step, reached).ok()?;
        let mut columns = (0..names.len()).map(|p| varied.state_derivative(p));
        let zeros = vec![0.0; self.plan.size];
        let sum = |terms: &Vec<(&str, f64)>| {
            let own: Vec<_> = columns.by_ref().take(terms.len()).collect();
            let parts: Option<Vec<_>> =
                terms.iter().zip(own).map(|(term, column)| Some((term.1, column?))).collect();
            let add = |mut sum: Vec<f64>, (weight, column): (f64, Vec<f64>)| {
                sum.iter_mut().zip(column).for_each(|(sum, x)| *sum += weight * x);
                sum
            };
            parts.unwrap_or_default().into_iter().fold(zeros.clone(), add)
        };
        Some(directions.iter().map(sum).collect())
    }
}

/// Returns a derivative as a number that a host can read: a touch may make a variation overflow.
fn number(x: f64) -> f64 {
    if x.is_nan() { 0.0 } else { x.clamp(f64::MIN, f64::MAX) + 0.0 }
}

impl LastStep {
    /// Returns the motion at the step's beginning, with its inputs; may reuse tables of `reached`.
    fn motion(&self, reached: &Moving) -> Result<Motion, Error> {
        let mut motion = if Arc::ptr_eq(&self.assembly, reached.motion.assembly()) {
            let mut motion = reached.motion.clone();
            motion.restore(&self.begin);
            motion
        } else {
            let none = || Error::Step { time: reached.motion.time(), end: self.end };
            Motion::resumed(self.assembly.clone(), &self.begin).ok_or_else(none)?
        };
        motion = motion.without_energy_accounts();
        let given = self.inputs.iter().enumerate().filter_map(|(i, input)| Some((i, (*input)?)));
        motion.set_inputs(&given.collect::<Vec<_>>())?;
        Ok(motion)
    }
}

/// Returns the derivatives at the present point of the motion with respect to parameters that
/// change at the step's beginning, through all events between.
fn replay_varied(
    begin: Motion,
    parameters: &[&str],
    step: &LastStep,
    reached: &Moving,
) -> Result<Differentiated, Error> {
    let mut varied = Differentiated::from_motion(begin, parameters)?;
    let now = reached.motion.time();
    let late = SAME_TIME * now.abs().max(step.end.abs());
    while varied.motion().time() < now - late || varied.motion().is_event_due() {
        let before = varied.clone();
        let outcome = varied.advance_before_event(step.end)?;
        let time = varied.motion().time();
        if time > now + late {
            // The host has ended the step between events.
            varied = before;
            varied.advance_before_event(now.max(varied.motion().time()))?;
            break;
        }
        // The law of the last event counts once the host sees the values after it.
        if outcome == Reached::End || time >= now - late && reached.motion.is_event_due() {
            break;
        }
        varied.apply_event(&mut |_, _| ())?;
    }
    Ok(varied)
}

/// Returns the derivatives at the present point of the motion with respect to states and inputs at
/// the step's beginning, through all events between.
fn replay(step: &LastStep, reached: &Moving) -> Result<Vec<Vec<f64>>, Error> {
    let mut motion = step.motion(reached)?;
    let mut variations = motion.unit_variations();
    let now = reached.motion.time();
    let late = SAME_TIME * now.abs().max(step.end.abs());
    while motion.time() < now - late || motion.is_event_due() {
        let before = (motion.save(), variations.clone());
        let outcome = motion.advance_with(step.end, &mut variations)?;
        if motion.time() > now + late {
            // The host has ended the step between events.
            motion.restore(&before.0);
            variations = before.1;
            motion.advance_with(now.max(motion.time()), &mut variations)?;
            break;
        }
        if outcome == Reached::End {
            break;
        }
        if motion.time() >= now - late {
            // The law of the last event counts once the host sees the values after it.
            if reached.motion.is_event_due() {
                break;
            }
            motion.pass_event_with(&mut variations)?;
        }
    }
    let system = motion.assembly().system();
    Ok(variations.iter().map(|variation| system.given(variation)).collect())
}
