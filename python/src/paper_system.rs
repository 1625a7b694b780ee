//! A machine's parameters and loads as Python objects. Both are plain values: the Python classes
//! around them add equality, text and pickling.

use crate::arrays::{Array1, column, numbers};
use crate::failure::{Failure, in_python};
use numpy::PyReadonlyArray1;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use vibro_impact::Parameters;
use vibro_impact::load::{Body, Interpolation};
use vibro_impact::parameters::{FIELDS, Field};
use vibro_studies::paper::{GROUPS, Name, ParameterSet, physical_parameters};

/// The parameters of a machine, in SI and as groups.
#[pyclass(frozen, module = "vibro_impact._native")]
#[derive(Clone, Debug)]
pub struct System {
    parameters: Parameters,
    /// `None` without a spring between box and ground, since time is scaled by ω10.
    set: Option<ParameterSet>,
    /// Physical parameters that were not given, if others were given.
    missing: Vec<Name>,
}

impl System {
    /// The parameters in both forms.
    ///
    /// # Errors
    /// [`vibro_impact::Error::Undefined`] without a spring between box and ground.
    pub fn set(&self) -> vibro_impact::Result<&ParameterSet> {
        match &self.set {
            Some(set) => Ok(set),
            None => Err(no_groups(&self.parameters)),
        }
    }

    /// The default set with these values: SI parameters first, then the groups.
    ///
    /// # Errors
    /// For values out of their range.
    pub fn of(si: &[(Name, f64)], groups: &[(Name, f64)]) -> Result<Self, Failure> {
        let free = physical(si)?;
        if free.box_stiffness == 0.0 && groups.is_empty() {
            let given = |field: &&'static Field| {
                field.name == "drive.phase" || si.iter().any(|(name, _)| *name == Name::Si(field))
            };
            let missing = FIELDS.iter().filter(|field| !given(field)).map(Name::Si).collect();
            return Ok(Self { parameters: free, set: None, missing });
        }
        let mut set = ParameterSet::basic();
        for part in [si, groups] {
            set.assign(part)?;
        }
        let missing = set.not_given();
        Ok(Self { parameters: *set.parameters(), set: Some(set), missing })
    }

    /// The physical parameters.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }
}

/// The reason why a machine has no groups.
fn no_groups(p: &Parameters) -> vibro_impact::Error {
    // Without the spring, `groups` returns an error. This function is not called for a machine
    // with the spring.
    p.groups().err().unwrap_or(vibro_impact::Error::Undefined {
        name: "box.k",
        value: p.box_stiffness,
        needed_by: "dimensionless form",
        allowed: "box.k > 0",
    })
}

/// The default machine with these values in SI.
fn physical(values: &[(Name, f64)]) -> vibro_impact::Result<Parameters> {
    let mut p = Parameters::default();
    for (name, value) in values {
        if let Name::Si(field) = name {
            field.check(*value)?;
            (field.set)(&mut p, *value);
        }
    }
    Ok(p)
}

#[pymethods]
impl System {
    /// The default set with these values: SI parameters first, then the groups, as in a parameter
    /// file.
    #[new]
    fn new(si: Vec<(String, f64)>, groups: Vec<(String, f64)>) -> PyResult<Self> {
        let named = |part: &[(String, f64)]| {
            part.iter().map(|(name, value)| Ok((find(name)?, *value))).collect::<PyResult<Vec<_>>>()
        };
        Ok(Self::of(&named(&si)?, &named(&groups)?)?)
    }

    /// The values of all parameters in the order of `parameters()`; only SI parameters if the
    /// machine has no groups.
    fn values(&self) -> Vec<f64> {
        let physical = physical_parameters().map(|field| (field.get)(&self.parameters));
        let groups = self.set.iter().flat_map(|set| GROUPS.iter().map(|group| (group.get)(set.groups())));
        physical.chain(groups).collect()
    }

    /// The physical parameters that were not given although others were, with their values from
    /// the default set.
    fn not_given(&self) -> Vec<(String, f64)> {
        let told = |name: &Name| match name {
            Name::Si(field) => Some((in_python(field.name), (field.get)(&self.parameters))),
            Name::Group(_) => None,
        };
        self.missing.iter().filter_map(told).collect()
    }

    /// The period of the drive, s; infinite for a constant force.
    fn period(&self) -> f64 {
        self.parameters().period()
    }

    /// The state (m and m/s) for coordinates in units of L and L omega10.
    fn dimensional(&self, coordinates: [f64; 6]) -> PyResult<[f64; 6]> {
        if coordinates[3..] != [0.0; 3] {
            self.set().map_err(Failure::from)?; // L ω10 is the unit of speeds
        }
        let state = vibro_studies::paper::stroboscopic::dimensional(self.parameters(), &coordinates);
        let ([x1, x2, x3], [v1, v2, v3]) = (state.x, state.v);
        Ok([x1, x2, x3, v1, v2, v3])
    }
}

/// All parameters: SI parameters first, then the groups.
fn names() -> impl Iterator<Item = Name> {
    physical_parameters().map(Name::Si).chain(GROUPS.iter().map(Name::Group))
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

/// The value in SI of a text that is a number, with or without a unit of a dimension, and whether
/// it has a unit.
#[pyfunction]
pub fn in_si(si: &str, text: &str) -> Option<(f64, bool)> {
    vibro_impact::quantities::quantity_in(si, text).map(|found| (found.value, found.unit.is_some()))
}

/// The number of SI parameters, and every parameter, SI first, as (name in Python, label of an
/// axis, unit, meaning, accepted values).
#[pyfunction]
#[allow(clippy::type_complexity)]
pub fn parameters() -> (usize, Vec<(String, String, &'static str, &'static str, String)>) {
    let told = |n: Name| (in_python(n.name()), n.label(), n.unit(), n.description(), in_python(n.allowed()));
    (physical_parameters().count(), names().map(told).collect())
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
            PyValueError::new_err(format!("body = {body:?}: expected 'box', 'block' or 'secondary'"))
        })?;
        let samples: Vec<(f64, f64)> = numbers(&t)?.into_iter().zip(numbers(&force)?).collect();
        let interpolation = if cubic { Interpolation::Cubic } else { Interpolation::Linear };
        let load = vibro_impact::load::Load::new(body, &samples, interpolation).map_err(Failure::from)?;
        Ok(Self { load })
    }

    /// The force (N) at times (s).
    fn at<'py>(&self, py: Python<'py>, t: PyReadonlyArray1<'_, f64>) -> PyResult<Array1<'py, f64>> {
        let forces: Vec<f64> = numbers(&t)?.into_iter().map(|t| self.load.force(t)).collect();
        Ok(column(py, &forces))
    }
}
