//! The C interface of FMI 2.0 and 3.0 for any Rust type.
//!
//! ```text
//! host ── fmi2XXX ──▶ fmi2/       who may call what when, C types, statuses of FMI 2.0
//!      ── fmi3XXX ──▶ fmi3/       the same for FMI 3.0
//!                      │    │
//!                      │    └───▶ messages   statuses, log categories and messages, alike in both
//!                      │          ffi/       checked pointers, panics caught, handles looked up
//!                      ▼
//!                  Component      what a type must be able to do: one trait, whose defaults refuse by name
//! ```
//!
//! A type that implements [`Component`] becomes a library that hosts load by [`export!`]. The doors check handles, pointers,
//! counts and states, keep saved states, turn panics into statuses and problems into log messages. They know nothing of what
//! moves; [`ffi`] knows nothing of FMI; the doors [`fmi2`] and [`fmi3`] stand beside each other, and neither imports the other.

pub mod component;
pub mod description;
pub mod events;
pub mod ffi;
pub mod fmi2;
pub mod fmi3;
pub mod identifier;
pub mod life;
pub mod log;
pub mod messages;
pub mod problem;
pub mod values;

pub use component::{Component, Instantiation, Named, Version};
pub use events::{Advance, EarlyEnd, Handled, Piece, StepOutcome, StepReason};
pub use life::{EventHandling, Experiment, Interface, Life, Phase};
pub use problem::{Problem, Refusal};
pub use values::{Base, Bases, Dependency, DependencyKind};

/// Exports a [`Component`] by FMI 2.0 and 3.0: every function of both standards, each a public function by its C name. It stands
/// once in the library that hosts load, in a module where the type is in scope. The library must be a `cdylib`.
#[macro_export]
macro_rules! export {
    ($component:ty) => {
        $crate::export_fmi2!($component);
        $crate::export_fmi3!($component);
    };
}
