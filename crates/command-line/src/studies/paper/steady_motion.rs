//! The motion with two symmetric impacts by a theory, dimensionless (docs/theory.md (20)), over
//! the phase of the drive.

use std::f64::consts::{PI, TAU};
use vibro_impact::parameters::{Groups, Parameters};
use vibro_impact::steady::exact_orbit::{self, ExactOrbit};
use vibro_impact::steady::multiple_scales::{self, FixedPoint};
use vibro_impact::steady::strong_coupling::{self, StrongPoint};
use vibro_studies::paper::motion::Flight;

/// Samples per period of a curve.
const SAMPLES: usize = 240;
/// Phase between an impact and the sample before it, rad. It is far above rounding and far below a
/// pixel.
const JUST_BEFORE: f64 = 1e-7;

/// A motion at one time: displacements in units of L, velocities in units of L ω10, with U and W
/// (docs/theory.md (28)).
#[derive(Clone, Copy, Debug)]
pub struct MotionSample {
    /// Time in drive periods.
    pub time: f64,
    /// U = X1 + ε X2, W = X2 - X1, X1, X2, X3.
    pub x: [f64; 5],
    /// Their rates.
    pub v: [f64; 5],
}

/// The steady state that figures show: the upper root if it is admissible, otherwise the lower
/// root if it is admissible, otherwise the upper root.
#[derive(Clone, Copy, Debug)]
pub enum SteadyMotion {
    /// Multiple scales: paper, section 3.
    MultipleScales(FixedPoint),
    /// Strong coupling: paper, section 5.
    Strong(StrongPoint),
    /// The exact orbit of docs/theory.md section 9; not in the paper.
    Exact(ExactOrbit),
}

impl SteadyMotion {
    /// The steady state of multiple scales; `None` if it has no motion with impacts.
    ///
    /// # Errors
    /// As [`multiple_scales::fixed_points`].
    pub fn multiple_scales(groups: &Groups) -> vibro_impact::Result<Option<Self>> {
        let roots = multiple_scales::fixed_points(groups)?.map(|r| [r.upper, r.lower]);
        let positive = roots.into_iter().flatten().filter(|p| p.c > 0.0);
        Ok(best(positive, |p| p.admissibility.all()).map(Self::MultipleScales))
    }

    /// The steady state of strong coupling; `None` if there is none.
    ///
    /// # Errors
    /// As [`strong_coupling::solve`].
    pub fn strong(groups: &Groups) -> vibro_impact::Result<Option<Self>> {
        let roots = strong_coupling::solve(groups)?.map(|r| [r.upper, r.lower]);
        Ok(best(roots.into_iter().flatten(), |p| p.admissibility.all()).map(Self::Strong))
    }

    /// The exact orbit; `None` if there is none.
    ///
    /// # Errors
    /// As [`exact_orbit::solve`].
    pub fn exact(parameters: &Parameters) -> vibro_impact::Result<Option<Self>> {
        let roots = exact_orbit::solve(parameters)?;
        let orbits = [roots.upper, roots.lower].into_iter().flatten();
        Ok(best(orbits, ExactOrbit::is_stable).map(Self::Exact))
    }

    /// Whether the motion is stable and admissible.
    pub fn is_stable(&self) -> bool {
        match self {
            Self::MultipleScales(p) => p.admissibility.all(),
            Self::Strong(p) => p.admissibility.all(),
            Self::Exact(o) => o.is_stable(),
        }
    }

    /// Phase of the drive at the upper impact, rad.
    fn impact(&self) -> f64 {
        match self {
            Self::MultipleScales(p) => p.drive_phase,
            Self::Strong(p) => p.drive_phase,
            Self::Exact(o) => o.drive_phase(),
        }
    }

    /// B, A1, A2, A3 in units of L.
    pub fn amplitudes(&self, parameters: &Parameters) -> [f64; 4] {
        match self {
            Self::MultipleScales(p) => [p.b, p.a1(), p.a2(), p.a3],
            Self::Strong(p) => [p.b, p.a1(), p.a2(), p.a3],
            Self::Exact(o) => {
                let gap = parameters.stop_gap;
                let b = o.amplitude_of([1.0, parameters.block_mass / parameters.box_mass, 0.0]);
                let [a1, a2, a3] = o.amplitudes();
                [b, a1, a2, a3].map(|a| a / gap)
            }
        }
    }

    /// The motion over some drive periods from phase 0, with a sample on either side of each
    /// impact.
    pub fn history(&self, parameters: &Parameters, periods: f64) -> Vec<MotionSample> {
        let count = (SAMPLES as f64 * periods).ceil() as usize;
        let mut phases: Vec<f64> = (0..=count).map(|i| TAU * periods * i as f64 / count as f64).collect();
        let first = self.impact().rem_euclid(PI);
        let impacts = (0..).map(|j| first + PI * f64::from(j)).take_while(|p| *p < TAU * periods);
        phases.extend(impacts.flat_map(|p| [p - JUST_BEFORE, p]));
        phases.sort_by(f64::total_cmp);
        phases.into_iter().map(|phase| self.at(parameters, phase)).collect()
    }

    fn at(&self, parameters: &Parameters, phase: f64) -> MotionSample {
        let p = parameters;
        let rate = p.drive_frequency / p.box_frequency();
        let motion = match self {
            Self::MultipleScales(m) => m.motion_at_drive(phase),
            Self::Strong(m) => m.motion_at_drive(phase),
            Self::Exact(o) => {
                let s = o.state(phase);
                return point(p, phase / TAU, &s.x, &s.v);
            }
        };
        let [x1, x2, x3] = motion.x;
        let [v1, v2, v3] = motion.dx.map(|v| rate * v);
        MotionSample {
            time: phase / TAU,
            x: [motion.u, motion.w, x1, x2, x3],
            v: [rate * motion.du, rate * motion.dw, v1, v2, v3],
        }
    }
}

fn best<T: Copy>(candidates: impl Iterator<Item = T>, stable: impl Fn(&T) -> bool) -> Option<T> {
    let all: Vec<T> = candidates.collect();
    all.iter().find(|c| stable(c)).or(all.first()).copied()
}

fn point(p: &Parameters, time: f64, x: &[f64; 3], v: &[f64; 3]) -> MotionSample {
    let (length, epsilon) = (p.stop_gap, p.block_mass / p.box_mass);
    let speed = length * p.box_frequency();
    let five = |a: &[f64; 3], unit: f64| {
        [a[0] + epsilon * a[1], a[1] - a[0], a[0], a[1], a[2]].map(|value| value / unit)
    };
    MotionSample { time, x: five(x, length), v: five(v, speed) }
}

/// A simulated record as samples; its time is shifted by less than a period so that whole numbers
/// have phase 0.
pub fn simulated(flights: &[Flight], parameters: &Parameters) -> Vec<MotionSample> {
    let begin = flights.first().and_then(|f| f.first()).map_or(0.0, |i| i.phase / TAU);
    let instants = flights.iter().flatten();
    let time = |t: f64| t + begin - begin.round();
    instants.map(|i| point(parameters, time(i.time), &i.state.x, &i.state.v)).collect()
}
