//! An exact orbit: its states, clearance from the stops, amplitudes and multipliers.

use super::super::{Bifurcation, EIGENVALUE_SWEEPS, Sheet};
use super::clearance::Clearance;
use super::flight::{Flight, Vector6};
use super::{OrbitFamily, no_eigenvalues};
use crate::error::Result;
use crate::parameters::Parameters;
use crate::state::State;
use nalgebra::{Complex, SMatrix};
use std::f64::consts::{PI, TAU};
use vibro_numerics::bernstein::{Polynomial, raise_to_maximum};

/// Relative tolerance for the rounding of phases.
const PHASE_ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Deflation threshold of the QR sweeps.
const EIGENVALUE_PRECISION: f64 = f64::EPSILON;

/// Taylor pieces of half a period from the upper impact, in order.
#[derive(Clone, Debug)]
struct OrbitPieces {
    flight: Flight,
    state: Vector6,
    phase: f64,
    next: u32,
}

impl Iterator for OrbitPieces {
    type Item = [Polynomial; 3];

    fn next(&mut self) -> Option<Self::Item> {
        if self.next == self.flight.pieces {
            return None;
        }
        let h = self.flight.step();
        let x = self.flight.piece(&self.state, self.phase + f64::from(self.next) * h, h, self.flight.force);
        self.state = Flight::state(&x, 1.0, h);
        self.next += 1;
        Some(x)
    }
}

/// States of an orbit at one phase after another, bit-identical to [`ExactOrbit::state`]. Each
/// Taylor piece starts where the piece before it ends, so a state needs all pieces up to its own.
/// For increasing phases a walk computes each piece once. A smaller phase restarts the walk.
#[derive(Clone, Debug)]
pub struct OrbitWalk<'a> {
    orbit: &'a ExactOrbit,
    pieces: OrbitPieces,
    /// Pieces taken so far; the last of them is `piece`.
    next: u32,
    piece: [Polynomial; 3],
}

impl OrbitWalk<'_> {
    /// State at phase θ (rad) of the drive, as [`ExactOrbit::state`].
    pub fn state(&mut self, theta: f64) -> State {
        let (since, sign) = self.orbit.since_impact(theta);
        let (flight, h) = (&self.orbit.flight, self.orbit.flight.step());
        let index = (since / h).floor().min(f64::from(flight.pieces - 1));
        if (index as u32) + 1 < self.next {
            (self.pieces, self.next) = (self.orbit.pieces(), 0);
        }
        while self.next <= index as u32 {
            // There is a next piece, because the index is less than the number of pieces.
            self.piece = self.pieces.next().unwrap_or_default();
            self.next += 1;
        }
        self.orbit.si(&(sign * Flight::state(&self.piece, since / h - index, h)))
    }
}

/// Symmetric orbit with two impacts per period.
#[derive(Clone, Copy, Debug)]
pub struct ExactOrbit {
    parameters: Parameters,
    flight: Flight,
    sheet: Sheet,
    /// p in units of m2 ω1 L.
    impulse: f64,
    /// δ in [0, 2π).
    phase: f64,
    /// σ⁻ of docs/theory.md (77), the state just before the upper impact.
    before: Vector6,
    /// σ⁺ of docs/theory.md (77), the state just after the upper impact.
    after: Vector6,
    clear: bool,
    multipliers: [Complex<f64>; 6],
}

impl ExactOrbit {
    /// Orbit with impulse p (units of m2 ω1 L) and phase δ of the force at the upper impact,
    /// docs/theory.md (77).
    pub(super) fn new(family: &OrbitFamily, sheet: Sheet, p: f64, phase: f64) -> Result<Self> {
        let flight = family.flight;
        let forced = -family.response * Complex::cis(phase);
        let mut after = p * family.half.after;
        after[0] += forced.im;
        after[3] += forced.re;
        let before = flight.pushed(&after, -p);
        let force = flight.force * phase.sin();
        let [approach, departure] = [&before, &after].map(|z| flight.rate_of(z, force));
        let delay = flight.delay(&approach, 0.0, &departure) / (before[4] - before[3]);
        // D_h = -S M of docs/theory.md (79), column by column.
        let half = |unit: Vector6| -flight.saltate(&family.half.map.apply(&unit), &delay);
        let map = SMatrix::from_columns(&[0, 1, 2, 3, 4, 5].map(|i| half(Vector6::ith(i, 1.0))));
        let mut orbit = Self {
            parameters: family.parameters,
            flight,
            sheet,
            impulse: p,
            phase: phase.rem_euclid(TAU),
            before,
            after,
            clear: false,
            multipliers: eigenvalues(map).ok_or_else(no_eigenvalues)?,
        };
        let mut clearance = Clearance::new(0.0, orbit.flight.pieces, forced.norm());
        orbit.clear = orbit.pieces().all(|x| {
            let w: Polynomial = std::array::from_fn(|k| x[1][k] - x[0][k]);
            clearance.holds(&w, x[0][0])
        });
        Ok(orbit)
    }

    /// Taylor pieces of half a period from the upper impact, in order.
    fn pieces(&self) -> OrbitPieces {
        OrbitPieces { flight: self.flight, state: self.after, phase: self.phase, next: 0 }
    }

    /// Parameters of the machine.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Root of the quadratic.
    pub fn sheet(&self) -> Sheet {
        self.sheet
    }

