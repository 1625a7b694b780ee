//! Blocks: derivatives of their rows by one parameter (docs/assembly-law.md, section 19).

use super::rows::{ElongationTangent, RateTangent, StopTangent};
use super::tangent::Tangent;
use crate::description::{Block, BlockInput, Description};
use crate::functional::StateRow;
use crate::mode::{Mode, StopState};
use crate::system::{CombinationTangent, SamplerTangent, System};
use nalgebra::{DMatrix, DVector};

fn matrix(rows: &[Vec<f64>], columns: usize) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), columns, |i, j| rows[i][j])
}

impl Tangent {
    /// Computes the derivatives of the blocks' rows, and of loads that follow outputs.
    pub(super) fn put_blocks(&mut self, system: &System, d: &Description, along: &Description) {
        if d.blocks.is_empty() {
            return;
        }
        let size = system.signals.size;
        let zero = |count: usize| CombinationTangent { row: StateRow::zeros(size), beyond: vec![0.0; count] };
        let none = |own: &crate::system::BlockRows| {
            own.outputs.iter().map(|output| zero(output.beyond.len())).collect::<Vec<_>>()
        };
        self.blocks.outputs = system.blocks.iter().map(none).collect();
        self.blocks.limits =
            vec![(StateRow::zeros(size), DVector::zeros(system.coordinates)); d.limits_of_outputs().len()];
        for (block, output) in d.output_order().unwrap_or_default() {
            if d.blocks[block].sampling.is_none() {
                self.put_output(system, (d, along), (block, output));
            }
        }
        for (block, own) in d.blocks.iter().enumerate() {
            self.put_states(system, (d, along), block);
            let by = &along.blocks[block];
            self.inner.extend(by.start.iter().copied().chain(vec![0.0; own.kept()]));
        }
        self.blocks.loads = system.load_limits.iter().map(|own| vec![0.0; own.len()]).collect();
        for (feed, by) in d.feeds.iter().zip(&along.feeds) {
            let own = &system.blocks[feed.block].outputs[feed.output];
            let tangent = &self.blocks.outputs[feed.block][feed.output];
            self.loads[feed.load] = by.factor * &own.row + feed.factor * &tangent.row;
            let body = system.load_bodies[feed.load];
            let (weights, turned) = (&system.bodies[body].weights, &self.bodies[body].weights);
            for (k, (&(stop, factor), dfactor)) in own.beyond.iter().zip(&tangent.beyond).enumerate() {
                let moved = by.factor * factor + feed.factor * dfactor;
                self.blocks.loads[feed.load][k] = moved;
                let w = &mut self.blocks.limits[stop - system.first_limit].1;
                w.axpy(-moved, weights, 1.0);
                w.axpy(-feed.factor * factor, turned, 1.0);
            }
        }
    }

    /// The derivative of an input.
    fn input_by(
        &self,
        system: &System,
        (d, along): (&Description, &Description),
        input: &BlockInput,
    ) -> CombinationTangent {
        let row = |row: StateRow| CombinationTangent { row, beyond: Vec::new() };
        let elongation = |i: usize| {
            let both = d
                .elements()
                .nth(i)
                .and_then(|own| own.arms())
                .zip(along.elements().nth(i).and_then(|own| own.arms()));
            both.map(|(own, by)| self.elongation(system, own, by))
        };
        let zeros = || StateRow::zeros(system.signals.size);
        match *input {
            BlockInput::Place(body) => row(self.bodies[body].s.clone()),
            BlockInput::Rate(body) => row(self.bodies[body].v.clone()),
            BlockInput::Elongation(i) => row(elongation(i).map_or_else(zeros, |own| own.e)),
            BlockInput::ElongationRate(i) => row(elongation(i).map_or_else(zeros, |own| own.rate)),
            BlockInput::Source(i) => {
                let rows = &self.signals.rows;
                row(rows[rows.len() - d.sources.len() + i].clone())
            }
            BlockInput::Output(block, output) => self.blocks.outputs[block][output].clone(),
        }
    }

    /// The derivative of a weighted sum of states and inputs, given the factors and their
    /// derivatives.
    fn sum_by(
        &self,
        system: &System,
        (d, along): (&Description, &Description),
        block: usize,
        [states, inputs]: [[&[f64]; 2]; 2],
    ) -> CombinationTangent {
        let (own, rows) = (&d.blocks[block], &system.blocks[block]);
        let mut sum = CombinationTangent { row: StateRow::zeros(system.signals.size), beyond: Vec::new() };
        for (k, by) in states[1].iter().enumerate() {
            sum.row[rows.first + k] += by;
        }
        for (j, input) in own.inputs.iter().enumerate() {
            let (factor, by) = (inputs[0][j], inputs[1][j]);
            let value = &rows.inputs[j];
            // The limits of all inputs are included; `put_output` then drops the limits of inputs
            // that the output does not read.
            let tangent = self.input_by(system, (d, along), input);
            sum.row += by * &value.row + factor * &tangent.row;
            let beyond = value.beyond.iter().zip(&tangent.beyond);
            sum.beyond.extend(beyond.map(|(own, dfactor)| by * own.1 + factor * dfactor));
        }
        sum
    }

