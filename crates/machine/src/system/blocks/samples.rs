//! Effect of samples on the augmented state and on its variations.

use super::super::System;
use super::{Combination, Sampler};
use crate::functional::StateRow;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// An action of a sampled block at an instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SampleAction {
    /// Index of the block.
    pub block: usize,
    /// Kind of the action.
    pub kind: SampleKind,
}

/// The two actions of a sampled block.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SampleKind {
    /// The first outputs under way begin to act.
    Acts,
    /// The block reads its inputs. Its outputs act at once, or after this number of other outputs.
    Reads(Option<usize>),
}

/// The derivative of a [`Combination`] by a parameter.
#[derive(Clone, Debug)]
pub struct CombinationTangent {
    /// Derivative of the row.
    pub row: StateRow,
    /// Derivatives of the limits' factors.
    pub beyond: Vec<f64>,
}

/// The derivative of a sampled block's law by a parameter.
#[derive(Clone, Debug)]
pub struct SamplerTangent {
    /// Derivative of `a`, by state and state.
    pub a: DMatrix<f64>,
    /// Derivative of `b`, by state and input.
    pub b: DMatrix<f64>,
    /// Derivative of `c`, by output and state.
    pub c: DMatrix<f64>,
    /// Derivative of `d`, by output and input.
    pub d: DMatrix<f64>,
    /// Derivatives of each output's limits.
    pub limits: Vec<[f64; 2]>,
    /// Derivatives of the inputs u.
    pub inputs: Vec<CombinationTangent>,
    /// Derivative of each input's quantum.
    pub quanta: Vec<f64>,
}

/// A variation of the state at an instant at which blocks are sampled.
pub struct SampledVariation<'a> {
    /// The variation δ.
    pub delta: &'a mut [f64],
    /// Derivative of each block's law; empty if only the state varies.
    pub blocks: &'a [Option<SamplerTangent>],
    /// Derivative of each stop's excess; `None` if only the state varies.
    pub excess: &'a dyn Fn(usize) -> Option<&'a StateRow>,
    /// Whether a rounded input keeps its multiple of the quantum. If not, it varies like the
    /// quantity that the block reads.
    pub rounds: bool,
}

/// An output that a sample computes.
pub(super) struct ReadOutput<'s> {
    /// The block.
    pub block: usize,
    /// The output.
    pub output: usize,
    /// The output's index in the state.
    pub place: usize,
    /// The block's law at samples.
    pub sampler: &'s Sampler,
}

/// Derivatives of the matrices of states and of inputs, of the inputs, and of the quanta.
type RowsTangent<'a> = (&'a DMatrix<f64>, &'a DMatrix<f64>, &'a Vec<CombinationTangent>, &'a [f64]);

/// Distance from the middle between two multiples within which rounding may choose either, in
/// quanta, and relative to the input if that is larger: some thousands of roundings.
const MIDDLE: f64 = 1e-12;

/// Returns the value of a rounded input: the nearest multiple, halves away from zero.
fn rounded(value: f64, quantum: f64) -> f64 {
    if quantum == 0.0 { value } else { quantum * (value / quantum).round() }
}

fn dot(row: &StateRow, z: &[f64]) -> f64 {
    row.iter().zip(z).map(|(a, b)| a * b).sum()
}

impl System {
    /// Applies the actions of blocks at an instant. First, outputs under way act. Then blocks
    /// compute outputs from their inputs, in the order of their d. Finally, blocks that have read
    /// update their states. Variations are carried along.
    pub(crate) fn sample(
        &self,
        actions: &[SampleAction],
        z: &mut DVector<f64>,
        variations: &mut [SampledVariation],
    ) {
        for action in actions.iter().filter(|own| own.kind == SampleKind::Acts) {
            self.act(action.block, z.as_mut_slice());
            variations.iter_mut().for_each(|own| self.act(action.block, own.delta));
        }
        for ReadOutput { block, output, place, sampler } in self.read_outputs(actions) {
            let free = self.sum(block, (&sampler.c, &sampler.d, output), sampler, z);
            let [low, high] = sampler.limits[output];
            let varied: Vec<f64> = variations
                .iter()
                .map(|own| {
                    let tangent = own.blocks.get(block).and_then(Option::as_ref);
                    match tangent {
                        _ if free <= low || free >= high => {
                            let side = usize::from(free >= high);
                            tangent.map_or(0.0, |by| by.limits[output][side])
                        }
                        _ => {
                            let by = tangent.map(|by| (&by.c, &by.d, &by.inputs, &by.quanta[..]));
                            self.sum_by(block, (&sampler.c, &sampler.d, output), (sampler, by), (z, own))
                        }
                    }
                })
                .collect();
            z[place] = free.clamp(low, high);
            variations.iter_mut().zip(varied).for_each(|(own, value)| own.delta[place] = value);
        }
        for action in actions.iter().filter(|own| own.kind != SampleKind::Acts) {
            self.follow_inputs(action.block, z, variations);
        }
    }

