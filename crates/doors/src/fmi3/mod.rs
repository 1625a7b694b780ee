//! The FMI 3.0 door: it maps the functions, states and statuses of the standard to the
//! [component](crate::component).
//!
//! ```text
//! host ── fmi3XXX ──▶ abi         checks arguments, catches panics (ffi), checks states
//!                      │
//!                      ▼
//!                     instance    what a function of the standard means for the component
//!                      │
//!                     states, status, types, description, problem: what the standard says
//! ```
//!
//! Clause numbers refer to *Functional Mock-up Interface Specification*, version 3.0.2.

pub mod abi;
pub mod instance;
mod intermediate;
mod model;
pub mod problem;
pub mod states;
pub mod status;
pub mod types;
