//! Report of a fit: verdict, parameters with errors, correlations, residuals, picture, versions.

use super::document::{document, table};
use crate::Result;
use crate::studies::Study;
use crate::studies::fit::{AT_BOUND, suspected};
use std::path::Path;
use vibro_figures::canvas;
use vibro_figures::html::escape;
use vibro_machine::quantity::NamedQuantity;
use vibro_numerics::digest::fnv1a;
use vibro_studies::fit::{FitRequest, Fitted, Misfit, Verdict};
use vibro_studies::{QuantityName, significant};

/// Significant digits of a standard error; they determine the decimals of its value.
const DIGITS: f64 = 2.0;
/// Largest number of decimals; beyond it, values are shown with an exponent.
const MOST_DECIMALS: f64 = 9.0;

/// Value and error, rounded to the digits of the error: `0.0050012` and `0.0000023`.
fn with_error(value: f64, error: f64) -> (String, String) {
    // Very small values have an exponent.
    let decimals = DIGITS - 1.0 - error.abs().log10().floor();
    if !decimals.is_finite() || decimals > MOST_DECIMALS || !value.is_finite() {
        return (significant(value), significant(error));
    }
    let decimals = decimals.max(0.0) as usize;
    let shown = |x: f64| format!("{x:.decimals$}").replace('-', "−");
    (shown(value), shown(error))
}

/// A value rounded to three digits.
fn rounded(x: f64) -> String {
    significant(format!("{x:.2e}").parse().unwrap_or(x))
}

/// Page of a finished fit. `files` are the files of the machine and the record.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output) if the picture cannot be drawn, and
/// [`Error::File`](crate::Error::File) for a file that cannot be read again.
pub fn fit_page(
    (request, fitted, misfit): (&FitRequest, &Fitted, &Misfit),
    study: &Study,
    command_line: &str,
    files: &[&Path],
) -> Result<String> {
    let name = escape(&request.machine.description.name);
    let picture = study.figure.as_ref().map(canvas::svg).transpose()?;
    let what = escape(&study.what);
    let picture = picture.map_or(String::new(), |svg| {
        let svg = svg.replacen("<svg ", &format!("<svg role=\"img\" aria-label=\"{what}\" "), 1);
        format!("<h2>Record and fitted motion</h2>\n<figure class=\"wide\">{svg}</figure>\n")
    });
    let body = [
        format!("<h1>{name}: fit to a record</h1>\n<p>A {what}.</p>\n"),
        verdict(&fitted.verdict),
        numbers(request, fitted),
        correlations(fitted),
        picture,
        residuals(request, fitted, misfit),
        origin(command_line, files)?,
    ]
    .concat();
    Ok(document(&format!("{}: fit to a record", request.machine.description.name), &body))
}

fn verdict(verdict: &Verdict) -> String {
    let class = match verdict {
        Verdict::Fits => "agrees",
        Verdict::Undecided(_) => "partly",
        Verdict::Misses(_) => "differs",
    };
    let remark = match verdict {
        Verdict::Fits => "",
        _ => " No errors are shown: they would hold for a motion other than the record's.",
    };
    format!("<p class=\"verdict {class}\"><b>{}</b>.{remark}</p>\n", escape(&verdict.to_string()))
}

/// Fitted parameters in the units of the machine's file, with errors and initial values.
fn numbers(request: &FitRequest, fitted: &Fitted) -> String {
    let own = &fitted.uncertainty;
    let errors = own.errors.iter().zip(&own.white);
    let rows = fitted.values.iter().zip(errors).map(|((name, value), (error, white))| {
        let (factor, symbol) = request.machine.unit(name);
        let begin = request.machine.description.get(name).map_or(String::new(), |x| significant(factor * x));
        let (shown, error) = match error {
            Some(_) if fitted.verdict != Verdict::Fits => (significant(factor * value), String::new()),
            Some(error) => {
                let (shown, error) = with_error(factor * value, factor * error);
                (shown, format!("± {error}"))
            }
            None => (significant(factor * value), "not determined".into()),
        };
        let white = white.filter(|_| fitted.verdict == Verdict::Fits);
        let white = white.map_or(String::new(), |x| rounded(factor * x));
        vec![escape(name), shown, error, escape(&symbol), begin, white]
    });
    let header =
        ["number", "fitted", "standard error", "unit", "first value", "error for white-noise residuals"];
    let combinations: String = own
        .undetermined
        .iter()
        .map(|own| {
            format!("<li>Not determined by the record (relative changes): {}</li>", escape(&own.to_string()))
        })
        .collect();
    let lost = fitted
        .lost
        .iter()
        .map(|lost| format!("<li>{}; finite differences are used instead</li>", escape(lost)));
    let at_bounds = fitted.at_bounds.iter().map(|(name, _)| format!("<li>{} {AT_BOUND}</li>", escape(name)));
    let notes = combinations + &lost.chain(at_bounds).collect::<String>();
    let notes = if notes.is_empty() { notes } else { format!("<ul>{notes}</ul>\n") };
    format!("<h2>Numbers</h2>\n{}{notes}", table(&header.map(String::from), rows))
}

