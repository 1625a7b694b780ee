//! Exact motions of any piecewise linear machine: bodies with one coordinate each, springs and dashpots, rigid links, rigid and
//! compliant stops, Coulomb friction and loads, written as a text file.
#![forbid(unsafe_code)]

pub mod description;

pub use description::Description;
