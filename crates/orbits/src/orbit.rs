//! One periodic orbit of a described machine: found by Newton's method and certified, with its
//! multipliers.

use super::conditions::Condition;
use super::cycle::{Cycle, Leg};
use super::directions::Direction;
use super::place::{Place, with_signals};
use super::problem::{Numbers, Problem};
use super::word::Word;
use crate::curve::Equations;
use crate::obstacle::Obstacle;
use nalgebra::{Complex, DMatrix, DVector, Schur};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use vibro_machine::Start;
use vibro_machine::mode::{Contact, Watch};
use vibro_machine::motion::keep;
use vibro_numerics::sorting::sort_by;
use vibro_studies::Error;

/// Largest number of Newton steps.
const STEPS: usize = 60;
/// Longest Newton step, in the units of the unknowns.
const LONGEST_STEP: f64 = 1.0;
/// Tolerance for multipliers on the unit circle: within it, stability is undecided.
const MARGIN: f64 = 1e-6;
/// Relative tolerance for a zero singular value of the Jacobian: there is a family of orbits.
const FAMILY: f64 = 1e-11;
/// Largest difference between states or times of the same orbit, in their units.
const SAME: f64 = 1e-6;
/// Rate of an event function, relative to terms and period, below which an event is a touch.
const GRAZES: f64 = 1e-9;
/// Slip duration, in periods, below which a slider only touches its yield force. At the edge of
/// the sticking orbits, rounding alone causes a slip this short.
const BRIEF_SLIP: f64 = 1e-6;
/// Largest number of sweeps of the Schur decomposition per multiplier.
const SWEEPS: usize = 200;

/// Whether an orbit attracts its neighbourhood.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Stability {
    /// All nontrivial multipliers lie within the unit circle.
    Stable,
    /// A multiplier lies outside the unit circle.
    Unstable,
    /// The largest multiplier lies on the unit circle, and the machine has no losses.
    Neutral,
    /// The largest multiplier is too near the unit circle to decide, or events are about to
    /// change, for example at a touch of a stop.
    Undecided,
}

impl std::fmt::Display for Stability {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Stable => "stable",
            Self::Unstable => "unstable",
            Self::Neutral => "neutral",
            Self::Undecided => "undecided",
        })
    }
}

/// A periodic orbit.
#[derive(Clone, Debug)]
pub struct Orbit {
    pub(super) problem: Problem,
    pub(super) u: DVector<f64>,
    pub(super) place: Arc<Place>,
    pub(super) cycle: Cycle,
    pub(super) numbers: Numbers,
    /// Largest first; the trivial multipliers come last.
    multipliers: Vec<Complex<f64>>,
    /// Number of trivial multipliers (1 by theory).
    trivial: usize,
    /// The conditions under which the cycle is a motion of the machine, with their values.
    conditions: Vec<(Condition, f64)>,
}

/// Why Newton's method found no orbit.
#[derive(Debug)]
pub(super) struct Obstructed {
    pub obstacle: Obstacle,
    /// Largest residual of the last step, in the units of the unknowns.
    pub residual: f64,
    pub word: String,
}

impl Obstructed {
    /// Converts to an error with the word and the residual.
    pub fn error(self) -> Error {
        let Self { obstacle, residual, word } = self;
        let reason = match obstacle {
            Obstacle::Refused(error) => return error,
            Obstacle::Order => "the order of the events changes".to_owned(),
            Obstacle::Singular => "the equations are singular: there is a family of orbits".to_owned(),
            _ => "Newton's method does not converge".to_owned(),
        };
        let problem = format!(
            "no orbit with the events [{word}] was found: {reason} (residual {residual:e}, \
             relative to the size of the motion); try a start nearer to the orbit"
        );
        Error::Described { problem }
    }
}

/// Newton's method for an orbit at fixed parameters.
pub(super) fn newton(
    problem: &Problem,
    place: &Place,
    guess: &DVector<f64>,
) -> std::result::Result<DVector<f64>, (Obstacle, f64)> {
    let (mut u, mut residual, mut before) = (guess.clone(), f64::INFINITY, f64::INFINITY);
    let size = problem.size();
    for _ in 0..STEPS {
        let at = problem.residual(place, &u, true).map_err(|o| (o, residual))?;
        let (value, matrix) = (at.value, at.matrix);
        residual = value.amax();
        let matrix = matrix.ok_or((Obstacle::NoConvergence, residual))?;
        let step = least_step(matrix, &value).ok_or((Obstacle::Singular, residual))?;
        let length = step.norm();
        let mut part = (LONGEST_STEP / length).min(1.0);
        part = part.min(problem.orderly(place, &u, &step));
        u.rows_mut(0, size).axpy(part, &step, 1.0);
        let is_done = length < problem.rounding() * (1.0 + u.norm());
        let has_stalled = length < problem.stalled() && length > 0.5 * before;
        if part == 1.0 && (is_done || has_stalled) {
            return Ok(u);
        }
        before = length;
    }
    Err((Obstacle::NoConvergence, residual))
}

