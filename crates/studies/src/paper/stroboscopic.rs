//! Stroboscopic states: dimensionless states at whole drive periods, with names for their
//! coordinates.

use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::State;

/// A state at a whole drive period: x1, x2, x3 in units of L, then v1, v2, v3 in units of L ω10
/// (docs/theory.md (20)).
pub type StroboscopicState = [f64; 6];

/// Names of the coordinates of a [`StroboscopicState`].
pub const COORDINATES: [&str; 6] = ["x1", "x2", "x3", "v1", "v2", "v3"];

/// A state in units of L and L ω10, from SI.
pub fn dimensionless(p: &Parameters, state: &State) -> StroboscopicState {
    Units::of(p).dimensionless(state)
}

/// The units of a [`StroboscopicState`], for many states of one machine.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Units {
    /// L, m.
    length: f64,
    /// L ω10, m/s.
    speed: f64,
}

impl Units {
    pub(crate) fn of(p: &Parameters) -> Self {
        Self { length: p.stop_gap, speed: p.stop_gap * p.box_frequency() }
    }

    /// L ω10, m/s.
    pub(crate) fn speed(&self) -> f64 {
        self.speed
    }

    pub(crate) fn dimensionless(&self, state: &State) -> StroboscopicState {
        let (x, v) = (state.x.map(|x| x / self.length), state.v.map(|v| v / self.speed));
        [x[0], x[1], x[2], v[0], v[1], v[2]]
    }
}

/// A state in SI, from units of L and L ω10.
pub fn dimensional(p: &Parameters, s: &StroboscopicState) -> State {
    let speed = p.stop_gap * p.box_frequency();
    State { x: [s[0], s[1], s[2]].map(|x| x * p.stop_gap), v: [s[3], s[4], s[5]].map(|v| v * speed) }
}

/// The common start of studies: everything at rest in the middle except the block, which moves
/// towards the upper stop with speed L ω10.
pub const MOVING_BLOCK: StroboscopicState = [0.0, 0.0, 0.0, 0.0, 1.0, 0.0];

/// [`MOVING_BLOCK`] in SI.
pub fn moving_block(p: &Parameters) -> State {
    dimensional(p, &MOVING_BLOCK)
}
