//! The paper's machine as a file against the orbits of the 3-DOF machine. Their equations in
//! impact phases share no code with the equations of described machines.

use super::*;
use crate::paper::{Label, Span, TreeOptions as Options};
use vibro_studies::paper::{ParameterSet, find_group};

/// Largest difference of a special point's load, N.
const SAME: f64 = 1e-9;
/// The load of f10 = 1, N.
const LOAD: f64 = 0.1;
/// Relative tolerance for equal periods: rounding.
const ROUNDING: f64 = 1e-12;
/// Distance within which a touch and a bifurcation count as one point.
const MERGED: f64 = 1e-8;

#[test]
fn second_method_special_points_of_the_papers_machine() {
    let family = Family::new(&example("paper_machine.toml"), "load.drive.amplitude", (0.19, 0.35)).unwrap();
    let own = grown(&family, 6, 1);
    let span = Span::new(find_group("f10").unwrap(), 1.9, 3.5).unwrap();
    let closed = crate::paper::Family::new(&ParameterSet::basic(), span).unwrap();
    let options = Options { seeds: 6, settle: 400, starts: 0, depth: 2, ..Options::default() };
    let theirs = crate::paper::tree(&closed, &options, &|_, _| ()).unwrap();
    let mut compared = 0;
    for (label, name) in [
        (Label::Fold, "LP"),
        (Label::PeriodDoubling, "PD"),
        (Label::NeimarkSacker, "NS"),
        (Label::BranchPoint, "BP"),
        (Label::Grazing, "GR"),
    ] {
        let points = theirs.branches.iter().flat_map(|b| &b.points);
        let known: Vec<f64> = points.filter(|p| p.label() == Some(label)).map(|p| LOAD * p.value).collect();
        let touches: Vec<f64> = specials_of(&own, "GR");
        for value in specials_of(&own, name) {
            if name != "GR" && nearest(&touches, value) < MERGED {
                continue;
            }
            assert!(nearest(&known, value) < SAME, "{name} {value}: {known:?}");
            compared += 1;
        }
    }
    assert!(compared > 15, "{compared}");
    let theirs: Vec<&OrbitPoint> = theirs.branches.iter().flat_map(|b| &b.points).collect();
    for fold in own.iter().flat_map(|b| &b.points).filter(|p| p.label() == Some(Label::Fold)) {
        let is_one =
            |p: &&&OrbitPoint| p.label() == fold.label() && (LOAD * p.value - fold.value).abs() < SAME;
        let has_period = |p: &&OrbitPoint| (p.period / fold.period - 1.0).abs() < ROUNDING;
        assert!(theirs.iter().filter(is_one).any(has_period), "{fold:?}");
    }
    // The condition of each point, in the shortest word of its orbit, is zero there too.
    let starts = own.iter().flat_map(|branch| {
        let of = |k| Some((branch.locus_start(k)?, branch.points[k].value));
        (0..branch.points.len()).filter_map(of).collect::<Vec<_>>()
    });
    let starts: Vec<_> = starts.collect();
    let apart = |(start, value): &(LocusStart, f64)| {
        let again = start.located_again();
        (start.special.label.name(), *value, again.map(|again| (again - value).abs()))
    };
    let found: Vec<_> = starts.iter().map(apart).collect();
    let wrong: Vec<_> = found.iter().filter(|own| own.2.is_none_or(|apart| apart > SAME)).collect();
    assert!(found.len() > 20 && wrong.is_empty(), "{wrong:?} of {}", found.len());
}

fn specials_of(branches: &[Branch], kind: &str) -> Vec<f64> {
    (0..40).flat_map(|events| specials(branches, events, kind)).collect()
}

#[test]
fn invariant_half_the_step_gives_the_same_special_points() {
    let family = Family::new(&example("paper_machine.toml"), "load.drive.amplitude", (0.19, 0.35)).unwrap();
    let whole = grown(&family, 6, 0);
    let longest_step = 0.5 * crate::PathOptions::default().longest_step;
    let path = crate::PathOptions { longest_step, ..crate::PathOptions::default() };
    let options = TreeOptions { seeds: 6, depth: 0, path, ..TreeOptions::default() };
    let half = tree(&family, &options, &mut |_, _| true).unwrap();
    let mut compared = 0;
    for name in ["LP", "PD", "NS", "BP", "GR"] {
        let (own, other) = (specials_of(&whole, name), specials_of(&half, name));
        for (values, known) in [(&own, &other), (&other, &own)] {
            for value in values {
                assert!(nearest(known, *value) < SAME, "{name} {value}: {known:?}");
                compared += 1;
            }
        }
    }
    assert!(compared > 10, "{compared}");
}
