//! A mode: which stops are closed or pressed, which friction slips or sticks; and its linear system
//! z' = A z with the functionals that end it (docs/assembly-law.md (A5)).

mod linear;
pub mod states;

pub use linear::{Elastic, Linear};
pub use states::{FrictionState, StopState};

use crate::law::box_qp::independent;
use crate::system::{Elongation, StateRow, System};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// A contact that keeps e'' at zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Contact {
    /// A rigid stop, by its place.
    Stop(usize),
    /// A friction, by its place.
    Friction(usize),
}

/// The state of every element, and the independent contacts whose forces are found.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Mode {
    /// By stop.
    pub stops: Vec<StopState>,
    /// By friction.
    pub frictions: Vec<FrictionState>,
    /// Closed stops and sticking frictions that are independent of one another; the forces of the
    /// others are set to zero.
    pub basis: Vec<Contact>,
}

/// An element in a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ElementState {
    /// A stop, by its place.
    Stop(usize, StopState),
    /// A friction, by its place.
    Friction(usize, FrictionState),
}

impl Mode {
    /// The state of the same element.
    pub fn state_of(&self, element: ElementState) -> ElementState {
        match element {
            ElementState::Stop(i, _) => ElementState::Stop(i, self.stops[i]),
            ElementState::Friction(i, _) => ElementState::Friction(i, self.frictions[i]),
        }
    }

    /// Becomes another mode of the same machine, in its own memory.
    pub(crate) fn assign(&mut self, other: &Self) {
        self.stops.clone_from(&other.stops);
        self.frictions.clone_from(&other.frictions);
        self.basis.clone_from(&other.basis);
    }

    /// All closed stops and sticking frictions.
    pub fn contacts(&self) -> impl Iterator<Item = Contact> {
        let closed = self.stops.iter().enumerate().filter(|(_, state)| **state == StopState::Closed);
        let sticking = self.frictions.iter().enumerate().filter(|(_, state)| state.sticks());
        closed.map(|(i, _)| Contact::Stop(i)).chain(sticking.map(|(i, _)| Contact::Friction(i)))
    }

    /// Whether its contacts are independent of one another.
    pub fn is_independent(&self) -> bool {
        self.contacts().eq(self.basis.iter().copied())
    }
}

/// What a watched functional tells when it passes from below zero to above.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Watch {
    /// A rigid stop meets its gap.
    Meets(usize),
    /// A closed stop's force falls to zero.
    Opens(usize),
    /// A compliant stop comes to its gap from below.
    Presses(usize),
    /// A compliant stop's force falls to zero or rises from it, or meets its cap.
    Changes(usize),
    /// A compliant stop without its linear force is left: e falls to the gap.
    Leaves(usize),
    /// A slipping friction's rate comes to zero.
    Stops(usize),
    /// A sticking friction's force reaches its level, upwards (true) or downwards.
    Slips(usize, bool),
    /// A friction's level passes zero.
    Level(usize),
}

impl Watch {
    /// Whether it is a functional of an element.
    pub fn is_of(self, element: ElementState) -> bool {
        match self {
            Self::Meets(i) | Self::Opens(i) | Self::Presses(i) | Self::Changes(i) | Self::Leaves(i) => {
                matches!(element, ElementState::Stop(own, _) if own == i)
            }
            Self::Stops(i) | Self::Slips(i, _) | Self::Level(i) => {
                matches!(element, ElementState::Friction(own, _) if own == i)
            }
        }
    }
}

impl System {
    /// The elongation of a contact.
    pub fn elongation_of(&self, contact: Contact) -> &Elongation {
        match contact {
            Contact::Stop(i) => &self.stops[i].elongation,
            Contact::Friction(i) => &self.frictions[i].elongation,
        }
    }

    /// The force of a stop in a state in which the state determines it: compliant ones.
    pub fn stop_force(&self, i: usize, state: StopState) -> Option<StateRow> {
        match state {
            StopState::Pressed => Some((*self.stops[i].force).clone()),
            StopState::Capped => Some(2.0 * &*self.stops[i].spring),
            _ => None,
        }
    }

