//! Named parameters, and the numbers of a machine that follow from them by expressions.

mod blame;
mod expression;
mod line;
mod ranges;

pub(crate) use expression::{Expression, Function, Operator, Term};

use crate::refusal::Problem;
use std::collections::BTreeMap;

/// The usual spelling of a name: `a[0,1]` for `a[0][1]`, and `amplitude` for
/// `harmonics[0].amplitude` of a single harmonic.
pub(crate) fn usual_name(name: &str) -> String {
    name.replace("][", ",").replace(".harmonics[0].", ".")
}

/// The named parameters of a machine with the expressions of its file. The file reader makes them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NamedParameters {
    all: Vec<Named>,
    /// Indices of the parameters with expressions, each after the parameters in its expression.
    order: Vec<usize>,
    /// Expression of each number that follows, by its name as in [`Description::parameters`].
    numbers: BTreeMap<String, Expression>,
}

/// A named parameter.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Named {
    pub name: String,
    /// SI unit of the value in the file; `1` if it has none.
    pub unit: &'static str,
    pub value: f64,
    pub expression: Option<Expression>,
    /// Comment after the value in the file; empty if there is none.
    pub comment: String,
}

impl Named {
    /// The comment or, without one, the words "Named parameter".
    pub fn meaning(&self) -> String {
        if self.comment.is_empty() { "Named parameter".into() } else { self.comment.clone() }
    }
}

impl NamedParameters {
    /// Creates named parameters and evaluates their expressions. The error is the index of a
    /// parameter and its problem.
    pub(crate) fn new(all: Vec<Named>) -> Result<Self, (usize, String)> {
        let mut named = Self { all, ..Self::default() };
        named.order = named.ordered()?;
        named.evaluate()?;
        Ok(named)
    }

    /// The parameters.
    pub(crate) fn all(&self) -> &[Named] {
        &self.all
    }

    /// The parameters, mutable.
    pub(crate) fn all_mut(&mut self) -> &mut [Named] {
        &mut self.all
    }

