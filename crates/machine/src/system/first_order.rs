//! States of first order, which follow the rates in the augmented state and precede the signals. A
//! row gives the rate of each: y' = row · z. The stretches y = e - x of springs in series are such
//! states (docs/assembly-law.md, section 15).
//!
//! The augmented state has y and not the inner place x: stiffness · (e - x) would have the
//! rounding of e, which may exceed a small force of a stiff spring. States that users give or read
//! have x ([`System::take_given`], [`System::given`]).

use super::{Elongation, FirstOrder, Part, StopRows, System};
use crate::description::{Arms, Description, Series, SeriesLaw, Spring};
use crate::functional::Functional;
use crate::kernel::SparseMatrix;
use crate::mode::{SliderState, StopState};
use std::ops::Range;

/// Rows of a spring in series with a dashpot or slider.
#[derive(Clone, Debug)]
pub struct BranchRows {
    /// Elongation e of both together.
    pub elongation: Elongation,
    /// Stiffness, N/m or N m/rad; positive.
    pub stiffness: f64,
    /// The dashpot or slider.
    pub law: SeriesLaw,
    /// Index of the stretch y = e - x in the augmented state.
    pub place: usize,
    /// Spring force b = stiffness · y, which a slipping slider limits ([`System::branch_force`]).
    pub force: Functional,
    /// The inner place x = e - y.
    pub inner: Functional,
}

impl BranchRows {
    /// Whether a slider is in series with the spring.
    pub(crate) fn is_slider(&self) -> bool {
        matches!(self.law, SeriesLaw::Slider { .. })
    }

    /// The stretch at which the force is at the slider's level `slip`.
    fn stretch_at(&self, slip: f64) -> f64 {
        slip / self.stiffness
    }
}

/// The springs in series with a dashpot or slider, in the order of their states.
pub(crate) fn in_series(d: &Description) -> impl Iterator<Item = (&Spring, Series)> + Clone {
    d.springs.iter().filter_map(|spring| Some((spring, spring.series?)))
}

