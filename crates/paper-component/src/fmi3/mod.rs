//! FMI 3.0: the functions of the door for this component, and its descriptions.

pub mod abi;
pub mod description;

pub use fmi_doors::fmi3::{instance, problem, states, status, types};
