//! States at whole drive periods in units of L and L ω10, by name, and the start that studies have in common.

use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::State;

/// A state at a whole drive period, x1, x2, x3 in units of L and v1, v2, v3 in units of L ω10.
pub type Section = [f64; 6];

/// Names of its entries.
pub const COORDINATES: [&str; 6] = ["x1", "x2", "x3", "v1", "v2", "v3"];

/// A state in these units.
pub fn section(p: &Parameters, state: &State) -> Section {
    let speed = p.stop_gap * p.box_frequency();
    let (x, v) = (state.x.map(|x| x / p.stop_gap), state.v.map(|v| v / speed));
    [x[0], x[1], x[2], v[0], v[1], v[2]]
}

/// A state from these units.
pub fn state(p: &Parameters, s: &Section) -> State {
    let speed = p.stop_gap * p.box_frequency();
    State { x: [s[0], s[1], s[2]].map(|x| x * p.stop_gap), v: [s[3], s[4], s[5]].map(|v| v * speed) }
}

/// A start with the block on its way to a stop.
pub const MOVING_BLOCK: Section = [0.0, 0.0, 0.0, 0.0, 1.0, 0.0];

/// The same in SI.
pub fn moving_block(p: &Parameters) -> State {
    state(p, &MOVING_BLOCK)
}
