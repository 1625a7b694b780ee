//! One periodic orbit: found by Newton's method from a guess of its impact phases, certified, with
//! its multipliers.

use super::cycle::{Cycle, Functional};
use super::flights;
use super::obstacle::Obstacle;
use super::system::System;
use super::word::{OrbitWord, REPETITION};
use nalgebra::{Complex, Matrix6};
use std::f64::consts::TAU;
use vibro_analysis::Error;
use vibro_impact::State;
use vibro_impact::steady::exact_orbit::Vector6;
pub(super) use vibro_impact::steady::exact_orbit::eigenvalues;

/// Most Newton steps: a fair guess needs four or five. Steps that would change the order of impacts
/// are shortened.
const STEPS: usize = 40;

/// Relative size of a Newton step below which the iteration has converged: the next is rounding.
pub(super) const STEP_ROUNDING: f64 = 1e-12;

/// Size of a Newton step, rad, below which one that is not half of the last is rounding: the
/// equations of many fast impacts leave phases fewer digits.
pub(super) const STEP_STALLED: f64 = 1e-9;

/// Longest Newton step, rad: next to a fold they are much longer and lead anywhere.
const LONGEST_STEP: f64 = 1.0;

/// Largest residual, units of L, of phases that count as those of an orbit.
const RESIDUAL: f64 = 1e-9;

/// Largest part of a flight by which one step may shorten it.
const SHORTENING: f64 = 0.5;

/// A periodic orbit of a machine.
///
/// ```
/// use vibro_orbits::{Orbit, OrbitWord, System};
/// use vibro_impact::{Parameters, steady::exact_orbit};
///
/// // Two symmetric impacts a period: one upper impact in half a period, closed with -1.
/// let system = System::new(&Parameters::default())?;
/// let orbit = Orbit::find(&system, &OrbitWord::new("U", -1, 1)?, &[5.5])?;
/// let closed_form = exact_orbit::solve(&Parameters::default())?.upper.expect("an orbit");
/// assert!((orbit.phases()[0] - closed_form.drive_phase()).abs() < 1e-12);
/// assert!(orbit.is_certified() && orbit.is_stable());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Orbit {
    system: System,
    word: OrbitWord,
    phases: Vec<f64>,
    /// z, the state less the motion without impacts, after each impact.
    departures: Vec<Vector6>,
    speeds: Vec<f64>,
    multipliers: [Complex<f64>; 6],
    clear: bool,
}

impl Orbit {
    /// The orbit of a word near a guess of its impact phases (rad, in order, one for each letter).
    /// It solves the equations of contact and restitution; [`is_certified`](Self::is_certified)
    /// tells whether it is an orbit of the machine.
    ///
    /// # Errors
    /// [`Error::NoOrbit`] when Newton's method does not converge, for a guess with another number
    /// of phases than the word has letters, and for a symmetric orbit of a machine under loads; an
    /// error with the parameter's name where phases do not determine the orbit: a block without a
    /// spring, an undamped mode in resonance.
    pub fn find(system: &System, word: &OrbitWord, guess: &[f64]) -> Result<Self, Error> {
        let found = || {
            if guess.len() != word.len() {
                return Err(Obstacle::Order);
            }
            Obstacle::check(system, word)?;
            let near = |system: &System| Self::at(system, word, &newton(system, word, guess)?);
            let first = near(system);
            if first.as_ref().is_ok_and(Self::is_certified) {
                return first;
            }
            let anchors = system.resonant_anchors(word).into_iter().flatten();
            let mut anchored = anchors.filter_map(|anchor| near(&system.anchored(Some(anchor))).ok());
            anchored.find(Self::is_certified).map_or(first, Ok)
        };
        found().map_err(|obstacle| obstacle.error(system, word))
    }

    /// The orbit whose phases are known.
    pub(super) fn at(system: &System, word: &OrbitWord, phases: &[f64]) -> Result<Self, Obstacle> {
        if word.is_empty() {
            let free = free_map(system, word) * f64::from(word.closing());
            let (departures, speeds) = (Vec::new(), Vec::new());
            let clearance = system.clearance().ok_or(Obstacle::Unbalanced)?;
            let clear = clearance >= -flights::PENETRATION_ROUNDING;
            let multipliers = eigenvalues(free).ok_or(Obstacle::NoConvergence)?;
            return Ok(Self {
                system: system.at_rest(),
                word: word.clone(),
                phases: Vec::new(),
                departures,
                speeds,
                multipliers,
                clear,
            });
        }
        let cycle = Cycle::new(system, word, phases)?;
        let multipliers = eigenvalues(cycle.monodromy()).ok_or(Obstacle::NoConvergence)?;
        let departures = (0..word.len()).map(|i| *cycle.departure(i)).collect();
        Ok(Self {
            system: *system,
            word: word.clone(),
            departures,
            speeds: (0..word.len()).map(|i| cycle.speed(i)).collect(),
            clear: is_clear(&cycle),
            multipliers,
            phases: phases.to_vec(),
        })
    }

