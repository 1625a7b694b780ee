//! Layout of a figure: title, panels, legends, caption.

use crate::canvas::palette::BLACK;
use crate::canvas::{Across, Along, Canvas, Colour, Drawing, PNG_SHRINK, SVG_SHRINK, Writing, text_width};
use crate::chart::{Figure, Layer};
use crate::panel::Layout;
use crate::symbols::{ENTRY, entry, entry_width};

/// Font sizes of title and caption.
const TITLE: f64 = 40.0;
const CAPTION: f64 = 28.0;
/// Height of the title's line and of a line of the caption.
const TITLE_LINE: u32 = 46;
const CAPTION_LINE: u32 = 47;
/// Space around the panels and between lines of text.
const GAP: u32 = 30;
const CAPTION_COLOUR: Colour = Colour(70, 70, 70);

/// A laid-out figure.
struct Page<'f> {
    panels: Vec<Layout<'f>>,
    /// Lines of the legend below each panel; empty if all panels share one legend.
    own: Vec<Vec<Vec<&'f Layer>>>,
    /// Lines of the legend below all panels.
    shared: Vec<Vec<&'f Layer>>,
}

impl<'f> Page<'f> {
    fn new(figure: &'f Figure) -> Self {
        let mut panels: Vec<_> = figure.panels.iter().map(|p| Layout::new(p, figure.panel)).collect();
        if !figure.shared_legend {
            panels.iter_mut().for_each(Layout::name_all_or_none);
        }
        let (mut own, mut shared) = (Vec::new(), Vec::new());
        if figure.shared_legend {
            // A curve that is named in one panel is identified by its colour in the others.
            let named = |layer: &Layer| panels.iter().any(|p: &Layout| p.names_like(layer));
            let entries = panels.iter().flat_map(|p| p.entries.iter().copied());
            shared = legend(entries.filter(|layer| !named(layer)), f64::from(figure.width() - 4 * GAP));
        } else {
            let width = f64::from(figure.panel.0 - 3 * GAP);
            own = panels.iter().map(|p| legend(p.entries.iter().copied(), width)).collect();
        }
        Self { panels, own, shared }
    }

    /// Height of the legend below each panel: equal for all panels, so that they have equal sizes.
    fn under(&self) -> u32 {
        self.own.iter().map(|l| l.len() as u32 * ENTRY as u32).max().unwrap_or(0)
    }
}

/// Lines of a legend no wider than `width`, with one entry for each name.
fn legend<'f>(layers: impl Iterator<Item = &'f Layer>, width: f64) -> Vec<Vec<&'f Layer>> {
    let mut lines: Vec<Vec<&Layer>> = Vec::new();
    let mut used = f64::INFINITY;
    let mut names = std::collections::BTreeSet::new();
    for layer in layers.filter(|l| names.insert(l.entry())) {
        let wide = entry_width(layer) + f64::from(2 * GAP);
        if used + wide > width {
            lines.push(Vec::new());
            used = 0.0;
        }
        used += wide;
        lines.last_mut().into_iter().for_each(|line| line.push(layer));
    }
    lines
}

fn draw_legend(canvas: &mut Canvas, lines: &[Vec<&Layer>], (left, top): (f64, f64)) {
    for (i, line) in lines.iter().enumerate() {
        let mut x = left;
        for layer in line {
            entry(canvas, layer, (x, top + i as f64 * ENTRY));
            x += entry_width(layer) + f64::from(2 * GAP);
        }
    }
}

/// A text whose symbols, values and units stay together: `k₁ = 48 kN/m`.
fn unbroken(paragraph: &str) -> String {
    let paragraph = paragraph.replace(" = ", "\u{a0}=\u{a0}");
    let mut text = String::new();
    for word in paragraph.split(' ') {
        let before = text.rsplit(' ').next().unwrap_or_default();
        let value = before.contains('=') && before.ends_with(|c: char| c.is_ascii_digit());
        let unit = value && word.starts_with(|c: char| c.is_alphabetic() || c == '°');
        if !text.is_empty() {
            text.push(if unit { '\u{a0}' } else { ' ' });
        }
        text.push_str(word);
    }
    text
}

impl Figure {
    fn rows(&self) -> u32 {
        self.panels.len().div_ceil(self.columns.max(1)) as u32
    }

    fn width(&self) -> u32 {
        self.panel.0 * self.columns.max(1) as u32 + 2 * GAP
    }

    fn head(&self) -> u32 {
        2 * GAP + TITLE_LINE
    }

    /// The caption broken into lines that fit.
    fn caption_lines(&self) -> Vec<String> {
        let room = f64::from(self.width() - 4 * GAP);
        let mut lines = Vec::new();
        for paragraph in &self.caption {
            let mut line = String::new();
            for word in unbroken(paragraph).split(' ') {
                if !line.is_empty() && text_width(&format!("{line} {word}"), CAPTION) > room {
                    lines.push(std::mem::take(&mut line));
                }
                if !line.is_empty() {
                    line.push(' ');
                }
                line.push_str(word);
            }
            lines.push(line);
        }
        lines.into_iter().map(|line| line.replace('\u{a0}', " ")).collect()
    }
}

impl Drawing for Figure {
    fn size(&self) -> (u32, u32) {
        let page = Page::new(self);
        let panels = (self.panel.1 + page.under()) * self.rows();
        let legend = page.shared.len() as u32 * ENTRY as u32;
        let caption = self.caption_lines().len() as u32 * CAPTION_LINE;
        // The size is a whole number of pixels in both files.
        let whole = |size: u32| size.next_multiple_of(SVG_SHRINK * PNG_SHRINK);
        (whole(self.width()), whole(self.head() + panels + legend + caption + 3 * GAP))
    }

    fn draw(&self, canvas: &mut Canvas) {
        let page = Page::new(self);
        let gap = f64::from(GAP);
        let style =
            |size, colour, along| Writing { size, colour, along, across: Across::Top, upwards: false };
        let middle = 0.5 * f64::from(self.width());
        canvas.text((middle, gap), &self.title, &style(TITLE, BLACK, Along::Middle));
        let columns = self.columns.max(1);
        let row_height = self.panel.1 + page.under();
        for (i, panel) in page.panels.iter().enumerate() {
            let (column, row) = ((i % columns) as u32, (i / columns) as u32);
            let at = (f64::from(GAP + column * self.panel.0), f64::from(self.head() + row * row_height));
            canvas.moved(at, |canvas| {
                panel.draw(canvas);
                if let Some(lines) = page.own.get(i) {
                    draw_legend(canvas, lines, (2.0 * gap, f64::from(self.panel.1) - 0.5 * gap));
                }
            });
        }
        let mut y = f64::from(self.head() + row_height * self.rows()) + 0.5 * gap;
        draw_legend(canvas, &page.shared, (2.0 * gap, y));
        y += page.shared.len() as f64 * ENTRY + 0.5 * gap;
        for line in self.caption_lines() {
            canvas.text((2.0 * gap, y), &line, &style(CAPTION, CAPTION_COLOUR, Along::Start));
            y += f64::from(CAPTION_LINE);
        }
    }
}
