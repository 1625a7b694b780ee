//! Random calls with random arguments on the bouncing ball, through both doors: no crash, no
//! panic, and the instance still answers afterwards.

use super::bouncing_ball::Ball;
use super::calls::{Random, Target, run_fmi2, run_fmi3};
use fmi_doors::tabular::FromTable;
use std::ffi::CString;

/// Calls per run.
const CALLS: usize = if cfg!(miri) { 60 } else { 4000 };

fn ball() -> Target {
    let token = CString::new(FromTable::<Ball>::token()).unwrap();
    Target { token, resources: None, references: 11, input: None }
}

#[test]
fn random_calls_by_fmi2_neither_crash_nor_panic() {
    for seed in 0..8_u64 {
        run_fmi2(&ball(), &mut Random { bytes: &[], seed }, (seed % 2) as i32, CALLS);
    }
}

#[test]
fn random_calls_by_fmi3_neither_crash_nor_panic() {
    for seed in 0..8_u64 {
        run_fmi3(&ball(), &mut Random { bytes: &[], seed }, seed % 2 == 0, seed % 4 < 2, CALLS);
    }
}
