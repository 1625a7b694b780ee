//! Model exchange: a host's solver integrates between events. It sets time and states and reads
//! derivatives and event indicators; the law at events is that of the exact motion.
//!
//! A solver's states carry its error. So that the law recognizes at an event what has passed zero,
//! an indicator passes zero late: where its functional exceeds zero by [`LATE`] of its size. Just
//! after an event an indicator is then positive, as hosts that look for a change of sign need.

use super::event::Event;
use super::jump::Parted;
use super::{Hybrid, Motion, Observer, saved};
use crate::assembly::Assembly;
use crate::energy::{Accounts, Samples};
use crate::error::Error;
use crate::kernel::NODES;
use crate::law::ZERO;
use crate::mode::Watch;
use crate::signals::Input;
use crate::system::{Row, System};
use nalgebra::DVector;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use vibro_impact::numerics::double_double::DoubleDouble;

/// Relative overshoot of a watched functional where its indicator passes zero: above the rounding
/// of roots that solvers find, and so small that an impact at this depth is as exact as a solver's
/// tolerance.
pub(super) const LATE: f64 = 1e-11;
/// Limit of modes in succession at one instant: times the number of indicators plus one.
const CHAIN: usize = 10;

/// Last event and last accepted point of a host's solver.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Course {
    /// Time of the last event, s: the signals' knots after it are still to come.
    event: f64,
    /// Time of the last accepted point, s.
    time: f64,
    /// State at that point.
    #[serde(with = "saved::vector")]
    z: DVector<f64>,
}

impl Course {
    /// Whether it can belong to a motion of this machine: its size, and finite numbers.
    pub fn fits(&self, assembly: &Assembly) -> bool {
        self.z.len() == assembly.system.signals.size
            && self.event.is_finite()
            && self.time.is_finite()
            && self.z.iter().all(|x| x.is_finite())
    }
}

/// Order of the event indicators: one per rigid stop; two per compliant stop, of its edge and of
/// its force; three per friction, of slipping upwards, of slipping downwards and of its level.
impl System {
    /// Number of indicators: the same in every mode.
    pub fn indicators(&self) -> usize {
        self.first_indicator_of_stop(self.stops.len()) + 3 * self.frictions.len()
    }

    fn first_indicator_of_stop(&self, i: usize) -> usize {
        self.stops[..i].iter().map(|stop| if stop.restitution().is_some() { 1 } else { 2 }).sum()
    }

    /// Index of a watched functional's indicator; `second` marks the second functional of an
    /// `ElastoGap`'s force.
    fn indicator(&self, watch: Watch, second: bool) -> usize {
        let friction = |i: usize| self.first_indicator_of_stop(self.stops.len()) + 3 * i;
        match watch {
            Watch::Meets(i) | Watch::Opens(i) | Watch::Presses(i) | Watch::Leaves(i) => {
                self.first_indicator_of_stop(i)
            }
            Watch::Changes(i) => self.first_indicator_of_stop(i) + usize::from(!second),
            // A slipping friction watches one direction only and uses the first indicator.
            Watch::Stops(i) | Watch::Slips(i, true) => friction(i),
            Watch::Slips(i, false) => friction(i) + 1,
            Watch::Level(i) => friction(i) + 2,
        }
    }
}

impl Assembly {
    /// The bodies whose coordinates, then rates, are the continuous states.
    pub fn states(&self) -> &[usize] {
        &self.system.bodies_of
    }

