//! Periodic orbits by the order of their impacts, and branches of them along a parameter.

use crate::arrays::{Array1, Array2, column, numbers, plane, state, states};
use crate::background::compute;
use crate::failure::Failure;
use crate::paper_system::{System, find};
use nalgebra::Complex;
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use vibro_orbits::paper::{Branch, Family, OrbitWord, PathOptions, Span, TreeOptions};
use vibro_studies::paper::ParameterSet;

/// A certified periodic orbit.
#[pyclass(frozen, module = "vibro_impact._native")]
#[derive(Clone, Debug)]
pub struct PaperOrbit {
    set: ParameterSet,
    orbit: vibro_orbits::paper::Orbit,
    /// How often the requested word passes the orbit.
    passages: u32,
}

impl PaperOrbit {
    /// An orbit that was found, in its shortest word.
    fn shortest(set: &ParameterSet, found: &vibro_orbits::paper::Orbit) -> Self {
        let (orbit, passages) = found.shortest();
        Self { set: set.clone(), orbit, passages }
    }
}

#[pymethods]
impl PaperOrbit {
    /// The orbit whose phases (rad) are known.
    #[new]
    fn new(
        system: &System,
        word: &str,
        closing: i8,
        half_periods: u32,
        phases: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<Self> {
        let word = OrbitWord::new(word, closing, half_periods).map_err(Failure::from)?;
        let machine = vibro_orbits::paper::System::new(system.parameters()).map_err(Failure::from)?;
        let orbit =
            vibro_orbits::paper::Orbit::find(&machine, &word, &numbers(&phases)?).map_err(Failure::from)?;
        Ok(Self { set: system.set().map_err(Failure::from)?.clone(), orbit, passages: 1 })
    }

    /// The stops in order, letters U and L.
    #[getter]
    fn word(&self) -> String {
        self.orbit.word().to_string()
    }

    /// +1, or -1 for a symmetric orbit whose word is half of it.
    #[getter]
    fn closing(&self) -> i8 {
        self.orbit.word().closing()
    }

    /// Half drive periods until the word closes.
    #[getter]
    fn half_periods(&self) -> u32 {
        self.orbit.word().half_periods()
    }

    /// The period in drive periods.
    #[getter]
    fn period(&self) -> u32 {
        self.orbit.word().period()
    }

    /// How often the requested word passes the orbit.
    #[getter]
    fn passages(&self) -> u32 {
        self.passages
    }

    /// Span of the multipliers in drive periods.
    #[getter]
    fn multiplier_periods(&self) -> f64 {
        self.orbit.multiplier_periods()
    }

    /// Phases of the drive at the impacts, rad.
    #[getter]
    fn phases<'py>(&self, py: Python<'py>) -> Array1<'py, f64> {
        column(py, self.orbit.phases())
    }

    /// Approach speeds at the impacts, m/s.
    #[getter]
    fn speeds<'py>(&self, py: Python<'py>) -> Array1<'py, f64> {
        let p = self.set.parameters();
        let speeds: Vec<f64> =
            self.orbit.speeds().iter().map(|s| s * p.drive_frequency * p.stop_gap).collect();
        column(py, &speeds)
    }

    /// The six multipliers, largest first.
    #[getter]
    fn multipliers<'py>(&self, py: Python<'py>) -> Array1<'py, Complex<f64>> {
        column(py, &self.orbit.multipliers())
    }

    /// Whether the orbit attracts neighbouring motions.
    #[getter]
    fn stable(&self) -> bool {
        self.orbit.is_stable()
    }

    /// Displacements (m) and velocities (m/s) at phases of the drive, rad.
    fn motion<'py>(
        &self,
        py: Python<'py>,
        theta: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<(Array2<'py, f64>, Array2<'py, f64>)> {
        let at = |theta: &f64| self.orbit.state(*theta);
        states(py, &numbers(&theta)?.iter().map(at).collect::<Vec<_>>())
    }

    /// Local maxima of a sum of x1, x2, x3 with weights, m.
    fn maxima<'py>(&self, py: Python<'py>, weights: [f64; 3]) -> Array1<'py, f64> {
        let gap = self.set.parameters().stop_gap;
        let found: Vec<f64> = self.orbit.maxima(weights).into_iter().map(|x| x * gap).collect();
        column(py, &found)
    }
}

