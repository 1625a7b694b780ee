//! Equations of a curve in two parameters: the contact equations, and a condition for the
//! bifurcation or the touch.

use crate::curve::{Equations, Linearization, slope};
use crate::obstacle::Obstacle;
use crate::paper::cycle::{Cycle, Functional};
use crate::paper::family::{ContactEquations, Family};
use crate::paper::grazing::Touching;
use crate::paper::orbit::is_clear;
use crate::paper::system::Anchor;
use crate::stop_word::OrbitWord;
use crate::two_parameters::{Border, LocusEnd, TwoParameters, smallness};
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::PI;

/// Step of the condition's differences. It affects the speed of convergence, not the result.
const DIFFERENCE: f64 = 1e-6;

/// Condition that holds along a curve.
#[derive(Clone, Debug)]
pub(crate) enum Condition {
    /// A multiplier ±1: the factor of closing variations, and the borders.
    Real(f64, Border<f64>),
    /// A pair of multipliers on the unit circle, whose angle is one of the unknowns.
    Complex(Border<Complex<f64>>),
    /// An impact at zero speed.
    Touch(usize),
}

/// Equations of a curve. A point contains the phases, the angle of the multipliers if it is an
/// unknown, and the two parameters.
#[derive(Clone)]
pub(crate) struct Locus<'a> {
    pub family: &'a Family,
    pub word: &'a OrbitWord,
    pub condition: Condition,
}

impl Locus<'_> {
    pub fn n(&self) -> usize {
        self.word.len()
    }

    /// The angle of the multipliers at a point of a curve of Neimark-Sacker points, rad.
    pub fn angle(&self, u: &DVector<f64>) -> Option<f64> {
        matches!(self.condition, Condition::Complex(_)).then(|| u[self.n()])
    }

    /// Values of a bifurcation's condition at a point, in a machine with a given anchor.
    fn tests(&self, u: &DVector<f64>, anchor: Option<Anchor>) -> Result<Vec<f64>, Obstacle> {
        let system = self.family.system_at(u)?.anchored(anchor);
        let cycle = Cycle::new(&system, self.word, &u.as_slice()[..self.n()])?;
        let found = match &self.condition {
            Condition::Real(factor, border) => {
                let matrix = cycle.derivative(Functional::Gap, *factor).ok_or(Obstacle::Singular)?;
                smallness(&matrix, border).map(|g| vec![g])
            }
            Condition::Complex(border) => {
                let matrix = cycle.complex_derivative(Complex::cis(u[self.n()])).ok_or(Obstacle::Singular)?;
                smallness(&matrix, border).map(|g| vec![g.re, g.im])
            }
            Condition::Touch(_) => Some(Vec::new()),
        };
        found.filter(|f| f.iter().all(|x| x.is_finite())).ok_or(Obstacle::NoConvergence)
    }

    /// The condition with its borders adapted to a point.
    pub fn adapted(&self, u: &DVector<f64>) -> Result<Condition, Obstacle> {
        let system = self.family.system_at(u)?;
        let cycle = Cycle::new(&system, self.word, &u.as_slice()[..self.n()])?;
        let adapted = match &self.condition {
            Condition::Real(factor, own) => {
                let matrix = cycle.derivative(Functional::Gap, *factor);
                matrix.and_then(Border::of).map(|border| Condition::Real(*factor, border.aligned(own)))
            }
            Condition::Complex(_) => {
                let matrix = cycle.complex_derivative(Complex::cis(u[self.n()]));
                matrix.and_then(Border::of).map(Condition::Complex)
            }
            Condition::Touch(index) => Some(Condition::Touch(*index)),
        };
        adapted.ok_or(Obstacle::NoConvergence)
    }
}

impl Equations for Locus<'_> {
    fn linearize(&self, u: &DVector<f64>, known: Option<&DMatrix<f64>>) -> Result<Linearization, Obstacle> {
        let (n, columns) = (self.n(), u.len());
        if let Condition::Touch(index) = self.condition {
            let contacts = ContactEquations { family: self.family, word: self.word };
            return Touching { contacts, index }.linearize(u, known);
        }
        let system = self.family.system_at(u)?;
        let cycle = Cycle::new(&system, self.word, &u.as_slice()[..n])?;
        let mut matrix = DMatrix::zeros(columns - 1, columns);
        let mut value = DVector::zeros(columns - 1);
        value.rows_mut(0, n).copy_from(&cycle.residual_vector());
        let by_phases = cycle.derivative(Functional::Gap, 1.0).ok_or(Obstacle::Singular)?;
        matrix.view_mut((0, 0), (n, n)).copy_from(&by_phases);
        let by_parameters = self.family.by_parameters(u, &cycle, |c| c.residual.clone())?;
        for (k, column) in by_parameters.iter().enumerate() {
            matrix.view_mut((0, columns - 2 + k), (n, 1)).copy_from(column);
        }
        let tests = self.tests(u, system.anchor())?;
        tests.iter().enumerate().for_each(|(i, test)| value[n + i] = *test);
        if let Some(known) = known {
            let rows = columns - 1 - n;
            matrix.rows_mut(n, rows).copy_from(&known.rows(n, rows));
            return Ok(Linearization { value, matrix });
        }
        for k in 0..columns {
            let at = |by: f64| {
                let mut moved = u.clone();
                moved[k] += by;
                self.tests(&moved, system.anchor())
            };
            let column = slope(DIFFERENCE, at)?;
            matrix.view_mut((n, k), (column.len(), 1)).copy_from(&column);
        }
        Ok(Linearization { value, matrix })
    }
}

impl TwoParameters for Locus<'_> {
    fn range(&self, k: usize) -> (f64, f64) {
        let span = &self.family.spans()[k];
        (span.from / span.unit(), span.to / span.unit())
    }

    fn is_orbit(&self, u: &DVector<f64>) -> Result<bool, Obstacle> {
        let system = self.family.system_at(u)?;
        let cycle = Cycle::new(&system, self.word, &u.as_slice()[..self.n()])?;
        let exempt = |i: usize| matches!(self.condition, Condition::Touch(index) if index == i);
        Ok((0..self.n()).all(|i| exempt(i) || cycle.speed(i) > 0.0) && is_clear(&cycle))
    }

    fn adapt(&mut self, u: &DVector<f64>) {
        if let Ok(condition) = self.adapted(u) {
            self.condition = condition;
        }
    }

    fn passed(&self, u: &DVector<f64>) -> Option<LocusEnd> {
        let angle = self.angle(u)?;
        let is_inside = (0.0..PI).contains(&angle);
        (!is_inside).then_some(LocusEnd::Resonance(if angle < 0.0 { 1 } else { -1 }))
    }

    fn near_end(&self, u: &DVector<f64>) -> Option<LocusEnd> {
        LocusEnd::resonance(self.angle(u)?)
    }

    fn products(&self, u: &DVector<f64>) -> Option<[f64; 2]> {
        let Condition::Real(factor, own) = &self.condition else { return None };
        let system = self.family.system_at(u).ok().filter(|_| *factor > 0.0)?;
        let cycle = Cycle::new(&system, self.word, &u.as_slice()[..self.n()]).ok()?;
        let left = cycle.derivative(Functional::Gap, 1.0).and_then(Border::of)?.aligned(own).left;
        let columns = self.family.by_parameters(u, &cycle, |c| c.residual.clone()).ok()?;
        let [first, second] = &columns[..] else { return None };
        Some([left.dot(first), left.dot(second)])
    }
}
