//! Reading of powers with an exponent: a power with two sides of springs and dampers, and the
//! curved force of a stop.

use super::reading::{Entry, FileTable, Reading};
use super::stepped;
use crate::description::{ContactLaw, DampingLimit, Dimension, OddPower, Signal, StopLaw};
use crate::kinds::{self, NumberKind};
use vibro_numerics::quantities::{plain_symbol, split};

/// Keys of a power with two sides.
pub(super) const KEYS: [&str; 2] = ["coefficient", "exponent"];
/// Keys of a stop's curved force.
pub(super) const CONTACT_KEYS: [&str; 2] = ["exponent", "dissipation"];

/// Whether a table of a spring or damper has a power with two sides.
pub(super) fn is_given(table: &FileTable) -> bool {
    KEYS.iter().any(|key| table.has(key))
}

/// Reads the power with two sides of a spring or damper; `Some(None)` if there is none, `None` if
/// it is refused. A table with one of `excluded` cannot have such a power.
pub(super) fn read(
    reading: &mut Reading,
    table: &FileTable,
    dimension: Dimension,
    (of_rate, excluded): (bool, &[&str]),
) -> Option<Option<OddPower>> {
    if !is_given(table) {
        return Some(None);
    }
    for (key, other) in [("exponent", "coefficient"), ("coefficient", "exponent")] {
        if !table.has(other) {
            let text =
                format!("requires `{other}`: the force is coefficient * |x|^exponent, with the sign of x");
            reading.excluded(table, key, &text);
            return None;
        }
    }
    let exponent = reading.required_number(table, "exponent", kinds::EXPONENT, dimension);
    let kind = kinds::coefficient_of_power(exponent.unwrap_or(f64::NAN), of_rate);
    let coefficient = reading.required(table, "coefficient", &kind.allowed(dimension))?;
    if let Some(other) = excluded.iter().find(|other| table.has(other)) {
        let text = format!("cannot be combined with `{other}`: use two springs in parallel");
        reading.refuse(&coefficient, text);
        return None;
    }
    let value = of_power(reading, &coefficient, (kind, exponent), dimension);
    Some(Some(OddPower { coefficient: value?, exponent: exponent? }))
}

/// Reads a number whose unit has the exponent.
fn of_power(
    reading: &mut Reading,
    entry: &Entry,
    (kind, exponent): (NumberKind, Option<f64>),
    dimension: Dimension,
) -> Option<f64> {
    let exponent = exponent?;
    let si = kind.unit(dimension);
    let written = entry.value.as_str().and_then(split).filter(|(_, unit)| !unit.is_empty());
    let (true, Some((number, unit))) = (si.ends_with('p'), written) else {
        return reading.number(entry, kind, dimension);
    };
    if let Some(other) = exponents_in(unit).find(|other| *other != exponent) {
        reading.refuse(entry, format!("its unit has the power {other}; expected the exponent {exponent}"));
        return None;
    }
    let Some(factor) = factor_of(unit, si, exponent) else {
        let expected = si.replace('.', " ").replace('p', &format!("^{exponent}"));
        let text = format!("cannot be in {unit}; expected {expected}, or a number without a unit");
        reading.refuse(entry, text);
        return None;
    };
    let value = number * factor;
    let fault = (!kind.contains(value)).then(|| kind.fault(value, dimension));
    fault.map_or(Some(value), |fault| {
        reading.refuse(entry, fault);
        None
    })
}

/// The value in the SI unit `si` of one of a unit whose exponents are `exponent`, written as p in
/// `si`. The force may have a prefix; a length may be in mm or um.
fn factor_of(unit: &str, si: &str, exponent: f64) -> Option<f64> {
    let unit = plain_symbol(unit);
    let (prefix, rest) = unit.split_once('N')?;
    let scale = match prefix {
        "" => 1.0,
        "m" => 1e-3,
        "k" => 1e3,
        "M" => 1e6,
        "G" => 1e9,
        _ => return None,
    };
    let power = exponent.to_string();
    let expected = si.strip_prefix('N')?.replace('p', &power);
    let lengths = [("/m", 0), ("/mm", 3), ("/um", 6)];
    let found = lengths.into_iter().find(|(length, _)| expected.replace("/m", length) == rest)?;
    Some(scale * 10f64.powi(found.1).powf(exponent))
}

