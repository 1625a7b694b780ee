//! Curves in two parameters from all special points of a tree.

use crate::paper::locus::start::{Normal, first_point};
use crate::paper::orbit::newton;
use crate::paper::{Branch, Family, Label, LocusStart, OrbitPoint, Span, Tree, TreeOptions, locus, tree};
use std::collections::BTreeMap;
use vibro_studies::paper::{Name, ParameterSet, find_group};

fn span(name: &str, from: f64, to: f64) -> Span {
    Span::new(Name::find(name).unwrap(), from, to).unwrap()
}

/// Special points of a tree from which curves start.
fn starts(tree: &Tree, held: f64) -> Vec<LocusStart> {
    let row = |b: &Branch, p: &OrbitPoint| {
        let label = p.label().filter(|label| Label::STARTS.contains(label))?;
        Some(LocusStart {
            label,
            word: b.word().clone(),
            phases: p.phases().to_vec(),
            values: [p.value, held],
        })
    };
    tree.branches.iter().flat_map(|b| b.points.iter().filter_map(move |p| row(b, p))).collect()
}

/// A located point is on its curve within rounding.
#[test]
fn invariant_every_special_point_of_a_tree_starts_its_curve() {
    /// Largest change caused by fifteen digits of a parameter, and of phases, which follow its
    /// square root at a fold.
    const MOVED: f64 = 1e-6;
    let set = ParameterSet::basic();
    let pulled = set.with(Name::find("load.block").unwrap(), -0.0005).unwrap();
    let f10 = |value: f64| set.with(find_group("f10").unwrap(), value).unwrap();
    let free = f10(2.2).with(Name::find("coupling.k").unwrap(), 0.0).unwrap();
    let cases = [
        (set.clone(), span("f10", 2.0, 3.2), span("kappa", 0.6, 0.9)),
        (f10(2.4), span("kappa", 0.6, 0.9), span("f10", 1.0, 4.0)),
        (f10(2.4), span("sigma1", -0.2, 1.0), span("f10", 1.0, 4.0)),
        (pulled, span("f10", 1.8, 2.6), span("kappa", 0.6, 0.9)),
        (free, span("drive.amplitude", 0.18, 0.30), span("stop.restitution", 0.6, 0.9)),
    ];
    let (mut good, mut bad) = (BTreeMap::<&str, usize>::new(), Vec::new());
    let mut folds_by_newton = 0;
    for (set, along, other) in cases {
        let one = Family::new(&set, along).unwrap();
        let options = TreeOptions {
            seeds: 7,
            settle: 500,
            starts: 0,
            depth: 3,
            longest_period: 8,
            ..TreeOptions::default()
        };
        let found = tree(&one, &options, &|_, _| ()).unwrap();
        let two = Family::over_two(&set, along, other).unwrap();
        let all = starts(&found, other.name.value(&set));
        for start in all {
            let begins = Normal::of(&two, &start).map_err(|e| e.to_string()).and_then(|normal| {
                let (_, u) = first_point(&two, &normal).map_err(|e| format!("{e:?}"))?;
                let moved = (two.values(&u)[0] - start.values[0]).abs() / along.unit();
                if moved < MOVED { Ok(()) } else { Err(format!("moved {moved:e}")) }
            });
            match begins {
                Ok(()) => *good.entry(start.label.name()).or_default() += 1,
                Err(why) => bad.push(format!(
                    "{} {} {}T {:?} {:?}: {why}",
                    start.label,
                    start.word,
                    start.word.period(),
                    start.values,
                    start.phases
                )),
            }
            // Newton's method at the parameter itself finds no fold, so the curve's own equations
            // are solved.
            let system = two.system(&start.values).unwrap();
            let direct = newton(&system, &start.word, &start.phases).is_ok();
            folds_by_newton += usize::from(start.label == Label::Fold && direct);
        }
    }
    assert!(bad.is_empty(), "{} of {good:?}: {}", bad.len(), bad.join("\n"));
    for label in ["LP", "BP", "PD", "NS", "GR"] {
        assert!(good.get(label).is_some_and(|n| *n >= 2), "{label}: {good:?}");
    }
    assert!(2 * folds_by_newton < good["LP"], "{folds_by_newton} of {good:?}");
}

#[test]
fn invariant_curves_start_from_folds_doublings_and_touches_of_either_branch() {
    let set = ParameterSet::basic();
    let (along, other) = (span("f10", 2.0, 2.6), span("kappa", 0.72, 0.78));
    let one = Family::new(&set, along).unwrap();
    let options = TreeOptions {
        seeds: 4,
        settle: 500,
        starts: 0,
        depth: 1,
        longest_period: 4,
        ..TreeOptions::default()
    };
    let found = tree(&one, &options, &|_, _| ()).unwrap();
    let two = Family::over_two(&set, along, other).unwrap();
    let all = starts(&found, 0.75);
    let mut curves: Vec<LocusStart> = Vec::new();
    let mut same = 0;
    for start in all {
        if curves.iter().any(|known| known.is_same(&start, &two).unwrap()) {
            same += 1;
            continue;
        }
        let points = locus(&two, &start.shortest(&two).unwrap()).unwrap();
        assert!(points.iter().any(|p| (p.values[1] - 0.75).abs() < 0.02), "{start:?}");
        curves.push(start);
    }
    // The point where a branch is born lies on two branches.
    assert!(same >= 2 && curves.len() >= 4, "{same} {}", curves.len());
}
