//! Tracing of a tree: all branches reached from settled motions over the whole range, from orbits
//! near which other motions pass, from the motion without impacts, and from every special point of
//! every branch. Also traces a single branch.

use super::branch::Branch;
use super::family::Family;
use super::free;
use super::grower::{BranchStart, Grower};
use super::orbit::Orbit;
use super::path::{End, Follower};
use super::seeds::seeds;
use super::switching;
use super::tree::Tree;
use super::tree_options::TreeOptions;
use crate::obstacle::Obstacle;
use crate::path::follow;
use crate::path_options::PathOptions;
use crate::stop_word::OrbitWord;
use crate::traced::{self, Order, Traced};
use rayon::prelude::*;
use vibro_studies::Error;
use vibro_studies::parts::{NoStore, PartStore, Task};

/// Traces the tree of a family with one parameter. `done` receives the number of traced starts and
/// the number of waiting starts, which may increase.
///
/// # Errors
/// [`Error::Form`] if the longest step is outside [`PathOptions::STEPS`], if the repetitions are
/// outside 1 to 64, or if the options exceed 1024 letters, 4096 drive periods or 1,000,000 starts;
/// the error of a machine of the family.
pub fn tree(
    family: &Family,
    options: &TreeOptions,
    done: &(dyn Fn(usize, usize) + Sync),
) -> Result<Tree, Error> {
    tree_in_parts(family, options, &NoStore, done)
}

/// [`tree`] with finished parts kept in a store. Part 0 contains the orbits found by simulation;
/// each further part contains the branches of one batch of starts. The number of parts is not
/// known in advance. An interrupted tree continues from its store, which must belong to this
/// family and these options. It becomes bit-identical to an uninterrupted tree.
///
/// # Errors
/// The errors of [`tree`]; the error of the store.
pub fn tree_in_parts(
    family: &Family,
    options: &TreeOptions,
    store: &dyn PartStore,
    done: &(dyn Fn(usize, usize) + Sync),
) -> Result<Tree, Error> {
    let task = Task { store, ..Task::ALL };
    let mut grower = Grower::new(family, options);
    options.check()?;
    grower.path.check()?;
    for (branch, contacts) in free::branches(family, &options.marks)? {
        let id = grower.tree.branches.len();
        grower.tree.branches.push(branch);
        for (point, contact) in contacts {
            grower.offer_longer(&contact, 0, (id, point));
        }
    }
    if let Some(found) = task.part(0, |_| seeds(family, options))? {
        grower.plant(found);
    }
    let mut traced = 0;
    for round in 1.. {
        if grower.queue.is_empty() {
            break;
        }
        let batch = grower.next_batch();
        traced += batch.len();
        let batch: Vec<BranchStart> = batch.into_iter().filter(|s| !grower.tree_has(s)).collect();
        let trace_all = |_| -> Result<Vec<Option<Traced<End>>>, Error> {
            let trace = |start: &BranchStart| trace(family, &grower.path, &options.marks, start).ok();
            Ok(batch.par_iter().map(trace).collect())
        };
        let found = task.part(round, trace_all)?.unwrap_or_default();
        for (start, branch) in batch.into_iter().zip(found) {
            match branch {
                Some(branch) => grower.add(start, branch),
                None => grower.tree.failures += 1,
            }
        }
        done(traced, grower.queue.len());
    }
    Ok(grower.tree)
}

/// The branch of one orbit, followed in both directions without switching. Points at the parameter
/// values `marks` are labelled UZ. Its word is the shortest word of the orbit. A symmetric orbit
/// given as UL closing with + is followed as U closing with -: the symmetry may break on the
/// branch, and the symmetric orbits are followed beyond this point. If the parameter is a load the
/// word stays UL, since no orbit is symmetric under a load.
///
/// ```
/// use vibro_orbits::paper::{Family, Label, OrbitWord, PathOptions, Span, branch};
/// use vibro_studies::paper::{ParameterSet, find_group};
///
/// let span = Span::new(find_group("f10")?, 0.5, 3.0)?;
/// let family = Family::new(&ParameterSet::basic(), span)?;
/// let word = OrbitWord::new("U", -1, 1)?;
/// let found = branch(&family, &word, &[5.5], 1.5, &PathOptions::default(), &[])?;
/// let special = found.points.iter().find(|p| p.label() == Some(Label::BranchPoint));
/// let breaking = special.expect("the symmetry breaks");
/// assert!((breaking.value - 2.039_588_865_238).abs() < 1e-11);
/// # Ok::<(), vibro_studies::Error>(())
/// ```
///
/// # Errors
/// [`Error::Form`] if the longest step is not allowed or the value is outside the family's range;
/// [`Error::NoOrbit`] if no orbit exists near `phases` at the value, or if that orbit passes a
/// stop; the error of the machine at the value.
pub fn branch(
    family: &Family,
    word: &OrbitWord,
    phases: &[f64],
    value: f64,
    options: &PathOptions,
    marks: &[f64],
) -> Result<Branch, Error> {
    options.check()?;
    if !family.span().contains(value) {
        let text = format!("{}={value}", family.span().name.name());
        return Err(Error::Form { text, expected: "a value within the range of the family" });
    }
    let system = family.system(&[value])?;
    let orbit = Orbit::find(&system, word, phases)?;
    if !orbit.is_certified() {
        let reason = "the solution of its equations passes through a stop between impacts; try \
                      another guess of the phases";
        return Err(word.no_orbit(reason));
    }
    if word.is_empty() {
        let around = |b: &Branch| b.points.windows(2).any(|p| (p[0].value..=p[1].value).contains(&value));
        let found = free::branches(family, marks)?.into_iter().map(|b| b.0).find(around);
        return found.ok_or_else(|| Obstacle::NoConvergence.error(&system, word));
    }
    let (word, phases) = family.shortest(&orbit);
    let followed = || {
        let (word, both) = switching::both_ways(family, &word, &phases, value)?;
        let start = BranchStart { depth: 0, parent: None, word, departures: both.to_vec(), island: false };
        Ok((trace(family, options, marks, &start)?, start.word))
    };
    let (Traced { points, closed, .. }, word) =
        followed().map_err(|obstacle: Obstacle| obstacle.error(&system, &word))?;
    Ok(Branch::new(word, points, closed))
}

/// Follows a start in all of its directions.
fn trace(
    family: &Family,
    options: &PathOptions,
    marks: &[f64],
    start: &BranchStart,
) -> Result<Traced<End>, Obstacle> {
    let follower = Follower { family, word: &start.word, options, marks };
    let order = Order { is_back_first: false, are_pieces: true };
    traced::trace(&start.departures, &order, |departure| follow(&follower, departure, options))
}
