//! Sine sweeps. No finite linear system has a sweep as its solution: polynomials over short cells
//! of time follow it, computed when they are needed (docs/assembly-law.md (A48)).

use super::phase::{Jet, ORDER, Phase, Side, Wave, binomial};
use crate::description::Sweep;
use std::f64::consts::TAU;
use vibro_numerics::double_double::DoubleDouble;

/// Number of coefficients of a polynomial. The polynomial shares [`ORDER`] derivatives with the
/// sweep at each end of its cell.
const COEFFICIENTS: usize = 2 * ORDER;
/// Largest order of integration.
const INTEGRALS: usize = 2;
/// Largest error of a polynomial, relative to the amplitude.
const ERROR: f64 = 5e-13;
/// Fraction of a turn in a cell of constant frequency: 0.79 rad, with an error of 3e-14.
const TURN: f64 = 0.125;
/// Largest number of halvings of a sweep's duration; the cells are then 1e-15 of it.
const HALVINGS: i32 = 50;

/// Number of coordinates of a sweep integrated `order` times.
pub(super) const fn count(order: usize) -> usize {
    COEFFICIENTS + order
}

/// A sweep, or its derivative in a direction of its parameters.
#[derive(Clone, Debug)]
pub(super) struct SweepPiece {
    /// Index of its value in the augmented state.
    pub first: usize,
    /// Order of integration.
    pub order: usize,
    /// Largest angular frequency, rad/s; derivatives are divided by its powers.
    pub scale: f64,
    sweep: Sweep,
    phase: Phase,
    along: Option<Sweep>,
    /// For an integrated sweep: start of each cell and end of the sweep, with the first and the
    /// second integral there.
    sums: Vec<(f64, [DoubleDouble; 2])>,
}

/// A cell of time.
#[derive(Clone, Copy, Debug)]
struct Cell {
    begin: DoubleDouble,
    /// `None` if the value stays constant.
    end: Option<DoubleDouble>,
    side: Side,
}

impl SweepPiece {
    pub fn new(sweep: &Sweep, order: usize) -> Self {
        let (phase, scale) = (Phase::of(sweep), TAU * sweep.from.max(sweep.to));
        Self { first: 0, order, scale, sweep: *sweep, phase, along: None, sums: Vec::new() }.summed()
    }

    /// The derivative in a direction of the sweep's parameters.
    pub fn along(&self, by: &Sweep) -> Self {
        Self { along: Some(*by), sums: Vec::new(), ..self.clone() }.summed()
    }

    /// End of the sweep, s; the frequency is constant afterwards.
    pub fn end(&self) -> f64 {
        self.sweep.duration
    }

    /// End of the cell that contains a time; `None` if the sweep stays constant.
    pub fn next(&self, time: f64) -> Option<DoubleDouble> {
        self.cell(time).end
    }

    /// The cell that contains a time. During the sweep, the duration is halved until the
    /// polynomial is exact enough; before and after, the cell is a fixed fraction of a turn.
    fn cell(&self, time: f64) -> Cell {
        let duration = self.sweep.duration;
        if time < 0.0 {
            return self.even_cell(time, (0.0, self.sweep.from), Side::Before);
        }
        if time >= duration {
            return self.even_cell(time, (duration, self.sweep.to), Side::After);
        }
        // The error grows with the length of the cell. The search for the longest cell that is
        // exact enough begins at one radian.
        let turns = TAU * self.phase.frequency(time) * duration;
        let mut halvings = turns.max(1.0).log2().round() as i32;
        while halvings > 0 && self.is_exact(halvings - 1, time) {
            halvings -= 1;
        }
        while halvings < HALVINGS && !self.is_exact(halvings, time) {
            halvings += 1;
        }
        let [begin, end] = self.part(halvings, time);
        Cell { begin, end: Some(end), side: Side::Within }
    }

    /// The part that contains a time, if the duration is halved `halvings` times.
    fn part(&self, halvings: i32, time: f64) -> [DoubleDouble; 2] {
        let (duration, parts) = (self.sweep.duration, f64::from(halvings).exp2());
        let at = |index: f64| {
            let whole = DoubleDouble::new(duration).times(DoubleDouble::new(index));
            DoubleDouble { hi: whole.hi / parts, lo: whole.lo / parts }
        };
        let mut index = (time / duration * parts).floor().clamp(0.0, parts - 1.0);
        while index > 0.0 && at(index).value() > time {
            index -= 1.0;
        }
        while index + 1.0 < parts && at(index + 1.0).value() <= time {
            index += 1.0;
        }
        [at(index), at(index + 1.0)]
    }

    /// Whether the polynomial of the part that contains a time is exact enough.
    fn is_exact(&self, halvings: i32, time: f64) -> bool {
        let frequencies = self.part(halvings, time).map(|end| self.phase.frequency(end.value()));
        let length = self.sweep.duration * (-f64::from(halvings)).exp2();
        remainder(self.phase.bound(frequencies[0].max(frequencies[1]), length)) <= ERROR
    }

