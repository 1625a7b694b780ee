//! A tree of branches from settled motions: each is followed in both directions, and further
//! branches begin at its special points.

use super::branch::{Branch, Special};
use super::conditions::Condition;
use super::kept::{KeptPaths, path as followed};
use super::orbit::Orbit;
use super::path::{Follow, PathEnd};
use super::place::Family;
use super::problem::Problem;
use super::step::{Departure, Follower};
use super::switching;
use super::traced::{self, Order, Traced};
use crate::curve::{CurvePoint, Equations, is_degenerate, tangent};
use crate::label::Label;
use crate::obstacle::Obstacle;
use crate::path_options::PathOptions;
use nalgebra::DVector;
use rayon::prelude::*;
use std::sync::Arc;
use vibro_machine::Start;
use vibro_numerics::sorting::sort_by_key;
use vibro_studies::now;
use vibro_studies::{Error, Result};

/// Length of the first step from an orbit.
const FIRST_STEP: f64 = 1e-2;
/// Lengths of a first step from a special point. The orbit after each step is compared with the
/// known branches. The shorter step is for branches that end within the longer one.
const KNOWN_STEPS: [f64; 2] = [1e-2, 1e-3];
/// Distance from a branch point within which a fold is not labelled: it is only the extremum of
/// the parameter on the side branch.
const TURN: f64 = 1e-4;
/// Number of branches followed in parallel. It is constant, so that the result does not depend on
/// the number of threads.
const BATCH: usize = 4;
/// The growth ends at this number of branches; the last batch may exceed it.
const MOST: usize = 400;

/// Options of a tree.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeOptions {
    /// Start of every motion that does not continue another one.
    pub start: Start,
    /// Number of parameter values with settled motions: with the parameter rising, with it falling
    /// and, if `depth` is positive, from `start`.
    pub seeds: usize,
    /// Number of returns discarded at each value; fewer if the motion settles before.
    pub discard: u32,
    /// Largest number of branch switches in a row, at period doublings, branch points and touches
    /// of rigid stops. If it is 0, only the branches of settled orbits are followed.
    pub depth: u32,
    /// Options for following a branch.
    pub path: PathOptions,
}

impl Default for TreeOptions {
    fn default() -> Self {
        Self { start: Start::default(), seeds: 24, discard: 400, depth: 3, path: PathOptions::default() }
    }
}

/// A possible start of a branch.
struct BranchStart {
    depth: u32,
    parent: Option<(usize, usize)>,
    kind: StartKind,
}

enum StartKind {
    Orbit(Box<Orbit>),
    /// One departure, or two in opposite directions. The points of the first path then come in
    /// reverse order, before the points of the second.
    Departures(Vec<Departure>),
}

/// A branch with its ends, in the order of its points.
type Grown = std::result::Result<(Branch, [PathEnd<Condition>; 2]), Obstacle>;

/// The departures in both directions from an orbit.
fn both_ways(orbit: &Orbit) -> std::result::Result<[Departure; 2], Obstacle> {
    let (problem, u) = (&orbit.problem, &orbit.u);
    if is_degenerate(&problem.linearize(u, None)?.matrix) {
        return Err(Obstacle::Singular);
    }
    let axis = crate::curve::axis(u.len(), u.len() - 1);
    let direction = tangent(problem, u, &axis)?;
    let departure = |direction: DVector<f64>| Departure {
        of: problem.clone(),
        u: u.clone(),
        direction,
        step: FIRST_STEP,
        special: None,
    };
    Ok([departure(-&direction), departure(direction)])
}

