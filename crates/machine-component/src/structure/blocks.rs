//! Dependencies of blocks and of loads that follow them.

use super::Structure;
use super::knowns::{Knowns, join, put};
use crate::table::Quantity;
use fmi_doors::DependencyKind::Dependent;
use vibro_machine::description::BlockInput;
use vibro_machine::{Element, Quantity as Column, What};

impl Structure<'_> {
    /// Returns the knowns of a load's force.
    pub(super) fn driving(&self, element: Element) -> Knowns {
        let mut knowns = self.signals(element);
        let load = self.machine.loads.iter().position(|own| own.name == element.name());
        let feed = self.machine.feeds.iter().find(|feed| Some(feed.load) == load);
        if let (Some(feed), Element::Load(_)) = (feed, element) {
            let first = self.elements.len() - self.machine.blocks.len();
            join(&mut knowns, &self.seen_output(first + feed.block, feed.output), Dependent);
        }
        knowns
    }

    /// Returns the knowns of an output, a state or a state's rate of a block, by its index among
    /// the elements. A sample sets these values of a sampled block from its states and inputs.
    pub(super) fn of_block(&self, element: usize, what: What) -> Knowns {
        let mut knowns = Knowns::new();
        let own = element + self.machine.blocks.len() - self.elements.len();
        let block = &self.machine.blocks[own];
        match what {
            What::State(_) if block.sampling.is_none() => self.state(element, what, &mut knowns),
            _ if block.sampling.is_some() => {
                (0..block.start.len()).for_each(|k| self.state(element, What::State(k), &mut knowns));
                self.of_section(&format!("block.{}", block.name), &mut knowns);
                self.read(own, &mut vec![false; self.machine.blocks.len()], &mut knowns);
                put(&mut knowns, self.references[&Quantity::Time], Dependent);
            }
            _ => self.computed(own, &mut vec![false; self.machine.blocks.len()], &mut knowns),
        }
        knowns
    }

    /// Returns the knowns of an output as loads and other blocks see it: a sampled output is held.
    fn seen_output(&self, element: usize, output: usize) -> Knowns {
        let block = &self.machine.blocks[element + self.machine.blocks.len() - self.elements.len()];
        let mut knowns = Knowns::new();
        match block.sampling {
            Some(_) => self.state(element, What::State(block.start.len() + output), &mut knowns),
            None => knowns = self.of_block(element, What::Output(output)),
        }
        knowns
    }

    fn state(&self, element: usize, what: What, knowns: &mut Knowns) {
        let state = Quantity::Column(Column::of_element(element, what));
        put(knowns, self.references[&state], Dependent);
    }

    /// Adds a continuous block's states and parameters, and the knowns of its inputs.
    fn computed(&self, block: usize, seen: &mut [bool], knowns: &mut Knowns) {
        if std::mem::replace(&mut seen[block], true) {
            return;
        }
        let (own, first) = (&self.machine.blocks[block], self.elements.len() - self.machine.blocks.len());
        (0..own.start.len()).for_each(|k| self.state(first + block, What::State(k), knowns));
        self.of_section(&format!("block.{}", own.name), knowns);
        self.read(block, seen, knowns);
    }

    /// Adds the knowns of a block's inputs.
    fn read(&self, block: usize, seen: &mut [bool], knowns: &mut Knowns) {
        let first = self.elements.len() - self.machine.blocks.len();
        for input in &self.machine.blocks[block].inputs {
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
                    join(knowns, &self.seen_output(first + other, output), Dependent);
                }
            }
        }
    }

    /// Adds the knowns of a block's states when initialization ends: the block may have been
    /// sampled.
    pub(super) fn start_of_block(&self, knowns: &mut Knowns) {
        let all = self.parameters.values().flatten();
        all.for_each(|(reference, _)| put(knowns, *reference, Dependent));
        self.inputs.values().for_each(|&input| put(knowns, input, Dependent));
        put(knowns, self.references[&Quantity::Time], Dependent);
    }
}
