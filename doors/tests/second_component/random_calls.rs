//! Random calls with random arguments on the bouncing ball, by both doors: no crash, no panic, and the instance answers afterwards.

use super::calls::{Random, run_fmi2, run_fmi3};

/// Calls a run.
const CALLS: usize = if cfg!(miri) { 60 } else { 4000 };

#[test]
fn random_calls_by_fmi2_neither_crash_nor_panic() {
    for seed in 0..8_u64 {
        run_fmi2(&mut Random { bytes: &[], seed }, (seed % 2) as i32, CALLS);
    }
}

#[test]
fn random_calls_by_fmi3_neither_crash_nor_panic() {
    for seed in 0..8_u64 {
        run_fmi3(&mut Random { bytes: &[], seed }, seed % 2 == 0, seed % 4 < 2, CALLS);
    }
}
