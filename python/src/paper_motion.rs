//! Motions: sampled with their events, many at once, and as sections.

use crate::arrays::{Array1, Array2, column, numbers, state, states, table};
use crate::background::{Control, compute, pool, with_partial};
use crate::designs::{GivenStarts, GivenSystems, Starts, Systems};
use crate::failure::Failure;
use crate::paper_system::{Load, System};
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use std::f64::consts::TAU;
use std::sync::{Arc, Mutex, PoisonError};
use vibro_impact::simulator::{AdvanceOutcome, Event, Pause};
use vibro_impact::{Parameters, Simulator, State, load};
use vibro_studies::paper::trajectories::{Start, propagate};

/// Drive periods of one call to the library per thread: half a second's work between checks for
/// cancellation. Shorter calls cost more, because each ends with empty lanes of the vectors.
const PERIODS_A_THREAD: usize = 400_000;
/// Smallest and largest number of motions per thread in one call; the smallest fills the vectors.
const MOTIONS_A_THREAD: std::ops::RangeInclusive<usize> = 64..=4096;

/// Impacts in order of time, an array for each quantity.
#[derive(IntoPyObject)]
struct Impacts<'py> {
    t: Array1<'py, f64>,
    stop: Array1<'py, i8>,
    speed: Array1<'py, f64>,
    impulse: Array1<'py, f64>,
}

/// Captures or releases in order of time.
#[derive(IntoPyObject)]
struct ContactTimes<'py> {
    t: Array1<'py, f64>,
    stop: Array1<'py, i8>,
}

/// A sampled motion with its events.
#[derive(IntoPyObject)]
pub struct SampledMotion<'py> {
    s: Array2<'py, f64>,
    v: Array2<'py, f64>,
    energy: Array2<'py, f64>,
    impacts: Impacts<'py>,
    rests: ContactTimes<'py>,
    releases: ContactTimes<'py>,
}

/// Samples and events collected along a motion.
#[derive(Debug, Default)]
struct MotionRecord {
    states: Vec<State>,
    energy: Vec<[f64; 4]>,
    events: Events,
}

/// Events by kind.
#[derive(Debug, Default)]
struct Events {
    impacts: Vec<(f64, i8, f64, f64)>,
    rests: Vec<(f64, i8)>,
    releases: Vec<(f64, i8)>,
}

impl Events {
    fn take(&mut self, event: &Event) {
        match *event {
            Event::Impact { time, side, speed, impulse } => self.impacts.push((time, side, speed, impulse)),
            Event::Rest { time, side } => self.rests.push((time, side)),
            Event::Release { time, side } => self.releases.push((time, side)),
        }
    }
}

fn contacts<'py>(py: Python<'py>, found: &[(f64, i8)]) -> ContactTimes<'py> {
    let (t, stop): (Vec<f64>, Vec<i8>) = found.iter().copied().unzip();
    ContactTimes { t: column(py, &t), stop: column(py, &stop) }
}

/// The motion from a state (m, m/s) at `begin` (s) under loads, reported at ascending times (s).
#[pyfunction]
#[pyo3(signature = (system, start, begin, t, loads, progress = None))]
pub fn paper_simulate<'py>(
    py: Python<'py>,
    system: &System,
    start: [f64; 6],
    begin: f64,
    t: PyReadonlyArray1<'_, f64>,
    loads: Vec<PyRef<'_, Load>>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<SampledMotion<'py>> {
    let (p, times) = (*system.parameters(), numbers(&t)?);
    let loads: Vec<load::Load> = loads.iter().map(|l| l.load().clone()).collect();
    let found = compute(py, progress, move |control| sampled(control, &p, &start, begin, &times, &loads))?;
    let (s, v) = states(py, &found.states)?;
    let impacts = &found.events.impacts;
    let part = |f: fn(&(f64, i8, f64, f64)) -> f64| column(py, &impacts.iter().map(f).collect::<Vec<_>>());
    Ok(SampledMotion {
        s,
        v,
        energy: table(py, &found.energy)?,
        impacts: Impacts {
            t: part(|i| i.0),
            stop: column(py, &impacts.iter().map(|i| i.1).collect::<Vec<_>>()),
            speed: part(|i| i.2),
            impulse: part(|i| i.3),
        },
        rests: contacts(py, &found.events.rests),
        releases: contacts(py, &found.events.releases),
    })
}

