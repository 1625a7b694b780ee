//! Order of the search strategies, the cheapest first. A result is kept only if it lowers the cost
//! over the whole record. The search ends at the first result whose residuals are noise.

use super::blocks::over_blocks;
use super::bounds::Bounds;
use super::evaluated::{Point, Reach, Solved};
use super::horizons::over_horizons;
use super::model::Model;
use super::segments::over_segments;
use super::solver::{Convergence, solve};
use super::ties::tied;
use super::{CLOSE, Segments, WAYS, Way};
use crate::error::Result;
use crate::sobol;
use rayon::prelude::*;

/// Number of starts near the given one, and their largest relative distance. These starts are
/// tried last, except that with blocks the first of them precedes [`Attempt::Divided`].
const BESIDE: (u32, f64) = (8, 0.3);
/// Largest number of attempts from a start: plain descent, each of [`WAYS`], blocks, segments of
/// the motion, and [`BESIDE`] other starts.
pub(super) const MOST_ATTEMPTS: usize = 2 + WAYS.len() + 1 + BESIDE.0 as usize;
/// Limit of the initial motion's contacts; above it, blocks come before horizons. Horizons over
/// 500 contacts ended in wrong minima; over 100 contacts they were cheaper.
const MANY: usize = 200;
/// Number of candidates for [`BESIDE`] if the record has only contacts.
const LOOKED_AT: u32 = 128;
/// The search ends when this number of starts agrees on the least cost within this relative
/// tolerance.
const AGREED: u32 = 3;
const SAME: f64 = 1e-6;

/// Callback that ends a search early by returning false.
type GoOn<'a> = &'a (dyn Fn() -> bool + Sync);

/// A search strategy.
enum Attempt {
    /// Descent over the whole record at once; suits regular motions.
    Plain,
    /// Growing horizons.
    Horizons(Vec<f64>, Way),
    /// Block filter, then segments that are tied into one motion.
    Blocks(Vec<f64>),
    /// Segments of the fitted motion.
    Divided,
}

/// Search for a fit from one start.
struct Search<'a> {
    model: &'a Model<'a>,
    bounds: &'a Bounds,
    start: &'a [f64],
    segments: Segments,
    go_on: GoOn<'a>,
}

