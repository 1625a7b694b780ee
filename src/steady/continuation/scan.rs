//! Scan along the parameter: intervals with real roots, nodes, special points, and the joining of
//! sheets.

use super::super::Sheet;
use super::{BranchPoint, Curve, Family, LOCATION, Special};
use crate::error::Result;
use std::cell::Cell;
use vibro_numerics::roots::brent;

/// Largest number of golden-section steps to a hidden extremum of the discriminant between three
/// nodes.
const GOLDEN_STEPS: usize = 40;

/// Interval of the parameter with real roots; each end is a fold or an end of the range.
pub struct Interval {
    from: f64,
    to: f64,
    fold_from: bool,
    fold_to: bool,
}

/// Points in order of a connected piece of one sheet or, once joined, of a curve.
pub type SheetRun<P> = Vec<BranchPoint<P>>;

/// Family over its parameter, with the number of nodes per interval.
pub struct Scan<M> {
    family: M,
    nodes: usize,
}

/// Width of the interval about a special point at which its search ends.
fn width(value: f64) -> f64 {
    0.1 * LOCATION * value.abs().max(1.0)
}

impl<F: Family, M: Fn(f64) -> Result<F>> Scan<M> {
    /// Scan of `family`, which gives the family at each value of the parameter.
    pub fn new(family: M, nodes: usize) -> Self {
        Self { family, nodes }
    }

    /// Last value between `inside` and `outside` at which a condition holds, by bisection. The
    /// condition holds at `inside` and not at `outside`.
    fn last_value_inside(
        &self,
        mut inside: f64,
        mut outside: f64,
        holds: impl Fn(&F) -> Result<bool>,
    ) -> Result<f64> {
        while (outside - inside).abs() > width(inside) {
            let middle = 0.5 * (inside + outside);
            if middle == inside || middle == outside {
                break;
            }
            if holds(&(self.family)(middle)?)? { inside = middle } else { outside = middle }
        }
        Ok(inside)
    }

    /// Intervals of the range with real roots of the quadratic.
    pub fn intervals(&self, from: f64, to: f64) -> Result<Vec<Interval>> {
        let n = self.nodes;
        let discriminant = |v: f64| (self.family)(v).map(|f| f.discriminant());
        let mut nodes = Vec::with_capacity(n + 1);
        for i in 0..=n {
            let v = if i == n { to } else { from + (to - from) * i as f64 / n as f64 };
            nodes.push((v, discriminant(v)?));
        }
        // A pair of zeros between two nodes is indicated by a minimum of |discriminant| at a node.
        let mut hidden = Vec::new();
        for w in nodes.windows(3) {
            let sign = if w[1].1 < 0.0 { -1.0 } else { 1.0 };
            let [a, b, c] = [w[0].1, w[1].1, w[2].1].map(|d| sign * d);
            if b <= a && b <= c && a >= 0.0 && c >= 0.0 {
                let v = self.least_discriminant(w[0].0, w[2].0, sign)?;
                let d = discriminant(v)?;
                if sign * d < 0.0 {
                    hidden.push((v, d));
                }
            }
        }
        nodes.extend(hidden);
        nodes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut intervals = Vec::new();
        let mut start = (nodes[0].1 >= 0.0).then_some((from, false));
        for w in nodes.windows(2) {
            let real = |f: &F| Ok(f.discriminant() >= 0.0);
            match (w[0].1 >= 0.0, w[1].1 >= 0.0, start) {
                (true, false, Some((from, fold_from))) => {
                    let to = self.last_value_inside(w[0].0, w[1].0, real)?;
                    intervals.push(Interval { from, to, fold_from, fold_to: true });
                    start = None;
                }
                (false, true, _) => start = Some((self.last_value_inside(w[1].0, w[0].0, real)?, true)),
                _ => {}
            }
        }
        if let Some((from, fold_from)) = start {
            intervals.push(Interval { from, to, fold_from, fold_to: false });
        }
        Ok(intervals)
    }

