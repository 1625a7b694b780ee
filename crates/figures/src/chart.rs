//! Figures as plain data: panels with axes and layers. Layout and style are in `draw`.

pub use crate::canvas::Colour;
use crate::canvas::palette::{CURVES, WHITE};

/// A figure: a title, panels in a grid, and a caption for a text file and for the metadata.
#[derive(Clone, Debug, Default)]
pub struct Figure {
    /// The title.
    pub title: String,
    /// Paragraphs of the caption, which is not drawn: method, parameters and their origin.
    pub caption: Vec<String>,
    /// Panels by rows.
    pub panels: Vec<Panel>,
    /// Number of panels in a row.
    pub columns: usize,
    /// Width and height of a panel in units of the drawing.
    pub panel: (u32, u32),
    /// Whether one legend below all panels replaces the legends of the panels.
    pub shared_legend: bool,
}

/// One diagram.
#[derive(Clone, Debug, Default)]
pub struct Panel {
    /// Title of the panel, with its letter.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Layers; the first is drawn at the bottom.
    pub layers: Vec<Layer>,
}

/// One axis.
#[derive(Clone, Debug, Default)]
pub struct Axis {
    /// Symbol and unit.
    pub label: String,
    /// Its range; if `None`, the range of the data with a margin.
    pub range: Option<(f64, f64)>,
    /// Whether it is logarithmic.
    pub log: bool,
    /// Factor from the data's unit to the label's unit, used for the numbers at the ticks; 1 if
    /// `None`.
    pub factor: Option<f64>,
    /// Names at 1, 2, … instead of numbers.
    pub names: Vec<String>,
    /// Whether it counts something: its ticks are whole numbers.
    pub whole: bool,
}

/// One curve, set of marks or area.
#[derive(Clone, Debug)]
pub struct Layer {
    /// Its name in the legend; `None` if it has no entry there.
    pub name: Option<String>,
    /// A short name next to the curve, in its colour. If there is no room for it, it becomes an
    /// entry of the legend.
    pub label: Option<String>,
    /// Its colour.
    pub colour: Colour,
    /// Whether it is drawn in a pale tint, as a background for another curve of the same colour.
    pub pale: bool,
    /// Its shape.
    pub shape: Shape,
}

/// A polyline.
pub type Path = Vec<(f64, f64)>;

/// Shape of a layer.
#[derive(Clone, Debug)]
pub enum Shape {
    /// Curves.
    Lines {
        /// The connected pieces.
        pieces: Vec<Path>,
        /// Stroke width in units of the drawing.
        width: u32,
        /// Its dashes.
        dash: Dash,
    },
    /// Points.
    Marks {
        /// Their positions.
        points: Path,
        /// Half their size in units of the drawing.
        radius: u32,
        /// Their form.
        mark: Mark,
    },
    /// The area between two curves over x; without points it is only an entry of the legend.
    Band {
        /// x, lower and upper y.
        points: Vec<(f64, f64, f64)>,
        /// Opacity from 0 (invisible) to 1 (opaque).
        opacity: f64,
    },
    /// Cells of equal size in their own colours, rows from below.
    Cells {
        /// Range of x covered.
        x: (f64, f64),
        /// Range of y covered.
        y: (f64, f64),
        /// Number of cells in a row.
        columns: usize,
        /// Index of each cell's colour in `colours`.
        cells: Vec<u8>,
        /// The colours; a cell with `None` is not drawn.
        colours: Vec<Option<Colour>>,
    },
    /// A bar of the colours of cells, in the legend only. The layer's name is the unit, to the
    /// right of the bar.
    Bar {
        /// The colours from left to right.
        colours: Vec<Colour>,
        /// Labels at the ends of the colours: one more than colours.
        limits: Vec<String>,
    },
    /// Text centred at a point.
    Text {
        /// Its position.
        at: (f64, f64),
        /// The text.
        text: String,
    },
}

/// Dashes of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dash {
    /// No dashes.
    Solid,
    /// Long dashes.
    Dashed,
    /// Short dashes.
    Dotted,
}

/// Form of a mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Filled circle.
    Disc,
    /// Empty circle.
    Ring,
    /// Filled square.
    Square,
    /// Filled triangle.
    Triangle,
    /// Oblique cross.
    Cross,
    /// Upright cross.
    Plus,
    /// Filled square on its corner.
    Diamond,
    /// Empty square.
    Frame,
    /// Empty triangle on its tip.
    Funnel,
    /// Upright cross in a circle.
    Target,
}

/// Stroke width of curves in units of the drawing.
pub const LINE: u32 = 6;
/// Stroke width of auxiliary curves.
pub const THIN: u32 = 4;
/// Fraction of white in a pale tint.
const PALE: f64 = 0.55;
/// Half of the size of marks, in units of the drawing.
pub const MARK: u32 = 13;

