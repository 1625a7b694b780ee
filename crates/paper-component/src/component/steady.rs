//! The steady states of the component: the `steady.*` variables, and the motions that the
//! closed-form modes play.

use super::problem::ComponentProblem;
use super::settings::{Derived, SolutionMode, Steady};
use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};
use vibro_impact::flow::Series;
use vibro_impact::model::{self, COORDINATES, DRIVE_COS, DRIVE_SIN, Impact, Model};
use vibro_impact::parameters::{GROUPS, Groups, Parameters};
use vibro_impact::simulator::State;
use vibro_impact::steady::exact_orbit::{ExactOrbit, OrbitFamily};
use vibro_impact::steady::multiple_scales::{FixedPoint, MultipleScales};
use vibro_impact::steady::{Roots, Sheet};

/// Orders of the displacements' derivatives, 0 to 5.
pub(crate) const ORDERS: usize = 6;

/// Values that follow from the parameters alone; every number is finite.
pub(crate) fn derived(parameters: &Parameters) -> Derived {
    Derived { groups: groups(parameters), steady: values(parameters) }
}

/// The dimensionless groups. If `box.k` is 0, the groups that it scales are 0. A value outside the
/// range of a double is set to the end of the range.
fn groups(parameters: &Parameters) -> Groups {
    let unscaled = Groups {
        epsilon: parameters.block_mass / parameters.box_mass,
        kappa: parameters.stop_restitution,
        mu13: parameters.box_mass / parameters.secondary_mass,
        ..Derived::default().groups
    };
    let mut groups = parameters.groups().unwrap_or(unscaled);
    for group in &GROUPS {
        let value = (group.get)(&groups);
        // A quotient is NaN if both its quantities are outside the range.
        (group.set)(&mut groups, if value.is_nan() { 0.0 } else { value.clamp(f64::MIN, f64::MAX) });
    }
    groups
}

/// The `steady.*` variables: multiple scales, with impulse and spectral radius of the exact orbit.
fn values(parameters: &Parameters) -> Steady {
    let mut steady = Steady::default();
    let scales = parameters.groups().and_then(|groups| MultipleScales::new(&groups));
    if let Some(point) = scales.ok().and_then(|scales| upper(&scales)) {
        steady.exists = true;
        steady.stable = point.admissibility.all();
        steady.phase = point.drive_phase;
        (steady.a1, steady.a2, steady.a3) = (point.a1(), point.a2(), point.a3);
    }
    let orbit = OrbitFamily::new(parameters).and_then(|family| family.orbit(Sheet::Upper));
    if let Ok(Some(orbit)) = orbit {
        let numbers = (orbit.impulse(), orbit.spectral_radius());
        if numbers.0.is_finite() && numbers.1.is_finite() {
            (steady.impulse, steady.spectral_radius) = numbers;
        }
    }
    steady
}

/// The upper fixed point, if the block moves in it and every amplitude is within the range of a
/// double.
fn upper(scales: &MultipleScales) -> Option<FixedPoint> {
    let finite = |point: &FixedPoint| {
        let numbers = [point.b, point.c, point.a3, point.drive_phase, point.a1(), point.a2()];
        numbers.iter().all(|number| number.is_finite())
    };
    scales.fixed_points().map(|Roots { upper, .. }| upper).filter(|point| point.c > 0.0 && finite(point))
}

/// A steady state to play.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant)] // what plays it is boxed as a whole
pub(crate) enum Solution {
    Scales { parameters: Parameters, point: FixedPoint },
    Orbit(Box<ExactOrbit>),
}

impl Solution {
    /// The steady state of a closed-form mode.
    ///
    /// # Errors
    /// [`ComponentProblem::ClosedForm`] with the range of existence if no steady state exists;
    /// [`ComponentProblem::Model`] if it is undefined.
    pub(crate) fn new(mode: SolutionMode, parameters: &Parameters) -> Result<Self, ComponentProblem> {
        if parameters.drive_frequency == 0.0 {
            return Err(ComponentProblem::value(
                "drive.frequency",
                0.0,
                "a finite number > 0 for a steady state",
            ));
        }
        match mode {
            SolutionMode::EventDriven | SolutionMode::ExactOrbit => exact(parameters),
            SolutionMode::MultipleScales => approximate(parameters),
        }
    }

    /// Description of the tests that the steady state fails; `None` if it passes all.
    pub(crate) fn objections(&self) -> Option<String> {
        let failed: Vec<_> = match self {
            Self::Scales { point, .. } => {
                let a = point.admissibility;
                [
                    (a.geometric, "the block passes through a stop"),
                    (a.fixed_point, "the slow flow leaves it"),
                    (a.periodic_motion, "the two-impact motion is unstable"),
                ]
                .into_iter()
                .filter_map(|(holds, test)| (!holds).then_some(test.to_owned()))
                .collect()
            }
            Self::Orbit(orbit) => {
                let radius = orbit.spectral_radius();
                let clear = (!orbit.is_clear()).then(|| "the block passes through a stop".to_owned());
                let stable =
                    (radius >= 1.0).then(|| format!("it is unstable (steady.spectralRadius = {radius})"));
                clear.into_iter().chain(stable).collect()
            }
        };
        (!failed.is_empty()).then(|| {
            format!(
                "the steady state exists, but would not be seen in the real system: {}",
                failed.join("; ")
            )
        })
    }

    /// Phase of the drive at the impact on the upper stop, rad; the lower stop follows half a
    /// period later.
    pub(crate) fn impact_phase(&self) -> f64 {
        match self {
            Self::Scales { point, .. } => point.drive_phase,
            Self::Orbit(orbit) => orbit.drive_phase(),
        }
    }

