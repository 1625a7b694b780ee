//! From the variable table to `modelDescription.xml`.

use crate::error::{Error, Result};
use crate::schema::*;
use serde::Serialize;
use vibro_fmi::component::variables::{
    Causality, DependencyKind, Edition, Initial, Kind, Variability, Variable, place,
};
use vibro_fmi::component::{structure, units};
use vibro_fmi::fmi2::description;

/// The model description, made from the table.
pub fn model_description() -> ModelDescription {
    let can = description::CAPABILITIES;
    let model_exchange = description::MODEL_EXCHANGE
        .then(|| ModelExchange::new(&can, can.completed_integrator_step_not_needed));
    let experiment = description::default_experiment();
    ModelDescription {
        fmi_version: "2.0".into(),
        model_name: description::MODEL_IDENTIFIER.into(),
        guid: description::guid(),
        description: description::MODEL_DESCRIPTION.into(),
        author: description::AUTHOR.into(),
        version: description::MODEL_VERSION.into(),
        copyright: description::COPYRIGHT.into(),
        license: description::LICENSE.into(),
        generation_tool: concat!("fmu-build ", env!("CARGO_PKG_VERSION")).into(),
        generation_date_and_time: None,
        variable_naming_convention: description::NAMING_CONVENTION.into(),
        number_of_event_indicators: model_exchange.as_ref().map(|_| description::EVENT_INDICATORS),
        model_exchange,
        co_simulation: CoSimulation::new(
            &can,
            can.can_handle_variable_communication_step_size,
            can.can_interpolate_inputs,
            can.max_output_derivative_order,
            can.can_run_asynchronuously,
        ),
        unit_definitions: UnitDefinitions { units: units::UNITS.iter().map(unit).collect() },
        type_definitions: TypeDefinitions { types: types() },
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
        model_variables: ModelVariables { variables: description::variables().map(variable).collect() },
        model_structure: ModelStructure {
            outputs: unknowns(&structure::outputs(Edition::Every)),
            derivatives: unknowns(&structure::derivatives(Edition::Every)),
            initial_unknowns: unknowns(&structure::initial_unknowns(Edition::Every)),
        },
    }
}

/// A description as text, of any version.
///
/// # Errors
/// [`Error::Xml`] when it cannot be written.
pub fn to_xml(model: &impl Serialize) -> Result<String> {
    let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let mut serializer = quick_xml::se::Serializer::new(&mut text);
    serializer.indent(' ', 2);
    model.serialize(serializer).map_err(|e| Error::Xml(e.to_string()))?;
    text.push('\n');
    Ok(text)
}

/// The model description of a text.
///
/// # Errors
/// [`Error::Xml`] when the text is none.
pub fn from_xml(text: &str) -> Result<ModelDescription> {
    quick_xml::de::from_str(text).map_err(|e| Error::Xml(e.to_string()))
}

/// A unit as an element.
pub(crate) fn unit(unit: &units::Unit) -> Unit {
    let exponent = |n: i32| (n != 0).then_some(n);
    Unit {
        name: unit.name.into(),
        base: BaseUnit {
            kg: exponent(unit.kg),
            m: exponent(unit.m),
            s: exponent(unit.s),
            rad: exponent(unit.rad),
        },
        display: unit.display.iter().map(|d| DisplayUnit { name: d.name.into(), factor: d.factor }).collect(),
    }
}

/// Whether a declared type is that of a variable of this version.
fn is_used(name: &str) -> bool {
    description::variables().any(|(_, v)| v.declared_type() == Some(name))
}

fn types() -> Vec<SimpleType> {
    let reals = units::REAL_TYPES.iter().filter(|t| is_used(t.name)).map(|t| SimpleType {
        name: t.name.into(),
        description: t.description.into(),
        kind: SimpleKind::Real(RealType {
            quantity: t.quantity.unwrap_or_default().into(),
            unit: t.unit.unwrap_or_default().into(),
            display_unit: t.display_unit.map(Into::into),
        }),
    });
    let enumerations = units::ENUMERATION_TYPES.iter().filter(|t| is_used(t.name)).map(|t| SimpleType {
        name: t.name.into(),
        description: t.description.into(),
        kind: SimpleKind::Enumeration(EnumerationType { items: enumeration_items(t) }),
    });
    reals.chain(enumerations).collect()
}

