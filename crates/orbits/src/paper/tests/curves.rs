//! Curves of special points in two parameters against the closed form, and their ends.

use super::branches::{family, labelled, machine, settled_branch, symmetric};
use crate::paper::{Family, Label, LocusEnd, LocusStart, OrbitPoint, PathOptions, Span, branch, locus};
use vibro_impact::parameters::{Groups, Scales};
use vibro_impact::steady::Sheet;
use vibro_impact::steady::exact_orbit::OrbitFamily;
use vibro_studies::paper::{ParameterSet, find_field, find_group};

/// The curve of a special point of the symmetric branch over force and restitution coefficient,
/// starting from a value of the restitution coefficient.
fn curve(label: Label, kappa: f64, [from, to]: [f64; 2]) -> Vec<crate::paper::LocusPoint> {
    let [f10, second] = ["f10", "kappa"].map(|name| find_group(name).unwrap());
    let set = ParameterSet::basic().with(second, kappa).unwrap();
    let one = Family::new(&set, Span::new(f10, 0.3, 3.0).unwrap()).unwrap();
    let found = branch(&one, &symmetric(), &[5.5], 1.5, &PathOptions::default(), &[]).unwrap();
    let point = labelled(&found, label).next().unwrap();
    let [first, second] =
        [(f10, 0.3, 3.0), (second, from, to)].map(|(n, from, to)| Span::new(n, from, to).unwrap());
    let two = Family::over_two(&set, first, second).unwrap();
    let start = LocusStart {
        label,
        word: symmetric(),
        phases: point.phases().to_vec(),
        values: [point.value, kappa],
    };
    locus(&two, &start).unwrap()
}

/// The closed form at a point of such a curve.
fn exact(values: [f64; 2]) -> OrbitFamily {
    let groups = Groups { f10: values[0], kappa: values[1], ..Groups::basic() };
    OrbitFamily::new(&groups.to_parameters(Scales::default()).unwrap()).unwrap()
}

#[test]
fn closed_form_of_curves_in_two_parameters() {
    /// Tolerance for the rounding of the discriminant, which is of order one over the curve.
    const ROUNDING: f64 = 1e-11;
    /// Tolerance for a multiplier at a simple crossing.
    const MULTIPLIER: f64 = 1e-9;
    for label in [Label::Fold, Label::BranchPoint, Label::NeimarkSacker, Label::Grazing] {
        let points = curve(label, 0.75, [0.6, 0.9]);
        assert!(points.len() > 10, "{label}: {}", points.len());
        let reached = |end: f64| points.iter().any(|p| (p.values[1] - end).abs() < 1e-9);
        assert!(reached(0.6) && reached(0.9), "{label}: {:?}", points.first().zip(points.last()));
        for point in &points {
            let exact = exact(point.values);
            match label {
                Label::Fold => assert!(exact.discriminant().abs() < ROUNDING, "{:e}", exact.discriminant()),
                Label::Grazing => {
                    let groups = Groups { f10: point.values[0], kappa: point.values[1], ..Groups::basic() };
                    let p = groups.to_parameters(Scales::default()).unwrap();
                    let amplitude = crate::paper::System::new(&p).unwrap().amplitude();
                    assert!((amplitude - 1.0).abs() < ROUNDING);
                }
                _ => {
                    let orbit = exact.orbit(Sheet::Upper).unwrap().unwrap();
                    let crossing = |m: &nalgebra::Complex<f64>| match label {
                        Label::BranchPoint => (m + 1.0).norm(),
                        _ => {
                            if m.im == 0.0 {
                                1.0
                            } else {
                                (m.norm() - 1.0).abs()
                            }
                        }
                    };
                    let nearest = orbit.multipliers().iter().map(crossing).fold(1.0, f64::min);
                    assert!(nearest < MULTIPLIER, "{label} at {:?}: {nearest:e}", point.values);
                }
            }
        }
        assert!(points.iter().all(|p| p.end != Some(LocusEnd::NoConvergence)));
    }
}

