//! Starts of branches at the special points of another one.

use super::branch::{Branch, Special};
use super::conditions::Condition;
use super::cycle::Cycle;
use super::orbit::{Orbit, within};
use super::path::Departure;
use super::place::Place;
use super::problem::{Numbers, Problem};
use super::seed::seed;
use super::word::{Cause, Letter, Word};
use crate::branch::Label;
use crate::curve::{Equations, least_vectors, tangent};
use crate::obstacle::Obstacle;
use nalgebra::{DMatrix, DVector};
use vibro_analysis::assembly::Section;
use vibro_analysis::assembly::flight::{Series, coefficients, turning_points};
use vibro_assembly::Motion;
use vibro_assembly::mode::Watch;
use vibro_assembly::motion::{Event, EventKind};

/// First step from a point where branches meet.
const SWITCH_STEP: f64 = 1e-3;
/// Step of the difference that tells on which side of a touch a branch lies.
const SIDE_STEP: f64 = 1e-5;
/// Ways along the parameter, in its unit, at which the machine's own motion is asked for the word
/// beyond a special point.
const BEYOND: [f64; 3] = [1e-5, 1e-3, 1e-2];

/// Part of a flight at which no touch lies that recurs after a fraction of the flight.
const GOLDEN: f64 = 0.381_966_011_250_105_1;

/// The departures of a doubled branch at a doubling.
pub(super) fn at_doubling(problem: &Problem, u: &DVector<f64>) -> Result<Departure, Obstacle> {
    let place = problem.place(u)?;
    let (doubled, u) = problem.repeated(&place, u, 2)?;
    let matrix = doubled.residual(&place, &u, true)?.matrix.ok_or(Obstacle::NoConvergence)?;
    let direction = least_vectors(matrix).ok_or(Obstacle::NoConvergence)?.1;
    let special = Some(Special::of(Label::PeriodDoubling));
    Ok(Departure { direction: direction.push(0.0), problem: doubled, u, step: SWITCH_STEP, special })
}

/// The departures, in both directions, of the branch that crosses another one along `along`.
pub(super) fn at_crossing(
    problem: &Problem,
    u: &DVector<f64>,
    along: &DVector<f64>,
) -> Result<[Departure; 2], Obstacle> {
    let mut matrix: DMatrix<f64> = problem.linearize(u, None)?.matrix;
    let last = matrix.nrows();
    // The null space is a plane. With the branch's own direction as one more equation one direction
    // is left.
    matrix = matrix.insert_row(last, 0.0);
    matrix.set_row(last, &along.normalize().transpose());
    let direction = least_vectors(matrix).ok_or(Obstacle::NoConvergence)?.1;
    let departure = |direction: DVector<f64>| Departure {
        problem: problem.clone(),
        u: u.clone(),
        direction,
        step: SWITCH_STEP,
        special: Some(Special::of(Label::BranchPoint)),
    };
    Ok([departure(-&direction), departure(direction)])
}

/// The departure, at a touch of a rigid stop, of the branch whose word lists it, or whose word does
/// not list it any more. At the touch an impact has no speed, so that both words have one orbit.
pub(super) fn at_touch(
    problem: &Problem,
    u: &DVector<f64>,
    condition: Condition,
    special: &Special,
) -> Result<Departure, Obstacle> {
    let (other, at, sought) = other_side(problem, u, condition)?;
    let axis = crate::curve::axis(at.len(), at.len() - 1);
    let direction = tangent(&other, &at, &axis)?;
    // The side on which the sought condition holds.
    let side = |sign: f64| {
        let moved = &at + &direction * (sign * SIDE_STEP);
        let place = other.place(&moved)?;
        let conditions = other.cycle(&place, &moved)?.conditions(&place, &other.word);
        let own = conditions.iter().find(|(own, _)| *own == sought).map(|(_, value)| *value);
        Ok::<f64, Obstacle>(own.unwrap_or(1.0))
    };
    let sign = if side(1.0)? >= side(-1.0)? { 1.0 } else { -1.0 };
    let special = Some(special.clone());
    Ok(Departure { problem: other, u: at, direction: direction * sign, step: SWITCH_STEP, special })
}

