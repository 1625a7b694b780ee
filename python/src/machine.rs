//! A described machine, its starts and sections, as Python objects.

use crate::failure::Failure;
use fmi_doors::Version;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::PathBuf;
use std::sync::Arc;
use vibro_figures::canvas;
use vibro_machine::description::Description;
use vibro_machine::{Assembly, file};
use vibro_pack::Kit;
use vibro_sketch::Sketch;
use vibro_studies::{Machine, Measure, SectionRule, Start, columns, common_period};

/// A described machine: immutable.
#[pyclass(frozen, module = "vibro_impact._native")]
#[derive(Clone, Debug)]
pub struct Described {
    pub(crate) description: Arc<Description>,
}

/// Names and numbers of a start, SI; empty for the machine's own start.
pub type Numbers = Vec<(String, f64)>;

/// A new value of a parameter: a number in SI, or a text with a unit.
#[derive(FromPyObject)]
pub enum Value {
    Number(f64),
    Text(String),
}

#[pymethods]
impl Described {
    /// From the text of a file, or from a file. Paths of records are relative to the file's
    /// folder.
    #[new]
    fn new(text: Option<&str>, path: Option<&str>) -> PyResult<Self> {
        let read = match (text, path) {
            (Some(text), _) => file::parse(text, "machine", &file::no_records),
            (None, path) => file::read(path.unwrap_or_default().as_ref()),
        };
        let description = read.map_err(Failure::from)?;
        // Checks matrices and start.
        Assembly::new(description.clone()).map_err(Failure::from)?;
        Ok(Self { description: Arc::new(description) })
    }

    fn name(&self) -> &str {
        &self.description.name
    }

    /// The text of its file, in SI with every digit.
    fn text(&self) -> String {
        self.description.to_toml()
    }

    /// The common period of all drives, s.
    fn period(&self) -> Option<f64> {
        common_period(&self.description)
    }

    /// Name, SI unit, value and meaning of each parameter.
    fn parameters(&self) -> Vec<(String, &'static str, f64, String)> {
        self.description.parameters().into_iter().map(|p| (p.name, p.unit, p.value, p.meaning)).collect()
    }

    /// Names of the columns of a motion.
    fn columns(&self) -> Vec<String> {
        columns(&self.description)
    }

    /// Name, unit and meaning of each measure.
    fn measures(&self) -> Vec<(String, &'static str, String)> {
        let d = &*self.description;
        Measure::all(d).into_iter().map(|m| (m.to_string(), m.unit(d), m.description())).collect()
    }

    /// The value of a parameter's text, SI.
    fn value(&self, name: &str, text: &str) -> PyResult<f64> {
        let read = self.description.parameter(name).and_then(|parameter| parameter.read(text));
        Ok(read.map_err(Failure::from)?)
    }

    /// The machine with some parameters changed.
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

    /// The numbers of a start after changes, SI.
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

    /// The file name of its FMU.
    fn fmu_name(&self, version: u8) -> String {
        let version = if version == 2 { Version::Fmi2 } else { Version::Fmi3 };
        vibro_pack::file_name(&self.description.name, version)
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

    /// The numbers of a start, after a check that each of its bodies has a coordinate.
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

/// The section rule of a choice.
pub fn rule(section: Option<SectionChoice>) -> SectionRule {
    match section {
        None => SectionRule::Auto,
        Some(SectionChoice::Period(period)) => SectionRule::Period(period),
        Some(SectionChoice::Element(name)) => SectionRule::Element(name),
    }
}
