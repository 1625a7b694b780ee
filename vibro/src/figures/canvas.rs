//! What all pictures share: the embedded font, the palette, and an SVG, from which the PNG is made, so that both are the
//! same picture on any machine.

pub mod palette;

use crate::{Error, Result};
use resvg::{tiny_skia, usvg};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::sync::{Arc, OnceLock};

/// Font of all labels, embedded so that no font has to be installed.
pub const FONT: &str = "DejaVu Sans";
/// The file of the font.
pub static FONT_DATA: &[u8] = include_bytes!("../../../assets/DejaVuSans.ttf");

/// Units of a drawing per pixel of its SVG.
pub const SVG_SHRINK: u32 = 3;
/// Units of a drawing per pixel of its PNG.
pub const PNG_SHRINK: u32 = 2;

/// Height of a capital, depth of a descender and height of a line above the baseline, in ems of the font.
const CAPITAL: f64 = 0.729;
const DESCENDER: f64 = 0.236;
const ASCENDER: f64 = 0.928;

/// Dots per metre in PNG files: 300 per inch.
const PIXELS_PER_METRE: u32 = 11_811;

/// A colour: red, green and blue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Colour(pub u8, pub u8, pub u8);

impl Colour {
    /// The colour of which a part, from 0 to 1, is replaced by another.
    #[must_use]
    pub fn towards(self, other: Self, part: f64) -> Self {
        let mix = |a: u8, b: u8| (f64::from(a) + part * (f64::from(b) - f64::from(a))).round() as u8;
        Self(mix(self.0, other.0), mix(self.1, other.1), mix(self.2, other.2))
    }

    /// The relative luminance of WCAG 2.2, from 0, black, to 1, white: how light the colour is to the eye, and in grey.
    ///
    /// ```
    /// use vibro::figures::canvas::Colour;
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

/// A place in units of the drawing, from the upper left corner.
pub type Place = (f64, f64);

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

/// Where a text's place lies along its line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Along {
    /// At its beginning.
    Start,
    /// At its middle.
    Middle,
    /// At its end.
    End,
}

/// Where a text's place lies across its line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Across {
    /// At the upper edge of the line.
    Top,
    /// At half the height of a capital.
    Centre,
    /// At the lower edge of the line.
    Bottom,
}

/// How a text is written.
#[derive(Clone, Copy, Debug)]
pub struct Writing {
    /// Size of the font (its em) in units of the drawing.
    pub size: f64,
    /// Its colour.
    pub colour: Colour,
    /// Where the place lies along it.
    pub along: Along,
    /// Where the place lies across it.
    pub across: Across,
    /// Whether it runs upwards.
    pub upwards: bool,
}

/// Width of a text of a size in units of the drawing.
pub fn text_width(words: &str, size: f64) -> f64 {
    static FACE: OnceLock<Option<ttf_parser::Face<'static>>> = OnceLock::new();
    let face = FACE.get_or_init(|| ttf_parser::Face::parse(FONT_DATA, 0).ok());
    let Some(face) = face else { return 0.0 };
    // A combining circumflex stands over its letter.
    let letters = words.chars().filter(|c| *c != '\u{302}');
    let advance = |c| face.glyph_index(c).and_then(|g| face.glyph_hor_advance(g)).unwrap_or(0);
    let sum: f64 = letters.map(|c| f64::from(advance(c))).sum();
    sum * size / f64::from(face.units_per_em())
}

/// A number written with at most one decimal.
#[derive(Clone, Copy)]
struct Rounded(f64);

impl std::fmt::Display for Rounded {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        /// Up to here doubles tell tenths apart, and whole numbers of them are written several times faster.
        const MOST: f64 = 1e15;
        let tenths = (self.0 * 10.0).round();
        if tenths.abs() < MOST {
            let (sign, size) = (if tenths < 0.0 { "-" } else { "" }, tenths.abs() as u64);
            return match size % 10 {
                0 => write!(f, "{sign}{}", size / 10),
                tenth => write!(f, "{sign}{}.{tenth}", size / 10),
            };
        }
        let text = format!("{:.1}", tenths / 10.0);
        f.write_str(text.strip_suffix(".0").unwrap_or(&text))
    }
}

/// An SVG that is being written.
#[derive(Debug, Default)]
pub struct Canvas {
    body: String,
    /// Names of the rectangles at which parts are cut.
    clips: BTreeSet<String>,
    /// Whether a coordinate was not finite.
    broken: bool,
}

impl Canvas {
    /// A number with at most one decimal.
    fn number(&mut self, value: f64) -> Rounded {
        self.broken |= !value.is_finite();
        Rounded(value)
    }