/// Beyond the bounds of a parameter there is no machine, and differences become one-sided. A curve
/// reaches the bounds, and may begin there.
#[test]
fn closed_form_curves_run_to_the_bounds_of_a_parameter_and_begin_there() {
    /// Tolerance for the rounding of the discriminant, which is of order one over the curve.
    const ROUNDING: f64 = 1e-11;
    for kappa in [0.75, 1.0] {
        for label in [Label::Fold, Label::NeimarkSacker] {
            let points = curve(label, kappa, [0.5, 1.0]);
            let ends = [&points[0], &points[points.len() - 1]];
            assert!(ends.iter().all(|end| end.end == Some(LocusEnd::Range)), "{label} {kappa} {ends:?}");
            assert!(
                points.len() > 10 && ends.iter().any(|end| end.values[1] == 1.0),
                "{label} {kappa} {ends:?}"
            );
            let off = |p: &crate::paper::LocusPoint| exact(p.values).discriminant().abs();
            assert!(label != Label::Fold || points.iter().all(|p| off(p) < ROUNDING), "{kappa}");
        }
    }
}

#[test]
fn starts_of_curves_that_cannot_be_are_refused() {
    let one = family(0.5, 3.0);
    let [first, second] = [("f10", 0.5, 3.0), ("kappa", 0.6, 0.9)]
        .map(|(name, from, to)| Span::new(find_group(name).unwrap(), from, to).unwrap());
    let two = Family::over_two(&ParameterSet::basic(), first, second).unwrap();
    let start = |label, values| LocusStart { label, word: symmetric(), phases: vec![5.5], values };
    for (family, start) in [
        (&two, start(Label::EndPoint, [1.5, 0.75])),
        (&two, start(Label::PeriodDoubling, [1.5, 0.75])),
        (&two, start(Label::Fold, [4.0, 0.75])),
        (&one, start(Label::Fold, [1.5, 0.75])),
    ] {
        assert!(matches!(locus(family, &start), Err(vibro_studies::Error::Form { .. })), "{start:?}");
    }
    assert!(Family::over_two(&ParameterSet::basic(), first, first).is_err());
    assert!(Span::new(find_group("kappa").unwrap(), 0.5, 1.5).is_err());
}

/// At the resonance where the multipliers of a Neimark-Sacker point meet at 1, one equation of its
/// curve vanishes: the curve ends there with R1, not with MX.
#[test]
fn invariant_a_curve_ends_at_the_resonance_to_which_it_comes() {
    const BOX: f64 = 0.1;
    let set = machine(&[
        ("stop.restitution", 0.325_289_286_605_822_74),
        ("drive.amplitude", 0.509_177_306_066_417_9),
    ]);
    let spans = [("drive.amplitude", 0.2825, 0.7411), ("box.c", 0.083_86, 0.171_425)]
        .map(|(name, from, to)| Span::new(find_field(name).unwrap(), from, to).unwrap());
    let one = settled_branch(&set, "drive.amplitude", (spans[0].from, spans[0].to), 0.509_177_306_066_417_9);
    let two = Family::over_two(&set, spans[0], spans[1]).unwrap();
    let points: Vec<&OrbitPoint> = labelled(&one, Label::NeimarkSacker).collect();
    assert!(!points.is_empty());
    for point in points {
        let start = LocusStart {
            label: Label::NeimarkSacker,
            word: one.word().clone(),
            phases: point.phases().to_vec(),
            values: [point.value, BOX],
        };
        let curve = locus(&two, &start).unwrap();
        let ends = [&curve[0], &curve[curve.len() - 1]];
        let resonant: Vec<_> = ends.iter().filter(|p| p.end == Some(LocusEnd::Resonance(1))).collect();
        assert!(
            !resonant.is_empty() && ends.iter().all(|p| p.end != Some(LocusEnd::NoConvergence)),
            "{ends:?}"
        );
        assert!(resonant.iter().all(|p| p.angle.is_some_and(|angle| angle < 1e-2)), "{ends:?}");
    }
}
