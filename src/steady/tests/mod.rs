//! Tests that set the methods of `steady` against each other and against model.md.

mod asymptotics;
mod exact_orbit;
mod multiple_scales;
mod strong_coupling;
