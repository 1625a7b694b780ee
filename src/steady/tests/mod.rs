//! The methods of `steady` against each other, against golden numbers and against direct
//! integration.

mod asymptotics;
mod continuation;
mod exact_orbit;
mod multiple_scales;
mod robustness;
mod strong_coupling;
