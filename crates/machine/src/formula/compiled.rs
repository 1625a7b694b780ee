//! A formula as a chain of operations, whose arguments are linear in `e`, `rate` and earlier
//! operations.

use super::{Function, Operator, Term};
use crate::curved::{Operation, POWERS, Polynomial};

/// Limit of the power of a polynomial in one operation.
const LARGEST: usize = POWERS + 1;

/// A term of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Atom {
    /// The constant 1.
    One,
    /// The elongation e.
    Elongation,
    /// The rate e'.
    Rate,
    /// The value of an operation, by its index.
    Step(usize),
}

/// A number with its derivatives by the formula's parameters.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Coefficient {
    pub value: f64,
    pub by: Vec<f64>,
}

impl Coefficient {
    fn number(value: f64, parameters: usize) -> Self {
        Self { value, by: vec![0.0; parameters] }
    }

    /// A function of the number with this value and slope.
    fn mapped(&self, value: f64, slope: f64) -> Self {
        let by = self.by.iter().map(|x| if *x == 0.0 { 0.0 } else { slope * x }).collect();
        Self { value, by }
    }

    fn times(&self, other: &Self) -> Self {
        let by = self.by.iter().zip(&other.by).map(|(x, y)| x * other.value + self.value * y).collect();
        Self { value: self.value * other.value, by }
    }

    fn plus(&self, other: &Self, sign: f64) -> Self {
        let by = self.by.iter().zip(&other.by).map(|(x, y)| x + sign * y).collect();
        Self { value: self.value + sign * other.value, by }
    }

    /// Whether the number is zero for all values of the parameters.
    fn is_zero(&self) -> bool {
        self.value == 0.0 && self.by.iter().all(|x| *x == 0.0)
    }

    /// The derivative, given the derivatives of the parameters.
    pub fn along(&self, parameters: &[f64]) -> f64 {
        self.by.iter().zip(parameters).map(|(by, x)| by * x).sum()
    }
}

/// A linear function of the atoms, in their order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Line(pub Vec<(Atom, Coefficient)>);

impl Line {
    /// The value if the line has no variable.
    fn constant(&self, parameters: usize) -> Option<Coefficient> {
        match &self.0[..] {
            [] => Some(Coefficient::number(0.0, parameters)),
            [(Atom::One, own)] => Some(own.clone()),
            _ => None,
        }
    }

    fn of(atom: Atom, coefficient: Coefficient) -> Self {
        if coefficient.is_zero() { Self::default() } else { Self(vec![(atom, coefficient)]) }
    }

    fn times(&self, factor: &Coefficient) -> Self {
        if factor.is_zero() {
            return Self::default();
        }
        Self(self.0.iter().map(|(atom, own)| (*atom, own.times(factor))).collect())
    }

    fn plus(mut self, other: &Self, sign: f64) -> Self {
        for (atom, x) in &other.0 {
            match self.0.binary_search_by_key(atom, |own| own.0) {
                Ok(k) => self.0[k].1 = self.0[k].1.plus(x, sign),
                Err(k) => {
                    let minus = Coefficient::number(0.0, x.by.len()).plus(x, sign);
                    self.0.insert(k, (*atom, minus));
                }
            }
        }
        self.0.retain(|own| !own.1.is_zero());
        self
    }
}

/// An operation of a formula.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Step {
    pub operation: Operation,
    /// The arguments; the second is empty for an operation of one argument.
    pub arguments: [Line; 2],
}

/// A chain of operations, with the force and its part without the rate as lines.
#[derive(Clone, Debug, Default)]
pub(crate) struct Compiled {
    pub steps: Vec<Step>,
    /// φ(e, e').
    pub force: Line,
    /// φ(e, 0); empty if it is not defined.
    pub elastic: Line,
}

/// The state of a compilation.
struct Compiler<'a> {
    values: &'a [f64],
    /// Whether the rate is 0.
    is_elastic: bool,
    steps: Vec<Step>,
}

impl Compiled {
    /// The chain of an expression for given values of its parameters.
    pub fn of(root: &Term, values: &[f64]) -> Result<Self, String> {
        let mut compiler = Compiler { values, is_elastic: false, steps: Vec::new() };
        let force = compiler.line(root)?;
        let known = compiler.steps.len();
        compiler.is_elastic = true;
        let elastic = compiler.line(root).unwrap_or_default();
        if elastic.0.is_empty() {
            compiler.steps.truncate(known);
        }
        Ok(Self { steps: compiler.steps, force, elastic })
    }

    /// The values of the operations at an elongation and rate.
    pub fn at(&self, e: f64, rate: f64) -> Vec<f64> {
        let mut values: Vec<f64> = Vec::new();
        for step in &self.steps {
            let arguments = step.arguments.each_ref().map(|line| value(line, (e, rate), &values));
            values.push(step.operation.value(arguments));
        }
        values
    }

    /// For each operation with a domain, whether its argument is positive, at an elongation
    /// without a rate.
    pub fn signs(&self, e: f64) -> Vec<bool> {
        let values = self.at(e, 0.0);
        let own = self.steps.iter().filter(|step| step.operation.has_domain());
        own.map(|step| value(&step.arguments[0], (e, 0.0), &values) > 0.0).collect()
    }

    /// The first operation that is not defined at an elongation and rate, with its argument.
    pub fn undefined(&self, e: f64, rate: f64) -> Option<(Operation, f64)> {
        let values = self.at(e, rate);
        let own = |step: &Step| (step.operation, value(&step.arguments[0], (e, rate), &values));
        self.steps.iter().map(own).find(|(operation, a)| !operation.is_defined(*a))
    }
}

