//! FMI 2.0: the functions of the door for this component, and its description.

pub mod abi;
pub mod description;

pub use fmi_doors::fmi2::{instance, problem, states, status, types};
