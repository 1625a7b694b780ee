//! Result of a search.

use crate::attractors::Attractor;
use crate::evaluation::{Evaluation, Value};

/// Whether a limit is met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Check {
    /// The whole error bar meets the limit.
    Met,
    /// The whole error bar violates the limit.
    NotMet,
    /// The limit lies within the error bar, or there is no value.
    Undecided,
}

impl Check {
    /// Name of the result.
    pub fn name(self) -> &'static str {
        match self {
            Self::Met => "met",
            Self::NotMet => "not met",
            Self::Undecided => "undecided",
        }
    }
}

/// Verdict on the best design.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// One design is better than all other compared designs, beyond the error bars.
    Decided,
    /// Several designs may be the best, or something about the best one is open; with the reason.
    Undecided(String),
    /// No design that meets the limits was found; with the reason.
    NoneFound(String),
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Decided => f.write_str("decided"),
            Self::Undecided(why) => write!(f, "undecided: {why}"),
            Self::NoneFound(why) => write!(f, "none found: {why}"),
        }
    }
}

/// The best design.
#[derive(Clone, Debug, PartialEq)]
pub struct Best {
    /// The varied parameters, SI.
    pub values: Vec<f64>,
    /// Names of parameters at an end of their range.
    pub at_ends: Vec<String>,
    /// The goal: the worst of all motions of the design.
    pub goal: Value,
    /// The motion with this value, in words; empty if there is one motion.
    pub place: String,
    /// The value of each limited measure, and whether its limit is met.
    pub limits: Vec<(Option<Value>, Check)>,
    /// Largest number of returns for measuring its nonperiodic motions.
    pub periods: u32,
    /// A caveat about its motions.
    pub reason: Option<String>,
    /// Attractors at the worst point of the band.
    pub attractors: Vec<Attractor>,
}

/// Another compared design, far from the best and from the other rivals.
#[derive(Clone, Debug, PartialEq)]
pub struct Rival {
    /// The varied parameters, SI.
    pub values: Vec<f64>,
    /// The goal.
    pub goal: Value,
    /// Whether it is worse than the best design beyond the error bars.
    pub is_told_apart: bool,
}

/// Result of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct Designed {
    /// The verdict on the best design.
    pub verdict: Verdict,
    /// The best design; `None` if no design has a value.
    pub best: Option<Best>,
    /// Rivals, best first.
    pub rivals: Vec<Rival>,
    /// All evaluated designs, in order.
    pub evaluations: Vec<Evaluation>,
    /// Number of orbits whose gradients were computed in the steps of local searches.
    pub orbits: usize,
    /// Whether a local search by exact gradients found or confirmed the best design.
    pub has_gradients: bool,
}
