//! Paths as bytes, from which an interrupted growth of branches goes on.
//!
//! A path is found again by its departure, so that the bytes hold its points and its end alone.

use super::branch::OrbitPoint;
use super::conditions::Condition;
use super::orbit::Orbit;
use super::path::{self, PathEnd};
use super::step::{Departure, follow};
use crate::obstacle::Obstacle;
use crate::path_options::PathOptions;
use serde::{Deserialize, Serialize};
use std::hash::{DefaultHasher, Hash, Hasher};

/// Where followed paths are kept. Failures to keep or to find one are no errors: the path is
/// followed anew.
pub trait KeptPaths: Sync {
    /// The bytes of a path.
    fn find(&self, key: u64) -> Option<Vec<u8>>;
    /// Keeps the bytes of a path.
    fn keep(&self, key: u64, bytes: &[u8]);
}

/// Keeps nothing.
impl KeptPaths for () {
    fn find(&self, _: u64) -> Option<Vec<u8>> {
        None
    }

    fn keep(&self, _: u64, _: &[u8]) {}
}

type Path = path::Path<Condition>;

/// A path whose end at a condition is the condition's place among those of its last orbit.
#[derive(Serialize, Deserialize)]
struct KeptPath {
    points: Vec<OrbitPoint>,
    end: PathEnd<usize>,
}

/// The path of a departure: kept, or followed and kept.
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

/// A number by machine, parameter, word, departure and options.
fn key(departure: &Departure, options: &PathOptions) -> u64 {
    let Departure { of: problem, u, direction, step, special } = departure;
    let family = &problem.family;
    let mut hasher = DefaultHasher::new();
    let machine = (&family.machine.description, &family.parameter, family.range);
    format!("{machine:?} {:?} {:?} {:?}", problem.word, problem.units, problem.fixed).hash(&mut hasher);
    format!("{u:?} {direction:?} {step:?} {special:?} {:?} {options:?}", problem.origin).hash(&mut hasher);
    hasher.finish()
}

/// The bytes of a path; `None` for an end that they do not tell.
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

/// The path of bytes; `None` for bytes that are damaged or of other unknowns.
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
