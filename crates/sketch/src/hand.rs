//! The hand that draws: lines, fills and texts at places of the row.

use crate::ways::Way;
use vibro_figures::canvas::palette::BLACK;
use vibro_figures::canvas::{Across, Along, Canvas, CanvasPoint, Colour, Pen, Writing};

/// Distance between strokes of a wall and of a body with prescribed motion.
pub(crate) const HATCH: f64 = 26.0;

/// The canvas, whether names are written, and the scale from the layout to the drawing.
pub(crate) struct Hand<'c> {
    pub canvas: &'c mut Canvas,
    pub named: bool,
    pub scale: f64,
    /// Direction of the row, and its length.
    pub way: Way,
    pub length: f64,
    /// Extension of the current symbol compared with the layout.
    pub stretch: f64,
}

impl Hand<'_> {
    /// Draws marks with `draw`, tagged as one item.
    pub(crate) fn tagged(&mut self, tag: u32, draw: impl FnOnce(&mut Hand<'_>)) {
        let Self { named, scale, way, length, stretch, .. } = *self;
        self.canvas.tagged(tag, |canvas| draw(&mut Hand { canvas, named, scale, way, length, stretch }));
    }

    pub(crate) fn width(&self) -> f64 {
        if self.named { 6.0 } else { 10.0 }
    }

    pub(crate) fn scaled(&self, places: &[CanvasPoint]) -> Vec<CanvasPoint> {
        let points = places.iter().map(|place| self.way.point(*place, self.length));
        points.map(|(x, y)| (self.scale * x, self.scale * y)).collect()
    }

    pub(crate) fn stroke(&mut self, points: &[CanvasPoint], colour: Colour, width: f64) {
        let (points, width) = (self.scaled(points), self.scale * width);
        self.canvas.lines(&[points], Pen::solid(colour, width));
    }

    pub(crate) fn fill(&mut self, corners: &[CanvasPoint], colour: Colour) {
        let corners = self.scaled(corners);
        self.canvas.polygon(&corners, colour, 1.0);
    }

    pub(crate) fn line(&mut self, points: Vec<CanvasPoint>) {
        self.stroke(&points, BLACK, self.width());
    }

    pub(crate) fn thick(&mut self, points: Vec<CanvasPoint>) {
        self.stroke(&points, BLACK, 2.0 * self.width());
    }

    /// Writes at a place of the row, moved by `by` in the picture.
    pub(crate) fn write(&mut self, at: CanvasPoint, by: CanvasPoint, words: &str, size: f64, along: Along) {
        if self.named && !words.is_empty() {
            let at = self.way.point(at, self.length);
            let (at, size) = ((self.scale * (at.0 + by.0), self.scale * (at.1 + by.1)), self.scale * size);
            let writing = Writing { size, colour: BLACK, along, across: Across::Centre, upwards: false };
            self.canvas.text(at, words, &writing);
        }
    }

    /// Draws with `draw` in the coordinates of the picture, not in the row's.
    pub(crate) fn plain(&mut self, draw: impl FnOnce(&mut Self)) {
        let way = std::mem::take(&mut self.way);
        draw(self);
        self.way = way;
    }

    /// An arrowhead with its tip a little beyond `at`.
    pub(crate) fn head(&mut self, at: CanvasPoint, along: CanvasPoint) {
        let size = along.0.hypot(along.1).max(f64::MIN_POSITIVE);
        let (dx, dy) = (along.0 / size, along.1 / size);
        let half = 1.6 * self.width() + 3.0;
        let tip = (at.0 + half * dx, at.1 + half * dy);
        let base = (tip.0 - 2.4 * half * dx, tip.1 - 2.4 * half * dy);
        let corners =
            [tip, (base.0 - half * dy, base.1 + half * dx), (base.0 + half * dy, base.1 - half * dx)];
        self.fill(&corners, BLACK);
    }

    pub(crate) fn arrow(&mut self, from: CanvasPoint, to: CanvasPoint) {
        self.line(vec![from, to]);
        self.head(to, (to.0 - from.0, to.1 - from.1));
    }

    /// A zigzag with `teeth` in the middle of a line.
    pub(crate) fn coil(&mut self, from: f64, to: f64, y: f64, teeth: u32) {
        // The length in the layout plus the stretch.
        let length = (to - from - self.stretch).min(34.0 * f64::from(teeth));
        let length = (length + self.stretch).max(0.2 * length).min(to - from);
        let (first, last) = (0.5 * (from + to - 0.8 * length), 0.5 * (from + to + 0.8 * length));
        let tooth = |i: u32| {
            let side = if i.is_multiple_of(2) { -24.0 } else { 24.0 };
            (first + (last - first) * (f64::from(i) + 0.5) / f64::from(teeth), y + side)
        };
        let mut points = vec![(from, y), (first, y)];
        points.extend((0..teeth).map(tooth));
        points.extend([(last, y), (to, y)]);
        self.line(points);
    }

    /// The middles of a symbol's two halves, which move with its ends.
    pub(crate) fn halves(&self, from: f64, to: f64) -> (f64, f64) {
        let half = 0.5 * (to - from - self.stretch);
        (from + half, to - half)
    }
}
