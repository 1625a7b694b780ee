//! Linear blocks as rows (docs/assembly-law.md, section 19). Continuous blocks have states of
//! first order. Sampled blocks keep states, outputs that act and outputs under way, as states
//! without a rate, which samples set.

mod samples;
mod sided;

pub use samples::{CombinationTangent, SampleAction, SampleKind, SampledVariation, SamplerTangent};
pub use sided::LimitedValue;

use super::{Elongation, FirstOrder, OutputLimit, Part, StopRows, System};
use crate::description::{Block, BlockInput, DampingLimit, Description, OutputPlace, StopLaw};
use crate::functional::{Functional, StateRow};
use crate::mode::StopState;
use crate::quantity::What;
use nalgebra::{DMatrix, DVector};

/// A combination Σ row · z + Σ factor · max(0, excess of a limit).
#[derive(Clone, Debug)]
pub struct Combination {
    /// The linear part.
    pub row: StateRow,
    /// Indices of limits among the stops, with factors.
    pub beyond: Vec<(usize, f64)>,
}

/// Rows of a block.
#[derive(Clone, Debug)]
pub struct BlockRows {
    /// Inputs u.
    pub inputs: Vec<Combination>,
    /// Outputs y, as their readers see them.
    pub outputs: Vec<Combination>,
    /// Index of the first state in the augmented state.
    pub first: usize,
    /// Number of states.
    pub states: usize,
    /// The samples of a sampled block.
    pub sampler: Option<Sampler>,
}

/// The law of a sampled block at its samples.
#[derive(Clone, Debug)]
pub struct Sampler {
    /// The matrix a of x⁺ = a x + b u.
    pub a: DMatrix<f64>,
    /// The matrix b, by state and input.
    pub b: DMatrix<f64>,
    /// The matrix c of y = c x + d u.
    pub c: DMatrix<f64>,
    /// The matrix d, by output and input.
    pub d: DMatrix<f64>,
    /// Limits of each output; infinite if it has none.
    pub limits: Vec<[f64; 2]>,
    /// Quantum of each input, which is rounded to its multiples; 0 if it is not rounded.
    pub quanta: Vec<f64>,
    /// Whether derivatives ignore the rounding.
    pub varies_rounded: bool,
    /// Time between samples, s.
    pub period: f64,
    /// Time until outputs act, s.
    pub delay: f64,
    /// Largest number of earlier samples whose outputs are under way.
    pub under_way: usize,
}

fn matrix(rows: &[Vec<f64>], columns: usize) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), columns, |i, j| rows[i][j])
}

impl Combination {
    fn of(row: StateRow) -> Self {
        Self { row, beyond: Vec::new() }
    }

    fn add(&mut self, factor: f64, other: &Self) {
        self.row.axpy(factor, &other.row, 1.0);
        self.beyond.extend(other.beyond.iter().map(|&(stop, own)| (stop, factor * own)));
    }

    /// The row while the limits are in these states.
    pub fn row_in(&self, stops: &[StopRows], states: &[StopState]) -> StateRow {
        let mut row = self.row.clone();
        for &(stop, factor) in self.beyond.iter().filter(|own| states[own.0] == StopState::Pressed) {
            row.axpy(factor, &stops[stop].excess, 1.0);
        }
        row
    }

    /// The value of the combination.
    pub fn at(&self, stops: &[StopRows], z: &DVector<f64>) -> f64 {
        let beyond =
            self.beyond.iter().map(|&(stop, own)| own * stops[stop].excess.at(z.as_slice()).max(0.0));
        self.row.dot(z) + beyond.sum::<f64>()
    }
}

impl Sampler {
    fn of(block: &Block) -> Option<Self> {
        let own = block.sampling.as_ref()?;
        let (states, inputs) = (block.start.len(), block.inputs.len());
        Some(Self {
            a: matrix(&block.a, states),
            b: matrix(&block.b, inputs),
            c: matrix(&block.c, states),
            d: matrix(&block.d, inputs),
            limits: (0..block.outputs.len()).map(|j| block.limits_of(j)).collect(),
            quanta: own.quanta.iter().map(|quantum| quantum.unwrap_or(0.0)).collect(),
            varies_rounded: false,
            period: own.period,
            delay: own.delay,
            under_way: own.under_way(),
        })
    }
}