/// The shortest step that solves the linearized equations. For a family of orbits the equations
/// are singular, and the step has no component along the family.
fn least_step(matrix: DMatrix<f64>, value: &DVector<f64>) -> Option<DVector<f64>> {
    if !matrix.iter().chain(value.iter()).all(|x| x.is_finite()) {
        return None;
    }
    let lu = matrix.clone().lu();
    let diagonal = lu.lu_internal().diagonal().abs();
    if diagonal.min() > FAMILY * diagonal.max() {
        return lu.solve(&-value).filter(|step| step.iter().all(|x| x.is_finite()));
    }
    let svd = matrix.try_svd(true, true, f64::EPSILON, 0)?;
    let cutoff = FAMILY * svd.singular_values.max();
    svd.solve(&-value, cutoff).ok()
}

/// The eigenvalues of a matrix in any order; `None` if the Schur decomposition fails.
pub(super) fn eigenvalues(matrix: DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    if !matrix.iter().all(|x| x.is_finite()) {
        return None;
    }
    let sweeps = SWEEPS * matrix.nrows().max(1);
    Some(Schur::try_new(matrix, f64::EPSILON, sweeps)?.complex_eigenvalues().iter().copied().collect())
}

/// Sorts multipliers by modulus, largest first; in a conjugate pair, by imaginary part.
pub(super) fn sort(multipliers: &mut [Complex<f64>]) {
    sort_by(multipliers, |a, b| b.norm().total_cmp(&a.norm()).then(b.im.total_cmp(&a.im)));
}

/// The eigenvalues of a monodromy matrix, largest first; the `trivial` nearest to 1 come last.
pub(super) fn multipliers(matrix: DMatrix<f64>, trivial: usize) -> Option<Vec<Complex<f64>>> {
    let mut all = eigenvalues(matrix)?;
    sort_by(&mut all, |a, b| (a - 1.0).norm().total_cmp(&(b - 1.0).norm()));
    let mut rest = all.split_off(trivial.min(all.len()));
    sort(&mut rest);
    rest.extend(all);
    Some(rest)
}

impl Orbit {
    /// The orbit with given unknowns.
    pub(super) fn at(problem: Problem, place: Place, u: DVector<f64>) -> std::result::Result<Self, Obstacle> {
        let cycle = problem.cycle(&place, &u)?;
        Self::of_cycle(problem, place, u, cycle)
    }

    /// The orbit of a periodic cycle.
    pub(super) fn of_cycle(
        problem: Problem,
        place: Place,
        u: DVector<f64>,
        cycle: Cycle,
    ) -> std::result::Result<Self, Obstacle> {
        let numbers = problem.numbers(&place, &u);
        let trivial = problem.directions.len() + usize::from(place.period.is_none());
        let units = &problem.units.state;
        let mut matrix = cycle.monodromy(&place, &problem.word)?;
        for i in 0..matrix.nrows() {
            for j in 0..matrix.ncols() {
                matrix[(i, j)] *= units[j] / units[i];
            }
        }
        let mut multipliers = multipliers(matrix, trivial).ok_or(Obstacle::NoConvergence)?;
        problem.sharpen((&place, &u), &mut multipliers, trivial)?;
        let conditions = cycle.conditions(&place, &problem.word);
        Ok(Self { problem, u, place: Arc::new(place), cycle, numbers, multipliers, trivial, conditions })
    }

    /// The machine.
    pub fn place(&self) -> &Place {
        &self.place
    }

    /// The events.
    pub fn word(&self) -> &Word {
        &self.problem.word
    }

    /// The flights of a period.
    pub fn legs(&self) -> &[Leg] {
        &self.cycle.legs
    }

    /// The period, s.
    pub fn period(&self) -> f64 {
        self.numbers.period
    }

