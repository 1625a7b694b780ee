//! Effect of block samples on derivatives (docs/assembly-law.md, section 19).

use super::lost::{Cause, Lost};
use super::machine::{Machine, Varied};
use crate::motion::{Event, EventKind};
use crate::system::{SampleAction, SampledVariation};
use nalgebra::DVector;

/// Returns the actions of sampled blocks in events.
pub(super) fn actions(events: &[Event]) -> Vec<SampleAction> {
    let action = |event: &Event| match event.kind {
        EventKind::Sample { action } => Some(action),
        _ => None,
    };
    events.iter().filter_map(action).collect()
}

impl Machine {
    /// Carries a derivative over samples; `z` is the state before them. Fails if a varying rounded
    /// input lies halfway between two multiples.
    pub(super) fn sample(
        &self,
        p: usize,
        (time, actions): (f64, &[SampleAction]),
        z: &DVector<f64>,
        delta: &mut DVector<f64>,
    ) -> Result<(), Lost> {
        let tangent = &self.tangents[p];
        let blocks = if tangent.is_zero { &[][..] } else { &tangent.blocks.samplers };
        let excess = |stop: usize| (!tangent.is_zero).then(|| &tangent.stops[stop].excess);
        let mut z = z.clone();
        let varied = SampledVariation { delta: delta.as_mut_slice(), blocks, excess: &excess, rounds: true };
        if let Some(block) = self.system.between_multiples(actions, &z, &varied) {
            let element = format!("block.{}", self.assembly.description.blocks[block].name);
            return Err(Lost { time, element, cause: Cause::Limit });
        }
        self.system.sample(actions, &mut z, &mut [varied]);
        Ok(())
    }

    /// Whether a column moves the time of a step at an instant at which blocks are sampled.
    pub(super) fn moves_steps(&self, column: &Varied, time: f64) -> bool {
        self.tangents[column.p].signals.later(time).is_some_and(|knot| knot.later != 0.0)
    }
}
