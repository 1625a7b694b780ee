//! Units on input: a number, or a number with a unit of the parameter's dimension.

use super::Name;
use crate::error::{Error, Result};
use std::f64::consts::PI;

/// A unit of an SI unit's dimension: a value in it times `times`, divided by `over`, is the value in the SI unit. Two
/// numbers, because a thousandth is no exact number while a division by 1000 rounds once.
struct Unit {
    si: &'static str,
    symbol: &'static str,
    times: f64,
    over: f64,
}

const fn unit(si: &'static str, symbol: &'static str, times: f64, over: f64) -> Unit {
    Unit { si, symbol, times, over }
}

/// The units understood, the SI unit of each dimension first. `si` is the unit of a
/// [`Field`](vibro_impact::parameters::Field), of which `1` is that of groups too.
#[rustfmt::skip]
const UNITS: [Unit; 39] = [
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
    // What is written in place of a point is replaced before the table is read; these two have no point.
    unit("N.s/m", "Ns/m", 1.0, 1.0), unit("N.s/m", "kNs/m", 1e3, 1.0), unit("N.s/m", "Ns/mm", 1e3, 1.0),
];

/// A number as it was written: its value and whether a unit stood beside it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Quantity {
    /// In the parameter's SI unit.
    value: f64,
    /// Whether a unit was written.
    has_unit: bool,
}

/// Reads a number, with or without a unit such as `48 kN/m`; without one it is in the parameter's SI unit.
///
/// # Errors
/// [`Error::NotANumber`]; [`Error::Unit`] for a unit of another dimension or an unknown one.
fn quantity(name: Name, text: &str) -> Result<Quantity> {
    let text = text.trim();
    if let Ok(value) = text.parse() {
        return Ok(Quantity { value, has_unit: false });
    }
    let no_number = || Error::NotANumber { name: name.name(), text: text.into(), allowed: name.allowed() };
    // Words such as `nanometre` begin with what would be read as a number.
    if !text.starts_with(|c: char| c.is_ascii_digit() || ['+', '-', '.'].contains(&c)) {
        return Err(no_number());
    }
    let split = (1..text.len()).rev().filter(|&end| text.is_char_boundary(end));
    let mut parts = split.map(|end| text.split_at(end));
    let number = parts.find_map(|(number, rest)| Some((number.trim_end().parse::<f64>().ok()?, rest.trim())));
    let (number, given) = number.ok_or_else(no_number)?;
    let plain = given.replace(['·', '*', ' ', '⋅'], ".").replace(['µ', 'μ'], "u");
    let same = |u: &&Unit| u.si == name.unit() && u.symbol == plain;
    let Some(unit) = UNITS.iter().find(same) else {
        let units = UNITS.iter().filter(|u| u.si == name.unit()).map(|u| u.symbol);
        let allowed = units.collect::<Vec<_>>().join(", ");
        return Err(Error::Unit { name: name.name(), unit: given.into(), allowed });
    };
    Ok(Quantity { value: number * unit.times / unit.over, has_unit: true })
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

/// The values of several numbers of one parameter. Either all have a unit or none, so that `9:11Hz` is no mixture.
///
/// # Errors
/// As [`number`], the range of a value, and [`Error::Form`] for a mixture.
pub fn numbers(name: Name, texts: &[&str]) -> Result<Vec<f64>> {
    let all = texts.iter().map(|text| quantity(name, text)).collect::<Result<Vec<_>>>()?;
    if all.iter().any(|q| q.has_unit != all[0].has_unit) {
        let text = format!("{}={}", name.name(), texts.join(":"));
        return Err(Error::Form { text, expected: "a unit at every number or at none" });
    }
    all.iter().map(|q| name.check(q.value).map(|()| q.value).map_err(Error::from)).collect()
}
