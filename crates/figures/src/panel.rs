//! One panel: axes, grid, layers and names next to curves.

use crate::canvas::palette::BLACK;
use crate::canvas::{Across, Along, Canvas, CanvasPoint, Colour, PNG_SHRINK, Pen, Writing, wrapped};
use crate::chart::{Layer, Panel, Path, Shape};
use crate::labels::Room;
use crate::scale::{Frame, Scale};
use crate::symbols::{SMALL, marks, pen, stroke};
use std::borrow::Cow;

/// Font size of axes and titles of panels.
const LABEL: f64 = 34.0;
const GRID: Colour = Colour(225, 225, 225);
/// Space for labels: left, top, right, bottom.
pub(super) const ROOM: [u32; 4] = [185, 80, 45, 140];
/// Distance of the lines of a title or label.
const LINE: f64 = 42.0;
const TICK: f64 = 14.0;
/// Stroke width of frames, grids and ticks.
const HAIR: f64 = 3.0;

/// Lines of the texts around a panel: its title, its horizontal and its vertical axis.
pub(super) type Around = [Vec<String>; 3];

/// The texts around a panel of a given size, in lines that fit.
pub(super) fn around(panel: &Panel, size: (u32, u32)) -> Around {
    let [left, top, right, bottom] = ROOM;
    let wide = f64::from(size.0.saturating_sub(left + right));
    let high = f64::from(size.1.saturating_sub(top + bottom));
    [(&panel.title, wide), (&panel.x.label, wide), (&panel.y.label, high)]
        .map(|(text, room)| wrapped(text, LABEL, room))
}

/// A laid-out panel: its scales, its frame, and the names next to its curves.
pub(super) struct Layout<'p> {
    panel: &'p Panel,
    around: Around,
    x: Scale,
    y: Scale,
    frame: Frame,
    /// Positions of names, and the layers they name.
    names: Vec<(CanvasPoint, &'p Layer)>,
    /// Layers that need an entry in a legend.
    pub entries: Vec<&'p Layer>,
}

impl<'p> Layout<'p> {
    /// Lays out a panel of a given size, with the origin at its upper left corner. `lines` are the
    /// largest numbers of lines of the texts around any panel of the figure.
    pub fn new(panel: &'p Panel, size: (u32, u32), lines: [usize; 3]) -> Self {
        let [left, top, right, bottom] = ROOM.map(f64::from);
        let (width, height) = (f64::from(size.0), f64::from(size.1));
        let [above, below, beside] = lines.map(|count| LINE * count.saturating_sub(1) as f64);
        let frame = Frame {
            left: left + beside,
            top: top + above,
            right: width - right,
            bottom: height - bottom - below,
        };
        let extent: Vec<_> = panel.layers.iter().flat_map(Layer::extent).collect();
        let x = Scale::new(&panel.x, extent.iter().map(|p| p.0), frame.left, frame.right);
        let y = Scale::new(&panel.y, extent.iter().map(|p| p.1), frame.bottom, frame.top);
        let around = around(panel, size);
        let mut layout = Self { panel, around, x, y, frame, names: Vec::new(), entries: Vec::new() };
        layout.name_layers();
        layout
    }

    /// Moves all names to the legend if one is there already: a legend of some curves would look
    /// like a legend of all.
    pub fn name_all_or_none(&mut self) {
        if self.entries.iter().any(|layer| layer.label.is_some()) {
            self.names.clear();
            self.entries = self.panel.layers.iter().filter(|layer| layer.entry().is_some()).collect();
        }
    }

    /// Whether a layer with equal label, colour and dashes has its name next to its curve.
    pub fn names_like(&self, layer: &Layer) -> bool {
        let pen = |layer: &Layer| match layer.shape {
            Shape::Lines { dash, .. } => Some((layer.tint(), dash)),
            _ => None,
        };
        layer.label.is_some()
            && self.names.iter().any(|(_, named)| named.label == layer.label && pen(named) == pen(layer))
    }

    /// Finds positions for the names of curves; the other names become legend entries.
    fn name_layers(&mut self) {
        let mut room = self.room();
        for layer in &self.panel.layers {
            let place = layer.label.as_ref().and_then(|label| {
                let Shape::Lines { pieces, .. } = &layer.shape else { return None };
                room.place(label, &self.clipped(pieces), layer.colour)
            });
            match place {
                Some(at) => self.names.push((at, layer)),
                None if layer.entry().is_some() => self.entries.push(layer),
                None => {}
            }
        }
    }

