//! A component made from a table of variables and a few functions that compute the motion.
//!
//! The values of the variables are the complete state of such a model. Access by a host, ranges,
//! phases, saved states, events in both interface types and the model description follow from the
//! table. The author writes only the motion.

mod describe;
mod motion;
mod row;

pub use row::{Role, Row};

use crate::description;
use crate::identifier::identifier;
use crate::instantiation::{Instantiation, Named};
use crate::life::{Interface, Life};
use crate::model::Model;
use crate::problem::Problem;
use crate::values::Bases;
use motion::InputPolynomial;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::marker::PhantomData;

/// Largest number of events per step. A step with more events is refused, since a model whose
/// events accumulate in time would never end the step.
pub const MOST_EVENTS: usize = 1_000_000;

/// A model whose variables are the rows of a table. The value reference of a row is its index in
/// the table, counted from 1. `values` has one value per row, in the order and units of the rows.
#[allow(unused_variables)] // of the defaults
pub trait Tabular: 'static {
    /// `modelName`.
    const NAME: &'static str;
    /// `modelIdentifier`: the name of the library's file.
    const IDENTIFIER: &'static str;
    /// Description of the model.
    const DESCRIPTION: &'static str;
    /// Version of the model: `env!("CARGO_PKG_VERSION")`.
    const VERSION: &'static str;
    /// The variables. One is [`Row::time`]; each [`Row::state`] has one [`Row::derivative`].
    const ROWS: &'static [Row];
    /// Event indicators: the indices of their rows, counted from 0 as in `values`.
    const INDICATORS: &'static [usize] = &[];
    /// Default experiment of a host.
    const EXPERIMENT: description::Experiment =
        description::Experiment { start_time: 0.0, stop_time: 1.0, tolerance: 1e-6, step_size: 0.01 };

    /// Computes the dependent values: derivatives and outputs.
    fn evaluate(values: &mut [f64]);

    /// Advances the states to `time`, s, which is before the next event. The time among `values`
    /// is still the present time.
    fn advance(values: &mut [f64], time: f64);

    /// Time of the next event, s: not before the present time; infinite if there is none.
    fn next_event(values: &[f64]) -> f64 {
        f64::INFINITY
    }

    /// Applies the law of the event that is due. Returns a short description of the event for the
    /// log.
    fn event(values: &mut [f64]) -> String {
        String::new()
    }
}

/// The component of a table, exported by `fmi_doors::export!(FromTable<Model>)`.
pub struct FromTable<T> {
    state: Saved,
    /// Inputs that follow a polynomial within the present step.
    courses: Vec<InputPolynomial>,
    model: PhantomData<fn() -> T>,
}

/// Complete state of such a component.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Saved {
    life: Life,
    values: Vec<f64>,
    /// Whether the last step has ended at an event whose law must still be applied.
    due: bool,
    /// The counters shown until the host handles the events of the last step.
    latched: Option<Vec<f64>>,
}

impl<T> fmt::Debug for FromTable<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.state.fmt(f)
    }
}

impl<T: Tabular> FromTable<T> {
    const TIME: usize = row::place_of_time(T::ROWS);

    fn new(life: Life) -> Self {
        let values = T::ROWS.iter().map(|row| row.start).collect();
        let mut made = Self {
            state: Saved { life, values, due: false, latched: None },
            courses: Vec::new(),
            model: PhantomData,
        };
        T::evaluate(&mut made.state.values);
        made
    }

    /// Token in a description, which the library compares with its own.
    pub fn token() -> String {
        identifier(&format!("{:?}", (T::NAME, T::VERSION, T::ROWS)))
    }

    /// Row and index of a variable of these types.
    fn row(reference: u32, bases: Bases) -> Result<(&'static Row, usize), Problem> {
        let place = (reference as usize).wrapping_sub(1);
        let row = T::ROWS.get(place).filter(|row| bases.contains(row.role.base()));
        row.map(|row| (row, place)).ok_or_else(|| Problem::Reference {
            reference,
            wanted: bases.name,
            found: format!(
                "expected a value reference of the model description, from 1 to {}",
                T::ROWS.len()
            ),
        })
    }

    /// Indices of the continuous states and, in the same order, of their derivatives.
    fn states() -> impl Iterator<Item = (usize, usize)> {
        let of = |state| T::ROWS.iter().position(move |row| row.role == Role::Derivative(state));
        let states = T::ROWS.iter().enumerate().filter(|(_, row)| row.role == Role::State);
        states.filter_map(move |(state, _)| Some((state, of(state)?)))
    }

    /// Changes values and computes the dependent values. If a value is then not finite, nothing is
    /// changed.
    fn change<R>(&mut self, change: impl FnOnce(&mut [f64]) -> R) -> Result<R, Problem> {
        let mut values = self.state.values.clone();
        let result = change(&mut values);
        T::evaluate(&mut values);
        for (value, row) in values.iter_mut().zip(T::ROWS) {
            if row.role == Role::Counter {
                *value = value.min(f64::from(i32::MAX));
            }
            if !value.is_finite() {
                return Err(Problem::value(row.name, *value, "a finite number"));
            }
        }
        self.state.values = values;
        Ok(result)
    }

    /// Indices of the counters.
    fn counters() -> impl Iterator<Item = usize> {
        (0..T::ROWS.len()).filter(|place| T::ROWS[*place].role == Role::Counter)
    }

