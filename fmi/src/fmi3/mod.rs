//! The FMI 3.0 door: what the standard says of the [component](crate::component). Clauses are those of *Functional Mock-up
//! Interface Specification*, version 3.0.2.

pub mod description;
