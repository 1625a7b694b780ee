//! The phase of a sine sweep, and its derivatives by time and by the sweep's parameters
//! (docs/assembly-law.md (A48)).

use crate::description::{Sweep, SweepLaw};
use std::f64::consts::TAU;
use vibro_numerics::double_double::DoubleDouble;

/// Number of derivatives computed, including the value.
pub(super) const ORDER: usize = 6;

/// Value and derivatives.
pub(super) type Jet = [f64; ORDER];

/// Sine and cosine of the phase, and their derivatives.
pub(super) type Wave = [(f64, f64); ORDER];

/// Position of a time relative to a sweep. At both ends of the sweep the second derivative of the
/// phase jumps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Before,
    Within,
    After,
}

/// The phase of a sweep over time.
#[derive(Clone, Debug)]
pub(super) struct Phase {
    sweep: Sweep,
    /// ln(to/from), for a logarithmic sweep between different frequencies.
    log: Option<DoubleDouble>,
}

/// Binomial coefficients up to order 12.
const BINOMIAL: [[f64; 13]; 13] = {
    let (mut all, mut n) = ([[0.0; 13]; 13], 0);
    while n < 13 {
        let mut k = 0;
        while k <= n {
            all[n][k] = if k == 0 || k == n { 1.0 } else { all[n - 1][k - 1] + all[n - 1][k] };
            k += 1;
        }
        n += 1;
    }
    all
};

/// The binomial coefficient n over k, for n up to 12.
pub(super) fn binomial(n: usize, k: usize) -> f64 {
    BINOMIAL[n][k]
}

/// The quotient a/b, to 32 digits.
fn over(a: DoubleDouble, b: DoubleDouble) -> DoubleDouble {
    let first = DoubleDouble::new(a.value() / b.value());
    let rest = a.minus(first.times(b));
    let second = rest.value() / b.value();
    let last = rest.minus(DoubleDouble::new(second).times(b)).value() / b.value();
    first.plus(second).plus(last)
}

/// exp(x) - 1, to some 30 digits, for |x| up to some hundreds: series for x/2ᵏ, then doublings.
fn exp_minus_one(x: DoubleDouble) -> DoubleDouble {
    let doublings = (x.value().abs().max(1e-300).log2().ceil() as i32 + 6).max(0);
    let scale = (-f64::from(doublings)).exp2();
    let small = DoubleDouble { hi: x.hi * scale, lo: x.lo * scale };
    // 18 terms suffice, since |small| <= 2⁻⁶ and (2⁻⁶)¹⁸/18! is below 1e-47.
    let mut sum = DoubleDouble::default();
    for k in (1..=18).rev() {
        sum = over(small.times(sum.plus(1.0)), DoubleDouble::new(f64::from(k)));
    }
    for _ in 0..doublings {
        sum = sum.times(sum.plus(2.0));
    }
    sum
}

/// ln(a/b) to some 30 digits: one Newton step from the logarithm in double precision.
fn log_of_ratio(a: f64, b: f64) -> DoubleDouble {
    let ratio = over(DoubleDouble::new(a), DoubleDouble::new(b));
    let first = DoubleDouble::new((a / b).ln());
    let off = ratio.times(exp_minus_one(DoubleDouble::default().minus(first)).plus(1.0)).plus(-1.0);
    // ln(1 + off), where `off` is of the order of a rounding error.
    first + off.minus(off.times(off).times(DoubleDouble::new(0.5)))
}

impl Phase {
    pub fn of(sweep: &Sweep) -> Self {
        let changes = sweep.law == SweepLaw::Logarithmic && sweep.from != sweep.to;
        let log = changes.then(|| log_of_ratio(sweep.to, sweep.from));
        Self { sweep: *sweep, log }
    }

    /// The frequency at a time within the sweep, Hz.
    pub fn frequency(&self, time: f64) -> f64 {
        let Sweep { from, to, duration, .. } = self.sweep;
        let part = (time / duration).clamp(0.0, 1.0);
        match self.log {
            Some(log) => from * (log.value() * part).exp(),
            None => from + (to - from) * part,
        }
    }

    /// Turns since time 0, to 32 digits.
    fn turns(&self, time: DoubleDouble, side: Side) -> DoubleDouble {
        let Sweep { from, to, duration, .. } = self.sweep;
        let (exact, span) = (DoubleDouble::new, DoubleDouble::new(duration));
        match (side, self.log) {
            (Side::Before, _) => exact(from).times(time),
            (Side::After, _) => self.turns(span, Side::Within) + exact(to).times(time.minus(span)),
            (Side::Within, None) => {
                let rise = over(DoubleDouble::sum(to, -from), span.times(exact(2.0)));
                exact(from).times(time) + rise.times(time).times(time)
            }
            (Side::Within, Some(log)) => {
                let grown = exp_minus_one(over(log.times(time), span));
                over(exact(from).times(span).times(grown), log)
            }
        }
    }

