//! Ranges of named parameters that follow from the ranges of numbers.

use super::line::Line;
use super::{Expression, Named, NamedParameters};
use vibro_numerics::Range;

impl NamedParameters {
    /// Range of each parameter, from the ranges of numbers that are straight lines in this
    /// parameter alone, such as `= backlash / 2`. The range contains the present value in spite of
    /// rounding. A number that depends on several parameters gives no range.
    pub(crate) fn ranges(&self, range_of: impl Fn(&str) -> Option<Range>) -> Vec<[f64; 2]> {
        let own = |(place, named): (usize, &Named)| {
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