impl Search<'_> {
    /// Attempts in order.
    fn attempts(&self) -> impl Iterator<Item = Attempt> {
        let Self { model, start, .. } = *self;
        // Without stops, a motion near the record from the start on has a single valley.
        let is_regular = self.is_regular();
        // Contact times alone do not determine the initial states of segments.
        let is_divided =
            self.segments != Segments::None && (!model.is_of_contacts() || self.length().is_some());
        let is_in_blocks = is_divided && !model.is_of_contacts() && !is_regular;
        let ways = WAYS.iter().take(if is_regular { 1 } else { WAYS.len() });
        // Contacts alone are matched in order, which only growing horizons preserve.
        let plain = (!model.is_of_contacts()).then_some(Attempt::Plain);
        let horizons = ways.map(|way| Attempt::Horizons(start.to_vec(), *way));
        // Horizons over many impacts end in wrong minima: each impact adds some.
        let has_many = is_in_blocks && self.has_many_contacts();
        let blocks = || Attempt::Blocks(start.to_vec());
        let (first, later) = (has_many.then(blocks), (is_in_blocks && !has_many).then(blocks));
        let divided = is_divided.then_some(Attempt::Divided);
        let beside = move |begin| match is_in_blocks {
            true => Attempt::Blocks(begin),
            false => Attempt::Horizons(begin, WAYS[1]),
        };
        let is_small = start.len() <= sobol::DIMENSIONS;
        let besides =
            move || std::iter::once(()).filter(move |()| is_small).flat_map(|()| self.beside()).map(beside);
        // Segments of a motion with wrong parameters take longer than blocks from another start.
        let early = usize::from(is_in_blocks);
        let (some, others) = (besides().take(early), besides().skip(early));
        plain.into_iter().chain(first).chain(horizons).chain(later).chain(some).chain(divided).chain(others)
    }

    /// Whether the motion has a single valley: no stops, and near the record from the start.
    fn is_regular(&self) -> bool {
        !self.model.has_stops() && self.model.is_near(self.start, WAYS[0])
    }

    /// Whether the motion has many contacts over the record.
    fn has_many_contacts(&self) -> bool {
        let (point, reach) = (Point::from(self.start.to_vec()), Reach::whole(self.model.end()));
        self.model.beside(&point, &reach).is_ok_and(|beside| beside.contacts_of_motion() > MANY)
    }

    /// Given length of segments, s.
    fn length(&self) -> Option<f64> {
        if let Segments::Length(length) = self.segments { Some(length) } else { None }
    }

    /// Starts around the given one. If the record has only contacts, the starts whose motions stay
    /// near the record longest: an extra or missing contact shifts all later matches.
    fn beside(&self) -> Vec<Vec<f64>> {
        let (model, (count, part)) = (self.model, BESIDE);
        // The first point of the sequence is the given start.
        let of = |count: u32| (2..=count + 1).map(|k| self.bounds.beside(self.start, k, part));
        if !model.is_of_contacts() {
            return of(count).collect();
        }
        let near = |values: Vec<f64>| (model.near_until(&Point::from(values.clone()), &[], WAYS[1]), values);
        let mut all: Vec<_> = of(LOOKED_AT).collect::<Vec<_>>().into_par_iter().map(near).collect();
        all.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        all.into_iter().take(count as usize).map(|(_, values)| values).collect()
    }

    /// Descent over the whole record.
    fn plain(&self, values: Vec<f64>) -> Result<Solved> {
        let reach = Reach::whole(self.model.end());
        let (model, bounds) = (self.model, self.bounds);
        let found = solve(model, bounds, &values.into(), (&reach, Convergence::Rough), self.go_on)?;
        if !model.fits(&found.point, &reach)? {
            return Ok(found);
        }
        solve(model, bounds, &found.point, (&reach, Convergence::Whole), self.go_on)
    }

    /// Best point after segments have been tied into one motion.
    fn continued(&self, found: Solved) -> Result<Solved> {
        let Self { model, go_on, .. } = *self;
        let values = found.point.values.clone();
        let mut best: Option<Solved> = None;
        // A single motion determines the parameters more accurately, unless it is chaotic.
        let ways: [&dyn Fn() -> Result<Solved>; 3] =
            [&|| self.plain(values.clone()), &|| Ok(found.clone()), &|| self.divided(&values)];
        for way in ways {
            let Ok(mut found) = way() else { continue };
            found.cost = model.cost(&found)?;
            let is_done = found.is_continuous && model.fits(&found.point, &found.reach)? || !go_on();
            if best.as_ref().is_none_or(|best| found.is_continuous && found.cost < best.cost) {
                best = Some(found);
            }
            if is_done {
                break;
            }
        }
        best.map_or_else(|| self.plain(values.clone()), Ok)
    }

    fn divided(&self, values: &[f64]) -> Result<Solved> {
        over_segments(&self.model.for_segments(), self.bounds, values, self.length(), self.go_on)
    }

    fn follow(&self, attempt: Attempt) -> Result<Solved> {
        let Self { model, bounds, go_on, .. } = *self;
        match attempt {
            Attempt::Plain => self.plain(self.start.to_vec()),
            Attempt::Blocks(start) => {
                let model = model.for_segments();
                let found = over_blocks(&model, bounds, &start, go_on)?;
                let is_chaotic = model.is_chaotic(&found.1.values);
                if !is_chaotic {
                    // A single motion takes far less time than its segments.
                    let single = self.plain(found.1.values.clone());
                    if let Ok(single) = single
                        && self.model.fits(&single.point, &single.reach)?
                    {
                        return Ok(single);
                    }
                }
                let found = tied(&model, bounds, (found, is_chaotic), go_on)?;
                if is_chaotic { Ok(found) } else { self.continued(found) }
            }
            Attempt::Horizons(start, way) => over_horizons(model, bounds, &start, way, go_on),
            Attempt::Divided => self.divided(self.start),
        }
    }
}

/// Result of the first attempt from a start that reaches the noise, otherwise the best.
pub(super) fn best_from(
    model: &Model,
    bounds: &Bounds,
    start: &[f64],
    segments: Segments,
    go_on: GoOn,
) -> Result<Solved> {
    let search = Search { model, bounds, start, segments, go_on };
    let is_regular = search.is_regular();
    let (mut best, mut same): (Option<Solved>, u32) = (None, 0);
    let mut tried = 0;
    for (k, attempt) in search.attempts().enumerate() {
        model.watch.begin(format!("attempt {} of at most {MOST_ATTEMPTS}", k + 1));
        tried = k;
        // All strategies from one start may end in the same wrong minimum.
        let is_beside = k + BESIDE.0 as usize >= MOST_ATTEMPTS;
        let found = search.follow(attempt);
        model.watch.over(1);
        let Ok(mut found) = found else { continue };
        // A fit that was ended early may not have seen where its motion cannot continue.
        found.cost = model.cost(&found).or_else(|e| if go_on() { Err(e) } else { Ok(f64::INFINITY) })?;
        // No single motion is near a chaotic record to its end.
        let is_whole =
            found.is_continuous || !found.reach.nodes.is_empty() && model.is_chaotic(&found.point.values);
        let is_done = is_whole && model.fits(&found.point, &found.reach)?
            || is_regular && model.is_near(&found.point.values, CLOSE)
            || !go_on();
        let before = best.as_ref().map_or(f64::INFINITY, |best| best.cost);
        if !is_whole && best.is_some() {
            continue;
        }
        if (found.cost / before - 1.0).abs() < SAME {
            same += u32::from(is_beside);
        } else if found.cost < before {
            same = 1;
        }
        if found.cost < before {
            best = Some(found);
        }
        if is_done || same >= AGREED {
            break;
        }
    }
    model.watch.over(MOST_ATTEMPTS - 1 - tried);
    // If all attempts fail, the error is the given start's.
    let best = best.map_or_else(|| over_horizons(model, bounds, start, WAYS[0], go_on), Ok)?;
    match search.length() {
        Some(_) if best.reach.nodes.is_empty() => search.divided(&best.point.values),
        _ => Ok(best),
    }
}
