//! Means of a motion without a period, with their standard errors, and the test whether two such
//! motions are on one attractor.
//!
//! The observables are x1, x2, x3 and their squares, at whole drive periods and, for the mirror
//! image, at half periods. The mirror image of a motion has these two sets of six in the other
//! order. docs/theory.md, "When two motions without a period are one attractor", states the test
//! and its limits.

use super::stroboscopic::StroboscopicState;
use serde::{Deserialize, Serialize};

/// Drive periods in the shortest blocks.
const BLOCK: u32 = 8;
/// Smallest number of blocks with a meaningful scatter.
const LEAST_BLOCKS: usize = 8;
/// Resolution of the test: two means are equal if their difference plus two of its standard errors
/// is less than this fraction of the observable's standard deviation, docs/theory.md (N6).
pub const EQUAL: f64 = 0.25;
/// Distance of two means, in standard errors, beyond which they differ: docs/theory.md (N7).
pub const CONFIDENCE: f64 = 6.0;
/// Differences below this fraction of L, or of L² for a square, are ignored.
const FLOOR: f64 = 1e-3;

/// Observables at one kind of instant: x1, x2, x3 (units of L) and their squares.
type Observables = [f64; 6];

/// Likeness of two motions without a period by their means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Likeness {
    /// All means are equal within the resolution of the test.
    Same,
    /// A mean certainly differs.
    Different,
    /// The windows are too short to decide.
    Undecided,
}

/// Mean of an observable, with its standard error and the observable's standard deviation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Mean {
    /// The mean.
    pub value: f64,
    /// Standard error of the mean: the largest from blocks of any length, if there are at least
    /// eight blocks. Infinite if there are fewer.
    pub error: f64,
    /// Standard deviation of the observable.
    pub deviation: f64,
}

/// Means over a window of a motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Statistics {
    /// Length of the window, in drive periods.
    pub periods: u32,
    /// Means of x1, x2, x3 (units of L) and their squares at whole drive periods, and of the
    /// mirror image at half periods.
    pub means: [[Mean; 6]; 2],
}

impl Statistics {
    /// Whether the means are precise enough to compare others with them: to an eighth of the
    /// test's resolution.
    pub fn is_precise(&self) -> bool {
        let sharp = |m: &Mean| 8.0 * m.error < FLOOR.max(EQUAL * m.deviation);
        self.means.iter().flatten().all(sharp)
    }

    /// The means of the mirror image.
    pub fn mirrored(&self) -> Self {
        let [own, image] = self.means;
        Self { means: [image, own], ..*self }
    }

    /// Whether two motions have the same means: docs/theory.md (N6), (N7).
    pub fn likeness(&self, other: &Self) -> Likeness {
        let mut likeness = Likeness::Same;
        for (a, b) in self.means.iter().flatten().zip(other.means.iter().flatten()) {
            let (difference, error) = ((a.value - b.value).abs(), a.error.hypot(b.error));
            let resolution = FLOOR.max(EQUAL * a.deviation.max(b.deviation));
            if difference > FLOOR + CONFIDENCE * error {
                return Likeness::Different;
            }
            if difference + 2.0 * error > resolution {
                likeness = Likeness::Undecided;
            }
        }
        likeness
    }

    /// Pooled means of two windows of one attractor. Windows of different motions are independent.
    pub fn pooled(&self, other: &Self) -> Self {
        let all = f64::from(self.periods) + f64::from(other.periods);
        let [a, b] = [self, other].map(|s| f64::from(s.periods) / all.max(1.0));
        let mut together = Self { periods: self.periods.saturating_add(other.periods), ..*self };
        for (mean, (x, y)) in together
            .means
            .iter_mut()
            .flatten()
            .zip(self.means.iter().flatten().zip(other.means.iter().flatten()))
        {
            mean.value = a * x.value + b * y.value;
            // A window too short for an error does not contribute one.
            mean.error = match (x.error.is_finite(), y.error.is_finite()) {
                (true, true) => (a * x.error).hypot(b * y.error),
                _ => x.error.min(y.error),
            };
            let square = |m: &Mean| m.deviation * m.deviation + m.value * m.value;
            mean.deviation = (a * square(x) + b * square(y) - mean.value * mean.value).max(0.0).sqrt();
        }
        together
    }

    /// Root mean squares of x1, x2, x3 at whole and half drive periods, units of L.
    pub fn sizes(&self) -> [f64; 3] {
        let [whole, half] = &self.means;
        std::array::from_fn(|i| (0.5 * (whole[3 + i].value + half[3 + i].value)).max(0.0).sqrt())
    }
}

