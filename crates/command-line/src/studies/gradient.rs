//! Derivatives of an orbit's measure with respect to every parameter of its machine, as a table.

use super::Study;
use crate::Result;
use crate::table::{CsvRows, exact};
use vibro_orbits::{Orbit, ParameterDerivative};
use vibro_studies::significant;
use vibro_studies::{Machine, Measure};

/// Number of parameters listed on the screen.
const SHOWN: usize = 5;

/// Adds the table `gradient` to an orbit's study, and its main parameters to the remarks.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output); an error if the orbit does not have the measure.
pub fn add_gradient(study: &mut Study, machine: &Machine, orbit: &Orbit, of: &Measure) -> Result<()> {
    let (own, unit) = (orbit.measure(of)?, of.unit(&machine.description));
    let rows = orbit.gradient(of)?;
    // Relative change of the measure per relative change of the parameter.
    let relative = |row: &ParameterDerivative| {
        let derivative = row.derivative.as_ref().ok()?;
        Some(derivative * row.value / own).filter(|x| x.is_finite())
    };
    let cell = |value: Option<f64>| value.map_or(String::new(), exact);
    let derivative = format!("d {of}");
    let mut table = CsvRows::new(["parameter", "unit", "value", derivative.as_str(), "relative", "without"])?;
    for row in &rows {
        let why = row.derivative.as_ref().err().cloned().unwrap_or_default();
        table.push([
            row.parameter.clone(),
            row.unit.into(),
            exact(row.value),
            cell(row.derivative.as_ref().ok().copied()),
            cell(relative(row)),
            why,
        ])?;
    }
    study.tables.push(("gradient".into(), table.text()?));
    let mut largest: Vec<(f64, &str)> =
        rows.iter().filter_map(|row| Some((relative(row)?, row.parameter.as_str()))).collect();
    largest.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
    let words: Vec<String> =
        largest.iter().take(SHOWN).map(|(x, name)| format!("{name} {} %", significant(*x))).collect();
    let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
    let value = format!("{of} = {}{unit}", significant(own));
    study.remarks.push(match words.is_empty() {
        false => format!("{value}; largest changes for a 1 % larger parameter: {}", words.join(", ")),
        true => {
            format!("{value}: relative changes are not available; gradient.csv has the derivatives")
        }
    });
    let without = rows.iter().filter(|row| row.derivative.is_err()).count();
    if without > 0 {
        study.remarks.push(format!("{without} parameters have no derivative; gradient.csv has the reasons"));
    }
    Ok(())
}
