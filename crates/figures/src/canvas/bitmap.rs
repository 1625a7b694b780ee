//! Marks as pixels, and the pixels as a PNG file.

use super::{Along, CanvasPoint, Colour, Mark, PNG_SHRINK, Pen, Sheet, letters};
use crate::{Error, Result};
use tiny_skia::{
    FillRule, LineCap, LineJoin, Mask, Paint, Path, PathBuilder, Pixmap, Rect, Stroke, StrokeDash, Transform,
};

/// Dots per metre in PNG files: 300 per inch.
const PIXELS_PER_METRE: u32 = 11_811;
/// Dots per metre of a PNG with a width in print: 600 per inch, as journals ask for line drawings.
const PRINTED: u32 = 23_622;

/// The whole file.
pub(super) fn file(marks: &[Mark], sheet: &Sheet) -> Result<Vec<u8>> {
    let ((width, height), about) = (sheet.size, &sheet.about);
    let (columns, rows, density) = match sheet.millimetres {
        Some(mm) => {
            let columns = (mm * 1e-3 * f64::from(PRINTED)).round().max(1.0);
            (columns as u32, (columns * f64::from(height) / f64::from(width)).round() as u32, PRINTED)
        }
        None => (width / PNG_SHRINK, height / PNG_SHRINK, PIXELS_PER_METRE),
    };
    let failed = || Error::making("a PNG file")("no memory for its pixels");
    let mut pixels = Pixmap::new(columns, rows).ok_or_else(failed)?;
    pixels.fill(tiny_skia::Color::WHITE);
    let fit = |pixels: u32, units: u32| pixels as f32 / units as f32;
    let scale = Transform::from_scale(fit(columns, width), fit(rows, height));
    Painter { pixels: &mut pixels }.marks(marks, scale, None);
    // The background is opaque, so the alpha channel contains no information.
    let colours: Vec<u8> = pixels.data().chunks(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, columns, rows);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_pixel_dims(Some(png::PixelDimensions {
        xppu: density,
        yppu: density,
        unit: png::Unit::Meter,
    }));
    for (keyword, words) in [("Title", &about.title), ("Description", &about.text)] {
        if !words.is_empty() {
            let added = encoder.add_itxt_chunk(keyword.into(), words.clone());
            added.map_err(Error::making("a PNG file"))?;
        }
    }
    let mut writer = encoder.write_header().map_err(Error::making("a PNG file"))?;
    writer.write_image_data(&colours).map_err(Error::making("a PNG file"))?;
    writer.finish().map_err(Error::making("a PNG file"))?;
    Ok(file)
}

/// Marks within a rectangle (an upper left corner and a size in units) as a PNG file with one pixel
/// for each unit, transparent where nothing is drawn.
pub(super) fn layer(marks: &[Mark], [(x, y), (w, h)]: [CanvasPoint; 2]) -> Result<Vec<u8>> {
    let (columns, rows) = (w.ceil().max(1.0) as u32, h.ceil().max(1.0) as u32);
    let failed = || Error::making("a layer of pixels")("no memory for its pixels");
    let mut pixels = Pixmap::new(columns, rows).ok_or_else(failed)?;
    let place = Transform::from_translate(-x as f32, -y as f32);
    Painter { pixels: &mut pixels }.marks(marks, place, None);
    let plain = pixels.pixels().iter().map(|pixel| pixel.demultiply());
    let colours: Vec<u8> = plain.flat_map(|c| [c.red(), c.green(), c.blue(), c.alpha()]).collect();
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, columns, rows);
    encoder.set_color(png::ColorType::Rgba);
    let mut writer = encoder.write_header().map_err(Error::making("a layer of pixels"))?;
    writer.write_image_data(&colours).map_err(Error::making("a layer of pixels"))?;
    writer.finish().map_err(Error::making("a layer of pixels"))?;
    Ok(file)
}

fn paint(Colour(r, g, b): Colour, opacity: f64) -> Paint<'static> {
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color_rgba8(r, g, b, (255.0 * opacity).round() as u8);
    paint
}

/// A path of polylines.
fn outline(pieces: &[Vec<CanvasPoint>], close: bool) -> Option<Path> {
    let mut path = PathBuilder::new();
    for piece in pieces {
        for (i, &(x, y)) in piece.iter().enumerate() {
            match i {
                0 => path.move_to(x as f32, y as f32),
                _ => path.line_to(x as f32, y as f32),
            }
        }
        if close {
            path.close();
        }
    }
    path.finish()
}

