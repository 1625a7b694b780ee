//! What lies between the values over which the motions of a design are taken together: a resonance that none of them meets.
//!
//! Along an interval the first measure is known at some values. Between two of them it may rise as steeply as it was seen to rise
//! anywhere, and twice that: where it could then pass the largest, the middle is looked at next (S. A. Piyavskii, 1972). Values
//! at which the machine resonates come first.

use super::{Machine, Outcome, Request, motions};

/// Most further values of one design along one interval.
pub(super) const MOST: usize = 32;
/// Values along an interval that are looked at in any case.
const LEAST: usize = 9;
/// How much steeper the measure may be than it was seen to be.
const STEEPER: f64 = 2.0;
/// What could pass the largest by less than this part is not looked at.
const PART: f64 = 0.01;
/// Values are not nearer to each other than this part of the interval.
const NEAREST: f64 = 1.0 / 256.0;

/// The motions of a design at values of [`Request::over`], from all starts at each.
#[derive(Clone, Debug, Default)]
pub(super) struct Looked {
    /// The values.
    pub places: Vec<Vec<f64>>,
    /// The motions there, place by place.
    pub outcomes: Vec<Outcome>,
}

impl Looked {
    /// The largest of a measure over the starts at a place.
    fn largest(&self, place: usize, measure: usize) -> Option<f64> {
        let starts = self.outcomes.len() / self.places.len();
        let own = &self.outcomes[place * starts..(place + 1) * starts];
        let numbers = own.iter().map(|(found, _)| found.numbers.get(measure).copied().flatten());
        numbers.reduce(|a, b| Some(a?.max(b?))).flatten()
    }
}

/// Looks between the values of those of [`Request::over`] that are intervals, along each through the largest. The new places follow
/// the others. A motion that fails ends the search, as the design has no value then.
pub(super) fn look_between<M: Machine>(own: &M, request: &Request<M>, measure: usize, looked: &mut Looked) {
    for (k, axis) in request.over.iter().enumerate() {
        if !request.between.contains(&axis.name) || axis.values.len() < 2 {
            continue;
        }
        let values: Option<Vec<f64>> = (0..looked.places.len()).map(|i| looked.largest(i, measure)).collect();
        let Some(values) = values else { return };
        let top = (1..values.len()).fold(0, |best, i| if values[i] > values[best] { i } else { best });
        let through = looked.places[top].clone();
        let on_line = |place: &[f64]| (0..through.len()).all(|j| j == k || place[j] == through[j]);
        let met = looked.places.iter().zip(&values).filter(|(place, _)| on_line(place));
        let mut line: Vec<(f64, f64)> = met.map(|(place, y)| (place[k], *y)).collect();
        line.sort_by(|a, b| a.0.total_cmp(&b.0));
        line.dedup_by(|a, b| a.0 == b.0);
        let assigned: Vec<_> =
            request.over.iter().map(|a| a.name.clone()).zip(through.iter().copied()).collect();
        let resonances = own.varied(&assigned).map_or(Vec::new(), |m| m.resonances(&axis.name));
        let mut first = resonances.into_iter();
        for _ in 0..MOST {
            let Some(x) = first.find(|x| is_new(&line, *x)).or_else(|| next(&line)) else { break };
            let mut place = through.clone();
            place[k] = x;
            looked.outcomes.extend(motions(own, request, std::slice::from_ref(&place)));
            looked.places.push(place);
            let Some(y) = looked.largest(looked.places.len() - 1, measure) else { return };
            let at = line.partition_point(|p| p.0 < x);
            line.insert(at, (x, y));
        }
    }
}

/// Whether a value lies in the interval and not at one that is there.
fn is_new(line: &[(f64, f64)], x: f64) -> bool {
    let (from, to) = (line[0].0, line[line.len() - 1].0);
    let near = NEAREST * (to - from);
    from < x && x < to && line.iter().all(|p| (p.0 - x).abs() > near)
}

/// The value to look at next, if any could have a larger one than those that are there, which are ascending.
fn next(line: &[(f64, f64)]) -> Option<f64> {
    let span = line[line.len() - 1].0 - line[0].0;
    let largest = line.iter().map(|p| p.1).fold(f64::NEG_INFINITY, f64::max);
    let steepest = line.windows(2).map(|p| ((p[1].1 - p[0].1) / (p[1].0 - p[0].0)).abs()).fold(0.0, f64::max);
    let wide = line.windows(2).filter(|p| p[1].0 - p[0].0 > 2.0 * NEAREST * span);
    let bound = |p: &[(f64, f64)]| {
        let width = p[1].0 - p[0].0;
        if line.len() < LEAST { width } else { 0.5 * (p[0].1 + p[1].1 + STEEPER * steepest * width) }
    };
    // Of equal ones the first.
    let (pair, bound) = wide.map(|p| (p, bound(p))).reduce(|a, b| if b.1 > a.1 { b } else { a })?;
    let passes = line.len() < LEAST || bound > largest + PART * largest.abs();
    passes.then(|| 0.5 * (pair[0].0 + pair[1].0))
}
