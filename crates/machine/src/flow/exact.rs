//! Flows in double-double arithmetic. If stiff springs and soft forces contribute to an entry of
//! A, the entry is rounded to the last digit of the stiff part. Repeated doubling multiplies this
//! rounding error by 2^k, which disturbs slow motions on soft springs.

use super::apart::Apart;
use super::exponential::series_orders;
use nalgebra::DMatrix;
use vibro_numerics::double_double::DoubleDouble;

type Matrix = DMatrix<DoubleDouble>;

/// ∫ exp(A s) ds over a length and exp(A h) - 1 at its end.
#[derive(Clone, Debug)]
pub(super) struct Exact {
    integral: Matrix,
    change: Matrix,
}

impl Exact {
    /// The flow over one sub-step; `radius` is its length times the rate.
    pub(super) fn first(apart: &Apart, size: usize, length: f64, radius: f64) -> Self {
        let a = apart.matrix(size);
        let mut term = Matrix::from_element(size, size, DoubleDouble::default());
        term.fill_diagonal(DoubleDouble::new(1.0));
        let scaled = |m: &Matrix, factor: DoubleDouble| m.map(|x| x.times(factor));
        let length = DoubleDouble::new(length);
        let mut integral = scaled(&term, length);
        let mut change = term.map(|_| DoubleDouble::default());
        // Twice the digits of a double need about twice as many orders.
        for k in 1..=2 * series_orders(radius) {
            term = scaled(&product(&a, &term), length.times(reciprocal(k)));
            change = sum(&change, &term);
            integral = sum(&integral, &scaled(&term, length.times(reciprocal(k + 1))));
        }
        Self { integral, change }
    }

    /// The flow over twice the length.
    pub(super) fn doubled(&self) -> Self {
        let twice = |m: &Matrix| sum(m, m);
        Self {
            integral: sum(&twice(&self.integral), &product(&self.change, &self.integral)),
            change: sum(&twice(&self.change), &product(&self.change, &self.change)),
        }
    }

    /// Integral and change, rounded to doubles.
    pub(super) fn rounded(&self) -> [DMatrix<f64>; 2] {
        [&self.integral, &self.change].map(|m| m.map(DoubleDouble::value))
    }

    /// Count of stored numbers.
    pub(super) fn numbers(&self) -> usize {
        4 * self.change.len()
    }
}

/// 1/k, to 32 digits.
fn reciprocal(k: usize) -> DoubleDouble {
    let (k, first) = (DoubleDouble::new(k as f64), 1.0 / k as f64);
    let left = DoubleDouble::new(1.0).minus(k.times(DoubleDouble::new(first)));
    DoubleDouble::new(first) + DoubleDouble::new(left.value() * first)
}

fn sum(a: &Matrix, b: &Matrix) -> Matrix {
    a.zip_map(b, |a, b| a + b)
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let (zero, size) = (DoubleDouble::default(), a.nrows());
    let mut all = Matrix::from_element(size, b.ncols(), zero);
    for (column, to) in b.as_slice().chunks(size).zip(all.as_mut_slice().chunks_mut(size)) {
        let terms = column.iter().zip(a.as_slice().chunks(size)).filter(|(x, _)| **x != zero);
        terms.for_each(|(x, from)| to.iter_mut().zip(from).for_each(|(y, a)| *y = *y + a.times(*x)));
    }
    all
}
