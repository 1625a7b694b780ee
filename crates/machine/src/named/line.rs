//! Expressions as straight lines in one named parameter, and the ranges of parameters that follow.

use super::{Expression, NamedParameters};
use vibro_numerics::Range;

/// `constant + slope · parameter`, with the parameter's place; a number without a place.
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
    fn within(self, range: &Range) -> Option<[f64; 2]> {
        let at = |value: f64| (value - self.constant) / self.slope;
        let [a, b] = [at(range.min), at(range.max)];
        let is_bound = self.slope != 0.0 && !a.is_nan() && !b.is_nan();
        is_bound.then(|| [a.min(b), a.max(b)])
    }
}

impl NamedParameters {
    /// The range of each parameter that follows from the ranges of the numbers that are straight
    /// lines in it alone, such as `= backlash / 2`. It contains the present value in spite of
    /// rounding. A number of several parameters gives no range.
    pub(crate) fn ranges(&self, range_of: impl Fn(&str) -> Option<Range>) -> Vec<[f64; 2]> {
        let own = |(place, named): (usize, &super::Named)| {
            named.expression.is_none().then_some(Line { place: Some(place), slope: 1.0, constant: 0.0 })
        };
        let mut lines: Vec<Option<Line>> = self.all.iter().enumerate().map(own).collect();
        for &place in &self.order {
            lines[place] = self.all[place].expression.as_ref().and_then(|own| own.line(&lines));
        }
        let mut ranges = vec![[f64::NEG_INFINITY, f64::INFINITY]; self.all.len()];
        let of = |(number, expression): (&String, &Expression)| {
            let line = expression.line(&lines)?;
            Some((line.place?, line.within(&range_of(number)?)?))
        };
        for (place, [low, high]) in self.numbers.iter().filter_map(of) {
            let (value, range) = (self.all[place].value, &mut ranges[place]);
            *range = [range[0].max(low).min(value), range[1].min(high).max(value)];
        }
        ranges
    }
}