/// Samples a motion at ascending times, advancing to each in turn: bit-identical to a host with
/// these communication points.
fn sampled(
    control: &Control,
    p: &Parameters,
    start: &[f64; 6],
    begin: f64,
    times: &[f64],
    loads: &[load::Load],
) -> Result<MotionRecord, Failure> {
    let mut simulator = Simulator::new(p, &state(start), begin)?;
    let mut found = MotionRecord::default();
    found.states.try_reserve_exact(times.len())?;
    found.energy.try_reserve_exact(times.len())?;
    for &time in times {
        control.check()?;
        let mut observer = |event: &Event| found.events.take(event);
        if loads.is_empty() {
            simulator.advance_observed(time, &mut observer)?;
        } else {
            simulator.advance_under(loads, time, Pause::Never, Some(&mut observer))?;
        }
        found.states.push(simulator.state());
        let e = simulator.energy_accounts();
        found.energy.push([e.mechanical, e.input, e.damped, e.impact]);
        control.add(1);
    }
    Ok(found)
}

/// A motion's end, or the reason why there is none.
type End = Result<State, String>;

/// Displacements (m), velocities (m/s), and for each motion the reason why there are none.
type Ends<'py> = (Array2<'py, f64>, Array2<'py, f64>, Vec<Option<String>>);

/// The states of many machines after a number of drive periods, each from its own start at time 0
/// or all from one. If `in_rows` is set, a motion without an end has zeros and its reason.
#[pyfunction]
#[pyo3(signature = (systems, starts, periods, in_rows, progress = None))]
pub fn paper_simulate_many<'py>(
    py: Python<'py>,
    systems: GivenSystems<'_>,
    starts: GivenStarts<'_>,
    periods: u32,
    in_rows: bool,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Ends<'py>> {
    let (systems, starts) = (systems.owned()?, starts.owned()?);
    let (count, ends) = (systems.len(), Arc::new(Mutex::new(Vec::new())));
    let theirs = Arc::clone(&ends);
    let ended = compute(py, progress, move |control| {
        together(control, (&systems, &starts), periods, in_rows, &theirs)
    });
    let ends = ends.lock().unwrap_or_else(PoisonError::into_inner);
    ended.map_err(|error| {
        let row =
            |end: &End| end.as_ref().map_or(Vec::new(), |end| end.x.iter().chain(&end.v).copied().collect());
        with_partial(py, error, (0..count).map(|index| ends.get(index).map(row)).collect())
    })?;
    let rows: Vec<State> = ends.iter().map(|end| *end.as_ref().unwrap_or(&State::default())).collect();
    let (s, v) = states(py, &rows)?;
    Ok((s, v, ends.iter().map(|end| end.as_ref().err().cloned()).collect()))
}

/// Appends the ends of motions in the order of the motions.
fn together(
    control: &Control,
    (systems, starts): (&Systems, &Starts),
    periods: u32,
    in_rows: bool,
    ends: &Mutex<Vec<End>>,
) -> Result<(), Failure> {
    let (pool, count) = (pool()?, systems.len());
    let ends = || ends.lock().unwrap_or_else(PoisonError::into_inner);
    ends().try_reserve_exact(count)?;
    let motions = PERIODS_A_THREAD / periods.max(1) as usize;
    let motions = motions.clamp(*MOTIONS_A_THREAD.start(), *MOTIONS_A_THREAD.end());
    let size = motions * pool.current_num_threads();
    let refused = |index: usize, failure: Failure| {
        if in_rows { failure.reason() } else { Err(failure.of_motion(index)) }
    };
    for begin in (0..count).step_by(size) {
        control.check()?;
        let made = (begin..count.min(begin + size)).map(|index| systems.motion(starts, index));
        let made: Vec<Result<Start, Failure>> =
            made.map(|own| own.map(|(parameters, state)| Start { parameters, state })).collect();
        let some: Vec<Start> = made.iter().flatten().cloned().collect();
        let mut found = pool.install(|| propagate(&some, periods, &|| control.add(1))).into_iter();
        let mut ends = ends();
        for one in made {
            let index = ends.len();
            let end = one.and_then(|_| found.next().map_or(Err(Failure::Cancelled), |end| Ok(end?)));
            ends.push(match end {
                Ok(end) => Ok(end),
                Err(failure) => Err(refused(index, failure)?),
            });
        }
    }
    Ok(())
}