    /// Returns the outputs of the blocks that read their inputs, in the order of their
    /// dependencies.
    pub(super) fn read_outputs<'s>(
        &'s self,
        actions: &'s [SampleAction],
    ) -> impl Iterator<Item = ReadOutput<'s>> {
        let turn = |block: usize| {
            actions.iter().find_map(|own| match own.kind {
                SampleKind::Reads(turn) if own.block == block => Some(turn),
                _ => None,
            })
        };
        self.output_order.iter().filter_map(move |&(block, output)| {
            let (turn, own) = (turn(block)?, &self.blocks[block]);
            let place = own.place_of_output(turn, output);
            Some(ReadOutput { block, output, place, sampler: own.sampler.as_ref()? })
        })
    }

    /// Applies x⁺ = a x + b u.
    fn follow_inputs(&self, block: usize, z: &mut DVector<f64>, variations: &mut [SampledVariation]) {
        let own = &self.blocks[block];
        let Some(sampler) = &own.sampler else { return };
        let of = |k: usize| (&sampler.a, &sampler.b, k);
        let next: Vec<f64> = (0..own.states).map(|k| self.sum(block, of(k), sampler, z)).collect();
        for varied in variations {
            let tangent = varied.blocks.get(block).and_then(Option::as_ref);
            let by = tangent.map(|by| (&by.a, &by.b, &by.inputs, &by.quanta[..]));
            let all: Vec<f64> =
                (0..own.states).map(|k| self.sum_by(block, of(k), (sampler, by), (z, varied))).collect();
            varied.delta[own.first..own.first + own.states].copy_from_slice(&all);
        }
        z.as_mut_slice()[own.first..own.first + own.states].copy_from_slice(&next);
    }

    /// Makes the first outputs under way of a block act.
    pub(super) fn act(&self, block: usize, z: &mut [f64]) {
        let own = &self.blocks[block];
        let (first, count) = (own.place_of_output(None, 0), own.outputs.len());
        let end = own.first + own.kept();
        z.copy_within(first + count..end, first);
        z[end - count..end].fill(0.0);
    }

    /// Returns row i of the matrices of states and inputs times the states and inputs.
    fn sum(
        &self,
        block: usize,
        (of_states, of_inputs, i): (&DMatrix<f64>, &DMatrix<f64>, usize),
        sampler: &Sampler,
        z: &DVector<f64>,
    ) -> f64 {
        let own = &self.blocks[block];
        let states: f64 = (0..own.states).map(|k| of_states[(i, k)] * z[own.first + k]).sum();
        let inputs = own.inputs.iter().enumerate().filter(|(j, _)| of_inputs[(i, *j)] != 0.0);
        let inputs =
            inputs.map(|(j, input)| of_inputs[(i, j)] * rounded(input.at(&self.stops, z), sampler.quanta[j]));
        states + inputs.sum::<f64>()
    }

    /// Returns the derivative of [`sum`](Self::sum). A rounded input is n q with its quantum q; n
    /// does not vary, unless rounding is ignored.
    fn sum_by(
        &self,
        block: usize,
        (of_states, of_inputs, i): (&DMatrix<f64>, &DMatrix<f64>, usize),
        (sampler, by): (&Sampler, Option<RowsTangent>),
        (z, varied): (&DVector<f64>, &SampledVariation),
    ) -> f64 {
        let own = &self.blocks[block];
        let mut sum: f64 = (0..own.states).map(|k| of_states[(i, k)] * varied.delta[own.first + k]).sum();
        for (j, input) in own.inputs.iter().enumerate() {
            let factor = of_inputs[(i, j)];
            if factor != 0.0 {
                let quantum = sampler.quanta[j];
                sum += factor
                    * if varied.rounds && quantum > 0.0 && !sampler.varies_rounded {
                        by.map_or(0.0, |by| by.3[j] * (input.at(&self.stops, z) / quantum).round())
                    } else {
                        self.combination_by(input, by.map(|by| &by.2[j]), z, varied)
                    };
            }
        }
        if let Some((states_by, inputs_by, ..)) = by {
            sum += (0..own.states).map(|k| states_by[(i, k)] * z[own.first + k]).sum::<f64>();
            let inputs = own.inputs.iter().enumerate();
            let read = |(j, input): (usize, &Combination)| match inputs_by[(i, j)] {
                0.0 => 0.0,
                factor => factor * rounded(input.at(&self.stops, z), sampler.quanta[j]),
            };
            sum += inputs.map(read).sum::<f64>();
        }
        sum
    }

    /// Returns the first block with a varying input in the middle between two multiples.
    pub(crate) fn between_multiples(
        &self,
        actions: &[SampleAction],
        z: &DVector<f64>,
        varied: &SampledVariation,
    ) -> Option<usize> {
        let reads = actions.iter().filter(|own| own.kind != SampleKind::Acts).map(|own| own.block);
        reads.into_iter().find(|&block| {
            let own = &self.blocks[block];
            let Some(sampler) = own.sampler.as_ref().filter(|own| !own.varies_rounded) else { return false };
            let tangent = varied.blocks.get(block).and_then(Option::as_ref);
            own.inputs.iter().zip(&sampler.quanta).enumerate().any(|(j, (input, &quantum))| {
                let multiple = if quantum > 0.0 { input.at(&self.stops, z) / quantum } else { return false };
                let apart = (multiple.fract().abs() - 0.5).abs();
                let by = tangent.map(|by| &by.inputs[j]);
                apart <= MIDDLE * (1.0 + multiple.abs()) && self.combination_by(input, by, z, varied) != 0.0
            })
        })
    }

    fn combination_by(
        &self,
        own: &Combination,
        by: Option<&CombinationTangent>,
        z: &DVector<f64>,
        varied: &SampledVariation,
    ) -> f64 {
        let mut sum = dot(&own.row, varied.delta) + by.map_or(0.0, |by| by.row.dot(z));
        for (k, &(stop, factor)) in own.beyond.iter().enumerate() {
            let excess = &self.stops[stop].excess;
            let beyond = excess.at(z.as_slice());
            if beyond > 0.0 {
                let moved = (varied.excess)(stop).map_or(0.0, |row| row.dot(z));
                sum += factor * (dot(excess, varied.delta) + moved);
                sum += by.map_or(0.0, |by| by.beyond[k] * beyond);
            }
        }
        sum
    }
}