/// Follows the branch of one orbit of the family's machine, at the present value of the parameter,
/// in both directions.
///
/// # Errors
/// [`Error::Described`] if the present value lies outside the range or the orbit belongs to a
/// continuous family; otherwise the obstacle to computing the orbit again or to following it.
///
/// # Examples
/// For a ball to fly for a period T between impacts, the table must rise with the speed
/// gT/2 (1 - ε)/(1 + ε) at each impact. The branch turns at a fold, where this speed is the
/// largest of the table:
///
/// ```
/// use std::f64::consts::TAU;
/// use vibro_orbits::{Family, Label, Orbit, PathOptions, branch};
/// use vibro_studies::{Machine, Start};
///
/// # let text = r#"
/// #     name = "Juggler"
/// #     gravity = 10.0
/// #     body.table = { motion = { amplitude = "4 mm", frequency = "5 Hz" } }
/// #     body.ball = { mass = "20 g", gravity = -1.0, start = { v = 1.0 } }
/// #     stop.table = { between = ["ball", "table"], gap = 0.0, restitution = 0.8 }
/// # "#;
/// let machine = Machine::parse(text, "juggler.toml", &vibro_machine::file::no_records)?;
/// let orbit = Orbit::settled(&machine, &Start::default(), 400)?;
/// let family = Family::new(&machine, "body.table.motion.amplitude", (0.003, 0.0045))?;
/// let found = branch(&family, &orbit, &PathOptions::default())?;
/// let fold = found.points.iter().find(|point| point.label() == Some(Label::Fold)).unwrap();
/// assert!((fold.value * TAU * 5.0 - 0.2 / 1.8).abs() < 1e-9);
/// # Ok::<(), vibro_studies::Error>(())
/// ```
pub fn branch(family: &Family, orbit: &Orbit, options: &PathOptions) -> Result<Branch> {
    let problem = Problem { family: Arc::new(family.clone()), ..orbit.problem.clone() };
    let (value, (from, to)) = (family.present()?, family.range);
    if !(from..=to).contains(&value) {
        let told = |value| family.machine.told(&family.parameter, value);
        let problem = format!(
            "{} = {}: must lie in the range {} to {}, because the branch begins at this value; extend the \
             range, or set another value",
            family.parameter,
            told(value),
            told(from),
            told(to)
        );
        return Err(Error::Described { problem });
    }
    let u = problem.point(orbit.place(), &problem.numbers(orbit.place(), &orbit.u), value);
    let place = family.place(value)?;
    let failed =
        |obstacle| super::orbit::Obstructed { obstacle, residual: f64::NAN, word: String::new() }.error();
    let orbit = Orbit::at(problem, place, u).map_err(failed)?;
    let departures = both_ways(&orbit).map_err(|obstacle| match obstacle {
        Obstacle::Singular => {
            let problem = format!(
                "{} = {value}: the orbit belongs to a family of orbits of this machine, so no \
                 single branch over {} passes through it",
                family.parameter, family.parameter
            );
            Error::Described { problem }
        }
        other => failed(other),
    })?;
    let (traced, _) = trace(&StartKind::Departures(departures.to_vec()), options, &()).map_err(failed)?;
    Ok(traced)
}

/// The branch of a start, with its ends in the order of its points.
fn trace(start: &StartKind, options: &PathOptions, kept: &dyn KeptPaths) -> Grown {
    let both;
    let departures = match start {
        StartKind::Orbit(orbit) => match both_ways(orbit) {
            Err(Obstacle::Singular) => return alone(orbit),
            found => {
                both = found?;
                &both[..]
            }
        },
        StartKind::Departures(departures) => departures,
    };
    let order = Order { is_back_first: true, are_pieces: false };
    let traced = traced::trace(departures, &order, |departure| followed(departure, options, kept))?;
    let problem = departures.first().ok_or(Obstacle::NoConvergence)?.of.clone();
    Ok(branch_of(problem, traced))
}

/// The branch of traced points. The side branch of a crossing turns there, so a fold at the
/// crossing is not labelled.
fn branch_of(problem: Problem, traced: Traced<Condition>) -> (Branch, [PathEnd<Condition>; 2]) {
    let Traced { mut points, closed, began_at, ends } = traced;
    let crossings = points.iter().filter(|p| p.label() == Some(Label::BranchPoint));
    let crossings: Vec<DVector<f64>> = crossings.map(|p| p.u.clone()).collect();
    for point in points.iter_mut().filter(|p| p.label() == Some(Label::Fold)) {
        if crossings.iter().any(|u| (u - &point.u).norm() < TURN) {
            point.special = None;
        }
    }
    let (id, parent, depth, began_at) = (0, None, 0, Some(began_at));
    let periods = problem.word.periods;
    (Branch { id, parent, depth, periods, points, closed, began_at, of: problem }, ends)
}

