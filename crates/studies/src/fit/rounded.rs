//! Blocks that round their inputs: derivatives ignore the rounding steps.

use super::FitRequest;
use super::beside::Beside;
use super::evaluated::{Point, Reach};
use super::model::Model;
use super::unknowns::Unknowns;
use crate::Machine;
use crate::error::Result;

/// Largest negligible change by rounding over all samples, in units of their noise. Up to it, no
/// parameter moves by more than this fraction of its standard error.
const NEGLIGIBLE: f64 = 0.5;

/// Machine whose blocks do not round; `None` if no block rounds.
fn exact(machine: &Machine) -> Option<Machine> {
    let mut exact = machine.clone();
    let samplings = exact.description.blocks.iter_mut().filter_map(|block| block.sampling.as_mut());
    let mut rounds = false;
    for quantum in samplings.flat_map(|sampling| &mut sampling.quanta) {
        rounds |= quantum.take().is_some();
    }
    rounds.then_some(exact)
}

impl Model<'_> {
    /// Message if errors may be wrong because a block rounds its input with a visible effect;
    /// `variance` is the variance of the residuals.
    pub(super) fn rounding(
        &self,
        request: &FitRequest,
        (point, reach): (&Point, &Reach),
        beside: &Beside,
        variance: f64,
    ) -> Result<Option<String>> {
        let Some(machine) = exact(&request.machine) else { return Ok(None) };
        let request = FitRequest { machine, ..request.clone() };
        // A free quantum does not exist in the other machine.
        let (rates, sensors) = (&self.compared.rates, self.compared.sensors.clone());
        let unknowns = Unknowns::new(&request, rates, sensors);
        let other = unknowns.and_then(|own| self.compared.beside(&own, point, reach, false));
        let apart = other.map_or(f64::INFINITY, |other| beside.apart(&other, self.deviations()));
        let why = "a block rounds its input to a quantum, and derivatives do not include these steps";
        Ok((apart > NEGLIGIBLE * variance.sqrt()).then(|| why.to_owned()))
    }
}
