//! `modelDescription.xml` of FMI 2.0 (chapters 2.2, 3.3 and 4.3) as plain structs; field order is the schema's.

use serde::{Deserialize, Serialize};

/// Root element.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename = "fmiModelDescription")]
#[allow(missing_docs)] // the names are those of the standard, here and below
pub struct ModelDescription {
    #[serde(rename = "@fmiVersion")]
    pub fmi_version: String,
    #[serde(rename = "@modelName")]
    pub model_name: String,
    #[serde(rename = "@guid")]
    pub guid: String,
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
    #[serde(rename = "@numberOfEventIndicators", default, skip_serializing_if = "Option::is_none")]
    pub number_of_event_indicators: Option<usize>,
    #[serde(rename = "ModelExchange", default, skip_serializing_if = "Option::is_none")]
    pub model_exchange: Option<ModelExchange>,
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

macro_rules! element {
    ($(#[$meta:meta])* $name:ident { $($(#[$field_meta:meta])* $xml:literal $field:ident: $type:ty,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[allow(missing_docs)]
        pub struct $name { $($(#[$field_meta])* #[serde(rename = $xml)] pub $field: $type,)* }
    };
}

/// An interface type: what both have, with its own attributes where the schema has them.
macro_rules! interface {
    ($(#[$meta:meta])* $name:ident { $($xml:literal $field:ident: $type:ty,)* }) => {
        element! {
            $(#[$meta])*
            $name {
                "@modelIdentifier" model_identifier: String,
                "@needsExecutionTool" needs_execution_tool: bool,
                $($xml $field: $type,)*
                "@canBeInstantiatedOnlyOncePerProcess" only_once_per_process: bool,
                "@canNotUseMemoryManagementFunctions" no_memory_functions: bool,
                "@canGetAndSetFMUstate" get_and_set_state: bool,
                "@canSerializeFMUstate" serialize_state: bool,
                "@providesDirectionalDerivative" directional_derivative: bool,
            }
        }
    };
}

interface! {
    /// Interface type Model Exchange.
    ModelExchange {
        "@completedIntegratorStepNotNeeded" completed_integrator_step_not_needed: bool,
    }
}
interface! {
    /// Interface type Co-Simulation.
    CoSimulation {
        "@canHandleVariableCommunicationStepSize" variable_step: bool,
        "@canInterpolateInputs" interpolate_inputs: bool,
        "@maxOutputDerivativeOrder" max_output_derivative_order: u32,
        "@canRunAsynchronuously" asynchronous: bool,
    }
}
element! {
    /// All units.
    UnitDefinitions { "Unit" units: Vec<Unit>, }
}
element! {
    /// A unit.
    Unit {
        "@name" name: String,
        "BaseUnit" base: BaseUnit,
        #[serde(default)] "DisplayUnit" display: Vec<DisplayUnit>,
    }
}
element! {
    /// Exponents of the SI base units; absent means 0.
    BaseUnit {
        #[serde(default, skip_serializing_if = "Option::is_none")] "@kg" kg: Option<i32>,
        #[serde(default, skip_serializing_if = "Option::is_none")] "@m" m: Option<i32>,
        #[serde(default, skip_serializing_if = "Option::is_none")] "@s" s: Option<i32>,
        #[serde(default, skip_serializing_if = "Option::is_none")] "@rad" rad: Option<i32>,
    }
}
element! {
    /// A unit for people.
    DisplayUnit { "@name" name: String, "@factor" factor: f64, }
}
element! {
    /// All declared types.
    TypeDefinitions { "SimpleType" types: Vec<SimpleType>, }
}
element! {
    /// A declared type.
    SimpleType {
        "@name" name: String,
        "@description" description: String,
        "$value" kind: SimpleKind,
    }
}

/// Type specific part of a declared type.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub enum SimpleKind {
    Real(RealType),
    Enumeration(EnumerationType),
}

element! {
    /// A declared Real.
    RealType {
        "@quantity" quantity: String,
        "@unit" unit: String,
        #[serde(default, skip_serializing_if = "Option::is_none")] "@displayUnit" display_unit: Option<String>,
    }
}
element! {
    /// A declared enumeration.
    EnumerationType { "Item" items: Vec<Item>, }
}
element! {
    /// An item of an enumeration.
    Item { "@name" name: String, "@value" value: i32, "@description" description: String, }
}
element! {
    /// All log categories.
    LogCategories { "Category" categories: Vec<Category>, }
}
element! {
    /// A log category.
    Category { "@name" name: String, "@description" description: String, }
}
element! {
    /// The default experiment.
    DefaultExperiment {
        "@startTime" start: f64, "@stopTime" stop: f64, "@tolerance" tolerance: f64, "@stepSize" step: f64,
    }
}
element! {
    /// All variables.
    ModelVariables { "ScalarVariable" variables: Vec<ScalarVariable>, }
}
element! {
    /// A variable.
    ScalarVariable {
        "@name" name: String,
        "@valueReference" value_reference: u32,
        "@description" description: String,
        "@causality" causality: String,
        "@variability" variability: String,
        #[serde(default, skip_serializing_if = "Option::is_none")] "@initial" initial: Option<String>,
        "$value" kind: VariableKind,
    }
}

/// Type specific part of a variable.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub enum VariableKind {
    Real(Real),
    Integer(Integer),
    Boolean(Boolean),
    Enumeration(Enumeration),
}

element! {
    /// A Real variable; its unit is that of the declared type.
    Real {
        "@declaredType" declared_type: String,
        #[serde(default, skip_serializing_if = "Option::is_none")] "@unit" unit: Option<String>,
        #[serde(default, skip_serializing_if = "Option::is_none")] "@displayUnit" display_unit: Option<String>,
        #[serde(default, skip_serializing_if = "Option::is_none")] "@min" min: Option<f64>,
        #[serde(default, skip_serializing_if = "Option::is_none")] "@max" max: Option<f64>,
        #[serde(default, skip_serializing_if = "Option::is_none")] "@nominal" nominal: Option<f64>,
        #[serde(default, skip_serializing_if = "Option::is_none")] "@start" start: Option<f64>,
        #[serde(default, skip_serializing_if = "Option::is_none")] "@derivative" derivative: Option<u32>,
        #[serde(default, skip_serializing_if = "Option::is_none")] "@reinit" reinit: Option<bool>,
    }
}
element! {
    /// An Integer variable.
    Integer {
        #[serde(default, skip_serializing_if = "Option::is_none")] "@min" min: Option<i32>,
        #[serde(default, skip_serializing_if = "Option::is_none")] "@start" start: Option<i32>,
    }
}
element! {
    /// A Boolean variable.
    Boolean { #[serde(default, skip_serializing_if = "Option::is_none")] "@start" start: Option<bool>, }
}
element! {
    /// An Enumeration variable.
    Enumeration {
        "@declaredType" declared_type: String,
        #[serde(default, skip_serializing_if = "Option::is_none")] "@start" start: Option<i32>,
    }
}
element! {
    /// Which unknown depends on what.
    ModelStructure {
        "Outputs" outputs: Unknowns,
        "Derivatives" derivatives: Unknowns,
        "InitialUnknowns" initial_unknowns: Unknowns,
    }
}
element! {
    /// A list of unknowns.
    Unknowns { #[serde(default)] "Unknown" unknowns: Vec<Unknown>, }
}
element! {
    /// An unknown; `dependencies` absent means on everything, empty means on nothing.
    Unknown {
        "@index" index: u32,
        #[serde(default, skip_serializing_if = "Option::is_none")] "@dependencies" dependencies: Option<String>,
        #[serde(default, skip_serializing_if = "Option::is_none")] "@dependenciesKind" kinds: Option<String>,
    }
}

impl ScalarVariable {
    /// Whether it has a start value.
    pub fn has_start(&self) -> bool {
        match &self.kind {
            VariableKind::Real(v) => v.start.is_some(),
            VariableKind::Integer(v) => v.start.is_some(),
            VariableKind::Boolean(v) => v.start.is_some(),
            VariableKind::Enumeration(v) => v.start.is_some(),
        }
    }

    /// Index of the state whose derivative this is.
    pub fn derivative(&self) -> Option<u32> {
        match &self.kind {
            VariableKind::Real(real) => real.derivative,
            _ => None,
        }
    }
}
