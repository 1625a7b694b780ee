//! Restarts near a fitted point. Appearing and disappearing impacts create local minima; friction
//! creates plateaus where a parameter has no effect.

use super::bounds::Bounds;
use super::directions::Directions;
use super::errors::Uncertainty;
use super::evaluated::{Evaluated, Point, Solved};
use super::problem::Problem;
use super::solver::{Convergence, solve};
use crate::error::Result;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Distances of a restart from the fitted point, in standard errors: without and with contacts.
/// The cost jumps where an impact appears, and the valley behind the jump often begins ten errors
/// away. The next distance is tried if the previous one finds no better point.
const AWAY: [&[f64]; 2] = [&[6.0], &[12.0]];
/// Distances along pairs of combinations if the residuals exceed noise, in standard errors.
const MORE: [f64; 2] = [12.0, 20.0];
/// Largest relative change of a parameter in a restart.
const MOST: f64 = 0.3;
/// Number of parameter combinations tried: without and with contacts.
const DIRECTIONS: [usize; 2] = [1, 6];
/// Change of a start parameter without effect, as a fraction of the motion's size.
const NUDGE: f64 = 0.1;
/// Singular value, relative to the largest, below which a combination is not tried.
const SINGULAR: f64 = 1e-6;
/// Decrease in cost, in units of the residual variance, that counts as an improvement: for a
/// single motion, and for segments, where the misses between segments count as well.
const BETTER: [f64; 2] = [0.01, 1.0];
/// A minimum is as good if its cost is at most `AS_GOOD` variances higher. It is another one if
/// the fitted point's own quadratic cost rises there by more than `ELSEWHERE` variances.
const AS_GOOD: f64 = 4.0;
const ELSEWHERE: f64 = 9.0;
/// Two minima within this many standard errors in each parameter count as one. The rise in cost
/// alone would separate minima that differ by rounding, which a chaotic motion amplifies. For a
/// parameter without a standard error: this fraction of its value.
const ONE: f64 = 3.0;
const ONE_PART: f64 = 1e-3;

/// Number of local minima near a point, the lowest ones, that start a second search of valleys:
/// the valley of least cost may be narrow and next to a wider one.
const AGAIN: usize = 2;

/// Cost of such a minimum, and of a valley on a line, relative to the best point's, at most.
const NEAR: f64 = 1.25;
const HOPEFUL: f64 = 4.0;

/// Result of restarts near a point.
pub(super) enum Found {
    /// A better point.
    Better(Solved),
    /// No better point, but these other minima that are as good.
    NoBetter(Vec<Other>),
}

/// Another minimum that is as good.
pub(super) struct Other {
    pub(super) values: Vec<f64>,
    /// Ratios of the errors that reach this minimum to the ones from the curvature, at least 1. As
    /// in a profile of the cost, a rise by r variances is √r errors away.
    pub(super) factors: Vec<f64>,
}

/// Starting points that move each parameter without effect at `point`, in both directions.
fn nudged(model: &dyn Problem, bounds: &Bounds, point: &Point, at: &Evaluated) -> Vec<Point> {
    let mut all = Vec::new();
    for j in (0..point.values.len()).filter(|&j| at.is_idle(j, point.values[j])) {
        let Some(size) = model.size_of_start(j, &point.values) else { continue };
        for sign in [1.0, -1.0] {
            let mut next = point.clone();
            next.values[j] = (next.values[j] + sign * NUDGE * size).clamp(bounds.low[j], bounds.high[j]);
            all.push(next);
        }
    }
    all
}

