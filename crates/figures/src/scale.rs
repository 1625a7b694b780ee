//! Conversion of values to positions on a panel: scales, ticks and clipping.

use crate::canvas::text_width;
use crate::chart::Axis;
use crate::symbols::SMALL;

/// Approximate number of ticks of an axis with enough room.
const TICKS: usize = 6;
/// Smallest distance between the labels of two ticks.
const APART: f64 = 12.0;
/// Margin around data without a given range, as a fraction of its span.
const AIR: f64 = 0.05;

/// Smallest number of ticks at decades and their subdivisions; with fewer, a logarithmic axis has
/// ticks at round numbers.
const FEWEST: usize = 3;
/// Approximate largest number of labelled decades.
const MOST: usize = 10;
/// Numbers of at least this size, and steps smaller than its reciprocal, are written with a power
/// of ten.
const LARGE: f64 = 1e6;

/// The map of one axis.
#[derive(Clone, Debug)]
pub(super) struct Scale {
    pub low: f64,
    pub high: f64,
    log: bool,
    factor: f64,
    names: Vec<String>,
    whole: bool,
    from: f64,
    to: f64,
}

impl Scale {
    /// The map of an axis with `values` to positions between `from` and `to`.
    pub fn new(axis: &Axis, values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let fits = |v: &f64| v.is_finite() && (!axis.log || *v > 0.0);
        let given = axis.range.filter(|(low, high)| low < high && fits(low) && fits(high));
        let (low, high) = given.unwrap_or_else(|| around(values.filter(fits), axis.log));
        let factor = axis.factor.unwrap_or(1.0);
        Self { low, high, log: axis.log, factor, names: axis.names.clone(), whole: axis.whole, from, to }
    }

    /// The position of a value.
    pub fn place(&self, value: f64) -> f64 {
        let part = if self.log {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        self.from + part * (self.to - self.from)
    }

    /// Values and labels of the ticks: about [`TICKS`], or the largest number that has room.
    pub fn ticks(&self) -> Vec<(f64, String)> {
        let mut ticks = Vec::new();
        for most in (1..=TICKS).rev() {
            ticks = self.about(most);
            if self.has_room(&ticks) {
                break;
            }
        }
        ticks
    }

    /// About `most` ticks; names are thinned by the same ratio.
    fn about(&self, most: usize) -> Vec<(f64, String)> {
        if !self.names.is_empty() {
            let stride = if most == TICKS { 1 } else { self.names.len().div_ceil(most) };
            return (1..).map(f64::from).zip(self.names.iter().cloned()).step_by(stride).collect();
        }
        let (low, high) = (self.factor * self.low, self.factor * self.high);
        let shown = match self.log {
            true => log_ticks(low, high, most),
            false => linear_ticks(low, high, most as f64, self.whole),
        };
        shown.into_iter().map(|(value, label)| (value / self.factor, label)).collect()
    }

    /// Whether neighbouring labels do not touch. An upright axis runs upwards, to smaller places.
    fn has_room(&self, ticks: &[(f64, String)]) -> bool {
        let size = |label: &str| if self.from < self.to { text_width(label, SMALL) } else { SMALL };
        let half = |tick: &(f64, String)| 0.5 * size(&tick.1);
        ticks.windows(2).all(|pair| {
            let apart = (self.place(pair[1].0) - self.place(pair[0].0)).abs();
            apart >= half(&pair[0]) + half(&pair[1]) + APART
        })
    }
}

/// The range of an axis for given values, which are positive for a logarithmic axis.
fn around(values: impl Iterator<Item = f64>, log: bool) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    match (low < high, low.is_finite()) {
        (true, _) if log => {
            let air = (high / low).powf(AIR);
            (low / air, high * air)
        }
        (true, _) => (low - AIR * (high - low), high + AIR * (high - low)),
        (_, true) if log => (0.5 * low, 2.0 * low),
        (_, true) => (low - 1.0, low + 1.0),
        _ if log => (0.1, 1.0),
        _ => (0.0, 1.0),
    }
}

/// Round or whole numbers from `low` to `high`, about `most` of them.
fn linear_ticks(low: f64, high: f64, most: f64, whole: bool) -> Vec<(f64, String)> {
    let rough = if whole { ((high - low) / most).max(1.0) } else { (high - low) / most };
    let power = 10f64.powf(rough.log10().floor());
    let steps = [1.0, 2.0, 2.5, 5.0, 10.0].map(|s| s * power);
    let is_fit = |s: &&f64| **s >= rough * 0.999 && (!whole || s.fract() == 0.0);
    let step = steps.iter().find(is_fit).copied().unwrap_or(rough);
    let decimals = |d: i32| (step * 10f64.powi(d)).fract();
    let digits = (0..12).find(|&d| decimals(d).min(1.0 - decimals(d)) < 1e-6).unwrap_or(12) as usize;
    let (first, last) = ((low / step - 1e-9).ceil() as i64, (high / step + 1e-9).floor() as i64);
    let plain = step * LARGE > 1.0 && low.abs().max(high.abs()) < LARGE;
    let label = |v: f64| if plain { format!("{:.digits$}", v + 0.0) } else { with_power(v) };
    (first..=last).map(|i| i as f64 * step).map(|v| (v, label(v).replace('-', "−"))).collect()
}

