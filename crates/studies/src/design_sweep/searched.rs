//! A design measured at the values of its band and between them, with all its motions.

use super::between::{BandMotions, search_between};
use super::row::{BARS, summary};
use super::{Again, DesignMachine, DesignRow, MotionMeasures, SweepRequest, design, row};
use crate::error::Result;

/// A design's row with the summarized motions.
#[derive(Clone, Debug)]
pub struct SearchedRow {
    /// The row.
    pub row: DesignRow,
    /// Combinations of values of [`SweepRequest::over`]: the ones of the request, followed by the
    /// combinations that the search between them added.
    pub places: Vec<Vec<f64>>,
    /// Measures of the motions: for each combination in order, one entry per start.
    pub motions: Vec<MotionMeasures>,
}

/// The row of a design whose intervals are searched for the largest value of each measure of the
/// window, as [`choice`](super::choice) does for the designs that may be the best.
pub fn searched<M: DesignMachine>(set: &M, request: &SweepRequest<M>, values: Vec<f64>) -> SearchedRow {
    by_motions(set, request, &values).unwrap_or_else(|_| {
        // The row states the reason.
        let listed = SweepRequest {
            designs: super::Designs::Rows { names: request.designs.names(), rows: vec![values] },
            ..request.clone()
        };
        SearchedRow { row: row(set, &listed, 0), places: Vec::new(), motions: Vec::new() }
    })
}

fn by_motions<M: DesignMachine>(set: &M, request: &SweepRequest<M>, values: &[f64]) -> Result<SearchedRow> {
    let own = design(set, request, values)?;
    let asked = request.places();
    let count = asked.len();
    let mut looked = BandMotions::new(&own, request, asked);
    let mut unseen = vec![0.0; request.measures.len()];
    for (index, measure) in request.measures.iter().enumerate() {
        if M::is_of_window(measure) {
            looked.unseen = 0.0;
            search_between(&own, request, (index, f64::INFINITY), &mut looked);
            unseen[index] = looked.unseen;
        }
    }
    let again = Again { periods: request.periods, between: looked.places[count..].to_vec() };
    let again = (!again.between.is_empty()).then_some(again);
    let mut row = summary(set, values.to_vec(), request, &looked.outcomes, again);
    for (output, unseen) in row.outputs.iter_mut().zip(unseen) {
        if let Some(output) = output.as_mut().filter(|_| unseen > 0.0) {
            (output.spread, output.is_exact) = (output.spread.max(unseen / BARS), false);
        }
    }
    Ok(SearchedRow { row, places: looked.places, motions: looked.outcomes })
}