    /// Map of the area without layers.
    fn room(&self) -> Room {
        let mut room = Room::new(self.frame);
        for layer in &self.panel.layers {
            match &layer.shape {
                Shape::Lines { pieces, .. } => {
                    self.clipped(pieces).iter().for_each(|path| room.cover_path(path, layer.colour));
                }
                Shape::Marks { points, radius, .. } => {
                    for (x, y) in points.iter().map(|&p| self.place(p)).filter(|&p| self.frame.holds(p)) {
                        let spot = Frame { left: x, top: y, right: x, bottom: y };
                        room.cover(&spot.grown(f64::from(*radius)), layer.colour);
                    }
                }
                _ => {}
            }
        }
        room
    }

    fn place(&self, (x, y): (f64, f64)) -> CanvasPoint {
        (self.x.place(x), self.y.place(y))
    }

    /// The parts of curves inside the frame.
    fn clipped(&self, pieces: &[Path]) -> Vec<Vec<CanvasPoint>> {
        let parts = |piece: &Path| self.frame.clip_path(piece.iter().map(|&p| self.place(p)));
        pieces.iter().flat_map(parts).collect()
    }

    /// Draws the panel.
    pub fn draw(&self, canvas: &mut Canvas) {
        let cells = self.panel.layers.iter().any(|l| matches!(l.shape, Shape::Cells { .. }));
        canvas.clipped(self.frame.corners(), |canvas| {
            self.panel.layers.iter().for_each(|layer| self.cells(canvas, layer));
            if !cells {
                self.grid(canvas);
            }
            self.panel.layers.iter().for_each(|layer| self.layer(canvas, layer));
        });
        for (at, layer) in &self.names {
            // Darker than the curve: thin strokes look paler than wide ones.
            let colour = layer.colour.towards(BLACK, 0.25);
            self.write(canvas, *at, layer.label.as_deref().unwrap_or_default(), colour);
        }
        self.axes(canvas);
    }

    fn write(&self, canvas: &mut Canvas, at: CanvasPoint, words: &str, colour: Colour) {
        let (along, across) = (Along::Middle, Across::Centre);
        canvas.text(at, words, &Writing { size: SMALL, colour, along, across, upwards: false });
    }

    fn grid(&self, canvas: &mut Canvas) {
        let f = &self.frame;
        let upright = |x: f64| vec![(x, f.top), (x, f.bottom)];
        let level = |y: f64| vec![(f.left, y), (f.right, y)];
        let across = self.x.ticks().into_iter().map(|t| upright(self.x.place(t.0)));
        let pieces: Vec<_> =
            across.chain(self.y.ticks().into_iter().map(|t| level(self.y.place(t.0)))).collect();
        canvas.lines(&pieces, Pen::solid(GRID, HAIR));
    }

    fn axes(&self, canvas: &mut Canvas) {
        let Frame { left, top, right, bottom } = self.frame;
        let mut lines = vec![vec![(left, top), (right, top), (right, bottom), (left, bottom), (left, top)]];
        let style = |size, along, across| Writing { size, colour: BLACK, along, across, upwards: false };
        for (value, label) in self.x.ticks() {
            let x = self.x.place(value);
            lines.push(vec![(x, bottom), (x, bottom - TICK)]);
            canvas.text((x, bottom + 14.0), &label, &style(SMALL, Along::Middle, Across::Top));
        }
        for (value, label) in self.y.ticks() {
            let y = self.y.place(value);
            lines.push(vec![(left, y), (left + TICK, y)]);
            canvas.text((left - 16.0, y), &label, &style(SMALL, Along::End, Across::Centre));
        }
        canvas.lines(&lines, Pen::solid(BLACK, HAIR));
        let (middle, centre) = (0.5 * (left + right), 0.5 * (top + bottom));
        let axis = style(LABEL, Along::Middle, Across::Top);
        let [title, across, upright] = &self.around;
        let places = |lines: &[String]| (0..lines.len()).map(|k| k as f64 * LINE).collect::<Vec<_>>();
        for (line, down) in across.iter().zip(places(across)) {
            canvas.text((middle, bottom + 68.0 + down), line, &axis);
        }
        for (line, right) in upright.iter().zip(places(upright)) {
            canvas.text((12.0 + right, centre), line, &Writing { upwards: true, ..axis });
        }
        for (line, up) in title.iter().rev().zip(places(title)) {
            canvas.text((left, top - 14.0 - up), line, &style(LABEL, Along::Start, Across::Bottom));
        }
    }

