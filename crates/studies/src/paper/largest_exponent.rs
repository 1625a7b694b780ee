//! Largest Lyapunov exponent of a motion, computed from its events. The zero exponent of the
//! drive's phase is left out.
//!
//! Between two events the variations follow a linear system (docs/theory.md, section 11). One
//! variation is carried from event to event in a single step (in several if the flight is very
//! long), and over each event by the jump (84). This needs only the events of the motion and the
//! states after them, so the motion may be one of a batch.
//!
//! The averaging time ends when the sign of the exponent is decided, or after a given number of
//! periods. Growth is summed over blocks of drive periods, whose scatter gives the standard error
//! of their mean. docs/theory.md, "The largest exponent of many motions", states the rule.

use super::variation::SingleVariation;
use crate::exponent::{CONFIDENCE, ExponentSign, LEAST_GROWTH, LargestExponent, ZERO_EXPONENT};
use vibro_impact::Parameters;
use vibro_impact::model::{Augmented, COORDINATES, Model, SmoothMode};
use vibro_impact::simulator::Event;

/// Threshold for the sign of a machine's exponent, 1/s. It is relative to the slower of box and
/// drive: with a drive hundreds of times slower than the box, even chaotic motions have exponents
/// below 1e-3 ω10.
pub(crate) fn zero_exponent(p: &Parameters) -> f64 {
    ZERO_EXPONENT * p.box_frequency().min(p.drive_frequency)
}

/// Drive periods in a block.
pub(crate) const BLOCK: u32 = 8;
/// Number of first blocks whose growth is not counted. During them the variation aligns with the
/// most expanding direction.
pub(crate) const ALIGN: u32 = 4;
/// Smallest number of blocks with a meaningful scatter.
const LEAST_BLOCKS: u32 = 8;
/// Range of squared lengths; a variation outside of it is rescaled.
const SCALED: std::ops::Range<f64> = 1e-200..1e200;
/// Longest time between checks of the length, in 1/rate. The length changes by at most e¹⁰⁰ in
/// this time, so its square does not overflow.
const LOOKED: f64 = 100.0;

impl LargestExponent {
    /// The sign at a machine's threshold.
    pub fn sign(&self, p: &Parameters) -> ExponentSign {
        self.sign_beyond(zero_exponent(p), p.period())
    }
}

/// Logarithms of a variation's growth, in blocks of [`BLOCK`] periods.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Growth {
    /// Growth in the current block.
    own: f64,
    /// Number of completed blocks; sums of the growth in counted blocks and of its square.
    blocks: u32,
    sums: [f64; 2],
}

impl Growth {
    /// Adds the logarithm of a growth to the current block.
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

    /// The exponent from the completed blocks, each `block` seconds long.
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

    /// Whether the exponent's sign is decided at a threshold, 1/s, or `most` periods are counted.
    pub(crate) fn is_decided(&self, block: f64, threshold: f64, most: u32) -> bool {
        let LargestExponent { value, error, periods } = self.exponent(block);
        let clear = value.abs() - CONFIDENCE * error > threshold;
        let enough = periods >= LEAST_BLOCKS * BLOCK || self.sums[0].is_infinite();
        periods >= most || (clear && enough && self.sums[0].abs() > LEAST_GROWTH)
    }
}

/// A variation of a motion, with the logarithms of its growth.
#[derive(Debug)]
pub(crate) struct Tangent {
    parameters: Parameters,
    /// Created when first carried, and renewed when first carried with new parameters.
    variation: Option<SingleVariation>,
    ready: bool,
    v: Augmented,
    mode: SmoothMode,
    /// Present time of the variation, s.
    time: f64,
    /// Length of a block and end of the current one, s.
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
    /// Starts at `time`, s, when the motion is in `mode`. The first block begins at `from`, s,
    /// which may be earlier.
    pub(crate) fn begin(&mut self, parameters: &Parameters, mode: SmoothMode, (from, time): (f64, f64)) {
        // A variation in general position, as in `generic_frame`.
        const START: Augmented = [0.31, 0.47, -0.23, 0.41, 0.37, -0.29, 0.0, 0.0];
        let block = f64::from(BLOCK) * parameters.period();
        if self.parameters != *parameters {
            (self.parameters, self.ready) = (*parameters, false);
        }
        (self.v, self.mode, self.time) = (START, mode, time);
        (self.block, self.block_end) = (block, from + block);
        self.growth = Growth::default();
    }

    /// Carries the variation to an event and through its jump. `after` is the state after the
    /// event's law.
    pub(crate) fn event(&mut self, event: &Event, after: &Augmented) {
        match *event {
            Event::Impact { time, side, speed, .. } => {
                self.carry(time, Some((f64::from(side) * speed, after)));
            }
            Event::Release { time, .. } => {
                self.carry(time, None);
                self.mode = SmoothMode::Flight;
            }
            // The contact closes at the time of the impact before it, since the remaining bounces
            // of the chatter take no time.
            Event::Rest { .. } => {
                if let Some(variation) = &self.variation {
                    variation.merge(&mut self.v);
                }
                self.mode = SmoothMode::Rest;
            }
        }
    }

    /// Carries the variation to `end`, s, at which a block ends.
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
        // There is more than one part if no event occurs for longer than 100/rate, for example
        // without impacts under a slow drive.
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

    /// Square of the variation's length; the drive's phase does not contribute.
    fn square(&self) -> f64 {
        let [a, b, c, d, e, f, ..] = self.v.map(|x| x * x);
        (a + b) + (c + d) + (e + f)
    }

    /// Scales the length to one. A variation of length zero has growth -∞.
    fn scale(&mut self, length: f64) {
        self.growth.add(length.ln());
        let scale = if length > 0.0 { 1.0 / length } else { 0.0 };
        for i in 0..COORDINATES {
            self.v[i] *= scale;
        }
    }

    /// The exponent from the completed blocks.
    pub(crate) fn exponent(&self) -> LargestExponent {
        self.growth.exponent(self.block)
    }

    /// Whether the exponent is certainly positive.
    pub(crate) fn is_positive(&self) -> bool {
        self.growth.sums[0] > 0.0 && self.is_decided(u32::MAX)
    }

    /// Whether the exponent's sign is decided, or `most` periods are counted.
    pub(crate) fn is_decided(&self, most: u32) -> bool {
        self.growth.is_decided(self.block, zero_exponent(&self.parameters), most)
    }
}

#[cfg(test)]
mod tests;
