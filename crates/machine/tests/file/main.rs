//! The file of a machine: errors with their messages, round trips, damaged texts, parameters and
//! examples.

mod completion;
mod contacts;
mod damaged;
mod examples;
mod extremes;
mod grammar;
mod named;
mod parameters;
mod random;
mod refusals;
mod residual;
mod round_trip;
mod stepped;