    /// The shown value of a variable.
    fn shown_value(&self, place: usize) -> f64 {
        let latched = self.state.latched.iter().flatten();
        let counter = Self::counters().zip(latched).find(|(counter, _)| *counter == place);
        counter.map_or(self.state.values[place], |(_, value)| *value)
    }

    /// Checks a state read from arbitrary bytes.
    fn check(saved: &Saved) -> Result<(), Problem> {
        let refused = |what: String| Problem::SavedState { what: what.into() };
        if saved.values.len() != T::ROWS.len() {
            return Err(refused(format!("it has {} values", saved.values.len())));
        }
        let latched = saved.latched.iter().flatten();
        let counters = Self::counters().map(|place| &T::ROWS[place]).zip(latched);
        let mut rows = T::ROWS.iter().zip(&saved.values).chain(counters);
        rows.try_for_each(|(row, value)| {
            row.check_reached(*value).map_err(|problem| refused(problem.to_string()))
        })
    }
}

impl<T: Tabular> Model for FromTable<T> {
    type Problem = Problem;
    type State = Saved;

    fn instantiate(request: &Instantiation<'_>) -> Result<Self, Problem> {
        request.check_token(&Self::token())?;
        Ok(Self::new(request.life()))
    }

    fn life(&self) -> &Life {
        &self.state.life
    }

    fn life_mut(&mut self) -> &mut Life {
        &mut self.state.life
    }

    fn reset(&mut self) {
        *self = Self::new(Life::new(self.state.life.interface, self.state.life.handling));
    }

    fn time(&self) -> f64 {
        self.state.values[Self::TIME]
    }

    fn variable(&self, reference: u32) -> Result<Named<'_>, Problem> {
        let row = Self::row(reference, Bases::ANY)?.0;
        let intermediate_update = row.role.is_intermediate();
        Ok(Named { name: row.name.into(), continuous_input: row.role == Role::Input, intermediate_update })
    }

    fn get(
        &mut self,
        bases: Bases,
        references: &[u32],
        mut write: impl FnMut(usize, f64),
    ) -> Result<(), Problem> {
        references.iter().try_for_each(|reference| Self::row(*reference, bases).map(drop))?;
        for (i, reference) in references.iter().enumerate() {
            write(i, self.shown_value(*reference as usize - 1));
        }
        Ok(())
    }

    fn set(&mut self, bases: Bases, references: &[u32], read: impl Fn(usize) -> f64) -> Result<(), Problem> {
        let phase = self.state.life.phase;
        let mut taken = Vec::with_capacity(references.len());
        for (i, &reference) in references.iter().enumerate() {
            let (row, place) = Self::row(reference, bases)?;
            if !row.role.is_settable(phase) {
                let (name, phase) = (row.name.into(), phase.words());
                return Err(Problem::NotSettable { name, phase, allowed: row::SETTABLE });
            }
            row.check(read(i))?;
            taken.push((place, read(i)));
        }
        self.change(|values| taken.iter().for_each(|(place, value)| values[*place] = *value))
    }

    fn next_event_time(&mut self) -> Option<f64> {
        let stepping = self.state.life.interface == Interface::CoSimulation;
        Some(T::next_event(&self.state.values)).filter(|time| stepping && time.is_finite())
    }

    fn number_of_event_indicators(&self) -> usize {
        T::INDICATORS.len()
    }

    fn set_continuous_states(&mut self, states: &[f64]) -> Result<(), Problem> {
        self.change(|values| {
            Self::states().zip(states).for_each(|((state, _), value)| values[state] = *value);
        })
    }

    fn continuous_states(&self) -> Result<impl AsRef<[f64]>, Problem> {
        Ok(Self::states().map(|(state, _)| self.state.values[state]).collect::<Vec<_>>())
    }

    fn state_derivatives(&self) -> Result<impl AsRef<[f64]>, Problem> {
        Ok(Self::states().map(|(_, derivative)| self.state.values[derivative]).collect::<Vec<_>>())
    }

    fn event_indicators(&self) -> Result<impl AsRef<[f64]>, Problem> {
        Ok(T::INDICATORS.iter().map(|place| self.state.values[*place]).collect::<Vec<_>>())
    }

    fn nominals(&self) -> impl AsRef<[f64]> {
        vec![1.0; Self::states().count()]
    }

    fn save(&self) -> Result<Saved, Problem> {
        Ok(self.state.clone())
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), Problem> {
        let mut life = self.state.life;
        life.take_over(&saved.life)?;
        let latched = saved.latched.clone().filter(|_| life.handling.event_mode);
        self.state = Saved { life, latched, ..saved.clone() };
        Ok(())
    }

    fn serialize(&self, saved: &Saved) -> Result<Vec<u8>, Problem> {
        postcard::to_stdvec(&(Self::token(), saved)).map_err(refused)
    }

    fn deserialize(&self, bytes: &[u8]) -> Result<Saved, Problem> {
        let (written_by, saved): (String, Saved) = postcard::from_bytes(bytes).map_err(refused)?;
        if written_by != Self::token() {
            return Err(Problem::SavedState { what: "it is not from this FMU".into() });
        }
        Self::check(&saved)?;
        Ok(saved)
    }
}

fn refused(error: postcard::Error) -> Problem {
    Problem::SavedState { what: error.to_string().into() }
}
