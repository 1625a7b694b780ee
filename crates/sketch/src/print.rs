//! Sketches of a width in print.

use crate::Sketch;
use crate::sizes::FONT;
use vibro_figures::canvas::{Canvas, Drawing};
use vibro_figures::print::{POINTS, units};

/// A sketch in the middle of a width in print.
#[derive(Debug)]
pub struct Printed<'a> {
    sketch: &'a Sketch,
    millimetres: f64,
}

impl Sketch {
    /// The sketch for a width in print, mm. Names of elements have
    /// [`POINTS`] points, with white on both sides; in a sketch that
    /// is too wide for this, they have fewer.
    ///
    /// ```
    /// use vibro_machine::file::{no_records, parse};
    ///
    /// let text = "name = \"A\"\nbody.b.mass = 1.0\n\
    ///     spring.s = { between = [\"ground\", \"b\"], stiffness = 1.0 }";
    /// let sketch = vibro_sketch::Sketch::new(&parse(text, "a.toml", &no_records)?);
    /// let printed = sketch.printed(84.0);
    /// assert_eq!(printed.points(), 7.0);
    /// let svg = vibro_figures::canvas::svg(&printed).expect("all its places are finite");
    /// assert!(svg.starts_with("<svg width=\"84mm\""));
    /// # Ok::<(), vibro_machine::Refusal>(())
    /// ```
    #[must_use]
    pub fn printed(&self, millimetres: f64) -> Printed<'_> {
        Printed { sketch: self, millimetres }
    }
}

impl Printed<'_> {
    /// Points of the names of elements.
    #[must_use]
    pub fn points(&self) -> f64 {
        POINTS * (units(self.millimetres, FONT) / self.own_width()).min(1.0)
    }

    /// Width in print from which names have [`POINTS`] points, mm.
    #[must_use]
    pub fn full_width(&self) -> f64 {
        self.own_width() / units(1.0, FONT)
    }

    fn own_width(&self) -> f64 {
        f64::from(self.sketch.size().0)
    }
}

impl Drawing for Printed<'_> {
    fn size(&self) -> (u32, u32) {
        let width = units(self.millimetres, FONT).max(self.own_width());
        (width.round() as u32, self.sketch.size().1)
    }

    fn draw(&self, canvas: &mut Canvas) {
        let side = 0.5 * (f64::from(self.size().0) - self.own_width());
        canvas.moved((side, 0.0), |canvas| self.sketch.draw(canvas));
    }

    fn millimetres(&self) -> Option<f64> {
        Some(self.millimetres)
    }
}