    /// Value in [a, b] at which sign × discriminant is least, by golden section; ends at the first
    /// negative value.
    fn least_discriminant(&self, mut a: f64, mut b: f64, sign: f64) -> Result<f64> {
        let golden = 0.5 * (5f64.sqrt() - 1.0);
        let value = |v: f64| (self.family)(v).map(|f| sign * f.discriminant());
        let (mut low, mut high) = (b - golden * (b - a), a + golden * (b - a));
        let (mut at_low, mut at_high) = (value(low)?, value(high)?);
        for _ in 0..GOLDEN_STEPS {
            if at_low < 0.0 || at_high < 0.0 {
                break;
            }
            if at_low < at_high {
                (b, high, at_high) = (high, low, at_low);
                low = b - golden * (b - a);
                at_low = value(low)?;
            } else {
                (a, low, at_low) = (low, high, at_high);
                high = a + golden * (b - a);
                at_high = value(high)?;
            }
        }
        Ok(if at_low < at_high { low } else { high })
    }

    /// Point of a sheet at a value of the parameter; `None` if the root is not positive.
    fn point(
        &self,
        value: f64,
        sheet: Sheet,
        special: Option<Special>,
    ) -> Result<Option<BranchPoint<F::Solution>>> {
        let solution = (self.family)(value)?.solution(sheet)?;
        Ok(solution.map(|solution| BranchPoint {
            value,
            sheet,
            solution,
            stable: F::is_stable(&solution),
            special,
        }))
    }

    /// Runs of steady states on one sheet over an interval, by increasing parameter. A run ends
    /// where the root is no longer positive.
    pub fn sheet(&self, interval: &Interval, sheet: Sheet) -> Result<Vec<SheetRun<F::Solution>>> {
        let root = |f: &F| f.root(sheet).unwrap_or(f64::NAN) > 0.0;
        let (half, n) = (0.5 * (interval.to - interval.from), self.nodes);
        let mut runs: Vec<SheetRun<F::Solution>> = Vec::new();
        let mut before: Option<(f64, bool)> = None;
        for i in 0..=n {
            let value = match i {
                0 => interval.from,
                i if i == n => interval.to,
                _ => interval.from + half * (1.0 - (std::f64::consts::PI * i as f64 / n as f64).cos()),
            };
            let end = |fold| Some(if fold { Special::Fold } else { Special::RangeEnd });
            let special = match i {
                0 => end(interval.fold_from),
                i if i == n => end(interval.fold_to),
                _ => None,
            };
            let point = self.point(value, sheet, special)?;
            let exists = point.is_some();
            if let Some((last, existed)) = before.filter(|b| b.1 != exists) {
                let (inside, outside) = if existed { (last, value) } else { (value, last) };
                let edge = self.last_value_inside(inside, outside, |f| Ok(root(f)))?;
                let end = self.point(edge, sheet, Some(Special::Vanishing))?;
                match (end, existed) {
                    (Some(end), true) => self.extend(&mut runs, end)?,
                    (end, false) => runs.push(end.into_iter().collect()),
                    (None, true) => {}
                }
            }
            if let Some(point) = point {
                if before.is_none() {
                    runs.push(Vec::new());
                }
                self.extend(&mut runs, point)?;
            }
            before = Some((value, exists));
        }
        Ok(runs)
    }

    /// Appends a point to the last run, after the special points between them.
    fn extend(&self, runs: &mut [SheetRun<F::Solution>], next: BranchPoint<F::Solution>) -> Result<()> {
        let Some(run) = runs.last_mut() else { return Ok(()) };
        let Some(&last) = run.last() else {
            run.push(next);
            return Ok(());
        };
        if next.value <= last.value {
            // The edge of the sheet coincides with a node: the special point of the two is kept.
            if last.special.is_none() {
                run.pop();
                run.push(next);
            }
            return Ok(());
        }
        let mut found = self.bifurcations(&last, &next)?;
        found.extend(self.grazing(&last, &next)?);
        found.sort_by(|a, b| a.value.total_cmp(&b.value));
        run.extend(found);
        run.push(next);
        Ok(())
    }

