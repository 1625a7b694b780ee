//! Marks of the symbols of a [`Layout`].

use crate::connections::Symbol;
use crate::hand::{HATCH, Hand};
use crate::items::height_of;
use crate::layout::{Layout, Placed, WALL};
use crate::sizes::{ARM_FONT, BESIDE, FONT, NAME};
use crate::ways::Way;
use vibro_figures::canvas::palette::{BLACK, GREY};
use vibro_figures::canvas::{Along, Canvas};

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
        // Right of the leg, over the box; in an upright row above the leg, left of the box.
        let (by, along) = match layout.way {
            Way::Right => ((10.0, -0.7 * ARM_FONT), Along::Start),
            Way::Down | Way::Up => ((-BESIDE, -0.75 * ARM_FONT), Along::End),
        };
        hand.write(*at, by, text, ARM_FONT, along);
    }
}

impl Hand<'_> {
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
                    false => self.hooks((from, to), y, compliant, opening),
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

    fn dashpot(&mut self, from: f64, to: f64, y: f64) {
        let (rod, cup) = self.halves(from, to);
        let (left, right, half) = (cup - 40.0, cup + 40.0, 24.0);
        let piston = rod.clamp(left + 6.0, right - 6.0);
        self.line(vec![(from, y), (piston, y)]);
        self.line(vec![(piston, y - 0.65 * half), (piston, y + 0.65 * half)]);
        self.line(vec![(left, y - half), (right, y - half), (right, y + half), (left, y + half)]);
        self.line(vec![(right, y), (to, y)]);
    }
}
