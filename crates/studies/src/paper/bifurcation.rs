//! Bifurcation diagrams: local maxima of X2, or of another displacement, over one parameter in both
//! directions, with period, class and exponents.
//!
//! As in the paper, section 4, some drive periods are discarded and some kept at each value, and
//! the last state is the start of the next value. The motion from value to value is one chain and
//! cannot be divided. The observation at each value does not depend on the other values: threads
//! and computers share that part, and the motions of some values run
//! [side by side](Workspace::run).

mod windows;

pub use windows::Window;

use super::attractor::{Attractor, LONGEST, MotionClass, Relation};
use super::lyapunov::{self, Spectrum};
use super::maxima::Displacement;
use super::motion::settled_simulator;
use super::parameter_set::ParameterSet;
use super::plane::ParameterAxis;
use super::start::StartRule;
use super::stroboscopic::StroboscopicState;
use super::trajectories::{MotionEnd, Program, Start, Workspace};
use super::verdict::{EXPONENT_PERIODS, Following, follow, has_arrived};
use crate::axis::check_count;
pub use crate::directions::DiagramPoint;
use crate::directions::{chained, in_both_directions, parts};
use crate::error::{Error, Result};
use crate::parts::{PartStore, Task};
use serde::{Deserialize, Serialize};
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{Simulator, State};

/// Maxima in a drive period that the estimate of a diagram's size assumes; few motions have more.
const MAXIMA_IN_A_PERIOD: usize = 4;
/// Resolution of maxima, units of L: six digits after the point are kept.
const RESOLUTION: f64 = 1e-6;

/// Part of the gap by which a block scaled to another gap may be past a stop: rounding of a place
/// some gaps away.
const ROUNDING: f64 = 1e-12;

/// Request of a bifurcation diagram.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sweep {
    /// The parameter and its values.
    pub axis: ParameterAxis,
    /// Drive periods discarded at each value.
    pub discard: u32,
    /// Drive periods kept.
    pub keep: u32,
    /// Options of the exponents, if they are computed.
    pub exponents: Option<lyapunov::SpectrumOptions>,
    /// The displacement whose maxima are kept.
    #[serde(default)]
    pub of: Displacement,
    /// Start of the motion at the first value, and at a value after a refused one.
    #[serde(default)]
    pub start: StartRule,
}

/// The motion at one value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepPoint {
    /// The parameter's value.
    pub value: f64,
    /// Local maxima of the sweep's displacement, units of L to six digits after the point,
    /// ascending, each with its count.
    pub maxima: Vec<(f64, u32)>,
    /// Attractor of the motion.
    pub attractor: Attractor,
    /// Class of the motion.
    pub class: MotionClass,
    /// Exponents in units of ω10, per unit of the dimensionless time τ.
    pub spectrum: Option<Spectrum>,
}

impl DiagramPoint for SweepPoint {
    fn value(&self) -> f64 {
        self.value
    }

    fn maxima(&self) -> &[(f64, u32)] {
        &self.maxima
    }

    fn class(&self) -> MotionClass {
        self.class
    }

    fn contacts(&self) -> f64 {
        self.attractor.impacts[0] + self.attractor.impacts[1]
    }

    fn differs(&self, other: &Self) -> Option<bool> {
        let both = self.class.is_decided() && other.class.is_decided();
        match self.attractor.relation(&other.attractor) {
            Relation::Undecided => None,
            relation => both.then_some(relation == Relation::Different),
        }
    }
}

/// Diagram of the paper's machine.
pub type Diagram<P = SweepPoint> = crate::directions::Diagram<P>;

/// Start of the kept periods at one value: the machine with its state after the discarded periods;
/// no state where the simulator refused.
#[derive(Clone, Copy, Debug)]
struct SettledStart {
    value: f64,
    parameters: Parameters,
    state: Option<State>,
}

/// A state of a machine with gap `from` for a machine with gap `to`. Displacements and velocities
/// scale with the gap, so that the block stays between the stops.
pub fn within_gap(state: State, from: f64, to: f64) -> State {
    if from == to {
        return state;
    }
    let mut scaled = State { x: state.x.map(|x| x * to / from), v: state.v.map(|v| v * to / from) };
    // Rounding may have put the block past a stop by some digits of its place, which is a few gaps.
    let room = to * (1.0 - ROUNDING);
    let relative = scaled.x[1] - scaled.x[0];
    if relative.abs() > room {
        scaled.x[1] = scaled.x[0] + relative.clamp(-room, room);
    }
    scaled
}

/// The chain of states from value to value, in the order of rising values. After a value that the
/// simulator refuses it begins anew at the sweep's start. The store may end it before any value.
fn chain(
    set: &ParameterSet,
    sweep: &Sweep,
    store: &dyn PartStore,
    upward: bool,
) -> Result<Vec<SettledStart>> {
    let mut state: Option<State> = None;
    let mut gap = set.parameters().stop_gap;
    chained(sweep.axis.count, upward, store, &mut |i| {
        let value = sweep.axis.value(i);
        let p = *set.with(sweep.axis.name, value)?.parameters();
        let first = match state {
            Some(before) => within_gap(before, gap, p.stop_gap),
            None => sweep.start.state(&p)?,
        };
        gap = p.stop_gap;
        let (discard, all) = (f64::from(sweep.discard), f64::from(sweep.discard + sweep.keep));
        let run = || -> vibro_impact::Result<(State, State)> {
            let mut simulator = settled_simulator(&p, &first, discard)?;
            let before = simulator.state();
            simulator.advance_to(all * p.period())?;
            Ok((before, simulator.state()))
        };
        let run = run();
        let settled = SettledStart { value, parameters: p, state: run.as_ref().ok().map(|r| r.0) };
        state = run.ok().map(|r| r.1);
        Ok(settled)
    })
}

