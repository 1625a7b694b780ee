//! Periodic orbits of described machines, stable or not, with their bifurcations along a parameter.
//!
//! ```text
//! word (events and modes) → cycle (the motion for given times) → problem (its equations) → orbit → path → branches
//! ```
//!
//! Between events a machine is linear, and an event at a given time is a linear map, so that the
//! motion over a word is linear in its start. An orbit's unknowns are its start and the times of
//! its events. A word is found by the machine's own motion, never written by hand.

// The Rust block of the package's page is run with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeBlocks;

mod bifurcation;
mod branch;
mod closing;
mod conditions;
mod corners;
mod crossing;
mod curve;
mod cycle;
mod directions;
mod examined;
mod gradient;
mod hidden;
mod kept;
mod known;
mod label;
mod location;
mod locus;
mod obstacle;
mod orbit;
pub mod paper;
mod parameter;
mod passes;
mod path;
mod path_options;
mod place;
mod position;
mod problem;
mod record;
mod search;
mod seed;
mod sides;
mod special;
mod step;
mod stop_word;
mod stored;
mod switching;
mod test_functions;
mod timed;
mod traced;
mod tree;
mod two_parameters;
mod violation;
mod wanted;
mod word;

#[cfg(test)]
mod tests;

pub use branch::{Branch, OrbitPoint, Special};
pub use conditions::Condition;
pub use cycle::Leg;
pub use examined::{check_measure, read_measure};
pub use gradient::ParameterDerivative;
pub use kept::KeptPaths;
pub use label::Label;
pub use locus::{LocusStart, check_second, locus};
pub use orbit::{Orbit, Stability};
pub use path_options::PathOptions;
pub use place::{Family, Place};
pub use search::{WantedPeriod, WordSearch};
pub use timed::{Source, Tick, Timed};
pub use tree::{TreeOptions, branch, tree, tree_on};
pub use two_parameters::{LocusEnd, LocusPoint};
pub use wanted::WantedWord;
pub use word::{Cause, Letter, Word};
