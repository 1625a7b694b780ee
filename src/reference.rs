//! The paper's numerics as an independent second method. In flight it uses RKF45 with error
//! control. When a step violates the constraint, it uses classical RK4 from the step's beginning
//! and bisects the step until the stop is met within tolerance.
//!
//! It shares only plain data types with `model`, `flow`, `events` and `simulator`, so that it can
//! be their oracle in tests and the baseline in benches. For this purpose the impact law and the
//! forces are written here a second time. The method differs from the paper in three points.
//! Without them it would not end or would miss impacts:
//! - a step inside which the block could reach the stop and return is searched too, by a heuristic
//!   without proof;
//! - resting contact is a separate mode, docs/theory.md (13) to (15);
//! - chatter is closed once a rebound stays below [`Tolerance::rebound`].
//!
//! Sources: E. Fehlberg, NASA TR R-315 (1969), table III (fourth order with a fifth-order
//! estimate; the fifth-order result is used, as in Shampine and Watts's RKF45); Fritzkowski &
//! Awrejcewicz, doi:10.1007/s11071-021-06838-w.

mod law;
mod steps;

use crate::error::{Error, Result};
use crate::parameters::{Parameters, Range};
use crate::simulator::{Contact, Event, ImpactRecord, Loads, State};
use law::{Law, Vector};

/// Largest number of halvings of a step. The step's length is then under the resolution of time.
const HALVINGS: u32 = 60;

/// Range of tolerances. Below it, round-off dominates. Above it, the computed motion no longer
/// resembles the system's motion.
const TOLERANCES: Range =
    Range { min: 1e-15, max: 1e-2, open_min: false, allowed: "1e-15 <= tolerance <= 0.01" };

/// Tolerances of the [`Reference`], unit 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Local error of a step, relative to each coordinate plus its scale: L, or L times the larger
    /// of ω1 and √(k1/m1).
    pub step: f64,
    /// Distance from the stop, in units of L, at which it counts as met.
    pub gap: f64,
    /// Height of a rebound, in units of L, at or below which a pressed block is put to rest. The
    /// omitted rebounds would shift the coordinates only by about that height, since they last a
    /// time v/a and their mean force equals the contact force.
    pub rebound: f64,
}

impl Tolerance {
    /// Tolerances with one value for step and gap, and four times this value for the rebound.
    pub const fn new(tolerance: f64) -> Self {
        Self { step: tolerance, gap: tolerance, rebound: 4.0 * tolerance }
    }

    fn validate(&self) -> Result<()> {
        TOLERANCES.check("tolerance.step", self.step)?;
        TOLERANCES.check("tolerance.gap", self.gap)?;
        Ok(TOLERANCES.check("tolerance.rebound", self.rebound)?)
    }
}

/// RKF45 and bisection integrator of one system, in SI units. It does not allocate.
#[derive(Clone, Debug)]
pub struct Reference {
    law: Law,
    tolerance: Tolerance,
    time: f64,
    /// Rounding of `time` (Kahan's summation), so that it does not drift over 10⁶ small steps.
    carry: f64,
    /// x1, x2, x3 (m) and their rates (m/s).
    y: Vector,
    /// Side of the stop on which the block rests: ±1, or 0 in flight.
    side: f64,
    /// Acceleration of the box by the drive at `time`, computed in the last step.
    drive: f64,
    /// Length of the next step, s.
    step: f64,
    /// Scale of each coordinate for its error, added to its size: L, or L times a typical rate.
    scale: Vector,
    impacts: ImpactRecord,
}

impl Reference {
    /// Starts at `time` (s) from `state`; the drive's phase is `ω1 time + drive.phase`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if a parameter, the state, the time or a tolerance is out of range;
    /// [`Error::Penetration`] if the block is outside the box.
    pub fn new(parameters: &Parameters, state: &State, time: f64, tolerance: Tolerance) -> Result<Self> {
        parameters.validate()?;
        tolerance.validate()?;
        let y = [state.x[0], state.x[1], state.x[2], state.v[0], state.v[1], state.v[2]];
        for (name, value) in ["box.s", "block.s", "secondary.s", "box.v", "block.v", "secondary.v"]
            .into_iter()
            .zip(y)
            .chain([("time", time)])
        {
            Range::FINITE.check(name, value)?;
        }
        let law = Law::new(parameters, time);
        let gap = parameters.stop_gap;
        if (y[1] - y[0]).abs() > gap + law.slack(&y) {
            return Err(Error::Penetration { value: y[1] - y[0], gap });
        }
        let rate = law.rate(parameters);
        let speed = gap * rate;
        Ok(Self {
            tolerance,
            time,
            carry: 0.0,
            y,
            side: 0.0,
            drive: law.drive(time),
            step: 1e-3 / rate,
            scale: [gap, gap, gap, speed, speed, speed],
            impacts: ImpactRecord::default(),
            law,
        })
    }

