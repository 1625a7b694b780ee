//! Tests that set the methods of `steady` against each other and against model.md.

mod exact_orbit;
mod multiple_scales;
