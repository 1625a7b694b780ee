//! Marks of the symbols of a [`Layout`].

use crate::connections::Symbol;
use crate::items::height_of;
use crate::layout::{Layout, Placed, WALL};
use crate::sizes::{ARM_FONT, BESIDE, FONT, NAME};
use crate::ways::Way;
use vibro_figures::canvas::palette::{BLACK, GREY};
use vibro_figures::canvas::{Across, Along, Canvas, CanvasPoint, Colour, Pen, Writing};

/// Distance between strokes of a wall and of a body with prescribed motion.
pub(crate) const HATCH: f64 = 26.0;
/// Distance between a stop's plates.
const GAP: f64 = 34.0;

/// The canvas, whether names are written, and the scale from the layout to the drawing.
pub(crate) struct Hand<'c> {
    canvas: &'c mut Canvas,
    named: bool,
    scale: f64,
    /// Direction of the row, and its length.
    pub way: Way,
    pub length: f64,
    /// Extension of the current symbol compared with the layout.
    stretch: f64,
}

/// Draws the machine.
pub(crate) fn draw(canvas: &mut Canvas, layout: &Layout, named: bool, scale: f64) {
    let mut hand = Hand { canvas, named, scale, way: layout.way, length: layout.length, stretch: 0.0 };
    layout.walls.iter().for_each(|wall| hand.wall(*wall));
    layout.lines.iter().for_each(|(line, _)| hand.line(line.to_vec()));
    for (tag, body) in (0..).zip(&layout.bodies) {
        hand.tagged(tag, |hand| hand.body(body, layout.top, layout.bottom));
    }
    for (tag, placed) in (layout.bodies.len() as u32..).zip(&layout.placed) {
        hand.tagged(tag, |hand| hand.element(placed));
    }
    let first = layout.bodies.len() + layout.placed.len();
    for (tag, block) in (first as u32..).zip(&layout.blocks) {
        hand.tagged(tag, |hand| hand.plain(|hand| hand.block(block)));
    }
    for (at, text, _) in &layout.texts {
        // Beside the leg, over the box; in an upright row above the leg, beside the box.
        let (by, along) = match layout.way {
            Way::Right => ((10.0, -0.7 * ARM_FONT), Along::Start),
            Way::Down | Way::Up => ((-BESIDE, -0.75 * ARM_FONT), Along::End),
        };
        hand.write(*at, by, text, ARM_FONT, along);
    }
}

