//! The C interfaces of the doors' second component, the bouncing ball: the fuzzer's bytes choose
//! calls and arguments.
#![no_main]
#![allow(missing_docs)]

#[path = "../../../crates/doors/examples/bouncing_ball/main.rs"]
mod bouncing_ball;
#[path = "../../../crates/doors/tests/common/calls.rs"]
mod calls;

use bouncing_ball as component;
use calls::{Random, Target, run_fmi2, run_fmi3};
use fmi_doors::tabular::FromTable;
use libfuzzer_sys::fuzz_target;
use std::ffi::CString;
use std::sync::LazyLock;

/// Calls a run, more than the bytes of most inputs choose.
const CALLS: usize = 64;

static BALL: LazyLock<Target> = LazyLock::new(|| {
    let token = CString::new(FromTable::<component::Ball>::token()).expect("no null byte");
    Target { token, resources: None, references: 11, input: None }
});

fuzz_target!(|bytes: &[u8]| {
    let Some((kind, bytes)) = bytes.split_first() else { return };
    let mut random = Random { bytes, seed: u64::from(*kind) };
    match kind % 5 {
        0 | 1 => run_fmi2(&BALL, &mut random, i32::from(kind % 5), CALLS),
        other => run_fmi3(&BALL, &mut random, other == 2, other == 3, CALLS),
    }
});
