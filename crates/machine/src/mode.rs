//! Modes: the states of all stops and frictions, which determine a linear system z' = A z and the
//! functionals that end it (docs/assembly-law.md (A5)).

pub(crate) mod groups;
mod held;
mod linear;
mod slider;
pub mod states;

pub use groups::Triangle;
pub use linear::{Elastic, Linear};
pub use slider::SliderState;
pub use states::{FrictionState, StopState};

use crate::system::{Elongation, Functional, StateRow, System};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::hash::{Hash, Hasher};

/// A contact that keeps e'' at zero, or a slider, which has states as these have and keeps nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Contact {
    /// A rigid stop, by its place.
    Stop(usize),
    /// A friction, by its place.
    Friction(usize),
    /// The slider of a branch, by the branch's place; none is in a basis.
    Slider(usize),
}

/// A mode: the state of every element, and the independent contacts whose forces are solved for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mode {
    /// By stop.
    pub stops: Vec<StopState>,
    /// By friction.
    pub frictions: Vec<FrictionState>,
    /// By branch.
    pub sliders: Vec<SliderState>,
    /// Independent closed stops and sticking frictions, in order. A dependent contact has the force
    /// zero or, where its state says so, its level.
    pub basis: Vec<Contact>,
}

/// By the states in one number: the derived hash takes eight bytes for each.
impl Hash for Mode {
    fn hash<H: Hasher>(&self, hasher: &mut H) {
        let states = self.stops.iter().map(|state| *state as u64);
        let all = states.chain(self.frictions.iter().map(|state| *state as u64));
        let all = all.chain(self.sliders.iter().map(|state| *state as u64));
        hasher.write_u64(all.fold(0, |sum, state| (sum ^ state).rotate_left(5).wrapping_mul(MIXER)));
    }
}

/// An odd number of mixed bits (from the golden ratio).
const MIXER: u64 = 0x9e37_79b9_7f4a_7c15;

/// An element in a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ElementState {
    /// A stop, by its place.
    Stop(usize, StopState),
    /// A friction, by its place.
    Friction(usize, FrictionState),
    /// A branch, by its place.
    Slider(usize, SliderState),
}

impl Mode {
    /// The present state of an element, whatever state is given.
    pub fn state_of(&self, element: ElementState) -> ElementState {
        match element {
            ElementState::Stop(i, _) => ElementState::Stop(i, self.stops[i]),
            ElementState::Friction(i, _) => ElementState::Friction(i, self.frictions[i]),
            ElementState::Slider(i, _) => ElementState::Slider(i, self.sliders[i]),
        }
    }

    /// Becomes another mode of the same machine without allocating.
    pub(crate) fn assign(&mut self, other: &Self) {
        self.stops.clone_from(&other.stops);
        self.frictions.clone_from(&other.frictions);
        self.sliders.clone_from(&other.sliders);
        self.basis.clone_from(&other.basis);
    }

    /// All closed stops and sticking frictions.
    pub fn contacts(&self) -> impl Iterator<Item = Contact> {
        let closed = self.stops.iter().enumerate().filter(|(_, state)| **state == StopState::Closed);
        let sticking = self.frictions.iter().enumerate().filter(|(_, state)| state.sticks());
        closed.map(|(i, _)| Contact::Stop(i)).chain(sticking.map(|(i, _)| Contact::Friction(i)))
    }

    /// Whether all its contacts are independent.
    pub fn is_independent(&self) -> bool {
        self.contacts().eq(self.basis.iter().copied())
    }
}

