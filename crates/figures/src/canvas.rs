//! Canvas of all pictures: palette, embedded font, and a list of marks. The list is written as SVG
//! and rasterized as PNG, so both files show the same picture on any machine.

mod bitmap;
mod flat;
mod letters;
pub mod palette;
mod vector;

pub use flat::{Flat, flat};
pub use letters::{FONT, FONT_DATA, text_width, wrapped};

use crate::{Error, Result};

/// Units of a drawing per pixel of its SVG.
pub const SVG_SHRINK: u32 = 3;
/// Units of a drawing per pixel of its PNG.
pub const PNG_SHRINK: u32 = 2;

/// A colour: red, green and blue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Colour(pub u8, pub u8, pub u8);

impl Colour {
    /// Mix of this colour with another; `part` from 0 (this one) to 1 (the other).
    #[must_use]
    pub fn towards(self, other: Self, part: f64) -> Self {
        let mix = |a: u8, b: u8| (f64::from(a) + part * (f64::from(b) - f64::from(a))).round() as u8;
        Self(mix(self.0, other.0), mix(self.1, other.1), mix(self.2, other.2))
    }

    /// The relative luminance of WCAG 2.2, from 0 (black) to 1 (white): the perceived lightness of
    /// the colour, also in a grey print.
    ///
    /// ```
    /// use vibro_figures::canvas::Colour;
    ///
    /// assert_eq!((Colour(0, 0, 0).luminance(), Colour(255, 255, 255).luminance()), (0.0, 1.0));
    /// ```
    #[must_use]
    pub fn luminance(self) -> f64 {
        let linear = |part: u8| match f64::from(part) / 255.0 {
            v if v <= 0.04045 => v / 12.92,
            v => ((v + 0.055) / 1.055).powf(2.4),
        };
        0.2126 * linear(self.0) + 0.7152 * linear(self.1) + 0.0722 * linear(self.2)
    }
}

/// A point in units of the drawing, from the upper left corner, y downwards.
pub type CanvasPoint = (f64, f64);

/// A line's colour, width in units of the drawing, and lengths of dashes and gaps (none: solid).
#[derive(Clone, Copy, Debug)]
pub struct Pen {
    /// Its colour.
    pub colour: Colour,
    /// Its width.
    pub width: f64,
    /// Lengths of dash and gap.
    pub dash: Option<(f64, f64)>,
}

impl Pen {
    /// A solid line.
    pub fn solid(colour: Colour, width: f64) -> Self {
        Self { colour, width, dash: None }
    }
}

/// Horizontal alignment of a text at its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Along {
    /// The point is the text's beginning.
    Start,
    /// The point is the text's middle.
    Middle,
    /// The point is the text's end.
    End,
}

/// Vertical alignment of a text at its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Across {
    /// The point is on the upper edge of the line.
    Top,
    /// The point is at half the height of a capital.
    Centre,
    /// The point is on the lower edge of the line.
    Bottom,
}

/// Style of a text.
#[derive(Clone, Copy, Debug)]
pub struct Writing {
    /// Size of the font (its em) in units of the drawing.
    pub size: f64,
    /// Its colour.
    pub colour: Colour,
    /// Horizontal alignment.
    pub along: Along,
    /// Vertical alignment.
    pub across: Across,
    /// Whether it runs upwards.
    pub upwards: bool,
}

/// One element of a canvas; later marks cover earlier ones.
#[derive(Clone, Debug)]
enum Mark {
    /// Polylines drawn by one pen.
    Lines { pieces: Vec<Vec<CanvasPoint>>, pen: Pen },
    /// A filled polygon.
    Polygon { corners: Vec<CanvasPoint>, colour: Colour, opacity: f64 },
    /// Filled rectangles, each an upper left corner and a size, with edges that are not smoothed.
    /// In an SVG, `bordered` rectangles have a border one pixel wide at any size of the picture.
    Rectangles { rectangles: Vec<[CanvasPoint; 2]>, colour: Colour, bordered: bool },
    /// Discs, or, with the line width `edge`, circles of the colour filled with white.
    Circles { centres: Vec<CanvasPoint>, radius: f64, colour: Colour, edge: Option<f64> },
    /// A line of text; its point is on the baseline.
    Text { place: CanvasPoint, words: String, size: f64, colour: Colour, along: Along, upwards: bool },
    /// Marks that are moved together.
    Moved { by: CanvasPoint, marks: Vec<Mark> },
    /// Marks of one item, with its number; picture files do not contain the number.
    Tagged { tag: u32, marks: Vec<Mark> },
    /// Marks cut at the edges of a rectangle, an upper left corner and a size.
    Clipped { rectangle: [CanvasPoint; 2], marks: Vec<Mark> },
}