    /// Nominal values of the continuous states, coordinates first, from start values, gaps, and
    /// loads with the stiffness and mass that resist them. All are positive.
    pub fn nominals(&self) -> Vec<f64> {
        let (system, n) = (&self.system, self.system.coordinates);
        let mut z: Row = DVector::from_element(system.signals.size, 1.0);
        z.rows_mut(0, system.signals.one).fill(0.0);
        let given = |row: &Row| row.abs().dot(&z);
        let stiffness = |k: usize| -system.forces[(k, k)];
        let mut lengths: Vec<f64> = (0..n)
            .map(|k| {
                let stops = system.stops.iter().filter(|stop| stop.elongation.w[k] != 0.0);
                let gaps = stops.map(|stop| given(&stop.excess) / stop.elongation.w[k].abs());
                let start = self.starts[system.bodies_of[k]].0.abs();
                let load = given(&system.forces.row(k).transpose());
                let bent = if stiffness(k) > 0.0 { load / stiffness(k) } else { 0.0 };
                gaps.fold(start.max(bent), f64::max)
            })
            .collect();
        let largest = lengths.iter().copied().fold(0.0, f64::max);
        let usual = if largest > 0.0 { largest } else { 1.0 };
        lengths.iter_mut().filter(|length| **length == 0.0).for_each(|length| *length = usual);
        let rate = |k: usize| {
            let (mass, length) = (system.mass[(k, k)], lengths[k]);
            let load = given(&system.forces.row(k).transpose());
            let own = length * (stiffness(k).max(0.0) / mass).sqrt();
            let rate = self.starts[system.bodies_of[k]].1.abs().max(own).max((length * load / mass).sqrt());
            if rate > 0.0 { rate } else { length }
        };
        let rates: Vec<f64> = (0..n).map(rate).collect();
        let positive = |x: f64| x.clamp(f64::MIN_POSITIVE, f64::MAX);
        lengths.into_iter().chain(rates).map(positive).collect()
    }
}

impl Motion {
    /// Hands the motion over to a host's solver at the present time. A pending event is applied
    /// first.
    ///
    /// # Errors
    /// As [`apply_event`](Self::apply_event).
    pub fn begin_course(&mut self) -> Result<Course, Error> {
        self.pass_event(&mut None)?;
        self.late = LATE;
        for (size, nominal) in self.hybrid.sizes.0.iter_mut().zip(self.assembly.nominals()) {
            *size = size.max(nominal);
        }
        Ok(Course { event: self.time(), time: self.time(), z: self.hybrid.z.clone() })
    }

    /// Continues with a course that was saved with this motion.
    pub fn resume_course(&mut self) {
        self.late = LATE;
    }

    /// [`changed`](Self::changed) where a host's solver integrates.
    ///
    /// # Errors
    /// As [`changed`](Self::changed); the course is then unchanged.
    pub fn changed_on(&self, course: &mut Course, assembly: Arc<Assembly>) -> Result<Self, Error> {
        let mut old = self.clone();
        old.accept(&mut course.clone());
        // The solver's drift off closed stops must not count as an effect of the change.
        old.keep_contacts();
        let changed = old.changed(assembly)?;
        *course = Course { event: self.time(), time: self.time(), z: changed.hybrid.z.clone() };
        Ok(changed)
    }

    /// Sets the time; the continuous states stay.
    pub fn place_at(&mut self, course: &Course, time: f64) {
        self.hybrid.time = DoubleDouble::new(time);
        self.refill_on(course);
    }

    /// The continuous states: coordinates, then rates.
    pub fn states(&self) -> &[f64] {
        &self.hybrid.z.as_slice()[..self.assembly.system.signals.one]
    }

    /// Sets the continuous states; `states` has as many entries as [`states`](Self::states).
    pub fn set_states(&mut self, states: &[f64]) {
        let own = self.assembly.system.signals.one;
        self.hybrid.z.as_mut_slice()[..own].iter_mut().zip(states).for_each(|(z, state)| *z = *state);
    }

    /// Time derivatives of the continuous states.
    pub fn state_derivatives(&self) -> Vec<f64> {
        self.rates_of(&self.hybrid.z).as_slice().to_vec()
    }

    /// Sets an input's value between events, without derivatives. It acts from the last accepted
    /// point on.
    pub fn set_input_on(&mut self, course: &mut Course, i: usize, value: f64) {
        self.hybrid.inputs[i] = (course.event, [value, 0.0, 0.0, 0.0]);
        self.refill_on(course);
        if self.time() == course.time {
            // The accelerations from there on must be those that the solver sees.
            let own = self.assembly.system.signals.one;
            course.z.as_mut_slice()[own..].copy_from_slice(&self.hybrid.z.as_slice()[own..]);
        }
        // A functional of inputs alone has no other size, and would count as zero.
        if let Some(place) = self.assembly.system.signals.place_of_input(i) {
            self.hybrid.sizes.include_from(place, &[value]);
        }
    }

