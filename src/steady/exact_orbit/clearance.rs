//! Proof that an orbit keeps within the stops, up to its own rounding.

use super::super::PENETRATION_ROUNDING;
use vibro_numerics::bernstein::{Polynomial, stays_within};

/// Proof that the block keeps within the stops along the Taylor pieces of an orbit, to 1e-12 L and
/// the orbit's rounding. The rounding grows from piece to piece. It is large near the resonance of
/// a box without damper, because the part of the motion due to the force and the part due to the
/// impacts are then many gaps in size and cancel.
pub struct Clearance {
    limit: f64,
    of_pieces: f64,
    size: f64,
}

impl Clearance {
    /// Proof for flights of at most `pieces` Taylor pieces. `contact` is the distance between the
    /// flight's start and its stop, in gaps; `forced` is the box's amplitude under the force
    /// alone, in gaps.
    pub fn new(contact: f64, pieces: u32, forced: f64) -> Self {
        let limit = 1.0 + PENETRATION_ROUNDING + contact + 16.0 * f64::EPSILON * forced;
        Self { limit, of_pieces: f64::EPSILON * f64::from(pieces), size: 0.0 }
    }

    /// Whether the proof holds for the next piece. `w` (gaps) is its polynomial, and `x1` (gaps)
    /// the start of the box.
    pub fn holds(&mut self, w: &Polynomial, x1: f64) -> bool {
        self.size = self.size.max(1.0 + x1.abs());
        let limit = self.limit + self.of_pieces * self.size;
        stays_within(w, -limit, limit)
    }
}