    /// Derivatives of the phase of orders 1 to 5; entry 0 is zero.
    fn rates(&self, time: f64, side: Side) -> Jet {
        let Sweep { from, to, duration, .. } = self.sweep;
        let mut rates = [0.0; ORDER];
        rates[1] = match side {
            Side::Before => TAU * from,
            Side::Within => TAU * self.frequency(time),
            Side::After => TAU * to,
        };
        match (side, self.log) {
            (Side::Within, Some(log)) => {
                (2..ORDER).for_each(|k| rates[k] = rates[k - 1] * log.value() / duration);
            }
            (Side::Within, None) => rates[2] = TAU * (to - from) / duration,
            _ => {}
        }
        rates
    }

    /// Sine and cosine of the phase with their derivatives.
    pub fn wave(&self, time: DoubleDouble, side: Side) -> Wave {
        let angle = TAU * self.turns(time, side).fraction().value() + self.sweep.phase;
        let rates = self.rates(time.value(), side);
        let mut wave = [angle.sin_cos(); ORDER];
        // F = exp(iφ) satisfies F' = iφ' F.
        for n in 0..ORDER - 1 {
            let (mut sine, mut cosine) = (0.0, 0.0);
            for k in 0..=n {
                let factor = binomial(n, k) * rates[k + 1];
                sine += factor * wave[n - k].1;
                cosine -= factor * wave[n - k].0;
            }
            wave[n + 1] = (sine, cosine);
        }
        wave
    }

    /// Upper bound, in a cell of length h, of h¹² times the twelfth derivative of the sine and the
    /// cosine of the phase. `frequency` is the highest frequency in the cell.
    pub fn bound(&self, frequency: f64, h: f64) -> f64 {
        const TWELVE: usize = 12;
        let Sweep { from, to, duration, .. } = self.sweep;
        let first = TAU * frequency * h;
        let growth = match self.log {
            Some(log) => log.value().abs() * h / duration,
            None => TAU * (to - from).abs() / duration * h * h,
        };
        // growthᵏ, for logarithmic sweeps.
        let mut powers = [1.0; TWELVE];
        (1..TWELVE).for_each(|k| powers[k] = powers[k - 1] * growth);
        let mut bounds = [1.0; TWELVE + 1];
        for n in 0..TWELVE {
            bounds[n + 1] = match self.log {
                Some(_) => (0..=n).map(|k| binomial(n, k) * first * powers[k] * bounds[n - k]).sum(),
                None if n > 0 => first * bounds[n] + n as f64 * growth * bounds[n - 1],
                None => first * bounds[n],
            };
        }
        bounds[TWELVE]
    }

    /// Derivative of the phase along the direction `by` of the sweep's parameters, and the time
    /// derivatives of this derivative.
    pub fn along(&self, time: f64, side: Side, by: &Sweep) -> Jet {
        let Sweep { from, to, duration, .. } = self.sweep;
        let mut jet = [0.0; ORDER];
        match (side, self.log) {
            (Side::Before, _) => (jet[0], jet[1]) = (TAU * by.from * time, TAU * by.from),
            (Side::After, _) => {
                let end = self.along(duration, Side::Within, by)[0];
                return [end + TAU * by.to * (time - duration), TAU * by.to, 0.0, 0.0, 0.0, 0.0];
            }
            (Side::Within, None) => {
                let part = time / duration;
                let bend = by.to - by.from - by.duration * (to - from) / duration;
                jet[0] = TAU * time * (by.from + 0.5 * part * bend);
                jet[1] = TAU * (by.from + part * bend);
                jet[2] = TAU * bend / duration;
            }
            (Side::Within, Some(log)) => {
                let (log, x) = (log.value(), time / duration);
                let (grown, e, kappa) = ((log * x).exp_m1() / log, (log * x).exp(), log / duration);
                let ratio = by.to / to - by.from / from;
                jet[0] = by.from * duration * grown
                    + by.duration * from * (grown - x * e)
                    + from * duration * ratio * bend_of_growth(log, x);
                for (k, jet) in jet.iter_mut().enumerate().skip(1) {
                    let [one, before] = [k as i32 - 1, k as i32 - 2].map(|power| kappa.powi(power.max(0)));
                    let order = (k - 1) as f64;
                    *jet = e
                        * (by.from * one - by.duration * from * (one * order / duration + one * kappa * x)
                            + from * ratio * (one * x + order * before / duration));
                }
                jet.iter_mut().for_each(|jet| *jet *= TAU);
            }
        }
        jet[0] += by.phase;
        jet
    }
}

/// (x exp(ax) - (exp(ax) - 1)/a)/a; its limit for a = 0 is x²/2.
fn bend_of_growth(a: f64, x: f64) -> f64 {
    /// The series of ten terms is exact up to this |ax|.
    const SMALL: f64 = 0.05;
    if (a * x).abs() > SMALL {
        return (x * (a * x).exp() - (a * x).exp_m1() / a) / a;
    }
    let (mut sum, mut power, mut factorial) = (0.0, x * x, 1.0);
    for m in 0..10 {
        // 1/(m + 1)! - 1/(m + 2)!
        factorial *= (m + 1) as f64;
        sum += power / factorial * (1.0 - 1.0 / (m + 2) as f64);
        power *= a * x;
    }
    sum
}
