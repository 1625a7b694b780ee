//! `modelDescription.xml` of FMI 3.0: its structs, made from the table of variables, and checked.

pub mod check;
pub mod describe;
pub mod schema;

pub use describe::{from_xml, model_description};
