//! Tests that set the methods of `steady` against each other and against model.md.

mod asymptotics;
mod continuation;
mod exact_orbit;
mod multiple_scales;
mod robustness;
mod strong_coupling;