/// Correlations of the parameters, with a darker background for stronger ones.
fn correlations(fitted: &Fitted) -> String {
    let own = &fitted.uncertainty;
    if own.names.len() < 2 {
        return String::new();
    }
    let header = std::iter::once(String::new()).chain(own.names.iter().map(|name| escape(name)));
    let cell = |x: &f64| {
        let strength = (60.0 * x.abs()).min(60.0);
        let text = format!("{x:.3}").replace('-', "−");
        format!(
            "<span style=\"background:color-mix(in srgb,#4a90d9 {strength:.0}%,transparent)\">{text}</span>"
        )
    };
    let rows = own.names.iter().zip(own.correlation.row_iter());
    let rows = rows.map(|(name, row)| std::iter::once(escape(name)).chain(row.iter().map(cell)).collect());
    let rows: Vec<Vec<String>> = rows.collect();
    format!("<h2>Correlations</h2>\n{}", table(&header.collect::<Vec<_>>(), rows))
}

/// Root mean square residuals, in SI, and the correlation of successive residuals.
fn residuals(request: &FitRequest, fitted: &Fitted, misfit: &Misfit) -> String {
    let unit = |name: &str| {
        let name = name.parse::<QuantityName>().ok();
        let named = name.and_then(|name| name.find(&request.machine.description).ok());
        // The residuals of a stop's contacts are times.
        named.map_or("s", |NamedQuantity { unit, .. }| unit)
    };
    let measured = &request.measured;
    let count = |name: &str| {
        let contacts = measured.contacts.iter().find(|own| own.0 == name);
        contacts.map_or(measured.times.len(), |own| own.1.len())
    };
    let rows = fitted
        .rms
        .iter()
        .map(|(name, rms)| vec![escape(name), rounded(*rms), unit(name).into(), count(name).to_string()]);
    let header = ["column or stop", "residual, rms", "unit", "samples"].map(String::from);
    let segments = match fitted.segments.len() {
        0 => String::new(),
        own => {
            format!(
                "<p>The motion is divided into {} segments, each with its own initial state.</p>\n",
                own + 1
            )
        }
    };
    let places = misfit.places.iter().map(ToString::to_string);
    let suspects = misfit.suspects.iter().map(|own| suspected(&request.machine, own));
    let notes: String = places.chain(suspects).map(|own| format!("<li>{}</li>", escape(&own))).collect();
    let notes = if notes.is_empty() { notes } else { format!("<ul>{notes}</ul>\n") };
    // Without given standard deviations, the weights are from the residuals themselves.
    let free = measured.samples().saturating_sub(fitted.values.len());
    let cost = request.sigma.as_ref().map_or(String::new(), |_| {
        format!(
            " Sum of squares of the residuals, in units of their noise: {} for {free} degrees of freedom.",
            significant(fitted.cost)
        )
    });
    format!(
        "<h2>Residuals</h2>\n{}<p>Correlation of a residual with the next one: {}. The fitted \
         motion stays near the record until {} s.{cost}</p>\n{notes}{segments}",
        table(&header, rows),
        rounded(fitted.uncertainty.persistence),
        significant(fitted.near_until),
    )
}

/// Version, command and files of the fit.
fn origin(command_line: &str, files: &[&Path]) -> Result<String> {
    let mut rows = Vec::new();
    for path in files {
        let bytes = std::fs::read(path).map_err(crate::Error::file("reading", path))?;
        rows.push(vec![
            escape(&path.display().to_string()),
            bytes.len().to_string(),
            format!("{:016x}", fnv1a(&bytes)),
        ]);
    }
    let header = ["file", "bytes", "digest (FNV-1a)"].map(String::from);
    Ok(format!(
        "<h2>How it was computed</h2>\n<p>vibro {}:</p>\n<pre>{}</pre>\n{}",
        env!("CARGO_PKG_VERSION"),
        escape(command_line),
        table(&header, rows)
    ))
}

#[cfg(test)]
mod tests {
    use super::with_error;

    #[test]
    fn closed_form_an_error_has_two_digits_and_its_number_as_many_decimals() {
        let pair = |a: &str, b: &str| (a.to_owned(), b.to_owned());
        assert_eq!(with_error(5.001234, 0.00234), pair("5.0012", "0.0023"));
        assert_eq!(with_error(-302_784.3, 667.2), pair("−302784", "667"));
        assert_eq!(with_error(1.0, 0.0), pair("1", "0"));
    }
}
