//! Fits of a machine to a record: nonlinear least squares with exact derivatives.
//!
//! A motion with impacts follows its parameters only over a time: a plain fit over a long record
//! often ends in a wrong minimum. `schedule` has the ways that are tried, the cheapest first: plain
//! descent, growing horizons, estimation block by block, segments of the fitted motion, and starts
//! beside.

mod beside;
mod blocks;
mod checks;
mod directions;
mod elimination;
mod errors;
mod evaluated;
mod filter;
mod finished;
mod horizons;
mod loss;
mod model;
mod profile;
mod progress;
mod record;
mod restarts;
mod rounded;
mod schedule;
mod segments;
mod solver;
mod statistics;
mod ties;
mod unknowns;
mod verdict;

pub use errors::{Uncertainty, Undetermined};
pub use filter::Filter;
pub use loss::Loss;
pub use progress::{Observer, Progress};
pub use verdict::Verdict;

use self::checks::check;
use self::evaluated::{Reach, Solved};
use self::model::Model;
use self::profile::{Profile, profile};
use self::restarts::{Found, restarted};
use self::schedule::{MOST_ATTEMPTS, best_from};
use self::solver::{Bounds, Convergence, solve};
use super::{Machine, QuantityName};
use crate::error::{Error, Result};
use crate::sobol;
use rayon::prelude::*;
use vibro_machine::Start;

/// Ways to lengthen horizons, the next where the residuals of the one before are more than noise.
const WAYS: [Way; 4] = [
    Way { near: 0.3, of_whole: true, growth: (1.25, 2.0) },
    Way { near: 0.3, of_whole: false, growth: (1.25, 2.0) },
    Way { near: 0.15, of_whole: false, growth: (1.1, 1.4) },
    Way { near: 0.05, of_whole: false, growth: (1.05, 1.2) },
];
/// Times that columns without a standard deviation are weighed by their residuals.
const REWEIGHTED: u32 = 2;
/// Times for losses under which large residuals count less: outliers leave the deviation in steps.
const REWEIGHTED_ROBUST: u32 = 6;
/// A motion that is close to the record throughout.
const CLOSE: Way = Way { near: 0.05, of_whole: true, growth: (1.25, 2.0) };
/// Times that a better point beside a fitted one is taken.
const BETTER: u32 = 20;
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

/// Fits numbers of a machine to a record. `observer` sees the progress at each step and ends the
/// fit by returning false. The result then has the best values so far, and is undecided.
///
/// # Errors
/// [`Error::Described`] for a record, a name or a range that is not allowed, and where no motion of
/// the machine covers the record; [`Error::Refusal`] for values that are not allowed.
pub fn fit(request: &FitRequest, observer: Observer) -> Result<Fitted> {
    check(request)?;
    let carrying = filter::carrying(request)?;
    let fitted = fit_carrying(carrying.as_ref().unwrap_or(request), observer)?;
    Ok(filter::without(fitted, request.filters.len()))
}

/// The fit of a machine that carries the filters of its sensors.
fn fit_carrying(request: &FitRequest, observer: Observer) -> Result<Fitted> {
    let mut model = Model::new(request)?;
    let (watch, compared) = (model.watch.clone(), model.compared.clone());
    let go_on: &(dyn Fn() -> bool + Sync) = &|| watch.go_on(observer, compared.simulations());
    let bounds = Bounds::of(request, &model)?;
    let count = bounds.begin.len();
    if request.starts > 0 && count > sobol::DIMENSIONS {
        let problem = format!("--starts with {count} free numbers: allowed are up to {}", sobol::DIMENSIONS);
        return Err(Error::Described { problem });
    }
    let further = (1..=request.starts).map(|k| bounds.within(k));
    let starts: Vec<Vec<f64>> =
        std::iter::once(Ok(bounds.begin.clone())).chain(further).collect::<Result<_>>()?;
    watch.announce(starts.len() * MOST_ATTEMPTS + BETTER as usize + 1);
    let by = |start: &Vec<f64>| best_from(&model, &bounds, start, request.segments, go_on);
    let found: Vec<Result<Solved>> = starts.par_iter().map(by).collect();
    let mut failed = None;
    let mut note = |error| _ = failed.get_or_insert(error);
    let sound = found.into_iter().filter_map(|found| found.map_err(&mut note).ok());
    let best = sound.reduce(|best, own| if own.cost < best.cost { own } else { best });
    let best = if watch.is_ended() { best_so_far(&model, &bounds, best) } else { best };
    let Some(mut best) = best else {
        let none = || Error::Described { problem: "no fit: no start was tried".into() };
        return Err(failed.unwrap_or_else(none));
    };
    let turns = match (model.has_sigma, request.loss) {
        (true, _) => 0,
        // One column weighs the same whatever its unit is.
        (false, Loss::Linear) if request.measured.columns.len() + request.measured.contacts.len() == 1 => 0,
        (false, Loss::Linear) => REWEIGHTED,
        (false, Loss::SoftL1 | Loss::Huber) => REWEIGHTED_ROBUST,
    };
    for _ in 0..turns {
        watch.begin("weights of the columns");
        model.reweigh(&best.point, &best.reach)?;
        let found = solve(&model, &bounds, &best.point, (&best.reach, Convergence::Whole), go_on)?;
        best = Solved { is_continuous: best.is_continuous, ..found };
    }
    let (mut doubt, mut factors) = (None, vec![1.0; count]);
    for turn in 0..=BETTER {
        // Of segments that stay apart no start leads to one motion.
        if !best.is_continuous {
            break;
        }
        watch.begin(format!("starts beside the best point, {} of at most {}", turn + 1, BETTER + 1));
        if !go_on() {
            break;
        }
        let found = match profile(&model, &bounds, &best, go_on)? {
            Profile::Better(own) => Found::Better(own),
            Profile::Factors(own) => {
                factors = own;
                restarted(&model, &bounds, &best, &factors, go_on)?
            }
        };
        match found {
            Found::Same => break,
            Found::Other(values) => {
                doubt = Some(format!("another minimum is as good, {}", bounds.told(&values)));
                break;
            }
            Found::Better(_) if turn == BETTER => {
                doubt = Some(format!("starts beside it led to better numbers {BETTER} times"));
            }
            Found::Better(next) => {
                let is_continuous = best.is_continuous;
                let found = solve(&model, &bounds, &next.point, (&next.reach, Convergence::Whole), go_on)?;
                best = Solved { is_continuous, ..found };
            }
        }
        watch.over(1);
    }
    if !best.is_continuous {
        doubt = Some("segments do not make one motion".into());
    }
    let mut fitted = model.finish(request, &best.point, &best.reach, best.cost, doubt)?;
    fitted.uncertainty.widen(&factors);
    fitted.at_bounds = bounds.reached(&best.point.values);
    Ok(if watch.is_ended() { Fitted { verdict: Verdict::ended(), ..fitted } } else { fitted })
}

/// The best point of a fit that was ended early, which is the given start where no other is better.
fn best_so_far(model: &Model, bounds: &Bounds, best: Option<Solved>) -> Option<Solved> {
    let reach = Reach::whole(model.end());
    let given =
        Solved { point: bounds.begin.clone().into(), reach, cost: f64::INFINITY, is_continuous: true };
    let given = model.cost(&given).ok().map(|cost| Solved { cost, ..given });
    given.into_iter().chain(best).min_by(|a, b| a.cost.total_cmp(&b.cost))
}
