//! Products of small matrices with vectors for the inner loop: columns of fixed length, which
//! compile to vector instructions, and lists of nonzero entries. Only constructors, and functions
//! that return vectors or matrices, allocate.

mod sparse;

pub use sparse::{Sparse, sort_by_place};

use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Abscissas and weights of Gauss's rule with twelve nodes on [0, 1] (Abramowitz and Stegun, table
/// 25.4). For a product of two functions of rate r over a span of at most 3/r the rule's relative
/// error is (12!)⁴ 6²⁴/(25 (24!)³) < 5e-20.
pub const NODES: [(f64, f64); 12] = {
    let half = [
        (0.125_233_408_511_468_9, 0.249_147_045_813_402_8),
        (0.367_831_498_998_180_2, 0.233_492_536_538_354_8),
        (0.587_317_954_286_617_4, 0.203_167_426_723_065_92),
        (0.769_902_674_194_304_7, 0.160_078_328_543_346_23),
        (0.904_117_256_370_474_9, 0.106_939_325_995_318_43),
        (0.981_560_634_246_719_3, 0.047_175_336_386_511_83),
    ];
    let mut nodes = [(0.0, 0.0); 12];
    let mut k = 0;
    while k < 6 {
        let (x, weight): (f64, f64) = half[k];
        nodes[5 - k] = (0.5 - 0.5 * x, 0.5 * weight);
        nodes[6 + k] = (0.5 + 0.5 * x, 0.5 * weight);
        k += 1;
    }
    nodes
};

/// Values at the [`NODES`] of an interval of time, or at its [`EIGHT`] nodes.
pub type AtNodes = [f64; NODES.len()];

/// Gauss's rule with eight nodes (Abramowitz and Stegun, table 25.4).
pub const EIGHT: [(f64, f64); 8] = [
    (0.019_855_071_751_231_884, 0.050_614_268_145_188_13),
    (0.101_666_761_293_186_63, 0.111_190_517_226_687_24),
    (0.237_233_795_041_835_5, 0.156_853_322_938_943_64),
    (0.408_282_678_752_175_1, 0.181_341_891_689_181),
    (0.591_717_321_247_825, 0.181_341_891_689_181),
    (0.762_766_204_958_164_5, 0.156_853_322_938_943_64),
    (0.898_333_238_706_813_4, 0.111_190_517_226_687_24),
    (0.980_144_928_248_768_1, 0.050_614_268_145_188_13),
];

/// Limit of rate times span x for [`EIGHT`] nodes. For G nodes, the relative error of a product of
/// two functions is (G!)⁴ (2x)²ᴳ/((2G + 1) ((2G)!)³): below 3e-17 for eight nodes up to x = 1.2,
/// below 6e-17 for twelve nodes up to x = 4.
pub const SHORT: f64 = 1.2;

/// Σ_j columns\[j\] z_j.
#[inline(always)]
pub fn combine<const R: usize>(columns: &[[f64; R]], z: &[f64]) -> [f64; R] {
    let mut sum = [0.0; R];
    for (column, x) in columns.iter().zip(z) {
        for (s, c) in sum.iter_mut().zip(column) {
            *s += c * x;
        }
    }
    sum
}

/// `sum` = `sum` × `factor` + `term`, coordinate by coordinate.
#[inline(always)]
pub fn multiply_add_rows(sum: &mut [f64], factor: f64, term: &[f64]) {
    sum.iter_mut().zip(term).for_each(|(sum, x)| *sum = *sum * factor + x);
}

/// The nonzero columns of a matrix of R rows, with their indices.
#[derive(Clone, Debug)]
pub struct SparseColumns<const R: usize>(Vec<(usize, [f64; R])>);

impl<const R: usize> SparseColumns<R> {
    /// Keeps the nonzero columns.
    pub fn of(columns: &[[f64; R]]) -> Self {
        let nonzero = |(_, column): &(usize, &[f64; R])| column.iter().any(|x| *x != 0.0);
        let mut own = Vec::with_capacity(columns.len());
        own.extend(columns.iter().enumerate().filter(nonzero).map(|(place, column)| (place, *column)));
        Self(own)
    }

