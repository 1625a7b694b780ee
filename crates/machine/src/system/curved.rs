//! Curved forces of a machine: their coordinates in the augmented state.

use super::{Elongation, Part, System};
use crate::curved::{Curved, Operation, POWERS, Polynomial};
use crate::description::Description;
use crate::elements::Element;
use crate::functional::Functional;

/// Number of curved forces of a machine.
pub fn count(d: &Description) -> usize {
    d.elements().filter(|element| element.is_curved()).count()
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
        spring.curve = Some(self.curved.len());
        let operation = Operation::Polynomial(Polynomial { coefficients });
        let second = Functional::zeros(self.signals.size);
        let owner = Part::Spring(self.springs.len() - 1);
        self.curved.push(Curved { argument, second, operation, place, is_of_rate, owner });
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
