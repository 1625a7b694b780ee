//! Curved forces in a mode, and the power series of a state under them.

mod edges;
mod pace;

pub(crate) use edges::{AtState, part_at_edges, part_from_edges, part_to_edge, sides_ahead};
pub(crate) use pace::{GroupNorms, part, shortened};

use super::ahead::{Ahead, HeadAhead, Series};
use super::{FlowTable, ORDERS, RADIUS};
use crate::curved::{
    ArgumentTerms, CurveSeries, CurveSizes, CurveTerms, Curved, LAST_ORDER, Operation, Piece, Remainder,
};
use crate::functional::Functional;
use crate::kernel::{Sparse, SparseMatrix, largest_product};
use crate::law::ZERO;
use crate::mode::Mode;
use crate::system::{Part, System};
use std::ops::Range;

/// Order of the last term of a series with curved forces.
pub(crate) const LAST_CURVE_ORDER: usize = LAST_ORDER;
/// Rate times the longest span over which coefficients are computed. The proved span of the series
/// may be longer or shorter.
pub(crate) const CURVE_REACH: f64 = 4.0;
/// The span of the computed coefficients may be 2³ times their radius of convergence. Beyond it
/// they are computed again.
const MOST_EXCESS: i64 = 3;

/// Shortest part of a span that is proved with the coefficients of the whole span.
const SHORT_PART: f64 = 1e-3;

/// Norms of the terms of a series by order: by group, and of the signals.
type Norms = ([GroupNorms; LAST_CURVE_ORDER + 1], [f64; LAST_CURVE_ORDER + 1]);

/// Norms of the row of an argument: Σ |ℓᵢ| wᵢ over the velocities, and over the other coordinates
/// without operations; and the operations in it.
#[derive(Clone, Debug, Default)]
struct RowNorms {
    others: f64,
    velocities: f64,
    /// Index in the mode and size of the factor of each operation.
    nested: Vec<(usize, f64)>,
}

impl RowNorms {
    /// The norms of a row. `places` has the places of the operations before.
    fn of(row: &Functional, velocities: &Range<usize>, places: &[usize], weights: &[f64]) -> Self {
        let mut norms = Self::default();
        for &(j, x) in row.terms() {
            if let Some(own) = places.iter().position(|place| *place == j) {
                norms.nested.push((own, x.abs()));
                continue;
            }
            let norm = if velocities.contains(&j) { &mut norms.velocities } else { &mut norms.others };
            *norm += x.abs() / weights[j];
        }
        norms
    }

    /// The norm for weights of velocities that are `faster` times larger.
    #[inline(always)]
    fn joint(&self, faster: f64) -> f64 {
        self.others + faster * self.velocities
    }
}

/// A curved force in a mode.
#[derive(Clone, Debug)]
pub(crate) struct CurveInMode {
    /// The force.
    pub(crate) curved: Curved,
    /// Norms of the arguments' rows.
    rows: [RowNorms; 2],
    /// Norm of φ's column for the accelerations, and of its column for other rates: max |yᵢ| / wᵢ.
    pub(super) effects: [f64; 2],
    /// Whether the force of an element moves no state in the mode, as between held bodies.
    is_unseen: bool,
    /// Whether the force acts in the mode: the operations of a stop do so beyond its gap.
    pub(crate) acts: bool,
    /// Largest entry of φ's column, and sums of the sizes of the entries of the first argument's
    /// row: of the velocities, and of the others. The sums have no weights.
    pub(crate) plain: [f64; 3],
}

