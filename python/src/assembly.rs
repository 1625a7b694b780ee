//! Machines that a file or a program describes: their parameters, motions, measures and diagrams.

use crate::arrays::{Array1, Array2, column, numbers, plane, table};
use crate::background::{Control, compute, each_of};
use crate::failure::Failure;
use crate::studies::{MeasureRow, in_parts, row};
use fmi_doors::Version;
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::PathBuf;
use std::sync::Arc;
use vibro_analysis::assembly::diagram::{self, AssemblyPoint};
use vibro_analysis::assembly::{Machine, Measure, SectionRule, Start, columns, measure, named, values};
use vibro_analysis::bifurcation::Diagram;
use vibro_analysis::measures::Measured;
use vibro_analysis::plane::ParameterAxis;
use vibro_assembly::derivative::VariedObserver;
use vibro_assembly::description::Description;
use vibro_assembly::motion::Event;
use vibro_assembly::{Assembly, Differentiated, Motion, file};
use vibro_figures::canvas;
use vibro_pack::Kit;
use vibro_sketch::Sketch;

/// A described machine: immutable.
#[pyclass(frozen, module = "vibro_impact._native")]
#[derive(Clone, Debug)]
pub struct Described {
    description: Arc<Description>,
}

/// A new value of a parameter: a number in SI, or a text with a unit.
#[derive(FromPyObject)]
pub enum Value {
    Number(f64),
    Text(String),
}

#[pymethods]
impl Described {
    /// From the text of a file, or from a file. A file's records are in its folder.
    #[new]
    fn new(text: Option<&str>, path: Option<&str>) -> PyResult<Self> {
        let read = match (text, path) {
            (Some(text), _) => file::parse(text, "machine", &file::no_records),
            (None, path) => file::read(path.unwrap_or_default().as_ref()),
        };
        let description = read.map_err(Failure::from)?;
        // Checks that need the matrices and the start.
        Assembly::new(description.clone()).map_err(Failure::from)?;
        Ok(Self { description: Arc::new(description) })
    }

    fn name(&self) -> &str {
        &self.description.name
    }

    /// The text of its file, in SI and with every digit.
    fn text(&self) -> String {
        self.description.to_toml()
    }

    /// Name, SI unit, value and meaning of each parameter.
    fn parameters(&self) -> Vec<(String, &'static str, f64, &'static str)> {
        self.description.parameters().into_iter().map(|p| (p.name, p.unit, p.value, p.meaning)).collect()
    }

    /// Names of a motion's columns.
    fn columns(&self) -> Vec<String> {
        columns(&self.description)
    }

    /// Name, unit and meaning of each measure.
    fn measures(&self) -> Vec<(String, &'static str, String)> {
        let d = &*self.description;
        Measure::all(d).into_iter().map(|m| (m.to_string(), m.unit(d), m.description())).collect()
    }

    /// The machine with other values.
    fn replace(&self, changes: Vec<(String, Value)>) -> PyResult<Self> {
        let value = |(name, value): &(String, Value)| match value {
            Value::Number(x) => Ok((name.clone(), *x)),
            Value::Text(text) => Ok((name.clone(), self.description.parameter(name)?.read(text)?)),
        };
        let values = changes.iter().map(value).collect::<Result<Vec<_>, Failure>>()?;
        let named = values.iter().map(|(name, value)| (name.as_str(), *value));
        let description = self.description.with(named).map_err(Failure::from)?;
        Assembly::new(description.clone()).map_err(Failure::from)?;
        Ok(Self { description: Arc::new(description) })
    }

    /// Its sketch as SVG.
    fn sketch(&self) -> PyResult<String> {
        Ok(canvas::svg(&Sketch::new(&self.description)).map_err(Failure::from)?)
    }

    /// Its sketch as PNG.
    fn sketch_as_png<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &canvas::png(&Sketch::new(&self.description)).map_err(Failure::from)?))
    }

    /// Writes its FMU around the library of a kit.
    fn fmu(&self, py: Python<'_>, version: u8, kit: PathBuf, path: PathBuf) -> PyResult<()> {
        let version = if version == 2 { Version::Fmi2 } else { Version::Fmi3 };
        let write = || vibro_pack::write(&self.description, version, &Kit::read(&kit)?, &path);
        Ok(py.detach(write).map_err(Failure::from)?)
    }
}

impl Described {
    fn motion(&self) -> Result<Motion, Failure> {
        Ok(Motion::new(Arc::new(Assembly::new((*self.description).clone())?))?)
    }

    /// The motion from the start, with its derivatives if `parameters` is not empty. `observer` is
    /// called with the impacts at the start.
    fn follower(&self, parameters: &[String], observer: &mut VariedObserver) -> Result<Follower, Failure> {
        let assembly = Arc::new(Assembly::new((*self.description).clone())?);
        if parameters.is_empty() {
            let motion = Motion::new_observed(assembly, &mut |event| observer(event, &[]))?;
            return Ok(Follower::Alone(Box::new(motion)));
        }
        let names: Vec<&str> = parameters.iter().map(String::as_str).collect();
        let known = names.iter().try_for_each(|name| self.description.parameter(name).map(drop));
        known?;
        Ok(Follower::Varied(Box::new(Differentiated::new_observed(assembly, &names, observer)?)))
    }

