//! Derivatives of motions from a start.

use super::{Start, in_words};
use crate::assembly::Assembly;
use crate::derivative::{By, Differentiated, VariedObserver};
use crate::error::Error;
use crate::refusal::{Problem, Refusal, advice};
use std::sync::Arc;

impl Start {
    /// Columns for names of parameters and of the start's own numbers, such as `start.box.s` and
    /// `start.time`. If this start is not the machine's own, its state is fixed: no parameter
    /// changes it, and `body.box.start.s` means `start.box.s`.
    ///
    /// # Errors
    /// A [`Refusal`] for an unknown name, with the nearest known name.
    pub fn columns(&self, assembly: &Assembly, names: &[&str]) -> Result<Vec<By>, Refusal> {
        names.iter().map(|name| self.column(assembly, name)).collect()
    }

    fn column(&self, assembly: &Assembly, name: &str) -> Result<By, Refusal> {
        let all = Self::names(assembly);
        let place = |own: &str| all.iter().position(|name| name == own);
        if let Some(own) = name.strip_prefix("start.") {
            let refused = || {
                let known: Vec<_> = all.iter().map(|own| format!("start.{own}")).collect();
                let near = advice(name, known.iter().map(String::as_str).chain(["start.time"]));
                Refusal::one(Problem::new(name, None, format!("no start value has this name; {near}")))
            };
            return if own == "time" { Ok(By::Time) } else { place(own).map(By::Start).ok_or_else(refused) };
        }
        if place(name).is_some() {
            let text = format!("is not a parameter; its start value is `start.{name}`");
            return Err(Refusal::one(Problem::new(name, None, text)));
        }
        let name = assembly.description.parameter(name)?.name;
        let of_body = name.strip_prefix("body.").map(|name| name.replace(".start.", "."));
        let of_slider = name
            .strip_prefix("spring.")
            .or(name.strip_prefix("contact."))
            .filter(|own| own.contains(".slider"));
        if let Some(place) = of_slider.filter(|_| !self.is_own()).and_then(place) {
            return Ok(By::Start(place));
        }
        let own = of_body.filter(|_| !self.is_own() && name.contains(".start."));
        Ok(own.and_then(|own| place(&own)).map_or(By::Parameter(name), By::Start))
    }

    /// The motion from this start with its derivatives by [`columns`](Self::columns). Events at
    /// the start are reported to `observer`.
    ///
    /// # Errors
    /// As [`motion`](Self::motion) and [`columns`](Self::columns).
    pub fn differentiated(
        &self,
        assembly: Arc<Assembly>,
        names: &[&str],
        observer: &mut VariedObserver,
    ) -> Result<Differentiated, Error> {
        let columns = self.columns(&assembly, names)?;
        self.differentiated_by(assembly, &columns, observer)
    }

    /// As [`differentiated`](Self::differentiated), with columns instead of names.
    ///
    /// # Errors
    /// As [`differentiated`](Self::differentiated).
    pub fn differentiated_by(
        &self,
        assembly: Arc<Assembly>,
        columns: &[By],
        observer: &mut VariedObserver,
    ) -> Result<Differentiated, Error> {
        if self.is_own() {
            return Differentiated::new_observed(assembly, columns, observer);
        }
        let state = self.state(&assembly)?;
        let begun =
            Differentiated::from_state_observed(assembly.clone(), self.time, &state, columns, observer);
        begun.map_err(|error| in_words(&assembly, self.time, error))
    }

    /// The motion from this start with its derivatives by the numbers of [`state`](Self::state),
    /// one column each. The [`state_derivative`](Differentiated::state_derivative)s of the columns
    /// form the transition matrix.
    ///
    /// # Errors
    /// As [`motion`](Self::motion).
    pub fn transition(&self, assembly: Arc<Assembly>) -> Result<Differentiated, Error> {
        let state = self.state(&assembly)?;
        let columns: Vec<By> = (0..state.len()).map(By::Start).collect();
        let begun = Differentiated::from_state(assembly.clone(), self.time, &state, &columns);
        begun.map_err(|error| in_words(&assembly, self.time, error))
    }
}