/// The number of states of first order of a machine.
pub(super) fn count(d: &Description) -> usize {
    in_series(d).count() + super::blocks::count(d)
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

    /// The branch of an element, by the index of the element.
    pub fn branch_of(&self, element: usize) -> Option<usize> {
        self.parts[element].iter().find_map(|part| if let Part::Branch(i) = *part { Some(i) } else { None })
    }

    /// The elongation of each branch in an augmented state.
    pub(crate) fn elongations_in_series(&self, z: &[f64]) -> Vec<f64> {
        self.branches.iter().map(|branch| branch.elongation.e.at(z)).collect()
    }

    /// Replaces the inner places of springs in series by their stretches in an augmented state.
    pub fn take_given(&self, z: &mut [f64]) {
        for branch in &self.branches {
            z[branch.place] = branch.elongation.e.at(z) - z[branch.place];
        }
    }

    /// The states that users read: coordinates, rates, then the inner places of springs in series
    /// and the states of blocks.
    pub fn given(&self, z: &[f64]) -> Vec<f64> {
        let mut states = z[..self.states()].to_vec();
        self.branches.iter().for_each(|branch| states[branch.place] = branch.inner.at(z));
        states
    }

    /// Adds a spring in series with a dashpot or slider.
    pub(super) fn add_branch(&mut self, arms: &Arms, stiffness: f64, law: SeriesLaw) -> Part {
        let (elongation, place) = (self.elongation(arms), 2 * self.coordinates + self.first_order.len());
        let stretch = |factor: f64| Functional::unit(elongation.e.len(), place, factor);
        let (force, inner) = (stretch(stiffness), &elongation.e - &stretch(1.0));
        let (rate, slider) = match law {
            SeriesLaw::Dashpot { damping } => (&elongation.rate - &stretch(stiffness / damping), None),
            SeriesLaw::Slider { .. } => (elongation.rate.clone(), Some(self.branches.len())),
        };
        self.first_order.push(FirstOrder { rate, slider });
        self.branches.push(BranchRows { elongation, stiffness, law, place, force, inner });
        Part::Branch(self.branches.len() - 1)
    }

    /// The row of the rate of state of first order `k` while the branches are in given states;
    /// `None` if the state does not change.
    pub(crate) fn rate_of_first_order(&self, k: usize, sliders: &[SliderState]) -> Option<&Functional> {
        let own = &self.first_order[k];
        let moves =
            own.slider.is_none_or(|i| sliders.get(i).is_some_and(|state| *state == SliderState::Held));
        moves.then_some(&own.rate)
    }

    /// Adds the rows of the states of first order to A.
    pub(crate) fn push_first_order(
        &self,
        a: &mut SparseMatrix,
        sliders: &[SliderState],
        stops: &[StopState],
    ) {
        let limits: Vec<&StopRows> = self.passed_limits(stops).map(|own| own.0).collect();
        for k in 0..self.first_order.len() {
            let rate = self.rate_of_first_order(k, sliders);
            let place = 2 * self.coordinates + k;
            let taken = limits.iter().flat_map(|stop| stop.further.iter().map(move |own| (stop, own)));
            let taken: Vec<_> = taken.filter(|(_, own)| own.0 == place).collect();
            if let (Some(rate), false) = (rate, taken.is_empty()) {
                let mut row = (**rate).clone();
                taken.iter().for_each(|(stop, own)| row.axpy(-own.1, &stop.excess, 1.0));
                a.push_row(row.iter().copied().enumerate());
                continue;
            }
            a.push_row(rate.map_or(&[][..], Functional::terms).iter().copied());
        }
    }

    /// The force of a branch in a state of its slider. While the slider slips it is the level,
    /// whatever the stretch.
    pub fn branch_force(&self, i: usize, state: SliderState) -> Functional {
        match self.slip_level(i) {
            Some(level) if state != SliderState::Held => state.direction() * &level,
            _ => self.branches[i].force.clone(),
        }
    }

    /// The value of [`branch_force`](Self::branch_force).
    pub fn branch_force_at(&self, i: usize, state: SliderState, z: &[f64]) -> f64 {
        let branch = &self.branches[i];
        match branch.law {
            SeriesLaw::Slider { slip } if state != SliderState::Held => {
                state.direction() * slip * z[self.signals.one]
            }
            _ => branch.force.at(z),
        }
    }

    /// All branches with their sliders held.
    pub fn held_sliders(&self) -> Vec<SliderState> {
        vec![SliderState::Held; self.branches.len()]
    }

    /// The level of a branch with a slider, as a row.
    pub(crate) fn slip_level(&self, i: usize) -> Option<Functional> {
        match self.branches[i].law {
            SeriesLaw::Slider { slip } => Some(self.constant(slip)),
            SeriesLaw::Dashpot { .. } => None,
        }
    }

    /// The branches with sliders, by index.
    pub(crate) fn sliders(&self) -> impl Iterator<Item = usize> {
        (0..self.branches.len()).filter(|&i| self.branches[i].is_slider())
    }

    /// Sets the stretch of each branch whose slider slips so that its force is at its level.
    pub(crate) fn keep_levels(&self, sliders: &[SliderState], z: &mut [f64]) {
        for (i, state) in sliders.iter().enumerate().filter(|(_, state)| **state != SliderState::Held) {
            self.keep_level(i, state.direction(), z);
        }
    }

    /// Sets the force of a branch to its level if an event has moved the branch's slider.
    pub(crate) fn keep_moved(&self, [before, after]: [&[f64]; 2], variation: &mut [f64]) {
        for i in 0..self.branches.len() {
            if let Some(direction) = self.was_moved(i, before, after) {
                self.keep_level(i, direction, variation);
            }
        }
    }

    /// The direction of a branch's force if an event has moved its slider: after a jump the force
    /// is at its level.
    pub(crate) fn was_moved(&self, i: usize, before: &[f64], after: &[f64]) -> Option<f64> {
        let branch = &self.branches[i];
        let SeriesLaw::Slider { slip } = branch.law else { return None };
        let [was, is] = [before[branch.place], after[branch.place]];
        (was != is && is.abs() == branch.stretch_at(slip)).then(|| is.signum())
    }

    fn keep_level(&self, i: usize, direction: f64, z: &mut [f64]) {
        let branch = &self.branches[i];
        if let SeriesLaw::Slider { slip } = branch.law {
            z[branch.place] = direction * branch.stretch_at(slip) * z[self.signals.one];
        }
    }

    /// Reduces the stretch of each branch whose force exceeds its level until the force is at its
    /// level. Returns the distances that inner places move.
    pub(crate) fn clamp_sliders(&self, z: &mut [f64]) -> Vec<f64> {
        let way = |branch: &BranchRows, z: &mut [f64]| {
            let SeriesLaw::Slider { slip } = branch.law else { return 0.0 };
            let (stretch, most) = (z[branch.place], branch.stretch_at(slip));
            if stretch.abs() <= most {
                return 0.0;
            }
            z[branch.place] = most.copysign(stretch);
            stretch - most.copysign(stretch)
        };
        self.branches.iter().map(|branch| way(branch, z)).collect()
    }
}
