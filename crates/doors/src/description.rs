//! The contents of `modelDescription.xml` as plain data, and its text for both versions (FMI 2.0,
//! 2.2; FMI 3.0.2, 2.4).
//!
//! A component fills in a [`Description`]; [`xml`](Description::xml) writes it for a [`Version`].
//! Names and texts may be made at run time.

mod element;
mod fmi2;
mod fmi3;
mod variable;

pub use variable::{Causality, Initial, Kind, Unknown, Variability, Variable};

use crate::instantiation::Version;
use crate::messages::Category;
use std::borrow::Cow;

/// A text of a description.
pub type Text = Cow<'static, str>;

/// The complete model description. The text of one version leaves out all that only the other
/// version defines.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// `modelName`.
    pub model_name: Text,
    /// `modelIdentifier`: the name of the library's file. It is not used for anything else.
    pub model_identifier: Text,
    /// `guid`, `instantiationToken`: compared by
    /// [`Instantiation::check_token`](crate::Instantiation::check_token).
    pub token: Text,
    /// Description of the model.
    pub description: Text,
    /// Author of the model.
    pub author: Text,
    /// Version of the model.
    pub version: Text,
    /// Copyright of the model.
    pub copyright: Text,
    /// Licence.
    pub license: Text,
    /// Program that has written the description.
    pub generation_tool: Text,
    /// `generationDateAndTime`, if it is to be written.
    pub generation_date_and_time: Option<Text>,
    /// Whether the names of the variables have dots between their levels
    /// (`variableNamingConvention`).
    pub structured_names: bool,
    /// The interface type Model Exchange, if offered.
    pub model_exchange: Option<ModelExchange>,
    /// The interface type Co-Simulation, if offered.
    pub co_simulation: Option<CoSimulation>,
    /// Capabilities of both interface types.
    pub capabilities: Capabilities,
    /// Every unit that a type or a variable names.
    pub units: Vec<Unit>,
    /// Declared types.
    pub types: Vec<Type>,
    /// Log categories: [`log_categories`](crate::messages::log_categories).
    pub log_categories: Vec<Category>,
    /// Default experiment of a host.
    pub experiment: Experiment,
    /// The variables, in their order.
    pub variables: Vec<Variable>,
    /// Every output.
    pub outputs: Vec<Unknown>,
    /// The derivatives of the states, in the order of the states.
    pub derivatives: Vec<Unknown>,
    /// The unknowns of initialization.
    pub initial_unknowns: Vec<Unknown>,
    /// The event indicators that are variables, in their order.
    pub event_indicators: Vec<Unknown>,
}

impl Description {
    /// The text of `modelDescription.xml`.
    pub fn xml(&self, version: Version) -> String {
        let root = match version {
            Version::Fmi2 => fmi2::root(self),
            Version::Fmi3 => fmi3::root(self),
        };
        root.document()
    }
}

/// Capabilities of both interface types (FMI 2.0, 3.3.1 and 4.3.1; FMI 3.0.2, 2.4.2). `Default`
/// has none, as the default methods of [`Model`](crate::Model) provide none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Capabilities {
    /// States can be saved and restored.
    pub can_get_and_set_fmu_state: bool,
    /// Saved states can be turned into bytes.
    pub can_serialize_fmu_state: bool,
    /// Directional derivatives.
    pub provides_directional_derivatives: bool,
    /// FMI 3.0: adjoint derivatives.
    pub provides_adjoint_derivatives: bool,
    /// FMI 3.0: dependencies at run time.
    pub provides_per_element_dependencies: bool,
    /// At most one instance per process.
    pub can_be_instantiated_only_once_per_process: bool,
}

/// The interface type Model Exchange (FMI 2.0, 3.3.1; FMI 3.0.2, 3.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModelExchange {
    /// The host must report accepted steps.
    pub needs_completed_integrator_step: bool,
    /// Number of event indicators.
    pub number_of_event_indicators: usize,
}

/// The interface type Co-Simulation (FMI 2.0, 4.3.1; FMI 3.0.2, 4.4). `Default` takes steps of any
/// size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CoSimulation {
    /// Any step size.
    pub can_handle_variable_communication_step_size: bool,
    /// FMI 2.0: derivatives of inputs.
    pub can_interpolate_inputs: bool,
    /// Highest order of derivatives of outputs.
    pub max_output_derivative_order: u32,
    /// FMI 3.0: how smoothly inputs that are set within a step are joined.
    pub recommended_intermediate_input_smoothness: i32,
    /// FMI 3.0: steps call the host's callback.
    pub provides_intermediate_update: bool,
    /// FMI 3.0: a step may end at an event.
    pub might_return_early_from_do_step: bool,
    /// FMI 3.0: a step ends where the callback requests it.
    pub can_return_early_after_intermediate_update: bool,
    /// FMI 3.0: Event Mode.
    pub has_event_mode: bool,
}

impl Default for CoSimulation {
    fn default() -> Self {
        Self {
            can_handle_variable_communication_step_size: true,
            can_interpolate_inputs: false,
            max_output_derivative_order: 0,
            recommended_intermediate_input_smoothness: 0,
            provides_intermediate_update: false,
            might_return_early_from_do_step: false,
            can_return_early_after_intermediate_update: false,
            has_event_mode: false,
        }
    }
}

/// `DefaultExperiment`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Experiment {
    /// Start, s.
    pub start_time: f64,
    /// Stop, s.
    pub stop_time: f64,
    /// Relative tolerance for solvers.
    pub tolerance: f64,
    /// Step, s.
    pub step_size: f64,
}

/// A unit, made of SI base units without a factor, and its display units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Unit {
    /// Name, e.g. `N.s/m`.
    pub name: Text,
    /// Exponents of kg, m, s, A, K, mol, cd and rad.
    pub exponents: [i32; 8],
    /// Display units for the user's choice, with the factor from this unit.
    pub display: Vec<(Text, f64)>,
}

/// A declared type.
#[derive(Clone, Debug, PartialEq)]
pub struct Type {
    /// Its name.
    pub name: Text,
    /// Description.
    pub description: Text,
    /// Kind: Reals or an enumeration.
    pub kind: TypeKind,
}

impl Type {
    /// A Real with a quantity and a unit.
    pub fn real(name: impl Into<Text>, quantity: impl Into<Text>, unit: impl Into<Text>) -> Self {
        let name = name.into();
        let kind =
            TypeKind::Real { quantity: Some(quantity.into()), unit: Some(unit.into()), display_unit: None };
        Self { description: name.clone(), name, kind }
    }

    /// Unit and display unit of a Real.
    fn units(&self) -> (Option<Text>, Option<Text>) {
        match &self.kind {
            TypeKind::Real { unit, display_unit, .. } => (unit.clone(), display_unit.clone()),
            TypeKind::Enumeration(_) => (None, None),
        }
    }
}

/// The type specific part of a declared type.
#[derive(Clone, Debug, PartialEq)]
pub enum TypeKind {
    /// A Real.
    Real {
        /// Physical quantity.
        quantity: Option<Text>,
        /// Name of its unit.
        unit: Option<Text>,
        /// Display unit to show it in by default.
        display_unit: Option<Text>,
    },
    /// An enumeration.
    Enumeration(Vec<Item>),
}

/// One item of an enumeration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Item {
    /// Its name.
    pub name: Text,
    /// Its value.
    pub value: i32,
    /// Meaning.
    pub description: Text,
}
