//! Branches of periodic orbits.

use crate::file::read;
use serde_json::{Value, json};
use vibro_orbits::{Branch, Family, Stability, TreeOptions, tree};
use vibro_studies::{Measure, QuantityName};
use wasm_bindgen::prelude::*;

#[wasm_bindgen]
extern "C" {
    /// The worker's function that receives the new branches as JSON, and the number of branches
    /// and starts known so far. Returns whether there is time for another branch.
    #[wasm_bindgen(js_namespace = globalThis, js_name = progressed, catch)]
    fn progressed(branches: String, known: usize) -> Result<bool, JsValue>;
}

/// A branch as a list of points
/// `[value, largest value of the quantity, 1 if stable, label, start on the orbit]`.
fn listed(branch: &Branch, measure: &Measure) -> Value {
    let points = branch.points.iter().map(|point| {
        let orbit = branch.orbit(point);
        let top = orbit.as_ref().and_then(|orbit| orbit.measure(measure).ok());
        let start = orbit.as_ref().map(|orbit| orbit.start().to_toml());
        let stable = u8::from(point.stability == Stability::Stable);
        let label = point.special.as_ref().map(|special| special.label.name());
        json!([point.value, top, stable, label, start])
    });
    points.collect()
}

/// Follows the branches of the orbits on which motions settle, over a range of a parameter (SI).
/// Each branch is passed to `progressed` as soon as it has been followed, so that it is kept if
/// the worker is ended.
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
) -> Result<(), JsError> {
    let machine = read(text, &names, &texts)?;
    let ends = (range.first().copied().unwrap_or(0.0), range.get(1).copied().unwrap_or(0.0));
    let family = Family::new(&machine, parameter, ends)?;
    let of: QuantityName = of.parse()?;
    let measure: Measure = format!("maximum.{of}").parse()?;
    let mut count = 0;
    tree(&family, &TreeOptions { seeds: 12, ..TreeOptions::default() }, &mut |found, known| {
        let new: Vec<Value> = found[count..].iter().map(|branch| listed(branch, &measure)).collect();
        count = found.len();
        progressed(Value::from(new).to_string(), known).unwrap_or(true)
    })?;
    Ok(())
}
