//! One panel: axes, grid, layers, and a legend where it covers the least.

use super::canvas::palette::BLACK;
use super::chart::{Axis, Layer, Panel, Shape};
use super::scale::{Frame, Scale};
use super::symbols::{entry, entry_width, mark, outline, stroke};
use super::text::{Area, Drawn, ENTRY, SMALL, failed, style, text};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

const LABEL: u32 = 40;
const GRID: RGBColor = RGBColor(225, 225, 225);
/// Room for labels: left, top, right, bottom.
const ROOM: [u32; 4] = [185, 80, 45, 140];
const TICK: i32 = 14;
/// Frames, grids and ticks.
const HAIR: u32 = 3;
/// Between a legend and the frame, and inside a legend.
const PADDING: i32 = 16;

struct Canvas<'a, DB: DrawingBackend> {
    area: Area<'a, DB>,
    x: Scale,
    y: Scale,
    frame: Frame,
}

/// Draws a panel with its upper left corner at `at`.
pub(super) fn draw_panel<DB: DrawingBackend>(
    area: Area<DB>,
    panel: &Panel,
    at: (u32, u32),
    size: (u32, u32),
    legend: bool,
) -> Drawn {
    let [left, top, right, bottom] = ROOM;
    let frame = Frame {
        left: f64::from(at.0 + left),
        top: f64::from(at.1 + top),
        right: f64::from(at.0 + size.0 - right),
        bottom: f64::from(at.1 + size.1 - bottom),
    };
    let extent: Vec<_> = panel.layers.iter().flat_map(Layer::extent).collect();
    let x = Scale::new(&panel.x, extent.iter().map(|p| p.0), frame.left, frame.right);
    let y = Scale::new(&panel.y, extent.iter().map(|p| p.1), frame.bottom, frame.top);
    let mut canvas = Canvas { area, x, y, frame };
    if legend {
        canvas.make_room(panel)?;
    }
    canvas.cells(panel)?;
    if !panel.layers.iter().any(|l| matches!(l.shape, Shape::Cells { .. })) {
        canvas.grid()?;
    }
    panel.layers.iter().try_for_each(|layer| canvas.layer(layer))?;
    canvas.axes(panel)?;
    if legend { canvas.legend(panel) } else { Ok(()) }
}

