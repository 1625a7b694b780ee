//! Data about events, kept between the calls of a host that handles them itself.

use super::values::OutputValues;
use serde::{Deserialize, Serialize};
use vibro_impact::simulator::{Contact, ImpactRecord, Simulator};

/// State of the event handling, as plain data.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct EventState {
    /// Values of the discrete outputs shown until the host handles the events that a step has
    /// passed.
    pub(crate) latched: Option<Discrete>,
    /// Whether the host was told about an event that it must handle before the next step.
    pub(crate) pending: bool,
    /// The stop of the last impact that a step has passed: +1 upper, -1 lower.
    pub(crate) side: i8,
    /// Whether the event was carried out, and nothing was set since then.
    pub(crate) carried_out: bool,
}

/// The values that change at events only.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Discrete {
    contact: Contact,
    pub(crate) impacts: ImpactRecord,
    impact_loss: f64,
}

impl Discrete {
    pub(crate) fn of(values: &OutputValues) -> Self {
        Self { contact: values.contact, impacts: values.impacts, impact_loss: values.impact_loss }
    }

    pub(crate) fn of_simulator(simulator: &Simulator) -> Self {
        Self {
            contact: simulator.contact(),
            impacts: *simulator.impacts(),
            impact_loss: simulator.impact_loss(),
        }
    }

    pub(crate) fn put(&self, values: &mut OutputValues) {
        (values.contact, values.impacts) = (self.contact, self.impacts);
        values.impact_loss = self.impact_loss;
    }
}
