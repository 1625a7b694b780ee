//! All branches that can be reached: from settled motions over the whole range, from the motion without impacts, and from every
//! special point of every branch.

use super::branch::{Branch, Label, Point, Special};
use super::family::Family;
use super::free;
use super::obstacle::Obstacle;
use super::orbit::Orbit;
use super::path::{Follower, PathEnd, PathOptions, follow};
use super::settled;
use super::switching::{self, Contact, Departure};
use super::word::OrbitWord;
use crate::bifurcation::within_gap;
use crate::error::Error;
use crate::stroboscopic::moving_block;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Starts that are traced together. It is fixed, so that the results do not depend on the number of threads.
const TOGETHER: usize = 16;

/// Values of the parameter, in units of a fifth of its range, that count as one place of the same kind of point.
pub(super) const SAME_PLACE: f64 = 1e-7;

/// What is traced.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TreeOptions {
    /// Values of the parameter at which motions are settled, in each direction.
    pub seeds: usize,
    /// Drive periods in which transients die out.
    pub settle: u32,
    /// Switches of branches that are followed one after another from a settled motion.
    pub depth: u32,
    /// The longest period of a branch, in drive periods.
    pub longest_period: u32,
    /// Most letters of a word.
    pub most_letters: usize,
    /// The longest step, as [`PathOptions::longest_step`].
    pub longest_step: f64,
    /// Most points of a branch in one direction.
    pub most_points: usize,
    /// At a touch the words that list it once in up to so many passages of the orbit without it are followed too: with 1 in every
    /// passage alone.
    pub repetitions: u32,
    /// Values of the parameter at which each branch has a point, labelled UZ.
    pub marks: Vec<f64>,
}

impl Default for TreeOptions {
    fn default() -> Self {
        let PathOptions { longest_step, most_points } = PathOptions::default();
        Self {
            seeds: 91,
            settle: 1000,
            depth: 12,
            longest_period: 32,
            most_letters: 64,
            longest_step,
            most_points,
            repetitions: 1,
            marks: Vec::new(),
        }
    }
}

/// All branches that were found.
#[derive(Clone, Debug)]
pub struct Tree {
    /// In the order in which they were found, which depends on nothing but the family and the options.
    pub branches: Vec<Branch>,
    /// Starts that led nowhere: no branch could be followed from them.
    pub failures: usize,
}

/// A place from which a branch may be traced.
#[derive(Clone, Debug)]
struct Start {
    depth: u32,
    parent: Option<(usize, usize)>,
    word: OrbitWord,
    departures: Vec<Departure>,
}

/// A branch that was traced, with how its ends continue.
struct Traced {
    start: Start,
    points: Vec<Point>,
    closed: bool,
    /// Indices of points with what continues there.
    ends: Vec<(usize, PathEnd)>,
}

/// Traces the tree of a family with one parameter; `done` hears of the starts that were traced and those that wait.
///
/// # Errors
/// What the machines of the family refuse.
pub fn tree(
    family: &Family,
    options: &TreeOptions,
    done: &(dyn Fn(usize, usize) + Sync),
) -> Result<Tree, Error> {
    let mut grower = Grower::new(family, options);
    for (branch, contacts) in free::branches(family, &options.marks)? {
        let id = grower.tree.branches.len();
        grower.tree.branches.push(branch);
        for (point, contact) in contacts {
            grower.offer_longer(&contact, 0, (id, point));
        }
    }
    for orbit in settled_orbits(family, options)? {
        let (word, phases, value) = orbit;
        if let Ok((word, both)) = switching::both_ways(family, &word, &phases, value) {
            grower.queue.push(Start { depth: 0, parent: None, word, departures: both.to_vec() });
        }
    }
    let mut traced = 0;
    while !grower.queue.is_empty() {
        let batch = grower.next_batch();
        traced += batch.len();
        let batch: Vec<Start> = batch.into_iter().filter(|s| !grower.tree_has(s)).collect();
        let found: Vec<_> =
            batch.into_par_iter().map(|start| trace(family, &grower.path, &options.marks, start)).collect();
        for branch in found {
            match branch {
                Ok(branch) => grower.add(branch),
                Err(_) => grower.tree.failures += 1,
            }
        }
        done(traced, grower.queue.len());
    }
    Ok(grower.tree)
}