/// Best point found after moving the parameters that have no effect at the initial point.
pub(super) fn from_rest(
    model: &dyn Problem,
    bounds: &Bounds,
    best: Solved,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Solved> {
    let starts = nudged(model, bounds, &best.point, &model.evaluate(&best.point, &best.reach)?);
    let reach = &best.reach;
    let all = starts
        .iter()
        .filter_map(|start| solve(model, bounds, start, (reach, Convergence::Rough), go_on).ok());
    let all: Vec<Solved> = all.collect();
    Ok(all.into_iter().fold(best, |best, own| if own.cost < best.cost { own } else { best }))
}

/// Number of points of a scanned line to each side, and their distance in standard errors.
const SCAN: (i32, f64) = (12, 1.0);
/// Growth factor of the distances beyond these points, for a line of a single parameter, and the
/// largest relative change of the parameter. Valleys can be narrow and close together: in one
/// record the valley of the true restitution was 500 standard errors away, 0.8 % of its value.
const WIDE: (f64, f64) = (1.25, 0.1);
/// Cap on the valleys that a scan descends into.
const VALLEYS: usize = 12;
/// Largest number of points to each side of a line of a single parameter in the last scan, with
/// the distance of [`SCAN`]. A scan with growing distances misses narrow valleys: in one record the
/// valley of the true restitution was 1 standard error wide and 300 errors away, and as good. The
/// last scan takes at most as many simulations as the fit before it.
const FINE: u32 = 500;

/// Distances of the points of a scanned line, in standard errors.
fn distances(best: &Point, line: &Point, count: i32) -> impl Iterator<Item = f64> {
    let step = SCAN.1;
    let mut moved = line.values.iter().zip(&best.values).filter(|(change, _)| **change != 0.0);
    let most = match (moved.next(), moved.next()) {
        (Some((change, value)), None) => (WIDE.1 * value / change).abs(),
        _ => 0.0,
    };
    let last = f64::from(count) * step;
    let wide = std::iter::successors(Some(WIDE.0 * last), |away| Some(WIDE.0 * away));
    (1..=count).map(move |k| step * f64::from(k)).chain(wide.take_while(move |away| *away <= most))
}

/// Where restarts begin.
#[derive(Clone, Copy)]
enum From {
    /// In the valleys of the cost on lines through the point, along combinations and along each
    /// parameter.
    Valleys,
    /// In the valleys on the lines along each parameter, scanned with this many points to each side
    /// before the distances grow.
    FineValleys(i32),
    /// At a distance in standard errors along combinations, or along pairs of them.
    Away(f64, bool),
}

/// Restarts near a point. `factors` are the ratios of the standard errors to the ones from the
/// curvature.
pub(super) fn restarted(
    model: &dyn Problem,
    bounds: &Bounds,
    best: &Solved,
    factors: &[f64],
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Found> {
    let has_valleys = model.has_stops() && best.reach.is_whole();
    let valleys = has_valleys.then_some(From::Valleys);
    let aways = AWAY[usize::from(has_valleys)].iter().map(|away| From::Away(*away, false));
    // Residuals above noise indicate that a better point exists.
    let is_better = has_valleys && model.misses(&best.point, &best.reach)?;
    let more = MORE.iter().filter(|_| is_better).map(|away| From::Away(*away, true));
    let restarts = Restarts::at(model, bounds, best, factors, go_on)?;
    let mut others = Vec::new();
    for from in valleys.into_iter().chain(aways).chain(more) {
        let minima = restarts.from(from);
        if let Some(better) = restarts.better(&minima) {
            return Ok(Found::Better(better));
        }
        if matches!(from, From::Valleys) {
            for own in restarts.lowest(&minima) {
                let again = Restarts::at(model, bounds, own, factors, go_on)?.from(from);
                if let Some(better) = restarts.better(&again) {
                    return Ok(Found::Better(better));
                }
                others.extend(restarts.others(&again));
            }
        }
        others.extend(restarts.others(&minima));
    }
    let count = (model.simulations() / (2 * factors.len() as u32)).min(FINE) as i32;
    // Fewer points were scanned above.
    if has_valleys && count > SCAN.0 {
        let minima = restarts.from(From::FineValleys(count));
        if let Some(better) = restarts.better(&minima) {
            return Ok(Found::Better(better));
        }
        others.extend(restarts.others(&minima));
    }
    Ok(Found::NoBetter(others))
}

/// A point near which a fit restarts.
struct Restarts<'a> {
    model: &'a dyn Problem,
    bounds: &'a Bounds,
    best: &'a Solved,
    /// Residuals and derivatives there.
    at: Evaluated,
    /// Jacobian of all residuals there; `None` if it is singular.
    jacobian: Option<DMatrix<f64>>,
    /// Standard errors from the curvature.
    errors: Vec<Option<f64>>,
    /// Ratios of the standard errors to these.
    factors: &'a [f64],
    go_on: &'a (dyn Fn() -> bool + Sync),
}

impl<'a> Restarts<'a> {
    /// Restarts near a minimum.
    fn at(
        model: &'a dyn Problem,
        bounds: &'a Bounds,
        best: &'a Solved,
        factors: &'a [f64],
        go_on: &'a (dyn Fn() -> bool + Sync),
    ) -> Result<Self> {
        let at = model.evaluate(&best.point, &best.reach)?;
        let own = (model.loss(), model.has_sigma());
        let errors = Uncertainty::of(&at, &bounds.names, &best.point.values, own).errors;
        let jacobian = Directions::of(model, &best.point.values, &at).map(|own| own.jacobian);
        Ok(Self { model, bounds, best, at, jacobian, errors, factors, go_on })
    }

    /// Minima that descents from these starts find.
    fn from(&self, from: From) -> Vec<Solved> {
        let Self { model, bounds, best, at, .. } = self;
        let (away, is_paired) = match from {
            From::Valleys | From::FineValleys(_) => (1.0, false),
            From::Away(away, is_paired) => (away, is_paired),
        };
        let Some(along) = along(*model, best, at, (away, is_paired)) else { return Vec::new() };
        let starts = match from {
            From::Valleys => self.valleys(along, SCAN.0),
            From::FineValleys(count) => self.valleys(Vec::new(), count),
            From::Away(..) => {
                let both = |change| [1.0, -1.0].map(|sign| bounds.moved(&best.point, &mut (change * sign)));
                nudged(*model, bounds, &best.point, at)
                    .into_iter()
                    .chain(along.iter().flat_map(both))
                    .collect()
            }
        };
        self.descended(&starts)
    }

    /// The lowest valleys of the cost on lines through the point: along combinations, and along
    /// each parameter. The cost of a motion with impacts has narrow valleys side by side, which a
    /// restart at a fixed distance misses.
    fn valleys(&self, mut lines: Vec<Point>, count: i32) -> Vec<Point> {
        let Self { model, bounds, best, errors, go_on, .. } = self;
        for (j, error) in errors.iter().enumerate() {
            let mut line = Point::from(vec![0.0; errors.len()]);
            line.values[j] = error.unwrap_or(0.0);
            lines.push(line);
        }
        let on_side = |(line, sign): (&Point, f64)| {
            let point = |away: f64| bounds.moved(&best.point, &mut (line * (sign * away)));
            let points: Vec<Point> = distances(&best.point, line, count).map(point).collect();
            let cost = |point: &Point| {
                let at = Solved { point: point.clone(), ..(*best).clone() };
                if go_on() { model.cost(&at).unwrap_or(f64::INFINITY) } else { f64::INFINITY }
            };
            let costs: Vec<f64> = points.par_iter().map(cost).collect();
            let before = |k: usize| k.checked_sub(1).map_or(best.cost, |before| costs[before]);
            let is_hopeful = |k: usize| k < SCAN.0 as usize || costs[k] < HOPEFUL * best.cost;
            let is_valley = |k: &usize| {
                let is_low = costs[*k] < before(*k) && costs.get(k + 1).is_none_or(|next| costs[*k] <= *next);
                is_low && is_hopeful(*k)
            };
            (0..costs.len()).filter(is_valley).map(|k| (costs[k], points[k].clone())).collect::<Vec<_>>()
        };
        let sides: Vec<(&Point, f64)> = lines.iter().flat_map(|line| [(line, 1.0), (line, -1.0)]).collect();
        let mut all: Vec<(f64, Point)> = sides.into_par_iter().flat_map(on_side).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.into_iter().take(VALLEYS).map(|own| own.1).collect()
    }

    /// Variance of the residuals at the best point.
    fn variance(&self) -> f64 {
        self.model.variance(self.best.cost, self.best.point.values.len())
    }

    /// Descends from several points.
    fn descended(&self, starts: &[Point]) -> Vec<Solved> {
        let Self { model, bounds, best, go_on, .. } = *self;
        // Without contacts there is one valley: its minimum need not be found again.
        let enough = if model.has_stops() { f64::NEG_INFINITY } else { best.cost + self.variance() };
        let convergence = Convergence::Back(enough);
        let by = |start: &Point| solve(model, bounds, start, (&best.reach, convergence), go_on).ok();
        starts.par_iter().filter_map(by).collect()
    }

    /// The lowest of some minima, if it is better than the best point.
    fn better(&self, minima: &[Solved]) -> Option<Solved> {
        let least = minima.iter().min_by(|a, b| a.cost.total_cmp(&b.cost));
        let better = BETTER[usize::from(!self.best.reach.is_whole())];
        least.filter(|own| own.cost < self.best.cost - better * self.variance()).cloned()
    }

    /// The lowest minima that are other ones than the best point and than each other.
    fn lowest<'m>(&self, minima: &'m [Solved]) -> Vec<&'m Solved> {
        let is_near = |own: &&Solved| own.cost < NEAR * self.best.cost && self.is_apart(own);
        let mut all: Vec<&Solved> = minima.iter().filter(is_near).collect();
        all.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        all.dedup_by(|a, b| (a.cost - b.cost).abs() < BETTER[0] * self.variance());
        all.truncate(AGAIN);
        all
    }

    /// The minima that are as good as the best point, and other ones.
    fn others(&self, minima: &[Solved]) -> Vec<Other> {
        let variance = self.variance();
        let is_as_good = |own: &&Solved| own.cost < self.best.cost + AS_GOOD * variance;
        let others = minima.iter().filter(is_as_good).filter(|own| self.is_apart(own));
        others.map(|own| self.other(own, variance)).collect()
    }

    /// Whether a minimum is another one than the best point.
    fn is_apart(&self, own: &Solved) -> bool {
        let (here, there) = (&self.best.point.values, &own.point.values);
        let off = DVector::from_iterator(here.len(), there.iter().zip(here).map(|(a, b)| a - b));
        let errors = self.errors.iter().zip(self.factors);
        let is_one = |((a, b), (error, factor)): ((&f64, &f64), (&Option<f64>, &f64))| {
            (a - b).abs() <= error.map_or(ONE_PART * a.abs(), |error| ONE * error * factor)
        };
        let rise = self.jacobian.as_ref().map_or(0.0, |jacobian| (jacobian * off).norm_squared());
        rise > ELSEWHERE * self.variance() && !here.iter().zip(there).zip(errors).all(is_one)
    }

    /// Another minimum, with the ratios of the errors that reach it.
    fn other(&self, own: &Solved, variance: f64) -> Other {
        let away = ((own.cost - self.best.cost) / variance).max(1.0).sqrt();
        let mut factors = self.factors.to_vec();
        for (j, factor) in factors.iter_mut().enumerate() {
            let off = (own.point.values[j] - self.best.point.values[j]).abs();
            let reached = self.errors[j].map_or(f64::INFINITY, |error| off / (error * away));
            *factor = factor.max(reached);
        }
        Other { values: own.point.values.clone(), factors }
    }
}

