//! The FMI 2.0 door: it maps the functions, states and statuses of the standard to the
//! [component](crate::component).
//!
//! ```text
//! host ── fmi2XXX ──▶ abi         checks arguments, catches panics (ffi), checks states
//!                      │
//!                      ▼
//!                     instance    what a function of the standard means for the component
//!                      │
//!                     states, status, types, description, problem: what the standard says
//! ```
//!
//! Clause numbers refer to *Functional Mock-up Interface for Model Exchange and Co-Simulation*,
//! version 2.0.x.

pub mod abi;
pub mod instance;
pub mod problem;
pub mod states;
pub mod status;
pub mod types;