/// A Poincaré section.
#[derive(IntoPyObject)]
pub struct SectionStates<'py> {
    t: Array1<'py, f64>,
    s: Array2<'py, f64>,
    v: Array2<'py, f64>,
    phase: Array1<'py, f64>,
    speed: Array1<'py, f64>,
}

/// One point of a section: time, state, phase of the drive, speed of the impact.
type SectionPoint = (f64, State, f64, f64);

/// States at a phase of the drive (`stop` = 0), or just after the impacts at a stop (+1 or -1),
/// over `periods` drive periods after `discard`, from a state at time 0.
#[pyfunction]
#[pyo3(signature = (system, start, stop, phase, discard, periods, progress = None))]
#[allow(clippy::too_many_arguments)]
pub fn paper_poincare<'py>(
    py: Python<'py>,
    system: &System,
    start: [f64; 6],
    stop: i8,
    phase: f64,
    discard: u32,
    periods: u32,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<SectionStates<'py>> {
    let p = *system.parameters();
    let found = compute(py, progress, move |control| {
        let simulator = Simulator::new(&p, &state(&start), 0.0)?.without_energy_accounts();
        if stop == 0 {
            at_phase(control, simulator, phase, (discard, periods))
        } else {
            at_stop(control, simulator, stop, (discard, periods))
        }
    })?;
    let part = |f: fn(&SectionPoint) -> f64| column(py, &found.iter().map(f).collect::<Vec<_>>());
    let (s, v) = states(py, &found.iter().map(|point| point.1).collect::<Vec<_>>())?;
    Ok(SectionStates {
        t: part(|point| point.0),
        s,
        v,
        phase: part(|point| point.2),
        speed: part(|point| point.3),
    })
}

/// States at a phase of the drive, rad, which is reached a fraction of a period after each whole
/// one.
fn at_phase(
    control: &Control,
    mut simulator: Simulator,
    phase: f64,
    (discard, periods): (u32, u32),
) -> Result<Vec<SectionPoint>, Failure> {
    let p = *simulator.parameters();
    let part = ((phase - p.drive_phase) / TAU).rem_euclid(1.0);
    let mut found = Vec::new();
    found.try_reserve_exact(periods as usize)?;
    for i in 0..u64::from(discard) + u64::from(periods) {
        control.check()?;
        simulator.advance_to((part + i as f64) * p.period())?;
        control.add(1);
        if i >= u64::from(discard) {
            let phase = simulator.drive_phase().rem_euclid(TAU);
            found.push((simulator.time(), simulator.state(), phase, 0.0));
        }
    }
    Ok(found)
}

/// States just after the impacts at a stop.
fn at_stop(
    control: &Control,
    mut simulator: Simulator,
    stop: i8,
    (discard, periods): (u32, u32),
) -> Result<Vec<SectionPoint>, Failure> {
    let period = simulator.parameters().period();
    let mut found = Vec::new();
    for i in 1..=u64::from(discard) + u64::from(periods) {
        control.check()?;
        let end = i as f64 * period;
        if i <= u64::from(discard) {
            simulator.advance_to(end)?;
        } else {
            while simulator.time() < end {
                let mut impact = None;
                let mut observer = |event: &Event| {
                    if let Event::Impact { side, speed, .. } = *event {
                        impact = Some((side, speed));
                    }
                };
                let outcome = simulator.advance_until(end, Pause::AfterImpact, Some(&mut observer))?;
                if let Some((_, speed)) = impact.filter(|(side, _)| *side == stop) {
                    let phase = simulator.drive_phase().rem_euclid(TAU);
                    found.push((simulator.time(), simulator.state(), phase, speed));
                }
                if outcome == AdvanceOutcome::End {
                    break;
                }
            }
        }
        control.add(1);
    }
    Ok(found)
}
