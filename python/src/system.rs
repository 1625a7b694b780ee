//! A machine's parameters and loads as Python objects. They are plain values: the Python classes around them add equality, text
//! and pickling.

use crate::arrays::{Column, column, numbers};
use crate::failure::{Failure, in_python};
use numpy::PyReadonlyArray1;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use vibro_analysis::{GROUPS, Name, ParameterSet};
use vibro_impact::Parameters;
use vibro_impact::load::{Body, Interpolation};
use vibro_impact::parameters::FIELDS;

/// The parameters of a machine, in SI and as groups.
#[pyclass(frozen, module = "vibro_impact._native")]
#[derive(Clone, Debug)]
pub struct System {
    set: ParameterSet,
}

impl System {
    /// The parameters by name.
    pub fn set(&self) -> &ParameterSet {
        &self.set
    }

    /// The physical parameters.
    pub fn parameters(&self) -> &Parameters {
        self.set.parameters()
    }
}

#[pymethods]
impl System {
    /// The default set with these values: first those in SI, then the groups, as in a parameter file.
    #[new]
    fn new(si: Vec<(String, f64)>, groups: Vec<(String, f64)>) -> PyResult<Self> {
        let mut set = ParameterSet::basic();
        for part in [si, groups] {
            let named: Vec<_> =
                part.iter().map(|(name, value)| Ok((find(name)?, *value))).collect::<PyResult<_>>()?;
            set.assign(&named).map_err(Failure::from)?;
        }
        Ok(Self { set })
    }

    /// The values of all parameters in the order of `parameters()`.
    fn values(&self) -> Vec<f64> {
        names().map(|name| name.value(&self.set)).collect()
    }

    /// The drive's period, s; infinite for a constant force.
    fn period(&self) -> f64 {
        self.parameters().period()
    }

    /// The state (m and m/s) at coordinates in units of L and L omega10.
    fn dimensional(&self, coordinates: [f64; 6]) -> [f64; 6] {
        let state = vibro_analysis::stroboscopic::dimensional(self.parameters(), &coordinates);
        let ([x1, x2, x3], [v1, v2, v3]) = (state.x, state.v);
        [x1, x2, x3, v1, v2, v3]
    }
}

/// All parameters: those in SI, then the groups.
fn names() -> impl Iterator<Item = Name> {
    FIELDS.iter().map(Name::Si).chain(GROUPS.iter().map(Name::Group))
}

/// A parameter by its name in Python, in the library, or its symbol in the paper.
pub fn find(name: &str) -> PyResult<Name> {
    let own = names().find(|own| in_python(own.name()) == name);
    let found = own.map_or_else(|| Name::find(name), Ok);
    found.map_err(|error| PyTypeError::new_err(in_python(&error.to_string())))
}

/// The name in Python of a parameter by any of its names.
#[pyfunction(name = "find")]
pub fn find_name(name: &str) -> PyResult<String> {
    Ok(in_python(find(name)?.name()))
}

/// Every parameter as (name in Python, unit, what it is, what is allowed), those in SI first; `si` of them.
#[pyfunction]
pub fn parameters() -> (usize, Vec<(String, &'static str, &'static str, String)>) {
    let told = |n: Name| (in_python(n.name()), n.unit(), n.description(), in_python(n.allowed()));
    (FIELDS.len(), names().map(told).collect())
}

/// A force history on one body.
#[pyclass(frozen, module = "vibro_impact._native")]
#[derive(Clone, Debug)]
pub struct Load {
    load: vibro_impact::load::Load,
}

impl Load {
    /// The library's load.
    pub fn load(&self) -> &vibro_impact::load::Load {
        &self.load
    }
}

#[pymethods]
impl Load {
    /// The interpolant of samples at times (s) of forces (N) on `box`, `block` or `secondary`.
    #[new]
    fn new(
        body: &str,
        t: PyReadonlyArray1<'_, f64>,
        force: PyReadonlyArray1<'_, f64>,
        cubic: bool,
    ) -> PyResult<Self> {
        let body = Body::ALL.into_iter().find(|b| b.name() == body).ok_or_else(|| {
            PyValueError::new_err(format!("body = {body:?}: allowed is 'box', 'block' or 'secondary'"))
        })?;
        let samples: Vec<(f64, f64)> = numbers(&t)?.into_iter().zip(numbers(&force)?).collect();
        let interpolation = if cubic { Interpolation::Cubic } else { Interpolation::Linear };
        let load = vibro_impact::load::Load::new(body, &samples, interpolation).map_err(Failure::from)?;
        Ok(Self { load })
    }

    /// The force (N) at times (s).
    fn at<'py>(&self, py: Python<'py>, t: PyReadonlyArray1<'_, f64>) -> PyResult<Column<'py, f64>> {
        let forces: Vec<f64> = numbers(&t)?.into_iter().map(|t| self.load.force(t)).collect();
        Ok(column(py, &forces))
    }
}
