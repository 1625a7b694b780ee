//! Fits of described machines to records.

use crate::arrays::{Array1, column};
use crate::background::{Control, search_with_best};
use crate::failure::Failure;
use crate::machine::{Described, Numbers};
use numpy::PyReadonlyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::collections::HashMap;
use vibro_machine::table::Table;
use vibro_studies::QuantityName;
use vibro_studies::fit::{
    Filter, FitRequest, Fitted, Free, Loss, Measured, Misfit, Progress, Segments, misfit,
};

/// Parts into which the longest course of a fit is divided for a progress bar.
const PARTS: u32 = 1000;

/// A fit as it is given to Python; all numbers in SI.
#[derive(IntoPyObject)]
pub struct FitParts<'py> {
    verdict: String,
    machine: String,
    start: Numbers,
    values: Vec<f64>,
    errors: Vec<Option<f64>>,
    white_errors: Vec<Option<f64>>,
    correlation: Vec<Vec<f64>>,
    undetermined: Vec<(Vec<(String, f64)>, f64)>,
    rms: Vec<(String, f64)>,
    residuals: Vec<Array1<'py, f64>>,
    contacts: Vec<(String, Vec<f64>)>,
    simulations: u32,
    near_until: f64,
    persistence: f64,
    segments: Vec<(f64, Numbers, Vec<f64>)>,
    lost: Vec<String>,
    at_bounds: Numbers,
    places: Vec<String>,
    suspects: Vec<(String, f64, f64, f64)>,
    unexplained: Option<String>,
}

/// A fit with its diagnosis, or with the error of the diagnosis.
type Explained = (Fitted, Result<Misfit, String>);

fn parts<'py>(py: Python<'py>, (fitted, explained): &Explained, columns: usize) -> FitParts<'py> {
    let own = &fitted.uncertainty;
    let misfit = explained.clone().unwrap_or_default();
    let residual = |k: usize| -> Vec<f64> { fitted.residuals.iter().map(|row| row[k]).collect() };
    FitParts {
        verdict: fitted.verdict.to_string(),
        machine: fitted.machine.description.to_toml(),
        start: fitted.start.numbers(),
        values: fitted.values.iter().map(|(_, value)| *value).collect(),
        errors: own.errors.clone(),
        white_errors: own.white.clone(),
        correlation: own.correlation.row_iter().map(|row| row.iter().copied().collect()).collect(),
        undetermined: own.undetermined.iter().map(|u| (u.combination.clone(), u.singular_value)).collect(),
        rms: fitted.rms.clone(),
        residuals: (0..columns).map(|k| column(py, &residual(k))).collect(),
        contacts: fitted.contacts.clone(),
        simulations: fitted.simulations,
        near_until: fitted.near_until,
        persistence: own.persistence,
        segments: fitted.segments.iter().map(|f| (f.time, f.state.clone(), f.defect.clone())).collect(),
        lost: fitted.lost.clone(),
        at_bounds: fitted.at_bounds.clone(),
        places: misfit.places.iter().map(ToString::to_string).collect(),
        suspects: misfit.suspects.iter().map(|s| (s.name.clone(), s.value, s.better, s.left)).collect(),
        unexplained: explained.as_ref().err().cloned(),
    }
}

/// The columns of a table with a heading, in SI; `names` has other names of the machine's columns.
#[pyfunction]
pub fn columns_of_table(
    machine: &Described,
    text: &str,
    names: HashMap<String, String>,
) -> PyResult<Vec<(String, Vec<f64>)>> {
    let unit = |name: &str| match name {
        "time" => Some("s"),
        name => {
            let own: QuantityName = names.get(name).map_or(name, |own| own).parse().ok()?;
            Some(own.find(&machine.description).ok()?.unit)
        }
    };
    Table::read(text).columns(&unit).map_err(PyValueError::new_err)
}

/// A record as Python gives it: machine, start, times, columns, contacts by stop, and standard
/// deviations.
type Record<'py> = (
    PyRef<'py, Described>,
    Numbers,
    PyReadonlyArray1<'py, f64>,
    Vec<(String, PyReadonlyArray1<'py, f64>)>,
    Vec<(String, Vec<f64>)>,
    Option<Vec<f64>>,
);

