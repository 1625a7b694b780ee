//! Curves of special points of a described machine over two parameters.

use super::Study;
use super::design_sweep::Labelled;
use super::paper::locus::{DrawnCurve, ends, layers, rows_of_one_point};
use crate::Result;
use crate::special_points::PointOfFile;
use crate::table::{CsvRows, exact};
use vibro_figures::chart::{Axis, Figure, Panel};
use vibro_orbits::paper::LocusEnd;
use vibro_orbits::{Family, LocusPoint, LocusStart};
use vibro_studies::Machine;

/// A curve of a described machine and the special point from which it was followed.
#[derive(Clone, Debug)]
pub struct CurveOfFile {
    /// File and row of its special point, in words.
    pub from: String,
    /// The special point's row.
    pub point: PointOfFile,
    /// The special point on its branch.
    pub start: LocusStart,
    /// Its points.
    pub points: Vec<LocusPoint>,
    /// Further rows of the special point, found on other branches.
    pub also: Vec<usize>,
}

impl CurveOfFile {
    /// Kind, element and number of periods.
    fn name(&self) -> String {
        let special = &self.point.special;
        let names = special.element.split(' ').filter_map(|name| name.rsplit('.').next());
        let element = names.collect::<Vec<_>>().join(" ");
        let periods = self.start.periods().map_or(String::new(), |n| format!("{n}T"));
        let words = [special.kind.name(), &element, &periods];
        words.into_iter().filter(|word| !word.is_empty()).collect::<Vec<_>>().join(" ")
    }

    fn in_words(&self, machine: &Machine, names: &[String; 2]) -> String {
        let told = |values: [f64; 2]| [0, 1].map(|i| machine.told(&names[i], values[i]));
        let ends = ends(self.points.iter().map(|p| (p.values, p.end)), told);
        let also = rows_of_one_point(&self.also);
        format!("{} from {}{also}: {} points{ends}", self.name(), self.from, self.points.len())
    }
}

/// The study of curves over two parameters of a machine; `problems` are the reasons for points from
/// which no curve could be followed.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output).
pub fn assembly_loci(
    machine: &Machine,
    families: [&Family; 2],
    curves: &[CurveOfFile],
    problems: &[String],
) -> Result<Study> {
    let names = families.map(|family| family.parameter.clone());
    let drawn = |curve: &CurveOfFile| DrawnCurve {
        name: format!("{} (row {})", curve.name(), curve.point.row),
        points: curve.points.iter().map(|p| (p.values, p.end)).collect(),
    };
    let axis = |family: &Family| Axis { range: Some(family.range), ..machine.axis(&family.parameter) };
    let figure = Figure {
        title: format!("{}: special points of periodic orbits", machine.description.name),
        caption: vec![format!("Elsewhere {}", machine.caption_but(&names))],
        panels: vec![Panel {
            title: String::new(),
            x: axis(families[0]),
            y: axis(families[1]),
            layers: layers(&curves.iter().map(drawn).collect::<Vec<_>>()),
        }],
        columns: 1,
        panel: (2000, 1500),
        shared_legend: false,
    };
    let mut remarks: Vec<String> = curves.iter().map(|curve| curve.in_words(machine, &names)).collect();
    remarks.extend(problems.iter().map(|problem| format!("no curve from {problem}")));
    let what = format!("{} curves of special points over ({}, {})", curves.len(), names[0], names[1]);
    Ok(Study {
        tables: vec![("locus".into(), table(&names, curves)?)],
        figure: Some(figure),
        subject: machine.caption_of_all(&names),
        ..Study::without_figure("locus", what).with_remarks(remarks)
    })
}

fn table(names: &[String; 2], curves: &[CurveOfFile]) -> Result<Vec<u8>> {
    let before = ["curve", "label", "word", "periods"].map(str::to_owned);
    let after = ["period", "angle", "end", "element", "row"].map(str::to_owned);
    let header: Vec<String> = before.into_iter().chain(names.iter().cloned()).chain(after).collect();
    let mut table = CsvRows::new(&header)?;
    for (i, curve) in curves.iter().enumerate() {
        let special = &curve.point.special;
        let (word, periods) = (curve.start.word(), curve.start.periods());
        for point in &curve.points {
            table.push([
                i.to_string(),
                special.kind.name().into(),
                word.clone(),
                periods.map_or(String::new(), |n| n.to_string()),
                exact(point.values[0]),
                exact(point.values[1]),
                exact(point.period),
                point.angle.map_or(String::new(), exact),
                point.end.map_or("", LocusEnd::name).into(),
                special.element.clone(),
                curve.point.row.to_string(),
            ])?;
        }
    }
    table.text()
}