    /// The matrix times a vector.
    #[inline(always)]
    pub fn times(&self, z: &[f64]) -> [f64; R] {
        self.first_times(z)
    }

    /// The first `N` rows of the matrix times a vector.
    #[inline(always)]
    pub fn first_times<const N: usize>(&self, z: &[f64]) -> [f64; N] {
        let mut sum = [0.0; N];
        for (place, column) in &self.0 {
            let x = z[*place];
            sum.iter_mut().zip(column).for_each(|(s, c)| *s += c * x);
        }
        sum
    }

    /// Count of stored numbers.
    pub fn numbers(&self) -> usize {
        self.0.len() * (R + 1)
    }
}

/// Nonzero entries of a row, with their columns.
pub type Entries<'a> = &'a [(usize, f64)];

/// A square matrix, stored as the nonzero entries of its rows.
#[derive(Clone, Debug)]
pub struct SparseMatrix {
    /// Index of each row's first entry, and the end of the last row.
    rows: Vec<usize>,
    entries: Vec<(usize, f64)>,
    /// The entries in a form for fast products.
    slices: Option<Slices>,
}

/// The matrix without rows.
impl Default for SparseMatrix {
    fn default() -> Self {
        Self { rows: vec![0], entries: Vec::new(), slices: None }
    }
}

/// Number of rows of a slice.
const SLICE: usize = 8;

/// Number of vectors multiplied together.
pub const ABREAST: usize = 8;

/// Least number of entries for which a diagonal of a slice is stored as a whole; fewer entries are
/// as fast one by one.
const FILLED: usize = 3;

/// A matrix in slices of eight rows, beginning with row `begin`. Each slice stores its well-filled
/// diagonals, as in a chain of bodies, and its other entries one by one. A product with a diagonal
/// needs no list of indices and compiles to vector instructions.
#[derive(Clone, Debug)]
struct Slices {
    /// The first row.
    begin: usize,
    /// For each slice: the end of its diagonals.
    ends: Vec<usize>,
    /// First column of each diagonal within its slice, and its entries.
    diagonals: Vec<(usize, [f64; SLICE])>,
    /// Row, column and value of each other entry.
    others: Vec<(usize, usize, f64)>,
}

impl Slices {
    fn of(matrix: &SparseMatrix, begin: usize) -> Self {
        let mut slices = Self { begin, ends: Vec::new(), diagonals: Vec::new(), others: Vec::new() };
        let size = matrix.len();
        for first in (begin..size).step_by(SLICE) {
            let rows = first..size.min(first + SLICE);
            let mut own: Vec<(usize, usize, f64)> = Vec::new();
            for i in rows {
                own.extend(matrix.row(i).iter().map(|&(j, x)| (i, j, x)));
            }
            // Column - row is constant on a diagonal; sorting is stable, so that rows ascend.
            vibro_numerics::sorting::sort_by_key(&mut own, |&(i, j, _)| size + j - i);
            for diagonal in own.chunk_by(|a, b| a.1 + b.0 == b.1 + a.0) {
                let (row, column, _) = diagonal[0];
                match column.checked_sub(row - first) {
                    Some(column) if diagonal.len() >= FILLED && column + SLICE <= size => {
                        let mut entries = [0.0; SLICE];
                        diagonal.iter().for_each(|&(i, _, x)| entries[i - first] = x);
                        slices.diagonals.push((column, entries));
                    }
                    _ => slices.others.extend_from_slice(diagonal),
                }
            }
            slices.ends.push(slices.diagonals.len());
        }
        slices
    }

    /// `to` = `factor` × matrix × `from`, beginning with the first row of the slices.
    #[inline(always)]
    fn times_to(&self, from: &[f64], factor: f64, to: &mut [f64]) {
        let mut first = 0;
        for (to, &end) in to.chunks_mut(SLICE).zip(&self.ends) {
            let mut sums = [0.0; SLICE];
            for (column, entries) in &self.diagonals[first..end] {
                let from = &from[*column..][..SLICE];
                (0..SLICE).for_each(|i| sums[i] += entries[i] * from[i]);
            }
            to.iter_mut().zip(&sums).for_each(|(y, sum)| *y = factor * sum);
            first = end;
        }
        self.others.iter().for_each(|&(i, j, x)| to[i - self.begin] += factor * x * from[j]);
    }
}

