//! Strokes, marks and their samples in legends.

use crate::canvas::palette::{BLACK, WHITE};
use crate::canvas::{Across, Along, Canvas, CanvasPoint, Pen, Writing, text_width, wrapped};
use crate::chart::{Colour, Dash, Layer, Mark, Shape};

/// Font size of ticks, legends and labels next to curves.
pub(super) const SMALL: f64 = 31.0;
/// Height of a line of a legend.
pub(super) const ENTRY: f64 = 54.0;
/// Width of the sample in a legend entry.
const SAMPLE: f64 = 90.0;
/// Distance of the lines of an entry.
pub(super) const ENTRY_LINE: f64 = 40.0;
/// Space between the sample and the text of a legend entry.
const SPACE: f64 = 20.0;
/// Largest distance of a simplified path from the original, in units of the drawing.
const TOLERANCE: f64 = 0.6;
/// Stroke width of crosses and of the outlines of empty marks.
const FINE: f64 = 4.0;

/// Simplifies a path by the method of Ramer, Douglas and Peucker: points within [`TOLERANCE`] of a
/// straight line are left out of the file.
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

/// The pen of a curve.
pub(super) fn pen(layer: &Layer, width: u32, dash: Dash) -> Pen {
    let width = f64::from(width);
    let dash = match dash {
        Dash::Solid => None,
        Dash::Dashed => Some((4.5 * width, 3.0 * width)),
        Dash::Dotted => Some((1.2 * width, 1.8 * width)),
    };
    Pen { colour: layer.tint(), width, dash }
}

/// Draws polylines with one pen.
pub(super) fn stroke(canvas: &mut Canvas, pieces: &[Vec<CanvasPoint>], pen: Pen) {
    let pieces: Vec<_> = pieces.iter().map(|piece| simplified(piece)).collect();
    canvas.lines(&pieces, pen);
}

/// Draws marks at given points.
pub(super) fn marks(canvas: &mut Canvas, places: &[CanvasPoint], colour: Colour, radius: u32, mark: Mark) {
    let r = f64::from(radius);
    match mark {
        Mark::Disc => canvas.circles(places, r, colour, None),
        Mark::Ring => canvas.circles(places, r, colour, Some(FINE)),
        Mark::Square => {
            places.iter().for_each(|&p| {
                canvas.polygon(&around(p, &[(-r, -r), (r, -r), (r, r), (-r, r)]), colour, 1.0)
            });
        }
        Mark::Triangle => {
            let corners = [(0.0, -1.25 * r), (r, 0.75 * r), (-r, 0.75 * r)];
            places.iter().for_each(|&p| canvas.polygon(&around(p, &corners), colour, 1.0));
        }
        Mark::Diamond => {
            let corners = [(0.0, -1.3 * r), (1.3 * r, 0.0), (0.0, 1.3 * r), (-1.3 * r, 0.0)];
            places.iter().for_each(|&p| canvas.polygon(&around(p, &corners), colour, 1.0));
        }
        Mark::Frame => outlines(canvas, places, &[(-r, -r), (r, -r), (r, r), (-r, r)], colour),
        Mark::Funnel => outlines(canvas, places, &[(-r, -r), (r, -r), (0.0, r)], colour),
        Mark::Cross => strokes(canvas, places, [[(-r, -r), (r, r)], [(-r, r), (r, -r)]], colour),
        Mark::Target => {
            canvas.circles(places, r, colour, Some(FINE));
            marks(canvas, places, colour, radius, Mark::Plus);
        }
        Mark::Plus => strokes(canvas, places, [[(-r, 0.0), (r, 0.0)], [(0.0, -r), (0.0, r)]], colour),
    }
}

/// An outline filled with white.
fn outlines(canvas: &mut Canvas, places: &[CanvasPoint], corners: &[CanvasPoint], colour: Colour) {
    places.iter().for_each(|&p| canvas.polygon(&around(p, corners), WHITE, 1.0));
    let closed = [corners, &corners[..1]].concat();
    let pieces: Vec<_> = places.iter().map(|&p| around(p, &closed)).collect();
    canvas.lines(&pieces, Pen::solid(colour, FINE));
}

/// A mark of two strokes.
fn strokes(canvas: &mut Canvas, places: &[CanvasPoint], two: [[CanvasPoint; 2]; 2], colour: Colour) {
    let pieces: Vec<_> = places.iter().flat_map(|&p| two.iter().map(move |s| around(p, s))).collect();
    canvas.lines(&pieces, Pen::solid(colour, FINE));
}

