//! Dependencies of blocks and of loads that follow them.

use super::Structure;
use super::knowns::{Knowns, join, put};
use crate::table::Quantity;
use fmi_doors::DependencyKind::Dependent;
use vibro_assembly::description::BlockInput;
use vibro_assembly::{Element, Quantity as Column, What};

impl Structure<'_> {
    /// The knowns of a load's force.
    pub(super) fn driving(&self, element: Element) -> Knowns {
        let mut knowns = self.signals(element);
        let load = self.machine.loads.iter().position(|own| own.name == element.name());
        let feed = self.machine.feeds.iter().find(|feed| Some(feed.load) == load);
        if let (Some(feed), Element::Load(_)) = (feed, element) {
            let first = self.elements.len() - self.machine.blocks.len();
            join(&mut knowns, &self.of_block(first + feed.block, What::Output(feed.output)), Dependent);
        }
        knowns
    }

    /// The knowns of an output, a state or a state's rate of the block with an index among the
    /// elements.
    pub(super) fn of_block(&self, element: usize, what: What) -> Knowns {
        let mut knowns = Knowns::new();
        let own = element + self.machine.blocks.len() - self.elements.len();
        let block = &self.machine.blocks[own];
        let states = block.start.len();
        match what {
            What::State(_) => self.state(element, what, &mut knowns),
            What::Output(j) if block.sampling.is_some() => {
                self.state(element, What::State(states + j), &mut knowns);
            }
            What::StateRate(_) if block.sampling.is_some() => {}
            _ => self.computed(own, &mut vec![false; self.machine.blocks.len()], &mut knowns),
        }
        knowns
    }

    fn state(&self, element: usize, what: What, knowns: &mut Knowns) {
        let state = Quantity::Column(Column::of_element(element, what));
        put(knowns, self.references[&state], Dependent);
    }

    /// Adds what a continuous block computes from: its states and parameters, and what it reads.
    fn computed(&self, block: usize, seen: &mut [bool], knowns: &mut Knowns) {
        if std::mem::replace(&mut seen[block], true) {
            return;
        }
        let (own, first) = (&self.machine.blocks[block], self.elements.len() - self.machine.blocks.len());
        (0..own.start.len()).for_each(|k| self.state(first + block, What::State(k), knowns));
        self.of_section(&format!("block.{}", own.name), knowns);
        for input in &own.inputs {
            match *input {
                BlockInput::Place(body) => join(knowns, &self.coordinate(body, 0), Dependent),
                BlockInput::Rate(body) => join(knowns, &self.coordinate(body, 1), Dependent),
                BlockInput::Elongation(i) => join(knowns, &self.of_element(self.elements[i], 0), Dependent),
                BlockInput::ElongationRate(i) => {
                    join(knowns, &self.of_element(self.elements[i], 1), Dependent)
                }
                BlockInput::Source(i) => {
                    join(knowns, &self.signals(Element::Source(&self.machine.sources[i])), Dependent);
                }
                BlockInput::Output(other, _) if self.machine.blocks[other].sampling.is_none() => {
                    self.computed(other, seen, knowns);
                }
                BlockInput::Output(other, output) => {
                    join(knowns, &self.of_block(first + other, What::Output(output)), Dependent);
                }
            }
        }
    }

    /// Adds what the numbers of a block depend on when initialization ends: it may have been
    /// sampled.
    pub(super) fn start_of_block(&self, knowns: &mut Knowns) {
        let all = self.parameters.values().flatten();
        all.for_each(|(reference, _)| put(knowns, *reference, Dependent));
        self.inputs.values().for_each(|&input| put(knowns, input, Dependent));
        put(knowns, self.references[&Quantity::Time], Dependent);
    }
}
