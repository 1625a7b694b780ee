//! Reading of numbers, with their units and expressions.

use super::any_unit::quantity;
use super::reading::{ASKED, Entry, FileTable, Reading};
use crate::description::Dimension;
use crate::kinds::{self, NumberKind};
use crate::named::Expression;
use crate::parameters;
use toml::de::{DeInteger, DeValue};
use vibro_numerics::quantities::symbols;

impl Reading<'_> {
    /// Records the allowed numbers if the completion of [`ASKED`] is requested.
    pub fn note_number(
        &mut self,
        entry: &Entry,
        units: impl Iterator<Item = &'static str>,
        words: impl Fn() -> String,
    ) {
        if entry.value.as_str() == Some(ASKED) {
            self.allowed.units.extend(units);
            self.allowed.names.extend(self.named.names().map(|name| format!("= {name}")));
            // If the dimension is not known, the words for a length are used.
            if self.allowed.words.is_empty() {
                self.allowed.words = words();
            }
        }
    }

    /// A value as a number of a kind, in SI.
    pub fn number(&mut self, entry: &Entry, kind: NumberKind, dimension: Dimension) -> Option<f64> {
        if let Some(expression) = self.expression(entry) {
            return self.following(entry, expression?, kind, dimension);
        }
        let units = symbols(kind.unit(dimension)).filter(|unit| *unit != "1");
        self.note_number(entry, units, || kind.allowed(dimension));
        if let (true, Some(text)) = (kind.any_unit, entry.value.as_str()) {
            let found = quantity(text.trim(), &kind.allowed(dimension));
            return found.map_err(|text| self.refuse(entry, text)).ok().map(|own| own.0);
        }
        let found = number(entry.value, kind, dimension);
        found.map_err(|fault| self.refuse(entry, fault)).ok()
    }

    /// Returns the expression of a value, if it is one; the inner `None` means a problem.
    pub fn expression(&mut self, entry: &Entry) -> Option<Option<Expression>> {
        let text = entry.value.as_str()?.trim();
        let Some(text) = text.strip_prefix('=') else {
            let fault = without_sign(text, self.named.names())?;
            self.refuse(entry, fault);
            return Some(None);
        };
        if self.named_refused {
            return Some(None);
        }
        let parsed = Expression::parse(text, self.named.names());
        Some(parsed.map_err(|text| self.refuse(entry, text)).ok())
    }

    /// Returns the value of a number's expression, in SI, and keeps the expression.
    pub fn following(
        &mut self,
        entry: &Entry,
        expression: Expression,
        kind: NumberKind,
        dimension: Dimension,
    ) -> Option<f64> {
        let found = expression.value(&self.named.values());
        let found = found.and_then(|value| {
            let fault = || format!("is {value:?}; {}", kind.fault(value, dimension));
            if kind.contains(value) { Ok(value) } else { Err(fault()) }
        });
        self.follow.push((entry.name.clone(), expression));
        found.map_err(|text| self.refuse(entry, text)).ok()
    }

    /// The number of a key that must be present.
    pub fn required_number(
        &mut self,
        table: &FileTable,
        key: &str,
        kind: NumberKind,
        dimension: Dimension,
    ) -> Option<f64> {
        let entry = self.required(table, key, &kind.allowed(dimension))?;
        self.number(&entry, kind, dimension)
    }

    /// The number of a key that may be absent.
    pub fn number_or(
        &mut self,
        table: &FileTable,
        key: &str,
        kind: NumberKind,
        dimension: Dimension,
        default: f64,
    ) -> Option<f64> {
        match self.optional(table, key) {
            Some(entry) => self.number(&entry, kind, dimension),
            None => Some(default),
        }
    }
}

/// Returns a value as an allowed number of a kind, in SI, or its fault.
pub(super) fn number(value: &DeValue, kind: NumberKind, dimension: Dimension) -> Result<f64, String> {
    let found = match value {
        DeValue::Integer(digits) => integer(digits),
        DeValue::Float(digits) => digits.as_str().parse().ok(),
        DeValue::String(text) => return parameters::read(kind, dimension, text),
        DeValue::Table(_) => return Err(format!("{}; it cannot be a signal", kind.allowed(dimension))),
        _ => None,
    };
    let found = found.ok_or_else(|| kind.allowed(dimension))?;
    if kind.contains(found) { Ok(found) } else { Err(kind.fault(found, dimension)) }
}

/// The fault of a text that is an expression without its `=`.
pub(super) fn without_sign<'n>(
    text: &'n str,
    names: impl Iterator<Item = &'n str> + Clone,
) -> Option<String> {
    let is_expression = text.parse::<f64>().is_err() && Expression::parse(text, names).is_ok();
    is_expression.then(|| format!("an expression begins with `=`; write \"= {text}\""))
}

/// Returns a value as a finite number without a unit.
pub(super) fn finite(value: &DeValue) -> Option<f64> {
    let plain = !value.is_str();
    plain.then(|| number(value, kinds::named("1"), Dimension::Translation).ok()).flatten()
}

/// Returns an integer of any size as the nearest double.
fn integer(digits: &DeInteger) -> Option<f64> {
    match digits.radix() {
        10 => digits.as_str().parse().ok(),
        radix => i64::from_str_radix(digits.as_str(), radix).ok().map(|n| n as f64),
    }
}
