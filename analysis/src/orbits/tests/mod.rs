//! Tests of the orbits, by what they are held against.

mod branches;
mod coverage;
mod golden;
mod ranges;
mod single;
mod trees;
