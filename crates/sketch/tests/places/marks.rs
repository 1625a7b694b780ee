//! Marks of a sketch with the things that they belong to, from the numbers of `flat`.

use vibro_figures::canvas::{Drawing, flat, text_width};
use vibro_sketch::Sketch;

/// Height of the highest letter and depth of the lowest of the font, in ems.
const HIGHEST: f64 = 0.76;
const LOWEST: f64 = 0.24;

/// A rectangle: left, top, right, bottom.
#[derive(Clone, Copy, Debug)]
pub struct Rectangle(pub [f64; 4]);

impl Rectangle {
    const NONE: Self = Self([f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY]);

    /// Smallest rectangle around points.
    pub fn around(points: &[(f64, f64)]) -> Self {
        points
            .iter()
            .fold(Self::NONE, |Self([l, t, r, b]), (x, y)| Self([l.min(*x), t.min(*y), r.max(*x), b.max(*y)]))
    }

    /// The rectangle with each edge moved outwards.
    pub fn grown(self, by: f64) -> Self {
        let Self([l, t, r, b]) = self;
        Self([l - by, t - by, r + by, b + by])
    }

    pub fn meets(self, other: Self) -> bool {
        let (Self([l, t, r, b]), Self([left, top, right, bottom])) = (self, other);
        l < right && left < r && t < bottom && top < b
    }

    pub fn holds(self, other: Self) -> bool {
        let (Self([l, t, r, b]), Self([left, top, right, bottom])) = (self, other);
        l <= left && right <= r && t <= top && bottom <= b
    }

    /// Whether a line of a width meets it: the part of the line between its left and right edges
    /// is not above it and not below it.
    pub fn is_crossed(self, [from, to]: Line, width: f64) -> bool {
        let Self([l, t, r, b]) = self.grown(0.5 * width);
        let (mut first, mut last) = (0.0_f64, 1.0_f64);
        for (start, end, low, high) in [(from.0, to.0, l, r), (from.1, to.1, t, b)] {
            if start == end {
                if start <= low || high <= start {
                    return false;
                }
                continue;
            }
            let (one, two) = ((low - start) / (end - start), (high - start) / (end - start));
            (first, last) = (first.max(one.min(two)), last.min(one.max(two)));
        }
        first < last
    }
}

/// The thing that a mark belongs to: an item of `Sketch::names`, or none for walls and legs.
pub type Item = Option<usize>;
/// A line from a point to a point.
pub type Line = [(f64, f64); 2];

/// A line of some width, a filled polygon or disc, and a text.
#[derive(Clone, Debug, Default)]
pub struct Marks {
    pub lines: Vec<(Item, Line, f64)>,
    pub fills: Vec<(Item, Rectangle)>,
    pub labels: Vec<(Item, Rectangle, String)>,
    /// The boxes of bodies and blocks: polygons with four corners.
    pub boxes: Vec<(usize, Rectangle)>,
    pub size: (f64, f64),
}

impl Marks {
    pub fn of(sketch: &Sketch) -> Self {
        let flat = flat(sketch).unwrap();
        let numbers: Vec<f64> = flat.numbers.iter().map(|&x| f64::from(x)).collect();
        let (mut all, mut item, mut at) = (Self::default(), None, 0);
        while at < numbers.len() {
            let own = &numbers[at..];
            let points = |from: usize, count: f64| -> Vec<(f64, f64)> {
                own[from..from + 2 * count as usize].chunks(2).map(|pair| (pair[0], pair[1])).collect()
            };
            at += match own[0] {
                0.0 => {
                    item = (own[1] >= 0.0).then_some(own[1] as usize);
                    2
                }
                4.0 => {
                    let (size, x, y) = (own[2], own[5], own[6]);
                    let words = flat.words[own[4] as usize].clone();
                    let width = text_width(&words, size);
                    let left = x - 0.5 * own[3] * width;
                    let box_of = [left, y - HIGHEST * size, left + width, y + LOWEST * size];
                    all.labels.push((item, Rectangle(box_of), words));
                    7
                }
                kind => {
                    let places = points(4, own[3]);
                    let around = Rectangle::around(&places);
                    if let (2.0, 4, Some(item)) = (kind, places.len(), item) {
                        all.boxes.push((item, around));
                    }
                    match kind {
                        1.0 => {
                            all.lines.extend(places.windows(2).map(|pair| (item, [pair[0], pair[1]], own[2])))
                        }
                        2.0 => all.fills.push((item, around)),
                        _ => all
                            .fills
                            .extend(places.iter().map(|&at| (item, Rectangle::around(&[at]).grown(own[2])))),
                    }
                    4 + 2 * places.len()
                }
            };
        }
        let (width, height) = sketch.size();
        all.size = (f64::from(width), f64::from(height));
        all
    }

    /// Smallest rectangle around all lines and fills of an item.
    pub fn around(&self, item: usize) -> Rectangle {
        let lines = self.lines.iter().filter(|line| line.0 == Some(item)).flat_map(|line| line.1);
        let fills = self.fills.iter().filter(|fill| fill.0 == Some(item));
        let corners = fills.flat_map(|fill| [(fill.1.0[0], fill.1.0[1]), (fill.1.0[2], fill.1.0[3])]);
        Rectangle::around(&lines.chain(corners).collect::<Vec<_>>())
    }
}
