//! Growth of a tree: the queue of starts, the known special points, and the starts at the special
//! points of each traced branch.

use super::branch::Branch;
use super::family::Family;
use super::free;
use super::grazing::Touch;
use super::path::End;
use super::seeds::{SeedOrbit, Seeds};
use super::switching::{self, Departure, FlightTouch};
use super::tree::Tree;
use super::tree_options::TreeOptions;
use crate::branch::{OrbitPoint, Special};
use crate::label::Label;
use crate::path::PathEnd;
use crate::path_options::PathOptions;
use crate::stop_word::OrbitWord;
use crate::traced::Traced;

/// Number of starts traced in parallel. It is constant, so that the result does not depend on the
/// number of threads.
const TOGETHER: usize = 16;

/// Tolerance for equal special points of one kind, as a difference of the parameter in its curve
/// unit.
pub(super) const SAME_PLACE: f64 = 1e-7;

/// A start for tracing a branch.
#[derive(Clone, Debug)]
pub(super) struct BranchStart {
    pub depth: u32,
    pub parent: Option<(usize, usize)>,
    pub word: OrbitWord,
    pub departures: Vec<Departure>,
    /// Whether its branch is kept only if it is stable somewhere: for orbits near which a motion
    /// passed.
    pub island: bool,
}

/// Depth in the queue of orbits near which motions passed; they come after all other starts.
const LAST: u32 = u32::MAX;

/// The tree found so far.
pub(super) struct Grower<'a> {
    family: &'a Family,
    options: &'a TreeOptions,
    pub path: PathOptions,
    pub tree: Tree,
    pub queue: Vec<BranchStart>,
    /// Traced branches that are not islands, because they are stable nowhere.
    left_out: Tree,
    /// Known special points, where branches were traced or end: label, canonical word, parameter.
    known: Vec<(Label, OrbitWord, f64)>,
}

impl<'a> Grower<'a> {
    pub fn new(family: &'a Family, options: &'a TreeOptions) -> Self {
        let path = PathOptions { longest_step: options.longest_step, most_points: options.most_points };
        let (tree, left_out) = (Tree::default(), Tree::default());
        Self { family, options, path, tree, left_out, queue: Vec::new(), known: Vec::new() }
    }

    /// Queues the orbits found by simulation: first settled orbits, last orbits near which motions
    /// passed.
    pub fn plant(&mut self, seeds: Seeds) {
        let Seeds { settled, passed, searched } = seeds;
        self.tree.searched = searched;
        // A stable orbit is on an island or on a known branch.
        let (stable, unstable): (Vec<SeedOrbit>, Vec<SeedOrbit>) =
            passed.into_iter().partition(|orbit| orbit.stable);
        let passed = stable.into_iter().chain(unstable).map(|orbit| (orbit, LAST));
        for (orbit, depth) in settled.into_iter().map(|orbit| (orbit, 0)).chain(passed) {
            let SeedOrbit { word, phases, value, .. } = orbit;
            if let Ok((word, both)) = switching::both_ways(self.family, &word, &phases, value) {
                let departures = both.to_vec();
                self.queue.push(BranchStart { depth, parent: None, word, departures, island: depth == LAST });
            }
        }
    }

