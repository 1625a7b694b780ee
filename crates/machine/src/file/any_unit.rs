//! Numbers whose unit determines their dimension: named parameters, signals that blocks read.

use crate::description::Dimension;
use crate::kinds;
use crate::parameters::read;
use vibro_numerics::quantities::{UNITS, split};

/// SI units that are tried first: Hz only for units that end in Hz, then rad/s.
const FIRST: [&str; 2] = ["Hz", "rad/s"];

/// Returns the value of a text in SI, and the SI unit of its dimension.
pub(super) fn quantity(text: &str, allowed: &str) -> Result<(f64, &'static str), String> {
    let refused = || allowed.to_owned();
    let (number, symbol) = split(text).ok_or_else(refused)?;
    if symbol == "g" {
        let text = "`g` is ambiguous (gram or 9.80665 m/s2): use kg for a mass, \
                    or m/s2 for an acceleration";
        return Err(text.into());
    }
    // Hz stays 1/s, but revolutions are converted to rad.
    let first = FIRST.into_iter().skip(usize::from(!symbol.ends_with("Hz")));
    let dimensions = first.chain(UNITS.iter().map(|unit| unit.si));
    let value = |si| read(kinds::named(si), Dimension::Translation, text).ok();
    match symbol {
        "" => value("1").map(|value| (value, "1")),
        _ => dimensions.into_iter().find_map(|si| Some((value(si)?, si))),
    }
    .ok_or_else(|| match number.is_finite() && !symbol.is_empty() {
        true => format!("`{symbol}` is not a known unit; expected a unit such as mm, N or rad/s"),
        false => refused(),
    })
}
