//! Starts of branches at the special points of another branch.

use super::branch::{Branch, Special};
use super::conditions::Condition;
use super::orbit::Orbit;
use super::problem::Problem;
use super::seed::{Seed, seed};
use super::sides::{Side, other_side};
use super::step::Departure;
use crate::curve::{Equations, correct, least_vectors, tangent};
use crate::label::Label;
use crate::obstacle::Obstacle;
use nalgebra::{DMatrix, DVector};
use vibro_machine::Motion;
use vibro_machine::mode::Contact;
use vibro_studies::Section;

/// First step from a point where branches meet.
const SWITCH_STEP: f64 = 1e-3;
/// Step of the difference that determines the side of a touch on which a branch lies.
const SIDE_STEP: f64 = 1e-5;
/// Distances beyond a special point, in the parameter's unit, at which the word is taken from the
/// machine's own motion.
const BEYOND: [f64; 3] = [1e-5, 1e-3, 1e-2];

/// The departure of a doubled branch at a doubling.
pub(super) fn at_doubling(problem: &Problem, u: &DVector<f64>) -> Result<Departure, Obstacle> {
    let place = problem.place(u)?;
    let (doubled, u) = problem.repeated(&place, u, 2)?;
    let matrix = doubled.residual(&place, &u, true)?.matrix.ok_or(Obstacle::NoConvergence)?;
    let direction = least_vectors(matrix).ok_or(Obstacle::NoConvergence)?.1;
    let special = Some(Special::of(Label::PeriodDoubling));
    Ok(Departure { direction: direction.push(0.0), of: doubled, u, step: SWITCH_STEP, special })
}

/// Both departures of the branch that crosses another one, whose direction is `along`.
pub(super) fn at_crossing(
    problem: &Problem,
    u: &DVector<f64>,
    along: &DVector<f64>,
) -> Result<[Departure; 2], Obstacle> {
    let mut matrix: DMatrix<f64> = problem.linearize(u, None)?.matrix;
    let last = matrix.nrows();
    // The null space is a plane. Requiring a direction perpendicular to the branch leaves one
    // direction.
    matrix = matrix.insert_row(last, 0.0);
    matrix.set_row(last, &along.normalize().transpose());
    let direction = least_vectors(matrix).ok_or(Obstacle::NoConvergence)?.1;
    let departure = |direction: DVector<f64>| Departure {
        of: problem.clone(),
        u: u.clone(),
        direction,
        step: SWITCH_STEP,
        special: Some(Special::of(Label::BranchPoint)),
    };
    Ok([departure(-&direction), departure(direction)])
}

/// The departure at a touch of a rigid stop, on the branch of the other word: with the touch if
/// this word does not list it, otherwise without. At the touch an impact has zero speed, so both
/// words describe one orbit.
pub(super) fn at_touch(
    problem: &Problem,
    u: &DVector<f64>,
    condition: Condition,
    special: &Special,
) -> Result<Departure, Obstacle> {
    let Side { problem: other, u: at, condition: sought } = other_side(problem, u, condition)?;
    let axis = crate::curve::axis(at.len(), at.len() - 1);
    let direction = tangent(&other, &at, &axis)?;
    // The side on which the condition holds.
    let side = |sign: f64| {
        let moved = &at + &direction * (sign * SIDE_STEP);
        let place = other.place(&moved)?;
        let conditions = other.cycle(&place, &moved)?.conditions(&place, &other.word);
        let own = conditions.iter().find(|(own, _)| *own == sought).map(|(_, value)| *value);
        Ok::<f64, Obstacle>(own.unwrap_or(1.0))
    };
    let sign = if side(1.0)? >= side(-1.0)? { 1.0 } else { -1.0 };
    let special = Some(special.clone());
    Ok(Departure { of: other, u: at, direction: direction * sign, step: SWITCH_STEP, special })
}

/// Orbits with other words beyond a special point, from the machine's own motion that starts on
/// the orbit there.
pub(super) fn beyond(branch: &Branch, u: &DVector<f64>) -> Vec<Orbit> {
    let problem = &branch.of;
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

/// The orbit near the motion from another orbit, in the machine at a value. If it has the same
/// word and violates a condition, the search is repeated from it. The touch of a buffer is a visit
/// of almost zero depth, which the motion from the touch itself may miss.
fn by_motion(problem: &Problem, u: &DVector<f64>, value: f64) -> Option<Orbit> {
    let (from, to) = problem.family.range;
    if !(from..=to).contains(&value) {
        return None;
    }
    let place = problem.place(u).ok()?;
    let there = problem.family.place(value).ok()?;
    let period = there.period? * f64::from(problem.word.periods?);
    let near = |orbit: &Orbit| {
        let (time, state) = orbit.middle_state();
        let motion = Motion::from_state(there.assembly.clone(), time, &state).ok()?;
        let section = Section::Shifted(period, time.rem_euclid(period));
        seed(&problem.family, value, &mut motion.without_energy_accounts(), &section, 1).ok()
    };
    let first = Orbit::of_seed(near(&Orbit::at(problem.clone(), place, u.clone()).ok()?)?).ok()?;
    if first.is_certified() || !first.has_word(&problem.word) {
        return Some(first).filter(Orbit::is_certified);
    }
    let seed = near(&first)?;
    let by_visit = with_visit(&seed);
    Orbit::of_seed(seed).ok().filter(Orbit::is_certified).or(by_visit)
}

/// The orbit whose shortest visit of a stop equals the seed's. The parameter value is found with
/// it, since the branch may turn at the touch.
fn with_visit(seed: &Seed) -> Option<Orbit> {
    let Seed { problem, numbers, value } = seed;
    let free = problem.word.free();
    let stop = |k: usize| match problem.word.letters[k].watch().map(|watch| watch.contact()) {
        Some(Contact::Stop(stop)) => Some(stop),
        _ => None,
    };
    let ends = |k: &usize| {
        let last = (k + 1..problem.word.len()).find(|later| stop(*later) == stop(*k))?;
        Some((numbers.times[last] - numbers.times[*k], [*k, last]))
    };
    let begins = (0..problem.word.len()).filter(|k| stop(*k).is_some());
    let (_, visit) = begins.filter_map(|k| ends(&k)).min_by(|a, b| a.0.total_cmp(&b.0))?;
    let guess = problem.point(&problem.family.place(*value).ok()?, numbers, *value);
    let mut along = DVector::zeros(guess.len());
    for (letter, sign) in visit.iter().zip([-1.0, 1.0]) {
        along[problem.first_time() + free.binary_search(letter).ok()?] = sign;
    }
    let at = correct(problem, &guess, &along.normalize()).ok()?;
    let orbit = Orbit::at(problem.clone(), problem.place(&at.u).ok()?, at.u).ok()?;
    let (from, to) = problem.family.range;
    Some(orbit).filter(|own| own.is_certified() && (from..=to).contains(&own.value()))
}