/// Number of styles of curves.
pub const STYLES: usize = 8;
/// Number of styles with full lines. The others repeat their colours in dashes.
pub const COLOURS: usize = CURVES.len();

/// Colour and dashes of a curve by its number in a panel. Any two styles differ in lightness or in
/// dashes.
pub fn style(number: usize) -> (Colour, Dash) {
    let dash = if (number / COLOURS).is_multiple_of(2) { Dash::Solid } else { Dash::Dashed };
    (CURVES[number % COLOURS], dash)
}

/// Begins the titles of several panels with letters: (a), (b), …
pub fn lettered(panels: &mut [Panel]) {
    if panels.len() > 1 {
        for (letter, panel) in ('a'..='z').zip(panels) {
            panel.title = format!("({letter}) {}", panel.title).trim_end().to_owned();
        }
    }
}

impl Axis {
    /// An axis over its data.
    pub fn new(label: impl Into<String>) -> Self {
        Self { label: label.into(), ..Self::default() }
    }

    /// An axis over a range.
    pub fn over(label: impl Into<String>, from: f64, to: f64) -> Self {
        Self { label: label.into(), range: Some((from, to)), ..Self::default() }
    }

    /// The axis with its numbers in the label's unit: the data's numbers times `factor`.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self { factor: Some(factor), ..self }
    }

    /// An axis of counts over its data, with whole numbers at the ticks.
    pub fn counts(label: impl Into<String>) -> Self {
        Self { label: label.into(), whole: true, ..Self::default() }
    }

    /// A logarithmic axis over its data.
    pub fn log(label: impl Into<String>) -> Self {
        Self { label: label.into(), log: true, ..Self::default() }
    }
}

impl Layer {
    /// A curve of one piece.
    pub fn line(name: &str, colour: Colour, dash: Dash, points: Path) -> Self {
        Self::lines(name, colour, dash, vec![points])
    }

    /// A curve in pieces; with an empty name it has no entry in the legend.
    pub fn lines(name: &str, colour: Colour, dash: Dash, pieces: Vec<Path>) -> Self {
        Self::new(name, colour, Shape::Lines { pieces, width: LINE, dash })
    }

    /// Points.
    pub fn marks(name: &str, colour: Colour, mark: Mark, points: Path) -> Self {
        Self::new(name, colour, Shape::Marks { points, radius: MARK, mark })
    }

    /// An area.
    pub fn band(name: &str, colour: Colour, opacity: f64, points: Vec<(f64, f64, f64)>) -> Self {
        Self::new(name, colour, Shape::Band { points, opacity })
    }

    /// Text.
    pub fn text(at: (f64, f64), text: impl Into<String>, colour: Colour) -> Self {
        Self::new("", colour, Shape::Text { at, text: text.into() })
    }

    /// Any shape; with an empty name it has no entry in the legend.
    pub fn new(name: &str, colour: Colour, shape: Shape) -> Self {
        Self { name: (!name.is_empty()).then(|| name.into()), label: None, colour, pale: false, shape }
    }

    /// The layer with a short name next to its curve.
    #[must_use]
    pub fn labelled(self, label: impl Into<String>) -> Self {
        Self { label: Some(label.into()), ..self }
    }

    /// The layer in a pale tint of its colour.
    #[must_use]
    pub fn pale(self) -> Self {
        Self { pale: true, ..self }
    }

    /// The layer's drawing colour.
    pub fn tint(&self) -> Colour {
        if self.pale { self.colour.towards(WHITE, PALE) } else { self.colour }
    }

    /// Text of its entry in a legend.
    pub(super) fn entry(&self) -> Option<&str> {
        self.label.as_deref().or(self.name.as_deref())
    }

    /// The layer with another stroke width or mark size.
    #[must_use]
    pub fn stroke(mut self, stroke: u32) -> Self {
        match &mut self.shape {
            Shape::Lines { width, .. } => *width = stroke,
            Shape::Marks { radius, .. } => *radius = stroke,
            _ => {}
        }
        self
    }

    /// The points that an axis must cover.
    pub fn extent(&self) -> Vec<(f64, f64)> {
        match &self.shape {
            Shape::Lines { pieces, .. } => pieces.concat(),
            Shape::Marks { points, .. } => points.clone(),
            Shape::Band { points, .. } => points.iter().flat_map(|&(x, a, b)| [(x, a), (x, b)]).collect(),
            Shape::Cells { x, y, .. } => vec![(x.0, y.0), (x.1, y.1)],
            Shape::Bar { .. } | Shape::Text { .. } => Vec::new(),
        }
    }
}
