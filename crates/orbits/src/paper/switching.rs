//! Starts of branches: at settled orbits, at bifurcations of another branch, at touches.

use super::cycle::{Cycle, Functional};
use super::family::{ContactEquations, Family};
use super::grazing::{self, Touch, Touching};
use super::orbit::{Orbit, canonical, repeated_phases, unfolded_phases};
use crate::branch::Special;
use crate::curve::{axis, least_vectors, tangent};
use crate::label::Label;
use crate::obstacle::Obstacle;
use crate::stop_word::{OrbitWord, REPETITION};
use nalgebra::{Complex, DVector};

/// First steps from an orbit, and from a point where branches meet.
const FIRST_STEP: f64 = 1e-2;
const SWITCH_STEP: f64 = 1e-3;

/// Step of the difference that determines the side of a touch on which the block clears the stop.
const SIDE_STEP: f64 = 1e-5;

/// Start of a path, with the multipliers at a touch, if the cycle does not give them.
pub(super) type Departure = crate::path::Departure<Option<[Complex<f64>; 6]>>;

/// A touch within a flight of the shortest word that does not list it. All words that meet at a
/// touch share one `FlightTouch`.
#[derive(Clone, Debug)]
pub(super) struct FlightTouch {
    /// The shortest word without the touch.
    pub shorter: OrbitWord,
    /// Phases and parameter.
    pub u: DVector<f64>,
    /// The flight with the touch.
    pub flight: usize,
    /// The phase of the touch.
    pub phase: f64,
    /// The stop.
    pub side: i8,
}

impl FlightTouch {
    /// The touch of a branch in the shortest word without it.
    pub fn of(family: &Family, touch: &Touch) -> Self {
        let values = family.values(&touch.u);
        let (phase, side) = (touch.u[touch.index], touch.longer.letters()[touch.index]);
        let kept: Vec<usize> =
            (0..touch.longer.len()).filter(|i| *i != touch.index && !touch.also.contains(i)).collect();
        let n = kept.len();
        if n == 0 {
            let word = free_word(family);
            return Self { shorter: word, u: family.point(&[], &values), flight: 0, phase, side };
        }
        let letters = kept.iter().map(|i| touch.longer.letters()[*i]).collect();
        let shorter = OrbitWord::of(letters, touch.longer.closing(), touch.longer.half_periods());
        let phases: Vec<f64> = kept.iter().map(|i| touch.u[*i]).collect();
        let (reduced, phases) = shorter.reduced(&phases, family.is_symmetric(), REPETITION);
        // A touch before the first impact equals a touch after the last one, one repetition later.
        let (flight, phase, side) = match kept.iter().filter(|i| **i < touch.index).count() {
            0 => (n - 1, phase + shorter.span(), side * shorter.closing()),
            before => (before - 1, phase, side),
        };
        let round = flight / reduced.len();
        let sign = if round % 2 == 1 { reduced.closing() } else { 1 };
        Self {
            u: family.point(&phases, &values),
            flight: flight % reduced.len(),
            phase: phase - round as f64 * reduced.span(),
            side: side * sign,
            shorter: reduced,
        }
    }

    /// The words that list the touch. The first word lists it once in each repetition. A symmetric
    /// orbit touches both stops; its unfolded word lists the touch at one of them. If
    /// `repetitions` exceeds 1, further words have up to this number of repetitions and list the
    /// touch in one of them. Such words belong to orbits of longer periods.
    pub fn longer(&self, family: &Family, repetitions: u32) -> Vec<Touch> {
        let phases = &self.u.as_slice()[..self.shorter.len()];
        let index = if phases.is_empty() { 0 } else { self.flight + 1 };
        let touch = |word: &OrbitWord, mut phases: Vec<f64>| {
            phases.insert(index, self.phase);
            let u = family.point(&phases, &family.values(&self.u));
            Touch { longer: word.inserted(index, self.side), index, u, also: Vec::new(), from_longer: false }
        };
        let unfolded = (self.shorter.closing() < 0)
            .then(|| (self.shorter.unfolded(), unfolded_phases(&self.shorter, phases)));
        let own = (self.shorter.clone(), phases.to_vec());
        let passages = |(word, phases): (OrbitWord, Vec<f64>)| {
            // A symmetric orbit closes with -1 after an odd number of repetitions.
            let step = if word.closing() < 0 { 2 } else { 1 };
            let repeated = |k| touch(&word.repeated(k), repeated_phases(&word, &phases, k));
            (1..=repetitions as usize).step_by(step).map(repeated).collect::<Vec<_>>()
        };
        std::iter::once(own).chain(unfolded).flat_map(passages).collect()
    }

    /// Departure of the branch without the touch, to the side where the block clears the stop.
    pub fn departure(&self, family: &Family) -> Result<Departure, Obstacle> {
        let n = self.shorter.len();
        let contacts = ContactEquations { family, word: &self.shorter };
        let along = tangent(&contacts, &self.u, &axis(n + 1, n))?;
        let excess = |step: f64| -> Result<f64, Obstacle> {
            let u = &self.u + &along * step;
            let system = family.system_at(&u)?;
            let cycle = Cycle::new(&system, &self.shorter, &u.as_slice()[..n])?;
            let since = self.phase - u[self.flight];
            let z = system.fly(since, cycle.departure(self.flight));
            Ok(f64::from(self.side) * (z[1] - z[0] + system.forced_gap(self.phase)[0]))
        };
        // A shift of the extremum changes its value only in second order.
        let leaves = excess(SIDE_STEP)? - excess(-SIDE_STEP)? < 0.0;
        let direction = if leaves { along } else { -along };
        at_touch(family, (&self.u, direction), &self.shorter, &self.u.as_slice()[..n])
    }
}

