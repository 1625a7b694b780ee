//! The WebAssembly component of the FMUs of described machines, by the working draft of the
//! layered standard FMI-LS-WASM. One component serves all machines: it reads its machine from the
//! archive's resources by the host's `read-file`.
//!
//! The functions of WIT (`wit/fmi3.wit`) call the C functions of FMI 3.0 in the same memory. So
//! the component and the shared libraries have the same rules, statuses and messages. Like the
//! libraries, this file is a door; `call` wraps the unsafe calls.

mod call;
mod instance;

use crate::instance::{CoSimulation, ModelExchange};
use exports::fmi::fmi3::{co_simulation, common, model_exchange};

#[allow(missing_docs, unsafe_code, clippy::all)] // generated
mod bindings {
    wit_bindgen::generate!({ world: "machine-fmu", path: "wit", pub_export_macro: true });
}
use bindings::{exports, fmi};

/// The exported component.
struct Fmu;

impl common::Guest for Fmu {
    fn get_version() -> String {
        "3.0".into()
    }
}

impl co_simulation::Guest for Fmu {
    type CoSimulationInstance = CoSimulation;
}

impl model_exchange::Guest for Fmu {
    type ModelExchangeInstance = ModelExchange;
}

#[allow(unsafe_code)] // the exported functions
mod exported {
    use super::{Fmu, bindings};
    bindings::export!(Fmu with_types_in bindings);
}
