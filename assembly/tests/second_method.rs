//! Motions against those of a second method in 50 digits (tests/data/make_motions.py).

use std::sync::Arc;
use vibro_assembly::description::Description;
use vibro_assembly::file::{no_records, parse};
use vibro_assembly::motion::EventKind;
use vibro_assembly::{Assembly, Motion};

const MACHINES: &str = include_str!("data/motions.txt");

/// A start that is off by this shows how much a motion magnifies an error.
const OFF: f64 = 1e-10;
/// Errors that a motion makes of its own, in the same measure: some hundreds of roundings, and bounces of 1e-12 of the paths that
/// are not followed.
const OWN: f64 = 2e-13;

struct Known {
    machine: Description,
    /// Time, then s and v of every body.
    states: Vec<Vec<f64>>,
    impacts: usize,
}

fn machines() -> Vec<Known> {
    let blocks = MACHINES.split("## machine ").skip(1);
    let known = |block: &str| {
        let (number, text) = block.split_once('\n').unwrap();
        let toml: String = text.lines().filter(|l| !l.starts_with("##")).flat_map(|l| [l, "\n"]).collect();
        let words = |key: &'static str| text.lines().filter_map(move |l| l.strip_prefix(key));
        let numbers = |line: &str| line.split_whitespace().map(|x| x.parse().unwrap()).collect();
        Known {
            machine: parse(&toml, number, &no_records).unwrap_or_else(|e| panic!("{e}")),
            states: words("## state ").map(numbers).collect(),
            impacts: words("## impacts ").next().unwrap().parse().unwrap(),
        }
    };
    blocks.map(known).collect()
}

/// The states at the times, and the impacts.
fn follow(machine: &Description, times: impl Iterator<Item = f64>) -> (Vec<Vec<f64>>, usize) {
    let mut m = Motion::new(Arc::new(Assembly::new(machine.clone()).unwrap())).unwrap();
    let mut hits = 0;
    let states = times.map(|time| {
        let mut count = |e: &vibro_assembly::motion::Event| {
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
    let all = machines();
    assert!(all.len() >= 88, "{}", all.len());
    let (mut worst, mut impacts) = (0.0f64, 0);
    for (number, known) in all.iter().enumerate() {
        let times = || known.states.iter().map(|s| s[0]);
        let (states, hits) = follow(&known.machine, times());
        let mut off = known.machine.clone();
        for body in &mut off.bodies {
            if let vibro_assembly::description::BodyKind::Free(free) = &mut body.kind {
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
