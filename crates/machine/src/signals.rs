//! Signals of time as coordinates of the augmented state, so that every mode is an autonomous
//! linear system (docs/assembly-law.md (A4)): the number 1, cosine and sine of each frequency, and
//! value and derivatives of each piecewise polynomial.

mod builder;
mod integral;
mod phase;
mod pieces;
mod repeated;
mod sweep;
mod tangent;

pub use builder::{Builder, Layout};
pub use repeated::{Repeated, RepeatedKnot};
pub use tangent::{SignalTangent, StepTime};

use crate::description::{BodyKind, Harmonic, Signal};
use crate::kernel::Sparse;
use integral::Integral;
use nalgebra::DVector;
use pieces::{Knots, Pieces};
use std::f64::consts::TAU;
use sweep::SweepPiece;
use vibro_numerics::double_double::DoubleDouble;

/// Value and first three derivatives of an input, a cubic polynomial, at the time it was set.
pub type Input = [f64; 4];

/// The piecewise polynomial part of a signal.
#[derive(Clone, Debug)]
struct SignalPiece {
    /// Index of its value in the augmented state; its derivatives follow.
    first: usize,
    /// Number of coordinates: value and derivatives.
    count: usize,
    steps: Option<Pieces<1>>,
    table: Option<Pieces<4>>,
    rate: f64,
    /// Index among the inputs.
    input: Option<usize>,
    /// Set if the signal is integrated: the integral of its constant, steps, table and input.
    /// The coordinates then belong to the integral, and `rate` is added without being integrated.
    integral: Option<SignalIntegral>,
}

/// The integral of a signal's polynomial part.
#[derive(Clone, Debug)]
struct SignalIntegral {
    order: usize,
    parts: Integral,
    /// Index, among the inputs, of the carried part: the contribution of earlier inputs and of
    /// displacements ([`Signals::displace`]), continued as a polynomial.
    carried: usize,
}

/// A signal, and how often it is integrated over time.
#[derive(Clone, Copy, Debug)]
pub struct Course<'a> {
    /// The signal.
    pub signal: &'a Signal,
    /// 0 for the signal itself, 1 or 2 for its first or second integral from time 0.
    pub order: usize,
    /// Constant of integration; used for orders 1 and 2 only.
    pub s: f64,
    /// Factor of a term proportional to time.
    pub v: f64,
}

impl<'a> From<&'a Signal> for Course<'a> {
    fn from(signal: &'a Signal) -> Self {
        Self { signal, order: 0, s: 0.0, v: 0.0 }
    }
}

impl BodyKind {
    /// The coordinate of a prescribed body.
    pub(crate) fn course(&self) -> Option<Course<'_>> {
        match self {
            Self::Free(_) | Self::Node(_) => None,
            Self::Prescribed { motion, rate } => Some(Course { v: *rate, ..Course::from(motion) }),
            Self::Integrated(own) => {
                Some(Course { signal: &own.signal, order: own.level.order(), s: own.s, v: own.v })
            }
        }
    }
}

/// A harmonic (`order` 0), or its integral of order 1 or 2 from time 0 (docs/assembly-law.md
/// (A46)): amplitudes of cosine and sine, constant part, factor of the part proportional to time.
fn harmonic(h: &Harmonic, order: usize) -> [f64; 4] {
    let (cosine, sine) = (h.amplitude * h.phase.sin(), h.amplitude * h.phase.cos());
    let omega = TAU * h.frequency;
    match order {
        0 => [cosine, sine, 0.0, 0.0],
        1 => [-sine / omega, cosine / omega, sine / omega, 0.0],
        _ => {
            let square = omega * omega;
            [-cosine / square, -sine / square, cosine / square, sine / omega]
        }
    }
}

/// Value and derivatives of a cubic after a time `dt`.
pub fn shifted(d: &[f64; 4], dt: f64) -> [f64; 4] {
    [
        d[0] + dt * (d[1] + dt * (0.5 * d[2] + dt * d[3] / 6.0)),
        d[1] + dt * (d[2] + dt * 0.5 * d[3]),
        d[2] + dt * d[3],
        d[3],
    ]
}

