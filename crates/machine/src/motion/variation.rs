//! Derivatives of a motion's values within its mode, by time, states and inputs. Between events
//! every coordinate, elongation and force is linear in the augmented state. Its derivative is
//! therefore its value at the state's derivative.

use super::Motion;
use nalgebra::DVector;

impl Motion {
    /// Returns a motion whose coordinates, elongations and forces are this motion's time
    /// derivatives of some order, within its mode. Only these values are meaningful.
    pub fn time_derivative(&self, order: usize) -> Self {
        let mut z = self.hybrid.z.clone();
        if self.table().is_curved() {
            self.table().derivative(order, z.as_mut_slice());
            return self.with_state(z);
        }
        for _ in 0..order {
            z = self.table().a.rows_times(0..z.len(), z.as_slice());
        }
        self.with_state(z)
    }

    /// Returns a motion whose coordinates, elongations and forces are this motion's derivatives,
    /// within its mode, along a direction of inputs and given states (coordinates, rates, inner
    /// places, states of blocks). Only these values are meaningful.
    pub fn variation(&self, states: &[f64], inputs: &[f64]) -> Self {
        let signals = &self.assembly.system.signals;
        let mut z: DVector<f64> = DVector::zeros(signals.size);
        z.iter_mut().zip(states.iter().take(signals.one)).for_each(|(z, state)| *z = *state);
        for (i, value) in inputs.iter().enumerate() {
            if let Some(place) = signals.place_of_input(i) {
                z[place] += value;
            }
        }
        self.assembly.system.take_given(z.as_mut_slice());
        self.assembly.system.vary_curved(self.hybrid.z.as_slice(), z.as_mut_slice());
        self.with_state(z)
    }

    fn with_state(&self, z: DVector<f64>) -> Self {
        let mut other = self.clone();
        other.hybrid.z = z;
        other.hybrid.standing.clear();
        other
    }
}
