//! Text of a description in FMI 2.0 (FMI 2.0, 2.2, 3.3 and 4.3).

use super::element::Element;
use super::{Capabilities, Description, Kind, Text, Type, TypeKind, Unit, Unknown, Variable};

pub(super) fn root(of: &Description) -> Element {
    let exchange = of.model_exchange.as_ref();
    named("2.0", "guid", of)
        .maybe("numberOfEventIndicators", exchange.map(|exchange| exchange.number_of_event_indicators))
        .children(exchange.map(|exchange| {
            let own = |element: Element| {
                element.with("completedIntegratorStepNotNeeded", !exchange.needs_completed_integrator_step)
            };
            interface("ModelExchange", of, own)
        }))
        .children(of.co_simulation.map(|can| {
            interface("CoSimulation", of, |element| {
                element
                    .with(
                        "canHandleVariableCommunicationStepSize",
                        can.can_handle_variable_communication_step_size,
                    )
                    .with("canInterpolateInputs", can.can_interpolate_inputs)
                    .with("maxOutputDerivativeOrder", can.max_output_derivative_order)
                    .with("canRunAsynchronuously", false)
            })
        }))
        .children(some("UnitDefinitions", of.units.iter().map(unit)))
        .children(some("TypeDefinitions", of.types.iter().map(declared)))
        .children(log_categories(of))
        .children([experiment(of)])
        .children([Element::new("ModelVariables").children(of.variables.iter().map(|v| variable(v, of)))])
        .children([Element::new("ModelStructure")
            .children(some("Outputs", unknowns(&of.outputs, of, false)))
            .children(some("Derivatives", unknowns(&of.derivatives, of, false)))
            .children(some("InitialUnknowns", unknowns(&of.initial_unknowns, of, true)))])
}

/// The root with the attributes common to both versions; `token` is the attribute for the token.
pub(super) fn named(version: &'static str, token: &'static str, of: &Description) -> Element {
    Element::new("fmiModelDescription")
        .with("fmiVersion", version)
        .with("modelName", &of.model_name)
        .with(token, &of.token)
        .with("description", &of.description)
        .with("author", &of.author)
        .with("version", &of.version)
        .with("copyright", &of.copyright)
        .with("license", &of.license)
        .with("generationTool", &of.generation_tool)
        .maybe("generationDateAndTime", of.generation_date_and_time.as_ref())
        .with("variableNamingConvention", if of.structured_names { "structured" } else { "flat" })
}

/// An element for a list; `None` for an empty list, which the schema does not allow.
pub(super) fn some(name: &'static str, children: impl Iterator<Item = Element>) -> Option<Element> {
    let children: Vec<_> = children.collect();
    (!children.is_empty()).then(|| Element::new(name).children(children))
}

/// An interface type; `own` adds its own attributes at the position that the schema requires.
fn interface(name: &'static str, of: &Description, own: impl FnOnce(Element) -> Element) -> Element {
    let Capabilities {
        can_get_and_set_fmu_state,
        can_serialize_fmu_state,
        provides_directional_derivatives,
        can_be_instantiated_only_once_per_process,
        ..
    } = of.capabilities;
    let element =
        Element::new(name).with("modelIdentifier", &of.model_identifier).with("needsExecutionTool", false);
    own(element)
        .with("canBeInstantiatedOnlyOncePerProcess", can_be_instantiated_only_once_per_process)
        .with("canNotUseMemoryManagementFunctions", true)
        .with("canGetAndSetFMUstate", can_get_and_set_fmu_state)
        .with("canSerializeFMUstate", can_serialize_fmu_state)
        .with("providesDirectionalDerivative", provides_directional_derivatives)
}

pub(super) fn unit(unit: &Unit) -> Element {
    const NAMES: [&str; 8] = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];
    let base = NAMES.iter().zip(unit.exponents).filter(|(_, exponent)| *exponent != 0);
    let base = base.fold(Element::new("BaseUnit"), |base, (name, exponent)| base.with(name, exponent));
    let display =
        |(name, factor): &(Text, f64)| Element::new("DisplayUnit").with("name", name).with("factor", factor);
    Element::new("Unit").with("name", &unit.name).children([base]).children(unit.display.iter().map(display))
}

pub(super) fn log_categories(of: &Description) -> Option<Element> {
    let category = |category: &crate::messages::Category| {
        Element::new("Category").with("name", category.name).with("description", category.description)
    };
    some("LogCategories", of.log_categories.iter().map(category))
}