    fn machine(&self, section: Option<SectionChoice>) -> Machine {
        Machine { section: rule(section), ..Machine::new((*self.description).clone()) }
    }
}

/// Section of a motion: a period in s, or an element's name.
#[derive(FromPyObject)]
pub enum SectionChoice {
    Period(f64),
    Element(String),
}

fn rule(section: Option<SectionChoice>) -> SectionRule {
    match section {
        None => SectionRule::Auto,
        Some(SectionChoice::Period(period)) => SectionRule::Period(period),
        Some(SectionChoice::Element(name)) => SectionRule::Element(name),
    }
}

/// A sampled motion with its events.
#[derive(IntoPyObject)]
pub struct AssemblyRun<'py> {
    values: Array2<'py, f64>,
    t: Array1<'py, f64>,
    kind: Vec<&'static str>,
    element: Vec<String>,
    value: Array1<'py, f64>,
    stops: Array1<'py, i32>,
    energy: Array2<'py, f64>,
    /// Derivatives by sample, column and parameter, and whether each exists.
    derivatives: Varied<'py>,
    /// Derivatives of the times of events, by event and parameter.
    event_derivatives: Varied<'py>,
    /// For each parameter the reason why derivatives do not exist from some time on, or an empty
    /// text.
    lost: Vec<String>,
}

/// Numbers, and for each whether it exists.
type Varied<'py> = (Array2<'py, f64>, Array2<'py, bool>);

fn varied<'py>(py: Python<'py>, rows: &[Vec<Option<f64>>], columns: usize) -> PyResult<Varied<'py>> {
    let all = rows.iter().flatten();
    let numbers: Vec<f64> = all.clone().map(|x| x.unwrap_or(0.0)).collect();
    let known: Vec<bool> = all.map(Option::is_some).collect();
    Ok((plane(py, &numbers, rows.len(), columns)?, plane(py, &known, rows.len(), columns)?))
}

/// A motion alone, or with its derivatives.
enum Follower {
    Alone(Box<Motion>),
    Varied(Box<Differentiated>),
}

impl Follower {
    fn motion(&self) -> &Motion {
        match self {
            Self::Alone(motion) => motion,
            Self::Varied(varied) => varied.motion(),
        }
    }

    /// The derivatives of all columns by all of `count` parameters.
    fn derivatives(&self, count: usize) -> Vec<Option<f64>> {
        let Self::Varied(varied) = self else { return Vec::new() };
        let quantities = varied.motion().assembly().description.quantities();
        quantities.flat_map(|q| (0..count).map(move |p| varied.derivative(q, p))).collect()
    }

    fn lost(&self, count: usize) -> Vec<String> {
        let Self::Varied(varied) = self else { return Vec::new() };
        (0..count).map(|p| varied.lost(p).map_or(String::new(), ToString::to_string)).collect()
    }

    fn advance(&mut self, time: f64, tell: &mut VariedObserver) -> Result<(), Failure> {
        match self {
            Self::Alone(motion) => motion.advance_observed(time, &mut |event| tell(event, &[]))?,
            Self::Varied(varied) => varied.advance_observed(time, tell)?,
        }
        Ok(())
    }
}

/// The motion at ascending times (s), with what happened up to the last, and with its derivatives
/// by parameters.
#[pyfunction]
#[pyo3(signature = (machine, t, parameters, progress = None))]
pub fn simulate_assembly<'py>(
    py: Python<'py>,
    machine: &Described,
    t: PyReadonlyArray1<'_, f64>,
    parameters: Vec<String>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<AssemblyRun<'py>> {
    let (own, times, count) = (machine.clone(), numbers(&t)?, parameters.len());
    let (samples, energies, events, told, by, times_by, lost) = compute(py, progress, move |control| {
        let (mut events, mut times_by): (Vec<Event>, Vec<Vec<Option<f64>>>) = Default::default();
        let mut tell = |event: &Event, by: &[Option<f64>]| {
            events.push(event.clone());
            times_by.push(by.to_vec());
        };
        let mut follower = own.follower(&parameters, &mut tell)?;
        let (mut samples, mut energies, mut by) = (Vec::new(), Vec::new(), Vec::new());
        samples.try_reserve_exact(times.len())?;
        for &time in &times {
            control.check()?;
            follower.advance(time, &mut tell)?;
            let motion = follower.motion();
            samples.push(values(motion));
            let (kinetic, stored) = motion.kinetic_and_stored();
            energies.push([kinetic, stored, motion.energy().balance()]);
            by.push(follower.derivatives(count));
            control.add(1);
        }
        let motion = follower.motion();
        let told: Vec<_> = events.iter().map(|event| named(motion.assembly(), &event.kind)).collect();
        Ok((samples, energies, events, told, by, times_by, follower.lost(count)))
    })?;
    Ok(AssemblyRun {
        values: plane(py, &samples.concat(), samples.len(), machine.description.quantities().count())?,
        t: column(py, &events.iter().map(|e| e.time).collect::<Vec<_>>()),
        kind: told.iter().map(|e| e.kind).collect(),
        value: column(py, &told.iter().map(|e| e.value.unwrap_or(0.0)).collect::<Vec<_>>()),
        stops: column(py, &told.iter().map(|e| e.stops.unwrap_or(0) as i32).collect::<Vec<_>>()),
        element: told.into_iter().map(|e| e.element).collect(),
        energy: table(py, &energies)?,
        derivatives: varied(py, &by, count * machine.description.quantities().count())?,
        event_derivatives: varied(py, &times_by, count)?,
        lost,
    })
}

