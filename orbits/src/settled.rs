//! Orbits from settled simulated motions.

use super::orbit::{Orbit, newton};
use super::system::System;
use super::word::{OrbitWord, REPETITION};
use std::f64::consts::TAU;
use vibro_analysis::attractor::distance;
use vibro_analysis::stroboscopic::dimensionless;
use vibro_analysis::{Error, Result};
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{Contact, Event, Simulator, State};

/// The longest period that is looked for, in drive periods.
const LONGEST: u32 = 32;

/// A motion counts as near a return when no coordinate (units of L and L ω10) differs by more: Newton's method does the rest.
const RETURN: f64 = 2e-3;

/// Largest change of a phase, rad, by which Newton's method may come from a near return to an orbit.
const MOVE: f64 = 0.05;

/// The phase of the drive at time 0, rad, without the turns by which a large one would leave the phases of impacts few digits.
pub(super) fn first_phase(p: &Parameters) -> f64 {
    let phase = p.drive_phase;
    if phase.abs() <= TAU { phase } else { phase.sin().atan2(phase.cos()) }
}

/// A simulator of a machine with its loads from a state on at time 0.
pub(super) fn simulator(system: &System, state: &State) -> Result<Simulator> {
    let mut simulator = Simulator::new(system.parameters(), state, 0.0)?.without_energy_accounts();
    simulator.set_loads(&system.loads().loads())?;
    Ok(simulator)
}

/// The state after a number of drive periods, in which a transient dies out.
///
/// # Errors
/// What the simulator refuses.
pub fn settle(system: &System, start: &State, periods: u32) -> Result<State> {
    let mut simulator = simulator(system, start)?;
    simulator.advance_to(f64::from(periods) * system.parameters().period())?;
    Ok(simulator.state())
}

/// The periodic orbit on which a motion has settled that passes a state at time 0.
///
/// Chaos comes near its unstable orbits too, so that what is found need not be stable: its multipliers say.
///
/// # Errors
/// [`Error::NoPeriodicMotion`] when the block comes to rest at a stop in its course, and when the motion does not return in up to
/// 32 drive periods; what the simulator refuses.
pub fn orbit_of(system: &System, state: &State) -> Result<Orbit> {
    let p = system.parameters();
    let mut simulator = simulator(system, state)?;
    let (start, first) = (dimensionless(p, &simulator.state()), first_phase(p));
    let (mut phases, mut letters) = (Vec::new(), Vec::new());
    // A block that a load holds at a stop throughout has no event.
    let mut rests = simulator.contact() != Contact::Flight;
    for q in 1..=LONGEST {
        simulator.advance_observed(f64::from(q) * p.period(), &mut |event| match *event {
            Event::Impact { time, side, .. } => {
                phases.push(first + p.drive_frequency * time);
                letters.push(side);
            }
            _ => rests = true,
        })?;
        if rests {
            let reason = "rests at a stop in its course, which orbits by impacts alone do not describe: a weaker drive or a \
                          larger stop.restitution may avoid rest";
            return Err(Error::NoPeriodicMotion { reason: reason.into() });
        }
        if distance(&start, &dimensionless(p, &simulator.state())) < RETURN
            && let Some(orbit) = near(system, &letters, &phases, q)
        {
            return Ok(orbit);
        }
    }
    let reason = format!(
        "does not return in up to {LONGEST} drive periods: it is chaotic, quasi-periodic or not settled; more periods, another start \
         or another value may help"
    );
    Err(Error::NoPeriodicMotion { reason })
}

/// The certified orbit near the impacts of q drive periods, in its shortest word.
fn near(system: &System, letters: &[i8], phases: &[f64], q: u32) -> Option<Orbit> {
    let word = OrbitWord::of(letters.to_vec(), 1, 2 * q);
    let mirror = system.is_symmetric();
    if word.is_empty() {
        let word = if mirror { OrbitWord::of(Vec::new(), -1, 1) } else { OrbitWord::of(Vec::new(), 1, 2) };
        return Orbit::find(system, &word, &[]).ok().filter(Orbit::is_certified);
    }
    let found = newton(system, &word, phases).ok()?;
    if phases.iter().zip(&found).any(|(a, b)| (a - b).abs() > MOVE) {
        return None;
    }
    let (word, phases) = word.reduced(&found, mirror, REPETITION);
    Orbit::at(system, &word, &phases).ok().filter(Orbit::is_certified)
}
