//! Periodic orbits of described machines, and their branches along a parameter.

use crate::arrays::{Array1, column};
use crate::background::{Control, compute};
use crate::failure::Failure;
use crate::machine::{Described, Numbers, SectionChoice};
use nalgebra::Complex;
use pyo3::prelude::*;
use vibro_machine::Start;
use vibro_orbits::paper::PathOptions;
use vibro_orbits::{
    Branch, Family, Stability, TreeOptions, WantedPeriod, WantedWord, WordSearch, branch, read_measure, tree,
};
use vibro_studies::{Machine, Measure, named};

/// A periodic orbit of a described machine.
#[pyclass(frozen, module = "vibro_impact._native")]
#[derive(Clone, Debug)]
pub struct Orbit {
    machine: Machine,
    orbit: vibro_orbits::Orbit,
}

#[pymethods]
impl Orbit {
    /// The orbit's word: its sequence of events as text.
    #[getter]
    fn word(&self) -> String {
        self.orbit.word().in_words(&self.orbit.place().assembly)
    }

    /// The period, s.
    #[getter]
    fn period(&self) -> f64 {
        self.orbit.period()
    }

    /// The period in common periods of the drive.
    #[getter]
    fn periods(&self) -> Option<u32> {
        self.orbit.word().periods
    }

    /// Time, kind and element of each event, without samples of blocks.
    #[getter]
    fn events(&self) -> Vec<(f64, &'static str, String)> {
        let assembly = &self.orbit.place().assembly;
        let told = |event: &vibro_machine::motion::Event| {
            let own = named(assembly, &event.kind);
            (event.time, own.kind, own.element)
        };
        self.orbit.events().iter().filter(|event| event.is_listed()).map(told).collect()
    }

    /// The multipliers that are not 1 by theory, largest first.
    #[getter]
    fn multipliers<'py>(&self, py: Python<'py>) -> Array1<'py, Complex<f64>> {
        column(py, self.orbit.multipliers())
    }

    /// `stable`, `unstable`, `neutral` or `undecided`.
    #[getter]
    fn stability(&self) -> String {
        self.orbit.stability().to_string()
    }

    /// The condition that the orbit violates; `None` if it is a motion of the machine.
    #[getter]
    fn violation(&self) -> Option<String> {
        self.orbit.violation()
    }

    /// Names and values of a start on the orbit.
    #[getter]
    fn start(&self) -> Numbers {
        self.orbit.start().numbers()
    }

    /// A measure over one period.
    fn measure(&self, name: &str) -> PyResult<f64> {
        let measure = read_measure(name, &self.machine.description).map_err(Failure::from)?;
        Ok(self.orbit.measure(&measure).map_err(Failure::from)?)
    }

    /// For each parameter: name, derivative of a measure, and the reason if there is none.
    fn gradient(&self, py: Python<'_>, name: &str) -> PyResult<Vec<(String, Option<f64>, String)>> {
        let measure = read_measure(name, &self.machine.description).map_err(Failure::from)?;
        let found = py.detach(|| self.orbit.gradient(&measure)).map_err(Failure::from)?;
        let row = |row: vibro_orbits::ParameterDerivative| match row.derivative {
            Ok(derivative) => (row.parameter, Some(derivative), String::new()),
            Err(reason) => (row.parameter, None, reason),
        };
        Ok(found.into_iter().map(row).collect())
    }

    /// Energies per period by element, J; `None` if the orbit is too unstable for a motion to stay
    /// on it.
    fn energies(&self, py: Python<'_>) -> PyResult<Option<Vec<(String, f64)>>> {
        Ok(py.detach(|| self.orbit.energies()).map_err(Failure::from)?)
    }
}

/// The orbit on which a motion settles, or an orbit with a given word or period. The period is a
/// number of common periods of the drives (`periods`) or a time, s (`time`).
#[pyfunction]
#[pyo3(signature = (machine, start, settle, section, word, periods, time, starts, progress = None))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of the package")]
pub fn orbit(
    py: Python<'_>,
    machine: &Described,
    start: Numbers,
    settle: u32,
    section: Option<SectionChoice>,
    word: Option<String>,
    periods: Option<u32>,
    time: Option<f64>,
    starts: u32,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Orbit> {
    let assembly = machine.assembly()?;
    let (start, machine) = (machine.start_of(&start)?, machine.machine(section));
    let word = word.map(|word| WantedWord::parse(&word, &assembly)).transpose().map_err(Failure::from)?;
    let period = periods.map(WantedPeriod::Drive).or_else(|| time.map(WantedPeriod::Time));
    compute(py, progress, move |control| {
        let orbit = if word.is_none() && period.is_none() {
            vibro_orbits::Orbit::settled(&machine, &start, settle)?
        } else {
            let wanted = WordSearch { start, word, period, starts, discard: settle };
            control.expect(wanted.most_returns());
            let found = vibro_orbits::Orbit::search(&machine, &wanted, &|| control.goes_on());
            control.check()?;
            found?
        };
        Ok(Orbit { orbit, machine })
    })
}

/// A branch of orbits along a parameter.
#[derive(IntoPyObject)]
pub struct BranchArrays<'py> {
    parent: Option<(usize, usize)>,
    word: String,
    periods: Option<u32>,
    closed: bool,
    value: Array1<'py, f64>,
    period: Array1<'py, f64>,
    multipliers: Vec<Array1<'py, Complex<f64>>>,
    stability: Vec<String>,
    stable: Array1<'py, bool>,
    labels: Vec<&'static str>,
    elements: Vec<String>,
    measure: Array1<'py, f64>,
    starts: Vec<Option<Numbers>>,
}

