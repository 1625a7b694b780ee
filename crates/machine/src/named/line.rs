//! Straight lines in one named parameter, which some expressions are.

use vibro_numerics::Range;

/// `constant + slope · parameter`, with the index of the parameter; `None` for a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Line {
    pub place: Option<usize>,
    pub slope: f64,
    pub constant: f64,
}

impl Line {
    pub fn number(constant: f64) -> Self {
        Self { place: None, slope: 0.0, constant }
    }

    pub fn times(self, factor: f64) -> Self {
        Self { slope: factor * self.slope, constant: factor * self.constant, ..self }
    }

    /// The sum; `None` for lines in two different parameters.
    pub fn plus(self, other: Self) -> Option<Self> {
        let place = self.place.or(other.place);
        let is_one = self.place.is_none() || other.place.is_none() || self.place == other.place;
        let (slope, constant) = (self.slope + other.slope, self.constant + other.constant);
        is_one.then_some(Self { place, slope, constant })
    }

    /// The values of the parameter for which the line is within a range.
    pub fn within(self, range: &Range) -> Option<[f64; 2]> {
        let at = |value: f64| (value - self.constant) / self.slope;
        let [a, b] = [at(range.min), at(range.max)];
        let is_bound = self.slope != 0.0 && !a.is_nan() && !b.is_nan();
        is_bound.then(|| [a.min(b), a.max(b)])
    }
}
