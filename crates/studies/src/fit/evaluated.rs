//! Residuals of a motion beside a record, and their derivatives by what is fitted.

use nalgebra::DMatrix;

/// Change of all residuals by the whole of a number (of 0, by one SI unit) up to which it moves
/// nothing: a derivative that is rounding would ask for a change without bound.
const IDLE: f64 = 1e-12;
/// Size of a number, SI, up to which it counts as 0: one that is fitted to be 0 is its rounding.
const NEARLY_0: f64 = 1e-12;

/// Node at which the next of several records begins, whose motion has a start of its own.
pub(super) const NEXT_RECORD: f64 = f64::NEG_INFINITY;

/// Where a fit stands: the free numbers, and the states in which segments after the first begin.
#[derive(Clone, Debug, Default)]
pub(super) struct Point {
    pub values: Vec<f64>,
    pub states: Vec<Vec<f64>>,
}

impl From<Vec<f64>> for Point {
    fn from(values: Vec<f64>) -> Self {
        Self { values, states: Vec::new() }
    }
}

/// A change of a [`Point`], or a size for each of its numbers.
pub(super) type Change = Point;

impl Point {
    /// Shortens a change to a part of each value at most; values of 0 set no bound.
    pub fn limit(&mut self, values: &[f64], part: f64) {
        let pairs = self.values.iter().zip(values).filter(|(_, x)| **x != 0.0);
        let most = pairs.fold(0.0, |most: f64, (change, x)| most.max((change / x).abs()));
        if most > part {
            let all = self.values.iter_mut().chain(self.states.iter_mut().flatten());
            all.for_each(|change| *change *= part / most);
        }
    }

    /// The length of a change whose numbers count by sizes.
    pub fn length(&self, sizes: &Change) -> f64 {
        let pair =
            |(a, b): (&Vec<f64>, &Vec<f64>)| -> f64 { a.iter().zip(b).map(|(x, s)| (x * s).powi(2)).sum() };
        (pair((&self.values, &sizes.values)) + self.states.iter().zip(&sizes.states).map(pair).sum::<f64>())
            .sqrt()
    }
}

/// How far a record counts, and where segments of the motion begin anew.
#[derive(Clone, Debug)]
pub(super) struct Reach {
    /// Time of the record up to which it counts, s.
    pub end: f64,
    /// Times of the record at which segments after the first begin, s.
    pub nodes: Vec<f64>,
    /// How much a segment's end that is not the next one's start counts, by number of the state, as
    /// a residual.
    pub weights: Vec<f64>,
}

impl Reach {
    /// One motion up to a time.
    pub fn whole(end: f64) -> Self {
        Self { end, nodes: Vec::new(), weights: Vec::new() }
    }

    /// Whether each record has one motion.
    pub fn is_whole(&self) -> bool {
        self.nodes.iter().all(|node| *node == NEXT_RECORD)
    }
}

/// A number of a motion with its derivatives by the free numbers, then by the segment's first
/// state; `None` where it has none.
pub(super) type Varied = (f64, Vec<Option<f64>>);

/// Residuals in units of the standard deviations, with their derivatives.
pub(super) struct Rows {
    pub residuals: Vec<f64>,
    /// By the state in which the segment begins; without columns in the first one.
    pub by_state: DMatrix<f64>,
    pub by_numbers: DMatrix<f64>,
}

impl Rows {
    /// Rows of values with derivatives, each value over its unit.
    pub fn of(rows: &[(Varied, f64)], (unknowns, states): (usize, usize)) -> Self {
        let entry = |i: usize, j: usize| rows[i].0.1[j].unwrap_or(0.0) / rows[i].1;
        Self {
            residuals: rows.iter().map(|((value, _), unit)| value / unit).collect(),
            by_state: DMatrix::from_fn(rows.len(), states, |i, j| entry(i, unknowns + j)),
            by_numbers: DMatrix::from_fn(rows.len(), unknowns, entry),
        }
    }

