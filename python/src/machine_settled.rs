//! Settled motions of machines from files: basins of attraction, Poincaré sections, Lyapunov
//! spectra.

use crate::arrays::{Array1, Array2, column, plane};
use crate::background::compute;
use crate::machine::{Described, Numbers, SectionChoice};
use crate::paper_studies::in_parts;
use pyo3::prelude::*;
use vibro_orbits::Orbit;
use vibro_studies::basin::{BasinCell, BasinRequest, SettledAttractor, StartAxis};
use vibro_studies::{Machine, MotionClass, PoincareRequest, columns, poincare};

/// An attractor.
#[derive(IntoPyObject)]
struct AttractorParts {
    kind: String,
    period: Option<u32>,
    contacts: f64,
    rests: bool,
    interval: f64,
    word: String,
    stability: String,
    start: Numbers,
}

impl AttractorParts {
    /// An attractor, with the events and the stability of its orbit if it is periodic.
    fn new(machine: &Machine, found: &SettledAttractor) -> Self {
        let settled = &found.settled;
        let orbit = match settled.class {
            MotionClass::Periodic(_) => Orbit::settled(machine, &found.start, 0).ok(),
            _ => None,
        };
        let (word, stability) = orbit.map_or_else(Default::default, |orbit| {
            (orbit.word().in_words(&orbit.place().assembly), orbit.stability().to_string())
        });
        Self {
            kind: settled.class.name(),
            period: settled.period,
            contacts: settled.contacts,
            rests: settled.rests,
            interval: settled.interval,
            word,
            stability,
            start: found.start.numbers(),
        }
    }
}

/// Basins over a plane of starts.
#[derive(IntoPyObject)]
pub struct BasinsArrays<'py> {
    attractors: Vec<AttractorParts>,
    cells: Array2<'py, i32>,
    ended: Option<String>,
}

/// Basins of attraction over two components of the initial state, each given as name, ends and
/// number of cells.
#[pyfunction]
#[pyo3(signature = (machine, x, y, start, discard, section, progress = None))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of the package")]
pub fn basins<'py>(
    py: Python<'py>,
    machine: &Described,
    x: (String, f64, f64, usize),
    y: (String, f64, f64, usize),
    start: Numbers,
    discard: u32,
    section: Option<SectionChoice>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<BasinsArrays<'py>> {
    let axis = |(name, from, to, count): (String, f64, f64, usize)| StartAxis { name, from, to, count };
    let (rows, columns) = (y.3, x.3);
    let start = machine.start_of(&start)?;
    let request = BasinRequest { x: axis(x), y: axis(y), start, discard };
    let own = machine.machine(section);
    let (attractors, cells, ended) = compute(py, progress, move |control| {
        let found =
            in_parts(control, request.count(), |task| vibro_studies::basin::basins(&own, &request, task))?;
        let attractors: Vec<_> = found.attractors.iter().map(|a| AttractorParts::new(&own, a)).collect();
        Ok((attractors, found.cells, found.ended))
    })?;
    let code = |cell: &BasinCell| match cell {
        BasinCell::Attractor(number) | BasinCell::Mirror(number) => i32::from(*number),
        BasinCell::Outside => -1,
        BasinCell::NotSettled | BasinCell::Undecided => -2,
        BasinCell::Ended => -3,
        BasinCell::Rest => -4,
    };
    let codes: Vec<i32> = cells.iter().map(code).collect();
    Ok(BasinsArrays { attractors, cells: plane(py, &codes, rows, columns)?, ended })
}

/// Points of a section.
#[derive(IntoPyObject)]
pub struct SectionArrays<'py> {
    t: Array1<'py, f64>,
    phase: Option<Array1<'py, f64>>,
    speed: Option<Array1<'py, f64>>,
    values: Array2<'py, f64>,
}

/// The points of a settled motion at its section.
#[pyfunction]
#[pyo3(signature = (machine, start, phase, settle, keep, section, progress = None))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of the package")]
pub fn section<'py>(
    py: Python<'py>,
    machine: &Described,
    start: Numbers,
    phase: f64,
    settle: u32,
    keep: u32,
    section: Option<SectionChoice>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<SectionArrays<'py>> {
    let request = PoincareRequest { start: machine.start_of(&start)?, phase, discard: settle, keep };
    let (own, count) = (machine.machine(section), columns(machine.description()).len());
    let found = compute(py, progress, move |control| {
        let points = poincare(&own, &request, &mut || control.goes_on())?;
        control.check()?;
        Ok(points)
    })?;
    let all = |of: fn(&vibro_studies::SectionPoint) -> Option<f64>| -> Option<Vec<f64>> {
        found.iter().map(of).collect()
    };
    let times: Vec<f64> = found.iter().map(|point| point.time).collect();
    let values: Vec<f64> = found.iter().flat_map(|point| point.values.iter().copied()).collect();
    Ok(SectionArrays {
        t: column(py, &times),
        phase: all(|point| point.phase).map(|phases| column(py, &phases)),
        speed: all(|point| point.speed).map(|speeds| column(py, &speeds)),
        values: plane(py, &values, found.len(), count)?,
    })
}

/// Lyapunov spectrum of a motion.
#[derive(IntoPyObject)]
pub struct SpectrumArrays<'py> {
    exponents: Array1<'py, f64>,
    errors: Array1<'py, f64>,
    period: Option<u32>,
    t: Array1<'py, f64>,
    running: Array2<'py, f64>,
}

/// Lyapunov spectrum of a machine's motion over a number of returns to the section.
#[pyfunction]
#[pyo3(signature = (machine, start, settle, periods, section, progress = None))]
pub fn spectrum<'py>(
    py: Python<'py>,
    machine: &Described,
    start: Numbers,
    settle: u32,
    periods: u32,
    section: Option<SectionChoice>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<SpectrumArrays<'py>> {
    let (start, own) = (machine.start_of(&start)?, machine.machine(section));
    let found = compute(py, progress, move |control| {
        let found = vibro_studies::spectrum(&own, &start, (settle, periods), &mut || control.goes_on())?;
        control.check()?;
        Ok(found)
    })?;
    let exponents: Vec<f64> = found.exponents.iter().map(|e| e.value).collect();
    let errors: Vec<f64> = found.exponents.iter().map(|e| e.error).collect();
    let times: Vec<f64> = found.running.iter().map(|(time, _)| *time).collect();
    let rows: Vec<f64> = found.running.iter().flat_map(|(_, all)| all.iter().copied()).collect();
    let count = found.exponents.len();
    Ok(SpectrumArrays {
        exponents: column(py, &exponents),
        errors: column(py, &errors),
        period: found.period,
        t: column(py, &times),
        running: plane(py, &rows, times.len(), count)?,
    })
}
