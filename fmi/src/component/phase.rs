//! How a component is used, and where it stands in its life.

use serde::{Deserialize, Serialize};

/// How a component is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Interface {
    /// The host brings the solver.
    ModelExchange,
    /// The component steps itself.
    CoSimulation,
}

impl Interface {
    /// Name for messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::ModelExchange => "Model Exchange",
            Self::CoSimulation => "Co-Simulation",
        }
    }
}

/// Where a component stands in its life, whatever a protocol calls it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    /// Just made or reset.
    Instantiated,
    /// The start is being set and looked at.
    Initialization,
    /// At an event, between two pieces of a host's integration.
    Event,
    /// A host's solver integrates.
    Continuous,
    /// At a communication point.
    Step,
    /// At the impact at which a step ended early: the next step may begin here, or the state saved before be put back.
    StoppedEarly,
    /// The simulation is over; outputs can still be read.
    Terminated,
    /// A panic has left it in an unknown state.
    Broken,
}

impl Phase {
    /// In words, for messages.
    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::Instantiated => "before initialization",
            Self::Initialization => "in initialization",
            Self::Event => "at an event",
            Self::Continuous => "between events",
            Self::Step => "at a communication point",
            Self::StoppedEarly => "at the impact at which the step ended",
            Self::Terminated => "after the end",
            Self::Broken => "after an internal error",
        }
    }
}

/// When the simulation begins, and where it ends at the latest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Experiment {
    pub(crate) start: f64,
    pub(crate) stop: Option<f64>,
}
