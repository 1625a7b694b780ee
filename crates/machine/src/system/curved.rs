//! Curved forces of a machine: their coordinates in the augmented state.

use super::{Elongation, Part, System};
use crate::curved::{Curved, Operation, POWERS, Polynomial};
use crate::description::{Description, OddPower};
use crate::elements::Element;
use crate::functional::Functional;
use crate::mode::{Mode, StopState};

/// Number of curved forces of a machine.
pub fn count(d: &Description) -> usize {
    let springs = d.springs.iter().map(|own| usize::from(own.has_polynomial()) + own.power.iter().count());
    let dampers = d.dampers.iter().map(|own| own.cubic.iter().count() + own.odd_powers().count());
    let stops = d.stops.iter().filter_map(|own| own.contact);
    let stops = stops.map(|own| usize::from(own.exponent != 1.0) + own.dissipation.iter().count());
    springs.chain(dampers).chain(stops).sum()
}

impl Curved {
    /// The column of xᵖ of a released contact, as if the contact had its force: accounts and event
    /// functions need this power beyond the release.
    pub(crate) fn released(&self, system: &System, mode: &Mode) -> Option<Vec<(usize, f64)>> {
        let (Part::Stop(i), Operation::OneSided(_)) = (self.owner, self.operation) else { return None };
        let stop = &system.stops[i];
        let terms = stop.elongation.mobility.terms().iter();
        let column = terms.map(|&(k, x)| (system.coordinates + k, stop.stiffness() * x));
        (mode.stops[i] == StopState::Free).then(|| column.collect())
    }
}

/// The first element with a curved force, by its dotted name.
pub fn first(d: &Description) -> Option<String> {
    d.elements().find(|element| element.is_curved()).map(Element::dotted)
}

impl System {
    /// Adds a curved force to the spring that was added last, of its elongation or of its rate.
    pub(crate) fn add_curve(&mut self, is_of_rate: bool, coefficients: [f64; POWERS]) {
        let place = self.signals.curved + self.curved.len();
        let Some(spring) = self.springs.last_mut() else { return };
        let Elongation { e, rate, .. } = &spring.elongation;
        let argument = if is_of_rate { rate } else { e }.clone();
        spring.force = &spring.force + &Functional::unit(self.signals.size, place, 1.0);
        spring.curves.push((self.curved.len(), 1.0));
        let operation = Operation::Polynomial(Polynomial { coefficients });
        let second = Functional::zeros(self.signals.size);
        let owner = Part::Spring(self.springs.len() - 1);
        self.curved.push(Curved { argument, second, operation, place, is_of_rate, owner });
    }

    /// Adds powers with two sides to the spring that was added last, of its elongation or of its
    /// rate.
    pub(crate) fn add_odd_powers(&mut self, is_of_rate: bool, powers: impl IntoIterator<Item = OddPower>) {
        for OddPower { coefficient, exponent } in powers {
            let Some(spring) = self.springs.last() else { return };
            let Elongation { e, rate, .. } = &spring.elongation;
            let argument = if is_of_rate { rate } else { e }.clone();
            let (index, owner) = (self.curved.len(), Part::Spring(self.springs.len() - 1));
            let none = Functional::zeros(self.signals.size);
            let row = self.add_operation(Operation::TwoSided(exponent), [&argument, &none], owner);
            self.curved[index].is_of_rate = is_of_rate;
            let Some(spring) = self.springs.last_mut() else { return };
            spring.force = &spring.force + &(coefficient * &row);
            spring.curves.push((index, coefficient));
        }
    }

    /// Adds an operation; returns the row of its value.
    pub(crate) fn add_operation(
        &mut self,
        operation: Operation,
        [argument, second]: [&Functional; 2],
        owner: Part,
    ) -> Functional {
        let place = self.signals.curved + self.curved.len();
        let (argument, second) = (argument.clone(), second.clone());
        self.curved.push(Curved { argument, second, operation, place, is_of_rate: false, owner });
        Functional::unit(self.signals.size, place, 1.0)
    }

    /// Writes the curved forces into the augmented state, from its coordinates and rates.
    #[inline(always)]
    pub(crate) fn fill_curved(&self, z: &mut [f64]) {
        for curved in &self.curved {
            curved.fill(z);
        }
    }

    /// Writes the variations of the curved forces into a variation of the state `z`.
    pub fn vary_curved(&self, z: &[f64], variation: &mut [f64]) {
        for curved in &self.curved {
            curved.vary(z, variation);
        }
    }

    /// Raises the sizes of curved forces to their rounding at a state.
    #[inline(always)]
    pub(crate) fn include_curved(&self, z: &[f64], sizes: &mut [f64]) {
        for curved in &self.curved {
            sizes[curved.place] = sizes[curved.place].max(curved.size(z, sizes));
        }
    }
}
