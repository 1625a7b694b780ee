//! What is wrong with a fit that is not accepted: where its residuals are, and which number would
//! take them up.

use super::evaluated::{Point, Reach};
use super::model::Model;
use super::places::Concentration;
use super::segments::DEFECTS;
use super::suspects::Suspect;
use super::{FitRequest, Fitted, Verdict, filter};
use crate::error::Result;

/// What is wrong with a fit that is not accepted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Misfit {
    /// Where residuals are concentrated.
    pub places: Vec<Concentration>,
    /// Numbers that are not free and would take up residuals, the best first.
    pub suspects: Vec<Suspect>,
}

/// Where the residuals of a fit are, and which numbers would take them up. Empty for a fit that is
/// accepted. `go_on` ends the search early by returning false. The search takes some ten fits'
/// steps.
///
/// # Errors
/// As [`fit`](super::fit()).
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
