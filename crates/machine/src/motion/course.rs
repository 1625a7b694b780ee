//! Motions that a host's solver integrates between events (Model Exchange). The solver sets time
//! and states and reads derivatives and event indicators. The law at events is the same as for
//! exact motions.
//!
//! A solver's states have errors. An indicator passes zero when its event function exceeds zero by
//! [`OVERSHOOT`] times its size, so that the event function is positive when the law is applied.
//! Just after an event the indicator is positive, as hosts that look for a change of sign require.

use super::event::Event;
use super::jump::Parted;
use super::{Hybrid, Motion, Observer};
use crate::assembly::Assembly;
use crate::energy::{Accounts, Samples};
use crate::error::Error;
use crate::functional::StateRow;
use crate::kernel::NODES;
use crate::law::ZERO;
use crate::mode::Watch;
use crate::signals::Input;
use crate::system::{BlockRows, BranchRows, StopRows, System};
use nalgebra::DVector;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use vibro_numerics::double_double::DoubleDouble;

/// Relative overshoot of an event function where its indicator passes zero. It exceeds the
/// rounding of the roots that solvers find. It is so small that an impact at this depth is as
/// exact as a solver's tolerance.
pub(super) const OVERSHOOT: f64 = 1e-11;
/// Largest number of successive modes at one instant, as a multiple of the indicators plus one.
const CHAIN: usize = 10;

/// The last event and the last accepted point of a host's solver.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Course {
    /// Time of the last event, s. Later knots of signals have not acted yet.
    event: f64,
    /// Time of the last accepted point, s.
    time: f64,
    /// State at that point.
    #[serde(with = "crate::serialized")]
    z: DVector<f64>,
}

impl Course {
    /// Whether the course fits a motion of this machine: lengths agree and numbers are finite.
    pub fn fits(&self, assembly: &Assembly) -> bool {
        self.z.len() == assembly.system.signals.size
            && self.event.is_finite()
            && self.time.is_finite()
            && self.z.iter().all(|x| x.is_finite())
    }
}

/// Indices of the event indicators. A rigid stop, a freewheel and a corner of a spring have one
/// each. A compliant stop has two: its edge and its force. A friction has three: slipping upwards,
/// slipping downwards and its level. A slider has two: slipping upwards and downwards.
impl System {
    /// Number of event indicators, equal in every mode.
    pub fn indicators(&self) -> usize {
        self.first_indicator_of_slider(self.branches.len())
    }

    fn first_indicator_of_slider(&self, i: usize) -> usize {
        let slides = |b: &&BranchRows| b.is_slider();
        let before = self.branches[..i].iter().filter(slides).count();
        self.first_indicator_of_stop(self.stops.len()) + 3 * self.frictions.len() + 2 * before
    }

    fn first_indicator_of_stop(&self, i: usize) -> usize {
        let i = if i < self.stops.len() { self.stop_of(i) } else { i };
        let stops = self.stops[..i].iter().enumerate();
        let of = |(i, stop): (usize, &StopRows)| match stop.level {
            Some(level) if level.stop != Some(i) => 0,
            _ if stop.restitution().is_some() || self.is_corner(i) => 1,
            _ => 2,
        };
        stops.map(of).sum()
    }

    /// Returns the index of an event function's indicator; `second` marks the second event
    /// function with the same [`Watch`], the cap of an `ElastoGap`.
    fn indicator(&self, watch: Watch, second: bool) -> usize {
        let friction = |i: usize| self.first_indicator_of_stop(self.stops.len()) + 3 * i;
        match watch {
            Watch::Meets(i) | Watch::Opens(i) | Watch::Presses(i) | Watch::Leaves(i) => {
                self.first_indicator_of_stop(i)
            }
            Watch::Changes(i) => self.first_indicator_of_stop(i) + usize::from(!second),
            Watch::Turns(i) => self.first_indicator_of_stop(i) + 1,
            // One indicator serves both: a friction either slips or sticks.
            Watch::Stops(i) | Watch::Slips(i, true) => friction(i),
            Watch::Slips(i, false) => friction(i) + 1,
            Watch::Level(i) => friction(i) + 2,
            Watch::Yields(i, true) | Watch::Reverses(i) => self.first_indicator_of_slider(i),
            Watch::Yields(i, false) => self.first_indicator_of_slider(i) + 1,
        }
    }
}

