//! Searches for the best design of described machines.

use crate::arrays::{Array1, Array2, column, plane};
use crate::background::{self, search_with_best};
use crate::failure::Failure;
use crate::machine::{Described, Numbers, SectionChoice};
use pyo3::prelude::*;
use vibro_design::{Attractor, Best, Control, DesignRequest, Designed, Goal, Limit, Value, design as search};
use vibro_studies::design_sweep::{ParameterInterval, SampledAxis};

/// Parts into which the longest course of a search is divided for a progress bar.
const PARTS: f64 = 1000.0;

/// A value with the ends of its error bar.
type Bar = (f64, f64, f64);

fn bar(own: &Value) -> Bar {
    (own.value, own.bar.0, own.bar.1)
}

/// A motion of the best design.
#[derive(Clone, IntoPyObject)]
struct AttractorParts {
    kind: String,
    contacts: f64,
    goal: Bar,
    starts: usize,
    start: Numbers,
    requested: bool,
    worse: bool,
}

impl From<&Attractor> for AttractorParts {
    fn from(own: &Attractor) -> Self {
        Self {
            kind: own.class.name(),
            contacts: own.impacts,
            goal: bar(&own.goal),
            starts: own.starts,
            start: own.start.numbers(),
            requested: own.is_requested,
            worse: own.is_worse,
        }
    }
}

/// The best design.
#[derive(Clone, IntoPyObject)]
struct BestParts {
    values: Vec<f64>,
    goal: Bar,
    exact: bool,
    place: String,
    at_ends: Vec<String>,
    limits: Vec<(Option<Bar>, &'static str)>,
    attractors: Vec<AttractorParts>,
}

impl From<&Best> for BestParts {
    fn from(own: &Best) -> Self {
        let limit =
            |(value, check): &(Option<Value>, vibro_design::Check)| (value.as_ref().map(bar), check.name());
        Self {
            values: own.values.clone(),
            goal: bar(&own.goal),
            exact: own.goal.is_exact,
            place: own.place.clone(),
            at_ends: own.at_ends.clone(),
            limits: own.limits.iter().map(limit).collect(),
            attractors: own.attractors.iter().map(AttractorParts::from).collect(),
        }
    }
}

/// A search as it is given to Python; all numbers in SI.
#[derive(IntoPyObject)]
pub struct DesignParts<'py> {
    verdict: String,
    best: Option<BestParts>,
    rivals: Vec<(Vec<f64>, Bar, bool)>,
    stages: Vec<&'static str>,
    values: Array2<'py, f64>,
    goals: Array1<'py, f64>,
    within_limits: Array1<'py, bool>,
    gradients: bool,
}

fn parts<'py>(py: Python<'py>, found: &Designed, numbers: usize) -> PyResult<DesignParts<'py>> {
    let all = &found.evaluations;
    let values: Vec<f64> = all.iter().flat_map(|own| own.values.iter().copied()).collect();
    let goals: Vec<f64> = all.iter().map(|own| own.goal.map_or(f64::NAN, |goal| goal.value)).collect();
    let within: Vec<bool> = all.iter().map(vibro_design::Evaluation::is_feasible).collect();
    Ok(DesignParts {
        verdict: found.verdict.to_string(),
        best: found.best.as_ref().map(BestParts::from),
        rivals: found
            .rivals
            .iter()
            .map(|own| (own.values.clone(), bar(&own.goal), own.is_told_apart))
            .collect(),
        stages: all.iter().map(|own| own.stage.name()).collect(),
        values: plane(py, &values, all.len(), numbers)?,
        goals: column(py, &goals),
        within_limits: column(py, &within),
        gradients: found.has_gradients,
    })
}

/// The design of a machine with the best output; `over` has names, values, and whether the values
/// sample an interval.
#[pyfunction]
#[pyo3(signature = (machine, output, maximize, vary, over, subject_to, robust, evaluations, windows, starts, section, progress = None))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of the package")]
pub fn design<'py>(
    py: Python<'py>,
    machine: &Described,
    output: &str,
    maximize: bool,
    vary: Vec<(String, f64, f64)>,
    over: Vec<(String, Vec<f64>, bool)>,
    subject_to: Vec<String>,
    robust: f64,
    evaluations: u32,
    windows: (u32, u32, u64),
    starts: Vec<Numbers>,
    section: Option<SectionChoice>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<DesignParts<'py>> {
    let own = machine.machine(section);
    let goal = Goal { measure: output.parse().map_err(Failure::from)?, maximize };
    let intervals = vary.into_iter().map(|(name, from, to)| ParameterInterval { name, from, to }).collect();
    let limit = |text: &String| Limit::read(text, &own).map_err(Failure::from);
    let limits = subject_to.iter().map(limit).collect::<Result<Vec<_>, _>>()?;
    let starts = starts.iter().map(|start| machine.start_of(start)).collect::<Result<Vec<_>, _>>()?;
    let request = DesignRequest {
        between: over.iter().filter(|own| own.2).map(|own| own.0.clone()).collect(),
        over: over.into_iter().map(|(name, values, _)| SampledAxis { name, values }).collect(),
        limits,
        robust,
        starts,
        discard: windows.0,
        periods: windows.1,
        again: windows.2,
        evaluations,
        ..DesignRequest::new(own, goal, intervals)
    };
    let numbers = request.vary.len();
    let work = move |control: &background::Control| {
        let watched = Control {
            go_on: &|| !control.is_cancelled(),
            progress: &|now| {
                control.at((PARTS * now.part) as usize, PARTS as usize, now.to_string());
            },
        };
        Ok(background::pool()?.install(|| search(&request, &watched))?)
    };
    search_with_best(py, progress, work, |found| parts(py, &found, numbers))
}
