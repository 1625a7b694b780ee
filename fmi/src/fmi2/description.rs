//! What else `modelDescription.xml` says (FMI 2.0, 2.2.1, 3.3.1, 4.3.1): identity, capabilities, log categories,
//! default experiment.

use super::units::{ENUMERATION_TYPES, REAL_TYPES, UNITS};
use super::variables::VARIABLES;
use super::{structure, variables};
use std::fmt::Write;
use vibro_impact::parameters::Parameters;

/// `modelName` and `modelIdentifier`.
pub const MODEL_IDENTIFIER: &str = "VibroImpact3DOF";

/// `description` of the model.
pub const MODEL_DESCRIPTION: &str = "Three-degree-of-freedom vibro-impact system: a driven box, a block free between two stops inside it, \
     and a secondary oscillator coupled to the block; exact event-driven simulation and closed-form steady states";

/// `version` of the model.
pub const MODEL_VERSION: &str = env!("CARGO_PKG_VERSION");

/// `license` of the model.
pub const LICENSE: &str = env!("CARGO_PKG_LICENSE");

/// `variableNamingConvention`.
pub const NAMING_CONVENTION: &str = "structured";

/// `numberOfEventIndicators`: both gaps and the contact force in rest.
pub const EVENT_INDICATORS: usize = 3;

/// Capability flags of `CoSimulation` and, where they exist there, of `ModelExchange` (FMI 2.0, 4.3.1 and 3.3.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Capabilities {
    /// Both: runs without its tool.
    pub needs_execution_tool: bool,
    /// Model Exchange: `fmi2CompletedIntegratorStep` need not be called.
    pub completed_integrator_step_not_needed: bool,
    /// Co-Simulation: any step size.
    pub can_handle_variable_communication_step_size: bool,
    /// Co-Simulation: `fmi2SetRealInputDerivatives` works.
    pub can_interpolate_inputs: bool,
    /// Co-Simulation: highest order of `fmi2GetRealOutputDerivatives`.
    pub max_output_derivative_order: u32,
    /// Co-Simulation: `fmi2DoStep` may return `fmi2Pending`.
    pub can_run_asynchronuously: bool,
    /// Both: one instance per process.
    pub can_be_instantiated_only_once_per_process: bool,
    /// Both: own memory management.
    pub can_not_use_memory_management_functions: bool,
    /// Both: `fmi2GetFMUstate` and its kin work.
    pub can_get_and_set_fmu_state: bool,
    /// Both: states can be serialized.
    pub can_serialize_fmu_state: bool,
    /// Both: `fmi2GetDirectionalDerivative` works.
    pub provides_directional_derivative: bool,
}

/// What this FMU can do.
pub const CAPABILITIES: Capabilities = Capabilities {
    needs_execution_tool: false,
    // Accepted steps are where the energy accounts of Model Exchange are integrated.
    completed_integrator_step_not_needed: false,
    can_handle_variable_communication_step_size: true,
    can_interpolate_inputs: true,
    max_output_derivative_order: 3,
    can_run_asynchronuously: false,
    can_be_instantiated_only_once_per_process: false,
    can_not_use_memory_management_functions: true,
    can_get_and_set_fmu_state: true,
    can_serialize_fmu_state: true,
    provides_directional_derivative: true,
};

/// Whether `ModelExchange` is part of the archive.
pub const MODEL_EXCHANGE: bool = true;

/// A log category (FMI 2.0, 2.2.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Category {
    /// Name.
    pub name: &'static str,
    /// What it logs.
    pub description: &'static str,
}

/// The log categories, all of standard names.
pub const LOG_CATEGORIES: [Category; 6] = [
    Category { name: "logEvents", description: "Each impact, rest and release" },
    Category {
        name: "logStatusWarning",
        description: "Things worth knowing that do not stop the simulation",
    },
    Category { name: "logStatusDiscard", description: "Why a step ended early or a status is not available" },
    Category { name: "logStatusError", description: "Why a call was refused" },
    Category { name: "logStatusFatal", description: "Why the instance can no longer be used" },
    Category { name: "logAll", description: "All of the above" },
];

/// `DefaultExperiment` (FMI 2.0, 2.2.5).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Experiment {
    /// Start, s.
    pub start_time: f64,
    /// Stop, s: 100 periods of the default drive.
    pub stop_time: f64,
    /// Relative tolerance for solvers of Model Exchange.
    pub tolerance: f64,
    /// Reporting interval, s: 50 a period.
    pub step_size: f64,
}

/// The default experiment.
pub fn default_experiment() -> Experiment {
    let period = Parameters::default().period();
    Experiment { start_time: 0.0, stop_time: 100.0 * period, tolerance: 1e-8, step_size: period / 50.0 }
}

/// `guid`: a hash of everything the model description says and of the crate's version (FMI 2.0, 2.2.1).
/// Computed anew on each call, so that the library keeps nothing between loads.
pub fn guid() -> String {
    format_guid(fingerprint_hash())
}

/// A number in the form of a GUID.
pub fn format_guid(hash: u128) -> String {
    format!(
        "{{{:08x}-{:04x}-{:04x}-{:04x}-{:012x}}}",
        (hash >> 96) as u32,
        (hash >> 80) as u16,
        (hash >> 64) as u16,
        (hash >> 48) as u16,
        hash & 0xffff_ffff_ffff
    )
}

/// The number behind [`guid`].
pub fn fingerprint_hash() -> u128 {
    fnv1a(fingerprint().as_bytes())
}

/// The table as text, without its function pointers.
fn fingerprint() -> String {
    let mut text =
        format!("{MODEL_IDENTIFIER} {MODEL_VERSION} {CAPABILITIES:?} {MODEL_EXCHANGE} {EVENT_INDICATORS}\n");
    // Writing to a String cannot fail.
    let _ = writeln!(text, "{UNITS:?}\n{REAL_TYPES:?}\n{ENUMERATION_TYPES:?}\n{LOG_CATEGORIES:?}");
    for v in &VARIABLES {
        let variables::Variable {
            name,
            description,
            causality,
            variability,
            initial,
            kind,
            allowed,
            open_min,
            ..
        } = v;
        let _ = writeln!(
            text,
            "{name}|{description}|{causality:?}|{variability:?}|{initial:?}|{kind:?}|{allowed}|{open_min}|{:?}",
            v.start()
        );
    }
    let _ = writeln!(text, "{:?}\n{:?}", structure::outputs(), structure::derivatives());
    text
}

/// FNV-1a, 128 bit.
fn fnv1a(bytes: &[u8]) -> u128 {
    const OFFSET: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;
    bytes.iter().fold(OFFSET, |hash, byte| (hash ^ u128::from(*byte)).wrapping_mul(PRIME))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hash_is_fnv1a() {
        assert_eq!(fnv1a(b""), 0x6c62272e07bb014262b821756295c58d);
        assert_eq!(fnv1a(b"a"), 0xd228cb696f1a8caf78912b704e4a8964);
    }

    #[test]
    fn guid_has_the_usual_form() {
        let guid = guid();
        assert_eq!(guid.len(), 38);
        assert!(guid.starts_with('{') && guid.ends_with('}'));
        assert_eq!(guid.matches('-').count(), 4);
    }
}
