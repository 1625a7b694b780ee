//! Fit of a machine to a record: values with their errors, residuals, a picture.

use super::Study;
use crate::Result;
use crate::table::{CsvRows, exact};
use crate::wording::{self, axis};
use std::fmt::Write;
use vibro_figures::canvas::palette::{BLUE, GREY, VERMILLION};
use vibro_figures::chart::{Dash, Figure, Layer, Mark, Panel, Path, lettered};
use vibro_machine::What;
use vibro_machine::description::StopLaw;
use vibro_machine::quantity::NamedQuantity;
use vibro_studies::fit::{FitRequest, Fitted, Misfit, Suspect, Verdict};
use vibro_studies::{Machine, significant};

/// Remark on a parameter at an end of its range.
pub const AT_BOUND: &str = "is at an end of its range: its error holds to one side only";
/// Largest number of points in a curve.
const POINTS: usize = 2000;
/// Cap on the drawn columns of the record.
const DRAWN: usize = 4;

/// Study of a fit: `residuals.csv` for columns, `residuals-contacts.csv` for contacts, and a
/// picture of record, motion and residual.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output).
pub fn fit(request: &FitRequest, fitted: &Fitted, misfit: &Misfit) -> Result<Study> {
    let mut remarks = vec![format!("verdict: {}", fitted.verdict)];
    if fitted.verdict != Verdict::Fits {
        remarks.push("no errors are shown: they would hold for a motion other than the record's".into());
    }
    for ((name, value), error) in fitted.values.iter().zip(&fitted.uncertainty.errors) {
        let unit = request.machine.si_unit(name);
        let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
        remarks.push(match error {
            Some(_) if fitted.verdict != Verdict::Fits => format!("{name} = {}{unit}", significant(*value)),
            Some(error) => {
                let vague = if *error > value.abs() { ", less than its error: may be 0" } else { "" };
                format!("{name} = {} ± {}{unit}{vague}", significant(*value), significant(*error))
            }
            None if is_undetermined(fitted, name) => {
                format!("{name} = {}{unit}: the record does not determine it", significant(*value))
            }
            None => format!("{name} = {}{unit}, without an error", significant(*value)),
        });
    }
    for own in &fitted.uncertainty.undetermined {
        remarks.push(format!("not determined (relative changes): {own}"));
    }
    remarks.extend(fitted.at_bounds.iter().map(|(name, _)| format!("{name} {AT_BOUND}")));
    remarks.extend(fitted.lost.iter().map(|lost| format!("{lost}; finite differences are used instead")));
    for (name, rms) in &fitted.rms {
        remarks.push(format!("rms residual of {name}: {} SI", significant(*rms)));
    }
    remarks.extend(misfit.places.iter().map(ToString::to_string));
    remarks.extend(misfit.suspects.iter().map(|own| suspected(&request.machine, own)));
    if !fitted.segments.is_empty() {
        let defects = fitted.segments.iter().flat_map(|own| &own.defect);
        let most = defects.fold(0.0, |most: f64, defect| most.max(defect.abs()));
        let count = fitted.segments.len() + 1;
        remarks.push(format!(
            "in {count} segments; largest gap between the end of a segment and the start of the next: {} SI",
            significant(most)
        ));
    }
    let last = fitted.near_until;
    let end = request.measured.times.last().copied().unwrap_or(last);
    if last < end {
        remarks.push(format!(
            "the fitted motion departs from the record at {} s: a local minimum, or the machine \
             lacks an effect",
            significant(last)
        ));
    }
    let what = format!(
        "fit of {} parameters to {} samples in {} simulations",
        fitted.values.len(),
        request.measured.samples(),
        fitted.simulations
    );
    let mut tables = Vec::new();
    if !request.measured.columns.is_empty() {
        tables.push(("residuals".into(), residual_table(request, fitted)?));
    }
    if !request.measured.contacts.is_empty() {
        tables.push(("residuals-contacts".into(), contact_table(request, fitted)?));
    }
    let figure = (!request.measured.columns.is_empty()).then(|| figure(request, fitted)).transpose()?;
    Ok(Study { tables, figure, ..Study::without_figure("fit", what).with_remarks(remarks) })
}