/// Sine and cosine of an angle of at most [`SMALL`] rad, by power series.
#[inline(always)]
fn small_turn(angle: f64) -> (f64, f64) {
    let square = -angle * angle;
    let (mut sine, mut cosine) = (0.0, 0.0);
    for [even, odd] in TURN.iter().rev() {
        cosine = cosine * square + even;
        sine = sine * square + odd;
    }
    (angle * sine, cosine)
}

/// Largest angle of the series in [`TURN`]: its first omitted terms are below 0.4¹⁶/16! < 3e-20.
pub(crate) const SMALL: f64 = 0.4;

/// 1/k! in pairs of even and odd k.
const TURN: [[f64; 2]; 8] = {
    let (mut terms, mut factor, mut k) = ([[0.0; 2]; 8], 1.0, 0);
    while k < 16 {
        terms[k / 2][k % 2] = factor;
        k += 1;
        factor /= k as f64;
    }
    terms
};

/// The signals of a machine as coordinates; the first has the index [`Signals::one`].
#[derive(Clone, Debug)]
pub struct Signals {
    /// Index of the coordinate that is always 1.
    pub one: usize,
    /// Frequencies of the harmonics, Hz. Each has two coordinates, cosine and sine, after the
    /// coordinate that is always 1.
    frequencies: Vec<f64>,
    pieces: Vec<SignalPiece>,
    sweeps: Vec<SweepPiece>,
    /// Change times of signals, sorted: steps and knots of records.
    knots: Knots,
    /// Knots of the repeated signals.
    repeated: Vec<Knots>,
    /// Index of the signal of each entry of `repeated`.
    repeated_of: Vec<usize>,
    /// Length of the augmented state.
    pub size: usize,
    /// Index of the first curved force ([`Curved`](crate::curved::Curved)). Curved forces are the
    /// last coordinates.
    pub curved: usize,
    /// Number of signals with an input.
    pub inputs: usize,
    /// Number of integrated signals. In the list of inputs their carried parts are last.
    integrals: usize,
    /// The rows of the signals' coordinates in z' = A z.
    rates: Vec<Sparse>,
    /// The parts of each signal.
    parts: Vec<Parts>,
}

/// Parts of a signal and their indices.
#[derive(Clone, Debug)]
struct Parts {
    constant: f64,
    /// Index of the frequency, amplitudes of cosine and sine.
    harmonics: Vec<(usize, f64, f64)>,
    piece: Option<usize>,
    /// Indices of sweeps.
    sweeps: Vec<usize>,
}

impl SignalIntegral {
    /// Contribution of the present input, since it was set, to the integral and its derivatives.
    fn of_input(&self, (from, input): &(f64, Input), time: f64) -> [f64; 6] {
        let mut d = [0.0; 6];
        d[self.order..self.order + 4].copy_from_slice(input);
        integral::shifted(&d, time - from)
    }
}

impl SignalPiece {
    /// Value and derivatives of an integrated part just after a time.
    fn integrated(&self, integral: &SignalIntegral, time: DoubleDouble, inputs: &[(f64, Input)]) -> [f64; 6] {
        let mut d = integral.parts.at(time);
        d[0] += time.times(DoubleDouble::new(self.rate)).value();
        d[1] += self.rate;
        let (from, carried) = &inputs[integral.carried];
        let carried = shifted(carried, time.value() - from);
        d.iter_mut().zip(carried).for_each(|(d, x)| *d += x);
        if let Some(input) = self.input.map(|i| &inputs[i]) {
            let input = integral.of_input(input, time.value());
            d.iter_mut().zip(input).for_each(|(d, x)| *d += x);
        }
        d
    }
}

impl Signals {
    /// The row of a signal's time derivative, from the row of the signal.
    pub fn derivative(&self, row: &DVector<f64>) -> DVector<f64> {
        let mut rate = DVector::zeros(self.size);
        for (f, frequency) in self.frequencies.iter().enumerate() {
            let omega = TAU * frequency;
            let cosine = self.one + 1 + 2 * f;
            rate[cosine] = omega * row[cosine + 1];
            rate[cosine + 1] = -omega * row[cosine];
        }
        for piece in &self.pieces {
            for k in 1..piece.count {
                rate[piece.first + k] = row[piece.first + k - 1];
            }
        }
        for sweep in &self.sweeps {
            for k in sweep.places().skip(1) {
                rate[k] = sweep.scale * row[k - 1];
            }
        }
        rate
    }

