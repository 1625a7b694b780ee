//! Parameters by name, with the texts and ranges that a page shows.

use std::fmt::Write;
use vibro_impact::parameters::{FIELDS, GROUPS};
use vibro_studies::Error;
use vibro_studies::paper::{Name, ParameterSet, number, typed_unit};
use wasm_bindgen::prelude::*;

/// A parameter set: physical parameters and dimensionless groups, kept consistent by the library.
#[wasm_bindgen]
#[derive(Clone, Debug)]
pub struct Set(pub(crate) ParameterSet);

#[wasm_bindgen]
impl Set {
    /// The default set (partly a reconstruction), or the strongly coupled one.
    ///
    /// # Errors
    /// No error occurs for these two sets.
    #[wasm_bindgen(constructor)]
    pub fn new(strong: bool) -> Result<Set, JsError> {
        Ok(Self(if strong { ParameterSet::strong()? } else { ParameterSet::basic() }))
    }

    /// The set with one parameter changed.
    ///
    /// # Errors
    /// An error if the name is unknown, or if the value is out of its range, which the message
    /// states.
    pub fn with(&self, name: &str, value: f64) -> Result<Set, JsError> {
        let mut set = self.0.clone();
        set.assign(&[(Name::find(name)?, value)])?;
        Ok(Self(set))
    }

    /// The value of a parameter: SI unit or 1.
    ///
    /// # Errors
    /// An error if the name is unknown.
    pub fn value(&self, name: &str) -> Result<f64, JsError> {
        Ok(Name::find(name)?.value(&self.0))
    }

    /// Parses a parameter value and returns it in the SI unit. The text is a number, with or
    /// without a unit as on the command line (`50 mm`, `10.65Hz`). A number without a unit is in
    /// `unit`, a unit as returned by [`typed`](Self::typed), or in the SI unit if `unit` is empty.
    ///
    /// # Errors
    /// An error if the name is unknown, the text is not a number, or the unit has another
    /// dimension; the message states the choices.
    pub fn read(&self, name: &str, text: &str, unit: &str) -> Result<f64, JsError> {
        let name = Name::find(name)?;
        let value = number(name, text)?;
        let plain = !unit.is_empty() && typed_unit(name, text).is_none();
        let value = if plain { number(name, &format!("{text} {unit}"))? } else { value };
        if value.is_finite() {
            return Ok(value);
        }
        let allowed = name.allowed();
        Err(Error::NotANumber { name: name.name(), text: text.trim().into(), allowed }.into())
    }

    /// The unit in the text of a parameter value, as written in files. Empty if the text has no
    /// unit or is not a value of the parameter.
    pub fn typed(&self, name: &str, text: &str) -> String {
        let unit = Name::find(name).ok().and_then(|name| typed_unit(name, text));
        unit.map_or_else(String::new, |unit| unit.symbol().replace('·', ".").replace('µ', "u"))
    }

    /// The 13 physical parameters and the 10 groups, in the order of [`catalogue`].
    pub fn values(&self) -> Vec<f64> {
        let names = FIELDS.iter().map(Name::Si).chain(GROUPS.iter().map(Name::Group));
        names.map(|name| name.value(&self.0)).collect()
    }

    /// A copy, which the page frees separately.
    pub fn copy(&self) -> Set {
        self.clone()
    }
}

/// All parameters, one per line, with fields separated by tabs: name, symbol, unit, allowed
/// values, lower and upper end of the slider, meaning. The slider of a phase goes from 0 to 2π.
/// The slider of another physical parameter covers its range or, without an upper bound, zero to
/// three times the default.
#[wasm_bindgen]
pub fn catalogue() -> String {
    let basic = ParameterSet::basic();
    let mut text = String::new();
    for name in FIELDS.iter().map(Name::Si).chain(GROUPS.iter().map(Name::Group)) {
        let (low, high) = match name {
            Name::Group(group) => group.shown,
            Name::Si(field) if field.unit == "rad" => (0.0, std::f64::consts::TAU),
            Name::Si(field) if field.range.max < f64::INFINITY => (field.range.min, field.range.max),
            Name::Si(_) => (0.0, 3.0 * name.value(&basic)),
        };
        let words = [name.name(), name.symbol(), name.unit(), name.allowed()];
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{}\t{low}\t{high}\t{}", words.join("\t"), name.description());
    }
    text
}
