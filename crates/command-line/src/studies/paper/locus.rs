//! Curves of bifurcations of the paper's machine in two parameters.

use crate::Result;
use crate::studies::branches::list;
use crate::studies::curves::{CurveStart, LocusCurve, Texts, study};
use crate::studies::{Study, parameter_axis};
use vibro_orbits::paper::{Family, Label, LocusPoint, LocusStart, Span};
use vibro_studies::paper::ParameterSet;

impl CurveStart for LocusStart {
    const COLUMNS: [&'static [&'static str]; 3] = [&["closing", "period"], &[], &["phases"]];

    fn cells(&self, point: &LocusPoint) -> [Vec<String>; 3] {
        let word = vec![self.word.sign().into(), self.word.period().to_string()];
        [word, Vec::new(), vec![list(point.phases.iter().copied())]]
    }

    fn label(&self) -> Label {
        self.label
    }

    fn word(&self) -> String {
        self.word.to_string()
    }

    fn drawn(&self, _: usize) -> String {
        format!("{} {} {}T", self.label, self.word.signed(), self.word.period())
    }

    fn told(&self) -> String {
        format!("{} of {}", self.label, self.word.signed())
    }
}

/// The study of curves over the two parameters of a family. `problems` are the reasons for points
/// without a curve.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output).
pub fn loci(
    set: &ParameterSet,
    family: &Family,
    curves: &[LocusCurve<LocusStart>],
    problems: &[String],
) -> Result<Study> {
    let spans = [0, 1].map(|i| family.spans()[i]);
    let names = spans.map(|span| span.name);
    let texts = Texts {
        names: [names[0].name(), names[1].name()],
        over: [names[0].symbol(), names[1].symbol()],
        of: "bifurcations",
        title: "Bifurcations of periodic orbits".into(),
        elsewhere: set.caption_but(&names),
        axes: spans.map(|span: Span| parameter_axis(set, span.name, (span.from, span.to))),
        told: &|values| values.map(|x| format!("{x:.6}")),
    };
    study(curves, problems, texts)
}