/// The orbit that touches a rigid stop in the shortest word on the other side: with the touch as an
/// impact without speed where the word does not list it, without that impact where it does; with
/// the condition that ceases to hold there.
pub(super) fn other_side(
    problem: &Problem,
    u: &DVector<f64>,
    condition: Condition,
) -> Result<(Problem, DVector<f64>, Condition), Obstacle> {
    let place = problem.place(u)?;
    let cycle = problem.cycle(&place, u)?;
    let (other, numbers, sought) = match condition {
        Condition::Stays { letter, watch: Watch::Meets(stop), place: functional } => {
            with_impact(problem, &place, u, &cycle, (letter, stop, functional))?
        }
        Condition::Rises { letter } => without_impact(problem, &place, u, &cycle, letter)?,
        _ => return Err(Obstacle::NoConvergence),
    };
    let value = problem.value(u);
    let at = other.point(&place, &numbers, value);
    let (short, at) = other.reduced(&at)?;
    // In the shorter word the sought condition is that of its first passage.
    let sought = match sought {
        Condition::Rises { letter } => Condition::Rises { letter: letter % short.word.len().max(1) },
        Condition::Stays { letter, watch, place } => {
            Condition::Stays { letter: letter % short.word.len().max(1), watch, place }
        }
        lasts => lasts,
    };
    Ok((short, at, sought))
}

type Other = (Problem, Numbers, Condition);

/// The word with an impact of `stop` in the flight after `letter`.
fn with_impact(
    problem: &Problem,
    place: &Place,
    u: &DVector<f64>,
    cycle: &Cycle,
    (letter, stop, functional): (usize, usize, usize),
) -> Result<Other, Obstacle> {
    let leg = &cycle.legs[letter];
    let row = leg.flow.watched[functional].1.as_slice();
    let (mut best, mut past) = ((f64::NEG_INFINITY, 0.0), 0.0);
    let mut look = |series: &Series, length: f64| {
        let q = coefficients(row, series);
        turning_points(&q, &mut |part, value| {
            let is_inside = past + part > 0.0 && past + part * length < leg.span;
            if is_inside && value > best.0 {
                best = (value, past + part * length);
            }
        });
        past += length;
    };
    for part in leg.parts() {
        leg.flow.stretches(part.start, part.span, &mut look);
    }
    let time = leg.time + best.1;
    let mode = problem.word.mode_after(letter).clone();
    let kind = EventKind::Impact { stop, speed: 0.0, impulse: 0.0, stops: 1 };
    let own = Letter {
        modes: [mode.clone(), mode],
        cause: Cause::Passes { watch: Watch::Meets(stop), place: 0 },
        events: vec![Event { time, kind }],
        chatter: None,
    };
    let mut numbers = problem.numbers(place, u);
    let mut letters = problem.word.letters.to_vec();
    let index = if letters.is_empty() { 0 } else { letter + 1 };
    letters.insert(index, own);
    if problem.word.is_empty() {
        let (_, mut state) = within(place, leg, best.1 / leg.span);
        state.truncate(numbers.states[0].len());
        numbers.states = vec![state];
        numbers.times = vec![time];
    } else {
        // An impact is no node.
        numbers.times.insert(index, time);
    }
    let word = Word::new(letters.into(), problem.word.mode.clone(), problem.word.periods);
    Ok((Problem { word, ..problem.clone() }, numbers, Condition::Rises { letter: index }))
}

