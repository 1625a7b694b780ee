//! From the variable table to `modelDescription.xml` of FMI 3.0.

use super::schema::*;
use crate::describe::{causality, enumeration_items, kind_name, unit, variability};
use crate::error::{Error, Result};
use crate::schema::{Category, DefaultExperiment, LogCategories, UnitDefinitions};
use vibro_fmi::component::structure::{self, Unknown as Row};
use vibro_fmi::component::units;
use vibro_fmi::component::variables::{self, Edition, Initial, Kind};
use vibro_fmi::fmi3::description;

/// The model description of an edition, made from the table.
pub fn model_description(edition: Edition) -> ModelDescription {
    let experiment = description::default_experiment();
    ModelDescription {
        fmi_version: "3.0".into(),
        model_name: model_name(edition),
        instantiation_token: description::instantiation_token(edition),
        description: description::MODEL_DESCRIPTION.into(),
        author: description::AUTHOR.into(),
        version: description::VERSION.into(),
        copyright: description::COPYRIGHT.into(),
        license: description::LICENSE.into(),
        generation_tool: concat!("fmu-build ", env!("CARGO_PKG_VERSION")).into(),
        generation_date_and_time: None,
        variable_naming_convention: description::NAMING_CONVENTION.into(),
        model_exchange: model_exchange(),
        co_simulation: co_simulation(),
        unit_definitions: UnitDefinitions { units: units::UNITS.iter().map(unit).collect() },
        type_definitions: TypeDefinitions { types: types(edition) },
        log_categories: LogCategories {
            categories: description::LOG_CATEGORIES
                .iter()
                .map(|c| Category { name: c.name.into(), description: c.description.into() })
                .collect(),
        },
        default_experiment: DefaultExperiment {
            start: experiment.start_time,
            stop: experiment.stop_time,
            tolerance: experiment.tolerance,
            step: experiment.step_size,
        },
        model_variables: ModelVariables {
            variables: description::variables(edition).map(|row| variable(row, edition)).collect(),
        },
        model_structure: ModelStructure {
            outputs: unknowns(&structure::outputs(edition), edition),
            derivatives: unknowns(&structure::derivatives(edition), edition),
            initial_unknowns: unknowns(&initial_unknowns(edition), edition),
            event_indicators: unknowns(&structure::event_indicators(), edition),
        },
    }
}

/// `modelName`: further descriptions have names of their own; the library's name is `modelIdentifier`.
pub fn model_name(edition: Edition) -> String {
    let suffix = match edition {
        description::ARRAYS => "Arrays",
        description::CLOCKED => "Clocked",
        _ => "",
    };
    format!("{}{suffix}", description::MODEL_IDENTIFIER)
}

/// The model description of a text.
///
/// # Errors
/// [`Error::Xml`] when the text is none.
pub fn from_xml(text: &str) -> Result<ModelDescription> {
    quick_xml::de::from_str(text).map_err(|e| Error::Xml(e.to_string()))
}

fn model_exchange() -> ModelExchange {
    let can = description::CAPABILITIES;
    ModelExchange {
        model_identifier: description::MODEL_IDENTIFIER.into(),
        get_and_set_state: can.can_get_and_set_fmu_state,
        serialize_state: can.can_serialize_fmu_state,
        directional_derivatives: can.provides_directional_derivatives,
        adjoint_derivatives: can.provides_adjoint_derivatives,
        per_element_dependencies: can.provides_per_element_dependencies,
        needs_completed_integrator_step: can.needs_completed_integrator_step,
    }
}

fn co_simulation() -> CoSimulation {
    let can = description::CAPABILITIES;
    CoSimulation {
        model_identifier: description::MODEL_IDENTIFIER.into(),
        get_and_set_state: can.can_get_and_set_fmu_state,
        serialize_state: can.can_serialize_fmu_state,
        directional_derivatives: can.provides_directional_derivatives,
        adjoint_derivatives: can.provides_adjoint_derivatives,
        per_element_dependencies: can.provides_per_element_dependencies,
        variable_step: can.can_handle_variable_communication_step_size,
        max_output_derivative_order: can.max_output_derivative_order,
        intermediate_input_smoothness: can.recommended_intermediate_input_smoothness,
        intermediate_update: can.provides_intermediate_update,
        might_return_early: can.might_return_early_from_do_step,
        can_return_early: can.can_return_early_after_intermediate_update,
        event_mode: can.has_event_mode,
    }
}

