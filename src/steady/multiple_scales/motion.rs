//! Time histories of a fixed point (paper, sections 3.1 and 4; docs/theory.md (32) and (33)).

use super::super::SteadyMotion;
use super::{FixedPoint, sawtooth, sawtooth_slope};

impl FixedPoint {
    /// U, W, X1, X2, X3 and their derivatives at the phase η (rad), with η = 0 where U rises
    /// through zero.
    pub fn motion(&self, eta: f64) -> SteadyMotion {
        let (sin, cos) = eta.sin_cos();
        let since_impact = eta - self.impact_phase;
        let block = (self.c * sawtooth(since_impact), self.c * sawtooth_slope(since_impact));
        let (sin3, cos3) = (eta + self.psi - self.psi3).sin_cos();
        let secondary = (self.a3 * sin3, self.a3 * cos3);
        SteadyMotion::new(self.epsilon, (self.b * sin, self.b * cos), block, secondary)
    }

    /// Motion at the phase Ω1 τ of the drive (rad), where the force is f̂10 sin(Ω1 τ).
    pub fn motion_at_drive(&self, drive_phase: f64) -> SteadyMotion {
        self.motion(drive_phase - self.psi)
    }
}
