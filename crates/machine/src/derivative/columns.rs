//! A state and its derivatives, stored side by side.

use nalgebra::DVector;

/// The width of a coordinate is a multiple of this: a whole number of vectors of any instruction
/// set.
const LANES: usize = 8;

/// A state and the columns of its derivative, stored by coordinate, so that a matrix entry
/// multiplies all of them at once. The first number of each coordinate is the state.
#[derive(Clone, Debug, Default)]
pub(super) struct Columns {
    /// Numbers of each coordinate.
    pub width: usize,
    pub numbers: Vec<f64>,
}

/// Rounds `count` numbers up to whole vectors of the processor.
pub(super) fn padded(count: usize) -> usize {
    count.next_multiple_of(LANES)
}

/// Numbers per coordinate, for `count` columns and the state.
pub(super) fn width_of(count: usize) -> usize {
    padded(count + 1)
}

impl Columns {
    /// Zeros for a state with `size` coordinates and `count` columns.
    pub fn zeros(size: usize, count: usize) -> Self {
        let width = width_of(count);
        Self { width, numbers: vec![0.0; size * width] }
    }

    /// Sets the state.
    pub fn put_state(&mut self, z: &[f64]) {
        self.numbers.iter_mut().step_by(self.width).zip(z).for_each(|(own, x)| *own = *x);
    }

    /// The state.
    pub fn state(&self) -> DVector<f64> {
        let size = self.numbers.len() / self.width;
        DVector::from_iterator(size, self.numbers.iter().step_by(self.width).copied())
    }

    /// Column `p`.
    pub fn column(&self, p: usize) -> DVector<f64> {
        let size = self.numbers.len() / self.width;
        DVector::from_iterator(size, self.numbers[p + 1..].iter().step_by(self.width).copied())
    }

    /// Sets column `p`.
    pub fn put(&mut self, p: usize, from: &DVector<f64>) {
        let own = self.numbers[p + 1..].iter_mut().step_by(self.width);
        own.zip(from.iter()).for_each(|(own, x)| *own = *x);
    }

    /// Sets each number to the size of the corresponding number of `other`, if that is larger.
    pub fn include(&mut self, other: &Self) {
        let all = self.numbers.iter_mut().zip(&other.numbers);
        all.for_each(|(most, x)| *most = if x.abs() > *most { x.abs() } else { *most });
    }
}
