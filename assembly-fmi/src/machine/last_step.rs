//! The last step, kept so that its derivatives can be had when they are asked for: a step itself
//! takes no longer.

use super::Machine;
use super::moving::Moving;
use std::sync::Arc;
use vibro_assembly::motion::{Hybrid, Reached};
use vibro_assembly::signals::Input;
use vibro_assembly::{Assembly, Error};

/// A time is met again but for this part of it: a step that a host has ended between events makes
/// other sub-steps.
const SAME_TIME: f64 = 8.0 * f64::EPSILON;

/// Where the last step began, what it took over there, and where it was to end.
#[derive(Clone)]
pub(super) struct LastStep {
    pub(super) assembly: Arc<Assembly>,
    pub(super) begin: Hybrid,
    pub(super) inputs: Vec<Option<Input>>,
    pub(super) end: f64,
}

/// Derivatives of the states at the end of a step, each matrix row by row.
#[derive(Clone, Default)]
pub(super) struct StepMatrices {
    /// By the states at its begin.
    pub(super) transition: Vec<f64>,
    /// By value and derivatives 1 to 3, at its begin, of each input in turn.
    pub(super) response: Vec<f64>,
}

impl Machine {
    /// The derivatives over the last step, with the law of an event at its end once that is shown.
    /// Without a step, as before the first and after a saved state was put back, they are those of
    /// a step of no length.
    pub(super) fn step_matrices(&mut self) -> &StepMatrices {
        let found = self.matrices.take().or_else(|| self.find_matrices());
        self.matrices.insert(found.unwrap_or_default())
    }

    fn find_matrices(&self) -> Option<StepMatrices> {
        let states = 2 * self.plan.assembly.states().len();
        let columns = match (&self.last_step, &self.moving) {
            (Some(step), Some(reached)) if !reached.is_on_course() => replay(step, reached).ok()?,
            _ => (0..states + 4 * self.pending.len())
                .map(|k| (0..states).map(|i| f64::from(u8::from(i == k))).collect())
                .collect(),
        };
        // A touch may throw a variation out of range.
        let value = |x: f64| if x.is_nan() { 0.0 } else { x.clamp(f64::MIN, f64::MAX) + 0.0 };
        let (of_states, of_inputs) = columns.split_at(states);
        let by_rows = |columns: &[Vec<f64>]| -> Vec<f64> {
            (0..states).flat_map(|i| columns.iter().map(move |column| value(column[i]))).collect()
        };
        Some(StepMatrices { transition: by_rows(of_states), response: by_rows(of_inputs) })
    }
}

/// The variations at the motion's present point by states and inputs at the step's begin, through
/// all events between.
fn replay(step: &LastStep, reached: &Moving) -> Result<Vec<Vec<f64>>, Error> {
    let mut motion = if Arc::ptr_eq(&step.assembly, reached.motion.assembly()) {
        let mut motion = reached.motion.clone();
        motion.restore(&step.begin);
        motion
    } else {
        let none = || Error::Step { time: reached.motion.time(), end: step.end };
        vibro_assembly::Motion::resumed(step.assembly.clone(), &step.begin).ok_or_else(none)?
    };
    motion = motion.without_energy_accounts();
    let given = step.inputs.iter().enumerate().filter_map(|(i, input)| Some((i, (*input)?)));
    motion.set_inputs(&given.collect::<Vec<_>>())?;
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
            return Ok(variations);
        }
        if motion.time() >= now - late {
            // The last event counts once its law is shown.
            if reached.motion.is_event_due() {
                break;
            }
            motion.pass_event_with(&mut variations)?;
        }
    }
    Ok(variations)
}
