//! Knots of repeated signals, each identified by the number of earlier knots of its signal. The
//! number stays the same when the times of knots move.

use super::Signals;
use super::pieces::Knots;

/// The knots of a signal that repeats.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repeated {
    /// Index of the signal.
    pub signal: usize,
    /// Its period, s.
    pub period: f64,
    /// Number of knots in a period.
    pub count: usize,
}

/// A knot of one of the [`Repeated`] signals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RepeatedKnot {
    /// Index among the repeated signals.
    pub of: usize,
    /// Number of earlier knots of the signal, counted from time 0.
    pub number: i64,
}

impl Knots {
    /// The time of a knot by its number, as the motion reaches it.
    fn at_number(&self, number: i64) -> f64 {
        let count = self.times.len() as i64;
        let place = (number.div_euclid(count) as f64, number.rem_euclid(count) as usize);
        self.at(place).value()
    }
}

impl Signals {
    /// The signals that repeat and have knots.
    pub fn repeated(&self) -> impl Iterator<Item = Repeated> + '_ {
        let own = self.repeated.iter().zip(&self.repeated_of);
        own.map(|(knots, &signal)| Repeated {
            signal,
            period: knots.repeat.unwrap_or(f64::INFINITY),
            count: knots.times.len(),
        })
    }

    /// The knots of repeated signals at a time that a motion reaches, s.
    pub fn repeated_knots_at(&self, time: f64) -> impl Iterator<Item = RepeatedKnot> + '_ {
        self.repeated.iter().enumerate().filter_map(move |(of, knots)| {
            let (turn, place) = knots.last(time)?;
            let number = turn as i64 * knots.times.len() as i64 + place as i64;
            (knots.at_number(number) == time).then_some(RepeatedKnot { of, number })
        })
    }

    /// The time of a knot, s.
    pub fn time_of(&self, knot: RepeatedKnot) -> f64 {
        self.repeated[knot.of].at_number(knot.number)
    }
}
