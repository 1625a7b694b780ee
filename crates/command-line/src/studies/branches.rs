//! Branches of periodic orbits over a parameter in tables and pictures, of any machine.

use super::Study;
use crate::Result;
use crate::table::{CsvRows, exact};
use rayon::prelude::*;
use std::collections::BTreeMap;
use vibro_figures::canvas::palette::{BLACK, FAMILY, GREY};
use vibro_figures::chart::{Axis, Colour, Dash, Figure, LINE, Layer, Mark, Panel, Path, THIN};
use vibro_orbits::{Branch, Label, OrbitPoint, Special};

/// Longest period with its own colour.
pub(super) const COLOURED: usize = FAMILY.len();
/// Cap on the marked special points; the picture marks none of a larger number, since they would
/// cover the branches.
const MARKED: usize = 150;

/// Marks of special points.
pub(super) const MARKS: [(Label, &str, Mark); 11] = [
    (Label::Fold, "LP fold", Mark::Disc),
    (Label::BranchPoint, "BP branch point", Mark::Square),
    (Label::PeriodDoubling, "PD period doubling", Mark::Triangle),
    (Label::NeimarkSacker, "NS Neimark–Sacker", Mark::Cross),
    (Label::Grazing, "GR touch", Mark::Ring),
    (Label::Chatter, "CH chatter", Mark::Target),
    (Label::NoConvergence, "MX not followed on", Mark::Plus),
    (Label::UserValue, "UZ value asked for", Mark::Diamond),
    (Label::Stick, "ST stick", Mark::Diamond),
    (Label::Crossing, "CC events change places", Mark::Frame),
    (Label::Saturation, "SA limit of an output", Mark::Funnel),
];

/// Texts and axes of a study of branches.
pub(super) struct Texts {
    /// Name of the study.
    pub name: String,
    /// Name of the parameter in the summary line of the study.
    pub over: String,
    pub title: String,
    /// A statement that holds for all orbits; it follows their number in a remark.
    pub certain: &'static str,
    /// The machine's other parameters, as a line of the caption.
    pub elsewhere: String,
    pub axes: [Axis; 2],
}

/// The study of branches over a parameter: a table of their points, one of their special points,
/// and a picture of the values `tops`.
pub(super) fn study<C>(
    branches: &[Branch<C>],
    tops: &[Vec<f64>],
    texts: Texts,
    [points, specials]: [Vec<u8>; 2],
) -> Study {
    let marks = marks(branches, tops);
    let mut caption = vec!["Full: stable; dashed: unstable. One colour for each period.".to_owned()];
    if marks.of_stable_only {
        caption.push("Marks: where a branch gains or loses its stability, or ends stable; special-points.csv has the others.".into());
    }
    caption.push(format!("Elsewhere {}", texts.elsewhere));
    let mut layers = branch_layers(branches.iter().zip(tops.iter().map(Vec::as_slice)));
    layers.extend(marks.layers);
    let [x, y] = texts.axes;
    let figure = Figure {
        title: texts.title,
        caption,
        panels: vec![Panel { title: String::new(), x, y, layers }],
        columns: 1,
        panel: (2900, 1700),
        shared_legend: false,
    };
    let what = format!("{} branches of periodic orbits over {}", branches.len(), texts.over);
    Study {
        tables: vec![("branches".into(), points), ("special-points".into(), specials)],
        figure: Some(figure),
        ..Study::without_figure(&texts.name, what).with_remarks(remarks(branches, texts.certain))
    }
}

/// Number of orbits, of stable branches, and of special points by their labels.
fn remarks<C>(branches: &[Branch<C>], certain: &str) -> Vec<String> {
    let mut labels: BTreeMap<&str, usize> = BTreeMap::new();
    let points = || branches.iter().flat_map(|b| &b.points);
    for label in points().filter_map(OrbitPoint::label) {
        *labels.entry(label.name()).or_default() += 1;
    }
    let counts: Vec<String> = labels.iter().map(|(label, count)| format!("{count} {label}")).collect();
    let stable = branches.iter().filter(|b| b.is_somewhere_stable()).count();
    vec![
        format!("{} orbits{certain}; {stable} branches are stable somewhere", points().count()),
        format!("{} special points: {}", labels.values().sum::<usize>(), counts.join(", ")),
    ]
}

