//! Samples as a linear map of the augmented state (docs/assembly-law.md (A56)): the sides of all
//! limits are given, and nothing is rounded to a quantum.

use super::super::System;
use super::samples::ReadOutput;
use super::{Combination, SampleAction, SampleKind, Sampler};
use nalgebra::DMatrix;

/// A value that a sample compares with limits.
#[derive(Clone, Copy, Debug)]
pub struct LimitedValue {
    /// The block that has the limits, and its output.
    pub output: (usize, usize),
    /// The value without limits.
    pub value: f64,
    /// Size of its terms.
    pub size: f64,
    /// Lower and upper limit; one of them may be infinite.
    pub limits: [f64; 2],
}

impl LimitedValue {
    /// 1 at or beyond the upper limit, -1 at or beyond the lower limit, otherwise 0.
    pub fn side(&self) -> i8 {
        let [low, high] = self.limits;
        i8::from(self.value >= high) - i8::from(self.value <= low)
    }

    /// Distance of the value into a side of its limits, relative to its terms; negative outside.
    pub fn margin(&self, side: i8) -> f64 {
        let [low, high] = self.limits;
        let way = match side {
            1 => self.value - high,
            -1 => low - self.value,
            _ => (high - self.value).min(self.value - low),
        };
        let ends = [low, high].into_iter().filter(|x| x.is_finite()).map(f64::abs);
        way / ends.fold(self.size, f64::max).max(f64::MIN_POSITIVE)
    }
}

/// Callback that decides on which side of its limits a value counts.
type Decide<'a> = &'a mut dyn FnMut(LimitedValue) -> i8;

impl System {
    /// Applies the actions of blocks at an instant to an augmented state or a variation. `decide`
    /// returns the side of each limited value, in an order that depends only on the machine.
    pub fn sample_as(&self, actions: &[SampleAction], decide: Decide, z: &mut [f64]) {
        for action in actions.iter().filter(|own| own.kind == SampleKind::Acts) {
            self.act(action.block, z);
        }
        for ReadOutput { block, output, place, sampler } in self.read_outputs(actions) {
            let (value, size) = self.sum_as(block, (&sampler.c, &sampler.d, output), decide, z);
            let limits = sampler.limits[output];
            let is_limited = limits.iter().any(|limit| limit.is_finite());
            let side = if is_limited {
                decide(LimitedValue { output: (block, output), value, size, limits })
            } else {
                0
            };
            let one = z[self.signals.one];
            z[place] = match side {
                1 => limits[1] * one,
                -1 => limits[0] * one,
                _ => value,
            };
        }
        for action in actions.iter().filter(|own| own.kind != SampleKind::Acts) {
            let own = &self.blocks[action.block];
            let Some(Sampler { a, b, .. }) = &own.sampler else { continue };
            let next: Vec<f64> =
                (0..own.states).map(|k| self.sum_as(action.block, (a, b, k), decide, z).0).collect();
            z[own.first..own.first + own.states].copy_from_slice(&next);
        }
    }

    /// Returns row i of the matrices times states and inputs, and the size of its terms.
    fn sum_as(
        &self,
        block: usize,
        (of_states, of_inputs, i): (&DMatrix<f64>, &DMatrix<f64>, usize),
        decide: Decide,
        z: &[f64],
    ) -> (f64, f64) {
        let own = &self.blocks[block];
        let (mut sum, mut size) = (0.0, 0.0);
        let mut add = |(value, terms): (f64, f64)| {
            sum += value;
            size += terms;
        };
        for k in 0..own.states {
            let term = of_states[(i, k)] * z[own.first + k];
            add((term, term.abs()));
        }
        for (j, input) in own.inputs.iter().enumerate().filter(|(j, _)| of_inputs[(i, *j)] != 0.0) {
            let (value, terms) = self.read_as(input, decide, z);
            add((of_inputs[(i, j)] * value, of_inputs[(i, j)].abs() * terms));
        }
        (sum, size)
    }

    /// Returns the value of an input, and the size of its terms.
    fn read_as(&self, read: &Combination, decide: Decide, z: &[f64]) -> (f64, f64) {
        let dot = |row: &[f64]| {
            let terms = row.iter().zip(z).map(|(a, x)| a * x);
            terms.fold((0.0, 0.0), |(sum, size), term| (sum + term, size + term.abs()))
        };
        let (mut value, mut size) = dot(read.row.as_slice());
        for &(stop, factor) in &read.beyond {
            let Some(limit) = self.stops[stop].limit else { continue };
            let (excess, terms) = dot(self.stops[stop].excess.as_slice());
            let limits = [f64::NEG_INFINITY, 0.0];
            let output = (limit.block, limit.output);
            if decide(LimitedValue { output, value: excess, size: terms, limits }) > 0 {
                value += factor * excess;
                size += factor.abs() * terms;
            }
        }
        (value, size)
    }
}
