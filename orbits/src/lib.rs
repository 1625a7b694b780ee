//! Periodic orbits with any impact word, stable or not, followed along a parameter with their
//! bifurcations (docs/theory.md, section 14).
//!
//! For given impact phases the motion is linear, so that an orbit of n impacts has n unknowns,
//! whatever it does in between.

mod balance;
mod branch;
mod coverage;
mod curve;
mod cycle;
mod family;
mod flights;
mod free;
mod grazing;
mod grower;
mod locus;
mod obstacle;
mod orbit;
mod path;
mod ranges;
mod search;
mod seeds;
mod settled;
mod special;
mod stored;
mod switching;
mod system;
mod test_functions;
mod trace;
mod tree;
mod tree_options;
mod word;

#[cfg(test)]
mod tests;

pub use branch::{Branch, Label, Point, Special};
pub use coverage::{Covering, TreeOrbit};
pub use family::{Family, Span};
pub use locus::{LocusEnd, LocusPoint, LocusStart, locus};
pub use orbit::Orbit;
pub use path::PathOptions;
pub use ranges::{Doubling, RangeEnd, StableRange, doubling_ratios, doubling_sequences};
pub use search::search;
pub use seeds::{Searched, SearchedValue};
pub use settled::{orbit_of, settle};
pub use system::{ConstantLoads, System};
pub use trace::{branch, tree, tree_in_parts};
pub use tree::Tree;
pub use tree_options::TreeOptions;
pub use word::OrbitWord;
