//! Diagnosis of a fit that is not accepted: where its residuals are, and which further parameter
//! would reduce them.

use super::evaluated::{Point, Reach};
use super::model::Model;
use super::places::Concentration;
use super::segments::DEFECTS;
use super::suspects::Suspect;
use super::{FitRequest, Fitted, Verdict, filter};
use crate::error::Result;

/// Diagnosis of a fit that is not accepted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Misfit {
    /// Concentrations of residuals.
    pub places: Vec<Concentration>,
    /// Parameters that are not free and would reduce the residuals, the best first.
    pub suspects: Vec<Suspect>,
}

/// Diagnoses a fit: concentrations of residuals, and parameters that would reduce them. Empty for
/// an accepted fit. `go_on` ends the search early by returning false. The search takes about as
/// many steps as ten fits.
///
/// # Errors
/// The same errors as [`fit`](super::fit()).
pub fn misfit(request: &FitRequest, fitted: &Fitted, go_on: &(dyn Fn() -> bool + Sync)) -> Result<Misfit> {
    if fitted.verdict == Verdict::Fits {
        return Ok(Misfit::default());
    }
    let carrying = filter::carrying(request)?;
    let request = carrying.as_ref().unwrap_or(request);
    let mut model = Model::new(request)?;
    let point = Point {
        values: fitted.values.iter().map(|(_, value)| *value).collect(),
        states: fitted.segments.iter().map(|own| own.state.iter().map(|(_, x)| *x).collect()).collect(),
    };
    let nodes = fitted.segments.iter().map(|own| own.time).collect();
    let mut reach = Reach { nodes, ..Reach::whole(model.end()) };
    if !reach.nodes.is_empty() {
        let sizes = model.sizes_of_states(&point.values)?;
        reach.weights = sizes.iter().map(|size| 1.0 / (DEFECTS[DEFECTS.len() - 1] * size)).collect();
    }
    if !model.has_sigma {
        model.reweigh(&point, &reach)?;
    }
    let made = model.unknowns.with(&point.values)?;
    let beside = model.beside(&point, &reach)?;
    let places = model.places_of(&beside, &made.machine.description, made.shift);
    Ok(Misfit { places, suspects: model.suspects(request, (&point, &reach), go_on)? })
}
