//! What all pictures share: the embedded font, the palette, and rendering to PNG and SVG on any machine alike.

use crate::{Error, Result};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};
use std::sync::Once;

/// Font of all labels, embedded so that no font has to be installed.
pub const FONT: &str = "DejaVu Sans";
/// The file of the font.
pub static FONT_DATA: &[u8] = include_bytes!("../../../assets/DejaVuSans.ttf");

/// Units of a drawing per pixel of its SVG. The drawing library rounds to whole units, so that fine units keep curves
/// smooth.
pub const SVG_SHRINK: u32 = 3;
/// Units of a drawing per pixel of its PNG; averaging over them smooths edges.
pub const PNG_SHRINK: u32 = 2;

/// The SVG backend divides font sizes by this.
const SVG_EM: f64 = 1.24;
/// Height of the embedded font's lines in ems (its hhea table).
const LINE_HEIGHT: f64 = 2384.0 / 2048.0;

/// Dots per metre in PNG files: 300 per inch.
const PIXELS_PER_METRE: u32 = 11_811;

/// Okabe–Ito colours: told apart by colour-blind eyes, and in print by their lightness.
pub mod palette {
    use plotters::style::RGBColor;
    /// First choice; the box, stable.
    pub const BLUE: RGBColor = RGBColor(0, 114, 178);
    /// Second choice; the block.
    pub const VERMILLION: RGBColor = RGBColor(213, 94, 0);
    /// Third choice; the secondary oscillator.
    pub const GREEN: RGBColor = RGBColor(0, 158, 115);
    /// Fourth choice.
    pub const PURPLE: RGBColor = RGBColor(204, 121, 167);
    /// Fifth choice.
    pub const ORANGE: RGBColor = RGBColor(230, 159, 0);
    /// Light; areas.
    pub const SKY: RGBColor = RGBColor(86, 180, 233);
    /// Frames, stops, exact values.
    pub const BLACK: RGBColor = RGBColor(0, 0, 0);
    /// Grids, captions, unstable areas.
    pub const GREY: RGBColor = RGBColor(140, 140, 140);
    /// Colours of a family of curves, in order.
    pub const FAMILY: [RGBColor; 5] = [BLUE, VERMILLION, GREEN, PURPLE, ORANGE];
}

/// Makes the embedded font known to the drawing library; cheap when done before.
pub fn register() {
    static ONCE: Once = Once::new();
    // A second registration would only replace the font by itself.
    ONCE.call_once(|| drop(register_font(FONT, FontStyle::Normal, FONT_DATA)));
}

/// A drawing, on any backend.
pub trait Drawing {
    /// Its size in units, [`SVG_SHRINK`] times the size of its SVG in pixels.
    fn size(&self) -> (u32, u32);
    /// Draws it on an area of that size.
    ///
    /// # Errors
    /// What the drawing library reports, as text.
    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> std::result::Result<(), String>;
}

/// As a PNG file, averaged down from the drawing's units.
///
/// # Errors
/// [`Error::Output`].
pub fn png(drawing: &impl Drawing) -> Result<Vec<u8>> {
    register();
    let (width, height) = drawing.size();
    let mut fine = vec![255; (width * height * 3) as usize];
    {
        let area = BitMapBackend::with_buffer(&mut fine, (width, height)).into_drawing_area();
        drawing.draw(&area).map_err(Error::output("a picture"))?;
        area.present().map_err(Error::output("a picture"))?;
    }
    let (columns, rows, n) = (width / PNG_SHRINK, height / PNG_SHRINK, PNG_SHRINK);
    let mut pixels = Vec::with_capacity((columns * rows * 3) as usize);
    for (y, x, channel) in (0..rows).flat_map(|y| (0..columns * 3).map(move |i| (y, i / 3, i % 3))) {
        let unit = |i: u32| fine[(((y * n + i / n) * width + x * n + i % n) * 3 + channel) as usize];
        let sum: u32 = (0..n * n).map(|i| u32::from(unit(i))).sum();
        pixels.push(((sum + n * n / 2) / (n * n)) as u8);
    }
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, columns, rows);
    encoder.set_color(png::ColorType::Rgb);
    let density = Some(PIXELS_PER_METRE);
    encoder.set_pixel_dims(density.map(|d| png::PixelDimensions {
        xppu: d,
        yppu: d,
        unit: png::Unit::Meter,
    }));
    let mut writer = encoder.write_header().map_err(Error::output("a PNG file"))?;
    writer.write_image_data(&pixels).map_err(Error::output("a PNG file"))?;
    writer.finish().map_err(Error::output("a PNG file"))?;
    Ok(file)
}

/// SVG text with other font sizes. The SVG backend divides a font's size by 1.24 to get its em; the bitmap backend, which
/// measures text for both, divides it by the height of the font's lines. This brings the former to the latter, so that words
/// are as wide as they were measured.
fn resized(svg: &str) -> String {
    const KEY: &str = "font-size=\"";
    let mut parts = svg.split(KEY);
    let mut text: String = parts.next().unwrap_or_default().into();
    for part in parts {
        text.push_str(KEY);
        let (size, rest) = part.split_once('"').unwrap_or((part, ""));
        match size.parse::<f64>() {
            Ok(size) => text.push_str(&format!("{:.2}", size * SVG_EM / LINE_HEIGHT)),
            Err(_) => text.push_str(size),
        }
        text.push('"');
        text.push_str(rest);
    }
    text
}

/// As SVG text.
///
/// # Errors
/// [`Error::Output`].
pub fn svg(drawing: &impl Drawing) -> Result<String> {
    register();
    let (width, height) = drawing.size();
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, (width, height)).into_drawing_area();
        drawing.draw(&area).map_err(Error::output("a picture"))?;
        area.present().map_err(Error::output("a picture"))?;
    }
    let size = |w, h| format!("width=\"{w}\" height=\"{h}\" viewBox");
    let scaled = text.replacen(&size(width, height), &size(width / SVG_SHRINK, height / SVG_SHRINK), 1);
    // Neighbouring cells of a plane would show seams where they share a pixel.
    let crisp = scaled.replace("<rect ", "<rect shape-rendering=\"crispEdges\" ");
    let sized = resized(&crisp);
    let spare = format!("font-family=\"{FONT}\"");
    Ok(sized.replace(&spare, &format!("font-family=\"{FONT}, Verdana, sans-serif\"")))
}
