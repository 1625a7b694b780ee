//! Motions and a second method in 50 digits (tests/data/make_motions.py and make_families.py).

use std::sync::Arc;
use vibro_machine::description::Description;
use vibro_machine::file::{no_records, parse};
use vibro_machine::motion::EventKind;
use vibro_machine::{Assembly, Motion};

const MACHINES: &str = include_str!("data/motions.txt");
const FAMILIES: &str = include_str!("data/families.txt");

/// Perturbation of a start, which measures how much a motion amplifies errors.
const OFF: f64 = 1e-10;
/// Errors of a motion, in the unit of [`OFF`]: hundreds of roundings, and skipped bounces of 1e-12
/// of the paths.
const OWN: f64 = 2e-13;
/// Errors at the edge of the law relative to the largest coordinate, by prefix of a family's name.
/// Most are a few times [`OWN`]. Grazing by 1e-9 of the gap amplifies a rounding of the gap 1e4
/// times in the velocity. Redundant stops, one of them plastic, cause ever faster bounces; bounces
/// closer than 1e-13 of the paths count as simultaneous. A stiff buffer amplifies a rounding of
/// the coordinate by 1e4/s in the velocity.
const EDGES: [(&str, f64); 9] = [
    ("grazing", 1e-10),
    ("redundant", 1e-9),
    ("loops", 1e-13),
    ("repressed", 1e-13),
    ("corners", 1e-13),
    ("levels", 1e-13),
    ("stiff", 1e-11),
    ("laws", 1e-13),
    ("follows", 1e-13),
];

struct Known {
    name: String,
    machine: Description,
    /// Time, then s and v of every body.
    states: Vec<Vec<f64>>,
    impacts: usize,
}

fn machines(all: &str) -> Vec<Known> {
    let blocks = all.split("## machine ").skip(1);
    let known = |block: &str| {
        let (number, text) = block.split_once('\n').unwrap();
        let toml: String = text.lines().filter(|l| !l.starts_with("##")).flat_map(|l| [l, "\n"]).collect();
        let words = |key: &'static str| text.lines().filter_map(move |l| l.strip_prefix(key));
        let numbers = |line: &str| line.split_whitespace().map(|x| x.parse().unwrap()).collect();
        Known {
            name: number.to_owned(),
            machine: parse(&toml, number, &no_records).unwrap_or_else(|e| panic!("{e}")),
            states: words("## state ").map(numbers).collect(),
            impacts: words("## impacts ").next().unwrap().parse().unwrap(),
        }
    };
    blocks.map(known).collect()
}

/// The states at the given times, and the number of impacts.
fn follow(machine: &Description, times: impl Iterator<Item = f64>) -> (Vec<Vec<f64>>, usize) {
    let mut m = Motion::new(Arc::new(Assembly::new(machine.clone()).unwrap())).unwrap();
    let mut hits = 0;
    let states = times.map(|time| {
        let mut count = |e: &vibro_machine::motion::Event| {
            hits += usize::from(matches!(e.kind, EventKind::Impact { .. }));
        };
        m.advance_observed(time, &mut count).unwrap();
        let bodies = (0..machine.bodies.len()).flat_map(|i| {
            let [s, v, _] = m.body(i);
            [s, v]
        });
        std::iter::once(m.time()).chain(bodies).collect()
    });
    (states.collect(), hits)
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).skip(1).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

#[test]
fn second_method_random_machines_in_50_digits() {
    let all = machines(MACHINES);
    assert!(all.len() >= 88, "{}", all.len());
    let (mut worst, mut impacts) = (0.0f64, 0);
    for (number, known) in all.iter().enumerate() {
        let times = || known.states.iter().map(|s| s[0]);
        let (states, hits) = follow(&known.machine, times());
        let mut off = known.machine.clone();
        for body in &mut off.bodies {
            if let vibro_machine::description::BodyKind::Free(free) = &mut body.kind {
                free.v += OFF;
            }
        }
        let (moved, _) = follow(&off, times());
        for ((state, moved), exact) in states.iter().zip(&moved).zip(&known.states) {
            let magnified = 1.0 + distance(state, moved) / OFF;
            let size = exact.iter().fold(1.0f64, |m, x| m.max(x.abs()));
            let error = distance(state, exact) / (magnified * size);
            worst = worst.max(error);
            assert!(
                error < OWN,
                "machine {number} at {}: {error:e}, magnified {magnified}\n{state:?}\n{exact:?}",
                exact[0]
            );
        }
        impacts += hits;
        assert!(hits <= known.impacts, "machine {number}: {hits} impacts instead of {}", known.impacts);
    }
    println!("largest error {worst:e} of {} machines with {impacts} impacts", all.len());
}

#[test]
fn second_method_machines_at_the_edge_of_the_law_in_50_digits() {
    let all = machines(FAMILIES);
    for (family, allowed) in EDGES {
        let (mut worst, mut count) = (0.0f64, 0);
        for known in all.iter().filter(|known| known.name.starts_with(family)) {
            let (states, _) = follow(&known.machine, known.states.iter().map(|s| s[0]));
            for (state, exact) in states.iter().zip(&known.states) {
                let size = exact[1..].iter().fold(1.0f64, |m, x| m.max(x.abs()));
                let error = distance(state, exact) / size;
                worst = worst.max(error);
                assert!(error < allowed, "{} at {}: {error:e}\n{state:?}\n{exact:?}", known.name, exact[0]);
            }
            count += 1;
        }
        println!("{family}: largest error {worst:e} of {count} machines");
        assert!(count >= 6, "{family}: {count}");
    }
}
