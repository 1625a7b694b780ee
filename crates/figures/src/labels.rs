//! Placement of names next to curves.

use crate::canvas::{CanvasPoint, Colour, text_width};
use crate::scale::Frame;
use crate::symbols::SMALL;

/// Side of a square of the map, in units of the drawing.
const SQUARE: f64 = 8.0;
/// Smallest distance of a name from anything drawn (`AIR`), and from a curve of another colour
/// (`APART`), so that it is not read as this curve's name.
const AIR: f64 = 6.0;
const APART: f64 = 26.0;
/// Distance between positions along a curve at which a name is tried.
const STEP: f64 = 12.0;
/// Largest number of tried positions along a curve.
const TRIES: f64 = 2000.0;
/// Largest number of tried pieces of a curve, the longest first.
const MOST_PIECES: usize = 5;
/// Height of a name's box.
const HEIGHT: f64 = 1.1 * SMALL;

/// Cover of a square of the map: free, one colour, or several.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Cover {
    Free,
    One(Colour),
    Mixed,
}

/// Map of the free and covered squares of a panel.
pub(super) struct Room {
    frame: Frame,
    columns: usize,
    squares: Vec<Cover>,
}

impl Room {
    pub fn new(frame: Frame) -> Self {
        let count = |from: f64, to: f64| ((to - from) / SQUARE).ceil().max(1.0) as usize;
        let (columns, rows) = (count(frame.left, frame.right), count(frame.top, frame.bottom));
        Self { frame, columns, squares: vec![Cover::Free; columns * rows] }
    }

    /// Indices of the squares that a rectangle touches.
    fn touched(&self, area: &Frame) -> impl Iterator<Item = usize> + use<> {
        let rows = self.squares.len() / self.columns;
        let span = |low: f64, high: f64, origin: f64, count: usize| {
            let index = |v: f64| ((v - origin) / SQUARE).floor().clamp(0.0, count as f64 - 1.0) as usize;
            index(low)..=index(high)
        };
        let across = span(area.left, area.right, self.frame.left, self.columns);
        let columns = self.columns;
        span(area.top, area.bottom, self.frame.top, rows)
            .flat_map(move |row| across.clone().map(move |column| row * columns + column))
    }

    /// Marks a rectangle as covered by something of a colour.
    pub fn cover(&mut self, area: &Frame, colour: Colour) {
        for i in self.touched(area) {
            let square = &mut self.squares[i];
            *square = match *square {
                Cover::Free => Cover::One(colour),
                Cover::One(other) if other == colour => Cover::One(colour),
                _ => Cover::Mixed,
            };
        }
    }

    /// Marks the squares along a curve.
    pub fn cover_path(&mut self, path: &[CanvasPoint], colour: Colour) {
        for (x, y) in along(path, 0.5 * SQUARE) {
            self.cover(&Frame { left: x, top: y, right: x, bottom: y }, colour);
        }
    }

    fn has_room(&self, name: &Frame, colour: Colour) -> bool {
        let f = &self.frame;
        let near = name.grown(AIR);
        near.left > f.left
            && near.right < f.right
            && near.top > f.top
            && near.bottom < f.bottom
            && self.touched(&near).all(|i| self.squares[i] == Cover::Free)
            && self
                .touched(&name.grown(APART))
                .all(|i| matches!(self.squares[i], Cover::Free) || self.squares[i] == Cover::One(colour))
    }

    /// Centre of a name next to its curve; marks the name's area as covered. `None` if there is no
    /// room.
    pub fn place(&mut self, words: &str, pieces: &[Vec<CanvasPoint>], colour: Colour) -> Option<CanvasPoint> {
        let mut longest: Vec<_> = pieces.iter().collect();
        longest.sort_by(|a, b| length(b).total_cmp(&length(a)));
        longest.into_iter().take(MOST_PIECES).find_map(|piece| self.place_beside(words, piece, colour))
    }

    /// Centre of a name next to one piece of its curve; marks the name's area as covered. `None`
    /// if there is no room.
    fn place_beside(&mut self, words: &str, piece: &[CanvasPoint], colour: Colour) -> Option<CanvasPoint> {
        let (half, high) = (0.5 * text_width(words, SMALL), 0.5 * HEIGHT);
        let away = AIR + SQUARE + 2.0;
        // The search starts at the middle of the piece and moves to its ends.
        let stride = (length(piece) / (STEP * TRIES)).ceil().max(1.0) as usize;
        let spots: Vec<CanvasPoint> = along(piece, STEP).step_by(stride).collect();
        let middle = spots.len() / 2;
        let order =
            (0..spots.len()).map(|i| if i % 2 == 0 { middle + i / 2 } else { middle - i.div_ceil(2) });
        let order = order.filter(|&i| i < spots.len());
        for i in order {
            let (x, y) = spots[i];
            for (dx, dy) in [(0, -1), (0, 1), (1, 0), (-1, 0), (1, -1), (-1, -1), (1, 1), (-1, 1)] {
                let at = (x + f64::from(dx) * (half + away), y + f64::from(dy) * (high + away));
                let name =
                    Frame { left: at.0 - half, top: at.1 - high, right: at.0 + half, bottom: at.1 + high };
                if self.has_room(&name, colour) {
                    // Names of all colours keep away from this one.
                    self.cover(&name, colour);
                    return Some(at);
                }
            }
        }
        None
    }
}

fn length(path: &[CanvasPoint]) -> f64 {
    path.windows(2).map(|p| (p[1].0 - p[0].0).hypot(p[1].1 - p[0].1)).sum()
}

/// Points along a path at about equal distances, beginning with its first point.
fn along(path: &[CanvasPoint], step: f64) -> impl Iterator<Item = CanvasPoint> {
    let between = move |pair: &[CanvasPoint]| {
        let (a, b) = (pair[0], pair[1]);
        let parts = ((b.0 - a.0).hypot(b.1 - a.1) / step).ceil().max(1.0) as u32;
        (1..=parts).map(move |i| {
            let t = f64::from(i) / f64::from(parts);
            (a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1))
        })
    };
    path.first().copied().into_iter().chain(path.windows(2).flat_map(between))
}