    /// The machine.
    pub fn system(&self) -> &System {
        &self.system
    }

    /// The impact word.
    pub fn word(&self) -> &OrbitWord {
        &self.word
    }

    /// The phases of the drive at the impacts, rad, in the order of the word.
    pub fn phases(&self) -> &[f64] {
        &self.phases
    }

    /// Approach speeds |w'⁻| of the impacts in units of ω1 L; one that is not positive is no impact
    /// of the machine.
    pub fn speeds(&self) -> &[f64] {
        &self.speeds
    }

    /// The six multipliers, docs/theory.md (106), largest modulus first: those of half a period for
    /// a symmetric orbit (closing -1), whose squares are those of the period.
    pub fn multipliers(&self) -> [Complex<f64>; 6] {
        self.multipliers
    }

    /// Largest modulus of the multipliers.
    pub fn spectral_radius(&self) -> f64 {
        self.multipliers[0].norm()
    }

    /// Whether the orbit is proved to be one of the machine: each impact approaches its stop,
    /// without restitution the block does not stay there, and in between it keeps within the stops,
    /// so that there is no impact that the word does not list. The proof allows 1e-12 L, the misses
    /// of contact of the impacts (at most 1e-9 L), and the rounding of the flights, which is larger
    /// where a mode is thousands of times faster than the drive or the undamped box is near
    /// resonance.
    pub fn is_certified(&self) -> bool {
        self.clear && self.speeds.iter().all(|speed| *speed > 0.0)
    }

    /// Whether the orbit attracts its neighbourhood. Without impacts the machine decides, since the
    /// multipliers of a body that no spring holds or nothing damps have modulus 1 except for
    /// rounding.
    pub fn is_stable(&self) -> bool {
        if self.word.is_empty() { self.system.holds_and_damps() } else { self.spectral_radius() < 1.0 }
    }

    /// This orbit with its word passed twice, closing with +1.
    ///
    /// # Errors
    /// None for an orbit that was found.
    pub fn unfolded(&self) -> Result<Self, Error> {
        let phases = unfolded_phases(&self.word, &self.phases);
        let word = self.word.unfolded();
        Self::at(&self.system, &word, &phases).map_err(|obstacle| obstacle.error(&self.system, &word))
    }

    /// The shortest word of this orbit, and how often this one's word passes it. A motion of two
    /// drive periods may be one of a single period passed twice, and one whose second half is the
    /// mirror image of its first is a symmetric orbit, which closes with -1. The multipliers are
    /// those of the shortest word.
    ///
    /// ```
    /// use vibro_orbits::{Orbit, OrbitWord, System};
    /// use vibro_impact::Parameters;
    ///
    /// let system = System::new(&Parameters::default())?;
    /// let guess = [5.5, 8.6, 11.8, 14.9]; // rad
    /// let twice = Orbit::find(&system, &OrbitWord::new("ULUL", 1, 4)?, &guess)?;
    /// let (orbit, passages) = twice.shortest();
    /// assert_eq!((orbit.word().signed(), passages), ("U-".into(), 2));
    /// // Four halves of a period in two periods.
    /// assert!((twice.spectral_radius() - orbit.spectral_radius().powi(4)).abs() < 1e-9);
    /// # Ok::<(), vibro_analysis::Error>(())
    /// ```
    pub fn shortest(&self) -> (Self, u32) {
        let (word, phases) = self.word.reduced(&self.phases, self.system.is_symmetric(), REPETITION);
        // The shorter word passes these phases, whose cycle is regular.
        let short = if word == self.word { None } else { Self::at(&self.system, &word, &phases).ok() };
        let orbit = short.unwrap_or_else(|| self.clone());
        let passages = self.word.period() / orbit.word.period().max(1);
        (orbit, passages)
    }

    /// Whether no shorter word has this orbit.
    pub fn is_shortest(&self) -> bool {
        self.word.reduced(&self.phases, self.system.is_symmetric(), REPETITION).0 == self.word
    }

