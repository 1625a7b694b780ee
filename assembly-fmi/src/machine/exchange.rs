//! Model Exchange: time and states come from a host's solver.

use super::Machine;
use super::moving::Moving;
use crate::problem::MachineProblem;
use fmi_doors::{Phase, Problem};
use std::borrow::Cow;
use vibro_assembly::motion::Course;

impl Machine {
    /// What moves, with where the host's solver has come from; none before initialization has
    /// ended.
    fn on_course(&mut self) -> Result<(&mut Moving, Course), MachineProblem> {
        let none = || Problem::Sequence { what: "the instance is not initialized".into() };
        let moving = self.moving.as_mut().ok_or_else(none)?;
        let course = moving.course.clone().ok_or_else(none)?;
        Ok((moving, course))
    }

    /// What was set at an event whose states the host did not update acts from here on.
    pub(super) fn take_ahead(&mut self) -> Result<(), MachineProblem> {
        let ahead = self.ahead.take();
        if let Some(moving) = self.moving.as_ref().filter(|_| self.is_set()) {
            self.moving = Some(ahead.map_or_else(|| self.taken_over(moving), Ok)?);
            self.end_taking_over();
        }
        Ok(())
    }

    pub(super) fn put_time(&mut self, time: f64) -> Result<(), MachineProblem> {
        let at_event = self.life.phase == Phase::Event;
        let (moving, course) = self.on_course()?;
        if !time.is_finite() {
            return Err(Problem::value("time", time, "a finite number").into());
        }
        if at_event && time != moving.motion.time() {
            return Err(Problem::value("time", time, "the present time in Event Mode").into());
        }
        moving.motion.place_at(&course, time);
        Ok(())
    }

    pub(super) fn put_states(&mut self, states: &[f64]) -> Result<(), MachineProblem> {
        let plan = self.plan.clone();
        let (moving, _) = self.on_course()?;
        if let Some((place, value)) = states.iter().enumerate().find(|(_, value)| !value.is_finite()) {
            let bodies = plan.assembly.states();
            let body = &plan.assembly.description.bodies[bodies[place % bodies.len()]].name;
            let what = if place < bodies.len() { "s" } else { "v" };
            return Err(Problem::value(format!("{body}.{what}"), *value, "a finite number").into());
        }
        moving.motion.set_states(states);
        Ok(())
    }

    /// The motion as it is, in initialization the start with all that was set.
    pub(super) fn seen(&self) -> Result<Cow<'_, Moving>, MachineProblem> {
        match (&self.ahead, &self.moving) {
            (Some(ahead), _) => Ok(Cow::Borrowed(ahead)),
            (None, Some(moving)) if self.is_set() && !moving.is_event_due() => {
                Ok(Cow::Owned(self.taken_over(moving)?))
            }
            (None, Some(moving)) => Ok(Cow::Borrowed(moving)),
            (None, None) => Ok(Cow::Owned(self.start()?)),
        }
    }

    /// Numbers for a host's solver, none of which is ever not finite; zeros without a sign.
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
