//! States as users give and read them: with the inner places x of springs in series. The augmented
//! state has stretches y = e - x instead.

use super::contact::Flags;
use super::jump::Parted;
use super::projection::place_of;
use super::{Hybrid, Motion};
use crate::assembly::Assembly;
use crate::mode::{Contact, SliderState};
use crate::signals::Input;
use nalgebra::DVector;
use vibro_numerics::double_double::DoubleDouble;

impl Motion {
    /// Returns the augmented state with coordinates, rates and states of first order `start`.
    /// Sliders are moved until no force exceeds its level.
    pub(super) fn state_with_signals(
        assembly: &Assembly,
        time: DoubleDouble,
        start: &[f64],
        inputs: &[(f64, Input)],
    ) -> DVector<f64> {
        let system = &assembly.system;
        let mut z = DVector::zeros(system.signals.size);
        z.as_mut_slice()[..start.len()].copy_from_slice(start);
        system.signals.fill(time, inputs, z.as_mut_slice());
        system.take_given(z.as_mut_slice());
        system.clamp_sliders(z.as_mut_slice());
        system.fill_curved(z.as_mut_slice());
        z
    }

    /// Returns the continuous states as [`from_state`](Self::from_state) takes them: coordinates,
    /// rates, inner places, states of blocks.
    ///
    ///
    /// ```
    /// use vibro_machine::{Assembly, Motion, file};
    ///
    /// let text = r#"
    ///     name = "Trolleys"
    ///     body.a = { mass = 1.0, start = { s = 1.0, v = 0.5 } }
    ///     body.b = { mass = 2.0, start = { s = 3.0 } }
    ///     stop.rope = { between = ["a", "b"], gap = 9.0, restitution = 0.5 }
    /// "#;
    /// let machine = file::parse(text, "trolleys.toml", &file::no_records)?;
    /// let mut motion = Motion::new(Assembly::new(machine)?.into())?;
    /// motion.advance_to(2.0)?;
    /// assert_eq!(motion.states(), [2.0, 3.0, 0.5, 0.0]);
    /// let same = Motion::from_state(motion.assembly().clone(), 2.0, &motion.states())?;
    /// assert_eq!(same.body(1), motion.body(1));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn states(&self) -> Vec<f64> {
        let system = &self.assembly.system;
        let mut states = self.hybrid.z.as_slice()[..system.states()].to_vec();
        system.branches.iter().enumerate().for_each(|(i, own)| states[own.place] = self.inner_place(i));
        states
    }

    /// Sets the continuous states, in the order and number of [`states`](Self::states).
    pub fn set_states(&mut self, states: &[f64]) {
        let Self { assembly, hybrid, .. } = self;
        let own = assembly.system.signals.one;
        hybrid.z.as_mut_slice()[..own].iter_mut().zip(states).for_each(|(z, state)| *z = *state);
        hybrid.standing.retain(|held| !matches!(held.0, Contact::Slider(_)));
        if self.overshoot > 0.0 {
            let given = assembly.system.branches.iter().enumerate();
            hybrid.standing.extend(given.map(|(i, branch)| (Contact::Slider(i), hybrid.z[branch.place])));
        }
        assembly.system.take_given(hybrid.z.as_mut_slice());
        assembly.system.fill_curved(hybrid.z.as_mut_slice());
    }

    /// Time derivatives of the continuous states.
    pub fn state_derivatives(&self) -> Vec<f64> {
        let mut rates = self.rates_of(&self.hybrid.z).as_slice().to_vec();
        let branches = self.assembly.system.branches.iter().enumerate();
        branches.for_each(|(i, own)| rates[own.place] = self.inner_rate(i));
        rates
    }

    /// Computes the stretches of springs in series from the inner places, which are states of the
    /// host's solver.
    pub(super) fn stretch_on(&mut self) {
        let Hybrid { z, standing, .. } = &mut self.hybrid;
        for (contact, inner) in standing {
            if let Contact::Slider(i) = *contact {
                let branch = &self.assembly.system.branches[i];
                z[branch.place] = branch.whole.at(z.as_slice()) - *inner;
            }
        }
    }

    /// The inner place of a spring in series.
    pub(crate) fn inner_place(&self, i: usize) -> f64 {
        let Hybrid { z, standing, .. } = &self.hybrid;
        let inner = || self.assembly.system.branches[i].inner.at(z.as_slice());
        place_of(Contact::Slider(i), standing).unwrap_or_else(inner)
    }

    /// Returns the rate of the inner place of a spring in series; 0 for a held slider.
    pub(super) fn inner_rate(&self, i: usize) -> f64 {
        let (branch, z) = (&self.assembly.system.branches[i], self.hybrid.z.as_slice());
        if branch.is_slider() && self.hybrid.mode.sliders[i] == SliderState::Held {
            return 0.0;
        }
        branch.rate.at(z) - self.table().a.row_times(branch.place, z)
    }

    /// Moves sliders after a jump until no force exceeds its level; returns the distances. These
    /// sliders, and contacts whose place has jumped, hold at their new places.
    pub(super) fn clamp(&mut self) -> Vec<f64> {
        let ways = self.assembly.system.clamp_sliders(self.hybrid.z.as_mut_slice());
        self.forget_moved(&ways);
        ways
    }

    /// Stretches springs in series by the jump of their elongations since `before`: the inner
    /// places stay. For a host's solver, inner places are states.
    pub(super) fn stretch(&mut self, before: &[f64]) {
        if self.overshoot > 0.0 {
            return self.stretch_on();
        }
        let Hybrid { z, sizes, .. } = &mut self.hybrid;
        for (branch, was) in self.assembly.system.branches.iter().zip(before) {
            let e = &branch.whole;
            let jump = e.at(z.as_slice()) - was;
            if jump.abs() > sizes.zero_of(e) {
                z[branch.place] += jump;
            }
        }
    }

    /// Moves the bodies onto touching stops. At a start the distance may exceed rounding: the
    /// inner places of springs in series keep their given values.
    pub(super) fn place_at_start(&mut self, flags: &mut Flags, parted: &Parted) {
        let system = &self.assembly.system;
        let is_start = self.hybrid.mode.stops.len() < system.stops.len();
        if !is_start || system.branches.is_empty() {
            return self.place_on_contacts(flags, parted);
        }
        let before = system.elongations_in_series(self.hybrid.z.as_slice());
        self.place_on_contacts(flags, parted);
        self.stretch(&before);
        self.clamp();
    }
}
