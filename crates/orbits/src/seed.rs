//! Initial guesses of orbits from motions: the events of a motion over a period are the word;
//! their times and the state after the first event are the guess.

use super::directions::Direction;
use super::orbit::{Obstructed, Orbit, newton};
use super::place::{Family, with_signals};
use super::problem::{Numbers, Problem};
use super::record::{Record, WHOLE};
use super::word::{Letter, Word};
use crate::obstacle::Obstacle;
use std::f64::consts::TAU;
use std::sync::Arc;
use vibro_machine::system::System;
use vibro_machine::{Motion, Start};
use vibro_studies::flight::Flows;
use vibro_studies::{Error, Machine, MotionClass, Result, Section, SectionRule, carried, discard, settled};

/// Largest number of events and samples of an orbit; each requires a matrix of the state's size.
const MOST_LETTERS: usize = 20_000;

/// A word, an initial guess of its orbit, and its equations.
#[derive(Debug)]
pub(super) struct Seed {
    pub problem: Problem,
    pub numbers: Numbers,
    pub value: f64,
}

/// Follows a motion over `returns` returns to its section, as the seed of an orbit.
pub(super) fn seed(
    family: &Arc<Family>,
    value: f64,
    motion: &mut Motion,
    section: &Section,
    returns: u32,
) -> Result<Seed> {
    let place = family.place(value)?;
    let (assembly, from) = (motion.assembly().clone(), motion.time());
    let (begin, mode) = (motion.state().as_slice().to_vec(), motion.mode().clone());
    let period = place.period.unwrap_or_default();
    let (mut record, mut flows) = (Record { period, ..Record::default() }, Flows::default());
    for _ in 0..returns {
        section.follow(motion, &mut flows, &mut [&mut record])?;
    }
    record.leave_plain_knots_out();
    let span = motion.time() - from;
    if span <= 0.0 {
        let problem =
            format!("at t = {from} s the period is lost in rounding: use a start at an earlier time");
        return Err(Error::Described { problem });
    }
    if let Some(time) = record.jump {
        let problem = format!(
            "at t = {time} s a signal changes the position or velocity of a body by a jump; orbits \
             of such a machine are not supported: use signals with jumps of forces or stiffness \
             only, or with continuous motions"
        );
        return Err(Error::Described { problem });
    }
    let periods = match place.period {
        Some(period) => {
            let ratio = span / period;
            if (ratio - ratio.round()).abs() > WHOLE * ratio || ratio.round() < 1.0 {
                let problem = format!(
                    "the motion returns after {span} s, which is not a multiple of the drive \
                     period {period} s"
                );
                return Err(Error::Described { problem });
            }
            Some(ratio.round() as u32)
        }
        None => None,
    };
    let period = place.period.map_or(span, |period| period * f64::from(periods.unwrap_or(1)));
    let system = assembly.system();
    let own = system.states();
    let is_empty = record.letters.is_empty();
    if is_empty && periods.is_none() {
        let problem = "the motion has no events and nothing drives it, so it rests or oscillates \
                       freely; expected a motion with events or a drive";
        return Err(Error::Described { problem: problem.into() });
    }
    record.with_runs(period, periods);
    record.begin_with_fixed_time(period, periods);
    if record.letters.len() > MOST_LETTERS {
        let problem = format!(
            "the motion has {} events and samples per period; an orbit may have at most {MOST_LETTERS}",
            record.letters.len()
        );
        return Err(Error::Described { problem });
    }
    let radian = place.period.unwrap_or(span) / TAU;
    let units = record.units(system, radian);
    let mut times = if is_empty { vec![from] } else { std::mem::take(&mut record.times) };
    let own_states = if is_empty { vec![begin] } else { std::mem::take(&mut record.states) };
    let mode = record.letters.last().map_or(mode, |letter| letter.last_mode().clone());
    let word = Word::new(record.letters.into(), mode, periods);
    // Times count from the first drive period; fixed times are taken from the word.
    let fixed =
        |k: usize| word.letters.get(k).and_then(Letter::timed).map(|own| own.time(place.assembly.system()));
    let whole = match (place.period, fixed(0)) {
        (Some(period), Some(first)) => ((times[0] - first) / period).round() * period,
        (Some(period), None) => (times[0] / period).floor() * period,
        (None, _) => times[0],
    };
    let own_times: Vec<f64> = (0..times.len()).map(|k| fixed(k).unwrap_or(times[k] - whole)).collect();
    let mut states = Vec::new();
    for &k in word.nodes() {
        let mut state = own_states[k].clone();
        move_back(system, &mut state, own_times[k])?;
        state.truncate(own);
        states.push(state);
    }
    times = own_times;
    let word = word.between_corners(&place, &times);
    let directions = Direction::all(&place, &word, &units.state);
    let drifts = vec![0.0; directions.len()];
    let (fixed, origin) = (Vec::new(), times[0]);
    let mut problem = Problem { family: family.clone(), word, units, directions, fixed, origin };
    let numbers = Numbers { states, times, period, drifts };
    problem.hold(&place, &numbers);
    Ok(Seed { problem, numbers, value })
}

