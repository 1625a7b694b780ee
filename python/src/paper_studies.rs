//! Studies: bifurcation diagrams, Lyapunov exponents, basins of attraction, measures of settled
//! motions.

use crate::arrays::{Array1, Array2, column, plane, state, table};
use crate::background::{Control, compute, each_of, pool};
use crate::designs::{GivenStarts, GivenSystems};
use crate::failure::{Failure, in_python};
use crate::paper_system::{System, find};
use pyo3::prelude::*;
use vibro_impact::{Parameters, Simulator, State};
use vibro_studies::basin::{BasinCell, BasinRequest, StartAxis, basins as basins_of};
use vibro_studies::diagram::diagram;
use vibro_studies::paper::attractor::Attractor;
use vibro_studies::paper::bifurcation::{Diagram, Sweep, SweepPoint};
use vibro_studies::paper::lyapunov::{SpectrumOptions, convergence_while};
use vibro_studies::paper::maxima::Displacement;
use vibro_studies::paper::measures::{Measure, measure as measured};
use vibro_studies::paper::motion::settled_simulator;
use vibro_studies::paper::plane::ParameterAxis;
use vibro_studies::paper::start::{Coordinate, StartRule};
use vibro_studies::paper::stroboscopic::COORDINATES;
use vibro_studies::parts::{PartStore, Shard, Task};
use vibro_studies::{Measured, MotionClass};

/// A store that keeps no parts and ends the study after the caller has stopped waiting.
struct Cancelling<'a>(&'a Control);

/// Error that ends a cancelled study.
#[derive(Debug, Clone, Copy)]
struct NobodyWaits;

impl std::fmt::Display for NobodyWaits {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("cancelled")
    }
}

impl std::error::Error for NobodyWaits {}

impl PartStore for Cancelling<'_> {
    fn load(&self, _: usize) -> Option<Vec<u8>> {
        None
    }

    fn save(&self, _: usize, _: &[u8]) -> vibro_studies::Result<()> {
        self.go_on()
    }

    fn go_on(&self) -> vibro_studies::Result<()> {
        if self.0.is_cancelled() { Err(vibro_studies::Error::store(NobodyWaits)) } else { Ok(()) }
    }
}

/// Computes all `parts` parts of a study, on all threads.
pub fn in_parts<T: Send>(
    control: &Control,
    parts: usize,
    study: impl FnOnce(&Task) -> vibro_studies::Result<Option<T>> + Send,
) -> Result<T, Failure> {
    control.expect(parts);
    let done = |_| control.add(1);
    let task = Task { store: &Cancelling(control), shard: Shard::ALL, done: &done };
    let found = pool()?.install(|| study(&task))?;
    control.check()?;
    found.ok_or(Failure::Cancelled)
}

/// The motions of one direction of a diagram, an entry for each value.
#[derive(IntoPyObject)]
struct Direction<'py> {
    value: Array1<'py, f64>,
    kind: Vec<String>,
    period: Array1<'py, i32>,
    impacts: Array2<'py, f64>,
    rests: Array1<'py, bool>,
    maxima: Array1<'py, f64>,
    at: Array1<'py, i64>,
    met: Array1<'py, u32>,
    exponents: Option<Array2<'py, f64>>,
}

/// A diagram in both directions.
#[derive(IntoPyObject)]
pub struct BothDirections<'py> {
    up: Direction<'py>,
    down: Direction<'py>,
    hysteresis: Array1<'py, bool>,
}

/// Maxima, classes and impacts over a parameter, with rising and with falling values.
#[pyfunction]
#[pyo3(signature = (system, start, name, ends, count, discard, keep, of, exponents, progress = None))]
#[allow(clippy::too_many_arguments)]
pub fn paper_bifurcation<'py>(
    py: Python<'py>,
    system: &System,
    start: Option<[f64; 6]>,
    name: &str,
    ends: (f64, f64),
    count: usize,
    discard: u32,
    keep: u32,
    of: &str,
    exponents: Option<u32>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<BothDirections<'py>> {
    let start = start.map_or_else(StartRule::default, |s| StartRule::State(s.map(Coordinate::Si)));
    let axis = ParameterAxis::new(find(name)?, ends, count).map_err(Failure::from)?;
    let of: Displacement = of.parse().map_err(Failure::from)?;
    let exponents = exponents.map(|periods| SpectrumOptions { periods, ..SpectrumOptions::default() });
    let sweep = Sweep { exponents, start, ..Sweep::new(axis, of, (discard, keep)) };
    let set = system.set().map_err(Failure::from)?.clone();
    let found = compute(py, progress, move |control| {
        in_parts(control, sweep.count(), |task| diagram(&set, &sweep, task))
    })?;
    let Diagram { up, down } = &found;
    Ok(BothDirections {
        up: direction(py, &axis, up, exponents.is_some())?,
        down: direction(py, &axis, down, exponents.is_some())?,
        hysteresis: column(py, &found.hysteresis()),
    })
}