    /// Drive periods over which the [`multipliers`](Self::multipliers) act: the orbit's period, or
    /// half of it for a symmetric orbit.
    pub fn multiplier_periods(&self) -> f64 {
        0.5 * f64::from(self.word.half_periods())
    }

    /// The state at phase θ (rad) of the drive; at an impact, the one just after it. A motion of
    /// several drive periods has as many states at one phase of the drive, so θ, which must be
    /// finite, counts from the first period of its [`phases`](Self::phases).
    pub fn state(&self, theta: f64) -> State {
        self.system.si(&self.dimensionless_state(theta))
    }

    /// The state at phase θ in units of L and ω1 L.
    fn dimensionless_state(&self, theta: f64) -> Vector6 {
        let Some(&first) = self.phases.first() else { return self.system.forced(theta) };
        let span = self.word.span();
        let whole = TAU * f64::from(self.word.period());
        let mut since = (within(theta, self.word.period()) - first).rem_euclid(whole);
        let mut sign = 1.0;
        if since >= span {
            (since, sign) = (since - span, f64::from(self.word.closing()));
        }
        let flight = self.phases.iter().rposition(|phase| *phase <= first + since).unwrap_or(0);
        let elapsed = (first + since - self.phases[flight]).max(0.0);
        let free = self.system.fly(elapsed, &self.departures[flight]);
        sign * (free + self.system.forced(first + since))
    }

    /// The state at time 0, where the phase of the drive is
    /// [`drive_phase`](vibro_impact::Parameters::drive_phase): start values for the simulator and
    /// the FMU.
    pub fn start_state(&self) -> State {
        self.state(self.system.parameters().drive_phase)
    }

    /// The flights from each impact: the free part of the state after it, its phase and the span to
    /// the next.
    fn flights(&self) -> impl Iterator<Item = (&Vector6, f64, f64)> {
        let end = self.phases.first().map(|first| first + self.word.span());
        let ends = self.phases.iter().skip(1).copied().chain(end);
        self.departures.iter().zip(&self.phases).zip(ends).map(|((z, phase), end)| (z, *phase, end - phase))
    }

    /// Local maxima of a displacement with weights of x1, x2, x3 over the orbit's period, units of
    /// L: extrema of the flights, and corners where an impact reverses the rate.
    pub fn maxima(&self, weights: [f64; 3]) -> Vec<f64> {
        let mut found = self.half_maxima(weights);
        if self.word.closing() < 0 {
            // The other half of the period is the mirror image.
            found.extend(self.half_maxima(weights.map(|w| -w)));
        }
        found
    }

    /// The local maxima until the word closes.
    fn half_maxima(&self, weights: [f64; 3]) -> Vec<f64> {
        if self.word.is_empty() {
            let rest: f64 = self.system.rest_positions().iter().zip(weights).map(|(x, w)| x * w).sum();
            return vec![rest + (weights[0] * self.system.amplitude()).abs()];
        }
        let dot = |y: &Vector6, from: usize| (0..3).map(|i| weights[i] * y[from + i]).sum::<f64>();
        let mut found = Vec::new();
        for (z, phase, span) in self.flights() {
            found.extend(flights::maxima(&self.system, z, phase, span, weights).into_iter().map(|m| m.1));
        }
        let closing = f64::from(self.word.closing());
        let arrivals = self.flights().enumerate().map(|(i, (z, phase, span))| {
            let forced = self.system.forced(phase + span);
            let before = self.system.fly(span, z) + forced;
            let last = i + 1 == self.word.len();
            let after = if last { closing * self.departures[0] } else { self.departures[i + 1] } + forced;
            (before, after)
        });
        found.extend(arrivals.filter(|(b, a)| dot(b, 3) > 0.0 && dot(a, 3) <= 0.0).map(|(b, _)| dot(&b, 0)));
        found
    }

    /// Whether another orbit of the same machine is this one: the same word, and phases equal to
    /// `tolerance` (rad) for some first letter and, without loads, for the mirror image too.
    pub fn is_same(&self, other: &Self, tolerance: f64) -> bool {
        let mirror = self.system.is_symmetric();
        let [own, their] = [self, other].map(|o| canonical(&o.word, &o.phases, mirror));
        own.0 == their.0 && same_phases(&own.0, &own.1, &their.1, mirror, tolerance)
    }
}

