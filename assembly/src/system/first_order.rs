//! States of first order, which stand in the augmented state between the rates and the signals:
//! each has a row that gives its rate, x' = row · z. Inner places of springs in series are such
//! states (docs/assembly-law.md, section 15).

use super::{Elongation, Functional, Part, StateRow, System};
use crate::description::{Arms, Description, Series, SeriesLaw, Spring};
use crate::kernel::SparseMatrix;
use std::ops::Range;

/// A state of first order.
#[derive(Clone, Debug)]
pub struct FirstOrder {
    /// x'.
    pub rate: Functional,
}

/// Rows of a spring in series with a partner.
#[derive(Clone, Debug)]
pub struct BranchRows {
    /// Elongation e of both together.
    pub elongation: Elongation,
    /// N/m or N m/rad, positive.
    pub stiffness: f64,
    /// The partner.
    pub law: SeriesLaw,
    /// Index of the inner place x in the augmented state.
    pub place: usize,
    /// b = stiffness · (e - x).
    pub force: Functional,
}

impl BranchRows {
    /// e - x.
    pub(crate) fn stretch(&self) -> StateRow {
        let mut row = self.elongation.e.clone();
        row[self.place] -= 1.0;
        row
    }
}

/// The springs with a partner, in the order of their states.
pub(crate) fn in_series(d: &Description) -> impl Iterator<Item = (&Spring, Series)> + Clone {
    d.springs.iter().filter_map(|spring| Some((spring, spring.series?)))
}

/// The number of states of first order of a machine.
pub(super) fn count(d: &Description) -> usize {
    in_series(d).count()
}

impl System {
    /// Number of states: coordinates, their rates, states of first order. They come first in the
    /// augmented state, before the signals.
    pub fn states(&self) -> usize {
        self.signals.one
    }

    /// The places of the states of first order in the augmented state.
    pub fn places_of_first_order(&self) -> Range<usize> {
        2 * self.coordinates..self.signals.one
    }

    /// The place of the inner place of an element, by the index of the element.
    pub fn slider_of(&self, element: usize) -> Option<usize> {
        self.parts[element].iter().find_map(|part| match *part {
            Part::Branch(i) => Some(self.branches[i].place),
            _ => None,
        })
    }

    /// Adds a spring with its partner.
    pub(super) fn add_branch(&mut self, arms: &Arms, stiffness: f64, law: SeriesLaw) -> Part {
        let (elongation, place) = (self.elongation(arms), 2 * self.coordinates + self.first_order.len());
        let mut branch =
            BranchRows { elongation, stiffness, law, place, force: Functional::of(StateRow::zeros(0)) };
        branch.force = Functional::of(stiffness * branch.stretch());
        let rate = match law {
            SeriesLaw::Dashpot { damping } => (1.0 / damping) * &*branch.force,
        };
        self.first_order.push(FirstOrder { rate: Functional::of(rate) });
        self.branches.push(branch);
        Part::Branch(self.branches.len() - 1)
    }

    /// Adds the rows of the states of first order to A.
    pub(crate) fn push_first_order(&self, a: &mut SparseMatrix) {
        self.first_order.iter().for_each(|own| a.push_row(own.rate.terms().iter().copied()));
    }
}