impl<DB: DrawingBackend> Canvas<'_, DB> {
    fn place(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (self.x.place(x), self.y.place(y))
    }

    fn hair(&self, from: (f64, f64), to: (f64, f64), colour: RGBColor) -> Drawn {
        let points = [from, to].map(|(x, y)| (x.round() as i32, y.round() as i32)).to_vec();
        self.area.draw(&PathElement::new(points, colour.stroke_width(HAIR))).map_err(failed)
    }

    fn grid(&self) -> Drawn {
        let f = &self.frame;
        for (value, _) in self.x.ticks() {
            let x = self.x.place(value);
            self.hair((x, f.top), (x, f.bottom), GRID)?;
        }
        for (value, _) in self.y.ticks() {
            let y = self.y.place(value);
            self.hair((f.left, y), (f.right, y), GRID)?;
        }
        Ok(())
    }

    fn axes(&self, panel: &Panel) -> Drawn {
        let f = &self.frame;
        let (left, right) = (f.left as i32, f.right as i32);
        let (top, bottom) = (f.top as i32, f.bottom as i32);
        outline(self.area, [(left, top), (right, bottom)], BLACK, HAIR)?;
        let below = style(SMALL, BLACK, HPos::Center, VPos::Top);
        for (value, label) in self.x.ticks() {
            let x = self.x.place(value);
            self.hair((x, f.bottom), (x, f.bottom - f64::from(TICK)), BLACK)?;
            text(self.area, (x.round() as i32, bottom + 14), &label, &below)?;
        }
        let beside = style(SMALL, BLACK, HPos::Right, VPos::Center);
        for (value, label) in self.y.ticks() {
            let y = self.y.place(value);
            self.hair((f.left, y), (f.left + f64::from(TICK), y), BLACK)?;
            text(self.area, (left - 16, y.round() as i32), &label, &beside)?;
        }
        let (middle, centre) = ((left + right) / 2, (top + bottom) / 2);
        let font = style(LABEL, BLACK, HPos::Center, VPos::Top);
        text(self.area, (middle, bottom + 68), &panel.x.label, &font)?;
        let turned = style(LABEL, BLACK, HPos::Center, VPos::Top).transform(FontTransform::Rotate270);
        text(self.area, (left - ROOM[0] as i32 + 12, centre), &panel.y.label, &turned)?;
        let font = style(LABEL, BLACK, HPos::Left, VPos::Bottom);
        text(self.area, (left, top - 14), &panel.title, &font)
    }

    fn layer(&self, layer: &Layer) -> Drawn {
        match &layer.shape {
            Shape::Lines { pieces, width, dash } => {
                for piece in pieces {
                    let path = piece.iter().map(|&p| self.place(p));
                    for part in self.frame.clip_path(path) {
                        stroke(self.area, part, layer.colour, *width, *dash)?;
                    }
                }
                Ok(())
            }
            Shape::Marks { points, radius, mark: form } => {
                let places = points.iter().map(|&p| self.place(p)).filter(|&p| self.frame.holds(p));
                places.into_iter().try_for_each(|p| mark(self.area, p, layer.colour, *radius, *form))
            }
            Shape::Band { points, opacity } if points.len() > 1 => {
                let f = &self.frame;
                let inside = |x: f64, y: f64| {
                    let (x, y) = self.place((x, y));
                    (x.clamp(f.left, f.right).round() as i32, y.clamp(f.top, f.bottom).round() as i32)
                };
                let lower = points.iter().map(|&(x, low, _)| inside(x, low));
                let upper = points.iter().rev().map(|&(x, _, high)| inside(x, high));
                let corners: Vec<_> = lower.chain(upper).collect();
                self.area.draw(&Polygon::new(corners, layer.colour.mix(*opacity).filled())).map_err(failed)
            }
            Shape::Text { at, text: words } => {
                let (x, y) = self.place(*at);
                let font = style(SMALL, layer.colour, HPos::Center, VPos::Center);
                text(self.area, (x.round() as i32, y.round() as i32), words, &font)
            }
            Shape::Band { .. } | Shape::Cells { .. } => Ok(()),
        }
    }

    /// Draws cells: neighbours of one colour in a row become one rectangle, which spans all following rows that are equal.
    fn cells(&self, panel: &Panel) -> Drawn {
        for layer in &panel.layers {
            let Shape::Cells { x, y, columns, cells, colours } = &layer.shape else { continue };
            let rows: Vec<&[u8]> = cells.chunks(*columns).collect();
            let count = (*columns as f64, rows.len() as f64);
            let mut from = 0;
            while from < rows.len() {
                let equal = rows[from..].iter().take_while(|r| **r == rows[from]).count();
                let edge = |i: usize| y.0 + (y.1 - y.0) * i as f64 / count.1;
                let mut column = 0;
                while column < *columns {
                    let class = rows[from][column];
                    let run = rows[from][column..].iter().take_while(|c| **c == class).count();
                    let side = |i: usize| x.0 + (x.1 - x.0) * i as f64 / count.0;
                    let (a, b) = (
                        self.place((side(column), edge(from))),
                        self.place((side(column + run), edge(from + equal))),
                    );
                    if let Some(colour) = colours.get(usize::from(class)).copied().flatten() {
                        let corners = [a, b].map(|(x, y)| (x.round() as i32, y.round() as i32));
                        self.area.draw(&Rectangle::new(corners, colour.filled())).map_err(failed)?;
                    }
                    column += run;
                }
                from += equal;
            }
        }
        Ok(())
    }

    /// The legend's entries and the size of its box.
    fn entries<'p>(&self, panel: &'p Panel) -> Result<(Vec<&'p Layer>, (f64, f64)), String> {
        let mut names = std::collections::BTreeSet::new();
        let named = |l: &&Layer| l.name.as_ref().is_some_and(|n| names.insert(n.clone()));
        let entries: Vec<&Layer> = panel.layers.iter().filter(named).collect();
        let widths = entries.iter().map(|l| entry_width(self.area, l)).collect::<Result<Vec<_>, _>>()?;
        let wide = f64::from(widths.into_iter().max().unwrap_or(0) + 2 * PADDING);
        let high = f64::from(entries.len() as i32 * ENTRY + PADDING);
        Ok((entries, (wide, high)))
    }

    /// Raises the upper end of a vertical axis that follows its data where the legend would cover some.
    fn make_room(&mut self, panel: &Panel) -> Drawn {
        let (entries, size) = self.entries(panel)?;
        if entries.is_empty() || panel.y.range.is_some() || panel.y.log {
            return Ok(());
        }
        let height = self.frame.bottom - self.frame.top;
        let left = height - size.1 - 2.0 * f64::from(PADDING);
        if self.emptiest(panel, size).1 > 0 && left > 0.5 * height {
            let (low, high) = (self.y.low, self.y.high);
            let range = Some((low, low + (high - low) * height / left));
            let axis = Axis { range, ..panel.y.clone() };
            self.y = Scale::new(&axis, std::iter::empty(), self.frame.bottom, self.frame.top);
        }
        Ok(())
    }

    fn legend(&self, panel: &Panel) -> Drawn {
        let (entries, (wide, high)) = self.entries(panel)?;
        if entries.is_empty() {
            return Ok(());
        }
        let ((left, top), _) = self.emptiest(panel, (wide, high));
        let corners = [(left as i32, top as i32), ((left + wide) as i32, (top + high) as i32)];
        self.area.draw(&Rectangle::new(corners, WHITE.mix(0.85).filled())).map_err(failed)?;
        outline(self.area, corners, GRID, HAIR)?;
        for (i, layer) in entries.into_iter().enumerate() {
            let at = (left as i32 + PADDING, top as i32 + PADDING / 2 + i as i32 * ENTRY);
            entry(self.area, layer, at)?;
        }
        Ok(())
    }

    /// Of nine positions of a box of this size, the upper left corner of the one that covers the fewest points of the layers,
    /// and how many these are.
    fn emptiest(&self, panel: &Panel, (wide, high): (f64, f64)) -> ((f64, f64), usize) {
        let f = &self.frame;
        let air = f64::from(PADDING);
        let columns = [f.right - air - wide, f.left + air, 0.5 * (f.left + f.right - wide)];
        let rows = [f.top + air, f.bottom - air - high, 0.5 * (f.top + f.bottom - high)];
        let mut places: Vec<(f64, f64)> = Vec::new();
        for layer in &panel.layers {
            match &layer.shape {
                Shape::Lines { pieces, .. } => {
                    for pair in pieces.iter().flat_map(|p| p.windows(2)) {
                        let (a, b) = (self.place(pair[0]), self.place(pair[1]));
                        // Long segments count along their length.
                        let parts = ((b.0 - a.0).hypot(b.1 - a.1) / 20.0).clamp(1.0, 200.0) as u32;
                        let part = |i: u32| f64::from(i) / f64::from(parts);
                        places.extend(
                            (0..parts).map(|i| (a.0 + part(i) * (b.0 - a.0), a.1 + part(i) * (b.1 - a.1))),
                        );
                    }
                }
                Shape::Band { points, .. } => {
                    places
                        .extend(points.iter().flat_map(|p| [(p.0, p.1), (p.0, p.2)]).map(|p| self.place(p)));
                }
                Shape::Cells { x, y, columns, cells, colours } => {
                    let rows = (cells.len() / (*columns).max(1)) as f64;
                    let filled = |class: u8| colours.get(usize::from(class)).is_some_and(Option::is_some);
                    let centre = |i: usize| {
                        let part = ((i % columns) as f64 + 0.5, (i / columns) as f64 + 0.5);
                        let across = x.0 + (x.1 - x.0) * part.0 / *columns as f64;
                        self.place((across, y.0 + (y.1 - y.0) * part.1 / rows))
                    };
                    places.extend((0..cells.len()).filter(|&i| filled(cells[i])).map(centre));
                }
                _ => places.extend(layer.extent().into_iter().map(|p| self.place(p))),
            }
            if let Shape::Text { at, .. } = &layer.shape {
                places.extend([self.place(*at); 50]);
            }
        }
        let covered = |(left, top): (f64, f64)| {
            let spot = Frame { left, top, right: left + wide, bottom: top + high };
            places.iter().filter(|&&p| spot.holds(p)).count()
        };
        // Corners first; the middles only where they are emptier.
        let order = [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (2, 1), (0, 2), (1, 2), (2, 2)];
        let spots = order.map(|(i, j)| (columns[i], rows[j]));
        let best = spots.into_iter().min_by_key(|&s| covered(s)).unwrap_or(spots[0]);
        (best, covered(best))
    }
}
