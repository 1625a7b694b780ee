//! States of first order, which follow the rates in the augmented state and precede the signals. A
//! row gives the rate of each: y' = row · z. The stretches y = e - x of springs in series are such
//! states (docs/assembly-law.md, section 15).
//!
//! The augmented state has y and not the inner place x: stiffness · (e - x) would have the
//! rounding of e, which may exceed a small force of a stiff spring. States that users give or read
//! have x ([`System::take_given`], [`System::given`]).

use super::{Elongation, FirstOrder, Part, StopRows, System};
use crate::description::{Arms, Description, SeriesLaw, Tangent};
use crate::elements::Element;
use crate::functional::Functional;
use crate::kernel::SparseMatrix;
use crate::mode::{SliderState, StopState};
use std::borrow::Cow;
use std::ops::Range;

/// The law of the dashpot or slider in series with a spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BranchLaw {
    /// A dashpot (Maxwell's element) with this damping, N s/m or N m s/rad.
    Dashpot(f64),
    /// A slider with this slip force, N or N m.
    Slider(f64),
    /// The slider of a contact: its limit is the coefficient of friction times the force of a
    /// stop, by the stop's index.
    Contact {
        /// Index of the stop.
        stop: usize,
        /// Coefficient of friction.
        friction: f64,
    },
}

impl BranchLaw {
    /// Whether this is the slider of a contact.
    pub(crate) fn is_of_contact(self) -> bool {
        matches!(self, Self::Contact { .. })
    }
}

/// A spring in series with a dashpot or slider, as an element gives it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InSeries<'a> {
    /// Section and name of the element.
    pub section: &'static str,
    pub name: &'a str,
    /// End of the names of the inner place, of events and of states: `[0]` or `[1]` for one of the
    /// two tangents of a contact, else empty.
    pub index: &'static str,
    /// The elongation of both together.
    pub arms: &'a Arms,
    /// Stiffness, N/m or N m/rad.
    pub stiffness: f64,
    pub law: BranchLaw,
    /// The inner place at time 0, m or rad.
    pub slider: f64,
}

impl InSeries<'_> {
    /// Name of the inner place: `mount.slider`, or `tip.slider[0]` for one of two tangents.
    pub fn name_of_slider(&self) -> String {
        format!("{}.slider{}", self.name, self.index)
    }

    /// Key among the inner places of a start: `mount`, or `tip[0]` for one of two tangents.
    pub fn key(&self) -> String {
        format!("{}{}", self.name, self.index)
    }
}

/// Rows of a spring in series with a dashpot or slider.
#[derive(Clone, Debug)]
pub struct BranchRows {
    /// Elongation e of both together.
    pub elongation: Elongation,
    /// Stiffness, N/m or N m/rad; positive.
    pub stiffness: f64,
    /// The dashpot or slider.
    pub law: BranchLaw,
    /// Index of the stretch y = e - x in the augmented state.
    pub place: usize,
    /// Spring force b = stiffness · y, which a slipping slider limits ([`System::branch_force`]).
    pub force: Functional,
    /// The elongation, with the displacements of residual flexibility by loads.
    pub whole: Functional,
    /// Rate of the stretch while the slider is at rest: the rate of `whole`.
    pub rate: Functional,
    /// The inner place x = `whole` - y.
    pub inner: Functional,
    /// The slider's limit of the force; `None` for a dashpot.
    pub level: Option<Functional>,
    /// Rate of the stretch while the slider of a contact slips, times the direction of the slip:
    /// friction N' / stiffness.
    pub sliding: Option<Functional>,
    /// On residual flexibility: the stretch and its rate while the slider does not hold.
    pub slaved: Option<[Functional; 2]>,
}

impl BranchRows {
    /// Whether a slider is in series with the spring.
    pub(crate) fn is_slider(&self) -> bool {
        !matches!(self.law, BranchLaw::Dashpot(_))
    }

    /// The slider's limit if it follows a stop's force, as a contact's does; `None` for a constant
    /// limit and for a dashpot.
    pub(crate) fn followed_level(&self) -> Option<&Functional> {
        self.stop().and(self.level.as_ref())
    }

    /// The rate of `whole`.
    pub(crate) fn rate_of_whole(&self) -> &Functional {
        if self.is_slider() { &self.rate } else { &self.elongation.rate }
    }

    /// The stop whose force limits the slider of a contact; `None` for another branch.
    pub fn stop(&self) -> Option<usize> {
        if let BranchLaw::Contact { stop, .. } = self.law { Some(stop) } else { None }
    }

    /// Whether the branch belongs to a contact whose coefficient of friction is zero. Its slider
    /// follows the elongation without a force, also while the contact is pressed.
    pub(crate) fn is_frictionless(&self) -> bool {
        matches!(self.law, BranchLaw::Contact { friction: 0.0, .. })
    }

    /// The largest stretch in an augmented state; `None` for a dashpot.
    pub(crate) fn most(&self, z: &[f64]) -> Option<f64> {
        match self.law {
            BranchLaw::Dashpot(_) => None,
            BranchLaw::Slider(slip) => Some(slip / self.stiffness),
            BranchLaw::Contact { .. } => {
                let level = self.level.as_ref().map_or(0.0, |level| level.at(z));
                Some(level.max(0.0) / self.stiffness)
            }
        }
    }

