//! A machine described by a text file as an FMI component.
//!
//! ```text
//! resources/machine.toml ──▶ plan ──▶ table   variables by value reference
//!                              │        └───▶ description   content of modelDescription.xml
//!                              ▼
//!            host ── doors ──▶ machine   parameters, steps, events, saved states
//!                                        of a motion of `vibro_assembly`
//! ```
//!
//! One library serves every machine: the variables are known once an instance is created and reads
//! the file in the FMU's resources. The token of the model description is a hash of this file and
//! of the library's version, so that another machine's file and another version's description are
//! refused.
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
pub use table::{Energy, Quantity, Role, Row, Table};
