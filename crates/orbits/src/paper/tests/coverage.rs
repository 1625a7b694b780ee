//! Stable branches against the rows of a simulated diagram.

use crate::paper::{Family, Span, Tree, TreeOptions, tree};
use vibro_studies::diagram::diagram;
use vibro_studies::paper::bifurcation::{Sweep, SweepPoint};
use vibro_studies::paper::maxima::Displacement;
use vibro_studies::paper::plane::ParameterAxis;
use vibro_studies::paper::{ParameterSet, find_group};
use vibro_studies::parts::Task;

/// Discarded periods of the diagram; the rest of a transient is then within a return's tolerance.
const DISCARD: u32 = 1500;

fn family(from: f64, to: f64) -> Family {
    let span = Span::new(find_group("f10").unwrap(), from, to).unwrap();
    Family::new(&ParameterSet::basic(), span).unwrap()
}

/// Periodic rows without rest of a simulated diagram, in both directions.
fn rows(from: f64, to: f64, count: usize) -> Vec<SweepPoint> {
    let axis = ParameterAxis::new(find_group("f10").unwrap(), (from, to), count).unwrap();
    let sweep = Sweep::new(axis, Displacement::X2, (DISCARD, 0));
    let found = diagram(&ParameterSet::basic(), &sweep, &Task::ALL).unwrap().unwrap();
    let rows = found.up.into_iter().chain(found.down).flatten();
    rows.filter(|row| row.attractor.period.is_some() && !row.attractor.rests).collect()
}

/// Rows that are not on a stable branch.
fn uncovered(tree: &Tree, family: &Family, rows: &[SweepPoint]) -> Vec<(f64, Option<u32>)> {
    let covered = |row: &&SweepPoint| tree.covering(family, row.value, &row.attractor).unwrap().is_none();
    rows.iter().filter(covered).map(|row| (row.value, row.attractor.period)).collect()
}

#[test]
fn second_method_periodic_rows_of_a_diagram_lie_on_stable_branches() {
    let family = family(2.0, 2.8);
    let options = TreeOptions { seeds: 9, settle: 600, starts: 0, depth: 3, ..TreeOptions::default() };
    let found = tree(&family, &options, &|_, _| ()).unwrap();
    // The values differ from the seeds' values.
    let rows = rows(2.013, 2.79, 25);
    assert!(rows.len() > 25, "{}", rows.len());
    assert_eq!(uncovered(&found, &family, &rows), []);
    // The branch also covers the mirror image, but not a motion some distance away.
    for row in &rows {
        let here = found.covering(&family, row.value, &row.attractor).unwrap().unwrap();
        let mut image = row.attractor.clone();
        std::mem::swap(&mut image.states, &mut image.mirror_states);
        let there = found.covering(&family, row.value, &image).unwrap().unwrap();
        assert_eq!((here.branch, here.orbit.word()), (there.branch, there.orbit.word()));
        image.states.iter_mut().for_each(|state| state[1] += 2.0 * Tree::SETTLED_DISTANCE);
        assert!(found.covering(&family, row.value, &image).unwrap().is_none());
    }
    // Without its branches the tree covers nothing.
    let empty = Tree::default();
    assert_eq!(uncovered(&empty, &family, &rows).len(), rows.len());
}