/// The items of an enumeration as elements.
pub(crate) fn enumeration_items(declared: &units::EnumerationType) -> Vec<Item> {
    let item =
        |i: &units::Item| Item { name: i.name.into(), value: i.value, description: i.description.into() };
    declared.items.iter().map(item).collect()
}

/// `dependenciesKind` as the standard writes it.
pub(crate) fn kind_name(kind: DependencyKind) -> &'static str {
    match kind {
        DependencyKind::Dependent => "dependent",
        DependencyKind::Constant => "constant",
        DependencyKind::Fixed => "fixed",
        DependencyKind::Tunable => "tunable",
        DependencyKind::Discrete => "discrete",
    }
}

/// `causality` as the standard writes it.
pub fn causality(causality: Causality) -> &'static str {
    match causality {
        Causality::Parameter => "parameter",
        Causality::CalculatedParameter => "calculatedParameter",
        Causality::Input => "input",
        Causality::Output => "output",
        Causality::Local => "local",
        Causality::Independent => "independent",
    }
}

/// `variability` as the standard writes it.
pub fn variability(variability: Variability) -> &'static str {
    match variability {
        Variability::Fixed => "fixed",
        Variability::Tunable => "tunable",
        Variability::Discrete => "discrete",
        Variability::Continuous => "continuous",
    }
}

fn variable((reference, v): (u32, &Variable)) -> ScalarVariable {
    let start = v.start();
    // Integers, enumerations and Booleans travel as whole f64 in the table.
    let whole = start.map(|x| x as i32);
    let (min, max) = v.bounds();
    let kind = match v.kind {
        Kind::Real { declared, nominal, derivative_of, reinit, range: _ } => VariableKind::Real(Real {
            declared_type: declared.name.into(),
            // Repeated from the declared type: some hosts read units of variables only.
            unit: declared.unit.map(Into::into),
            display_unit: declared.display_unit.map(Into::into),
            min,
            max,
            nominal,
            start,
            derivative: derivative_of.map(|state| description::index(place(state))),
            reinit: (reinit && description::MODEL_EXCHANGE).then_some(true),
        }),
        Kind::Integer { min } => VariableKind::Integer(Integer { min: Some(min), start: whole }),
        Kind::Boolean => VariableKind::Boolean(Boolean { start: start.map(|x| x != 0.0) }),
        Kind::Enumeration(declared) => {
            VariableKind::Enumeration(Enumeration { declared_type: declared.name.into(), start: whole })
        }
        // FMI 2.0 has none; the rows that are clocks are of a later edition.
        Kind::Clock => VariableKind::Boolean(Boolean { start: None }),
    };
    ScalarVariable {
        name: v.name.into(),
        value_reference: reference,
        description: v.description.into(),
        causality: causality(v.causality).into(),
        variability: variability(v.variability).into(),
        initial: v.initial.map(|initial| match initial {
            Initial::Exact => "exact".into(),
            Initial::Calculated => "calculated".into(),
        }),
        kind,
    }
}

fn unknowns(list: &[structure::Unknown]) -> Unknowns {
    let joined = |words: Vec<String>| words.join(" ");
    let unknown = |u: &structure::Unknown| Unknown {
        index: description::index(u.place),
        dependencies: Some(joined(
            u.dependencies.iter().map(|(known, _)| description::index(*known).to_string()).collect(),
        )),
        kinds: Some(joined(u.dependencies.iter().map(|(_, k)| kind_name(*k).to_owned()).collect())),
    };
    Unknowns { unknowns: list.iter().map(unknown).collect() }
}