    /// The rate of the slider while it slips along a direction: σ e' - friction N' / stiffness,
    /// and σ e' if the limit is constant.
    pub(crate) fn slip_rate(&self, direction: f64) -> Functional {
        let rate = direction * &self.rate;
        match &self.sliding {
            Some(sliding) => &rate - sliding,
            None => rate,
        }
    }
}

/// The springs in series with a dashpot or slider, in the order of their states.
pub(crate) fn in_series(d: &Description) -> impl Iterator<Item = InSeries<'_>> + Clone {
    let springs = d.springs.iter().filter_map(|spring| {
        let series = spring.series?;
        let law = match series.law {
            SeriesLaw::Dashpot { damping } => BranchLaw::Dashpot(damping),
            SeriesLaw::Slider { slip } => BranchLaw::Slider(slip),
        };
        let (section, name, arms) = ("spring", spring.name.as_str(), &spring.arms);
        let (index, stiffness, slider) = ("", spring.stiffness, series.slider);
        Some(InSeries { section, name, index, arms, stiffness, law, slider })
    });
    let contacts = d.contacts.iter().enumerate().flat_map(|(i, contact)| {
        let law = BranchLaw::Contact { stop: d.stops.len() + i, friction: contact.friction };
        contact.tangents.iter().enumerate().map(move |(k, own)| {
            let (section, name, index) = ("contact", contact.name.as_str(), contact.index_of(k));
            let Tangent { arms, stiffness, slider } = own;
            InSeries { section, name, index, arms, stiffness: *stiffness, law, slider: *slider }
        })
    });
    springs.chain(contacts)
}

/// The number of states of first order of a machine.
pub(super) fn count(d: &Description) -> usize {
    in_series(d).count() + super::blocks::count(d)
}

impl System {
    /// Number of states: coordinates, their rates, states of first order. The states come first in
    /// the augmented state, before the signals.
    pub fn states(&self) -> usize {
        self.signals.one
    }

    /// The places of the states of first order in the augmented state.
    pub fn places_of_first_order(&self) -> Range<usize> {
        2 * self.coordinates..self.signals.one
    }

    /// The branch of an element, by the index of the element; `which` is the index among two.
    pub fn branch_of(&self, element: usize, which: Option<usize>) -> Option<usize> {
        let own = self.parts[element].iter();
        let mut own = own.filter_map(|part| if let Part::Branch(i) = *part { Some(i) } else { None });
        own.nth(which.unwrap_or_default())
    }

    /// The elongation of each branch in an augmented state.
    pub(crate) fn elongations_in_series(&self, z: &[f64]) -> Vec<f64> {
        self.branches.iter().map(|branch| branch.whole.at(z)).collect()
    }

    /// Replaces the inner places of springs in series by their stretches in an augmented state.
    pub fn take_given(&self, z: &mut [f64]) {
        for branch in &self.branches {
            z[branch.place] = branch.whole.at(z) - z[branch.place];
        }
    }

    /// The states that users read: coordinates, rates, then the inner places of springs in series
    /// and the states of blocks.
    pub fn given(&self, z: &[f64]) -> Vec<f64> {
        let mut states = z[..self.states()].to_vec();
        self.branches.iter().for_each(|branch| states[branch.place] = branch.inner.at(z));
        states
    }

    /// Adds the springs in series with dashpots and sliders, after the stops that limits follow.
    pub(super) fn add_branches(&mut self, d: &Description) {
        let elements: Vec<_> = d.elements().collect();
        for own in in_series(d) {
            let part = self.add_branch(own.arms, own.stiffness, own.law);
            let is_own = |element: &Element| (element.section(), element.name()) == (own.section, own.name);
            if let Some(element) = elements.iter().position(is_own) {
                self.parts[element].push(part);
            }
        }
    }

    /// Adds a spring in series with a dashpot or slider.
    fn add_branch(&mut self, arms: &Arms, stiffness: f64, law: BranchLaw) -> Part {
        let (elongation, place) = (self.elongation(arms), 2 * self.coordinates + self.first_order.len());
        let stretch = |factor: f64| Functional::unit(elongation.e.len(), place, factor);
        let (force, inner) = (stretch(stiffness), &elongation.e - &stretch(1.0));
        let (rate, slider) = match law {
            BranchLaw::Dashpot(damping) => (&elongation.rate - &stretch(stiffness / damping), None),
            _ => (elongation.rate.clone(), Some(self.branches.len())),
        };
        let (level, sliding) = match law {
            BranchLaw::Dashpot(_) => (None, None),
            BranchLaw::Slider(slip) => (Some(self.constant(slip)), None),
            BranchLaw::Contact { stop, friction } => {
                self.stops[stop].is_followed = true;
                let rows = &self.stops[stop];
                let factor = friction * rows.stiffness() / stiffness;
                (Some(friction * &rows.force), Some(factor * &rows.elongation.rate))
            }
        };
        self.first_order.push(FirstOrder { rate, slider });
        let (whole, rate, slaved) = (elongation.e.clone(), elongation.rate.clone(), None);
        self.branches.push(BranchRows {
            elongation,
            stiffness,
            law,
            place,
            force,
            whole,
            rate,
            inner,
            level,
            sliding,
            slaved,
        });
        Part::Branch(self.branches.len() - 1)
    }

