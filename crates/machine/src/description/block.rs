//! Named signals and linear blocks: filters, motors, controllers, continuous or sampled.

use super::{Description, Signal};
use std::collections::HashSet;

/// A named signal that blocks read.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// Name, unique among all names but the names of parameters.
    pub name: String,
    /// Signal, dimensionless.
    pub signal: Signal,
}

/// A linear block: x' = a x + b u and y = c x + d u or, sampled, x⁺ = a x + b u.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Block {
    /// Name, unique among all names but the names of parameters.
    pub name: String,
    /// Inputs u.
    pub inputs: Vec<BlockInput>,
    /// States x at time 0.
    pub start: Vec<f64>,
    /// A row for each state, with a column for each state.
    pub a: Vec<Vec<f64>>,
    /// A row for each state, with a column for each input.
    pub b: Vec<Vec<f64>>,
    /// A row for each output, with a column for each state.
    pub c: Vec<Vec<f64>>,
    /// A row for each output, with a column for each input.
    pub d: Vec<Vec<f64>>,
    /// Names of the outputs y.
    pub outputs: Vec<String>,
    /// For each output: lower and upper limit, either of them possibly infinite; `None` without
    /// limits.
    pub limits: Vec<Option<[f64; 2]>>,
    /// Sampling; `None` for a continuous block.
    pub sampling: Option<Sampling>,
}

/// When a sampled block reads its inputs, and when its outputs act.
#[derive(Clone, Debug, PartialEq)]
pub struct Sampling {
    /// Time between samples, s; the first one is at time 0.
    pub period: f64,
    /// Time from a sample until its outputs act, s.
    pub delay: f64,
    /// For each input: the quantum to whose multiples it is rounded; `None` without rounding.
    pub quanta: Vec<Option<f64>>,
}

/// Input of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockInput {
    /// Coordinate of a body or a node, by its index.
    Place(usize),
    /// Rate of a body or a node, by its index.
    Rate(usize),
    /// Elongation of an element, by its index in [`Description::elements`].
    Elongation(usize),
    /// Rate of an elongation, by the element's index.
    ElongationRate(usize),
    /// A signal, by its index in [`Description::sources`].
    Source(usize),
    /// An output of a block, by the indices of block and output.
    Output(usize, usize),
}

/// An output of a block that a load follows, instead of a force of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feed {
    /// Index of the load.
    pub load: usize,
    /// Index of the block.
    pub block: usize,
    /// Index among its outputs.
    pub output: usize,
    /// Force per unit of the output, N or N m.
    pub factor: f64,
}

/// An output of a block: index of the block, and index among its outputs.
pub type OutputPlace = (usize, usize);

impl Sampling {
    /// Largest number of earlier samples whose outputs are delayed and do not act yet.
    pub fn under_way(&self) -> usize {
        let count = self.delay / self.period;
        // A delay of whole periods ends exactly at a sample.
        let near = count.round();
        if (count - near).abs() <= 4.0 * f64::EPSILON * near { near as usize } else { count.ceil() as usize }
    }
}

impl Block {
    /// Whether an output acts at the instant at which its inputs are read.
    fn is_direct(&self) -> bool {
        self.sampling.as_ref().is_none_or(|own| own.delay == 0.0)
    }

    /// Outputs of blocks that an output depends on at the same instant.
    fn read_by(&self, output: usize) -> impl Iterator<Item = OutputPlace> + '_ {
        let pairs = self.inputs.iter().zip(&self.d[output]);
        pairs.filter_map(|(input, &d)| match *input {
            BlockInput::Output(block, output) if d != 0.0 => Some((block, output)),
            _ => None,
        })
    }

    /// Lower and upper limit of an output; infinite if there is none.
    pub(crate) fn limits_of(&self, output: usize) -> [f64; 2] {
        self.limits[output].unwrap_or([f64::NEG_INFINITY, f64::INFINITY])
    }

    /// Count of the values that a sampled block keeps between samples in addition to its states:
    /// outputs that act, and delayed outputs.
    pub(crate) fn kept(&self) -> usize {
        self.sampling.as_ref().map_or(0, |own| self.outputs.len() * (1 + own.under_way()))
    }
}

impl Description {
    /// All outputs of blocks, each after the outputs that it depends on at the same instant.
    ///
    /// # Errors
    /// The outputs in a loop.
    pub(crate) fn output_order(&self) -> Result<Vec<OutputPlace>, Vec<OutputPlace>> {
        let (mut order, mut done, mut way) = (Vec::new(), HashSet::new(), Vec::new());
        for (block, own) in self.blocks.iter().enumerate() {
            for output in 0..own.outputs.len() {
                self.visit((block, output), &mut way, &mut done, &mut order)?;
            }
        }
        Ok(order)
    }

    fn visit(
        &self,
        place: OutputPlace,
        way: &mut Vec<OutputPlace>,
        done: &mut HashSet<OutputPlace>,
        order: &mut Vec<OutputPlace>,
    ) -> Result<(), Vec<OutputPlace>> {
        if done.contains(&place) {
            return Ok(());
        }
        if let Some(first) = way.iter().position(|own| *own == place) {
            return Err(way[first..].to_vec());
        }
        way.push(place);
        let from: Vec<OutputPlace> = self.blocks[place.0].read_by(place.1).collect();
        // A delayed output keeps its value, independently of the present inputs.
        for own in from.into_iter().filter(|own| self.blocks[own.0].is_direct()) {
            self.visit(own, way, done, order)?;
        }
        way.pop();
        done.insert(place);
        order.push(place);
        Ok(())
    }

    /// A limited output of a continuous block on which output `place` depends at the same instant.
    pub(crate) fn limit_behind(&self, place: OutputPlace) -> Option<OutputPlace> {
        let mut next: Vec<OutputPlace> = self.blocks[place.0].read_by(place.1).collect();
        while let Some(own) = next.pop() {
            let block = &self.blocks[own.0];
            match (block.sampling.is_some(), block.limits[own.1].is_some()) {
                (true, _) => {}
                (false, true) => return Some(own),
                (false, false) => next.extend(block.read_by(own.1)),
            }
        }
        None
    }

    /// The finite limits of outputs of continuous blocks, in the order of their stops in the law:
    /// output, and whether it is the upper limit.
    pub fn limits_of_outputs(&self) -> Vec<(OutputPlace, bool)> {
        let order = self.output_order().unwrap_or_default();
        let continuous = order.into_iter().filter(|own| self.blocks[own.0].sampling.is_none());
        let limits = continuous.flat_map(|own| {
            let both = self.blocks[own.0].limits_of(own.1).into_iter().zip([false, true]);
            both.filter(|limit| limit.0.is_finite()).map(move |limit| (own, limit.1))
        });
        limits.collect()
    }

    /// The name of an output, such as `pid.u`.
    pub fn name_of_output(&self, (block, output): OutputPlace) -> String {
        format!("{}.{}", self.blocks[block].name, self.blocks[block].outputs[output])
    }
}
