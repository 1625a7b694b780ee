//! The vibro-impact machine as an FMI component, and its doors to C.

pub mod fmi2;
