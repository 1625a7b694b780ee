//! The report as one HTML file with embedded pictures and no script.

use super::document::document;
use super::statement::{Statement, Verdict};
use crate::Result;
use crate::studies::Study;
use crate::table::TextTable;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use rayon::prelude::*;
use vibro_figures::canvas;
use vibro_figures::html::escape;
use vibro_studies::paper::{ParameterSet, short};

/// The whole page; `spectra` is the table of exponents.
pub(super) fn page(
    set: &ParameterSet,
    quick: bool,
    statements: &[Statement],
    spectra: &TextTable,
    studies: &[Study],
) -> Result<String> {
    let pictures = studies.par_iter().map(|s| s.figure.as_ref().map(canvas::png).transpose());
    let pictures = pictures.collect::<std::result::Result<Vec<_>, _>>()?;
    let figures = studies.iter().zip(pictures).map(|(study, picture)| figure(study, picture));
    let body = [introduction(set, quick), comparison(statements), exponents(spectra)].concat()
        + "<h2>Figures</h2>\n"
        + &figures.collect::<String>();
    Ok(document("vibro-impact: the study redone", &body))
}

/// Introduction: the paper, and the source of the parameters.
fn introduction(set: &ParameterSet, quick: bool) -> String {
    let quick =
        if quick { " This is the quick look: fewer values and periods than the paper's." } else { "" };
    format!(
        "<h1>Near-resonant dynamics of a 3-DOF vibro-impact system: the study redone</h1>\n\
         <p>After P. Fritzkowski and J. Awrejcewicz, <i>Nonlinear Dynamics</i> 106 (2021) 81–103, \
         doi:10.1007/s11071-021-06838-w. Motions are propagated exactly between impacts, events are located with proof.</p>\n\
         <p class=\"note\"><b>The default parameters are not the paper's own data set.</b> The copy of the paper this work was built \
         from lacks the displayed numbers, so that most default values are a reconstruction. A reader who holds the paper sets its \
         values with <code>--config FILE</code> or <code>--set NAME=VALUE</code>. Here: {}. With these, a number of the \
         paper can be met only in kind and at about the same place.{quick}</p>\n",
        escape(&set.caption())
    )
}

/// Table of the paper's statements with the results.
fn comparison(statements: &[Statement]) -> String {
    let row = |s: &Statement| {
        let class = match s.verdict {
            Verdict::Agrees => "agrees",
            Verdict::Partly => "partly",
            Verdict::Differs => "differs",
        };
        let cells = [escape(s.place), escape(s.paper), escape(&s.found), s.verdict.name().into()];
        format!("<tr class=\"{class}\"><td>{}</td></tr>\n", cells.join("</td><td>"))
    };
    format!(
        "<h2>The paper's statements and what is found</h2>\n<div class=\"wide\"><table><tr><th>where</th><th>the paper</th>\
         <th>found here</th><th>verdict</th></tr>\n{}</table></div>\n",
        statements.iter().map(row).collect::<String>()
    )
}

/// Table of exponents: value, numbers, class, ends of the stable range.
fn exponents(spectra: &TextTable) -> String {
    let name = |name: &String| match name.as_str() {
        "f10" => "<th>f̂₁₀</th>".to_owned(),
        other => format!("<th>{}</th>", other.replace("lambda", "λ")),
    };
    let row = |row: &Vec<String>| {
        let cell = |(i, cell): (usize, &String)| match cell.parse() {
            Ok(value) if i == 0 => format!("<td>{}</td>", short(value)),
            Ok(_) => format!("<td class=\"n\">{}</td>", readable(cell)),
            _ => format!("<td>{}</td>", escape(cell)),
        };
        format!("<tr>{}</tr>\n", row.iter().enumerate().map(cell).collect::<String>())
    };
    format!(
        "<h2>Spectra of Lyapunov exponents (cf. table 2)</h2>\n<p>Per unit of the dimensionless time τ, value rising.</p>\n\
         <div class=\"wide\"><table><tr>{}</tr>\n{}</table></div>\n",
        spectra.header.iter().map(name).collect::<String>(),
        spectra.rows.iter().map(row).collect::<String>()
    )
}

/// A number with four decimals; other text unchanged.
fn readable(cell: &str) -> String {
    match cell.parse::<f64>() {
        Ok(x) if x == f64::NEG_INFINITY => "−∞".into(),
        // The number is rounded before zero is added, which removes a negative zero.
        Ok(x) => format!("{:.4}", (x * 1e4).round() / 1e4 + 0.0).replace('-', "−"),
        Err(_) => escape(cell),
    }
}

/// A study: picture as PNG, remarks, names of the files with its numbers.
fn figure(study: &Study, picture: Option<Vec<u8>>) -> String {
    let (name, what) = (escape(&study.name), escape(&study.what));
    let caption = study.figure.as_ref().map_or(String::new(), |figure| escape(&figure.caption.join(" ")));
    let picture = picture.map_or(String::new(), |bytes| {
        let data = STANDARD.encode(bytes);
        format!(
            "<p><img alt=\"{what}\" src=\"data:image/png;base64,{data}\"></p>\n<p><small>{caption}</small></p>\n"
        )
    });
    let remarks: String = study.remarks.iter().map(|r| format!("<li>{}</li>", escape(r))).collect();
    let remarks = if remarks.is_empty() { remarks } else { format!("<ul>{remarks}</ul>\n") };
    let files: Vec<_> = study.tables.iter().map(|t| format!("{}.csv", escape(&t.0))).collect();
    format!(
        "<h3 id=\"{name}\">{name}: {what}</h3>\n{picture}{remarks}<p><small>Numbers: {}</small></p>\n",
        files.join(", ")
    )
}
