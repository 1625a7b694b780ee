//! The hybrid loop: exact flow between events, events found with proof, the impact law at each.
//!
//! This file is the API skeleton; bodies follow.

use crate::error::Result;
use crate::parameters::Parameters;
use serde::{Deserialize, Serialize};

/// Displacements (m) and velocities (m/s) of box, block and secondary oscillator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// x1, x2, x3 in m.
    pub x: [f64; 3],
    /// x1', x2', x3' in m/s.
    pub v: [f64; 3],
}

/// Which smooth mode the motion is in.
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

/// External forces on box, block and secondary oscillator: value and time derivatives 1…3 at the moment they are
/// set, `f_b(t) = Σ_k derivatives[b][k] (t - t0)^k / k!`; N, N/s, N/s², N/s³.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Loads {
    /// `[body][order]`.
    pub derivatives: [[f64; 4]; 3],
}

/// What happened, in order of time, inside an advance.
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
        /// Time in s.
        time: f64,
        /// +1 upper, -1 lower.
        side: i8,
    },
    /// The contact force fell through zero: the block lets go.
    Release {
        /// Time in s.
        time: f64,
        /// +1 upper, -1 lower.
        side: i8,
    },
}

/// Counts and last values of the impacts since the start (energy accounts in [`Ledger`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ImpactRecord {
    /// Impacts at w = +L.
    pub upper: u64,
    /// Impacts at w = -L.
    pub lower: u64,
    /// Time of the last impact, s (0 before the first).
    pub last_time: f64,
    /// Its impulse, N·s.
    pub last_impulse: f64,
    /// Its approach speed |w'⁻|, m/s.
    pub last_speed: f64,
    /// Sum of all impulses (absolute), N·s.
    pub total_impulse: f64,
}

/// Energy accounts in J since the start: mechanical = initial + input - damped - impact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ledger {
    /// Kinetic and elastic energy now.
    pub mechanical: f64,
    /// Work of drive and loads.
    pub input: f64,
    /// Dissipated in c1 and c3.
    pub damped: f64,
    /// Lost at impacts.
    pub impact: f64,
}

/// How an advance ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// At the requested end.
    End,
    /// Just after the first impact, as asked for.
    Impact,
}

/// Counters of work done, for snapshots that catch lost efficiency.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Work {
    /// Sub-steps begun.
    pub substeps: u64,
    /// Taylor expansions.
    pub expansions: u64,
    /// Root iterations (Newton or bisection).
    pub iterations: u64,
    /// Events handled.
    pub events: u64,
}

/// The event-driven simulator of one system.
#[derive(Clone, Debug)]
pub struct Simulator {}

/// Everything that changes as the simulator advances, as plain data: restore then continue is bit-identical.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {}

#[allow(unused_variables, missing_docs)]
impl Simulator {
    /// Starts at `time` (s) from `state`. The drive's phase is `ω1 time + drive.phase`.
    ///
    /// # Errors
    /// `OutOfRange`, `Penetration`, `PrecisionLost`.
    pub fn new(parameters: &Parameters, state: &State, time: f64) -> Result<Self> {
        todo!()
    }
    pub fn parameters(&self) -> &Parameters {
        todo!()
    }
    /// Takes effect at once; a change of drive frequency keeps the drive's phase continuous.
    pub fn set_parameters(&mut self, parameters: &Parameters) -> Result<()> {
        todo!()
    }
    /// Loads from now on, as polynomials in the time from now.
    pub fn set_loads(&mut self, loads: &Loads) -> Result<()> {
        todo!()
    }
    pub fn time(&self) -> f64 {
        todo!()
    }
    pub fn state(&self) -> State {
        todo!()
    }
    pub fn contact(&self) -> Contact {
        todo!()
    }
    /// Accelerations of the three bodies (resting contact included), m/s².
    pub fn acceleration(&self) -> [f64; 3] {
        todo!()
    }
    /// Time derivatives of the three displacements: `[body][order]`, orders 0…5 (m/s^order).
    pub fn derivatives(&self) -> [[f64; 6]; 3] {
        todo!()
    }
    /// Relative displacement w (m) and velocity w' (m/s): exactly ±L and 0 in rest.
    pub fn gap(&self) -> (f64, f64) {
        todo!()
    }
    /// Contact force λ ≥ 0 in resting contact, 0 in flight, N.
    pub fn contact_force(&self) -> f64 {
        todo!()
    }
    /// Drive phase θ reduced to [0, 2π).
    pub fn drive_phase(&self) -> f64 {
        todo!()
    }
    pub fn ledger(&self) -> Ledger {
        todo!()
    }
    pub fn impacts(&self) -> &ImpactRecord {
        todo!()
    }
    pub fn work(&self) -> &Work {
        todo!()
    }
    /// Advances to exactly `end` (s).
    pub fn advance_to(&mut self, end: f64) -> Result<()> {
        todo!()
    }
    /// Advances to `begin + step` in extended precision, reporting each event; optionally stops after the first impact.
    pub fn advance(
        &mut self,
        begin: f64,
        step: f64,
        stop_at_impact: bool,
        on_event: &mut dyn FnMut(&Event),
    ) -> Result<StopReason> {
        todo!()
    }
    pub fn snapshot(&self) -> Snapshot {
        todo!()
    }
    /// Puts back a snapshot taken from any simulator with the same parameters (they are part of it).
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<()> {
        todo!()
    }
}
