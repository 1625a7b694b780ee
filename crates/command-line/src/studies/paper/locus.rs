//! Curves of bifurcations in two parameters.

use crate::Result;
use crate::studies::{Study, parameter_axis};
use crate::table::{CsvRows, exact};
use vibro_figures::canvas::palette::{BLACK, FAMILY};
use vibro_figures::chart::{Dash, Figure, Layer, Mark, Panel, Path};
use vibro_orbits::paper::{Family, LocusEnd, LocusPoint, LocusStart, Span};
use vibro_studies::paper::ParameterSet;

/// A curve and the special point from which it was followed.
#[derive(Clone, Debug)]
pub struct LocusCurve {
    /// File and row of its special point, in words.
    pub from: String,
    /// The row.
    pub row: usize,
    /// The special point.
    pub start: LocusStart,
    /// Its points.
    pub points: Vec<LocusPoint>,
    /// Other rows of the table for this point, found on another branch.
    pub also: Vec<usize>,
}

impl LocusCurve {
    fn drawn(&self) -> DrawnCurve {
        let LocusStart { label, word, .. } = &self.start;
        let name = format!("{label} {} {}T", word.signed(), word.period());
        DrawnCurve { name, points: self.points.iter().map(|p| (p.values, p.end)).collect() }
    }

    fn in_words(&self) -> String {
        let also = rows_of_one_point(&self.also);
        let LocusStart { label, .. } = self.start;
        format!(
            "{label} of {} from {}{}: {} points{}",
            self.start.word.signed(),
            self.from,
            also,
            self.points.len(),
            ends(self.points.iter().map(|p| (p.values, p.end)), |values| values.map(|x| format!("{x:.6}")))
        )
    }
}

/// Further rows of a special point, in words.
pub(in crate::studies) fn rows_of_one_point(also: &[usize]) -> String {
    also.iter().map(|row| format!(" = row {row}")).collect()
}

/// A curve as it is drawn.
pub(in crate::studies) struct DrawnCurve {
    pub name: String,
    /// Both parameters at each point, and the end there if it is one.
    pub points: Vec<([f64; 2], Option<LocusEnd>)>,
}

/// Special points at a curve's ends and along it, except ends of the ranges, in words; `told` gives
/// both values with their units.
pub(in crate::studies) fn ends(
    points: impl Iterator<Item = ([f64; 2], Option<LocusEnd>)>,
    told: impl Fn([f64; 2]) -> [String; 2],
) -> String {
    let in_full = |(values, end): ([f64; 2], Option<LocusEnd>)| {
        let what = end.filter(|end| *end != LocusEnd::Range).and_then(in_words)?;
        let [x, y] = told(values);
        Some(format!("{what} at ({x}, {y})"))
    };
    let all: Vec<String> = points.filter_map(in_full).collect();
    if all.is_empty() { String::new() } else { format!("; {}", all.join(", ")) }
}

/// The kind of a special point in words; `None` for an end of the ranges.
fn in_words(end: LocusEnd) -> Option<&'static str> {
    Some(match end {
        LocusEnd::Range | LocusEnd::Closed => return None,
        LocusEnd::Touch => "GR ends where a contact comes in",
        LocusEnd::Cusp => "CP cusp",
        LocusEnd::FoldPitchfork => "LPBP fold-pitchfork",
        LocusEnd::FoldFlip => "LPPD fold-flip",
        LocusEnd::Resonance(1) => "R1 multipliers meet at 1",
        LocusEnd::Resonance(_) => "R2 multipliers meet at −1",
        LocusEnd::NoConvergence => "MX not followed on",
    })
}

/// Marks of special points of curves.
const MARKS: [(LocusEnd, Mark); 7] = [
    (LocusEnd::Touch, Mark::Ring),
    (LocusEnd::Cusp, Mark::Disc),
    (LocusEnd::FoldPitchfork, Mark::Diamond),
    (LocusEnd::FoldFlip, Mark::Cross),
    (LocusEnd::Resonance(1), Mark::Square),
    (LocusEnd::Resonance(-1), Mark::Triangle),
    (LocusEnd::NoConvergence, Mark::Plus),
];

/// The study of curves over the two parameters of a family; `problems` are the reasons for points
/// from which no curve could be followed.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output).
pub fn loci(
    set: &ParameterSet,
    family: &Family,
    curves: &[LocusCurve],
    problems: &[String],
) -> Result<Study> {
    let [x, y] = [0, 1].map(|i| family.spans()[i]);
    let layers = layers(&curves.iter().map(LocusCurve::drawn).collect::<Vec<_>>());
    let axis = |span: &Span| parameter_axis(set, span.name, (span.from, span.to));
    let what =
        format!("{} curves of bifurcations over ({}, {})", curves.len(), x.name.symbol(), y.name.symbol());
    let figure = Figure {
        title: "Bifurcations of periodic orbits".into(),
        caption: vec![format!("Elsewhere {}", set.caption_but(&[x.name, y.name]))],
        panels: vec![Panel { title: String::new(), x: axis(&x), y: axis(&y), layers }],
        columns: 1,
        panel: (2000, 1500),
        shared_legend: false,
    };
    let mut remarks: Vec<String> = curves.iter().map(LocusCurve::in_words).collect();
    remarks.extend(problems.iter().map(|problem| format!("no curve from {problem}")));
    Ok(Study {
        tables: vec![("locus".into(), table(x, y, curves)?)],
        figure: Some(figure),
        ..Study::without_figure("locus", what).with_remarks(remarks)
    })
}

/// The curves with their special points.
pub(in crate::studies) fn layers(curves: &[DrawnCurve]) -> Vec<Layer> {
    let mut layers = Vec::new();
    for (i, curve) in curves.iter().enumerate() {
        let path = curve.points.iter().map(|([x, y], _)| (*x, *y)).collect();
        let line = Layer::line("", FAMILY[i % FAMILY.len()], Dash::Solid, path);
        layers.push(line.labelled(curve.name.clone()));
    }
    for (end, mark) in MARKS {
        let of = |curve: &'_ DrawnCurve| curve.points.clone();
        let own = curves.iter().flat_map(of).filter(|(_, own)| *own == Some(end));
        let at: Path = own.map(|([x, y], _)| (x, y)).collect();
        if let (Some(name), false) = (in_words(end), at.is_empty()) {
            layers.push(Layer::marks(name, BLACK, mark, at).stroke(9));
        }
    }
    layers
}

fn table(x: Span, y: Span, curves: &[LocusCurve]) -> Result<Vec<u8>> {
    let mut table = CsvRows::new([
        "curve",
        "label",
        "word",
        "closing",
        "period",
        x.name.name(),
        y.name.name(),
        "angle",
        "end",
        "phases",
        "row",
    ])?;
    for (i, LocusCurve { row, start, points, .. }) in curves.iter().enumerate() {
        for point in points {
            let phases: Vec<String> = point.phases.iter().map(|p| exact(*p)).collect();
            table.push([
                i.to_string(),
                start.label.name().into(),
                start.word.to_string(),
                start.word.sign().into(),
                start.word.period().to_string(),
                exact(point.values[0]),
                exact(point.values[1]),
                point.angle.map_or(String::new(), exact),
                point.end.map_or("", LocusEnd::name).into(),
                phases.join(" "),
                row.to_string(),
            ])?;
        }
    }
    table.text()
}
