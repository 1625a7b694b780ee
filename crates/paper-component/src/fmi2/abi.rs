//! The C interface of FMI 2.0 to this component.

use crate::component::Instance;
pub use fmi_doors::fmi2::abi::{FmiCallbackFunctions, FmiComponent, FmiLogger};

fmi_doors::export_fmi2!(Instance);
