//! Search for a fit: schedule of each record, joint descent over all records, weights of the
//! columns, and restarts near the best point.

use super::bounds::Bounds;
use super::checks::check;
use super::divided::Divided;
use super::errors::Uncertainty;
use super::evaluated::Solved;
use super::joint::Joint;
use super::loss::Loss;
use super::problem::Problem;
use super::profile::{Profile, profile};
use super::progress::Observer;
use super::restarts::{Found, Other, restarted};
use super::schedule::{MOST_ATTEMPTS, best_from};
use super::solver::{Convergence, solve};
use super::verdict::Verdict;
use super::{FitRequest, Fitted, Segments, filter};
use crate::error::{Error, Result};
use crate::sobol;
use rayon::prelude::*;

/// Number of reweightings of columns without a given standard deviation.
const REWEIGHTED: u32 = 2;
/// The same number for a robust loss: the deviation decreases as outliers lose weight.
const REWEIGHTED_ROBUST: u32 = 6;
/// Largest number of moves to a better point found by a restart.
const BETTER: u32 = 20;

/// Cap on the widening of errors by other minima of equal quality, as a ratio. Impacts that appear
/// or disappear divide one valley into several; a minimum farther away is a different answer.
const WIDER: f64 = 5.0;

/// Largest number of moves to a better point found by segments.
const DIVIDED: u32 = 3;

/// Callback that ends a search early by returning false.
type GoOn<'a> = &'a (dyn Fn() -> bool + Sync);

/// Fits parameters of a machine to a record. `observer` receives the progress at each step and
/// ends the fit by returning false. The result then has the best values so far, and is undecided.
///
/// # Errors
/// [`Error::Described`] for an invalid record, name or range, and if no motion of the machine
/// covers the record; [`Error::Refusal`] for values outside their range.
///
/// # Examples
/// The record of an oscillator with ω² = 4, and a machine with ω² = 3.5 and an unknown start:
///
/// ```
/// use vibro_studies::fit::{FitRequest, Free, Loss, Measured, Segments, fit};
/// use vibro_studies::{Machine, Start};
///
/// # let text = r#"
/// #     name = "Oscillator"
/// #     body.a = { mass = 1.0, start = { s = 0.8 } }
/// #     spring.k = { between = ["ground", "a"], stiffness = 3.5 }
/// # "#;
/// let machine = Machine::parse(text, "oscillator.toml", &vibro_machine::file::no_records)?;
/// let times: Vec<f64> = (0..40).map(|k| 0.1 * f64::from(k)).collect();
/// let column = times.iter().map(|t| (2.0 * t).cos()).collect();
/// let columns = vec![("a.s".parse()?, column)];
/// let measured = Measured { times, columns, contacts: Vec::new() };
/// let names = ["spring.k.stiffness", "body.a.start.s"];
/// let free = names.map(|name| Free { name: name.into(), within: None, is_own: false }).to_vec();
/// let request = FitRequest {
///     name: String::new(),
///     machine,
///     measured,
///     free,
///     start: Start::default(),
///     sigma: None,
///     filters: Vec::new(),
///     loss: Loss::Linear,
///     segments: Segments::Auto,
///     starts: 0,
/// };
/// let found = fit(&request, &|_| true)?;
/// let [stiffness, start] = [0, 1].map(|k| found.values[k].1);
/// assert!((stiffness - 4.0).abs() < 1e-12 && (start - 1.0).abs() < 1e-12);
/// # Ok::<(), vibro_studies::Error>(())
/// ```
pub fn fit(request: &FitRequest, observer: Observer) -> Result<Fitted> {
    let mut all = fit_records(std::slice::from_ref(request), observer)?;
    all.pop().ok_or_else(|| Error::Described { problem: "no record; expected one".into() })
}

