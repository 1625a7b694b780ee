//! Equations of a curve over two parameters: the orbit's equations, and a condition for the
//! special point.

use super::super::conditions;
use super::super::crossing;
use super::super::cycle::Cycle;
use super::super::orbit::Orbit;
use super::super::place::{Family, Place};
use super::super::position::doubling;
use super::super::problem::{Problem, Residual};
use crate::curve::{Equations, Linearization, slope};
use crate::label::Label;
use crate::obstacle::Obstacle;
use crate::test_functions::{SignedLog, is_on_circle, pair_test};
use crate::two_parameters::{Border, Located, LocusEnd, LocusPoint, TwoParameters, smallness};
use nalgebra::{Complex, DMatrix, DVector};
use std::sync::Arc;

/// Step of the condition's differences. It affects the speed of convergence, not the result.
const DIFFERENCE: f64 = 1e-6;
/// Value of a further condition below which the end of a curve is a touch of this condition.
const TOUCHES: f64 = 1e-4;
/// Tolerance for the extent of a single-point curve, as a fraction of the ranges.
const POINT: f64 = 1e-4;
/// Tolerance for a further condition that is zero along a curve, such as the second touch of a
/// symmetric orbit.
const TWIN: f64 = 1e-8;
/// Tolerance for the unfolding of a crossing, in units of the equations: rounding.
const KEPT: f64 = 1e-7;

/// Condition that holds along a curve.
#[derive(Clone, Debug)]
pub(super) enum Condition {
    /// The equations are singular.
    Fold(Border<f64>),
    /// The equations, with the parameter's column, are singular up to a multiple of the border's
    /// left vector, which unfolds them (G. Moore, The numerical treatment of non-trivial
    /// bifurcation points, 1980). The multiple is an unknown. It is 0 if the two parameters keep
    /// the crossing, as for a symmetric orbit.
    Crossing(Border<f64>),
    /// A multiplier -1: the equations are singular for variations that change sign.
    Doubling(Border<f64>),
    /// A pair of multipliers with the product 1.
    Pair,
    /// A condition of the orbit that is just about to fail.
    Touch(conditions::Condition),
}

impl Condition {
    /// The condition of a bifurcation at a point.
    pub fn of(label: Label, problem: &Problem, u: &DVector<f64>) -> Result<Self, Obstacle> {
        let border = || {
            let matrix = problem.residual(&problem.place(u)?, u, true)?.matrix;
            matrix.and_then(Border::of).ok_or(Obstacle::NoConvergence)
        };
        Ok(match label {
            Label::Fold => Self::Fold(border()?),
            Label::BranchPoint => Self::Crossing(border()?),
            Label::PeriodDoubling => Self::Doubling(antiperiodic(problem, u)?),
            _ => Self::Pair,
        })
    }

    /// Values of the condition at an orbit: two for a crossing, otherwise one.
    pub fn tests(&self, problem: &Problem, place: Place, u: &DVector<f64>) -> Result<Vec<f64>, Obstacle> {
        let found = match self {
            Self::Pair => {
                let test = pair_test(Orbit::at(problem.clone(), place, u.clone())?.multipliers());
                Some(vec![test.relative_to(SignedLog { sign: 1.0, log: 0.0 })])
            }
            Self::Touch(condition) => {
                let cycle = problem.cycle(&place, u)?;
                cycle.value_of(*condition, &place, &problem.word).map(|value| vec![value])
            }
            Self::Fold(border) | Self::Doubling(border) | Self::Crossing(border) => {
                let Residual { matrix, cycle, .. } = problem.residual(&place, u, true)?;
                let matrix = matrix.ok_or(Obstacle::NoConvergence)?;
                match self {
                    Self::Crossing(_) => {
                        let column = problem.by_parameter((&place, u), &cycle, &matrix)?;
                        crossing::conditions(&matrix, &column, border)
                    }
                    Self::Doubling(_) => {
                        let turned = problem.antiperiodic(&place, &cycle, &matrix);
                        smallness(&turned, border).map(|g| vec![g])
                    }
                    _ => smallness(&matrix, border).map(|g| vec![g]),
                }
            }
        };
        found.filter(|f| f.iter().all(|x| x.is_finite())).ok_or(Obstacle::NoConvergence)
    }
}

/// The border of the equations for variations that change sign over the period.
fn antiperiodic(problem: &Problem, u: &DVector<f64>) -> Result<Border<f64>, Obstacle> {
    let place = problem.place(u)?;
    let Residual { matrix, cycle, .. } = problem.residual(&place, u, true)?;
    let turned = matrix.map(|matrix| problem.antiperiodic(&place, &cycle, &matrix));
    turned.and_then(Border::of).ok_or(Obstacle::NoConvergence)
}

