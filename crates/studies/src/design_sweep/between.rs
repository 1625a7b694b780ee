//! Search for a resonance between the values over which a design's motions are summarized.
//!
//! Along an interval the first measure is known at some values. Between two of them its slope is
//! assumed to be at most twice the largest slope between known values. If the measure could then
//! exceed its largest known value, the midpoint is measured next (S. A. Piyavskii, 1972). Values
//! at which the machine resonates come first.

use super::row::{BARS, is_exact, upper};
use super::{DesignMachine, MotionMeasures, SweepRequest, motions};
use vibro_numerics::sorting::sort_by;

/// Largest number of further values of one design along one interval.
pub(super) const MOST: usize = 32;
/// Lower limit for the measured values along an interval.
const LEAST: usize = 9;
/// Factor between the assumed and the observed steepness.
const STEEPER: f64 = 2.0;
/// Threshold of the search: it continues while a bound exceeds the largest value by this fraction.
const PART: f64 = 0.01;
/// Smallest distance of values, as a fraction of the interval.
const NEAREST: f64 = 1.0 / 256.0;

/// Motions of a design at combinations of values of [`SweepRequest::over`], from all starts for
/// each.
#[derive(Clone, Debug, Default)]
pub(super) struct BandMotions {
    /// The combinations of values.
    pub places: Vec<Vec<f64>>,
    /// The motions, combination by combination.
    pub outcomes: Vec<MotionMeasures>,
    /// Number of computed motions.
    pub computed: usize,
    /// Excess over the largest measure that a branch may reach before the measure jumps to another
    /// branch between two values.
    pub unseen: f64,
}

/// A value along an interval, the largest measure at this value, and the measure's spread.
type ValueSpread = (f64, f64, f64);

/// Whether a longer window does not change a motion's measures, since all of them repeat.
fn repeats((found, objection): &MotionMeasures) -> bool {
    let mut numbers = found.numbers.iter().zip(&found.spreads);
    objection.is_none() && numbers.all(|(number, spread)| number.is_some_and(|x| is_exact(x, *spread)))
}

impl BandMotions {
    /// The motions at some combinations.
    pub fn new<M: DesignMachine>(own: &M, request: &SweepRequest<M>, places: Vec<Vec<f64>>) -> Self {
        let outcomes = motions(own, request, &places);
        Self { computed: outcomes.len(), outcomes, places, unseen: 0.0 }
    }

    /// The motions at one combination.
    fn at(&self, place: usize) -> &[MotionMeasures] {
        let starts = self.outcomes.len() / self.places.len();
        &self.outcomes[place * starts..(place + 1) * starts]
    }

    /// Number of motions at the combinations where a motion does not repeat.
    pub fn open(&self) -> usize {
        let starts = self.outcomes.len() / self.places.len().max(1);
        starts * (0..self.places.len()).filter(|&place| !self.at(place).iter().all(repeats)).count()
    }

    /// The same motions over the windows of another request. Motions that repeat are not computed
    /// again. The next search finds `unseen` again.
    pub fn over<M: DesignMachine>(&self, own: &M, request: &SweepRequest<M>) -> Self {
        let mut looked = Self { places: self.places.clone(), ..Self::default() };
        for (place, values) in self.places.iter().enumerate() {
            let known = self.at(place);
            if known.iter().all(repeats) {
                looked.outcomes.extend_from_slice(known);
            } else {
                looked.add(motions(own, request, std::slice::from_ref(values)));
            }
        }
        looked
    }

    /// Appends computed motions.
    fn add(&mut self, outcomes: Vec<MotionMeasures>) {
        self.computed += outcomes.len();
        self.outcomes.extend(outcomes);
    }

    /// Largest value of a measure over the starts at a combination, and half its distance from the
    /// largest upper end of the error bars.
    fn largest(&self, place: usize, measure: usize) -> Option<(f64, f64)> {
        let number = |(found, _): &MotionMeasures| {
            Some((found.numbers.get(measure).copied()??, found.spreads[measure]))
        };
        let bars: Vec<(f64, f64)> = self.at(place).iter().map(number).collect::<Option<_>>()?;
        let largest = bars.iter().map(|bar| bar.0).reduce(f64::max)?;
        let top = bars.into_iter().map(upper).fold(largest, f64::max);
        Some((largest, (top - largest) / BARS))
    }

    /// Values along an axis through the combination with the largest measure, and that
    /// combination. `None` if a motion has failed.
    fn line(&self, axis: usize, measure: usize) -> Option<(Vec<ValueSpread>, Vec<f64>)> {
        let values: Vec<(f64, f64)> =
            (0..self.places.len()).map(|i| self.largest(i, measure)).collect::<Option<_>>()?;
        let top = (1..values.len()).fold(0, |best, i| if values[i].0 > values[best].0 { i } else { best });
        let through = self.places[top].clone();
        let on_line = |place: &[f64]| (0..through.len()).all(|j| j == axis || place[j] == through[j]);
        let met = self.places.iter().zip(&values).filter(|(place, _)| on_line(place));
        let mut line: Vec<ValueSpread> = met.map(|(place, y)| (place[axis], y.0, y.1)).collect();
        sort_by(&mut line, |a, b| a.0.total_cmp(&b.0));
        line.dedup_by(|a, b| a.0 == b.0);
        Some((line, through))
    }
}