/// Largest absolute value among the elementwise products of two lists.
#[inline(always)]
pub fn largest_product(x: &[f64], z: &[f64]) -> f64 {
    let ((x, x_rest), (z, z_rest)) = (x.as_chunks::<SLICE>(), z.as_chunks::<SLICE>());
    let larger = |most: f64, product: f64| if product.abs() > most { product.abs() } else { most };
    let mut most = [0.0; SLICE];
    for (x, z) in x.iter().zip(z) {
        (0..SLICE).for_each(|i| most[i] = larger(most[i], x[i] * z[i]));
    }
    let rest = x_rest.iter().zip(z_rest).map(|(x, z)| x * z);
    most.into_iter().chain(rest).fold(0.0, larger)
}

impl SparseMatrix {
    /// Appends a row, given by its entries; zeros are not stored.
    pub fn push_row(&mut self, row: impl Iterator<Item = (usize, f64)>) {
        self.entries.extend(row.filter(|&(_, x)| x != 0.0));
        self.rows.push(self.entries.len());
    }

    /// The matrix with some rows replaced, and with `value` applied to all other entries.
    pub fn with_rows<R: Iterator<Item = (usize, f64)>>(
        &self,
        value: impl Fn(f64) -> f64,
        replaced: impl Fn(usize) -> Option<R>,
    ) -> Self {
        let mut sum = Self::default();
        sum.rows.reserve(self.len());
        sum.entries.reserve(self.entries.len() + self.entries.len() / 4);
        for i in 0..self.len() {
            match replaced(i) {
                Some(row) => sum.push_row(row),
                None => {
                    sum.entries.extend(self.row(i).iter().map(|&(j, x)| (j, value(x))));
                    sum.rows.push(sum.entries.len());
                }
            }
        }
        sum
    }

    /// The transpose.
    pub fn transpose(&self) -> Self {
        let mut rows = vec![0; self.len() + 1];
        self.entries.iter().for_each(|&(j, _)| rows[j + 1] += 1);
        (0..self.len()).for_each(|j| rows[j + 1] += rows[j]);
        let (mut next, mut entries) = (rows.clone(), vec![(0, 0.0); self.entries.len()]);
        for i in 0..self.len() {
            for &(j, x) in self.row(i) {
                entries[next[j]] = (i, x);
                next[j] += 1;
            }
        }
        Self { rows, entries, slices: None }
    }

    /// The matrix with its rows from `begin` on also stored as slices, for repeated products.
    pub fn with_slices(mut self, begin: usize) -> Self {
        self.slices = Some(Slices::of(&self, begin));
        self
    }

    /// The entry in row `i` and column `j`.
    pub fn entry(&self, i: usize, j: usize) -> f64 {
        self.row(i).iter().find(|term| term.0 == j).map_or(0.0, |term| term.1)
    }

    /// The nonzero entries of a row with their columns.
    #[inline(always)]
    pub fn row(&self, i: usize) -> &[(usize, f64)] {
        &self.entries[self.rows[i]..self.rows[i + 1]]
    }

    /// A row as a dense vector.
    pub fn row_of(&self, i: usize) -> DVector<f64> {
        let mut row = DVector::zeros(self.len());
        self.row(i).iter().for_each(|&(j, x)| row[j] = x);
        row
    }

    /// The number of rows.
    pub fn len(&self) -> usize {
        self.rows.len() - 1
    }

    /// Whether the matrix has no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The number of nonzero entries.
    pub fn entries(&self) -> usize {
        self.entries.len()
    }

    /// `to` = `factor` × matrix × `from`, beginning with row `first`.
    #[inline(always)]
    pub fn rows_times_to(&self, first: usize, from: &[f64], factor: f64, to: &mut [f64]) {
        let sliced = self.slices.as_ref().filter(|slices| slices.begin >= first);
        let (by_entries, by_slices) = to.split_at_mut(sliced.map_or(to.len(), |slices| slices.begin - first));
        for (y, ends) in by_entries.iter_mut().zip(self.rows[first..].windows(2)) {
            let row = &self.entries[ends[0]..ends[1]];
            *y = factor * row.iter().map(|&(j, x)| x * from[j]).sum::<f64>();
        }
        if let Some(slices) = sliced {
            slices.times_to(from, factor, by_slices);
        }
    }

