//! Strokes, marks, areas and their samples in legends.

use super::canvas::palette::BLACK;
use super::chart::{Colour, Dash, Layer, Mark, Shape};
use super::draw::{Area, Drawn, ENTRY, SAMPLE, SMALL, failed, style, text};
use super::scale::dashes;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

/// Points nearer than this on a path are one.
const NEAR: f64 = 1.5;

fn whole((x, y): (f64, f64)) -> (i32, i32) {
    (x.round() as i32, y.round() as i32)
}

/// A path without points that its neighbours hide: strokes of many tiny segments come out ragged.
fn thinned(path: &[(f64, f64)]) -> Vec<(i32, i32)> {
    let mut kept: Vec<(f64, f64)> = Vec::new();
    for (i, &point) in path.iter().enumerate() {
        let far = |k: &(f64, f64)| (point.0 - k.0).hypot(point.1 - k.1) >= NEAR;
        if kept.last().is_none_or(far) {
            kept.push(point);
        } else if i + 1 == path.len() && kept.len() > 1 {
            kept.pop();
            kept.push(point);
        }
    }
    kept.into_iter().map(whole).collect()
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
        let points = thinned(&piece);
        if points.len() > 1 {
            area.draw(&PathElement::new(points, colour.stroke_width(width))).map_err(failed)?;
        }
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
            area.draw(&Rectangle::new(corners, BLACK.stroke_width(2))).map_err(failed)?;
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
