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
