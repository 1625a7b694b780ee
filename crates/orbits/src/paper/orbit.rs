//! One periodic orbit: found by Newton's method from a guess of its impact phases, certified, with
//! its multipliers.

use super::cycle::{Cycle, Functional};
use super::flights;
use super::system::System;
use crate::curve::{STEP_ROUNDING, STEP_STALLED};
use crate::obstacle::Obstacle;
use crate::stop_word::{OrbitWord, REPETITION};
use nalgebra::{Complex, Matrix6};
use std::f64::consts::TAU;
use vibro_impact::State;
use vibro_impact::steady::exact_orbit::Vector6;
pub(super) use vibro_impact::steady::exact_orbit::eigenvalues;
use vibro_studies::Error;

/// Largest number of Newton steps. A fair guess needs four or five; more are needed if steps are
/// shortened to keep the order of impacts.
const STEPS: usize = 40;

/// Largest change of a phase in one Newton step, rad. Near a fold, unlimited steps are much longer
/// and lead to arbitrary phases.
const LONGEST_STEP: f64 = 1.0;

/// Tolerance for the residual of an orbit, units of L.
const RESIDUAL: f64 = 1e-9;

/// Limit of a flight's shortening in one Newton step, as a fraction of the flight.
const SHORTENING: f64 = 0.5;

/// A periodic orbit of a machine.
///
/// ```
/// use vibro_orbits::paper::{Orbit, OrbitWord, System};
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
    /// z, the state minus the motion without impacts, after each impact.
    departures: Vec<Vector6>,
    speeds: Vec<f64>,
    multipliers: [Complex<f64>; 6],
    clear: bool,
}

impl Orbit {
    /// The orbit of a word near a guess of its impact phases (rad, in order, one for each letter).
    /// It solves the equations of contact and restitution. Use
    /// [`is_certified`](Self::is_certified) to check that it is an orbit of the machine.
    ///
    /// # Errors
    /// [`Error::NoOrbit`] if Newton's method does not converge, if the number of phases in `guess`
    /// differs from the number of letters in `word`, if `word` closes with -1 and there are loads,
    /// or if the impulses of `word` cannot balance on a body without a spring. An error that names
    /// the parameter if phases do not determine the orbit, as for two bodies without springs or an
    /// undamped mode in resonance.
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

    /// The orbit with known phases.
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

    /// Approach speeds s w'⁻ of the impacts, units of ω1 L, where s = ±1 is the stop. The machine
    /// can only have impacts with a positive approach speed.
    pub fn speeds(&self) -> &[f64] {
        &self.speeds
    }

    /// The six multipliers, docs/theory.md (106), largest modulus first. For a symmetric orbit
    /// (closing -1) they are the multipliers of half a period; their squares are the multipliers
    /// of the period.
    pub fn multipliers(&self) -> [Complex<f64>; 6] {
        self.multipliers
    }

    /// Largest modulus of the multipliers.
    pub fn spectral_radius(&self) -> f64 {
        self.multipliers[0].norm()
    }

    /// Whether the orbit is proved to be an orbit of the machine. Each impact approaches its stop,
    /// the block does not stay on a stop after an impact without restitution, and the block stays
    /// within the stops between impacts, so the word lists all impacts. The proof allows a
    /// penetration of a stop by 1e-12 L, by the contact errors at the impacts (at most 1e-9 L),
    /// and by the rounding of the flights. This rounding is larger if a mode is thousands of times
    /// faster than the drive or if the undamped box is near resonance.
    pub fn is_certified(&self) -> bool {
        self.clear && self.speeds.iter().all(|speed| *speed > 0.0)
    }

    /// Whether the orbit attracts its neighbourhood. Without impacts this follows from the
    /// machine's springs and dampers: a body without a spring or a damper has multipliers of
    /// modulus 1 except for rounding.
    pub fn is_stable(&self) -> bool {
        if self.word.is_empty() { self.system.holds_and_damps() } else { self.spectral_radius() < 1.0 }
    }

    /// This orbit with its word repeated twice, closing with +1.
    ///
    /// # Errors
    /// Never, for an orbit that was found.
    pub fn unfolded(&self) -> Result<Self, Error> {
        let phases = unfolded_phases(&self.word, &self.phases);
        let word = self.word.unfolded();
        Self::at(&self.system, &word, &phases).map_err(|obstacle| obstacle.error(&self.system, &word))
    }

    /// This orbit in its shortest word, and how often the word of `self` repeats it. An orbit over
    /// two drive periods may be an orbit of one period, repeated twice. An orbit whose second half
    /// mirrors its first is symmetric; its shortest word closes with -1. The multipliers refer to
    /// the shortest word.
    ///
    /// ```
    /// use vibro_orbits::paper::{Orbit, OrbitWord, System};
    /// use vibro_impact::Parameters;
    ///
    /// let system = System::new(&Parameters::default())?;
    /// let guess = [5.5, 8.6, 11.8, 14.9]; // rad
    /// let twice = Orbit::find(&system, &OrbitWord::new("ULUL", 1, 4)?, &guess)?;
    /// let (orbit, passages) = twice.shortest();
    /// assert_eq!((orbit.word().signed(), passages), ("U-".into(), 2));
    /// // Four halves of a period in two periods.
    /// assert!((twice.spectral_radius() - orbit.spectral_radius().powi(4)).abs() < 1e-9);
    /// # Ok::<(), vibro_studies::Error>(())
    /// ```
    pub fn shortest(&self) -> (Self, u32) {
        let (word, phases) = self.word.reduced(&self.phases, self.system.is_symmetric(), REPETITION);
        // The shorter word has some of these phases, whose cycle is regular.
        let short = if word == self.word { None } else { Self::at(&self.system, &word, &phases).ok() };
        let orbit = short.unwrap_or_else(|| self.clone());
        let passages = self.word.period() / orbit.word.period().max(1);
        (orbit, passages)
    }

