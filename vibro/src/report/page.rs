//! The page: one file, pictures inside, no script.

use super::statement::{Statement, Verdict};
use crate::Result;
use crate::figures::canvas;
use crate::studies::Study;
use crate::table::Table;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use rayon::prelude::*;
use vibro_analysis::{ParameterSet, short};

const STYLE: &str = "body{font:16px/1.5 sans-serif;color:#222;max-width:1200px;margin:2em auto;padding:0 1em}\
h1,h2,h3{line-height:1.2}table{border-collapse:collapse;width:100%}td,th{border:1px solid #ccc;padding:.4em .6em;\
text-align:left;vertical-align:top}th{background:#f3f3f3}td.n{text-align:right;white-space:nowrap}\
img{max-width:100%;border:1px solid #ddd}.agrees{background:#e2f2e6}.partly{background:#fdf3d8}.differs{background:#f9dedc}\
.note{background:#eef3fa;padding:.8em 1em}small{color:#555}";

/// Text as it may stand between tags and in attributes.
fn text(words: &str) -> String {
    words.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Rounded for reading.
fn readable(cell: &str) -> String {
    match cell.parse::<f64>() {
        Ok(x) if x == f64::NEG_INFINITY => "−∞".into(),
        // Rounding first, so that there is no negative zero.
        Ok(x) => format!("{:.4}", (x * 1e4).round() / 1e4 + 0.0).replace('-', "−"),
        Err(_) => text(cell),
    }
}

pub(super) fn page(
    set: &ParameterSet,
    quick: bool,
    statements: &[Statement],
    spectra: &Table,
    studies: &[Study],
) -> Result<String> {
    let mut body =
        String::from("<h1>Near-resonant dynamics of a 3-DOF vibro-impact system: the study redone</h1>\n");
    body.push_str(
        "<p>After P. Fritzkowski and J. Awrejcewicz, <i>Nonlinear Dynamics</i> 106 (2021) 81–103, \
         doi:10.1007/s11071-021-06838-w. Motions are propagated exactly between impacts, events are located with proof.</p>\n",
    );
    body.push_str(&format!(
        "<p class=\"note\"><b>The parameters are not the paper's own.</b> Its text has lost the numbers of its data set; \
         here: {}. So a number of the paper can be met only in kind and about in place.{}</p>\n",
        text(&set.caption()),
        if quick { " This is the quick look: fewer values and periods than the paper's." } else { "" }
    ));
    body.push_str("<h2>The paper's statements and what is found</h2>\n<table><tr><th>where</th><th>the paper</th><th>found here</th><th>verdict</th></tr>\n");
    for s in statements {
        let class = match s.verdict {
            Verdict::Agrees => "agrees",
            Verdict::Partly => "partly",
            Verdict::Differs => "differs",
        };
        body.push_str(&format!(
            "<tr class=\"{class}\"><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
            text(s.place),
            text(s.paper),
            text(&s.found),
            s.verdict.name()
        ));
    }
    body.push_str("</table>\n<h2>Spectra of Lyapunov exponents (cf. table 2)</h2>\n<p>Per unit of the dimensionless time τ, value rising.</p>\n<table><tr>");
    let names: Vec<_> = spectra
        .header
        .iter()
        .map(|h| match h.as_str() {
            "f10" => "f̂₁₀".to_owned(),
            other => other.replace("lambda", "λ"),
        })
        .collect();
    for name in names {
        body.push_str(&format!("<th>{name}</th>"));
    }
    body.push_str("</tr>\n");
    for row in &spectra.rows {
        body.push_str("<tr>");
        for (i, cell) in row.iter().enumerate() {
            let number = i > 0 && i + 1 < row.len();
            let shown = match (i, number, cell.parse()) {
                (0, _, Ok(value)) => short(value),
                (_, true, _) => readable(cell),
                _ => text(cell),
            };
            body.push_str(&format!("<td{}>{shown}</td>", if number { " class=\"n\"" } else { "" }));
        }
        body.push_str("</tr>\n");
    }
    body.push_str("</table>\n<h2>Figures</h2>\n");
    let pictures = studies
        .par_iter()
        .map(|s| s.figure.as_ref().map(canvas::png).transpose())
        .collect::<Result<Vec<_>>>()?;
    for (study, picture) in studies.iter().zip(pictures) {
        body.push_str(&format!("<h3 id=\"{0}\">{0}: {1}</h3>\n", text(&study.name), text(&study.what)));
        if let Some(bytes) = picture {
            body.push_str(&format!(
                "<p><img alt=\"{}\" src=\"data:image/png;base64,{}\"></p>\n",
                text(&study.what),
                STANDARD.encode(bytes)
            ));
        }
        if !study.remarks.is_empty() {
            let lines: Vec<_> = study.remarks.iter().map(|r| format!("<li>{}</li>", text(r))).collect();
            body.push_str(&format!("<ul>{}</ul>\n", lines.join("")));
        }
        let files: Vec<_> = study.tables.iter().map(|t| format!("{}.csv", text(&t.0))).collect();
        body.push_str(&format!("<p><small>Numbers: {}</small></p>\n", files.join(", ")));
    }
    Ok(format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>vibro-impact: the study redone</title>\
         <style>{STYLE}</style></head>\n<body>\n{body}</body></html>\n"
    ))
}
