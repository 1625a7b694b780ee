//! Special points in the same step as a start, an end or each other.

use super::closing::ball;
use super::steps::{meissner, meissners_test};
use super::*;
use crate::path::{PathEnd, closes};
use crate::step::{Departure, follow};
use nalgebra::DVector;
use vibro_machine::Start;

/// Tolerance for a special point's parameter.
const LOCATED: f64 = 1e-10;

/// The parameter values of the special points of a kind on a path.
fn values(points: &[OrbitPoint], kind: &str) -> Vec<f64> {
    let own = points.iter().filter(|p| p.special.as_ref().is_some_and(|s| s.label.name() == kind));
    own.map(|p| p.value).collect()
}

/// The point of a branch at a value, and the direction in which the branch leaves it; for `sign` 1
/// with increasing parameter.
fn departure(branch: &Branch, value: f64, sign: f64) -> Departure {
    let orbit = branch.orbits_at(value).pop().unwrap();
    let axis = crate::curve::axis(orbit.u.len(), orbit.u.len() - 1);
    let direction = crate::curve::tangent(&orbit.problem, &orbit.u, &axis).unwrap();
    let rises = direction[direction.len() - 1].signum();
    Departure {
        of: orbit.problem.clone(),
        u: orbit.u.clone(),
        direction: direction * (sign * rises),
        step: 0.05,
        special: None,
    }
}

/// The flip of a ball on a table in the first step of a path from a special point.
#[test]
fn closed_form_a_flip_in_the_first_step_from_a_special_point() {
    let (branch, flip) = ball();
    let mut start = departure(&branch, 0.997 * flip, 1.0);
    start.special = Some(Special::new(crate::Label::Grazing, ""));
    let points = follow(&start, &Default::default()).unwrap().points;
    let found = values(&points, "PD");
    assert!(nearest(&found, flip) < LOCATED, "{found:?} {flip}");
    // The start has the stability of the piece before the flip; the flip, of the piece after it.
    assert_eq!([points[0].stability, points[1].stability], [Stability::Stable, Stability::Unstable]);
}

/// The published flip of an oscillator with a wall in the step that ends at its touch.
#[test]
fn published_flip_in_the_last_step_before_a_touch() {
    let (force, digits) = (0.3475334, 1e-7);
    let family = Family::new(&closed_forms::wall("0.81"), "load.drive.amplitude", (0.33, 0.4)).unwrap();
    let branches = grown(&family, 8, 2);
    let own =
        branches.iter().find(|b| b.word().len() == 1 && nearest(&values(&b.points, "PD"), force) < digits);
    let start = Departure { step: 0.2, ..departure(own.unwrap(), force + 1e-5, -1.0) };
    let options = crate::PathOptions { longest_step: 0.2, ..Default::default() };
    let path = follow(&start, &options).unwrap();
    assert!(matches!(path.end, PathEnd::At(_)), "{:?}", path.points.last());
    let plain = path.points.iter().filter(|p| p.special.is_none()).count();
    let found = values(&path.points, "PD");
    assert!(nearest(&found, force) < digits && plain <= 1, "{found:?}, {plain} plain points");
}

/// A circle closes only in the step that passes its first point. A helix, which passes it at a
/// distance, does not close.
#[test]
fn closed_form_a_circle_closes_and_a_helix_does_not() {
    let steps = 40.5;
    let at = |k: u32, pitch: f64| {
        let (angle, turn) = (std::f64::consts::TAU * f64::from(k) / steps, f64::from(k) / steps);
        let u = DVector::from_vec(vec![angle.cos(), angle.sin(), pitch * turn]);
        (u, DVector::from_vec(vec![-angle.sin(), angle.cos(), pitch]).normalize())
    };
    for pitch in [0.0, 0.02] {
        let (first, begins) = at(0, pitch);
        let is_loop = |k: &u32| {
            let (next, tangent) = at(k + 1, pitch);
            closes((&first, &begins), [&at(*k, pitch).0, &next], &tangent)
        };
        let closed: Vec<u32> = (1..60).filter(is_loop).collect();
        assert_eq!(closed, if pitch == 0.0 { vec![40] } else { Vec::new() });
    }
}

#[test]
fn closed_form_the_extremum_of_a_parabola() {
    let at = |x: f64| (x, 3.0 * (x - 0.3).powi(2) - 0.02);
    let (place, value) = crate::hidden::extremum(&[at(-1.0), at(0.4), at(1.4)]).unwrap();
    assert!((place - 0.3).abs() < 1e-14 && (value + 0.02).abs() < 1e-14, "{place} {value}");
    assert_eq!(crate::hidden::extremum(&[(0.0, 1.0), (1.0, 2.0), (3.0, 4.0)]), None);
}

/// The two flips of Meissner's oscillator at the tip of a tongue, within one step of each other.
#[test]
fn closed_form_two_flips_within_one_step() {
    /// Values of the stiffness on both sides of the tongue.
    const SIDES: (f64, f64) = (4.5, 7.0);
    /// Value of the test at the tip: the flips are 0.01 apart, and a step is 0.025 long.
    const OPEN: f64 = -5e-7;
    let period = 1.6;
    let tip = |damping: f64| {
        let (mut from, mut to) = SIDES;
        while to - from > 1e-9 {
            let thirds = [from + (to - from) / 3.0, to - (to - from) / 3.0];
            let [a, b] = thirds.map(|low| meissners_test(low, damping, period));
            if a < b { to = thirds[1] } else { from = thirds[0] }
        }
        0.5 * (from + to)
    };
    let (mut open, mut shut) = (0.2, 0.5);
    while shut - open > 1e-9 {
        let middle = 0.5 * (open + shut);
        if meissners_test(tip(middle), middle, period) < OPEN { open = middle } else { shut = middle }
    }
    let tip = tip(open);
    let root = |mut outer: f64| {
        let mut inner = tip;
        while f64::abs(outer - inner) > 1e-14 {
            let middle = 0.5 * (outer + inner);
            if meissners_test(middle, open, period) > 0.0 { outer = middle } else { inner = middle }
        }
        outer
    };
    let exact = [root(SIDES.0), root(SIDES.1)];
    assert!((0.001..0.02).contains(&(exact[1] - exact[0])), "{exact:?}");
    let family = Family::new(&meissner(SIDES.1, open, period), "low", SIDES).unwrap();
    let orbit = Orbit::settled(&family.machine, &Start::default(), 2000).unwrap();
    let found = values(&branch(&family, &orbit, &Default::default()).unwrap().points, "PD");
    assert!(exact.iter().all(|own| nearest(&found, *own) < 1e-8), "{found:?} {exact:?}");
}