/// Observes the motions at some values side by side; `None` where the simulator refuses.
fn observe_all(
    starts: &[SettledStart],
    sweep: &Sweep,
    workspace: &mut Workspace,
) -> Result<Vec<Option<SweepPoint>>> {
    let mut points: Vec<Option<SweepPoint>> = vec![None; starts.len()];
    let there: Vec<(usize, Start)> = starts
        .iter()
        .enumerate()
        .filter_map(|(index, s)| Some((index, Start { parameters: s.parameters, state: s.state? })))
        .collect();
    let program = Program {
        maxima: Some((sweep.of, sweep.keep)),
        observed: true,
        exponent: Some(EXPONENT_PERIODS),
        ..Program::default()
    };
    let (mut refused, mut ends) = (Ok(()), vec![State::default(); there.len()]);
    // Whether returns are so exact that the finding is final.
    let mut arrived = vec![true; there.len()];
    workspace.run(&mut there.iter().map(|(_, start)| *start), &program, &mut |number, outcome| {
        let (index, start) = there[number];
        if let Ok(outcome) = &outcome {
            ends[number] = outcome.state;
            let period = outcome.attractor.as_ref().and_then(|attractor| attractor.period);
            arrived[number] = period.is_none_or(|n| has_arrived(outcome.record, n, &start.parameters));
        }
        match outcome.and_then(|outcome| point(starts[index].value, &start.parameters, outcome, sweep)) {
            Ok(point) => points[index] = point,
            Err(Error::Model(_)) => {}
            Err(other) => refused = Err(other),
        }
    });
    refused?;
    let open: Vec<(usize, Start)> = there
        .iter()
        .zip(ends.iter().zip(&arrived))
        .filter(|((index, _), (_, arrived))| {
            points[*index].as_ref().is_some_and(|p| !(p.class.is_final() && **arrived))
        })
        .map(|((index, start), (end, _))| (*index, Start { state: *end, ..*start }))
        .collect();
    prolong(&open, &mut points, workspace);
    Ok(points)
}

/// Follows motions without a final class until they have one.
fn prolong(open: &[(usize, Start)], points: &mut [Option<SweepPoint>], workspace: &mut Workspace) {
    let starts: Vec<Start> = open.iter().map(|(_, start)| *start).collect();
    follow(workspace, &starts, &Following::default(), &mut |number, motion, _| {
        // A motion that is refused on the way keeps its finding.
        let (Ok(motion), Some(point)) = (motion, &mut points[open[number].0]) else { return true };
        (point.class, point.attractor) = (motion.class, motion.attractor.clone());
        point.class.is_decided()
    });
}

fn point(value: f64, p: &Parameters, outcome: MotionEnd<'_>, sweep: &Sweep) -> Result<Option<SweepPoint>> {
    let MotionEnd { state, maxima, attractor: Some(attractor), exponent, .. } = outcome else {
        return Ok(None);
    };
    let six_digits = |value: &f64| (value / p.stop_gap / RESOLUTION).round() as i64;
    let mut tops: Vec<i64> = maxima.iter().map(six_digits).collect();
    tops.sort_unstable();
    let met = tops.chunk_by(|a, b| a == b);
    let maxima = met.map(|same| (same[0] as f64 * RESOLUTION, same.len() as u32)).collect();
    let exponents = |options| {
        let mut simulator = Simulator::new(p, &state, 0.0)?.without_energy_accounts();
        Ok::<_, Error>(lyapunov::dimensionless(&mut simulator, options)?.spectrum)
    };
    let spectrum = sweep.exponents.as_ref().map(exponents).transpose()?;
    let class = match &spectrum {
        Some(spectrum) => MotionClass::of(&attractor, Some(spectrum), p),
        None => MotionClass::by_largest(&attractor, exponent.as_ref(), p),
    };
    Ok(Some(SweepPoint { value, maxima, attractor, class, spectrum }))
}

/// Refuses periods that cannot be counted, and results that do not fit into memory.
fn check(sweep: &Sweep) -> Result<()> {
    let Sweep { axis, discard, keep, .. } = sweep;
    if discard.checked_add(*keep).is_none() {
        let count = f64::from(*discard) + f64::from(*keep);
        return Err(Error::TooMany {
            what: "drive periods at a value",
            count,
            most: u32::MAX as usize,
            side: None,
        });
    }
    let states = 2 * LONGEST as usize * size_of::<StroboscopicState>();
    let maxima = MAXIMA_IN_A_PERIOD.saturating_mul(*keep as usize).saturating_mul(size_of::<(f64, u32)>());
    let value = maxima.saturating_add(states + size_of::<Option<SweepPoint>>());
    // Both directions, and the parts beside the whole.
    check_count("values of the diagram", axis.count, value.saturating_mul(4))
}

/// Number of parts of a sweep.
pub fn count(sweep: &Sweep) -> usize {
    parts(sweep.axis.count)
}

/// The diagram, on all threads, in [`count`] parts; `None` where parts belong to other shards. The
/// result depends neither on threads nor on shards.
///
/// # Errors
/// Ranges that are not allowed; [`Error::TooMany`] for more periods or values than fit; what the
/// parts' folder refuses.
pub fn diagram(set: &ParameterSet, sweep: &Sweep, task: &Task) -> Result<Option<Diagram>> {
    check(sweep)?;
    in_both_directions(
        sweep.axis.count,
        task,
        &|upward| chain(set, sweep, task.store, upward),
        &|workspace, starts| observe_all(starts, sweep, workspace),
    )
}

#[cfg(test)]
mod tests;
