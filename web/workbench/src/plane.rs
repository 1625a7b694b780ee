//! Classes of motions over a plane of two parameters.

use crate::file::read;
use serde_json::json;
use vibro_machine::Start;
use vibro_studies::isoperiodic::{IsoperiodicRequest, PlaneMachine, check};
use vibro_studies::{Machine, ParameterAxis};
use wasm_bindgen::prelude::*;

/// A plane that is being computed.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Plane {
    machine: Machine,
    request: IsoperiodicRequest<Machine>,
}

#[wasm_bindgen]
impl Plane {
    /// The plane of the parameters `across` and `upwards`, SI: `ranges` contains both ends of
    /// each, `counts` their numbers of values. Motions begin with the machine's own start;
    /// `discard` returns of each are discarded.
    ///
    /// # Errors
    /// The problems of the text as JSON; names and ranges that are not allowed; motions without a
    /// class.
    #[wasm_bindgen(constructor)]
    #[allow(clippy::too_many_arguments)]
    pub fn new(
        text: &str,
        names: Vec<String>,
        texts: Vec<String>,
        across: &str,
        upwards: &str,
        ranges: &[f64],
        counts: &[u32],
        discard: u32,
    ) -> Result<Plane, JsError> {
        let machine = read(text, &names, &texts)?;
        let axis = |name: &str, k: usize| {
            let end = |i: usize| ranges.get(2 * k + i).copied().unwrap_or(0.0);
            let count = counts.get(k).copied().unwrap_or(0) as usize;
            ParameterAxis::of(name.to_owned(), (end(0), end(1)), count)
        };
        let (x, y) = (axis(across, 0)?, axis(upwards, 1)?);
        let request = IsoperiodicRequest { x, y, start: Start::default(), discard, exponents: None };
        check(&machine, &request)?;
        Ok(Self { machine, request })
    }

    /// A row of the plane, counted from the lowest, as JSON. For each value: its class (null if
    /// its motion has none), impacts and first contacts per return, and whether it rests.
    pub fn row(&self, row: usize) -> String {
        let points = self.machine.points(&self.request, row..row + 1, &mut ());
        let told = points.iter().map(|point| {
            let class = point.map(|point| point.class.name());
            json!([class, point.map(|point| point.contacts), point.is_some_and(|point| point.rests)])
        });
        json!(told.collect::<Vec<_>>()).to_string()
    }
}