    /// Times of the events, s, counted from the first common period of the drive.
    pub fn times(&self) -> &[f64] {
        if self.word().is_empty() { &[] } else { &self.numbers.times }
    }

    /// The state (q, q') after the first event, or at the start of an orbit without events.
    pub fn state(&self) -> &[f64] {
        &self.numbers.states[0]
    }

    /// Drift of each neutral direction of the state in a period, SI.
    pub fn drifts(&self) -> &[f64] {
        let count = self.problem.directions.iter().filter(|own| own.is_neutral()).count();
        &self.numbers.drifts[..count]
    }

    /// The sliders and frictions that stick for the whole period, if other places where they stick
    /// give other orbits.
    pub fn held(&self) -> Vec<Contact> {
        let mut all: Vec<Contact> = self.problem.directions.iter().flat_map(Direction::contacts).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// The nontrivial multipliers of the period, largest first. Neutral directions, places where
    /// contacts stick for the whole period and, for an autonomous machine, the shift in time have
    /// the multiplier 1 and are left out.
    ///
    /// A flight preserves areas of the ball's states, and an impact multiplies them by ε²:
    ///
    /// ```
    /// use vibro_orbits::{Orbit, Stability};
    /// use vibro_studies::{Machine, Start};
    ///
    /// # let text = r#"
    /// #     name = "Juggler"
    /// #     gravity = 10.0
    /// #     body.table = { motion = { amplitude = "4 mm", frequency = "5 Hz" } }
    /// #     body.ball = { mass = "20 g", gravity = -1.0, start = { v = 1.0 } }
    /// #     stop.table = { between = ["ball", "table"], gap = 0.0, restitution = 0.8 }
    /// # "#;
    /// let machine = Machine::parse(text, "juggler.toml", &vibro_machine::file::no_records)?;
    /// let orbit = Orbit::settled(&machine, &Start::default(), 400)?;
    /// let [a, b] = orbit.multipliers() else { panic!("a ball has two states") };
    /// assert!((a * b - 0.8 * 0.8).norm() < 1e-12);
    /// assert_eq!(orbit.stability(), Stability::Stable);
    /// # Ok::<(), vibro_studies::Error>(())
    /// ```
    pub fn multipliers(&self) -> &[Complex<f64>] {
        &self.multipliers[..self.multipliers.len() - self.trivial.min(self.multipliers.len())]
    }

    /// Number of trivial multipliers (1 by theory).
    pub fn trivial_multipliers(&self) -> usize {
        self.trivial
    }

    /// Largest modulus of the nontrivial multipliers; 0 if there are none.
    pub fn spectral_radius(&self) -> f64 {
        self.multipliers().first().map_or(0.0, |m| m.norm())
    }

    /// Whether the orbit attracts its neighbourhood.
    pub fn stability(&self) -> Stability {
        let radius = self.spectral_radius();
        // Near the orbit, stops that are hit together may be hit one after the other, and an event
        // function that hardly rises may not reach zero. A slider that hardly slips may stick
        // there.
        let slips = |letter: usize| matches!(self.word().letters[letter].watch(), Some(Watch::Yields(..)));
        let is_doubtful = |(condition, value): &(Condition, f64)| match condition {
            Condition::Together { .. } => true,
            Condition::Rises { .. } => *value < GRAZES,
            Condition::Lasts { letter } => *value < BRIEF_SLIP && slips(*letter),
            _ => false,
        };
        if self.conditions.iter().any(is_doubtful) && radius <= 1.0 + MARGIN {
            Stability::Undecided
        } else if radius < 1.0 - MARGIN {
            Stability::Stable
        } else if radius > 1.0 + MARGIN {
            Stability::Unstable
        } else if has_losses(&self.place) {
            Stability::Undecided
        } else {
            Stability::Neutral
        }
    }

    /// Whether the orbit is a motion of the machine: it reaches each of its events and no other.
    pub fn is_certified(&self) -> bool {
        self.broken().is_none()
    }

    /// The conditions under which the orbit is a motion of the machine, with their values.
    pub(super) fn conditions(&self) -> &[(Condition, f64)] {
        &self.conditions
    }

    /// The violated condition that is furthest from holding; `None` if all hold.
    pub(super) fn broken(&self) -> Option<(Condition, f64)> {
        let broken = self.conditions.iter().filter(|(condition, value)| condition.fails(*value));
        broken.min_by(|a, b| a.1.total_cmp(&b.1)).copied()
    }

    /// A start on the orbit, in the middle of its longest flight.
    pub fn start(&self) -> Start {
        let (time, z) = self.middle_state();
        let mut start = Start { time, ..Start::default() };
        let names = Start::names(&self.place.assembly);
        let d = &self.place.assembly.description;
        // The machine has all these names, so `set` cannot fail.
        names.iter().zip(&z).for_each(|(name, x)| _ = start.set(d, name, *x));
        start
    }

    /// Time and given state (q, q', inner displacements, stored values of blocks) in the middle of
    /// the longest flight.
    pub(super) fn middle_state(&self) -> (f64, Vec<f64>) {
        let (time, z) = middle(&self.place, self.longest());
        (time, self.place.assembly.system().given(&z))
    }

    fn longest(&self) -> &Leg {
        let legs = self.legs();
        let longest = (0..legs.len()).max_by(|a, b| legs[*a].span.total_cmp(&legs[*b].span));
        &legs[longest.unwrap_or(0)]
    }

    /// The value of the family's parameter.
    pub fn value(&self) -> f64 {
        self.problem.value(&self.u)
    }

    /// Whether the orbit has the events of a word, up to a cyclic shift.
    pub(super) fn has_word(&self, word: &Word) -> bool {
        same_word(self.word(), word)
    }

    /// Whether another orbit of this machine is the same, up to a cyclic shift of its events.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        if !same_word(self.word(), other.word()) {
            return false;
        }
        let m = self.word().len();
        if m == 0 {
            return self.passes_start_of(other);
        }
        let is_near = |k: usize| {
            let turns = self.place.period.map_or(0.0, |p| (self.legs()[k].time - other.legs()[0].time) / p);
            self.is_at(&self.legs()[k].states[0], other) && (turns - turns.round()).abs() < SAME
        };
        (0..m).any(|k| self.word().is_from(k, other.word()) && is_near(k))
    }

    /// Whether a state of this orbit is the first state of another orbit.
    fn is_at(&self, state: &[f64], other: &Self) -> bool {
        let pairs = state.iter().zip(other.state()).zip(&self.problem.units.state);
        pairs.map(|((a, b), unit)| ((a - b) / unit).abs()).fold(0.0, f64::max) < SAME
    }

    /// Whether an orbit without events passes the first state of another orbit at the same phase of
    /// the drive. A machine with curved forces may have several orbits without events.
    fn passes_start_of(&self, other: &Self) -> bool {
        let Some(period) = self.place.period else { return true };
        let (leg, shift) = (&self.legs()[0], other.legs()[0].time - self.legs()[0].time);
        let laps = (leg.span / period).round().max(1.0);
        (0..laps as u32).any(|lap| {
            let part = (shift / leg.span + f64::from(lap) / laps).rem_euclid(1.0);
            self.is_at(&within(&self.place, leg, part).1, other)
        })
    }
}