/// Equations of a curve. A point contains the orbit's unknowns without the parameter, the
/// unfolding of a crossing, and the two parameters.
#[derive(Clone)]
pub(super) struct Locus {
    families: [Family; 2],
    problem: Problem,
    condition: Condition,
    /// Further conditions that are zero along the curve.
    twins: Vec<conditions::Condition>,
}

/// The machine and the orbit's equations at a point of a curve, over each parameter.
struct At {
    place: Place,
    problems: [Problem; 2],
    points: [DVector<f64>; 2],
}

impl Locus {
    pub fn new(families: [Family; 2], problem: Problem, condition: Condition) -> Self {
        Self { families, problem, condition, twins: Vec::new() }
    }

    /// The curve with the further conditions that are zero at its start.
    pub fn with_twins(self, w: &DVector<f64>) -> Result<Self, Obstacle> {
        let orbit = self.orbit(w)?;
        let is_twin = |(condition, value): &&(conditions::Condition, f64)| {
            // `Together` has a scale of its own.
            let is_together = matches!(condition, conditions::Condition::Together { .. });
            value.abs() < TWIN && !is_together && !self.is_own(condition)
        };
        let of_touch = matches!(self.condition, Condition::Touch(_)).then(|| orbit.conditions());
        let twins = of_touch.unwrap_or_default().iter().filter(is_twin).map(|at| at.0).collect();
        Ok(Self { twins, ..self })
    }

    fn n(&self) -> usize {
        self.problem.size()
    }

    /// Whether a condition is the touch that defines the curve.
    fn is_own(&self, condition: &conditions::Condition) -> bool {
        matches!(&self.condition, Condition::Touch(own) if own == condition)
    }

    fn unfolds(&self) -> bool {
        matches!(self.condition, Condition::Crossing(_))
    }

    /// Whether a curve of crossings is so short that only rounding keeps its crossing.
    pub fn is_point(&self, curve: &[Located]) -> bool {
        let part = |k: usize| {
            let (from, to) = TwoParameters::range(self, k);
            let all = curve.iter().map(|(w, _)| w[w.len() - 2 + k]);
            let ends = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
            (ends.1 - ends.0) / (to - from)
        };
        self.unfolds() && part(0).max(part(1)) < POINT
    }

    /// The point of an orbit at a value of the second parameter.
    pub fn point(&self, u: &DVector<f64>, second: f64) -> DVector<f64> {
        let n = self.n();
        let unfolding = self.unfolds().then_some(0.0);
        let parameters = [u[n], second / self.families[1].unit()];
        let all = u.as_slice()[..n].iter().copied().chain(unfolding).chain(parameters);
        DVector::from_vec(all.collect())
    }

    /// Both parameters at a point, SI.
    fn values(&self, w: &DVector<f64>) -> [f64; 2] {
        let last = w.len() - 1;
        [w[last - 1] * self.families[0].unit(), w[last] * self.families[1].unit()]
    }

    fn at(&self, w: &DVector<f64>) -> Result<At, Obstacle> {
        let values = self.values(w);
        let over = |k: usize| -> Result<Problem, Obstacle> {
            let machine = self.families[1 - k].at(values[1 - k])?;
            let family = Arc::new(Family { machine, ..self.families[k].clone() });
            Ok(Problem { family, ..self.problem.clone() })
        };
        let problems = [over(0)?, over(1)?];
        let place = problems[0].family.place(values[0])?;
        let own = &w.as_slice()[..self.n()];
        let point = |k: usize| {
            let parameter = values[k] / self.families[k].unit();
            DVector::from_iterator(self.n() + 1, own.iter().copied().chain([parameter]))
        };
        Ok(At { place, problems, points: [point(0), point(1)] })
    }

    /// The orbit of a point.
    fn orbit(&self, w: &DVector<f64>) -> Result<Orbit, Obstacle> {
        let At { place, problems: [problem, _], points: [u, _] } = self.at(w)?;
        Orbit::at(problem, place, u)
    }

    /// The point in SI units, for users of the curve.
    pub fn seen(&self, w: &DVector<f64>, end: Option<LocusEnd>) -> Result<LocusPoint, Obstacle> {
        let orbit = self.orbit(w)?;
        let angle = matches!(self.condition, Condition::Pair).then(|| angle(orbit.multipliers())).flatten();
        // Converted values may exceed the bounds by rounding.
        let values = [0, 1].map(|k| {
            let (from, to) = self.families[k].range;
            self.values(w)[k].clamp(from, to)
        });
        Ok(LocusPoint { values, period: orbit.period(), phases: Vec::new(), angle, end })
    }

