//! Response curves of described machines: branches of settled motions over a parameter, with their
//! ends and largest values.

use super::Study;
use super::orbits::{measured, study_of, words};
use crate::Result;
use crate::wording::{self, shown_unit};
use vibro_orbits::{Branch, Family, OrbitPoint, check_measure};
use vibro_studies::{Error, significant};
use vibro_studies::{Machine, Measure};

/// Largest number of branches described on the screen.
const SHOWN: usize = 12;
/// Largest number of events named in the description of a branch.
const SPELLED: usize = 4;

/// The study of a machine's response: the tables of its curve and of special points, and a picture
/// of a measure.
///
/// # Errors
/// [`Error::Described`] if no settled motion is periodic; [`Error::Output`](crate::Error::Output);
/// an error if the machine does not have the measure.
pub fn response(
    machine: &Machine,
    family: &Family,
    branches: &[Branch],
    measure: &Measure,
    name: &str,
) -> Result<Study> {
    check_measure(measure, &machine.description)?;
    let parameter = &family.parameter;
    if branches.is_empty() {
        let (from, to) = family.range;
        let problem = format!(
            "{parameter} from {} to {}: no motion settles on a periodic orbit that can be \
             followed; try other starts (--start), more discarded returns (--discard) or more \
             values (--seeds)",
            machine.told(parameter, from),
            machine.told(parameter, to)
        );
        return Err(Error::Described { problem }.into());
    }
    let tops = measured(branches, measure);
    let mut study = study_of(machine, family, branches, (measure, &tops), name)?;
    study.tables[0].0 = name.into();
    let count = if branches.len() == 1 { "1 branch".into() } else { format!("{} branches", branches.len()) };
    study.what = format!("response: {measure} over {parameter}, {count}");
    if let Some(figure) = &mut study.figure {
        let d = &machine.description;
        let [own, of, over] =
            [wording::title(&d.name), wording::measure(d, measure), wording::parameter(parameter)];
        figure.title = format!("{own}: {of} over {over}");
    }
    let told = branches.iter().zip(&tops).take(SHOWN);
    study.remarks.extend(told.map(|(b, tops)| in_words(machine, family, b, (measure, tops))));
    if branches.len() > SHOWN {
        study.remarks.push(format!("and {} more branches", branches.len() - SHOWN));
    }
    Ok(study)
}

/// Description of a branch: events, names of its ends, largest and largest stable value.
fn in_words(
    machine: &Machine,
    family: &Family,
    branch: &Branch,
    (measure, tops): (&Measure, &[f64]),
) -> String {
    let parameter = &family.parameter;
    let events = match branch.word().len() {
        0 => "no event".into(),
        1..=SPELLED => words(family, branch),
        count => format!("{count} events"),
    };
    let periods = branch.word().periods.map_or(String::new(), |n| format!("{n}T "));
    let head = format!("branch {}: {periods}[{events}]", branch.id);
    let ends = match &branch.points[..] {
        _ if branch.closed => ", closed".into(),
        [first, .., last] => format!(
            ", from {} to {}",
            end_in_words(machine, parameter, first),
            end_in_words(machine, parameter, last)
        ),
        _ => String::new(),
    };
    let largest = |stable: bool| {
        let held = |(point, _): &(&OrbitPoint, &f64)| !stable || point.is_stable();
        let all = branch.points.iter().zip(tops).filter(|(_, top)| top.is_finite()).filter(held);
        all.max_by(|a, b| a.1.total_cmp(b.1))
    };
    let unit = measure.unit(&machine.description);
    let told = |what: &str, stable: bool| {
        largest(stable).map_or(String::new(), |(point, top)| {
            let (factor, symbol) = shown_unit(unit, top.abs());
            let symbol = if symbol == "1" { String::new() } else { format!(" {symbol}") };
            let value = machine.told(parameter, point.value);
            format!("; {what} {}{symbol} at {value}", significant(factor * top))
        })
    };
    format!("{head}{ends}{}{}", told("largest", false), told("largest stable", true))
}

/// Description of an end of a branch: its label, its element, and the parameter.
fn end_in_words(machine: &Machine, parameter: &str, point: &OrbitPoint) -> String {
    let value = machine.told(parameter, point.value);
    match &point.special {
        Some(special) if special.element.is_empty() => format!("{} {value}", special.label),
        Some(special) => format!("{} {} {value}", special.label, special.element),
        None => value,
    }
}