/// Fits parameters of a machine to several records together. Each request has a record, the
/// machine and the start of its motion. All requests have the same free parameters. All records
/// share them, except the ones that each record has for itself ([`Free::is_own`](super::Free)).
///
/// Returns a result for each record: its machine, start, residuals and free parameters. Values,
/// errors, correlations, `cost` and `simulations` are from all records together.
///
/// # Errors
/// The same errors as [`fit`]; [`Error::Described`] for requests that differ in free parameters,
/// loss, segments or starts, and for a shared parameter with different initial values.
pub fn fit_records(requests: &[FitRequest], observer: Observer) -> Result<Vec<Fitted>> {
    requests.iter().try_for_each(check)?;
    let carrying = |request| Ok(filter::carrying(request)?.unwrap_or_else(|| request.clone()));
    let carrying = requests.iter().map(carrying).collect::<Result<Vec<_>>>()?;
    let all = fit_carrying(&carrying, observer)?;
    Ok(all.into_iter().zip(requests).map(|(own, of)| filter::without(own, of.filters.len())).collect())
}

/// Fits machines that contain the filters of their sensors.
fn fit_carrying(requests: &[FitRequest], observer: Observer) -> Result<Vec<Fitted>> {
    let mut joint = Joint::new(requests)?;
    let (watch, compared) = (joint.models[0].watch.clone(), joint.compared());
    let simulations = || compared.iter().map(|own| own.simulations()).sum();
    let go_on: GoOn = &|| watch.go_on(observer, simulations());
    let bounds = joint.bounds(requests)?;
    let request = &requests[0];
    let count = bounds.begin.len();
    if request.starts > 0 && count > sobol::DIMENSIONS {
        let problem =
            format!("--starts with {count} free parameters; expected at most {}", sobol::DIMENSIONS);
        return Err(Error::Described { problem });
    }
    let further = (1..=request.starts).map(|k| bounds.within(k));
    let starts: Vec<Vec<f64>> =
        std::iter::once(Ok(bounds.begin.clone())).chain(further).collect::<Result<_>>()?;
    watch.announce(starts.len() * requests.len() * MOST_ATTEMPTS + BETTER as usize + 1);
    let search = Search { joint: &joint, bounds: &bounds, segments: request.segments, go_on };
    let found: Vec<Result<Solved>> = starts.par_iter().map(|start| search.from(start)).collect();
    let mut best = Best::default();
    found.into_iter().for_each(|found| _ = best.take(found));
    if watch.is_ended() {
        // The given start may be better than the result of a fit that was ended early.
        let given = joint.single(bounds.begin.clone());
        best.take(joint.cost(&given).map(|cost| Solved { cost, ..given }));
    }
    let mut best = best.found()?;
    for _ in 0..reweighted(&joint, requests) {
        watch.begin("weights of the columns");
        joint.reweigh(&best.point, &best.reach)?;
        let found = solve(&joint, &bounds, &best.point, (&best.reach, Convergence::Whole), go_on)?;
        best = Solved { is_continuous: best.is_continuous, ..found };
    }
    let found = settled(&joint, &bounds, best, go_on)?;
    let is_divided = matches!(request.segments, Segments::Length(_));
    let found = if is_divided { found } else { joined(&joint, &bounds, found, go_on)? };
    let Settled { best, factors, doubt } = found;
    let at = joint.evaluate(&best.point, &best.reach)?;
    let own = (request.loss, joint.has_sigma());
    let mut uncertainty = Uncertainty::of(&at, &bounds.names, &best.point.values, own);
    uncertainty.widen(&factors);
    let doubt = joint.lacks_noise().or(doubt);
    let mut all = joint.finish(requests, &bounds, (&best, &uncertainty, doubt))?;
    if watch.is_ended() {
        all.iter_mut().for_each(|own| own.verdict = Verdict::ended());
    }
    Ok(all)
}

