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
//! [`component`] knows no version of FMI. What the versions differ in for this machine stands in
//! `exported`, [`fmi2`] and [`fmi3`], of which neither imports the other; what their descriptions
//! have in common in `description`.

pub mod component;
mod description;
mod exported;
pub mod fmi2;
pub mod fmi3;
#[cfg(test)]
mod random;

pub use fmi_doors::{ffi, messages};