/// A branch with a measure of each orbit and a start on each orbit.
struct Measured {
    branch: Branch,
    values: Vec<(f64, Option<Numbers>)>,
}

fn measured(branch: Branch, measure: &Measure, control: &Control) -> Result<Measured, Failure> {
    let value = |point| {
        control.check()?;
        let orbit = branch.orbit(point);
        let value = orbit.as_ref().and_then(|orbit| orbit.measure(measure).ok()).unwrap_or(f64::NAN);
        Ok((value, orbit.map(|orbit| orbit.start().numbers())))
    };
    let values = branch.points.iter().map(value).collect::<Result<_, Failure>>()?;
    Ok(Measured { branch, values })
}

fn arrays<'py>(py: Python<'py>, family: &Family, found: Measured) -> PyResult<BranchArrays<'py>> {
    let Measured { branch, values } = found;
    let points = &branch.points;
    let (values, starts): (Vec<_>, Vec<_>) = values.into_iter().unzip();
    let place = family.place(points[0].value).map_err(Failure::from)?;
    let special = |of: fn(&vibro_orbits::Special) -> String| -> Vec<String> {
        points.iter().map(|p| p.special.as_ref().map_or_else(String::new, of)).collect()
    };
    let numbers = |of: fn(&vibro_orbits::OrbitPoint) -> f64| -> Vec<f64> { points.iter().map(of).collect() };
    let stable: Vec<bool> = points.iter().map(|p| p.stability == Stability::Stable).collect();
    Ok(BranchArrays {
        parent: branch.parent,
        word: branch.word().in_words(&place.assembly),
        periods: branch.word().periods,
        closed: branch.closed,
        value: column(py, &numbers(|p| p.value)),
        period: column(py, &numbers(|p| p.period)),
        multipliers: points.iter().map(|p| column(py, &p.multipliers)).collect(),
        stability: points.iter().map(|p| p.stability.to_string()).collect(),
        stable: column(py, &stable),
        labels: points.iter().map(|p| p.label().map_or("", |label| label.name())).collect(),
        elements: special(|s| s.element.clone()),
        measure: column(py, &values),
        starts,
    })
}

/// The branch of an orbit over a range of a parameter, in both directions.
#[pyfunction]
#[pyo3(signature = (orbit, name, ends, of, progress = None))]
pub fn follow<'py>(
    py: Python<'py>,
    orbit: &Orbit,
    name: &str,
    ends: (f64, f64),
    of: &str,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<BranchArrays<'py>> {
    let measure = read_measure(of, &orbit.machine.description).map_err(Failure::from)?;
    let own = orbit.orbit.clone();
    let family = Family::new(&orbit.machine, name, ends).map_err(Failure::from)?;
    let along = family.clone();
    let found = compute(py, progress, move |control| {
        measured(branch(&along, &own, &PathOptions::default())?, &measure, control)
    })?;
    arrays(py, &family, found)
}

/// The branches over a range of a parameter that are reached from settled motions and special
/// points.
#[pyfunction]
#[pyo3(signature = (machine, name, ends, of, start, seeds, depth, settle, section, progress = None))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of the package")]
pub fn branches<'py>(
    py: Python<'py>,
    machine: &Described,
    name: &str,
    ends: (f64, f64),
    of: &str,
    start: Numbers,
    seeds: usize,
    depth: u32,
    settle: u32,
    section: Option<SectionChoice>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Vec<BranchArrays<'py>>> {
    let start: Start = machine.start_of(&start)?;
    let machine = machine.machine(section);
    let measure = read_measure(of, &machine.description).map_err(Failure::from)?;
    let family = Family::new(&machine, name, ends).map_err(Failure::from)?;
    let along = family.clone();
    let options = TreeOptions { start, seeds, depth, discard: settle, path: PathOptions::default() };
    let found = compute(py, progress, move |control| {
        let mut count = 0;
        let branches = tree(&along, &options, &mut |found, all| {
            control.expect(all);
            control.add(found.len() - count);
            count = found.len();
            !control.is_cancelled()
        })?;
        control.check()?;
        branches
            .into_iter()
            .map(|branch| measured(branch, &measure, control))
            .collect::<Result<Vec<_>, Failure>>()
    })?;
    found.into_iter().map(|found| arrays(py, &family, found)).collect()
}