pub(super) fn experiment(of: &Description) -> Element {
    Element::new("DefaultExperiment")
        .with("startTime", of.experiment.start_time)
        .with("stopTime", of.experiment.stop_time)
        .with("tolerance", of.experiment.tolerance)
        .with("stepSize", of.experiment.step_size)
}

pub(super) fn items(items: &[super::Item]) -> impl Iterator<Item = Element> {
    items.iter().map(|item| {
        Element::new("Item")
            .with("name", &item.name)
            .with("value", item.value)
            .with("description", &item.description)
    })
}

fn declared(declared: &Type) -> Element {
    let kind = match &declared.kind {
        TypeKind::Real { quantity, unit, display_unit } => Element::new("Real")
            .maybe("quantity", quantity.as_ref())
            .maybe("unit", unit.as_ref())
            .maybe("displayUnit", display_unit.as_ref()),
        TypeKind::Enumeration(list) => Element::new("Enumeration").children(items(list)),
    };
    Element::new("SimpleType")
        .with("name", &declared.name)
        .with("description", &declared.description)
        .children([kind])
}

/// `ScalarVariable` index, counted from 1, of the variable with a reference (FMI 2.0, 2.2.8).
fn index(reference: u32, of: &Description) -> Option<usize> {
    of.variables.iter().position(|variable| variable.reference == reference).map(|place| place + 1)
}

fn variable(v: &Variable, of: &Description) -> Element {
    let whole = v.start.map(|start| start as i32);
    let kind = match &v.kind {
        Kind::Real { unit, display_unit, nominal, derivative_of, reinit } => Element::new("Real")
            .maybe("declaredType", v.declared_type.as_ref())
            .maybe("unit", unit.as_ref())
            .maybe("displayUnit", display_unit.as_ref())
            .maybe("min", v.min)
            .maybe("max", v.max)
            .maybe("nominal", *nominal)
            .maybe("start", v.start)
            .maybe("derivative", derivative_of.and_then(|state| index(state, of)))
            .maybe("reinit", (*reinit && of.model_exchange.is_some()).then_some(true)),
        Kind::Integer => Element::new("Integer")
            .maybe("min", v.min.map(|min| min as i32))
            .maybe("max", v.max.map(|max| max as i32))
            .maybe("start", whole),
        // FMI 2.0 has no clocks; a component must not put one into a description for it.
        Kind::Boolean | Kind::Clock => {
            Element::new("Boolean").maybe("start", v.start.map(|start| start != 0.0))
        }
        Kind::Enumeration => {
            Element::new("Enumeration").maybe("declaredType", v.declared_type.as_ref()).maybe("start", whole)
        }
    };
    Element::new("ScalarVariable")
        .with("name", &v.name)
        .with("valueReference", v.reference)
        .with("description", &v.description)
        .with("causality", v.causality.name())
        .with("variability", v.variability.name())
        .maybe("initial", v.initial.map(super::Initial::name))
        .children([kind])
}

/// Rows of a list of unknowns. Outside initialization parameters are not knowns (FMI 2.0, 2.2.8).
fn unknowns<'a>(
    list: &'a [Unknown],
    of: &'a Description,
    initially: bool,
) -> impl Iterator<Item = Element> + 'a {
    let is_known =
        move |place: &usize| initially || of.variables[place - 1].causality != super::Causality::Parameter;
    list.iter().filter_map(move |unknown| {
        let element = Element::new("Unknown").with("index", index(unknown.reference, of)?);
        Some(with_dependencies(element, unknown, |known| index(known, of).filter(is_known)))
    })
}

/// Adds both lists of dependencies, even empty ones, since some importers need them. Adds none if
/// the unknown may depend on all knowns.
pub(super) fn with_dependencies<T: ToString>(
    element: Element,
    unknown: &Unknown,
    name: impl Fn(u32) -> Option<T>,
) -> Element {
    let Some(dependencies) = &unknown.dependencies else { return element };
    let knowns =
        dependencies.iter().filter_map(|(known, kind)| Some((name(*known)?.to_string(), kind.name())));
    let (knowns, kinds): (Vec<_>, Vec<_>) = knowns.unzip();
    element.with("dependencies", knowns.join(" ")).with("dependenciesKind", kinds.join(" "))
}