/// The canonical word of an orbit with its phases.
pub(super) fn canonical(word: &OrbitWord, phases: &[f64], mirror: bool) -> (OrbitWord, Vec<f64>) {
    let (canonical, turn) = word.canonical_turn(mirror);
    let phases = word.turned_phases(phases, turn);
    (canonical, phases)
}

/// Whether two lists of phases with the same word are those of one orbit, to `tolerance`.
pub(super) fn same_phases(word: &OrbitWord, a: &[f64], b: &[f64], mirror: bool, tolerance: f64) -> bool {
    word.symmetries(mirror).into_iter().any(|turn| {
        let turned = word.turned_phases(b, turn);
        let Some(shift) = turned.first().zip(a.first()).map(|(b, a)| ((b - a) / TAU).round() * TAU) else {
            return true;
        };
        a.iter().zip(&turned).all(|(a, b)| (b - shift - a).abs() < tolerance)
    }) || word.is_empty()
}

/// The phases of the word passed twice.
pub(super) fn unfolded_phases(word: &OrbitWord, phases: &[f64]) -> Vec<f64> {
    repeated_phases(word, phases, 2)
}

/// The phases of the word passed k times.
pub(super) fn repeated_phases(word: &OrbitWord, phases: &[f64], k: usize) -> Vec<f64> {
    (0..k).flat_map(|round| phases.iter().map(move |phase| phase + round as f64 * word.span())).collect()
}

/// A phase reduced to some drive periods, rad, where it has so many turns that differences from
/// others would keep few digits.
fn within(theta: f64, periods: u32) -> f64 {
    const MANY: f64 = 1e3;
    if theta.abs() <= MANY {
        return theta;
    }
    let turn = theta.sin().atan2(theta.cos());
    turn + TAU * ((theta - turn) / TAU).round().rem_euclid(f64::from(periods))
}

/// Whether it is proved that the block leaves its stop after all impacts and keeps within the stops
/// in all flights, except for the misses of contact at their ends.
pub(super) fn is_clear(cycle: &Cycle) -> bool {
    (0..cycle.phases.len()).all(|i| {
        let span = cycle.arrival(i) - cycle.phases[i];
        let contact = cycle.contact_errors(i).iter().sum::<f64>();
        contact < RESIDUAL
            && !cycle.stays(i)
            && flights::is_clear(cycle.system, cycle.departure(i), cycle.phases[i], span, contact)
    })
}

/// exp(A Θ), the map of the motion without impacts until it closes.
fn free_map(system: &System, word: &OrbitWord) -> Matrix6<f64> {
    let transition = system.flight.transition(word.span());
    let columns = [0, 1, 2, 3, 4, 5].map(|i| transition.apply(&Vector6::ith(i, 1.0)));
    Matrix6::from_columns(&columns)
}

/// The phases at which the residual is zero, by Newton's method from a guess. A step that would
/// take more than half of a flight is shortened, so that the impacts keep their order.
pub(super) fn newton(system: &System, word: &OrbitWord, guess: &[f64]) -> Result<Vec<f64>, Obstacle> {
    let mut phases = guess.to_vec();
    let n = phases.len();
    if n == 0 {
        return Ok(phases);
    }
    let mut last = f64::INFINITY;
    for _ in 0..STEPS {
        let cycle = Cycle::new(system, word, &phases)?;
        let matrix = cycle.derivative(Functional::Gap, 1.0).ok_or(Obstacle::Singular)?;
        let step = matrix.lu().solve(&-cycle.residual_vector()).ok_or(Obstacle::NoConvergence)?;
        let mut part = (LONGEST_STEP / step.amax()).min(1.0);
        for i in 0..n {
            let span = cycle.arrival(i) - phases[i];
            let shorter = step[i] - step[(i + 1) % n];
            if shorter > SHORTENING * span {
                part = part.min(SHORTENING * span / shorter);
            }
        }
        if !step.iter().all(|x| x.is_finite()) {
            return Err(Obstacle::NoConvergence);
        }
        let small = cycle.residual.iter().all(|r| r.abs() < RESIDUAL);
        phases.iter_mut().zip(&step).for_each(|(phase, step)| *phase += part * step);
        let size = phases.iter().fold(1.0, |most: f64, phase| most.max(phase.abs()));
        let length = step.amax();
        if length < STEP_ROUNDING * size || (length < STEP_STALLED && length > 0.5 * last) {
            return if small { Ok(phases) } else { Err(Obstacle::NoConvergence) };
        }
        last = length;
    }
    Err(Obstacle::NoConvergence)
}
