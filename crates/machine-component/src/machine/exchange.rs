//! Model Exchange: states of a host's solver.

use super::Machine;
use super::moving::Moving;
use crate::problem::MachineProblem;
use fmi_doors::Problem;
use std::borrow::Cow;

impl Machine {
    pub(super) fn put_states(&mut self, states: &[f64]) -> Result<(), MachineProblem> {
        let none = || Problem::Sequence { what: "the instance is not initialized".into() };
        let moving = self.moving.as_mut().filter(|moving| moving.is_on_course()).ok_or_else(none)?;
        if let Some((place, value)) = states.iter().enumerate().find(|(_, value)| !value.is_finite()) {
            let name = vibro_machine::Start::names(&self.plan.assembly).swap_remove(self.plan.places[place]);
            return Err(Problem::value(name, *value, "a finite number").into());
        }
        moving.set_states(&self.plan.places, states);
        Ok(())
    }

    /// Returns the present motion; in initialization the start with all values that were set.
    pub(super) fn seen(&self) -> Result<Cow<'_, Moving>, MachineProblem> {
        match (&self.ahead, &self.moving) {
            (Some(ahead), _) => Ok(Cow::Borrowed(ahead)),
            (None, Some(moving)) if self.is_set() && !moving.is_event_due() => {
                Ok(Cow::Owned(self.ahead_of(moving)?))
            }
            (None, Some(moving)) => Ok(Cow::Borrowed(moving)),
            (None, None) => Ok(Cow::Owned(self.start()?)),
        }
    }

    /// Removes the signs of zeros for a host's solver. Error if a number is not finite.
    pub(super) fn finite(&self, what: &str, mut numbers: Vec<f64>) -> Result<Vec<f64>, MachineProblem> {
        numbers.iter_mut().for_each(|number| *number += 0.0);
        match numbers.iter().find(|number| !number.is_finite()) {
            None => Ok(numbers),
            Some(number) => {
                Err(Problem::value(what.to_owned(), *number, "states that keep it finite").into())
            }
        }
    }
}
