//! Periodic orbits with any impact word, stable or not, followed along a parameter with their
//! bifurcations (docs/theory.md, section 14).
//!
//! For given impact phases the motion is linear. An orbit of n impacts therefore has n unknowns,
//! its impact phases.
//!
//! The way from a word to a tree of branches:
//!
//! - `system` is the machine in an orbit's units, `cycle` the linear part for given phases,
//!   `orbit` Newton's method and the certificate that no other impact occurs.
//! - `family` and `path` take the steps requested by the follower of all machines' branches
//!   (`crate::path`); `special` and `grazing` locate bifurcations and touches by equations that
//!   are regular there; `switching` starts branches at them.
//! - `seeds`, `grower` and `trace` grow the tree; `ranges` and `coverage` read it; `locus` follows
//!   a special point in two parameters.
//!
//! Two properties must survive every change. First, the result depends neither on the number of
//! threads nor on interruptions: batches have a constant size (`grower`), and finished parts of a
//! tree are kept bit for bit (`crate::stored`). Second, the equations of motion and the impact law
//! are taken from the closed forms (`vibro_impact::steady`), never from the simulator, which is
//! the oracle of the tests (docs/design.md, "Oracles and shared code").
//!
//! A new type of special point needs a [`Label`], a test function in `test_functions` (a zero) or
//! an announcement in `grazing` (a touch), its departure in `switching`, and, if it has a curve in
//! two parameters, a condition in `locus/equations.rs`.

mod balance;
mod branch;
mod coverage;
mod cycle;
mod family;
mod flights;
mod free;
mod grazing;
mod grower;
mod locus;
mod orbit;
mod path;
mod ranges;
mod refusal;
mod sample;
mod search;
mod seeds;
mod settled;
mod special;
mod switching;
mod system;
mod trace;
mod tree;
mod tree_options;

#[cfg(test)]
mod tests;

pub use crate::stop_word::OrbitWord;
pub use crate::{Label, LocusEnd, LocusPoint, OrbitPoint, PathOptions, Special};
pub use branch::Branch;
pub use coverage::{Covering, TreeOrbit};
pub use family::{Family, Span};
pub use locus::{LocusStart, locus};
pub use orbit::Orbit;
pub use ranges::{Doubling, RangeEnd, StableRange, doubling_ratios, doubling_sequences};
pub use search::search;
pub use seeds::{Searched, SearchedValue};
pub use settled::{orbit_of, settle};
pub use system::{ConstantLoads, System};
pub use trace::{branch, tree, tree_in_parts};
pub use tree::Tree;
pub use tree_options::TreeOptions;