    /// The next batch of the queue, which is ordered by depth and then by discovery. Only the
    /// first of several starts with the same word is taken, since the others may lie on its
    /// branch.
    pub fn next_batch(&mut self) -> Vec<BranchStart> {
        let (mut batch, mut rest): (Vec<BranchStart>, Vec<BranchStart>) = (Vec::new(), Vec::new());
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

    /// Whether a start's orbit already lies on a branch.
    pub fn tree_has(&self, start: &BranchStart) -> bool {
        let Some(departure) = start.departures.first().filter(|d| d.special.is_none()) else { return false };
        let value = self.family.values(&departure.u)[0];
        let phases = &departure.u.as_slice()[..start.word.len()];
        let passes = |tree: &Tree| tree.passing(self.family, &start.word, phases, value).is_some();
        passes(&self.tree) || (start.island && passes(&self.left_out))
    }

    /// Adds a new branch to the tree, and queues the starts on it.
    pub fn add(&mut self, start: BranchStart, traced: Traced<End>) {
        let Traced { points, closed, ends, .. } = traced;
        let BranchStart { depth, parent, word, departures, island } = start;
        self.tree.searched.followed += usize::from(island);
        if points.len() < 3 {
            self.tree.failures += usize::from(!island);
            return;
        }
        if island && !points.iter().any(OrbitPoint::is_stable) {
            let id = self.left_out.branches.len();
            self.left_out.branches.push(Branch { id, parent, depth, ..Branch::new(word, points, closed) });
            return;
        }
        let depth = if island { 0 } else { depth };
        let born = departures.len() == 1;
        // The probe is away from the ends, where several branches lie close together.
        let middle = points.len() / 2;
        let probe = points[middle..].iter().find(|p| p.special.is_none()).unwrap_or(&points[middle]);
        if self.tree.passing(self.family, &word, probe.phases(), probe.value).is_some() {
            return;
        }
        self.tree.searched.islands += usize::from(island);
        let id = self.tree.branches.len();
        if let (true, Some(label)) = (born, points[0].label()) {
            self.know(label, &word, points[0].value);
        }
        let starts: Vec<(usize, Label)> =
            points.iter().enumerate().filter_map(|(i, p)| Some((i, p.label()?))).collect();
        let last = points.len() - 1;
        self.tree.branches.push(Branch { id, parent, depth, ..Branch::new(word.clone(), points, closed) });
        for (point, label) in starts {
            let doubles = matches!(label, Label::PeriodDoubling | Label::BranchPoint);
            if doubles && point != 0 && point != last {
                self.offer_doubled(id, point, label);
            }
        }
        for (point, end) in [0, last].into_iter().zip(ends) {
            match end {
                PathEnd::At(End::Touch(touch)) => {
                    let contact = FlightTouch::of(self.family, &touch);
                    let value = self.family.values(&touch.u)[0];
                    let fold = self.is_fold(&contact, &touch);
                    if let Some(special) = &mut self.tree.branches[id].points[point].special {
                        special.fold = fold;
                    }
                    self.know(Label::Grazing, &word, value);
                    self.offer_shorter(&contact, depth, (id, point));
                    self.offer_longer(&contact, depth, (id, point));
                }
                PathEnd::At(End::Primary(primary, u)) => {
                    let label = self.tree.branches[id].points[point].label();
                    let value = self.family.values(&u)[0];
                    self.know(label.unwrap_or(Label::BranchPoint), &word, value);
                    let phases = u.as_slice()[..primary.len()].to_vec();
                    if let Ok((word, both)) = switching::both_ways(self.family, &primary, &phases, value) {
                        self.offer(BranchStart {
                            depth: depth + 1,
                            parent: Some((id, point)),
                            word,
                            departures: both.to_vec(),
                            island: false,
                        });
                    }
                }
                PathEnd::Plain | PathEnd::Closed => {}
            }
        }
    }

    /// Whether the orbits with and without a touch exist on the same side of the touch.
    fn is_fold(&self, contact: &FlightTouch, touch: &Touch) -> Option<bool> {
        let with = switching::with_touch(self.family, touch).ok()?;
        let longer = with.direction[touch.longer.len()];
        let shorter = if contact.shorter.is_empty() {
            free::towards_clear(self.family, &contact.u)?
        } else {
            contact.departure(self.family).ok()?.direction[contact.shorter.len()]
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

    /// Records a special point; returns false if it was known.
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

    /// Queues a start by depth, unless it is beyond the tree's limits.
    fn offer(&mut self, start: BranchStart) {
        if start.depth > self.options.depth || !self.options.admits(&start.word) {
            return;
        }
        let position = self.queue.partition_point(|s| s.depth <= start.depth);
        self.queue.insert(position, start);
    }

    fn offer_doubled(&mut self, id: usize, point: usize, label: Label) {
        let branch = &self.tree.branches[id];
        let (at, depth, word) = (&branch.points[point], branch.depth, branch.word().clone());
        let u = self.family.point(at.phases(), &[at.value]);
        let value = at.value;
        // The crossing of a doubled branch with another one is not a doubling.
        let Ok((word, departure)) = switching::doubled(self.family, &word, &u, label) else { return };
        if self.is_new(label, &word, value) {
            let (word, departure) = switching::canonical_departure(self.family, &word, &departure);
            self.offer(BranchStart {
                depth: depth + 1,
                parent: Some((id, point)),
                word,
                departures: vec![departure],
                island: false,
            });
        }
    }

    pub fn offer_longer(&mut self, contact: &FlightTouch, depth: u32, parent: (usize, usize)) {
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

    fn offer_shorter(&mut self, contact: &FlightTouch, depth: u32, parent: (usize, usize)) {
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
        let departures = vec![departure];
        self.offer(BranchStart { depth: depth + 1, parent: Some(parent), word, departures, island: false });
    }
}
