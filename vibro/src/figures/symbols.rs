//! Strokes, marks, areas and their samples in legends.

use super::canvas::palette::BLACK;
use super::chart::{Colour, Dash, Layer, Mark, Shape};
use super::scale::dashes;
use super::text::{Area, Drawn, ENTRY, SAMPLE, SMALL, failed, style, text};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

/// Greatest distance of a simplified path from the original, in units of the drawing.
const TOLERANCE: f64 = 0.6;
/// Segments drawn at once: a stroke is filled as a polygon, which must not meet itself.
const AT_ONCE: usize = 10;

fn whole((x, y): (f64, f64)) -> (i32, i32) {
    (x.round() as i32, y.round() as i32)
}

/// Simplifies a path by the method of Ramer, Douglas and Peucker. Without this, strokes of many tiny segments, rounded to
/// whole units, look ragged.
fn simplified(path: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut kept = vec![false; path.len()];
    let mut open = vec![(0, path.len().saturating_sub(1))];
    while let Some((from, to)) = open.pop() {
        for end in [from, to] {
            kept.get_mut(end).into_iter().for_each(|k| *k = true);
        }
        let (mut worst, mut at) = (TOLERANCE, None);
        for i in from + 1..to {
            let off = distance(path[i], path[from], path[to]);
            if off > worst {
                (worst, at) = (off, Some(i));
            }
        }
        open.extend(at.into_iter().flat_map(|i| [(from, i), (i, to)]));
    }
    path.iter().zip(kept).filter(|p| p.1).map(|p| *p.0).collect()
}

/// Distance of a point from a segment.
fn distance(p: (f64, f64), a: (f64, f64), b: (f64, f64)) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let square = dx * dx + dy * dy;
    let part = if square > 0.0 { ((p.0 - a.0) * dx + (p.1 - a.1) * dy) / square } else { 0.0 };
    let t = part.clamp(0.0, 1.0);
    (p.0 - a.0 - t * dx).hypot(p.1 - a.1 - t * dy)
}

/// Strokes a path of places.
pub(super) fn stroke<DB: DrawingBackend>(
    area: Area<DB>,
    path: Vec<(f64, f64)>,
    colour: Colour,
    width: u32,
    dash: Dash,
) -> Drawn {
    for piece in dashes(path, dash, f64::from(width)) {
        let points: Vec<_> = simplified(&piece).into_iter().map(whole).collect();
        for run in runs(&points) {
            for from in (0..run.len().saturating_sub(1)).step_by(AT_ONCE) {
                // One segment more than the step, so that the joints are filled.
                let part = run[from..run.len().min(from + AT_ONCE + 2)].to_vec();
                area.draw(&PathElement::new(part, colour.stroke_width(width))).map_err(failed)?;
            }
            // The next run begins at this end: a disc makes the join round.
            if let Some(&end) = run.last().filter(|&&end| Some(&end) != points.last()) {
                area.draw(&Circle::new(end, width as i32 / 2, colour.filled())).map_err(failed)?;
            }
        }
    }
    Ok(())
}

/// The path cut where it turns by more than a right angle. The drawing library joins segments by mitres of any length, so
/// that a turn by nearly half a circle would throw a spike across the page.
fn runs(points: &[(i32, i32)]) -> Vec<&[(i32, i32)]> {
    let mut runs = Vec::new();
    let mut from = 0;
    for (i, corner) in points.windows(3).enumerate() {
        let along = |k: usize| (corner[k + 1].0 - corner[k].0, corner[k + 1].1 - corner[k].1);
        let (before, after) = (along(0), along(1));
        if before.0 * after.0 + before.1 * after.1 < 0 {
            runs.push(&points[from..=i + 1]);
            from = i + 1;
        }
    }
    runs.push(&points[from..]);
    runs
}

/// The edge of a rectangle, as a path: rectangles on SVG have no stroke width.
pub(super) fn outline<DB: DrawingBackend>(
    area: Area<DB>,
    [a, b]: [(i32, i32); 2],
    colour: Colour,
    width: u32,
) -> Drawn {
    // Each side on its own, so that the filled stroke never meets itself.
    let corners = [a, (b.0, a.1), b, (a.0, b.1), a];
    for side in corners.windows(2) {
        area.draw(&PathElement::new(side.to_vec(), colour.stroke_width(width))).map_err(failed)?;
    }
    Ok(())
}

/// Draws a mark at a place.
pub(super) fn mark<DB: DrawingBackend>(
    area: Area<DB>,
    at: (f64, f64),
    colour: Colour,
    radius: u32,
    mark: Mark,
) -> Drawn {
    let (x, y) = whole(at);
    let r = radius as i32;
    let near = |dx: i32, dy: i32| (x + dx, y + dy);
    let polygon = |points: Vec<(i32, i32)>| area.draw(&Polygon::new(points, colour.filled())).map_err(failed);
    match mark {
        Mark::Disc => area.draw(&Circle::new((x, y), r, colour.filled())).map_err(failed),
        Mark::Ring => {
            area.draw(&Circle::new((x, y), r, colour.filled())).map_err(failed)?;
            area.draw(&Circle::new((x, y), r - 4.min(r / 2), WHITE.filled())).map_err(failed)
        }
        Mark::Square => polygon(vec![near(-r, -r), near(r, -r), near(r, r), near(-r, r)]),
        Mark::Triangle => polygon(vec![near(0, -r - r / 4), near(r, r - r / 4), near(-r, r - r / 4)]),
        Mark::Cross => {
            for path in [[near(-r, -r), near(r, r)], [near(-r, r), near(r, -r)]] {
                area.draw(&PathElement::new(path.to_vec(), colour.stroke_width(4))).map_err(failed)?;
            }
            Ok(())
        }
    }
}

/// One entry of a legend with its upper left corner at `at`; returns where it ends.
pub(super) fn entry<DB: DrawingBackend>(
    area: Area<DB>,
    layer: &Layer,
    at: (i32, i32),
) -> Result<i32, String> {
    let name = layer.name.as_deref().unwrap_or_default();
    let (left, y) = (f64::from(at.0), f64::from(at.1 + ENTRY / 2));
    let right = left + f64::from(SAMPLE - 20);
    match &layer.shape {
        Shape::Lines { width, dash, .. } => {
            stroke(area, vec![(left, y), (right, y)], layer.colour, *width, *dash)?;
        }
        Shape::Marks { radius, mark: form, .. } => {
            mark(area, (0.5 * (left + right), y), layer.colour, (*radius).max(5), *form)?;
        }
        Shape::Band { opacity, .. } => {
            let corners = [whole((left, y - 17.0)), whole((right, y + 17.0))];
            area.draw(&Rectangle::new(corners, layer.colour.mix(*opacity).filled())).map_err(failed)?;
            outline(area, corners, BLACK, 3)?;
        }
        Shape::Cells { .. } | Shape::Text { .. } => {}
    }
    let font = style(SMALL, BLACK, HPos::Left, VPos::Center);
    text(area, (at.0 + SAMPLE, at.1 + ENTRY / 2), name, &font)?;
    Ok(at.0 + entry_width(area, layer)?)
}

/// Width of an entry of a legend.
pub(super) fn entry_width<DB: DrawingBackend>(area: Area<DB>, layer: &Layer) -> Result<i32, String> {
    let font = style(SMALL, BLACK, HPos::Left, VPos::Center);
    let name = layer.name.as_deref().unwrap_or_default();
    Ok(SAMPLE + area.estimate_text_size(name, &font).map_err(failed)?.0 as i32)
}
