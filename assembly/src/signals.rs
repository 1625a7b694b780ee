//! Signals of time as coordinates of the augmented state, in which every mode is an autonomous
//! linear system (docs/assembly-law.md (A2)): the number 1, cosine and sine of each frequency, and
//! value and derivatives of each piecewise polynomial.

use crate::description::{Record, Signal, Step};
use crate::kernel::Sparse;
use nalgebra::DVector;
use std::f64::consts::TAU;
use vibro_impact::numerics::double_double::DoubleDouble;

/// Value and derivatives of an input, which is a cubic from the time it was set.
pub type Input = [f64; 4];

/// The piecewise polynomial part of a signal.
#[derive(Clone, Debug)]
struct SignalPiece {
    /// Place of its value in the augmented state; its derivatives follow.
    first: usize,
    /// Number of coordinates: value and derivatives.
    count: usize,
    steps: Vec<Step>,
    table: Option<Cubics>,
    rate: f64,
    /// Its index among the inputs.
    input: Option<usize>,
}

/// A record as a cubic on each interval between knots.
#[derive(Clone, Debug)]
struct Cubics {
    knots: Vec<(f64, f64)>,
    /// Derivatives of orders 0 to 3 at the start of each interval.
    starts: Vec<[f64; 4]>,
}

impl Cubics {
    fn of(record: &Record) -> Self {
        let knots = record.knots.clone();
        let slopes = record.cubic.then(|| vibro_impact::load::monotone_slopes(&knots));
        let starts = knots
            .windows(2)
            .enumerate()
            .map(|(i, pair)| {
                let ((t0, y0), (t1, y1)) = (pair[0], pair[1]);
                let h = t1 - t0;
                let chord = (y1 - y0) / h;
                let Some(slopes) = &slopes else { return [y0, chord, 0.0, 0.0] };
                let (a, b) = (slopes[i], slopes[i + 1]);
                [y0, a, 2.0 * (3.0 * chord - 2.0 * a - b) / h, 6.0 * (a + b - 2.0 * chord) / (h * h)]
            })
            .collect();
        Self { knots, starts }
    }

    /// Value and derivatives just after a time; constant before the first and after the last knot.
    fn at(&self, time: f64) -> [f64; 4] {
        let after = self.knots.partition_point(|&(t, _)| t <= time);
        if after == 0 {
            return [self.knots[0].1, 0.0, 0.0, 0.0];
        }
        if after == self.knots.len() {
            return [self.knots[after - 1].1, 0.0, 0.0, 0.0];
        }
        shifted(&self.starts[after - 1], time - self.knots[after - 1].0)
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

/// How signals become coordinates. A motion shares what it can; derivatives by a frequency or by
/// the rate of a prescribed body need coordinates of their own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Layout {
    /// Whether each harmonic has a cosine and a sine of its own, even where frequencies are equal.
    pub frequencies_apart: bool,
    /// Whether each prescribed motion has a part that grows with time, even at the rate 0.
    pub rates: bool,
}

/// The signals of a machine as coordinates from [`Signals::one`] on.
#[derive(Clone, Debug)]
pub struct Signals {
    /// Index of the coordinate that is always 1.
    pub one: usize,
    /// Frequencies, Hz; the cosine and sine of each follow the number 1.
    frequencies: Vec<f64>,
    pieces: Vec<SignalPiece>,
    /// Times of all steps and all knots of records, sorted.
    knots: Vec<f64>,
    /// Length of the augmented state.
    pub size: usize,
    /// Number of signals with an input.
    pub inputs: usize,
    /// The rows of the signals' coordinates in z' = A z.
    rates: Vec<Sparse>,
    /// The parts of each signal.
    parts: Vec<Parts>,
}

/// Builder of [`Signals`]: [`add`](Self::add) takes every signal, then [`finish`](Self::finish)
/// returns a row for each.
#[derive(Debug)]
pub struct Builder {
    signals: Signals,
    layout: Layout,
}

/// Where the parts of a signal are among the coordinates.
#[derive(Clone, Debug)]
struct Parts {
    constant: f64,
    /// Index of the frequency, amplitudes of cosine and sine.
    harmonics: Vec<(usize, f64, f64)>,
    piece: Option<usize>,
}

impl Builder {
    /// A builder for an augmented state whose first `one` coordinates are not signals.
    pub fn new(one: usize, layout: Layout) -> Self {
        let signals = Signals {
            one,
            frequencies: Vec::new(),
            pieces: Vec::new(),
            knots: Vec::new(),
            size: 0,
            inputs: 0,
            rates: Vec::new(),
            parts: Vec::new(),
        };
        Self { signals, layout }
    }

    /// Adds a signal; returns its index.
    pub fn add(&mut self, signal: &Signal) -> usize {
        self.add_part(signal, 0.0, false)
    }

    /// Adds a signal plus `rate` times the time; returns its index.
    pub fn add_motion(&mut self, signal: &Signal, rate: f64) -> usize {
        self.add_part(signal, rate, self.layout.rates || rate != 0.0)
    }

