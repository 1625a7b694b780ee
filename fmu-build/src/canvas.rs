//! What pictures share: the embedded font, colours, and rendering to PNG and SVG.

use crate::error::{Error, Result};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};
use std::sync::Once;

/// Font of all labels, embedded so that no font has to be installed.
pub const FONT: &str = "DejaVu Sans";
static FONT_DATA: &[u8] = include_bytes!("../../assets/DejaVuSans.ttf");

/// Okabe–Ito colours: told apart by colour-blind eyes, and in print by their lightness.
pub mod colour {
    use plotters::style::RGBColor;
    /// Box.
    pub const BLUE: RGBColor = RGBColor(0, 114, 178);
    /// Block.
    pub const VERMILLION: RGBColor = RGBColor(213, 94, 0);
    /// Secondary oscillator.
    pub const GREEN: RGBColor = RGBColor(0, 158, 115);
    /// Stops, frames.
    pub const BLACK: RGBColor = RGBColor(0, 0, 0);
    /// Ground, grids.
    pub const GREY: RGBColor = RGBColor(140, 140, 140);
}

/// A drawing, on any backend.
pub trait Drawing {
    /// Its name, for messages.
    const NAME: &'static str;
    /// Its size in units of the drawing.
    const SIZE: (u32, u32);
    /// Draws it.
    ///
    /// # Errors
    /// What the drawing library reports, as text.
    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> std::result::Result<(), String>;
}

fn register() {
    static ONCE: Once = Once::new();
    // A second registration would only replace the font by itself.
    ONCE.call_once(|| drop(register_font(FONT, FontStyle::Normal, FONT_DATA)));
}

fn failed<D: Drawing>(problem: impl ToString) -> Error {
    Error::Picture { what: D::NAME, problem: problem.to_string() }
}

/// As a PNG file, averaged down `shrink` times from the size of the drawing, which smooths its edges.
///
/// # Errors
/// [`Error::Picture`], [`Error::File`].
pub fn png<D: Drawing>(drawing: &D, shrink: u32) -> Result<Vec<u8>> {
    register();
    let (width, height) = D::SIZE;
    let mut fine = vec![255; (width * height * 3) as usize];
    {
        let area = BitMapBackend::with_buffer(&mut fine, D::SIZE).into_drawing_area();
        drawing.draw(&area).map_err(failed::<D>)?;
        area.present().map_err(failed::<D>)?;
    }
    // The backend writes PNG to a path only.
    let folder = tempfile::tempdir().map_err(Error::file("making a folder in", &std::env::temp_dir()))?;
    let path = folder.path().join("picture.png");
    {
        let backend = BitMapBackend::new(&path, (width / shrink, height / shrink));
        let area = backend.into_drawing_area();
        for y in 0..height / shrink {
            for x in 0..width / shrink {
                let mean = |channel: u32| {
                    let block = (0..shrink * shrink).map(|i| {
                        let (column, row) = (x * shrink + i % shrink, y * shrink + i / shrink);
                        u32::from(fine[((row * width + column) * 3 + channel) as usize])
                    });
                    ((block.sum::<u32>() + shrink * shrink / 2) / (shrink * shrink)) as u8
                };
                let colour = RGBColor(mean(0), mean(1), mean(2));
                area.draw_pixel((x as i32, y as i32), &colour).map_err(failed::<D>)?;
            }
        }
        area.present().map_err(failed::<D>)?;
    }
    std::fs::read(&path).map_err(Error::file("reading", &path))
}

/// As SVG text, shown `shrink` times smaller than the size of the drawing.
///
/// # Errors
/// [`Error::Picture`].
pub fn svg<D: Drawing>(drawing: &D, shrink: u32) -> Result<String> {
    register();
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, D::SIZE).into_drawing_area();
        drawing.draw(&area).map_err(failed::<D>)?;
        area.present().map_err(failed::<D>)?;
    }
    // The backend rounds to whole units: a large canvas, scaled down, keeps curves smooth.
    let (width, height) = D::SIZE;
    let size = |w, h| format!("width=\"{w}\" height=\"{h}\" viewBox");
    let scaled = text.replacen(&size(width, height), &size(width / shrink, height / shrink), 1);
    let spare = format!("font-family=\"{FONT}\"");
    Ok(scaled.replace(&spare, &format!("font-family=\"{FONT}, Verdana, sans-serif\"")))
}
