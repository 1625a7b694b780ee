//! An FMI component for machines described by text files.
//!
//! ```text
//! resources/machine.toml ──▶ plan ──▶ table          variables by value reference
//!                              │        └───▶ description   modelDescription.xml
//!                              ▼
//!            host ── doors ──▶ machine        parameters, steps, events, saved states,
//!                                             on a motion of `vibro_machine`
//! ```
//!
//! One library serves every machine: the variables follow from the file in the FMU's resources,
//! which is read when an instance is made. The instantiation token is a hash of this file and of
//! the library's version. So another machine's file and another version's description are
//! rejected.
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

pub use experiment::experiment;
pub use machine::Machine;
pub use plan::{FILE, Plan, ResourceReader, read_resources_by};
pub use problem::MachineProblem;
pub use saved_state::SavedState;
pub use table::{Energy, Quantity, Role, VariableRow, VariableTable};
