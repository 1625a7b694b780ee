//! Variations (linearised perturbations) of the motion of a machine from a file, carried exactly
//! through flights and events (docs/assembly-law.md (A26)). [`Variation`] carries one, for the
//! largest Lyapunov exponent; [`Frame`] one for each state, for Floquet multipliers.
//!
//! Directions that contacts constrain are removed from every variation. [`Variation::grown`] also
//! removes neutral directions.

use super::flight::{ObservedFlight, Observer, Passage, dot};
use nalgebra::DVector;
use vibro_machine::mode::Mode;
use vibro_machine::motion::{Crossing, keep};
use vibro_machine::neutral::Neutral;
use vibro_machine::system::System;

/// Number of stretches of a flight between two checks of a variation's length. The length changes
/// by at most a factor of e¹⁰⁰ between two checks.
const STRETCHES: f64 = 50.0;
/// Range of lengths; a variation outside of it is rescaled. The square of such a length cannot
/// overflow before the next check, [`STRETCHES`] stretches later.
const SCALED: std::ops::Range<f64> = 1e-100..1e100;
/// Tolerance for the remainder of a variation, relative to its length; a smaller one is set to
/// zero.
const HELD: f64 = 1e-12;

/// Units of the state variables: coordinates, rates and inner states. The units define the length
/// of a variation.
#[derive(Clone, Debug, PartialEq)]
pub struct Metric(pub Vec<f64>);

impl Metric {
    /// Metric of n coordinates, n rates and `inner` inner states. The unit is 1 for rates and 1/ω
    /// (s) for the others, so that ω x compares with x'.
    pub fn by_frequency(n: usize, inner: usize, omega: f64) -> Self {
        let is_rate = |k: usize| (n..2 * n).contains(&k);
        Self((0..2 * n + inner).map(|k| if is_rate(k) { 1.0 } else { 1.0 / omega }).collect())
    }

    /// The length of a variation.
    pub fn length(&self, v: &[f64]) -> f64 {
        v.iter().zip(&self.0).map(|(x, unit)| (x / unit).powi(2)).sum::<f64>().sqrt()
    }

    /// A change of the state in these units.
    pub fn scaled(&self, v: &[f64]) -> DVector<f64> {
        DVector::from_iterator(self.0.len(), v.iter().zip(&self.0).map(|(x, unit)| x / unit))
    }

    /// Orthonormal basis, in these units, of the space that the given changes of the state span.
    pub fn basis(&self, directions: impl IntoIterator<Item = Vec<f64>>) -> Vec<DVector<f64>> {
        let mut basis: Vec<DVector<f64>> = Vec::new();
        for direction in directions {
            let mut u = self.scaled(&direction);
            let size = u.norm();
            // Two passes give orthogonality to rounding.
            for _ in 0..2 {
                basis.iter().for_each(|b| u.axpy(-b.dot(&u), b, 1.0));
            }
            if u.norm() > HELD * size {
                basis.push(u.normalize());
            }
        }
        basis
    }

    /// Removes the components of a variation along a basis.
    pub fn remove(&self, basis: &[DVector<f64>], v: &mut [f64]) {
        for b in basis {
            let share: f64 = b.iter().zip(v.iter().zip(&self.0)).map(|(b, (x, unit))| b * x / unit).sum();
            v.iter_mut().zip(b.iter().zip(&self.0)).for_each(|(x, (b, unit))| *x -= share * b * unit);
        }
    }
}

/// Removes the components of a variation that contacts constrain. A variation without other
/// components becomes zero.
pub(super) fn hold(system: &System, mode: &Mode, v: &mut [f64], metric: &Metric) {
    if mode.basis.is_empty() && mode.sliders.is_empty() {
        return;
    }
    let before = metric.length(v);
    keep(system, mode, v);
    if metric.length(v) <= HELD * before {
        v.fill(0.0);
    }
}

/// Applies the saltation matrix of an event to the variations.
pub(super) fn pass(system: &System, passage: Passage<'_>, variations: &mut [Vec<f64>], metric: &Metric) {
    let Passage { watch, flows, states, events, .. } = passage;
    let rates = [0, 1].map(|k| flows[k].derivative(states[k]));
    // Two functionals may have the same `Watch`. The one closest to zero here is used.
    let ended = flows[0].watched.iter().filter(|ended| Some(ended.0) == watch);
    let off = |row: &[f64]| dot(row, states[0]).abs();
    let row = ended.map(|(_, row)| row.as_slice()).min_by(|a, b| off(a).total_cmp(&off(b)));
    let (modes, rates) = (flows.map(|flow| &flow.mode), [&rates[0][..], &rates[1][..]]);
    let crossing = Crossing { modes, states, rates, row, events };
    let before: Vec<f64> = variations.iter().map(|v| metric.length(v)).collect();
    crossing.carry(system, variations.iter_mut().map(Vec::as_mut_slice));
    variations.iter_mut().for_each(|v| system.vary_curved(states[1], v));
    for (v, before) in variations.iter_mut().zip(before) {
        if metric.length(v) <= HELD * before {
            v.fill(0.0);
        }
    }
}

