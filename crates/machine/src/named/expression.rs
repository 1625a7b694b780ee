//! Expressions: sums and products of numbers, `pi` and named parameters.

use super::line::Line;
use crate::refusal::advice;
use std::f64::consts::PI;

/// Longest text of an expression, bytes; it bounds the depth of its parentheses.
const LONGEST: usize = 1_000;

/// An expression with its text, without the `=` before it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Expression {
    pub text: String,
    root: Term,
}

#[derive(Clone, Debug, PartialEq)]
enum Term {
    Number(f64),
    /// Index among the named parameters.
    Parameter(usize),
    Minus(Box<Term>),
    Of(Operator, Box<(Term, Term)>),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Operator {
    Plus,
    Minus,
    Times,
    Over,
}

impl Expression {
    /// Parses the text after the `=`; `names` are the names of the parameters.
    ///
    /// # Errors
    /// A message about the first fault.
    pub fn parse<'t>(text: &'t str, names: impl Iterator<Item = &'t str> + Clone) -> Result<Self, String> {
        let text = text.trim();
        if text.len() > LONGEST {
            return Err(format!("expected an expression of at most {LONGEST} bytes"));
        }
        if text.is_empty() {
            return Err("the expression is empty; write a number or a parameter after `=`".into());
        }
        let mut parser = Parser { rest: text, names };
        let root = parser.sum()?;
        match parser.rest {
            "" => Ok(Self { text: text.into(), root }),
            rest if rest.starts_with('^') || rest.starts_with("**") => {
                Err("powers are not supported; write a product, such as k * k".into())
            }
            rest if rest.starts_with(',') => {
                Err("`,` is not allowed in an expression; write a decimal point".into())
            }
            rest => Err(format!("expected an operator before `{rest}`: + - * /{}", no_unit(rest))),
        }
    }

    /// The value for given values of the parameters.
    ///
    /// # Errors
    /// A message about a division by zero or a value that is not finite.
    pub fn value(&self, parameters: &[f64]) -> Result<f64, String> {
        Ok(self.root.along(parameters, &|_| 0.0)?.0)
    }

    /// The derivative for given values and derivatives of the parameters; 0 without a value.
    pub fn derivative(&self, parameters: &[f64], derivatives: &[f64]) -> f64 {
        self.root.along(parameters, &|place| derivatives[place]).map_or(0.0, |found| found.1)
    }

    /// Exponent of length in the unit; `of` holds the exponents of the parameters.
    pub fn length_power(&self, of: &[i32]) -> i32 {
        self.root.length_power(of)
    }

    /// The expression as a line in one parameter, if it is one; `of` holds the parameters' lines.
    pub(super) fn line(&self, of: &[Option<Line>]) -> Option<Line> {
        self.root.line(of)
    }

    /// Adds the indices of its parameters.
    pub fn add_parameters(&self, to: &mut Vec<usize>) {
        self.root.add_parameters(to);
    }
}

impl Term {
    /// The value and its derivative, by forward differentiation.
    fn along(&self, parameters: &[f64], dot: &dyn Fn(usize) -> f64) -> Result<(f64, f64), String> {
        let (value, derivative) = match self {
            Self::Number(x) => (*x, 0.0),
            Self::Parameter(place) => (parameters[*place], dot(*place)),
            Self::Minus(term) => {
                let (x, dx) = term.along(parameters, dot)?;
                (-x, -dx)
            }
            Self::Of(operator, terms) => {
                let ((x, dx), (y, dy)) = (terms.0.along(parameters, dot)?, terms.1.along(parameters, dot)?);
                match operator {
                    Operator::Plus => (x + y, dx + dy),
                    Operator::Minus => (x - y, dx - dy),
                    Operator::Times => (x * y, dx * y + x * dy),
                    Operator::Over if y == 0.0 => return Err("divides by zero".into()),
                    Operator::Over => (x / y, (dx - x / y * dy) / y),
                }
            }
        };
        if value.is_finite() { Ok((value, derivative)) } else { Err("is not finite".into()) }
    }

    fn length_power(&self, of: &[i32]) -> i32 {
        match self {
            Self::Number(_) => 0,
            Self::Parameter(place) => of[*place],
            Self::Minus(term) => term.length_power(of),
            Self::Of(operator, terms) => {
                let (x, y) = (terms.0.length_power(of), terms.1.length_power(of));
                match operator {
                    Operator::Times => x.saturating_add(y),
                    Operator::Over => x.saturating_sub(y),
                    // A parameter plus a number without a unit has the parameter's unit.
                    Operator::Plus | Operator::Minus => {
                        if x == 0 {
                            y
                        } else {
                            x
                        }
                    }
                }
            }
        }
    }

