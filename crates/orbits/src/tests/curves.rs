//! Curves of special points over two parameters against closed forms.

use super::closed_forms::wall;
use super::*;
use crate::LocusEnd;
use std::f64::consts::PI;
use vibro_impact::parameters::{Groups, Scales};
use vibro_impact::steady::Sheet;
use vibro_impact::steady::exact_orbit::OrbitFamily;

/// Tolerance for a touch.
const ROUNDING: f64 = 1e-11;
/// Tolerances for the symmetric orbit's discriminant, which is of order one over the curve, and
/// for a multiplier at a simple crossing, both magnified by the special point's own condition.
const DISCRIMINANT: f64 = 1e-9;
const MULTIPLIER: f64 = 1e-8;
/// The load of f10 = 1, N.
const LOAD: f64 = 0.1;

/// The curve of the first special point of a kind on some branches, over a second parameter.
fn curve(
    branches: &[Branch],
    (kind, events): (&str, usize),
    machine: &Machine,
    second: (&str, [f64; 2]),
) -> Vec<LocusPoint> {
    let second = Family::new(machine, second.0, (second.1[0], second.1[1])).unwrap();
    let is_own = |p: &OrbitPoint| p.special.as_ref().is_some_and(|s| s.label.name() == kind);
    let own = branches.iter().filter(|b| b.word().len() == events);
    let starts = own.flat_map(|b| (0..b.points.len()).filter(|k| is_own(&b.points[*k])).map(move |k| (b, k)));
    let kinds = || {
        let all = branches.iter().flat_map(|b| b.points.iter().map(move |p| (b.word().len(), p)));
        all.filter_map(|(n, p)| Some((n, p.special.clone()?.label.name(), p.value))).collect::<Vec<_>>()
    };
    let (branch, point) = starts.into_iter().next().unwrap_or_else(|| panic!("{kind}: {:?}", kinds()));
    locus(&branch.locus_start(point).unwrap(), &second).unwrap()
}

/// Checks that a curve ends only at the bounds of its second parameter.
fn check_ends(points: &[LocusPoint], bounds: [f64; 2]) {
    let ends: Vec<_> = points.iter().filter_map(|p| p.end).collect();
    assert!(ends.iter().all(|end| matches!(end, LocusEnd::Range)), "{ends:?}");
    let reached = |end: f64| points.iter().any(|p| (p.values[1] - end).abs() < 1e-9);
    assert!(bounds.into_iter().all(reached), "{:?}", points.first().zip(points.last()));
}

#[test]
fn closed_form_graze_of_an_oscillator_over_force_and_frequency() {
    let m = wall("0.8");
    let family = Family::new(&m, "load.drive.amplitude", (0.2, 0.6)).unwrap();
    let bounds = [0.75, 0.85].map(|omega| omega / (2.0 * PI));
    let points = curve(&grown(&family, 8, 0), ("GR", 0), &m, ("load.drive.frequency", bounds));
    check_ends(&points, bounds);
    assert!(points.len() > 10, "{}", points.len());
    for point in points {
        let omega = 2.0 * PI * point.values[1];
        let force = (1.0 - omega * omega).hypot(0.04 * omega);
        assert!((point.values[0] - force).abs() < ROUNDING, "{point:?} {force}");
    }
}

#[test]
fn published_flip_and_fold_lie_on_curves_over_force_and_frequency() {
    // From ω = 0.805 the flip of the orbit with one impact in two periods reaches ω = 0.81 at
    // F = 0.3475334; from ω = 0.797 its fold reaches ω = 0.799 at F = 0.3628362.
    for (omega, kind, end, force) in [("0.805", "PD", 0.81, 0.3475334), ("0.797", "LP", 0.799, 0.3628362)] {
        let m = wall(omega);
        let family = Family::new(&m, "load.drive.amplitude", (0.33, 0.4)).unwrap();
        let begin: f64 = omega.parse().unwrap();
        let mut bounds = [begin, end];
        bounds.sort_by(f64::total_cmp);
        let bounds = bounds.map(|omega| omega / (2.0 * PI));
        let points = curve(&grown(&family, 8, 2), (kind, 1), &m, ("load.drive.frequency", bounds));
        let at = points.iter().find(|p| (2.0 * PI * p.values[1] - end).abs() < 1e-9);
        assert!((at.unwrap().values[0] - force).abs() < 1e-7, "{kind}: {at:?}");
    }
}

/// The paper's machine with one restitution for both stops.
fn paper() -> Machine {
    let text = std::fs::read_to_string(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../examples/assembly/paper_machine.toml"
    ));
    let named = text.unwrap().replace("restitution = 0.75", "restitution = \"= e\"");
    machine(&format!("{named}\n[parameters]\ne = 0.75\n"))
}

#[test]
fn closed_form_fold_crossing_and_pair_of_the_papers_symmetric_orbit() {
    let m = paper();
    let family = Family::new(&m, "load.drive.amplitude", (0.03, 0.35)).unwrap();
    let branches = grown(&family, 12, 1);
    let bounds = [0.7, 0.8];
    for kind in ["LP", "BP", "NS"] {
        let points = curve(&branches, (kind, 2), &m, ("e", bounds));
        assert!(points.len() > 5, "{kind}: {}", points.len());
        check_ends(&points, bounds);
        for point in &points {
            let groups = Groups { f10: point.values[0] / LOAD, kappa: point.values[1], ..Groups::basic() };
            let exact = OrbitFamily::new(&groups.to_parameters(Scales::default()).unwrap()).unwrap();
            if kind == "LP" {
                assert!(exact.discriminant().abs() < DISCRIMINANT, "{point:?} {:e}", exact.discriminant());
                continue;
            }
            let orbit = exact.orbit(Sheet::Upper).unwrap().unwrap();
            let off = |m: &nalgebra::Complex<f64>| match kind {
                "BP" => (m + 1.0).norm(),
                _ if m.im == 0.0 => 1.0,
                _ => (m.norm() - 1.0).abs(),
            };
            let nearest = orbit.multipliers().iter().map(off).fold(1.0, f64::min);
            assert!(nearest < MULTIPLIER, "{kind} at {point:?}: {nearest:e}");
        }
    }
}

#[test]
fn invariant_a_special_point_is_found_again_from_an_orbit_beside_it() {
    let m = wall("0.8");
    let family = Family::new(&m, "load.drive.amplitude", (0.33, 0.4)).unwrap();
    let branches = grown(&family, 8, 2);
    let mut compared = 0;
    for branch in &branches {
        for (k, point) in branch.points.iter().enumerate() {
            if branch.locus_start(k).is_none() {
                continue;
            }
            let Some(beside) = branch.beside(k) else { continue };
            let there =
                Family::new(&family.at(beside.value()).unwrap(), &family.parameter, family.range).unwrap();
            let orbit = Orbit::near(&there.machine, &beside.start(), beside.period()).unwrap();
            let special = point.special.as_ref().unwrap();
            let found = LocusStart::find(&there, &orbit, special, point.value).unwrap();
            assert_eq!(found.special, *special);
            compared += 1;
        }
    }
    assert!(compared > 5, "{compared}");
}
