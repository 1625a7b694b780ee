//! The vibro-impact machine as an FMI component, and its doors to C.
//!
//! ```text
//! host ── fmi2XXX ──▶ fmi2/       who may call what when, C types, statuses, what FMI 2.0 describes
//!      ── fmi3XXX ──▶ fmi3/       the same for FMI 3.0
//!                      │    │
//!                      │    └───▶ messages.rs statuses, log categories and messages, alike in both
//!                      │          ffi/        checked pointers, panics caught
//!                      ▼
//!                     component/  variables, what may be set when, steps, events, saved states
//!                      ▼
//!                     vibro_impact
//! ```
//!
//! [`component`] knows no version of FMI; [`ffi`] knows neither it nor FMI; [`messages`] is what both versions have in
//! common. The doors [`fmi2`] and [`fmi3`] stand beside each other, and neither imports the other.

pub mod component;
pub mod ffi;
pub mod fmi2;
pub mod fmi3;
pub mod messages;