impl Hand<'_> {
    /// Draws marks with `draw`, tagged as one item.
    fn tagged(&mut self, tag: u32, draw: impl FnOnce(&mut Hand<'_>)) {
        let Self { named, scale, way, length, stretch, .. } = *self;
        self.canvas.tagged(tag, |canvas| draw(&mut Hand { canvas, named, scale, way, length, stretch }));
    }

    pub(crate) fn width(&self) -> f64 {
        if self.named { 6.0 } else { 10.0 }
    }

    fn scaled(&self, places: &[CanvasPoint]) -> Vec<CanvasPoint> {
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

    /// Draws with `draw` in the coordinates of the picture instead of those of the row.
    pub(crate) fn plain(&mut self, draw: impl FnOnce(&mut Self)) {
        let way = std::mem::take(&mut self.way);
        draw(self);
        self.way = way;
    }

    /// The name of an element and its lever arms.
    fn texts(&mut self, placed: &Placed) {
        let Placed { from, to, y, symbol, ref name, ref arms, .. } = *placed;
        let half = 0.5 * height_of(symbol);
        // A load's arrow is at the end of its lane, and so is the name, away from ground.
        let load = symbol.is_none();
        let middle = if load { to - 65.0 } else { 0.5 * (from + to) };
        if self.way.is_upright() {
            self.write((middle, y + half), (BESIDE, 0.0), name, FONT, Along::Start);
            for (arm, end) in arms.iter().zip([from + 28.0, to - 28.0]) {
                let arm = arm.as_deref().unwrap_or_default();
                self.write((end, y), (BESIDE, 0.0), arm, ARM_FONT, Along::Start);
            }
            return;
        }
        let (place, along) = if load { (to - BESIDE, Along::End) } else { (middle, Along::Middle) };
        self.write((place, y - half - 0.42 * NAME), (0.0, 0.0), name, FONT, along);
        for (arm, (end, along)) in arms.iter().zip([(from + 12.0, Along::Start), (to - 12.0, Along::End)]) {
            let arm = arm.as_deref().unwrap_or_default();
            self.write((end, y + 0.8 * ARM_FONT), (0.0, 0.0), arm, ARM_FONT, along);
        }
    }

    /// A wall at `x`, with strokes behind it.
    fn wall(&mut self, (x, top, bottom, right): (f64, f64, f64, bool)) {
        self.thick(vec![(x, top), (x, bottom)]);
        let out = if right { WALL - 6.0 } else { 6.0 - WALL };
        let strokes = ((bottom - top) / HATCH).floor().max(1.0) as usize;
        for k in 0..strokes {
            let y = top + (bottom - top) * (k as f64 + 0.2) / strokes as f64;
            self.stroke(&[(x, y), (x + out, y + 0.8 * out.abs())], GREY, 0.7 * self.width());
        }
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

    fn element(&mut self, placed: &Placed) {
        let Placed { from, to, y, faces, opening, stretch, .. } = *placed;
        self.stretch = stretch;
        let middle = 0.5 * (from + to);
        self.texts(placed);
        match placed.symbol {
            Some(
                symbol @ (Symbol::Spring { zigzag: true, dashpot: true, .. }
                | Symbol::Series { dashpot: true, .. }),
            ) => {
                let (upper, lower) = (y - 34.0, y + 34.0);
                let [left, right] = [0, 1].map(|end| 26.0 + self.way.room_of(placed.arms[end].as_deref()));
                let ends = (from + left, to - right);
                self.line(vec![(from, y), (ends.0, y)]);
                self.line(vec![(ends.1, y), (to, y)]);
                self.line(vec![(ends.0, upper), (ends.0, lower)]);
                self.line(vec![(ends.1, upper), (ends.1, lower)]);
                match symbol {
                    Symbol::Series { slides, .. } => self.series(ends.0, ends.1, upper, slides),
                    Symbol::Spring { curved: true, .. } => {
                        self.zigzag(ends.0, ends.1, upper);
                        self.across(middle, upper);
                    }
                    _ => self.zigzag(ends.0, ends.1, upper),
                }
                self.dashpot(ends.0, ends.1, lower);
            }
            Some(Symbol::Series { slides, .. }) => self.series(from, to, y, slides),
            Some(Symbol::Spring { zigzag, curved, .. }) => {
                if zigzag {
                    self.zigzag(from, to, y);
                } else {
                    self.dashpot(from, to, y);
                }
                if curved {
                    self.across(middle, y);
                }
            }
            Some(Symbol::Stop { compliant, curved }) => {
                match faces {
                    true => self.plates((from, to), y, compliant, opening),
                    false => self.clasp((from, to), y, compliant, opening),
                }
                if curved {
                    self.across(middle, y);
                }
            }
            Some(Symbol::Friction) => self.bars(from, to, y, 60.0),
            Some(Symbol::Freewheel) => self.ratchet(from, to, y, faces),
            Some(Symbol::Link) => {
                self.thick(vec![(from, y), (to, y)]);
                let (ends, radius) = (self.scaled(&[(from, y), (to, y)]), 2.2 * self.scale * self.width());
                self.canvas.circles(&ends, radius, BLACK, None);
            }
            None => self.arrow((to - 130.0, y), (to - 2.0 * self.width() - 3.0, y)),
        }
    }

    /// The arrow across a symbol whose law is curved.
    fn across(&mut self, x: f64, y: f64) {
        self.arrow((x - 40.0, y + 24.0), (x + 36.0, y - 18.0));
    }

    fn zigzag(&mut self, from: f64, to: f64, y: f64) {
        self.coil(from, to, y, 6);
    }

    /// A zigzag with `teeth` in the middle of a line.
    fn coil(&mut self, from: f64, to: f64, y: f64, teeth: u32) {
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

    /// A short zigzag in series with a dashpot or a slider; each takes half of the stretch.
    fn series(&mut self, from: f64, to: f64, y: f64, slides: bool) {
        let (middle, stretch) = (0.5 * (from + to), self.stretch);
        self.stretch = 0.5 * stretch;
        self.coil(from, middle, y, 3);
        if slides {
            self.bars(middle, to, y, 40.0)
        } else {
            self.dashpot(middle, to, y)
        }
        self.stretch = stretch;
    }

    /// The middles of a symbol's two halves, which move with its ends.
    fn halves(&self, from: f64, to: f64) -> (f64, f64) {
        let half = 0.5 * (to - from - self.stretch);
        (from + half, to - half)
    }

    /// Two bars in sliding contact, each extending to `half` beyond the middle.
    fn bars(&mut self, from: f64, to: f64, y: f64, half: f64) {
        let (left, right) = self.halves(from, to);
        self.line(vec![(from, y), (left - half, y), (left - half, y - 9.0)]);
        self.thick(vec![(left - half - 2.0, y - 9.0), (left + half - 16.0, y - 9.0)]);
        self.thick(vec![(right - half + 16.0, y + 9.0), (right + half + 2.0, y + 9.0)]);
        self.line(vec![(right + half, y + 9.0), (right + half, y), (to, y)]);
    }

    /// A pawl of the left end on the teeth of the right end. It prevents separation, or approach
    /// if both ends `face` each other.
    fn ratchet(&mut self, from: f64, to: f64, y: f64, face: bool) {
        const TOOTH: f64 = 24.0;
        let (first, base) = (0.5 * (from + to) - 2.0 * TOOTH, y + 12.0);
        let mut teeth = vec![(first, base)];
        for i in 0..4 {
            let x = first + TOOTH * f64::from(i);
            let top = if face { x } else { x + TOOTH };
            teeth.extend([(top, base - 14.0), (x + TOOTH, base)]);
        }
        teeth.extend([(first + 4.0 * TOOTH, y), (to, y)]);
        self.line(teeth);
        let (way, tip) = if face { (-1.0, 2.0 * TOOTH - 3.0) } else { (1.0, TOOTH + 3.0) };
        let (tip, above) = ((first + tip, base - 5.0), y - 26.0);
        let hinge = (tip.0 + 1.9 * TOOTH * way, above);
        self.line(vec![(from, y), (first - 12.0, y), (first - 12.0, above), hinge]);
        self.thick(vec![hinge, tip]);
    }

    /// The zigzag of a compliant stop behind its plate.
    fn beside(&mut self, from: f64, to: f64, y: f64) {
        let (end, stretch) = (to.min(from + 96.0), self.stretch);
        self.stretch = 0.0;
        self.coil(from, end, y, 3);
        self.stretch = stretch;
        self.line(vec![(end, y), (to, y)]);
    }

    fn dashpot(&mut self, from: f64, to: f64, y: f64) {
        let (rod, cup) = self.halves(from, to);
        let (left, right, half) = (cup - 40.0, cup + 40.0, 24.0);
        let piston = rod.clamp(left + 6.0, right - 6.0);
        self.line(vec![(from, y), (piston, y)]);
        self.line(vec![(piston, y - 0.65 * half), (piston, y + 0.65 * half)]);
        self.line(vec![(left, y - half), (right, y - half), (right, y + half), (left, y + half)]);
        self.line(vec![(right, y), (to, y)]);
    }

    /// Positions of the first plate, which moves with the left end, and of its counterpart; a stop
    /// is open between them.
    fn met(&self, (from, to): (f64, f64), compliant: bool, opening: Option<f64>, way: f64) -> (f64, f64) {
        let (left, right) = self.halves(from, to);
        let off = if compliant { 48.0 } else { 0.0 };
        let plate = left - off - 0.5 * way * GAP;
        let rest = right - off + 0.5 * way * GAP;
        let room = if way > 0.0 { to - 30.0 - plate } else { plate - from - 12.0 };
        (plate, opening.map_or(rest, |open| plate + way * open.clamp(0.0, room.max(0.0))))
    }

    /// A stop with two facing plates.
    fn plates(&mut self, ends: (f64, f64), y: f64, compliant: bool, opening: Option<f64>) {
        let ((from, to), (left, right)) = (ends, self.met(ends, compliant, opening, 1.0));
        self.line(vec![(from, y), (left, y)]);
        self.thick(vec![(left, y - 30.0), (left, y + 30.0)]);
        self.thick(vec![(right, y - 30.0), (right, y + 30.0)]);
        if compliant { self.beside(right, to, y) } else { self.line(vec![(right, y), (to, y)]) }
    }

    /// A stop with a plate behind the lips of a bracket.
    fn clasp(&mut self, ends: (f64, f64), y: f64, compliant: bool, opening: Option<f64>) {
        let ((from, to), (plate, lip)) = (ends, self.met(ends, compliant, opening, -1.0));
        let back = (lip + 1.9 * GAP).max(plate + 0.9 * GAP);
        self.line(vec![(from, y), (plate, y)]);
        self.thick(vec![(plate, y - 17.0), (plate, y + 17.0)]);
        for side in [-1.0, 1.0] {
            let (inner, outer) = (y + 12.0 * side, y + 32.0 * side);
            self.line(vec![(lip, inner), (lip, outer), (back, outer), (back, y)]);
        }
        if compliant { self.beside(back, to, y) } else { self.line(vec![(back, y), (to, y)]) }
    }
}