    /// A row of the matrix times a vector.
    #[inline(always)]
    pub fn row_times(&self, i: usize, z: &[f64]) -> f64 {
        self.row(i).iter().map(|&(j, x)| x * z[j]).sum()
    }

    /// Some rows of the matrix times a vector.
    pub fn rows_times(&self, rows: Range<usize>, z: &[f64]) -> DVector<f64> {
        DVector::from_iterator(rows.len(), rows.map(|i| self.row_times(i, z)))
    }

    /// `to` = `factor` × `row` × matrix.
    pub fn after_row(&self, row: &[f64], factor: f64, to: &mut [f64]) {
        to.fill(0.0);
        for (i, &r) in row.iter().enumerate() {
            if r != 0.0 {
                self.row(i).iter().for_each(|&(j, x)| to[j] += r * x);
            }
        }
        to.iter_mut().for_each(|y| *y *= factor);
    }

    /// The row with these entries times the matrix, by its nonzero entries.
    pub fn after_terms(&self, terms: &[(usize, f64)]) -> Sparse {
        if let &[(i, r)] = terms {
            return Sparse::from_terms(self.row(i).iter().map(|&(j, x)| (j, r * x)));
        }
        let mut all: Vec<(usize, f64)> = Vec::new();
        for &(i, r) in terms {
            all.extend(self.row(i).iter().map(|&(j, x)| (j, r * x)));
        }
        sort_by_place(&mut all);
        all.dedup_by(|next, sum| {
            let same = next.0 == sum.0;
            if same {
                sum.1 += next.1;
            }
            same
        });
        Sparse::from_terms(all.into_iter())
    }

    /// The matrix minus outer products of a column and a row, both given by their entries.
    pub fn less<'t>(&self, products: impl Iterator<Item = [Entries<'t>; 2]>) -> Self {
        let mut changes: Vec<(usize, Entries, f64)> = Vec::new();
        for [column, row] in products {
            changes.extend(column.iter().map(|&(i, x)| (i, row, x)));
        }
        vibro_numerics::sorting::sort_by_key(&mut changes, |change| change.0);
        let mut sum = Self { rows: Vec::with_capacity(self.rows.len()), ..Self::default() };
        sum.rows.clear();
        sum.entries.reserve(self.entries.len() + 4 * changes.len());
        let (mut next, mut row) = (0, Vec::new());
        for i in 0..self.len() {
            sum.rows.push(sum.entries.len());
            if changes.get(next).is_none_or(|change| change.0 != i) {
                sum.entries.extend_from_slice(self.row(i));
                continue;
            }
            row.clear();
            row.extend_from_slice(self.row(i));
            while let Some(&(_, own, x)) = changes.get(next).filter(|change| change.0 == i) {
                for &(j, f) in own {
                    match row.iter_mut().find(|entry: &&mut (usize, f64)| entry.0 == j) {
                        Some(entry) => entry.1 -= x * f,
                        None => row.push((j, -x * f)),
                    }
                }
                next += 1;
            }
            sort_by_place(&mut row);
            sum.entries.extend(row.iter().filter(|entry| entry.1 != 0.0));
        }
        sum.rows.push(sum.entries.len());
        sum
    }

    /// Row `i` of the matrix of absolute values, times a vector.
    #[inline(always)]
    pub fn sizes_row_times(&self, i: usize, z: &[f64]) -> f64 {
        self.row(i).iter().map(|&(j, x)| x.abs() * z[j]).sum()
    }

    /// `to` = `factor` × the matrix of absolute values × `from`, beginning with row `first`.
    #[inline(always)]
    pub fn sizes_rows_times_to(&self, first: usize, from: &[f64], factor: f64, to: &mut [f64]) {
        to.iter_mut().enumerate().for_each(|(i, y)| *y = factor * self.sizes_row_times(first + i, from));
    }

    /// `to` = `factor` × `row` × the matrix of absolute values.
    pub fn sizes_after_row(&self, row: &[f64], factor: f64, to: &mut [f64]) {
        to.fill(0.0);
        for (i, &r) in row.iter().enumerate().filter(|(_, r)| **r != 0.0) {
            self.row(i).iter().for_each(|&(j, x)| to[j] += r * x.abs());
        }
        to.iter_mut().for_each(|y| *y *= factor);
    }

    /// `factor` × matrix × the transpose of `right`, transposed: whole columns are added up.
    pub fn times_rows(&self, right: &DMatrix<f64>, factor: f64) -> DMatrix<f64> {
        let size = right.nrows();
        let mut product = DMatrix::zeros(size, self.len());
        for (i, to) in product.as_mut_slice().chunks_mut(size).enumerate() {
            for &(j, x) in self.row(i) {
                to.iter_mut().zip(&right.as_slice()[j * size..][..size]).for_each(|(y, r)| *y += x * r);
            }
            to.iter_mut().for_each(|y| *y *= factor);
        }
        product
    }

    /// `to` = `factor` × matrix × `from`, for eight interleaved vectors.
    #[inline(always)]
    pub fn times_eight(&self, from: &[[f64; ABREAST]], factor: f64, to: &mut [[f64; ABREAST]]) {
        for (to, ends) in to.iter_mut().zip(self.rows.windows(2)) {
            let mut sums = [0.0; ABREAST];
            for &(j, x) in &self.entries[ends[0]..ends[1]] {
                let from = &from[j];
                (0..ABREAST).for_each(|i| sums[i] += x * from[i]);
            }
            *to = sums.map(|sum| sum * factor);
        }
    }

    /// The matrix of absolute values.
    pub fn abs(&self) -> Self {
        let entries = self.entries.iter().map(|&(j, x)| (j, x.abs())).collect();
        Self { rows: self.rows.clone(), entries, slices: None }
    }
}

