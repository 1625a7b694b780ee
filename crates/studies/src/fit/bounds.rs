//! Ranges of the free parameters of a fit.

use super::evaluated::{Change, Point};
use super::model::Model;
use super::{FitRequest, MOST_FREE};
use crate::error::{Error, Result};
use crate::{significant, sobol};

/// Lower bound while segments are apart, as a fraction of a positive initial value.
const INSIDE: f64 = 0.02;

/// Largest growth of a positive parameter in a rough descent, and in restarts near a point.
const MOST_GROWTH: f64 = 10.0;

/// Ranges and initial values of the free parameters.
#[derive(Clone, Debug)]
pub(super) struct Bounds {
    pub begin: Vec<f64>,
    pub low: Vec<f64>,
    pub high: Vec<f64>,
    pub names: Vec<String>,
    given: Vec<bool>,
}

impl Bounds {
    pub fn of(request: &FitRequest, model: &Model) -> Result<Self> {
        let refused = |problem: String| Err(Error::Described { problem });
        let free = &request.free;
        if free.is_empty() || free.len() > MOST_FREE {
            return refused(format!("{} free parameters: expected 1 to {MOST_FREE}", free.len()));
        }
        if let Some(i) = (1..free.len()).find(|&i| free[..i].iter().any(|own| own.name == free[i].name)) {
            return refused(format!(
                "{} is given twice; give each free parameter once, as a shared or as an own one",
                free[i].name
            ));
        }
        let begin = model.unknowns.begin.clone();
        let (mut low, mut high) = (Vec::new(), Vec::new());
        for (k, own) in free.iter().enumerate() {
            let (least, most) = own.within.unwrap_or_else(|| model.unknowns.allowed(k));
            if least >= most || least.is_nan() || most.is_nan() {
                return refused(format!(
                    "{} within {least} to {most}: the lower end must be less than the upper end",
                    own.name
                ));
            }
            if !(least..=most).contains(&begin[k]) {
                let told = |value: f64| request.machine.told(&own.name, value);
                return refused(format!(
                    "{}: the initial value {} is outside its range, {} to {}; widen the range (--within), or \
                     set another value (--set)",
                    own.name,
                    told(begin[k]),
                    told(least),
                    told(most)
                ));
            }
            low.push(least);
            high.push(most);
        }
        let names = free.iter().map(|own| own.name.clone()).collect();
        let given = free.iter().map(|own| own.within.is_some()).collect();
        Ok(Self { begin, low, high, names, given })
    }

    /// Bounds of `count` joint parameters. `places` has the joint indices of each record's
    /// parameters, `names` the names of the records; `rows` is the number of residuals of all
    /// records.
    pub fn joint(
        all: &[Self],
        (places, count): (&[Vec<usize>], usize),
        (names, rows): (&[String], usize),
    ) -> Result<Self> {
        let refused = |problem: String| Err(Error::Described { problem });
        if count > MOST_FREE {
            return refused(format!("{count} free parameters of all records: expected at most {MOST_FREE}"));
        }
        if rows < count {
            return refused(format!(
                "the record has {rows} samples for {count} free parameters; expected at least {count} samples"
            ));
        }
        // Records that have a joint parameter, each with the parameter's index there.
        let of = |joint: usize| -> Vec<(usize, usize)> {
            let place = |own: &Vec<usize>| own.iter().position(|place| *place == joint);
            places.iter().enumerate().filter_map(|(k, own)| Some((k, place(own)?))).collect()
        };
        let mut found = Self { begin: vec![], low: vec![], high: vec![], names: vec![], given: vec![] };
        for joint in 0..count {
            let records = of(joint);
            let Some(&(record, place)) = records.first() else { continue };
            let own = &all[record];
            let name = &own.names[place];
            let differs = |(k, there): &&(usize, usize)| all[*k].begin[*there] != own.begin[place];
            if let Some((other, there)) = records.iter().find(differs) {
                return refused(format!(
                    "{name} begins at {} in {} and at {} in {}; expected the same \
                     value in all records, or a parameter that each record has for itself (--own)",
                    own.begin[place], names[record], all[*other].begin[*there], names[*other]
                ));
            }
            let is_one_of_many = records.len() < all.len();
            found.begin.push(own.begin[place]);
            found.low.push(own.low[place]);
            found.high.push(own.high[place]);
            found.given.push(own.given[place]);
            found.names.push(if is_one_of_many {
                format!("{name} of {}", names[record])
            } else {
                name.clone()
            });
        }
        Ok(found)
    }

    /// Bounds of one record's parameters, by joint indices, with their own initial values.
    pub fn local(&self, places: &[usize], begin: &[f64]) -> Self {
        let of = |all: &[f64]| places.iter().map(|&place| all[place]).collect();
        Self {
            begin: begin.to_vec(),
            low: of(&self.low),
            high: of(&self.high),
            names: places.iter().map(|&place| self.names[place].clone()).collect(),
            given: places.iter().map(|&place| self.given[place]).collect(),
        }
    }

