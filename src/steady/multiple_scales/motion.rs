//! Time histories of a fixed point (paper (13)–(17), (38), figure 8).

use super::super::Motion;
use super::{FixedPoint, sawtooth, sawtooth_slope};

impl FixedPoint {
    /// U, W, X1, X2, X3 and their derivatives at the phase η (rad), with η = 0 where U rises through zero.
    pub fn motion(&self, eta: f64) -> Motion {
        let e = self.epsilon;
        let (sin, cos) = eta.sin_cos();
        let s = eta - self.impact_phase;
        let (z, dz) = (self.c * sawtooth(s), self.c * sawtooth_slope(s));
        let (sin3, cos3) = (eta + self.psi - self.psi3).sin_cos();
        let (one, less) = (1.0 - e + e * e, e - e * e);
        let (u, du) = (self.b * sin, self.b * cos);
        Motion {
            u,
            w: z - u,
            x: [u - less * z, one * z, self.a3 * sin3],
            du,
            dw: dz - du,
            dx: [du - less * dz, one * dz, self.a3 * cos3],
        }
    }

    /// The same at the phase Ω1 τ of the drive (rad): the force is f̂10 sin(Ω1 τ).
    pub fn motion_at_drive(&self, drive_phase: f64) -> Motion {
        self.motion(drive_phase - self.psi)
    }
}
