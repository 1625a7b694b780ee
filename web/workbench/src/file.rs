//! The text of a machine: problems by line, parameters by name, edits that keep all else.

use serde_json::{Value, json};
use std::io;
use vibro_machine::description::{BodyKind, Description, Dimension};
use vibro_machine::elements::Element;
use vibro_machine::refusal::{Problem, Refusal};
use vibro_numerics::quantities::quantity_in;
use vibro_studies::{Machine, common_period, places};
use wasm_bindgen::prelude::*;

/// Name of the file in messages; the page leaves it out.
const FILE: &str = "machine.toml";

/// Texts of the gallery with their file names.
macro_rules! examples {
    ($($name:literal),*) => {
        &[$(($name, include_str!(concat!("../../../examples/assembly/", $name)))),*]
    };
}
const EXAMPLES: &[(&str, &str)] = examples![
    "bouncing_ball.toml",
    "three_balls.toml",
    "cradle.toml",
    "damper_with_buffer.toml",
    "impact_pair.toml",
    "impact_damper.toml",
    "den_hartog.toml",
    "impact_on_spring.toml",
    "relay_bounce.toml",
    "belt_friction.toml",
    "coulomb_oscillator.toml",
    "brake_squeal.toml",
    "two_blocks.toml",
    "gear_backlash.toml",
    "rack_and_pinion.toml",
    "valve_train.toml",
    "percussion_drill.toml",
    "vibratory_conveyor.toml",
    "bead_column.toml",
    "pipe_supports.toml",
    "play_by_one_number.toml",
    "msl_backlash.toml",
    "msl_brake.toml",
    "msl_coupled_clutches.toml",
    "msl_elastogap.toml",
    "aster_sdnd106.toml",
    "paper_machine.toml",
    "cantilever.toml",
    "gear_mesh.toml",
    "iwan_joint.toml",
    "duffing_stop.toml",
    "pull_in.toml",
    "energy_sink.toml",
    "stribeck_brake.toml",
    "hammer_drill.toml",
    "run_up.toml",
    "servo.toml",
    "shaken_rig.toml",
    "shaken_box.toml",
    "blade_tip.toml",
    "underplatform_damper.toml",
    "bar_on_wall.toml",
    "cam_lift.csv",
    "cantilever_mass.mtx",
    "cantilever_stiffness.mtx",
    "shaken_rig.csv"
];

/// The gallery as JSON: pairs of file name and text, in the order of the page's list.
#[wasm_bindgen]
pub fn examples() -> String {
    let list: Vec<Value> = EXAMPLES.iter().map(|(name, text)| json!([name, text])).collect();
    Value::from(list).to_string()
}

/// Problems as the message of an error.
fn refused(problems: &[(Option<usize>, String)]) -> JsError {
    let list: Vec<Value> =
        problems.iter().map(|(line, words)| json!({ "line": line, "words": words })).collect();
    JsError::new(&Value::from(list).to_string())
}

/// The error of a machine that cannot move, with the line of the element that `words` names, if
/// any.
pub(crate) fn cannot(text: &str, words: &str) -> JsError {
    let named = |line: &str| {
        let name = line.trim().strip_prefix('[')?.split(']').next()?.rsplit('.').next()?.trim();
        Some(!name.is_empty() && words.split(|c: char| !c.is_alphanumeric() && c != '_').any(|w| w == name))
    };
    let line = text.lines().position(|line| named(line) == Some(true)).map(|at| at + 1);
    refused(&[(line, words.to_owned())])
}

/// Reads a machine; records are passed as names and texts.
pub(crate) fn read(text: &str, names: &[String], texts: &[String]) -> Result<Machine, JsError> {
    let records = |wanted: &str| {
        let place = names.iter().position(|name| name == wanted);
        place.map(|place| texts[place].clone()).ok_or_else(|| {
            let words = format!(
                "the record {wanted} is missing: drop it on this page together with the machine's file"
            );
            io::Error::new(io::ErrorKind::NotFound, words)
        })
    };
    Machine::parse(text, FILE, &records).map_err(|error| match error {
        vibro_studies::Error::Refusal(Refusal { problems, .. }) => {
            let problems: Vec<_> =
                problems.iter().map(|problem: &Problem| (problem.line, problem.to_string())).collect();
            refused(&problems)
        }
        other => refused(&[(None, other.to_string())]),
    })
}

