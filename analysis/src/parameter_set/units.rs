//! Units: a number, or a number with a unit of the parameter's dimension, on input; and the units in which labels show
//! parameters.

use super::{Name, name::physical_parameters};
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use vibro_impact::parameters::{FIELDS, LOADS};

/// A unit of an SI unit's dimension: a value in it times `times`, divided by `over`, is the value in the SI unit. Two
/// numbers, because a thousandth is no exact number while a division by 1000 rounds once.
#[derive(Debug, PartialEq)]
pub struct Unit {
    si: &'static str,
    symbol: &'static str,
    times: f64,
    over: f64,
}

const fn unit(si: &'static str, symbol: &'static str, times: f64, over: f64) -> Unit {
    Unit { si, symbol, times, over }
}

impl Unit {
    /// A number of this unit in the SI unit.
    pub fn si(&self, number: f64) -> f64 {
        number * self.times / self.over
    }

    /// Whether numbers are the same in this unit and in the SI unit.
    pub fn is_si(&self) -> bool {
        self.times == self.over
    }

    /// How many of this unit a value in the SI unit is.
    ///
    /// ```
    /// use vibro_analysis::{Name, typed_unit};
    ///
    /// let unit = typed_unit(Name::find("stop.gap")?, "5 mm").unwrap();
    /// assert_eq!((unit.number(0.005), unit.symbol()), (5.0, "mm".into()));
    /// # Ok::<(), vibro_analysis::Error>(())
    /// ```
    pub fn number(&self, si: f64) -> f64 {
        si * self.over / self.times
    }

    /// Its symbol, as labels write it.
    pub fn symbol(&self) -> String {
        self.symbol.replace('.', "·").replace("um", "µm")
    }

    /// Its symbol, as files and the command line write it.
    pub fn plain(&self) -> &'static str {
        self.symbol
    }

    /// Whether it counts revolutions, while the SI unit of an angular frequency counts radians.
    pub(super) fn counts_revolutions(&self) -> bool {
        ["Hz", "mHz", "kHz", "rpm", "1/min"].contains(&self.symbol)
    }
}

/// The units understood, the SI unit of each dimension first. `si` is the unit of a
/// [`Field`](vibro_impact::parameters::Field), of which `1` is that of groups too.
#[rustfmt::skip]
static UNITS: [Unit; 47] = [
    unit("kg", "kg", 1.0, 1.0), unit("kg", "g", 1.0, 1e3), unit("kg", "mg", 1.0, 1e6), unit("kg", "t", 1e3, 1.0),
    unit("N/m", "N/m", 1.0, 1.0), unit("N/m", "N/mm", 1e3, 1.0), unit("N/m", "kN/m", 1e3, 1.0),
    unit("N/m", "kN/mm", 1e6, 1.0), unit("N/m", "MN/m", 1e6, 1.0), unit("N/m", "N/cm", 1e2, 1.0),
    unit("N.s/m", "N.s/m", 1.0, 1.0), unit("N.s/m", "kN.s/m", 1e3, 1.0), unit("N.s/m", "N.s/mm", 1e3, 1.0),
    unit("N.s/m", "kg/s", 1.0, 1.0),
    unit("m", "m", 1.0, 1.0), unit("m", "cm", 1.0, 1e2), unit("m", "mm", 1.0, 1e3), unit("m", "um", 1.0, 1e6),
    unit("1", "1", 1.0, 1.0), unit("1", "%", 1.0, 1e2),
    unit("N", "N", 1.0, 1.0), unit("N", "mN", 1.0, 1e3), unit("N", "kN", 1e3, 1.0), unit("N", "MN", 1e6, 1.0),
    unit("rad/s", "rad/s", 1.0, 1.0), unit("rad/s", "1/s", 1.0, 1.0), unit("rad/s", "Hz", 2.0 * PI, 1.0),
    unit("rad/s", "mHz", 2.0 * PI, 1e3), unit("rad/s", "kHz", 2e3 * PI, 1.0), unit("rad/s", "rpm", PI, 30.0),
    unit("rad/s", "1/min", PI, 30.0), unit("rad/s", "deg/s", PI, 180.0),
    unit("rad", "rad", 1.0, 1.0), unit("rad", "mrad", 1.0, 1e3), unit("rad", "deg", PI, 180.0),
    unit("rad", "°", PI, 180.0),
    unit("s", "s", 1.0, 1.0), unit("s", "ms", 1.0, 1e3), unit("s", "us", 1.0, 1e6), unit("s", "min", 60.0, 1.0),
    unit("s", "h", 3600.0, 1.0),
    unit("m/s", "m/s", 1.0, 1.0), unit("m/s", "cm/s", 1.0, 1e2), unit("m/s", "mm/s", 1.0, 1e3),
    // What is written in place of a point is replaced before the table is read; these three have no point.
    unit("N.s/m", "Ns/m", 1.0, 1.0), unit("N.s/m", "kNs/m", 1e3, 1.0), unit("N.s/m", "Ns/mm", 1e3, 1.0),
];