/// Cell of a number; empty if it is not finite.
pub(super) fn cell(value: f64) -> String {
    if value.is_finite() { exact(value) } else { String::new() }
}

/// Cell of a number that may be absent.
pub(super) fn or_empty<T: ToString>(value: Option<T>) -> String {
    value.map_or(String::new(), |value| value.to_string())
}

/// Largest number of sequences of doublings, and of rows, listed on the screen.
pub(super) const MAX_LISTED: usize = 12;

/// Text with the number of rows, their description and the first rows; `None` if there are none.
pub(super) fn listed(what: &str, rows: impl ExactSizeIterator<Item = String>) -> Option<String> {
    let count = rows.len();
    let listed: Vec<String> = rows.take(MAX_LISTED).collect();
    let more = if count > MAX_LISTED { ", …" } else { "" };
    (count > 0).then(|| format!("{count} {what}: {}{more}", listed.join(", ")))
}

/// Numbers as one cell.
pub(super) fn list(numbers: impl IntoIterator<Item = f64>) -> String {
    numbers.into_iter().map(exact).collect::<Vec<_>>().join(" ")
}

/// A table of all points of all branches, as in AUTO's b-files: first the columns of any machine,
/// then the machine's own, with `cells` for the points of a branch.
pub(super) fn point_table<C>(
    parameter: &str,
    own: impl IntoIterator<Item = String>,
    branches: &[Branch<C>],
    cells: impl Fn(usize, &Branch<C>) -> Vec<Vec<String>>,
) -> Result<Vec<u8>> {
    let common = ["branch", "parent", "point", "label", parameter].map(str::to_owned);
    let mut table = CsvRows::new(common.into_iter().chain(own))?;
    for (k, branch) in branches.iter().enumerate() {
        let parent = branch.parent.map_or(String::new(), |(id, point)| format!("{id}:{point}"));
        for (i, (point, own)) in branch.points.iter().zip(cells(k, branch)).enumerate() {
            let label = point.label().map_or("", Label::name);
            let value = exact(point.value);
            let common = [branch.id.to_string(), parent.clone(), i.to_string(), label.into(), value];
            table.push(common.into_iter().chain(own))?;
        }
    }
    table.text()
}

/// The cells of a special point, by its index among the points of a branch.
pub(super) type SpecialCells<'a> = Box<dyn Fn(usize, &OrbitPoint, &Special) -> Vec<String> + 'a>;

/// A table of the special points, with the data that another study needs to start from them: first
/// the columns of any machine, then the machine's own.
pub(super) fn special_table<'a, C: Sync>(
    parameter: &str,
    own: &[&str],
    branches: &'a [Branch<C>],
    cells: impl Fn(&'a Branch<C>) -> SpecialCells<'a> + Sync,
) -> Result<Vec<u8>> {
    let mut table = CsvRows::new(["label", "branch", "point", "parameter", "value"].iter().chain(own))?;
    let rows = |branch: &'a Branch<C>| -> Vec<Vec<String>> {
        let cells = cells(branch);
        let row = |(i, point): (usize, &OrbitPoint)| {
            let special = point.special.as_ref()?;
            let (label, value) = (special.label.name().into(), exact(point.value));
            let common = [label, branch.id.to_string(), i.to_string(), parameter.into(), value];
            Some(common.into_iter().chain(cells(i, point, special)).collect())
        };
        branch.points.iter().enumerate().filter_map(row).collect()
    };
    let rows: Vec<_> = branches.par_iter().map(rows).collect();
    rows.into_iter().flatten().try_for_each(|row| table.push(row))?;
    table.text()
}

