//! Paths as texts, from which an interrupted growth of branches goes on.
//!
//! A path is found again by its departure, so that the text holds numbers alone: how it ends, and
//! of each point the parameter, the period, the stability, the special point, the multipliers and
//! the unknowns. Numbers are exact.

use super::branch::{OrbitPoint, Special};
use super::conditions::Condition;
use super::orbit::{Orbit, Stability};
use super::path::{self, PathEnd};
use super::step::{Departure, follow};
use crate::label::Label;
use crate::obstacle::Obstacle;
use crate::path_options::PathOptions;
use nalgebra::{Complex, DVector};
use std::fmt::Write;
use std::hash::{DefaultHasher, Hash, Hasher};

/// Where followed paths are kept. Failures to keep or to find one are no errors: the path is
/// followed anew.
pub trait KeptPaths: Sync {
    /// The text of a path.
    fn find(&self, key: u64) -> Option<String>;
    /// Keeps the text of a path.
    fn keep(&self, key: u64, text: &str);
}

/// Keeps nothing.
impl KeptPaths for () {
    fn find(&self, _: u64) -> Option<String> {
        None
    }

    fn keep(&self, _: u64, _: &str) {}
}

type Path = path::Path<Condition>;

const STABILITIES: [Stability; 4] =
    [Stability::Stable, Stability::Unstable, Stability::Neutral, Stability::Undecided];

/// The path of a departure: kept, or followed and kept.
pub(super) fn path(
    departure: &Departure,
    options: &PathOptions,
    kept: &dyn KeptPaths,
) -> Result<Path, Obstacle> {
    let key = key(departure, options);
    if let Some(path) = kept.find(key).and_then(|text| read(departure, &text)) {
        return Ok(path);
    }
    let path = follow(departure, options)?;
    if let Some(text) = written(departure, &path) {
        kept.keep(key, &text);
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

/// The text of a path; `None` for an end that it does not tell.
fn written(departure: &Departure, path: &Path) -> Option<String> {
    let mut text = match &path.end {
        PathEnd::Plain => "plain\n".to_owned(),
        PathEnd::Closed => "closed\n".to_owned(),
        PathEnd::At(condition) => {
            let orbit = orbit(departure, path.points.last()?)?;
            let place = orbit.conditions().iter().position(|own| own.0 == *condition)?;
            format!("broken {place}\n")
        }
    };
    for point in &path.points {
        let special = point.special.as_ref();
        let (kind, element) = special.map_or(("", ""), |own| (own.label.name(), own.element.as_str()));
        // Writing to a text cannot fail.
        let _ =
            write!(text, "{:?}\t{:?}\t{}\t{kind}\t{element}\t", point.value, point.period, point.stability);
        point.multipliers.iter().for_each(|m| _ = write!(text, "{:?} {:?} ", m.re, m.im));
        text.push('\t');
        point.u.iter().for_each(|x| _ = write!(text, "{x:?} "));
        text.push('\n');
    }
    Some(text)
}

fn orbit(departure: &Departure, point: &OrbitPoint) -> Option<Orbit> {
    let problem = departure.of.clone();
    let place = problem.place(&point.u).ok()?;
    Orbit::at(problem, place, point.u.clone()).ok()
}

/// The path of a text; `None` for a text that is damaged or of other unknowns.
fn read(departure: &Departure, text: &str) -> Option<Path> {
    let (end, lines) = text.split_once('\n')?;
    let points: Vec<OrbitPoint> = lines.lines().map(point).collect::<Option<_>>()?;
    let last = points.last()?;
    if !text.ends_with('\n') || points.iter().any(|point| point.u.len() != departure.u.len()) {
        return None;
    }
    let end = match end {
        "plain" => PathEnd::Plain,
        "closed" => PathEnd::Closed,
        broken => {
            let place: usize = broken.strip_prefix("broken ")?.parse().ok()?;
            PathEnd::At(orbit(departure, last)?.conditions().get(place)?.0)
        }
    };
    Some(Path { points, end })
}

fn point(line: &str) -> Option<OrbitPoint> {
    let cells: Vec<&str> = line.split('\t').collect();
    let [value, period, stability, kind, element, multipliers, u] = cells[..] else { return None };
    let numbers =
        |text: &str| -> Option<Vec<f64>> { text.split_whitespace().map(|x| x.parse().ok()).collect() };
    let pairs = numbers(multipliers)?;
    let label = match kind {
        "" => None,
        name => Some(Label::find(name)?),
    };
    Some(OrbitPoint {
        value: value.parse().ok()?,
        period: period.parse().ok()?,
        multipliers: pairs.chunks_exact(2).map(|pair| Complex::new(pair[0], pair[1])).collect(),
        stability: STABILITIES.into_iter().find(|own| own.to_string() == stability)?,
        special: label.map(|label| Special::new(label, element)),
        u: DVector::from_vec(numbers(u)?),
    })
}
