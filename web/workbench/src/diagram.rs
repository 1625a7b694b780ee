//! One direction of a bifurcation diagram.

use crate::file::read;
use serde_json::json;
use vibro_machine::Start;
use vibro_studies::ParameterAxis;
use vibro_studies::diagram::{DiagramRequest, Direction};
use wasm_bindgen::prelude::*;

/// One direction of a diagram that is being computed.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Diagram(Direction);

#[wasm_bindgen]
impl Diagram {
    /// A direction of a diagram over a parameter, SI: `count` values from `from` to `to`, with a
    /// quantity's local maxima or its values at the section. `discard` and `keep` are returns.
    ///
    /// # Errors
    /// The problems of the text as JSON; names and ranges that are not allowed.
    #[wasm_bindgen(constructor)]
    #[allow(clippy::too_many_arguments)]
    pub fn new(
        text: &str,
        names: Vec<String>,
        texts: Vec<String>,
        parameter: &str,
        range: &[f64],
        count: usize,
        of: &str,
        at_section: bool,
        discard: u32,
        keep: u32,
        upward: bool,
    ) -> Result<Diagram, JsError> {
        let machine = read(text, &names, &texts)?;
        let ends = (range.first().copied().unwrap_or(0.0), range.get(1).copied().unwrap_or(0.0));
        let request = DiagramRequest {
            axis: ParameterAxis::of(parameter.to_owned(), ends, count)?,
            of: of.parse()?,
            at_section,
            discard,
            keep,
            exponents: None,
            anew: false,
            start: Start::default(),
        };
        Ok(Self(Direction::new(machine, request, upward)?))
    }

    /// The next value as JSON: `index`, `start` (the settled state, as a start file), `values`,
    /// `words` (its class); null after the last one.
    pub fn further(&mut self) -> String {
        let Some((index, start, point)) = self.0.next() else { return "null".into() };
        let values: Vec<f64> = point.iter().flat_map(|point| point.maxima.iter().map(|m| m.0)).collect();
        let words = point.as_ref().map_or(String::new(), |point| point.settled.class.name());
        let start = start.map(|start| start.to_toml());
        json!({ "index": index, "start": start, "values": values, "words": words }).to_string()
    }
}
