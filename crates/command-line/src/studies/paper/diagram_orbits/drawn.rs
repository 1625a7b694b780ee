//! Branches drawn over a diagram: curves of their local maxima, stable and unstable, and marks
//! where stability changes.

use crate::Result;
use crate::studies::branches::{MARKS, colour, period_name};
use crate::studies::paper::lengths::Lengths;
use crate::studies::paper::maxima_panel::maxima_panel;
use crate::table::{CsvRows, exact};
use rayon::prelude::*;
use std::collections::BTreeMap;
use vibro_figures::canvas::palette::{BLACK, WHITE};
use vibro_figures::chart::{Colour, Dash, LINE, Layer, Mark, Panel, Path, Shape, THIN};
use vibro_orbits::paper::{Branch, Family};
use vibro_studies::paper::ParameterSet;
use vibro_studies::paper::bifurcation::{Diagram, Sweep};

/// Fraction of white that is mixed into the diagram's points, so that the branches are clearly
/// visible.
const PALE: f64 = 0.55;
/// Longest period of an orbit whose unstable pieces are drawn. Hundreds of orbits with longer
/// periods would cover the picture.
pub(super) const UNSTABLE: u32 = 2;
/// Upper limit of the drawn orbits' periods, for a branch without a stable range.
pub(super) const NEVER_STABLE: u32 = 1;

/// A curve of a local maximum along a piece of a branch.
struct BranchCurve {
    branch: usize,
    stable: bool,
    points: Path,
}

/// A mark of a change of stability: index into [`MARKS`] and position.
type StabilityMark = (usize, (f64, f64));

/// The drawn parts of the branches.
pub(super) struct Drawn {
    curves: Vec<BranchCurve>,
    /// Places where stability changes.
    marks: Vec<Path>,
}

impl Drawn {
    pub(super) fn new(family: &Family, branches: &[Branch], sweep: &Sweep, lengths: &Lengths) -> Self {
        let weights = sweep.of.weights();
        let scaled = |branch: &Branch, weights: [f64; 3]| -> Vec<Vec<f64>> {
            let mut found = branch.maxima(family, weights);
            for (point, all) in branch.points.iter().zip(&mut found) {
                all.iter_mut().for_each(|x| *x *= lengths.ratio(sweep.axis.name, point.value));
            }
            found
        };
        let is_drawn = |b: &&Branch| b.word().period() <= NEVER_STABLE || b.is_somewhere_stable();
        let shown: Vec<&Branch> = branches.iter().filter(is_drawn).collect();
        let found: Vec<(Vec<BranchCurve>, Vec<StabilityMark>)> = shown
            .par_iter()
            .map(|branch| {
                // The mirror image of an unsymmetric orbit is another orbit; its maxima are the
                // minima of this one with the opposite sign. Under constant loads there is no
                // mirror image.
                let mut sides = vec![scaled(branch, weights)];
                if branch.word().closing() > 0 && family.is_symmetric() {
                    sides.push(scaled(branch, weights.map(|w| -w)));
                }
                let all = sides.iter().flat_map(|maxima| curves(branch, maxima));
                let curves = all.filter(|curve| curve.stable || branch.word().period() <= UNSTABLE).collect();
                (curves, marks(branch, &sides))
            })
            .collect();
        let mut drawn = Self { curves: Vec::new(), marks: vec![Path::new(); MARKS.len()] };
        for (curves, marks) in found {
            drawn.curves.extend(curves);
            marks.into_iter().for_each(|(kind, place)| drawn.marks[kind].push(place));
        }
        drawn
    }

    pub(super) fn panel(
        &self,
        set: &ParameterSet,
        sweep: &Sweep,
        diagram: &Diagram,
        branches: &[Branch],
    ) -> Panel {
        let mut panel = maxima_panel(set, sweep, diagram, &diagram.apart());
        panel.title = String::new();
        panel.layers.iter_mut().for_each(pale);
        // Drawn by period, unstable curves below.
        let mut pieces: BTreeMap<(bool, Colour), Vec<Path>> = BTreeMap::new();
        for curve in &self.curves {
            let tint = colour(branches[curve.branch].word().period());
            pieces.entry((curve.stable, tint)).or_default().push(curve.points.clone());
        }
        for ((stable, colour), pieces) in pieces {
            let (dash, stroke) = if stable { (Dash::Solid, LINE) } else { (Dash::Dashed, THIN) };
            panel.layers.push(Layer::lines("", colour, dash, pieces).stroke(stroke));
        }
        let mut periods: Vec<u32> = self.curves.iter().map(|c| branches[c.branch].word().period()).collect();
        periods.sort_unstable();
        let mut names: Vec<(String, Colour)> =
            periods.iter().map(|p| (period_name(*p), colour(*p))).collect();
        names.dedup();
        panel.layers.extend(names.iter().map(|(name, c)| Layer::lines(name, *c, Dash::Solid, Vec::new())));
        panel.layers.push(Layer::lines("unstable", BLACK, Dash::Dashed, Vec::new()).stroke(THIN));
        for ((_, name, mark), points) in MARKS.into_iter().zip(&self.marks) {
            if !points.is_empty() {
                // A white edge shows the mark on curves of any colour.
                if matches!(mark, Mark::Disc | Mark::Square | Mark::Triangle) {
                    panel.layers.push(Layer::marks("", WHITE, mark, points.clone()).stroke(12));
                }
                panel.layers.push(Layer::marks(name, BLACK, mark, points.clone()).stroke(9));
            }
        }
        panel
    }

