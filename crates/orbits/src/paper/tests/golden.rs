//! Special points of all types against 30 digits (`crates/orbits/tests/data/make_orbits.py`).

use crate::paper::orbit::{canonical, same_phases};
use crate::paper::{Family, Orbit, OrbitWord, PathOptions, Span, branch};
use vibro_studies::paper::{ParameterSet, find_group};

/// Tolerance for a located parameter: rounding of the residual over the sensitivity of the
/// condition.
const LOCATION: f64 = 2e-13;
/// Tolerance for the phases; at a fold they move with the square root of the parameter.
const PHASES: f64 = 2e-11;
/// Distances from the point, in f10, at which its branch is entered, and to which followed.
const ENTRY: f64 = 1e-3;
const REACH: f64 = 0.02;
/// Tolerance for the phases of the orbit at the branch's entry, compared with the point's, rad.
const NEAR: f64 = 0.3;

#[test]
fn golden_orbits_in_thirty_digits() {
    let table = include_str!("../../../tests/data/orbits.csv");
    let mut count = 0;
    for line in table.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let [label, letters, closing, half, f10, phases] = cells[..] else { panic!("{line}") };
        let word = OrbitWord::new(letters, closing.parse().unwrap(), half.parse().unwrap()).unwrap();
        let value: f64 = f10.parse().unwrap();
        let phases: Vec<f64> = phases.split(' ').map(|x| x.parse().unwrap()).collect();
        let span = Span::new(find_group("f10").unwrap(), value - REACH, value + REACH).unwrap();
        let family = Family::new(&ParameterSet::basic(), span).unwrap();
        // On one side of a fold or a touch there is no orbit. At a fold Newton's method needs a
        // perturbed guess.
        let pushed = |k: usize, by: f64| -> Vec<f64> {
            phases.iter().enumerate().map(|(i, p)| if i == k { p + by } else { *p }).collect()
        };
        let guesses = (0..word.len()).flat_map(|k| [0.0, 0.03, -0.03].map(|by| pushed(k, by)));
        let entries = guesses.flat_map(|guess| [ENTRY, -ENTRY].map(|by| (value + by, guess.clone())));
        let near = |orbit: &Orbit| orbit.phases().iter().zip(&phases).all(|(a, b)| (a - b).abs() < NEAR);
        let mut entry = entries.filter_map(|(at, guess)| {
            let orbit = Orbit::find(&family.system(&[at]).unwrap(), &word, &guess).ok()?;
            (orbit.is_certified() && near(&orbit)).then(|| (at, orbit.phases().to_vec()))
        });
        let (at, guess) = entry.next().unwrap_or_else(|| panic!("no orbit beside {line}"));
        let options = PathOptions { longest_step: 0.01, ..PathOptions::default() };
        let found = branch(&family, &word, &guess, at, &options, &[]).unwrap();
        let named = found.points.iter().filter(|p| p.label().is_some_and(|l| l.name() == label));
        let nearest = named.min_by(|a, b| (a.value - value).abs().total_cmp(&(b.value - value).abs()));
        let point = nearest.unwrap_or_else(|| {
            panic!(
                "no {label} of {letters} near {value}: {:?}",
                found
                    .points
                    .iter()
                    .filter(|p| p.label().is_some())
                    .map(|p| (p.label(), p.value))
                    .collect::<Vec<_>>()
            )
        });
        assert!((point.value - value).abs() < LOCATION, "{label} {letters}: {:e}", point.value - value);
        let (canonical, golden) = canonical(&word, &phases, true);
        assert!(
            same_phases(&canonical, &golden, point.phases(), true, PHASES),
            "{label} {letters}: {:?} {golden:?}",
            point.phases()
        );
        count += 1;
    }
    assert!(count >= 12, "{count} points");
}
