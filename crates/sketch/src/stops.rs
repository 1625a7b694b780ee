//! Marks of stops. A stop that limits an approach is a nose before a plate, one that limits an
//! extension is two hooks. A compliant stop has a zigzag behind, a rigid plate has strokes.

use crate::hand::Hand;
use vibro_figures::canvas::palette::{BLACK, GREY};

/// Distance between a stop's plates.
const GAP: f64 = 34.0;
/// Half of the width of a thick line, up to which a nose reaches.
const THICK: f64 = 6.0;

impl Hand<'_> {
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

    /// A stop with a nose and a plate that face each other.
    pub(crate) fn plates(&mut self, ends: (f64, f64), y: f64, compliant: bool, opening: Option<f64>) {
        let ((from, to), (left, right)) = (ends, self.met(ends, compliant, opening, 1.0));
        let nose = [(-24.0, -17.0), (-5.0, -17.0), (THICK, -8.0), (THICK, 8.0), (-5.0, 17.0), (-24.0, 17.0)];
        self.line(vec![(from, y), (left - 24.0, y)]);
        self.fill(&nose.map(|(along, across)| (left + along, y + across)), BLACK);
        self.thick(vec![(right, y - 30.0), (right, y + 30.0)]);
        if compliant {
            return self.beside(right, to, y);
        }
        for across in [-26.0, -6.0, 14.0] {
            let stroke = [(right + THICK, y + across), (right + THICK + 18.0, y + across + 14.0)];
            self.stroke(&stroke, GREY, 0.7 * self.width());
        }
        self.line(vec![(right, y), (to, y)]);
    }

    /// A stop with two hooks that catch each other.
    pub(crate) fn hooks(&mut self, ends: (f64, f64), y: f64, compliant: bool, opening: Option<f64>) {
        const ROOT: f64 = 24.0;
        let ((from, to), (far, near)) = (ends, self.met(ends, compliant, opening, -1.0));
        let (first, last) = ((near - ROOT).max(from), (far + ROOT).min(to));
        self.line(vec![(from, y), (first, y), (first, y - 24.0), (far, y - 24.0)]);
        self.thick(vec![(far, y - 24.0), (far, y + 9.0)]);
        self.thick(vec![(near, y + 24.0), (near, y - 9.0)]);
        self.line(vec![(near, y + 24.0), (last, y + 24.0), (last, y)]);
        if compliant { self.beside(last, to, y) } else { self.line(vec![(last, y), (to, y)]) }
    }

    /// The zigzag of a compliant stop behind its plate or hook.
    fn beside(&mut self, from: f64, to: f64, y: f64) {
        let (end, stretch) = (to.min(from + 96.0), self.stretch);
        self.stretch = 0.0;
        self.coil(from, end, y, 3);
        self.stretch = stretch;
        self.line(vec![(end, y), (to, y)]);
    }
}
