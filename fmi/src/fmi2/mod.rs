//! The FMI 2.0 layer: `variables` (one table) → `instance` (safe state machine) → `abi` (every `extern "C"`).
//!
//! ```text
//! host ── fmi2XXX ──▶ abi.rs        pointers checked (arguments.rs), panics caught (panics.rs), nothing decided
//!                      │
//!                      ▼
//!                     instance.rs   who may call what when (states.rs), what it means
//!                      │    │
//!                      │    └─────▶ variables.rs   names, units, ranges, getters, setters
//!                      ▼
//!                     simulator / steady
//! ```
//!
//! Clauses are those of *Functional Mock-up Interface for Model Exchange and Co-Simulation*, version 2.0.x.

pub mod abi;
mod arguments;
mod bytes;
mod closed_form;
mod continuous;
pub mod description;
pub mod instance;
pub mod logging;
pub mod panics;
pub mod problem;
pub mod settings;
pub mod states;
mod steady;
pub mod structure;
pub mod types;
pub mod units;
pub mod variables;
mod variation;
