//! Exact motions of machines described by a text file, piecewise linear except for curved forces:
//! rigid and flexible bodies, springs and dashpots, rigid links, rigid and compliant stops,
//! freewheels, Coulomb friction, loads and blocks.
//!
//! ```text
//! file → description → system → law (impacts, selection) → linear → flow → motion → energy
//! ```
//!
//! `docs/assembly-law.md` states the law, `docs/machine-file.md` the grammar of the file.
#![forbid(unsafe_code)]

// The Rust block of the package's page is run with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeBlocks;

pub mod assembly;
mod check;
pub mod components;
pub mod curved;
pub mod derivative;
pub mod description;
pub mod elements;
pub mod energy;
pub mod error;
pub mod file;
pub mod flow;
pub mod following;
pub mod formula;
pub mod functional;
mod kernel;
mod kinds;
pub mod law;
pub mod linear;
pub mod mode;
pub mod motion;
pub mod named;
pub mod neutral;
pub mod norm;
pub mod parameters;
mod part;
mod polyline;
pub mod quantity;
mod rates;
pub mod refusal;
pub mod rest;
mod serialized;
pub mod signals;
mod slots;
pub mod sparse_factor;
pub mod start;
pub mod steep;
mod stepped;
pub mod system;
pub mod table;
mod vectors;
mod what;

pub use assembly::Assembly;
pub use derivative::Differentiated;
pub use description::Description;
pub use elements::Element;
pub use error::Error;
pub use motion::Motion;
pub use parameters::Parameter;
pub use quantity::{Owner, Quantity, What};
pub use refusal::{Problem, Refusal};
pub use start::Start;