/// The branch of one orbit, followed in both directions without switching to others; points at the values `marks` of the parameter
/// are labelled UZ.
///
/// ```
/// use vibro_analysis::orbits::{ConstantLoads, Family, Label, OrbitWord, PathOptions, Span, branch};
/// use vibro_analysis::{ParameterSet, find_group};
///
/// let span = Span::new(find_group("f10")?, 0.5, 3.0)?;
/// let family = Family::new(&ParameterSet::basic(), ConstantLoads::NONE, span)?;
/// let found = branch(&family, &OrbitWord::new("U", -1, 1)?, &[5.5], 1.5, &PathOptions::default(), &[])?;
/// let breaking = found.points.iter().find(|p| p.label() == Some(Label::BranchPoint)).expect("one");
/// assert!((breaking.value - 2.039_588_865_238).abs() < 1e-11);
/// # Ok::<(), vibro_analysis::Error>(())
/// ```
///
/// # Errors
/// [`Error::NoOrbit`] when there is no orbit near `phases` at the value, or none of the machine; what the machine refuses.
pub fn branch(
    family: &Family,
    word: &OrbitWord,
    phases: &[f64],
    value: f64,
    options: &PathOptions,
    marks: &[f64],
) -> Result<Branch, Error> {
    let system = family.system(&[value])?;
    let orbit = Orbit::find(&system, word, phases)?;
    if !orbit.is_certified() {
        let reason = "what solves its equations passes a stop between its impacts; another guess of the phases may help";
        return Err(Error::NoOrbit {
            word: word.to_string(),
            closing: if word.closing() > 0 { '+' } else { '-' },
            period: word.period(),
            reason: reason.into(),
        });
    }
    if word.is_empty() {
        let around = |b: &Branch| b.points.windows(2).any(|p| (p[0].value..=p[1].value).contains(&value));
        let found = free::branches(family, marks)?.into_iter().map(|b| b.0).find(around);
        return found.ok_or_else(|| Obstacle::NoConvergence.error(&system, word));
    }
    let followed = || {
        let (word, both) = switching::both_ways(family, word, orbit.phases(), value)?;
        let start = Start { depth: 0, parent: None, word, departures: both.to_vec() };
        trace(family, options, marks, start)
    };
    let Traced { start, points, closed, .. } =
        followed().map_err(|obstacle| obstacle.error(&system, word))?;
    Ok(Branch { id: 0, parent: None, depth: 0, word: start.word, points, closed })
}

/// Follows a start in all its directions.
fn trace(family: &Family, options: &PathOptions, marks: &[f64], start: Start) -> Result<Traced, Obstacle> {
    let follower = Follower { family, word: &start.word, options, marks };
    let mut departures = start.departures.iter();
    let first = departures.next().ok_or(Obstacle::NoConvergence)?;
    let forward = follow(&follower, first.clone())?;
    let closed = matches!(forward.end, PathEnd::Closed);
    let second = departures.next().filter(|_| !closed);
    let backward = second.map(|d| follow(&follower, d.clone())).transpose()?;
    let mut points = Vec::new();
    let mut ends = Vec::new();
    if let Some(path) = backward {
        // Each point keeps the stability of the piece that follows it in the branch's order.
        let pieces: Vec<bool> = path.points.iter().map(|p| p.stable).collect();
        let reversed = path.points.into_iter().enumerate().skip(1).rev();
        points.extend(reversed.map(|(i, point)| Point { stable: pieces[i - 1], ..point }));
        ends.push((0, path.end));
    }
    points.extend(forward.points);
    ends.push((points.len() - 1, forward.end));
    Ok(Traced { start, points, closed, ends })
}

/// An orbit's word, phases and parameter.
type Place = (OrbitWord, Vec<f64>, f64);

/// The periodic orbits on which motions settle with the parameter rising and falling, the end of one value being the start of the
/// next.
fn settled_orbits(family: &Family, options: &TreeOptions) -> Result<Vec<Place>, Error> {
    let seeds = options.seeds;
    let span = *family.span();
    let value = |i: usize| {
        let part = if seeds > 1 { i as f64 / (seeds - 1) as f64 } else { 0.5 };
        span.from * (1.0 - part) + span.to * part
    };
    let chain = |rising: bool| -> Result<Vec<Place>, Error> {
        let mut found = Vec::new();
        let mut last = None;
        for i in 0..seeds {
            let value = value(if rising { i } else { seeds - 1 - i });
            let system = family.system(&[value])?;
            let p = system.parameters();
            let start =
                last.map_or_else(|| moving_block(p), |(state, gap)| within_gap(state, gap, p.stop_gap));
            // Where the simulator refuses, the next value starts anew.
            let settled = settled::settle(&system, &start, options.settle).ok();
            last = settled.map(|state| (state, p.stop_gap));
            if let Some(orbit) = settled.and_then(|state| settled::orbit_of(&system, &state).ok())
                && !orbit.word().is_empty()
            {
                found.push((orbit.word().clone(), orbit.phases().to_vec(), value));
            }
        }
        Ok(found)
    };
    let (rising, falling) = rayon::join(|| chain(true), || chain(false));
    Ok([rising?, falling?].concat())
}