/// Parameters of several records that were fitted together: a table `numbers.csv` with a row for
/// each record and parameter. Shared parameters have the same value in each record.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output).
pub fn fit_numbers(names: &[&str], requests: &[FitRequest], all: &[Fitted]) -> Result<Study> {
    let mut table = CsvRows::new(["record", "number", "value", "error"])?;
    for (record, fitted) in names.iter().zip(all) {
        let fits = fitted.verdict == Verdict::Fits;
        for ((name, value), error) in fitted.values.iter().zip(&fitted.uncertainty.errors) {
            let error = error.filter(|_| fits).map_or(String::new(), exact);
            table.push([(*record).to_owned(), name.clone(), exact(*value), error])?;
        }
    }
    let samples: usize = requests.iter().map(|own| own.measured.samples()).sum();
    let what = format!(
        "fit of {} records together, {samples} samples in {} simulations",
        all.len(),
        all.first().map_or(0, |own| own.simulations)
    );
    Ok(Study { tables: vec![("numbers".into(), table.text()?)], ..Study::without_figure("numbers", what) })
}

/// Describes how a parameter that is not free would change the residuals.
pub fn suspected(machine: &Machine, own: &Suspect) -> String {
    let is_of_file = machine.description.get(&own.name).is_ok();
    let shown = |x: f64| match is_of_file {
        true => machine.told(&own.name, x),
        false => format!("{} {}", significant(x), own.unit),
    };
    let (name, value, better) = (&own.name, shown(own.value), shown(own.better));
    let what = if is_of_file { format!("{name} ({value})") } else { format!("{name} (none)") };
    format!(
        "{what}: with {better} the residuals would fall to {:.1} % of their present size",
        100.0 * own.left
    )
}

/// Whether a parameter is part of an undetermined combination.
fn is_undetermined(fitted: &Fitted, name: &str) -> bool {
    let all = fitted.uncertainty.undetermined.iter().flat_map(|own| &own.combination);
    all.into_iter().any(|(own, _)| own == name)
}

/// Text of `fit.json`.
pub fn fit_json(fitted: &Fitted, misfit: &Misfit) -> String {
    let number = |x: f64| if x.is_finite() { format!("{x:?}") } else { "null".into() };
    let quoted = |text: &str| format!("{text:?}");
    let list = |all: Vec<String>| all.join(", ");
    let own = &fitted.uncertainty;
    let parameters =
        fitted.values.iter().zip(own.errors.iter().zip(&own.white)).map(|((name, value), (error, white))| {
            let [error, white] = [error, white].map(|x| x.map_or("null".into(), number));
            format!(
                "{}: {{\"value\": {}, \"error\": {error}, \"white_error\": {white}}}",
                quoted(name),
                number(*value)
            )
        });
    let names = own.names.iter().map(|name| quoted(name)).collect();
    let rows =
        own.correlation.row_iter().map(|row| format!("[{}]", list(row.iter().map(|x| number(*x)).collect())));
    let undetermined = own.undetermined.iter().map(|own| {
        let parts = own.combination.iter().map(|(name, part)| format!("{}: {}", quoted(name), number(*part)));
        let (parts, value) = (list(parts.collect()), number(own.singular_value));
        format!("{{\"combination\": {{{parts}}}, \"singular_value\": {value}}}")
    });
    let rms = fitted.rms.iter().map(|(name, rms)| format!("{}: {}", quoted(name), number(*rms)));
    let at_bounds = fitted.at_bounds.iter().map(|(name, end)| format!("{}: {}", quoted(name), number(*end)));
    let segments = fitted.segments.iter().map(|own| {
        let named = own.state.iter().zip(&own.defect);
        let (state, defect): (Vec<_>, Vec<_>) = named
            .map(|((name, x), d)| [*x, *d].map(|x| format!("{}: {}", quoted(name), number(x))).into())
            .unzip();
        let (time, state, defect) = (number(own.time), list(state), list(defect));
        format!("{{\"time\": {time}, \"state\": {{{state}}}, \"defect\": {{{defect}}}}}")
    });
    let places = misfit.places.iter().map(|own| quoted(&own.to_string()));
    let suspects = misfit.suspects.iter().map(|own| {
        let numbers = [own.value, own.better, own.left].map(number);
        let [value, better, left] = numbers;
        let name = quoted(&own.name);
        format!("{{\"name\": {name}, \"value\": {value}, \"better\": {better}, \"left\": {left}}}")
    });
    let mut text = String::new();
    // Writing to a string does not fail.
    let _ = writeln!(
        text,
        "{{\n  \"verdict\": {},\n  \"parameters\": {{{}}},\n  \"correlation\": {{\"names\": [{}], \"matrix\": [{}]}},\n  \"undetermined\": [{}],\n  \"rms\": {{{}}},\n  \"simulations\": {},\n  \"near_until\": {},\n  \"at_bounds\": {{{}}},\n  \"persistence\": {},\n  \"segments\": [{}],\n  \"places\": [{}],\n  \"suspects\": [{}]\n}}",
        quoted(&fitted.verdict.to_string()),
        list(parameters.collect()),
        list(names),
        list(rows.collect()),
        list(undetermined.collect()),
        list(rms.collect()),
        fitted.simulations,
        number(fitted.near_until),
        list(at_bounds.collect()),
        number(own.persistence),
        list(segments.collect()),
        list(places.collect()),
        list(suspects.collect())
    );
    text
}

