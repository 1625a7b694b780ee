//! Expressions: sums and products of numbers, `pi` and named parameters; in the force of a spring
//! or damper also powers and functions.

use super::line::Line;
use crate::refusal::advice;
use std::f64::consts::PI;

/// Longest text of an expression, bytes; it bounds the depth of its parentheses.
const LONGEST: usize = 1_000;
/// Longest text of a force, bytes: a thousand operations with names.
const LONGEST_FORCE: usize = 40_000;
/// Largest number of operations of a force; it bounds the depth of its parentheses.
const MOST_OPERATIONS: usize = 1_000;

/// Largest size of an exponent.
const LARGEST_EXPONENT: f64 = 64.0;

/// An expression with its text, without the `=` before it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Expression {
    pub text: String,
    root: Term,
}

/// A part of an expression.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Term {
    Number(f64),
    /// Index among the names.
    Parameter(usize),
    Minus(Box<Term>),
    Of(Operator, Box<(Term, Term)>),
    /// A power with a constant exponent.
    Power(Box<Term>, f64),
    Function(Function, Box<Term>),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Operator {
    Plus,
    Minus,
    Times,
    Over,
}

/// A function of one argument.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Function {
    Sqrt,
    Exp,
    Ln,
    Sin,
    Cos,
    Tanh,
    Atan,
}

impl Function {
    /// All functions with their names.
    pub const ALL: [(Self, &str); 7] = [
        (Self::Sqrt, "sqrt"),
        (Self::Exp, "exp"),
        (Self::Ln, "ln"),
        (Self::Sin, "sin"),
        (Self::Cos, "cos"),
        (Self::Tanh, "tanh"),
        (Self::Atan, "atan"),
    ];

    /// The value and the derivative.
    pub fn along(self, x: f64) -> (f64, f64) {
        match self {
            Self::Sqrt => (x.sqrt(), 0.5 / x.sqrt()),
            Self::Exp => (x.exp(), x.exp()),
            Self::Ln => (x.ln(), 1.0 / x),
            Self::Sin => (x.sin(), x.cos()),
            Self::Cos => (x.cos(), -x.sin()),
            Self::Tanh => (x.tanh(), x.cosh().powi(-2)),
            Self::Atan => (x.atan(), 1.0 / (1.0 + x * x)),
        }
    }
}

/// Functions and signs with corners, which a force cannot have.
const WITH_CORNERS: [&str; 6] = ["abs", "sign", "min", "max", "floor", "ceil"];
/// First characters of comparisons.
const COMPARISONS: [char; 5] = ['<', '>', '=', '!', '?'];
/// Advice on corners.
pub(crate) const CORNERS: &str = "a formula has no corners: points, stops and friction have them";

/// The fault of a comparison in a force.
fn of_comparison(rest: &str) -> String {
    format!("comparisons are not supported at `{rest}`: {CORNERS}")
}

