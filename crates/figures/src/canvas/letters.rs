//! The embedded font: text widths, positions of baselines, and outlines of letters.

use super::Across;
use std::sync::OnceLock;
use tiny_skia::{Path, PathBuilder};
use ttf_parser::{Face, GlyphId, OutlineBuilder};

/// Font of all labels, embedded so that no font has to be installed.
pub const FONT: &str = "DejaVu Sans";
/// The file of the font.
#[cfg(not(target_family = "wasm"))]
pub static FONT_DATA: &[u8] = include_bytes!("../../../../assets/DejaVuSans.ttf");
/// The font's file; in a page only the letters of names and units, 24 kB instead of 756 kB.
#[cfg(target_family = "wasm")]
pub static FONT_DATA: &[u8] = include_bytes!("../../../../assets/DejaVuSans-page.ttf");

/// Height of a capital, depth of a descender and height of a line above the baseline, in ems.
const CAPITAL: f64 = 0.729;
const DESCENDER: f64 = 0.236;
const ASCENDER: f64 = 0.928;

/// The combining circumflex, drawn above the preceding letter without advance width.
const CIRCUMFLEX: char = '\u{302}';
/// Largest height of a letter, in ems, below the font's circumflex without touching it.
const LOW_LETTER: f64 = 0.56;

/// Distance from a text's anchor down to its baseline, in ems.
pub(super) fn drop(across: Across) -> f64 {
    match across {
        Across::Top => ASCENDER,
        Across::Centre => 0.5 * CAPITAL,
        Across::Bottom => -DESCENDER,
    }
}

fn face() -> Option<&'static Face<'static>> {
    static FACE: OnceLock<Option<Face<'static>>> = OnceLock::new();
    FACE.get_or_init(|| Face::parse(FONT_DATA, 0).ok()).as_ref()
}

/// Glyph and advance width of a letter, in font units; an empty box for a letter that the font
/// lacks.
fn glyph(face: &Face<'_>, letter: char) -> (GlyphId, f64) {
    let glyph = face.glyph_index(letter).unwrap_or(GlyphId(0));
    (glyph, f64::from(face.glyph_hor_advance(glyph).unwrap_or(0)))
}

/// Width of a text with font size `size`, in units of the drawing.
pub fn text_width(words: &str, size: f64) -> f64 {
    let Some(face) = face() else { return 0.0 };
    let sum: f64 = words.chars().filter(|c| *c != CIRCUMFLEX).map(|c| glyph(face, c).1).sum();
    sum * size / f64::from(face.units_per_em())
}

/// A text broken at spaces into lines no wider than `room`; a longer word is a line of its own.
pub fn wrapped(text: &str, size: f64, room: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(line) if text_width(&format!("{line} {word}"), size) <= room => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// A pen that moves from glyph to glyph and records their outlines, y downwards.
struct Outlines {
    path: PathBuilder,
    scale: f64,
    /// Position of the glyph's origin.
    origin: (f64, f64),
}

impl Outlines {
    fn at(&self, x: f32, y: f32) -> (f32, f32) {
        let (x, y) = (f64::from(x), f64::from(y));
        ((self.origin.0 + self.scale * x) as f32, (self.origin.1 - self.scale * y) as f32)
    }
}

impl OutlineBuilder for Outlines {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.move_to(x, y);
    }
    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.line_to(x, y);
    }
    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.at(x1, y1), self.at(x, y));
        self.path.quad_to(x1, y1, x, y);
    }
    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.at(x1, y1), self.at(x2, y2), self.at(x, y));
        self.path.cubic_to(x1, y1, x2, y2, x, y);
    }
    fn close(&mut self) {
        self.path.close();
    }
}

/// Outlines of a text with font size `size` that begins at `start` on its baseline. `None` if it
/// has no visible letter.
pub(super) fn outlines(words: &str, size: f64, start: f64) -> Option<Path> {
    let face = face()?;
    let scale = size / f64::from(face.units_per_em());
    let mut pen = Outlines { path: PathBuilder::new(), scale, origin: (start, 0.0) };
    let mut before = None;
    for letter in words.chars() {
        let (glyph, advance) = glyph(face, letter);
        if letter == CIRCUMFLEX {
            let next = pen.origin;
            if let Some(origin) = before.and_then(|(base, at)| over(face, base, glyph, at, scale)) {
                pen.origin = origin;
                face.outline_glyph(glyph, &mut pen);
            }
            pen.origin = next;
            continue;
        }
        face.outline_glyph(glyph, &mut pen);
        before = Some((glyph, pen.origin.0));
        pen.origin.0 += scale * advance;
    }
    pen.path.finish()
}

/// The origin of an accent centred above a letter with its origin at `at`, raised for a high
/// letter.
fn over(face: &Face<'_>, base: GlyphId, accent: GlyphId, at: f64, scale: f64) -> Option<(f64, f64)> {
    let (base, accent) = (face.glyph_bounding_box(base)?, face.glyph_bounding_box(accent)?);
    let middle = |b: ttf_parser::Rect| 0.5 * (f64::from(b.x_min) + f64::from(b.x_max));
    let raised = (f64::from(base.y_max) - LOW_LETTER * f64::from(face.units_per_em())).max(0.0);
    Some((at + scale * (middle(base) - middle(accent)), -scale * raised))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Outlines and advance widths equal the whole font's, so the page's pictures equal the
    /// packager's.
    #[test]
    fn second_method_letters_of_the_pages_font_are_those_of_the_whole_one() {
        let part = Face::parse(include_bytes!("../../../../assets/DejaVuSans-page.ttf"), 0).unwrap();
        let whole = face().unwrap();
        assert_eq!(part.units_per_em(), whole.units_per_em());
        let drawn = |face: &Face<'_>, letter: char| {
            let mut pen = Outlines { path: PathBuilder::new(), scale: 1.0, origin: (0.0, 0.0) };
            let (glyph, advance) = glyph(face, letter);
            face.outline_glyph(glyph, &mut pen);
            (advance, pen.path.finish())
        };
        for letter in (' '..='~').chain("\u{2212}\u{b7}\u{e4}\u{f6}\u{fc}\u{3c9}".chars()) {
            assert_eq!(drawn(&part, letter), drawn(whole, letter), "{letter}");
        }
    }
}
