//! Random calls with random arguments on machines with every kind of element, by both doors: no crash, no panic, and the instance answers
//! afterwards. The fuzzer `machine` of `tests/fuzz` makes the same calls.

use crate::calls::{Random, Target, run_fmi2, run_fmi3};
use crate::host::*;
use std::ffi::CString;
use vibro_assembly_fmi::Plan;

/// Calls a run.
const CALLS: usize = 400;

fn target(example: &str, arrays: bool) -> Target {
    let plan = plan(example, unchanged);
    let folder = resources(&format!("random {example} {arrays}"), &plan);
    let plan: Plan = if arrays { plan.with_arrays() } else { plan };
    Target {
        token: CString::new(plan.token()).unwrap(),
        resources: Some(CString::new(folder.to_str().unwrap()).unwrap()),
        references: plan.table.rows.len() as u64 + 3,
        input: plan.table.inputs.first().copied(),
    }
}

const EXAMPLES: [&str; 4] =
    ["bouncing_ball.toml", "damper_with_buffer.toml", "gear_backlash.toml", "msl_coupled_clutches.toml"];

#[test]
fn random_calls_by_fmi2_neither_crash_nor_panic() {
    for example in EXAMPLES {
        for seed in 0..4_u64 {
            run_fmi2(&target(example, false), &mut Random { bytes: &[], seed }, (seed % 2) as i32, CALLS);
        }
    }
}

#[test]
fn random_calls_by_fmi3_neither_crash_nor_panic() {
    for example in EXAMPLES {
        for seed in 0..8_u64 {
            let target = target(example, seed >= 4);
            run_fmi3(&target, &mut Random { bytes: &[], seed }, seed % 2 == 0, seed % 4 < 2, CALLS);
        }
    }
}
