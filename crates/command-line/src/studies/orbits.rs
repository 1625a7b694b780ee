//! Branches of periodic orbits of described machines over a parameter.

use super::Study;
use super::branches::{self, Texts, cell, or_empty};
use super::design_sweep::Labelled;
use crate::Result;
use crate::table::exact;
use crate::wording::{self, axis};
use rayon::prelude::*;
use vibro_figures::chart::Axis;
use vibro_orbits::{Branch, Family, LocusStart, Orbit, OrbitPoint, check_measure};
use vibro_studies::{Machine, Measure};

/// The study of a machine's branches over a parameter: tables of points and special points, and a
/// picture of a measure.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output); an error if the machine does not have the measure.
pub fn orbits(
    machine: &Machine,
    family: &Family,
    branches: &[Branch],
    measure: &Measure,
    name: &str,
) -> Result<Study> {
    check_measure(measure, &machine.description)?;
    study_of(machine, family, branches, (measure, &measured(branches, measure)), name)
}

/// A measure of each orbit of branches; NaN if it has none.
pub(super) fn measured(branches: &[Branch], measure: &Measure) -> Vec<Vec<f64>> {
    let value = |branch: &Branch, point: &OrbitPoint| {
        branch.orbit(point).and_then(|orbit| orbit.measure(measure).ok()).unwrap_or(f64::NAN)
    };
    branches.par_iter().map(|b| b.points.iter().map(|p| value(b, p)).collect()).collect()
}

/// As [`orbits`], with the measure's values.
pub(super) fn study_of(
    machine: &Machine,
    family: &Family,
    all: &[Branch],
    (measure, tops): (&Measure, &[Vec<f64>]),
    name: &str,
) -> Result<Study> {
    let parameter = &family.parameter;
    let d = &machine.description;
    let unit = measure.unit(d);
    let largest = tops.iter().flatten().copied().filter(|x| x.is_finite()).map(f64::abs).fold(0.0, f64::max);
    let x = Axis { range: Some(family.range), ..machine.axis(parameter) };
    let texts = Texts {
        name: name.into(),
        over: parameter.clone(),
        title: format!("{}: periodic orbits over {}", wording::title(&d.name), wording::parameter(parameter)),
        certain: "",
        elsewhere: machine.caption_but(std::slice::from_ref(parameter)),
        axes: [x, axis(&wording::measure(d, measure), unit, largest)],
    };
    let tables = [point_table(family, all, (measure, tops))?, special_table(family, all)?];
    let subject = machine.caption_of_all(std::slice::from_ref(parameter));
    Ok(Study { subject, ..branches::study(all, tops, texts, tables) })
}

/// Description of the events of a branch.
pub(super) fn words(family: &Family, branch: &Branch) -> String {
    let place = family.place(branch.points[0].value);
    place.map_or_else(|_| String::new(), |place| branch.word().in_words(&place.assembly))
}

fn point_table(family: &Family, all: &[Branch], (measure, tops): (&Measure, &[Vec<f64>])) -> Result<Vec<u8>> {
    let most = all.iter().flat_map(|b| &b.points).map(|p| p.multipliers.len()).max().unwrap_or(0);
    let mut own = ["period", "periods", "stability"].map(str::to_owned).to_vec();
    own.extend([measure.to_string(), "word".into()]);
    own.extend((1..=most).flat_map(|k| [format!("mu{k}_re"), format!("mu{k}_im")]));
    branches::point_table(&family.parameter, own, all, |k, branch| {
        let word = words(family, branch);
        let row = |(point, top): (&OrbitPoint, &f64)| {
            let (period, periods) = (exact(point.period), or_empty(branch.periods));
            let mut row = vec![period, periods, point.stability.to_string(), cell(*top), word.clone()];
            let numbers = (0..most).map(|k| point.multipliers.get(k));
            row.extend(numbers.flat_map(|m| m.map_or(Default::default(), |m| [cell(m.re), cell(m.im)])));
            row
        };
        branch.points.iter().zip(&tops[k]).map(row).collect()
    })
}

/// Table of the special points, each with a neighbouring orbit of its branch as the start of a
/// curve over two parameters.
pub(super) fn special_table(family: &Family, all: &[Branch]) -> Result<Vec<u8>> {
    let own = [
        "value_error",
        "word",
        "periods",
        "period",
        "stability_before",
        "stability_after",
        "element",
        "beside_value",
        "beside_period",
        "beside_start",
    ];
    branches::special_table(&family.parameter, &own, all, |branch| {
        let word = words(family, branch);
        Box::new(move |i, point, special| {
            let [before, after] = branch.stability_around(i);
            let start = branch.locus_start(i);
            let again = start.as_ref().and_then(LocusStart::located_again);
            let beside = start.and_then(|_| branch.beside(i));
            let number = |of: fn(&Orbit) -> f64| or_empty(beside.as_ref().map(|orbit| exact(of(orbit))));
            vec![
                or_empty(again.map(|again| exact((again - point.value).abs()))),
                word.clone(),
                or_empty(branch.periods),
                exact(point.period),
                before.to_string(),
                after.to_string(),
                special.element.clone(),
                number(Orbit::value),
                number(Orbit::period),
                or_empty(beside.as_ref().map(Orbit::start)),
            ]
        })
    })
}
