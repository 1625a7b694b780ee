//! The written files: the body, its basis, the report.

pub mod body;
pub mod npz;
