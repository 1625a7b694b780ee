//! FMI 2.0: the functions of the door for this component, and what its description says.

pub mod abi;
pub mod description;

pub use fmi_doors::fmi2::{instance, problem, states, status, types};
