//! Branches of periodic orbits.

use crate::file::read;
use serde_json::{Value, json};
use vibro_analysis::assembly::{Measure, QuantityName};
use vibro_orbits::assembly::{Family, Stability, TreeOptions, tree};
use wasm_bindgen::prelude::*;

#[wasm_bindgen]
extern "C" {
    /// The worker's function that is told how many branches there are, and how many are known of.
    #[wasm_bindgen(js_namespace = globalThis, js_name = progressed, catch)]
    fn progressed(done: usize, known: usize) -> Result<(), JsValue>;
}

/// The branches over a range of a parameter (SI) of the orbits on which motions settle, as JSON: a
/// list of branches, each a list of points `[value, largest of the quantity, 1 if stable, label]`.
///
/// # Errors
/// The problems of the text as JSON; names and ranges that are not allowed.
#[wasm_bindgen]
pub fn branches(
    text: &str,
    names: Vec<String>,
    texts: Vec<String>,
    parameter: &str,
    range: &[f64],
    of: &str,
) -> Result<String, JsError> {
    let machine = read(text, &names, &texts)?;
    let ends = (range.first().copied().unwrap_or(0.0), range.get(1).copied().unwrap_or(0.0));
    let family = Family::new(&machine, parameter, ends)?;
    let of: QuantityName = of.parse()?;
    let measure: Measure = format!("maximum.{of}").parse()?;
    let found = tree(&family, &TreeOptions { seeds: 12, ..TreeOptions::default() }, &mut |done, known| {
        let _ = progressed(done, known);
        true
    })?;
    let list = found.iter().map(|branch| {
        let points = branch.points.iter().map(|point| {
            let top = branch.orbit(point).and_then(|orbit| orbit.measure(&measure).ok());
            let stable = u8::from(point.stability == Stability::Stable);
            let label = point.special.as_ref().map(|special| special.kind.name());
            json!([point.value, top, stable, label])
        });
        points.collect::<Vec<Value>>()
    });
    Ok(json!(list.collect::<Vec<_>>()).to_string())
}
