//! Forces of elements in states of contacts, and the resulting accelerations (docs/assembly-law.md
//! (A5)).

use super::{Elongation, System};
use crate::functional::{Functional, StateRow};
use crate::mode::{Contact, FrictionState, SliderState, StopState};
use nalgebra::{DMatrix, DVector};

impl System {
    /// The elongation of a contact.
    pub fn elongation_of(&self, contact: Contact) -> &Elongation {
        match contact {
            Contact::Stop(i) => &self.stops[i].elongation,
            Contact::Friction(i) => &self.frictions[i].elongation,
            Contact::Slider(i) => &self.branches[i].elongation,
        }
    }

    /// The force of a compliant stop; `None` in a state without a force.
    pub fn stop_force(&self, i: usize, state: StopState) -> Option<Functional> {
        state.force(&self.stops[i].force, &self.stops[i].spring)
    }

    /// The force of a friction in a state that determines it, slipping or held at its level, while
    /// the stops are in these states.
    pub fn friction_force(&self, i: usize, state: FrictionState, stops: &[StopState]) -> Option<Functional> {
        let own = self.frictions[i].at(stops)?;
        state.force(&own.level, &own.static_level)
    }

    /// The value of [`stop_force`](Self::stop_force).
    pub fn stop_force_at(&self, i: usize, state: StopState, z: &DVector<f64>) -> Option<f64> {
        let z = z.as_slice();
        match state {
            StopState::Pressed => Some(self.stops[i].force.at(z)),
            StopState::Capped => Some(2.0 * self.stops[i].spring.at(z)),
            StopState::Rebounding => Some(self.stops[i].spring.at(z)),
            _ => None,
        }
    }

    /// The value of [`friction_force`](Self::friction_force).
    pub fn friction_force_at(
        &self,
        i: usize,
        state: FrictionState,
        stops: &[StopState],
        z: &DVector<f64>,
    ) -> Option<f64> {
        let friction = self.frictions[i].at(stops)?;
        match state {
            FrictionState::Up => Some(friction.level.dot(z)),
            FrictionState::Down => Some(-friction.level.dot(z)),
            FrictionState::HeldUp => Some(friction.static_level.dot(z)),
            FrictionState::HeldDown => Some(-friction.static_level.dot(z)),
            FrictionState::Off | FrictionState::Stuck => None,
        }
    }

    /// Rows of the accelerations without contact forces, in given states of stops, frictions and
    /// sliders.
    pub fn free_acceleration(
        &self,
        stops: &[StopState],
        frictions: &[FrictionState],
        sliders: &[SliderState],
    ) -> DMatrix<f64> {
        self.accelerations(&self.forces, stops, (frictions, stops), sliders)
    }

    /// Returns M⁻¹ times the sum of the forces `always` and the forces of stops, frictions and
    /// sliders that the given states determine. Frictions may follow stops in states `followed`.
    pub(crate) fn accelerations(
        &self,
        always: &DMatrix<f64>,
        stops: &[StopState],
        (frictions, followed): (&[FrictionState], &[StopState]),
        sliders: &[SliderState],
    ) -> DMatrix<f64> {
        let mut forces = always.clone();
        for (i, &state) in stops.iter().enumerate() {
            if let Some(force) = self.stop_force(i, state) {
                add_outer(&mut forces, &self.stops[i].elongation.w, &force);
            }
        }
        for (i, &state) in frictions.iter().enumerate() {
            if let Some(force) = self.friction_force(i, state, followed) {
                add_outer(&mut forces, &self.frictions[i].elongation.w, &force);
            }
        }
        for i in self.sliders() {
            if let Some(&state) = sliders.get(i) {
                add_outer(&mut forces, &self.branches[i].elongation.w, &self.branch_force(i, state));
            }
        }
        // Forces are summed before they are divided, so that forces that cancel leave exact zeros.
        if self.is_diagonal {
            for (mut row, inertia) in forces.row_iter_mut().zip(self.mass.diagonal().iter()) {
                row /= *inertia;
            }
            return forces;
        }
        self.inertia.solve(&forces)
    }
}

/// Subtracts a force in direction w from the forces on the coordinates.
fn add_outer(forces: &mut DMatrix<f64>, w: &DVector<f64>, force: &StateRow) {
    for (j, &f) in force.iter().enumerate().filter(|(_, f)| **f != 0.0) {
        forces.column_mut(j).axpy(-f, w, 1.0);
    }
}
