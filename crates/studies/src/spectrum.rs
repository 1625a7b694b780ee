//! All Lyapunov exponents of a described machine's motion. Every variation of its state is carried
//! exactly through flights and events (docs/assembly-law.md (A26)) and orthogonalized on the way.
//!
//! A machine with n coordinates has 2n exponents, and one for each state of first order; the zero
//! exponent of the drive's phase is not counted. The exponents' sum is the mean rate at which
//! state volumes grow, by dampers and, at each impact, by the logarithm of the squared
//! restitution. Directions held by contacts are lost for ever; their exponents are -∞.
//!
//! On a periodic orbit the exponents are ln|μ|/T, with the orbit's multipliers μ over its period
//! T. The growth over n periods differs from them by up to about 1/(n T).

use super::flight::{Flows, ObservedFlight, Observer, Passage};
use super::growth::{ALIGN, Growth};
use super::settled::multipliers;
use super::variation::{Metric, hold, pass};
use super::{Machine, require_free, settle};
use crate::error::Result;
use crate::exponent::LargestExponent;
use std::f64::consts::TAU;
use vibro_machine::Start;
use vibro_machine::mode::Mode;
use vibro_machine::system::System;
use vibro_numerics::sorting::sort_by;

/// Stretches of a flight between two orthogonalizations: variations then differ in length by at
/// most e⁸, and the smallest one keeps its digits.
const STRETCHES: f64 = 4.0;
/// A variation is lost if orthogonalization leaves less than this fraction of its length.
const LOST: f64 = 1e-13;

/// All exponents of a motion, with their convergence.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// The exponents, 1/s, largest first, with standard errors. On a periodic orbit an exponent is
    /// ln|μ|/T with the multiplier μ, and its error is the difference from the period before. If
    /// |μ| is below rounding, the exponent is counted as for a motion without a period.
    pub exponents: Vec<LargestExponent>,
    /// Returns per period of the orbit on which the motion has settled.
    pub period: Option<u32>,
    /// After each counted return: time since counting began, s, and the exponents so far.
    pub running: Vec<(f64, Vec<f64>)>,
}

/// Variations with the logarithms of their growth.
struct Orthogonal {
    columns: Vec<Vec<f64>>,
    metric: Metric,
    growth: Vec<f64>,
}

impl Orthogonal {
    fn new(system: &System, mode: &Mode, metric: Metric) -> Self {
        let size = system.states();
        // In general position, so that the first variation turns into the fastest direction.
        let column = |j: usize| {
            let mut v = vec![0.0; system.signals.size];
            for (i, (x, unit)) in v.iter_mut().zip(&metric.0).enumerate() {
                let own = if i == j { 1.0 } else { 0.0 };
                *x = (own + 0.3 * (1.0 + 0.7 * (i * size + j) as f64).sin()) * unit;
            }
            hold(system, mode, &mut v, &metric);
            v
        };
        let mut new = Self { columns: (0..size).map(column).collect(), growth: vec![0.0; size], metric };
        new.orthogonalize();
        new.growth.fill(0.0);
        new
    }

    /// Orthonormalizes the variations, and adds the logarithms of their previous lengths. A
    /// variation that consists only of rounding becomes zero.
    fn orthogonalize(&mut self) {
        let size = self.metric.0.len();
        for j in 0..self.columns.len() {
            let (done, rest) = self.columns.split_at_mut(j);
            let v = &mut rest[0];
            let before = self.metric.length(v);
            // Two passes give orthogonality to rounding.
            for _ in 0..2 {
                for u in done.iter() {
                    let share = inner(&self.metric, u, v);
                    v[..size].iter_mut().zip(u).for_each(|(x, u)| *x -= share * u);
                }
            }
            let length = self.metric.length(v);
            if length <= LOST * before {
                v.fill(0.0);
                self.growth[j] = f64::NEG_INFINITY;
            } else {
                v.iter_mut().for_each(|x| *x /= length);
                self.growth[j] += length.ln();
            }
        }
    }

    /// The growth since the last call.
    fn grown(&mut self) -> Vec<f64> {
        self.orthogonalize();
        let zero = vec![0.0; self.growth.len()];
        std::mem::replace(&mut self.growth, zero)
    }
}

/// Inner product of two variations.
fn inner(metric: &Metric, a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).zip(&metric.0).map(|((a, b), unit)| a * b / (unit * unit)).sum()
}

