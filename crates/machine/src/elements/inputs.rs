//! Names of the inputs of blocks: quantities of bodies and elements, signals, outputs of blocks.

use super::Element;
use crate::description::{Block, BlockInput, Description};
use crate::what::What;
use std::collections::HashSet;

impl BlockInput {
    /// Whether the input depends on coordinates or rates of bodies.
    fn is_of_bodies(&self) -> bool {
        !matches!(self, Self::Source(_) | Self::Output(..))
    }
}

impl Description {
    /// The first block among some that reads a body or an element, with the name of that input.
    fn reads_body(&self, among: impl Fn(usize) -> bool) -> Option<(&Block, String)> {
        let all = self.blocks.iter().enumerate().filter(|own| among(own.0));
        all.map(|own| own.1).find_map(|block| {
            let place = block.inputs.iter().position(BlockInput::is_of_bodies)?;
            Some((block, self.names_of_inputs(block).swap_remove(place)))
        })
    }

    /// The first block through which loads feed back the motion of bodies, with its input's name.
    pub fn feedback(&self) -> Option<(&Block, String)> {
        let mut reached = HashSet::new();
        let mut next: Vec<usize> = self.feeds.iter().map(|feed| feed.block).collect();
        while let Some(block) = next.pop() {
            if reached.insert(block) {
                let inputs = self.blocks.get(block).into_iter().flat_map(|own| &own.inputs);
                next.extend(inputs.filter_map(|own| match *own {
                    BlockInput::Output(block, _) => Some(block),
                    _ => None,
                }));
            }
        }
        self.reads_body(|block| reached.contains(&block))
    }

    /// The names of a block's inputs, as its file writes them.
    pub fn names_of_inputs(&self, block: &Block) -> Vec<String> {
        self.inputs_of(block).0
    }

    /// The names of a block's inputs, as its file writes them, and their SI units.
    pub(crate) fn inputs_of(&self, block: &Block) -> (Vec<String>, Vec<&'static str>) {
        if block.inputs.is_empty() {
            return (Vec::new(), Vec::new());
        }
        let elements: Vec<Element> = self.elements().collect();
        let name = |input: &BlockInput| {
            let of_body = |i: usize, what: What| {
                let body = self.bodies.get(i);
                body.map_or((String::new(), "1"), |own| {
                    (format!("{}.{}", own.name, what.word()), what.unit(own.dimension))
                })
            };
            let of_element = |i: usize, what: What| {
                let element = elements.get(i);
                let named = |own: &Element| {
                    (format!("{}.{}", own.name(), what.word()), what.unit(own.dimension(self)))
                };
                element.map_or((String::new(), "1"), named)
            };
            match *input {
                BlockInput::Place(i) => of_body(i, What::S),
                BlockInput::Rate(i) => of_body(i, What::V),
                BlockInput::Elongation(i) => of_element(i, What::E),
                BlockInput::ElongationRate(i) => of_element(i, What::Rate),
                BlockInput::Source(i) => {
                    (self.sources.get(i).map_or_else(String::new, |own| own.name.clone()), "1")
                }
                BlockInput::Output(i, j) => {
                    let own = self.blocks.get(i).filter(|own| j < own.outputs.len());
                    (own.map_or_else(String::new, |_| self.name_of_output((i, j))), "1")
                }
            }
        };
        block.inputs.iter().map(name).unzip()
    }
}