/// The word without the impact `letter`.
fn without_impact(
    problem: &Problem,
    place: &Place,
    u: &DVector<f64>,
    cycle: &Cycle,
    letter: usize,
) -> Result<Other, Obstacle> {
    let own = &problem.word.letters[letter];
    let is_simple =
        own.chatter.is_none() && own.is_impact() && own.modes[0] == own.modes[1] && own.hits().count() == 1;
    let Some(Watch::Meets(stop)) = own.watch() else { return Err(Obstacle::NoConvergence) };
    if !is_simple {
        return Err(Obstacle::NoConvergence);
    }
    let mut numbers = problem.numbers(place, u);
    let mut letters = problem.word.letters.to_vec();
    let mode = letters.remove(letter).modes[1].clone();
    let count = problem.word.len();
    let functional = |leg: &super::cycle::Leg| {
        leg.flow.watched.iter().position(|(watch, _)| *watch == Watch::Meets(stop)).unwrap_or(0)
    };
    let watch = Watch::Meets(stop);
    let (origin, sought) = if count == 1 {
        // A touch at the orbit's begin would be left out.
        let (leg, own) = (&cycle.legs[0], numbers.states[0].len());
        let (origin, state) = within(place, leg, GOLDEN);
        numbers.states = vec![state[..own].to_vec()];
        numbers.times = vec![origin];
        (origin, Condition::Stays { letter: 0, watch, place: functional(leg) })
    } else {
        numbers.times.remove(letter);
        if letter == 0 {
            // The next event is the first, and its state that of the first node.
            let state = cycle.legs[1].entered()[..numbers.states[0].len()].to_vec();
            let was_node = problem.word.nodes().contains(&1);
            numbers.states.splice(..if was_node { 2 } else { 1 }, [state]);
        }
        let before = (letter + count - 1) % count;
        let place = functional(&cycle.legs[before]);
        let flight = if letter == 0 { count - 2 } else { letter - 1 };
        (problem.origin, Condition::Stays { letter: flight, watch, place })
    };
    let mode = letters.last().map_or(mode, |letter| letter.last_mode().clone());
    let word = Word::new(letters.into(), mode, problem.word.periods);
    let mut other = Problem { word, origin, ..problem.clone() };
    other.fixed =
        other.neutral.iter().map(|n| n.iter().zip(&numbers.states[0]).map(|(n, x)| n * x).sum()).collect();
    Ok((other, numbers, sought))
}

/// Orbits with other words beyond a special point, by the machine's own motion from the orbit
/// there.
pub(super) fn beyond(branch: &Branch, u: &DVector<f64>) -> Vec<Orbit> {
    let problem = &branch.problem;
    let mut found: Vec<Orbit> = Vec::new();
    for sign in [-1.0, 1.0] {
        let near = BEYOND.iter().find_map(|way| {
            let value = problem.value(u) + sign * way * problem.family.unit();
            let orbit = by_motion(problem, u, value)?;
            (!orbit.has_word(&problem.word)).then_some(orbit)
        });
        found.extend(near.filter(|orbit| !found.iter().any(|own| own.is_same(orbit))));
    }
    found
}

/// The orbit near the motion that begins on another orbit, in the machine at a value.
fn by_motion(problem: &Problem, u: &DVector<f64>, value: f64) -> Option<Orbit> {
    let (from, to) = problem.family.range;
    if !(from..=to).contains(&value) {
        return None;
    }
    let place = problem.place(u).ok()?;
    let orbit = Orbit::at(problem.clone(), place, u.clone()).ok()?;
    let (time, state) = orbit.middle_state();
    let there = problem.family.place(value).ok()?;
    let period = there.period? * f64::from(problem.word.periods?);
    let mut motion = Motion::from_state(there.assembly.clone(), time, &state).ok()?.without_energy_accounts();
    let section = Section::Shifted(period, time.rem_euclid(period));
    let seed = seed(&problem.family, value, &mut motion, &section, 1).ok()?;
    Orbit::of_seed(seed).ok().filter(Orbit::is_certified)
}
