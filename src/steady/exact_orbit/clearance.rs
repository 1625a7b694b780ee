//! Whether an orbit keeps within the stops, to its own rounding.

use super::super::PENETRATION_ROUNDING;
use crate::numerics::bernstein::{Polynomial, stays_within};

/// The proof that the block keeps within the stops along the Taylor pieces of an orbit, to 1e-12 L
/// and the orbit's rounding. From piece to piece that adds up, and next to the resonance of a box
/// without damper what the force and the impacts do cancels: behind thousands of pieces, or of
/// gaps, it is more.
pub struct Clearance {
    limit: f64,
    of_pieces: f64,
    size: f64,
}

impl Clearance {
    /// For flights of so many `pieces` from a `contact` that is off its stop by so much (gaps),
    /// where the force alone would swing the box by `forced` gaps.
    pub fn new(contact: f64, pieces: u32, forced: f64) -> Self {
        let limit = 1.0 + PENETRATION_ROUNDING + contact + 16.0 * f64::EPSILON * forced;
        Self { limit, of_pieces: f64::EPSILON * f64::from(pieces), size: 0.0 }
    }

    /// Whether it is proved for the next piece, in which w (gaps) is a polynomial and the box
    /// begins at x1 (gaps).
    pub fn holds(&mut self, w: &Polynomial, x1: f64) -> bool {
        self.size = self.size.max(1.0 + x1.abs());
        let limit = self.limit + self.of_pieces * self.size;
        stays_within(w, -limit, limit)
    }
}
