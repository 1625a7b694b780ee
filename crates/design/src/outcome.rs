//! Result of a search.

use crate::attractors::Attractor;
use crate::evaluation::{Evaluation, Value};

/// Whether a limit is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Check {
    /// Kept by the whole error bar.
    Met,
    /// Passed by the whole error bar.
    NotMet,
    /// The limit lies within the error bar, or there is no value.
    Undecided,
}

impl Check {
    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Met => "met",
            Self::NotMet => "not met",
            Self::Undecided => "undecided",
        }
    }
}

/// What is known of the best design.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// One design is better than all others that were compared, beyond the error bars.
    Decided,
    /// Several designs may be the best, or something about the best one is open; the reason.
    Undecided(String),
    /// No design that keeps the limits was found.
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
    /// The numbers that vary, SI.
    pub values: Vec<f64>,
    /// Numbers at an end of their range, by name.
    pub at_ends: Vec<String>,
    /// The goal: the worst of all motions of the design.
    pub goal: Value,
    /// The motion with this value, in words; empty where there is one motion.
    pub place: String,
    /// Each limited measure and whether its limit is kept.
    pub limits: Vec<(Option<Value>, Check)>,
    /// Largest number of returns over which its motions were measured, except those that repeat.
    pub periods: u32,
    /// A caveat of its motions.
    pub reason: Option<String>,
    /// Attractors at the place of the worst value.
    pub attractors: Vec<Attractor>,
}

/// Another design that was compared with the best one, far from it and from the others.
#[derive(Clone, Debug, PartialEq)]
pub struct Rival {
    /// The numbers that vary, SI.
    pub values: Vec<f64>,
    /// The goal.
    pub goal: Value,
    /// Whether it is worse than the best beyond the error bars.
    pub is_told_apart: bool,
}

/// Result of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct Designed {
    /// What is known of the best design.
    pub verdict: Verdict,
    /// The best design; `None` where no design has a value.
    pub best: Option<Best>,
    /// Other designs that were compared with it, best first.
    pub rivals: Vec<Rival>,
    /// All evaluated designs, in order.
    pub evaluations: Vec<Evaluation>,
    /// Number of orbits that were sought for gradients.
    pub orbits: usize,
    /// Whether the best comes from, or was confirmed by, a local search by exact gradients.
    pub has_gradients: bool,
}
