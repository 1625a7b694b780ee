//! Figures of a width in print: letters, lines and marks keep their sizes in points.

use crate::canvas::{About, Canvas, Drawing};
use crate::chart::Figure;
use crate::draw::MARGINS;
use crate::panel::ROOM;
use crate::symbols::SMALL;

/// Font size of ticks and legends in print, points.
pub const POINTS: f64 = 7.0;
/// Millimetres in a point.
const MILLIMETRES: f64 = 25.4 / 72.0;
/// Smallest width of a panel, in units; if more panels do not fit beside each other, rows have
/// fewer panels.
const NARROWEST: u32 = 940;
/// Smallest height of a frame, in units.
const LOWEST: f64 = 420.0;

/// Number of units in a width in print, mm, if letters of the size `font` have [`POINTS`] points.
pub fn units(millimetres: f64, font: f64) -> f64 {
    millimetres / MILLIMETRES * font / POINTS
}

/// A figure laid out for a width in print.
#[derive(Clone, Debug)]
pub struct Printed {
    figure: Figure,
    millimetres: f64,
}

impl Figure {
    /// The figure for a width in print, mm: 84 for one column of a journal, 174 for two. Its small
    /// letters have [`POINTS`] points; panels become narrower, with fewer in a row if needed.
    #[must_use]
    pub fn printed(&self, millimetres: f64) -> Printed {
        let units = units(millimetres, SMALL).round() as u32;
        let room = units.saturating_sub(MARGINS).max(1);
        let columns = self.columns.clamp(1, (room / NARROWEST).max(1) as usize);
        let wide = room / columns as u32;
        let [left, top, right, bottom] = ROOM.map(f64::from);
        let (before, after) = (f64::from(self.panel.0) - left - right, f64::from(wide) - left - right);
        let high = (f64::from(self.panel.1) - top - bottom) * after / before;
        let panel = (wide, (high.max(LOWEST) + top + bottom) as u32);
        Printed { figure: Figure { columns, panel, ..self.clone() }, millimetres }
    }
}

impl Drawing for Printed {
    fn size(&self) -> (u32, u32) {
        (units(self.millimetres, SMALL).round() as u32, self.figure.size().1)
    }

    fn draw(&self, canvas: &mut Canvas) {
        self.figure.draw(canvas);
    }

    fn about(&self) -> About {
        self.figure.about()
    }

    fn millimetres(&self) -> Option<f64> {
        Some(self.millimetres)
    }
}