impl Observer for Orthogonal {
    fn flight(&mut self, system: &System, flight: ObservedFlight<'_>) {
        let ObservedFlight { flow, span, .. } = flight;
        let parts = (flow.stretches_of(span) / STRETCHES).ceil();
        let mut state = flight.start.to_vec();
        for _ in 0..parts as u64 {
            flow.carry_along(&mut state, &mut self.columns, span / parts);
            for v in &mut self.columns {
                hold(system, &flow.mode, v, &self.metric);
            }
            self.orthogonalize();
        }
    }

    fn passage(&mut self, system: &System, passage: Passage<'_>) {
        pass(system, passage, &mut self.columns, &self.metric);
        self.orthogonalize();
    }
}

/// The exponents of a machine's motion from a start, over `keep` returns. Before that the motion
/// settles for `discard` returns, and the variations align for 32 returns. `go_on` is called at
/// each return, and ends the count by returning false.
///
/// # Errors
/// As [`Machine::motion`] and [`Section::advance`](super::Section::advance).
///
/// # Examples
/// All motions of a linear oscillator come closer with e^(-c/2m t):
///
/// ```
/// use vibro_studies::{Machine, Start, spectrum};
///
/// # let text = r#"
/// #     name = "Shaken"
/// #     body.a = { mass = 1.0 }
/// #     spring.k = { between = ["ground", "a"], stiffness = 4.0, damping = 1.25 }
/// #     load.f = { on = "a", amplitude = 26.0, frequency = "2 Hz" }
/// # "#;
/// let machine = Machine::parse(text, "shaken.toml", &vibro_machine::file::no_records)?;
/// let found = spectrum(&machine, &Start::default(), (100, 50), &mut || true)?;
/// assert_eq!((found.exponents.len(), found.period), (2, Some(1)));
/// assert!(found.exponents.iter().all(|own| (own.value + 0.625).abs() < 1e-12));
/// # Ok::<(), vibro_studies::Error>(())
/// ```
pub fn spectrum(
    machine: &Machine,
    start: &Start,
    (discard, keep): (u32, u32),
    go_on: &mut dyn FnMut() -> bool,
) -> Result<Spectrum> {
    let (motion, section) = machine.motion(start)?;
    require_free(motion.assembly())?;
    let mut motion = motion.without_energy_accounts();
    settle(&mut motion, &section, discard)?;
    let assembly = motion.assembly().clone();
    let (system, begin) = (assembly.system(), motion.time());
    let mut ahead = motion.clone();
    section.advance(&mut ahead, &mut |_| ())?;
    let metric = Metric::by_frequency(
        system.coordinates,
        system.places_of_first_order().len(),
        TAU / (ahead.time() - begin),
    );
    let mut variations = Orthogonal::new(system, motion.mode(), metric);
    let (mut flows, mut running) = (Flows::default(), Vec::new());
    let mut growths = vec![Growth::default(); system.states()];
    let (mut sums, mut counted) = (vec![0.0; growths.len()], 0.0);
    for k in 0..keep as usize + ALIGN {
        if !go_on() {
            break;
        }
        let from = motion.time();
        section.follow(&mut motion, &mut flows, &mut [&mut variations])?;
        let (grown, seconds) = (variations.grown(), motion.time() - from);
        growths.iter_mut().zip(&grown).for_each(|(growth, x)| growth.add(*x, seconds));
        if k >= ALIGN {
            counted += seconds;
            sums.iter_mut().zip(&grown).for_each(|(sum, x)| *sum += x);
            running.push((counted, sums.iter().map(|sum| sum / counted).collect()));
        }
    }
    let mut exponents: Vec<LargestExponent> = growths.iter().map(Growth::exponent).collect();
    sort_by(&mut exponents, |a, b| b.value.total_cmp(&a.value));
    let multipliers = multipliers(&mut motion, &section)?;
    let period = multipliers.as_ref().map(|periods| periods[0].returns);
    if let Some([before, last]) = multipliers {
        let lost = exponents.iter().filter(|e| e.value == f64::NEG_INFINITY).count();
        // Directions whose multipliers are rounding keep their growth.
        for (own, (value, before)) in
            exponents.iter_mut().zip(last.exponents(lost).into_iter().zip(before.exponents(lost)))
        {
            *own = LargestExponent { value, error: (value - before).abs(), periods: last.returns };
        }
    }
    Ok(Spectrum { exponents, period, running })
}

#[cfg(test)]
mod tests;
