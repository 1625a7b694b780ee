//! What else than the table `modelDescription.xml` says (FMI 3.0.2, 2.4, 3.4 and 4.4): capabilities, log categories, references,
//! and the two descriptions of one library.

use crate::component::identity;
pub use crate::component::identity::{
    LICENSE, MODEL_DESCRIPTION, MODEL_IDENTIFIER, NAMING_CONVENTION, VERSION, default_experiment,
};
use crate::component::settings::Settings;
use crate::component::structure::STATES;
pub use crate::component::variables::Edition;
use crate::component::variables::{
    Access, Causality, Initial, Kind, Variability, Variable, find, of_edition,
};
use crate::messages::{Category, log_categories};

/// The description of the archive that every importer can read.
pub const MAIN: Edition = Edition::Extended;
/// The second description, with a clock. Several importers break on clocks that are outputs.
pub const CLOCKED: Edition = Edition::Clocked;

/// Capability flags (FMI 3.0.2, 2.4.3, 3.4 and 4.4); one that is absent here has its default.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Capabilities {
    /// Both interface types: `fmi3GetFMUState` and its kin work.
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
    /// Co-Simulation: inputs that are set within a step are joined by cubics.
    pub recommended_intermediate_input_smoothness: i32,
    /// Co-Simulation: the callback for intermediate updates is called.
    pub provides_intermediate_update: bool,
    /// Co-Simulation: a step may end at an event.
    pub might_return_early_from_do_step: bool,
    /// Co-Simulation: a step ends where the callback asks for it.
    pub can_return_early_after_intermediate_update: bool,
    /// Co-Simulation: Event Mode.
    pub has_event_mode: bool,
}

/// What this FMU can do.
pub const CAPABILITIES: Capabilities = Capabilities {
    can_get_and_set_fmu_state: true,
    can_serialize_fmu_state: true,
    provides_directional_derivatives: true,
    provides_adjoint_derivatives: true,
    provides_per_element_dependencies: true,
    // Accepted steps are where the energy accounts of Model Exchange are integrated.
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
pub const LOG_CATEGORIES: [Category; 6] = log_categories("Why a value was not taken");

/// What an instance starts from: the settings of every description, but a step returns at an event where the importer allows
/// it, since FMI 3.0 has a protocol for that.
pub fn start_settings() -> Settings {
    Settings { stop_at_impact: true, ..Settings::default() }
}

/// Value reference of a place in the table: they count from 1, in the order of the description. Some importers take value
/// references for places.
pub const fn value_reference(place: u32) -> u32 {
    place + 1
}

/// Place of a value reference in the table; none for 0.
pub const fn place(value_reference: u32) -> Option<u32> {
    value_reference.checked_sub(1)
}

/// Every variable of a description with its value reference.
pub fn variables(edition: Edition) -> impl Iterator<Item = (u32, &'static Variable)> {
    of_edition(edition).map(|(place, variable)| (value_reference(place), variable))
}

/// Value reference of the variable whose derivative this is. A state has no such attribute, although velocities are
/// derivatives: importers would take it for a state and a derivative.
pub fn derivative(variable: &Variable) -> Option<u32> {
    match variable.kind {
        Kind::Real { derivative_of: Some(of), .. } if !STATES.contains(&variable.name) => {
            Some(value_reference(find(of)?.0))
        }
        _ => None,
    }
}

/// Whether a variable can be set or read in Intermediate Update Mode (FMI 3.0.2, 4.2.2): continuous inputs and outputs.
pub fn intermediate_update(variable: &Variable) -> bool {
    matches!(variable.causality, Causality::Input | Causality::Output)
        && variable.variability == Variability::Continuous
}

/// Whether a variable belongs to the clock of impacts.
pub fn is_clocked(variable: &Variable) -> bool {
    matches!(variable.access, Access::Tick(_)) && variable.kind != Kind::Clock
}

/// The symbol of docs/theory.md as an alias (FMI 3.0.2, 2.4.7.3), for what is set and for time. Validators exist that take the
/// alias of a calculated output for an output that is missing from the model's structure.
pub fn alias(variable: &Variable) -> Option<&'static str> {
    let set = variable.causality == Causality::Input || variable.initial == Some(Initial::Exact);
    variable.symbol.filter(|_| set)
}

/// `instantiationToken` of a description: a hash of everything that it says (FMI 3.0.2, 2.3.1). Computed anew on each call, so
/// that the library keeps nothing between loads.
pub fn instantiation_token(edition: Edition) -> String {
    let own = format!("3.0 {edition:?} {CAPABILITIES:?} {LOG_CATEGORIES:?} {:?}\n", start_settings());
    identity::identifier(&(own + &identity::text()))
}

/// The description that a token belongs to.
pub fn edition_of(token: &str) -> Option<Edition> {
    [MAIN, CLOCKED].into_iter().find(|edition| instantiation_token(*edition) == token)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn each_description_has_a_token_of_its_own() {
        for edition in [MAIN, CLOCKED] {
            assert_eq!(edition_of(&instantiation_token(edition)), Some(edition));
        }
        assert_eq!(edition_of(&instantiation_token(Edition::Every)), None);
        assert_eq!(edition_of("{}"), None);
    }

    #[test]
    fn value_references_are_places_counted_from_one() {
        for (i, (reference, variable)) in (1..).zip(variables(MAIN)) {
            assert_eq!(reference, i, "{}", variable.name);
            assert_eq!(place(reference), Some(i - 1));
        }
        assert_eq!(place(0), None);
    }

    #[test]
    fn each_state_has_one_derivative_and_is_none() {
        let states: BTreeSet<u32> =
            STATES.iter().map(|name| value_reference(find(name).unwrap().0)).collect();
        let derivatives: Vec<u32> = variables(CLOCKED).filter_map(|(_, v)| derivative(v)).collect();
        assert_eq!(derivatives.iter().copied().collect::<BTreeSet<_>>(), states);
        assert_eq!(derivatives.len(), states.len());
    }
}
