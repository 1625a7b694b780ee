//! A state and its derivatives side by side.

use nalgebra::DVector;

/// Numbers of a coordinate come in multiples of these, so that every kind of vectors divides them.
const LANES: usize = 8;

/// A state and the columns of its derivative, coordinate by coordinate, so that an entry of a
/// matrix multiplies all of them at once. The state is the first number of each coordinate.
#[derive(Clone, Debug, Default)]
pub(super) struct Columns {
    /// Numbers of each coordinate.
    pub width: usize,
    pub numbers: Vec<f64>,
}

/// The length of a vector of `count` numbers that is divided into whole vectors of the processor.
pub(super) fn padded(count: usize) -> usize {
    count.next_multiple_of(LANES)
}

/// The numbers of a coordinate with `count` columns beside the state.
pub(super) fn width_of(count: usize) -> usize {
    padded(count + 1)
}

impl Columns {
    /// Zeros of a state with `size` coordinates and `count` columns.
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

    /// Becomes the largest sizes of its own numbers and of another's.
    pub fn include(&mut self, other: &Self) {
        let all = self.numbers.iter_mut().zip(&other.numbers);
        all.for_each(|(most, x)| *most = if x.abs() > *most { x.abs() } else { *most });
    }
}