    /// Table of the drawn curves, in units of the set's own gap.
    pub(super) fn table(&self, sweep: &Sweep, branches: &[Branch]) -> Result<Vec<u8>> {
        let maximum = format!("{}_maximum", sweep.of.name());
        let mut table = CsvRows::new([
            "curve",
            "branch",
            "word",
            "closing",
            "period",
            "stable",
            sweep.axis.name.name(),
            &maximum,
        ])?;
        for (i, curve) in self.curves.iter().enumerate() {
            let word = branches[curve.branch].word();
            for (value, maximum) in &curve.points {
                table.push([
                    i.to_string(),
                    curve.branch.to_string(),
                    word.to_string(),
                    word.sign().into(),
                    word.period().to_string(),
                    curve.stable.to_string(),
                    exact(*value),
                    exact(*maximum),
                ])?;
            }
        }
        table.text()
    }
}

/// Makes the points of a diagram pale.
fn pale(layer: &mut Layer) {
    match &mut layer.shape {
        Shape::Cells { colours, .. } => {
            colours.iter_mut().flatten().for_each(|colour| *colour = colour.towards(WHITE, PALE));
        }
        Shape::Band { .. } => layer.colour = layer.colour.towards(WHITE, PALE),
        _ => {}
    }
}

/// Marks at the ends of a branch's stable ranges, at the largest maximum of the orbit and of its
/// mirror image.
fn marks(branch: &Branch, sides: &[Vec<Vec<f64>>]) -> Vec<StabilityMark> {
    let ranges = branch.stable_ranges();
    let ends = ranges.iter().flat_map(|range| [range.points.0, range.points.1]);
    let placed = ends.filter_map(|point| {
        let label = branch.points[point].label()?;
        let kind = MARKS.iter().position(|mark| mark.0 == label)?;
        Some((point, kind))
    });
    placed
        .flat_map(|(point, kind)| {
            let tops = sides.iter().filter_map(move |maxima| maxima[point].first());
            tops.map(move |top| (kind, (branch.points[point].value, *top)))
        })
        .collect()
}

/// Connects the local maxima along a branch to curves, which end where stability changes and where
/// a maximum appears or vanishes.
fn curves(branch: &Branch, maxima: &[Vec<f64>]) -> Vec<BranchCurve> {
    let mut found = Vec::new();
    let mut open: Vec<Path> = Vec::new();
    let mut state = None;
    let close = |open: &mut Vec<Path>, stable: bool, found: &mut Vec<BranchCurve>| {
        let curves = std::mem::take(open).into_iter().filter(|points| points.len() > 1);
        found.extend(curves.map(|points| BranchCurve { branch: branch.id, stable, points }));
    };
    for (pair, tops) in branch.points.windows(2).zip(maxima.windows(2)) {
        let stable = pair[0].is_stable();
        if state != Some(stable) {
            close(&mut open, state.unwrap_or(stable), &mut found);
            open = tops[0].iter().map(|top| vec![(pair[0].value, *top)]).collect();
            state = Some(stable);
        }
        let mut last = std::mem::take(&mut open);
        let from = partners(&tops[0], &tops[1]);
        open = from
            .iter()
            .zip(&tops[1])
            .map(|(from, top)| {
                let mut path = from.and_then(|i| last.get_mut(i)).map(std::mem::take).unwrap_or_default();
                path.push((pair[1].value, *top));
                path
            })
            .collect();
        close(&mut last, stable, &mut found);
    }
    close(&mut open, state.unwrap_or(false), &mut found);
    found
}

/// For each maximum at a point, the index of the maximum at the point before that continues into
/// it; nearest pairs are matched first. Both lists are in falling order.
fn partners(before: &[f64], after: &[f64]) -> Vec<Option<usize>> {
    if before.len() == after.len() {
        return (0..after.len()).map(Some).collect();
    }
    let mut pairs: Vec<(usize, usize)> =
        (0..before.len()).flat_map(|a| (0..after.len()).map(move |b| (a, b))).collect();
    let distance = |(a, b): &(usize, usize)| (before[*a] - after[*b]).abs();
    pairs.sort_by(|p, q| distance(p).total_cmp(&distance(q)));
    let mut from = vec![None; after.len()];
    let mut taken = vec![false; before.len()];
    for (a, b) in pairs {
        if !taken[a] && from[b].is_none() {
            (taken[a], from[b]) = (true, Some(a));
        }
    }
    from
}