/// The ends of many machines' motions at a time (s), of which all have the same columns.
#[pyfunction]
#[pyo3(signature = (machines, until, progress = None))]
pub fn simulate_assemblies<'py>(
    py: Python<'py>,
    machines: Vec<PyRef<'_, Described>>,
    until: f64,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Array2<'py, f64>> {
    let count = machines.first().map_or(0, |m| m.description.quantities().count());
    let machines = clones(&machines);
    let ends = each_of(py, machines.len(), progress, move |_, index| {
        let mut motion = machines[index].motion()?.without_energy_accounts();
        motion.advance_to(until)?;
        Ok(values(&motion))
    })?;
    plane(py, &ends.concat(), ends.len(), count)
}

fn clones(machines: &[PyRef<'_, Described>]) -> Vec<Described> {
    machines.iter().map(|m| (*m).clone()).collect()
}

/// Measures of many machines' settled motions, a row for each.
#[pyfunction]
#[pyo3(signature = (machines, names, settle, periods, section, in_rows, progress = None))]
#[allow(clippy::too_many_arguments)]
pub fn measure_assemblies(
    py: Python<'_>,
    machines: Vec<PyRef<'_, Described>>,
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
    let machines = clones(&machines);
    let count = machines.len();
    let one = move |control: &Control, index: usize| -> Result<Measured, Failure> {
        let machine = Machine { section: rule.clone(), ..machines[index].machine(None) };
        let (mut motion, section) = machine.motion(&Start::default())?;
        vibro_analysis::assembly::settle(&mut motion, &section, settle)?;
        control.check()?;
        Ok(measure(&mut motion, &section, &measures, periods)?)
    };
    each_of(py, count, progress, move |control, index| row(one(control, index), in_rows))
}

/// One direction of a diagram.
#[derive(IntoPyObject)]
struct AssemblyDirection<'py> {
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
pub struct AssemblyDiagram<'py> {
    up: AssemblyDirection<'py>,
    down: AssemblyDirection<'py>,
    hysteresis: Array1<'py, bool>,
}

fn direction<'py>(
    py: Python<'py>,
    axis: &ParameterAxis<String>,
    points: &[Option<AssemblyPoint>],
) -> AssemblyDirection<'py> {
    let of = |read: &dyn Fn(&AssemblyPoint) -> f64| -> Vec<f64> {
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
    let class = |p: &Option<AssemblyPoint>| p.as_ref().map_or("refused".into(), |p| p.settled.class.name());
    let period = |p: &Option<AssemblyPoint>| p.as_ref().and_then(|p| p.settled.period).unwrap_or(0) as i32;
    let rests: Vec<bool> = points.iter().map(|p| p.as_ref().is_some_and(|p| p.settled.rests)).collect();
    AssemblyDirection {
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

/// Maxima of a quantity, or its values at the section, over a parameter, with what motions settle
/// on.
#[pyfunction]
#[pyo3(signature = (machine, name, ends, count, of, at_section, periods, exponents, section, anew, progress = None))]
#[allow(clippy::too_many_arguments)]
pub fn assembly_diagram<'py>(
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
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<AssemblyDiagram<'py>> {
    let axis = ParameterAxis::of(name, ends, count).map_err(Failure::from)?;
    let of = of.parse().map_err(Failure::from)?;
    let (discard, keep) = periods;
    let request =
        diagram::DiagramRequest { axis: axis.clone(), of, at_section, discard, keep, exponents, anew };
    let own = machine.machine(section);
    let found: Diagram<AssemblyPoint> = compute(py, progress, move |control| {
        in_parts(control, request.count(), |task| diagram::diagram(&own, &request, task))
    })?;
    Ok(AssemblyDiagram {
        up: direction(py, &axis, &found.up),
        down: direction(py, &axis, &found.down),
        hysteresis: column(py, &found.hysteresis()),
    })
}
