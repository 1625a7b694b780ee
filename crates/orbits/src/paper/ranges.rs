//! Stable ranges of branches between located bifurcations, and sequences of period doublings.

use super::branch::Branch;
use super::orbit::Orbit;
use crate::branch::OrbitPoint;
use crate::label::Label;

/// Tolerance for equal points, as a difference of the parameter relative to its size. A branch and
/// the branch born on it locate their common point separately.
const SAME_PLACE: f64 = 1e-9;

/// An end of a stable range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeEnd {
    /// The parameter.
    pub value: f64,
    /// Label of the point; `None` only where the branch could not be continued.
    pub label: Option<Label>,
    /// Whether the branch itself ends here. At a PD or BP, this branch is then born from another
    /// one; otherwise another branch is born from it.
    pub is_branch_end: bool,
}

/// A maximal stable piece of a branch. The parameter is monotone along it, since it turns only at
/// folds, where stability changes.
#[derive(Clone, Debug, PartialEq)]
pub struct StableRange {
    /// The number of the branch.
    pub branch: usize,
    /// The first and the last point of the piece.
    pub points: (usize, usize),
    /// Letters of the branch's word.
    pub letters: usize,
    /// The period of its orbits, in drive periods.
    pub period: u32,
    /// The end with the smallest value.
    pub from: RangeEnd,
    /// The end with the largest value.
    pub to: RangeEnd,
}

/// A bifurcation at which a stable orbit is replaced by one with twice as many impacts in its
/// word: a period doubling, or a symmetry breaking, which keeps the period.
#[derive(Clone, Debug, PartialEq)]
pub struct Doubling {
    /// The parameter.
    pub value: f64,
    /// PD, or BP for a symmetry breaking.
    pub label: Label,
    /// Period of the replaced orbit, in drive periods.
    pub period: u32,
    /// Index of the replaced orbit's branch.
    pub branch: usize,
}

impl Branch {
    /// Stable ranges in the order of the points.
    pub fn stable_ranges(&self) -> Vec<StableRange> {
        let mut found = Vec::new();
        let last = self.points.len().saturating_sub(1);
        let mut first = 0;
        while first < last {
            let stable = self.points[first].is_stable();
            let end = (first + 1..last).find(|i| self.points[*i].is_stable() != stable).unwrap_or(last);
            if stable {
                found.push(self.range(first, end));
            }
            first = end;
        }
        found
    }

    fn range(&self, first: usize, last: usize) -> StableRange {
        let end = |i: usize| RangeEnd {
            value: self.points[i].value,
            label: self.points[i].label(),
            is_branch_end: i == 0 || i + 1 == self.points.len(),
        };
        let (a, b) = (end(first), end(last));
        let (from, to) = if a.value <= b.value { (a, b) } else { (b, a) };
        let (letters, period) = (self.word().len(), self.word().period());
        StableRange { branch: self.id, points: (first, last), letters, period, from, to }
    }

    /// The stable range that contains a stable orbit of the branch at a parameter value. If two
    /// ranges contain the value, the result is the range with the nearest flight times. Flight
    /// times are sorted before the comparison, so the first letter of the word and the mirror
    /// image do not matter.
    pub fn stable_range_of(&self, orbit: &Orbit, value: f64) -> Option<StableRange> {
        let room = SAME_PLACE * value.abs().max(1.0);
        let inside = |r: &StableRange| (r.from.value - room..=r.to.value + room).contains(&value);
        let own = flight_times(orbit.phases(), orbit.word().span());
        let distance = |range: &StableRange| {
            let points = &self.points[range.points.0..=range.points.1];
            let near = |a: &&OrbitPoint, b: &&OrbitPoint| {
                (a.value - value).abs().total_cmp(&(b.value - value).abs())
            };
            let nearest = points.iter().min_by(near).map(|p| flight_times(p.phases(), self.word().span()));
            nearest.map_or(f64::INFINITY, |n| n.iter().zip(&own).map(|(a, b)| (a - b).abs()).sum())
        };
        let ranges = self.stable_ranges().into_iter().filter(inside);
        ranges.map(|r| (distance(&r), r)).min_by(|a, b| a.0.total_cmp(&b.0)).map(|found| found.1)
    }
}

/// Times between the impacts of an orbit, in radians of the drive, ascending.
fn flight_times(phases: &[f64], span: f64) -> Vec<f64> {
    let ends = phases.iter().skip(1).copied().chain(phases.first().map(|first| first + span));
    let mut times: Vec<f64> = phases.iter().zip(ends).map(|(a, b)| b - a).collect();
    times.sort_by(f64::total_cmp);
    times
}