/// The certified orbits with a word that a search finds, each in its shortest word; orbits without
/// a shorter word come first.
#[pyfunction]
#[pyo3(signature = (system, word, closing, half_periods, tries, progress = None))]
pub fn paper_orbit(
    py: Python<'_>,
    system: &System,
    word: &str,
    closing: i8,
    half_periods: u32,
    tries: u32,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Vec<PaperOrbit>> {
    let word = OrbitWord::new(word, closing, half_periods).map_err(Failure::from)?;
    let set = system.set().map_err(Failure::from)?.clone();
    compute(py, progress, move |_| {
        let found =
            vibro_orbits::paper::search(&vibro_orbits::paper::System::new(set.parameters())?, &word, tries)?;
        Ok(found.iter().map(|orbit| PaperOrbit::shortest(&set, orbit)).collect())
    })
}

/// The orbit on which the motion from a state has settled after `discard` drive periods.
#[pyfunction]
#[pyo3(signature = (system, start, discard, progress = None))]
pub fn paper_settled_orbit(
    py: Python<'_>,
    system: &System,
    start: [f64; 6],
    discard: u32,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<PaperOrbit> {
    let set = system.set().map_err(Failure::from)?.clone();
    compute(py, progress, move |control| {
        let machine = vibro_orbits::paper::System::new(set.parameters())?;
        let settled = vibro_orbits::paper::settle(&machine, &state(&start), discard)?;
        control.check()?;
        Ok(PaperOrbit { orbit: vibro_orbits::paper::orbit_of(&machine, &settled)?, set, passages: 1 })
    })
}

/// A branch of orbits along a parameter.
#[derive(IntoPyObject)]
pub struct BranchArrays<'py> {
    word: String,
    symmetric: bool,
    period: u32,
    closed: bool,
    value: Array1<'py, f64>,
    phases: Vec<Array1<'py, f64>>,
    multipliers: Array2<'py, Complex<f64>>,
    stable: Array1<'py, bool>,
    labels: Vec<&'static str>,
    maxima: Vec<Array1<'py, f64>>,
}

/// The branch of an orbit over a range of a parameter, in both directions, with local maxima of a
/// displacement in m.
#[pyfunction]
#[pyo3(signature = (orbit, name, ends, weights, progress = None))]
pub fn paper_follow<'py>(
    py: Python<'py>,
    orbit: &PaperOrbit,
    name: &str,
    ends: (f64, f64),
    weights: [f64; 3],
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<BranchArrays<'py>> {
    let name = find(name)?;
    let (set, word, phases) = (orbit.set.clone(), orbit.orbit.word().clone(), orbit.orbit.phases().to_vec());
    let span = Span::new(name, ends.0, ends.1).map_err(Failure::from)?;
    let value = name.value(&set);
    let (branch, maxima) = compute(py, progress, move |_| {
        let family = Family::new(&set, span)?;
        let found =
            vibro_orbits::paper::branch(&family, &word, &phases, value, &PathOptions::default(), &[])?;
        let maxima = maxima_of(&family, &found, weights)?;
        Ok((found, maxima))
    })?;
    branch_arrays(py, &branch, &maxima)
}

/// Local maxima of a displacement at each point of a branch, m.
fn maxima_of(family: &Family, found: &Branch, weights: [f64; 3]) -> Result<Vec<Vec<f64>>, Failure> {
    let mut maxima = found.maxima(family, weights);
    for (maxima, point) in maxima.iter_mut().zip(&found.points) {
        let gap = family.parameter_set(&[point.value])?.parameters().stop_gap;
        maxima.iter_mut().for_each(|x| *x *= gap);
    }
    Ok(maxima)
}

fn branch_arrays<'py>(py: Python<'py>, branch: &Branch, maxima: &[Vec<f64>]) -> PyResult<BranchArrays<'py>> {
    let points = &branch.points;
    let multipliers: Vec<Complex<f64>> = points.iter().flat_map(|p| p.multipliers.iter().copied()).collect();
    Ok(BranchArrays {
        word: branch.word().to_string(),
        symmetric: branch.word().closing() < 0,
        period: branch.word().period(),
        closed: branch.closed,
        value: column(py, &points.iter().map(|p| p.value).collect::<Vec<_>>()),
        phases: points.iter().map(|p| column(py, p.phases())).collect(),
        multipliers: plane(py, &multipliers, points.len(), 6)?,
        stable: column(py, &points.iter().map(|p| p.is_stable()).collect::<Vec<_>>()),
        labels: points.iter().map(|p| p.label().map_or("", |label| label.name())).collect(),
        maxima: maxima.iter().map(|m| column(py, m)).collect(),
    })
}

/// All branches of orbits over a range of a parameter, from the orbits on which motions settle,
/// and at most `depth` branch switches away from these.
#[pyfunction]
#[pyo3(signature = (system, name, ends, weights, seeds, depth, settle, starts, progress = None))]
#[allow(clippy::too_many_arguments)]
pub fn paper_branches<'py>(
    py: Python<'py>,
    system: &System,
    name: &str,
    ends: (f64, f64),
    weights: [f64; 3],
    seeds: usize,
    depth: u32,
    settle: u32,
    starts: usize,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Vec<BranchArrays<'py>>> {
    let span = Span::new(find(name)?, ends.0, ends.1).map_err(Failure::from)?;
    let set = system.set().map_err(Failure::from)?.clone();
    let options = TreeOptions { seeds, depth, settle, starts, ..TreeOptions::default() };
    let found = compute(py, progress, move |control| {
        let family = Family::new(&set, span)?;
        let told = |_: usize, waiting: usize| {
            control.add(1);
            control.expect(waiting);
        };
        let found = vibro_orbits::paper::tree(&family, &options, &told)?;
        let maxima = |branch: Branch| Ok((maxima_of(&family, &branch, weights)?, branch));
        found.branches.into_iter().map(maxima).collect::<Result<Vec<_>, Failure>>()
    })?;
    found.iter().map(|(maxima, branch)| branch_arrays(py, branch, maxima)).collect()
}
