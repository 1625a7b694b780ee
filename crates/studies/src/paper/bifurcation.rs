//! Diagrams of the paper's machine: local maxima of X2, or of another displacement, with all seven
//! exponents on request. The motions at some values run [side by side](Workspace::run).

use super::attractor::Attractor;
use super::lyapunov::{self, Spectrum};
use super::maxima::Displacement;
use super::motion::settled_simulator;
use super::parameter_set::ParameterSet;
use super::stroboscopic::StroboscopicState;
use super::trajectories::{MotionEnd, Program, Start, Workspace};
use super::verdict::{EXPONENT_PERIODS, Following, follow, has_arrived};
use crate::axis::check_count;
use crate::class::{LONGEST, MotionClass, Relation};
use crate::diagram::{DiagramMachine, DiagramPoint, DiagramRequest};
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{Simulator, State};

/// Maxima per drive period assumed in the estimate of a diagram's size; few motions have more.
const MAXIMA_IN_A_PERIOD: usize = 4;
/// Resolution of maxima, units of L: six decimals are kept.
const RESOLUTION: f64 = 1e-6;

/// Tolerance for a block past a stop, as a fraction of the gap: rounding when its position, some
/// gaps away, is scaled to another gap.
const ROUNDING: f64 = 1e-12;

/// Request of a diagram of the paper's machine.
pub type Sweep = DiagramRequest<ParameterSet>;
/// Diagram of the paper's machine.
pub type Diagram<P = SweepPoint> = crate::diagram::Diagram<P>;

/// The motion at one value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepPoint {
    /// The parameter's value.
    pub value: f64,
    /// Local maxima of the sweep's displacement, units of L to six decimals, ascending, each with
    /// its count.
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

/// The machine with its states after the discarded periods and after the kept ones.
#[derive(Clone, Copy, Debug)]
pub struct SettledStart {
    parameters: Parameters,
    before: State,
    after: State,
}

/// A state of a machine with gap `from` for a machine with gap `to`. Displacements and velocities
/// scale with the gap, so that the block stays between the stops.
pub fn within_gap(state: State, from: f64, to: f64) -> State {
    if from == to {
        return state;
    }
    let mut scaled = State { x: state.x.map(|x| x * to / from), v: state.v.map(|v| v * to / from) };
    // Rounding of the position, which is a few gaps, may have put the block past a stop.
    let room = to * (1.0 - ROUNDING);
    let relative = scaled.x[1] - scaled.x[0];
    if relative.abs() > room {
        scaled.x[1] = scaled.x[0] + relative.clamp(-room, room);
    }
    scaled
}

impl DiagramMachine for ParameterSet {
    type Of = Displacement;
    type Exponents = lyapunov::SpectrumOptions;
    type Point = SweepPoint;
    type Settled = SettledStart;
    type DiagramWorkspace = Workspace;

    /// Refuses values at a section, too many periods, and results that do not fit into memory.
    fn check_diagram(&self, request: &Sweep) -> Result<()> {
        if request.at_section {
            let text = "values at the section".into();
            return Err(Error::Form {
                text,
                expected: "local maxima: sections of the paper's machine are not supported",
            });
        }
        let DiagramRequest { axis, discard, keep, .. } = request;
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
        let maxima =
            MAXIMA_IN_A_PERIOD.saturating_mul(*keep as usize).saturating_mul(size_of::<(f64, u32)>());
        let value = maxima.saturating_add(states + size_of::<Option<SweepPoint>>());
        // Both directions, and the parts and the whole in memory at the same time.
        check_count("values of the diagram", axis.count, value.saturating_mul(4))
    }

    fn settled_at(
        &self,
        request: &Sweep,
        value: f64,
        before: Option<&SettledStart>,
    ) -> Result<Option<SettledStart>> {
        let p = *self.with(request.axis.name, value)?.parameters();
        let first = match before {
            Some(s) => within_gap(s.after, s.parameters.stop_gap, p.stop_gap),
            None => request.start.state(&p)?,
        };
        let (discard, all) = (f64::from(request.discard), f64::from(request.discard + request.keep));
        let run = || -> vibro_impact::Result<SettledStart> {
            let mut simulator = settled_simulator(&p, &first, discard)?;
            let before = simulator.state();
            simulator.advance_to(all * p.period())?;
            Ok(SettledStart { parameters: p, before, after: simulator.state() })
        };
        Ok(run().ok())
    }

    fn observe(
        &self,
        request: &Sweep,
        starts: &[(f64, Option<SettledStart>)],
        workspace: &mut Workspace,
    ) -> Result<Vec<Option<SweepPoint>>> {
        let mut points: Vec<Option<SweepPoint>> = vec![None; starts.len()];
        let there: Vec<(usize, Start)> = starts
            .iter()
            .enumerate()
            .filter_map(|(index, (_, s))| {
                s.as_ref().map(|s| (index, Start { parameters: s.parameters, state: s.before }))
            })
            .collect();
        let program = Program {
            maxima: Some((request.of, request.keep)),
            observed: true,
            exponent: Some(EXPONENT_PERIODS),
            ..Program::default()
        };
        let (mut refused, mut ends) = (Ok(()), vec![State::default(); there.len()]);
        // Whether returns are so exact that the result is final.
        let mut arrived = vec![true; there.len()];
        workspace.run(&mut there.iter().map(|(_, start)| *start), &program, &mut |number, outcome| {
            let (index, start) = there[number];
            if let Ok(outcome) = &outcome {
                ends[number] = outcome.state;
                let period = outcome.attractor.as_ref().and_then(|attractor| attractor.period);
                arrived[number] = period.is_none_or(|n| has_arrived(outcome.record, n, &start.parameters));
            }
            match outcome.and_then(|outcome| point(starts[index].0, &start.parameters, outcome, request)) {
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
}

/// Follows motions without a final class until their class is decided.
fn prolong(open: &[(usize, Start)], points: &mut [Option<SweepPoint>], workspace: &mut Workspace) {
    let starts: Vec<Start> = open.iter().map(|(_, start)| *start).collect();
    follow(workspace, &starts, &Following::default(), &mut |number, motion, _| {
        // A motion that is refused on the way keeps its earlier result.
        let (Ok(motion), Some(point)) = (motion, &mut points[open[number].0]) else { return true };
        (point.class, point.attractor) = (motion.class, motion.attractor.clone());
        point.class.is_decided()
    });
}

fn point(value: f64, p: &Parameters, outcome: MotionEnd<'_>, request: &Sweep) -> Result<Option<SweepPoint>> {
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
    let spectrum = request.exponents.as_ref().map(exponents).transpose()?;
    let class = match &spectrum {
        Some(spectrum) => MotionClass::of(&attractor, Some(spectrum), p),
        None => MotionClass::by_largest(&attractor, exponent.as_ref(), p),
    };
    Ok(Some(SweepPoint { value, maxima, attractor, class, spectrum }))
}

#[cfg(test)]
mod tests;
