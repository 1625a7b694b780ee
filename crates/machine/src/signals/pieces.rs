//! Piecewise functions of time: records and staircases, single or repeated.

use super::shifted;
use crate::description::{Interpolation, Record, Step};
use vibro_numerics::double_double::DoubleDouble;

/// A knot of a repeated function: number of whole periods before it, and index in the period.
pub(super) type Place = (f64, usize);

/// Sorted times, in each period if they repeat. Knot i of turn k is at k·period + tᵢ, rounded
/// once.
#[derive(Clone, Debug, Default)]
pub(super) struct Knots {
    pub times: Vec<f64>,
    pub repeat: Option<f64>,
}

/// The exact time of a knot.
fn exactly(period: f64, turn: f64, time: f64) -> DoubleDouble {
    DoubleDouble::new(period).times(DoubleDouble::new(turn)).plus(time)
}

impl Knots {
    /// The time of a knot, exactly.
    pub fn at(&self, (turn, place): Place) -> DoubleDouble {
        match self.repeat {
            Some(period) => exactly(period, turn, self.times[place]),
            None => DoubleDouble::new(self.times[place]),
        }
    }

    /// The last knot up to a time; `None` before the first.
    pub fn last(&self, time: f64) -> Option<Place> {
        let Some(period) = self.repeat else {
            return self.last_of_once(time).map(|place| (0.0, place));
        };
        let turns = (time / period).floor();
        // A rounded quotient may be one off, and a rounded knot may belong to the next turn.
        [turns + 1.0, turns, turns - 1.0].into_iter().find_map(|turn| {
            let after = self.times.partition_point(|&t| exactly(period, turn, t).value() <= time);
            after.checked_sub(1).map(|place| (turn, place))
        })
    }

    /// Index of the last knot up to a time, for knots that do not repeat. The index for equally
    /// spaced knots, as most records have them, is tried first.
    fn last_of_once(&self, time: f64) -> Option<usize> {
        let (first, last) = (*self.times.first()?, *self.times.last()?);
        let guess = ((time - first) / (last - first) * (self.times.len() - 1) as f64) as usize;
        let is_last = |&place: &usize| {
            self.times.get(place).is_some_and(|own| *own <= time)
                && self.times.get(place + 1).is_none_or(|next| *next > time)
        };
        // A rounded quotient may be one off.
        let near = [guess, guess.saturating_sub(1), guess.saturating_add(1)].into_iter().find(is_last);
        near.or_else(|| self.times.partition_point(|&t| t <= time).checked_sub(1))
    }

    /// The first knot after a time.
    pub fn next(&self, time: f64) -> Option<DoubleDouble> {
        let after = match (self.last(time), self.repeat) {
            (None, None) => (0.0, 0),
            (Some((turn, place)), _) if place + 1 < self.times.len() => (turn, place + 1),
            (Some((turn, _)), Some(_)) => (turn + 1.0, 0),
            _ => return None,
        };
        (after.1 < self.times.len()).then(|| self.at(after))
    }

    /// The number of knots at a time.
    pub fn count_at(&self, time: f64) -> usize {
        let Some(mut place) = self.last(time) else { return 0 };
        let mut count = 0;
        while self.at(place).value() == time {
            count += 1;
            place = match (place, self.repeat) {
                ((turn, at), _) if at > 0 => (turn, at - 1),
                ((turn, _), Some(_)) => (turn - 1.0, self.times.len() - 1),
                _ => break,
            };
        }
        count
    }
}

/// A function that is a polynomial from each knot to the next, by its value and derivatives there.
#[derive(Clone, Debug)]
pub(super) struct Pieces<const D: usize> {
    pub knots: Knots,
    pub starts: Vec<[f64; D]>,
    /// Value and derivatives before the first knot.
    pub before: [f64; D],
}

impl<const D: usize> Pieces<D> {
    /// The piece that contains a time, and the time since its start; `None` before the first.
    #[inline]
    pub fn piece(&self, time: DoubleDouble) -> Option<(Place, f64)> {
        let place = self.knots.last(time.value())?;
        let since = match self.knots.repeat {
            // The piece begins at the exact time of its knot, not at the rounded time.
            Some(_) => time.minus(self.knots.at(place)).value(),
            None => time.value() - self.knots.times[place.1],
        };
        Some((place, since))
    }
}

impl Pieces<4> {
    /// The pieces of a record with period `repeat`.
    pub fn of_record(record: &Record, scale: f64, repeat: Option<f64>) -> Self {
        let mut knots: Vec<(f64, f64)> = record.knots.iter().map(|&(t, y)| (t, scale * y)).collect();
        if let Some(period) = repeat {
            close(&mut knots, period);
        }
        let starts = match record.interpolation {
            Interpolation::Hold => knots.iter().map(|&(_, y)| [y, 0.0, 0.0, 0.0]).collect(),
            Interpolation::Straight => between(&knots, None, repeat),
            Interpolation::Cubic => between(&knots, Some(slopes(&knots, repeat)), repeat),
        };
        let before = [knots[0].1, 0.0, 0.0, 0.0];
        let times = knots.into_iter().map(|(t, _)| t).collect();
        Self { knots: Knots { times, repeat }, starts, before }
    }