/// The tree as far as it has grown.
struct Grower<'a> {
    family: &'a Family,
    options: &'a TreeOptions,
    path: PathOptions,
    tree: Tree,
    queue: Vec<Start>,
    /// Places from which branches were traced or at which they end: kind, canonical word, parameter.
    known: Vec<(Label, OrbitWord, f64)>,
}

impl<'a> Grower<'a> {
    fn new(family: &'a Family, options: &'a TreeOptions) -> Self {
        let path = PathOptions { longest_step: options.longest_step, most_points: options.most_points };
        let tree = Tree { branches: Vec::new(), failures: 0 };
        Self { family, options, path, tree, queue: Vec::new(), known: Vec::new() }
    }

    /// The next starts of the queue, which is in order of depth and in each depth in order of discovery: of those of one word the
    /// first alone, since others may lie on its branch.
    fn next_batch(&mut self) -> Vec<Start> {
        let (mut batch, mut rest): (Vec<Start>, Vec<Start>) = (Vec::new(), Vec::new());
        for start in self.queue.drain(..) {
            let first = batch.first().is_none_or(|b| b.depth == start.depth);
            if first && batch.len() < TOGETHER && batch.iter().all(|b| b.word != start.word) {
                batch.push(start);
            } else {
                rest.push(start);
            }
        }
        self.queue = rest;
        batch
    }

    /// Whether the orbit from which a start leaves is on a branch already.
    fn tree_has(&self, start: &Start) -> bool {
        let Some(departure) = start.departures.first().filter(|d| d.special.is_none()) else { return false };
        let value = self.family.values(&departure.u)[0];
        self.tree
            .passing(self.family, &start.word, &departure.u.as_slice()[..start.word.len()], value)
            .is_some()
    }

    /// Takes a branch into the tree, unless it is there, and queues what begins on it.
    fn add(&mut self, traced: Traced) {
        let Traced { start, points, closed, ends } = traced;
        let Start { depth, parent, word, departures } = start;
        if points.len() < 3 {
            self.tree.failures += 1;
            return;
        }
        let born = departures.len() == 1;
        // Away from the ends, next to which several branches lie close together.
        let middle = points.len() / 2;
        let probe = points[middle..].iter().find(|p| p.special.is_none()).unwrap_or(&points[middle]);
        if self.tree.passing(self.family, &word, &probe.phases, probe.value).is_some() {
            return;
        }
        let id = self.tree.branches.len();
        if let (true, Some(label)) = (born, points[0].label()) {
            self.know(label, &word, points[0].value);
        }
        let starts: Vec<(usize, Label)> =
            points.iter().enumerate().filter_map(|(i, p)| Some((i, p.label()?))).collect();
        self.tree.branches.push(Branch { id, parent, depth, word: word.clone(), points, closed });
        let end_points: Vec<usize> = ends.iter().map(|e| e.0).collect();
        for (point, label) in starts {
            let doubles = matches!(label, Label::PeriodDoubling | Label::BranchPoint);
            if doubles && !end_points.contains(&point) && !(born && point == 0) {
                self.offer_doubled(id, point, label);
            }
        }
        for (point, end) in ends {
            match end {
                PathEnd::Touch(touch) => {
                    let contact = Contact::of(self.family, &touch);
                    let value = self.family.values(&touch.u)[0];
                    let fold = self.is_fold(&contact, &touch);
                    if let Some(special) = &mut self.tree.branches[id].points[point].special {
                        special.fold = fold;
                    }
                    self.know(Label::Grazing, &word, value);
                    self.offer_shorter(&contact, depth, (id, point));
                    self.offer_longer(&contact, depth, (id, point));
                }
                PathEnd::Primary(primary, u) => {
                    let label = self.tree.branches[id].points[point].label();
                    let value = self.family.values(&u)[0];
                    self.know(label.unwrap_or(Label::BranchPoint), &word, value);
                    let phases = u.as_slice()[..primary.len()].to_vec();
                    if let Ok((word, both)) = switching::both_ways(self.family, &primary, &phases, value) {
                        self.offer(Start {
                            depth: depth + 1,
                            parent: Some((id, point)),
                            word,
                            departures: both.to_vec(),
                        });
                    }
                }
                PathEnd::Plain | PathEnd::Closed => {}
            }
        }
    }