fn rectangle([(x, y), (w, h)]: [CanvasPoint; 2]) -> Option<Rect> {
    Rect::from_xywh(x as f32, y as f32, w as f32, h as f32)
}

/// Rasterizer of marks.
struct Painter<'p> {
    pixels: &'p mut Pixmap,
}

impl Painter<'_> {
    fn marks(&mut self, marks: &[Mark], place: Transform, cut: Option<&Mask>) {
        for mark in marks {
            self.mark(mark, place, cut);
        }
    }

    fn fill(&mut self, path: Option<Path>, paint: &Paint<'_>, place: Transform, cut: Option<&Mask>) {
        if let Some(path) = path {
            self.pixels.fill_path(&path, paint, FillRule::Winding, place, cut);
        }
    }

    fn stroke(&mut self, path: Option<Path>, pen: Pen, place: Transform, cut: Option<&Mask>) {
        let dash = pen.dash.and_then(|(on, off)| StrokeDash::new(vec![on as f32, off as f32], 0.0));
        let line_cap = if pen.dash.is_some() { LineCap::Butt } else { LineCap::Round };
        let stroke = Stroke {
            width: pen.width as f32,
            line_cap,
            line_join: LineJoin::Round,
            dash,
            ..Stroke::default()
        };
        if let Some(path) = path {
            self.pixels.stroke_path(&path, &paint(pen.colour, 1.0), &stroke, place, cut);
        }
    }

    fn mark(&mut self, mark: &Mark, place: Transform, cut: Option<&Mask>) {
        match mark {
            Mark::Lines { pieces, pen } => self.stroke(outline(pieces, false), *pen, place, cut),
            Mark::Polygon { corners, colour, opacity } => {
                let path = outline(std::slice::from_ref(corners), true);
                self.fill(path, &paint(*colour, *opacity), place, cut);
            }
            Mark::Rectangles { rectangles, colour, .. } => {
                let mut path = PathBuilder::new();
                rectangles.iter().filter_map(|&r| rectangle(r)).for_each(|r| path.push_rect(r));
                let sharp = Paint { anti_alias: false, ..paint(*colour, 1.0) };
                self.fill(path.finish(), &sharp, place, cut);
            }
            Mark::Circles { centres, radius, colour, edge } => {
                let mut path = PathBuilder::new();
                centres.iter().for_each(|&(x, y)| path.push_circle(x as f32, y as f32, *radius as f32));
                let path = path.finish();
                let inside = if edge.is_some() { super::palette::WHITE } else { *colour };
                self.fill(path.clone(), &paint(inside, 1.0), place, cut);
                if let Some(width) = *edge {
                    self.stroke(path, Pen::solid(*colour, width), place, cut);
                }
            }
            Mark::Text { place: at, words, size, colour, along, upwards } => {
                let before = match along {
                    Along::Start => 0.0,
                    Along::Middle => 0.5,
                    Along::End => 1.0,
                };
                let start = -before * letters::text_width(words, *size);
                let turn = if *upwards { -90.0 } else { 0.0 };
                let there = place.pre_translate(at.0 as f32, at.1 as f32).pre_rotate(turn);
                self.fill(letters::outlines(words, *size, start), &paint(*colour, 1.0), there, cut);
            }
            Mark::Tagged { marks, .. } => self.marks(marks, place, cut),
            Mark::Moved { by, marks } => {
                self.marks(marks, place.pre_translate(by.0 as f32, by.1 as f32), cut);
            }
            Mark::Clipped { rectangle, marks } => self.clipped(*rectangle, marks, place, cut),
        }
    }

    fn clipped(&mut self, corners: [CanvasPoint; 2], marks: &[Mark], place: Transform, cut: Option<&Mask>) {
        // Draws nothing if the rectangle is empty or there is not enough memory for the mask.
        let Some(edges) = rectangle(corners).map(PathBuilder::from_rect) else { return };
        let mask = match cut {
            None => Mask::new(self.pixels.width(), self.pixels.height()).map(|mut mask| {
                mask.fill_path(&edges, FillRule::Winding, true, place);
                mask
            }),
            Some(cut) => {
                let mut mask = cut.clone();
                mask.intersect_path(&edges, FillRule::Winding, true, place);
                Some(mask)
            }
        };
        if let Some(mask) = mask {
            self.marks(marks, place, Some(&mask));
        }
    }
}