/// The empty word of a family.
pub(super) fn free_word(family: &Family) -> OrbitWord {
    if family.is_symmetric() { OrbitWord::of(Vec::new(), -1, 1) } else { OrbitWord::of(Vec::new(), 1, 2) }
}

/// Departure of the branch with the touch, to the side where the impact has a positive speed.
pub(super) fn with_touch(family: &Family, touch: &Touch) -> Result<Departure, Obstacle> {
    let n = touch.longer.len();
    let contacts = ContactEquations { family, word: &touch.longer };
    let along = tangent(&contacts, &touch.u, &axis(n + 1, n))?;
    let gradient = grazing::speed_gradient(&Touching { contacts, index: touch.index }, &touch.u)?;
    let direction = if gradient.dot(&along) > 0.0 { along } else { -along };
    at_touch(family, (&touch.u, direction), &touch.shorter(), &touch.without().as_slice()[..n - 1])
}

/// Departure from a touch, with the multipliers of the orbit without the touching impact.
fn at_touch(
    family: &Family,
    (u, direction): (&DVector<f64>, DVector<f64>),
    shorter: &OrbitWord,
    phases: &[f64],
) -> Result<Departure, Obstacle> {
    let of = Some(Orbit::at(&family.system_at(u)?, shorter, phases)?.multipliers());
    let special = Some(Special::of(Label::Grazing));
    Ok(Departure { u: u.clone(), direction, step: SWITCH_STEP, special, of })
}

/// Departure of the branch born by doubling. It starts from a point with a multiplier -1, along
/// the variation that closes with the opposite sign. One direction suffices: the other leads to
/// the same orbits, half a span later.
pub(super) fn doubled(
    family: &Family,
    word: &OrbitWord,
    u: &DVector<f64>,
    label: Label,
) -> Result<(OrbitWord, Departure), Obstacle> {
    let n = word.len();
    let system = family.system_at(u)?;
    let phases = &u.as_slice()[..n];
    let cycle = Cycle::new(&system, word, phases)?;
    let matrix = cycle.derivative(Functional::Gap, -1.0).ok_or(Obstacle::Singular)?;
    let null = least_vectors(matrix).ok_or(Obstacle::NoConvergence)?.1;
    let size = std::f64::consts::SQRT_2;
    let direction = DVector::from_fn(2 * n + 1, |i, _| match i {
        i if i < n => null[i] / size,
        i if i < 2 * n => -null[i - n] / size,
        _ => 0.0,
    });
    let doubled = unfolded_phases(word, phases);
    let departure = Departure {
        u: family.point(&doubled, &family.values(u)),
        direction,
        step: SWITCH_STEP,
        special: Some(Special::of(label)),
        of: None,
    };
    Ok((word.unfolded(), departure))
}

/// Departures from an orbit in both directions, the parameter rising and falling, in its canonical
/// word.
pub(super) fn both_ways(
    family: &Family,
    word: &OrbitWord,
    phases: &[f64],
    value: f64,
) -> Result<(OrbitWord, [Departure; 2]), Obstacle> {
    let (word, phases) = canonical(word, phases, family.is_symmetric());
    let u = family.point(&phases, &[value]);
    let along = tangent(&ContactEquations { family, word: &word }, &u, &axis(word.len() + 1, word.len()))?;
    let departure =
        |direction| Departure { u: u.clone(), direction, step: FIRST_STEP, special: None, of: None };
    Ok((word.clone(), [departure(along.clone()), departure(-along)]))
}

/// A departure in the shortest word of its orbit. If a repeated orbit touches a stop in each
/// repetition, the branch that lists all these touches also repeats the branch of a shorter word.
pub(super) fn reduced_departure(
    family: &Family,
    word: &OrbitWord,
    departure: &Departure,
) -> (OrbitWord, Departure) {
    let n = word.len();
    let (least, phases) = word.reduced(&departure.u.as_slice()[..n], family.is_symmetric(), REPETITION);
    let m = least.len();
    let rates = &departure.direction;
    let repeats = (m..n).all(|i| (rates[i] - rates[i - m]).abs() < REPETITION);
    if m == n || !repeats {
        return (word.clone(), departure.clone());
    }
    let u = family.point(&phases, &family.values(&departure.u));
    let direction = DVector::from_fn(m + 1, |i, _| if i < m { rates[i] } else { rates[n] }).normalize();
    (least, Departure { u, direction, ..departure.clone() })
}

/// A departure in the canonical word, so that one orbit has one start in a tree.
pub(super) fn canonical_departure(
    family: &Family,
    word: &OrbitWord,
    departure: &Departure,
) -> (OrbitWord, Departure) {
    let n = word.len();
    let (canonical, turn) = word.canonical_turn(family.is_symmetric());
    let phases = word.turned_phases(&departure.u.as_slice()[..n], turn);
    let (u, rates) = (&departure.u, &departure.direction);
    let u = DVector::from_fn(n + 1, |i, _| if i < n { phases[i] } else { u[n] });
    let direction = DVector::from_fn(n + 1, |i, _| if i < n { rates[(i + turn.by) % n] } else { rates[n] });
    (canonical, Departure { u, direction, ..departure.clone() })
}