    /// Values of the condition at a point.
    fn tests(&self, w: &DVector<f64>) -> Result<Vec<f64>, Obstacle> {
        let At { place, problems: [problem, _], points: [u, _] } = self.at(w)?;
        self.condition.tests(&problem, place, &u)
    }

    /// The derivatives with respect to both parameters.
    fn columns(&self, at: &At, cycle: &Cycle, matrix: &DMatrix<f64>) -> Result<[DVector<f64>; 2], Obstacle> {
        let column = |k: usize| at.problems[k].by_parameter((&at.place, &at.points[k]), cycle, matrix);
        Ok([column(0)?, column(1)?])
    }
}

/// Product of one factor per multiplier; it is zero only at the multiplier 1.
fn unit(multipliers: &[Complex<f64>]) -> f64 {
    doubling(&multipliers.iter().map(|m| -m).collect::<Vec<_>>())
}

/// The multipliers except the one nearest to a number.
fn without_nearest(multipliers: &[Complex<f64>], to: f64) -> Vec<Complex<f64>> {
    let off = |k: &usize| (multipliers[*k] - to).norm();
    let nearest = (0..multipliers.len()).min_by(|a, b| off(a).total_cmp(&off(b)));
    let others = (0..multipliers.len()).filter(|k| Some(*k) != nearest);
    others.map(|k| multipliers[k]).collect()
}

/// The sum of the pair of multipliers whose product is nearest to 1.
fn sum_of_pair(multipliers: &[Complex<f64>]) -> Option<f64> {
    let pairs = multipliers.iter().enumerate().flat_map(|(i, a)| {
        let later = multipliers.iter().skip(i + 1);
        later.map(move |b| ((a * b - 1.0).norm(), (a + b).re))
    });
    pairs.min_by(|a, b| a.0.total_cmp(&b.0)).map(|pair| pair.1)
}

/// The angle, rad, of the complex pair nearest to the unit circle.
fn angle(multipliers: &[Complex<f64>]) -> Option<f64> {
    let pairs = multipliers.iter().filter(|m| m.im > 0.0);
    let off = |m: &Complex<f64>| (m.norm() - 1.0).abs();
    pairs.min_by(|a, b| off(a).total_cmp(&off(b))).map(|m| m.arg())
}

impl Equations for Locus {
    fn linearize(&self, w: &DVector<f64>, known: Option<&DMatrix<f64>>) -> Result<Linearization, Obstacle> {
        let (n, columns) = (self.n(), w.len());
        let at = self.at(w)?;
        let Residual { value, matrix, cycle } = at.problems[0].residual(&at.place, &at.points[0], true)?;
        let by_unknowns = matrix.ok_or(Obstacle::NoConvergence)?;
        let mut whole = DMatrix::zeros(columns - 1, columns);
        whole.view_mut((0, 0), (n, n)).copy_from(&by_unknowns);
        let mut all = DVector::zeros(columns - 1);
        all.rows_mut(0, n).copy_from(&value);
        if let Condition::Crossing(border) = &self.condition {
            all.rows_mut(0, n).axpy(w[n], &border.left, 1.0);
            whole.view_mut((0, n), (n, 1)).copy_from(&border.left);
        }
        self.tests(w)?.iter().enumerate().for_each(|(i, test)| all[n + i] = *test);
        if let Some(known) = known {
            let rows = columns - 1 - n;
            whole.view_mut((0, columns - 2), (n, 2)).copy_from(&known.view((0, columns - 2), (n, 2)));
            whole.rows_mut(n, rows).copy_from(&known.rows(n, rows));
            return Ok(Linearization { value: all, matrix: whole });
        }
        for (k, column) in self.columns(&at, &cycle, &by_unknowns)?.iter().enumerate() {
            whole.view_mut((0, columns - 2 + k), (n, 1)).copy_from(column);
        }
        for k in (0..columns).filter(|k| *k != n || !self.unfolds()) {
            let moved = |by: f64| {
                let mut moved = w.clone();
                moved[k] += by;
                self.tests(&moved)
            };
            let column = slope(DIFFERENCE, moved)?;
            whole.view_mut((n, k), (column.len(), 1)).copy_from(&column);
        }
        Ok(Linearization { value: all, matrix: whole })
    }

    fn rounding(&self) -> f64 {
        self.problem.rounding()
    }

    fn stalled(&self) -> f64 {
        self.problem.stalled()
    }
}

impl TwoParameters for Locus {
    fn range(&self, k: usize) -> (f64, f64) {
        let family = &self.families[k];
        (family.range.0 / family.unit(), family.range.1 / family.unit())
    }

