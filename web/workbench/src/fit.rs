//! Fits of a machine to a record.

use crate::file::read;
use serde_json::{Value, json};
use vibro_machine::Start;
use vibro_machine::description::Description;
use vibro_machine::table::Table;
use vibro_studies::fit::{FitRequest, Fitted, Free, Loss, Measured, Segments, Verdict, fit};
use wasm_bindgen::prelude::*;

#[wasm_bindgen]
extern "C" {
    /// The worker's function, called at each step of a fit: whether to continue.
    #[wasm_bindgen(js_namespace = globalThis, js_name = goesOn, catch)]
    fn goes_on() -> Result<bool, JsValue>;
}

/// The record of a table: values over time, or times of contacts if it has a column `element`.
/// Without a machine, only the times are in SI.
fn record(text: &str, machine: Option<&Description>) -> Result<Measured, JsError> {
    let (table, mut measured) = (Table::read(text), Measured::default());
    match table.names().iter().any(|own| own.name == "element") {
        true => measured.add_contacts(&table)?,
        false => measured.add_columns(&table, machine)?,
    }
    Ok(measured)
}

/// Contents of a record, as JSON: `samples`, `columns`, `contacts`, `from` and `to` (s).
///
/// # Errors
/// If the table is not a record.
#[wasm_bindgen]
pub fn recorded(table: &str) -> Result<String, JsError> {
    let measured = record(table, None)?;
    let columns: Vec<String> = measured.columns.iter().map(|(name, _)| name.to_string()).collect();
    let contacts: Vec<&String> = measured.contacts.iter().map(|(name, _)| name).collect();
    let times = measured.times.iter().chain(measured.contacts.iter().flat_map(|(_, times)| times));
    let (from, to) =
        times.clone().fold((f64::INFINITY, f64::NEG_INFINITY), |ends, t| (ends.0.min(*t), ends.1.max(*t)));
    Ok(json!({ "samples": times.count(), "columns": columns, "contacts": contacts, "from": from, "to": to })
        .to_string())
}

/// The machine fitted to a record by the parameters `free`, as JSON: `verdict` (`fits`, `misses`
/// or `undecided`) and `words`, `values` (`name`, `value`, `error`, `unit`, SI), `undetermined`,
/// `remarks`, `times`, `columns` (`name`, `unit`, `record`, `motion`), `simulations`.
///
/// # Errors
/// The problems of the text as JSON; a table that is not a record; a motion that is too short.
#[wasm_bindgen]
pub fn fitted(
    text: &str,
    names: Vec<String>,
    texts: Vec<String>,
    table: &str,
    free: Vec<String>,
) -> Result<String, JsError> {
    let machine = read(text, &names, &texts)?;
    let measured = record(table, Some(&machine.description))?;
    let request = FitRequest {
        name: String::new(),
        machine,
        start: Start::default(),
        measured,
        free: free.into_iter().map(|name| Free { name, within: None, is_own: false }).collect(),
        sigma: None,
        loss: Loss::Linear,
        segments: Segments::Auto,
        filters: Vec::new(),
        starts: 0,
    };
    let fitted = fit(&request, &|_| goes_on().unwrap_or(true))?;
    Ok(told(&request, &fitted)?.to_string())
}

fn told(request: &FitRequest, fitted: &Fitted) -> Result<Value, JsError> {
    let (machine, measured) = (&request.machine, &request.measured);
    let (verdict, words) = match &fitted.verdict {
        Verdict::Fits => ("fits", ""),
        Verdict::Misses(why) => ("misses", why.as_str()),
        Verdict::Undecided(why) => ("undecided", why.as_str()),
    };
    let values = fitted.values.iter().zip(&fitted.uncertainty.errors).map(|((name, value), error)| {
        json!({ "name": name, "value": value, "error": error, "unit": machine.si_unit(name) })
    });
    let undetermined = fitted.uncertainty.undetermined.iter().map(ToString::to_string);
    let mut columns = Vec::new();
    for (k, (name, record)) in measured.columns.iter().enumerate() {
        let unit = name.find(&machine.description)?.unit;
        let motion = fitted.residuals.iter().zip(record).map(|(row, x)| x + row[k]);
        let motion: Vec<f64> = motion.collect();
        columns.push(json!({ "name": name.to_string(), "unit": unit, "record": record, "motion": motion }));
    }
    Ok(json!({
        "verdict": verdict, "words": words, "values": values.collect::<Vec<_>>(),
        "undetermined": undetermined.collect::<Vec<_>>(), "remarks": fitted.lost, "times": measured.times,
        "columns": columns, "simulations": fitted.simulations, "segments": fitted.segments.len(),
        "nearUntil": fitted.near_until,
    }))
}
