//! `documentation/index.html`: one self-contained page, its variables from the table.

use crate::describe::{causality, variability};
use std::fmt::Write;
use vibro_impact::fmi2::description::{MODEL_DESCRIPTION, MODEL_IDENTIFIER, MODEL_VERSION};
use vibro_impact::fmi2::units::{ENUMERATION_TYPES, EnumerationType};
use vibro_impact::fmi2::variables::{Kind, VARIABLES, Variable};

static TEMPLATE: &str = include_str!("../../modelDescription/documentation/index.html");
static PICTURE: &str = include_str!("../../modelDescription/documentation/run.svg");

/// The page.
pub fn page() -> String {
    let picture = PICTURE.find("<svg").map_or("", |start| &PICTURE[start..]);
    TEMPLATE
        .replace("{{name}}", MODEL_IDENTIFIER)
        .replace("{{version}}", MODEL_VERSION)
        .replace("{{description}}", &escape(MODEL_DESCRIPTION))
        .replace("{{variables}}", &variables())
        .replace("{{enumerations}}", &enumerations())
        .replace("{{picture}}", picture)
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

fn variables() -> String {
    VARIABLES.iter().map(row).collect()
}

fn row(v: &Variable) -> String {
    let kind = match v.kind {
        Kind::Real { .. } => v.unit().unwrap_or(""),
        Kind::Integer { .. } => "Integer",
        Kind::Boolean => "Boolean",
        Kind::Enumeration(declared) => declared.name,
    };
    let start = match (v.start(), v.kind) {
        (None, _) => String::new(),
        (Some(start), Kind::Boolean) => (start != 0.0).to_string(),
        (Some(start), Kind::Enumeration(declared)) => item(declared, start),
        (Some(start), _) => start.to_string(),
    };
    let cells = [
        format!("<code>{}</code>", escape(v.name)),
        escape(v.description),
        escape(kind),
        escape(&start),
        escape(v.allowed),
        format!("{}, {}", causality(v.causality), variability(v.variability)),
    ];
    format!("<tr><td>{}</td></tr>\n", cells.join("</td><td>"))
}

fn item(declared: EnumerationType, value: f64) -> String {
    let found = declared.items.iter().find(|item| f64::from(item.value) == value);
    found.map_or_else(String::new, |item| item.name.to_owned())
}

fn enumerations() -> String {
    let mut text = String::new();
    for declared in ENUMERATION_TYPES {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "<h3>{}: {}</h3>\n<dl>", declared.name, escape(declared.description));
        for item in declared.items {
            let _ = writeln!(
                text,
                "<dt>{} = {}</dt><dd>{}</dd>",
                item.value,
                item.name,
                escape(item.description)
            );
        }
        text += "</dl>\n";
    }
    text
}
