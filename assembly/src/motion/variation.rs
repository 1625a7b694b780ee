//! What a motion's values vary by: with time, with states, with inputs. Between events every
//! coordinate, elongation and force is linear in the augmented state, so that its variation is its
//! value at the state's variation.

use super::Motion;
use nalgebra::DVector;

impl Motion {
    /// A motion of which coordinates, elongations and forces are the time derivatives of this
    /// one's, of some order, within its mode. Only these can be read of it.
    pub fn time_derivative(&self, order: usize) -> Self {
        let mut z = self.hybrid.z.clone();
        for _ in 0..order {
            z = self.table().a.rows_times(0..z.len(), z.as_slice());
        }
        self.with_state(z)
    }

    /// A motion of which coordinates, elongations and forces are the derivatives of this one's
    /// along a direction of states (coordinates, then rates) and inputs, within its mode. Only
    /// these can be read of it.
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
