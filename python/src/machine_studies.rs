//! Measures and diagrams of described machines.

use crate::arrays::{Array1, column};
use crate::background::{Control, compute, each_of};
use crate::designs::{GivenAssemblies, start_of};
use crate::failure::Failure;
use crate::machine::{Described, Numbers, SectionChoice, rule};
use crate::paper_studies::{MeasureRow, in_parts, row};
use pyo3::prelude::*;
use vibro_studies::diagram::{DescribedPoint, DiagramRequest};
use vibro_studies::paper::bifurcation::Diagram;
use vibro_studies::{Machine, Measure, Measured, ParameterAxis, measure};

/// A row of measures for each of many settled motions, each from its own start or all from one.
#[pyfunction]
#[pyo3(signature = (machines, starts, names, settle, periods, section, in_rows, progress = None))]
#[allow(clippy::too_many_arguments)]
pub fn measure_many(
    py: Python<'_>,
    machines: GivenAssemblies<'_>,
    starts: Vec<Numbers>,
    names: Vec<String>,
    settle: u32,
    periods: u32,
    section: Option<SectionChoice>,
    in_rows: bool,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Vec<MeasureRow>> {
    let measures = names.iter().map(|name| name.parse()).collect::<Result<Vec<Measure>, _>>();
    let measures = measures.map_err(Failure::from)?;
    let rule = rule(section);
    let machines = machines.owned()?;
    if in_rows {
        machines.check(&measures, &rule)?;
    }
    let count = machines.len();
    let one = move |control: &Control, index: usize| -> Result<Measured, Failure> {
        let own = machines.machine(index)?;
        let machine = Machine { section: rule.clone(), ..own.machine(None) };
        let (mut motion, section) = machine.motion(&own.start_of(start_of(&starts, index))?)?;
        vibro_studies::settle(&mut motion, &section, settle)?;
        control.check()?;
        Ok(measure(&mut motion, &section, &measures, periods)?)
    };
    each_of(py, count, progress, move |control, index| row(one(control, index), in_rows))
}

/// One direction of a diagram.
#[derive(IntoPyObject)]
struct DirectionArrays<'py> {
    value: Array1<'py, f64>,
    kind: Vec<String>,
    period: Array1<'py, i32>,
    contacts: Array1<'py, f64>,
    rests: Array1<'py, bool>,
    maxima: Array1<'py, f64>,
    at: Array1<'py, i64>,
    met: Array1<'py, u32>,
    exponent: Array1<'py, f64>,
}

/// A diagram in both directions.
#[derive(IntoPyObject)]
pub struct DiagramArrays<'py> {
    up: DirectionArrays<'py>,
    down: DirectionArrays<'py>,
    hysteresis: Array1<'py, bool>,
}

fn direction<'py>(
    py: Python<'py>,
    axis: &ParameterAxis<String>,
    points: &[Option<DescribedPoint>],
) -> DirectionArrays<'py> {
    let of = |read: &dyn Fn(&DescribedPoint) -> f64| -> Vec<f64> {
        points.iter().map(|p| p.as_ref().map_or(0.0, read)).collect()
    };
    let mut tops = (Vec::new(), Vec::new(), Vec::new());
    for (index, point) in points.iter().enumerate() {
        for &(x, met) in point.iter().flat_map(|p| &p.maxima) {
            tops.0.push(x);
            tops.1.push(index as i64);
            tops.2.push(met);
        }
    }
    let class = |p: &Option<DescribedPoint>| p.as_ref().map_or("refused".into(), |p| p.settled.class.name());
    let period = |p: &Option<DescribedPoint>| p.as_ref().and_then(|p| p.settled.period).unwrap_or(0) as i32;
    let rests: Vec<bool> = points.iter().map(|p| p.as_ref().is_some_and(|p| p.settled.rests)).collect();
    DirectionArrays {
        value: column(py, &(0..axis.count).map(|i| axis.value(i)).collect::<Vec<_>>()),
        kind: points.iter().map(class).collect(),
        period: column(py, &points.iter().map(period).collect::<Vec<_>>()),
        contacts: column(py, &of(&|p| p.settled.contacts)),
        rests: column(py, &rests),
        maxima: column(py, &tops.0),
        at: column(py, &tops.1),
        met: column(py, &tops.2),
        exponent: column(py, &of(&|p| p.settled.exponent.map_or(0.0, |e| e.value))),
    }
}

/// Maxima of a quantity, or its values at the section, over a parameter, with the settled motions.
#[pyfunction]
#[pyo3(signature = (machine, name, ends, count, of, at_section, periods, exponents, section, anew, start, progress = None))]
#[allow(clippy::too_many_arguments)]
pub fn diagram<'py>(
    py: Python<'py>,
    machine: &Described,
    name: String,
    ends: (f64, f64),
    count: usize,
    of: &str,
    at_section: bool,
    periods: (u32, u32),
    exponents: Option<u32>,
    section: Option<SectionChoice>,
    anew: bool,
    start: Numbers,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<DiagramArrays<'py>> {
    let axis = ParameterAxis::of(name, ends, count).map_err(Failure::from)?;
    let of = of.parse().map_err(Failure::from)?;
    let (discard, keep) = periods;
    let start = machine.start_of(&start)?;
    let axis_of = axis.clone();
    let request = DiagramRequest { axis: axis_of, of, at_section, discard, keep, exponents, anew, start };
    let own = machine.machine(section);
    let found: Diagram<DescribedPoint> = compute(py, progress, move |control| {
        in_parts(control, request.count(), |task| vibro_studies::diagram::diagram(&own, &request, task))
    })?;
    Ok(DiagramArrays {
        up: direction(py, &axis, &found.up),
        down: direction(py, &axis, &found.down),
        hysteresis: column(py, &found.hysteresis()),
    })
}
