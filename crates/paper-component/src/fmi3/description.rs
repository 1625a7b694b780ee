//! The parts of `modelDescription.xml` that do not come from the table (FMI 3.0.2, 2.4, 3.4 and
//! 4.4): capabilities, log categories, value references, and the additional model descriptions
//! that the library accepts.

use crate::component::identity;
use crate::component::identity::EVENTS;
pub use crate::component::identity::{
    AUTHOR, COPYRIGHT, LICENSE, MODEL_DESCRIPTION, MODEL_IDENTIFIER, NAMING_CONVENTION, VERSION,
    default_experiment,
};
use crate::component::settings::Settings;
use crate::component::structure::{self, STATES};
pub use crate::component::variables::Edition;
use crate::component::variables::{Access, Causality, Initial, Kind, Numbering, Variable};
use crate::description::Table;
use fmi_doors::description::{self, CoSimulation, Description, ModelExchange};
use fmi_doors::messages::{Category, log_categories};

/// The model description in the archive. Every importer can read it.
pub const MAIN: Edition = Edition::Extended;
/// A further description with arrays. It is separate, since several importers read every local
/// variable as a scalar.
pub const ARRAYS: Edition = Edition::Arrays;
/// A further description with arrays and a clock. It is separate, since several importers fail on
/// clocks that are outputs.
pub const CLOCKED: Edition = Edition::Clocked;

/// Capability flags (FMI 3.0.2, 2.4.2, 3.4 and 4.4); a flag that is missing here has its default.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Capabilities {
    /// Both interface types: `fmi3GetFMUState` and the related functions work.
    pub can_get_and_set_fmu_state: bool,
    /// Both: states can be serialized.
    pub can_serialize_fmu_state: bool,
    /// Both: `fmi3GetDirectionalDerivative` works.
    pub provides_directional_derivatives: bool,
    /// Both: `fmi3GetAdjointDerivative` works.
    pub provides_adjoint_derivatives: bool,
    /// Both: `fmi3GetVariableDependencies` works.
    pub provides_per_element_dependencies: bool,
    /// Model Exchange: `fmi3CompletedIntegratorStep` must be called.
    pub needs_completed_integrator_step: bool,
    /// Co-Simulation: any step size.
    pub can_handle_variable_communication_step_size: bool,
    /// Co-Simulation: highest order of `fmi3GetOutputDerivatives`.
    pub max_output_derivative_order: u32,
    /// Co-Simulation: order up to which derivatives of intermediate inputs should be continuous.
    /// The FMU interpolates inputs within a step by cubics.
    pub recommended_intermediate_input_smoothness: i32,
    /// Co-Simulation: the callback for intermediate updates is called.
    pub provides_intermediate_update: bool,
    /// Co-Simulation: a step may end at an event.
    pub might_return_early_from_do_step: bool,
    /// Co-Simulation: a step ends where the callback requests it.
    pub can_return_early_after_intermediate_update: bool,
    /// Co-Simulation: Event Mode.
    pub has_event_mode: bool,
}

/// Capabilities of this FMU.
pub const CAPABILITIES: Capabilities = Capabilities {
    can_get_and_set_fmu_state: true,
    can_serialize_fmu_state: true,
    provides_directional_derivatives: true,
    provides_adjoint_derivatives: true,
    provides_per_element_dependencies: true,
    // The energy accounts of Model Exchange are integrated at accepted steps.
    needs_completed_integrator_step: true,
    can_handle_variable_communication_step_size: true,
    max_output_derivative_order: 3,
    recommended_intermediate_input_smoothness: 3,
    provides_intermediate_update: true,
    might_return_early_from_do_step: true,
    can_return_early_after_intermediate_update: true,
    has_event_mode: true,
};

/// The log categories.
pub const LOG_CATEGORIES: [Category; 6] = log_categories(EVENTS, "Why a value was not taken");

/// Start values of the settings: the defaults, except that a step ends at an impact if the
/// importer allows early return. FMI 3.0 has a protocol for this.
pub fn start_settings() -> Settings {
    Settings { stop_at_impact: true, ..Settings::default() }
}

/// The value references of a description, numbered from 1 in the order of its variables:
/// OMSimulator mistakes value references for indices in ModelStructure and in `derivative`. So
/// these references differ from the table's own references, and are valid only for this
/// description.
pub const fn numbering(edition: Edition) -> Numbering {
    Numbering::counted(edition)
}

/// Value reference of the named variable in a description; `None` if the description does not
/// contain the variable.
pub fn value_reference(edition: Edition, name: &str) -> Option<u32> {
    variables(edition).find(|(_, variable)| variable.name == name).map(|(reference, _)| reference)
}

/// Every variable of a description with its value reference.
pub fn variables(edition: Edition) -> impl Iterator<Item = (u32, &'static Variable)> {
    numbering(edition).variables()
}

/// Name of the state whose derivative the variable is (attribute `derivative`). A state has no
/// such attribute, although velocities are derivatives of positions: importers would treat it as
/// both a state and a derivative.
pub fn derivative(variable: &Variable) -> Option<&'static str> {
    match variable.kind {
        Kind::Real { derivative_of, .. } if !STATES.contains(&variable.name) => derivative_of,
        _ => None,
    }
}

