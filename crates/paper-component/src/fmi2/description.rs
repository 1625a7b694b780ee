//! The parts of `modelDescription.xml` that do not come from the table (FMI 2.0, 2.2.1, 3.3.1,
//! 4.3.1): identity, capabilities, log categories, default experiment.

use crate::component::identity;
use crate::component::identity::EVENTS;
pub use crate::component::identity::{
    AUTHOR, COPYRIGHT, LICENSE, MODEL_DESCRIPTION, MODEL_IDENTIFIER, NAMING_CONVENTION, default_experiment,
};
use crate::component::settings::Settings;
pub use crate::component::structure::EVENT_INDICATORS;
pub use crate::component::variables::Edition;
use crate::component::variables::{Kind, Numbering, Variable};
use crate::description::Table;
use fmi_doors::description::{self, CoSimulation, Description, ModelExchange};
use fmi_doors::messages::{Category, log_categories};

/// `version` of the model.
pub const MODEL_VERSION: &str = identity::VERSION;

/// Capability flags of `CoSimulation` and, if it has them, of `ModelExchange` (FMI 2.0, 4.3.1 and
/// 3.3.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Capabilities {
    /// Both: needs its tool to run.
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
    /// Both: does not use the host's memory functions.
    pub can_not_use_memory_management_functions: bool,
    /// Both: `fmi2GetFMUstate` and the related functions work.
    pub can_get_and_set_fmu_state: bool,
    /// Both: states can be serialized.
    pub can_serialize_fmu_state: bool,
    /// Both: `fmi2GetDirectionalDerivative` works.
    pub provides_directional_derivative: bool,
}

/// Capabilities of this FMU.
pub const CAPABILITIES: Capabilities = Capabilities {
    needs_execution_tool: false,
    // The energy accounts of Model Exchange are integrated at accepted steps.
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

/// The log categories, all with standard names.
pub const LOG_CATEGORIES: [Category; 6] =
    log_categories(EVENTS, "Why a step ended early or a status is not available");

/// The value references: the table's own.
pub const NUMBERING: Numbering = Numbering::EVERY;

/// Every variable of this version with its value reference.
pub fn variables() -> impl Iterator<Item = (u32, &'static Variable)> {
    NUMBERING.variables()
}

/// `guid`: a hash of the variables, capabilities and log categories of the model description, and
/// of the crate's version (FMI 2.0, 2.2.1). Computed again on each call, as [`identity::number`].
pub fn guid() -> String {
    let own = format!("{MODEL_IDENTIFIER} {CAPABILITIES:?} {MODEL_EXCHANGE} {LOG_CATEGORIES:?}\n");
    identity::identifier(&(own + &identity::text()))
}

/// The content of the model description.
pub fn description() -> Description {
    let Capabilities {
        needs_execution_tool: _,
        completed_integrator_step_not_needed,
        can_handle_variable_communication_step_size,
        can_interpolate_inputs,
        max_output_derivative_order,
        can_run_asynchronuously: _,
        can_be_instantiated_only_once_per_process,
        can_not_use_memory_management_functions: _,
        can_get_and_set_fmu_state,
        can_serialize_fmu_state,
        provides_directional_derivative,
    } = CAPABILITIES;
    let derivative: fn(&Variable) -> _ = |variable| match variable.kind {
        Kind::Real { derivative_of, .. } => derivative_of,
        _ => None,
    };
    let table =
        Table { edition: Edition::Every, numbering: NUMBERING, start: Settings::default(), derivative };
    Description {
        token: guid().into(),
        model_exchange: MODEL_EXCHANGE.then_some(ModelExchange {
            needs_completed_integrator_step: !completed_integrator_step_not_needed,
            number_of_event_indicators: EVENT_INDICATORS,
        }),
        co_simulation: Some(CoSimulation {
            can_handle_variable_communication_step_size,
            can_interpolate_inputs,
            max_output_derivative_order,
            ..CoSimulation::default()
        }),
        capabilities: description::Capabilities {
            can_get_and_set_fmu_state,
            can_serialize_fmu_state,
            provides_directional_derivatives: provides_directional_derivative,
            can_be_instantiated_only_once_per_process,
            ..description::Capabilities::default()
        },
        log_categories: LOG_CATEGORIES.to_vec(),
        ..table.description()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn guid_has_the_usual_form() {
        let guid = guid();
        assert_eq!(guid.len(), 38);
        assert!(guid.starts_with('{') && guid.ends_with('}'));
        assert_eq!(guid.matches('-').count(), 4);
    }
}
