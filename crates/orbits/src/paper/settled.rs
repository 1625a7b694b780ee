//! Orbits from settled simulated motions.

use super::orbit::{Orbit, newton};
use super::system::System;
use crate::obstacle::Obstacle;
use crate::stop_word::{MOST_LETTERS, OrbitWord, REPETITION};
use std::f64::consts::TAU;
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{Contact, Event, Simulator, State};
use vibro_studies::paper::attractor::distance;
use vibro_studies::paper::stroboscopic::StroboscopicState;
use vibro_studies::{Error, Result};

/// Longest period in the search, in drive periods.
pub(super) const LONGEST: u32 = 32;

/// Largest change of a coordinate (units of L and L ω1) in a near return. Newton's method removes
/// this difference.
const RETURN: f64 = 2e-3;

/// Largest correction of a phase by Newton's method from a near return to an orbit, rad.
const MOVE: f64 = 0.05;

/// Tolerance for equal phases of two repetitions, rad: Newton's method may leave such a difference
/// near a period doubling.
const ALIKE: f64 = 1e-5;

/// Limit of the number of impacts of a word that is tried after a shorter one. The work grows with
/// the cube of this number and takes about a second here.
const MANY: usize = 512;

/// Limits for following a motion until it returns.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Largest number of drive periods.
    pub periods: u32,
    /// Largest number of impacts.
    pub impacts: usize,
}

impl Limits {
    const WIDEST: Self = Self { periods: LONGEST, impacts: MOST_LETTERS };
}

/// Phase of the drive at time 0, rad, reduced by whole turns: with many turns the phases of
/// impacts would lose digits.
pub(super) fn first_phase(p: &Parameters) -> f64 {
    let phase = p.drive_phase;
    if phase.abs() <= TAU { phase } else { phase.sin().atan2(phase.cos()) }
}

/// A state in units of L and L ω1. In these units, velocities are as large as displacements, even
/// if the box is hardly held by a spring.
pub(super) fn in_drive_units(p: &Parameters, state: &State) -> StroboscopicState {
    let speed = p.stop_gap * p.drive_frequency;
    let (x, v) = (state.x.map(|x| x / p.stop_gap), state.v.map(|v| v / speed));
    [x[0], x[1], x[2], v[0], v[1], v[2]]
}

/// A state in SI units from a state in units of L and L ω1.
pub(super) fn from_drive_units(p: &Parameters, s: &StroboscopicState) -> State {
    let speed = p.stop_gap * p.drive_frequency;
    State { x: [s[0], s[1], s[2]].map(|x| x * p.stop_gap), v: [s[3], s[4], s[5]].map(|v| v * speed) }
}

/// A simulator of a machine with its loads, starting from a state at time 0.
pub(super) fn simulator(system: &System, state: &State) -> Result<Simulator> {
    let mut simulator = Simulator::new(system.parameters(), state, 0.0)?.without_energy_accounts();
    simulator.set_loads(&system.loads().loads())?;
    Ok(simulator)
}

/// The state after a number of drive periods, for a transient to die out.
///
/// # Errors
/// An error of the simulator.
pub fn settle(system: &System, start: &State, periods: u32) -> Result<State> {
    let mut simulator = simulator(system, start)?;
    simulator.advance_to(f64::from(periods) * system.parameters().period())?;
    Ok(simulator.state())
}

/// The periodic orbit on which a motion from a state at time 0 has settled.
///
/// The orbit can be unstable, since a chaotic motion also nearly returns near unstable orbits; its
/// multipliers show whether it is stable. A stable orbit is preferred: near a period doubling a
/// settled motion nearly returns after half of its period, near the orbit that has just become
/// unstable. Words of more than 1024 impacts are not tried; after the first near return the limit
/// is 512 impacts.
///
/// # Errors
/// [`Error::NoPeriodicMotion`] if the block comes to rest at a stop during the motion, if the
/// motion does not return within 32 drive periods and 1024 impacts, or if it returns but there is
/// no orbit. An error that names the parameter if phases do not determine the orbit, as without
/// springs. An error of the simulator.
pub fn orbit_of(system: &System, state: &State) -> Result<Orbit> {
    orbit_within(system, state, Limits::WIDEST)
}

