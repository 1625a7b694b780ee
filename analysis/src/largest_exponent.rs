//! The largest Lyapunov exponent of a motion beside the drive phase's, which is zero, from the motion's events alone.
//!
//! Between two events the variations follow a linear system (docs/theory.md, section 11), so that one variation is carried over the whole
//! time between them at once, and through the jump (84). Nothing else is needed of the motion, which can be one of many side by side.
//!
//! The time that is counted is not fixed: it ends when the class is decided. Growth is summed over blocks of drive periods, whose
//! scatter gives the standard error of their mean. docs/numerics.md, "The largest exponent of many motions", states the rule.

use super::attractor::ZERO_EXPONENT;
use super::variation::Variation;
use serde::{Deserialize, Serialize};
use vibro_impact::Parameters;
use vibro_impact::model::{Augmented, LANES, Model, RELATIVE, RELATIVE_RATE, SmoothMode};
use vibro_impact::simulator::{Event, Simulator};

/// Drive periods in a block.
pub(crate) const BLOCK: u32 = 8;
/// Blocks in which the variation turns into its direction before anything is counted.
const ALIGN: u32 = 4;
/// An exponent is decided to be positive or negative when it is farther than so many standard errors from the threshold, …
const CONFIDENCE: f64 = 5.0;
/// … and the variation has grown or shrunk by this, as a logarithm: on a torus it stays within some powers of ten for ever.
const LEAST_GROWTH: f64 = 20.0;
/// Lengths between which a variation is not scaled.
const SCALED: std::ops::Range<f64> = 1e-100..1e100;

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

/// One variation of a motion and the logarithms of its growth.
#[derive(Debug, Default)]
pub(crate) struct Tangent {
    parameters: Option<Parameters>,
    /// Made at the first event.
    variation: Option<Box<Variation>>,
    v: Augmented,
    mode: Option<SmoothMode>,
    /// Up to where the variation has come, s.
    time: f64,
    /// The length of a block and the end of the one under way, s.
    block: f64,
    block_end: f64,
    /// The logarithm of the growth in the block so far.
    growth: f64,
    /// Blocks that are over, and the sums of the growth in those that count and of its square.
    blocks: u32,
    sums: [f64; 2],
}

impl Tangent {
    /// Begins at the present of a motion.
    pub(crate) fn begin(&mut self, simulator: &Simulator) {
        // In general position, as `generic_frame`.
        const START: Augmented = [0.31, 0.47, -0.23, 0.41, 0.37, -0.29, 0.0, 0.0];
        let p = *simulator.parameters();
        if self.parameters != Some(p) {
            self.variation = None;
        }
        let block = f64::from(BLOCK) * p.period();
        *self = Self {
            parameters: Some(p),
            variation: self.variation.take(),
            v: START,
            mode: Some(simulator.contact().mode()),
            time: simulator.time(),
            block,
            block_end: simulator.time() + block,
            ..Self::default()
        };
    }

    /// Carries the variation to an event and through its jump. `after` is the state after its law.
    pub(crate) fn event(&mut self, event: &Event, after: &Augmented) {
        match *event {
            Event::Impact { time, side, speed, .. } => {
                self.carry(time, Some((f64::from(side) * speed, after)));
            }
            Event::Release { time, .. } => {
                self.carry(time, None);
                self.mode = Some(SmoothMode::Flight);
            }
            // Together with the impact before it: what is left of the chatter takes no time.
            Event::Rest { .. } => {
                (self.v[RELATIVE], self.v[RELATIVE_RATE]) = (0.0, 0.0);
                self.mode = Some(SmoothMode::Rest);
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
        let (Some(p), Some(mode)) = (&self.parameters, self.mode) else { return };
        if self.variation.is_none() {
            // The simulator has accepted the parameters.
            let Ok(model) = Model::new(p) else { return };
            self.variation = Some(Box::new(Variation::new(&model)));
        }
        if let Some(variation) = &mut self.variation {
            variation.propagate_one(&mut self.v, (mode, (time - self.time).max(0.0)), impact);
        }
        self.time = time;
        let length = self.length();
        if !SCALED.contains(&length) {
            self.scale(length);
        }
    }

    /// Ends the blocks up to `time`.
    fn count_blocks(&mut self, time: f64) {
        self.scale(self.length());
        while self.block_end <= time {
            self.blocks += 1;
            if self.blocks > ALIGN {
                self.sums[0] += self.growth;
                self.sums[1] += self.growth * self.growth;
            }
            self.growth = 0.0;
            self.block_end += self.block;
        }
    }

    fn length(&self) -> f64 {
        self.v.iter().map(|x| x * x).sum::<f64>().sqrt()
    }

    /// Makes the length one; a variation without length has shrunk by all.
    fn scale(&mut self, length: f64) {
        self.growth += length.ln();
        let scale = if length > 0.0 { 1.0 / length } else { 0.0 };
        for i in 0..LANES {
            self.v[i] *= scale;
        }
    }

    /// The exponent from the blocks so far.
    pub(crate) fn exponent(&self) -> LargestExponent {
        let counted = self.blocks.saturating_sub(ALIGN);
        let (count, periods) = (f64::from(counted.max(1)), counted * BLOCK);
        if self.sums[0] == f64::NEG_INFINITY {
            return LargestExponent { value: f64::NEG_INFINITY, error: 0.0, periods };
        }
        let mean = self.sums[0] / count;
        let variance = (self.sums[1] / count - mean * mean).max(0.0);
        let error = (variance / (count - 1.0).max(1.0)).sqrt();
        LargestExponent { value: mean / self.block, error: error / self.block, periods }
    }

    /// Whether the exponent's sign is decided, or it has been counted over `most` periods.
    pub(crate) fn is_decided(&self, most: u32) -> bool {
        let LargestExponent { value, error, periods } = self.exponent();
        let rate = self.parameters.map_or(1.0, |p| p.box_frequency());
        let clear = value.abs() - CONFIDENCE * error > ZERO_EXPONENT * rate;
        periods >= most || (clear && self.sums[0].abs() > LEAST_GROWTH)
    }
}

#[cfg(test)]
#[path = "largest_exponent/tests.rs"]
mod tests;