/// A branch with a single point, for an orbit whose equations are singular.
fn alone(orbit: &Orbit) -> Grown {
    let (problem, u) = (&orbit.problem, orbit.u.clone());
    let tangent = crate::curve::axis(u.len(), u.len() - 1);
    let follower = Follower { problem };
    let at = follower.look(CurvePoint { u, tangent, steps: 1 })?;
    let points = vec![follower.point(&at, Some(Special::of(Label::NoConvergence)))];
    let ends = [PathEnd::Plain, PathEnd::Plain];
    Ok(branch_of(problem.clone(), Traced { points, closed: false, began_at: 0, ends }))
}

/// The branches found so far.
struct Grower<'a> {
    family: &'a Arc<Family>,
    options: &'a TreeOptions,
    kept: &'a dyn KeptPaths,
    branches: Vec<Branch>,
    /// The orbits of branches whose points all coincide.
    points: Vec<Orbit>,
    queue: Vec<BranchStart>,
}

/// The branches of a family reached from settled motions and special points. `told` receives the
/// branches found so far and the number of known branches and starts. The growth ends when `told`
/// returns false.
///
/// # Errors
/// None at present.
pub fn tree(
    family: &Family,
    options: &TreeOptions,
    told: &mut dyn FnMut(&[Branch], usize) -> bool,
) -> Result<Vec<Branch>> {
    tree_on(family, options, &(), told)
}

/// As [`tree`], with the paths kept from an interrupted growth.
///
/// # Errors
/// As [`tree`].
pub fn tree_on(
    family: &Family,
    options: &TreeOptions,
    kept: &dyn KeptPaths,
    told: &mut dyn FnMut(&[Branch], usize) -> bool,
) -> Result<Vec<Branch>> {
    let family = Arc::new(family.clone());
    let (branches, points, queue) = (Vec::new(), Vec::new(), Vec::new());
    let mut grower = Grower { family: &family, options, kept, branches, points, queue };
    grower.plant()?;
    while !grower.queue.is_empty() {
        grower.grow();
        let goes_on = told(&grower.branches, grower.branches.len() + grower.queue.len());
        if !goes_on || grower.branches.len() >= MOST {
            break;
        }
    }
    Ok(grower.branches)
}

