//! The sketch of a machine as an engineer draws it: bodies in a row along their coordinate, springs as zigzags, dashpots, stops with
//! their gaps, friction, links as bars, loads as arrows, ground hatched.
//!
//! ```text
//! description ─▶ connections (what each element ties together) ─▶ order (of the bodies) ─▶ layout (places) ─▶ symbols (marks)
//! ```
#![forbid(unsafe_code)]

mod connections;
mod layout;
mod order;
mod symbols;

use layout::Layout;
use vibro_assembly::Description;
use vibro_figures::canvas::{Canvas, Drawing};

/// The sketch of a machine, to be drawn as SVG or PNG ([`vibro_figures::canvas::svg_and_png`]).
///
/// ```
/// let text = "name = \"A\"\n[body.b]\nmass = 1.0\n[spring.s]\nbetween = [\"ground\", \"b\"]\nstiffness = 1.0\n";
/// let machine = vibro_assembly::file::parse(text, "a.toml", &vibro_assembly::file::no_records)?;
/// let svg = vibro_figures::canvas::svg(&vibro_sketch::Sketch::new(&machine)).expect("all its places are finite");
/// assert!(svg.contains(">b<") && svg.contains(">s<"));
/// # Ok::<(), vibro_assembly::Refusal>(())
/// ```
#[derive(Debug)]
pub struct Sketch {
    layout: Layout,
    named: bool,
    /// Side of the square in whose middle it stands, for an icon.
    square: Option<f64>,
}

impl Sketch {
    /// The sketch with all names.
    pub fn new(machine: &Description) -> Self {
        Self { layout: Layout::new(machine), named: true, square: None }
    }

    /// The sketch without names in a square, with heavier strokes.
    pub fn icon(machine: &Description) -> Self {
        let layout = Layout::new(machine);
        let square = Some(layout.width.max(layout.height));
        Self { layout, named: false, square }
    }
}

impl Drawing for Sketch {
    fn size(&self) -> (u32, u32) {
        let (width, height) = match self.square {
            Some(side) => (side, side),
            None => (self.layout.width, self.layout.height),
        };
        (width.ceil() as u32, height.ceil() as u32)
    }

    fn draw(&self, canvas: &mut Canvas) {
        let Layout { width, height, .. } = self.layout;
        let by = self.square.map_or((0.0, 0.0), |side| (0.5 * (side - width), 0.5 * (side - height)));
        canvas.moved(by, |canvas| symbols::draw(canvas, &self.layout, self.named));
    }
}
