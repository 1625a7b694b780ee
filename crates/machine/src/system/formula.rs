//! Formulas in the forces of springs: rows of their operations.

use crate::formula::{Atom, Compiled, Formula, Line, potential};
use crate::functional::Functional;

/// A formula in the force of a spring.
#[derive(Clone, Debug)]
pub(crate) struct FormulaRows {
    /// The formula.
    pub formula: Formula,
    /// Its operations.
    pub compiled: Compiled,
    /// Places of the operations.
    pub operations: Operations,
    /// The part of the force that dissipates: φ(e, e') - φ(e, 0).
    pub lossy: Functional,
    /// Elongation at which the stored energy is 0.
    pub from: f64,
}

impl FormulaRows {
    /// Whether the force depends on the rate, or on the elongation.
    pub fn acts(&self, of_rate: bool) -> bool {
        if of_rate { self.formula.depends_on_rate() } else { self.formula.depends_on_elongation() }
    }

    /// The stored energy at an elongation, J.
    pub fn stored(&self, e: f64) -> f64 {
        if self.formula.depends_on_elongation() {
            potential(&self.formula, self.from, e)
        } else {
            self.formula.value(0.0, 0.0).unwrap_or(0.0) * (e - self.from)
        }
    }
}

/// Places of a formula's operations in the augmented state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Operations {
    /// Index of the constant 1.
    pub one: usize,
    /// Place of the first operation.
    pub first: usize,
}

/// The numbers of a line.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Numbers<'a> {
    /// Their values.
    Values,
    /// Their derivatives, given the derivatives of the formula's parameters.
    Along(&'a [f64]),
}

impl Operations {
    /// The row of a line, given the rows of e and e'.
    pub fn row(&self, line: &Line, e: &Functional, rate: &Functional, numbers: Numbers) -> Functional {
        let size = e.len();
        let unit = |place: usize| Functional::unit(size, place, 1.0);
        let rows: Vec<(f64, Functional)> = line
            .0
            .iter()
            .map(|(atom, own)| {
                let number = match numbers {
                    Numbers::Values => own.value,
                    Numbers::Along(parameters) => own.along(parameters),
                };
                let row = match atom {
                    Atom::One => unit(self.one),
                    Atom::Elongation => e.clone(),
                    Atom::Rate => rate.clone(),
                    Atom::Step(i) => unit(self.first + i),
                };
                (number, row)
            })
            .collect();
        Functional::sum(size, rows.iter().map(|own| (own.0, &own.1)))
    }

    /// The derivative of the row of a line, given the derivatives of the rows of e and e' and of
    /// the formula's parameters.
    pub fn row_by(
        &self,
        line: &Line,
        [e, rate]: [&Functional; 2],
        [de, drate]: [&Functional; 2],
        parameters: &[f64],
    ) -> Functional {
        let numbers = self.row(line, e, rate, Numbers::Along(parameters));
        let fixed = |own: &&(Atom, _)| matches!(own.0, Atom::Elongation | Atom::Rate);
        let moving = Line(line.0.iter().filter(fixed).cloned().collect());
        &numbers + &self.row(&moving, de, drate, Numbers::Values)
    }
}

/// Elongation at which the stored energy of a formula is 0: e = 0, or the start if the force is not
/// defined between them.
pub(super) fn reference(compiled: &Compiled, start: f64) -> f64 {
    let is_defined = |k: u32| compiled.undefined(f64::from(k) / f64::from(POINTS) * start, 0.0).is_none();
    let signs = |k: u32| compiled.signs(f64::from(k) / f64::from(POINTS) * start);
    let same = (0..=POINTS).all(|k| is_defined(k) && signs(k) == signs(POINTS));
    if same || !start.is_finite() { 0.0 } else { start }
}

/// Number of intervals from 0 to the start for the check of a formula's domain.
const POINTS: u32 = 64;
