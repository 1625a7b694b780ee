//! The component's table as a description of the doors: the parts common to all versions.

use crate::component::identity;
use crate::component::settings::Settings;
use crate::component::structure;
use crate::component::units;
use crate::component::variables::{self, Edition, Numbering};
use fmi_doors::description::{self, Description, Item, Type, TypeKind, Unit, Unknown, Variable};

/// The descriptions of one version and edition.
pub(crate) struct Table {
    pub(crate) edition: Edition,
    pub(crate) numbering: Numbering,
    /// Settings that supply the start values.
    pub(crate) start: Settings,
    /// Name of the state whose derivative a variable is, by the rules of the version.
    pub(crate) derivative: fn(&variables::Variable) -> Option<&'static str>,
}

impl Table {
    /// The part of the description from the table and the identity. The version adds interface
    /// types, capabilities, log categories and token.
    pub(crate) fn description(&self) -> Description {
        let unknowns =
            |list: Vec<structure::Unknown>| list.iter().filter_map(|row| self.unknown(row)).collect();
        Description {
            model_name: identity::MODEL_IDENTIFIER.into(),
            model_identifier: identity::MODEL_IDENTIFIER.into(),
            token: "".into(),
            description: identity::MODEL_DESCRIPTION.into(),
            author: identity::AUTHOR.into(),
            version: identity::VERSION.into(),
            copyright: identity::COPYRIGHT.into(),
            license: identity::LICENSE.into(),
            generation_tool: "".into(),
            generation_date_and_time: None,
            structured_names: identity::NAMING_CONVENTION == "structured",
            model_exchange: None,
            co_simulation: None,
            capabilities: description::Capabilities::default(),
            units: units::UNITS.iter().map(unit).collect(),
            types: self.types(),
            log_categories: Vec::new(),
            experiment: identity::default_experiment(),
            variables: self.numbering.variables().map(|row| self.variable(row)).collect(),
            outputs: unknowns(structure::outputs(self.edition)),
            derivatives: unknowns(structure::derivatives(self.edition)),
            initial_unknowns: unknowns(structure::initial_unknowns(self.edition)),
            event_indicators: Vec::new(),
        }
    }

    /// An unknown by its value reference; `None` if the description leaves it out.
    pub(crate) fn unknown(&self, row: &structure::Unknown) -> Option<Unknown> {
        let knowns = row.dependencies.iter();
        let dependencies =
            knowns.filter_map(|(place, kind)| Some((self.numbering.reference(*place)?, *kind))).collect();
        Some(Unknown { reference: self.numbering.reference(row.place)?, dependencies: Some(dependencies) })
    }

    /// Value reference of the variable with a name; `None` if the description leaves it out.
    pub(crate) fn reference(&self, name: &str) -> Option<u32> {
        self.numbering.variables().find(|(_, variable)| variable.name == name).map(|(reference, _)| reference)
    }

    fn variable(&self, (reference, v): (u32, &variables::Variable)) -> Variable {
        let (mut min, max) = v.bounds();
        let kind = match v.kind {
            variables::Kind::Real { declared, nominal, reinit, .. } => description::Kind::Real {
                // Repeated from the declared type: some hosts read units of variables only.
                unit: declared.unit.map(Into::into),
                display_unit: declared.display_unit.map(Into::into),
                nominal,
                derivative_of: (self.derivative)(v).and_then(|name| self.reference(name)),
                reinit,
            },
            variables::Kind::Integer { min: smallest } => {
                min = Some(f64::from(smallest));
                description::Kind::Integer
            }
            variables::Kind::Boolean => description::Kind::Boolean,
            variables::Kind::Enumeration(_) => description::Kind::Enumeration,
            variables::Kind::Clock => description::Kind::Clock,
        };
        Variable {
            name: v.name.into(),
            reference,
            description: v.description.into(),
            causality: v.causality,
            variability: v.variability,
            initial: v.initial,
            kind,
            declared_type: v.declared_type().map(Into::into),
            min,
            max,
            start: v.start_in(&self.start),
            dimensions: v.dimensions.to_vec(),
            intermediate_update: false,
            clock: None,
            alias: None,
        }
    }

    /// The declared types used by a variable of this edition.
    fn types(&self) -> Vec<Type> {
        let used =
            |name: &str| variables::of_edition(self.edition).any(|(_, v)| v.declared_type() == Some(name));
        let reals = units::REAL_TYPES.iter().filter(|t| used(t.name)).map(|t| Type {
            name: t.name.into(),
            description: t.description.into(),
            kind: TypeKind::Real {
                quantity: t.quantity.map(Into::into),
                unit: t.unit.map(Into::into),
                display_unit: t.display_unit.map(Into::into),
            },
        });
        let item = |item: &units::Item| Item {
            name: item.name.into(),
            value: item.value,
            description: item.description.into(),
        };
        let enumerations = units::ENUMERATION_TYPES.iter().filter(|t| used(t.name)).map(|t| Type {
            name: t.name.into(),
            description: t.description.into(),
            kind: TypeKind::Enumeration(t.items.iter().map(item).collect()),
        });
        reals.chain(enumerations).collect()
    }
}

fn unit(unit: &units::Unit) -> Unit {
    let display = unit.display.iter().map(|display| (display.name.into(), display.factor)).collect();
    let exponents = [unit.kg, unit.m, unit.s, 0, 0, 0, 0, unit.rad];
    Unit { name: unit.name.into(), exponents, display }
}
