//! Derivatives of a motion by the numbers of its machine, through impacts, contacts and sticking
//! (docs/assembly-law.md, section 14).
//!
//! A machine's numbers enter through rows and matrices, which are differentiated in closed form:
//! `tangent` has what a parameter changes in the machine, `mode` what it changes in z' = A z.
//! `flight` carries derivatives between events, `crossing` and `impulse` over them, `start` and
//! `rest` begin them; `resting` says which contacts at rest come to rest again when they are moved.
//! A [`Differentiated`] motion puts these together. It drives an ordinary
//! [`Motion`](crate::Motion), which has the bits that it has alone.

mod adjoint;
mod blocks;
mod bodies;
mod branches;
mod by;
mod columns;
mod crossing;
mod differentiated;
mod extremes;
mod flight;
mod gradient;
mod impulse;
mod jump;
mod lost;
mod machine;
mod mode;
mod passed;
mod rest;
mod resting;
mod rows;
mod samples;
mod series;
mod start;
mod tangent;
mod values;
mod weights;

pub use by::{By, has_derivative};
pub use differentiated::{Differentiated, VariedObserver};
pub use extremes::{Extreme, Extremes};
pub use gradient::Gradient;
pub use lost::{Cause, Lost};