    /// The cell that contains a time with constant frequency; cells are counted from `from`.
    fn even_cell(&self, time: f64, (from, frequency): (f64, f64), side: Side) -> Cell {
        if frequency == 0.0 {
            let end = (side == Side::Before).then(DoubleDouble::default);
            return Cell { begin: DoubleDouble::new(from), end, side };
        }
        let length = TURN / frequency;
        let at = |index: f64| DoubleDouble::new(length).times(DoubleDouble::new(index)).plus(from);
        let mut index = ((time - from) / length).floor();
        while at(index).value() > time {
            index -= 1.0;
        }
        while at(index + 1.0).value() <= time {
            index += 1.0;
        }
        Cell { begin: at(index), end: Some(at(index + 1.0)), side }
    }

    /// Value and derivatives of orders 1 to 5.
    fn jet(&self, time: DoubleDouble, side: Side) -> Jet {
        let wave = self.phase.wave(time, side);
        match &self.along {
            None => wave.map(|(sine, _)| self.sweep.amplitude * sine),
            Some(by) => self.varied(&wave, &self.phase.along(time.value(), side, by), by),
        }
    }

    /// Derivative of the values in a direction: a' sin φ + a cos φ ψ, with ψ the derivative of the
    /// phase.
    fn varied(&self, wave: &Wave, phase: &Jet, by: &Sweep) -> Jet {
        std::array::from_fn(|n| {
            let turned: f64 = (0..=n).map(|k| binomial(n, k) * wave[n - k].1 * phase[k]).sum();
            by.amplitude * wave[n].0 + self.sweep.amplitude * turned
        })
    }

    /// Coefficients of a cell's polynomial in the fraction of the cell, and the cell's length.
    /// Without an end, coefficients in time and length 1.
    fn polynomial(&self, cell: Cell) -> ([f64; COEFFICIENTS], f64) {
        let begin = self.jet(cell.begin, cell.side);
        let Some(end) = cell.end.filter(|_| cell.side != Side::Before || self.sweep.from > 0.0) else {
            let mut c = [0.0; COEFFICIENTS];
            c[..ORDER].copy_from_slice(&taylor(&begin, 1.0));
            return (c, 1.0);
        };
        let h = end.minus(cell.begin).value();
        (hermite(&taylor(&begin, h), &taylor(&self.jet(end, cell.side), h)), h)
    }

    /// Computes the integrals at the cells of the sweep.
    fn summed(mut self) -> Self {
        let (mut sums, mut time) = ([DoubleDouble::default(); 2], 0.0);
        while self.order > 0 && time < self.sweep.duration {
            let cell = self.cell(time);
            self.sums.push((time, sums));
            let (c, h) = self.polynomial(cell);
            let h = DoubleDouble::new(h);
            let parts = |order: usize| -> f64 {
                let divided = c.iter().enumerate().rev();
                divided.map(|(k, c)| c / (1..=order).map(|i| (k + i) as f64).product::<f64>()).sum()
            };
            let way = sums[0].times(h) + DoubleDouble::new(parts(2)).times(h).times(h);
            sums[1] = sums[1] + way;
            sums[0] = sums[0] + DoubleDouble::new(parts(1)).times(h);
            time = cell.end.map_or(self.sweep.duration, DoubleDouble::value);
        }
        self.sums.push((self.sweep.duration, sums));
        self
    }

    /// First and second integral at the start of a cell.
    fn integrals(&self, cell: Cell) -> [f64; 2] {
        let time = cell.begin.value();
        if cell.side == Side::Within {
            let place = self.sums.partition_point(|sum| sum.0 <= time);
            return self.sums[place.max(1) - 1].1.map(DoubleDouble::value);
        }
        let (from, sums) = match cell.side {
            Side::Before => (0.0, [DoubleDouble::default(); 2]),
            _ => self.sums[self.sums.len() - 1],
        };
        let t = DoubleDouble::minus(cell.begin, DoubleDouble::new(from)).value();
        let [once, twice] = self.even_integrals(from, cell, t);
        [sums[0].plus(once).value(), (sums[1] + sums[0].times(DoubleDouble::new(t))).plus(twice).value()]
    }