    /// Relative speed, impulse and lost energy, equal for all its impacts.
    pub(crate) fn impact(&self, model: &Model) -> Impact {
        let factors = model.impact_factors();
        let (speed, impulse) = match self {
            Self::Scales { parameters: p, point } => {
                // W' just before the upper impact, from the slope 2/π of the sawtooth and B cos Φ
                // = -ρ C.
                let rho = FRAC_2_PI * (1.0 - p.stop_restitution) / (1.0 + p.stop_restitution);
                let speed = p.stop_gap * p.drive_frequency * point.c * (FRAC_2_PI + rho);
                (speed, factors.impulse * speed)
            }
            Self::Orbit(orbit) => {
                let before = orbit.before_impact();
                (before.v[1] - before.v[0], orbit.impulse())
            }
        };
        Impact { speed, impulse, lost: factors.loss * speed * speed }
    }

    /// Calls `use_states` with a function that returns the state at a drive phase (rad), like
    /// [`state`](Self::state). For rising phases the total cost is one pass along the orbit.
    pub(crate) fn with_states<R>(&self, use_states: impl FnOnce(&mut dyn FnMut(f64) -> State) -> R) -> R {
        match self {
            Self::Scales { .. } => use_states(&mut |theta| self.state(theta)),
            Self::Orbit(orbit) => {
                let mut walk = orbit.walk();
                use_states(&mut |theta| walk.state(theta))
            }
        }
    }

    /// Displacements and velocities at drive phase `theta` (rad).
    pub(crate) fn state(&self, theta: f64) -> State {
        match self {
            Self::Scales { parameters, point } => {
                let motion = point.motion_at_drive(theta);
                let length = parameters.stop_gap;
                let speed = length * parameters.drive_frequency;
                State { x: motion.x.map(|x| length * x), v: motion.dx.map(|dx| speed * dx) }
            }
            Self::Orbit(orbit) => {
                let state = orbit.state(theta);
                State { x: state.x, v: state.v }
            }
        }
    }

    /// Time derivatives of the displacements at drive phase `theta`, with the motion in `state`;
    /// `[body][order]`.
    pub(crate) fn derivatives(&self, theta: f64, state: &State) -> [[f64; ORDERS]; 3] {
        let mut d: [[f64; ORDERS]; 3] =
            std::array::from_fn(|body| [state.x[body], state.v[body], 0.0, 0.0, 0.0, 0.0]);
        match self {
            Self::Scales { parameters: p, point } => {
                // The sawtooth is linear between impacts, so derivatives from the second order on
                // come from the sines.
                for (body, amplitude, lag) in [(0, point.b, point.psi), (2, point.a3, point.psi3)] {
                    let mut scale = p.stop_gap * amplitude * p.drive_frequency;
                    for (order, d) in d[body].iter_mut().enumerate().skip(2) {
                        scale *= p.drive_frequency;
                        *d = scale * (theta - lag + order as f64 * FRAC_PI_2).sin();
                    }
                }
            }
            Self::Orbit(orbit) => {
                // Between impacts the orbit follows the equations of motion.
                let Ok(model) = Model::new(orbit.parameters()) else { return d };
                let mut z = [0.0; COORDINATES];
                z[..6].copy_from_slice(&state.to_relative());
                (z[DRIVE_SIN], z[DRIVE_COS]) = theta.sin_cos();
                let series =
                    Series::<ORDERS>::expand(&model, model::SmoothMode::Flight, &z, None, 1.0 / model.rate);
                // The displacement of the orbit is kept.
                for (d, own) in d.iter_mut().zip(series.derivatives::<ORDERS>(model.rate)) {
                    d[1..].copy_from_slice(&own[1..]);
                }
            }
        }
        d
    }
}

fn approximate(parameters: &Parameters) -> Result<Solution, ComponentProblem> {
    let groups = parameters.groups()?;
    let scales = MultipleScales::new(&groups)?;
    if let Some(point) = upper(&scales) {
        return Ok(Solution::Scales { parameters: *parameters, point });
    }
    let from = scales.force_range()?.positive_from;
    let unit = parameters.box_stiffness * parameters.stop_gap * groups.epsilon;
    Err(ComponentProblem::ClosedForm {
        what: format!(
            "drive.amplitude = {} N: must be at least {} N for the steady state by multiple scales \
             (groups.f10 = {}, at least {from})",
            parameters.drive_amplitude,
            from * unit,
            groups.f10
        ),
    })
}

fn exact(parameters: &Parameters) -> Result<Solution, ComponentProblem> {
    let family = OrbitFamily::new(parameters)?;
    if let Some(orbit) = family.orbit(Sheet::Upper)? {
        return Ok(Solution::Orbit(Box::new(orbit)));
    }
    // The response of w to the force is proportional to the force. The range follows from the
    // force at which the quadratic has a root p > 0.
    let unit = OrbitFamily::new(&Parameters { drive_amplitude: 1.0, ..*parameters })?;
    let (a, b, c) = unit.quadratic();
    let response = (1.0 - c).max(0.0).sqrt();
    let needed = if b < 0.0 { (1.0 - b * b / (4.0 * a)).max(0.0).sqrt() } else { 1.0 };
    Err(ComponentProblem::ClosedForm {
        what: format!(
            "drive.amplitude = {} N: must be at least {} N for the exact two-impact orbit",
            parameters.drive_amplitude,
            needed / response
        ),
    })
}
