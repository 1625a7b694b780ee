//! Formulas: the force of a spring or damper as an expression of its elongation `e` and its rate
//! `rate` (docs/assembly-law.md, section 20).

mod compiled;
mod potential;

pub(crate) use compiled::{Atom, Compiled, Line, Step};
pub(crate) use potential::potential;

use crate::named::{Expression, Function, Operator, Term};

/// Names of the variables; they precede the names of the parameters.
pub(crate) const VARIABLES: [&str; 2] = ["e", "rate"];

/// An expression of `e`, `rate` and named parameters, in SI.
///
/// ```
/// use vibro_machine::formula::Formula;
///
/// let formula = Formula::new("k * e + c * rate^3", &[("k", 2.0), ("c", 4.0)])?;
/// assert_eq!(formula.value(3.0, 0.5), Some(6.5));
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    text: String,
    /// The names are the [`VARIABLES`], then `names`.
    root: Term,
    /// Names of the parameters in the expression.
    names: Vec<String>,
    /// Values of the parameters.
    pub(crate) values: Vec<f64>,
}

impl Formula {
    /// Parses a formula without the `=` before it; `parameters` are names with values.
    ///
    /// # Errors
    /// A message about the first fault.
    pub fn new(text: &str, parameters: &[(&str, f64)]) -> Result<Self, String> {
        let all = VARIABLES.into_iter().chain(parameters.iter().map(|own| own.0));
        let mut root = Expression::parse_force(text, all)?.root_of_force();
        let mut used = Vec::new();
        root.add_parameters(&mut used);
        used.retain(|place| *place >= VARIABLES.len());
        used.sort_unstable();
        used.dedup();
        let own: Vec<&(&str, f64)> = used.iter().map(|place| &parameters[place - VARIABLES.len()]).collect();
        root.renumber(&|place| match used.iter().position(|own| *own == place) {
            Some(k) => VARIABLES.len() + k,
            None => place,
        });
        let names = own.iter().map(|own| own.0.to_owned()).collect();
        let values = own.iter().map(|own| own.1).collect();
        let formula = Self { text: text.trim().into(), root, names, values };
        if !formula.depends_on(0) && !formula.depends_on(1) {
            return Err("has neither `e` nor `rate`: use `preload` or a load for a constant force".into());
        }
        Ok(formula)
    }

    /// The text without the `=`.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Names of the parameters in the expression.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Names and values of the parameters, mutable.
    pub(crate) fn parameters_mut(&mut self) -> impl Iterator<Item = (&str, &mut f64)> {
        self.names.iter().map(String::as_str).zip(&mut self.values)
    }

    /// Whether the force depends on e.
    pub fn depends_on_elongation(&self) -> bool {
        self.depends_on(0)
    }

    /// Whether the force depends on the rate.
    pub fn depends_on_rate(&self) -> bool {
        self.depends_on(1)
    }

    fn depends_on(&self, variable: usize) -> bool {
        let mut used = Vec::new();
        self.root.add_parameters(&mut used);
        used.contains(&variable)
    }

    /// The force; `None` where it is not defined.
    pub fn value(&self, e: f64, rate: f64) -> Option<f64> {
        let values: Vec<f64> = [e, rate].into_iter().chain(self.values.iter().copied()).collect();
        let found = self.root.along(&values, &|_| 0.0).ok()?;
        Some(found.0)
    }

    /// The derivative of the force by e and by the rate; `None` where it is not defined.
    pub fn slopes(&self, e: f64, rate: f64) -> Option<[f64; 2]> {
        let values: Vec<f64> = [e, rate].into_iter().chain(self.values.iter().copied()).collect();
        let by = |variable: usize| {
            let along = |place: usize| f64::from(u8::from(place == variable));
            Some(self.root.along(&values, &along).ok()?.1).filter(|slope| slope.is_finite())
        };
        Some([by(0)?, by(1)?])
    }

    /// The chain of operations.
    ///
    /// # Errors
    /// A message about a part without variables that is not finite.
    pub(crate) fn compiled(&self) -> Result<Compiled, String> {
        Compiled::of(&self.root, &self.values)
    }
}