impl BlockRows {
    /// The index of an output in the state: the one that acts, or one under way by its turn.
    pub fn place_of_output(&self, turn: Option<usize>, output: usize) -> usize {
        self.first + self.states + turn.map_or(0, |turn| 1 + turn) * self.outputs.len() + output
    }

    /// The index, among [`kept`](Self::kept), of a state or of an output that acts.
    fn place_among_kept(&self, what: What) -> Option<usize> {
        match what {
            What::State(k) => Some(k),
            What::Output(j) => Some(self.states + j),
            _ => None,
        }
    }

    /// Count of stored values: states, outputs that act, outputs under way.
    pub fn kept(&self) -> usize {
        self.states + self.sampler.as_ref().map_or(0, |own| self.outputs.len() * (1 + own.under_way))
    }
}

/// The number of states of first order of all blocks.
pub(super) fn count(d: &Description) -> usize {
    d.blocks.iter().map(|block| block.start.len() + block.kept()).sum()
}

/// The states of first order of all blocks at time 0, with zeros for outputs.
pub(crate) fn starts(d: &Description) -> impl Iterator<Item = f64> + '_ {
    let of = |block: &Block| block.start.iter().copied().chain(vec![0.0; block.kept()]).collect::<Vec<_>>();
    d.blocks.iter().flat_map(of)
}

impl System {
    /// Adds the blocks, their limits after all stops and corners (for continuous blocks), and the
    /// loads that follow them.
    pub(super) fn add_blocks(&mut self, d: &Description, sources: &[StateRow]) {
        if d.blocks.is_empty() {
            return;
        }
        let mut first = 2 * self.coordinates + self.first_order.len();
        for block in &d.blocks {
            let zero = Combination::of(StateRow::zeros(self.signals.size));
            let outputs = vec![zero; block.outputs.len()];
            let (states, sampler) = (block.start.len(), Sampler::of(block));
            let rows = BlockRows { inputs: Vec::new(), outputs, first, states, sampler };
            first += rows.kept();
            self.blocks.push(rows);
        }
        self.add_outputs(d, sources);
        for block in 0..d.blocks.len() {
            let inputs = d.blocks[block].inputs.iter().map(|input| self.input(d, sources, input)).collect();
            self.blocks[block].inputs = inputs;
            self.add_states(&d.blocks[block], block);
        }
        self.add_block_loads(d);
        for stop in self.first_limit..self.stops.len() {
            let Elongation { w, column, mobility, reach, .. } = self.acting(&self.stops[stop].elongation.w);
            let own = &mut self.stops[stop].elongation;
            (own.w, own.column, own.mobility, own.reach) = (w, column, mobility, reach);
        }
    }

    /// An input as a row; outputs that are not known yet count as zero.
    fn input(&self, d: &Description, sources: &[StateRow], input: &BlockInput) -> Combination {
        let zeros = || StateRow::zeros(self.signals.size);
        let elongation =
            |i: usize| d.elements().nth(i).and_then(|own| own.arms()).map(|arms| self.elongation(arms));
        match *input {
            BlockInput::Place(body) => Combination::of((*self.bodies[body].s).clone()),
            BlockInput::Rate(body) => Combination::of((*self.bodies[body].v).clone()),
            BlockInput::Elongation(i) => {
                Combination::of(elongation(i).map_or_else(zeros, |own| (*own.e).clone()))
            }
            BlockInput::ElongationRate(i) => {
                Combination::of(elongation(i).map_or_else(zeros, |own| (*own.rate).clone()))
            }
            BlockInput::Source(i) => Combination::of(sources[i].clone()),
            BlockInput::Output(block, output) => self.blocks[block].outputs[output].clone(),
        }
    }

