//! Inputs and results of a simulation: loads, events, records, accounts, pauses.

use crate::model::SmoothMode;
use serde::{Deserialize, Serialize};

/// Whether the block flies or rests, and at which stop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Contact {
    /// The block is free between the stops.
    #[default]
    Flight,
    /// Resting contact at w = +L.
    RestUpper,
    /// Resting contact at w = -L.
    RestLower,
}

/// External forces on box, block and secondary oscillator: value and time derivatives 1…3 at the
/// moment they are set, `f_b(t) = Σ_k derivatives[b][k] (t - t0)^k / k!`; N, N/s, N/s², N/s³.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Loads {
    /// `[body][order]`.
    pub derivatives: [[f64; 4]; 3],
}

/// Event of a motion, as shown to an observer in order of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// An impact at stop `side` (+1 or -1).
    Impact {
        /// Time in s.
        time: f64,
        /// +1 upper, -1 lower.
        side: i8,
        /// |w'| before the impact, m/s.
        speed: f64,
        /// Impulse p on the box in direction `side`, N·s.
        impulse: f64,
    },
    /// A chatter run (or κ = 0) ended in resting contact.
    Rest {
        /// Instant at which the impacts accumulate, s. The state is at rest already after the last
        /// reported impact. The reported impact is earlier by t_c of docs/theory.md (16), which is
        /// at most 1.5e-8 sqrt(L/(a (1 - κ))); a is the acceleration that presses the block to the
        /// stop. The end of the advance, and later events, may lie between these two times. For κ
        /// = 0 or 1 - κ < 10⁻³ the instant is the time of the last impact itself.
        time: f64,
        /// +1 upper, -1 lower.
        side: i8,
    },
    /// The contact force fell through zero: the block leaves the stop.
    Release {
        /// Time in s.
        time: f64,
        /// +1 upper, -1 lower.
        side: i8,
    },
}

/// Counts and last values of the impacts since the start (energy accounts in [`EnergyAccounts`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ImpactRecord {
    /// Impacts at w = +L.
    pub upper: u64,
    /// Impacts at w = -L.
    pub lower: u64,
    /// Time of the last impact, s (0 before the first).
    pub last_time: f64,
    /// Impulse of the last impact, N·s.
    pub last_impulse: f64,
    /// Approach speed |w'⁻| of the last impact, m/s.
    pub last_speed: f64,
    /// Sum of the absolute impulses, N·s.
    pub total_impulse: f64,
    /// Signed impulse of the stops on the box, N·s, from all impacts and merges into rest, without
    /// the contact force in rest (docs/theory.md (114)). The impulse on the block is the opposite.
    pub box_impulse: f64,
}

/// Energy accounts in J since the start: mechanical = initial + input - damped - impact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EnergyAccounts {
    /// Kinetic and elastic energy now.
    pub mechanical: f64,
    /// Work of drive and loads.
    pub input: f64,
    /// Dissipated in c1 and c3.
    pub damped: f64,
    /// Lost at impacts.
    pub impact: f64,
}

/// Event at which an advance ends before its given time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pause {
    /// None: the advance goes through all events.
    #[default]
    Never,
    /// The first impact, after its law.
    AfterImpact,
    /// The first event (impact or release), before its law: the state is the left limit.
    BeforeEvent,
}

/// How an advance ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AdvanceOutcome {
    /// At the requested end.
    End,
    /// Just after the first impact, requested by [`Pause::AfterImpact`].
    Impact,
    /// Before the first event, requested by [`Pause::BeforeEvent`]; the event is due.
    EventDue,
}

/// Event that a motion has reached. Its law is not yet applied. Capture into rest is not a
/// separate event: the impact law decides on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum DueEvent {
    /// The block touches stop `side` from inside.
    Impact {
        /// +1 upper, -1 lower.
        side: i8,
    },
    /// The contact force at stop `side` has fallen to zero.
    Release {
        /// +1 upper, -1 lower.
        side: i8,
    },
}

impl DueEvent {
    /// The stop: +1 upper, -1 lower.
    pub fn side(self) -> i8 {
        match self {
            Self::Impact { side } | Self::Release { side } => side,
        }
    }
}

/// Counters of work done, with which tests detect a loss of efficiency.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct WorkCounters {
    /// Sub-steps begun.
    pub substeps: u64,
    /// Taylor expansions.
    pub expansions: u64,
    /// Root iterations (Newton or bisection).
    pub iterations: u64,
    /// Events handled.
    pub events: u64,
}

impl Contact {
    /// The smooth mode: flight, or rest at either stop.
    #[inline(always)]
    pub fn mode(self) -> SmoothMode {
        match self {
            Self::Flight => SmoothMode::Flight,
            _ => SmoothMode::Rest,
        }
    }

    /// Rest at the stop `side`, +1 or -1.
    pub(super) fn at(side: f64) -> Self {
        if side > 0.0 { Self::RestUpper } else { Self::RestLower }
    }

    /// +1 at the upper stop, -1 at the lower, 0 in flight.
    pub fn side(self) -> f64 {
        match self {
            Self::Flight => 0.0,
            Self::RestUpper => 1.0,
            Self::RestLower => -1.0,
        }
    }
}

impl ImpactRecord {
    /// Counts an impact at stop `side`.
    #[inline(always)]
    pub fn count(&mut self, side: f64, time: f64, speed: f64, impulse: f64) {
        // Computed without a branch, because the processor cannot predict the stops of a chaotic
        // motion.
        self.upper += u64::from(side > 0.0);
        self.lower += u64::from(side <= 0.0);
        (self.last_time, self.last_speed, self.last_impulse) = (time, speed, impulse);
        self.total_impulse += impulse;
        self.box_impulse += side * impulse;
    }
}