    /// Bifurcations between two neighbours on a sheet, where a test function changes its sign.
    fn bifurcations(
        &self,
        last: &BranchPoint<F::Solution>,
        next: &BranchPoint<F::Solution>,
    ) -> Result<Vec<BranchPoint<F::Solution>>> {
        let mut found = Vec::new();
        let (a, b) = (F::tests(&last.solution), F::tests(&next.solution));
        for index in 0..a.len() {
            if (a[index] > 0.0) == (b[index] > 0.0) {
                continue;
            }
            let failure = Cell::new(None);
            let test = |v: f64| match self.point(v, next.sheet, None) {
                Ok(Some(p)) => F::tests(&p.solution)[index],
                Ok(None) => f64::NAN,
                Err(e) => {
                    failure.set(Some(e));
                    f64::NAN
                }
            };
            let zero = brent(test, last.value, next.value, width(last.value));
            if let Some(e) = failure.take() {
                return Err(e);
            }
            let Some(point) = zero.map(|v| self.point(v, next.sheet, None)).transpose()?.flatten() else {
                continue;
            };
            if let Some(kind) = F::confirm(&point.solution, index) {
                found.push(BranchPoint { special: Some(Special::Bifurcation(kind)), ..point });
            }
        }
        Ok(found)
    }

    /// Point between two neighbours on a sheet at which the block begins to touch a stop between
    /// its impacts, if there is one.
    fn grazing(
        &self,
        last: &BranchPoint<F::Solution>,
        next: &BranchPoint<F::Solution>,
    ) -> Result<Option<BranchPoint<F::Solution>>> {
        let (was_clear, is_clear) = (F::is_clear(&last.solution), F::is_clear(&next.solution));
        if was_clear == is_clear {
            return Ok(None);
        }
        let clear = |f: &F| Ok(f.solution(next.sheet)?.is_some_and(|s| F::is_clear(&s)));
        let (inside, outside) = if was_clear { (last.value, next.value) } else { (next.value, last.value) };
        let edge = self.last_value_inside(inside, outside, clear)?;
        self.point(edge, next.sheet, Some(Special::Grazing))
    }

    /// Joins runs end to end at their folds. The runs of the upper sheet must have increasing
    /// parameter, the runs of the lower sheet decreasing parameter.
    pub fn join(&self, mut runs: Vec<SheetRun<F::Solution>>) -> Result<Vec<Curve<F::Solution>>> {
        let fold = |point: Option<&BranchPoint<F::Solution>>| {
            point.filter(|p| p.special == Some(Special::Fold)).map(|p| p.value)
        };
        let (first, last) =
            (|r: &SheetRun<F::Solution>| fold(r.first()), |r: &SheetRun<F::Solution>| fold(r.last()));
        let mut i = 0;
        while i < runs.len() {
            let follows = |(j, run): (usize, &SheetRun<F::Solution>)| {
                j != i && last(&runs[i]).is_some() && first(run) == last(&runs[i])
            };
            let Some(j) = runs.iter().enumerate().position(follows) else {
                i += 1;
                continue;
            };
            let tail = runs.remove(j);
            i -= usize::from(j < i);
            runs[i].extend(tail.into_iter().skip(1));
        }
        runs.iter_mut().try_for_each(|run| self.mark_stability(run))?;
        let curve = |points: SheetRun<F::Solution>| {
            let closed = points.len() > 1 && first(&points).is_some() && first(&points) == last(&points);
            Curve { points, closed }
        };
        Ok(runs.into_iter().map(curve).collect())
    }

    /// Gives each special point the stability of the piece that follows, and the last point the
    /// stability of the piece before it.
    fn mark_stability(&self, run: &mut SheetRun<F::Solution>) -> Result<()> {
        for i in 0..run.len() {
            if run[i].special.is_none() {
                continue;
            }
            let Some(other) = run.get(i + 1).or(i.checked_sub(1).and_then(|j| run.get(j))) else { continue };
            // A fold belongs to both sheets. Its neighbour determines the sheet of the piece.
            let sheet = if run[i].special == Some(Special::Fold) { other.sheet } else { run[i].sheet };
            let middle = 0.5 * (run[i].value + other.value);
            let stable = self.point(middle, sheet, None)?.is_some_and(|p| p.stable);
            run[i].stable = stable;
        }
        Ok(())
    }
}