    fn unit(&self, place: usize) -> StateRow {
        let mut row = StateRow::zeros(self.signals.size);
        row[place] = 1.0;
        row
    }

    /// Adds the outputs, each after the outputs on which it depends.
    fn add_outputs(&mut self, d: &Description, sources: &[StateRow]) {
        for block in 0..self.blocks.len() {
            for output in 0..self.blocks[block].outputs.len() {
                if self.blocks[block].sampler.is_some() {
                    let held = self.unit(self.blocks[block].place_of_output(None, output));
                    self.blocks[block].outputs[output] = Combination::of(held);
                }
            }
        }
        self.first_limit = self.stops.len();
        let order = d.output_order().unwrap_or_default();
        self.output_order = order.iter().copied().filter(|own| d.blocks[own.0].sampling.is_some()).collect();
        for (block, output) in order {
            let own = &d.blocks[block];
            if own.sampling.is_some() {
                continue;
            }
            let mut sum = Combination::of(StateRow::zeros(self.signals.size));
            for (k, c) in own.c[output].iter().enumerate() {
                sum.row[self.blocks[block].first + k] += c;
            }
            for (input, &factor) in own.inputs.iter().zip(&own.d[output]).filter(|(_, d)| **d != 0.0) {
                sum.add(factor, &self.input(d, sources, input));
            }
            self.blocks[block].outputs[output] = self.limited(d, (block, output), sum);
        }
    }

    /// An output with its limits.
    fn limited(&mut self, d: &Description, (block, output): OutputPlace, own: Combination) -> Combination {
        let Some(limits) = d.blocks[block].limits[output] else { return own };
        let (row, mut limited) = (own.row.clone(), own);
        for (limit, sign) in limits.into_iter().zip([-1.0, 1.0]).filter(|own| own.0.is_finite()) {
            let excess = Functional::of(sign * (&row - &*self.constant(limit)));
            let elongation = self.acting(&Functional::zeros(self.coordinates));
            let law = StopLaw::Compliant { stiffness: 0.0, damping: 0.0, limit: DampingLimit::Pull };
            limited.beyond.push((self.stops.len(), -sign));
            // The force of the stop is the output's excess beyond the limit.
            let (force, spring) = (excess.clone(), excess.clone());
            let limit = Some(OutputLimit { block, output, is_upper: sign > 0.0 });
            let elongation = Elongation { e: excess.clone(), ..elongation };
            self.stops.push(StopRows { force, spring, limit, ..StopRows::new(elongation, excess, law) });
            let element = d.elements().count() - d.blocks.len() + block;
            self.parts[element].push(Part::Stop(self.stops.len() - 1));
        }
        limited
    }

    /// An elongation without rows; its force acts along w.
    fn acting(&self, w: &Functional) -> Elongation {
        let [e, rate, drift] = [(); 3].map(|()| Functional::zeros(self.signals.size));
        self.reaching(e, rate, drift, w.clone())
    }

    /// The states of a block as states of first order.
    fn add_states(&mut self, own: &Block, block: usize) {
        let (first, states, kept) =
            (self.blocks[block].first, self.blocks[block].states, self.blocks[block].kept());
        for k in 0..kept {
            let mut rate = Combination::of(StateRow::zeros(self.signals.size));
            if own.sampling.is_none() && k < states {
                for (j, a) in own.a[k].iter().enumerate() {
                    rate.row[first + j] += a;
                }
                let inputs = self.blocks[block].inputs.iter().zip(&own.b[k]);
                inputs.for_each(|(input, &factor)| rate.add(factor, input));
            }
            for &(stop, factor) in &rate.beyond {
                self.stops[stop].further.push((first + k, -factor));
            }
            self.first_order.push(FirstOrder { rate: Functional::of(rate.row), slider: None });
        }
    }

