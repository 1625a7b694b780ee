//! `modelDescription.xml` of FMI 3.0 (2.4, 3.4 and 4.4) as plain structs; field order is the schema's.

use crate::schema::{DefaultExperiment, Item, LogCategories, UnitDefinitions};
use serde::{Deserialize, Serialize};

/// An element: attributes and children that it always has, then optional attributes, then children of which there may be none.
macro_rules! element {
    ($(#[$meta:meta])* $name:ident {
        $($xml:literal $field:ident: $type:ty,)*
        $(; $($option:literal $optional:ident: $of:ty,)* $(; $($child:literal $list:ident: $element:ty,)*)?)?
    }) => {
        $(#[$meta])*
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        #[serde(default)]
        #[allow(missing_docs)] // the names are those of the standard
        pub struct $name {
            $(#[serde(rename = $xml)] pub $field: $type,)*
            $($(#[serde(rename = $option, skip_serializing_if = "Option::is_none")] pub $optional: Option<$of>,)*
            $($(#[serde(rename = $child, skip_serializing_if = "Vec::is_empty")] pub $list: Vec<$element>,)*)?)?
        }
    };
}

/// Root element.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename = "fmiModelDescription")]
#[allow(missing_docs)]
pub struct ModelDescription {
    #[serde(rename = "@fmiVersion")]
    pub fmi_version: String,
    #[serde(rename = "@modelName")]
    pub model_name: String,
    #[serde(rename = "@instantiationToken")]
    pub instantiation_token: String,
    #[serde(rename = "@description")]
    pub description: String,
    #[serde(rename = "@author")]
    pub author: String,
    #[serde(rename = "@version")]
    pub version: String,
    #[serde(rename = "@copyright")]
    pub copyright: String,
    #[serde(rename = "@license")]
    pub license: String,
    #[serde(rename = "@generationTool")]
    pub generation_tool: String,
    #[serde(rename = "@generationDateAndTime", default, skip_serializing_if = "Option::is_none")]
    pub generation_date_and_time: Option<String>,
    #[serde(rename = "@variableNamingConvention")]
    pub variable_naming_convention: String,
    #[serde(rename = "ModelExchange")]
    pub model_exchange: ModelExchange,
    #[serde(rename = "CoSimulation")]
    pub co_simulation: CoSimulation,
    #[serde(rename = "UnitDefinitions")]
    pub unit_definitions: UnitDefinitions,
    #[serde(rename = "TypeDefinitions")]
    pub type_definitions: TypeDefinitions,
    #[serde(rename = "LogCategories")]
    pub log_categories: LogCategories,
    #[serde(rename = "DefaultExperiment")]
    pub default_experiment: DefaultExperiment,
    #[serde(rename = "ModelVariables")]
    pub model_variables: ModelVariables,
    #[serde(rename = "ModelStructure")]
    pub model_structure: ModelStructure,
}

element! {
    /// Interface type Model Exchange.
    ModelExchange {
        "@modelIdentifier" model_identifier: String,
        "@canGetAndSetFMUState" get_and_set_state: bool,
        "@canSerializeFMUState" serialize_state: bool,
        "@providesDirectionalDerivatives" directional_derivatives: bool,
        "@providesAdjointDerivatives" adjoint_derivatives: bool,
        "@providesPerElementDependencies" per_element_dependencies: bool,
        "@needsCompletedIntegratorStep" needs_completed_integrator_step: bool,
    }
}
element! {
    /// Interface type Co-Simulation.
    CoSimulation {
        "@modelIdentifier" model_identifier: String,
        "@canGetAndSetFMUState" get_and_set_state: bool,
        "@canSerializeFMUState" serialize_state: bool,
        "@providesDirectionalDerivatives" directional_derivatives: bool,
        "@providesAdjointDerivatives" adjoint_derivatives: bool,
        "@providesPerElementDependencies" per_element_dependencies: bool,
        "@canHandleVariableCommunicationStepSize" variable_step: bool,
        "@maxOutputDerivativeOrder" max_output_derivative_order: u32,
        "@recommendedIntermediateInputSmoothness" intermediate_input_smoothness: i32,
        "@providesIntermediateUpdate" intermediate_update: bool,
        "@mightReturnEarlyFromDoStep" might_return_early: bool,
        "@canReturnEarlyAfterIntermediateUpdate" can_return_early: bool,
        "@hasEventMode" event_mode: bool,
    }
}
element! {
    /// All declared types.
    TypeDefinitions { "$value" types: Vec<Type>, }
}

/// A declared type.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub enum Type {
    Float64Type(Float64Type),
    EnumerationType(EnumerationType),
}

impl Type {
    /// Its name.
    pub fn name(&self) -> &str {
        match self {
            Self::Float64Type(declared) => &declared.name,
            Self::EnumerationType(declared) => &declared.name,
        }
    }
}

element! {
    /// A declared Float64.
    Float64Type {
        "@name" name: String,
        "@description" description: String,
        ;
        "@quantity" quantity: String,
        "@unit" unit: String,
        "@displayUnit" display_unit: String,
    }
}
element! {
    /// A declared enumeration.
    EnumerationType { "@name" name: String, "@description" description: String, "Item" items: Vec<Item>, }
}
element! {
    /// All variables.
    ModelVariables { "$value" variables: Vec<Variable>, }
}

/// A variable of one of the types that are used.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub enum Variable {
    Float64(Attributes),
    Int32(Attributes),
    Boolean(Attributes),
    Enumeration(Attributes),
    Clock(Attributes),
}

impl Variable {
    /// What is said of it.
    pub fn attributes(&self) -> &Attributes {
        match self {
            Self::Float64(a) | Self::Int32(a) | Self::Boolean(a) | Self::Enumeration(a) | Self::Clock(a) => a,
        }
    }

    /// The same, to be changed.
    pub fn attributes_mut(&mut self) -> &mut Attributes {
        match self {
            Self::Float64(a) | Self::Int32(a) | Self::Boolean(a) | Self::Enumeration(a) | Self::Clock(a) => a,
        }
    }
}

element! {
    /// Attributes and elements of all types; one that a type does not have is absent there. Start values are text, since a
    /// Boolean's are words.
    Attributes {
        "@name" name: String,
        "@valueReference" value_reference: u32,
        "@description" description: String,
        "@causality" causality: String,
        "@variability" variability: String,
        ;
        "@initial" initial: String,
        "@declaredType" declared_type: String,
        "@unit" unit: String,
        "@displayUnit" display_unit: String,
        "@min" min: f64,
        "@max" max: f64,
        "@nominal" nominal: f64,
        "@start" start: String,
        "@derivative" derivative: u32,
        "@reinit" reinit: bool,
        "@intermediateUpdate" intermediate_update: bool,
        "@clocks" clocks: String,
        "@intervalVariability" interval_variability: String,
        ;
        "Dimension" dimensions: Dimension,
        "Alias" aliases: Alias,
    }
}
element! {
    /// Length of an array in one direction.
    Dimension { "@start" start: u64, }
}
element! {
    /// Another name.
    Alias { "@name" name: String, }
}
element! {
    /// Which unknown depends on what.
    ModelStructure {
        ;
        ;
        "Output" outputs: Unknown,
        "ContinuousStateDerivative" derivatives: Unknown,
        "InitialUnknown" initial_unknowns: Unknown,
        "EventIndicator" event_indicators: Unknown,
    }
}
element! {
    /// An unknown; importers exist that need both lists, empty ones too.
    Unknown {
        "@valueReference" value_reference: u32,
        ;
        "@dependencies" dependencies: String,
        "@dependenciesKind" kinds: String,
    }
}