/// [`orbit_of`] within limits.
pub(super) fn orbit_within(system: &System, state: &State, limits: Limits) -> Result<Orbit> {
    let p = system.parameters();
    let mut simulator = simulator(system, state)?;
    let (start, first) = (in_drive_units(p, &simulator.state()), first_phase(p));
    let (mut phases, mut letters) = (Vec::new(), Vec::new());
    let (mut unstable, mut missed) = (None, None);
    // A block that a load always holds at a stop has no events.
    let mut rests = simulator.contact() != Contact::Flight;
    let mut many = false;
    for q in 1..=limits.periods {
        simulator.advance_observed(f64::from(q) * p.period(), &mut |event| match *event {
            Event::Impact { time, side, .. } => {
                phases.push(first + p.drive_frequency * time);
                letters.push(side);
            }
            _ => rests = true,
        })?;
        if rests {
            break;
        }
        let tried = unstable.is_some() || missed.is_some();
        many = letters.len() > if tried { MANY.min(limits.impacts) } else { limits.impacts };
        if many {
            break;
        }
        if distance(&start, &in_drive_units(p, &simulator.state())) < RETURN {
            // The first near return of each kind is kept: later ones repeat the same orbit.
            match near(system, &letters, &phases, q, MOVE) {
                Ok(orbit) if orbit.is_stable() => return Ok(orbit),
                Ok(orbit) => unstable = unstable.or(Some(orbit)),
                Err(obstacle) => missed = missed.or(Some((q, obstacle))),
            }
        }
    }
    unstable.ok_or_else(|| if rests { at_rest() } else { not_found(system, missed, limits, many) })
}

/// The error for a motion with rest.
fn at_rest() -> Error {
    let reason = "rests at a stop for a while; orbits with rest are not supported: try a weaker \
                  drive or a larger stop.restitution";
    Error::NoPeriodicMotion { reason: reason.into() }
}

/// The error for a motion without an orbit. `missed` is the first near return without an orbit;
/// `many` is whether there were too many impacts.
fn not_found(system: &System, missed: Option<(u32, Obstacle)>, limits: Limits, many: bool) -> Error {
    let Limits { periods, impacts } = limits;
    let within =
        if many { format!("within {impacts} impacts") } else { format!("in up to {periods} drive periods") };
    let reason = match missed {
        Some((q, obstacle @ (Obstacle::Singular | Obstacle::Refused(_)))) => {
            return obstacle.error(system, &OrbitWord::of(Vec::new(), 1, 2 * q));
        }
        Some((q, _)) => format!(
            "nearly returns after {q} drive periods, but no orbit within the stops was found \
             nearby: the motion has not settled, or grazes a stop; try more periods, another start \
             or another value"
        ),
        None => format!(
            "does not return {within}: it is chaotic, quasi-periodic or not settled; try more \
             periods, another start or another value"
        ),
    };
    Error::NoPeriodicMotion { reason }
}

/// The certified orbit near the impacts of q drive periods, in its shortest word. Its phases
/// differ from the phases of these impacts by at most `most`.
///
/// Near a period doubling, the equations of a word repeated twice are nearly singular. Newton's
/// method then converges so slowly that it stops early, with different phases in the two
/// repetitions. The single word is therefore tried too. If the two repetitions differ, the orbit
/// of the single word is accepted only if it is stable.
pub(super) fn near(
    system: &System,
    letters: &[i8],
    phases: &[f64],
    q: u32,
    most: f64,
) -> std::result::Result<Orbit, Obstacle> {
    let word = OrbitWord::of(letters.to_vec(), 1, 2 * q);
    let mirror = system.is_symmetric();
    if word.is_empty() {
        let word = if mirror { OrbitWord::of(Vec::new(), -1, 1) } else { OrbitWord::of(Vec::new(), 1, 2) };
        return certified(Orbit::at(system, &word, &[])?);
    }
    let found = newton_near(system, &word, phases, most);
    let own = found.as_ref().map_or(word.clone(), |found| word.reduced(found, mirror, REPETITION).0);
    let (guess, tolerance) = found.as_ref().map_or((phases, most), |found| (found.as_slice(), ALIKE));
    let (short, guess) = word.reduced(guess, mirror, tolerance);
    if short != word
        && let Ok(phases) = newton_near(system, &short, &guess, most)
        && let Ok(orbit) = Orbit::at(system, &short, &phases).and_then(certified)
        && (short == own || orbit.is_stable())
    {
        return Ok(orbit);
    }
    let (word, phases) = word.reduced(&found?, mirror, REPETITION);
    certified(Orbit::at(system, &word, &phases)?)
}

/// Phases of an orbit that differ from a guess by at most `most`.
fn newton_near(
    system: &System,
    word: &OrbitWord,
    guess: &[f64],
    most: f64,
) -> std::result::Result<Vec<f64>, Obstacle> {
    let found = newton(system, word, guess)?;
    let far = guess.iter().zip(&found).any(|(a, b)| (a - b).abs() > most);
    if far { Err(Obstacle::NoConvergence) } else { Ok(found) }
}

/// An orbit, if certified.
fn certified(orbit: Orbit) -> std::result::Result<Orbit, Obstacle> {
    if orbit.is_certified() { Ok(orbit) } else { Err(Obstacle::NoConvergence) }
}