    /// The row of the rate of state of first order `k` while the branches are in given states;
    /// `None` if the state does not change.
    pub(crate) fn rate_of_first_order(
        &self,
        k: usize,
        sliders: &[SliderState],
    ) -> Option<Cow<'_, Functional>> {
        let own = &self.first_order[k];
        let Some(i) = own.slider else { return Some(Cow::Borrowed(&own.rate)) };
        match *sliders.get(i)? {
            SliderState::Held => Some(Cow::Borrowed(&own.rate)),
            _ if self.branches[i].slaved.is_some() => {
                self.branches[i].slaved.as_ref().map(|own| Cow::Borrowed(&own[1]))
            }
            state => {
                let sliding = self.branches[i].sliding.as_ref().filter(|_| state != SliderState::Off);
                sliding.map(|row| Cow::Owned(state.direction() * row))
            }
        }
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
            if let (Some(rate), false) = (&rate, taken.is_empty()) {
                let mut row = (***rate).clone();
                taken.iter().for_each(|(stop, own)| row.axpy(-own.1, &stop.excess, 1.0));
                a.push_row(row.iter().copied().enumerate());
                continue;
            }
            a.push_row(rate.as_deref().map_or(&[][..], Functional::terms).iter().copied());
        }
    }

    /// The force of a branch in a state of its slider. While the slider slips it is the level,
    /// whatever the stretch.
    pub fn branch_force(&self, i: usize, state: SliderState) -> Functional {
        match &self.branches[i].level {
            Some(_) if state == SliderState::Off => Functional::zeros(self.signals.size),
            Some(level) if state != SliderState::Held => state.direction() * level,
            _ => self.branches[i].force.clone(),
        }
    }

    /// The value of [`branch_force`](Self::branch_force).
    pub fn branch_force_at(&self, i: usize, state: SliderState, z: &[f64]) -> f64 {
        let branch = &self.branches[i];
        match branch.law {
            _ if state == SliderState::Held => branch.force.at(z),
            BranchLaw::Slider(slip) => state.direction() * slip * z[self.signals.one],
            BranchLaw::Contact { .. } => {
                state.direction() * branch.level.as_ref().map_or(0.0, |level| level.at(z))
            }
            BranchLaw::Dashpot(_) => branch.force.at(z),
        }
    }

    /// The states of all branches with sliders held and contacts open.
    pub fn held_sliders(&self) -> Vec<SliderState> {
        let state = |own: &BranchRows| match own.stop() {
            Some(_) => SliderState::Off,
            None => SliderState::Held,
        };
        self.branches.iter().map(state).collect()
    }

    /// The level of a branch with a slider, as a row.
    pub(crate) fn slip_level(&self, i: usize) -> Option<&Functional> {
        self.branches[i].level.as_ref()
    }

    /// The branches with sliders, by index.
    pub(crate) fn sliders(&self) -> impl Iterator<Item = usize> {
        (0..self.branches.len()).filter(|&i| self.branches[i].is_slider())
    }

    /// Sets the stretch of each branch whose slider slips so that its force is at its level. The
    /// stretch of an open contact is zero.
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
        if self.is_residual(Part::Branch(i)) {
            return None;
        }
        let [was, is] = [before[branch.place], after[branch.place]];
        let most = branch.most(after).filter(|most| *most > 0.0)?;
        (was != is && is.abs() == most).then(|| is.signum())
    }

    fn keep_level(&self, i: usize, direction: f64, z: &mut [f64]) {
        let branch = &self.branches[i];
        if let Some([stretch, _]) = &branch.slaved {
            z[branch.place] = stretch.at(z);
            return;
        }
        z[branch.place] = match branch.law {
            BranchLaw::Dashpot(_) => return,
            BranchLaw::Slider(slip) => direction * (slip / branch.stiffness) * z[self.signals.one],
            BranchLaw::Contact { .. } => {
                let level = branch.level.as_ref().map_or(0.0, |level| level.at(z));
                direction * level / branch.stiffness
            }
        };
    }

    /// Reduces the stretch of each branch whose force exceeds its level until the force is at its
    /// level. Returns the distances that inner places move.
    pub(crate) fn clamp_sliders(&self, z: &mut [f64]) -> Vec<f64> {
        let settled = self.settle_residual(z);
        let way = |(i, branch): (usize, &BranchRows), z: &mut [f64]| {
            if self.is_residual(Part::Branch(i)) {
                return settled[i];
            }
            let Some(most) = branch.most(z) else { return 0.0 };
            let stretch = z[branch.place];
            if stretch.abs() <= most {
                return 0.0;
            }
            z[branch.place] = most.copysign(stretch);
            stretch - most.copysign(stretch)
        };
        self.branches.iter().enumerate().map(|own| way(own, z)).collect()
    }
}