fn direction<'py>(
    py: Python<'py>,
    axis: &ParameterAxis,
    points: &[Option<SweepPoint>],
    with_exponents: bool,
) -> PyResult<Direction<'py>> {
    let each = |f: &dyn Fn(&SweepPoint) -> [f64; 2]| -> Vec<[f64; 2]> {
        points.iter().map(|p| p.as_ref().map_or([0.0; 2], f)).collect()
    };
    let values: Vec<f64> = (0..points.len()).map(|i| axis.value(i)).collect();
    let class = |p: &Option<SweepPoint>| p.as_ref().map_or_else(|| "refused".into(), |p| p.class.name());
    let period = |p: &Option<SweepPoint>| p.as_ref().and_then(|p| p.attractor.period).map_or(0, |n| n as i32);
    let tops = points.iter().enumerate().flat_map(|(i, p)| {
        p.iter().flat_map(move |p| p.maxima.iter().map(move |(value, met)| (i as i64, *value, *met)))
    });
    let (mut at, mut maxima, mut met) = (Vec::new(), Vec::new(), Vec::new());
    for (i, value, times) in tops {
        at.push(i);
        maxima.push(value);
        met.push(times);
    }
    let spectrum = |p: &Option<SweepPoint>| {
        p.as_ref().and_then(|p| p.spectrum.as_ref()).map_or([0.0; 7], |s| s.exponents)
    };
    let exponents: Vec<[f64; 7]> = points.iter().map(spectrum).collect();
    Ok(Direction {
        value: column(py, &values),
        kind: points.iter().map(class).collect(),
        period: column(py, &points.iter().map(period).collect::<Vec<_>>()),
        impacts: table(py, &each(&|p| p.attractor.impacts))?,
        rests: column(
            py,
            &points.iter().map(|p| p.as_ref().is_some_and(|p| p.attractor.rests)).collect::<Vec<_>>(),
        ),
        maxima: column(py, &maxima),
        at: column(py, &at),
        met: column(py, &met),
        exponents: with_exponents.then(|| table(py, &exponents)).transpose()?,
    })
}

/// A Lyapunov spectrum with its values on the way.
#[derive(IntoPyObject)]
pub struct Spectrum<'py> {
    exponents: Array1<'py, f64>,
    deviation: f64,
    impacts: u64,
    rests: bool,
    running: Array2<'py, f64>,
}

/// The seven Lyapunov exponents of the motion after `discard` drive periods from a state.
#[pyfunction]
#[pyo3(signature = (system, start, discard, periods, progress = None))]
pub fn paper_lyapunov<'py>(
    py: Python<'py>,
    system: &System,
    start: [f64; 6],
    discard: u32,
    periods: u32,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Spectrum<'py>> {
    let p = *system.parameters();
    let options = SpectrumOptions { periods, ..SpectrumOptions::default() };
    let found = compute(py, progress, move |control| {
        let mut simulator = settled(control, &p, &start, discard)?;
        let mut go_on = || {
            control.add(1);
            !control.is_cancelled()
        };
        Ok(convergence_while(&mut simulator, &options, &mut go_on)?)
    })?;
    let spectrum = found.spectrum;
    Ok(Spectrum {
        exponents: column(py, &spectrum.exponents),
        deviation: spectrum.deviation,
        impacts: spectrum.impacts,
        rests: spectrum.rests,
        running: table(py, &found.running)?,
    })
}

/// The motion after whole drive periods from a state.
fn settled(
    control: &Control,
    p: &vibro_impact::Parameters,
    start: &[f64; 6],
    discard: u32,
) -> Result<Simulator, Failure> {
    let simulator = settled_simulator(p, &state(start), f64::from(discard))?;
    control.check()?;
    Ok(simulator)
}

/// An attractor: class, period, impacts, states.
#[derive(IntoPyObject)]
struct Settled<'py> {
    kind: String,
    period: Option<u32>,
    impacts: Array1<'py, f64>,
    rests: bool,
    symmetric: bool,
    states: Array2<'py, f64>,
    mirror_states: Array2<'py, f64>,
    sizes: Array1<'py, f64>,
}

fn attractor<'py>(py: Python<'py>, found: &Attractor, class: MotionClass) -> PyResult<Settled<'py>> {
    Ok(Settled {
        kind: class.name(),
        period: found.period,
        impacts: column(py, &found.impacts),
        rests: found.rests,
        symmetric: found.is_symmetric(),
        states: table(py, &found.states)?,
        mirror_states: table(py, &found.mirror_states)?,
        sizes: column(py, &found.sizes),
    })
}

/// Attractors with the cells of starts that lead to them.
#[derive(IntoPyObject)]
pub struct Basins<'py> {
    attractors: Vec<Settled<'py>>,
    cells: Array2<'py, i32>,
    mirror: Array2<'py, bool>,
}

