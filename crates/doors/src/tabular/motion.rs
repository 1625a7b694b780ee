//! Motion of a table: from event to event, with constant inputs, or in small parts of a step if
//! inputs follow polynomials.

use super::{FromTable, MOST_EVENTS, Saved, Tabular};
use crate::events::Handled;
use crate::hybrid::{Ended, Hybrid, Met, StepEnd, Until};
use crate::life::Interface;
use crate::log::{Category, Log};
use crate::model::Model;
use crate::problem::Problem;
use crate::values::Bases;

/// Number of parts of a step. Each part holds a polynomial input at its value in the middle; the
/// error is proportional to the square of the length of a part.
const PARTS: f64 = 16.0;

/// An input that follows a polynomial.
pub(super) struct InputPolynomial {
    place: usize,
    /// Start time of the polynomial, s.
    since: f64,
    /// Value and time derivatives 1 to 3 at the start time.
    polynomial: [f64; 4],
}

impl InputPolynomial {
    fn value(&self, time: f64) -> f64 {
        let ([u, first, second, third], t) = (self.polynomial, time - self.since);
        u + t * (first + t * (second / 2.0 + t * (third / 6.0)))
    }
}

impl<T: Tabular> FromTable<T> {
    fn move_to(&mut self, time: f64) -> Result<(), Problem> {
        self.change(|values| {
            T::advance(values, time);
            values[Self::TIME] = time;
        })
    }

    fn pass_event(&mut self, log: &mut dyn Log) -> Result<(), Problem> {
        let what = self.change(T::event)?;
        if log.wants(Category::Events) {
            log.log(Category::Events, &format!("{what} at t = {} s", self.state.values[Self::TIME]));
        }
        Ok(())
    }

    /// Sets inputs that follow a polynomial to their values at a time.
    fn follow(&mut self, time: f64) -> Result<(), Problem> {
        if self.courses.is_empty() {
            return Ok(());
        }
        let given: Vec<_> = self.courses.iter().map(|course| (course.place, course.value(time))).collect();
        self.change(|values| given.into_iter().for_each(|(place, value)| values[place] = value))
    }
}

impl<T: Tabular> Hybrid for FromTable<T> {
    type Shown = Vec<f64>;
    type Undo = Saved;

    fn forget(&mut self) {
        self.state.values[Self::TIME] = self.state.life.start_time();
    }

    fn start(&mut self, _: &mut dyn Log) -> Result<(), Problem> {
        Ok(())
    }

    /// Values that were set have already taken effect. Only the law of an event remains, if the
    /// last step has ended at an event that the host has not handled.
    fn take_over(&mut self, _: StepEnd, log: &mut dyn Log) -> Result<(Saved, bool), Problem> {
        let before = self.state.clone();
        if self.state.due {
            self.apply_law(log)?;
        }
        Ok((before, false))
    }

    fn run(&mut self, end: StepEnd, until: Until, log: &mut dyn Log) -> Result<Met, Problem> {
        let end = end.value().max(self.time());
        let part = if self.courses.is_empty() { f64::INFINITY } else { (end - self.time()) / PARTS };
        let mut met = Met::default();
        while met.events <= MOST_EVENTS {
            let to = (self.time() + part).min(end);
            self.follow(0.5 * (self.time() + to))?;
            let next = T::next_event(&self.state.values).max(self.time());
            if next > to {
                self.move_to(to)?;
                if to < end {
                    continue;
                }
                return Ok(met);
            }
            self.move_to(next)?;
            if until == Until::Event {
                self.state.due = true;
                return Ok(Met { due: true, ..met });
            }
            self.pass_event(log)?;
            met.events += 1;
            if until == Until::After && next < end {
                return Ok(Met { stopped: true, ..met });
            }
        }
        let what = format!("a step with {MOST_EVENTS} events up to t = {} s: expected fewer", self.time());
        Err(Problem::Sequence { what: what.into() })
    }

    fn undo(&mut self, before: Saved, problem: Problem) -> Problem {
        self.state = before;
        problem
    }

    fn apply_law(&mut self, log: &mut dyn Log) -> Result<(), Problem> {
        self.pass_event(log)?;
        self.state.due = false;
        Ok(())
    }

    fn shown(&self) -> Vec<f64> {
        Self::counters().map(|place| self.state.values[place]).collect()
    }

    fn latch(&mut self, shown: Option<Vec<f64>>) {
        self.state.latched = shown;
    }

    fn end_step(&mut self, _: Ended) {
        // If an input would lead to a value that is not finite, the input keeps its value of the
        // last part.
        let _ = self.follow(self.time());
        self.courses.clear();
    }

    fn set_input(&mut self, reference: u32, polynomial: [f64; 4]) {
        let Ok((_, place)) = Self::row(reference, Bases::REAL) else { return };
        self.courses.retain(|course| course.place != place);
        if polynomial[1..] != [0.0; 3] {
            self.courses.push(InputPolynomial { place, since: self.time(), polynomial });
        }
        // The host has set this value before, and all values were finite then.
        let _ = self.change(|values| values[place] = polynomial[0]);
    }

    /// In Model Exchange the host finds the events from the indicators. An event is due if the
    /// time of the next event is not in the future.
    fn carry_out(&mut self, log: &mut dyn Log) -> Result<Handled, Problem> {
        let come = T::next_event(&self.state.values) <= self.time();
        let states = self.state.due || come && self.state.life.interface == Interface::ModelExchange;
        if states {
            self.apply_law(log)?;
        }
        Ok(Handled { states, nominals: false })
    }

    fn put_time(&mut self, time: f64) -> Result<(), Problem> {
        self.change(|values| values[Self::TIME] = time)
    }
}
