//! Layout of a figure: title, panels, legends.

use crate::canvas::palette::BLACK;
use crate::canvas::{About, Across, Along, Canvas, Drawing, PNG_SHRINK, SVG_SHRINK, Writing, wrapped};
use crate::chart::{Figure, Layer};
use crate::panel::{Layout, around};
use crate::symbols::{ENTRY, ENTRY_LINE, entry, entry_lines, entry_width};

/// Font size of the title, and height of its line.
const TITLE: f64 = 40.0;
const TITLE_LINE: u32 = 46;
/// Space around the panels and between lines of text.
const GAP: u32 = 30;
/// Width of both margins of a figure.
pub(super) const MARGINS: u32 = 2 * GAP;

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
        let texts = figure.panels.iter().map(|panel| around(panel, figure.panel));
        let lines = texts.fold([1; 3], |most, own| [0, 1, 2].map(|k| own[k].len().max(most[k])));
        let mut panels: Vec<_> = figure.panels.iter().map(|p| Layout::new(p, figure.panel, lines)).collect();
        if !figure.shared_legend {
            panels.iter_mut().for_each(Layout::name_all_or_none);
        }
        let (mut own, mut shared) = (Vec::new(), Vec::new());
        if figure.shared_legend {
            // A curve that is named in one panel is identified by its colour in the others.
            let named = |layer: &Layer| panels.iter().any(|p: &Layout| p.names_like(layer));
            let entries = panels.iter().flat_map(|p| p.entries.iter().copied());
            shared = legend(entries.filter(|layer| !named(layer)), figure.legend_width());
        } else {
            let width = figure.legend_width();
            own = panels.iter().map(|p| legend(p.entries.iter().copied(), width)).collect();
        }
        Self { panels, own, shared }
    }

    /// Height of the legend below each panel: equal for all panels, so that they have equal sizes.
    fn under(&self, width: f64) -> u32 {
        self.own.iter().map(|lines| height(lines, width)).max().unwrap_or(0)
    }
}

/// Height of a line of a legend of a width, with entries of one or more lines of text.
fn line_height(line: &[&Layer], width: f64) -> f64 {
    let most = line.iter().map(|layer| entry_lines(layer, width).len()).max().unwrap_or(1);
    ENTRY + ENTRY_LINE * most.saturating_sub(1) as f64
}

/// Height of a legend of a width.
fn height(lines: &[Vec<&Layer>], width: f64) -> u32 {
    lines.iter().map(|line| line_height(line, width)).sum::<f64>() as u32
}

/// Lines of a legend no wider than `width`, with one entry for each name.
fn legend<'f>(layers: impl Iterator<Item = &'f Layer>, width: f64) -> Vec<Vec<&'f Layer>> {
    let mut lines: Vec<Vec<&Layer>> = Vec::new();
    let mut used = f64::INFINITY;
    let mut names = std::collections::BTreeSet::new();
    for layer in layers.filter(|l| names.insert(l.entry())) {
        let wide = entry_width(layer, width) + f64::from(2 * GAP);
        if used + wide > width + f64::from(2 * GAP) {
            lines.push(Vec::new());
            used = 0.0;
        }
        used += wide;
        lines.last_mut().into_iter().for_each(|line| line.push(layer));
    }
    lines
}

fn draw_legend(canvas: &mut Canvas, lines: &[Vec<&Layer>], (left, top): (f64, f64), width: f64) {
    let mut y = top;
    for line in lines {
        let mut x = left;
        for layer in line {
            entry(canvas, layer, (x, y), width);
            x += entry_width(layer, width) + f64::from(2 * GAP);
        }
        y += line_height(line, width);
    }
}

impl Figure {
    fn rows(&self) -> u32 {
        self.panels.len().div_ceil(self.columns.max(1)) as u32
    }

    fn width(&self) -> u32 {
        self.panel.0 * self.columns.max(1) as u32 + MARGINS
    }

    /// The title in lines.
    fn title_lines(&self) -> Vec<String> {
        wrapped(&self.title, TITLE, f64::from(self.width() - 2 * GAP))
    }

    fn head(&self) -> u32 {
        2 * GAP + TITLE_LINE * self.title_lines().len() as u32
    }

    /// Width of a legend: of the panel, or with a shared legend of the figure.
    fn legend_width(&self) -> f64 {
        f64::from(if self.shared_legend { self.width() } else { self.panel.0 } - 3 * GAP)
    }

    /// The caption in words: what each panel shows, then the paragraphs.
    pub fn caption_text(&self) -> String {
        let panels = self.panels.iter().map(|panel| {
            let over = format!("{}, over {}.", panel.y.label, panel.x.label);
            if panel.title.is_empty() { over } else { format!("{}: {over}", panel.title) }
        });
        panels.chain(self.caption.iter().cloned()).collect::<Vec<_>>().join("\n")
    }
}

impl Drawing for Figure {
    fn size(&self) -> (u32, u32) {
        let page = Page::new(self);
        let panels = (self.panel.1 + page.under(self.legend_width())) * self.rows();
        let legend = height(&page.shared, self.legend_width());
        // The size is a whole number of pixels in both files.
        let whole = |size: u32| size.next_multiple_of(SVG_SHRINK * PNG_SHRINK);
        (whole(self.width()), whole(self.head() + panels + legend + 2 * GAP))
    }

    fn draw(&self, canvas: &mut Canvas) {
        let page = Page::new(self);
        let gap = f64::from(GAP);
        let style =
            |size, colour, along| Writing { size, colour, along, across: Across::Top, upwards: false };
        let middle = 0.5 * f64::from(self.width());
        for (k, line) in (0_u32..).zip(self.title_lines()) {
            let y = gap + f64::from(k * TITLE_LINE);
            canvas.text((middle, y), &line, &style(TITLE, BLACK, Along::Middle));
        }
        let width = self.legend_width();
        let columns = self.columns.max(1);
        let row_height = self.panel.1 + page.under(width);
        for (i, panel) in page.panels.iter().enumerate() {
            let (column, row) = ((i % columns) as u32, (i / columns) as u32);
            let at = (f64::from(GAP + column * self.panel.0), f64::from(self.head() + row * row_height));
            canvas.moved(at, |canvas| {
                panel.draw(canvas);
                if let Some(lines) = page.own.get(i) {
                    draw_legend(canvas, lines, (2.0 * gap, f64::from(self.panel.1) - 0.5 * gap), width);
                }
            });
        }
        let y = f64::from(self.head() + row_height * self.rows()) + 0.5 * gap;
        draw_legend(canvas, &page.shared, (2.0 * gap, y), width);
    }

    fn about(&self) -> About {
        About { title: self.title.clone(), text: self.caption_text() }
    }
}
