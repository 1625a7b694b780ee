//! A 3-DOF vibro-impact model: exact hybrid simulation, closed-form steady states, FMI 2.0.
//!
//! ```text
//! parameters → model → flow → events → simulator ─┬→ fmi2 (variables → instance → abi)
//!                                                 └→ analysis → command line
//! parameters → steady (multiple scales, strong coupling, exact orbit) ─┴→ fmi2, analysis
//! ```
//!
//! `steady` never calls the simulator and the simulator never calls `steady`: each is the other's oracle.

#[cfg(feature = "cli")]
pub mod analysis;
pub mod error;
mod events;
mod extended;
mod flow;
pub mod fmi2;
mod ledger;
mod model;
pub mod parameters;
pub mod reference;
pub mod simulator;
pub mod steady;
mod vector;
mod wide;

pub use error::{Error, Result};
pub use parameters::{Groups, Parameters, Scales};
pub use simulator::{Simulator, State};
