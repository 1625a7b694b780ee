//! Text of a description in FMI 3.0 (FMI 3.0.2, 2.4, 3.4 and 4.4).

use super::element::Element;
use super::fmi2::{experiment, items, log_categories, named, some, unit, with_dependencies};
use super::{Description, Kind, Type, TypeKind, Unknown, Variable};

pub(super) fn root(of: &Description) -> Element {
    let nominals = nominal_values(of);
    let exchange = of.model_exchange.map(|exchange| {
        interface("ModelExchange", of)
            .with("needsCompletedIntegratorStep", exchange.needs_completed_integrator_step)
    });
    named("3.0", "instantiationToken", of)
        .children(exchange)
        .children(co_simulation(of))
        .children(some("UnitDefinitions", of.units.iter().map(unit)))
        .children(some(
            "TypeDefinitions",
            of.types.iter().map(declared).chain(with_nominal_values(of, &nominals)),
        ))
        .children(log_categories(of))
        .children([experiment(of)])
        .children([
            Element::new("ModelVariables").children(of.variables.iter().map(|v| variable(v, &nominals)))
        ])
        .children([Element::new("ModelStructure")
            .children(unknowns("Output", &of.outputs))
            .children(unknowns("ContinuousStateDerivative", &of.derivatives))
            .children(unknowns("InitialUnknown", &of.initial_unknowns))
            .children(unknowns("EventIndicator", &of.event_indicators))])
}

fn interface(name: &'static str, of: &Description) -> Element {
    let can = of.capabilities;
    Element::new(name)
        .with("modelIdentifier", &of.model_identifier)
        .maybe(
            "canBeInstantiatedOnlyOncePerProcess",
            can.can_be_instantiated_only_once_per_process.then_some(true),
        )
        .with("canGetAndSetFMUState", can.can_get_and_set_fmu_state)
        .with("canSerializeFMUState", can.can_serialize_fmu_state)
        .with("providesDirectionalDerivatives", can.provides_directional_derivatives)
        .with("providesAdjointDerivatives", can.provides_adjoint_derivatives)
        .with("providesPerElementDependencies", can.provides_per_element_dependencies)
}

fn co_simulation(of: &Description) -> Option<Element> {
    let can = of.co_simulation?;
    Some(
        interface("CoSimulation", of)
            .with("canHandleVariableCommunicationStepSize", can.can_handle_variable_communication_step_size)
            .with("maxOutputDerivativeOrder", can.max_output_derivative_order)
            .with("recommendedIntermediateInputSmoothness", can.recommended_intermediate_input_smoothness)
            .with("providesIntermediateUpdate", can.provides_intermediate_update)
            .with("mightReturnEarlyFromDoStep", can.might_return_early_from_do_step)
            .with("canReturnEarlyAfterIntermediateUpdate", can.can_return_early_after_intermediate_update)
            .with("hasEventMode", can.has_event_mode),
    )
}

fn declared(declared: &Type) -> Element {
    let named =
        |name| Element::new(name).with("name", &declared.name).with("description", &declared.description);
    match &declared.kind {
        TypeKind::Real { quantity, unit, display_unit } => named("Float64Type")
            .maybe("quantity", quantity.as_ref())
            .maybe("unit", unit.as_ref())
            .maybe("displayUnit", display_unit.as_ref()),
        TypeKind::Enumeration(list) => named("EnumerationType").children(items(list)),
    }
}

/// The nominal value of a variable of a declared type; `None` for 1, which is the default.
fn nominal_value(v: &Variable) -> Option<(&str, f64)> {
    let Kind::Real { nominal, .. } = &v.kind else { return None };
    Some((v.declared_type.as_deref()?, nominal.filter(|nominal| *nominal != 1.0)?))
}