/// Whether a variable belongs to the clock of impacts.
pub fn is_clocked(variable: &Variable) -> bool {
    matches!(variable.access, Access::Tick(_)) && variable.kind != Kind::Clock
}

/// The symbol of docs/theory.md as an alias (FMI 3.0.2, 2.4.7.3), for variables that are set.
/// Other variables have none: some validators take the alias of a calculated output for an output
/// that is missing from the model's structure.
pub fn alias(variable: &Variable) -> Option<&'static str> {
    let set = variable.causality == Causality::Input || variable.initial == Some(Initial::Exact);
    variable.symbol.filter(|_| set)
}

/// `instantiationToken` of a description (FMI 3.0.2, 2.3.1): a hash of the version, variables,
/// units, types, capabilities, log categories and start settings. Computed again on each call, so
/// that the library keeps nothing between loads.
pub fn instantiation_token(edition: Edition) -> String {
    let own = format!("3.0 {edition:?} {CAPABILITIES:?} {LOG_CATEGORIES:?} {:?}\n", start_settings());
    identity::identifier(&(own + &identity::text()))
}

/// The description with a token.
pub fn edition_of(token: &str) -> Option<Edition> {
    [MAIN, ARRAYS, CLOCKED].into_iter().find(|edition| instantiation_token(*edition) == token)
}

/// Name of the clock of impacts.
const CLOCK: &str = "impacts.clock";

/// `modelName`: further descriptions have their own names; the library's name is
/// `modelIdentifier`.
pub fn model_name(edition: Edition) -> String {
    let suffix = match edition {
        ARRAYS => "Arrays",
        CLOCKED => "Clocked",
        _ => "",
    };
    format!("{MODEL_IDENTIFIER}{suffix}")
}

/// The complete model description. Variables of a clock are not among the unknowns of
/// initialization (FMI 3.0.2, 2.4.8). The clock itself is listed there because validators require
/// this, although a clock cannot have the attribute `initial`.
pub fn description(edition: Edition) -> Description {
    let can = CAPABILITIES;
    let table = Table { edition, numbering: numbering(edition), start: start_settings(), derivative };
    let clock = table.reference(CLOCK);
    let mut description = table.description();
    for (described, (_, variable)) in description.variables.iter_mut().zip(variables(edition)) {
        described.intermediate_update = variable.is_seen_within_steps();
        described.clock = clock.filter(|_| is_clocked(variable));
        described.alias = alias(variable).map(Into::into);
    }
    let clocked: Vec<u32> = variables(edition)
        .filter(|(_, variable)| is_clocked(variable))
        .map(|(reference, _)| reference)
        .collect();
    description.initial_unknowns.retain(|unknown| !clocked.contains(&unknown.reference));
    Description {
        model_name: model_name(edition).into(),
        token: instantiation_token(edition).into(),
        model_exchange: Some(ModelExchange {
            needs_completed_integrator_step: can.needs_completed_integrator_step,
            number_of_event_indicators: structure::EVENT_INDICATORS,
        }),
        co_simulation: Some(CoSimulation {
            can_handle_variable_communication_step_size: can.can_handle_variable_communication_step_size,
            can_interpolate_inputs: false,
            max_output_derivative_order: can.max_output_derivative_order,
            recommended_intermediate_input_smoothness: can.recommended_intermediate_input_smoothness,
            provides_intermediate_update: can.provides_intermediate_update,
            might_return_early_from_do_step: can.might_return_early_from_do_step,
            can_return_early_after_intermediate_update: can.can_return_early_after_intermediate_update,
            has_event_mode: can.has_event_mode,
        }),
        capabilities: description::Capabilities {
            can_get_and_set_fmu_state: can.can_get_and_set_fmu_state,
            can_serialize_fmu_state: can.can_serialize_fmu_state,
            provides_directional_derivatives: can.provides_directional_derivatives,
            provides_adjoint_derivatives: can.provides_adjoint_derivatives,
            provides_per_element_dependencies: can.provides_per_element_dependencies,
            can_be_instantiated_only_once_per_process: false,
        },
        log_categories: LOG_CATEGORIES.to_vec(),
        event_indicators: structure::event_indicators().iter().filter_map(|row| table.unknown(row)).collect(),
        ..description
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn each_description_has_a_token_of_its_own() {
        for edition in [MAIN, ARRAYS, CLOCKED] {
            assert_eq!(edition_of(&instantiation_token(edition)), Some(edition));
        }
        assert_eq!(edition_of(&instantiation_token(Edition::Every)), None);
        assert_eq!(edition_of("{}"), None);
    }

    #[test]
    fn value_references_are_places_counted_from_one() {
        for edition in [MAIN, ARRAYS, CLOCKED] {
            for (i, (reference, variable)) in (1..).zip(variables(edition)) {
                assert_eq!(reference, i, "{}", variable.name);
                assert_eq!(numbering(edition).variable(i).map(|v| v.name), Some(variable.name));
            }
            assert!(numbering(edition).variable(0).is_none());
        }
    }

    #[test]
    fn each_state_has_one_derivative_and_is_none() {
        let states = BTreeSet::from(STATES);
        let derivatives: Vec<_> = variables(CLOCKED).filter_map(|(_, v)| derivative(v)).collect();
        assert_eq!(derivatives.iter().copied().collect::<BTreeSet<_>>(), states);
        assert_eq!(derivatives.len(), states.len());
    }
}