    /// Gives the free numbers other places among a larger count of numbers.
    fn place(&mut self, places: &[usize], count: usize) {
        let mut all = DMatrix::zeros(self.by_numbers.nrows(), count);
        for (own, &place) in self.by_numbers.column_iter().zip(places) {
            all.set_column(place, &own);
        }
        self.by_numbers = all;
    }

    fn is_finite(&self) -> bool {
        let all = self.by_state.iter().chain(self.by_numbers.iter());
        self.residuals.iter().chain(all).all(|x| x.is_finite())
    }
}

/// A segment of a motion beside its part of the record.
pub(super) struct Segment {
    pub rows: Rows,
    /// Time and column of each row; the columns of contacts follow those of quantities. Rows of one
    /// time stand together.
    pub places: Vec<(f64, usize)>,
    /// The segment's end less the start of the next one, over its weight; `None` of the last.
    pub defect: Option<Rows>,
    /// Derivative of a row of `defect` by its number of the next segment's state, negative.
    pub weights: Vec<f64>,
    /// Whether differences stand in for some of its derivatives.
    pub has_differences: bool,
    /// Index of its record among several.
    pub record: usize,
}

impl Segment {
    /// Makes the segment one of a record among several: with the free numbers at other places among
    /// a larger count, and columns after the columns of the records before.
    pub fn place(&mut self, record: usize, (places, count): (&[usize], usize), columns: usize) {
        self.record = record;
        self.rows.place(places, count);
        self.defect.iter_mut().for_each(|rows| rows.place(places, count));
        self.places.iter_mut().for_each(|(_, column)| *column += columns);
    }
}

/// Residuals over all segments.
pub(super) struct Evaluated(pub Vec<Segment>);

impl Evaluated {
    /// Whether all its numbers are finite.
    pub fn is_finite(&self) -> bool {
        self.0.iter().all(|own| own.rows.is_finite() && own.defect.as_ref().is_none_or(Rows::is_finite))
    }

    /// The residuals of all segments.
    pub fn residuals(&self) -> impl Iterator<Item = f64> {
        self.0.iter().flat_map(|own| own.rows.residuals.iter().copied())
    }

    /// Time and column of each of them.
    pub fn places(&self) -> impl Iterator<Item = (f64, usize)> {
        self.0.iter().flat_map(|own| own.places.iter().copied())
    }

    /// Whether differences stand in for some of the derivatives.
    pub fn has_differences(&self) -> bool {
        self.0.iter().any(|own| own.has_differences)
    }

    /// What the defects count.
    pub fn defects(&self) -> f64 {
        let all = self.0.iter().filter_map(|own| own.defect.as_ref());
        all.flat_map(|own| own.residuals.iter()).map(|r| r * r).sum()
    }
}

impl Evaluated {
    /// Whether the motion stays as it is whatever a free number of some value does.
    pub(super) fn is_idle(&self, j: usize, value: f64) -> bool {
        let size = if value.abs() <= NEARLY_0 { 1.0 } else { value.abs() };
        self.0.iter().all(|own| own.rows.by_numbers.column(j).amax() * size <= IDLE)
    }
}

/// A point reached.
#[derive(Clone, Debug)]
pub(super) struct Solved {
    pub point: Point,
    pub reach: Reach,
    /// The sum of losses, without that of defects.
    pub cost: f64,
    /// Whether no segment misses the next one's start.
    pub is_continuous: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_a_change_is_shortened_to_a_part_of_each_value_that_is_not_zero() {
        let mut change = Point { values: vec![3.0, 1.0, -1.0], states: vec![vec![6.0]] };
        change.limit(&[1.0, 0.0, 4.0], 0.5);
        // The first number may change by half of its value: a sixth of the whole change is left.
        assert_eq!(change.values, [0.5, 1.0 / 6.0, -1.0 / 6.0]);
        assert_eq!(change.states, [[1.0]]);
        change.limit(&[1.0, 0.0, 4.0], 0.5);
        assert_eq!(change.values[0], 0.5);
    }
}
