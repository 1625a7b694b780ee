//! A machine that is written as a text file, as an FMI component.
//!
//! ```text
//! resources/machine.toml ──▶ plan ──▶ table   variables by value reference: parameters, inputs, outputs
//!                              │        └───▶ description   what modelDescription.xml says of them
//!                              ▼
//!            host ── doors ──▶ machine   parameters, steps, events, saved states, on a motion of `vibro_assembly`
//! ```
//!
//! One library serves every machine: which variables it has is known when an instance is made and
//! the file in the FMU's resources is read. The token of the description is a hash of this file and
//! of the library's version, so that neither another machine's file nor another version's
//! description is taken.
#![forbid(unsafe_code)]

mod description;
mod experiment;
mod machine;
mod plan;
mod problem;
mod saved_state;
mod structure;
mod table;
mod units;

pub use machine::Machine;
pub use plan::{FILE, Plan};
pub use problem::MachineProblem;
pub use saved_state::SavedState;
pub use table::{Energy, Quantity, Role, VariableRow, VariableTable};
