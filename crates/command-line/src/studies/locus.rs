//! Curves of special points of a described machine over two parameters.

use super::Study;
use super::branches::or_empty;
use super::curves::{CurveStart, LocusCurve, Texts, study};
use super::design_sweep::Labelled;
use crate::Result;
use crate::table::exact;
use crate::wording;
use vibro_figures::chart::Axis;
use vibro_orbits::{Family, Label, LocusPoint, LocusStart};
use vibro_studies::Machine;

impl CurveStart for LocusStart {
    const COLUMNS: [&'static [&'static str]; 3] = [&["periods"], &["period"], &["element"]];

    fn cells(&self, point: &LocusPoint) -> [Vec<String>; 3] {
        let element = self.special.element.clone();
        [vec![or_empty(self.periods())], vec![exact(point.period)], vec![element]]
    }

    fn label(&self) -> Label {
        self.special.label
    }

    fn word(&self) -> String {
        self.word()
    }

    fn drawn(&self, row: usize) -> String {
        format!("{} (row {row})", self.told())
    }

    fn told(&self) -> String {
        let names = self.special.element.split(' ').filter_map(|name| name.rsplit('.').next());
        let element = names.collect::<Vec<_>>().join(" ");
        let periods = self.periods().map_or(String::new(), |n| format!("{n}T"));
        let words = [self.special.label.name(), &element, &periods];
        words.into_iter().filter(|word| !word.is_empty()).collect::<Vec<_>>().join(" ")
    }
}

/// The study of curves over two parameters of a machine; `problems` are the reasons for points from
/// which no curve could be followed.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output).
pub fn loci(
    machine: &Machine,
    families: [&Family; 2],
    curves: &[LocusCurve<LocusStart>],
    problems: &[String],
) -> Result<Study> {
    let names = families.map(|family| family.parameter.clone());
    let over = [names[0].as_str(), names[1].as_str()];
    let axis = |family: &Family| Axis { range: Some(family.range), ..machine.axis(&family.parameter) };
    let texts = Texts {
        names: over,
        over,
        of: "special points",
        title: format!("{}: special points of periodic orbits", wording::title(&machine.description.name)),
        elsewhere: machine.caption_but(&names),
        axes: families.map(axis),
        told: &|values| [0, 1].map(|i| machine.told(&names[i], values[i])),
    };
    Ok(Study { subject: machine.caption_of_all(&names), ..study(curves, problems, texts)? })
}
