//! Steady states in closed form: the symmetric motion with two impacts a drive period by three
//! theories.

use crate::arrays::{Array1, Array2, column, numbers, states};
use crate::failure::{Failure, in_python};
use crate::paper_system::System;
use nalgebra::Complex;
use numpy::PyReadonlyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use vibro_impact::State;
use vibro_impact::steady::exact_orbit::{self, ExactOrbit};
use vibro_impact::steady::multiple_scales::{self, FixedPoint};
use vibro_impact::steady::strong_coupling::{self, StrongPoint};
use vibro_impact::steady::{Admissibility, Bifurcation, Sheet, SteadyMotion};
use vibro_studies::paper::ParameterSet;

/// The steady state of one theory.
enum Theory {
    MultipleScales(FixedPoint),
    StrongCoupling(Box<StrongPoint>),
    ExactOrbit(Box<ExactOrbit>),
}

/// A steady state as Python has it.
#[derive(IntoPyObject)]
pub struct Closed<'py> {
    amplitudes: Array1<'py, f64>,
    drive_phase: f64,
    geometric: bool,
    fixed_point: bool,
    periodic_motion: bool,
    eigenvalues: Array1<'py, Complex<f64>>,
    multipliers: Array1<'py, Complex<f64>>,
    bifurcation: &'static str,
}

fn sheet(upper: bool) -> Sheet {
    if upper { Sheet::Upper } else { Sheet::Lower }
}

/// The state of a theory on a sheet; `None` if it has none.
fn solve(system: &System, theory: &str, sheet: Sheet) -> vibro_impact::Result<Option<Theory>> {
    system.parameters().check_symmetric()?;
    let groups = || system.set().map(ParameterSet::groups);
    Ok(match theory {
        "multiple_scales" => {
            multiple_scales::fixed_points(groups()?)?.map(|r| Theory::MultipleScales(r.get(sheet)))
        }
        "strong_coupling" => {
            strong_coupling::solve(groups()?)?.map(|r| Theory::StrongCoupling(Box::new(r.get(sheet))))
        }
        _ => exact_orbit::solve(system.parameters())?
            .get(sheet)
            .map(|orbit| Theory::ExactOrbit(Box::new(orbit))),
    })
}

fn name(bifurcation: Bifurcation) -> &'static str {
    match bifurcation {
        Bifurcation::SaddleNode => "saddle node",
        Bifurcation::SymmetryBreaking => "symmetry breaking",
        Bifurcation::PeriodDoubling => "period doubling",
        Bifurcation::NeimarkSacker => "Neimark-Sacker",
        _ => "other",
    }
}

impl Theory {
    /// Result for Python, lengths in m.
    fn closed<'py>(&self, py: Python<'py>, gap: f64) -> Closed<'py> {
        let make = |amplitudes: [f64; 3], drive_phase, tests: Admissibility, bifurcation| {
            move |eigenvalues: &[Complex<f64>], multipliers: &[Complex<f64>]| Closed {
                amplitudes: column(py, &amplitudes),
                drive_phase,
                geometric: tests.geometric,
                fixed_point: tests.fixed_point,
                periodic_motion: tests.periodic_motion,
                eigenvalues: column(py, eigenvalues),
                multipliers: column(py, multipliers),
                bifurcation: name(bifurcation),
            }
        };
        match self {
            Self::MultipleScales(s) => {
                let amplitudes = [s.a1(), s.a2(), s.a3].map(|a| a * gap);
                make(amplitudes, s.drive_phase, s.admissibility, s.bifurcation())(
                    &s.eigenvalues,
                    &s.multipliers,
                )
            }
            Self::StrongCoupling(s) => {
                let amplitudes = [s.a1(), s.a2(), s.a3].map(|a| a * gap);
                make(amplitudes, s.drive_phase, s.admissibility, s.bifurcation())(
                    &s.eigenvalues,
                    &s.multipliers,
                )
            }
            Self::ExactOrbit(orbit) => {
                let tests = Admissibility {
                    geometric: orbit.is_clear(),
                    fixed_point: true, // the exact orbit has no slow flow
                    periodic_motion: orbit.spectral_radius() < 1.0,
                };
                let (amplitudes, phase) = (orbit.amplitudes(), orbit.drive_phase());
                make(amplitudes, phase, tests, orbit.bifurcation())(&[], &orbit.multipliers())
            }
        }
    }

    /// The state at a phase of the drive, rad.
    fn state(&self, gap: f64, frequency: f64, theta: f64) -> State {
        let si = |m: SteadyMotion| State { x: m.x.map(|x| x * gap), v: m.dx.map(|dx| dx * gap * frequency) };
        match self {
            Self::MultipleScales(s) => si(s.motion_at_drive(theta)),
            Self::StrongCoupling(s) => si(s.motion_at_drive(theta)),
            Self::ExactOrbit(orbit) => orbit.state(theta),
        }
    }
}

/// The steady state of a theory, or the reason why there is none.
#[pyfunction]
pub fn paper_steady<'py>(
    py: Python<'py>,
    system: &System,
    theory: &str,
    upper: bool,
) -> (Option<Closed<'py>>, Option<String>) {
    match solve(system, theory, sheet(upper)) {
        Ok(Some(found)) => (Some(found.closed(py, system.parameters().stop_gap)), None),
        Ok(None) => (None, Some("no symmetric motion with two impacts a period".into())),
        Err(error) => (None, Some(in_python(&error.to_string()))),
    }
}

/// Displacements (m) and velocities (m/s) of the steady state of a theory at phases of the drive,
/// rad.
#[pyfunction]
#[allow(clippy::type_complexity)]
pub fn paper_steady_motion<'py>(
    py: Python<'py>,
    system: &System,
    theory: &str,
    upper: bool,
    theta: PyReadonlyArray1<'_, f64>,
) -> PyResult<(Array2<'py, f64>, Array2<'py, f64>)> {
    let found = solve(system, theory, sheet(upper)).map_err(Failure::from)?;
    let found =
        found.ok_or_else(|| PyValueError::new_err("no symmetric motion with two impacts a period"))?;
    let p = system.parameters();
    let at = |theta: &f64| found.state(p.stop_gap, p.drive_frequency, *theta);
    states(py, &numbers(&theta)?.iter().map(at).collect::<Vec<_>>())
}
