//! Functionals that end a mode: each is negative inside the mode, with an event at which it passes
//! zero.

use super::{Contact, ElementState};
use crate::kernel::{Sparse, SparseMatrix};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

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
    /// e of a compliant stop falls to the gap, where its force need not vanish.
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
    /// The contact to which the functional belongs.
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

    /// Whether the functional belongs to an element.
    pub fn is_of(self, element: ElementState) -> bool {
        self.contact() == element.contact()
    }
}

/// A watched functional of a mode.
#[derive(Clone, Debug)]
pub struct WatchTable {
    /// Event at which the functional passes zero.
    pub watch: Watch,
    /// The functional.
    pub row: Arc<Sparse>,
    /// Time derivative of the functional.
    pub slope: Sparse,
}

impl WatchTable {
    /// The table of a functional in a mode with matrix A.
    pub(crate) fn new(watch: Watch, row: Arc<Sparse>, a: &SparseMatrix) -> Self {
        Self { watch, slope: a.after_terms(row.terms()), row }
    }

    /// The same functional in a mode with another A.
    pub(crate) fn in_mode(&self, a: &SparseMatrix) -> Self {
        Self { watch: self.watch, slope: a.after_terms(self.row.terms()), row: self.row.clone() }
    }
}
