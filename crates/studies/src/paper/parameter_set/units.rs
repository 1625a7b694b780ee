//! Parameter values with or without a unit, and the [units](vibro_impact::quantities) in labels.

use super::{Name, name::physical_parameters};
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use vibro_impact::parameters::{FIELDS, LOADS};
pub use vibro_impact::quantities::{Quantity, Unit, quantity_in};
use vibro_impact::quantities::{UNITS, in_si, split, symbols};

/// Written unit of each physical parameter: its index in [`UNITS`] plus 1, or 0 without a unit.
/// Serialized as a map from parameter names to unit symbols.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "BTreeMap<String, String>", into = "BTreeMap<String, String>")]
pub(super) struct Units([u8; FIELDS.len() + LOADS.len()]);

impl Units {
    /// Whether no parameter had a unit.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The unit of a physical parameter, if it was written with one.
    pub fn get(&self, name: &str) -> Option<&'static Unit> {
        let place = physical_parameters().position(|f| f.name == name)?;
        UNITS.get(usize::from(self.0[place]).checked_sub(1)?)
    }

    /// Sets the unit of a physical parameter. An unknown name or a unit of another dimension
    /// changes nothing.
    pub fn set(&mut self, name: &str, symbol: &str) {
        let Some((place, field)) = physical_parameters().enumerate().find(|(_, f)| f.name == name) else {
            return;
        };
        if let Some(unit) = UNITS.iter().position(|u| u.si == field.unit && u.symbol == symbol) {
            self.0[place] = unit as u8 + 1;
        }
    }
}

impl From<BTreeMap<String, String>> for Units {
    fn from(written: BTreeMap<String, String>) -> Self {
        let mut units = Self::default();
        written.iter().for_each(|(name, symbol)| units.set(name, symbol));
        units
    }
}

impl From<Units> for BTreeMap<String, String> {
    fn from(units: Units) -> Self {
        let written = |name: &str| Some((name.to_owned(), units.get(name)?.symbol.to_owned()));
        physical_parameters().filter_map(|f| written(f.name)).collect()
    }
}

/// Parses the value of a parameter, with or without a unit, such as `48 kN/m`. Without a unit the
/// value is in the parameter's SI unit.
///
/// # Errors
/// [`Error::NotANumber`]; [`Error::Unit`] for a unit of another dimension or an unknown one.
fn quantity(name: Name, text: &str) -> Result<Quantity> {
    let no_number =
        || Error::NotANumber { name: name.name(), text: text.trim().into(), allowed: name.allowed() };
    let (number, symbol) = split(text).ok_or_else(no_number)?;
    in_si(name.unit(), number, symbol).ok_or_else(|| {
        let allowed = symbols(name.unit()).collect::<Vec<_>>().join(", ");
        Error::Unit { name: name.name(), unit: symbol.into(), allowed }
    })
}

/// Parses the value of a parameter, with or without a unit, and returns it in the parameter's SI
/// unit.
///
/// ```
/// use vibro_studies::paper::{Name, number};
///
/// assert_eq!(number(Name::find("box.k")?, "48 kN/m")?, 48_000.0);
/// # Ok::<(), vibro_studies::Error>(())
/// ```
///
/// # Errors
/// [`Error::NotANumber`]; [`Error::Unit`] for a unit of another dimension or an unknown one.
pub fn number(name: Name, text: &str) -> Result<f64> {
    Ok(quantity(name, text)?.value)
}

/// The unit written after a number. `None` without a unit, and if the text is not a number of the
/// parameter.
pub fn typed_unit(name: Name, text: &str) -> Option<&'static Unit> {
    quantity(name, text).ok()?.unit
}

/// The values of several numbers of one parameter, and their unit. Either all numbers have a unit
/// or none has one, so `9:11Hz` is refused. Ranges are not checked, since the meaning of a number
/// without a unit may depend on the parameter's [written unit](super::ParameterSet::unit).
///
/// # Errors
/// As [`number`], and [`Error::Form`] if only some of the numbers have a unit.
pub fn numbers(name: Name, texts: &[&str]) -> Result<(Vec<f64>, Option<&'static Unit>)> {
    let all = texts.iter().map(|text| quantity(name, text)).collect::<Result<Vec<_>>>()?;
    if all.iter().any(|q| q.unit.is_some() != all[0].unit.is_some()) {
        let text = format!("{}={}", name.name(), texts.join(":"));
        return Err(Error::Form { text, expected: "a unit on every number or on none" });
    }
    Ok((all.iter().map(|q| q.value).collect(), all.first().and_then(|q| q.unit)))
}