    /// Whether the orbit has no shorter word.
    pub fn is_shortest(&self) -> bool {
        self.word.reduced(&self.phases, self.system.is_symmetric(), REPETITION).0 == self.word
    }

    /// Drive periods over which the [`multipliers`](Self::multipliers) act: the orbit's period, or
    /// half of it for a symmetric orbit.
    pub fn multiplier_periods(&self) -> f64 {
        0.5 * f64::from(self.word.half_periods())
    }

    /// The state at phase θ (rad) of the drive; at an impact, the state just after it. θ must be
    /// finite. An orbit of several drive periods passes each phase of the drive in several states,
    /// so θ is counted from the first period of its [`phases`](Self::phases).
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
    /// [`drive_phase`](vibro_impact::Parameters::drive_phase): the initial state for the simulator
    /// and the FMU.
    pub fn start_state(&self) -> State {
        self.state(self.system.parameters().drive_phase)
    }

    /// The flight after each impact: the free part of the state after the impact, the phase of the
    /// impact, and the span to the next impact.
    fn flights(&self) -> impl Iterator<Item = (&Vector6, f64, f64)> {
        let end = self.phases.first().map(|first| first + self.word.span());
        let ends = self.phases.iter().skip(1).copied().chain(end);
        self.departures.iter().zip(&self.phases).zip(ends).map(|((z, phase), end)| (z, *phase, end - phase))
    }

    /// Local maxima, over the orbit's period, of the weighted sum of x1, x2, x3, units of L:
    /// extrema within flights, and corners where an impact reverses the rate.
    pub fn maxima(&self, weights: [f64; 3]) -> Vec<f64> {
        let mut found = self.half_maxima(weights);
        if self.word.closing() < 0 {
            // The other half of the period is the mirror image.
            found.extend(self.half_maxima(weights.map(|w| -w)));
        }
        found
    }

    /// The local maxima until the word closes (half a period for closing -1).
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

    /// Whether another orbit of the same machine is this orbit: both have the same canonical word,
    /// and their phases agree to `tolerance` (rad) for some choice of the first letter. Without
    /// loads an orbit also equals its mirror image.
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

/// Whether two lists of phases with the same word describe the same orbit, to `tolerance`.
pub(super) fn same_phases(word: &OrbitWord, a: &[f64], b: &[f64], mirror: bool, tolerance: f64) -> bool {
    word.symmetries(mirror).into_iter().any(|turn| {
        let turned = word.turned_phases(b, turn);
        let Some(shift) = turned.first().zip(a.first()).map(|(b, a)| ((b - a) / TAU).round() * TAU) else {
            return true;
        };
        a.iter().zip(&turned).all(|(a, b)| (b - shift - a).abs() < tolerance)
    }) || word.is_empty()
}

/// The phases of the word repeated twice.
pub(super) fn unfolded_phases(word: &OrbitWord, phases: &[f64]) -> Vec<f64> {
    repeated_phases(word, phases, 2)
}

/// The phases of the word repeated k times.
pub(super) fn repeated_phases(word: &OrbitWord, phases: &[f64], k: usize) -> Vec<f64> {
    (0..k).flat_map(|round| phases.iter().map(move |phase| phase + round as f64 * word.span())).collect()
}

/// The phase `theta`, rad. A modulus above a thousand radians is reduced by multiples of `periods`
/// drive periods, because differences from other phases would lose digits.
fn within(theta: f64, periods: u32) -> f64 {
    const MANY: f64 = 1e3;
    if theta.abs() <= MANY {
        return theta;
    }
    let turn = theta.sin().atan2(theta.cos());
    turn + TAU * ((theta - turn) / TAU).round().rem_euclid(f64::from(periods))
}

/// Whether it is proved that the block leaves its stop after each impact and stays within the
/// stops in all flights, except for the contact errors at their ends.
pub(super) fn is_clear(cycle: &Cycle) -> bool {
    (0..cycle.phases.len()).all(|i| {
        let span = cycle.arrival(i) - cycle.phases[i];
        let contact = cycle.contact_errors(i).iter().sum::<f64>();
        contact < RESIDUAL
            && !cycle.stays(i)
            && flights::is_clear(cycle.system, cycle.departure(i), cycle.phases[i], span, contact)
    })
}

/// exp(A Θ), the map of the flight without impacts over the span Θ of the word.
fn free_map(system: &System, word: &OrbitWord) -> Matrix6<f64> {
    let transition = system.flight.transition(word.span());
    let columns = [0, 1, 2, 3, 4, 5].map(|i| transition.apply(&Vector6::ith(i, 1.0)));
    Matrix6::from_columns(&columns)
}

/// The phases at which the residual is zero, by Newton's method from a guess. A step that would
/// shorten a flight by more than half is reduced, so that impacts keep their order.
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