impl Expression {
    /// Parses the text after the `=`; `names` are the names of the parameters.
    ///
    /// # Errors
    /// A message about the first fault.
    pub fn parse<'t>(text: &'t str, names: impl Iterator<Item = &'t str> + Clone) -> Result<Self, String> {
        Self::parsed(text.trim(), names, false)
    }

    /// Parses the text after the `=` of a force; `names` are the names of the variables and of the
    /// parameters. A force may have powers with constant exponents, and functions.
    ///
    /// # Errors
    /// A message about the first fault.
    pub fn parse_force<'t>(
        text: &'t str,
        names: impl Iterator<Item = &'t str> + Clone,
    ) -> Result<Self, String> {
        Self::parsed(text.trim(), names, true)
    }

    /// The parsed expression.
    pub fn root_of_force(self) -> Term {
        self.root
    }

    fn parsed<'t>(
        text: &'t str,
        names: impl Iterator<Item = &'t str> + Clone,
        is_force: bool,
    ) -> Result<Self, String> {
        let longest = if is_force { LONGEST_FORCE } else { LONGEST };
        if text.len() > longest {
            return Err(format!("expected an expression of at most {longest} bytes"));
        }
        if text.is_empty() {
            return Err("the expression is empty; write a number or a parameter after `=`".into());
        }
        let mut parser = Parser { rest: text, names, is_force, operations: 0 };
        let root = parser.sum()?;
        match parser.rest {
            "" => Ok(Self { text: text.into(), root }),
            rest if is_force && rest.starts_with(COMPARISONS) => Err(of_comparison(rest)),
            rest if rest.starts_with('^') || rest.starts_with("**") => {
                Err("powers are not supported; write a product, such as k * k".into())
            }
            rest if rest.starts_with(',') => {
                Err("`,` is not allowed in an expression; write a decimal point".into())
            }
            rest if rest.starts_with(')') => Err("`)` has no matching `(`; remove it".into()),
            rest => {
                let power = if is_force { " ^" } else { "" };
                Err(format!("expected an operator before `{rest}`: + - * /{power}{}", no_unit(rest)))
            }
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
    /// Replaces the indices of the names.
    pub(crate) fn renumber(&mut self, index: &dyn Fn(usize) -> usize) {
        match self {
            Self::Number(_) => {}
            Self::Parameter(place) => *place = index(*place),
            Self::Minus(term) | Self::Power(term, _) | Self::Function(_, term) => term.renumber(index),
            Self::Of(_, terms) => {
                terms.0.renumber(index);
                terms.1.renumber(index);
            }
        }
    }

    /// The value and its derivative, by forward differentiation.
    pub(crate) fn along(&self, parameters: &[f64], dot: &dyn Fn(usize) -> f64) -> Result<(f64, f64), String> {
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
                    Operator::Over if y == 0.0 => {
                        return Err(
                            "divides by zero; change the expression or a parameter in its divisor".into()
                        );
                    }
                    Operator::Over => (x / y, (dx - x / y * dy) / y),
                }
            }
            Self::Power(base, exponent) => {
                let (x, dx) = base.along(parameters, dot)?;
                // The derivative of x¹ at 0 is 1, and no power of x then multiplies a zero by dx.
                let slope = if dx == 0.0 { 0.0 } else { exponent * x.powf(exponent - 1.0) * dx };
                (x.powf(*exponent), slope)
            }
            Self::Function(function, term) => {
                let (x, dx) = term.along(parameters, dot)?;
                let (value, slope) = function.along(x);
                (value, if dx == 0.0 { 0.0 } else { slope * dx })
            }
        };
        if value.is_finite() { Ok((value, derivative)) } else { Err("is not finite".into()) }
    }

    fn length_power(&self, of: &[i32]) -> i32 {
        match self {
            Self::Number(_) => 0,
            Self::Parameter(place) => of[*place],
            Self::Minus(term) => term.length_power(of),
            Self::Power(..) | Self::Function(..) => 0,
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
            Self::Power(..) | Self::Function(..) => None,
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

    /// Adds the indices of its names.
    pub(crate) fn add_parameters(&self, to: &mut Vec<usize>) {
        match self {
            Self::Number(_) => {}
            Self::Parameter(place) => to.push(*place),
            Self::Minus(term) | Self::Power(term, _) | Self::Function(_, term) => term.add_parameters(to),
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
    /// Whether the expression is a force, with powers and functions.
    is_force: bool,
    /// Number of operations and parentheses so far.
    operations: usize,
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

    /// Counts an operation or a parenthesis.
    fn count(&mut self) -> Result<(), String> {
        self.operations += 1;
        match self.operations > MOST_OPERATIONS {
            true => Err(format!("expected an expression of at most {MOST_OPERATIONS} operations")),
            false => Ok(()),
        }
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
            self.count()?;
            term = Term::Of(operator, Box::new((term, self.product()?)));
        }
        Ok(term)
    }

    fn product(&mut self) -> Result<Term, String> {
        let mut term = self.factor()?;
        while let Some(operator) = self.operator([('*', Operator::Times), ('/', Operator::Over)]) {
            self.count()?;
            term = Term::Of(operator, Box::new((term, self.factor()?)));
        }
        Ok(term)
    }

    fn factor(&mut self) -> Result<Term, String> {
        if self.rest.starts_with('-') {
            self.count()?;
            self.skip(1);
            return Ok(Term::Minus(Box::new(self.factor()?)));
        }
        let base = self.atom()?;
        if !self.is_force {
            return Ok(base);
        }
        if self.rest.starts_with("**") {
            return Err(format!("write `^` for a power at `{}`", self.rest));
        }
        if !self.rest.starts_with('^') {
            return Ok(base);
        }
        self.count()?;
        self.skip(1);
        let exponent = self.factor()?;
        let mut variables = Vec::new();
        exponent.add_parameters(&mut variables);
        if !variables.is_empty() {
            return Err("an exponent must be a number, such as 2 or 1.5; for a variable one write \
                        exp(x * ln(y))"
                .into());
        }
        let value = exponent.along(&[], &|_| 0.0).map_err(|text| format!("the exponent {text}"))?.0;
        if value.abs() > LARGEST_EXPONENT {
            return Err(format!("expected an exponent from -{LARGEST_EXPONENT} to {LARGEST_EXPONENT}"));
        }
        Ok(Term::Power(Box::new(base), value))
    }

    fn atom(&mut self) -> Result<Term, String> {
        match self.rest.chars().next() {
            Some('(') => {
                self.count()?;
                self.skip(1);
                let term = self.sum()?;
                if !self.rest.starts_with(')') {
                    let rest = self.rest;
                    return Err(match rest {
                        "" => "a `)` is missing at the end of the expression".into(),
                        _ if self.is_force && rest.starts_with(COMPARISONS) => of_comparison(rest),
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
            None if self.is_force && self.rest[end..].trim_start().starts_with('(') => {
                return self.function(name, end);
            }
            None if self.rest[end..].trim_start().starts_with('(') => {
                return Err(format!(
                    "`{name}`: functions are not supported; expected numbers, parameters, pi, + - * / and ( )"
                ));
            }
            None if self.is_force && Function::ALL.iter().any(|own| own.1 == name) => {
                return Err(format!("`{name}` is a function; expected its argument in brackets, {name}( )"));
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

    /// Parses a function of one argument; its name ends at a byte.
    fn function(&mut self, name: &'t str, end: usize) -> Result<Term, String> {
        if WITH_CORNERS.contains(&name) {
            return Err(format!("`{name}` is not supported: {CORNERS}"));
        }
        let Some((function, _)) = Function::ALL.into_iter().find(|own| own.1 == name) else {
            let near = advice(name, Function::ALL.iter().map(|own| own.1));
            return Err(format!("no function is called `{name}`; {near}"));
        };
        self.count()?;
        self.skip(end);
        // A bracket follows the name.
        Ok(Term::Function(function, Box::new(self.atom()?)))
    }
}