/// The nominal values of variables with a declared type. Each needs a separate type, since a
/// variable takes the attribute from its type (FMI 3.0.2, `TypeDefinitions`).
fn nominal_values(of: &Description) -> Vec<(&str, f64)> {
    let mut all: Vec<(&str, f64)> = Vec::new();
    for value in of.variables.iter().filter_map(nominal_value) {
        if !all.contains(&value) {
            all.push(value);
        }
    }
    all
}

/// The name of the declared type for a nominal value, from its index among all.
fn name_with_nominal(nominals: &[(&str, f64)], value: (&str, f64)) -> Option<String> {
    let place = nominals.iter().position(|own| *own == value)?;
    Some(format!("{}.nominal{}", value.0, place + 1))
}

/// The declared types of nominal values.
fn with_nominal_values(of: &Description, nominals: &[(&str, f64)]) -> Vec<Element> {
    let with = |&(name, nominal): &(&str, f64)| {
        let own = of.types.iter().find(|own| own.name == name)?;
        let name = name_with_nominal(nominals, (name, nominal))?;
        Some(declared(&Type { name: name.into(), ..own.clone() }).with("nominal", nominal))
    };
    nominals.iter().filter_map(with).collect()
}

fn variable(v: &Variable, nominals: &[(&str, f64)]) -> Element {
    let name = match v.kind {
        Kind::Real { .. } => "Float64",
        Kind::Integer => "Int32",
        Kind::Boolean => "Boolean",
        Kind::Enumeration => "Enumeration",
        Kind::Clock => "Clock",
    };
    let (mut own_unit, mut own_display, mut own_nominal, mut derivative, mut reinitialized) =
        (None, None, None, None, None);
    if let Kind::Real { unit, display_unit, nominal, derivative_of, reinit } = &v.kind {
        // A declared type gives unit, display unit and nominal value, so these attributes are left
        // out: fmi-sim (fmi-schema 0.8) does not open an archive if a variable has one of the
        // three.
        own_unit = unit.as_ref().filter(|_| v.declared_type.is_none());
        own_display = display_unit.as_ref().filter(|_| v.declared_type.is_none());
        own_nominal = nominal.filter(|nominal| *nominal != 1.0 && v.declared_type.is_none());
        derivative = *derivative_of;
        reinitialized = reinit.then_some(true);
    }
    let start = v.start.map(|start| match v.kind {
        Kind::Boolean => (start != 0.0).to_string(),
        _ => start.to_string(),
    });
    let clock = v.kind == Kind::Clock;
    let own_type = || v.declared_type.as_deref().map(str::to_string);
    let declared_type =
        nominal_value(v).and_then(|value| name_with_nominal(nominals, value)).or_else(own_type);
    Element::new(name)
        .with("name", &v.name)
        .with("valueReference", v.reference)
        .with("description", &v.description)
        .with("causality", v.causality.name())
        .with("variability", v.variability.name())
        // A clock does not have this attribute.
        .maybe("initial", v.initial.filter(|_| !clock).map(super::Initial::name))
        .maybe("declaredType", declared_type)
        .maybe("unit", own_unit)
        .maybe("displayUnit", own_display)
        .maybe("min", v.min)
        .maybe("max", v.max)
        .maybe("nominal", own_nominal)
        .maybe("start", start)
        .maybe("derivative", derivative)
        .maybe("reinit", reinitialized)
        .maybe("intermediateUpdate", v.intermediate_update.then_some(true))
        .maybe("clocks", v.clock)
        .maybe("intervalVariability", clock.then_some("triggered"))
        .children(v.dimensions.iter().map(|length| Element::new("Dimension").with("start", length)))
        .children(v.alias.iter().map(|alias| Element::new("Alias").with("name", alias)))
}

fn unknowns<'a>(name: &'static str, list: &'a [Unknown]) -> impl Iterator<Item = Element> + 'a {
    list.iter().map(move |unknown| {
        let element = Element::new(name).with("valueReference", unknown.reference);
        with_dependencies(element, unknown, Some)
    })
}
