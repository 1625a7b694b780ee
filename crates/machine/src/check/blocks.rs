//! Checks of signals and blocks: names, sizes, limits and loops.

use super::refused;
use crate::description::{Block, BlockInput, Description};
use crate::elements::Element;
use crate::quantity::What;
use crate::refusal::Problem;

/// Largest delay of an output, in samples.
const MOST_UNDER_WAY: usize = 100;
/// Largest number of values kept by all blocks: states, acting outputs, delayed outputs.
const MOST_STATES: usize = 500;

/// Problems of signals and blocks.
pub(super) fn check(machine: &Description, problems: &mut Vec<Problem>) {
    let before = problems.len();
    machine.blocks.iter().for_each(|block| check_block(machine, block, problems));
    for (i, feed) in machine.feeds.iter().enumerate() {
        let is_there = machine.blocks.get(feed.block).is_some_and(|block| feed.output < block.outputs.len());
        // Feeds are in the order of their loads, at most one for each load.
        let is_next = i == 0 || machine.feeds[i - 1].load < feed.load;
        if !is_there || !is_next || feed.load >= machine.loads.len() {
            let text = "no load or output has this index, counted from 0, or the feeds are not in \
                the order of their loads";
            problems.push(Problem::new(format!("feeds[{i}]"), None, text));
        }
    }
    if problems.len() > before {
        return;
    }
    let kept: usize = machine.blocks.iter().map(|block| block.start.len() + block.kept()).sum();
    if kept > MOST_STATES {
        let text = format!(
            "blocks keep {kept} numbers (states, outputs and delayed outputs); expected at most {MOST_STATES}"
        );
        problems.push(Problem::new("block", None, text));
    }
    match machine.output_order() {
        Err(way) => {
            let names: Vec<String> =
                way.iter().chain(&way[..1]).map(|own| machine.name_of_output(*own)).collect();
            let text = format!(
                "an algebraic loop through `d`: {} reads {}; put a state, or a sampled block with a \
                 delay, into the loop",
                names[0],
                names[1..].join(", which reads ")
            );
            problems.push(Problem::new(format!("block.{}.d", machine.blocks[way[0].0].name), None, text));
        }
        Ok(order) => order.into_iter().for_each(|place| check_limited(machine, place, problems)),
    }
}

/// Refuses a limited continuous output that depends on another one at the same instant.
fn check_limited(machine: &Description, place: (usize, usize), problems: &mut Vec<Problem>) {
    let block = &machine.blocks[place.0];
    if block.sampling.is_some() || block.limits[place.1].is_none() {
        return;
    }
    if let Some(other) = machine.limit_behind(place) {
        let text = format!(
            "depends through `d` on {}, which has limits, too; give only one of them limits, put a \
             state between \
             them, or use a sampled block",
            machine.name_of_output(other)
        );
        let name = format!("block.{}.limits.{}", block.name, block.outputs[place.1]);
        problems.push(Problem::new(name, None, text));
    }
}

fn check_block(machine: &Description, block: &Block, problems: &mut Vec<Problem>) {
    let of = format!("block.{}", block.name);
    let (states, inputs, outputs) = (block.start.len(), block.inputs.len(), block.outputs.len());
    let shapes = [
        ("a", &block.a, states, states),
        ("b", &block.b, states, inputs),
        ("c", &block.c, outputs, states),
        ("d", &block.d, outputs, inputs),
    ];
    for (key, rows, count, columns) in shapes {
        if rows.len() != count || rows.iter().any(|row| row.len() != columns) {
            let text = format!("expected a {count} × {columns} matrix (rows × columns)");
            problems.push(Problem::new(format!("{of}.{key}"), None, text));
        }
    }
    let quanta = block.sampling.as_ref().map_or(inputs, |own| own.quanta.len());
    if block.limits.len() != outputs || quanta != inputs || outputs == 0 {
        problems.push(Problem::new(
            &of,
            None,
            "expected at least one output, limits for each output, and a quantum for each input",
        ));
    }
    for (i, input) in block.inputs.iter().enumerate() {
        let has_elongation = |element: Element| element.quantities().contains(&What::E);
        let is_there = match *input {
            BlockInput::Place(body) | BlockInput::Rate(body) => body < machine.bodies.len(),
            BlockInput::Elongation(i) | BlockInput::ElongationRate(i) => {
                machine.elements().nth(i).is_some_and(has_elongation)
            }
            BlockInput::Source(i) => i < machine.sources.len(),
            BlockInput::Output(i, j) => machine.blocks.get(i).is_some_and(|own| j < own.outputs.len()),
        };
        if !is_there {
            let text = "no body, element, signal or output has this index, counted from 0";
            problems.push(Problem::new(format!("{of}.inputs[{i}]"), None, text));
        }
    }
    for (output, limits) in block.outputs.iter().zip(&block.limits) {
        let Some([low, high]) = *limits else { continue };
        if low.is_nan() || high.is_nan() || low >= high {
            let text = format!("must be greater than the lower limit, {low:?}");
            problems.push(refused(format!("{of}.limits.{output}[1]"), high, text));
        }
    }
    if let Some(own) = block.sampling.as_ref().filter(|own| own.delay > own.period * MOST_UNDER_WAY as f64) {
        let text =
            format!("must be at most {MOST_UNDER_WAY} samples, {:?} s", own.period * MOST_UNDER_WAY as f64);
        problems.push(refused(format!("{of}.delay"), own.delay, text));
    }
}

/// Problems of a start at rest with blocks that feed the motion of bodies back to loads.
pub(super) fn at_rest(machine: &Description, problems: &mut Vec<Problem>) {
    if let Some((block, read)) = machine.feedback() {
        let text = format!(
            "cannot be combined with a block that feeds motion back to loads: block.{} reads \
             {read}; give the \
             bodies and the block start values instead",
            block.name
        );
        problems.push(Problem::new("start", Some("\"rest\"".into()), text));
    }
}
