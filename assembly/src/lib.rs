//! Exact motions of any piecewise linear machine: bodies with one coordinate each, springs and dashpots, rigid links, rigid and
//! compliant stops, Coulomb friction and loads, written as a text file.
//!
//! ```text
//! description → system → law (impacts, selection) → mode → flow → motion → energy
//! ```
#![forbid(unsafe_code)]

pub mod assembly;
pub mod description;
pub mod energy;
pub mod error;
pub mod flow;
pub mod law;
pub mod mode;
pub mod motion;
pub mod signals;
pub mod system;

pub use assembly::Assembly;
pub use description::Description;
pub use error::Error;
pub use motion::Motion;