    fn is_orbit(&self, w: &DVector<f64>) -> Result<bool, Obstacle> {
        let orbit = self.orbit(w)?;
        let is_kept = !self.unfolds() || w[self.n()].abs() < KEPT;
        let holds = |(condition, value): &(conditions::Condition, f64)| {
            self.is_own(condition)
                || !condition.fails(*value)
                || (self.twins.contains(condition) && *value > -TWIN)
        };
        Ok(is_kept && orbit.conditions().iter().all(holds))
    }

    fn adapt(&mut self, w: &DVector<f64>) {
        let Ok(At { place, problems: [problem, _], points: [u, _] }) = self.at(w) else { return };
        let border = || problem.residual(&place, &u, true).ok()?.matrix.and_then(Border::of);
        let adapted = match &self.condition {
            Condition::Fold(own) => border().map(|border| Condition::Fold(border.aligned(own))),
            Condition::Crossing(own) => border().map(|border| Condition::Crossing(border.aligned(own))),
            Condition::Doubling(own) => {
                antiperiodic(&problem, &u).ok().map(|border| Condition::Doubling(border.aligned(own)))
            }
            Condition::Pair | Condition::Touch(_) => None,
        };
        if let Some(adapted) = adapted {
            self.condition = adapted;
        }
    }

    fn passed(&self, w: &DVector<f64>) -> Option<LocusEnd> {
        if !matches!(self.condition, Condition::Pair) {
            return None;
        }
        // Beyond a resonance the pair consists of two real reciprocal multipliers.
        let orbit = self.orbit(w).ok()?;
        if is_on_circle(orbit.multipliers()) {
            return None;
        }
        let largest = orbit.multipliers().iter().filter(|m| m.im == 0.0).map(|m| m.re);
        let sum: f64 = largest.fold(0.0, |most, re| if re.abs() > f64::abs(most) { re } else { most });
        Some(LocusEnd::Resonance(if sum < 0.0 { -1 } else { 1 }))
    }

    fn near_end(&self, w: &DVector<f64>) -> Option<LocusEnd> {
        let orbit = self.orbit(w).ok()?;
        let touches = |(condition, value): &(conditions::Condition, f64)| match condition {
            conditions::Condition::Together { .. } => false,
            // Near a touch the speed of an impact is a square root of the distance from it.
            conditions::Condition::Rises { .. } => *value < TOUCHES.sqrt(),
            _ => *value < TOUCHES,
        };
        let is_other = |condition| !self.is_own(condition) && !self.twins.contains(condition);
        if orbit.conditions().iter().any(|at| is_other(&at.0) && touches(at)) {
            return Some(LocusEnd::Touch);
        }
        matches!(self.condition, Condition::Pair)
            .then(|| angle(orbit.multipliers()))
            .flatten()
            .and_then(LocusEnd::resonance)
    }

    fn products(&self, w: &DVector<f64>) -> Option<[f64; 2]> {
        let Condition::Fold(own) = &self.condition else { return None };
        let at = self.at(w).ok()?;
        let Residual { matrix, cycle, .. } = at.problems[0].residual(&at.place, &at.points[0], true).ok()?;
        let matrix = matrix?;
        let columns = self.columns(&at, &cycle, &matrix).ok()?;
        let left = Border::of(matrix)?.aligned(own).left;
        Some(columns.map(|column| left.dot(&column)))
    }

    fn tests_on_curve(&self, w: &DVector<f64>) -> Vec<(LocusEnd, f64)> {
        let [one, minus] = [1, -1].map(LocusEnd::Resonance);
        let Ok(orbit) = self.orbit(w) else { return Vec::new() };
        let multipliers = orbit.multipliers();
        match self.condition {
            Condition::Fold(_) => {
                let others = without_nearest(multipliers, 1.0);
                vec![(LocusEnd::FoldFlip, doubling(multipliers)), (one, unit(&others))]
            }
            Condition::Doubling(_) => {
                let others = without_nearest(multipliers, -1.0);
                vec![(LocusEnd::FoldFlip, unit(multipliers)), (minus, doubling(&others))]
            }
            Condition::Pair => {
                let sum = sum_of_pair(multipliers);
                sum.map_or(Vec::new(), |sum| vec![(one, sum - 2.0), (minus, sum + 2.0)])
            }
            Condition::Crossing(_) | Condition::Touch(_) => Vec::new(),
        }
    }

    fn ends_at(&self, mark: LocusEnd) -> bool {
        let is_resonance = matches!(mark, LocusEnd::Resonance(_));
        mark == LocusEnd::FoldPitchfork || (is_resonance && matches!(self.condition, Condition::Pair))
    }
}
