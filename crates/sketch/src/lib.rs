//! Schematic sketch of a machine: bodies in a row along their coordinate, springs as zigzags,
//! dashpots, stops with their gaps, friction, links as bars, loads as arrows, ground hatched.
//! Bodies that feel gravity are above each other, with the floor below. Blocks are boxes at the
//! bottom.
//!
//! ```text
//! description ─▶ connections   elements with their ends
//!             ─▶ order         bodies from left to right
//!             ─▶ blocks        boxes with the names of their signals
//!             ─▶ ways          direction of the row: upright with gravity
//!             ─▶ sorted        elements by region, each an item with its room
//!             ─▶ layout        places of boxes, and of symbols in lanes
//!             ─▶ symbols       marks on the canvas, with boxes and stops, by one hand
//! ```
#![forbid(unsafe_code)]

mod blocks;
mod boxes;
mod connections;
mod flexible;
mod hand;
mod items;
mod lanes;
mod layout;
mod moved;
mod order;
mod print;
mod sizes;
mod sorted;
mod stops;
mod symbols;
mod ways;

use layout::Layout;
pub use print::Printed;
use vibro_figures::canvas::{Canvas, Drawing};
use vibro_machine::Description;

/// The sketch of a machine, a drawing for SVG and PNG ([`vibro_figures::canvas::svg_and_png`]).
///
/// ```
/// use vibro_machine::file::{no_records, parse};
///
/// let text = r#"
///     name = "A"
///     [body.b]
///     mass = 1.0
///     [spring.s]
///     between = ["ground", "b"]
///     stiffness = 1.0
/// "#;
/// let machine = parse(text, "a.toml", &no_records)?;
/// let sketch = vibro_sketch::Sketch::new(&machine);
/// let svg = vibro_figures::canvas::svg(&sketch).expect("all its places are finite");
/// assert!(svg.contains(">b<") && svg.contains(">s<"));
/// # Ok::<(), vibro_machine::Refusal>(())
/// ```
#[derive(Debug)]
pub struct Sketch {
    layout: Layout,
    icon: bool,
}

/// Side of an icon, in units of the drawing.
const ICON: f64 = 1024.0;

impl Sketch {
    /// The sketch with all names.
    pub fn new(machine: &Description) -> Self {
        Self { layout: Layout::new(machine), icon: false }
    }

    /// The sketch of the machine in motion: each body moved along its coordinate by `shift`, and
    /// the plates of each stop `opening` apart; both by name, in units of the drawing.
    ///
    /// ```
    /// use vibro_machine::file::{no_records, parse};
    /// use vibro_figures::canvas::svg;
    ///
    /// let text = "name = \"A\"\nbody.b.mass = 1.0\n\
    ///     spring.s = { between = [\"ground\", \"b\"], stiffness = 1.0 }";
    /// let sketch = vibro_sketch::Sketch::new(&parse(text, "a.toml", &no_records)?);
    /// assert_eq!(sketch.names().collect::<Vec<_>>(), ["b", "s"]);
    /// let moved = sketch.moved(&|body| if body == "b" { 50.0 } else { 0.0 }, &|_| None);
    /// assert_ne!(svg(&moved).ok(), svg(&sketch).ok());
    /// assert_eq!(svg(&sketch.moved(&|_| 0.0, &|_| None)).ok(), svg(&sketch).ok());
    /// # Ok::<(), vibro_machine::Refusal>(())
    /// ```
    #[must_use]
    pub fn moved(&self, shift: &dyn Fn(&str) -> f64, opening: &dyn Fn(&str) -> Option<f64>) -> Self {
        Self { layout: self.layout.moved(shift, opening), icon: self.icon }
    }

    /// Names of the drawn bodies, then of the drawn elements, then of the blocks, in the order of
    /// the item numbers in [`flat`](vibro_figures::canvas::flat()).
    pub fn names(&self) -> impl Iterator<Item = &str> {
        let Layout { bodies, placed, blocks, .. } = &self.layout;
        let elements = placed.iter().map(|placed| placed.name.as_str());
        let bodies = bodies.iter().map(|body| body.name.as_str());
        bodies.chain(elements).chain(blocks.iter().map(|block| block.name.as_str()))
    }

    /// The sketch without names in a square, with heavier strokes.
    pub fn icon(machine: &Description) -> Self {
        Self { layout: Layout::new(machine), icon: true }
    }
}

impl Drawing for Sketch {
    fn size(&self) -> (u32, u32) {
        let (width, height) = if self.icon { (ICON, ICON) } else { (self.layout.width, self.layout.height) };
        (width.ceil() as u32, height.ceil() as u32)
    }

    fn draw(&self, canvas: &mut Canvas) {
        if !self.icon {
            return symbols::draw(canvas, &self.layout, true, 1.0);
        }
        let Layout { width, height, .. } = self.layout;
        let scale = ICON / width.max(height);
        let by = (0.5 * (ICON - scale * width), 0.5 * (ICON - scale * height));
        canvas.moved(by, |canvas| symbols::draw(canvas, &self.layout, false, scale));
    }
}
