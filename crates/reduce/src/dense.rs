//! Products of tall dense matrices by `faer`, since the products of nalgebra are not blocked in
//! this build.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::DMatrix;
use std::ops::Range;

fn columns<'m>(a: &'m DMatrix<f64>, range: &Range<usize>) -> MatRef<'m, f64> {
    let rows = a.nrows();
    MatRef::from_column_major_slice(&a.as_slice()[range.start * rows..range.end * rows], rows, range.len())
}

/// Aᵀ B for some columns of A.
pub fn transposed_times(a: &DMatrix<f64>, range: Range<usize>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut product = DMatrix::zeros(range.len(), b.ncols());
    let (rows, width) = product.shape();
    let into = MatMut::from_column_major_slice_mut(product.as_mut_slice(), rows, width);
    let b = columns(b, &(0..width));
    matmul(into, Accum::Replace, columns(a, &range).transpose(), b, 1.0, Par::Seq);
    product
}

/// C += factor A B for some columns of A.
pub fn add_product(
    c: &mut DMatrix<f64>,
    factor: f64,
    a: &DMatrix<f64>,
    range: Range<usize>,
    b: &DMatrix<f64>,
) {
    let (rows, width) = c.shape();
    let into = MatMut::from_column_major_slice_mut(c.as_mut_slice(), rows, width);
    matmul(into, Accum::Add, columns(a, &range), columns(b, &(0..width)), factor, Par::Seq);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::factor::random;

    /// Sums of a few hundred products.
    const ROUNDING: f64 = 1e-13;

    #[test]
    fn second_method_products_are_those_of_nalgebra() {
        let (a, b, c) = (random(300, 7, 1), random(300, 4, 2), random(3, 4, 3));
        let own = a.columns(2, 3).into_owned();
        assert!((transposed_times(&a, 2..5, &b) - own.transpose() * &b).amax() < ROUNDING);
        let mut sum = b.clone();
        add_product(&mut sum, -0.5, &a, 2..5, &c);
        assert!((sum - (b - own * c * 0.5)).amax() < ROUNDING);
    }
}