    /// Whether the orbits with and without a touch exist on the same side of it.
    fn is_fold(&self, contact: &Contact, touch: &super::grazing::Touch) -> Option<bool> {
        let with = switching::with_touch(self.family, touch).ok()?;
        let longer = with.tangent[touch.longer.len()];
        let shorter = if contact.shorter.is_empty() {
            free::towards_clear(self.family, &contact.u)?
        } else {
            contact.departure(self.family).ok()?.tangent[contact.shorter.len()]
        };
        Some(longer * shorter > 0.0)
    }

    fn key(&self, label: Label, word: &OrbitWord, value: f64) -> (Label, OrbitWord, f64) {
        (label, word.canonical_turn(self.family.is_symmetric()).0, value / self.family.span().unit())
    }

    fn know(&mut self, label: Label, word: &OrbitWord, value: f64) {
        let key = self.key(label, word, value);
        self.known.push(key);
    }

    /// Remembers a place; false where it is known.
    fn is_new(&mut self, label: Label, word: &OrbitWord, value: f64) -> bool {
        let key = self.key(label, word, value);
        let same =
            |k: &(Label, OrbitWord, f64)| k.0 == key.0 && k.1 == key.1 && (k.2 - key.2).abs() < SAME_PLACE;
        if self.known.iter().any(same) {
            return false;
        }
        self.known.push(key);
        true
    }

    /// Queues a start in the order of depth, unless it is out of bounds.
    fn offer(&mut self, start: Start) {
        let TreeOptions { depth, longest_period, most_letters, .. } = *self.options;
        if start.depth > depth || start.word.period() > longest_period || start.word.len() > most_letters {
            return;
        }
        let place = self.queue.partition_point(|s| s.depth <= start.depth);
        self.queue.insert(place, start);
    }

    fn offer_doubled(&mut self, id: usize, point: usize, label: Label) {
        let branch = &self.tree.branches[id];
        let (at, depth, word) = (&branch.points[point], branch.depth, branch.word.clone());
        let u = self.family.point(&at.phases, &[at.value]);
        let value = at.value;
        // A doubled branch's own crossing of another one is not a doubling.
        let Ok((word, departure)) = switching::doubled(self.family, &word, &u, label) else { return };
        if self.is_new(label, &word, value) {
            let (word, departure) = switching::canonical_departure(self.family, &word, &departure);
            self.offer(Start {
                depth: depth + 1,
                parent: Some((id, point)),
                word,
                departures: vec![departure],
            });
        }
    }

    fn offer_longer(&mut self, contact: &Contact, depth: u32, parent: (usize, usize)) {
        for touch in contact.longer(self.family, self.options.repetitions) {
            let value = self.family.values(&touch.u)[0];
            if !self.is_new(Label::Grazing, &touch.longer, value) {
                continue;
            }
            if let Ok(departure) = switching::with_touch(self.family, &touch) {
                self.offer_born(&touch.longer, &departure, depth, parent, &touch.longer);
            }
        }
    }

    fn offer_shorter(&mut self, contact: &Contact, depth: u32, parent: (usize, usize)) {
        let value = self.family.values(&contact.u)[0];
        if contact.shorter.is_empty() || !self.is_new(Label::Grazing, &contact.shorter, value) {
            return;
        }
        let longer = contact.longer(self.family, 1).remove(0).longer;
        if let Ok(departure) = contact.departure(self.family) {
            self.offer_born(&contact.shorter, &departure, depth, parent, &longer);
        }
    }

    fn offer_born(
        &mut self,
        word: &OrbitWord,
        departure: &Departure,
        depth: u32,
        parent: (usize, usize),
        longer: &OrbitWord,
    ) {
        let special = Special { longer: Some(longer.clone()), ..Special::of(Label::Grazing) };
        let departure = Departure { special: Some(special), ..departure.clone() };
        let (word, departure) = switching::reduced_departure(self.family, word, &departure);
        let (word, departure) = switching::canonical_departure(self.family, &word, &departure);
        self.offer(Start { depth: depth + 1, parent: Some(parent), word, departures: vec![departure] });
    }
}
