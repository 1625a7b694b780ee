//! Options for following a branch.

use vibro_studies::Error;

/// Options for following a branch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathOptions {
    /// Longest step along a branch: phases in rad, the parameter in fifths of its range.
    pub longest_step: f64,
    /// Largest number of points of a branch in one direction.
    pub most_points: usize,
}

impl PathOptions {
    /// Permitted values of the longest step. Shorter steps are close to the length at which a path
    /// counts as stuck. A step of any length can miss two special points of one kind, or a pair of
    /// multipliers that crosses the unit circle near a fold; longer steps miss them more often.
    pub const STEPS: std::ops::RangeInclusive<f64> = 1e-5..=0.2;

    /// Refuses a longest step outside [`STEPS`](Self::STEPS).
    pub(super) fn check(&self) -> Result<(), Error> {
        if Self::STEPS.contains(&self.longest_step) {
            return Ok(());
        }
        let text = format!("longest step {}", self.longest_step);
        Err(Error::Form { text, expected: "a number from 1e-5 to 0.2" })
    }
}

impl Default for PathOptions {
    fn default() -> Self {
        Self { longest_step: 0.05, most_points: 3000 }
    }
}
