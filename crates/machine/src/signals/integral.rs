//! Integrals of piecewise polynomials over time, from time 0 on (docs/assembly-law.md (A46)).

use super::pieces::{Knots, Pieces};
use vibro_numerics::double_double::DoubleDouble;

/// Value and derivatives of orders 1 to 5.
pub(super) type Long = [f64; 6];

/// A function to be integrated: a sum of parts.
#[derive(Clone, Debug, Default)]
pub(super) struct Integrand {
    pub constant: f64,
    pub table: Option<Pieces<4>>,
    pub steps: Option<Pieces<1>>,
    /// Times and sizes of impulses: each raises the first integral by its size.
    pub kicks: Vec<(f64, f64)>,
    pub repeat: Option<f64>,
}

impl Integrand {
    /// Value and derivatives just after a time.
    fn at(&self, time: f64) -> [f64; 4] {
        let mut d = self.table.as_ref().map_or([0.0; 4], |table| table.at(DoubleDouble::new(time)));
        d[0] += self.steps.as_ref().map_or(0.0, |steps| steps.sum(time)) + self.constant;
        d
    }

    /// Value before the first knot.
    fn before(&self) -> f64 {
        let steps = self.steps.as_ref().map_or(0.0, |steps| steps.before[0]);
        self.table.as_ref().map_or(0.0, |table| table.before[0]) + steps + self.constant
    }

    /// Sum of the impulses at a time.
    fn kick(&self, time: f64) -> f64 {
        self.kicks.iter().filter(|kick| kick.0 == time).map(|kick| kick.1).sum()
    }

    /// Start times of pieces, including time 0.
    fn times(&self) -> Vec<f64> {
        let table = self.table.iter().flat_map(|table| &table.knots.times);
        let steps = self.steps.iter().flat_map(|steps| &steps.knots.times);
        let kicks = self.kicks.iter().map(|kick| kick.0);
        let mut times: Vec<f64> = table.chain(steps).copied().chain(kicks).chain([0.0]).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        times
    }
}

/// First and second integral; an integral of order 1 uses `place` only.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    rate: DoubleDouble,
    place: DoubleDouble,
}

impl Sums {
    /// Contribution of a polynomial over a time `h` to its first and second integral, if both are
    /// zero at its start.
    fn over(d: &[f64; 4], h: DoubleDouble) -> Self {
        let t = h.value();
        let once = DoubleDouble::new(d[0]).plus(t * (d[1] / 2.0 + t * (d[2] / 6.0 + t * d[3] / 24.0)));
        let twice =
            DoubleDouble::new(d[0] / 2.0).plus(t * (d[1] / 6.0 + t * (d[2] / 24.0 + t * d[3] / 120.0)));
        Self { rate: once.times(h), place: twice.times(h).times(h) }
    }

    fn add(&mut self, order: usize, other: Self, h: DoubleDouble) {
        if order == 1 {
            self.place = self.place + other.rate;
        } else {
            self.place = self.place + self.rate.times(h) + other.place;
            self.rate = self.rate + other.rate;
        }
    }

    /// Reverses [`add`](Self::add).
    fn take(&mut self, order: usize, other: Self, h: DoubleDouble) {
        if order == 1 {
            self.place = self.place.minus(other.rate);
        } else {
            self.rate = self.rate.minus(other.rate);
            self.place = self.place.minus(self.rate.times(h)).minus(other.place);
        }
    }

    fn kick(&mut self, order: usize, size: f64) {
        if order == 1 {
            self.place = self.place.plus(size);
        } else {
            self.rate = self.rate.plus(size);
        }
    }

    /// Value and derivatives of the integral, from value and derivatives `d` of the function.
    fn with(self, order: usize, d: [f64; 4]) -> Long {
        let [a, b, c, e] = d;
        match order {
            1 => [self.place.value(), a, b, c, e, 0.0],
            _ => [self.place.value(), self.rate.value(), a, b, c, e],
        }
    }
}

/// Integral of order 1 or 2 of a function. The integral and its rate are zero at time 0.
#[derive(Clone, Debug)]
pub(super) struct Integral {
    order: usize,
    pieces: Pieces<6>,
    /// Increase over one period.
    gain: Sums,
}

impl Integral {
    pub fn of(order: usize, of: &Integrand) -> Self {
        let times = of.times();
        let first = times.partition_point(|&t| t < 0.0);
        let mut starts = vec![[0.0; 6]; times.len()];
        let span = |i: usize| DoubleDouble::sum(times[i + 1], -times[i]);
        let mut sums = Sums::default();
        for i in first..times.len() {
            if of.repeat.is_none() && times[i] > 0.0 || of.repeat.is_some() {
                sums.kick(order, of.kick(times[i]));
            }
            let d = of.at(times[i]);
            starts[i] = sums.with(order, d);
            if i + 1 < times.len() {
                sums.add(order, Sums::over(&d, span(i)), span(i));
            } else if let Some(period) = of.repeat {
                let rest = DoubleDouble::sum(period, -times[i]);
                sums.add(order, Sums::over(&d, rest), rest);
            }
        }
        let gain = sums;
        sums = Sums::default();
        for i in (0..first).rev() {
            let d = of.at(times[i]);
            if i + 1 < first {
                sums.kick(order, -of.kick(times[i + 1]));
            }
            sums.take(order, Sums::over(&d, span(i)), span(i));
            starts[i] = sums.with(order, d);
        }
        let before = sums.with(order, [of.before(), 0.0, 0.0, 0.0]);
        Self { order, pieces: Pieces { knots: Knots { times, repeat: of.repeat }, starts, before }, gain }
    }

    /// Value and derivatives just after a time.
    pub fn at(&self, time: DoubleDouble) -> Long {
        let Some(((turn, place), since)) = self.pieces.piece(time) else {
            return shifted(&self.pieces.before, time.value() - self.pieces.knots.times[0]);
        };
        let mut start = self.pieces.starts[place];
        if let Some(period) = self.pieces.knots.repeat
            && turn != 0.0
        {
            let turns = DoubleDouble::new(turn);
            let once = self.gain.place.times(turns);
            if self.order == 1 {
                start[0] = once.plus(start[0]).value();
            } else {
                // Rate after k turns, and displacement with the rates of all earlier turns.
                let rate = self.gain.rate.times(turns);
                let pairs = DoubleDouble::new(turn * (turn - 1.0) / 2.0);
                let grown = self.gain.rate.times(DoubleDouble::new(period)).times(pairs);
                let way = once + grown + rate.times(DoubleDouble::new(self.pieces.knots.times[place]));
                start[0] = way.plus(start[0]).value();
                start[1] = rate.plus(start[1]).value();
            }
        }
        shifted(&start, since)
    }
}

/// Value and derivatives of a polynomial of degree five after a time `dt`.
pub(super) fn shifted(d: &Long, dt: f64) -> Long {
    let mut to = *d;
    for k in 0..6 {
        // The larger terms are added last.
        let mut sum = 0.0;
        for j in (k + 1..6).rev() {
            sum = (sum + d[j]) * dt / (j - k) as f64;
        }
        to[k] = d[k] + sum;
    }
    to
}
