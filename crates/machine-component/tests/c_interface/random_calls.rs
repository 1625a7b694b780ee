//! Random calls with random arguments on machines with every kind of element, through both doors:
//! no crash, no panic, and the instance still answers. The fuzzer `machine` of `tests/fuzz` makes
//! the same calls; its findings are in its corpus.

use crate::calls::{Random, Target, run_fmi2, run_fmi3};
use crate::machines::{machines, run};
use std::path::Path;

/// Number of calls in a run.
const CALLS: usize = 400;

fn targets(folder: &str) -> Vec<Target> {
    machines(&Path::new(env!("CARGO_TARGET_TMPDIR")).join(folder))
}

#[test]
fn random_calls_by_fmi2_neither_crash_nor_panic() {
    for target in targets("random 2").iter().step_by(2) {
        for seed in 0..4_u64 {
            run_fmi2(target, &mut Random { bytes: &[], seed }, (seed % 2) as i32, CALLS);
        }
    }
}

#[test]
fn random_calls_by_fmi3_neither_crash_nor_panic() {
    for target in targets("random 3") {
        for seed in 0..4_u64 {
            run_fmi3(&target, &mut Random { bytes: &[], seed }, seed % 2 == 0, seed < 2, CALLS);
        }
    }
}

#[test]
fn inputs_of_the_fuzzer_and_its_findings_neither_crash_nor_panic() {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fuzz/corpus/machine");
    let targets = targets("corpus");
    let inputs = std::fs::read_dir(corpus).unwrap().map(|entry| entry.unwrap().path());
    assert!(inputs.inspect(|input| run(&targets, &std::fs::read(input).unwrap())).count() > 0);
}
