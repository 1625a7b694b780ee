//! A model description of either version, reduced to the data for the checks.

use crate::xml::Element;
use fmi_doors::Version;
use std::collections::BTreeSet;

/// Type of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum VariableType {
    Real,
    Whole,
    Boolean,
    Enumeration,
    Clock,
}

/// A variable of either version.
pub(super) struct Variable<'a> {
    pub(super) element: &'a Element,
    /// Element with the attributes that depend on the type; in FMI 2.0 it is a child of the
    /// variable's element.
    pub(super) of_type: &'a Element,
    pub(super) kind: VariableType,
    pub(super) place: u32,
    /// Key in the model structure: the index in FMI 2.0, the value reference in FMI 3.0.
    pub(super) key: u32,
    pub(super) name: &'a str,
    pub(super) causality: &'a str,
    pub(super) variability: &'a str,
}

impl<'a> Variable<'a> {
    pub(super) fn of(element: &'a Element, place: u32, version: Version) -> Option<Self> {
        let of_type = if version == Version::Fmi2 { element.children.first()? } else { element };
        let kind = match of_type.name.as_str() {
            "Real" | "Float64" => VariableType::Real,
            "Integer" | "Int32" => VariableType::Whole,
            "Boolean" => VariableType::Boolean,
            "Enumeration" => VariableType::Enumeration,
            "Clock" => VariableType::Clock,
            _ => return None,
        };
        let key = match version {
            Version::Fmi2 => place,
            Version::Fmi3 => element.attribute("valueReference")?.parse().ok()?,
        };
        let text = |name| element.attribute(name).unwrap_or_default();
        let (name, causality, variability) = (text("name"), text("causality"), text("variability"));
        Some(Self { element, of_type, kind, place, key, name, causality, variability })
    }

    pub(super) fn get(&self, name: &str) -> Option<&'a str> {
        self.of_type.attribute(name).or_else(|| self.element.attribute(name))
    }

    /// Key of the state if this is its derivative.
    pub(super) fn derivative(&self) -> Option<u32> {
        self.get("derivative").map(|key| key.parse().unwrap_or(u32::MAX))
    }

    /// Whether its initial value is set.
    pub(super) fn is_set(&self) -> bool {
        self.get("initial") == Some("exact") || self.causality == "input"
    }
}

/// A description of either version.
pub(super) struct Model<'a> {
    pub(super) root: &'a Element,
    pub(super) version: Version,
    pub(super) units: &'a [Element],
    /// Declared types, each with the element of its type-specific attributes.
    pub(super) types: Vec<(&'a str, &'a Element)>,
    pub(super) variables: Vec<Variable<'a>>,
}

impl<'a> Model<'a> {
    pub(super) fn of(root: &'a Element, version: Version) -> Self {
        let types = root.within("TypeDefinitions").iter().filter_map(|declared| {
            let of_type = if version == Version::Fmi2 { declared.children.first()? } else { declared };
            Some((declared.attribute("name")?, of_type))
        });
        let variables = (1..).zip(root.within("ModelVariables"));
        let variables = variables.filter_map(|(place, element)| Variable::of(element, place, version));
        let (types, variables) = (types.collect(), variables.collect());
        Self { root, version, units: root.within("UnitDefinitions"), types, variables }
    }

    pub(super) fn is_fmi3(&self) -> bool {
        self.version == Version::Fmi3
    }

    /// The declared type of a variable, if it is of the variable's type.
    pub(super) fn type_of(&self, v: &Variable) -> Option<&'a Element> {
        let declared = v.get("declaredType")?;
        let fits = |of_type: &Element| match of_type.name.as_str() {
            "Real" | "Float64Type" => v.kind == VariableType::Real,
            _ => v.kind == VariableType::Enumeration,
        };
        self.types.iter().find(|(name, of_type)| *name == declared && fits(of_type)).map(|found| found.1)
    }

    pub(super) fn by_key(&self, key: u32) -> Option<&Variable<'a>> {
        self.variables.iter().find(|v| v.key == key)
    }

    /// Keys of variables.
    pub(super) fn keys(&self, wanted: impl Fn(&Variable) -> bool) -> BTreeSet<u32> {
        self.variables.iter().filter(|v| wanted(v)).map(|v| v.key).collect()
    }
}