    /// Names of the parameters.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> + Clone {
        self.all.iter().map(|own| own.name.as_str())
    }

    /// The values of all parameters.
    pub(crate) fn values(&self) -> Vec<f64> {
        self.all.iter().map(|own| own.value).collect()
    }

    /// Whether any number of the machine follows from named parameters.
    pub(crate) fn has_numbers(&self) -> bool {
        !self.numbers.is_empty()
    }

    /// Names of the numbers of the machine that follow from parameters.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = &str> {
        self.numbers.keys().map(String::as_str)
    }

    /// The expression of a number of the machine.
    pub(crate) fn of_number(&self, name: &str) -> Option<&Expression> {
        self.numbers.get(name)
    }

    /// Adds the expression of a number of the machine.
    pub(crate) fn put(&mut self, number: String, expression: Expression) {
        self.numbers.insert(number, expression);
    }

    /// Indices of the parameters with expressions, each after the parameters in its expression.
    fn ordered(&self) -> Result<Vec<usize>, (usize, String)> {
        let mut order = Vec::new();
        // 0: unseen, 1: being followed, 2: placed.
        let mut seen = vec![0u8; self.all.len()];
        (0..self.all.len()).try_for_each(|place| self.visit(place, &mut seen, &mut order))?;
        Ok(order)
    }

    fn visit(&self, place: usize, seen: &mut [u8], order: &mut Vec<usize>) -> Result<(), (usize, String)> {
        if seen[place] == 2 {
            return Ok(());
        }
        let name = &self.all[place].name;
        if seen[place] == 1 {
            let text = format!("depends on itself: its expression leads back to `{name}`; break this loop");
            return Err((place, text));
        }
        seen[place] = 1;
        if let Some(expression) = &self.all[place].expression {
            let mut from = Vec::new();
            expression.add_parameters(&mut from);
            from.into_iter().try_for_each(|other| self.visit(other, seen, order))?;
            order.push(place);
        }
        seen[place] = 2;
        Ok(())
    }

    /// Sets the values of parameters with expressions.
    pub(crate) fn evaluate(&mut self) -> Result<(), (usize, String)> {
        let values = self.evaluated(self.values())?;
        self.all.iter_mut().zip(values).for_each(|(own, value)| own.value = value);
        Ok(())
    }

    /// Values of all parameters, with expressions evaluated.
    fn evaluated(&self, mut values: Vec<f64>) -> Result<Vec<f64>, (usize, String)> {
        for &place in &self.order {
            let Some(expression) = &self.all[place].expression else { continue };
            values[place] = expression.value(&values).map_err(|text| (place, text))?;
        }
        Ok(values)
    }

    /// Value of a number or parameter with an expression, by its name. `value` returns the values
    /// of parameters without expressions. NaN if the expression divides by zero or overflows.
    pub fn value_with(&self, name: &str, value: impl Fn(&str) -> Option<f64>) -> f64 {
        let given = self.all.iter().map(|own| value(&own.name).unwrap_or(own.value));
        let found = self.evaluated(given.collect()).ok();
        let found = found.and_then(|values| self.expression_of(name)?.value(&values).ok());
        found.unwrap_or(f64::NAN)
    }

    /// Names of the parameters without expressions that the expression of a number or parameter
    /// contains, directly or through other parameters; empty without an expression.
    pub fn sources_of(&self, name: &str) -> Vec<&str> {
        let sources = self.expression_of(name).map(|expression| self.sources(expression));
        sources.into_iter().flatten().map(|place| self.all[place].name.as_str()).collect()
    }

    /// Exponent of length in the unit of each parameter.
    pub(crate) fn length_powers(&self) -> Vec<i32> {
        let of = |own: &Named| match own.unit {
            "m" => 1,
            "1/m" => -1,
            _ => 0,
        };
        let mut powers: Vec<_> = self.all.iter().map(of).collect();
        for &place in &self.order {
            powers[place] = self.all[place].expression.as_ref().map_or(0, |own| own.length_power(&powers));
        }
        powers
    }

    /// The numbers that follow from a parameter, with their derivatives by it.
    pub(crate) fn derivatives(&self, parameter: &str) -> BTreeMap<&str, f64> {
        let Some(own) = self.all.iter().position(|named| named.name == parameter) else {
            return BTreeMap::new();
        };
        let (values, mut along) = (self.values(), vec![0.0; self.all.len()]);
        along[own] = 1.0;
        for &place in &self.order {
            if let Some(expression) = &self.all[place].expression {
                along[place] = expression.derivative(&values, &along);
            }
        }
        let follows = |expression: &Expression| {
            self.sources(expression).contains(&own).then(|| expression.derivative(&values, &along))
        };
        let all = self.numbers.iter();
        all.filter_map(|pair| Some((pair.0.as_str(), follows(pair.1)?))).collect()
    }

    /// Names of the numbers that follow from a parameter; empty for any other name.
    pub fn numbers_of(&self, parameter: &str) -> Vec<&str> {
        self.derivatives(parameter).into_keys().collect()
    }

    /// The parameters without expressions that determine an expression.
    fn sources(&self, expression: &Expression) -> Vec<usize> {
        let (mut next, mut found, mut seen) = (Vec::new(), Vec::new(), vec![false; self.all.len()]);
        expression.add_parameters(&mut next);
        while let Some(place) = next.pop() {
            if std::mem::replace(&mut seen[place], true) {
                continue;
            }
            match &self.all[place].expression {
                Some(further) => further.add_parameters(&mut next),
                None => found.push(place),
            }
        }
        found.sort_unstable();
        found
    }

    fn expression_of(&self, name: &str) -> Option<&Expression> {
        let own = || self.all.iter().find(|named| named.name == name)?.expression.as_ref();
        let number = |name: &str| self.numbers.get(name);
        number(name).or_else(|| number(&usual_name(name))).or_else(own)
    }

    /// The problem of setting a number that follows from parameters, or of differentiating by it.
    pub(crate) fn refusal(&self, name: &str) -> Option<Problem> {
        let expression = self.expression_of(name)?;
        let sources = self.sources(expression).into_iter().map(|place| format!("`{}`", self.all[place].name));
        let sources = sources.collect::<Vec<_>>().join(", ");
        let text = match sources.as_str() {
            "" => format!("is fixed by its expression `= {}`", expression.text),
            _ => {
                format!(
                    "follows from {sources} by the expression `= {}`; change {sources} instead",
                    expression.text
                )
            }
        };
        Some(Problem::new(name, None, text))
    }
}
