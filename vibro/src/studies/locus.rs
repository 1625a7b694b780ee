//! Curves of bifurcations in two parameters.

use super::orbits::said;
use super::{Study, parameter_axis};
use crate::Result;
use crate::figures::canvas::palette::FAMILY;
use crate::figures::chart::{Dash, Figure, Layer, Panel};
use crate::table::{CsvRows, exact};
use vibro_analysis::ParameterSet;
use vibro_analysis::orbits::{Family, LocusEnd, LocusPoint, LocusStart, Span};

/// The study of curves over the two parameters of a family.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output).
pub fn loci(set: &ParameterSet, family: &Family, curves: &[(LocusStart, Vec<LocusPoint>)]) -> Result<Study> {
    let [x, y] = [0, 1].map(|i| family.spans()[i]);
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
    ])?;
    let mut layers = Vec::new();
    for (i, (start, points)) in curves.iter().enumerate() {
        let sign = if start.word.closing() > 0 { "+" } else { "-" };
        for point in points {
            let phases: Vec<String> = point.phases.iter().map(|p| exact(*p)).collect();
            table.push([
                i.to_string(),
                start.label.name().into(),
                start.word.to_string(),
                sign.into(),
                start.word.period().to_string(),
                exact(point.values[0]),
                exact(point.values[1]),
                point.angle.map_or(String::new(), exact),
                point.end.map_or("", LocusEnd::name).into(),
                phases.join(" "),
            ])?;
        }
        let path = points.iter().map(|p| (p.values[0], p.values[1])).collect();
        let name = format!("{} {}{sign} {}T", start.label, start.word, start.word.period());
        layers.push(Layer::line("", FAMILY[i % FAMILY.len()], Dash::Solid, path).labelled(name));
    }
    let axis = |span: &Span| parameter_axis(set, span.name, (span.from, span.to));
    let what =
        format!("{} curves of bifurcations over ({}, {})", curves.len(), x.name.symbol(), y.name.symbol());
    let figure = Figure {
        title: "Bifurcations of periodic orbits".into(),
        caption: vec![format!(
            "Elsewhere {}{}",
            set.caption_but(&[x.name, y.name]),
            said(set, family.loads())
        )],
        panels: vec![Panel { title: String::new(), x: axis(&x), y: axis(&y), layers }],
        columns: 1,
        panel: (2000, 1500),
        shared_legend: false,
    };
    let remarks = curves
        .iter()
        .map(|(start, points)| format!("{} of {}: {} points", start.label, start.word, points.len()));
    Ok(Study {
        tables: vec![("locus".into(), table.text()?)],
        figure: Some(figure),
        ..Study::without_figure("locus", what).with_remarks(remarks.collect())
    })
}
