//! Tests of the orbits, by what they are held against.

mod single;
mod scratch;