fn around(at: CanvasPoint, offsets: &[CanvasPoint]) -> Vec<CanvasPoint> {
    offsets.iter().map(|o| (at.0 + o.0, at.1 + o.1)).collect()
}

/// Height of a bar of colours.
const BAR: f64 = 26.0;
/// Free length at both ends of a bar, for the outer halves of its labels.
const ENDS: f64 = 60.0;
/// Smallest distance of two labels of a bar.
const APART: f64 = 14.0;

/// A bar of colours in a legend of a width, with its upper left corner at `at`.
fn bar(canvas: &mut Canvas, layer: &Layer, at: CanvasPoint, width: f64) {
    let Shape::Bar { colours, limits } = &layer.shape else { return };
    let unit = layer.entry().unwrap_or_default();
    let length = width - 2.0 * ENDS - text_width(unit, SMALL);
    let (left, top) = (at.0 + ENDS, at.1 + 0.5 * (ENTRY - BAR));
    let place = |k: usize| left + length * k as f64 / colours.len() as f64;
    for (k, colour) in colours.iter().enumerate() {
        canvas.rectangles(&[[(place(k), top), (place(k + 1), top + BAR)]], *colour);
    }
    let right = left + length;
    let frame = vec![(left, top), (right, top), (right, top + BAR), (left, top + BAR), (left, top)];
    canvas.lines(&[frame], Pen::solid(BLACK, 3.0));
    let writing =
        Writing { size: SMALL, colour: BLACK, along: Along::Middle, across: Across::Top, upwards: false };
    let mut free = f64::NEG_INFINITY;
    for (k, label) in limits.iter().enumerate() {
        let half = 0.5 * text_width(label, SMALL);
        if place(k) - half >= free {
            canvas.text((place(k), top + BAR + 4.0), label, &writing);
            free = place(k) + half + APART;
        }
    }
    let beside = Writing { along: Along::Start, across: Across::Centre, ..writing };
    canvas.text((right + ENDS, top + 0.5 * BAR), unit, &beside);
}

/// Text of an entry in lines, for a legend of a width.
pub(super) fn entry_lines(layer: &Layer, width: f64) -> Vec<String> {
    if let Shape::Bar { .. } = layer.shape {
        // The bar, and its labels below.
        return vec![String::new(); 2];
    }
    wrapped(layer.entry().unwrap_or_default(), SMALL, width - SAMPLE - SPACE)
}

/// One entry of a legend of a width, with its upper left corner at `at`.
pub(super) fn entry(canvas: &mut Canvas, layer: &Layer, at: CanvasPoint, width: f64) {
    let (left, right, y) = (at.0, at.0 + SAMPLE, at.1 + 0.5 * ENTRY);
    match &layer.shape {
        Shape::Lines { width, dash, .. } => {
            stroke(canvas, &[vec![(left, y), (right, y)]], pen(layer, *width, *dash));
        }
        Shape::Marks { radius, mark: form, .. } => {
            marks(canvas, &[(0.5 * (left + right), y)], layer.tint(), (*radius).max(5), *form);
        }
        Shape::Band { opacity, .. } => {
            let (top, bottom) = (y - 17.0, y + 17.0);
            let corners = vec![(left, top), (right, top), (right, bottom), (left, bottom)];
            canvas.polygon(&corners, layer.colour, *opacity);
            let closed = [corners.clone(), vec![corners[0]]].concat();
            canvas.lines(&[closed], Pen::solid(BLACK, 3.0));
        }
        Shape::Bar { .. } => bar(canvas, layer, at, width),
        Shape::Cells { .. } | Shape::Text { .. } => {}
    }
    let writing =
        Writing { size: SMALL, colour: BLACK, along: Along::Start, across: Across::Centre, upwards: false };
    for (k, line) in entry_lines(layer, width).iter().enumerate() {
        canvas.text((right + SPACE, y + k as f64 * ENTRY_LINE), line, &writing);
    }
}

/// Width of an entry of a legend of a width.
pub(super) fn entry_width(layer: &Layer, width: f64) -> f64 {
    if let Shape::Bar { .. } = layer.shape {
        return width;
    }
    let lines = entry_lines(layer, width);
    SAMPLE + SPACE + lines.iter().map(|line| text_width(line, SMALL)).fold(0.0, f64::max)
}
