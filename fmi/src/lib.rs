//! The vibro-impact machine as an FMI component, and its doors to C.
//!
//! ```text
//! host ── fmi2XXX ──▶ fmi2/       who may call what when, C types, statuses, what FMI 2.0 describes
//!                      │    │
//!                      │    └───▶ ffi/        checked pointers, panics caught
//!                      ▼
//!                     component/  variables, what may be set when, steps, events, saved states
//!                      ▼
//!                     vibro_impact
//! ```
//!
//! [`component`] knows no version of FMI; [`ffi`] knows neither it nor FMI. A door to another version stands beside
//! [`fmi2`], and neither imports the other.

pub mod component;
pub mod ffi;
pub mod fmi2;
pub mod fmi3;