/// A parameter written in the text, with a slider's range.
fn number(machine: &Machine, name: &str, line: usize) -> Option<Value> {
    let parameter = machine.description.parameter(name).ok()?;
    let ((factor, symbol), range) = (machine.unit(name), parameter.range());
    let bound = |x: f64| if x.is_finite() { Value::from(factor * x) } else { Value::Null };
    let exact = factor * parameter.value;
    // The display form has a minus sign that cannot be parsed.
    let value: f64 = vibro_studies::significant(exact).replace('\u{2212}', "-").parse().unwrap_or(exact);
    Some(json!({
        "name": name, "meaning": parameter.meaning, "unit": symbol, "si": parameter.unit,
        "value": value, "exact": parameter.value, "factor": factor,
        "min": bound(range.min), "max": bound(range.max), "allowed": range.allowed, "line": line,
    }))
}

/// Everything that the page shows of a machine except its motion.
pub(crate) fn described(machine: &Machine, text: &str) -> Value {
    let d = &machine.description;
    let places = places(text, d);
    let mut all: Vec<_> = places.iter().map(|(name, span)| (span.start, name)).collect();
    all.sort();
    let line = |at: usize| text[..at].matches('\n').count() + 1;
    let numbers: Vec<Value> =
        all.iter().filter_map(|&(start, name)| number(machine, name, line(start))).collect();
    let columns: Vec<Value> = d
        .named_quantities()
        .iter()
        .map(|q| json!({ "name": q.name, "unit": q.unit, "meaning": q.meaning }))
        .collect();
    let bodies: Vec<Value> = d
        .bodies
        .iter()
        .map(|body| {
            let rotates = body.dimension == Dimension::Rotation;
            let prescribed = matches!(body.kind, BodyKind::Prescribed { .. } | BodyKind::Integrated(_));
            json!({ "name": body.name, "rotates": rotates, "prescribed": prescribed, "inner": body.is_inner() })
        })
        .collect();
    json!({
        "name": d.name, "numbers": numbers, "columns": columns, "bodies": bodies, "elements": elements(d),
        "period": common_period(d), "records": d.signals().any(|of| of.signal.table.is_some()),
    })
}

fn elements(d: &Description) -> Vec<Value> {
    let of = |element: Element| {
        let gap = match element {
            Element::Stop(stop) => Some(stop.gap),
            _ => None,
        };
        let rotates = element.dimension(d) == Dimension::Rotation;
        json!({ "name": element.name(), "section": element.section(), "gap": gap, "rotates": rotates })
    };
    d.elements().map(of).collect()
}

/// The text of a machine with a new value of a parameter, written in place of the old one.
/// Everything else, including comments, is kept. A value without a unit is in the unit of the
/// text.
///
/// # Errors
/// The problems of the text, or why the value is refused, as JSON.
#[wasm_bindgen]
pub fn edited(
    text: &str,
    names: Vec<String>,
    texts: Vec<String>,
    name: &str,
    value: &str,
) -> Result<String, JsError> {
    let machine = read(text, &names, &texts)?;
    let span = places(text, &machine.description).remove(name);
    let span = span.ok_or_else(|| refused(&[(None, format!("{name}: no such parameter in the text"))]))?;
    machine.quantity(name, value).map_err(|error| refused(&[(None, error.to_string())]))?;
    let typed = quantity_in(machine.si_unit(name), value.trim()).and_then(|q| q.unit);
    // The unit keeps its spelling.
    let spelt = text[span.clone()]
        .trim_matches(['"', '\''])
        .trim_start_matches(|c: char| c.is_ascii_digit() || "+-._eE ".contains(c));
    let written = match (typed, machine.written_unit(name)) {
        (Some(_), _) => format!("{:?}", value.trim()),
        (None, Some(_)) => format!("\"{} {spelt}\"", value.trim()),
        // TOML does not allow numbers such as `.5` or `5.`.
        (None, None) => {
            value.trim().parse::<f64>().map_or_else(|_| format!("{value:?}"), |x| format!("{x:?}"))
        }
    };
    Ok(format!("{}{written}{}", &text[..span.start], &text[span.end..]))
}