impl Assembly {
    /// Returns the bodies whose coordinates are continuous states of a host's solver. Their rates
    /// and the states of first order follow.
    pub fn states(&self) -> &[usize] {
        &self.system.bodies_of
    }

    /// Returns positive nominal values of the continuous states, estimated from starts, gaps,
    /// loads and the springs that bear the loads.
    pub fn nominals(&self) -> Vec<f64> {
        let (system, n) = (&self.system, self.system.coordinates);
        let mut z: StateRow = DVector::from_element(system.signals.size, 1.0);
        z.rows_mut(0, system.states()).fill(0.0);
        let given = |row: &StateRow| row.abs().dot(&z);
        let held = |k: usize| {
            let sliders = system.sliders().map(|i| &system.branches[i]);
            sliders.map(|own| own.elongation.w[k] * own.stiffness * own.elongation.e[k]).sum::<f64>()
        };
        let stiffness = |k: usize| held(k) - system.forces[(k, k)];
        let mut lengths: Vec<f64> = (0..n)
            .map(|k| {
                let stops =
                    system.stops.iter().filter(|stop| stop.elongation.w[k] != 0.0 && !stop.is_freewheel);
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
        let inner = system.branches.iter().map(|own| {
            let along = own.elongation.w.iter().zip(&lengths).map(|(w, length)| w.abs() * length);
            own.elongation.e.abs().dot(&z).max(self.inner[own.place - 2 * n].abs()).max(along.sum())
        });
        let inner: Vec<f64> = inner.map(|x| if x > 0.0 { x } else { usual }).collect();
        let kept: usize = system.blocks.iter().map(BlockRows::kept).sum();
        let kept =
            self.inner[self.inner.len() - kept..].iter().map(|x| if *x == 0.0 { 1.0 } else { x.abs() });
        let kept: Vec<f64> = kept.collect();
        lengths.into_iter().chain(rates).chain(inner).chain(kept).map(positive).collect()
    }
}

impl Motion {
    /// Begins a course at the present time. A pending event is applied first.
    ///
    /// # Errors
    /// As [`apply_event`](Self::apply_event).
    pub fn begin_course(&mut self) -> Result<Course, Error> {
        self.pass_event(&mut None)?;
        self.overshoot = OVERSHOOT;
        self.note_standing();
        for (size, nominal) in self.hybrid.sizes.0.iter_mut().zip(self.assembly.nominals()) {
            *size = size.max(nominal);
        }
        Ok(Course { event: self.time(), time: self.time(), z: self.hybrid.z.clone() })
    }

    /// Continues a course that was saved with this motion.
    pub fn resume_course(&mut self) {
        self.overshoot = OVERSHOOT;
    }

    /// As [`changed`](Self::changed), for a motion that a host's solver integrates.
    ///
    /// # Errors
    /// As [`changed`](Self::changed); the course is then unchanged.
    pub fn changed_on(&self, course: &mut Course, assembly: Arc<Assembly>) -> Result<Self, Error> {
        let mut old = self.clone();
        old.accept(&mut course.clone());
        // Errors of the solver at closed stops must not count as changes of their gaps.
        old.keep_contacts();
        let changed = old.changed(assembly)?;
        *course = Course { event: self.time(), time: self.time(), z: changed.hybrid.z.clone() };
        Ok(changed)
    }

    /// Sets the time and keeps the states.
    pub fn place_at(&mut self, course: &Course, time: f64) {
        self.hybrid.time = DoubleDouble::new(time);
        self.refill_on(course);
    }

    /// Sets an input without derivatives in continuous-time mode, after the last accepted point.
    pub fn set_input_on(&mut self, course: &mut Course, i: usize, value: f64) {
        // An integral keeps what the input has contributed up to the accepted point.
        let signals = &self.assembly.system.signals;
        let from = if signals.is_integrated(i) { course.time } else { course.event };
        signals.set_input(&mut self.hybrid.inputs, i, (from, [value, 0.0, 0.0, 0.0]));
        self.refill_on(course);
        if self.time() == course.time {
            // The interpolation from the accepted point uses the solver's accelerations.
            let own = self.assembly.system.signals.one;
            course.z.as_mut_slice()[own..].copy_from_slice(&self.hybrid.z.as_slice()[own..]);
        }
        // The size of an event function of inputs alone comes from this value only. Without a size
        // the event function would count as zero.
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
        // The solver's errors at closed contacts are not impacts. Only rates are projected, since
        // the prescribed body of a closed stop may have jumped since the last event.
        self.keep_rates();
        self.set_inputs(inputs).inspect_err(|_| self.hybrid.z = left)?;
        *course = Course { event: self.time(), time: self.time(), z: self.hybrid.z.clone() };
        Ok(())
    }

    /// Whether an event is pending: an event function has passed zero, or a signal has a knot.
    pub fn is_event_due_on(&self, course: &Course) -> bool {
        self.knot_now(course.event).is_some() || self.is_at_sample() || !self.passed().is_empty()
    }

    /// Returns the event indicators: stops, frictions, sliders. Each is 1e-11 minus its event
    /// function divided by the event function's size; without an event function it is 1. An event
    /// occurs where the indicator becomes negative.
    pub fn indicators(&self) -> Vec<f64> {
        let system = &self.assembly.system;
        let mut indicators = vec![1.0; system.indicators()];
        for (place, value) in self.watched_now() {
            indicators[place] = OVERSHOOT - value;
        }
        indicators
    }

    /// Returns the event functions divided by their sizes, with the indices of their indicators.
    fn watched_now(&self) -> impl Iterator<Item = (usize, f64)> {
        let (system, hybrid) = (&self.assembly.system, &self.hybrid);
        let mut last = None;
        self.table().watched.iter().map(move |w| {
            let second = last.replace(w.watch) == Some(w.watch);
            let size = w.row.size(hybrid.sizes.0.as_slice());
            let value = if size > 0.0 { w.row.dot(hybrid.z.as_slice()) / size } else { 0.0 };
            (system.indicator(w.watch, second), value)
        })
    }

    /// Returns the event functions that have passed zero, by more than half of [`OVERSHOOT`].
    fn passed(&self) -> Vec<Watch> {
        let passed = self.watched_now().map(|(_, value)| value > 0.5 * OVERSHOOT);
        passed.zip(&self.table().watched).filter(|(passed, _)| *passed).map(|(_, w)| w.watch).collect()
    }

    /// Time of the next knot of a signal or sample of a block, s.
    pub fn next_knot_on(&self, course: &Course) -> Option<f64> {
        let knot = self.assembly.system.signals.next_knot(course.event);
        [knot, self.next_sample()].into_iter().flatten().reduce(f64::min)
    }

    /// Accepts the present point and advances the energy accounts to it. Returns whether an event
    /// was stepped over.
    pub fn accept(&mut self, course: &mut Course) -> bool {
        self.hybrid.energy = self.energy_on(course);
        (course.time, course.z) = (self.time(), self.hybrid.z.clone());
        self.knot_now(course.event).is_some()
            || self.is_at_sample()
            || self.indicators().iter().any(|indicator| *indicator <= 0.0)
    }

    /// Applies the law at an event: a signal's knot acts; if event functions have passed zero,
    /// impacts and the next mode follow. Returns whether there was an event. If so, the solver has
    /// to restart, since states or derivatives have changed.
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
        // First remove the solver's errors at closed contacts, which are neither impacts nor
        // openings. An event function that passed zero only by these errors does not count as
        // passed. At a knot only rates are projected, since coordinates may jump with prescribed
        // bodies.
        let (left, knot) = (self.hybrid.z.clone(), self.knot_now(course.event));
        if knot.is_some() {
            self.keep_rates()
        } else {
            self.keep_contacts()
        }
        let mut changed = left != self.hybrid.z;
        if let Some(knot) = knot {
            course.event = knot.max(self.time());
            let stood = self.before_jump();
            self.refill_on(course);
            self.apply_knot(stood, observer)?;
            changed = true;
        }
        if self.is_at_sample() {
            course.event = course.event.max(self.time());
            self.refill_on(course);
            self.apply_samples(observer)?;
            changed = true;
        }
        for _ in 0..CHAIN * (self.assembly.system.indicators() + 1) {
            let ended = self.passed();
            if ended.is_empty() {
                return Ok(changed);
            }
            changed = true;
            course.event = course.event.max(self.time());
            self.hybrid.last = ended.first().copied();
            let (mode, z) = (self.hybrid.mode.clone(), self.hybrid.z.clone());
            self.settle(&ended, &Parted::default(), observer)?;
            if mode == self.hybrid.mode && self.counts_as(&z) {
                return Ok(changed);
            }
        }
        Err(self.stuck("the modes change without end"))
    }

    /// Whether the state equals another within the zero tolerance. A repeated projection leaves
    /// rounding errors.
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

    /// Interpolates the state at a fraction of the time since the last accepted point. Coordinates
    /// follow the quintic through values, rates and accelerations at both ends, and rates its
    /// derivative. States of first order follow the cubic through values and rates.
    fn between(&self, course: &Course, u: f64) -> DVector<f64> {
        let n = self.assembly.system.coordinates;
        let (h, from, to) = (self.time() - course.time, &course.z, &self.hybrid.z);
        let (a, b) = (self.rates_of(from), self.rates_of(to));
        let mut z = self.signals_on(course, DoubleDouble::new(course.time).plus(u * h));
        for k in 0..n {
            let (q0, v0, a0) = (from[k], h * from[n + k], h * h * a[n + k]);
            let (q1, v1, a1) = (to[k], h * to[n + k], h * h * b[n + k]);
            // Coefficients 3 to 5 of the quintic; the first end gives coefficients 0 to 2.
            let (d, e, f) = (q1 - q0 - v0 - 0.5 * a0, v1 - v0 - a0, a1 - a0);
            let (c3, c4, c5) =
                (10.0 * d - 4.0 * e + 0.5 * f, -15.0 * d + 7.0 * e - f, 6.0 * d - 3.0 * e + 0.5 * f);
            z[k] = q0 + u * (v0 + u * (0.5 * a0 + u * (c3 + u * (c4 + u * c5))));
            z[n + k] = (v0 + u * (a0 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))) / h;
        }
        for k in self.assembly.system.places_of_first_order() {
            let (x0, r0, d, r1) = (from[k], h * a[k], to[k] - from[k], h * b[k]);
            z[k] = x0 + u * (r0 + u * (3.0 * d - 2.0 * r0 - r1 + u * (r0 + r1 - 2.0 * d)));
        }
        self.assembly.system.fill_curved(z.as_mut_slice());
        z
    }

