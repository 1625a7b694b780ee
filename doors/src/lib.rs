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
//! The doors check handles, pointers, counts and states, keep saved states, turn panics into statuses and problems into log
//! messages. They know nothing of what moves; [`ffi`] knows nothing of FMI; the doors [`fmi2`] and [`fmi3`] stand beside each other,
//! and neither imports the other.
//!
//! # An FMU from your Rust type
//!
//! 1. A crate whose library is a `cdylib`, with this crate among its dependencies.
//! 2. A type that implements [`Component`]: what it offers; the defaults refuse the rest by name. Below, a first-order lag that steps
//!    itself exactly.
//! 3. One line, [`export!`], makes all functions of FMI 2.0 and 3.0. It expands to `unsafe` functions by the C names; the crate may
//!    deny `unsafe_code` elsewhere, but not forbid it.
//! 4. A program that writes `modelDescription.xml` from a [`Description`](description::Description), one for each version.
//! 5. A zip archive of the description and the library, in `binaries/linux64/` (FMI 2.0) or `binaries/x86_64-linux/` (FMI 3.0) and the
//!    like of other platforms, under the name that the description has as `modelIdentifier`.
//!
//! ```
//! use fmi_doors::log::Log;
//! use fmi_doors::{Advance, Base, Bases, Component, Instantiation, Life, Named, Phase, Problem};
//!
//! /// y follows u: y' = (u - y) / T.
//! #[derive(Debug)]
//! struct Lag {
//!     life: Life,
//!     time: f64,
//!     u: f64,
//!     y: f64,
//! }
//!
//! fmi_doors::export!(Lag);
//!
//! /// The time constant, s.
//! const T: f64 = 0.5;
//!
//! impl Lag {
//!     /// The variable of a reference: 1 is u, 2 is y.
//!     fn place(&mut self, reference: u32, bases: Bases) -> Result<&mut f64, Problem> {
//!         match reference {
//!             1 if bases.contains(Base::Real) => Ok(&mut self.u),
//!             2 if bases.contains(Base::Real) => Ok(&mut self.y),
//!             _ => Err(Problem::Reference { reference, wanted: bases.name, found: "there are 1 and 2".into() }),
//!         }
//!     }
//! }
//!
//! impl Component for Lag {
//!     type Problem = Problem;
//!     type State = (); // states cannot be saved
//!     type Pieces = (); // steps ask nothing in their course
//!
//!     fn instantiate(request: &Instantiation<'_>) -> Result<Self, Problem> {
//!         request.check_token("{lag}")?; // as in the description
//!         Ok(Self { life: request.life(), time: 0.0, u: 0.0, y: 0.0 })
//!     }
//!     fn life(&self) -> &Life {
//!         &self.life
//!     }
//!     fn life_mut(&mut self) -> &mut Life {
//!         &mut self.life
//!     }
//!     fn exit_initialization(&mut self, _: &mut dyn Log) -> Result<(), Problem> {
//!         self.time = self.life.start_time();
//!         self.life.begin();
//!         Ok(())
//!     }
//!     fn reset(&mut self) {
//!         *self = Self { life: Life::new(self.life.interface, self.life.handling), time: 0.0, u: 0.0, y: 0.0 };
//!     }
//!     fn time(&self) -> f64 {
//!         self.time
//!     }
//!     fn variable(&self, reference: u32) -> Result<Named<'_>, Problem> {
//!         let name = if reference == 1 { "u" } else { "y" };
//!         Ok(Named { name: name.into(), continuous_input: reference == 1, intermediate_update: false })
//!     }
//!     fn get(&mut self, bases: Bases, references: &[u32], mut write: impl FnMut(usize, f64)) -> Result<(), Problem> {
//!         for (i, &reference) in references.iter().enumerate() {
//!             write(i, *self.place(reference, bases)?);
//!         }
//!         Ok(())
//!     }
//!     fn set(&mut self, bases: Bases, references: &[u32], read: impl Fn(usize) -> f64) -> Result<(), Problem> {
//!         for (i, &reference) in references.iter().enumerate() {
//!             *self.place(reference, bases)? = read(i);
//!         }
//!         Ok(())
//!     }
//!     fn advance(&mut self, point: f64, size: f64, _: &mut dyn Log) -> Result<Advance, Problem> {
//!         self.life.check_step(point, size, self.time)?;
//!         self.y = self.u + (self.y - self.u) * (-size / T).exp();
//!         (self.time, self.life.phase) = (point + size, Phase::Step);
//!         Ok(Advance { time: self.time, event: false, early: false })
//!     }
//! }
//!
//! // A host's calls.
//! # use std::ptr::null;
//! let mut y = 0.0;
//! unsafe {
//!     let c = fmi2Instantiate(c"lag".as_ptr(), 1, c"{lag}".as_ptr(), null(), null(), 0, 0);
//!     assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), 0);
//!     assert_eq!(fmi2EnterInitializationMode(c), 0);
//!     assert_eq!(fmi2ExitInitializationMode(c), 0);
//!     assert_eq!(fmi2SetReal(c, &1, 1, &1.0), 0);
//!     assert_eq!(fmi2DoStep(c, 0.0, 0.5, 1), 0);
//!     assert_eq!(fmi2GetReal(c, &2, 1, &mut y), 0);
//!     fmi2FreeInstance(c);
//! }
//! assert!((y - (1.0 - (-1.0_f64).exp())).abs() < 1e-15);
//! ```
//!
//! `set` above takes any number at any time, which a component of use would not; `examples/bouncing_ball.rs` checks what it is given,
//! and has states, an event indicator, event mode, both interface types, saved states and a description; `examples/describe.rs` writes
//! that.

pub mod component;
pub mod description;
pub mod events;
pub mod ffi;
pub mod fmi2;
pub mod fmi3;
pub mod identifier;
pub mod instantiation;
pub mod life;
pub mod log;
pub mod messages;
pub mod problem;
pub mod values;

pub use component::Component;
pub use events::{Advance, EarlyEnd, Handled, Piece, StepOutcome, StepReason};
pub use instantiation::{Instantiation, Named, Version};
#[doc(hidden)]
pub use libc; // what the macros name
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