/// A picture that is being drawn.
#[derive(Debug, Default)]
pub struct Canvas {
    marks: Vec<Mark>,
    /// Whether a coordinate was not finite.
    broken: bool,
}

impl Canvas {
    /// Returns the number. A number that is not finite makes [`svg()`] and [`png()`] fail.
    fn number(&mut self, value: f64) -> f64 {
        self.broken |= !value.is_finite();
        value
    }

    fn place(&mut self, (x, y): CanvasPoint) -> CanvasPoint {
        (self.number(x), self.number(y))
    }

    fn places(&mut self, places: &[CanvasPoint]) -> Vec<CanvasPoint> {
        places.iter().map(|&place| self.place(place)).collect()
    }

    /// Upper left corner and size of the rectangle with two given opposite corners.
    fn rectangle(&mut self, [a, b]: [CanvasPoint; 2]) -> [CanvasPoint; 2] {
        [self.place((a.0.min(b.0), a.1.min(b.1))), self.place(((b.0 - a.0).abs(), (b.1 - a.1).abs()))]
    }

    /// Polylines drawn by one pen, with round joins.
    pub fn lines(&mut self, pieces: &[Vec<CanvasPoint>], pen: Pen) {
        let pieces: Vec<_> =
            pieces.iter().map(|piece| self.places(piece)).filter(|p| !p.is_empty()).collect();
        if !pieces.is_empty() {
            let width = self.number(pen.width);
            let dash = pen.dash.map(|lengths| self.place(lengths));
            self.marks.push(Mark::Lines { pieces, pen: Pen { width, dash, ..pen } });
        }
    }

    /// A filled polygon.
    pub fn polygon(&mut self, corners: &[CanvasPoint], colour: Colour, opacity: f64) {
        let corners = self.places(corners);
        self.marks.push(Mark::Polygon { corners, colour, opacity });
    }

    /// Filled rectangles of one colour, each given by two opposite corners. Their edges are not
    /// smoothed: smoothed neighbours that share a pixel would show a seam.
    pub fn rectangles(&mut self, corners: &[[CanvasPoint; 2]], colour: Colour) {
        self.push_rectangles(corners, colour, false);
    }

    /// Filled [rectangles](Self::rectangles) that stay visible in an SVG at any size. A border one
    /// pixel wide makes each rectangle cover at least one pixel, even between the centres of two
    /// pixels.
    pub fn visible_rectangles(&mut self, corners: &[[CanvasPoint; 2]], colour: Colour) {
        self.push_rectangles(corners, colour, true);
    }

    fn push_rectangles(&mut self, corners: &[[CanvasPoint; 2]], colour: Colour, bordered: bool) {
        let rectangles: Vec<_> = corners.iter().map(|&corners| self.rectangle(corners)).collect();
        if !rectangles.is_empty() {
            self.marks.push(Mark::Rectangles { rectangles, colour, bordered });
        }
    }

    /// Discs of one colour, or, with the line width `edge`, circles of that colour filled with
    /// white.
    pub fn circles(&mut self, centres: &[CanvasPoint], radius: f64, colour: Colour, edge: Option<f64>) {
        let radius = self.number(radius - 0.5 * edge.unwrap_or(0.0));
        let centres = self.places(centres);
        let edge = edge.map(|edge| self.number(edge));
        if !centres.is_empty() {
            self.marks.push(Mark::Circles { centres, radius, colour, edge });
        }
    }

    /// A line of text.
    pub fn text(&mut self, (x, y): CanvasPoint, words: &str, writing: &Writing) {
        let drop = writing.size * letters::drop(writing.across);
        let place = self.place(if writing.upwards { (x + drop, y) } else { (x, y + drop) });
        let Writing { colour, along, upwards, .. } = *writing;
        let size = self.number(writing.size);
        self.marks.push(Mark::Text { place, words: words.into(), size, colour, along, upwards });
    }

