//! Work over many sub-steps at once for modes without tables: from the states at the nodes of
//! Gauss's rule in all sub-steps (docs/assembly-law.md (A29)).
//!
//! A mode of a large machine seldom occurs twice. Matrices for each power and length would serve
//! every state, but only few states begin a long step.

use crate::flow::{FlowTable, INTERVALS, Rung, Series};
use crate::kernel::{NODES, Sparse};

/// Largest remainder of a coordinate in the dropped columns, relative to its root mean square. The
/// work loses the square of it.
const DROPPED: f64 = 1e-13;

/// States at the nodes, each times the root of its weight, as columns that may have been rotated.
/// The sum over columns of the product of two functionals is the integral of the product.
pub(super) struct NodeStates {
    /// Number of coordinates.
    size: usize,
    columns: Vec<f64>,
}

impl NodeStates {
    /// The states over 2^`k` sub-steps from a state.
    pub(super) fn over(k: usize, table: &FlowTable, z: &[f64]) -> Self {
        (0..k).fold(Self::first(table, z), |states, k| states.doubled(table, table.rung(k)))
    }

    /// The states over one sub-step.
    fn first(table: &FlowTable, z: &[f64]) -> Self {
        let (mut series, mut at) = (Series::default(), Vec::new());
        series.expand(table, z, table.length, table.orders_to(INTERVALS - 1));
        series.at_nodes(&NODES, 1.0, 0, &mut at);
        let root = |node: usize| (table.length * NODES[node].1).sqrt();
        let column = |node: usize| at.iter().map(move |x| x[node] * root(node));
        Self { size: z.len(), columns: (0..NODES.len()).flat_map(column).collect() }.reduced()
    }

    /// The states over twice the rung's length.
    fn doubled(mut self, table: &FlowTable, rung: &Rung) -> Self {
        let (own, mut rates) = (self.columns.len(), vec![0.0; self.size]);
        self.columns.resize(2 * own, 0.0);
        let (columns, later) = self.columns.split_at_mut(own);
        for (z, to) in columns.chunks_exact(self.size).zip(later.chunks_exact_mut(self.size)) {
            table.rates(z, &mut rates);
            rung.at_end(z, &rates, to);
        }
        self.reduced()
    }

    /// The integral of the product of two functionals.
    pub(super) fn product(&self, left: &Sparse, right: &Sparse) -> f64 {
        self.columns.chunks_exact(self.size).map(|z| left.dot(z) * right.dot(z)).sum()
    }

    /// Reduces the number of columns. A reflection collects the remainder of one coordinate in one
    /// column, each time for the largest relative remainder, until all remainders count as zero.
    fn reduced(mut self) -> Self {
        let size = self.size;
        let [mut all, mut rest, mut sum] = [0; 3].map(|_| vec![0.0; size]);
        squares(&self.columns, &mut all);
        let (mut kept, mut by) = (0, Vec::new());
        loop {
            let left = &mut self.columns[kept * size..];
            squares(left, &mut rest);
            let part = |i: usize| if rest[i] > DROPPED * DROPPED * all[i] { rest[i] / all[i] } else { 0.0 };
            let parts = (0..size).map(|i| (i, part(i))).filter(|own| own.1 > 0.0);
            let Some((row, _)) = parts.max_by(|a, b| a.1.total_cmp(&b.1)) else { break };
            reflect(left, row, rest[row].sqrt(), &mut by, &mut sum);
            kept += 1;
        }
        self.columns.truncate(kept * size);
        self
    }
}

/// Writes the sum of squares of each coordinate.
fn squares(columns: &[f64], to: &mut [f64]) {
    to.fill(0.0);
    for column in columns.chunks_exact(to.len()) {
        to.iter_mut().zip(column).for_each(|(sum, x)| *sum += x * x);
    }
}

/// Householder reflection of the columns of a matrix. Afterwards row `row`, whose Euclidean norm
/// is `size`, is zero except in the first column. `by` and `sum` are scratch memory.
fn reflect(columns: &mut [f64], row: usize, size: f64, by: &mut Vec<f64>, sum: &mut [f64]) {
    by.clear();
    by.extend(columns.chunks_exact(sum.len()).map(|column| column[row]));
    let size = size.copysign(by[0]);
    by[0] += size;
    sum.fill(0.0);
    for (column, by) in columns.chunks_exact(sum.len()).zip(by.iter()) {
        sum.iter_mut().zip(column).for_each(|(sum, x)| *sum += by * x);
    }
    let factor = 1.0 / (size * by[0]);
    for (column, by) in columns.chunks_exact_mut(sum.len()).zip(by.iter()) {
        let by = by * factor;
        column.iter_mut().zip(sum.iter()).for_each(|(x, sum)| *x -= by * sum);
    }
}
