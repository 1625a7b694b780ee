//! Tests of the orbits, by subject.

mod branches;
mod coverage;
mod curves;
mod exponents;
mod free_block;
mod golden;
mod islands;
mod plastic;
mod ranges;
mod resonance;
mod rows;
mod settled;
mod single;
mod soft_springs;
mod trees;
