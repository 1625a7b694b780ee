//! The last step, kept so that its derivatives can be computed on request.

use super::events::{Changes, Present};
use super::{Engine, Instance};
use crate::component::sensitivity;
use crate::component::values::StepMatrices;
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{Loads, Simulator, Snapshot};

/// State at the beginning of the last step, and the settings that it took over there.
#[derive(Clone, Debug)]
pub(super) struct LastStep {
    pub(super) before: Snapshot,
    pub(super) parameters: Option<Parameters>,
    pub(super) loads: Option<Loads>,
}

impl LastStep {
    /// Saves the beginning of a step. The snapshot is written in place, since a step without an
    /// event takes little longer than a copy of the snapshot.
    #[inline]
    pub(super) fn begin<'a>(
        place: &'a mut Option<Self>,
        simulator: &Simulator,
        changes: &Changes<'_>,
    ) -> &'a mut Self {
        let new = || Self { before: simulator.snapshot(), parameters: None, loads: None };
        let step = place.get_or_insert_with(new);
        simulator.snapshot_into(&mut step.before);
        (step.parameters, step.loads) = (changes.parameters.copied(), changes.loads.copied());
        step
    }
}

impl Instance {
    /// Updates the derivatives over the last step. The derivatives include the law of an impact at
    /// the end of the step once the impact is shown. Without a last step, for a closed form, or if
    /// the motion cannot be replayed, they are the derivatives of a step of length zero.
    pub(super) fn refresh_step_matrices(&mut self) {
        if self.step_matrices.is_none() {
            self.step_matrices = Some(self.last_step_matrices().unwrap_or_default());
        }
    }

    fn last_step_matrices(&self) -> Option<StepMatrices> {
        let (Some(step), Engine::Simulation(simulator)) = (&self.last_step, &self.engine) else {
            return None;
        };
        let Ok(Present::Simulation(reached)) = self.present() else { return None };
        let mut replay = Simulator::clone(simulator).without_energy_accounts();
        replay.restore(&step.before).ok()?;
        let LastStep { parameters, loads, .. } = step;
        Changes { parameters: parameters.as_ref(), loads: loads.as_ref() }.put(&mut replay).ok()?;
        sensitivity::matrices(replay, &reached).ok()
    }
}