impl Grower<'_> {
    /// Queues the orbits on which motions settle with the parameter rising and falling.
    fn plant(&mut self) -> Result<()> {
        let (from, to) = self.family.range;
        let count = self.options.seeds.max(1);
        // Only values inside the range. Its ends are often round numbers, at which a machine may
        // be symmetric by chance.
        let value = |i: usize| from + (to - from) * (i as f64 + 0.5) / count as f64;
        let chain = |upward: bool| -> Vec<Orbit> {
            let (mut end, mut found): (Option<Start>, Vec<Orbit>) = (None, Vec::new());
            for k in 0..count {
                let value = value(if upward { k } else { count - 1 - k });
                let Some((orbit, now)) = self.settled(value, end.as_ref()) else { continue };
                found.extend(orbit);
                end = Some(now);
            }
            found
        };
        let chains: Vec<Vec<Orbit>> = [true, false].into_par_iter().map(chain).collect();
        // A motion from the start may settle on an orbit that neither chain reaches. At the first
        // and at the last value a chain begins from the start.
        let fresh = if self.options.depth == 0 { 0..0 } else { 1..count.max(1) - 1 };
        let fresh = fresh.into_par_iter().filter_map(|k| self.settled(value(k), None)?.0);
        let fresh: Vec<Orbit> = fresh.collect();
        for orbit in chains.into_iter().flatten().chain(fresh).filter(Orbit::is_certified) {
            self.queue.push(BranchStart { depth: 0, parent: None, kind: StartKind::Orbit(Box::new(orbit)) });
        }
        Ok(())
    }

    /// The orbit on which a motion settles at a parameter value, and the final state of the
    /// motion. It continues from another motion's end, or begins at the tree's start.
    fn settled(&self, value: f64, from: Option<&Start>) -> Option<(Option<Orbit>, Start)> {
        let machine = self.family.at(value).ok()?;
        let begun = match from {
            Some(end) => machine.motion_on(end),
            None => machine.motion(&self.options.start),
        };
        let (motion, section) = begun.ok()?;
        let mut motion = motion.without_energy_accounts();
        let settled = Orbit::settled_in(self.family, value, (&mut motion, &section), self.options.discard);
        Some((settled.ok(), now(&motion)))
    }

    /// Follows the branches of the next starts in parallel, and adds the new ones.
    fn grow(&mut self) {
        sort_by_key(&mut self.queue, |start| start.depth);
        let starts: Vec<BranchStart> = self.queue.drain(..BATCH.min(self.queue.len())).collect();
        let (path, kept) = (&self.options.path, self.kept);
        let traced: Vec<_> = starts
            .into_par_iter()
            .filter(|start| !self.is_known(&start.kind))
            .filter_map(|start| Some((trace(&start.kind, path, kept).ok()?, start)))
            .collect();
        let known = self.branches.len();
        for ((mut branch, ends), BranchStart { depth, parent, kind }) in traced {
            if self.branches.len() > known && self.is_known(&kind) {
                continue;
            }
            let is_departure = matches!(kind, StartKind::Departures(_));
            // A path of one point: next to the special point no orbit has this word.
            if is_departure && branch.points.len() == 1 {
                continue;
            }
            (branch.id, branch.depth, branch.parent) = (self.branches.len(), depth, parent);
            // If all points coincide, other branches meet at this orbit. They are queued with the
            // parent of this branch, which is not kept.
            let point = branch.points.first().filter(|_| is_departure && branch.is_point());
            match point.map(|point| branch.orbit(point)) {
                None => {
                    self.switch(&branch, &ends, None);
                    self.branches.push(branch);
                }
                Some(Some(orbit)) if !self.points.iter().any(|own| own.is_same(&orbit)) => {
                    self.switch(&branch, &ends, parent);
                    self.points.push(orbit);
                }
                Some(_) => {}
            }
        }
    }

    /// Whether a start lies on a known branch.
    fn is_known(&self, start: &StartKind) -> bool {
        match start {
            StartKind::Orbit(orbit) => self.branches.iter().any(|branch| branch.passes(orbit)),
            StartKind::Departures(departures) => {
                let mut first = KNOWN_STEPS.iter().filter_map(|step| departures[0].first_orbit(*step));
                first.any(|orbit| self.is_known(&StartKind::Orbit(Box::new(orbit))))
            }
        }
    }

    /// Queues the starts at the special points of a branch. `parent` replaces the branch as their
    /// parent; it is given if all points of the branch coincide.
    fn switch(&mut self, branch: &Branch, ends: &[PathEnd<Condition>; 2], parent: Option<(usize, usize)>) {
        let goes_on = branch.depth < self.options.depth;
        let mut add = |point: usize, depth: u32, kind: StartKind| {
            let parent = parent.or(Some((branch.id, point)));
            self.queue.push(BranchStart { depth, parent, kind });
        };
        let last = branch.points.len() - 1;
        let further = branch.depth + 1;
        for (k, point) in branch.points.iter().enumerate().filter(|_| goes_on) {
            let Some(special) = &point.special else { continue };
            let is_end = k == 0 || k == last;
            match special.label {
                Label::PeriodDoubling if !is_end => {
                    if let Ok(departure) = switching::at_doubling(&branch.of, &point.u) {
                        add(k, further, StartKind::Departures(vec![departure]));
                    }
                }
                Label::BranchPoint if !is_end => {
                    let along = &branch.points[k + 1].u - &branch.points[k - 1].u;
                    // The point at which the branch itself began is skipped.
                    let began = k > 0 && branch.began_at == Some(k);
                    if let Ok(both) = switching::at_crossing(&branch.of, &point.u, &along)
                        && !began
                    {
                        add(k, further, StartKind::Departures(both.to_vec()));
                    }
                }
                _ => {}
            }
        }
        for (end, point) in ends.iter().zip([0, last]) {
            let PathEnd::At(condition) = end else { continue };
            let at = &branch.points[point];
            let Some(special) = &at.special else { continue };
            // At a touch of a rigid stop another branch begins. At any other condition the same
            // curve continues with a different word.
            let Ok(place) = branch.of.place(&at.u) else { continue };
            let parts = condition.touches_rigid_stop(branch.word(), place.assembly.system());
            if parts && !goes_on {
                continue;
            }
            let depth = if parts { further } else { branch.depth };
            match switching::at_touch(&branch.of, &at.u, *condition, special) {
                Ok(departure) => add(point, depth, StartKind::Departures(vec![departure])),
                Err(_) => {
                    for orbit in switching::beyond(branch, &at.u) {
                        add(point, depth, StartKind::Orbit(Box::new(orbit)));
                    }
                }
            }
        }
    }
}