impl CurveInMode {
    /// The curved forces in a mode with matrix A. `weights` are the 1/wᵢ of the norm (A6).
    pub(crate) fn all(system: &System, mode: &Mode, a: &SparseMatrix, weights: &[f64]) -> Vec<Self> {
        let columns = if system.curved.is_empty() { SparseMatrix::default() } else { a.transpose() };
        let velocities = system.coordinates..2 * system.coordinates;
        let places: Vec<usize> = system.curved.iter().map(|curved| curved.place).collect();
        let in_mode = |(known, curved): (usize, &Curved)| {
            let curved = &curved.in_mode(mode);
            let of = |row: &Functional| RowNorms::of(row, &velocities, &places[..known], weights);
            let mut rows = [of(&curved.argument), of(&curved.second)];
            if curved.polynomial().is_some() && rows[0].nested.is_empty() {
                // The row of a rate may contain signals. As velocities they give a larger norm.
                let terms = curved.argument.terms().iter();
                let reach = terms.map(|&(j, x)| x.abs() / weights[j]).sum();
                let [others, velocities] = if curved.is_of_rate { [0.0, reach] } else { [reach, 0.0] };
                rows[0] = RowNorms { others, velocities, nested: Vec::new() };
            }
            let column: Vec<(usize, f64)> = match curved.released(system, mode) {
                Some(column) => column,
                None => columns.row(curved.place).to_vec(),
            };
            let mut effects = [0.0f64; 2];
            for &(i, y) in &column {
                let effect = &mut effects[usize::from(!velocities.contains(&i))];
                *effect = effect.max(y.abs() * weights[i]);
            }
            let acts = match curved.owner {
                Part::Stop(i) => mode.stops[i].is_inside(),
                _ => true,
            };
            let largest = column.iter().fold(0.0f64, |most, entry| most.max(entry.1.abs()));
            let [mut of_velocities, mut of_others] = [0.0; 2];
            for &(j, x) in curved.argument.terms() {
                *if velocities.contains(&j) { &mut of_velocities } else { &mut of_others } += x.abs();
            }
            let plain = [largest, of_velocities, of_others];
            let is_in = |force: &Functional| force.terms().iter().any(|own| own.0 == curved.place);
            let is_unseen = effects == [0.0; 2]
                && acts
                && match curved.owner {
                    Part::Spring(i) => is_in(&system.springs[i].force),
                    Part::Stop(i) => is_in(&system.stops[i].force),
                    _ => false,
                };
            Self { curved: curved.clone(), rows, effects, acts, plain, is_unseen }
        };
        let mut all: Vec<Self> = system.curved.iter().enumerate().map(in_mode).collect();
        for i in 0..all.len() {
            let nested: Vec<usize> =
                all[i].rows.iter().flat_map(|row| row.nested.iter().map(|own| own.0)).collect();
            nested.into_iter().for_each(|inner| all[inner].is_unseen = false);
        }
        all
    }

    /// Whether this is a polynomial of a row without operations.
    #[inline(always)]
    fn is_plain(&self) -> bool {
        matches!(self.curved.operation, Operation::Polynomial(_)) && self.rows[0].nested.is_empty()
    }

    /// The norm of φ's column, in a norm whose weights of velocities are `faster` times larger.
    #[inline(always)]
    fn effect(&self, faster: f64) -> f64 {
        (self.effects[0] / faster).max(self.effects[1])
    }

    /// The force with its series, for the bound of the remainder.
    #[inline(always)]
    fn with<'a>(&'a self, series: &'a CurveSeries, faster: f64) -> CurveTerms<'a> {
        let argument =
            |row: &'a RowNorms| ArgumentTerms { reach: row.joint(faster), nested: row.nested.as_slice() };
        let [first, second] = &self.rows;
        let arguments = [argument(first), argument(second)];
        let own = &self.curved.operation;
        let terms = CurveTerms::new(own.on(series.piece), series, arguments, self.effect(faster));
        CurveTerms { is_sided: own.edge().is_some(), is_unseen: self.is_unseen, ..terms }
    }

    /// Norms of the derivative of φ by the states without velocities, and by the velocities.
    /// `known` has the norms of the forces before.
    #[inline(always)]
    fn steepness(&self, slopes: [f64; 2], known: &[[f64; 2]]) -> [f64; 2] {
        let mut norms = [0.0; 2];
        for (row, slope) in self.rows.iter().zip(slopes) {
            let mut own = [row.others, row.velocities];
            for &(i, factor) in &row.nested {
                (0..2).for_each(|k| own[k] += factor * known[i][k]);
            }
            // An infinite slope by an argument that no state moves has no effect.
            (0..2).filter(|k| own[*k] > 0.0).for_each(|k| norms[k] += slope.abs() * own[k]);
        }
        norms
    }
}