    /// Computes [`rates`](Self::rates) from the derivative of each coordinate.
    fn rates_of_units(&self) -> Vec<Sparse> {
        let mut rates = vec![Vec::new(); self.size - self.one];
        let mut put = |of: usize, place: usize, x: f64| rates[of - self.one].push((place, x));
        for (f, frequency) in self.frequencies.iter().enumerate() {
            let (omega, cosine) = (TAU * frequency, self.one + 1 + 2 * f);
            put(cosine + 1, cosine, omega);
            put(cosine, cosine + 1, -omega);
        }
        for piece in &self.pieces {
            (1..piece.count).for_each(|k| put(piece.first + k - 1, piece.first + k, 1.0));
        }
        for sweep in &self.sweeps {
            sweep.places().skip(1).for_each(|k| put(k - 1, k, sweep.scale));
        }
        rates.into_iter().map(Sparse::summed).collect()
    }

    /// The rows of the signals' coordinates in z' = A z.
    pub(crate) fn rates(&self) -> &[Sparse] {
        &self.rates
    }

    /// Writes the signals just after `time` into the augmented state.
    pub fn fill(&self, time: DoubleDouble, inputs: &[(f64, Input)], z: &mut [f64]) {
        z[self.one] = 1.0;
        for (f, &frequency) in self.frequencies.iter().enumerate() {
            // Turns are reduced to their fraction in 32 digits, so that the phase does not drift.
            let turns = time.times(DoubleDouble::new(frequency)).fraction().value();
            let (sine, cosine) = (TAU * turns).sin_cos();
            (z[self.one + 1 + 2 * f], z[self.one + 2 + 2 * f]) = (cosine, sine);
        }
        let t = time.value();
        for piece in &self.pieces {
            if let Some(integral) = &piece.integral {
                let d = piece.integrated(integral, time, inputs);
                z[piece.first..piece.first + piece.count].copy_from_slice(&d[..piece.count]);
                continue;
            }
            let mut d = piece.table.as_ref().map_or([0.0; 4], |table| table.at(time));
            d[0] += piece.steps.as_ref().map_or(0.0, |steps| steps.sum(t));
            d[0] += time.times(DoubleDouble::new(piece.rate)).value();
            d[1] += piece.rate;
            if let Some((from, input)) = piece.input.map(|i| &inputs[i]) {
                let now = shifted(input, t - from);
                d.iter_mut().zip(now).for_each(|(d, n)| *d += n);
            }
            z[piece.first..piece.first + piece.count].copy_from_slice(&d[..piece.count]);
        }
        self.sweeps.iter().for_each(|sweep| sweep.fill(time, z));
    }

    /// Ranges of the coordinates that are set again between knots.
    pub(crate) fn renewed(&self) -> impl Iterator<Item = std::ops::Range<usize>> {
        self.sweeps.iter().map(SweepPiece::places)
    }

    /// First time after `time`, s, at which coordinates are set again between knots.
    pub(crate) fn next_renewal(&self, time: f64) -> Option<DoubleDouble> {
        let next = self.sweeps.iter().filter_map(|sweep| sweep.next(time));
        next.reduce(|a, b| if b.minus(a).value() < 0.0 { b } else { a })
    }

    /// The index of an input's value in the augmented state.
    pub(crate) fn place_of_input(&self, i: usize) -> Option<usize> {
        let own = self.pieces.iter().find(|piece| piece.input == Some(i))?;
        Some(own.first + own.integral.as_ref().map_or(0, |integral| integral.order))
    }

    /// Advances the polynomials by a time `dt`, ignoring knots in between.
    pub(crate) fn carry(&self, dt: f64, z: &mut [f64]) {
        for piece in &self.pieces {
            let place = piece.first..piece.first + piece.count;
            if piece.count > 4 {
                let mut d = [0.0; 6];
                d[..piece.count].copy_from_slice(&z[place.clone()]);
                z[place].copy_from_slice(&integral::shifted(&d, dt)[..piece.count]);
                continue;
            }
            let mut d = [0.0; 4];
            d[..piece.count].copy_from_slice(&z[place.clone()]);
            z[place].copy_from_slice(&shifted(&d, dt)[..piece.count]);
        }
        self.sweeps.iter().for_each(|sweep| sweep.carry(dt, z));
    }