    fn push(&mut self, text: std::fmt::Arguments<'_>) {
        // Writing into a string cannot fail.
        let _ = self.body.write_fmt(text);
    }

    fn hex(Colour(r, g, b): Colour) -> String {
        format!("#{r:02x}{g:02x}{b:02x}")
    }

    /// The data of a path of polylines.
    fn outlines(&mut self, pieces: &[Vec<Place>], close: bool) -> String {
        let mut data = String::new();
        for piece in pieces {
            for (i, (x, y)) in piece.iter().enumerate() {
                let (x, y) = (self.number(*x), self.number(*y));
                data.push_str(match i {
                    0 => "M",
                    1 => "L",
                    _ => " ",
                });
                let _ = write!(data, "{x} {y}");
            }
            if close {
                data.push('z');
            }
        }
        data
    }

    /// Polylines drawn by one pen, with round joins.
    pub fn lines(&mut self, pieces: &[Vec<Place>], pen: Pen) {
        let data = self.outlines(pieces, false);
        if data.is_empty() {
            return;
        }
        let (colour, width) = (Self::hex(pen.colour), self.number(pen.width));
        self.push(format_args!(
            "<path d=\"{data}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\""
        ));
        if let Some((on, off)) = pen.dash {
            let (on, off) = (self.number(on), self.number(off));
            self.push(format_args!(" stroke-linecap=\"butt\" stroke-dasharray=\"{on} {off}\""));
        }
        self.push(format_args!("/>\n"));
    }

    /// A filled polygon.
    pub fn polygon(&mut self, corners: &[Place], colour: Colour, opacity: f64) {
        let data = self.outlines(&[corners.to_vec()], true);
        let (colour, opacity) = (Self::hex(colour), format!("{opacity:.2}"));
        self.push(format_args!("<path d=\"{data}\" fill=\"{colour}\""));
        if opacity != "1.00" {
            self.push(format_args!(" fill-opacity=\"{opacity}\""));
        }
        self.push(format_args!("/>\n"));
    }

    /// Filled rectangles of one colour, given by two opposite corners. Their edges are not smoothed: neighbours would show
    /// seams where they share a pixel.
    pub fn rectangles(&mut self, corners: &[[Place; 2]], colour: Colour) {
        let mut data = String::new();
        for [a, b] in corners {
            let (x, y) = (self.number(a.0.min(b.0)), self.number(a.1.min(b.1)));
            let (w, h) = (self.number((b.0 - a.0).abs()), self.number((b.1 - a.1).abs()));
            let _ = write!(data, "M{x} {y}h{w}v{h}h-{w}z");
        }
        if !data.is_empty() {
            let colour = Self::hex(colour);
            self.push(format_args!(
                "<path d=\"{data}\" fill=\"{colour}\" shape-rendering=\"crispEdges\"/>\n"
            ));
        }
    }

    /// Discs of one colour, or circles of that pen on white.
    pub fn circles(&mut self, centres: &[Place], radius: f64, colour: Colour, edge: Option<f64>) {
        let radius = radius - 0.5 * edge.unwrap_or(0.0);
        let (r, across) = (self.number(radius), self.number(2.0 * radius));
        let mut data = String::new();
        for &(x, y) in centres {
            let (x, y) = (self.number(x - radius), self.number(y));
            let _ = write!(data, "M{x} {y}a{r} {r} 0 1 0 {across} 0a{r} {r} 0 1 0-{across} 0z");
        }
        if data.is_empty() {
            return;
        }
        let colour = Self::hex(colour);
        match edge.map(|e| self.number(e)) {
            Some(edge) => self.push(format_args!(
                "<path d=\"{data}\" fill=\"#ffffff\" stroke=\"{colour}\" stroke-width=\"{edge}\"/>\n"
            )),
            None => self.push(format_args!("<path d=\"{data}\" fill=\"{colour}\"/>\n")),
        }
    }

    /// A line of text.
    pub fn text(&mut self, (x, y): Place, words: &str, writing: &Writing) {
        let size = writing.size;
        let drop = size
            * match writing.across {
                Across::Top => ASCENDER,
                Across::Centre => 0.5 * CAPITAL,
                Across::Bottom => -DESCENDER,
            };
        let (x, y) = if writing.upwards { (x + drop, y) } else { (x, y + drop) };
        let (x, y, size) = (self.number(x), self.number(y), self.number(size));
        let anchor = match writing.along {
            Along::Start => "",
            Along::Middle => " text-anchor=\"middle\"",
            Along::End => " text-anchor=\"end\"",
        };
        let turn =
            if writing.upwards { format!(" transform=\"rotate(-90 {x} {y})\"") } else { String::new() };
        let (colour, words) = (Self::hex(writing.colour), crate::html::escape(words));
        self.push(format_args!(
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\" fill=\"{colour}\"{anchor}{turn}>{words}</text>\n"
        ));
    }

