//! Text on a drawing area, and the sizes that legends share.

use super::canvas::FONT;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Text of ticks and legends.
pub(super) const SMALL: u32 = 36;
/// Height of a line of a legend and width of its sample.
pub(super) const ENTRY: i32 = 54;
pub(super) const SAMPLE: i32 = 110;
/// Combining circumflex, and the same as a character of its own.
const HAT: char = '\u{302}';
const HAT_ALONE: &str = "\u{2c6}";

pub(super) type Drawn = std::result::Result<(), String>;
pub(super) type Area<'a, DB> = &'a DrawingArea<DB, Shift>;

pub(super) fn failed<E: std::error::Error + Send + Sync>(e: DrawingAreaErrorKind<E>) -> String {
    e.to_string()
}

pub(super) fn style(size: u32, colour: RGBColor, h: HPos, v: VPos) -> TextStyle<'static> {
    TextStyle { font: (FONT, size).into_font(), color: colour.to_backend_color(), pos: Pos::new(h, v) }
}

/// Writes text. A combining circumflex is drawn as a circumflex of its own over the middle of its letter, since the
/// bitmap backend knows no combining characters.
pub(super) fn text<DB: DrawingBackend>(
    area: Area<DB>,
    at: (i32, i32),
    words: &str,
    style: &TextStyle,
) -> Drawn {
    let plain: String = words.chars().filter(|c| *c != HAT).collect();
    area.draw_text(&plain, style, at).map_err(failed)?;
    if plain.len() == words.len() {
        return Ok(());
    }
    let size = style.font.get_size();
    let upright = style.clone().transform(FontTransform::None);
    let width = |part: &str| -> Result<f64, String> {
        Ok(f64::from(area.estimate_text_size(part, &upright).map_err(failed)?.0))
    };
    let before = match style.pos.h_pos {
        HPos::Left => 0.0,
        HPos::Center => 0.5 * width(&plain)?,
        HPos::Right => width(&plain)?,
    };
    let mut letters = String::new();
    for letter in words.chars() {
        if letter == HAT {
            let until = width(&letters)?;
            let base = letters.pop().unwrap_or(' ');
            let middle = 0.5 * (until + width(&letters)?) - before;
            letters.push(base);
            let along = middle.round() as i32;
            // Tall letters lift it; it stands on the same line otherwise.
            let lift = (size * if base.is_uppercase() || "fβ".contains(base) { 0.17 } else { 0.0 }) as i32;
            let turned = matches!(style.font.get_transform(), FontTransform::Rotate270);
            let spot = if turned { (at.0 - lift, at.1 - along) } else { (at.0 + along, at.1 - lift) };
            let mut centred = style.clone();
            centred.pos.h_pos = HPos::Center;
            area.draw_text(HAT_ALONE, &centred, spot).map_err(failed)?;
        } else {
            letters.push(letter);
        }
    }
    Ok(())
}