/// The unit in which each physical parameter was written: its place in [`UNITS`] and 1, or 0 where it had none. A file has
/// the units' symbols by the parameters' names.
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

    /// Notes the unit of a physical parameter; a unit of another dimension, or another name, changes nothing.
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

/// A number as it was written: its value and the unit that stood beside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    /// In the SI unit.
    pub value: f64,
    /// What was written.
    pub unit: Option<&'static Unit>,
}

/// A number and what stands behind it, if anything.
fn split(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    if let Ok(value) = text.parse() {
        return Some((value, ""));
    }
    // Words such as `nanometre` begin with what would be read as a number.
    if !text.starts_with(|c: char| c.is_ascii_digit() || ['+', '-', '.'].contains(&c)) {
        return None;
    }
    let ends = (1..text.len()).rev().filter(|&end| text.is_char_boundary(end));
    let mut parts = ends.map(|end| text.split_at(end));
    parts.find_map(|(number, rest)| Some((number.trim_end().parse().ok()?, rest.trim())))
}

/// The quantity of a number and a symbol of a unit, which may be empty; `None` for a unit of another dimension.
fn in_si(si: &str, number: f64, symbol: &str) -> Option<Quantity> {
    if symbol.is_empty() {
        return Some(Quantity { value: number, unit: None });
    }
    let plain = symbol.replace(['·', '*', ' ', '⋅'], ".").replace(['µ', 'μ'], "u");
    let unit = UNITS.iter().find(|u| u.si == si && u.symbol == plain)?;
    Some(Quantity { value: unit.si(number), unit: Some(unit) })
}

/// Reads a number of any quantity, with or without a unit of the dimension of `si`, which is `s`, `m/s` or the unit of a
/// parameter. `None` for what is neither.
///
/// ```
/// let time = vibro_analysis::quantity_in("s", "20 ms").expect("a time");
/// assert!(time.value == 0.02 && time.unit.is_some());
/// assert_eq!(vibro_analysis::quantity_in("s", "20 mm"), None);
/// ```
pub fn quantity_in(si: &str, text: &str) -> Option<Quantity> {
    let (number, symbol) = split(text)?;
    in_si(si, number, symbol)
}

/// Reads a number of a parameter, with or without a unit such as `48 kN/m`; without one it is in the parameter's SI unit.
///
/// # Errors
/// [`Error::NotANumber`]; [`Error::Unit`] for a unit of another dimension or an unknown one.
fn quantity(name: Name, text: &str) -> Result<Quantity> {
    let no_number =
        || Error::NotANumber { name: name.name(), text: text.trim().into(), allowed: name.allowed() };
    let (number, symbol) = split(text).ok_or_else(no_number)?;
    in_si(name.unit(), number, symbol).ok_or_else(|| {
        let units = UNITS.iter().filter(|u| u.si == name.unit()).map(|u| u.symbol);
        let allowed = units.collect::<Vec<_>>().join(", ");
        Error::Unit { name: name.name(), unit: symbol.into(), allowed }
    })
}

/// The value of a number, with or without a unit, in the parameter's SI unit.
///
/// ```
/// use vibro_analysis::{Name, number};
///
/// assert_eq!(number(Name::find("box.k")?, "48 kN/m")?, 48_000.0);
/// # Ok::<(), vibro_analysis::Error>(())
/// ```
///
/// # Errors
/// [`Error::NotANumber`]; [`Error::Unit`] for a unit of another dimension or an unknown one.
pub fn number(name: Name, text: &str) -> Result<f64> {
    Ok(quantity(name, text)?.value)
}

/// The unit that stands beside a number; `None` where there is none, and for what is no number of the parameter.
pub fn typed_unit(name: Name, text: &str) -> Option<&'static Unit> {
    quantity(name, text).ok()?.unit
}

/// The values of several numbers of one parameter, and the unit in which they were written. Either all have a unit or none, so that
/// `9:11Hz` is no mixture. Ranges are not checked: what a number without a unit means may depend on
/// [how the parameter was written](super::ParameterSet::unit).
///
/// # Errors
/// As [`number`], and [`Error::Form`] for a mixture.
pub fn numbers(name: Name, texts: &[&str]) -> Result<(Vec<f64>, Option<&'static Unit>)> {
    let all = texts.iter().map(|text| quantity(name, text)).collect::<Result<Vec<_>>>()?;
    if all.iter().any(|q| q.unit.is_some() != all[0].unit.is_some()) {
        let text = format!("{}={}", name.name(), texts.join(":"));
        return Err(Error::Form { text, expected: "a unit at every number or at none" });
    }
    Ok((all.iter().map(|q| q.value).collect(), all.first().and_then(|q| q.unit)))
}
