//! The vibro-impact machine as a component that a host can set, step, read, save and restore. It
//! does not depend on a version of FMI: it follows the rules common to all versions. A door maps
//! its calls, phases and outcomes to the functions, states and statuses of one version.
//!
//! ```text
//! instance ── variables, units, structure    table: names, units, ranges, dependencies, access
//!    │
//!    ├─ simulator (vibro_impact)             it steps itself, event by event
//!    ├─ closed_form, steady                  it plays a steady state in time
//!    ├─ continuous, variation                a host's solver integrates it
//!    └─ saved_state                          all of it as bytes
//! ```

mod closed_form;
mod continuous;
mod event_state;
pub mod identity;
pub mod instance;
pub mod jets;
pub mod problem;
pub mod protocol;
pub mod saved_state;
mod sensitivity;
pub mod settings;
mod steady;
pub mod structure;
pub mod units;
pub mod values;
pub mod variables;
mod variation;

pub use fmi_doors::log;
pub use fmi_doors::{Dependency, EventHandling, Handled, Interface, Phase, Piece, StepOutcome};
pub use instance::Instance;
pub use problem::{ComponentProblem, Outcome};
pub use protocol::Protocol;