    /// Advances the signals of `from` by a time `dt` and writes them to `to`. Requires that no
    /// knot lies in between and that no harmonic turns by more than [`SMALL`] rad. The rounding
    /// errors of several calls add up until the next [`fill`](Self::fill).
    #[inline(always)]
    pub(crate) fn carry_within(&self, from: &[f64], dt: f64, to: &mut [f64]) {
        to[self.one..].copy_from_slice(&from[self.one..]);
        let pairs = to[self.one + 1..].as_chunks_mut::<2>().0;
        for (pair, frequency) in pairs.iter_mut().zip(&self.frequencies) {
            let (sine, cosine) = small_turn(TAU * frequency * dt);
            let [c, s] = *pair;
            *pair = [c * cosine - s * sine, s * cosine + c * sine];
        }
        self.carry(dt, to);
    }

    /// The first knot after a time, s.
    pub fn next_knot(&self, time: f64) -> Option<f64> {
        self.next_knot_exactly(time).map(DoubleDouble::value)
    }

    /// The first knot after a time, s. For a repeated signal this is the knot's time within the
    /// period plus a whole number of periods, to 32 digits.
    pub(crate) fn next_knot_exactly(&self, time: f64) -> Option<DoubleDouble> {
        let next = |knots: &Knots| knots.next(time);
        let all = std::iter::once(&self.knots).chain(&self.repeated).filter_map(next);
        all.reduce(|a, b| if b.minus(a).value() < 0.0 { b } else { a })
    }

    /// The number of knots at a time.
    pub(crate) fn knots_at(&self, time: f64) -> usize {
        let own = std::iter::once(&self.knots).chain(&self.repeated);
        own.map(|knots| knots.count_at(time)).sum()
    }

    /// Initial list of inputs and carried parts: all are zero.
    pub fn no_inputs(&self) -> Vec<(f64, Input)> {
        vec![(0.0, [0.0; 4]); self.inputs + self.integrals]
    }

    /// Sets input `i` to a polynomial after a time. If the input is integrated, the integral
    /// continues without a jump.
    pub(crate) fn set_input(&self, inputs: &mut [(f64, Input)], i: usize, (time, derivatives): (f64, Input)) {
        let own = self.pieces.iter().find(|piece| piece.input == Some(i));
        if let Some(integral) = own.and_then(|piece| piece.integral.as_ref()) {
            let left = integral.of_input(&inputs[i], time);
            let (from, carried) = inputs[integral.carried];
            let mut now = shifted(&carried, time - from);
            (0..integral.order).for_each(|k| now[k] += left[k]);
            inputs[integral.carried] = (time, now);
        }
        inputs[i] = (time, derivatives);
    }

    /// The first coordinate of signal `i`'s integral, and its order; `None` without one.
    pub(crate) fn integral(&self, i: usize) -> Option<(usize, usize)> {
        let piece = &self.pieces[self.parts[i].piece?];
        Some((piece.first, piece.integral.as_ref()?.order))
    }

    /// Whether input `i` is integrated, because it gives a rate or an acceleration.
    pub(crate) fn is_integrated(&self, i: usize) -> bool {
        self.pieces.iter().any(|piece| piece.input == Some(i) && piece.integral.is_some())
    }

    /// Adds `place` to the integral of signal `i` after a time; to a second integral also a part
    /// that grows with `rate`.
    pub(crate) fn displace(&self, inputs: &mut [(f64, Input)], i: usize, time: f64, [place, rate]: [f64; 2]) {
        let piece = self.parts[i].piece.map(|p| &self.pieces[p]);
        if let Some(integral) = piece.and_then(|piece| piece.integral.as_ref()) {
            let (from, carried) = inputs[integral.carried];
            let mut now = shifted(&carried, time - from);
            now[0] += place;
            now[1] += if integral.order == 2 { rate } else { 0.0 };
            inputs[integral.carried] = (time, now);
        }
    }

    /// Index after the coordinates of constant amplitude: the number 1, cosines and sines.
    pub fn constant_size_until(&self) -> usize {
        self.one + 1 + 2 * self.frequencies.len()
    }
}

#[cfg(test)]
mod tests;