    fn put_output(
        &mut self,
        system: &System,
        both: (&Description, &Description),
        (block, output): (usize, usize),
    ) {
        let (own, by) = (&both.0.blocks[block], &both.1.blocks[block]);
        let states = [&own.c[output][..], &by.c[output]];
        let mut sum = self.sum_by(system, both, block, [states, [&own.d[output], &by.d[output]]]);
        let read = own.inputs.iter().enumerate().filter(|(j, _)| own.d[output][*j] == 0.0).map(|(j, _)| j);
        let unread: Vec<usize> = read.collect();
        sum.beyond = self.of_read(system, block, &unread, sum.beyond);
        if let Some(limits) = own.limits[output] {
            let moved = by.limits[output].unwrap_or_default();
            let all = limits.into_iter().zip(moved).zip([-1.0, 1.0]).filter(|own| own.0.0.is_finite());
            let stops = system.blocks[block].outputs[output].beyond.iter().map(|own| own.0);
            for ((((_, moved), sign), stop), _) in all.zip(stops).zip(0..) {
                let mut excess = sign * &sum.row;
                excess[system.signals.one] -= sign * moved;
                self.blocks.limits[stop - system.first_limit].0 = excess;
                sum.beyond.push(0.0);
            }
        }
        self.blocks.outputs[block][output] = sum;
    }

    /// Drops the factors that belong to limits of unread inputs.
    fn of_read(&self, system: &System, block: usize, unread: &[usize], all: Vec<f64>) -> Vec<f64> {
        let inputs = system.blocks[block].inputs.iter().enumerate();
        let is_read = inputs.flat_map(|(j, own)| own.beyond.iter().map(move |_| !unread.contains(&j)));
        all.into_iter().zip(is_read).filter(|own| own.1).map(|own| own.0).collect()
    }

    fn put_states(&mut self, system: &System, both: (&Description, &Description), block: usize) {
        let (own, by): (&Block, &Block) = (&both.0.blocks[block], &both.1.blocks[block]);
        let rows = &system.blocks[block];
        if let Some(sampling) = by.sampling.as_ref().filter(|_| own.sampling.is_some()) {
            let (states, inputs) = (own.start.len(), own.inputs.len());
            let read = own.inputs.iter().map(|input| self.input_by(system, both, input)).collect();
            self.blocks.samplers.push(Some(SamplerTangent {
                a: matrix(&by.a, states),
                b: matrix(&by.b, inputs),
                c: matrix(&by.c, states),
                d: matrix(&by.d, inputs),
                limits: by.limits.iter().map(|own| own.unwrap_or_default()).collect(),
                inputs: read,
                quanta: sampling.quanta.iter().map(|quantum| quantum.unwrap_or(0.0)).collect(),
            }));
            return;
        }
        self.blocks.samplers.push(None);
        for k in 0..rows.states {
            let sum = self.sum_by(system, both, block, [[&own.a[k], &by.a[k]], [&own.b[k], &by.b[k]]]);
            let places = rows.inputs.iter().flat_map(|input| input.beyond.iter().map(|own| own.0));
            self.blocks.rates.push((rows.first + k, sum.row, places.zip(sum.beyond).collect()));
        }
    }

    /// Adds the derivatives of the limits of outputs. In the order of stops they come after the
    /// corners of springs.
    pub(super) fn put_limits(&mut self) {
        for (excess, w) in &self.blocks.limits {
            let zeros = StateRow::zeros(excess.len());
            let elongation =
                ElongationTangent { e: excess.clone(), rate: zeros.clone(), w: w.clone(), drift: zeros };
            let [force, spring] = [excess.clone(), excess.clone()];
            self.stops.push(StopTangent {
                elongation,
                excess: excess.clone(),
                force,
                spring,
                restitution: 0.0,
                release: None,
            });
        }
    }

    /// Returns the derivatives of the rows of blocks' states in a mode, with their places.
    pub(super) fn rates_of_blocks(&self, system: &System, mode: &Mode) -> Vec<(usize, StateRow)> {
        let of = |(place, row, factors): &RateTangent| {
            let mut row = row.clone();
            let is_passed = |stop: &usize| mode.stops[*stop] == StopState::Pressed;
            for &(stop, factor) in factors.iter().filter(|own| is_passed(&own.0)) {
                row.axpy(factor, &system.stops[stop].excess, 1.0);
            }
            for (stop, i) in system.passed_limits(&mode.stops) {
                for &(_, taken) in stop.further.iter().filter(|own| own.0 == *place) {
                    row.axpy(-taken, &self.stops[i].excess, 1.0);
                }
            }
            (*place, row)
        };
        self.blocks.rates.iter().map(of).collect()
    }

    /// Returns the derivative of the row of a source or of a block's output. `element` is the
    /// index of the source or block among all elements.
    pub(super) fn block_row(
        &self,
        system: &System,
        element: usize,
        output: Option<usize>,
        stops: &[StopState],
    ) -> StateRow {
        let first = system.parts.len() - system.blocks.len();
        let Some(output) = output else {
            let rows = &self.signals.rows;
            return rows[rows.len() - system.sources.len() + (element + system.sources.len() - first)]
                .clone();
        };
        let (own, by) =
            (&system.blocks[element - first].outputs[output], &self.blocks.outputs[element - first][output]);
        self.combination(system, (&own.beyond, &by.beyond), by.row.clone(), stops)
    }

    /// Returns the derivative of a load's force in a mode.
    pub(super) fn load_row(&self, system: &System, load: usize, stops: &[StopState]) -> StateRow {
        match self.blocks.loads.get(load) {
            Some(by) => {
                self.combination(system, (&system.load_limits[load], by), self.loads[load].clone(), stops)
            }
            None => self.loads[load].clone(),
        }
    }

    fn combination(
        &self,
        system: &System,
        (beyond, by): (&[(usize, f64)], &[f64]),
        mut row: StateRow,
        stops: &[StopState],
    ) -> StateRow {
        for (&(stop, factor), dfactor) in beyond.iter().zip(by) {
            if stops[stop] == StopState::Pressed {
                row.axpy(*dfactor, &system.stops[stop].excess, 1.0);
                row.axpy(factor, &self.stops[stop].excess, 1.0);
            }
        }
        row
    }
}