/// The value of a line.
fn value(line: &Line, (e, rate): (f64, f64), steps: &[f64]) -> f64 {
    let term = |(atom, own): &(Atom, Coefficient)| {
        own.value
            * match atom {
                Atom::One => 1.0,
                Atom::Elongation => e,
                Atom::Rate => rate,
                Atom::Step(i) => steps[*i],
            }
    };
    line.0.iter().map(term).sum()
}

impl Compiler<'_> {
    fn number(&self, value: f64) -> Coefficient {
        Coefficient::number(value, self.values.len())
    }

    fn variable(&self, place: usize) -> Line {
        match place {
            0 => Line::of(Atom::Elongation, self.number(1.0)),
            1 if self.is_elastic => Line::default(),
            1 => Line::of(Atom::Rate, self.number(1.0)),
            _ => {
                let mut own = self.number(self.values[place - 2]);
                own.by[place - 2] = 1.0;
                Line::of(Atom::One, own)
            }
        }
    }

    fn line(&mut self, term: &Term) -> Result<Line, String> {
        match term {
            Term::Number(x) => Ok(Line::of(Atom::One, self.number(*x))),
            Term::Parameter(place) => Ok(self.variable(*place)),
            Term::Minus(term) => Ok(Line::default().plus(&self.line(term)?, -1.0)),
            Term::Of(operator, terms) => self.of(*operator, &terms.0, &terms.1),
            Term::Power(base, exponent) => self.power(base, *exponent),
            Term::Function(function, term) => {
                let line = self.line(term)?;
                self.function(*function, line)
            }
        }
    }

    fn of(&mut self, operator: Operator, a: &Term, b: &Term) -> Result<Line, String> {
        match operator {
            Operator::Plus => Ok(self.line(a)?.plus(&self.line(b)?, 1.0)),
            Operator::Minus => Ok(self.line(a)?.plus(&self.line(b)?, -1.0)),
            Operator::Times => {
                let (a, b) = (self.line(a)?, self.line(b)?);
                Ok(self.product(a, b))
            }
            Operator::Over => {
                let a = self.line(a)?;
                // The power of a divisor changes its sign: a division has one pole, not a power
                // and a reciprocal.
                let b = match b {
                    Term::Power(base, exponent) => self.power(base, -exponent)?,
                    _ => self.power(b, -1.0)?,
                };
                Ok(self.product(a, b))
            }
        }
    }

    fn product(&mut self, a: Line, b: Line) -> Line {
        let count = self.values.len();
        if let Some(factor) = a.constant(count) {
            return b.times(&factor);
        }
        if let Some(factor) = b.constant(count) {
            return a.times(&factor);
        }
        if a == b { self.monomial(a, 2) } else { self.step(Operation::Product, [a, b]) }
    }

    fn power(&mut self, base: &Term, exponent: f64) -> Result<Line, String> {
        let base = self.line(base)?;
        if exponent == 0.0 {
            return Ok(Line::of(Atom::One, self.number(1.0)));
        }
        if let Some(own) = base.constant(self.values.len()) {
            if exponent < 0.0 && own.value == 0.0 {
                return Err("divides by zero; change the expression or a parameter in its divisor".into());
            }
            let (value, slope) = (own.value.powf(exponent), exponent * own.value.powf(exponent - 1.0));
            return finite(own.mapped(value, slope));
        }
        if exponent.fract() == 0.0 && exponent > 0.0 {
            return Ok(self.whole_power(base, exponent as usize));
        }
        Ok(self.step(Operation::Power(exponent), [base, Line::default()]))
    }

    /// A power with a whole positive exponent, by polynomials and products.
    fn whole_power(&mut self, base: Line, exponent: usize) -> Line {
        match exponent {
            1 => base,
            2..=LARGEST => self.monomial(base, exponent),
            _ if exponent.is_multiple_of(2) => {
                let half = self.whole_power(base, exponent / 2);
                self.monomial(half, 2)
            }
            _ => {
                let rest = self.whole_power(base.clone(), exponent - 1);
                self.step(Operation::Product, [rest, base])
            }
        }
    }

    fn monomial(&mut self, base: Line, exponent: usize) -> Line {
        let mut coefficients = [0.0; POWERS];
        coefficients[exponent - 2] = 1.0;
        self.step(Operation::Polynomial(Polynomial { coefficients }), [base, Line::default()])
    }

    fn function(&mut self, function: Function, argument: Line) -> Result<Line, String> {
        if let Some(own) = argument.constant(self.values.len()) {
            let (value, slope) = function.along(own.value);
            return finite(own.mapped(value, slope));
        }
        let operation = match function {
            Function::Sqrt => Operation::Power(0.5),
            Function::Exp => Operation::Exponential,
            Function::Ln => Operation::Logarithm,
            Function::Sin => Operation::Sine,
            Function::Cos => Operation::Cosine,
            Function::Tanh => Operation::HyperbolicTangent,
            Function::Atan => Operation::Arctangent,
        };
        Ok(self.step(operation, [argument, Line::default()]))
    }

    /// The value of an operation; an operation that is known has one value.
    fn step(&mut self, operation: Operation, arguments: [Line; 2]) -> Line {
        let step = Step { operation, arguments };
        let place = self.steps.iter().position(|own| *own == step).unwrap_or_else(|| {
            self.steps.push(step);
            self.steps.len() - 1
        });
        Line::of(Atom::Step(place), self.number(1.0))
    }
}

/// A constant as a line, if it is finite.
fn finite(own: Coefficient) -> Result<Line, String> {
    if own.value.is_finite() && own.by.iter().all(|x| x.is_finite()) {
        return Ok(Line::of(Atom::One, own));
    }
    Err("has a part without `e` and `rate` that is not finite".into())
}
