//! Means of a motion without a period, with their standard errors, and the test by which two such
//! motions are one attractor.
//!
//! Six observables are followed: x1, x2, x3 and their squares, at whole drive periods and, of the
//! mirror image, at half ones. Two sets of six, since the mirror image of a motion has the same two
//! in the other order. docs/studies.md, "When two motions without a period are one attractor",
//! states the test and what it leaves open.

use super::stroboscopic::StroboscopicState;
use serde::{Deserialize, Serialize};

/// Drive periods in the shortest blocks.
const BLOCK: u32 = 8;
/// Fewer blocks do not tell their scatter.
const LEAST_BLOCKS: usize = 8;
/// Two means are the same when their difference and two of its standard errors are less than this
/// part of the observable's standard deviation: docs/studies.md (N1). It is the resolution of the
/// test.
pub const EQUAL: f64 = 0.25;
/// Two means differ when they are farther apart than so many standard errors: docs/studies.md (N2).
pub const CONFIDENCE: f64 = 6.0;
/// Nothing less than this part of L, or of L² for a square, tells two motions apart.
const FLOOR: f64 = 1e-3;

/// The observables of one kind of instant: x1, x2, x3 (units of L) and their squares.
type Observables = [f64; 6];

/// What two motions without a period are to each other by their means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Likeness {
    /// All means are the same to within the resolution of the test.
    Same,
    /// A mean differs for certain.
    Different,
    /// The windows are too short to tell.
    Undecided,
}

/// One mean, with its standard error, and the standard deviation of the observable.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Mean {
    /// The mean.
    pub value: f64,
    /// Its standard error: the largest that blocks of any length give, of which there are eight or
    /// more. Infinite where there are fewer.
    pub error: f64,
    /// The standard deviation of the observable itself.
    pub deviation: f64,
}

/// Means over a window of a motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Statistics {
    /// The window, in drive periods.
    pub periods: u32,
    /// Of x1, x2, x3 (units of L) and their squares at whole drive periods, and of the mirror image
    /// at half ones.
    pub means: [[Mean; 6]; 2],
}

impl Statistics {
    /// Whether the means are known well enough for others to be compared with them: to an eighth of
    /// the test's resolution.
    pub fn is_precise(&self) -> bool {
        let sharp = |m: &Mean| 8.0 * m.error < FLOOR.max(EQUAL * m.deviation);
        self.means.iter().flatten().all(sharp)
    }

    /// The same of the mirror image.
    pub fn mirrored(&self) -> Self {
        let [own, image] = self.means;
        Self { means: [image, own], ..*self }
    }

    /// Whether two motions have the same means: docs/studies.md (N1), (N2).
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

    /// The means of two windows of one attractor together. Windows of different motions are
    /// independent.
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
            // A window too short to tell its error adds none of its own.
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

/// A motion's observables, as its window grows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Blocks {
    /// Blocks that are full.
    full: Vec<Block>,
    /// The block under way and the number of its drive periods.
    open: Block,
    count: u32,
}

/// Sums of the observables over a block, and of their squares.
#[derive(Clone, Copy, Debug, Default)]
struct Block {
    sums: [Observables; 2],
    squares: [Observables; 2],
}

/// The places of all observables: of which instants, and which one.
fn places() -> impl Iterator<Item = (usize, usize)> {
    (0..2).flat_map(|k| (0..6).map(move |i| (k, i)))
}

fn observables(state: &StroboscopicState) -> Observables {
    let [x1, x2, x3, ..] = *state;
    [x1, x2, x3, x1 * x1, x2 * x2, x3 * x3]
}

impl Blocks {
    /// Adds a window that follows at once. Windows are whole blocks but for the last one.
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

    /// Adds a drive period: the state at its end, and that of the mirror image at its middle.
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

    /// The means of its first and of its second half.
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

/// The standard error of the mean of correlated numbers: the largest of those that the scatter of
/// blocks of 1, 2, 4, … of them gives, as long as there are [`LEAST_BLOCKS`]. While blocks are
/// shorter than the memory of the motion it grows with their length.
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
