//! Options for tracing a tree.

use super::settled::{LONGEST, Limits};
use crate::path_options::PathOptions;
use crate::stop_word::{MOST_LETTERS, OrbitWord};
use serde::{Deserialize, Serialize};
use vibro_studies::Error;

/// Extent and limits of a tree.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TreeOptions {
    /// Number of parameter values with settled motions, for rising and for falling values each.
    pub seeds: usize,
    /// Number of drive periods for transients to die out.
    pub settle: u32,
    /// Number of motions from starts spread over the range and over the states visited by settled
    /// motions. Branches of orbits near which they pass are kept if they are stable somewhere.
    /// Such islands are not reached by motions followed along the range.
    #[serde(default)]
    pub starts: usize,
    /// Largest number of successive switches of branches since a settled motion.
    pub depth: u32,
    /// Longest period of a branch, in drive periods.
    pub longest_period: u32,
    /// Largest number of letters of a word.
    pub most_letters: usize,
    /// Longest step, as [`PathOptions::longest_step`].
    pub longest_step: f64,
    /// Largest number of points of a branch in one direction.
    pub most_points: usize,
    /// Cap on the repetitions in words that list a touch in only one of them. If it is 1, words
    /// list the touch in every repetition.
    pub repetitions: u32,
    /// Values of the parameter at which each branch has a point, labelled UZ.
    pub marks: Vec<f64>,
}

/// Largest permitted number of repetitions and longest permitted period.
const MOST_REPETITIONS: u32 = 64;
const LONGEST_PERIOD: u32 = 1 << 12;

/// Largest number of starts.
const MOST_STARTS: usize = 1_000_000;

impl TreeOptions {
    /// Refuses options for which a tree would not end or would exceed the memory.
    pub(super) fn check(&self) -> Result<(), Error> {
        let refused = |text: String, expected| Err(Error::Form { text, expected });
        if !(1..=MOST_REPETITIONS).contains(&self.repetitions) {
            return refused(format!("{} repetitions", self.repetitions), "1 to 64");
        }
        if self.longest_period > LONGEST_PERIOD {
            return refused(format!("longest period {}", self.longest_period), "up to 4096 drive periods");
        }
        if self.starts > MOST_STARTS {
            return refused(format!("{} starts", self.starts), "up to 1,000,000");
        }
        if self.most_letters > MOST_LETTERS {
            return refused(format!("{} letters", self.most_letters), "up to 1024");
        }
        Ok(())
    }

    /// Whether a word is within the limits of period and letters.
    pub(super) fn admits(&self, word: &OrbitWord) -> bool {
        word.period() <= self.longest_period && word.len() <= self.most_letters
    }

    /// Limits for finding any word of a tree from a motion; the word may be half of the orbit.
    pub(super) fn limits(&self) -> Limits {
        let impacts = self.most_letters.saturating_mul(2).min(MOST_LETTERS);
        Limits { periods: self.longest_period.min(LONGEST), impacts }
    }
}

impl Default for TreeOptions {
    fn default() -> Self {
        let PathOptions { longest_step, most_points } = PathOptions::default();
        Self {
            seeds: 91,
            settle: 1000,
            starts: 512,
            depth: 12,
            longest_period: 32,
            most_letters: 64,
            longest_step,
            most_points,
            repetitions: 1,
            marks: Vec::new(),
        }
    }
}