/// Number of reweightings of the columns.
fn reweighted(joint: &Joint, requests: &[FitRequest]) -> u32 {
    let lists = requests.iter().map(|own| own.measured.columns.len() + own.measured.contacts.len());
    match (joint.has_sigma(), joint.loss()) {
        (true, _) => 0,
        // The weight of a single column does not matter.
        (false, Loss::Linear) if lists.sum::<usize>() == 1 => 0,
        (false, Loss::Linear) => REWEIGHTED,
        (false, Loss::SoftL1 | Loss::Huber) => REWEIGHTED_ROBUST,
    }
}

/// Search from one start.
struct Search<'s, 'a> {
    joint: &'s Joint<'a>,
    bounds: &'s Bounds,
    segments: Segments,
    go_on: GoOn<'s>,
}

impl Search<'_, '_> {
    /// Best point from a start. A single record follows its schedule. Several records try a joint
    /// descent first, then the best points of single records.
    fn from(&self, start: &[f64]) -> Result<Solved> {
        let joint = self.joint;
        if joint.models.len() == 1 {
            return self.of_record(0, start);
        }
        let mut best = Best::default();
        if self.is_last(best.take(self.descent(joint.single(start.to_vec()))))? {
            return best.found();
        }
        let all = (0..joint.models.len()).into_par_iter().map(|k| self.of_record(k, start));
        let all = all.collect::<Result<Vec<_>>>()?;
        // Records that fit come first: their shared parameters are better.
        let mut order: Vec<usize> = (0..all.len()).collect();
        let misses = |k: &usize| !joint.models[*k].fits(&all[*k].point, &all[*k].reach).unwrap_or(false);
        order.sort_by_cached_key(misses);
        for k in order {
            let values = joint.values_as(k, &all);
            if self.is_last(best.take(self.descent(joint.single(values.clone()))))? {
                break;
            }
            let other = |j: usize| if j == k { Ok(all[k].clone()) } else { self.of_record(j, &values) };
            let all = (0..all.len()).into_par_iter().map(other).collect::<Result<Vec<_>>>()?;
            let merged = joint.merged(&all).map(|values| self.bounds.cut(values));
            let together = joint.together(&all, merged.unwrap_or(values));
            if self.is_last(best.take(self.descent(together)))? {
                break;
            }
        }
        best.found()
    }

    /// Best point of one record by its schedule, from joint values.
    fn of_record(&self, k: usize, start: &[f64]) -> Result<Solved> {
        let places = &self.joint.places[k];
        let begin = self.joint.values_of(k, start);
        let bounds = self.bounds.local(places, &begin);
        best_from(&self.joint.models[k], &bounds, &begin, self.segments, self.go_on)
    }

    /// A descent over all records.
    fn descent(&self, begin: Solved) -> Result<Solved> {
        let (joint, bounds, reach) = (self.joint, self.bounds, &begin.reach);
        let rough = solve(joint, bounds, &begin.point, (reach, Convergence::Rough), self.go_on)?;
        let found = solve(joint, bounds, &rough.point, (reach, Convergence::Whole), self.go_on)?;
        Ok(Solved { is_continuous: begin.is_continuous, ..found })
    }

    /// Whether a point ends the search.
    fn is_last(&self, found: Option<&Solved>) -> Result<bool> {
        let fits = found.map(|own| self.joint.fits(&own.point, &own.reach)).transpose()?;
        Ok(fits == Some(true) || !(self.go_on)())
    }
}

/// Best of several points.
#[derive(Default)]
struct Best {
    found: Option<Solved>,
    failed: Option<Error>,
}

impl Best {
    /// Takes a point; returns it if it is the best so far.
    fn take(&mut self, found: Result<Solved>) -> Option<&Solved> {
        match found {
            Err(error) => _ = self.failed.get_or_insert(error),
            Ok(own) if self.found.as_ref().is_none_or(|best| own.cost < best.cost) => {
                return Some(self.found.insert(own));
            }
            Ok(_) => {}
        }
        None
    }

    fn found(self) -> Result<Solved> {
        let none = || Error::Described { problem: "no fit: no start was tried".into() };
        self.found.ok_or_else(|| self.failed.unwrap_or_else(none))
    }
}

