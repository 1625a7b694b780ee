//! Marks of the boxes of bodies and blocks.

use crate::blocks::{ARROW, BlockBox};
use crate::hand::{HATCH, Hand};
use crate::layout::{BodyBox, MARK};
use crate::sizes::{ARM_FONT, BESIDE, BODY_FONT, FONT};
use std::f64::consts::PI;
use vibro_figures::canvas::palette::{GREY, WHITE};
use vibro_figures::canvas::{Along, CanvasPoint, Colour, text_width};

/// Fill of bodies.
const BODY: Colour = Colour(214, 226, 242);

impl Hand<'_> {
    /// The box of a body across the row from `top` to `bottom`, in the coordinates of the picture.
    pub(crate) fn body(&mut self, body: &BodyBox, top: f64, bottom: f64) {
        let upright = self.way.is_upright();
        let ends = [(body.left, top), (body.right, bottom)].map(|end| self.way.point(end, self.length));
        let [left, right] = [ends[0].0.min(ends[1].0), ends[0].0.max(ends[1].0)];
        let [top, bottom] = [ends[0].1.min(ends[1].1), ends[0].1.max(ends[1].1)];
        self.plain(|hand| {
            let (fill, high) = match (body.prescribed, upright) {
                (false, _) => (BODY, None),
                (true, true) => (WHITE, Some(32.0)),
                (true, false) => (WHITE, Some(44.0)),
            };
            hand.rectangle([left, top, right, bottom], fill, high);
            let (x, y) = (0.5 * (left + right), 0.5 * (top + bottom));
            hand.write((x, y), (0.0, 0.0), &body.name, BODY_FONT, Along::Middle);
            if upright {
                hand.mark_beside(body, (x + 0.5 * text_width(&body.name, BODY_FONT) + 0.5 * MARK, y));
            } else {
                hand.marks(body, (x, y));
            }
        });
    }

    /// A rectangle, with strokes of the height `hatched` at its upper and lower edge.
    fn rectangle(&mut self, [left, top, right, bottom]: [f64; 4], fill: Colour, hatched: Option<f64>) {
        let corners = [(left, top), (right, top), (right, bottom), (left, bottom)];
        self.fill(&corners, fill);
        if let Some(high) = hatched {
            for (from, to) in [(top, top + high), (bottom - high, bottom)] {
                let strokes = ((right - left) / HATCH).floor() as usize;
                for k in 0..strokes {
                    let x = left + (right - left) * k as f64 / strokes as f64;
                    let end = (x + 0.8 * (right - left) / strokes as f64).min(right);
                    self.stroke(&[(x, to), (end, from)], GREY, 0.7 * self.width());
                }
            }
        }
        self.line(vec![corners[0], corners[1], corners[2], corners[3], corners[0]]);
    }

    /// Rotation, prescribed motion and gravity over and under the name, for a row to the right.
    fn marks(&mut self, body: &BodyBox, (x, y): CanvasPoint) {
        let BodyBox { prescribed, rotates, gravity, .. } = *body;
        let over = y - 0.9 * BODY_FONT;
        match (rotates, prescribed) {
            (true, _) => self.turn((x, over)),
            (false, true) => {
                self.arrow((x, over), (x - 50.0, over));
                self.arrow((x, over), (x + 50.0, over));
            }
            (false, false) => {}
        }
        if gravity != 0.0 {
            let under = y + 0.95 * BODY_FONT;
            let half = 32.0 * gravity.signum();
            self.arrow((x - half - 16.0, under), (x + half - 16.0, under));
            self.write((x + 52.0, under), (0.0, 0.0), "g", ARM_FONT, Along::Middle);
        }
    }

    /// Rotation, prescribed motion or gravity to the right of the name, for an upright row.
    fn mark_beside(&mut self, body: &BodyBox, (x, y): CanvasPoint) {
        let BodyBox { prescribed, rotates, gravity, .. } = *body;
        match (rotates, prescribed) {
            (true, _) => self.turn((x + 20.0, y)),
            (false, true) => {
                self.arrow((x, y), (x, y - 22.0));
                self.arrow((x, y), (x, y + 22.0));
            }
            (false, false) if gravity != 0.0 => {
                self.arrow((x - 8.0, y - 30.0), (x - 8.0, y + 20.0));
                self.write((x + 20.0, y), (0.0, 0.0), "g", ARM_FONT, Along::Middle);
            }
            (false, false) => {}
        }
    }

    pub(crate) fn block(&mut self, block: &BlockBox) {
        let BlockBox { left, right, top, bottom, .. } = *block;
        self.rectangle([left, top, right, bottom], WHITE, None);
        let (x, [name, sample]) = (0.5 * (left + right), block.titles());
        self.write((x, name), (0.0, 0.0), &block.name, BODY_FONT, Along::Middle);
        self.write((x, sample), (0.0, 0.0), &block.sample, ARM_FONT, Along::Middle);
        let tip = 2.0 * self.width() + 3.0;
        for (i, read) in block.reads.iter().enumerate() {
            let y = block.line(i, block.reads.len());
            self.arrow((left - ARROW, y), (left - tip, y));
            self.write((left - ARROW - BESIDE, y), (0.0, 0.0), read, FONT, Along::End);
        }
        for (i, put) in block.puts.iter().enumerate() {
            let y = block.line(i, block.puts.len());
            self.arrow((right, y), (right + ARROW - tip, y));
            self.write((right + ARROW + BESIDE, y), (0.0, 0.0), put, FONT, Along::Start);
        }
    }

    /// The arc that marks a rotating body.
    fn turn(&mut self, (x, y): CanvasPoint) {
        let at = |k: u32| {
            let angle = PI * (1.15 + 0.65 * f64::from(k) / 12.0);
            (x + 46.0 * angle.cos(), y + 22.0 + 46.0 * angle.sin())
        };
        self.line((0..=12).map(at).collect());
        let (end, before) = (at(12), at(11));
        self.head(end, (end.0 - before.0, end.1 - before.1));
    }
}