    /// Sets inputs at an event, as [`set_inputs`](Self::set_inputs): prescribed bodies may jump.
    ///
    /// # Errors
    /// As [`set_inputs`](Self::set_inputs); the motion is then unchanged.
    pub fn set_inputs_on(&mut self, course: &mut Course, inputs: &[(usize, Input)]) -> Result<(), Error> {
        let left = self.hybrid.z.clone();
        // The solver's residual rates of closed contacts are no impact. Coordinates are left to the
        // jump: a prescribed body at a closed stop may have moved since the last event.
        self.keep_rates();
        self.set_inputs(inputs).inspect_err(|_| self.hybrid.z = left)?;
        *course = Course { event: self.time(), time: self.time(), z: self.hybrid.z.clone() };
        Ok(())
    }

    /// Whether an event is pending: a watched functional has passed zero or a signal has a knot.
    pub fn is_event_due_on(&self, course: &Course) -> bool {
        self.is_at_knot(course) || !self.passed().is_empty()
    }

    /// The event indicators, stops first, then frictions: watched functionals relative to their
    /// sizes. An event is where one becomes negative; indicators not in use in this mode are 1.
    pub fn indicators(&self) -> Vec<f64> {
        let system = &self.assembly.system;
        let mut indicators = vec![1.0; system.indicators()];
        for (place, value) in self.watched_now() {
            indicators[place] = LATE - value;
        }
        indicators
    }

    /// Every watched functional relative to its size, with the index of its indicator.
    fn watched_now(&self) -> impl Iterator<Item = (usize, f64)> {
        let (system, hybrid) = (&self.assembly.system, &self.hybrid);
        let mut last = None;
        self.table().watched.iter().map(move |w| {
            let second = last.replace(w.watch) == Some(w.watch);
            let size = hybrid.sizes.of(&w.row);
            let value = if size > 0.0 { w.row.dot(&hybrid.z) / size } else { 0.0 };
            (system.indicator(w.watch, second), value)
        })
    }

    /// The functionals that have passed zero, by more than half of [`LATE`].
    fn passed(&self) -> Vec<Watch> {
        let passed = self.watched_now().map(|(_, value)| value > 0.5 * LATE);
        passed.zip(&self.table().watched).filter(|(passed, _)| *passed).map(|(_, w)| w.watch).collect()
    }

    /// The next knot of a signal, s.
    pub fn next_knot_on(&self, course: &Course) -> Option<f64> {
        self.assembly.system.signals.next_knot(course.event)
    }

    fn is_at_knot(&self, course: &Course) -> bool {
        self.next_knot_on(course).is_some_and(|knot| knot <= self.time())
    }

    /// Accepts the present point and adds the step to the energy accounts; returns whether an event
    /// is pending there.
    pub fn accept(&mut self, course: &mut Course) -> bool {
        self.hybrid.energy = self.energy_on(course);
        (course.time, course.z) = (self.time(), self.hybrid.z.clone());
        self.is_at_knot(course) || self.indicators().iter().any(|indicator| *indicator <= 0.0)
    }

    /// Applies the law at an event: the signals' knot, impacts, and the mode that follows. Returns
    /// whether states or derivatives have changed, so that the solver must restart.
    ///
    /// # Errors
    /// As [`apply_event`](Self::apply_event); motion and course are then unchanged.
    pub fn handle_on(
        &mut self,
        course: &mut Course,
        observer: &mut dyn FnMut(&Event),
    ) -> Result<bool, Error> {
        let before = (self.hybrid.clone(), course.clone());
        self.accept(course);
        match self.settle_on(course, &mut Some(observer)) {
            Ok(changed) => {
                (course.time, course.z) = (self.time(), self.hybrid.z.clone());
                Ok(changed)
            }
            Err(error) => {
                self.restore(&before.0);
                *course = before.1;
                Err(error)
            }
        }
    }

    fn settle_on(&mut self, course: &mut Course, observer: &mut Observer) -> Result<bool, Error> {
        if !self.is_event_due_on(course) {
            return Ok(false);
        }
        // Closed contacts are projected first: the solver's drift off them is neither an impact nor
        // their end, and what has passed zero by drift alone is no event. Where prescribed bodies
        // may jump, only rates are projected: coordinates are left to the jump.
        let (left, is_at_knot) = (self.hybrid.z.clone(), self.is_at_knot(course));
        if is_at_knot {
            self.keep_rates()
        } else {
            self.keep_contacts()
        }
        let mut changed = left != self.hybrid.z;
        if is_at_knot {
            course.event = self.time();
            let stood = self.before_jump();
            self.refill_on(course);
            self.knot(stood, observer)?;
            changed = true;
        }
        for _ in 0..CHAIN * (self.assembly.system.indicators() + 1) {
            let ended = self.passed();
            if ended.is_empty() {
                return Ok(changed);
            }
            changed = true;
            course.event = self.time();
            self.hybrid.last = ended.first().copied();
            let (mode, z) = (self.hybrid.mode.clone(), self.hybrid.z.clone());
            self.settle(&ended, &Parted::default(), observer)?;
            if mode == self.hybrid.mode && self.counts_as(&z) {
                return Ok(changed);
            }
        }
        Err(self.stuck("the modes change without end"))
    }

