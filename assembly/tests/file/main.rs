//! The file of a machine: what is refused and how, that what is written reads back, that no text
//! breaks the reader, and that the examples are machines.

mod damaged;
mod examples;
mod grammar;
mod parameters;
mod random;
mod refusals;
mod round_trip;