/// The event at which a watched functional passes zero from below.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Watch {
    /// A rigid stop meets its gap.
    Meets(usize),
    /// The force of a closed stop falls to zero.
    Opens(usize),
    /// A compliant stop meets its gap from below.
    Presses(usize),
    /// The force of a compliant stop falls to zero, rises from it, or meets or leaves its cap.
    Changes(usize),
    /// A compliant stop whose force need not vanish there is left: e falls to the gap.
    Leaves(usize),
    /// The rate of a slipping friction reaches zero.
    Stops(usize),
    /// The force of a sticking friction reaches its level, upwards (true) or downwards.
    Slips(usize, bool),
    /// The level of a friction passes zero.
    Level(usize),
    /// e' of a compliant stop with the law `undamped-rebound` passes zero beyond its gap.
    Turns(usize),
    /// The force of a branch whose slider is held reaches its level, upwards (true) or downwards.
    Yields(usize, bool),
    /// The rate of a branch whose slider slips reaches zero.
    Reverses(usize),
}

impl Watch {
    /// The contact whose functional it is.
    pub fn contact(self) -> Contact {
        match self {
            Self::Meets(i)
            | Self::Opens(i)
            | Self::Presses(i)
            | Self::Changes(i)
            | Self::Leaves(i)
            | Self::Turns(i) => Contact::Stop(i),
            Self::Stops(i) | Self::Slips(i, _) | Self::Level(i) => Contact::Friction(i),
            Self::Yields(i, _) | Self::Reverses(i) => Contact::Slider(i),
        }
    }

    /// Whether its functional belongs to an element.
    pub fn is_of(self, element: ElementState) -> bool {
        self.contact() == element.contact()
    }
}

impl ElementState {
    /// The contact whose state it is.
    pub fn contact(self) -> Contact {
        match self {
            Self::Stop(i, _) => Contact::Stop(i),
            Self::Friction(i, _) => Contact::Friction(i),
            Self::Slider(i, _) => Contact::Slider(i),
        }
    }
}

impl System {
    /// The elongation of a contact.
    pub fn elongation_of(&self, contact: Contact) -> &Elongation {
        match contact {
            Contact::Stop(i) => &self.stops[i].elongation,
            Contact::Friction(i) => &self.frictions[i].elongation,
            Contact::Slider(i) => &self.branches[i].elongation,
        }
    }

    /// The force of a compliant stop in a state in which it is not zero.
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

    /// Accelerations without contact forces, in given states of stops, frictions and sliders, as
    /// rows.
    pub fn free_acceleration(
        &self,
        stops: &[StopState],
        frictions: &[FrictionState],
        sliders: &[SliderState],
    ) -> DMatrix<f64> {
        self.accelerations(&self.forces, stops, (frictions, stops), sliders)
    }

    /// M⁻¹ times the sum of the forces `always` and the forces that the given states determine:
    /// those of stops, of frictions with the states of the stops that they follow, and of sliders.
    fn accelerations(
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
        // Forces are summed before they are divided, so that cancelling ones leave exact zeros.
        if self.is_diagonal {
            for (mut row, inertia) in forces.row_iter_mut().zip(self.mass.diagonal().iter()) {
                row /= *inertia;
            }
            return forces;
        }
        self.inertia.solve(&forces)
    }

    /// L⁻¹ w of contacts, as columns.
    pub fn columns(&self, contacts: &[Contact]) -> DMatrix<f64> {
        let mut columns = DMatrix::zeros(self.coordinates, contacts.len());
        for (k, &contact) in contacts.iter().enumerate() {
            columns.set_column(k, &self.elongation_of(contact).column);
        }
        columns
    }

    /// The mode that differs from `mode` by the state of an element.
    pub fn with_element(&self, mode: &Mode, element: ElementState) -> Mode {
        let mut mode = mode.clone();
        match element {
            ElementState::Stop(i, state) => mode.stops[i] = state,
            ElementState::Friction(i, state) => mode.frictions[i] = state,
            ElementState::Slider(i, state) => mode.sliders[i] = state,
        }
        mode.basis = self.independent(&mode.contacts().collect::<Vec<_>>());
        mode
    }
}

/// Subtracts a force in direction w from the forces on the coordinates.
fn add_outer(forces: &mut DMatrix<f64>, w: &DVector<f64>, force: &StateRow) {
    for (j, &f) in force.iter().enumerate().filter(|(_, f)| **f != 0.0) {
        forces.column_mut(j).axpy(-f, w, 1.0);
    }
}
