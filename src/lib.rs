//! A 3-DOF vibro-impact model: exact hybrid simulation and closed-form steady states.
//!
//! ```text
//! parameters → model → flow → events → simulator
//! parameters → steady (multiple scales, strong coupling, exact orbit)
//! ```
//!
//! `steady` never calls the simulator and the simulator never calls `steady`: each is the other's oracle.
#![forbid(unsafe_code)]

pub mod energy;
pub mod error;
pub mod events;
pub mod flow;
pub mod model;
pub mod numerics;
pub mod parameters;
pub mod reference;
pub mod simulator;
mod state;
pub mod steady;

pub use error::{Error, Result};
pub use parameters::{Groups, Parameters, Scales};
pub use simulator::Simulator;
pub use state::State;
