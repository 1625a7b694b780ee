//! The C interface of FMI 2.0 and 3.0 for any Rust type.
//!
//! ```text
//! host ── fmi2XXX ──▶ fmi2/       who may call what when, C types, statuses of FMI 2.0
//!      ── fmi3XXX ──▶ fmi3/       the same for FMI 3.0
//!                      │    │
//!                      │    └───▶ messages   statuses, log categories and messages, alike in both
//!                      │          ffi/       checked pointers, panics caught, handles looked up
//!                      ▼
//!                  instance       the component, saved states and log categories, alike in both
//!                      ▼
//!                  Component      life, steps and events, the same for every Hybrid
//!                      ▲
//!              Model + Hybrid     what a type must be able to do; the defaults refuse by name
//!                      ▲
//!                  tabular        both from a table of variables and what moves them
//! ```
//!
//! The doors check handles, pointers, counts and states, keep saved states, turn panics into
//! statuses and problems into log messages. The doors do not depend on a model, and [`ffi`] does
//! not depend on FMI. The doors [`fmi2`] and [`fmi3`] do not import each other.
//!
//! # An FMU from your Rust type
//!
//! 1. A crate with a `cdylib` library that depends on this crate.
//! 2. A type that implements [`Tabular`](tabular::Tabular): a table of variables and the functions
//!    of their motion, as below and in `examples/bouncing_ball/ball.rs`, which has events. Both
//!    interface types, event mode, intermediate update, saved states, ranges, phases and messages
//!    follow from the table. If a table is not enough (arrays, derivatives, variables known only
//!    at run time), a type implements [`Model`] and [`Hybrid`] directly. Their defaults refuse
//!    what is missing by name, and the steps are provided ([`hybrid`]).
//! 3. One line, [`export!`], makes all functions of FMI 2.0 and 3.0. It expands to `unsafe`
//!    functions with the C names; the crate may deny `unsafe_code` elsewhere, but not forbid it.
//! 4. A program that writes `modelDescription.xml` for each version (`examples/describe.rs`), from
//!    [`FromTable::description`](tabular::FromTable::description) or a
//!    [`Description`](description::Description) of your own.
//! 5. A zip archive of the description and the library, in `binaries/linux64/` (FMI 2.0) or
//!    `binaries/x86_64-linux/` (FMI 3.0) or the folder of another platform. The library has the
//!    name given as `modelIdentifier` in the description.
//!
//! ```
//! use fmi_doors::tabular::{FromTable, Row, Tabular};
//!
//! /// y follows u: y' = (u - y) / T.
//! enum Lag {}
//!
//! fmi_doors::export!(FromTable<Lag>);
//!
//! // Places in the table; value references are counted from 1.
//! const TIME: usize = 0;
//! const CONSTANT: usize = 1;
//! const U: usize = 2;
//! const Y: usize = 3;
//! const RATE: usize = 4;
//!
//! impl Tabular for Lag {
//!     const NAME: &'static str = "Lag";
//!     const IDENTIFIER: &'static str = "lag";
//!     const DESCRIPTION: &'static str = "A first-order lag";
//!     const VERSION: &'static str = "1.0";
//!     const ROWS: &'static [Row] = &[
//!         Row::time("time"),
//!         Row::parameter("T", "s", 0.5, "Time constant").within(f64::MIN_POSITIVE, f64::MAX),
//!         Row::input("u", "1", 0.0, "What is followed"),
//!         Row::state("y", "1", 0.0, "What follows"),
//!         Row::derivative("der(y)", "1/s", Y, "Its rate"),
//!     ];
//!
//!     fn evaluate(x: &mut [f64]) {
//!         x[RATE] = (x[U] - x[Y]) / x[CONSTANT];
//!     }
//!
//!     /// Exactly, for an input that is held.
//!     fn advance(x: &mut [f64], time: f64) {
//!         x[Y] = x[U] + (x[Y] - x[U]) * (-(time - x[TIME]) / x[CONSTANT]).exp();
//!     }
//! }
//!
//! // A host's calls.
//! # use std::ffi::CString;
//! # use std::ptr::null;
//! let token = CString::new(FromTable::<Lag>::token()).unwrap();
//! let mut y = 0.0;
//! unsafe {
//!     let c = fmi2Instantiate(c"lag".as_ptr(), 1, token.as_ptr(), null(), null(), 0, 0);
//!     assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), 0);
//!     assert_eq!(fmi2EnterInitializationMode(c), 0);
//!     assert_eq!(fmi2ExitInitializationMode(c), 0);
//!     assert_eq!(fmi2SetReal(c, &3, 1, &1.0), 0); // u
//!     assert_eq!(fmi2DoStep(c, 0.0, 0.5, 1), 0);
//!     assert_eq!(fmi2GetReal(c, &4, 1, &mut y), 0); // y
//!     fmi2FreeInstance(c);
//! }
//! assert!((y - (1.0 - (-1.0_f64).exp())).abs() < 1e-15);
//! ```

mod allowed;
pub mod component;
pub mod description;
pub mod events;
pub mod ffi;
pub mod fmi2;
pub mod fmi3;
pub mod hybrid;
pub mod identifier;
pub mod instance;
pub mod instantiation;
pub mod life;
pub mod log;
pub mod messages;
pub mod model;
pub mod problem;
pub mod tabular;
pub mod values;

pub use component::Component;
pub use events::{EarlyEnd, Handled, Piece, StepOutcome};
pub use hybrid::Hybrid;
pub use instantiation::{Instantiation, Named, Version};
pub use life::{EventHandling, Experiment, Interface, Life, Phase};
pub use model::Model;
pub use problem::{Problem, Refusal};
pub use values::{Base, Bases, Dependency, DependencyKind};

/// Exports a [`Component`] by FMI 2.0 and 3.0: every function of both standards, as a public
/// function with its C name. The macro is invoked once in the library that hosts load, in a module
/// with the type in scope. The library must be a `cdylib`.
#[macro_export]
macro_rules! export {
    ($component:ty) => {
        $crate::export_fmi2!($component);
        $crate::export_fmi3!($component);
    };
}
