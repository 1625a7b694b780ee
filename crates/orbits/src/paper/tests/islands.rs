//! Stable windows that only other starts reach, not motions followed along the range.

use crate::paper::{Branch, Family, Orbit, Span, TreeOptions, tree};
use vibro_impact::Simulator;
use vibro_studies::paper::{ParameterSet, find_group};

/// Values in the two windows of period three of the default set, found from random starts.
const WINDOWS: [f64; 2] = [3.33, 3.84];

#[test]
fn second_method_both_windows_of_period_three_beside_chaos_are_found_and_stand_in_the_simulator() {
    /// Tolerance for the remaining difference after thousands of periods of a motion with decaying
    /// deviations.
    const RETURN: f64 = 1e-9;
    let span = Span::new(find_group("f10").unwrap(), 3.2, 3.95).unwrap();
    let family = Family::new(&ParameterSet::basic(), span).unwrap();
    let options = TreeOptions {
        seeds: 16,
        starts: 192,
        settle: 400,
        depth: 1,
        longest_period: 6,
        ..TreeOptions::default()
    };
    let found = tree(&family, &options, &|_, _| ()).unwrap();
    for value in WINDOWS {
        let stable = |b: &&Branch| {
            b.word().period() == 3
                && b.stable_ranges().iter().any(|r| r.from.value < value && value < r.to.value)
        };
        let branch = found.branches.iter().find(stable).unwrap_or_else(|| panic!("no window at {value}"));
        // The simulator stays on the orbit.
        let orbits = found.orbits_at(&family, value).unwrap();
        let own =
            orbits.iter().map(|o| (o.branch, &o.orbit)).find(|(id, o)| *id == branch.id && o.is_stable());
        let orbit: &Orbit = own.expect("an orbit of the branch").1;
        let (p, start) = (orbit.system().parameters(), orbit.start_state());
        let mut simulator = Simulator::new(p, &start, 0.0).unwrap();
        simulator.advance_to(3000.0 * p.period()).unwrap();
        let end = simulator.state();
        let apart = start.x.iter().zip(&end.x).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
        assert!(apart < RETURN, "{} at {value}: {apart:e}", orbit.word());
    }
    // The search reports its starts and islands.
    assert_eq!(found.searched.values.iter().map(|v| v.starts).sum::<u32>(), 192);
    assert!(found.searched.islands > 0 && found.searched.islands <= found.searched.followed);
    let without = tree(&family, &TreeOptions { starts: 0, ..options }, &|_, _| ()).unwrap();
    assert_eq!(without.searched.followed, 0);
}
