//! Storage of paths as bytes, for continuing an interrupted growth of branches.
//!
//! A path is found by its departure, so the bytes contain only its points and its end.

use super::branch::OrbitPoint;
use super::conditions::Condition;
use super::orbit::Orbit;
use super::path::{self, PathEnd};
use super::step::{Departure, follow};
use crate::obstacle::Obstacle;
use crate::path_options::PathOptions;
use serde::{Deserialize, Serialize};
use std::hash::{DefaultHasher, Hash, Hasher};

/// Storage of followed paths. Failures to store or find a path are not errors: the path is
/// followed again.
pub trait KeptPaths: Sync {
    /// The bytes of a stored path.
    fn find(&self, key: u64) -> Option<Vec<u8>>;
    /// Stores the bytes of a path.
    fn keep(&self, key: u64, bytes: &[u8]);
}

/// Stores nothing.
impl KeptPaths for () {
    fn find(&self, _: u64) -> Option<Vec<u8>> {
        None
    }

    fn keep(&self, _: u64, _: &[u8]) {}
}

type Path = path::Path<Condition>;

/// A path whose end condition is stored as its index among the last orbit's conditions.
#[derive(Serialize, Deserialize)]
struct KeptPath {
    points: Vec<OrbitPoint>,
    end: PathEnd<usize>,
}

/// The path of a departure: read from storage, or followed and stored.
pub(super) fn path(
    departure: &Departure,
    options: &PathOptions,
    kept: &dyn KeptPaths,
) -> Result<Path, Obstacle> {
    let key = key(departure, options);
    if let Some(path) = kept.find(key).and_then(|bytes| read(departure, &bytes)) {
        return Ok(path);
    }
    let path = follow(departure, options)?;
    if let Some(bytes) = written(departure, &path) {
        kept.keep(key, &bytes);
    }
    Ok(path)
}

/// Hash of machine, parameter, word, departure and options.
fn key(departure: &Departure, options: &PathOptions) -> u64 {
    let Departure { of: problem, u, direction, step, special } = departure;
    let family = &problem.family;
    let mut hasher = DefaultHasher::new();
    let machine = (&family.machine.description, &family.parameter, family.range);
    format!("{machine:?} {:?} {:?} {:?}", problem.word, problem.units, problem.fixed).hash(&mut hasher);
    format!("{u:?} {direction:?} {step:?} {special:?} {:?} {options:?}", problem.origin).hash(&mut hasher);
    hasher.finish()
}

/// The bytes of a path; `None` for an end that they cannot represent.
fn written(departure: &Departure, path: &Path) -> Option<Vec<u8>> {
    let place = |condition: &Condition| {
        orbit(departure, path.points.last()?)?.conditions().iter().position(|own| own.0 == *condition)
    };
    let end = match &path.end {
        PathEnd::Plain => PathEnd::Plain,
        PathEnd::Closed => PathEnd::Closed,
        PathEnd::At(condition) => PathEnd::At(place(condition)?),
    };
    postcard::to_stdvec(&KeptPath { points: path.points.clone(), end }).ok()
}

fn orbit(departure: &Departure, point: &OrbitPoint) -> Option<Orbit> {
    let place = departure.of.place(&point.u).ok()?;
    Orbit::at(departure.of.clone(), place, point.u.clone()).ok()
}

/// The path from bytes; `None` for damaged bytes or a different number of unknowns.
fn read(departure: &Departure, bytes: &[u8]) -> Option<Path> {
    let KeptPath { points, end } = postcard::from_bytes(bytes).ok()?;
    let last = points.last().filter(|_| points.iter().all(|point| point.u.len() == departure.u.len()))?;
    let end = match end {
        PathEnd::Plain => PathEnd::Plain,
        PathEnd::Closed => PathEnd::Closed,
        PathEnd::At(place) => PathEnd::At(orbit(departure, last)?.conditions().get(place)?.0),
    };
    Some(Path { points, end })
}