/// The numbers in a unit, such as 2.2 in `N/m^2.2`.
fn exponents_in(unit: &str) -> impl Iterator<Item = f64> {
    let words = unit.split(|c: char| !c.is_ascii_digit() && c != '.');
    words.filter_map(|word| word.trim_matches('.').parse().ok())
}

/// Reads the law of a compliant stop with `exponent` or `dissipation`.
pub(super) fn contact(
    reading: &mut Reading,
    table: &FileTable,
    dimension: Dimension,
) -> Option<(StopLaw, Option<ContactLaw>)> {
    let exponent = reading.number_or(table, "exponent", kinds::EXPONENT, dimension, 1.0);
    let is_sound = alone(reading, table);
    let kind = kinds::stiffness_of_power(exponent.unwrap_or(f64::NAN));
    let allowed = kind.allowed(dimension);
    let stiffness = reading.required(table, "stiffness", &allowed);
    let stiffness = stiffness.and_then(|entry| match entry.value.is_table() {
        true => {
            let text = "a stiffness that steps in time cannot be combined with `exponent` or \
                        `dissipation`: use two stops in parallel";
            reading.refuse(&entry, text);
            None
        }
        false => of_power(reading, &entry, (kind, exponent), dimension),
    });
    let damping = reading.number_or(table, "damping", kinds::DAMPING, dimension, 0.0);
    let dissipation = match reading.optional(table, "dissipation") {
        Some(entry) => reading.number(&entry, kinds::DISSIPATION, dimension).map(Some),
        None => Some(None),
    };
    let (exponent, dissipation) = (exponent?, dissipation?);
    let limit = DampingLimit::NoPull;
    let law = StopLaw::Compliant { stiffness: stiffness?, damping: damping?, limit };
    // A parameter may give an exponent other than 1.
    let follows = reading.optional(table, "exponent").is_some_and(|entry| entry.value.is_str());
    let is_curved = exponent != 1.0 || follows || dissipation.is_some();
    is_sound.then_some((law, is_curved.then_some(ContactLaw { exponent, dissipation })))
}

/// Whether no other key excludes a curved force; refuses it otherwise.
fn alone(reading: &mut Reading, table: &FileTable) -> bool {
    let mut is_alone = true;
    if let (Some(entry), true) = (reading.optional(table, "dissipation"), table.has("damping")) {
        let text = "cannot be combined with `damping`: use `dissipation` for the contact of Hunt and \
                    Crossley, or `damping` for a linear dashpot";
        reading.refuse(&entry, text);
        is_alone = false;
    }
    if let Some(law) = reading.optional(table, "law")
        && reading.word(&law, &DampingLimit::ALL) != Some(DampingLimit::NoPull)
    {
        let key = CONTACT_KEYS.into_iter().find(|key| table.has(key)).unwrap_or_default();
        reading.refuse(&law, format!("cannot be combined with `{key}`; expected \"no-pull\""));
        is_alone = false;
    }
    is_alone
}

/// Reads the law of a compliant stop: straight, with steps in time, or curved.
pub(super) fn compliant(
    reading: &mut Reading,
    table: &FileTable,
    dimension: Dimension,
) -> Option<(StopLaw, Option<Signal>, Option<ContactLaw>)> {
    if CONTACT_KEYS.iter().any(|key| table.has(key)) {
        return contact(reading, table, dimension).map(|(law, contact)| (law, None, contact));
    }
    let stiffness = stepped::read(reading, table, kinds::STIFFNESS, dimension);
    let damping = reading.number_or(table, "damping", kinds::DAMPING, dimension, 0.0);
    let limit = match reading.optional(table, "law") {
        None => Some(DampingLimit::NoPull),
        Some(entry) => reading.word(&entry, &DampingLimit::ALL),
    };
    let (stiffness, stepped) = stiffness?;
    Some((StopLaw::Compliant { stiffness, damping: damping?, limit: limit? }, stepped, None))
}
