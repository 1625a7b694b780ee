//! Flights of a state and its derivatives under curved forces (docs/assembly-law.md, section 20).

use super::columns::Columns;
use super::curved::CurvesInMode;
use super::mode::VariedMode;
use crate::curved::{CurveSeries, Polynomial};
use crate::flow::{CURVE_OVERFLOW, CURVE_REACH, CurveInMode, LAST_CURVE_ORDER, balance};

/// Size of the last terms relative to the first ones, of the state and of each column.
const LAST: f64 = 1e-18;
/// All powers of an argument are computed, as a coefficient may be 0 and still vary.
const ALL: Polynomial = Polynomial { coefficients: [1.0; 4] };

/// Series of the arguments of the curved forces, and of their derivatives by column.
struct Arguments {
    own: Vec<CurveSeries>,
    /// Coefficients of φ' by force and order.
    slopes: Vec<Vec<f64>>,
    /// Coefficients of the derivative of the argument, by force, column and order.
    by: Vec<Vec<Vec<f64>>>,
}

impl VariedMode {
    /// Carries a state and its derivatives over a time under curved forces. The time must be within
    /// the motion's: a state that reaches the end of its motion stays there.
    pub(super) fn carry_curved(&self, z: &mut Columns, time: f64) {
        let mut left = time;
        while left > 0.0 {
            let span = self.curved_series(z, left);
            if span == 0.0 {
                break;
            }
            left = if span >= left { 0.0 } else { left - span };
        }
    }

    /// Carries a state and its derivatives along one series; returns the time.
    fn curved_series(&self, z: &mut Columns, most: f64) -> f64 {
        let state = z.state();
        let (faster, rate) = balance(self.curves.rate, &self.curves.forces, state.as_slice());
        let mut span = most.min(CURVE_REACH / rate);
        let terms = loop {
            let terms = self.curved_terms(z, span);
            if span < f64::MIN_POSITIVE || terms[LAST_CURVE_ORDER].iter().all(|x| x.is_finite()) {
                break terms;
            }
            span *= CURVE_OVERFLOW;
        };
        let part = self.part(&terms, z.width, faster).min(1.0);
        z.numbers.copy_from_slice(&terms[LAST_CURVE_ORDER]);
        for term in terms[..LAST_CURVE_ORDER].iter().rev() {
            z.numbers.iter_mut().zip(term).for_each(|(sum, x)| *sum = *sum * part + x);
        }
        part * span
    }

    /// The fraction of a span over which the last terms of the state and of each column are
    /// rounding.
    fn part(&self, terms: &[Vec<f64>], width: usize, faster: f64) -> f64 {
        // In the norm of (A6) the coordinates are comparable; φ follows from the others.
        let CurvesInMode { weights, forces, velocities, .. } = &self.curves;
        let weight = |i: usize| weights[i] / if velocities.contains(&i) { faster } else { 1.0 };
        let size = |k: usize, column: usize| {
            let numbers = terms[k][column..].iter().step_by(width).enumerate();
            let others = numbers.take(weights.len() - forces.len());
            others.fold(0.0f64, |most, (i, x)| most.max((x * weight(i)).abs()))
        };
        let mut part = f64::INFINITY;
        for column in 0..=self.by.len() {
            let first = (0..LAST_CURVE_ORDER / 2).map(|k| size(k, column)).fold(0.0, f64::max);
            for k in [LAST_CURVE_ORDER - 1, LAST_CURVE_ORDER] {
                let last = size(k, column);
                if last > 0.0 && first > 0.0 {
                    part = part.min((LAST * first / last).powf(1.0 / k as f64));
                }
            }
        }
        part
    }

    /// The terms of the series of a state and its derivatives over a span.
    fn curved_terms(&self, z: &Columns, span: f64) -> Vec<Vec<f64>> {
        let (width, count, forces) = (z.width, self.by.len(), &self.curves.forces);
        let mut terms = vec![z.numbers.clone()];
        let mut arguments = Arguments {
            own: vec![CurveSeries::default(); forces.len()],
            slopes: vec![Vec::new(); forces.len()],
            by: vec![vec![Vec::new(); count]; forces.len()],
        };
        for k in 0..=LAST_CURVE_ORDER {
            self.put_curves(&mut terms[k], width, &mut arguments, k);
            if k < LAST_CURVE_ORDER {
                let next = self.next_term(&terms[k], width, span / (k + 1) as f64);
                terms.push(next);
            }
        }
        terms
    }

    /// `factor` times the derivative of a term by time, without the curved forces.
    fn next_term(&self, term: &[f64], width: usize, factor: f64) -> Vec<f64> {
        let (mut next, sources) = (vec![0.0; term.len()], &self.sources.0);
        for (i, to) in next.chunks_exact_mut(width).enumerate() {
            for &(j, x) in self.a.row(i) {
                to.iter_mut().zip(&term[j * width..]).for_each(|(to, own)| *to += factor * x * own);
            }
            for place in sources.row(i) {
                let state = factor * term[sources.entries[place].0 * width];
                let by = &sources.by[place * width..][..width];
                to.iter_mut().zip(by).for_each(|(to, by)| *to += state * by);
            }
        }
        next
    }

    /// Writes the terms of order `k` of the curved forces and of their derivatives.
    fn put_curves(&self, term: &mut [f64], width: usize, arguments: &mut Arguments, k: usize) {
        let dot = |term: &[f64], row: &[(usize, f64)], column: usize| -> f64 {
            row.iter().map(|&(j, x)| x * term[j * width + column]).sum()
        };
        for (i, CurveInMode { curved: own, .. }) in self.curves.forces.iter().enumerate() {
            let series = &mut arguments.own[i];
            series.next(&ALL, k, dot(term, own.argument.terms(), 0));
            let slopes = &mut arguments.slopes[i];
            slopes.push(series.slope(&own.force, k));
            term[own.place * width] = series.at_order(&own.force, k);
            for (p, by) in self.curves.by.iter().enumerate() {
                let by = &by[i];
                let moved = dot(term, by.argument.terms(), 0);
                let steps = &mut arguments.by[i][p];
                steps.push(dot(term, own.argument.terms(), p + 1) + moved);
                let sum: f64 = slopes.iter().zip(steps.iter().rev()).map(|(slope, step)| slope * step).sum();
                term[own.place * width + p + 1] = sum + series.at_order(&by.force, k);
            }
        }
    }
}
