//! A shared library that panics inside an FMI call, for `fmu-build/tests/loading.rs`; the packaged
//! library cannot panic on request.
#![allow(unsafe_code)] // exported by name

use vibro_paper_component::component;
use vibro_paper_component::ffi::panics::{guarded, silence};
use vibro_paper_component::fmi2::problem::CallProblem;

/// Returns `fmi2Fatal`.
#[unsafe(no_mangle)]
pub extern "C" fn provoke_panic() -> i32 {
    silence();
    match guarded(|| -> i32 { panic!("provoked") }) {
        Ok(status) => status,
        Err(fault) => CallProblem::<component::ComponentProblem>::from(fault).status() as i32,
    }
}
