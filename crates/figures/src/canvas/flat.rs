//! Marks as numbers and words, for a page that redraws them.

use super::{Along, CanvasPoint, Colour, Drawing, Mark, marks};
use crate::Result;

/// Marks of a drawing in order, each as its kind and its numbers:
///
/// | kind | numbers after it |
/// |---|---|
/// | 0 item | its number, or -1: the following marks belong to this item, or to none |
/// | 1 line | colour, width, count, points |
/// | 2 polygon | colour, opacity, count, points |
/// | 3 discs | colour, radius, count, points |
/// | 4 text | colour, size, 0 start, 1 middle or 2 end, index of its words, baseline point |
///
/// A colour is 65536 red + 256 green + blue, a point is x and y. Moved marks are already moved;
/// rectangles, clips, dashes, the direction of texts and the white of circles are left out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Flat {
    /// Kinds and numbers.
    pub numbers: Vec<f32>,
    /// Words of the texts.
    pub words: Vec<String>,
}

/// A drawing as numbers and words.
///
/// # Errors
/// [`Error`](crate::Error) if a coordinate is not finite.
pub fn flat(drawing: &impl Drawing) -> Result<Flat> {
    let mut flat = Flat::default();
    flat.add(&marks(drawing)?, (0.0, 0.0));
    Ok(flat)
}

impl Flat {
    fn add(&mut self, marks: &[Mark], by: CanvasPoint) {
        for mark in marks {
            match mark {
                Mark::Lines { pieces, pen } => {
                    pieces.iter().for_each(|piece| self.places(1.0, pen.colour, pen.width, piece, by));
                }
                Mark::Polygon { corners, colour, opacity } => {
                    self.places(2.0, *colour, *opacity, corners, by);
                }
                Mark::Circles { centres, radius, colour, .. } => {
                    self.places(3.0, *colour, *radius, centres, by);
                }
                Mark::Text { place, words, size, colour, along, .. } => {
                    let along = match along {
                        Along::Start => 0.0,
                        Along::Middle => 1.0,
                        Along::End => 2.0,
                    };
                    let (index, at) = (self.words.len() as f64, (place.0 + by.0, place.1 + by.1));
                    self.push(&[4.0, number(*colour), *size, along, index, at.0, at.1]);
                    self.words.push(words.clone());
                }
                Mark::Moved { by: further, marks } => self.add(marks, (by.0 + further.0, by.1 + further.1)),
                Mark::Tagged { tag, marks } => {
                    self.push(&[0.0, f64::from(*tag)]);
                    self.add(marks, by);
                    self.push(&[0.0, -1.0]);
                }
                Mark::Clipped { marks, .. } => self.add(marks, by),
                Mark::Rectangles { .. } => {}
            }
        }
    }

    fn push(&mut self, numbers: &[f64]) {
        self.numbers.extend(numbers.iter().map(|&x| x as f32));
    }

    fn places(&mut self, kind: f64, colour: Colour, size: f64, places: &[CanvasPoint], by: CanvasPoint) {
        self.push(&[kind, number(colour), size, places.len() as f64]);
        places.iter().for_each(|(x, y)| self.push(&[x + by.0, y + by.1]));
    }
}

fn number(Colour(r, g, b): Colour) -> f64 {
    f64::from(r) * 65536.0 + f64::from(g) * 256.0 + f64::from(b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::canvas::{Across, Canvas, Pen, Writing};

    struct Two;

    impl Drawing for Two {
        fn size(&self) -> (u32, u32) {
            (9, 9)
        }

        fn draw(&self, canvas: &mut Canvas) {
            canvas.lines(&[vec![(1.0, 2.0), (3.0, 4.0)]], Pen::solid(Colour(1, 2, 3), 5.0));
            let writing = Writing {
                size: 1000.0,
                colour: Colour(0, 0, 1),
                along: Along::End,
                across: Across::Bottom,
                upwards: false,
            };
            canvas.moved((1.0, 1.0), |canvas| {
                canvas.tagged(7, |canvas| canvas.text((0.0, 236.0), "w", &writing));
            });
        }
    }

    #[test]
    fn golden_numbers_of_a_line_and_a_moved_text_of_a_thing() {
        let flat = flat(&Two).unwrap();
        let line = [1.0, 66051.0, 5.0, 2.0, 1.0, 2.0, 3.0, 4.0];
        let text = [0.0, 7.0, 4.0, 1.0, 1000.0, 2.0, 0.0, 1.0, 1.0, 0.0, -1.0];
        assert_eq!(flat.numbers, [&line[..], &text].concat());
        assert_eq!(flat.words, ["w"]);
    }
}
