//! Residuals of a motion against a record, and their derivatives.

use nalgebra::DMatrix;

/// A parameter is idle if no residual changes by more than this when the parameter changes by its
/// own value (by one SI unit if it is 0). Its derivatives are rounding and would lead to unbounded
/// steps.
const IDLE: f64 = 1e-12;
/// Zero tolerance of a parameter, SI: rounding of a parameter whose fitted value is 0.
const NEARLY_0: f64 = 1e-12;

/// Node that marks the next of several records, whose motion has a start of its own.
pub(super) const NEXT_RECORD: f64 = f64::NEG_INFINITY;

/// Point of a fit: the free parameters, and the initial states of all segments but the first.
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

/// Change of a [`Point`], or a scale for each of its components.
pub(super) type Change = Point;

impl std::ops::Mul<f64> for &Change {
    type Output = Change;

    fn mul(self, factor: f64) -> Change {
        let of = |own: &Vec<f64>| own.iter().map(|x| x * factor).collect();
        Change { values: of(&self.values), states: self.states.iter().map(of).collect() }
    }
}

impl Point {
    /// Shortens a change to at most a fraction of each value; values of 0 set no limit.
    pub fn limit(&mut self, values: &[f64], part: f64) {
        let pairs = self.values.iter().zip(values).filter(|(_, x)| **x != 0.0);
        let most = pairs.fold(0.0, |most: f64, (change, x)| most.max((change / x).abs()));
        if most > part {
            let all = self.values.iter_mut().chain(self.states.iter_mut().flatten());
            all.for_each(|change| *change *= part / most);
        }
    }

    /// Norm of a change with the given scales.
    pub fn length(&self, sizes: &Change) -> f64 {
        let pair =
            |(a, b): (&Vec<f64>, &Vec<f64>)| -> f64 { a.iter().zip(b).map(|(x, s)| (x * s).powi(2)).sum() };
        (pair((&self.values, &sizes.values)) + self.states.iter().zip(&sizes.states).map(pair).sum::<f64>())
            .sqrt()
    }
}

/// End of the record's used part, and nodes at which new segments begin.
#[derive(Clone, Debug)]
pub(super) struct Reach {
    /// End of the fitted part of the record, s.
    pub end: f64,
    /// Start times of the segments after the first, as times of the record, s.
    pub nodes: Vec<f64>,
    /// Weight of the defect between a segment's end and the next one's start, for each state
    /// component.
    pub weights: Vec<f64>,
}

impl Reach {
    /// A single motion up to a time.
    pub fn whole(end: f64) -> Self {
        Self { end, nodes: Vec::new(), weights: Vec::new() }
    }

    /// Whether each record has a single motion.
    pub fn is_whole(&self) -> bool {
        self.nodes.iter().all(|node| *node == NEXT_RECORD)
    }
}

/// Value with its derivatives with respect to the free parameters, then the segment's initial
/// state; `None` for a derivative that does not exist.
pub(super) type Varied = (f64, Vec<Option<f64>>);

/// Residuals in units of the standard deviation, with their derivatives.
pub(super) struct Rows {
    pub residuals: Vec<f64>,
    /// Derivatives with respect to the segment's initial state; no columns in the first segment.
    pub by_state: DMatrix<f64>,
    pub by_numbers: DMatrix<f64>,
}

impl Rows {
    /// Rows from values with derivatives, each divided by its unit.
    pub fn of(rows: &[(Varied, f64)], (unknowns, states): (usize, usize)) -> Self {
        let entry = |i: usize, j: usize| rows[i].0.1[j].unwrap_or(0.0) / rows[i].1;
        Self {
            residuals: rows.iter().map(|((value, _), unit)| value / unit).collect(),
            by_state: DMatrix::from_fn(rows.len(), states, |i, j| entry(i, unknowns + j)),
            by_numbers: DMatrix::from_fn(rows.len(), unknowns, entry),
        }
    }

    /// Moves the free parameters to other columns among a larger number of parameters.
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

/// Segment of a motion and its part of the record.
pub(super) struct Segment {
    pub rows: Rows,
    /// Time and column of each row; contact columns follow the columns of quantities. Rows of one
    /// time are adjacent.
    pub places: Vec<(f64, usize)>,
    /// The segment's end minus the next one's start, weighted; `None` for the last segment.
    pub defect: Option<Rows>,
    /// Negative derivative of each row of `defect` with respect to the next segment's state.
    pub weights: Vec<f64>,
    /// Whether some derivatives are finite differences.
    pub has_differences: bool,
    /// Index of the record.
    pub record: usize,
}

impl Segment {
    /// Assigns the segment to one of several records: moves its parameters to other columns among
    /// a larger number, and numbers its columns after the columns of earlier records.
    pub fn place(&mut self, record: usize, (places, count): (&[usize], usize), columns: usize) {
        self.record = record;
        self.rows.place(places, count);
        self.defect.iter_mut().for_each(|rows| rows.place(places, count));
        self.places.iter_mut().for_each(|(_, column)| *column += columns);
    }
}

/// Residuals of all segments.
pub(super) struct Evaluated(pub Vec<Segment>);

impl Evaluated {
    /// Whether all residuals and derivatives are finite.
    pub fn is_finite(&self) -> bool {
        self.0.iter().all(|own| own.rows.is_finite() && own.defect.as_ref().is_none_or(Rows::is_finite))
    }

    /// Residuals of all segments.
    pub fn residuals(&self) -> impl Iterator<Item = f64> {
        self.0.iter().flat_map(|own| own.rows.residuals.iter().copied())
    }

    /// Time and column of each residual.
    pub fn places(&self) -> impl Iterator<Item = (f64, usize)> {
        self.0.iter().flat_map(|own| own.places.iter().copied())
    }

    /// Whether some derivatives are finite differences.
    pub fn has_differences(&self) -> bool {
        self.0.iter().any(|own| own.has_differences)
    }

    /// Sum of squares of the defects.
    pub fn defects(&self) -> f64 {
        let all = self.0.iter().filter_map(|own| own.defect.as_ref());
        all.flat_map(|own| own.residuals.iter()).map(|r| r * r).sum()
    }
}

impl Evaluated {
    /// Whether a free parameter of this value has no effect on the motion.
    pub(super) fn is_idle(&self, j: usize, value: f64) -> bool {
        let size = if value.abs() <= NEARLY_0 { 1.0 } else { value.abs() };
        self.0.iter().all(|own| own.rows.by_numbers.column(j).amax() * size <= IDLE)
    }
}

/// Result of a search.
#[derive(Clone, Debug)]
pub(super) struct Solved {
    pub point: Point,
    pub reach: Reach,
    /// Sum of losses, without the defects.
    pub cost: f64,
    /// Whether each segment ends at the next one's start.
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