    /// The forces of loads that follow outputs.
    fn add_block_loads(&mut self, d: &Description) {
        for from in &d.feeds {
            let load = from.load;
            let mut sum = Combination::of(StateRow::zeros(self.signals.size));
            sum.add(from.factor, &self.blocks[from.block].outputs[from.output]);
            for &(stop, factor) in &sum.beyond {
                let weights = -factor * &self.bodies[self.load_bodies[load]].weights;
                let w = &mut self.stops[stop].elongation.w;
                *w = &*w + &weights;
            }
            self.loads[load] = Functional::of(sum.row);
            self.load_limits[load] = sum.beyond;
        }
    }

    /// The force of a load while the limits are in these states.
    pub fn load_row(&self, load: usize, states: &[StopState]) -> StateRow {
        let own = Combination { row: (*self.loads[load]).clone(), beyond: self.load_limits[load].clone() };
        own.row_in(&self.stops, states)
    }

    /// Subtracts the effect of passed limits from the rates of states of first order.
    pub(crate) fn add_limits(&self, states: &[StopState], z: &DVector<f64>, rates: &mut DVector<f64>) {
        for (stop, _) in self.passed_limits(states) {
            let beyond = stop.excess.at(z.as_slice());
            stop.further.iter().for_each(|&(place, by)| rates[place] -= by * beyond);
        }
    }

    /// The limits that outputs have passed, with their indices.
    pub(crate) fn passed_limits<'a>(
        &'a self,
        states: &'a [StopState],
    ) -> impl Iterator<Item = (&'a StopRows, usize)> {
        let passed = |i: &usize| states.get(*i) == Some(&StopState::Pressed);
        (self.first_limit..self.first_freewheel).filter(passed).map(|i| (&self.stops[i], i))
    }

    /// The limits of outputs.
    pub(crate) fn limits(&self) -> impl Iterator<Item = &StopRows> {
        self.stops.iter().filter(|own| own.limit.is_some())
    }

    /// Sets the outputs at time 0 of blocks that read no body: for continuous blocks from their
    /// starts, for sampled blocks without delay from their first sample.
    pub(crate) fn put_out_at_rest(&self, d: &Description, z: &mut StateRow) {
        let Some(first) = self.blocks.first().map(|own| own.first) else { return };
        starts(d).enumerate().for_each(|(k, x)| z[first + k] = x);
        let acts = |own: &BlockRows| own.sampler.as_ref().is_some_and(|own| own.delay == 0.0);
        let sampled = (0..self.blocks.len()).filter(|&block| acts(&self.blocks[block]));
        let action = |block: usize| SampleAction { block, kind: SampleKind::Reads(None) };
        self.sample(&sampled.map(action).collect::<Vec<_>>(), z, &mut []);
    }

    /// Whether a stop is a limit of an output.
    pub(crate) fn is_limit(&self, stop: usize) -> bool {
        self.stops[stop].limit.is_some()
    }

    /// The row of a signal or of a block's output while the limits are in these states, by the
    /// index of the element.
    pub fn block_row(&self, element: usize, what: What, states: &[StopState]) -> StateRow {
        let first = self.parts.len() - self.blocks.len();
        match what {
            What::Output(j) => self.blocks[element - first].outputs[j].row_in(&self.stops, states),
            _ => self.sources[element + self.sources.len() - first].clone(),
        }
    }

    /// The index of a quantity of a sampled block, by its element, among
    /// [`Motion::kept_by_samples`](crate::Motion::kept_by_samples).
    pub fn place_by_samples(&self, element: usize, what: What) -> Option<usize> {
        let own = (element + self.blocks.len()).checked_sub(self.parts.len())?;
        let block = self.blocks.get(own).filter(|block| block.sampler.is_some())?;
        let before = self.blocks[..own].iter().filter(|block| block.sampler.is_some());
        Some(before.map(BlockRows::kept).sum::<usize>() + block.place_among_kept(what)?)
    }

    /// The index of a block's state, by the index of the element.
    pub fn block_place(&self, element: usize, what: What) -> usize {
        let block = &self.blocks[element + self.blocks.len() - self.parts.len()];
        match what {
            What::State(k) | What::StateRate(k) => block.first + k,
            _ => block.first,
        }
    }
}
