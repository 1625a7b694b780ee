//! Exact motions of any piecewise linear machine: bodies with one coordinate each, springs and dashpots, rigid links, rigid and
//! compliant stops, Coulomb friction and loads, written as a text file.
#![forbid(unsafe_code)]

mod check;
pub mod description;
pub mod file;
mod kinds;
pub mod parameters;
pub mod refusal;

pub use description::Description;
pub use parameters::Parameter;
pub use refusal::{Problem, Refusal};
