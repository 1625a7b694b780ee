//! Fits of a machine to a record: nonlinear least squares with exact derivatives.
//!
//! A motion with impacts depends smoothly on its parameters over a short time only, so a plain fit
//! over a long record often ends in a wrong minimum. `schedule` tries several strategies, the
//! cheapest first: plain descent, growing horizons, a block filter, segments of the fitted motion,
//! and restarts.

mod beside;
mod blocks;
mod bounds;
mod checks;
mod directions;
mod divided;
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

/// Growing horizons in order; the next one is tried while residuals exceed noise.
const WAYS: [Way; 4] = [
    Way { near: 0.3, of_whole: true, growth: (1.25, 2.0) },
    Way { near: 0.3, of_whole: false, growth: (1.25, 2.0) },
    Way { near: 0.15, of_whole: false, growth: (1.1, 1.4) },
    Way { near: 0.05, of_whole: false, growth: (1.05, 1.2) },
];
/// Criterion for a motion that is close to the whole record.
const CLOSE: Way = Way { near: 0.05, of_whole: true, growth: (1.25, 2.0) };
/// Largest number of free parameters.
const MOST_FREE: usize = 50;

/// Growth of horizons.
#[derive(Clone, Copy)]
struct Way {
    /// A motion is near the record up to this fraction of the record's standard deviation.
    near: f64,
    /// Whether the standard deviation is over the whole record, otherwise over its part so far.
    of_whole: bool,
    /// Smallest and largest growth factor of a horizon.
    growth: (f64, f64),
}

/// Record: values of quantities at increasing times, and contact times of stops.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured {
    /// Increasing times, s, not before the motion's start.
    pub times: Vec<f64>,
    /// Columns with a value for each time, SI.
    pub columns: Vec<(QuantityName, Vec<f64>)>,
    /// Stops with the increasing times of their impacts or first touches, s.
    pub contacts: Vec<(String, Vec<f64>)>,
}

/// A fitted parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Free {
    /// Parameter of the machine or the start, `record.shift` (s, time of the motion at the
    /// record's time 0) or `record.offset.COLUMN`.
    pub name: String,
    /// Smallest and largest value, SI; the parameter's own range if `None`.
    pub within: Option<(f64, f64)>,
    /// Whether each of several records has its own value, for example the initial velocity of its
    /// motion. Parameters `record.…` always have one for each record.
    pub is_own: bool,
}

/// Division of the motion into segments, each with its own initial state, which the fit ties to
/// the end of the previous segment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Segments {
    /// Automatic: a single motion if growing horizons lead to it, otherwise segments that end
    /// where small changes have grown.
    #[default]
    Auto,
    /// Segments of about this length, s.
    Length(f64),
    /// A single motion.
    None,
}

/// Initial state of a segment.
#[derive(Clone, Debug, PartialEq)]
pub struct Fresh {
    /// Time of the record, s.
    pub time: f64,
    /// State, by the names of start parameters, SI.
    pub state: Vec<(String, f64)>,
    /// End of the previous segment minus this state, SI.
    pub defect: Vec<f64>,
}

/// Request for a fit: machine, record and free parameters.
#[derive(Clone, Debug)]
pub struct FitRequest {
    /// Name of the record in messages about several records; if empty, its number.
    pub name: String,
    /// Machine with the initial parameter values.
    pub machine: Machine,
    /// Start of the motion.
    pub start: Start,
    /// The record.
    pub measured: Measured,
    /// Free parameters.
    pub free: Vec<Free>,
    /// Standard deviation of the noise: of each column in order, SI, then of contact times, s.
    /// Without it, each column is weighted by its own standard deviation.
    pub sigma: Option<Vec<f64>>,
    /// Sensor filters of columns; a column of accelerations requires one.
    pub filters: Vec<Filter>,
    /// Loss function of the residuals.
    pub loss: Loss,
    /// Division into segments.
    pub segments: Segments,
    /// Number of further starts, spread over the ranges of the free parameters.
    pub starts: u32,
}

/// A fitted machine.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// Whether the motion is the record's; the errors are valid only if it is.
    pub verdict: Verdict,
    /// Machine with the fitted parameters.
    pub machine: Machine,
    /// Start of its motion.
    pub start: Start,
    /// Names and values of the free parameters, SI.
    pub values: Vec<(String, f64)>,
    /// Standard errors, correlations and undetermined combinations.
    pub uncertainty: Uncertainty,
    /// Root mean square residual of each column and of the contact times, SI.
    pub rms: Vec<(String, f64)>,
    /// Motion minus record, for each time and then each column, SI.
    pub residuals: Vec<Vec<f64>>,
    /// Motion minus record of the contact times of each stop, s; NaN if the motion lacks the
    /// contact.
    pub contacts: Vec<(String, Vec<f64>)>,
    /// Record times of impacts and first touches of the fitted motion, with the stops' names.
    pub events: Vec<(f64, String)>,
    /// Segments after the first; empty for a single motion.
    pub segments: Vec<Fresh>,
    /// Parameters at an end of their range, with that end, SI; their errors are one-sided.
    pub at_bounds: Vec<(String, f64)>,
    /// Reasons why derivatives stop existing at some time; finite differences replace them.
    pub lost: Vec<String>,
    /// Number of simulations.
    pub simulations: u32,
    /// End of the agreement with the record, s: the last time with a motion near the record, or
    /// the record's end.
    pub near_until: f64,
    /// Sum of losses, in units of the squared standard deviations.
    pub cost: f64,
}