    /// The force of a friction in a state in which the state determines it: slipping, or at its
    /// level while it sticks.
    pub fn friction_force(&self, i: usize, state: FrictionState) -> Option<StateRow> {
        let friction = &self.frictions[i];
        match state {
            FrictionState::Up => Some(friction.level.clone()),
            FrictionState::Down => Some(-&friction.level),
            FrictionState::HeldUp => Some(friction.static_level.clone()),
            FrictionState::HeldDown => Some(-&friction.static_level),
            FrictionState::Off | FrictionState::Stuck => None,
        }
    }

    /// The value of [`stop_force`](Self::stop_force).
    pub fn stop_force_at(&self, i: usize, state: StopState, z: &DVector<f64>) -> Option<f64> {
        let z = z.as_slice();
        match state {
            StopState::Pressed => Some(self.stops[i].force.at(z)),
            StopState::Capped => Some(2.0 * self.stops[i].spring.at(z)),
            _ => None,
        }
    }

    /// The value of [`friction_force`](Self::friction_force).
    pub fn friction_force_at(&self, i: usize, state: FrictionState, z: &DVector<f64>) -> Option<f64> {
        let friction = &self.frictions[i];
        match state {
            FrictionState::Up => Some(friction.level.dot(z)),
            FrictionState::Down => Some(-friction.level.dot(z)),
            FrictionState::HeldUp => Some(friction.static_level.dot(z)),
            FrictionState::HeldDown => Some(-friction.static_level.dot(z)),
            FrictionState::Off | FrictionState::Stuck => None,
        }
    }

    /// M⁻¹ times the forces that the state determines in given states: accelerations without
    /// contact forces.
    pub fn free_acceleration(&self, stops: &[StopState], frictions: &[FrictionState]) -> DMatrix<f64> {
        self.accelerations(&self.forces, stops, frictions)
    }

    /// M⁻¹ times some forces that always act and those that the state determines in given states.
    fn accelerations(
        &self,
        always: &DMatrix<f64>,
        stops: &[StopState],
        frictions: &[FrictionState],
    ) -> DMatrix<f64> {
        let mut forces = always.clone();
        for (i, &state) in stops.iter().enumerate() {
            if let Some(force) = self.stop_force(i, state) {
                add_outer(&mut forces, &self.stops[i].elongation.w, &force);
            }
        }
        for (i, &state) in frictions.iter().enumerate() {
            if let Some(force) = self.friction_force(i, state) {
                add_outer(&mut forces, &self.frictions[i].elongation.w, &force);
            }
        }
        // Forces are summed up before they are divided, so that what cancels leaves zeros.
        if self.is_diagonal {
            for (mut row, inertia) in forces.row_iter_mut().zip(self.mass.diagonal().iter()) {
                row /= *inertia;
            }
            return forces;
        }
        self.inertia.solve(&forces)
    }

    /// L⁻¹ w of several contacts as columns.
    pub fn columns(&self, contacts: &[Contact]) -> DMatrix<f64> {
        let mut columns = DMatrix::zeros(self.coordinates, contacts.len());
        for (k, &contact) in contacts.iter().enumerate() {
            columns.set_column(k, &self.elongation_of(contact).column);
        }
        columns
    }

    /// An independent part of contacts, in their order of preference.
    pub fn independent(&self, contacts: &[Contact]) -> Vec<Contact> {
        let places: Vec<usize> = (0..contacts.len()).collect();
        let mut basis: Vec<Contact> =
            independent(&self.columns(contacts), &places).into_iter().map(|k| contacts[k]).collect();
        basis.sort();
        basis
    }

    /// The mode in which an element has another state.
    pub fn with_element(&self, mode: &Mode, element: ElementState) -> Mode {
        let mut mode = mode.clone();
        match element {
            ElementState::Stop(i, state) => mode.stops[i] = state,
            ElementState::Friction(i, state) => mode.frictions[i] = state,
        }
        mode.basis = self.independent(&mode.contacts().collect::<Vec<_>>());
        mode
    }
}

/// Takes a force in a direction from the forces on the coordinates.
fn add_outer(forces: &mut DMatrix<f64>, w: &DVector<f64>, force: &StateRow) {
    for (i, &w) in w.iter().enumerate().filter(|(_, w)| **w != 0.0) {
        forces.row_mut(i).iter_mut().zip(force.iter()).for_each(|(sum, f)| *sum -= w * f);
    }
}