    /// Impulse p > 0 of each impact, N·s.
    pub fn impulse(&self) -> f64 {
        let p = &self.parameters;
        self.impulse * p.block_mass * p.drive_frequency * p.stop_gap
    }

    /// Phase δ of the force when the block meets the upper stop, in [0, 2π) rad; the lower stop
    /// follows at δ + π.
    pub fn drive_phase(&self) -> f64 {
        self.phase
    }

    /// State just before the impact at the upper stop.
    pub fn before_impact(&self) -> State {
        self.si(&self.before)
    }

    /// State just after the impact at the upper stop.
    pub fn after_impact(&self) -> State {
        self.si(&self.after)
    }

    /// State at phase θ (rad) of the drive F10 sin θ; at an impact, the state just after it. On
    /// the orbit, θ = ω1 t + [`Parameters::drive_phase`].
    pub fn state(&self, theta: f64) -> State {
        self.walk().state(theta)
    }

    /// Walk along the orbit, for states at many phases; see [`OrbitWalk`].
    pub fn walk(&self) -> OrbitWalk<'_> {
        OrbitWalk { orbit: self, pieces: self.pieces(), next: 0, piece: Default::default() }
    }

    /// Phase since the last impact, and the sign of the orbit: -1 after the impact at the lower
    /// stop, where the orbit is the mirror image.
    fn since_impact(&self, theta: f64) -> (f64, f64) {
        // A phase within rounding of an impact counts as the impact, with the state after it.
        let rounding = PHASE_ROUNDING * (theta.abs() + TAU);
        let since = (theta - self.phase + rounding).rem_euclid(TAU);
        let (since, sign) = if since < PI { (since, 1.0) } else { (since - PI, -1.0) };
        ((since - rounding).max(0.0), sign)
    }

    /// State at time 0, where the phase of the drive is [`Parameters::drive_phase`].
    pub fn initial_state(&self) -> State {
        self.state(self.parameters.drive_phase)
    }

    /// Converts a state from units of L and ω1 L to SI units.
    fn si(&self, s: &Vector6) -> State {
        let length = self.parameters.stop_gap;
        let speed = length * self.parameters.drive_frequency;
        State { x: [0, 1, 2].map(|i| length * s[i]), v: [3, 4, 5].map(|i| speed * s[i]) }
    }

    /// Whether |w| ≤ L between the impacts, proved by Bernstein bounds of the Taylor pieces over
    /// half a period; the other half is the mirror image. The proof holds up to 1e-12 L and the
    /// rounding of the orbit. The rounding is larger if a mode is thousands of times faster than
    /// the drive or a box without damper is near resonance. If the proof fails for a root, the
    /// root does not belong to an orbit of the system, whose block meets a stop earlier.
    pub fn is_clear(&self) -> bool {
        self.clear
    }

    /// Largest |x1|, |x2|, |x3| over a period, m: exact extrema.
    pub fn amplitudes(&self) -> [f64; 3] {
        let mut best = [0.0; 3];
        for x in self.pieces() {
            best.iter_mut().zip(&x).for_each(|(best, x)| raise_to_maximum(x, best));
        }
        best.map(|a| self.parameters.stop_gap * a)
    }

    /// Largest |q1 x1 + q2 x2 + q3 x3| over a period, m; (1, ε, 0) gives the paper's B.
    pub fn amplitude_of(&self, q: [f64; 3]) -> f64 {
        let mut best = 0.0;
        for x in self.pieces() {
            let sum: Polynomial = std::array::from_fn(|k| q[0] * x[0][k] + q[1] * x[1][k] + q[2] * x[2][k]);
            raise_to_maximum(&sum, &mut best);
        }
        self.parameters.stop_gap * best
    }

    /// Six multipliers of the half-cycle map, docs/theory.md (79), largest modulus first. The
    /// multipliers of the full period are their squares.
    pub fn multipliers(&self) -> [Complex<f64>; 6] {
        self.multipliers
    }

    /// Largest modulus of the half-cycle multipliers.
    pub fn spectral_radius(&self) -> f64 {
        self.multipliers[0].norm()
    }

    /// Whether the orbit attracts its neighbourhood and keeps clear of the stops between its
    /// impacts.
    pub fn is_stable(&self) -> bool {
        self.clear && self.spectral_radius() < 1.0
    }

    /// Bifurcation that the largest multiplier indicates. It has already occurred if the
    /// multiplier is outside the unit circle.
    pub fn bifurcation(&self) -> Bifurcation {
        Bifurcation::of(self.multipliers[0])
    }
}

/// Eigenvalues by decreasing modulus; `None` if numbers are not finite or the sweeps do not end.
///
/// For some matrices the QR sweeps cycle without end. The coordinates are then reordered, which
/// leaves the eigenvalues unchanged but changes the sweeps.
pub fn eigenvalues(map: SMatrix<f64, 6, 6>) -> Option<[Complex<f64>; 6]> {
    if map.iter().any(|x| !x.is_finite()) {
        return None;
    }
    let turned = |by: usize| SMatrix::<f64, 6, 6>::from_fn(|i, j| map[((i + by) % 6, (j + by) % 6)]);
    let schur = (0..6).find_map(|by| turned(by).try_schur(EIGENVALUE_PRECISION, EIGENVALUE_SWEEPS))?;
    let mut values: [Complex<f64>; 6] = schur.complex_eigenvalues().into();
    values.sort_by(|a, b| b.norm_sqr().total_cmp(&a.norm_sqr()));
    Some(values)
}
