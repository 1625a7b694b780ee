//! The vibro-impact machine as an FMI component, and its doors to C.
//!
//! ```text
//! host ── fmi2XXX, fmi3XXX ──▶ fmi_doors    which call is allowed, pointers, panics, messages
//!                                 │
//!                                 ▼
//!                              exported     the component as the doors want it
//!                                 │     └──▶ fmi2, fmi3   exported functions, descriptions
//!                                 ▼
//!                              component    variables, settings, steps, events, saved states
//!                                 ▼
//!                              vibro_impact
//! ```
//!
//! [`component`] does not depend on a version of FMI. The differences between the versions for this
//! machine are in `exported`, [`fmi2`] and [`fmi3`]; [`fmi2`] and [`fmi3`] do not import each
//! other. The common parts of their descriptions are in `description`.

pub mod component;
mod description;
mod exported;
pub mod fmi2;
pub mod fmi3;

pub use fmi_doors::{ffi, messages};