/// Sequences of doublings, ordered by period and then by smallest value. Each begins with a stable
/// range that is not born at a doubling. It continues while the branch born at a doubling is
/// stable near its birth; folds may lie between this branch's birth and its own doubling.
///
/// ```
/// use vibro_orbits::paper::{Family, Span, TreeOptions, doubling_sequences, tree};
/// use vibro_studies::paper::{ParameterSet, find_group};
///
/// let span = Span::new(find_group("f10")?, 2.0, 2.5)?;
/// let family = Family::new(&ParameterSet::basic(), span)?;
/// let few = TreeOptions { seeds: 1, settle: 300, starts: 0, ..TreeOptions::default() };
/// let options = TreeOptions { depth: 2, longest_period: 2, ..few };
/// let found = tree(&family, &options, &|_, _| ())?;
/// let sequence = &doubling_sequences(&found.branches)[0];
/// // The symmetry breaks before the first period doubling.
/// assert_eq!(sequence.iter().map(|d| d.label.name()).collect::<Vec<_>>(), ["BP", "PD", "PD"]);
/// assert!((sequence[1].value - 2.373_075_370_806).abs() < 1e-11);
/// # Ok::<(), vibro_studies::Error>(())
/// ```
pub fn doubling_sequences(branches: &[Branch]) -> Vec<Vec<Doubling>> {
    let ranges: Vec<StableRange> = branches.iter().flat_map(Branch::stable_ranges).collect();
    let followed = |from: &StableRange, at: RangeEnd| -> Option<(usize, RangeEnd)> {
        let born = ranges.iter().position(|range| is_born(from, at, range))?;
        Some(next_doubling(&ranges, born, at))
    };
    // A sequence does not begin at a range that is born at a doubling or reached by another
    // sequence.
    let mut reached = vec![false; ranges.len()];
    for range in &ranges {
        for end in [range.from, range.to] {
            if let Some((next, _)) = followed(range, end) {
                reached[next] = true;
            }
            ranges
                .iter()
                .zip(&mut reached)
                .for_each(|(other, reached)| *reached |= is_born(range, end, other));
        }
    }
    let mut found: Vec<Vec<Doubling>> = Vec::new();
    for start in (0..ranges.len()).filter(|i| !reached[*i]) {
        for end in [ranges[start].from, ranges[start].to] {
            let (mut sequence, mut here) = (Vec::new(), Some((start, end)));
            // Words double at each step, so the loop ends.
            while let Some((range, end)) = here
                && let Some(label) = end.label.filter(|_| is_doubling(end))
            {
                let StableRange { period, branch, .. } = ranges[range];
                sequence.push(Doubling { value: end.value, label, period, branch });
                here = followed(&ranges[range], end);
            }
            if !sequence.is_empty() {
                found.push(sequence);
            }
        }
    }
    found.sort_by(|a, b| a[0].period.cmp(&b[0].period).then(a[0].value.total_cmp(&b[0].value)));
    found
}

/// The range with the next doubling after a range born at a doubling, and the end at this
/// doubling. It is the given range if it ends at a doubling; otherwise the first such range
/// further along its branch, beyond folds. If there is none, the result is the given range with
/// its other end.
fn next_doubling(ranges: &[StableRange], born: usize, at: RangeEnd) -> (usize, RangeEnd) {
    let own = &ranges[born];
    let doubles = |r: &StableRange| [r.to, r.from].into_iter().find(|end| is_doubling(*end));
    if let Some(end) = doubles(own) {
        return (born, end);
    }
    // The branch is born at its first or last point.
    let forward = own.points.0 == 0;
    let beyond = |r: &&StableRange| r.branch == own.branch && (r.points.0 > own.points.0) == forward;
    let mut further: Vec<&StableRange> = ranges.iter().filter(beyond).collect();
    if !forward {
        further.reverse();
    }
    let next = further.into_iter().find_map(|r| Some((r, doubles(r)?)));
    let place = |r: &StableRange| ranges.iter().position(|other| other == r);
    let other = if is_same(own.from.value, at.value) { own.to } else { own.from };
    next.and_then(|(r, end)| Some((place(r)?, end))).unwrap_or((born, other))
}

/// The ratios (λ2 - λ1)/(λ3 - λ2), … of the distances of successive period doublings, which tend
/// to Feigenbaum's 4.669… in a sequence of a smooth map with one extremum.
pub fn doubling_ratios(sequence: &[Doubling]) -> Vec<f64> {
    let values: Vec<f64> =
        sequence.iter().filter(|d| d.label == Label::PeriodDoubling).map(|d| d.value).collect();
    values.windows(3).map(|v| (v[1] - v[0]) / (v[2] - v[1])).collect()
}

fn is_same(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME_PLACE * a.abs().max(1.0)
}

/// Whether a branch of a doubled word is born at an end of a range.
fn is_doubling(end: RangeEnd) -> bool {
    !end.is_branch_end && matches!(end.label, Some(Label::PeriodDoubling | Label::BranchPoint))
}

/// Whether a range belongs to the branch that is born at the end of another one.
fn is_born(from: &StableRange, end: RangeEnd, range: &StableRange) -> bool {
    let begins =
        |own: &RangeEnd| own.is_branch_end && own.label == end.label && is_same(own.value, end.value);
    is_doubling(end) && range.letters == 2 * from.letters && [range.from, range.to].iter().any(begins)
}