fn residual_table(request: &FitRequest, fitted: &Fitted) -> Result<Vec<u8>> {
    let names = request.measured.columns.iter().map(|(name, _)| name.to_string());
    let header: Vec<String> = std::iter::once("time".to_owned())
        .chain(names.flat_map(|name| [name.clone(), format!("{name}.fit"), format!("{name}.residual")]))
        .collect();
    let mut table = CsvRows::new(&header)?;
    for (i, (time, residuals)) in request.measured.times.iter().zip(&fitted.residuals).enumerate() {
        let cells = residuals.iter().zip(&request.measured.columns).flat_map(|(residual, (_, values))| {
            [exact(values[i]), exact(values[i] + residual), exact(*residual)]
        });
        table.push(std::iter::once(exact(*time)).chain(cells))?;
    }
    table.text()
}

/// A row for each contact of the record: the element, the time in the record, the time in the
/// fitted motion, and the difference of the two times. If the motion lacks the contact, the last
/// two cells are empty.
fn contact_table(request: &FitRequest, fitted: &Fitted) -> Result<Vec<u8>> {
    let mut table = CsvRows::new(["element", "time", "time.fit", "time.residual"])?;
    for ((name, times), (_, off)) in request.measured.contacts.iter().zip(&fitted.contacts) {
        for (time, off) in times.iter().zip(off) {
            let cell = |x: f64| if x.is_nan() { String::new() } else { exact(x) };
            table.push([name.clone(), exact(*time), cell(time + off), cell(*off)])?;
        }
    }
    table.text()
}

/// Contacts of the fitted motion as ticks below a record; `None` if there are none.
fn contacts(request: &FitRequest, fitted: &Fitted, values: &[f64]) -> Option<Layer> {
    let times = &request.measured.times;
    let (first, last) = (times.first().copied().unwrap_or(0.0), times.last().copied().unwrap_or(0.0));
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let inside = fitted.events.iter().map(|(time, _)| *time).filter(|time| (first..=last).contains(time));
    let every = fitted.events.len().div_ceil(POINTS).max(1);
    let ends = [0.1, 0.04].map(|below| least - below * (most - least));
    let ticks = inside.step_by(every).map(|time| ends.map(|y| (time, y)).to_vec());
    let ticks: Vec<Path> = ticks.collect();
    (!ticks.is_empty()).then(|| Layer::lines("contacts of the fitted motion", GREY, Dash::Solid, ticks))
}

