//! Machines that a file or a program describes: their parameters, motions, measures and diagrams.

use crate::arrays::{Array1, column};
use crate::background::{Control, compute, each_of};
use crate::designs::{GivenAssemblies, start_of};
use crate::failure::Failure;
use crate::studies::{MeasureRow, in_parts, row};
use fmi_doors::Version;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::PathBuf;
use std::sync::Arc;
use vibro_analysis::assembly::diagram::{self, AssemblyPoint};
use vibro_analysis::assembly::{Machine, Measure, SectionRule, Start, columns, common_period, measure};
use vibro_analysis::bifurcation::Diagram;
use vibro_analysis::measures::Measured;
use vibro_analysis::plane::ParameterAxis;
use vibro_assembly::description::Description;
use vibro_assembly::{Assembly, file};
use vibro_figures::canvas;
use vibro_pack::Kit;
use vibro_sketch::Sketch;

/// A described machine: immutable.
#[pyclass(frozen, module = "vibro_impact._native")]
#[derive(Clone, Debug)]
pub struct Described {
    description: Arc<Description>,
}

/// Names and numbers of a start, SI; none of a machine's own.
pub type Numbers = Vec<(String, f64)>;

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

    /// The common period of all that drives it, s.
    fn period(&self) -> Option<f64> {
        common_period(&self.description)
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

    /// The numbers of a start that changes some of another's, SI.
    fn start(&self, numbers: Numbers, changes: Vec<(String, Value)>) -> PyResult<Numbers> {
        let mut start = self.start_of(&numbers)?;
        let d = &*self.description;
        let set = |(name, value): &(String, Value)| match value {
            Value::Number(x) => start.set(d, name, *x),
            Value::Text(text) => start.set_text(d, name, text),
        };
        changes.iter().try_for_each(set).map_err(Failure::from)?;
        self.checked(&start)
    }

    /// The numbers of a start's file.
    fn read_start(&self, path: PathBuf) -> PyResult<Numbers> {
        self.checked(&Start::read(&path, &self.description).map_err(Failure::from)?)
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
    /// A machine whose description has been checked.
    pub fn of(description: Description) -> Self {
        Self { description: Arc::new(description) }
    }

    /// The machine with its matrices.
    pub fn assembly(&self) -> Result<Arc<Assembly>, Failure> {
        Ok(Arc::new(Assembly::new((*self.description).clone())?))
    }

    /// The description.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// The numbers of a start whose bodies have coordinates of their own.
    fn checked(&self, start: &Start) -> PyResult<Numbers> {
        start.state(&*self.assembly()?).map_err(Failure::from)?;
        Ok(start.numbers())
    }

    /// The start with these numbers by name.
    pub fn start_of(&self, numbers: &Numbers) -> Result<Start, Failure> {
        let mut start = Start::default();
        numbers.iter().try_for_each(|(name, value)| start.set(&self.description, name, *value))?;
        Ok(start)
    }

    pub fn machine(&self, section: Option<SectionChoice>) -> Machine {
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

/// Measures of many machines' settled motions, each from its start or all from one, a row for each.
#[pyfunction]
#[pyo3(signature = (machines, starts, names, settle, periods, section, in_rows, progress = None))]
#[allow(clippy::too_many_arguments)]
pub fn measure_assemblies(
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
    let count = machines.len();
    let one = move |control: &Control, index: usize| -> Result<Measured, Failure> {
        let own = machines.machine(index)?;
        let machine = Machine { section: rule.clone(), ..own.machine(None) };
        let (mut motion, section) = machine.motion(&own.start_of(start_of(&starts, index))?)?;
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
#[pyo3(signature = (machine, name, ends, count, of, at_section, periods, exponents, section, anew, start, progress = None))]
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
    start: Numbers,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<AssemblyDiagram<'py>> {
    let axis = ParameterAxis::of(name, ends, count).map_err(Failure::from)?;
    let of = of.parse().map_err(Failure::from)?;
    let (discard, keep) = periods;
    let start = machine.start_of(&start)?;
    let axis_of = axis.clone();
    let request =
        diagram::DiagramRequest { axis: axis_of, of, at_section, discard, keep, exponents, anew, start };
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
