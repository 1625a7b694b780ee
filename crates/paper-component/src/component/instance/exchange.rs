//! Integration by a host's own solver: time and continuous states.

use super::events::Present;
use super::initial::forces;
use super::{ComponentProblem, Engine, Instance, Interface, Outcome};
use crate::component::continuous::Continuous;
use fmi_doors::Model as _;

impl Instance {
    /// Whether the nominal values differ from the last reported ones; records the present values
    /// as reported. Only a host's solver needs them.
    pub(super) fn nominals_changed(&mut self) -> bool {
        if self.life.interface != Interface::ModelExchange {
            return false;
        }
        let now = self.nominals();
        let before = self.nominals_told.replace(now);
        before.is_some_and(|before| before != now)
    }

    pub(super) fn continuous_mut(&mut self) -> Outcome<&mut Continuous> {
        match &mut self.engine {
            Engine::Continuous(continuous) => Ok(continuous),
            _ => Err(ComponentProblem::sequence("the instance is not initialized")),
        }
    }

    /// Evaluates numbers of the model; in initialization at the start. All of them are finite.
    pub(super) fn with_continuous<const N: usize>(
        &self,
        names: [&'static str; N],
        evaluate: impl FnOnce(&Continuous) -> [f64; N],
    ) -> Outcome<[f64; N]> {
        let values = match self.present()? {
            Present::Continuous(continuous) => evaluate(&continuous),
            _ => {
                let (simulator, _) = self.initial_simulator(&self.settings)?;
                evaluate(&Continuous::start(&simulator, forces(&self.settings))?)
            }
        };
        match values.iter().position(|value| !value.is_finite()) {
            None => Ok(values),
            Some(i) => {
                Err(ComponentProblem::Overflow { name: names[i], value: values[i], time: self.time() })
            }
        }
    }
}