/// Observables of a motion in a growing window.
#[derive(Clone, Debug, Default)]
pub(crate) struct Blocks {
    /// Complete blocks.
    full: Vec<Block>,
    /// The current block and its number of drive periods.
    open: Block,
    count: u32,
}

/// Sums of the observables over a block, and of their squares.
#[derive(Clone, Copy, Debug, Default)]
struct Block {
    sums: [Observables; 2],
    squares: [Observables; 2],
}

/// Indices of all observables: kind of instant, observable.
fn places() -> impl Iterator<Item = (usize, usize)> {
    (0..2).flat_map(|k| (0..6).map(move |i| (k, i)))
}

fn observables(state: &StroboscopicState) -> Observables {
    let [x1, x2, x3, ..] = *state;
    [x1, x2, x3, x1 * x1, x2 * x2, x3 * x3]
}

impl Blocks {
    /// Appends the next window. Only the last window may end in an incomplete block.
    pub(crate) fn append(&mut self, next: Self) {
        self.full.extend(next.full);
        self.count += next.count;
        for (k, i) in places() {
            self.open.sums[k][i] += next.open.sums[k][i];
            self.open.squares[k][i] += next.open.squares[k][i];
        }
    }

    /// Drive periods of the window.
    pub(crate) fn periods(&self) -> u32 {
        BLOCK * self.full.len() as u32 + self.count
    }

    /// Adds a drive period: the state at its end, and the mirror image of the state at its middle.
    pub(crate) fn add(&mut self, whole: &StroboscopicState, mirrored_half: &StroboscopicState) {
        for (k, state) in [whole, mirrored_half].into_iter().enumerate() {
            for (i, q) in observables(state).into_iter().enumerate() {
                self.open.sums[k][i] += q;
                self.open.squares[k][i] += q * q;
            }
        }
        self.count += 1;
        if self.count == BLOCK {
            self.full.push(std::mem::take(&mut self.open));
            self.count = 0;
        }
    }

    /// Forgets the first half of the window.
    pub(crate) fn forget_half(&mut self) {
        self.full.drain(..self.full.len() / 2);
    }

    /// The means of the whole window.
    pub(crate) fn statistics(&self) -> Statistics {
        self.of(&self.full, true)
    }

    /// The means of the first and of the second half of the window.
    pub(crate) fn halves(&self) -> [Statistics; 2] {
        let (first, second) = self.full.split_at(self.full.len() / 2);
        [first, second].map(|part| self.of(part, false))
    }

    fn of(&self, blocks: &[Block], whole: bool) -> Statistics {
        let open = if whole { self.open } else { Block::default() };
        let periods = BLOCK * blocks.len() as u32 + if whole { self.count } else { 0 };
        let count = f64::from(periods.max(1));
        let mut found = Statistics { periods, ..Statistics::default() };
        for (k, i) in places() {
            let mean =
                |sums: &dyn Fn(&Block) -> f64| (blocks.iter().map(sums).sum::<f64>() + sums(&open)) / count;
            let (value, square) = (mean(&|b| b.sums[k][i]), mean(&|b| b.squares[k][i]));
            let error = standard_error(blocks.iter().map(|b| b.sums[k][i] / f64::from(BLOCK)));
            let deviation = (square - value * value).max(0.0).sqrt();
            found.means[k][i] = Mean { value, error, deviation };
        }
        found
    }
}

/// Standard error of the mean of correlated numbers: the largest from the scatter of blocks of 1,
/// 2, 4, … numbers, while there are [`LEAST_BLOCKS`]. It grows with the length of blocks while
/// they are shorter than the memory of the motion.
fn standard_error(numbers: impl Iterator<Item = f64>) -> f64 {
    let mut blocks: Vec<f64> = numbers.collect();
    let mut most = f64::NEG_INFINITY;
    while blocks.len() >= LEAST_BLOCKS {
        let count = blocks.len() as f64;
        let mean = blocks.iter().sum::<f64>() / count;
        let scatter = blocks.iter().map(|b| (b - mean).powi(2)).sum::<f64>();
        most = most.max((scatter / (count * (count - 1.0))).sqrt());
        blocks = blocks.chunks_exact(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
    }
    if most >= 0.0 { most } else { f64::INFINITY }
}

#[cfg(test)]
mod tests;