/// A free parameter as Python gives it: name, range, and whether each record has its own.
type FreeNumber = (String, Option<(f64, f64)>, bool);

/// Fits numbers of machines to records, one machine for each record. A free number has a name, a
/// range, and whether each record has it for itself.
#[pyfunction]
#[pyo3(signature = (records, free, filters, loss, segments, starts, progress = None))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of the package")]
pub fn fit<'py>(
    py: Python<'py>,
    records: Vec<Record<'py>>,
    free: Vec<FreeNumber>,
    filters: Vec<(String, u32, f64)>,
    loss: &str,
    segments: Option<f64>,
    starts: u32,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Vec<FitParts<'py>>> {
    let filter = |(column, order, frequency): (String, u32, f64)| {
        PyResult::Ok(Filter { column: column.parse().map_err(Failure::from)?, order, frequency })
    };
    let filters: Vec<Filter> = filters.into_iter().map(filter).collect::<PyResult<_>>()?;
    let free: Vec<Free> =
        free.into_iter().map(|(name, within, is_own)| Free { name, within, is_own }).collect();
    // A filter is for the records that have its column.
    let of_all: Vec<String> =
        records.iter().flat_map(|own| own.3.iter().map(|(name, _)| name.clone())).collect();
    let request = |(machine, start, times, columns, contacts, sigma): Record| {
        let has = |own: &&Filter| {
            let name = own.column.to_string();
            columns.iter().any(|(own, _)| *own == name) || !of_all.contains(&name)
        };
        let column = |(name, values): &(String, PyReadonlyArray1<'_, f64>)| {
            let name = name.parse().map_err(Failure::from)?;
            PyResult::Ok((name, values.as_slice()?.to_vec()))
        };
        PyResult::Ok(FitRequest {
            name: String::new(),
            start: machine.start_of(&start)?,
            machine: machine.machine(None),
            measured: Measured {
                times: times.as_slice()?.to_vec(),
                columns: columns.iter().map(column).collect::<PyResult<_>>()?,
                contacts,
            },
            free: free.clone(),
            sigma,
            filters: filters.iter().filter(has).cloned().collect(),
            loss: match loss {
                "soft_l1" => Loss::SoftL1,
                "huber" => Loss::Huber,
                _ => Loss::Linear,
            },
            // No length is `auto`, and 0 one motion.
            segments: match segments {
                None => Segments::Auto,
                Some(0.0) => Segments::None,
                Some(length) => Segments::Length(length),
            },
            starts,
        })
    };
    let requests: Vec<FitRequest> = records.into_iter().map(request).collect::<PyResult<_>>()?;
    let counts: Vec<usize> = requests.iter().map(|own| own.measured.columns.len()).collect();
    let work = move |control: &Control| {
        let all = vibro_studies::fit::fit_records(&requests, &|now| {
            control.at((f64::from(PARTS) * now.part) as usize, PARTS as usize, in_words(now))
        })?;
        let goes_on = || !control.is_cancelled();
        let explained = |(request, fitted): (&FitRequest, &Fitted)| match goes_on() {
            true => misfit(request, fitted, &goes_on).map_err(|error| error.to_string()),
            false => Ok(Misfit::default()),
        };
        let misfits: Vec<_> = requests.iter().zip(&all).map(explained).collect();
        Ok(all.into_iter().zip(misfits).collect())
    };
    let made = |all: Vec<Explained>| {
        let one = |(found, count): (&Explained, &usize)| parts(py, found, *count);
        Ok(all.iter().zip(&counts).map(one).collect::<Vec<_>>())
    };
    search_with_best(py, progress, work, made)
}

/// Costs and number of simulations of a fit, with its stage.
fn in_words(now: &Progress) -> String {
    let best = now.best.map_or(String::new(), |best| format!(", best cost {best:.4e}"));
    format!("{}{best}, {} simulations", now.stage, now.simulations)
}