/// Decades from `low` to `high`, with subdivisions if there is room. If there are fewer than
/// [`FEWEST`], round numbers instead. If `most` is less than [`TICKS`], subdivisions and then
/// decades are left out.
fn log_ticks(low: f64, high: f64, most: usize) -> Vec<(f64, String)> {
    let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
    let decade = |e: i32, factors: &'static [f64]| {
        let digits = (-e).max(0) as usize;
        let label = move |v: f64| if e.abs() < 6 { format!("{v:.digits$}") } else { with_power(v) };
        factors.iter().map(move |f| f * 10f64.powi(e)).map(move |v| (v, label(v).replace('-', "−")))
    };
    let inside = |t: &(f64, String)| t.0 >= low * (1.0 - 1e-9) && t.0 <= high * (1.0 + 1e-9);
    let factors: &[f64] = if last - first <= 4 && most == TICKS { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let sparse = ((last - first) as usize / MOST).max(1) * TICKS.saturating_sub(most).max(1);
    let ticks: Vec<_> =
        (first..=last).step_by(sparse).flat_map(|e| decade(e, factors)).filter(inside).collect();
    if ticks.len() < FEWEST { linear_ticks(low, high, most as f64, false) } else { ticks }
}

/// A number with a power of ten, to four digits.
fn with_power(value: f64) -> String {
    let text = format!("{value:.3e}");
    let (digits, power) = text.split_once('e').unwrap_or((&text, "0"));
    let digits = digits.trim_end_matches('0').trim_end_matches('.');
    if power == "0" { digits.into() } else { format!("{digits}e{power}") }
}

/// A rectangle of positions: left, top, right, bottom.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

impl Frame {
    /// The part of a segment inside (Liang and Barsky).
    fn clip(&self, a: (f64, f64), b: (f64, f64)) -> Option<[(f64, f64); 2]> {
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        let edges =
            [(-dx, a.0 - self.left), (dx, self.right - a.0), (-dy, a.1 - self.top), (dy, self.bottom - a.1)];
        for (toward, room) in edges {
            if toward == 0.0 && room < 0.0 {
                return None;
            }
            let t = room / toward;
            if toward < 0.0 {
                enter = enter.max(t);
            } else if toward > 0.0 {
                leave = leave.min(t);
            }
        }
        let at = |t: f64| (a.0 + t * dx, a.1 + t * dy);
        (enter <= leave).then(|| [at(enter), at(leave)])
    }

    /// The parts of a path inside; a NaN point cuts it.
    pub fn clip_path(&self, path: impl Iterator<Item = (f64, f64)>) -> Vec<Vec<(f64, f64)>> {
        let mut pieces: Vec<Vec<(f64, f64)>> = Vec::new();
        let mut before: Option<(f64, f64)> = None;
        // The last point, if it has no finite neighbour yet.
        let mut alone: Option<(f64, f64)> = None;
        let mut joined = false;
        let dot = |alone: Option<(f64, f64)>| alone.filter(|&p| self.holds(p)).map(|p| vec![p, p]);
        for point in path {
            let finite = point.0.is_finite() && point.1.is_finite();
            if !finite {
                pieces.extend(dot(alone));
            }
            alone = (finite && before.is_none()).then_some(point);
            let piece = before.filter(|_| finite).and_then(|b| self.clip(b, point));
            if let Some([a, b]) = piece {
                match pieces.last_mut().filter(|_| joined) {
                    Some(piece) => piece.push(b),
                    None => pieces.push(vec![a, b]),
                }
                joined = b == point;
            } else {
                joined = false;
            }
            before = finite.then_some(point);
        }
        pieces.extend(dot(alone));
        pieces
    }

    /// The rectangle extended on all sides.
    pub fn grown(&self, by: f64) -> Self {
        Self { left: self.left - by, top: self.top - by, right: self.right + by, bottom: self.bottom + by }
    }

    /// Its upper left and lower right corners.
    pub fn corners(&self) -> [(f64, f64); 2] {
        [(self.left, self.top), (self.right, self.bottom)]
    }

