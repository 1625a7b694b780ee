//! Derivatives of a motion's values by time, states and inputs, within a mode. Coordinates,
//! elongations and forces are linear in the augmented state, so that the derivative of each is its
//! value at the derivative of the state.

use super::Motion;
use nalgebra::DVector;

impl Motion {
    /// A motion whose coordinates, elongations and forces are the time derivatives of order `order`
    /// of this one's, within its mode. Nothing else of it is meaningful.
    pub fn time_derivative(&self, order: usize) -> Self {
        let mut z = self.hybrid.z.clone();
        for _ in 0..order {
            z = self.table().a.rows_times(0..z.len(), z.as_slice());
        }
        self.with_state(z)
    }

    /// A motion whose coordinates, elongations and forces are the derivatives of this one's along a
    /// direction of states (coordinates, then rates) and inputs, within its mode. Nothing else of
    /// it is meaningful.
    pub fn variation(&self, states: &[f64], inputs: &[f64]) -> Self {
        let signals = &self.assembly.system.signals;
        let mut z: DVector<f64> = DVector::zeros(signals.size);
        z.iter_mut().zip(states.iter().take(signals.one)).for_each(|(z, state)| *z = *state);
        for (i, value) in inputs.iter().enumerate() {
            if let Some(place) = signals.place_of_input(i) {
                z[place] += value;
            }
        }
        self.with_state(z)
    }

    fn with_state(&self, z: DVector<f64>) -> Self {
        let mut other = self.clone();
        other.hybrid.z = z;
        other
    }
}