/// A bound of the rate of z' = A z with the slopes of the curved forces, 1/s. `rate` is the norm
/// of A, in the same norm. `slopes` returns the slopes of a force by its arguments.
#[inline(always)]
fn with_slopes(rate: f64, curves: &[CurveInMode], slopes: impl Fn(&Curved) -> [f64; 2]) -> f64 {
    let (mut stiffness, mut damping) = (0.0, 0.0);
    let are_plain = curves.iter().all(CurveInMode::is_plain);
    let mut known: Vec<[f64; 2]> = Vec::new();
    for curve in curves {
        let (slopes, effect) = (slopes(&curve.curved), curve.effect(1.0));
        if are_plain {
            let of_rate = curve.curved.is_of_rate;
            let RowNorms { others, velocities, .. } = curve.rows[0];
            let own = effect * if of_rate { velocities } else { others } * slopes[0];
            *if of_rate { &mut damping } else { &mut stiffness } += own;
            continue;
        }
        let own = curve.steepness(slopes, &known);
        if effect > 0.0 {
            stiffness += effect * own[0];
            damping += effect * own[1];
        }
        known.push(own);
    }
    // If the weights of velocities grow by a factor ≥ 1, the norm of A grows at most by this
    // factor.
    let faster = (stiffness / rate).sqrt().max(1.0);
    faster * rate + stiffness / faster + damping
}

/// The slopes of a polynomial's majorant at the size of its argument, and of another operation at
/// the state.
#[inline(always)]
fn slopes(curved: &Curved, z: &[f64], size: impl Fn(&Functional) -> f64) -> [f64; 2] {
    match &curved.operation {
        Operation::Polynomial(force) => [force.majorant().derivative(size(&curved.argument)), 0.0],
        operation => operation.slopes(curved.arguments(z)),
    }
}

/// The rate with the slopes of the curved forces at a state, 1/s.
#[inline(always)]
pub(crate) fn rate_at(rate: f64, curves: &[CurveInMode], z: &[f64]) -> f64 {
    with_slopes(rate, curves, |curved| slopes(curved, z, |argument| argument.at(z).abs()))
}

/// The norms of a term with the weights of velocities `faster` times larger: without the
/// coordinates of curved forces, and of the states alone.
#[inline(always)]
fn joint([displacements, velocities, inner]: GroupNorms, signals: f64, faster: f64) -> (f64, f64) {
    let states = displacements.max(velocities / faster).max(inner);
    (states.max(signals), states)
}

impl Series {
    /// The norms of (A6) of a term: by group, and of the signals.
    #[inline(always)]
    fn norms(&self, table: &FlowTable, k: usize) -> (GroupNorms, f64) {
        let (n, one, straight) = (table.coordinates, table.one, table.a.len() - table.curves.len());
        let term = self.term(k);
        let norm = |from: usize, to: usize| largest_product(&term[from..to], &table.weights[from..to]);
        ([norm(0, n), norm(n, 2 * n), norm(2 * n, one)], norm(one, straight))
    }

    /// Sets the sides on which the curved forces begin.
    #[inline(always)]
    fn set_sides(&mut self, sides: &[Piece], backwards: bool) {
        self.curves.resize(sides.len(), CurveSeries::default());
        for (series, side) in self.curves.iter_mut().zip(sides) {
            (series.piece, series.backwards) = (*side, backwards);
        }
    }

