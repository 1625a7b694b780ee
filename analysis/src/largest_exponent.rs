//! The largest Lyapunov exponent of a motion beside the drive phase's, which is zero, from the
//! motion's events alone.
//!
//! Between two events the variations follow a linear system (docs/theory.md, section 11), so that
//! one variation is carried over the whole time between them at once, and through the jump (84).
//! Nothing else is needed of the motion, which can be one of many side by side.
//!
//! The time that is counted is not fixed: it ends when the class is decided. Growth is summed over
//! blocks of drive periods, whose scatter gives the standard error of their mean. docs/studies.md,
//! "The largest exponent of many motions", states the rule.

use super::variation::SingleVariation;
use serde::{Deserialize, Serialize};
use vibro_impact::Parameters;
use vibro_impact::model::{Augmented, COORDINATES, Model, SmoothMode};
use vibro_impact::simulator::Event;

/// An exponent above this counts as positive and one below its negative as negative, per unit of
/// the dimensionless time τ or, where the drive is slower than the box by itself, of the time in
/// which the drive turns by 1 rad: over 1500 periods those that are zero stay within a few 1e-4.
pub const ZERO_EXPONENT: f64 = 1e-3;

/// The threshold of a machine's exponents, 1/s. With a drive hundreds of times slower than the box,
/// chaos has exponents under 1e-3 ω10.
pub(crate) fn zero_exponent(p: &Parameters) -> f64 {
    ZERO_EXPONENT * p.box_frequency().min(p.drive_frequency)
}

/// Drive periods in a block.
pub(crate) const BLOCK: u32 = 8;
/// Blocks in which the variation turns into its direction before anything is counted.
pub(crate) const ALIGN: u32 = 4;
/// An exponent is decided to be positive or negative when it is farther than so many standard
/// errors from the threshold, …
const CONFIDENCE: f64 = 6.0;
/// … and the variation has grown or shrunk by this, as a logarithm: on a torus it stays within some
/// powers of ten for ever.
const LEAST_GROWTH: f64 = 20.0;
/// Fewer blocks do not tell their scatter.
const LEAST_BLOCKS: u32 = 8;
/// Squares of lengths between which a variation is not scaled, …
const SCALED: std::ops::Range<f64> = 1e-200..1e200;
/// … and the longest time, in 1/rate, until that is looked at: a length changes by e¹⁰⁰ in it at
/// most, so that its square stays a number.
const LOOKED: f64 = 100.0;

/// The largest exponent of a motion apart from the drive phase's zero.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LargestExponent {
    /// Its estimate, 1/s; -∞ where all variations end in rest.
    pub value: f64,
    /// The standard error of the estimate, 1/s.
    pub error: f64,
    /// Drive periods that were counted.
    pub periods: u32,
}

/// What is known of the sign of an exponent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExponentSign {
    /// Positive for certain.
    Positive,
    /// Negative for certain.
    Negative,
    /// Between the thresholds, ± [`ZERO_EXPONENT`](crate::attractor::ZERO_EXPONENT) times ω10 or
    /// ω1, after so long that one beyond them would have made the variation grow or shrink by e²⁰.
    Zero,
    /// Not known.
    Undecided,
}

impl LargestExponent {
    /// What is known of the sign.
    pub fn sign(&self, p: &Parameters) -> ExponentSign {
        self.sign_beyond(zero_exponent(p), p.period())
    }

    /// The same for a threshold in 1/s and a period in s.
    pub(crate) fn sign_beyond(&self, threshold: f64, period: f64) -> ExponentSign {
        let time = f64::from(self.periods) * period;
        let clear = self.value.abs() - CONFIDENCE * self.error > threshold;
        match (clear, self.value > 0.0) {
            (true, positive) if self.value.abs() * time > LEAST_GROWTH => {
                if positive {
                    ExponentSign::Positive
                } else {
                    ExponentSign::Negative
                }
            }
            _ if self.value.abs() <= threshold && threshold * time > LEAST_GROWTH => ExponentSign::Zero,
            _ => ExponentSign::Undecided,
        }
    }
}

/// The logarithms of a variation's growth, in blocks of [`BLOCK`] periods.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Growth {
    /// In the block so far.
    own: f64,
    /// Blocks that are over, and the sums of the growth in those that count and of its square.
    blocks: u32,
    sums: [f64; 2],
}

impl Growth {
    /// The variation has grown by this, as a logarithm.
    pub(crate) fn add(&mut self, logarithm: f64) {
        self.own += logarithm;
    }

    /// Ends the block.
    pub(crate) fn end_block(&mut self) {
        self.blocks += 1;
        if self.blocks > ALIGN {
            self.sums[0] += self.own;
            self.sums[1] += self.own * self.own;
        }
        self.own = 0.0;
    }

    /// The exponent from the blocks so far, each of this many seconds.
    pub(crate) fn exponent(&self, block: f64) -> LargestExponent {
        let counted = self.blocks.saturating_sub(ALIGN);
        let (count, periods) = (f64::from(counted.max(1)), counted * BLOCK);
        if self.sums[0] == f64::NEG_INFINITY {
            return LargestExponent { value: f64::NEG_INFINITY, error: 0.0, periods };
        }
        let mean = self.sums[0] / count;
        let variance = (self.sums[1] / count - mean * mean).max(0.0);
        let error = (variance / (count - 1.0).max(1.0)).sqrt();
        LargestExponent { value: mean / block, error: error / block, periods }
    }

