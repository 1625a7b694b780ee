//! The C interface of FMI 3.0 to this component.

use crate::component::Instance;
pub use fmi_doors::fmi3::abi::{FmiInstance, FmiIntermediateUpdate, FmiLogMessage};

fmi_doors::export_fmi3!(Instance);
