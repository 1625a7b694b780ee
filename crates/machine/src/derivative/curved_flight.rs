//! Flights of a state and its derivatives under curved forces (docs/assembly-law.md, section 20).

use super::columns::Columns;
use super::curved::CurvesInMode;
use super::mode::VariedMode;
use crate::curved::{CurveSeries, Operation, Piece};
use crate::flow::{
    AtState, CURVE_REACH, CurveInMode, GroupNorms, LAST_CURVE_ORDER, part, part_at_edges, part_from_edges,
    part_to_edge, rate_at, shortened, sides_ahead,
};

/// Size of the last terms relative to the first ones, of the state and of each column.
const LAST: f64 = 1e-18;

/// Series of the arguments of the curved forces, and of their derivatives by column.
struct Arguments {
    own: Vec<CurveSeries>,
    /// Coefficients of the derivatives by the arguments, by force and order.
    slopes: Vec<Vec<[f64; 2]>>,
    /// Coefficients of the derivatives of the arguments, by force, column and order.
    by: Vec<Vec<Vec<[f64; 2]>>>,
}

/// Power series of a state and its derivatives, in the fraction of a span.
pub(super) struct CurvedSeries {
    terms: Vec<Vec<f64>>,
    /// Span over which the coefficients were computed, s.
    span: f64,
    /// Fraction of the span over which the omitted terms are rounding.
    pub part: f64,
}

impl CurvedSeries {
    /// The time that the series covers, s.
    pub fn time(&self) -> f64 {
        self.part * self.span
    }

    /// Writes the state and its derivatives after the fraction `part` of the span; returns the
    /// time, s.
    pub fn at(&self, part: f64, to: &mut Columns) -> f64 {
        to.numbers.copy_from_slice(&self.terms[LAST_CURVE_ORDER]);
        for term in self.terms[..LAST_CURVE_ORDER].iter().rev() {
            to.numbers.iter_mut().zip(term).for_each(|(sum, x)| *sum = *sum * part + x);
        }
        part * self.span
    }

    /// Coefficients of the slope of a functional of the state, by the fraction of the span.
    pub fn slope(&self, row: &[f64], width: usize) -> [f64; LAST_CURVE_ORDER] {
        std::array::from_fn(|k| {
            let state = self.terms[k + 1].iter().step_by(width);
            (k + 1) as f64 * row.iter().zip(state).map(|(a, x)| a * x).sum::<f64>()
        })
    }
}

impl VariedMode {
    /// Whether the mode has curved forces.
    pub(super) fn is_curved(&self) -> bool {
        !self.curves.is_empty()
    }

    /// Carries a state and its derivatives over a time under curved forces. The time must be within
    /// the motion's: a state that reaches the end of its motion stays there.
    pub(super) fn carry_curved(&self, z: &mut Columns, time: f64) {
        self.along_curves(z, time, &mut |_, _| ());
    }

    /// [`carry_curved`](Self::carry_curved), and passes each series to `visit`, with the time before
    /// it.
    pub(super) fn along_curves(&self, z: &mut Columns, time: f64, visit: &mut dyn FnMut(&CurvedSeries, f64)) {
        let mut left = time;
        while left > 0.0 {
            let series = self.curved_series(z, left);
            let span = series.time();
            if span == 0.0 {
                break;
            }
            visit(&series, time - left);
            series.at(series.part, z);
            left = if span >= left { 0.0 } else { left - span };
        }
    }

    /// The series of a state and its derivatives over a time of at most `most`.
    fn curved_series(&self, z: &Columns, most: f64) -> CurvedSeries {
        let (state, forces) = (z.state(), &self.curves.forces);
        let rate = rate_at(self.curves.rate, forces, state.as_slice());
        let rates = self.a.rows_times(0..state.len(), state.as_slice());
        let at = AtState {
            z: state.as_slice(),
            rates: rates.as_slice(),
            weights: &self.curves.weights,
            one: self.curves.one,
            rate: self.curves.rate,
            // Only states and their derivatives are carried.
            watched: &[],
        };
        let (sides, to_edge) = sides_ahead(forces, &at);
        let mut span = most.min(CURVE_REACH / rate).min(to_edge);
        let (terms, own) = loop {
            let (terms, own) = self.curved_terms(z, span, &sides);
            let is_finite = terms[LAST_CURVE_ORDER].iter().all(|x| x.is_finite());
            match shortened(span, is_finite, &self.group_norms(&terms, z.width, 0), 0) {
                Some(shorter) => span = shorter,
                None => break (terms, own),
            }
        };
        let parts = (0..=self.by.len()).map(|column| part(&self.group_norms(&terms, z.width, column), LAST));
        let part = parts.fold(1.0, f64::min);
        let groups = self.group_norms(&terms, z.width, 0);
        let norms = std::array::from_fn(|k| groups[k].into_iter().fold(0.0, f64::max));
        let part = part_at_edges(forces, &own, (part, span), (at.z, norms));
        let part = part_from_edges(forces, &own, part);
        CurvedSeries { part: part_to_edge(forces, &own, part, false), terms, span }
    }

    /// The norms of (A6) of the terms of a column, by group. Column 0 is the state.
    fn group_norms(&self, terms: &[Vec<f64>], width: usize, column: usize) -> Vec<GroupNorms> {
        let CurvesInMode { weights, coordinates: n, one, .. } = &self.curves;
        let norm = |term: &[f64], from: usize, to: usize| {
            (from..to).fold(0.0f64, |most, i| most.max((term[i * width + column] * weights[i]).abs()))
        };
        let of_term = |term: &Vec<f64>| [norm(term, 0, *n), norm(term, *n, 2 * n), norm(term, 2 * n, *one)];
        terms.iter().map(of_term).collect()
    }

    /// The terms of the series of a state and its derivatives over a span, and the series of the
    /// curved forces, which begin on these sides of their edges.
    fn curved_terms(&self, z: &Columns, span: f64, sides: &[Piece]) -> (Vec<Vec<f64>>, Vec<CurveSeries>) {
        let (width, count, forces) = (z.width, self.by.len(), &self.curves.forces);
        let mut terms = vec![z.numbers.clone()];
        let mut arguments = Arguments {
            own: sides.iter().map(|&side| CurveSeries::beginning(side)).collect(),
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
        (terms, arguments.own)
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
            let (series, is_of_two) = (&mut arguments.own[i], own.operation.is_of_two());
            let rows = [own.argument.terms(), own.second.terms()];
            let value = series.next_of_all(&own.operation, k, rows.map(|row| dot(term, row, 0)));
            let slopes = &mut arguments.slopes[i];
            slopes.push(series.slopes(&own.operation, k));
            term[own.place * width] = value;
            for (p, by) in self.curves.by.iter().enumerate() {
                let by = &by[i];
                let moved = by.arguments.each_ref().map(|row| dot(term, row.terms(), 0));
                let steps = &mut arguments.by[i][p];
                steps.push(std::array::from_fn(|j| dot(term, rows[j], p + 1) + moved[j]));
                let along = |j: usize| -> f64 {
                    slopes.iter().zip(steps.iter().rev()).map(|(slope, step)| slope[j] * step[j]).sum()
                };
                let mut sum = along(0);
                if is_of_two {
                    sum += along(1);
                }
                if let Operation::Polynomial(_) = own.operation {
                    sum += series.at_order(&by.force, k);
                }
                term[own.place * width + p + 1] = sum;
            }
        }
    }
}
