//! Stable ranges and sequences of doublings against the multipliers of the orbits in them.

use crate::paper::{Branch, Family, Label, Span, TreeOptions, doubling_ratios, doubling_sequences, tree};
use vibro_studies::paper::{ParameterSet, find_group};

/// Distance of a multiplier from the unit circle at an end of a range: the square root of the
/// rounding of the parameter, since two multipliers meet at a fold.
const ON_CIRCLE: f64 = 1e-5;

fn found() -> (Family, Vec<Branch>) {
    let span = Span::new(find_group("f10").unwrap(), 2.2, 2.86).unwrap();
    let family = Family::new(&ParameterSet::basic(), span).unwrap();
    let options = TreeOptions {
        seeds: 12,
        settle: 400,
        starts: 0,
        depth: 3,
        longest_period: 4,
        ..TreeOptions::default()
    };
    let branches = tree(&family, &options, &|_, _| ()).unwrap().branches;
    (family, branches)
}

#[test]
fn second_method_multipliers_are_inside_the_circle_in_a_stable_range_and_on_it_at_its_ends() {
    let (family, branches) = found();
    let mut checked = 0;
    for branch in &branches {
        for range in branch.stable_ranges() {
            let (first, last) = range.points;
            for point in &branch.points[first + 1..last] {
                let orbit = branch.orbit(&family, point).unwrap();
                assert!(orbit.is_stable() || point.special.is_some(), "{range:?}");
                if point.special.is_none() {
                    assert_eq!(branch.stable_range_of(&orbit, point.value), Some(range.clone()));
                }
            }
            for point in [first, last].map(|i| &branch.points[i]) {
                let crosses = [Label::Fold, Label::PeriodDoubling, Label::NeimarkSacker];
                if point.label().is_some_and(|label| crosses.contains(&label)) {
                    let radius = branch.orbit(&family, point).unwrap().spectral_radius();
                    assert!((radius - 1.0).abs() < ON_CIRCLE, "{radius} {range:?}");
                    checked += 1;
                }
            }
        }
    }
    assert!(checked > 8, "{checked}");
}

#[test]
fn doublings_follow_one_another_over_folds_and_births_are_none() {
    let (_, branches) = found();
    let sequences = doubling_sequences(&branches);
    // The range contains the asymmetric motion, and the motion with three impacts, whose doubled
    // branch has two folds.
    for (first, expected) in [
        (2.373_075_370_806, vec![(1, 2.373_075_370_806), (2, 2.493_021_660_408), (4, 2.511_747_833_602)]),
        (2.802_205_439_173, vec![(1, 2.802_205_439_173), (2, 2.835_209_901_315), (4, 2.848_740_511_358)]),
    ] {
        let sequence = sequences.iter().find(|s| (s[0].value - first).abs() < 1e-10).expect("a sequence");
        let places: Vec<(u32, f64)> = sequence.iter().map(|d| (d.period, d.value)).collect();
        assert_eq!(places.len(), expected.len(), "{places:?}");
        for (found, expected) in places.iter().zip(&expected) {
            assert!(found.0 == expected.0 && (found.1 - expected.1).abs() < 1e-10, "{places:?}");
        }
        let ratio = (expected[1].1 - expected[0].1) / (expected[2].1 - expected[1].1);
        assert!((doubling_ratios(sequence)[0] - ratio).abs() < 1e-8);
    }
    let once = |value: f64| sequences.iter().flatten().filter(|d| (d.value - value).abs() < 1e-9).count();
    assert!(sequences.iter().flatten().all(|d| once(d.value) == 1), "{sequences:?}");
}
