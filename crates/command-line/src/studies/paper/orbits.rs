//! Branches of periodic orbits over a parameter, with their bifurcations.

use super::lengths::Lengths;
use crate::Result;
use crate::studies::{Study, parameter_axis};
use crate::table::{CsvRows, exact};
use rayon::prelude::*;
use std::collections::BTreeMap;
use vibro_figures::canvas::palette::{BLACK, FAMILY, GREY};
use vibro_figures::chart::{Axis, Colour, Dash, Figure, LINE, Layer, Mark, Panel, Path, THIN};
use vibro_orbits::paper::{Branch, Family, Label, Searched, Span};
use vibro_studies::paper::ParameterSet;

/// Weights of X1, X2, X3 in the weighted sum that equals X2.
const BLOCK: [f64; 3] = [0.0, 1.0, 0.0];
/// Longest period that has a colour of its own.
pub(in crate::studies) const COLOURED: usize = FAMILY.len();
/// Largest number of special points at which the picture marks all of them; more marks would cover
/// the branches.
const MARKED: usize = 150;

/// Marks of special points.
pub(in crate::studies) const MARKS: [(Label, &str, Mark); 8] = [
    (Label::Fold, "LP fold", Mark::Disc),
    (Label::BranchPoint, "BP branch point", Mark::Square),
    (Label::PeriodDoubling, "PD period doubling", Mark::Triangle),
    (Label::NeimarkSacker, "NS Neimark–Sacker", Mark::Cross),
    (Label::Grazing, "GR touch", Mark::Ring),
    (Label::Chatter, "CH chatter", Mark::Target),
    (Label::NoConvergence, "MX not followed on", Mark::Plus),
    (Label::UserValue, "UZ value asked for", Mark::Diamond),
];

/// The study of branches over the one parameter of a family: tables of the branches and special
/// points, for a tree a table of the search, and a picture.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output).
pub fn orbits(
    set: &ParameterSet,
    family: &Family,
    branches: &[Branch],
    searched: Option<&Searched>,
) -> Result<Study> {
    let span = *family.span();
    let tops: Vec<Vec<f64>> = branches.par_iter().map(|b| largest(family, b)).collect();
    let specials = branches.iter().flat_map(|b| &b.points).filter(|p| p.special.is_some()).count();
    let points: usize = branches.iter().map(|b| b.points.len()).sum();
    let marks = special_marks(branches, &tops);
    let mut caption = vec!["Full: stable; dashed: unstable. One colour for each period.".into()];
    if marks.of_stable_only {
        caption.push("Marks: where a branch gains or loses its stability, or ends stable; special-points.csv has the others.".into());
    }
    caption.push(format!("Elsewhere {}", set.caption_but(&[span.name])));
    let what = format!("{} branches of periodic orbits over {}", branches.len(), span.name.symbol());
    let figure = Figure {
        title: format!("Periodic orbits over {}", set.symbol(span.name)),
        caption,
        panels: vec![panel(set, &span, branches, &tops, marks)],
        columns: 1,
        panel: (2900, 1700),
        shared_legend: false,
    };
    let mut tables = vec![
        ("branches".into(), branch_table(&span, branches, &tops)?),
        ("special-points".into(), special_table(&span, branches)?),
    ];
    let mut told = remarks(branches, points, specials);
    if let Some(searched) = searched {
        told.push(search_in_words(searched));
        tables.push(("orbits-search".into(), search_table(&span, searched)?));
    }
    Ok(Study { tables, figure: Some(figure), ..Study::without_figure("orbits", what).with_remarks(told) })
}

/// Description of the search for the orbits of a tree.
pub(in crate::studies) fn search_in_words(searched: &Searched) -> String {
    let Searched { values, periods, followed, islands } = searched;
    let settled = values.iter().flat_map(|v| [v.rising, v.falling]).flatten().count();
    let starts: u32 = values.iter().map(|v| v.starts).sum();
    let ways = format!(
        "searched from motions at {} values, rising and falling, of which {settled} settled on a stable orbit",
        values.len()
    );
    if starts == 0 {
        return ways;
    }
    format!(
        "{ways}, and from {starts} starts over the states they visit, half again as wide, for {periods} periods each: of {followed} more \
         branches near whose orbits these passed {islands} are stable somewhere and were kept"
    )
}

/// Table of the search by value; starts lie between the value and the next one.
fn search_table(span: &Span, searched: &Searched) -> Result<Vec<u8>> {
    let mut table =
        CsvRows::new([span.name.name(), "period_rising", "period_falling", "starts", "orbits_passed"])?;
    let period = |period: Option<u32>| period.map_or(String::new(), |p| p.to_string());
    for v in &searched.values {
        let (rising, falling) = (period(v.rising), period(v.falling));
        table.push([exact(v.value), rising, falling, v.starts.to_string(), v.found.to_string()])?;
    }
    table.text()
}