fn types(edition: Edition) -> Vec<Type> {
    let used = |name: &str| variables::of_edition(edition).any(|(_, v)| v.declared_type() == Some(name));
    let floats = units::REAL_TYPES.iter().filter(|t| used(t.name)).map(|t| {
        Type::Float64Type(Float64Type {
            name: t.name.into(),
            description: t.description.into(),
            quantity: t.quantity.map(Into::into),
            unit: t.unit.map(Into::into),
            display_unit: t.display_unit.map(Into::into),
        })
    });
    let enumerations = units::ENUMERATION_TYPES.iter().filter(|t| used(t.name)).map(|t| {
        Type::EnumerationType(EnumerationType {
            name: t.name.into(),
            description: t.description.into(),
            items: enumeration_items(t),
        })
    });
    floats.chain(enumerations).collect()
}

fn variable((reference, v): (u32, &variables::Variable), edition: Edition) -> Variable {
    let numbered = |name: &str| description::value_reference(edition, name);
    let (min, max) = v.bounds();
    let mut attributes = Attributes {
        name: v.name.into(),
        value_reference: reference,
        description: v.description.into(),
        causality: causality(v.causality).into(),
        variability: variability(v.variability).into(),
        initial: v.initial.map(|initial| match initial {
            Initial::Exact => "exact".into(),
            Initial::Calculated => "calculated".into(),
        }),
        declared_type: v.declared_type().map(Into::into),
        // The declared type says these, and 1 is the nominal value where none is given: fmi-sim (fmi-schema 0.8) opens no
        // archive in which a variable has one of the three.
        unit: None,
        display_unit: None,
        min,
        max,
        nominal: None,
        start: start(v),
        derivative: description::derivative(v).and_then(numbered),
        reinit: None,
        intermediate_update: description::intermediate_update(v).then_some(true),
        clocks: numbered(CLOCK).filter(|_| description::is_clocked(v)).map(|clock| clock.to_string()),
        interval_variability: None,
        dimensions: v.dimensions.iter().map(|length| Dimension { start: *length as u64 }).collect(),
        aliases: description::alias(v).map(|name| Alias { name: name.into() }).into_iter().collect(),
    };
    match v.kind {
        Kind::Real { nominal, reinit, .. } => {
            attributes.nominal = nominal.filter(|nominal| *nominal != 1.0);
            attributes.reinit = reinit.then_some(true);
            Variable::Float64(attributes)
        }
        Kind::Integer { min } => {
            attributes.min = Some(f64::from(min));
            Variable::Int32(attributes)
        }
        Kind::Boolean => Variable::Boolean(attributes),
        Kind::Enumeration(_) => Variable::Enumeration(attributes),
        Kind::Clock => {
            attributes.initial = None; // a clock has none
            attributes.interval_variability = Some("triggered".into());
            Variable::Clock(attributes)
        }
    }
}

/// Name of the clock of impacts.
const CLOCK: &str = "impacts.clock";

fn start(v: &variables::Variable) -> Option<String> {
    let start = v.start_in(&description::start_settings())?;
    Some(if v.kind == Kind::Boolean { (start != 0.0).to_string() } else { start.to_string() })
}

/// Calculated outputs, calculated parameters, and those derivatives of states that are no outputs (FMI 3.0.2, 2.4.8). What belongs
/// to a clock is not among them; the clock itself is, although it cannot have the attribute `initial`: validators ask for it.
fn initial_unknowns(edition: Edition) -> Vec<Row> {
    let clocked = |row: &Row| description::is_clocked(&variables::VARIABLES[row.place]);
    structure::initial_unknowns(edition).into_iter().filter(|row| !clocked(row)).collect()
}

/// Every element has both lists, since importers exist that need them.
fn unknowns(rows: &[Row], edition: Edition) -> Vec<Unknown> {
    let numbering = description::numbering(edition);
    let reference = |place: usize| numbering.reference(place).map_or_else(String::new, |r| r.to_string());
    let joined = |words: Vec<String>| Some(words.join(" "));
    let unknown = |row: &Row| {
        Some(Unknown {
            value_reference: numbering.reference(row.place)?,
            dependencies: joined(row.dependencies.iter().map(|(place, _)| reference(*place)).collect()),
            kinds: joined(row.dependencies.iter().map(|(_, kind)| kind_name(*kind).to_owned()).collect()),
        })
    };
    rows.iter().filter_map(unknown).collect()
}
