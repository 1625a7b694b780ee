//! From values to places on a panel: scales, ticks and clipping.

use super::chart::Axis;

/// Number of ticks that an axis gets about.
const TICKS: f64 = 6.0;
/// Room around data without a given range, in parts of its span.
const AIR: f64 = 0.05;

/// The map of one axis.
#[derive(Clone, Debug)]
pub(super) struct Scale {
    pub low: f64,
    pub high: f64,
    log: bool,
    names: Vec<String>,
    from: f64,
    to: f64,
}

impl Scale {
    /// The map of an axis that shows `values` between the places `from` and `to`.
    pub fn new(axis: &Axis, values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let fits = |v: &f64| v.is_finite() && (!axis.log || *v > 0.0);
        let (low, high) = axis.range.unwrap_or_else(|| {
            let (low, high) = values
                .filter(fits)
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
            match (low < high, low.is_finite()) {
                (true, _) if axis.log => {
                    let air = (high / low).powf(AIR);
                    (low / air, high * air)
                }
                (true, _) => (low - AIR * (high - low), high + AIR * (high - low)),
                (_, true) if axis.log => (0.5 * low, 2.0 * low),
                (_, true) => (low - 1.0, low + 1.0),
                _ => (0.0, 1.0),
            }
        });
        Self { low, high, log: axis.log, names: axis.names.clone(), from, to }
    }

    /// The place of a value.
    pub fn place(&self, value: f64) -> f64 {
        let part = if self.log {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        self.from + part * (self.to - self.from)
    }

    /// Values and labels of the ticks.
    pub fn ticks(&self) -> Vec<(f64, String)> {
        if !self.names.is_empty() {
            return (1..).map(f64::from).zip(self.names.iter().cloned()).collect();
        }
        if self.log {
            return self.log_ticks();
        }
        let rough = (self.high - self.low) / TICKS;
        let power = 10f64.powf(rough.log10().floor());
        let steps = [1.0, 2.0, 2.5, 5.0, 10.0];
        let step = steps.iter().map(|s| s * power).find(|s| *s >= rough * 0.999).unwrap_or(rough);
        let decimals = |d: i32| (step * 10f64.powi(d)).fract();
        let digits = (0..12).find(|&d| decimals(d).min(1.0 - decimals(d)) < 1e-6).unwrap_or(12) as usize;
        let (first, last) =
            ((self.low / step - 1e-9).ceil() as i64, (self.high / step + 1e-9).floor() as i64);
        let label = |v: f64| format!("{:.digits$}", v + 0.0).replace('-', "−");
        (first..=last).map(|i| i as f64 * step).map(|v| (v, label(v))).collect()
    }

    fn log_ticks(&self) -> Vec<(f64, String)> {
        let (first, last) = (self.low.log10().floor() as i32, self.high.log10().ceil() as i32);
        // Few decades leave room for 2 and 5.
        let factors: &[f64] = if last - first <= 4 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let decade = |e: i32| {
            let digits = (-e).max(0) as usize;
            factors.iter().map(move |f| (f * 10f64.powi(e), format!("{:.digits$}", f * 10f64.powi(e))))
        };
        let inside = |t: &(f64, String)| t.0 >= self.low * (1.0 - 1e-9) && t.0 <= self.high * (1.0 + 1e-9);
        (first..=last).flat_map(decade).filter(inside).collect()
    }
}

/// A rectangle of places: left, top, right, bottom.
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

    /// The parts of a path inside; a place that is no number cuts it.
    pub fn clip_path(&self, path: impl Iterator<Item = (f64, f64)>) -> Vec<Vec<(f64, f64)>> {
        let mut pieces: Vec<Vec<(f64, f64)>> = Vec::new();
        let mut before: Option<(f64, f64)> = None;
        let mut joined = false;
        for point in path {
            let finite = point.0.is_finite() && point.1.is_finite();
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
        pieces
    }

    /// The rectangle with more room on all sides.
    pub fn grown(&self, by: f64) -> Self {
        Self { left: self.left - by, top: self.top - by, right: self.right + by, bottom: self.bottom + by }
    }

    /// Its upper left and lower right corners.
    pub fn corners(&self) -> [(f64, f64); 2] {
        [(self.left, self.top), (self.right, self.bottom)]
    }

    /// Whether a place is inside.
    pub fn holds(&self, (x, y): (f64, f64)) -> bool {
        (self.left..=self.right).contains(&x) && (self.top..=self.bottom).contains(&y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(low: f64, high: f64, log: bool) -> Vec<String> {
        let axis = Axis { range: Some((low, high)), log, ..Axis::default() };
        Scale::new(&axis, std::iter::empty(), 0.0, 1.0).ticks().into_iter().map(|t| t.1).collect()
    }

    #[test]
    fn ticks_are_round_numbers() {
        assert_eq!(labels(-2.0, 2.0, false), ["−2", "−1", "0", "1", "2"]);
        assert_eq!(labels(0.0, 1.0, false), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(0.005, 0.1, true), ["0.005", "0.01", "0.02", "0.05", "0.1"]);
    }

    #[test]
    fn paths_are_cut_at_the_frame_and_at_gaps() {
        let frame = Frame { left: 0.0, top: 0.0, right: 10.0, bottom: 10.0 };
        let path = [(-5.0, 5.0), (5.0, 5.0), (5.0, 15.0), (f64::NAN, 0.0), (1.0, 1.0), (2.0, 1.0)];
        let pieces = frame.clip_path(path.into_iter());
        let expected = [vec![(0.0, 5.0), (5.0, 5.0), (5.0, 10.0)], vec![(1.0, 1.0), (2.0, 1.0)]];
        assert_eq!(pieces, expected);
    }
}
