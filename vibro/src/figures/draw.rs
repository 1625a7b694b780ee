//! Lays a figure out: title, panels, shared legend, caption.

use super::canvas::palette::BLACK;
use super::canvas::{Drawing, PNG_SHRINK, SVG_SHRINK};
use super::chart::{Figure, Layer};
use super::panel::draw_panel;
use super::symbols::entry;
use super::text::{Area, Drawn, ENTRY, SAMPLE, SMALL, failed, style, text};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

const TITLE: u32 = 46;
const CAPTION: u32 = 32;
/// Room around the panels and between lines of text.
const RELATIVE: u32 = 30;
const CAPTION_COLOUR: RGBColor = RGBColor(70, 70, 70);
/// An upper estimate of a letter's mean width in parts of its height, for line breaks.
const LETTER: f64 = 0.57;

impl Figure {
    fn rows(&self) -> u32 {
        self.panels.len().div_ceil(self.columns.max(1)) as u32
    }

    fn width(&self) -> u32 {
        self.panel.0 * self.columns.max(1) as u32 + 2 * RELATIVE
    }

    fn head(&self) -> u32 {
        2 * RELATIVE + TITLE
    }

    /// Lines of the shared legend, with as many entries as fit by that estimate.
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
            let wide = f64::from(SAMPLE + 2 * RELATIVE as i32) + letters;
            if used + wide > f64::from(self.width() - 4 * RELATIVE) {
                lines.push(Vec::new());
                used = 0.0;
            }
            used += wide;
            lines.last_mut().into_iter().for_each(|line| line.push(layer));
        }
        lines
    }

    /// The caption broken into lines that fit by that estimate.
    fn caption_lines(&self) -> Vec<String> {
        let letters = (f64::from(self.width() - 4 * RELATIVE) / (LETTER * f64::from(CAPTION))) as usize;
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
        let caption = self.caption_lines().len() as u32 * (CAPTION + RELATIVE / 2);
        let height = self.head() + self.panel.1 * self.rows() + legend + caption + 3 * RELATIVE;
        // Whole pixels of either file.
        let whole = |size: u32| size.next_multiple_of(SVG_SHRINK * PNG_SHRINK);
        (whole(self.width()), whole(height))
    }

    fn draw<DB: DrawingBackend>(&self, area: Area<DB>) -> Drawn {
        area.fill(&WHITE).map_err(failed)?;
        let middle = self.width() as i32 / 2;
        text(area, (middle, RELATIVE as i32), &self.title, &style(TITLE, BLACK, HPos::Center, VPos::Top))?;
        for (i, panel) in self.panels.iter().enumerate() {
            let (column, row) = ((i % self.columns.max(1)) as u32, (i / self.columns.max(1)) as u32);
            let at = (RELATIVE + column * self.panel.0, self.head() + row * self.panel.1);
            draw_panel(area, panel, at, self.panel, !self.shared_legend)?;
        }
        let mut y = (self.head() + self.panel.1 * self.rows() + RELATIVE / 2) as i32;
        for line in self.legend_lines() {
            let mut x = 2 * RELATIVE as i32;
            for layer in line {
                x = entry(area, layer, (x, y))? + 2 * RELATIVE as i32;
            }
            y += ENTRY;
        }
        y += RELATIVE as i32 / 2;
        for line in self.caption_lines() {
            text(
                area,
                (2 * RELATIVE as i32, y),
                &line,
                &style(CAPTION, CAPTION_COLOUR, HPos::Left, VPos::Top),
            )?;
            y += (CAPTION + RELATIVE / 2) as i32;
        }
        Ok(())
    }
}