    /// Sets the terms of order `k` of the curved forces, given the other coordinates' terms.
    #[inline(always)]
    pub(super) fn curve(&mut self, table: &FlowTable, k: usize) {
        self.curves.resize(table.curves.len(), CurveSeries::default());
        for (curve, series) in table.curves.iter().zip(&mut self.curves) {
            let terms = &mut self.terms[k * self.size..][..self.size];
            let value = series.next(&curve.curved.operation, k, curve.curved.arguments(terms));
            terms[curve.curved.place] = value;
        }
    }
}

impl Series {
    /// Expands the states ahead of `z` over a span, or over a shorter one where the series would
    /// not converge; returns the norms of the terms.
    #[inline(always)]
    fn expand_curved(&mut self, table: &FlowTable, z: &[f64], span: &mut f64) -> Norms {
        let (mut groups, mut signals) = ([[0.0; 3]; LAST_CURVE_ORDER + 1], [0.0; LAST_CURVE_ORDER + 1]);
        loop {
            self.expand(table, z, *span, LAST_CURVE_ORDER);
            for k in 0..=LAST_CURVE_ORDER {
                (groups[k], signals[k]) = self.norms(table, k);
            }
            let is_finite = self.term(LAST_CURVE_ORDER).iter().all(|x| x.is_finite());
            match shortened(*span, is_finite, &groups, MOST_EXCESS) {
                Some(shorter) => *span = shorter,
                None => return (groups, signals),
            }
        }
    }
}

/// Time, relative to that of the mode's rate, up to which a series is used without its proof:
/// terms from the third order on are below rounding, and the highest ones are too small for a
/// double, so that the proof would give a part of any such time.
const TINY: f64 = 1e-11;

impl Ahead {
    /// Expands the states ahead of `z` over the longest time, at most `most`, for which the
    /// remainder of the series is proved to be rounding.
    #[inline(always)]
    pub(super) fn find_curved(&mut self, table: &FlowTable, z: &[f64], most: f64) {
        let rate = rate_at(table.rate, &table.curves, z);
        let mut scale = most.min(CURVE_REACH / rate);
        let series = &mut self.series;
        let mut to_edge = f64::INFINITY;
        if edges::any(&table.curves) {
            let (sides, time) = table.sides_ahead(z);
            series.set_sides(&sides, self.backwards);
            to_edge = time;
            scale = scale.min(to_edge);
        }
        let (mut groups, mut signals) = series.expand_curved(table, z, &mut scale);
        // Beyond the edge of a power the series has no remainder.
        let longest = if to_edge < most { (most / scale).min(to_edge / scale) } else { most / scale };
        let mut longest = table.part_at_edges(z, series, (longest, scale));
        if longest < SHORT_PART {
            // Powers of the radius would overflow.
            scale *= longest;
            (groups, signals) = series.expand_curved(table, z, &mut scale);
            longest = (most / scale).min(1.0);
        }
        // The weights of velocities follow the pace of the motion. The remainder is then at most
        // the rounding of the displacements, and at most the rounding of the velocities.
        let faster = (pace::pace(&groups, scale) / table.rate).max(1.0);
        let is_tiny = longest * scale >= most && most * rate <= TINY;
        let part = match is_tiny {
            true => longest,
            false => table.proved_part(series, (&groups, &signals), (scale, faster), longest),
        };
        let part = part_to_edge(&table.curves, &series.curves, part, self.backwards);
        let mut power = 1.0;
        for k in 1..=LAST_CURVE_ORDER {
            power *= part;
            series.scale(k, power);
        }
        // Not by `part * scale`, whose rounding may end just before `most`, at which a knot would
        // then be missed.
        self.span = if part == most / scale { most } else { (part * scale).min(most) };
        self.expanded = scale;
        self.heads.clear();
        for w in &table.watched {
            let of = |k: usize| w.row.dot(series.term(k));
            self.heads.push(HeadAhead { value: of(0), slope: of(1), behind: 0.0 });
        }
        self.sum_behind(table);
    }
}

impl FlowTable {
    /// Whether the mode has curved forces.
    pub fn is_curved(&self) -> bool {
        !self.curves.is_empty()
    }