    /// What `draw` draws, moved by `by`.
    pub fn moved(&mut self, by: Place, draw: impl FnOnce(&mut Self)) {
        let (x, y) = (self.number(by.0), self.number(by.1));
        self.push(format_args!("<g transform=\"translate({x} {y})\">\n"));
        draw(self);
        self.push(format_args!("</g>\n"));
    }

    /// What `draw` draws, cut at the edges of a rectangle, whose name in the file is made of its numbers.
    pub fn clipped(&mut self, [a, b]: [Place; 2], draw: impl FnOnce(&mut Self)) {
        let (x, y) = (self.number(a.0), self.number(a.1));
        let (w, h) = (self.number(b.0 - a.0), self.number(b.1 - a.1));
        let name = format!("clip-{x}-{y}-{w}-{h}");
        if self.clips.insert(name.clone()) {
            self.push(format_args!(
                "<clipPath id=\"{name}\"><rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\"/></clipPath>\n"
            ));
        }
        self.push(format_args!("<g clip-path=\"url(#{name})\">\n"));
        draw(self);
        self.push(format_args!("</g>\n"));
    }
}

/// Something that can be drawn.
pub trait Drawing {
    /// Its size in units, [`SVG_SHRINK`] times the size of its SVG in pixels.
    fn size(&self) -> (u32, u32);
    /// Draws it on a white canvas of that size.
    fn draw(&self, canvas: &mut Canvas);
}

/// As SVG text.
///
/// # Errors
/// [`Error::Output`] where a coordinate is not finite.
pub fn svg(drawing: &impl Drawing) -> Result<String> {
    let (width, height) = drawing.size();
    let mut canvas = Canvas::default();
    drawing.draw(&mut canvas);
    if canvas.broken {
        return Err(Error::output("a picture")("a coordinate is not finite"));
    }
    Ok(format!(
        "<svg width=\"{}\" height=\"{}\" viewBox=\"0 0 {width} {height}\" xmlns=\"http://www.w3.org/2000/svg\" \
         font-family=\"{FONT}, sans-serif\" stroke-linejoin=\"round\" stroke-linecap=\"round\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n{}</svg>\n",
        width / SVG_SHRINK,
        height / SVG_SHRINK,
        canvas.body
    ))
}

/// The embedded font for the renderer.
fn fonts() -> Arc<usvg::fontdb::Database> {
    static FONTS: OnceLock<Arc<usvg::fontdb::Database>> = OnceLock::new();
    let load = || {
        let mut fonts = usvg::fontdb::Database::new();
        fonts.load_font_data(FONT_DATA.to_vec());
        Arc::new(fonts)
    };
    Arc::clone(FONTS.get_or_init(load))
}

/// As a PNG file, made from the SVG.
///
/// # Errors
/// [`Error::Output`].
pub fn png(drawing: &impl Drawing) -> Result<Vec<u8>> {
    svg_and_png(drawing).map(|(_, png)| png)
}

/// As SVG text and as a PNG file made from it, drawn once.
///
/// # Errors
/// As [`svg()`] and [`png()`].
pub fn svg_and_png(drawing: &impl Drawing) -> Result<(String, Vec<u8>)> {
    let (svg, (width, height)) = (svg(drawing)?, drawing.size());
    let failed = || Error::output("a PNG file")("no memory for its pixels");
    let options = usvg::Options { fontdb: fonts(), ..usvg::Options::default() };
    let tree = usvg::Tree::from_str(&svg, &options).map_err(Error::output("a PNG file"))?;
    let (columns, rows) = (width / PNG_SHRINK, height / PNG_SHRINK);
    let mut pixels = tiny_skia::Pixmap::new(columns, rows).ok_or_else(failed)?;
    let scale = |pixels: u32, size: f32| pixels as f32 / size;
    let size = tree.size();
    let fit = tiny_skia::Transform::from_scale(scale(columns, size.width()), scale(rows, size.height()));
    resvg::render(&tree, fit, &mut pixels.as_mut());
    // The background is opaque, so that alpha says nothing.
    let colours: Vec<u8> = pixels.data().chunks(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, columns, rows);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_pixel_dims(Some(png::PixelDimensions {
        xppu: PIXELS_PER_METRE,
        yppu: PIXELS_PER_METRE,
        unit: png::Unit::Meter,
    }));
    let mut writer = encoder.write_header().map_err(Error::output("a PNG file"))?;
    writer.write_image_data(&colours).map_err(Error::output("a PNG file"))?;
    writer.finish().map_err(Error::output("a PNG file"))?;
    Ok((svg, file))
}