/// Where motions from a plane of two initial values end: the index of the attractor, -1 for a
/// start outside the stops, -2 if the motion has not settled, -3 if the attractor is undecided;
/// and whether the attractor is reached as its mirror image. In a row, y is constant.
#[pyfunction]
#[pyo3(signature = (system, x, y, start, discard, progress = None))]
pub fn paper_basins<'py>(
    py: Python<'py>,
    system: &System,
    x: (usize, f64, f64, usize),
    y: (usize, f64, f64, usize),
    start: [f64; 6],
    discard: u32,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Basins<'py>> {
    let axis = |(coordinate, from, to, count): (usize, f64, f64, usize)| {
        let name = COORDINATES.get(coordinate).copied().unwrap_or_default().into();
        StartAxis { name, from, to, count }
    };
    let start = StartRule::scaled(start);
    let request = BasinRequest { x: axis(x), y: axis(y), discard, start };
    let set = system.set().map_err(Failure::from)?.clone();
    let found = compute(py, progress, move |control| {
        in_parts(control, request.count(), |task| basins_of(&set, &request, task))
    })?;
    let cell = |cell: &BasinCell| match cell {
        BasinCell::Attractor(number) => (i32::from(*number), false),
        BasinCell::Mirror(number) => (i32::from(*number), true),
        BasinCell::Outside => (-1, false),
        BasinCell::NotSettled => (-2, false),
        BasinCell::Undecided | BasinCell::Ended | BasinCell::Rest => (-3, false),
    };
    let (cells, mirror): (Vec<i32>, Vec<bool>) = found.cells.iter().map(cell).unzip();
    let attractors =
        found.attractors.iter().map(|a| attractor(py, &a.attractor, a.class)).collect::<PyResult<_>>()?;
    Ok(Basins { attractors, cells: plane(py, &cells, y.3, x.3)?, mirror: plane(py, &mirror, y.3, x.3)? })
}

/// Every measure as (name, unit, meaning).
#[pyfunction]
pub fn paper_measures() -> Vec<(String, &'static str, String)> {
    Measure::all().map(|m| (m.name(), m.unit(), in_python(&m.description()))).collect()
}

/// Measures of the motion after `discard` drive periods from a state, over the next `periods`: a
/// row of [`measure_many`].
#[pyfunction]
#[pyo3(signature = (system, start, names, discard, periods, progress = None))]
pub fn paper_measure(
    py: Python<'_>,
    system: &System,
    start: [f64; 6],
    names: Vec<String>,
    discard: u32,
    periods: u32,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<MeasureRow> {
    let named = names.iter().map(|name| name.parse()).collect::<Result<Vec<Measure>, _>>();
    let (named, p) = (named.map_err(Failure::from)?, *system.parameters());
    let found =
        compute(py, progress, move |control| one(control, &p, &state(&start), &named, (discard, periods)))?;
    Ok(row(Ok(found), false)?)
}

/// Measures of a settled motion.
fn one(
    control: &Control,
    p: &Parameters,
    start: &State,
    measures: &[Measure],
    (discard, periods): (u32, u32),
) -> Result<Measured, Failure> {
    control.check()?;
    let mut simulator = Simulator::new(p, start, 0.0)?;
    simulator.advance_to(f64::from(discard) * p.period())?;
    control.check()?;
    Ok(measured(&mut simulator, measures, periods)?)
}

/// Measures of one of many motions: numbers, their spreads, class, index of the measure that had
/// not settled, and the reason if measures are missing and the row gives reasons.
pub type MeasureRow = (Vec<Option<f64>>, Vec<f64>, Option<String>, Option<usize>, Option<String>);

/// A motion's row. If `in_rows` is set, the row reports a failure of this motion alone.
///
/// # Errors
/// All other failures.
pub fn row(found: Result<Measured, Failure>, in_rows: bool) -> Result<MeasureRow, Failure> {
    match found {
        Ok(found) => {
            Ok((found.numbers, found.spreads, found.class.map(MotionClass::name), found.unsettled, None))
        }
        Err(failure) if in_rows => Ok((Vec::new(), Vec::new(), None, None, Some(failure.reason()?))),
        Err(failure) => Err(failure),
    }
}

/// A row of measures for each of many motions, each from its own start or all from one, on all
/// threads.
#[pyfunction]
#[pyo3(signature = (systems, starts, names, discard, periods, in_rows, progress = None))]
#[allow(clippy::too_many_arguments)]
pub fn paper_measure_many(
    py: Python<'_>,
    systems: GivenSystems<'_>,
    starts: GivenStarts<'_>,
    names: Vec<String>,
    discard: u32,
    periods: u32,
    in_rows: bool,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Vec<MeasureRow>> {
    let named = names.iter().map(|name| name.parse()).collect::<Result<Vec<Measure>, _>>();
    let named = named.map_err(Failure::from)?;
    let (systems, starts) = (systems.owned()?, starts.owned()?);
    each_of(py, systems.len(), progress, move |control, index| {
        let measured = systems
            .motion(&starts, index)
            .and_then(|(p, start)| one(control, &p, &start, &named, (discard, periods)));
        row(measured, in_rows)
    })
}