    /// The longest part of a span over which powers at their edges are negligible.
    fn part_at_edges(&self, z: &[f64], series: &Series, (part, span): (f64, f64)) -> f64 {
        if !series.curves.iter().any(|own| own.piece == Piece::Still) {
            return part;
        }
        let norms = std::array::from_fn(|k| series.norm(self, k, self.one));
        part_at_edges(&self.curves, &series.curves, (part, span), (z, norms))
    }

    /// The sides of powers with an edge ahead of a state, and the longest time over which the
    /// coefficients of a series are computed, s.
    #[inline(always)]
    fn sides_ahead(&self, z: &[f64]) -> (Vec<Piece>, f64) {
        let mut rates = vec![0.0; z.len()];
        self.rates(z, &mut rates);
        let Self { rate, weights, one, watched, .. } = self;
        sides_ahead(&self.curves, &AtState { z, rates: &rates, weights, one: *one, rate: *rate, watched })
    }

    /// Time limit of a sub-step, s, for the growth of the sizes of rates by the forces. Curved
    /// forces shorten it by their slopes at the largest sizes: over a longer time the sizes of
    /// rates would raise the sizes of displacements, and these the slopes, without end. The slopes
    /// of other operations than polynomials are taken at the state.
    pub fn length_for(&self, z: &[f64], sizes: &[f64]) -> f64 {
        if !self.is_curved() {
            return self.length;
        }
        RADIUS
            / with_slopes(self.rate, &self.curves, |curved| {
                slopes(curved, z, |argument| argument.size(sizes))
            })
    }

    /// Replaces a state by its time derivative of an order below `TERMS`.
    pub fn derivative(&self, order: usize, z: &mut [f64]) {
        let mut series = Series::default();
        series.set_sides(&edges::sides(&self.curves, z), false);
        series.expand(self, z, 1.0, order);
        z.copy_from_slice(series.term(order));
        let factorial = (1..=order).fold(1.0, |product, k| product * k as f64);
        z.iter_mut().for_each(|x| *x *= factorial);
    }

    /// The longest fraction of the span of a series, at most `most`, over which its remainder is
    /// proved to be rounding.
    #[inline(always)]
    fn proved_part(
        &self,
        series: &Series,
        (groups, signals): (&[GroupNorms], &[f64]),
        (span, faster): (f64, f64),
        most: f64,
    ) -> f64 {
        let (mut norms, mut sizes) = ([0.0; LAST_CURVE_ORDER + 1], [0.0; LAST_CURVE_ORDER + 1]);
        for k in 0..=LAST_CURVE_ORDER {
            (norms[k], sizes[k]) = joint(groups[k], signals[k], faster);
        }
        let pairs = self.curves.iter().zip(&series.curves);
        let mut curves: Vec<CurveTerms> = pairs.map(|(own, series)| own.with(series, faster)).collect();
        let mut remainder =
            Remainder { span, rate: faster * self.rate, norms: &norms, sizes: &sizes, curves: &mut curves };
        remainder.longest(most)
    }

    /// Advances a state by a time of either sign within the mode, and variations with it. The time
    /// must be within the motion's: a state that reaches the end of its motion stays there.
    pub fn carry_along(&self, z: &mut [f64], variations: &mut [Vec<f64>], time: f64) {
        let (mut left, sign) = (time.abs(), time.signum());
        let mut ahead = Ahead::towards(sign < 0.0);
        let mut terms = vec![vec![0.0; z.len()]; LAST_CURVE_ORDER + 1];
        while left > 0.0 {
            ahead.find_curved(self, z, left);
            if ahead.span == 0.0 {
                break;
            }
            let part = sign * ahead.span / ahead.expanded;
            for variation in variations.iter_mut() {
                self.vary(&ahead, variation, &mut terms, part);
            }
            // The bound of the remainder holds for both signs of time.
            ahead.series.at(sign, z);
            self.fill_curves(z);
            variations.iter_mut().for_each(|variation| self.vary_curves(z, variation));
            left = if ahead.span >= left { 0.0 } else { left - ahead.span };
        }
    }