/// Number of rows of a block, whose products are computed together.
const BLOCK: usize = 8;
/// Number of rows of the last block if no more are left.
const HALF: usize = BLOCK / 2;

/// Writes the first numbers into a list that may be shorter. The compiler would make a call of a
/// copy of unknown length, which takes longer than the product.
#[inline(always)]
fn put<const N: usize>(numbers: &[f64; N], to: &mut [f64]) {
    if to.len() == N {
        return to.copy_from_slice(numbers);
    }
    for k in 0..N {
        if k < to.len() {
            to[k] = numbers[k];
        }
    }
}

/// A dense matrix in blocks of eight rows; the last block has four if these suffice.
#[derive(Clone, Debug)]
pub struct Blocks {
    columns: usize,
    blocks: Vec<[f64; BLOCK]>,
    last: Vec<[f64; HALF]>,
}

impl Blocks {
    /// The blocks of a matrix.
    pub fn of(matrix: &DMatrix<f64>) -> Self {
        let (rows, columns) = matrix.shape();
        let left = rows % BLOCK;
        let whole = if left <= HALF { rows / BLOCK } else { rows / BLOCK + 1 };
        let mut blocks = vec![[0.0; BLOCK]; whole * columns];
        let mut last = vec![[0.0; HALF]; if whole * BLOCK < rows { columns } else { 0 }];
        for (j, column) in matrix.as_slice().chunks_exact(rows).enumerate() {
            let (of_blocks, of_last) = column.split_at(rows.min(whole * BLOCK));
            for (b, part) in of_blocks.chunks(BLOCK).enumerate() {
                blocks[b * columns + j][..part.len()].copy_from_slice(part);
            }
            if !of_last.is_empty() {
                last[j][..of_last.len()].copy_from_slice(of_last);
            }
        }
        Self { columns, blocks, last }
    }

    /// `to` = matrix × `from`.
    #[inline(always)]
    pub fn times(&self, from: &[f64], to: &mut [f64]) {
        let blocks = self.blocks.chunks_exact(self.columns);
        let (whole, last) = to.split_at_mut(to.len().min(blocks.len() * BLOCK));
        for (block, to) in blocks.zip(whole.chunks_mut(BLOCK)) {
            let sum = combine(block, from);
            put(&sum, to);
        }
        put(&combine(&self.last, from), last);
    }
}