    /// Whether the state equals `other` up to [`ZERO`] of the sizes: projecting onto contacts once
    /// more leaves rounding.
    fn counts_as(&self, other: &DVector<f64>) -> bool {
        let Hybrid { z, sizes, .. } = &self.hybrid;
        z.iter().zip(other).zip(&sizes.0).all(|((is, was), size)| (is - was).abs() <= ZERO * size)
    }

    /// The energy accounts up to the present point.
    pub fn energy_on(&self, course: &Course) -> Accounts {
        let mut energy = self.hybrid.energy.clone();
        let (dt, system) = (self.time() - course.time, &self.assembly.system);
        if dt > 0.0 {
            let states: Vec<f64> =
                NODES.iter().flat_map(|node| self.between(course, node.0).data.as_vec().clone()).collect();
            let samples = Samples::States(&states, self.hybrid.z.len());
            energy.add(self.tables.at(self.place).powers(system), dt, &samples, &mut Vec::new());
        }
        energy
    }

    /// The state at the fraction `u` of the step from the last accepted point: coordinates by the
    /// quintic Hermite interpolant of values, rates and accelerations at both ends, rates by its
    /// derivative.
    fn between(&self, course: &Course, u: f64) -> DVector<f64> {
        let n = self.assembly.system.coordinates;
        let (h, from, to) = (self.time() - course.time, &course.z, &self.hybrid.z);
        let (a, b) = (self.rates_of(from), self.rates_of(to));
        let mut z = self.signals_on(course, DoubleDouble::new(course.time).plus(u * h));
        for k in 0..n {
            let (q0, v0, a0) = (from[k], h * from[n + k], h * h * a[n + k]);
            let (q1, v1, a1) = (to[k], h * to[n + k], h * h * b[n + k]);
            // Coefficients 3 to 5 of the remainder beyond the parabola at the first end.
            let (d, e, f) = (q1 - q0 - v0 - 0.5 * a0, v1 - v0 - a0, a1 - a0);
            let (c3, c4, c5) =
                (10.0 * d - 4.0 * e + 0.5 * f, -15.0 * d + 7.0 * e - f, 6.0 * d - 3.0 * e + 0.5 * f);
            z[k] = q0 + u * (v0 + u * (0.5 * a0 + u * (c3 + u * (c4 + u * c5))));
            z[n + k] = (v0 + u * (a0 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))) / h;
        }
        z
    }

    /// Rates and accelerations in a state.
    fn rates_of(&self, z: &DVector<f64>) -> DVector<f64> {
        self.table().a.rows_times(0..self.assembly.system.signals.one, z.as_slice())
    }

    /// Computes the signals' part of the state, knots after the last event left out.
    fn refill_on(&mut self, course: &Course) {
        let signals = self.signals_on(course, self.hybrid.time);
        let own = self.assembly.system.signals.one;
        self.hybrid.z.as_mut_slice()[own..].copy_from_slice(&signals.as_slice()[own..]);
    }

    /// An augmented state that is zero but for the signals at `time`, knots after the last event
    /// left out.
    fn signals_on(&self, course: &Course, time: DoubleDouble) -> DVector<f64> {
        let (signals, event) = (&self.assembly.system.signals, DoubleDouble::new(course.event));
        let (mut now, mut pieces) = (DVector::zeros(signals.size), DVector::zeros(signals.size));
        signals.fill(time, &self.hybrid.inputs, now.as_mut_slice());
        signals.fill(event, &self.hybrid.inputs, pieces.as_mut_slice());
        signals.carry(time.minus(event).value(), pieces.as_mut_slice());
        let first = signals.constant_size_until();
        now.as_mut_slice()[first..].copy_from_slice(&pieces.as_slice()[first..]);
        now
    }
}