/// Whether two words have the same events, up to a cyclic shift.
pub(super) fn same_word(a: &Word, b: &Word) -> bool {
    (0..a.len().max(1)).any(|k| a.is_from(k, b))
}

/// Time and augmented state in the middle of a flight, projected onto the closed contacts.
pub(super) fn middle(place: &Place, leg: &Leg) -> (f64, Vec<f64>) {
    within(place, leg, 0.5)
}

/// Time and augmented state after a part of a flight, projected onto the closed contacts.
pub(super) fn within(place: &Place, leg: &Leg, part: f64) -> (f64, Vec<f64>) {
    let time = leg.time + part * leg.span;
    let begin = leg.parts().take_while(|own| own.time <= time).last();
    let (from, start) = begin.map_or((leg.time, &leg.states[0][..]), |own| (own.time, own.start));
    let mut z = leg.flow.after(start, time - from);
    let system = place.assembly.system();
    with_signals(system, time, &mut z);
    keep(system, &leg.flow.mode, &mut z);
    (time, z)
}

/// Whether anything dissipates energy in a machine; blocks count as losses.
fn has_losses(place: &Place) -> bool {
    let system = place.assembly.system();
    !system.blocks.is_empty()
        || system.springs.iter().any(|spring| spring.has_losses())
        || system.curved.iter().any(|curved| curved.is_of_rate)
        || !system.frictions.is_empty()
        || system.stops.iter().any(|stop| match stop.restitution() {
            Some(restitution) => restitution < 1.0,
            None => stop.force != stop.spring,
        })
}