    fn add_part(&mut self, signal: &Signal, rate: f64, grows: bool) -> usize {
        let apart = self.layout.frequencies_apart;
        let mut harmonics = Vec::new();
        for h in &signal.harmonics {
            let frequencies = &mut self.signals.frequencies;
            let known = frequencies.iter().position(|&f| f == h.frequency && !apart);
            let place = known.unwrap_or_else(|| {
                frequencies.push(h.frequency);
                frequencies.len() - 1
            });
            harmonics.push((place, h.amplitude * h.phase.sin(), h.amplitude * h.phase.cos()));
        }
        let table = signal.table.as_ref();
        let degree = match (signal.input || table.is_some_and(|t| t.cubic), table.is_some() || grows) {
            (true, _) => 3,
            (_, true) => 1,
            _ => 0,
        };
        let needs_piece = degree > 0 || !signal.steps.is_empty();
        let piece = needs_piece.then(|| {
            let input = signal.input.then(|| {
                self.signals.inputs += 1;
                self.signals.inputs - 1
            });
            self.signals.pieces.push(SignalPiece {
                first: 0,
                count: degree + 1,
                steps: signal.steps.clone(),
                table: table.map(Cubics::of),
                rate,
                input,
            });
            self.signals.pieces.len() - 1
        });
        self.signals.parts.push(Parts { constant: signal.constant, harmonics, piece });
        self.signals.parts.len() - 1
    }

    /// The coordinates, and the row of each signal in the order of [`add`](Self::add).
    pub fn finish(mut self) -> (Signals, Vec<DVector<f64>>) {
        let signals = &mut self.signals;
        let mut place = signals.one + 1 + 2 * signals.frequencies.len();
        for piece in &mut signals.pieces {
            piece.first = place;
            place += piece.count;
        }
        signals.size = place;
        for piece in &signals.pieces {
            signals.knots.extend(piece.steps.iter().map(|s| s.time));
            signals.knots.extend(piece.table.iter().flat_map(|t| &t.knots).map(|k| k.0));
        }
        signals.knots.sort_by(f64::total_cmp);
        let unit = |j: usize| DVector::from_fn(signals.size, |i, _| if i == j { 1.0 } else { 0.0 });
        let rates = (signals.one..signals.size).map(|j| Sparse::of(signals.derivative(&unit(j)).as_slice()));
        signals.rates = rates.collect();
        let rows = signals.parts.iter().map(|parts| {
            let mut row = DVector::zeros(signals.size);
            row[signals.one] = parts.constant;
            for &(f, cosine, sine) in &parts.harmonics {
                row[signals.one + 1 + 2 * f] += cosine;
                row[signals.one + 2 + 2 * f] += sine;
            }
            if let Some(p) = parts.piece {
                row[signals.pieces[p].first] += 1.0;
            }
            row
        });
        let rows = rows.collect();
        (self.signals, rows)
    }
}

impl Signals {
    /// The row of the time derivative of a signal's row.
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
        rate
    }

    /// The rows of the signals' coordinates in z' = A z.
    pub(crate) fn rates(&self) -> &[Sparse] {
        &self.rates
    }

    /// Writes the signals just after `time` into the augmented state.
    pub fn fill(&self, time: DoubleDouble, inputs: &[(f64, Input)], z: &mut [f64]) {
        z[self.one] = 1.0;
        for (f, &frequency) in self.frequencies.iter().enumerate() {
            // The fraction of the turns, taken in 32 digits, keeps the phase from drifting.
            let turns = time.times(DoubleDouble::new(frequency)).fraction().value();
            let (sine, cosine) = (TAU * turns).sin_cos();
            (z[self.one + 1 + 2 * f], z[self.one + 2 + 2 * f]) = (cosine, sine);
        }
        let t = time.value();
        for piece in &self.pieces {
            let mut d = piece.table.as_ref().map_or([0.0; 4], |table| table.at(t));
            d[0] += piece.steps.iter().filter(|s| s.time <= t).map(|s| s.height).sum::<f64>();
            d[0] += time.times(DoubleDouble::new(piece.rate)).value();
            d[1] += piece.rate;
            if let Some((from, input)) = piece.input.map(|i| &inputs[i]) {
                let now = shifted(input, t - from);
                d.iter_mut().zip(now).for_each(|(d, n)| *d += n);
            }
            z[piece.first..piece.first + piece.count].copy_from_slice(&d[..piece.count]);
        }
    }

    /// The index of an input's value in the augmented state.
    pub(crate) fn place_of_input(&self, i: usize) -> Option<usize> {
        self.pieces.iter().find(|piece| piece.input == Some(i)).map(|piece| piece.first)
    }

    /// Advances the polynomials by a time `dt`, ignoring knots in between.
    pub(crate) fn carry(&self, dt: f64, z: &mut [f64]) {
        for piece in &self.pieces {
            let place = piece.first..piece.first + piece.count;
            let mut d = [0.0; 4];
            d[..piece.count].copy_from_slice(&z[place.clone()]);
            z[place].copy_from_slice(&shifted(&d, dt)[..piece.count]);
        }
    }

    /// Advances the signals of `from` by a time `dt` and writes them to `to`. Requires that no knot
    /// lies in between and no frequency turns by more than [`SMALL`] rad. Its rounding, like a
    /// sub-step's, lasts until the next [`fill`](Self::fill).
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
        self.knots.get(self.knots.partition_point(|&t| t <= time)).copied()
    }

    /// The number of knots at a time.
    pub(crate) fn knots_at(&self, time: f64) -> usize {
        self.knots.iter().filter(|&&t| t == time).count()
    }

    /// The index after the last coordinate of constant amplitude: 1, cosines and sines.
    pub fn constant_size_until(&self) -> usize {
        self.one + 1 + 2 * self.frequencies.len()
    }
}

mod tangent;

pub use tangent::{SignalTangent, StepTime};

#[cfg(test)]
mod tests;
