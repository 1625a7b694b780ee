//! Curves of special points of described machines over two parameters.

use crate::arrays::{Array1, Array2, column, table};
use crate::background::compute;
use crate::failure::Failure;
use crate::machine::{Described, Numbers};
use pyo3::prelude::*;
use vibro_machine::Start;
use vibro_orbits::paper::LocusEnd;
use vibro_orbits::{Family, Label, LocusPoint, LocusStart, Special, check_second};
use vibro_studies::Error;

/// A parameter with the ends of its range, SI.
type Range = (String, (f64, f64));

/// A curve of special points over two parameters.
#[derive(IntoPyObject)]
pub struct LocusArrays<'py> {
    word: String,
    periods: Option<u32>,
    values: Array2<'py, f64>,
    period: Array1<'py, f64>,
    angle: Array1<'py, f64>,
    labels: Vec<&'static str>,
}

/// The start of the curve, from the first suitable orbit next to the special point.
fn start(over: &Family, point: (&Special, f64), beside: &[(f64, f64, Start)]) -> Result<LocusStart, Failure> {
    let mut failed = None;
    for (value, period, start) in beside {
        match LocusStart::from_beside(over, point, (*value, *period, start)) {
            Ok(start) => return Ok(start),
            Err(error) => failed = failed.or(Some(error)),
        }
    }
    let no_orbit = || {
        let (label, value) = (point.0.label.name(), point.1);
        let problem = format!(
            "{label} at {} = {value}: no orbit next to this point could be computed again",
            over.parameter
        );
        Error::Described { problem }
    };
    Err(failed.unwrap_or_else(no_orbit).into())
}

/// The curve over two parameters from a special point of a branch over the first one. The point is
/// given by label, element and value, and by neighbouring orbits: value, period (s) and start.
#[pyfunction]
#[pyo3(signature = (machine, first, second, point, beside, progress = None))]
pub fn locus<'py>(
    py: Python<'py>,
    machine: &Described,
    first: Range,
    second: Range,
    point: (String, String, f64),
    beside: Vec<(f64, f64, Numbers)>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<LocusArrays<'py>> {
    let (label, element, value) = point;
    let kind = Label::find(&label).filter(|label| Label::STARTS.contains(label));
    let kind = kind.ok_or_else(|| Failure::Ours(format!("no curve begins at {label}")))?;
    let special = Special::new(kind, element);
    let named = |(value, period, numbers): (f64, f64, Numbers)| {
        Ok::<_, Failure>((value, period, machine.start_of(&numbers)?))
    };
    let beside = beside.into_iter().map(named).collect::<Result<Vec<_>, Failure>>()?;
    let machine = machine.machine(None);
    let (start, found) = compute(py, progress, move |control| {
        let [first, second] =
            [Family::new(&machine, &first.0, first.1)?, Family::new(&machine, &second.0, second.1)?];
        check_second(&first, &second)?;
        let start = start(&first, (&special, value), &beside)?;
        let found = vibro_orbits::locus(&start, &second)?;
        control.add(1);
        Ok((start.shortest(), found))
    })?;
    let of = |value: fn(&LocusPoint) -> f64| column(py, &found.iter().map(value).collect::<Vec<_>>());
    Ok(LocusArrays {
        word: start.word(),
        periods: start.periods(),
        values: table(py, &found.iter().map(|point| point.values).collect::<Vec<_>>())?,
        period: of(|point| point.period),
        angle: of(|point| point.angle.unwrap_or(f64::NAN)),
        labels: found.iter().map(|point| point.end.map_or("", LocusEnd::name)).collect(),
    })
}
