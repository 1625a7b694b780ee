//! Tables and figures of curves of special points in two parameters, for any machine.

use super::Study;
use crate::Result;
use crate::table::{CsvRows, exact};
use vibro_figures::canvas::palette::{BLACK, FAMILY};
use vibro_figures::chart::{Axis, Dash, Figure, Layer, Mark, Panel, Path};
use vibro_orbits::{Label, LocusEnd, LocusPoint};

/// A curve and its first special point.
#[derive(Clone, Debug)]
pub struct LocusCurve<S> {
    /// File and row of the special point, as FILE:ROW.
    pub from: String,
    /// Row of the special point in that file.
    pub row: usize,
    /// The special point.
    pub start: S,
    /// Points of the curve.
    pub points: Vec<LocusPoint>,
    /// Other rows that contain the same special point, for example as a point of another branch.
    pub also: Vec<usize>,
}

/// The special point at the start of a curve, for tables and pictures.
pub trait CurveStart {
    /// Names of the additional columns, in three groups: after the column `word`, after the two
    /// parameter columns, and before the column `row`.
    const COLUMNS: [&'static [&'static str]; 3];

    /// The cells of the additional columns at a point of the curve.
    fn cells(&self, point: &LocusPoint) -> [Vec<String>; 3];

    /// The type of all points of the curve.
    fn label(&self) -> Label;

    /// The events of the orbit.
    fn word(&self) -> String;

    /// The curve's name in pictures.
    fn drawn(&self, row: usize) -> String;

    /// Description of the curve.
    fn told(&self) -> String;
}

/// Texts and axes of a study of curves.
pub(super) struct Texts<'a> {
    /// Names of the two parameter columns.
    pub names: [&'a str; 2],
    /// Names of the two parameters in the summary line of the study.
    pub over: [&'a str; 2],
    /// Kind of the points on the curves, in the plural, e.g. `bifurcations`.
    pub of: &'static str,
    pub title: String,
    /// The machine's other parameters, as a line of the caption.
    pub elsewhere: String,
    pub axes: [Axis; 2],
    /// Converts values of both parameters to texts.
    pub told: &'a dyn Fn([f64; 2]) -> [String; 2],
}

/// The study of curves over two parameters. `problems` names each special point without a curve,
/// with the reason.
pub(super) fn study<S: CurveStart>(
    curves: &[LocusCurve<S>],
    problems: &[String],
    texts: Texts,
) -> Result<Study> {
    let Texts { names, over, of, title, elsewhere, axes: [x, y], told } = texts;
    let figure = Figure {
        title,
        caption: vec![format!("Elsewhere {elsewhere}")],
        panels: vec![Panel { title: String::new(), x, y, layers: layers(curves) }],
        columns: 1,
        panel: (2000, 1500),
        shared_legend: false,
    };
    let mut remarks: Vec<String> = curves.iter().map(|curve| in_words(curve, told)).collect();
    remarks.extend(problems.iter().map(|problem| format!("no curve from {problem}")));
    let what = format!("{} curves of {of} over ({}, {})", curves.len(), over[0], over[1]);
    Ok(Study {
        tables: vec![("locus".into(), table(names, curves)?)],
        figure: Some(figure),
        ..Study::without_figure("locus", what).with_remarks(remarks)
    })
}

/// Description of a curve with its special points; ends of ranges and the end of a closed curve
/// are left out.
fn in_words<S: CurveStart>(curve: &LocusCurve<S>, told: &dyn Fn([f64; 2]) -> [String; 2]) -> String {
    let also: String = curve.also.iter().map(|row| format!(" = row {row}")).collect();
    let end = |point: &LocusPoint| {
        let what = end_in_words(point.end?)?;
        let [x, y] = told(point.values);
        Some(format!("{what} at ({x}, {y})"))
    };
    let ends = curve.points.iter().filter_map(end).collect::<Vec<_>>().join(", ");
    let ends = if ends.is_empty() { ends } else { format!("; {ends}") };
    format!("{} from {}{also}: {} points{ends}", curve.start.told(), curve.from, curve.points.len())
}

/// Description of the kind of a special point; `None` for the end of a range and of a closed
/// curve.
fn end_in_words(end: LocusEnd) -> Option<&'static str> {
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

/// The curves with their special points.
fn layers<S: CurveStart>(curves: &[LocusCurve<S>]) -> Vec<Layer> {
    let mut layers = Vec::new();
    let place = |point: &LocusPoint| (point.values[0], point.values[1]);
    for (i, curve) in curves.iter().enumerate() {
        let path = curve.points.iter().map(place).collect();
        let line = Layer::line("", FAMILY[i % FAMILY.len()], Dash::Solid, path);
        layers.push(line.labelled(curve.start.drawn(curve.row)));
    }
    for (end, mark) in MARKS {
        let own = curves.iter().flat_map(|curve| &curve.points).filter(|point| point.end == Some(end));
        let at: Path = own.map(place).collect();
        if let (Some(name), false) = (end_in_words(end), at.is_empty()) {
            layers.push(Layer::marks(name, BLACK, mark, at).stroke(9));
        }
    }
    layers
}

fn table<S: CurveStart>(names: [&str; 2], curves: &[LocusCurve<S>]) -> Result<Vec<u8>> {
    let [before, between, after] = S::COLUMNS;
    let header = [&["curve", "label", "word"], before, &names, between, &["angle", "end"], after, &["row"]];
    let mut table = CsvRows::new(header.concat())?;
    for (i, LocusCurve { row, start, points, .. }) in curves.iter().enumerate() {
        for point in points {
            let [before, between, after] = start.cells(point);
            let angle = point.angle.map_or(String::new(), exact);
            table.push(
                [
                    vec![i.to_string(), start.label().name().into(), start.word()],
                    before,
                    point.values.map(exact).to_vec(),
                    between,
                    vec![angle, point.end.map_or("", LocusEnd::name).into()],
                    after,
                    vec![row.to_string()],
                ]
                .concat(),
            )?;
        }
    }
    table.text()
}
