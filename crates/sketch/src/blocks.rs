//! Blocks under the machine: a box with its inputs on the left, and its outputs with the loads
//! that follow them on the right. Signals are named instead of connected to the machine by lines.

use crate::connections::number;
use crate::sizes::{ARM_FONT, BESIDE, BODY_FONT, FONT, MARGIN};
use vibro_figures::canvas::text_width;
use vibro_machine::Description;
use vibro_machine::description::Block;

/// Line height of a signal's name.
pub(crate) const LINE: f64 = 50.0;
/// Length of the arrows into and out of a box.
pub(crate) const ARROW: f64 = 90.0;
/// Smallest width and height of a box.
const BOX: (f64, f64) = (190.0, 130.0);
/// Distance between boxes.
const APART: f64 = 36.0;

/// The box of a block with the names of its signals.
#[derive(Clone, Debug)]
pub(crate) struct BlockBox {
    pub name: String,
    /// Time between samples, in words; empty for a continuous block.
    pub sample: String,
    /// The inputs, by line.
    pub reads: Vec<String>,
    /// The outputs, by line.
    pub puts: Vec<String>,
    pub left: f64,
    pub right: f64,
    pub top: f64,
    pub bottom: f64,
}

fn widest<'a>(texts: impl IntoIterator<Item = &'a String>, font: f64) -> f64 {
    texts.into_iter().map(|text| text_width(text, font)).fold(0.0, f64::max)
}

impl BlockBox {
    fn new(machine: &Description, place: usize, block: &Block) -> Self {
        let put = |(output, name): (usize, &String)| {
            let feeds = machine.feeds.iter().filter(|feed| (feed.block, feed.output) == (place, output));
            let loads: Vec<&str> = feeds.map(|feed| machine.loads[feed.load].name.as_str()).collect();
            if loads.is_empty() { name.clone() } else { format!("{name} \u{2192} {}", loads.join(", ")) }
        };
        let sample = block.sampling.as_ref().map(|own| format!("{} ms", number(1e3 * own.period)));
        Self {
            name: block.name.clone(),
            sample: sample.unwrap_or_default(),
            reads: machine.names_of_inputs(block),
            puts: block.outputs.iter().enumerate().map(put).collect(),
            left: 0.0,
            right: (text_width(&block.name, BODY_FONT) + 60.0).max(BOX.0),
            top: 0.0,
            bottom: BOX.1.max(LINE * block.inputs.len().max(block.outputs.len()) as f64),
        }
    }

    /// Widths of the names on both sides with their arrows.
    fn sides(&self) -> [f64; 2] {
        [&self.reads, &self.puts].map(|names| widest(names, FONT) + ARROW + 2.0 * BESIDE)
    }

    /// y coordinate of the middle of a line among `count` lines.
    pub(crate) fn line(&self, line: usize, count: usize) -> f64 {
        0.5 * (self.top + self.bottom) + LINE * (line as f64 - 0.5 * (count as f64 - 1.0))
    }

    /// y coordinates of the middles of the name and of the time between samples.
    pub(crate) fn titles(&self) -> [f64; 2] {
        let middle = 0.5 * (self.top + self.bottom);
        if self.sample.is_empty() { [middle; 2] } else { [middle - 0.45 * ARM_FONT, middle + ARM_FONT] }
    }
}

/// The boxes of a machine's blocks, stacked below `top` in a picture of the given width, and the
/// smallest width that holds them.
pub(crate) fn blocks(machine: &Description, top: f64, width: f64) -> (Vec<BlockBox>, f64) {
    let of = |(place, block): (usize, &Block)| BlockBox::new(machine, place, block);
    let mut all: Vec<BlockBox> = machine.blocks.iter().enumerate().map(of).collect();
    let most = |of: &dyn Fn(&BlockBox) -> f64| all.iter().map(of).fold(0.0, f64::max);
    let before = most(&|own| own.sides()[0]);
    let (own, after) = (most(&|own| own.right), most(&|own| own.sides()[1]));
    let whole = before + own + after;
    let width = width.max(whole + 2.0 * MARGIN);
    let left = 0.5 * (width - whole) + before;
    let mut y = top;
    for block in &mut all {
        (block.left, block.right) = (left, left + own);
        (block.top, block.bottom) = (y, y + block.bottom);
        y = block.bottom + APART;
    }
    (all, width)
}
