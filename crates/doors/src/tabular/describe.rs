//! The model description of a table.

use super::{FromTable, Role, Row, Tabular};
use crate::description::{Capabilities, Causality, CoSimulation, Description, ModelExchange};
use crate::description::{Unit, Unknown, Variable};
use crate::messages::log_categories;

impl<T: Tabular> FromTable<T> {
    /// The contents of `modelDescription.xml` for both versions. Author, licence and similar texts
    /// are empty; the caller may add them.
    ///
    /// # Panics
    /// If a row has a unit that is not made of the symbols of [`Row::parameter`].
    pub fn description() -> Description {
        let references = |is: fn(Role) -> bool| {
            let rows = (1..).zip(T::ROWS).filter(move |(_, row)| is(row.role));
            rows.map(|(reference, _)| Unknown::on_anything(reference)).collect::<Vec<_>>()
        };
        let calculated = |role| matches!(role, Role::Derivative(_) | Role::Output | Role::Counter);
        let mut units: Vec<Unit> = Vec::new();
        for row in T::ROWS.iter().filter(|row| !row.unit.is_empty()) {
            if units.iter().all(|unit| unit.name != row.unit) {
                let exponents = exponents(row.unit)
                    .unwrap_or_else(|| panic!("{} has the unit {}, which is not known", row.name, row.unit));
                units.push(Unit { name: row.unit.into(), exponents, display: Vec::new() });
            }
        }
        let indicators = T::INDICATORS.iter().map(|place| Unknown::on_anything(reference(*place)));
        Description {
            model_name: T::NAME.into(),
            model_identifier: T::IDENTIFIER.into(),
            token: Self::token().into(),
            description: T::DESCRIPTION.into(),
            author: "".into(),
            version: T::VERSION.into(),
            copyright: "".into(),
            license: "".into(),
            generation_tool: "fmi-doors".into(),
            generation_date_and_time: None,
            structured_names: true,
            model_exchange: Some(ModelExchange {
                needs_completed_integrator_step: false,
                number_of_event_indicators: T::INDICATORS.len(),
            }),
            co_simulation: Some(CoSimulation {
                might_return_early_from_do_step: true,
                provides_intermediate_update: true,
                can_return_early_after_intermediate_update: true,
                has_event_mode: true,
                ..CoSimulation::default()
            }),
            capabilities: Capabilities {
                can_get_and_set_fmu_state: true,
                can_serialize_fmu_state: true,
                ..Capabilities::default()
            },
            units,
            types: Vec::new(),
            log_categories: log_categories("Each event", "Why a value was not taken").to_vec(),
            experiment: T::EXPERIMENT,
            variables: T::ROWS
                .iter()
                .enumerate()
                .map(|(place, row)| row.described(reference(place)))
                .collect(),
            outputs: references(|role| matches!(role, Role::State | Role::Output | Role::Counter)),
            derivatives: Self::states().map(|(_, place)| Unknown::on_anything(reference(place))).collect(),
            initial_unknowns: references(calculated),
            event_indicators: indicators.collect(),
        }
    }
}

/// The value reference of a row.
fn reference(place: usize) -> u32 {
    place as u32 + 1
}

impl Row {
    /// The variable of a model description.
    fn described(&self, own: u32) -> Variable {
        let (causality, settable) = match self.role {
            Role::Time => (Causality::Independent, false),
            Role::Parameter => (Causality::Parameter, true),
            Role::Input => (Causality::Input, true),
            Role::State => (Causality::Output, true),
            Role::Derivative(_) => (Causality::Local, false),
            Role::Output | Role::Counter => (Causality::Output, false),
        };
        let unit = Some(self.unit).filter(|unit| !unit.is_empty()).map(Into::into);
        let mut variable = Variable {
            min: Some(self.min).filter(|min| settable && *min != f64::MIN),
            max: Some(self.max).filter(|max| settable && *max != f64::MAX),
            ..Variable::of_unit(own, self.name, unit, causality, self.description)
        };
        if settable {
            variable = variable.starting_at(self.start);
        }
        match self.role {
            Role::State => variable.reinitialized(),
            Role::Derivative(state) => variable.derivative_of(reference(state)),
            Role::Counter => variable.counting(),
            _ => variable,
        }
    }
}

/// The exponents of kg, m, s, A, K, mol, cd and rad in a unit. A unit is a product of factors
/// separated by points; after at most one slash follow the factors of the denominator. A factor
/// may have an exponent. `None` if a symbol is not known.
fn exponents(unit: &str) -> Option<[i32; 8]> {
    let mut sum = [0; 8];
    let (above, below) = unit.split_once('/').unwrap_or((unit, ""));
    for (factors, sign) in [(above, 1), (below, -1)] {
        for factor in factors.split('.').filter(|factor| !factor.is_empty()) {
            let digits = factor.find(|c: char| c == '-' || c.is_ascii_digit()).filter(|place| *place > 0);
            let (symbol, power) = factor.split_at(digits.unwrap_or(factor.len()));
            let power: i32 = if power.is_empty() { 1 } else { power.parse().ok()? };
            sum.iter_mut().zip(of_symbol(symbol)?).for_each(|(sum, own)| *sum += sign * power * own);
        }
    }
    Some(sum)
}

fn of_symbol(symbol: &str) -> Option<[i32; 8]> {
    Some(match symbol {
        "1" => [0; 8],
        "kg" => [1, 0, 0, 0, 0, 0, 0, 0],
        "m" => [0, 1, 0, 0, 0, 0, 0, 0],
        "s" => [0, 0, 1, 0, 0, 0, 0, 0],
        "A" => [0, 0, 0, 1, 0, 0, 0, 0],
        "K" => [0, 0, 0, 0, 1, 0, 0, 0],
        "mol" => [0, 0, 0, 0, 0, 1, 0, 0],
        "cd" => [0, 0, 0, 0, 0, 0, 1, 0],
        "rad" => [0, 0, 0, 0, 0, 0, 0, 1],
        "N" => [1, 1, -2, 0, 0, 0, 0, 0],
        "Pa" => [1, -1, -2, 0, 0, 0, 0, 0],
        "J" => [1, 2, -2, 0, 0, 0, 0, 0],
        "W" => [1, 2, -3, 0, 0, 0, 0, 0],
        "V" => [1, 2, -3, -1, 0, 0, 0, 0],
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::exponents;

    #[test]
    fn closed_form_exponents_of_units() {
        assert_eq!(exponents("m/s2"), Some([0, 1, -2, 0, 0, 0, 0, 0]));
        assert_eq!(exponents("N.s/m"), Some([1, 0, -1, 0, 0, 0, 0, 0]));
        assert_eq!(exponents("1/s"), Some([0, 0, -1, 0, 0, 0, 0, 0]));
        assert_eq!(exponents("1"), Some([0; 8]));
        assert_eq!(exponents("kg.m2/s-2"), Some([1, 2, 2, 0, 0, 0, 0, 0]));
        assert_eq!(exponents("furlong"), None);
        assert_eq!(exponents("m/x"), None);
    }
}