    fn layer(&self, canvas: &mut Canvas, layer: &Layer) {
        match &layer.shape {
            Shape::Lines { pieces, width, dash } => {
                stroke(canvas, &self.clipped(pieces), pen(layer, *width, *dash));
            }
            Shape::Marks { points, radius, mark } => {
                let places = points.iter().map(|&p| self.place(p)).filter(|&p| self.frame.holds(p));
                marks(canvas, &places.collect::<Vec<_>>(), layer.tint(), *radius, *mark);
            }
            Shape::Band { points, opacity } if points.len() > 1 => {
                let f = &self.frame;
                let inside = |x: f64, y: f64| {
                    let (x, y) = self.place((x, y));
                    (x.clamp(f.left, f.right), y.clamp(f.top, f.bottom))
                };
                let lower = points.iter().map(|&(x, low, _)| inside(x, low));
                let upper = points.iter().rev().map(|&(x, _, high)| inside(x, high));
                canvas.polygon(&lower.chain(upper).collect::<Vec<_>>(), layer.colour, *opacity);
            }
            Shape::Text { at, text } => self.write(canvas, self.place(*at), text, layer.colour),
            Shape::Band { .. } | Shape::Bar { .. } | Shape::Cells { .. } => {}
        }
    }

    /// Draws cells: adjacent cells of one colour in a row become one rectangle, which also spans
    /// all following equal rows.
    fn cells(&self, canvas: &mut Canvas, layer: &Layer) {
        let Shape::Cells { x, y, columns, cells, colours } = &layer.shape else { return };
        // The number of cells is at most the number of pixels of the bitmap.
        let f = &self.frame;
        let most = |from: f64, to: f64| ((to - from) / f64::from(PNG_SHRINK)).max(1.0) as usize;
        let (columns, cells) = merged(cells, *columns, (most(f.left, f.right), most(f.top, f.bottom)));
        let rows: Vec<&[u8]> = cells.chunks(columns).collect();
        let edge = |i: usize| y.0 + (y.1 - y.0) * i as f64 / rows.len() as f64;
        let side = |i: usize| x.0 + (x.1 - x.0) * i as f64 / columns as f64;
        let whole = |place: CanvasPoint| (place.0.round(), place.1.round());
        let mut areas = vec![Vec::new(); colours.len()];
        // If some cells are not drawn, each drawn cell is a separate datum and must not vanish.
        let isolated = colours.contains(&None);
        let mut from = 0;
        while from < rows.len() {
            let equal = rows[from..].iter().take_while(|r| **r == rows[from]).count();
            let mut column = 0;
            while column < columns {
                let class = rows[from][column];
                let run = rows[from][column..].iter().take_while(|c| **c == class).count();
                if let Some(areas) = areas.get_mut(usize::from(class)) {
                    let corners = [(side(column), edge(from)), (side(column + run), edge(from + equal))];
                    areas.push(corners.map(|corner| whole(self.place(corner))));
                }
                column += run;
            }
            from += equal;
        }
        for (areas, colour) in areas.iter().zip(colours) {
            if let Some(colour) = colour {
                if isolated {
                    canvas.visible_rectangles(areas, *colour);
                } else {
                    canvas.rectangles(areas, *colour);
                }
            }
        }
    }
}

/// Cells reduced to at most `most` in a row and in a column, with the new number of columns.
/// Merged cells take their most frequent value, the first of equally frequent ones.
fn merged(cells: &[u8], columns: usize, most: (usize, usize)) -> (usize, Cow<'_, [u8]>) {
    let rows = cells.len() / columns;
    let (across, up) = (columns.min(most.0), rows.min(most.1));
    if (across, up) == (columns, rows) {
        return (columns, Cow::Borrowed(cells));
    }
    let part = |i: usize, from: usize, to: usize| i * from / to..(i + 1) * from / to;
    let last = cells.iter().copied().max().unwrap_or_default();
    let common = |i: usize, j: usize| {
        let mut counts = [0_u32; 256];
        for row in part(j, rows, up) {
            let row = &cells[row * columns..(row + 1) * columns];
            part(i, columns, across).for_each(|column| counts[usize::from(row[column])] += 1);
        }
        (0..=last).rev().max_by_key(|class| counts[usize::from(*class)]).unwrap_or_default()
    };
    (across, (0..up).flat_map(|j| (0..across).map(move |i| common(i, j))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn merged_cells_are_the_commonest() {
        let cells = [0, 0, 1, 2, 0, 3, 1, 2, 5, 5, 4, 4, 5, 6, 4, 7];
        assert_eq!(merged(&cells, 4, (4, 4)), (4, Cow::Borrowed(&cells[..])));
        assert_eq!(merged(&cells, 4, (2, 2)), (2, Cow::Owned(vec![0, 1, 5, 4])));
        // Three columns of four: the last has two of them.
        assert_eq!(merged(&[1, 2, 3, 3], 4, (3, 9)), (3, Cow::Owned(vec![1, 2, 3])));
    }
}
