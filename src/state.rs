//! The state of the three bodies.

use serde::{Deserialize, Serialize};

/// Displacements (m) and velocities (m/s) of box, block and secondary oscillator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// x1, x2, x3 in m.
    pub x: [f64; 3],
    /// x1', x2', x3' in m/s.
    pub v: [f64; 3],
}

impl State {
    /// x1, w = x2 - x1, x3 and their rates: the simulator's coordinates (docs/theory.md (5)).
    pub fn to_relative(&self) -> [f64; 6] {
        let Self { x, v } = self;
        [x[0], x[1] - x[0], x[2], v[0], v[1] - v[0], v[2]]
    }

    /// State from x1, w, x3 and their rates, as [`to_relative`](Self::to_relative) returns them.
    pub fn from_relative(y: &[f64; 6]) -> Self {
        Self { x: [y[0], y[0] + y[1], y[2]], v: [y[3], y[3] + y[4], y[5]] }
    }
}