/// The colour of a period.
pub(super) fn colour(period: u32) -> Colour {
    FAMILY.get(period as usize - 1).copied().unwrap_or(GREY)
}

/// The name of a period in legends.
pub(super) fn period_name(period: u32) -> String {
    if period as usize <= COLOURED { format!("{period}T") } else { "longer".into() }
}

/// Pieces of branches by period and stability.
type PiecesByPeriod = BTreeMap<(u32, bool), Vec<Path>>;

fn pieces<'a, C: 'a, T: AsRef<[f64]>>(
    curves: impl IntoIterator<Item = (&'a Branch<C>, T)>,
) -> PiecesByPeriod {
    let mut found = PiecesByPeriod::new();
    for (branch, tops) in curves {
        let mut state = None;
        for (pair, tops) in branch.points.windows(2).zip(tops.as_ref().windows(2)) {
            if tops.iter().any(|t| !t.is_finite()) {
                state = None;
                continue;
            }
            let stable = pair[0].is_stable();
            let period = branch.periods.unwrap_or(1).min(COLOURED as u32 + 1);
            let all = found.entry((period, stable)).or_default();
            if state != Some(stable) {
                all.push(vec![(pair[0].value, tops[0])]);
                state = Some(stable);
            }
            all.last_mut().into_iter().for_each(|path| path.push((pair[1].value, tops[1])));
        }
    }
    found
}

/// The curves of branches, each with its values by point, coloured by period. Values that are not
/// finite are left out. Short periods are drawn above long ones, and stable pieces above all
/// others.
pub(super) fn branch_layers<'a, C: 'a, T: AsRef<[f64]>>(
    curves: impl IntoIterator<Item = (&'a Branch<C>, T)>,
) -> Vec<Layer> {
    let mut unstable = Vec::new();
    let mut stable = Vec::new();
    let mut periods: Vec<u32> = Vec::new();
    for ((period, is_stable), paths) in pieces(curves).into_iter().rev() {
        if !periods.contains(&period) {
            periods.insert(0, period);
        }
        if is_stable {
            stable.push(Layer::lines("", colour(period), Dash::Solid, paths).stroke(LINE + 2));
        } else {
            let width = if period as usize > COLOURED { THIN / 2 } else { THIN };
            unstable.push(Layer::lines("", colour(period), Dash::Dashed, paths).stroke(width));
        }
    }
    let mut layers = unstable;
    layers.extend(stable);
    let name = |period| Layer::lines(&period_name(period), colour(period), Dash::Solid, Vec::new());
    layers.extend(periods.into_iter().map(name));
    layers
}

/// The marks of special points.
pub(super) struct SpecialMarks {
    pub layers: Vec<Layer>,
    /// Whether only points that bound a stable piece are shown, since there are more than
    /// [`MARKED`].
    of_stable_only: bool,
}

pub(super) fn marks<C>(branches: &[Branch<C>], tops: &[Vec<f64>]) -> SpecialMarks {
    let marked = |label: Label, all: bool| -> Path {
        let all = all || label == Label::UserValue;
        let of = |(branch, tops): (&Branch<C>, &Vec<f64>)| -> Path {
            let points = branch.points.iter().zip(tops).enumerate();
            let own = points.filter(|(i, (point, top))| {
                point.label() == Some(label) && top.is_finite() && (all || branch.bounds_stability(*i))
            });
            own.map(|(_, (point, top))| (point.value, *top)).collect()
        };
        branches.iter().zip(tops).flat_map(of).collect()
    };
    let count: usize = MARKS.iter().map(|(label, ..)| marked(*label, true).len()).sum();
    let of_stable_only = count > MARKED;
    let layers = MARKS.into_iter().filter_map(|(label, name, mark)| {
        let points = marked(label, !of_stable_only);
        (!points.is_empty()).then(|| Layer::marks(name, BLACK, mark, points).stroke(9))
    });
    SpecialMarks { layers: layers.collect(), of_stable_only }
}
