//! `documentation/index.html`: a self-contained page with the variables of the table.

use crate::recipes::recipes;
use std::fmt::Write;
use vibro_figures::html::escape;
use vibro_paper_component::component::units::{ENUMERATION_TYPES, EnumerationType};
use vibro_paper_component::component::variables::{Edition, Kind, SECTIONS, VARIABLES, Variable};
use vibro_paper_component::fmi2::description::{MODEL_DESCRIPTION, MODEL_IDENTIFIER, MODEL_VERSION};
use vibro_paper_component::fmi3::description::start_settings;

static TEMPLATE: &str = include_str!("../../modelDescription/documentation/index.html");
static RUN: &str = include_str!("../../modelDescription/documentation/run.svg");
static SKETCH: &str = include_str!("../../modelDescription/documentation/sketch.svg");
static RESPONSE: &str = include_str!("../../modelDescription/documentation/response.svg");

/// Link to the live page.
const EXPLORER: &str = "<p><a href=\"explorer.html\">The machine, live</a>: move it, hear it hit, see where it settles. It opens in a \
browser, needs JavaScript and WebAssembly, and loads nothing.</p>";

/// The page, with a link to the live page if that page is packed too.
pub fn page(explorer: bool) -> String {
    TEMPLATE
        .replace("{{explorer}}", if explorer { EXPLORER } else { "" })
        .replace("{{name}}", MODEL_IDENTIFIER)
        .replace("{{version}}", MODEL_VERSION)
        .replace("{{description}}", &escape(MODEL_DESCRIPTION))
        .replace("{{variables}}", &variables())
        .replace("{{enumerations}}", &enumerations())
        .replace("{{recipes}}", &recipes())
        .replace("{{sketch}}", &inline(SKETCH, "sketch", "Sketch of the machine with its symbols"))
        .replace("{{picture}}", &inline(RUN, "run", "Time histories and phase portraits of a run"))
        .replace("{{response}}", &inline(RESPONSE, "response", "Amplitudes over the drive amplitude"))
}

/// An SVG file as an inline element with an accessible name. Ids of its clip paths get the stem as
/// prefix, since ids are unique in a page.
fn inline(file: &str, stem: &str, name: &str) -> String {
    let picture = file.find("<svg").map_or("", |start| &file[start..]);
    let picture = picture.replace("id=\"clip-", &format!("id=\"{stem}-clip-"));
    let picture = picture.replace("url(#clip-", &format!("url(#{stem}-clip-"));
    picture.replacen("<svg", &format!("<svg role=\"img\" aria-label=\"{name}\""), 1)
}

/// The table's rows by section, within a section in the order of the table.
fn variables() -> String {
    let mut rows = String::new();
    for section in SECTIONS {
        rows += &format!("<tr class=\"group\"><th colspan=\"6\">{}</th></tr>\n", section.heading());
        rows.extend(VARIABLES.iter().filter(|v| v.section == *section).map(row));
    }
    rows
}

fn row(v: &Variable) -> String {
    let kind = match v.kind {
        Kind::Real { .. } => v.unit().unwrap_or(""),
        Kind::Integer { .. } => "Integer",
        Kind::Boolean => "Boolean",
        Kind::Enumeration(declared) => declared.name,
        Kind::Clock => "Clock",
    };
    let shown = |start: Option<f64>| match (start, v.kind) {
        (None, _) => String::new(),
        (Some(start), Kind::Boolean) => (start != 0.0).to_string(),
        (Some(start), Kind::Enumeration(declared)) => item(declared, start),
        (Some(start), _) => start.to_string(),
    };
    let (start, start3) = (shown(v.start()), shown(v.start_in(&start_settings())));
    let start = if start == start3 { start } else { format!("{start}; FMI 3.0: {start3}") };
    let cells = [
        format!("<code>{}</code>", escape(v.name)),
        escape(v.description),
        escape(kind) + &lengths(v),
        escape(&start),
        range(v),
        format!("{}, {}{}", v.causality.name(), v.variability.name(), edition(v.edition)),
    ];
    format!("<tr><td>{}</td></tr>\n", cells.join("</td><td>"))
}

/// Dimensions of an array.
fn lengths(v: &Variable) -> String {
    match v.dimensions {
        [] => String::new(),
        lengths => format!(" {lengths:?}"),
    }
}

/// Names of the descriptions that have a variable; empty if all have it.
fn edition(edition: Edition) -> &'static str {
    match edition {
        Edition::Every => "",
        Edition::Extended => "; FMI 3.0 only",
        Edition::Arrays => "; FMI 3.0 with arrays only",
        Edition::Clocked => "; FMI 3.0 with a clock only",
    }
}

/// Valid values of a settable variable; bounds or items of an output.
fn range(v: &Variable) -> String {
    if v.start().is_some() {
        return escape(v.allowed());
    }
    match v.kind {
        Kind::Real { .. } => "any number".into(),
        Kind::Integer { min } => format!("at least {min}"),
        Kind::Boolean | Kind::Clock => "false or true".into(),
        Kind::Enumeration(declared) => {
            declared.items.iter().map(|item| item.name).collect::<Vec<_>>().join(", ")
        }
    }
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
