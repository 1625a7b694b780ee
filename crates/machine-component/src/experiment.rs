//! The default experiment: a stop time of many periods of the slowest motion, and a step size that
//! resolves the fastest motion.

use fmi_doors::description::Experiment;
use std::f64::consts::{PI, TAU};
use vibro_machine::Assembly;
use vibro_machine::description::{BodyKind, Signal};
use vibro_machine::mode::StopState;
use vibro_machine::system::StopRows;

/// Length of the run, in units of the longest period (natural, harmonic, swept or of a repeated
/// signal).
const PERIODS: f64 = 20.0;
/// Number of steps in the shortest period or contact time, within the limits [`STEPS`].
const PARTS: f64 = 10.0;
/// Length of the run of a machine without periods, contacts and flights, s.
const DURATION: f64 = 10.0;
/// Limits of the number of steps (4096 if a power of two is needed), because a host's result has a
/// row for each step.
const STEPS: [f64; 2] = [1000.0, 4000.0];
/// A squared natural frequency below this fraction of the highest squared one counts as zero.
const NONE: f64 = 1e-12;

/// Returns the default experiment of a machine.
pub fn experiment(assembly: &Assembly) -> Experiment {
    let machine = &assembly.description;
    let own = own_periods(assembly);
    let driven = machine.signals().flat_map(|of| {
        let harmonics = of.signal.harmonics.iter().map(|h| 1.0 / h.frequency);
        let swept = of.signal.sweeps.iter().flat_map(|sweep| [1.0 / sweep.from, 1.0 / sweep.to]);
        harmonics.chain(of.signal.repeat).chain(swept).collect::<Vec<_>>()
    });
    let periods: Vec<f64> = own.into_iter().chain(driven).filter(|period| is_time(*period)).collect();
    let contacts: Vec<f64> = contact_times(assembly).filter(|time| is_time(*time)).collect();
    let longest = |times: &[f64]| times.iter().copied().reduce(f64::max);
    // A machine without periods moves from contact to contact.
    let flights: Vec<f64> = flights(assembly).filter(|time| is_time(*time)).collect();
    let slowest = longest(&periods).or(longest(&[&contacts[..], &flights[..]].concat()));
    let knots = machine.signals().filter_map(|of| last_knot(of.signal)).fold(0.0, f64::max);
    let stop_time = rounded(slowest.map_or(DURATION, |slowest| PERIODS * slowest).max(knots));
    let fastest = periods.iter().chain(&contacts).copied().fold(f64::INFINITY, f64::min);
    let steps = (PARTS * stop_time / fastest).clamp(STEPS[0], STEPS[1]);
    let steps = 1000.0 * (steps / 1000.0).log2().ceil().exp2();
    // Some importers require stop time over step size to be a whole number in floating point.
    let divides = |step: &f64| (stop_time / step).fract() == 0.0;
    let step_size = Some(stop_time / steps).filter(divides).unwrap_or(stop_time / steps.log2().ceil().exp2());
    Experiment { start_time: 0.0, stop_time, tolerance: 1e-6, step_size }
}

/// Whether a duration is positive and [`PERIODS`] times it is finite.
fn is_time(time: f64) -> bool {
    time.is_normal() && time > 0.0 && time < f64::MAX / PERIODS
}

/// Returns the smallest number with two significant digits that is not below `time`.
fn rounded(time: f64) -> f64 {
    // A number that has two digits already must not grow by its rounding.
    const ROUNDING: f64 = 1e-12;
    let text = format!("{:e}", time * (1.0 - ROUNDING));
    let exponent: i32 = text.split('e').nth(1).and_then(|exponent| exponent.parse().ok()).unwrap_or_default();
    let digits = (time * (1.0 - ROUNDING) / 10.0f64.powi(exponent - 1)).ceil();
    format!("{digits}e{}", exponent - 1).parse().unwrap_or(time)
}

/// Returns the time of a signal's last sweep end, step or knot that does not repeat, s.
fn last_knot(signal: &Signal) -> Option<f64> {
    let sweeps = signal.sweeps.iter().map(|sweep| sweep.duration).reduce(f64::max);
    if signal.repeat.is_some() {
        return sweeps;
    }
    let steps = signal.steps.last().map(|step| step.time);
    let knots = signal.table.as_ref().and_then(|table| Some(table.knots.last()?.0));
    [sweeps, steps, knots].into_iter().flatten().reduce(f64::max)
}

/// Returns the undamped natural periods of the machine on its springs alone, s.
fn own_periods(assembly: &Assembly) -> Vec<f64> {
    let system = assembly.system();
    let (n, factor) = (system.coordinates, system.inertia.l());
    // L⁻¹ K L⁻ᵀ, where the forces of springs are -K q.
    let mut stiffness = -system.forces.columns(0, n).into_owned();
    // A stepped stiffness counts at its first level.
    for level in system.stops.iter().filter(|own| own.is_gapless() && own.state_apart() == StopState::Pressed)
    {
        stiffness.ger(level.stiffness(), &level.elongation.w, &level.elongation.w, 1.0);
    }
    let half = factor.solve_lower_triangular(&stiffness);
    let squares = half.and_then(|half| factor.solve_lower_triangular(&half.transpose()));
    let Some(squares) = squares.filter(|squares| n > 0 && squares.iter().all(|x| x.is_finite())) else {
        return Vec::new();
    };
    let squares = squares.symmetric_eigenvalues();
    let highest = squares.amax();
    squares.iter().filter(|square| **square > NONE * highest).map(|square| TAU / square.sqrt()).collect()
}

/// Returns the contact time of each compliant stop, s, from its stiffness without damping.
fn contact_times(assembly: &Assembly) -> impl Iterator<Item = f64> {
    let time = |stop: &StopRows| PI / (stop.stiffness() * stop.elongation.column.norm_squared()).sqrt();
    let system = assembly.system();
    let stops = system.stops.iter().enumerate().filter(|(i, _)| !system.is_corner(*i));
    stops.map(|(_, stop)| stop).filter(|stop| stop.restitution().is_none()).map(time)
}

/// Returns the time that each stop's elongation takes from the start to its gap at constant
/// acceleration, s; NaN if it does not reach the gap.
fn flights(assembly: &Assembly) -> impl Iterator<Item = f64> {
    let (machine, system) = (&assembly.description, assembly.system());
    let mut z = 0.0 * system.forces.row(0).transpose();
    for (k, &body) in system.bodies_of.iter().enumerate() {
        if let BodyKind::Free(free) = machine.bodies[body].kind {
            (z[k], z[system.coordinates + k]) = (free.s, free.v);
        }
    }
    z[system.signals.one] = 1.0;
    let a = system.inertia.solve(&system.forces.times(&z));
    let flight = |stop: &StopRows| {
        let (left, rate, bend) =
            (-stop.excess.at(z.as_slice()), stop.elongation.rate.at(z.as_slice()), stop.elongation.w.dot(&a));
        // The first positive root of left = rate t + bend t²/2.
        2.0 * left / (rate + (rate * rate + 2.0 * bend * left).sqrt())
    };
    system.stops.iter().filter(|stop| !stop.is_freewheel).map(flight).collect::<Vec<_>>().into_iter()
}