    /// Whether a position is inside.
    pub fn holds(&self, (x, y): (f64, f64)) -> bool {
        (self.left..=self.right).contains(&x) && (self.top..=self.bottom).contains(&y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(low: f64, high: f64, log: bool) -> Vec<String> {
        let axis = Axis { range: Some((low, high)), log, ..Axis::default() };
        Scale::new(&axis, std::iter::empty(), 0.0, 2000.0).ticks().into_iter().map(|t| t.1).collect()
    }

    #[test]
    fn ticks_are_round_numbers() {
        assert_eq!(labels(-2.0, 2.0, false), ["−2", "−1", "0", "1", "2"]);
        assert_eq!(labels(0.0, 1.0, false), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(0.005, 0.1, true), ["0.005", "0.01", "0.02", "0.05", "0.1"]);
        // Too few powers of ten and subdivisions.
        assert_eq!(labels(3.4, 4.6, true), ["3.4", "3.6", "3.8", "4.0", "4.2", "4.4", "4.6"]);
        assert_eq!(labels(0.0, 4e7, false), ["0", "1e7", "2e7", "3e7", "4e7"]);
        assert_eq!(labels(0.0, 2e-7, false)[1], "5e−8");
    }

    #[test]
    fn closed_form_ticks_of_counts_are_whole() {
        for (low, high, expected) in [
            (0.9, 2.1, vec!["1", "2"]),
            (-0.2, 4.2, vec!["0", "1", "2", "3", "4"]),
            (0.0, 13.0, vec!["0", "5", "10"]),
            (0.0, 60.0, vec!["0", "10", "20", "30", "40", "50", "60"]),
        ] {
            let axis = Axis { range: Some((low, high)), ..Axis::counts("impacts") };
            let ticks = Scale::new(&axis, std::iter::empty(), 0.0, 2000.0).ticks();
            assert_eq!(ticks.into_iter().map(|t| t.1).collect::<Vec<_>>(), expected);
        }
    }

    /// On short axes with long numbers, no label touches its neighbour, and at least one remains.
    #[test]
    fn invariant_labels_of_ticks_do_not_touch() {
        for length in [150.0, 400.0, 764.0, 2000.0] {
            for (low, high, log) in
                [(0.0, 1.0, false), (-5e-4, 5e-4, false), (0.123_45, 0.123_46, false), (1e-3, 1e3, true)]
            {
                for (from, to) in [(0.0, length), (length, 0.0)] {
                    let axis = Axis { range: Some((low, high)), log, ..Axis::default() };
                    let scale = Scale::new(&axis, std::iter::empty(), from, to);
                    let ticks = scale.ticks();
                    assert!(!ticks.is_empty(), "{length} {low} {high}");
                    for pair in ticks.windows(2) {
                        let [one, other] = [0, 1].map(|k| {
                            let half = 0.5 * if from < to { text_width(&pair[k].1, SMALL) } else { SMALL };
                            let place = scale.place(pair[k].0);
                            (place - half, place + half)
                        });
                        assert!(one.1 < other.0 || other.1 < one.0, "{length} {low} {high}: {pair:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn ticks_are_round_in_the_unit_of_the_label() {
        let axis = Axis::over("gap (mm)", 0.005, 0.03).times(1000.0);
        let ticks = Scale::new(&axis, std::iter::empty(), 0.0, 2000.0).ticks();
        let labels: Vec<_> = ticks.iter().map(|t| t.1.as_str()).collect();
        assert_eq!(labels, ["5", "10", "15", "20", "25", "30"]);
        assert!(ticks.iter().all(|t| (0.005 - 1e-12..=0.03 + 1e-12).contains(&t.0)), "{ticks:?}");
    }

    /// Without data, with a range that is invalid for a logarithm, and with an empty range.
    #[test]
    fn invariant_every_axis_has_finite_ticks() {
        for log in [false, true] {
            for range in [None, Some((0.0, 1.0)), Some((-1.0, 1.0)), Some((2.0, 2.0)), Some((f64::NAN, 1.0))]
            {
                for values in [vec![], vec![f64::NAN], vec![0.0], vec![3.0], vec![1e-100, 1e100]] {
                    let axis = Axis { range, log, ..Axis::default() };
                    let scale = Scale::new(&axis, values.clone().into_iter(), 0.0, 2000.0);
                    let ticks = scale.ticks();
                    assert!(!ticks.is_empty() && ticks.len() < 30, "{range:?} {values:?}: {}", ticks.len());
                    assert!(ticks.iter().all(|t| scale.place(t.0).is_finite()), "{range:?} {values:?}");
                }
            }
        }
    }

    #[test]
    fn paths_are_cut_at_the_frame_and_at_gaps() {
        let frame = Frame { left: 0.0, top: 0.0, right: 10.0, bottom: 10.0 };
        let path = [(-5.0, 5.0), (5.0, 5.0), (5.0, 15.0), (f64::NAN, 0.0), (1.0, 1.0), (2.0, 1.0)];
        let pieces = frame.clip_path(path.into_iter());
        let expected = [vec![(0.0, 5.0), (5.0, 5.0), (5.0, 10.0)], vec![(1.0, 1.0), (2.0, 1.0)]];
        assert_eq!(pieces, expected);
        // A point without a finite neighbour is a dot, at the beginning, between gaps and at the
        // end.
        let gap = (f64::NAN, 0.0);
        let alone = [(1.0, 2.0), gap, (3.0, 4.0), gap, (30.0, 4.0), gap, (5.0, 6.0)];
        let dots = [(1.0, 2.0), (3.0, 4.0), (5.0, 6.0)].map(|dot| vec![dot, dot]);
        assert_eq!(frame.clip_path(alone.into_iter()), dots);
    }
}