    /// Parameters at an end of their range, with that end.
    pub fn reached(&self, values: &[f64]) -> Vec<(String, f64)> {
        let ends = self.low.iter().zip(&self.high);
        let all = self.names.iter().zip(values).zip(ends);
        let is_reached = all.filter(|((_, value), (low, high))| *value == *low || *value == *high);
        is_reached.map(|((name, value), _)| (name.clone(), *value)).collect()
    }

    /// Point `k` of the Sobol sequence within the bounds.
    pub fn within(&self, k: u32) -> Result<Vec<f64>> {
        let at = |i: usize| {
            if !self.given[i] {
                let problem = format!(
                    "further starts require a range of each free parameter; give a range of {} by \
                     --within (within= in Python)",
                    self.names[i]
                );
                return Err(Error::Described { problem });
            }
            Ok(self.low[i] + (self.high[i] - self.low[i]) * sobol::coordinate(k, i))
        };
        (0..self.begin.len()).map(at).collect()
    }

    /// Point `k` of the Sobol sequence around a start: within a relative distance and the bounds.
    pub fn beside(&self, start: &[f64], k: u32, part: f64) -> Vec<f64> {
        let at = |i: usize| {
            let moved = start[i] * (1.0 + part * (2.0 * sobol::coordinate(k, i) - 1.0));
            moved.clamp(self.low[i], self.high[i])
        };
        (0..start.len()).map(at).collect()
    }

    /// Values clamped to the bounds.
    pub fn cut(&self, values: Vec<f64>) -> Vec<f64> {
        let ends = self.low.iter().zip(&self.high);
        values.into_iter().zip(ends).map(|(x, (low, high))| x.clamp(*low, *high)).collect()
    }

    /// Bounds that exclude 0 if the start is positive: at 0 a parameter has no derivative.
    pub fn inside(&self, start: &[f64]) -> Self {
        let mut bounds = self.clone();
        for (low, x) in bounds.low.iter_mut().zip(start) {
            if *low == 0.0 && *x > 0.0 {
                *low = INSIDE * x;
            }
        }
        bounds
    }

    /// Bounds within which a positive parameter grows at most tenfold over given values. A
    /// parameter that a record hardly determines would otherwise grow by any factor, and motions
    /// of a stiff machine take long.
    pub fn near(&self, values: &[f64]) -> Self {
        let mut bounds = self.clone();
        for (j, x) in values.iter().enumerate() {
            if bounds.low[j] >= 0.0 && *x > 0.0 {
                bounds.high[j] = bounds.high[j].min(MOST_GROWTH * x);
            }
        }
        bounds
    }

    /// Bounds that hold a parameter at a value.
    pub fn held(&self, number: usize, value: f64) -> Self {
        let mut bounds = self.clone();
        (bounds.low[number], bounds.high[number]) = (value, value);
        bounds
    }

    /// Values with their names, as text.
    pub fn told(&self, values: &[f64]) -> String {
        let all = self.names.iter().zip(values).map(|(name, x)| format!("{name} = {}", significant(*x)));
        all.collect::<Vec<_>>().join(", ")
    }

    /// Point after a change, with the change clamped to the bounds.
    pub fn moved(&self, point: &Point, change: &mut Change) -> Point {
        let mut next = point.clone();
        for (j, value) in next.values.iter_mut().enumerate() {
            let before = *value;
            *value = (before + change.values[j]).clamp(self.low[j], self.high[j]);
            change.values[j] = *value - before;
        }
        for (state, change) in next.states.iter_mut().zip(&change.states) {
            state.iter_mut().zip(change).for_each(|(x, dx)| *x += dx);
        }
        next
    }

    /// Whether a parameter is at a bound that the step would cross.
    pub fn holds(&self, i: usize, value: f64, step: f64) -> bool {
        (value <= self.low[i] && step < 0.0) || (value >= self.high[i] && step > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invariant_only_positive_parameters_have_a_limit_near_a_point() {
        let bounds = Bounds {
            begin: vec![2.0, 0.0, -1.0, 2.0, 1.0],
            low: vec![0.0, 0.0, -5.0, 1.0, -1.0],
            high: vec![f64::INFINITY, 9.0, 9.0, 9.0, 99.0],
            names: vec![String::new(); 5],
            given: vec![false; 5],
        };
        let near = bounds.near(&[2.0, 0.0, -1.0, 2.0, 1.0]);
        assert_eq!(near.high, [2.0 * MOST_GROWTH, 9.0, 9.0, 9.0, 99.0]);
        assert_eq!(near.low, bounds.low);
    }

    #[test]
    fn invariant_bounds_inside_leave_out_0_below_a_positive_start_alone() {
        let bounds = Bounds {
            begin: vec![2.0, 0.0, -1.0, 2.0],
            low: vec![0.0, 0.0, -5.0, 1.0],
            high: vec![9.0; 4],
            names: vec![String::new(); 4],
            given: vec![false; 4],
        };
        let inside = bounds.inside(&bounds.begin);
        assert_eq!(inside.low, [2.0 * INSIDE, 0.0, -5.0, 1.0]);
        assert_eq!(inside.high, bounds.high);
    }
}