/// Smallest and largest value of each state variable of a motion over some returns, or until the
/// motion stops.
pub(super) fn extents(motion: &mut Motion, section: &Section, returns: u32) -> Vec<(f64, f64)> {
    let (mut record, mut flows) = (Record::default(), Flows::default());
    for _ in 0..returns {
        if section.follow(motion, &mut flows, &mut [&mut record]).is_err() {
            break;
        }
    }
    record.extents
}

/// The state of uniformly moving bodies, and of bodies carried along, at an earlier time.
fn move_back(system: &System, state: &mut [f64], time: f64) -> Result<()> {
    let mut earlier = state.to_vec();
    with_signals(system, time, &mut earlier);
    let own = system.states();
    let change: Vec<f64> =
        (0..state.len()).map(|i| if i < own { 0.0 } else { earlier[i] - state[i] }).collect();
    let is_rounding = |(i, x): (usize, &f64)| x.abs() <= WHOLE * (state[i].abs() + earlier[i].abs()).max(1.0);
    if change.iter().enumerate().all(is_rounding) {
        return Ok(());
    }
    let change: Vec<f64> =
        change.iter().enumerate().map(|(i, x)| if is_rounding((i, x)) { 0.0 } else { *x }).collect();
    let Some(along) = carried(system, &change, false) else {
        let problem = "uniformly moving bodies change the elongation of springs and stops, so the \
                       motion does not repeat";
        return Err(Error::Described { problem: problem.into() });
    };
    along.iter().enumerate().for_each(|(i, x)| state[i] += x);
    Ok(())
}

impl Orbit {
    /// The orbit of a seed.
    pub(super) fn of_seed(seed: Seed) -> std::result::Result<Self, Obstructed> {
        let Seed { problem, numbers, value } = seed;
        let word = |problem: &Problem| {
            let place = problem.family.place(value);
            place.map_or_else(|_| String::new(), |place| problem.word.in_words(&place.assembly))
        };
        let found = || {
            let place = problem.family.place(value).map_err(|e| (Obstacle::Refused(e), f64::INFINITY))?;
            let guess = problem.point(&place, &numbers, value);
            newton(&problem, &place, &guess).map(|u| (u, place))
        };
        match found() {
            Ok((u, place)) => {
                let residual = 0.0;
                let obstructed = |obstacle| Obstructed { obstacle, residual, word: String::new() };
                let (problem, u) = problem.reduced(&u).map_err(obstructed)?;
                Self::at(problem, place, u).map_err(obstructed)
            }
            Err((obstacle, residual)) => Err(Obstructed { obstacle, residual, word: word(&problem) }),
        }
    }