    /// Sets the external forces as polynomials in the time after the present time.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a value that is not finite.
    pub fn set_loads(&mut self, loads: &Loads) -> Result<()> {
        for value in loads.derivatives.into_iter().flatten() {
            Range::FINITE.check("load", value)?;
        }
        self.law.set_loads(loads, self.time);
        Ok(())
    }

    /// Present time in s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Present state, m and m/s.
    pub fn state(&self) -> State {
        let [x1, x2, x3, v1, v2, v3] = self.y;
        State { x: [x1, x2, x3], v: [v1, v2, v3] }
    }

    /// Present mode.
    pub fn contact(&self) -> Contact {
        match self.side {
            0.0 => Contact::Flight,
            1.0 => Contact::RestUpper,
            _ => Contact::RestLower,
        }
    }

    /// Contact force λ in N, zero in flight.
    pub fn contact_force(&self) -> f64 {
        if self.side == 0.0 { 0.0 } else { self.law.force(&self.y, self.drive, self.time, self.side) }
    }

    /// Counts and last values of the impacts so far. The impacts of a chatter run after it is
    /// closed are not counted.
    pub fn impacts(&self) -> &ImpactRecord {
        &self.impacts
    }

    /// Advances to exactly `end` (s).
    ///
    /// # Errors
    /// As [`advance`](Self::advance).
    pub fn advance_to(&mut self, end: f64) -> Result<()> {
        self.advance(end, &mut |_| {})
    }

    /// Advances to exactly `end` (s), reporting each event.
    ///
    /// # Errors
    /// [`Error::Step`] if `end` is not finite or in the past; [`Error::PrecisionLost`] if the
    /// error control needs steps under the resolution of time.
    pub fn advance(&mut self, end: f64, on_event: &mut dyn FnMut(&Event)) -> Result<()> {
        if !end.is_finite() || end < self.time {
            return Err(Error::Step { time: self.time, end });
        }
        self.start_on_stop(on_event);
        while self.time < end {
            let left = end - self.time + self.carry;
            let h = self.step.min(left);
            let (next, drive, error) = self.fehlberg(h);
            // `error > 1` alone would accept a NaN.
            if error.is_nan() || error > 1.0 {
                self.step = h * (0.9 / error.sqrt().sqrt()).clamp(0.2, 1.0);
                let floor = 4.0 * f64::EPSILON * self.time.abs();
                if error.is_nan() || self.step <= floor {
                    return Err(Error::PrecisionLost {
                        what: "1 / RKF45 step",
                        value: 1.0 / h,
                        limit: 1.0 / floor,
                    });
                }
                continue;
            }
            if self.advance_to_event(&next, drive, h, on_event) {
                continue;
            }
            let grown = h * (0.9 / error.sqrt().sqrt()).clamp(0.2, 5.0);
            if h < left {
                self.step = grown;
                self.add_time(h);
            } else {
                self.step = self.step.max(grown);
                (self.time, self.carry) = (end, 0.0);
            }
            (self.y, self.drive) = (next, drive);
        }
        Ok(())
    }

    /// Searches the accepted step to `next` for an event. If there is one, advances to the event
    /// instead, applies it and returns true.
    fn advance_to_event(
        &mut self,
        next: &Vector,
        drive: f64,
        h: f64,
        on_event: &mut dyn FnMut(&Event),
    ) -> bool {
        if self.side != 0.0 {
            return self.law.force(next, drive, self.time + h, self.side) < 0.0 && self.release(h, on_event);
        }
        let (gap, w, rate) = (self.law.gap, next[1] - next[0], next[4] - next[3]);
        let mut side = w.signum();
        let reach = gap + self.law.slack(next);
        let violated = w.abs() > reach;
        if !violated {
            // side·w may have a maximum inside the step. It can reach the stop only if the
            // tangents at both ends do.
            let (w0, rate0) = (self.y[1] - self.y[0], self.y[4] - self.y[3]);
            side = rate0.signum();
            let peak = side * rate < 0.0 && side * (w0 + rate0 * h) > reach && side * (w - rate * h) > reach;
            if !peak {
                return false;
            }
        }
        match self.bisect(side, h, violated) {
            Some((y, elapsed)) => {
                self.y = y;
                self.add_time(elapsed);
                self.drive = self.law.drive(self.time);
                self.strike(side, on_event);
                true
            }
            None => false,
        }
    }

