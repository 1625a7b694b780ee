//! Curved forces of a machine: their coordinates in the augmented state, and the slopes that give
//! a mode its time scale.

use super::{Elongation, System};
use crate::curved::{Curved, POWERS, Polynomial};
use crate::description::{BodyKind, Description};
use crate::elements::Element;
use crate::functional::Functional;
use crate::kernel::SparseMatrix;

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
        let force = Polynomial { coefficients };
        self.curved.push(Curved { argument, force, place, is_of_rate, slope: 0.0 });
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

    /// Sets the slopes at the amplitudes that the start and the loads suggest.
    pub(crate) fn estimate_slopes(&mut self, d: &Description) {
        if self.curved.is_empty() {
            return;
        }
        let load = d.loads.iter().map(|load| {
            let signal = &load.force;
            let harmonics = signal.harmonics.iter().map(|h| h.amplitude.abs()).sum::<f64>();
            let steps = signal.steps.iter().map(|step| step.height.abs()).sum::<f64>();
            let sweeps = signal.sweeps.iter().map(|sweep| sweep.amplitude.abs()).sum::<f64>();
            signal.constant.abs() + harmonics + steps + sweeps
        });
        let weight = self.weights.iter().map(|weight| weight.abs()).sum::<f64>();
        let preload = self.springs.iter().map(|spring| spring.preload.abs()).sum::<f64>();
        let force = load.sum::<f64>() + weight + preload;
        let (mut places, mut speeds) = (0.0f64, 0.0f64);
        for body in &d.bodies {
            let (s, v) = match &body.kind {
                BodyKind::Free(free) => (free.s, free.v),
                BodyKind::Prescribed { motion, rate } => {
                    let harmonics = motion.harmonics.iter().map(|h| h.amplitude.abs()).sum::<f64>();
                    (motion.constant.abs() + harmonics, *rate)
                }
                BodyKind::Integrated(own) => (own.s, own.v),
                BodyKind::Node(_) => (0.0, 0.0),
            };
            (places, speeds) = (places + s.abs(), speeds + v.abs());
        }
        let inertia = self.inertias.iter().sum::<f64>();
        for curved in &mut self.curved {
            let arm = curved.argument.terms().iter().map(|term| term.1.abs()).fold(0.0, f64::max);
            let reached = if curved.is_of_rate { speeds } else { places } * arm;
            // A body with this speed is stopped where the work of φ is its kinetic energy.
            let stopping = curved.force.reaching(force + inertia * speeds * speeds / reached.max(1e-9));
            let x = reached.max(if stopping.is_finite() { stopping } else { 0.0 });
            curved.slope = curved.force.majorant().derivative(x);
        }
    }

    /// A with the slopes of the curved forces added to the sizes of its entries.
    pub(crate) fn with_slopes(&self, a: &SparseMatrix) -> SparseMatrix {
        let mut with = SparseMatrix::default();
        for i in 0..a.len() {
            let mut row = a.row(i).to_vec();
            for curved in &self.curved {
                let by = row.iter().find(|term| term.0 == curved.place).map_or(0.0, |term| term.1);
                for &(j, x) in curved.argument.terms().iter().filter(|_| by != 0.0) {
                    let added = (by * curved.slope * x).abs();
                    match row.iter_mut().find(|term| term.0 == j) {
                        Some(term) => term.1 += added.copysign(term.1),
                        None => row.push((j, added)),
                    }
                }
            }
            row.sort_by_key(|term| term.0);
            with.push_row(row.into_iter());
        }
        with
    }
}