    /// The orbit on which the motion of a machine from a start settles. At most `discard_returns`
    /// returns to the section are discarded first, fewer if it settles before.
    ///
    /// # Errors
    /// [`Error::Described`] if the motion does not settle on a periodic orbit, with its class, or
    /// if Newton's method fails; otherwise as [`Machine::motion`] and [`Family::place`].
    ///
    /// # Examples
    /// A ball that flies for a period T after each impact on a shaken table has the closing speed
    /// gT/(1 + ε), whatever the table's amplitude:
    ///
    /// ```
    /// use vibro_orbits::Orbit;
    /// use vibro_studies::{Machine, Start};
    ///
    /// let text = r#"
    ///     name = "Juggler"
    ///     gravity = 10.0
    ///     body.table = { motion = { amplitude = "4 mm", frequency = "5 Hz" } }
    ///     body.ball = { mass = "20 g", gravity = -1.0, start = { v = 1.0 } }
    ///     stop.table = { between = ["ball", "table"], gap = 0.0, restitution = 0.8 }
    /// "#;
    /// let machine = Machine::parse(text, "juggler.toml", &vibro_machine::file::no_records)?;
    /// let orbit = Orbit::settled(&machine, &Start::default(), 400)?;
    /// let speed = orbit.measure(&"impact.speed.table".parse()?)?;
    /// assert!((orbit.period() - 0.2).abs() < 1e-14 && orbit.word().len() == 1);
    /// assert!((speed - 10.0 * 0.2 / 1.8).abs() < 1e-12);
    /// # Ok::<(), vibro_studies::Error>(())
    /// ```
    pub fn settled(machine: &Machine, start: &Start, discard_returns: u32) -> Result<Self> {
        let family = Arc::new(Family::of_one(machine)?);
        let (motion, section) = machine.motion(start)?;
        let value = family.present()?;
        let mut motion = motion.without_energy_accounts();
        Self::settled_in(&family, value, (&mut motion, &section), discard_returns)
    }

    /// The orbit on which the motion of a family's machine at a value settles.
    ///
    /// # Errors
    /// As [`settled`](Self::settled).
    pub fn settled_at(family: &Family, value: f64, start: &Start, discard_returns: u32) -> Result<Self> {
        let (motion, section) = family.at(value)?.motion(start)?;
        let mut motion = motion.without_energy_accounts();
        Self::settled_in(&Arc::new(family.clone()), value, (&mut motion, &section), discard_returns)
    }

    /// As [`settled`](Self::settled), for a family's machine at a value and from a motion's
    /// present state. The motion is left at the end of its observation.
    pub(super) fn settled_in(
        family: &Arc<Family>,
        value: f64,
        (motion, section): (&mut Motion, &Section),
        discard_returns: u32,
    ) -> Result<Self> {
        discard(motion, section, discard_returns)?;
        let found = settled(motion, section, None)?;
        let MotionClass::Periodic(returns) = found.class else {
            let words = section.in_words(&motion.assembly().description);
            let problem = format!(
                "the motion does not settle on a periodic orbit: it is {} at {words}; try another \
                 start (--start) or discard more returns (--discard)",
                found.class.name()
            );
            return Err(Error::Described { problem });
        };
        let seed = seed(family, value, motion, section, returns)?;
        Self::of_seed(seed).map_err(Obstructed::error)
    }

    /// The orbit near a motion from a start, with a period close to `period`, s.
    ///
    /// # Errors
    /// [`Error::Described`] if Newton's method does not converge, with its last result.
    pub fn near(machine: &Machine, start: &Start, period: f64) -> Result<Self> {
        let family = Arc::new(Family::of_one(machine)?);
        let (mut motion, _) = machine.motion(start)?;
        let from = motion.time();
        let section = Section::of(&machine.description, &SectionRule::Period(period))?;
        let section = match section {
            Section::Period(period) if from != 0.0 => Section::Shifted(period, from),
            section => section,
        };
        let value = family.present()?;
        let seed = seed(&family, value, &mut motion, &section, 1)?;
        Self::of_seed(seed).map_err(Obstructed::error)
    }
}