    /// Records the marks of `draw` in a separate list.
    fn apart(&mut self, draw: impl FnOnce(&mut Self)) -> Vec<Mark> {
        let before = std::mem::take(&mut self.marks);
        draw(self);
        std::mem::replace(&mut self.marks, before)
    }

    /// Draws the marks of `draw`, moved by `by`.
    pub fn moved(&mut self, by: CanvasPoint, draw: impl FnOnce(&mut Self)) {
        let (by, marks) = (self.place(by), self.apart(draw));
        self.marks.push(Mark::Moved { by, marks });
    }

    /// Draws the marks of `draw`, tagged as one item with a number that [`flat()`] returns.
    pub fn tagged(&mut self, tag: u32, draw: impl FnOnce(&mut Self)) {
        let marks = self.apart(draw);
        self.marks.push(Mark::Tagged { tag, marks });
    }

    /// Draws the marks of `draw`, clipped to the rectangle with two opposite `corners`.
    pub fn clipped(&mut self, corners: [CanvasPoint; 2], draw: impl FnOnce(&mut Self)) {
        let (rectangle, marks) = (self.rectangle(corners), self.apart(draw));
        self.marks.push(Mark::Clipped { rectangle, marks });
    }
}

/// Words in a picture's files that are not drawn.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct About {
    /// Its title, in one line.
    pub title: String,
    /// Contents of the picture, and the settings of the computation.
    pub text: String,
}

/// Something that can be drawn.
pub trait Drawing {
    /// Its size in units, [`SVG_SHRINK`] times the size of its SVG in pixels.
    fn size(&self) -> (u32, u32);
    /// Draws it on a white canvas of that size.
    fn draw(&self, canvas: &mut Canvas);
    /// Words for the files' metadata; empty words are left out.
    fn about(&self) -> About {
        About::default()
    }
    /// The width in print, mm. `None` for a drawing that is sized in pixels.
    fn millimetres(&self) -> Option<f64> {
        None
    }
}

impl<D: Drawing> Drawing for &D {
    fn size(&self) -> (u32, u32) {
        (**self).size()
    }

    fn draw(&self, canvas: &mut Canvas) {
        (**self).draw(canvas);
    }

    fn about(&self) -> About {
        (**self).about()
    }

    fn millimetres(&self) -> Option<f64> {
        (**self).millimetres()
    }
}

/// Everything of a drawing but its marks.
struct Sheet {
    size: (u32, u32),
    about: About,
    millimetres: Option<f64>,
}

impl Sheet {
    fn of(drawing: &impl Drawing) -> Self {
        Self { size: drawing.size(), about: drawing.about(), millimetres: drawing.millimetres() }
    }
}

/// The marks of a drawing.
fn marks(drawing: &impl Drawing) -> Result<Vec<Mark>> {
    let mut canvas = Canvas::default();
    drawing.draw(&mut canvas);
    if canvas.broken {
        return Err(Error::making("a picture")("a coordinate is not finite"));
    }
    Ok(canvas.marks)
}

/// A drawing as SVG text.
///
/// # Errors
/// [`Error`] if a coordinate is not finite.
pub fn svg(drawing: &impl Drawing) -> Result<String> {
    Ok(vector::document(&marks(drawing)?, &Sheet::of(drawing)))
}

/// A drawing as a PNG file.
///
/// # Errors
/// [`Error`] if a coordinate is not finite, or if there is not enough memory for the pixels.
pub fn png(drawing: &impl Drawing) -> Result<Vec<u8>> {
    bitmap::file(&marks(drawing)?, &Sheet::of(drawing))
}

/// A drawing as SVG text and as a PNG file, drawn once.
///
/// # Errors
/// As [`svg()`] and [`png()`].
pub fn svg_and_png(drawing: &impl Drawing) -> Result<(String, Vec<u8>)> {
    let (marks, sheet) = (marks(drawing)?, Sheet::of(drawing));
    Ok((vector::document(&marks, &sheet), bitmap::file(&marks, &sheet)?))
}
