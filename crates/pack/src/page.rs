//! The documentation page of a described machine: its sketch, its description in words, and the
//! table of its variables.

use crate::error::Result;
use std::fmt::Write;
use vibro_figures::canvas;
use vibro_machine_component::{FILE, Plan, Quantity, Role};
use vibro_sketch::Sketch;

/// Style sheet: limited line length, scrolling tables, a dark scheme on request; the sketch stays
/// on white.
const STYLE: &str = ":root{color-scheme:light dark}body{font-family:sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;line-height:1.4}\
    table{border-collapse:collapse;display:block;overflow-x:auto}td,th{text-align:left;padding:.15rem .8rem .15rem 0;border-bottom:1px solid #8884}\
    figure{margin:0;overflow-x:auto}svg{max-width:100%;height:auto;background:#fff}code{white-space:nowrap}";

/// Smallest displayed width of the sketch, as a fraction of its drawn width: its names are then
/// nine pixels high. On a narrower page the sketch scrolls sideways.
const LEAST: f64 = 0.7;

/// Sections of the table: heading, explanation, roles.
const SECTIONS: [(&str, &str, &[Role]); 6] = [
    ("Inputs", "Added to a signal of the file; 0 unless set.", &[Role::Input]),
    (
        "Outputs",
        "States of stops and friction, impacts and impulses change at events only.",
        &[Role::Output, Role::Discrete],
    ),
    (
        "Parameters",
        "All parameters of the file, in SI. Tunable parameters may be set at events, or between \
         steps if the host does not handle events.",
        &[Role::Parameter, Role::Tunable],
    ),
    (
        "Calculated parameters",
        "Calculated from named parameters by expressions; they cannot be set.",
        &[Role::Calculated],
    ),
    ("Event indicators", "For the solver of a host in Model Exchange.", &[Role::Local]),
    (
        "Derivatives over a step",
        "Before the law of an event is applied, they do not include its jump; afterwards they do.",
        &[Role::Sensitivity],
    ),
];

/// The start value of a parameter, or of a value that follows from parameters.
fn start(plan: &Plan, quantity: Quantity) -> Option<f64> {
    match quantity {
        Quantity::Parameter(i) => Some(plan.table.parameters[i].value),
        Quantity::Following(i) => Some(plan.table.following[i].value),
        _ => None,
    }
}

/// Escapes the special characters of HTML, for example in a comment of the machine's file.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// The page. Names and units need no escaping: their characters have no meaning in HTML.
///
/// # Errors
/// [`Error::Picture`](crate::Error::Picture), only through a defect of this crate.
pub fn page(plan: &Plan) -> Result<String> {
    let (name, machine) = (plan.name(), &plan.assembly.description);
    let sketch = canvas::svg(&Sketch::new(machine))?;
    // An SVG within a page has no declaration.
    let sketch = sketch.find("<svg").map_or("", |from| &sketch[from..]);
    let width: f64 = sketch.split('"').nth(1).and_then(|width| width.parse().ok()).unwrap_or_default();
    let sketch = sketch.replacen("<svg", &format!("<svg style=\"min-width:{:.0}px\"", LEAST * width), 1);
    let counts = machine.counts().into_iter();
    let counts = counts.filter(|(count, _)| *count > 0).map(|(count, what)| format!("{what}: {count}"));
    let mut text = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\"><title>{name}</title><style>{STYLE}</style></head>\n\
         <body>\n<h1>{name}</h1>\n<figure>\n{sketch}</figure>\n<p>{}.</p>\n\
         <p>A piecewise linear machine. In Co-Simulation it is advanced by its exact flow from event to event: its result does not \
         depend on a tolerance or a step size. In Model Exchange the solver of the host integrates between events, and the law at \
         events is the same. The machine's file is <a href=\"../resources/{FILE}\">resources/{FILE}</a>.</p>\n",
        counts.collect::<Vec<_>>().join(", "),
    );
    for (heading, words, roles) in SECTIONS {
        let rows: Vec<_> = plan.table.rows.iter().filter(|row| roles.contains(&row.role)).collect();
        if rows.is_empty() {
            continue;
        }
        let start = rows.iter().any(|row| start(plan, row.quantity).is_some());
        let head = if start { "<th>Start</th><th></th>" } else { "" };
        // Writing to a String cannot fail.
        let _ = write!(
            text,
            "<h2>{heading}</h2>\n<p>{words}</p>\n<table>\n<tr><th>Variable</th><th>Unit</th><th>What it is</th>{head}</tr>\n"
        );
        for row in rows {
            let _ = write!(
                text,
                "<tr><td><code>{}</code></td><td>{}</td><td>{}</td>",
                row.name,
                row.unit,
                escaped(&row.meaning)
            );
            if let Some(value) = self::start(plan, row.quantity) {
                let kind = match row.role {
                    Role::Tunable => "tunable",
                    Role::Calculated => "calculated",
                    _ => "fixed",
                };
                let _ = write!(text, "<td>{value}</td><td>{kind}</td>");
            }
            text += "</tr>\n";
        }
        text += "</table>\n";
    }
    Ok(text + "</body>\n</html>\n")
}