    /// Time derivatives of the coordinates and velocities at a state.
    pub(super) fn rates_of(&self, z: &DVector<f64>) -> DVector<f64> {
        self.table().a.rows_times(0..self.assembly.system.signals.one, z.as_slice())
    }

    /// Computes the signals' part of the state without knots after the last event.
    fn refill_on(&mut self, course: &Course) {
        let signals = self.signals_on(course, self.hybrid.time);
        let own = self.assembly.system.signals.one;
        self.hybrid.z.as_mut_slice()[own..].copy_from_slice(&signals.as_slice()[own..]);
        self.stretch_on();
        self.assembly.system.fill_curved(self.hybrid.z.as_mut_slice());
    }

    /// Returns the signals at a time, ignoring knots after the last event, in an augmented state
    /// whose other coordinates are zero.
    fn signals_on(&self, course: &Course, time: DoubleDouble) -> DVector<f64> {
        let (signals, event) = (&self.assembly.system.signals, DoubleDouble::new(course.event));
        let (mut now, mut pieces) = (DVector::zeros(signals.size), DVector::zeros(signals.size));
        signals.fill(time, &self.hybrid.inputs, now.as_mut_slice());
        signals.fill(event, &self.hybrid.inputs, pieces.as_mut_slice());
        signals.carry(time.minus(event).value(), pieces.as_mut_slice());
        let first = signals.constant_size_until();
        // Coordinates that are reset between knots are functions of the time alone.
        signals.renewed().for_each(|own| pieces.rows_range_mut(own.clone()).copy_from(&now.rows_range(own)));
        now.as_mut_slice()[first..].copy_from_slice(&pieces.as_slice()[first..]);
        now
    }
}
