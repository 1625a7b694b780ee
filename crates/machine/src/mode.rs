//! Modes: the states of all stops, frictions and sliders. A mode determines the linear system z' =
//! A z and the functionals that end it (docs/assembly-law.md (A5)). States are plain data; the
//! rows for each state are in [`System`](crate::system::System).

mod states;
mod watch;

pub use states::{FrictionState, SliderState, StopState};
pub use watch::{Watch, WatchTable};

use serde::{Deserialize, Serialize};
use std::hash::{Hash, Hasher};

/// A contact that keeps e'' at zero, or a slider, which has similar states but keeps nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Contact {
    /// A rigid stop, by its index.
    Stop(usize),
    /// A friction, by its index.
    Friction(usize),
    /// The slider of a branch, by the branch's index; never in a basis.
    Slider(usize),
}

/// A mode: the state of every element, and the independent contacts with unknown forces.
///
///
/// A body that is pressed onto a stop:
///
/// ```
/// use vibro_machine::mode::{Contact, StopState};
/// use vibro_machine::{Assembly, Motion, file};
///
/// # let text = r#"
/// #     name = "Pressed"
/// #     body.a = { mass = 1.0, start = { s = 0.1 } }
/// #     load.push = { on = "a", constant = 5.0 }
/// #     stop.wall = { between = ["ground", "a"], gap = 0.1, restitution = 0.5 }
/// #     stop.back = { between = ["a", "ground"], gap = 0.1, restitution = 0.5 }
/// # "#;
/// let machine = file::parse(text, "pressed.toml", &file::no_records)?;
/// let motion = Motion::new(Assembly::new(machine)?.into())?;
/// assert_eq!(motion.mode().stops, [StopState::Closed, StopState::Open]);
/// assert_eq!(motion.mode().basis, [Contact::Stop(0)]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mode {
    /// State of each stop.
    pub stops: Vec<StopState>,
    /// State of each friction.
    pub frictions: Vec<FrictionState>,
    /// State of each branch.
    pub sliders: Vec<SliderState>,
    /// Independent closed stops and sticking frictions, in order. A dependent contact has zero
    /// force or, depending on its state, the force of its level.
    pub basis: Vec<Contact>,
}

/// Hashes the states as one number: the derived hash takes eight bytes for each state.
impl Hash for Mode {
    fn hash<H: Hasher>(&self, hasher: &mut H) {
        let states = self.stops.iter().map(|state| *state as u64);
        let all = states.chain(self.frictions.iter().map(|state| *state as u64));
        let all = all.chain(self.sliders.iter().map(|state| *state as u64));
        hasher.write_u64(all.fold(0, |sum, state| (sum ^ state).rotate_left(5).wrapping_mul(MIXER)));
    }
}

/// Odd multiplier with well-mixed bits (from the golden ratio).
const MIXER: u64 = 0x9e37_79b9_7f4a_7c15;

/// An element with a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ElementState {
    /// A stop, by its index.
    Stop(usize, StopState),
    /// A friction, by its index.
    Friction(usize, FrictionState),
    /// A branch, by its index.
    Slider(usize, SliderState),
}

impl Mode {
    /// The present state of an element; the state in `element` is ignored.
    pub fn state_of(&self, element: ElementState) -> ElementState {
        match element {
            ElementState::Stop(i, _) => ElementState::Stop(i, self.stops[i]),
            ElementState::Friction(i, _) => ElementState::Friction(i, self.frictions[i]),
            ElementState::Slider(i, _) => ElementState::Slider(i, self.sliders[i]),
        }
    }

    /// Copies another mode of the same machine without allocating.
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

    /// Whether all contacts of the mode are independent.
    pub fn is_independent(&self) -> bool {
        self.contacts().eq(self.basis.iter().copied())
    }
}

impl ElementState {
    /// The contact that has this state.
    pub fn contact(self) -> Contact {
        match self {
            Self::Stop(i, _) => Contact::Stop(i),
            Self::Friction(i, _) => Contact::Friction(i),
            Self::Slider(i, _) => Contact::Slider(i),
        }
    }
}
