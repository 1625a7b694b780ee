//! The flow of a mode as stored matrices and columns that act on the state, for machines of few
//! coordinates.

use super::exponential::{exponentials, second_integral};
use super::watched::{Heads, WatchColumns, taylor, watch_columns};
use super::{ENDS, FlowTable, Group, INTERVALS, LOCAL};
use crate::kernel::{Blocks, SparseColumns};

/// Number of Taylor coefficients of the velocities within an interval, from order 1 on: the first
/// omitted term is below 0.375¹⁷/17! < 2e-22 of the largest coordinate. A multiple of the length
/// of the processor's vectors.
const WITHIN: usize = 16;

/// Factors 1/(k + 1) of the integrals of powers u^k, beginning with order 1.
const INTEGRAL: [f64; WITHIN] = {
    let mut factors = [0.0; WITHIN];
    let mut k = 0;
    while k < WITHIN {
        factors[k] = 1.0 / (k + 2) as f64;
        k += 1;
    }
    factors
};

/// Construction of a mode's matrices, compiled for each set of vector instructions.
struct Making<'a>(&'a FlowTable);

impl pulp::WithSimd for Making<'_> {
    type Output = Kept;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Kept {
        Kept::made(self.0)
    }
}

/// Stored matrices of a sub-step in a mode.
#[derive(Debug)]
pub(super) struct Kept {
    /// z at the interval ends from z at the sub-step's start.
    transitions: Vec<Blocks>,
    /// For each velocity and first-order state: its Taylor coefficients of order 1 and above, for
    /// time in units of an interval. Each column belongs to one number of the state.
    velocities: Vec<SparseColumns<WITHIN>>,
    /// Number of coordinates.
    coordinates: usize,
    /// ∫ (h - s) exp(A s) ds over a sub-step h, if elastic forces are computed separately. Then
    /// z(h) = z + h z' + (this matrix) z''.
    integral: Option<Blocks>,
    /// Columns of each watched functional.
    watched: Vec<WatchColumns>,
    /// Heads of the watched functionals.
    heads: Vec<Heads>,
}

impl Kept {
    /// The matrices of a mode.
    pub(super) fn of(table: &FlowTable) -> Self {
        crate::vectors::Vectors::new().dispatch(Making(table))
    }

    #[inline(always)]
    fn made(table: &FlowTable) -> Self {
        let (a, one, step) = (&table.a, table.one, table.interval());
        let (size, transpose) = (a.len(), a.transpose());
        let watched: Vec<_> = table.watched.iter().map(|w| w.row.dense(size)).collect();
        let watched = watch_columns(&watched, &transpose, (step, table.apart.is_some()));
        let rates: Vec<_> =
            (table.coordinates..one).map(|j| (a.row_of(j) * step).as_slice().to_vec()).collect();
        let mut velocities = taylor::<WITHIN>(&transpose, &rates, step);
        for c in velocities.iter_mut().flatten() {
            (0..WITHIN).for_each(|k| c[k] /= (k + 1) as f64);
        }
        Self {
            transitions: exponentials(a, table.rate, table.length, &ENDS).iter().map(Blocks::of).collect(),
            velocities: velocities.iter().map(|columns| SparseColumns::of(columns)).collect(),
            coordinates: table.coordinates,
            heads: Heads::of(&table.watched, &watched, size),
            watched,
            integral: table.apart.as_ref().map(|_| Blocks::of(&second_integral(a, table.rate, table.length))),
        }
    }

    /// Count of stored numbers for a state of `size` numbers.
    pub(super) fn numbers(&self, size: usize) -> usize {
        self.transitions.len() * size * size
            + self.velocities.iter().map(SparseColumns::numbers).sum::<usize>()
            + self.watched.len() * size * (INTERVALS + LOCAL + 1)
            + self.integral.as_ref().map_or(0, |_| size * size)
    }

    /// Writes the heads of the watched functionals at a state; the bounds of their second
    /// derivatives are computed from the vector `sizes`.
    #[inline(always)]
    pub(super) fn heads_at(&self, z: &[f64], sizes: &[f64], to: &mut Vec<Group>) {
        to.resize(self.heads.len(), Default::default());
        for (to, group) in to.iter_mut().zip(&self.heads) {
            *to = group.at(z, sizes);
        }
    }

    /// The columns of the watched functional at a place.
    #[inline(always)]
    pub(super) fn watched(&self, place: usize) -> &WatchColumns {
        &self.watched[place]
    }

    /// Writes the state at the end of a sub-step from the state at its start and, if elastic
    /// forces are computed separately, its first two derivatives.
    #[inline(always)]
    pub(super) fn at_end(&self, z: &[f64], [rates, second]: [&[f64]; 2], length: f64, to: &mut [f64]) {
        match &self.integral {
            Some(integral) => {
                integral.times(second, to);
                to.iter_mut().zip(z).zip(rates).for_each(|((to, z), rate)| *to = z + (length * rate + *to));
            }
            None => self.at_interval_end(INTERVALS - 1, z, to),
        }
    }

    /// Writes the state at the end of interval `i` from the state at the sub-step's start.
    #[inline(always)]
    pub(super) fn at_interval_end(&self, i: usize, z: &[f64], to: &mut [f64]) {
        self.transitions[i].times(z, to);
    }

    /// Writes coordinates, velocities and states of first order at a time `dt` within an interval
    /// of length `step` from the state at its start.
    #[inline(always)]
    pub(super) fn within(&self, z: &[f64], dt: f64, step: f64, to: &mut [f64]) {
        let u = dt / step;
        let mut powers = [u; WITHIN];
        for k in 1..WITHIN {
            powers[k] = powers[(k - 1) / 2] * powers[k / 2];
        }
        let integrals: [f64; WITHIN] = std::array::from_fn(|k| powers[k] * INTEGRAL[k]);
        let (q, v) = z.split_at(self.coordinates);
        let (to_q, to_v) = to.split_at_mut(self.coordinates);
        for (j, columns) in self.velocities.iter().enumerate() {
            let c = columns.times(z);
            // The larger terms are added last.
            if j < self.coordinates {
                to_q[j] = q[j] + (v[j] + product(&c, &integrals)) * dt;
            }
            to_v[j] = v[j] + product(&c, &powers);
        }
    }
}

/// The scalar product of two coefficient vectors, in four partial sums.
#[inline(always)]
fn product(a: &[f64; WITHIN], b: &[f64; WITHIN]) -> f64 {
    let mut sums = [0.0; 4];
    for (a, b) in a.chunks_exact(4).zip(b.chunks_exact(4)).rev() {
        sums.iter_mut().zip(a).zip(b).for_each(|((sum, a), b)| *sum += a * b);
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}