    /// Classical RK4 from the step's beginning up to the stop, with a step that is halved each
    /// time. Returns the state at the stop and the time elapsed. `None` if the block turns before
    /// the stop, which is possible only if the constraint was not `violated` at the step's end.
    fn bisect(&self, side: f64, h: f64, violated: bool) -> Option<(Vector, f64)> {
        let (mut y, mut elapsed, mut step) = (self.y, 0.0, h);
        for _ in 0..HALVINGS {
            let gap = self.law.gap - side * (y[1] - y[0]);
            let rate = side * (y[4] - y[3]);
            if gap <= self.tolerance.gap * self.law.gap && rate > 0.0 {
                return Some((y, elapsed));
            }
            if !violated && gap > rate * step {
                return None;
            }
            step *= 0.5;
            let trial = self.runge_kutta(&y, elapsed, step);
            let outside = side * (trial[1] - trial[0]) > self.law.gap;
            let past_peak = rate > 0.0 && side * (trial[4] - trial[3]) <= 0.0;
            if !outside && !past_peak {
                (y, elapsed) = (trial, elapsed + step);
            }
        }
        // RKF45 passed the stop by less than the difference of the two methods. The block is
        // therefore at the stop.
        (violated && side * (y[4] - y[3]) > 0.0).then_some((y, elapsed))
    }

    /// Applies the impact law, docs/theory.md (10) and (11), at the stop and closes a chatter run.
    /// It is written a second time on purpose, like the equations in [`law`].
    fn strike(&mut self, side: f64, on_event: &mut dyn FnMut(&Event)) {
        let law = &self.law;
        let speed = side * (self.y[4] - self.y[3]);
        let impulse = (1.0 + law.restitution) * law.reduced * speed;
        self.y[3] += side * impulse / law.m1;
        self.y[4] -= side * impulse / law.m2;
        let record = &mut self.impacts;
        *(if side > 0.0 { &mut record.upper } else { &mut record.lower }) += 1;
        (record.last_time, record.last_impulse, record.last_speed) = (self.time, impulse, speed);
        record.total_impulse += impulse;
        record.box_impulse += side * impulse;
        on_event(&Event::Impact { time: self.time, side: side as i8, speed, impulse });
        self.rest_if_pressed(side, on_event);
    }

    /// Merges box and block into rest if the block is pressed to the stop and its rebound would
    /// stay below the tolerated height; momentum and centre of mass are conserved.
    fn rest_if_pressed(&mut self, side: f64, on_event: &mut dyn FnMut(&Event)) {
        let law = &self.law;
        let pressing = law.force(&self.y, self.drive, self.time, side) / law.reduced;
        let rebound = self.y[4] - self.y[3];
        if pressing > 0.0 && rebound * rebound <= 2.0 * pressing * law.gap * self.tolerance.rebound {
            let both = law.m1 + law.m2;
            let velocity = (law.m1 * self.y[3] + law.m2 * self.y[4]) / both;
            self.impacts.box_impulse += law.m1 * (velocity - self.y[3]);
            (self.y[3], self.y[4]) = (velocity, velocity);
            self.y[0] += (self.y[1] - self.y[0] - side * law.gap) * law.m2 / both;
            self.y[1] = self.y[0] + side * law.gap;
            self.side = side;
            on_event(&Event::Rest { time: self.time, side: side as i8 });
        }
    }

    /// Classifies a state on a stop at the start of an advance: an impact if the block moves
    /// outward, rest if it is pressed.
    fn start_on_stop(&mut self, on_event: &mut dyn FnMut(&Event)) {
        let w = self.y[1] - self.y[0];
        if self.side != 0.0 || w.abs() < self.law.gap - self.law.slack(&self.y) {
            return;
        }
        let side = w.signum();
        if side * (self.y[4] - self.y[3]) > 0.0 {
            self.strike(side, on_event);
        } else {
            self.rest_if_pressed(side, on_event);
        }
    }

    /// Advances to the release of docs/theory.md (15), by RK4 with bisection up to the instant at
    /// which the contact force has just become negative, within tolerance.
    fn release(&mut self, h: f64, on_event: &mut dyn FnMut(&Event)) -> bool {
        let small = self.tolerance.step * self.law.reduced * self.scale[3] * self.scale[3] / self.law.gap;
        let (mut y, mut elapsed, mut step) = (self.y, 0.0, h);
        for k in 0..HALVINGS {
            step *= 0.5;
            let trial = self.runge_kutta(&y, elapsed, step);
            let time = self.time + elapsed + step;
            let force = self.law.force(&trial, self.law.drive(time), time, self.side);
            if force >= 0.0 || force > -small || k + 1 == HALVINGS {
                (y, elapsed) = (trial, elapsed + step);
            }
            if (-small..0.0).contains(&force) {
                break;
            }
        }
        self.y = y;
        self.add_time(elapsed);
        self.drive = self.law.drive(self.time);
        on_event(&Event::Release { time: self.time, side: self.side as i8 });
        self.side = 0.0;
        true
    }

    /// Adds `h` to the time by Kahan's summation.
    fn add_time(&mut self, h: f64) {
        let add = h - self.carry;
        let sum = self.time + add;
        self.carry = (sum - self.time) - add;
        self.time = sum;
    }
}