/// Parameter changes of `away` standard errors along the least
/// determined combinations, each with the resulting changes of segment states.
fn along(
    model: &dyn Problem,
    best: &Solved,
    at: &Evaluated,
    (away, is_paired): (f64, bool),
) -> Option<Vec<Point>> {
    let values = &best.point.values;
    let p = values.len();
    let Directions { triangle, scales, singular, right, .. } = Directions::of(model, values, at)?;
    let largest = singular.max();
    let mut known: Vec<usize> = (0..right.nrows()).filter(|&k| singular[k] > SINGULAR * largest).collect();
    known.sort_by(|&a, &b| singular[a].total_cmp(&singular[b]));
    let variance = model.variance(best.cost, p);
    let of = |ways: &[(usize, f64)]| {
        let mut change = DVector::zeros(p);
        for &(k, part) in ways {
            let direction = right.row(k).transpose();
            let length = (away * variance.sqrt() / singular[k]).min(MOST / direction.amax());
            change += DVector::from_fn(p, |j, _| part * length * scales[j] * direction[j]);
        }
        let states = triangle.states_of(&change, 0.0)?;
        Some(Point { values: change.iter().copied().collect(), states })
    };
    let most = DIRECTIONS[usize::from(model.has_stops())];
    known.truncate(most);
    let mut ways: Vec<Vec<(usize, f64)>> = Vec::new();
    for (i, &a) in known.iter().enumerate() {
        match is_paired {
            false => ways.push(vec![(a, 1.0)]),
            true => ways.extend(known[..i].iter().flat_map(|&b| {
                [0.5f64.sqrt(), -0.5f64.sqrt()].map(|part| vec![(a, 0.5f64.sqrt()), (b, part)])
            })),
        }
    }
    Some(ways.iter().filter_map(|own| of(own)).collect())
}