    /// First and second integral over a time `t` from `from` on at a constant frequency. The terms
    /// are (a + b τ) sin φ and (a + b τ) cos φ, with φ = θ + ω τ.
    fn even_integrals(&self, from: f64, cell: Cell, t: f64) -> [f64; 2] {
        let wave = |time: DoubleDouble| self.phase.wave(time, cell.side)[0];
        let [start, end] = [wave(DoubleDouble::new(from)), wave(cell.begin)];
        let frequency = if cell.side == Side::Before { self.sweep.from } else { self.sweep.to };
        let parts = |a: f64, b: f64, [(s, c), (s1, c1)]: [(f64, f64); 2]| {
            if frequency == 0.0 {
                return [s * t * (a + 0.5 * b * t), s * t * t * (0.5 * a + b * t / 6.0)];
            }
            // Antiderivatives of (a + b τ) s(φ), where c is the derivative of s.
            let omega = TAU * frequency;
            let once = |x: f64, s: f64, c: f64| (b * s / omega - x * c) / omega;
            let twice = |x: f64, s: f64, c: f64| -(x * s + 2.0 * b * c / omega) / (omega * omega);
            let (x, x1) = (a, a + b * t);
            [once(x1, s1, c1) - once(x, s, c), twice(x1, s1, c1) - twice(x, s, c) - once(x, s, c) * t]
        };
        let Some(by) = &self.along else { return parts(self.sweep.amplitude, 0.0, [start, end]) };
        let phase = self.phase.along(from, cell.side, by);
        let a = self.sweep.amplitude;
        // A cosine is the sine of an angle that is larger by a quarter turn.
        let turned = [start, end].map(|(s, c)| (c, -s));
        let (sines, cosines) =
            (parts(by.amplitude, 0.0, [start, end]), parts(a * phase[0], a * phase[1], turned));
        [sines[0] + cosines[0], sines[1] + cosines[1]]
    }

    /// Writes the coordinates just after a time.
    pub fn fill(&self, time: DoubleDouble, z: &mut [f64]) {
        let mut d = [0.0; COEFFICIENTS + INTEGRALS];
        let cell = self.cell(time.value());
        let (c, h) = self.polynomial(cell);
        let u = time.minus(cell.begin).value() / h;
        // Derivatives of the polynomial, whose coefficients are in the fraction u of the cell.
        let own = &mut d[self.order..];
        for (k, own) in own.iter_mut().enumerate().take(COEFFICIENTS) {
            let falling = |j: usize| (j - k + 1..=j).map(|i| i as f64).product::<f64>();
            let sum = (k..COEFFICIENTS).rev().fold(0.0, |sum, j| sum * u + falling(j) * c[j]);
            *own = sum / h.powi(k as i32);
        }
        if self.order > 0 {
            let [once, twice] = self.integrals(cell);
            let rising = |j: usize, order: usize| (1..=order).map(|i| (j + i) as f64).product::<f64>();
            let over = |order: usize| {
                let sum = (0..COEFFICIENTS).rev().fold(0.0, |sum, j| sum * u + c[j] / rising(j, order));
                sum * (h * u).powi(order as i32)
            };
            d[self.order - 1] = once + over(1);
            if self.order == 2 {
                d[0] = twice + once * h * u + over(2);
            }
        }
        let mut power = 1.0;
        for (z, d) in z[self.first..].iter_mut().zip(&d[..count(self.order)]) {
            *z = d / power;
            power *= self.scale;
        }
    }

    /// Advances the coordinates by a time within a cell.
    pub fn carry(&self, dt: f64, z: &mut [f64]) {
        let own = &mut z[self.places()];
        for k in 0..own.len() {
            let later = own[k..].iter().enumerate().skip(1).rev();
            let sum = later.fold(0.0, |sum, (j, y)| (sum + y) * self.scale * dt / j as f64);
            own[k] += sum;
        }
    }

    /// Range of its coordinates in the augmented state.
    pub fn places(&self) -> std::ops::Range<usize> {
        self.first..self.first + count(self.order)
    }
}

/// Error of a cell's polynomial relative to the amplitude, given a bound of the derivative of
/// order 12 times h¹²: error of Hermite interpolation, |f⁽¹²⁾| h¹²/(12! 4⁶).
fn remainder(bound: f64) -> f64 {
    const FACTOR: f64 = 479_001_600.0 * 4096.0;
    bound / FACTOR
}

/// Taylor coefficients in the fraction of a length h.
fn taylor(jet: &Jet, h: f64) -> Jet {
    let mut factor = 1.0;
    let mut c = *jet;
    for (k, c) in c.iter_mut().enumerate() {
        *c *= factor;
        factor *= h / (k + 1) as f64;
    }
    c
}

/// The polynomial of degree 11 that has the Taylor coefficients of a function at 0 and at 1.
fn hermite(begin: &Jet, end: &Jet) -> [f64; COEFFICIENTS] {
    // p = Σ cₖ uᵏ + u⁶ q, where u⁶ q has the Taylor coefficients r at u = 1. Let v = u - 1; q is
    // (1 + v)⁻⁶ Σ rₖ vᵏ up to v⁵.
    let rest: Jet = std::array::from_fn(|k| {
        let own: f64 = (k..ORDER).map(|j| binomial(j, k) * begin[j]).sum();
        end[k] - own
    });
    let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
    let by_v: Jet =
        std::array::from_fn(|k| (0..=k).map(|m| sign(m) * binomial(ORDER - 1 + m, m) * rest[k - m]).sum());
    let mut c = [0.0; COEFFICIENTS];
    c[..ORDER].copy_from_slice(begin);
    for i in 0..ORDER {
        c[ORDER + i] = (i..ORDER).map(|k| sign(k - i) * binomial(k, i) * by_v[k]).sum();
    }
    c
}
