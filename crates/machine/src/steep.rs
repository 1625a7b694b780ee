//! Curved forces that change fast: they make the power series of a motion short.

use crate::assembly::Assembly;
use crate::elements::Element;
use crate::flow::CURVE_REACH;
use crate::functional::Functional;
use crate::part::Part;
use nalgebra::DVector;

/// A curved force that changes fast.
#[derive(Clone, Debug, PartialEq)]
pub struct Steep {
    /// Dotted name of the element.
    pub element: String,
    /// Rate that the slope of the force gives to the masses that it moves, 1/s.
    pub rate: f64,
}

impl Steep {
    /// Number of series that a second of motion takes.
    pub fn series(&self) -> f64 {
        self.rate / CURVE_REACH
    }
}

impl Assembly {
    /// The curved force that changes fastest at zero displacements and rates, where most curves are
    /// steepest; `None` if no curved force acts there.
    pub fn steepest_at_zero(&self) -> Option<Steep> {
        let mut z = DVector::zeros(self.system.signals.size);
        z[self.system.signals.one] = 1.0;
        self.system.fill_curved(z.as_mut_slice());
        self.steepest(&z)
    }

    /// The curved force that changes fastest at an augmented state.
    pub(crate) fn steepest(&self, z: &DVector<f64>) -> Option<Steep> {
        let of = |(place, element): (usize, Element)| {
            let parts = self.system.parts[place].iter();
            let rate = parts.filter_map(|part| self.rate_of(*part, z)).fold(0.0, f64::max);
            (rate > 0.0).then(|| Steep { element: element.dotted(), rate })
        };
        let curved = self.description.elements().enumerate().filter(|own| own.1.is_curved());
        curved.filter_map(of).max_by(|a, b| a.rate.total_cmp(&b.rate))
    }

    /// The rate of the curved force of a part of an element: its slope by the rate of the elongation
    /// over the moved mass, or the root of its slope by the elongation over the mass.
    fn rate_of(&self, part: Part, z: &DVector<f64>) -> Option<f64> {
        let system = &self.system;
        let (elongation, force) = match part {
            Part::Spring(i) => (&system.springs[i].elongation, &system.springs[i].force),
            Part::Stop(i) if system.stops[i].excess.dot(z) > 0.0 => {
                (&system.stops[i].elongation, &system.stops[i].force)
            }
            Part::Friction(i) => {
                (&system.frictions[i].elongation, &system.frictions[i].levels.first()?.level)
            }
            _ => return None,
        };
        let slope = |first: usize| {
            let mut moved = vec![0.0; system.signals.size];
            elongation.mobility.terms().iter().for_each(|&(k, x)| moved[first + k] = x);
            system.vary_curved(z.as_slice(), &mut moved);
            let curved = force.terms().iter().filter(|term| term.0 >= system.signals.curved);
            Functional::from_terms(system.signals.size, curved.copied()).at(&moved).abs()
        };
        let rate = slope(system.coordinates).max(slope(0).sqrt());
        rate.is_finite().then_some(rate)
    }
}