    /// Whether the exponent's sign is decided beyond a threshold in 1/s, or it has been counted
    /// over `most` periods.
    pub(crate) fn is_decided(&self, block: f64, threshold: f64, most: u32) -> bool {
        let LargestExponent { value, error, periods } = self.exponent(block);
        let clear = value.abs() - CONFIDENCE * error > threshold;
        let enough = periods >= LEAST_BLOCKS * BLOCK || self.sums[0].is_infinite();
        periods >= most || (clear && enough && self.sums[0].abs() > LEAST_GROWTH)
    }
}

/// One variation of a motion and the logarithms of its growth.
#[derive(Debug)]
pub(crate) struct Tangent {
    parameters: Parameters,
    /// Made at the first event, and made ready for other parameters at the first event with them.
    variation: Option<SingleVariation>,
    ready: bool,
    v: Augmented,
    mode: SmoothMode,
    /// Up to where the variation has come, s.
    time: f64,
    /// The length of a block and the end of the one under way, s.
    block: f64,
    block_end: f64,
    growth: Growth,
}

impl Default for Tangent {
    fn default() -> Self {
        Self {
            parameters: Parameters::default(),
            variation: None,
            ready: false,
            v: [0.0; COORDINATES],
            mode: SmoothMode::Flight,
            time: 0.0,
            block: 0.0,
            block_end: 0.0,
            growth: Growth::default(),
        }
    }
}

impl Tangent {
    /// Begins at `time`, s, with a motion that is in this mode. The first block begins at `from`,
    /// s, which may be some time before.
    pub(crate) fn begin(&mut self, parameters: &Parameters, mode: SmoothMode, (from, time): (f64, f64)) {
        // In general position, as `generic_frame`.
        const START: Augmented = [0.31, 0.47, -0.23, 0.41, 0.37, -0.29, 0.0, 0.0];
        let block = f64::from(BLOCK) * parameters.period();
        if self.parameters != *parameters {
            (self.parameters, self.ready) = (*parameters, false);
        }
        (self.v, self.mode, self.time) = (START, mode, time);
        (self.block, self.block_end) = (block, from + block);
        self.growth = Growth::default();
    }

    /// Carries the variation to an event and through its jump. `after` is the state after its law.
    pub(crate) fn event(&mut self, event: &Event, after: &Augmented) {
        match *event {
            Event::Impact { time, side, speed, .. } => {
                self.carry(time, Some((f64::from(side) * speed, after)));
            }
            Event::Release { time, .. } => {
                self.carry(time, None);
                self.mode = SmoothMode::Flight;
            }
            // Together with the impact before it: what is left of the chatter takes no time.
            Event::Rest { .. } => {
                if let Some(variation) = &self.variation {
                    variation.merge(&mut self.v);
                }
                self.mode = SmoothMode::Rest;
            }
        }
    }

    /// Carries the variation to `end`, s, where blocks end too.
    pub(crate) fn end_block(&mut self, end: f64) {
        self.carry(end, None);
        if end > self.block_end - 0.5 * self.block {
            self.count_blocks(self.block_end);
        }
    }

    fn carry(&mut self, time: f64, impact: Option<(f64, &Augmented)>) {
        if time >= self.block_end {
            self.count_blocks(time);
        }
        let variation = match &mut self.variation {
            Some(variation) if self.ready => variation,
            variation => {
                // The simulator has accepted the parameters.
                let Ok(model) = Model::new(&self.parameters) else { return };
                self.ready = true;
                let variation = variation.get_or_insert_with(|| SingleVariation::new(&model));
                variation.renew(&model);
                variation
            }
        };
        let span = (time - self.time).max(0.0);
        self.time = time;
        // More than one beside a drive that is slower than the dampers by far.
        let parts = (span * variation.rate() / LOOKED).ceil().max(1.0);
        for part in 1..=parts as u64 {
            let Some(variation) = &mut self.variation else { return };
            let impact = impact.filter(|_| part as f64 == parts);
            variation.propagate(&mut self.v, (self.mode, span / parts), impact);
            let square = self.square();
            if !SCALED.contains(&square) {
                self.scale(square.sqrt());
            }
        }
    }

    /// Ends the blocks up to `time`.
    fn count_blocks(&mut self, time: f64) {
        self.scale(self.square().sqrt());
        while self.block_end <= time {
            self.growth.end_block();
            self.block_end += self.block;
        }
    }

    /// The square of the variation's length, to which the drive's phase adds nothing.
    fn square(&self) -> f64 {
        let [a, b, c, d, e, f, ..] = self.v.map(|x| x * x);
        (a + b) + (c + d) + (e + f)
    }

    /// Makes the length one; a variation without length has shrunk by all.
    fn scale(&mut self, length: f64) {
        self.growth.add(length.ln());
        let scale = if length > 0.0 { 1.0 / length } else { 0.0 };
        for i in 0..COORDINATES {
            self.v[i] *= scale;
        }
    }

    /// The exponent from the blocks so far.
    pub(crate) fn exponent(&self) -> LargestExponent {
        self.growth.exponent(self.block)
    }

    /// Whether the exponent is positive for certain.
    pub(crate) fn is_positive(&self) -> bool {
        self.growth.sums[0] > 0.0 && self.is_decided(u32::MAX)
    }

    /// Whether the exponent's sign is decided, or it has been counted over `most` periods.
    pub(crate) fn is_decided(&self, most: u32) -> bool {
        self.growth.is_decided(self.block, zero_exponent(&self.parameters), most)
    }
}

#[cfg(test)]
mod tests;
