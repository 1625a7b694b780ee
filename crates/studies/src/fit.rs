//! Fits of a machine to a record: nonlinear least squares with exact derivatives.
//!
//! A motion with impacts follows its parameters only over a time: a plain fit over a long record
//! often ends in a wrong minimum. `schedule` has the ways that are tried, the cheapest first: plain
//! descent, growing horizons, estimation block by block, segments of the fitted motion, and starts
//! beside.

mod beside;
mod blocks;
mod bounds;
mod checks;
mod directions;
mod elimination;
mod errors;
mod evaluated;
mod filter;
mod finished;
mod horizons;
mod joint;
mod loss;
mod misfit;
mod model;
mod places;
mod problem;
mod profile;
mod progress;
mod record;
mod restarts;
mod rounded;
mod schedule;
mod search;
mod segments;
mod solver;
mod statistics;
mod suspects;
mod ties;
mod unknowns;
mod verdict;

pub use errors::{Uncertainty, Undetermined};
pub use filter::Filter;
pub use loss::Loss;
pub use misfit::{Misfit, misfit};
pub use places::{Concentration, Place};
pub use progress::{Observer, Progress};
pub use suspects::Suspect;
pub use verdict::Verdict;

pub use search::{fit, fit_records};

use super::{Machine, QuantityName};
use vibro_machine::Start;

/// Ways to lengthen horizons, the next where the residuals of the one before are more than noise.
const WAYS: [Way; 4] = [
    Way { near: 0.3, of_whole: true, growth: (1.25, 2.0) },
    Way { near: 0.3, of_whole: false, growth: (1.25, 2.0) },
    Way { near: 0.15, of_whole: false, growth: (1.1, 1.4) },
    Way { near: 0.05, of_whole: false, growth: (1.05, 1.2) },
];
/// A motion that is close to the record throughout.
const CLOSE: Way = Way { near: 0.05, of_whole: true, growth: (1.25, 2.0) };
/// Most free numbers.
const MOST_FREE: usize = 50;

/// How horizons become longer.
#[derive(Clone, Copy)]
struct Way {
    /// Part of a record's own deviation up to which a motion is near it.
    near: f64,
    /// Whether this deviation is that of the whole record, else of the record so far.
    of_whole: bool,
    /// Least and largest growth of a horizon.
    growth: (f64, f64),
}

/// A record: values of quantities at rising times, and times of contacts of stops.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured {
    /// Rising times, s, from the motion's start on.
    pub times: Vec<f64>,
    /// Columns with a value for each time, SI.
    pub columns: Vec<(QuantityName, Vec<f64>)>,
    /// Stops, each with the rising times of its impacts or first touches, s.
    pub contacts: Vec<(String, Vec<f64>)>,
}

/// A number that is fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct Free {
    /// A parameter of the machine, a number of the start, `record.shift` (s, the time of the motion
    /// at the record's time 0) or `record.offset.COLUMN`.
    pub name: String,
    /// Least and largest value, SI; those that the parameter allows if `None`.
    pub within: Option<(f64, f64)>,
    /// Whether each of several records has the number for itself, as the initial velocity of its
    /// motion. The numbers `record.…` always are.
    pub is_own: bool,
}

/// How the motion is divided into segments, each with a start of its own that continues the segment
/// before.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Segments {
    /// By the record: one motion where horizons lead to it, else segments that end where changes
    /// have grown.
    #[default]
    Auto,
    /// Segments of about this length, s.
    Length(f64),
    /// One motion.
    None,
}

/// The start of a segment.
#[derive(Clone, Debug, PartialEq)]
pub struct Fresh {
    /// Time of the record, s.
    pub time: f64,
    /// Its state, by the names of a start's numbers, SI.
    pub state: Vec<(String, f64)>,
    /// The end of the segment before less this state, SI.
    pub defect: Vec<f64>,
}

/// What is fitted to which record.
#[derive(Clone, Debug)]
pub struct FitRequest {
    /// The machine with the values from which the fit begins.
    pub machine: Machine,
    /// Start of the motion.
    pub start: Start,
    /// The record.
    pub measured: Measured,
    /// The numbers that are fitted.
    pub free: Vec<Free>,
    /// Standard deviation of each column's noise, SI, in their order, then of the contacts' times,
    /// s. Without them all columns weigh the same by their own deviation.
    pub sigma: Option<Vec<f64>>,
    /// Filters of the sensors of columns; a column of accelerations has one.
    pub filters: Vec<Filter>,
    /// How residuals count.
    pub loss: Loss,
    /// Whether the motion is divided.
    pub segments: Segments,
    /// Number of further starts, spread over the ranges of the free numbers.
    pub starts: u32,
}

/// A fitted machine.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// Whether the fitted motion is the record's; errors are those of the record only where it is.
    pub verdict: Verdict,
    /// The machine with the fitted numbers.
    pub machine: Machine,
    /// The start of its motion.
    pub start: Start,
    /// The free numbers' names and values, SI.
    pub values: Vec<(String, f64)>,
    /// Standard errors, correlations, what the record does not determine.
    pub uncertainty: Uncertainty,
    /// Root mean square of the residuals of each column and of the contacts' times, SI.
    pub rms: Vec<(String, f64)>,
    /// For each time of the record and then each column the motion's value less the record's, SI.
    pub residuals: Vec<Vec<f64>>,
    /// For each stop the times of the motion's contacts less those of the record, s; NaN where the
    /// motion has none.
    pub contacts: Vec<(String, Vec<f64>)>,
    /// Times of the record at which stops of the fitted motion are hit or touched, with their
    /// names.
    pub events: Vec<(f64, String)>,
    /// Segments after the first; empty of one motion.
    pub segments: Vec<Fresh>,
    /// Numbers that lie at an end of their range, with that end, SI: their errors are of one side.
    pub at_bounds: Vec<(String, f64)>,
    /// Why the fitted motion has no derivative by a number from some time on; differences stand
    /// there.
    pub lost: Vec<String>,
    /// Number of motions that were followed.
    pub simulations: u32,
    /// Time up to which the motion keeps near the record, s: its last where it does throughout.
    pub near_until: f64,
    /// Sum of the losses, in units of the standard deviations' squares.
    pub cost: f64,
}