/// Fundamental matrix: one variation for each state variable, carried along a motion.
#[derive(Debug)]
pub struct Frame {
    /// One variation for each state variable as in a start (q, q', inner states): it began as a
    /// unit change of this variable.
    pub columns: Vec<Vec<f64>>,
    metric: Metric,
}

impl Frame {
    /// Variations along each number of the state, without the components that a mode's contacts
    /// constrain.
    pub fn new(system: &System, mode: &Mode, metric: &Metric) -> Self {
        let unit = |place: usize| {
            let mut v = vec![0.0; system.signals.size];
            v[place] = 1.0;
            system.take_given(&mut v);
            hold(system, mode, &mut v, metric);
            v
        };
        Self { columns: (0..system.states()).map(unit).collect(), metric: metric.clone() }
    }
}

impl Observer for Frame {
    fn flight(&mut self, system: &System, flight: ObservedFlight<'_>) {
        flight.flow.carry(flight.start, &mut self.columns, flight.span);
        for v in &mut self.columns {
            hold(system, &flight.flow.mode, v, &self.metric);
        }
    }

    fn passage(&mut self, system: &System, passage: Passage<'_>) {
        pass(system, passage, &mut self.columns, &self.metric);
    }
}

/// One variation of a motion, with the logarithm of its growth.
#[derive(Debug)]
pub struct Variation {
    v: [Vec<f64>; 1],
    metric: Metric,
    neutral: Vec<Vec<f64>>,
    /// Logarithm of the growth since it was last read.
    growth: f64,
}

impl Variation {
    /// A variation with components along all states, without the part constrained by the mode's
    /// contacts.
    pub fn new(system: &System, mode: &Mode, metric: Metric, neutral: &Neutral) -> Self {
        let mut v = vec![0.0; system.signals.size];
        for (k, (x, unit)) in v.iter_mut().zip(&metric.0).enumerate() {
            // The components are all different and not zero.
            *x = (1.0 + 0.7 * k as f64).sin() * unit;
        }
        hold(system, mode, &mut v, &metric);
        Self { v: [v], metric, neutral: neutral.states(), growth: 0.0 }
    }

    /// Removes the components along neutral directions, and along `shift`, the shift in time of an
    /// autonomous machine. Scales the variation to length one. Returns the logarithm of the growth
    /// since the last call, or -∞ if the variation has become zero.
    pub fn grown(&mut self, shift: Option<Vec<f64>>) -> f64 {
        let before = self.metric.length(&self.v[0]);
        let basis = self.metric.basis(self.neutral.iter().cloned().chain(shift));
        self.metric.remove(&basis, &mut self.v[0]);
        if self.metric.length(&self.v[0]) <= HELD * before {
            self.v[0].fill(0.0);
        }
        self.scale();
        std::mem::take(&mut self.growth)
    }

    fn scale(&mut self) {
        let length = self.metric.length(&self.v[0]);
        self.growth += length.ln();
        let scale = if length > 0.0 { 1.0 / length } else { 0.0 };
        self.v[0].iter_mut().for_each(|x| *x *= scale);
    }
}

impl Observer for Variation {
    fn flight(&mut self, system: &System, flight: ObservedFlight<'_>) {
        let ObservedFlight { flow, span, .. } = flight;
        let parts = (flow.stretches_of(span) / STRETCHES).ceil();
        let mut state = flight.start.to_vec();
        for _ in 0..parts as u64 {
            flow.carry_along(&mut state, &mut self.v, span / parts);
            hold(system, &flow.mode, &mut self.v[0], &self.metric);
            // Under a slow drive, dampers can make the variation underflow between two returns to
            // the section, so it is also rescaled here.
            if !SCALED.contains(&self.metric.length(&self.v[0])) {
                self.scale();
            }
        }
    }

    fn passage(&mut self, system: &System, passage: Passage<'_>) {
        pass(system, passage, &mut self.v, &self.metric);
    }
}

#[cfg(test)]
mod tests;