    /// Value and derivatives just after a time.
    pub fn at(&self, time: DoubleDouble) -> [f64; 4] {
        match self.piece(time) {
            None => self.before,
            // Constant after the last knot.
            Some(((_, last), _)) if self.knots.repeat.is_none() && last + 1 == self.starts.len() => {
                self.starts[last]
            }
            Some(((_, place), since)) => shifted(&self.starts[place], since),
        }
    }
}

/// Moves a knot at the end of the period to time 0; drops it if time 0 has a knot.
fn close(knots: &mut Vec<(f64, f64)>, period: f64) {
    if let Some(&(last, value)) = knots.last()
        && last == period
    {
        knots.pop();
        if knots.first().is_none_or(|first| first.0 > 0.0) {
            knots.insert(0, (0.0, value));
        }
    }
}

/// Slopes at the knots. At the ends of a period, the neighbouring knots are taken from the
/// adjacent periods.
fn slopes(knots: &[(f64, f64)], repeat: Option<f64>) -> Vec<f64> {
    let Some(period) = repeat else { return vibro_numerics::monotone::monotone_slopes(knots) };
    let (first, last) = (knots[0], knots[knots.len() - 1]);
    let mut all = vec![(last.0 - period, last.1)];
    all.extend(knots);
    all.push((first.0 + period, first.1));
    vibro_numerics::monotone::monotone_slopes(&all)[1..=knots.len()].to_vec()
}

/// Value and derivatives at the start of each piece: linear, or cubic with given slopes.
fn between(knots: &[(f64, f64)], slopes: Option<Vec<f64>>, repeat: Option<f64>) -> Vec<[f64; 4]> {
    let last = knots[knots.len() - 1];
    let piece = |i: usize| {
        let next = knots.get(i + 1).copied();
        let next = next.or_else(|| repeat.map(|period| (knots[0].0 + period, knots[0].1)));
        let ((t0, y0), Some((t1, y1))) = (knots[i], next) else { return [last.1, 0.0, 0.0, 0.0] };
        let h = t1 - t0;
        let chord = (y1 - y0) / h;
        let Some(slopes) = &slopes else { return [y0, chord, 0.0, 0.0] };
        let (a, b) = (slopes[i], slopes[(i + 1) % knots.len()]);
        [y0, a, 2.0 * (3.0 * chord - 2.0 * a - b) / h, 6.0 * (a + b - 2.0 * chord) / (h * h)]
    };
    (0..knots.len()).map(piece).collect()
}

impl Pieces<1> {
    /// Sums of steps in their order. In a period the sum restarts at each turn, with the steps at
    /// time 0.
    pub fn of_steps(steps: &[Step], repeat: Option<f64>) -> Self {
        let mut times: Vec<f64> = steps.iter().map(|step| step.time).collect();
        let mut heights: Vec<f64> = steps.iter().map(|step| step.height).collect();
        let none: f64 = [0.0; 0].iter().sum();
        if repeat.is_some() && times.first().is_some_and(|first| *first > 0.0) {
            times.insert(0, 0.0);
            heights.insert(0, 0.0);
        }
        let sum = |sum: &mut f64, height: f64| {
            *sum += height;
            Some([*sum])
        };
        let starts = heights.into_iter().scan(none, sum).collect();
        Self { knots: Knots { times, repeat }, starts, before: [none] }
    }

    /// The sum of the heights up to a time.
    pub fn sum(&self, time: f64) -> f64 {
        self.knots.last(time).map_or(self.before[0], |(_, place)| self.starts[place][0])
    }
}

impl<const D: usize> Pieces<D> {
    /// The knots at which the function changes: every knot if `all`, otherwise only knots with a
    /// jump (for functions that are constant in between).
    pub fn changes(&self, all: bool) -> Knots {
        let count = self.starts.len();
        let jumps = |i: &usize| {
            let before = match (i.checked_sub(1), self.knots.repeat) {
                (Some(before), _) => self.starts[before][0],
                (None, Some(_)) => self.starts[count - 1][0],
                (None, None) => self.before[0],
            };
            all || self.starts[*i][0] != before
        };
        let times = (0..count).filter(jumps).map(|i| self.knots.times[i]).collect();
        Knots { times, repeat: self.knots.repeat }
    }
}

#[cfg(test)]
mod tests {
    use super::Knots;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn second_method_the_last_knot_is_that_of_a_search_in_halves(
            steps in prop::collection::vec(prop_oneof![Just(0.0), Just(1.0), 0.0..3.0f64], 1..40),
            at in -2.0..130.0f64,
            whole in any::<bool>(),
        ) {
            let sum = |sum: &mut f64, step: f64| { *sum += step; Some(*sum) };
            let times: Vec<f64> = steps.into_iter().scan(0.5, sum).collect();
            let at = if whole { at.round() + 0.5 } else { at };
            let halves = times.partition_point(|t| *t <= at).checked_sub(1);
            let knots = Knots { times, repeat: None };
            prop_assert_eq!(knots.last(at), halves.map(|place| (0.0, place)));
        }
    }
}
