//! Marks as SVG text.

use super::letters::FONT;
use super::{Along, CanvasPoint, Colour, Mark, SVG_SHRINK, Sheet};
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

/// A number written with at most two decimals.
struct Hundredths(f64);

impl Display for Hundredths {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        f.write_str(format!("{:.2}", self.0).trim_end_matches('0').trim_end_matches('.'))
    }
}

/// The whole file.
pub(super) fn document(marks: &[Mark], sheet: &Sheet) -> String {
    let ((width, height), about) = (sheet.size, &sheet.about);
    let shown = match sheet.millimetres {
        Some(mm) => {
            [mm, mm * f64::from(height) / f64::from(width)].map(|side| format!("{}mm", Hundredths(side)))
        }
        None => [width, height].map(|side| (side / SVG_SHRINK).to_string()),
    };
    let mut text = Text::default();
    for (name, words) in [("title", &about.title), ("desc", &about.text)] {
        if !words.is_empty() {
            text.push(format_args!("<{name}>{}</{name}>\n", escape(words)));
        }
    }
    text.push(format_args!("<rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n"));
    text.marks(marks);
    format!(
        "<svg width=\"{}\" height=\"{}\" viewBox=\"0 0 {width} {height}\" xmlns=\"http://www.w3.org/2000/svg\" \
         font-family=\"{FONT}, sans-serif\" stroke-linejoin=\"round\" stroke-linecap=\"round\">\n{}</svg>\n",
        shown[0], shown[1], text.body
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

/// Largest number of circles and rectangles of a layer that are single elements. More of them become
/// an image: the file stays small, and a browser displays it quickly.
const MOST: usize = 20_000;
/// Largest side of such an image, in units.
const LARGEST: f64 = 8000.0;

/// Number of circles or rectangles of a mark; `None` for other marks.
fn count(mark: &Mark) -> Option<usize> {
    match mark {
        Mark::Circles { centres, .. } => Some(centres.len()),
        Mark::Rectangles { rectangles, .. } => Some(rectangles.len()),
        _ => None,
    }
}

/// Corners of the rectangles around circles and rectangles.
fn corners(mark: &Mark) -> Vec<CanvasPoint> {
    match mark {
        Mark::Circles { centres, radius, edge, .. } => {
            let r = radius + edge.unwrap_or(0.0);
            centres.iter().flat_map(|&(x, y)| [(x - r, y - r), (x + r, y + r)]).collect()
        }
        Mark::Rectangles { rectangles, .. } => {
            rectangles.iter().flat_map(|&[(x, y), (w, h)]| [(x, y), (x + w, y + h)]).collect()
        }
        _ => Vec::new(),
    }
}

/// Bytes in base 64 (RFC 4648).
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for part in bytes.chunks(3) {
        let number =
            part.iter().fold(0_u32, |all, byte| all << 8 | u32::from(*byte)) << (8 * (3 - part.len()));
        for k in 0..4 {
            let sixth = number >> (18 - 6 * k) & 63;
            text.push(if k <= part.len() { char::from(LETTERS[sixth as usize]) } else { '=' });
        }
    }
    text
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
        let mut rest = marks;
        while let Some(mark) = rest.first() {
            let run = rest.iter().take_while(|mark| count(mark).is_some()).count();
            let (many, others) = rest.split_at(run);
            if many.iter().filter_map(count).sum::<usize>() > MOST && self.raster(many) {
                rest = others;
            } else {
                self.mark(mark);
                rest = &rest[1..];
            }
        }
    }

    /// Adds marks as one image. Returns false for an extent that is too large for pixels.
    fn raster(&mut self, marks: &[Mark]) -> bool {
        let corners = marks.iter().flat_map(corners);
        let (low, high) = corners.fold(
            ((f64::INFINITY, f64::INFINITY), (f64::NEG_INFINITY, f64::NEG_INFINITY)),
            |(low, high), p| ((low.0.min(p.0), low.1.min(p.1)), (high.0.max(p.0), high.1.max(p.1))),
        );
        let (x, y) = (low.0.floor(), low.1.floor());
        let (w, h) = ((high.0 - x).ceil().max(1.0), (high.1 - y).ceil().max(1.0));
        if w.max(h) > LARGEST {
            return false;
        }
        let Ok(file) = super::bitmap::layer(marks, [(x, y), (w, h)]) else { return false };
        self.push(format_args!(
            "<image x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" href=\"data:image/png;base64,{}\"/>\n",
            base64(&file)
        ));
        true
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn golden_base_64_of_the_standard() {
        let told = ["", "f", "fo", "foo", "foob"].map(|text| base64(text.as_bytes()));
        assert_eq!(told, ["", "Zg==", "Zm8=", "Zm9v", "Zm9vYg=="]);
    }
}
