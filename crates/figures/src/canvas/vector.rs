//! Marks as SVG text.

use super::letters::FONT;
use super::{Along, CanvasPoint, Colour, Mark, SVG_SHRINK};
use crate::html::escape;
use std::collections::BTreeSet;
use std::fmt::{Display, Formatter, Write as _};

/// A number written with at most one decimal.
#[derive(Clone, Copy)]
struct Rounded(f64);

impl Display for Rounded {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        /// Limit below which a double resolves tenths. The number of tenths is then written as an
        /// integer, which is several times faster.
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

/// The whole file.
pub(super) fn document(marks: &[Mark], (width, height): (u32, u32)) -> String {
    let mut text = Text::default();
    text.marks(marks);
    format!(
        "<svg width=\"{}\" height=\"{}\" viewBox=\"0 0 {width} {height}\" xmlns=\"http://www.w3.org/2000/svg\" \
         font-family=\"{FONT}, sans-serif\" stroke-linejoin=\"round\" stroke-linecap=\"round\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n{}</svg>\n",
        width / SVG_SHRINK,
        height / SVG_SHRINK,
        text.body
    )
}

fn hex(Colour(r, g, b): Colour) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// The data of a path of polylines.
fn outline(piece: &[CanvasPoint], data: &mut String) {
    for (i, &(x, y)) in piece.iter().enumerate() {
        data.push_str(match i {
            0 => "M",
            1 => "L",
            _ => " ",
        });
        let _ = write!(data, "{} {}", Rounded(x), Rounded(y));
    }
}

/// SVG text under construction.
#[derive(Default)]
struct Text {
    body: String,
    /// Names of the clip rectangles that are already in the text.
    clips: BTreeSet<String>,
}

impl Text {
    fn push(&mut self, text: std::fmt::Arguments<'_>) {
        // Writing into a string cannot fail.
        let _ = self.body.write_fmt(text);
    }

    fn marks(&mut self, marks: &[Mark]) {
        for mark in marks {
            self.mark(mark);
        }
    }

    fn mark(&mut self, mark: &Mark) {
        match mark {
            Mark::Lines { pieces, pen } => {
                let mut data = String::new();
                pieces.iter().for_each(|piece| outline(piece, &mut data));
                let (colour, width) = (hex(pen.colour), Rounded(pen.width));
                self.push(format_args!(
                    "<path d=\"{data}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\""
                ));
                if let Some((on, off)) = pen.dash {
                    let (on, off) = (Rounded(on), Rounded(off));
                    self.push(format_args!(" stroke-linecap=\"butt\" stroke-dasharray=\"{on} {off}\""));
                }
                self.push(format_args!("/>\n"));
            }
            Mark::Polygon { corners, colour, opacity } => {
                let mut data = String::new();
                outline(corners, &mut data);
                let (colour, opacity) = (hex(*colour), format!("{opacity:.2}"));
                self.push(format_args!("<path d=\"{data}z\" fill=\"{colour}\""));
                if opacity != "1.00" {
                    self.push(format_args!(" fill-opacity=\"{opacity}\""));
                }
                self.push(format_args!("/>\n"));
            }
            Mark::Rectangles { rectangles, colour, bordered } => {
                let mut data = String::new();
                for &[(x, y), (w, h)] in rectangles {
                    let [x, y, w, h] = [x, y, w, h].map(Rounded);
                    let _ = write!(data, "M{x} {y}h{w}v{h}h-{w}z");
                }
                let colour = hex(*colour);
                self.push(format_args!(
                    "<path d=\"{data}\" fill=\"{colour}\" shape-rendering=\"crispEdges\""
                ));
                if *bordered {
                    self.push(format_args!(
                        " stroke=\"{colour}\" stroke-linejoin=\"miter\" vector-effect=\"non-scaling-stroke\""
                    ));
                }
                self.push(format_args!("/>\n"));
            }
            Mark::Circles { centres, radius, colour, edge } => self.circles(centres, *radius, *colour, *edge),
            Mark::Text { place, words, size, colour, along, upwards } => {
                let [x, y, size] = [place.0, place.1, *size].map(Rounded);
                let anchor = match along {
                    Along::Start => "",
                    Along::Middle => " text-anchor=\"middle\"",
                    Along::End => " text-anchor=\"end\"",
                };
                let turn =
                    if *upwards { format!(" transform=\"rotate(-90 {x} {y})\"") } else { String::new() };
                let (colour, words) = (hex(*colour), escape(words));
                self.push(format_args!(
                    "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\" fill=\"{colour}\"{anchor}{turn}>{words}</text>\n"
                ));
            }
            Mark::Moved { by: (x, y), marks } => {
                self.push(format_args!("<g transform=\"translate({} {})\">\n", Rounded(*x), Rounded(*y)));
                self.marks(marks);
                self.push(format_args!("</g>\n"));
            }
            Mark::Tagged { marks, .. } => self.marks(marks),
            Mark::Clipped { rectangle, marks } => self.clipped(*rectangle, marks),
        }
    }

    fn circles(&mut self, centres: &[CanvasPoint], radius: f64, colour: Colour, edge: Option<f64>) {
        let (r, across) = (Rounded(radius), Rounded(2.0 * radius));
        let mut data = String::new();
        for &(x, y) in centres {
            let (x, y) = (Rounded(x - radius), Rounded(y));
            let _ = write!(data, "M{x} {y}a{r} {r} 0 1 0 {across} 0a{r} {r} 0 1 0-{across} 0z");
        }
        let colour = hex(colour);
        match edge.map(Rounded) {
            Some(edge) => self.push(format_args!(
                "<path d=\"{data}\" fill=\"#ffffff\" stroke=\"{colour}\" stroke-width=\"{edge}\"/>\n"
            )),
            None => self.push(format_args!("<path d=\"{data}\" fill=\"{colour}\"/>\n")),
        }
    }

    /// The rectangle's name in the file consists of its numbers.
    fn clipped(&mut self, [(x, y), (w, h)]: [CanvasPoint; 2], marks: &[Mark]) {
        let [x, y, w, h] = [x, y, w, h].map(Rounded);
        let name = format!("clip-{x}-{y}-{w}-{h}");
        if self.clips.insert(name.clone()) {
            self.push(format_args!(
                "<clipPath id=\"{name}\"><rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\"/></clipPath>\n"
            ));
        }
        self.push(format_args!("<g clip-path=\"url(#{name})\">\n"));
        self.marks(marks);
        self.push(format_args!("</g>\n"));
    }
}