/// A curve with a gap at each of these times, where the quantity jumps.
fn with_gaps(curve: Path, times: &[f64]) -> Path {
    let mut found = Path::new();
    for point in curve {
        if let Some((before, _)) = found.last() {
            found.extend(
                times.iter().find(|time| *before < **time && **time <= point.0).map(|t| (*t, f64::NAN)),
            );
        }
        found.push(point);
    }
    found
}

/// Two panels for each of the first [`DRAWN`] columns: the record with the fitted motion, and the
/// residual.
fn figure(request: &FitRequest, fitted: &Fitted) -> Result<Figure> {
    let measured = &request.measured;
    let mut panels = Vec::new();
    let end = measured.times.iter().fold(0.0, |most: f64, time| most.max(time.abs()));
    let time = || axis("time", "s", end);
    let every = measured.times.len().div_ceil(POINTS).max(1);
    let stops = &request.machine.description.stops;
    let rigid = stops.iter().filter(|stop| matches!(stop.law, StopLaw::Rigid { .. }));
    let rigid: Vec<&str> = rigid.map(|stop| stop.name.as_str()).collect();
    let hits = fitted.events.iter().filter(|(_, stop)| rigid.contains(&stop.as_str()));
    let impacts: Vec<f64> = hits.map(|(time, _)| *time).collect();
    for (k, (name, values)) in measured.columns.iter().enumerate().take(DRAWN) {
        let d = &request.machine.description;
        let (NamedQuantity { unit, .. }, words) = (name.find(d)?, wording::quantity(d, name));
        let size = values.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let path = |of: &dyn Fn(usize) -> f64| -> Path {
            (0..fitted.residuals.len()).step_by(every).map(|i| (measured.times[i], of(i))).collect()
        };
        // Only coordinates and elongations are continuous at an impact.
        let jumps = !matches!(name.what, What::S | What::E | What::TangentE(_));
        let moved = path(&|i| values[i] + fitted.residuals[i][k]);
        let moved = if jumps { with_gaps(moved, &impacts) } else { moved };
        let drawn = [
            Layer::marks("record", GREY, Mark::Disc, path(&|i| values[i])).stroke(5),
            Layer::line("fitted motion", BLUE, Dash::Solid, moved),
        ];
        panels.push(Panel {
            title: "record and motion".into(),
            x: time(),
            y: axis(&words, unit, size),
            layers: drawn.into_iter().chain(contacts(request, fitted, values)).collect(),
        });
        let size = fitted.residuals.iter().fold(0.0, |most: f64, all| most.max(all[k].abs()));
        panels.push(Panel {
            title: "residual".into(),
            x: time(),
            y: axis("motion less record", unit, size),
            layers: vec![Layer::line("residual", VERMILLION, Dash::Solid, path(&|i| fitted.residuals[i][k]))],
        });
    }
    lettered(&mut panels);
    let told =
        fitted.values.iter().zip(&fitted.uncertainty.errors).map(|((name, value), error)| match error {
            Some(_) if fitted.verdict != Verdict::Fits => format!("{name} = {}", significant(*value)),
            Some(error) => format!("{name} = {} ± {}", significant(*value), significant(*error)),
            None => format!("{name} undetermined"),
        });
    Ok(Figure {
        title: format!("{}: fit to a record", wording::title(&request.machine.description.name)),
        caption: vec![told.collect::<Vec<_>>().join(", ")],
        panels,
        columns: 2,
        panel: (1500, 900),
        shared_legend: false,
    })
}

#[cfg(test)]
mod tests {
    use super::with_gaps;

    /// The velocity of a ball is not joined across its impact at 0.55 s.
    #[test]
    fn golden_a_gap_at_each_jump() {
        let found = with_gaps(vec![(0.5, -5.0), (0.6, 3.0), (0.7, 2.0)], &[0.55]);
        assert!(found[1].0 == 0.55 && found[1].1.is_nan() && found.len() == 4, "{found:?}");
        assert_eq!(with_gaps(vec![(0.5, -5.0), (0.6, 3.0)], &[0.5, 0.7]).len(), 2);
    }
}
