//! Lays a figure out: title, panels, shared legend, caption.

use super::canvas::palette::BLACK;
use super::canvas::{Drawing, FONT, PNG_SHRINK, SVG_SHRINK};
use super::chart::{Figure, Layer};
use super::panel::draw_panel;
use super::symbols::entry;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

const TITLE: u32 = 46;
/// Text of ticks and legends.
pub(super) const SMALL: u32 = 36;
const CAPTION: u32 = 32;
/// Room around the panels and between lines of text.
const GAP: u32 = 30;
/// Height of a line of a legend and width of its sample.
pub(super) const ENTRY: i32 = 54;
pub(super) const SAMPLE: i32 = 110;
const CAPTION_COLOUR: RGBColor = RGBColor(70, 70, 70);
/// Cautious guess of a letter's width in parts of its height, for line breaks.
const LETTER: f64 = 0.57;
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

impl Figure {
    fn rows(&self) -> u32 {
        self.panels.len().div_ceil(self.columns.max(1)) as u32
    }

    fn width(&self) -> u32 {
        self.panel.0 * self.columns.max(1) as u32 + 2 * GAP
    }

    fn head(&self) -> u32 {
        2 * GAP + TITLE
    }

    /// Lines of the shared legend, with as many entries as surely fit.
    fn legend_lines(&self) -> Vec<Vec<&Layer>> {
        let mut lines: Vec<Vec<&Layer>> = Vec::new();
        if !self.shared_legend {
            return lines;
        }
        let mut used = f64::INFINITY;
        let mut names = std::collections::BTreeSet::new();
        for layer in self.panels.iter().flat_map(|p| &p.layers) {
            let Some(name) = layer.name.as_ref().filter(|n| names.insert(n.as_str())) else { continue };
            let letters = LETTER * f64::from(SMALL) * name.chars().count() as f64;
            let wide = f64::from(SAMPLE + 2 * GAP as i32) + letters;
            if used + wide > f64::from(self.width() - 4 * GAP) {
                lines.push(Vec::new());
                used = 0.0;
            }
            used += wide;
            lines.last_mut().into_iter().for_each(|line| line.push(layer));
        }
        lines
    }

    /// The caption broken into lines that surely fit.
    fn caption_lines(&self) -> Vec<String> {
        let letters = (f64::from(self.width() - 4 * GAP) / (LETTER * f64::from(CAPTION))) as usize;
        let mut lines = Vec::new();
        for paragraph in &self.caption {
            let mut line = String::new();
            for word in paragraph.split(' ') {
                if !line.is_empty() && line.chars().count() + 1 + word.chars().count() > letters {
                    lines.push(std::mem::take(&mut line));
                }
                if !line.is_empty() {
                    line.push(' ');
                }
                line.push_str(word);
            }
            lines.push(line);
        }
        lines
    }
}

impl Drawing for Figure {
    fn size(&self) -> (u32, u32) {
        let legend = self.legend_lines().len() as u32 * ENTRY as u32;
        let caption = self.caption_lines().len() as u32 * (CAPTION + GAP / 2);
        let height = self.head() + self.panel.1 * self.rows() + legend + caption + 3 * GAP;
        // Whole pixels of either file.
        let whole = |size: u32| size.next_multiple_of(SVG_SHRINK * PNG_SHRINK);
        (whole(self.width()), whole(height))
    }

    fn draw<DB: DrawingBackend>(&self, area: Area<DB>) -> Drawn {
        area.fill(&WHITE).map_err(failed)?;
        let middle = self.width() as i32 / 2;
        text(area, (middle, GAP as i32), &self.title, &style(TITLE, BLACK, HPos::Center, VPos::Top))?;
        for (i, panel) in self.panels.iter().enumerate() {
            let (column, row) = ((i % self.columns.max(1)) as u32, (i / self.columns.max(1)) as u32);
            let at = (GAP + column * self.panel.0, self.head() + row * self.panel.1);
            draw_panel(area, panel, at, self.panel, !self.shared_legend)?;
        }
        let mut y = (self.head() + self.panel.1 * self.rows() + GAP / 2) as i32;
        for line in self.legend_lines() {
            let mut x = 2 * GAP as i32;
            for layer in line {
                x = entry(area, layer, (x, y))? + 2 * GAP as i32;
            }
            y += ENTRY;
        }
        y += GAP as i32 / 2;
        for line in self.caption_lines() {
            text(area, (2 * GAP as i32, y), &line, &style(CAPTION, CAPTION_COLOUR, HPos::Left, VPos::Top))?;
            y += (CAPTION + GAP / 2) as i32;
        }
        Ok(())
    }
}