    fn line(&self, of: &[Option<Line>]) -> Option<Line> {
        let number = |line: &Line| line.place.is_none();
        match self {
            Self::Number(x) => Some(Line::number(*x)),
            Self::Parameter(place) => of[*place],
            Self::Minus(term) => Some(term.line(of)?.times(-1.0)),
            Self::Of(operator, terms) => {
                let (x, y) = (terms.0.line(of)?, terms.1.line(of)?);
                match operator {
                    Operator::Plus => x.plus(y),
                    Operator::Minus => x.plus(y.times(-1.0)),
                    Operator::Times if number(&x) => Some(y.times(x.constant)),
                    Operator::Times => number(&y).then(|| x.times(y.constant)),
                    Operator::Over => number(&y).then(|| x.times(1.0 / y.constant)),
                }
            }
        }
    }

    fn add_parameters(&self, to: &mut Vec<usize>) {
        match self {
            Self::Number(_) => {}
            Self::Parameter(place) => to.push(*place),
            Self::Minus(term) => term.add_parameters(to),
            Self::Of(_, terms) => {
                terms.0.add_parameters(to);
                terms.1.add_parameters(to);
            }
        }
    }
}

struct Parser<'t, N> {
    rest: &'t str,
    names: N,
}

/// A hint if a unit may have been meant.
fn no_unit(rest: &str) -> &'static str {
    let is_word = rest.starts_with(|c: char| c.is_alphabetic() || c == '°' || c == '%');
    if is_word { "; numbers in an expression are in SI, without a unit" } else { "" }
}

impl<'t, N: Iterator<Item = &'t str> + Clone> Parser<'t, N> {
    fn skip(&mut self, bytes: usize) {
        self.rest = self.rest[bytes..].trim_start();
    }

    fn operator(&mut self, allowed: [(char, Operator); 2]) -> Option<Operator> {
        let first = self.rest.chars().next()?;
        let found = allowed.into_iter().find(|(c, _)| *c == first)?.1;
        self.skip(1);
        Some(found)
    }

    fn sum(&mut self) -> Result<Term, String> {
        let mut term = self.product()?;
        while let Some(operator) = self.operator([('+', Operator::Plus), ('-', Operator::Minus)]) {
            term = Term::Of(operator, Box::new((term, self.product()?)));
        }
        Ok(term)
    }

    fn product(&mut self) -> Result<Term, String> {
        let mut term = self.factor()?;
        while let Some(operator) = self.operator([('*', Operator::Times), ('/', Operator::Over)]) {
            term = Term::Of(operator, Box::new((term, self.factor()?)));
        }
        Ok(term)
    }

    fn factor(&mut self) -> Result<Term, String> {
        match self.rest.chars().next() {
            Some('-') => {
                self.skip(1);
                Ok(Term::Minus(Box::new(self.factor()?)))
            }
            Some('(') => {
                self.skip(1);
                let term = self.sum()?;
                if !self.rest.starts_with(')') {
                    let rest = self.rest;
                    return Err(match rest {
                        "" => "a `)` is missing at the end of the expression".into(),
                        _ => format!("expected `)` or an operator before `{rest}`{}", no_unit(rest)),
                    });
                }
                self.skip(1);
                Ok(term)
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_ascii_alphabetic() => self.name(),
            _ => {
                let at = if self.rest.is_empty() {
                    "at the end of the expression".into()
                } else {
                    format!("at `{}`", self.rest)
                };
                Err(format!("expected a number, `pi`, a parameter, `-` or `(` {at}"))
            }
        }
    }

    fn number(&mut self) -> Result<Term, String> {
        let bytes = self.rest.as_bytes();
        let digits = |from: usize| {
            bytes[from..].iter().take_while(|b| b.is_ascii_digit() || **b == b'.').count() + from
        };
        let mut end = digits(0);
        if bytes.get(end).is_some_and(|b| b.eq_ignore_ascii_case(&b'e')) {
            let sign = usize::from(bytes.get(end + 1).is_some_and(|b| b"+-".contains(b)));
            let exponent = digits(end + 1 + sign);
            end = if exponent > end + 1 + sign { exponent } else { end };
        }
        let text = &self.rest[..end];
        let value: f64 = text.parse().map_err(|_| format!("`{text}` is not a number"))?;
        self.skip(end);
        Ok(Term::Number(value))
    }

    fn name(&mut self) -> Result<Term, String> {
        let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let end = self.rest.find(|c| !is_part(c)).unwrap_or(self.rest.len());
        let name = &self.rest[..end];
        let term = match self.names.clone().position(|own| own == name) {
            Some(place) => Term::Parameter(place),
            None if name == "pi" => Term::Number(PI),
            None if self.rest[end..].trim_start().starts_with('(') => {
                return Err(format!(
                    "`{name}`: functions are not supported; expected numbers, parameters, pi, + - * / and ( )"
                ));
            }
            None if self.names.clone().next().is_none() => {
                return Err(format!("no parameter is called `{name}`; the file has no [parameters]"));
            }
            None => {
                let near = advice(name, self.names.clone());
                return Err(format!("no parameter is called `{name}`; {near}"));
            }
        };
        self.skip(end);
        Ok(term)
    }
}
