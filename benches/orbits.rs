//! Periodic orbits: the time of one accepted branch point with n impacts, compared with a point by
//! simulation and by differences of the reference method; and the tree of all branches. Targets:
//! 30, 60, 160 µs per point at n = 1, 2, 6; the tree in less than 5 s on two cores.

use std::collections::BTreeMap;
use std::hint::black_box;
use std::time::{Duration, Instant};
use vibro_impact::reference::{Reference, Tolerance};
use vibro_impact::{Simulator, State};
use vibro_orbits::paper::{
    Family, Orbit, PathOptions, Span, System, TreeOptions, branch, orbit_of, settle, tree,
};
use vibro_studies::paper::stroboscopic::moving_block;
use vibro_studies::paper::{ParameterSet, find_group};

/// Number of rounds; the smallest time counts.
const ROUNDS: u32 = 5;
/// Drive periods for a transient to decay, as for a point of a simulated diagram.
const SETTLE: u32 = 600;
/// Number of Newton steps of a corrector by differences of the period map.
const CORRECTIONS: u32 = 3;

fn least(mut work: impl FnMut()) -> Duration {
    let once = |_| {
        let begin = Instant::now();
        work();
        begin.elapsed()
    };
    (0..ROUNDS).map(once).min().unwrap_or_default()
}

fn family(from: f64, to: f64) -> Family {
    let span = Span::new(find_group("f10").expect("a group"), from, to).expect("a range");
    Family::new(&ParameterSet::basic(), span).expect("machines")
}

/// A stable orbit of the default set at f10.
fn settled(family: &Family, f10: f64) -> Orbit {
    let system = family.system(&[f10]).expect("a machine");
    let state = settle(&system, &moving_block(system.parameters()), 4000).expect("a motion");
    orbit_of(&system, &state).expect("an orbit")
}

fn micros(time: Duration, count: usize) -> f64 {
    1e6 * time.as_secs_f64() / count as f64
}

/// Simulates some periods from a state by the reference method.
fn reference(system: &System, state: &State, periods: f64) {
    let p = system.parameters();
    let mut reference = Reference::new(p, state, 0.0, Tolerance::new(1e-12)).expect("a start");
    reference.advance_to(periods * p.period()).expect("a motion");
    black_box(reference.state());
}

fn main() {
    println!(
        "| impacts | word | µs per accepted point | by simulation | by differences of the reference method |"
    );
    println!("|---|---|---|---|---|");
    let narrow = PathOptions::default();
    for (f10, word) in [(1.5, "U"), (2.2, "UL"), (3.1, "")] {
        let family = family(f10 - 0.2, f10 + 0.15);
        let orbit = settled(&family, f10);
        assert!(word.is_empty() || orbit.word().canonical().to_string() == word, "{}", orbit.word());
        let follow = || branch(&family, orbit.word(), orbit.phases(), f10, &narrow, &[]).expect("a branch");
        let points = follow().points.len();
        let time = least(|| {
            black_box(follow());
        });
        let (system, start) = (*orbit.system(), orbit.start_state());
        let simulated = least(|| {
            let mut simulator =
                Simulator::new(system.parameters(), &start, 0.0).expect("a start").without_energy_accounts();
            simulator.advance_to(f64::from(SETTLE) * system.parameters().period()).expect("a motion");
            black_box(simulator.state());
        });
        // A Newton step takes seven motions over a period.
        let periods = f64::from(orbit.word().period());
        let differences = least(|| (0..7 * CORRECTIONS).for_each(|_| reference(&system, &start, periods)));
        println!(
            "| {} | {} | {:.0} | {:.0} | {:.0} |",
            orbit.word().len(),
            orbit.word(),
            micros(time, points),
            micros(simulated, 1),
            micros(differences, 1)
        );
    }
    println!();
    for starts in [0, TreeOptions::default().starts] {
        grow(&TreeOptions { starts, ..TreeOptions::default() });
    }
}

/// Grows the tree of the default set and prints its contents and the time.
fn grow(options: &TreeOptions) {
    let begin = Instant::now();
    let found = tree(&family(0.5, 5.0), options, &|_, _| ()).expect("a tree");
    let elapsed = begin.elapsed().as_secs_f64();
    let points: usize = found.branches.iter().map(|b| b.points.len()).sum();
    let mut labels: BTreeMap<&str, usize> = BTreeMap::new();
    for label in found.branches.iter().flat_map(|b| b.points.iter().filter_map(|p| p.label())) {
        *labels.entry(label.name()).or_default() += 1;
    }
    let labels: Vec<String> = labels.iter().map(|(label, count)| format!("{count} {label}")).collect();
    println!(
        "The tree over f10 from 0.5 to 5 with {} starts beside the settled motions: {} branches, {points} points ({}), {elapsed:.2} s on {} \
         threads; {} branches followed from orbits that were passed, {} kept.",
        options.starts,
        found.branches.len(),
        labels.join(", "),
        rayon::current_num_threads(),
        found.searched.followed,
        found.searched.islands
    );
}
