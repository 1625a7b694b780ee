//! Variation of the outputs with states, inputs, parameters and time.

use super::Continuous;
use crate::component::values::OutputValues;
use crate::component::variation::{Direction, quadrature, variation, velocities};
use vibro_impact::model::{COORDINATES, DRIVE_COS, DRIVE_SIN};

impl Continuous {
    /// Variation of the outputs along a direction; everything else is constant.
    pub(crate) fn variation(&self, along: &Direction) -> OutputValues {
        let (p, z) = (&self.data.parameters, self.augmented());
        let drive = (z[DRIVE_SIN], z[DRIVE_COS]);
        let mut rates = variation(&self.model, p, self.data.contact, &self.data.state, drive, along);
        // The energy of the open interval varies with its end, and with the slope of the forces at
        // both ends.
        let (from, now) = (self.data.accepted, self.now());
        let h = now.time - from.time;
        if h != 0.0 {
            let df = along.forces;
            let slope = std::array::from_fn(|i| (now.forces[i] - from.forces[i]) / h);
            let (a, b) = (self.velocities(&from, slope), self.velocities(&now, slope));
            let (mode, turn) = (self.mode(), df.map(|df| df / h));
            let mut z = [0.0; COORDINATES];
            let da = velocities(&self.model, mode, &z, [0.0; 3], turn);
            z[..6].copy_from_slice(&along.state.to_relative());
            let db = velocities(&self.model, mode, &z, df, turn);
            rates.damped = 2.0 * quadrature(h, &self.power(&a, &da), &self.power(&b, &db));
            if along.time != 0.0 {
                rates.damped += along.time * self.damped_with_time(h);
            }
        } else {
            let v = self.velocities(&now, [0.0; 3]);
            rates.damped = along.time * self.power(&v, &v)[0];
        }
        if self.values().contact_force == 0.0 {
            rates.contact_force = 0.0; // at a release that the host has not handled yet it is held at 0
        }
        rates.input = rates.mechanical + rates.damped;
        rates
    }

    /// Derivative of the damped energy with respect to the end time of the open interval, at
    /// constant state at the end: a fourth-order difference of the quadrature.
    fn damped_with_time(&self, h: f64) -> f64 {
        const PART: f64 = 1e-3; // of the interval
        let at = |places: f64| {
            let mut there = self.clone();
            there.data.time += places * PART * h;
            there.damped()
        };
        (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * PART * h)
    }
}
