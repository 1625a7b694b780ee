//! The paper's machine as a file against the orbits of the 3-DOF machine: closed equations in phases
//! of impacts, which share no code with those of described machines.

use super::*;
use crate::{Label, Span, TreeOptions as Options};
use vibro_analysis::{ParameterSet, find_group};

/// Largest difference of a special point's load, N.
const SAME: f64 = 1e-9;
/// The load of f10 = 1, N.
const LOAD: f64 = 0.1;
/// A touch within this of a bifurcation is one with it.
const MERGED: f64 = 1e-8;

#[test]
fn second_method_special_points_of_the_papers_machine() {
    let family = Family::new(&example("paper_machine.toml"), "load.drive.amplitude", (0.19, 0.35)).unwrap();
    let own = grown(&family, 6, 1);
    let span = Span::new(find_group("f10").unwrap(), 1.9, 3.5).unwrap();
    let closed = crate::Family::new(&ParameterSet::basic(), span).unwrap();
    let options = Options { seeds: 6, settle: 400, starts: 0, depth: 2, ..Options::default() };
    let theirs = crate::tree(&closed, &options, &|_, _| ()).unwrap();
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
}

fn specials_of(branches: &[Branch], kind: &str) -> Vec<f64> {
    (0..40).flat_map(|events| specials(branches, events, kind)).collect()
}