/// The largest X2 at each point. Without loads, it is the larger one of the orbit and its mirror
/// image, which is an orbit too. NaN if there is none; pictures and tables leave it out.
fn largest(family: &Family, branch: &Branch) -> Vec<f64> {
    let own = branch.maxima(family, BLOCK);
    let mirror = if family.is_symmetric() { BLOCK.map(|w| -w) } else { BLOCK };
    let image = branch.maxima(family, mirror);
    let first = |all: &Vec<f64>| all.first().copied().unwrap_or(f64::NAN);
    own.iter().zip(&image).map(|(a, b)| first(a).max(first(b))).collect()
}

fn remarks(branches: &[Branch], points: usize, specials: usize) -> Vec<String> {
    let mut labels: BTreeMap<&str, usize> = BTreeMap::new();
    for label in branches.iter().flat_map(|b| b.points.iter().filter_map(|p| p.label())) {
        *labels.entry(label.name()).or_default() += 1;
    }
    let counts: Vec<String> = labels.iter().map(|(label, count)| format!("{count} {label}")).collect();
    let stable = branches.iter().filter(|b| b.points.iter().any(|p| p.stable)).count();
    vec![
        format!(
            "{points} orbits, each certified but for the touch at GR; {stable} branches are stable somewhere"
        ),
        format!("{specials} special points: {}", counts.join(", ")),
    ]
}

/// Cell of a number; empty for NaN.
fn or_empty(value: f64) -> String {
    if value.is_finite() { exact(value) } else { String::new() }
}

/// Table of all points of all branches, as in AUTO's b-files.
fn branch_table(span: &Span, branches: &[Branch], tops: &[Vec<f64>]) -> Result<Vec<u8>> {
    let name = span.name.name();
    let mut table = CsvRows::new([
        "branch",
        "parent",
        "point",
        "label",
        name,
        "period",
        "word",
        "closing",
        "stable",
        "multiplier",
        "X2_max",
        "phase",
        "flights",
    ])?;
    for (branch, tops) in branches.iter().zip(tops) {
        let parent = branch.parent.map_or(String::new(), |(id, point)| format!("{id}:{point}"));
        for (i, (point, top)) in branch.points.iter().zip(tops).enumerate() {
            let ends = point.phases.iter().skip(1).copied();
            let last = point.phases.first().map(|first| first + branch.word.span());
            let flights = point.phases.iter().zip(ends.chain(last)).map(|(a, b)| exact(b - a));
            table.push([
                branch.id.to_string(),
                parent.clone(),
                i.to_string(),
                point.label().map_or("", Label::name).into(),
                exact(point.value),
                branch.word.period().to_string(),
                branch.word.to_string(),
                branch.word.sign().into(),
                point.stable.to_string(),
                or_empty(point.multipliers[0].norm()),
                or_empty(*top),
                point.phases.first().map_or(String::new(), |p| exact(*p)),
                flights.collect::<Vec<_>>().join(" "),
            ])?;
        }
    }
    table.text()
}

/// Table of the special points, with what another study needs to start from them.
pub(in crate::studies) fn special_table(span: &Span, branches: &[Branch]) -> Result<Vec<u8>> {
    let mut table = CsvRows::new([
        "label",
        "branch",
        "point",
        "parameter",
        "value",
        "word",
        "closing",
        "period",
        "longer_word",
        "turns",
        "stable_before",
        "stable_after",
        "phases",
    ])?;
    for branch in branches {
        for (i, point) in branch.points.iter().enumerate() {
            let Some(special) = &point.special else { continue };
            let (before, after) = branch.stability_around(i);
            let turns = match special.fold {
                Some(true) => "fold",
                Some(false) => "through",
                None => "",
            };
            let phases: Vec<String> = point.phases.iter().map(|p| exact(*p)).collect();
            table.push([
                special.label.name().into(),
                branch.id.to_string(),
                i.to_string(),
                span.name.name().into(),
                exact(point.value),
                branch.word.to_string(),
                branch.word.sign().into(),
                branch.word.period().to_string(),
                special.longer.as_ref().map_or(String::new(), ToString::to_string),
                turns.into(),
                before.to_string(),
                after.to_string(),
                phases.join(" "),
            ])?;
        }
    }
    table.text()
}