    /// Advances a variation along a series by the fraction `part` of the span over which its
    /// coefficients were computed. `terms` is memory for the variation's coefficients.
    fn vary(&self, ahead: &Ahead, variation: &mut [f64], terms: &mut [Vec<f64>], part: f64) {
        terms[0].copy_from_slice(variation);
        for k in 0..=LAST_CURVE_ORDER {
            let (known, later) = terms.split_at_mut(k + 1);
            for (CurveInMode { curved, .. }, series) in self.curves.iter().zip(&ahead.series.curves) {
                let slopes = |j: usize| series.slopes(&curved.operation, j);
                let product = |j: usize| slopes(j)[0] * curved.argument.at(&known[k - j]);
                let mut value: f64 = (0..=k).map(product).sum();
                if curved.operation.is_of_two() {
                    value += (0..=k).map(|j| slopes(j)[1] * curved.second.at(&known[k - j])).sum::<f64>();
                }
                known[k][curved.place] = value;
            }
            if let Some(next) = later.first_mut() {
                self.rows_times_to(0, &known[k], ahead.expanded / (k + 1) as f64, next);
            }
        }
        variation.copy_from_slice(&terms[LAST_CURVE_ORDER]);
        for term in terms[..LAST_CURVE_ORDER].iter().rev() {
            variation.iter_mut().zip(term).for_each(|(sum, x)| *sum = *sum * part + x);
        }
    }

    /// Writes the curved forces into a state.
    pub fn fill_curves(&self, z: &mut [f64]) {
        for CurveInMode { curved, .. } in &self.curves {
            curved.fill(z);
        }
    }

    /// Writes the variations of the curved forces into a variation of a state.
    fn vary_curves(&self, z: &[f64], variation: &mut [f64]) {
        for CurveInMode { curved, .. } in &self.curves {
            curved.vary(z, variation);
        }
    }

    /// For each watched functional: order and value of its first nonzero derivative, as
    /// [`departure`](Self::departure) finds it for straight laws.
    pub(crate) fn curved_departures(
        &self,
        z: &[f64],
        sizes: &[f64],
        doubt: f64,
    ) -> Vec<Option<(usize, f64)>> {
        let mut series = Series::default();
        let length = self.length_for(z, sizes);
        series.set_sides(&edges::sides(&self.curves, z), false);
        series.expand(self, z, length, ORDERS - 1);
        let all = self.sizes_of_terms(z, sizes, (length, ORDERS - 1));
        let leaves = |value: f64, size: f64| value < -ZERO * size || value > doubt * ZERO * size;
        let of = |row: &Sparse| {
            (0..ORDERS).find_map(|k| {
                let value = row.dot(series.term(k));
                leaves(value, row.size(&all[k])).then_some((k, value))
            })
        };
        self.watched.iter().map(|w| of(&w.row)).collect()
    }

    /// For each order up to `last` the sizes of the terms of a series over a span, given the sizes
    /// of the coordinates at its start.
    fn sizes_of_terms(&self, z: &[f64], sizes: &[f64], (span, last): (f64, usize)) -> Vec<Vec<f64>> {
        let own = self.sizes.as_ref().unwrap_or(&self.a);
        let mut all = vec![sizes.to_vec()];
        let mut majorants: Vec<CurveSizes> = self
            .curves
            .iter()
            .map(|curve| {
                let own = &curve.curved;
                CurveSizes::of(&own.operation, own.arguments(z), own.argument_sizes(sizes))
            })
            .collect();
        for k in 1..=last {
            let mut next = vec![0.0; sizes.len()];
            own.sizes_rows_times_to(0, &all[k - 1], span / k as f64, &mut next);
            for (curve, majorant) in self.curves.iter().zip(&mut majorants) {
                next[curve.curved.place] = majorant.next(k, curve.curved.argument_sizes(&next));
            }
            all.push(next);
        }
        all
    }
}

#[cfg(test)]
mod tests;