/// A point that no restart improves.
struct Settled {
    best: Solved,
    /// Ratios of the errors to the ones from the curvature.
    factors: Vec<f64>,
    /// Reason why the point is not certain.
    doubt: Option<String>,
}

/// Continues with a single motion of each record if segments are left and do not fit: a segment
/// may begin next to an impact that the previous segment lacks, from where no restart leads to it.
fn joined(joint: &Joint, bounds: &Bounds, found: Settled, go_on: GoOn) -> Result<Settled> {
    let best = &found.best;
    if best.reach.is_whole() || joint.fits(&best.point, &best.reach)? || joint.is_chaotic(&best.point.values)
    {
        return Ok(found);
    }
    let begin = joint.single(best.point.values.clone());
    let Ok(single) = solve(joint, bounds, &begin.point, (&begin.reach, Convergence::Whole), go_on) else {
        return Ok(found);
    };
    let single = settled(joint, bounds, Solved { is_continuous: true, ..single }, go_on)?;
    Ok(if single.best.cost < found.best.cost { single } else { found })
}

/// Moves to better points found by restarts or by segments of the motion until there is none.
fn settled(joint: &Joint, bounds: &Bounds, best: Solved, go_on: GoOn) -> Result<Settled> {
    let mut found = restarted_often(joint, bounds, best, go_on)?;
    for _ in 0..DIVIDED {
        // A segment that cannot be simulated, for example one that begins behind a stop, ends the
        // test and not the fit.
        let Ok(Some(divided)) = Divided::of(joint, bounds, &found.best, go_on) else { break };
        if !divided.is_suspect() {
            break;
        }
        let begin = divided.joined(joint, bounds, go_on).ok().flatten();
        match begin.and_then(|begin| restarted_often(joint, bounds, begin, go_on).ok()) {
            Some(next) if next.best.cost < found.best.cost => found = next,
            _ => {
                found.doubt = found.doubt.or_else(|| divided.doubt(bounds));
                break;
            }
        }
    }
    Ok(found)
}

/// Moves to better points found by restarts until there is none.
fn restarted_often(joint: &Joint, bounds: &Bounds, mut best: Solved, go_on: GoOn) -> Result<Settled> {
    let watch = &joint.models[0].watch;
    let (mut doubt, mut factors) = (None, vec![1.0; bounds.begin.len()]);
    for turn in 0..=BETTER {
        // Restarts from segments that stay apart do not lead to a single motion.
        if !best.is_continuous {
            doubt = Some("the segments do not join into a single motion".into());
            break;
        }
        watch.begin(format!("restarts near the best fit, {} of at most {}", turn + 1, BETTER + 1));
        if !go_on() {
            break;
        }
        let near = bounds.near(&best.point.values);
        let found = match profile(joint, &near, &best, go_on)? {
            Profile::Better(own) => Found::Better(own),
            Profile::Factors(own) => {
                factors = own;
                restarted(joint, &near, &best, &factors, go_on)?
            }
        };
        match found {
            Found::NoBetter(others) => {
                let own = factors.clone();
                let is_far = |other: &&Other| other.factors.iter().zip(&own).any(|(a, b)| *a > WIDER * b);
                let far = others.iter().find(is_far);
                doubt =
                    far.map(|other| format!("another minimum is as good, {}", bounds.told(&other.values)));
                for other in others.iter().filter(|other| !is_far(other)) {
                    factors.iter_mut().zip(&other.factors).for_each(|(a, b)| *a = a.max(*b));
                }
                break;
            }
            Found::Better(_) if turn == BETTER => {
                doubt = Some(format!("restarts near the best fit improved it {BETTER} times in a row"));
            }
            Found::Better(next) => {
                let is_continuous = best.is_continuous;
                let found = solve(joint, bounds, &next.point, (&next.reach, Convergence::Whole), go_on)?;
                best = Solved { is_continuous, ..found };
            }
        }
        watch.over(1);
    }
    Ok(Settled { best, factors, doubt })
}