/// The colour of a period.
pub(in crate::studies) fn colour(period: u32) -> Colour {
    FAMILY.get(period as usize - 1).copied().unwrap_or(GREY)
}

/// A branch as a picture has it.
pub(in crate::studies) struct DrawnBranch<'a> {
    /// The period in periods of the drive, which chooses the colour.
    pub period: u32,
    /// By point: the parameter, and whether the piece from there to the next is stable.
    pub points: Vec<(f64, bool)>,
    /// By point: what is drawn; the picture leaves out what is not finite.
    pub tops: &'a [f64],
}

/// Pieces of branches by period and stability.
type PiecesByPeriod = BTreeMap<(u32, bool), Vec<Path>>;

fn pieces(branches: &[DrawnBranch]) -> PiecesByPeriod {
    let mut found = PiecesByPeriod::new();
    for branch in branches {
        let mut state = None;
        for (pair, tops) in branch.points.windows(2).zip(branch.tops.windows(2)) {
            if tops.iter().any(|t| !t.is_finite()) {
                state = None;
                continue;
            }
            let stable = pair[0].1;
            let all = found.entry((branch.period.min(COLOURED as u32 + 1), stable)).or_default();
            if state != Some(stable) {
                all.push(vec![(pair[0].0, tops[0])]);
                state = Some(stable);
            }
            all.last_mut().into_iter().for_each(|path| path.push((pair[1].0, tops[1])));
        }
    }
    found
}

/// The curves of branches, and their colours by period. Short periods are drawn above long ones,
/// and stable pieces above all.
pub(in crate::studies) fn branch_layers(branches: &[DrawnBranch]) -> Vec<Layer> {
    let mut unstable = Vec::new();
    let mut stable = Vec::new();
    let mut periods: Vec<u32> = Vec::new();
    for ((period, is_stable), paths) in pieces(branches).into_iter().rev() {
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
    for period in periods {
        let more = period as usize > COLOURED;
        let name = if more { "longer".into() } else { format!("{period}T") };
        layers.push(Layer::lines(&name, colour(period), Dash::Solid, Vec::new()));
    }
    layers
}

/// The marks of special points.
struct SpecialMarks {
    layers: Vec<Layer>,
    /// Whether only points that bound a stable piece are shown, since there are more than
    /// [`MARKED`].
    of_stable_only: bool,
}

/// Whether a branch gains or loses its stability at a point, or ends there while stable.
fn bounds_stability(branch: &Branch, point: usize) -> bool {
    let (before, after) = branch.stability_around(point);
    let ends = point == 0 || point + 1 == branch.points.len();
    before != after || (ends && after)
}

fn special_marks(branches: &[Branch], tops: &[Vec<f64>]) -> SpecialMarks {
    let marked = |label: Label, all: bool| -> Path {
        let points = branches.iter().zip(tops).flat_map(|(b, tops)| {
            b.points.iter().zip(tops).enumerate().map(move |(i, (p, top))| (b, i, p, *top))
        });
        points
            .filter(|(b, i, p, top)| {
                p.label() == Some(label)
                    && top.is_finite()
                    && (all || label == Label::UserValue || bounds_stability(b, *i))
            })
            .map(|(_, _, p, top)| (p.value, top))
            .collect()
    };
    let count: usize = MARKS.iter().map(|(label, ..)| marked(*label, true).len()).sum();
    let of_stable_only = count > MARKED;
    let layers = MARKS.into_iter().filter_map(|(label, name, mark)| {
        let points = marked(label, !of_stable_only);
        (!points.is_empty()).then(|| Layer::marks(name, BLACK, mark, points).stroke(9))
    });
    SpecialMarks { layers: layers.collect(), of_stable_only }
}

fn panel(
    set: &ParameterSet,
    span: &Span,
    branches: &[Branch],
    tops: &[Vec<f64>],
    marks: SpecialMarks,
) -> Panel {
    let drawn: Vec<DrawnBranch> = branches
        .iter()
        .zip(tops)
        .map(|(branch, tops)| DrawnBranch {
            period: branch.word.period(),
            points: branch.points.iter().map(|p| (p.value, p.stable)).collect(),
            tops,
        })
        .collect();
    let mut layers = branch_layers(&drawn);
    layers.extend(marks.layers);
    let (x, lengths) = (parameter_axis(set, span.name, (span.from, span.to)), Lengths::of(set));
    // Over the gap itself each point is in units of its own gap.
    let y = match span.name.name() {
        "stop.gap" => Axis::new("largest X₂ (units of L)"),
        _ => lengths.axis(&format!("largest {}", lengths.displacement("X₂"))),
    };
    Panel { title: String::new(), x, y, layers }
}
