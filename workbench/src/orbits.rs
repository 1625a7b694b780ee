//! Branches of periodic orbits.

use crate::file::read;
use serde_json::{Value, json};
use vibro_analysis::assembly::{Measure, QuantityName};
use vibro_orbits::assembly::{Family, Stability, TreeOptions, tree};
use wasm_bindgen::prelude::*;

#[wasm_bindgen]
extern "C" {
    /// The worker's function that is told how many branches there are, and how many are known of,
    /// and says whether there is time for another.
    #[wasm_bindgen(js_namespace = globalThis, js_name = progressed, catch)]
    fn progressed(done: usize, known: usize) -> Result<bool, JsValue>;
}

/// The branches over a range of a parameter (SI) of the orbits on which motions settle, as JSON:
/// `known`, the number of branches known of, and `branches`, those that there was time for, each a
/// list of points `[value, largest of the quantity, 1 if stable, label, start on the orbit]`.
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
    let mut all = 0;
    let found = tree(&family, &TreeOptions { seeds: 12, ..TreeOptions::default() }, &mut |done, known| {
        all = known;
        progressed(done, known).unwrap_or(true)
    })?;
    let list = found.iter().map(|branch| {
        let points = branch.points.iter().map(|point| {
            let orbit = branch.orbit(point);
            let top = orbit.as_ref().and_then(|orbit| orbit.measure(&measure).ok());
            let start = orbit.as_ref().map(|orbit| orbit.start().to_toml());
            let stable = u8::from(point.stability == Stability::Stable);
            let label = point.special.as_ref().map(|special| special.kind.name());
            json!([point.value, top, stable, label, start])
        });
        points.collect::<Vec<Value>>()
    });
    Ok(json!({ "known": all, "branches": list.collect::<Vec<_>>() }).to_string())
}