/// Searches each interval of [`SweepRequest::over`] along the line through the combination with
/// the largest measure. The search ends when a measure minus twice its spread exceeds `enough`.
/// New combinations are appended. A failed motion ends the search, since the design then has no
/// value. Returns whether the search is complete.
pub(super) fn search_between<M: DesignMachine>(
    own: &M,
    request: &SweepRequest<M>,
    (measure, enough): (usize, f64),
    looked: &mut BandMotions,
) -> bool {
    for (k, axis) in request.over.iter().enumerate() {
        if !request.between.contains(&axis.name) || axis.values.len() < 2 {
            continue;
        }
        let Some((mut line, through)) = looked.line(k, measure) else { return true };
        let assigned: Vec<_> =
            request.over.iter().map(|a| a.name.clone()).zip(through.iter().copied()).collect();
        let resonances = own.varied(&assigned).map_or(Vec::new(), |m| m.resonances(&axis.name));
        let mut first = resonances.into_iter();
        while line.len() < axis.values.len() + MOST {
            if line.iter().any(|p| p.1 - BARS * p.2 > enough) {
                return false;
            }
            let Some(x) = first.find(|x| is_new(&line, *x)).or_else(|| next(&line)) else { break };
            let mut place = through.clone();
            place[k] = x;
            looked.add(motions(own, request, std::slice::from_ref(&place)));
            looked.places.push(place);
            let Some((y, spread)) = looked.largest(looked.places.len() - 1, measure) else { return true };
            let at = line.partition_point(|p| p.0 < x);
            line.insert(at, (x, y, spread));
        }
        looked.unseen = looked.unseen.max(before_jumps(&line));
    }
    true
}

/// Excess over the largest measure of a line that the measure may reach next to a jump. At a jump
/// the motion leaves its branch between two values. The branch continues with its slope at most to
/// the other value. `line` is ascending.
fn before_jumps(line: &[ValueSpread]) -> f64 {
    let top = line.iter().map(|p| p.1).fold(f64::NEG_INFINITY, f64::max);
    let end = |[far, near, other]: [&ValueSpread; 3]| {
        near.1 + (near.1 - far.1) / (near.0 - far.0) * (other.0 - near.0)
    };
    // At a smooth maximum the extrapolations of both sides exceed the other side; next to a jump
    // only the extrapolation of the upper side does.
    let excess = |own: &[ValueSpread]| {
        let [a, b, c, d] = own else { return 0.0 };
        let steepness = |p: &ValueSpread, q: &ValueSpread| ((q.1 - p.1) / (q.0 - p.0)).abs();
        if steepness(b, c) <= steepness(a, b).max(steepness(c, d)) {
            return 0.0;
        }
        let (from_left, from_right) = (end([a, b, c]), end([d, c, b]));
        match (from_left > c.1, from_right > b.1) {
            (true, false) if b.1 > c.1 => from_left - top,
            (false, true) if c.1 > b.1 => from_right - top,
            _ => 0.0,
        }
    };
    let most = line.windows(4).map(excess).fold(0.0, f64::max);
    if most > PART * top.abs() { most } else { 0.0 }
}

/// Whether a value lies in the interval and is not near a known value.
fn is_new(line: &[ValueSpread], x: f64) -> bool {
    let (from, to) = (line[0].0, line[line.len() - 1].0);
    let near = NEAREST * (to - from);
    from < x && x < to && line.iter().all(|p| (p.0 - x).abs() > near)
}

/// The next value to measure: the midpoint of the pair of values with the largest bound. `None` if
/// at least [`LEAST`] values are known and this bound does not exceed the largest measure by twice
/// its spread and by [`PART`]. `line` is ascending.
fn next(line: &[ValueSpread]) -> Option<f64> {
    let span = line[line.len() - 1].0 - line[0].0;
    let top = line.iter().copied().reduce(|a, b| if b.1 > a.1 { b } else { a })?;
    let rise = |p: &[ValueSpread]| ((p[1].1 - p[0].1).abs() - p[0].2.hypot(p[1].2)).max(0.0);
    let steepest = line.windows(2).map(|p| rise(p) / (p[1].0 - p[0].0)).fold(0.0, f64::max);
    let wide = line.windows(2).filter(|p| p[1].0 - p[0].0 > 2.0 * NEAREST * span);
    let bound = |p: &[ValueSpread]| {
        let width = p[1].0 - p[0].0;
        if line.len() < LEAST { width } else { 0.5 * (p[0].1 + p[1].1 + STEEPER * steepest * width) }
    };
    // The first of equal bounds is used.
    let (pair, bound) = wide.map(|p| (p, bound(p))).reduce(|a, b| if b.1 > a.1 { b } else { a })?;
    let passes = line.len() < LEAST || bound > top.1 + (BARS * top.2).max(PART * top.1.abs());
    passes.then(|| 0.5 * (pair[0].0 + pair[1].0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A branch with slope 2 that jumps down between 0.5 and 0.6 reaches at most 0.2 more than at
    /// 0.5. A smooth maximum, and a jump below the largest value, leave nothing unseen.
    #[test]
    fn closed_form_a_branch_reaches_as_far_as_its_slope_before_it_jumps() {
        let line = |of: &dyn Fn(f64) -> f64| -> Vec<ValueSpread> {
            (0..=10).map(|k| 0.1 * f64::from(k)).map(|x| (x, of(x), 0.0)).collect()
        };
        let jumps = line(&|x| if x < 0.55 { 1.0 + 2.0 * x } else { 0.3 * x });
        assert!((before_jumps(&jumps) - 0.2).abs() < 1e-12, "{}", before_jumps(&jumps));
        let mut turned: Vec<ValueSpread> = jumps.iter().map(|p| (1.0 - p.0, p.1, p.2)).collect();
        turned.reverse();
        assert!((before_jumps(&turned) - 0.2).abs() < 1e-12);
        assert_eq!(before_jumps(&line(&|x| 3.0 - (x - 0.44) * (x - 0.44))), 0.0);
        assert_eq!(before_jumps(&line(&|x| if x < 0.35 { x } else { 2.0 - (x - 0.8).powi(2) })), 0.0);
    }
}
