//! Flights of a motion with derivatives, and the touches in them.

use super::super::columns::Columns;
use super::super::extremes::Extremes;
use super::super::machine::{Instant, Varied};
use super::super::mode::VariedMode;
use super::Differentiated;
use crate::error::Error;
use crate::functional::Functional;
use crate::mode::Watch;
use crate::motion::{Motion, Reached};
use nalgebra::DVector;

/// Returns the present mode's event functions that are zero throughout it.
pub(in super::super) fn throughout<'a>(
    mode: &'a VariedMode,
    motion: &'a Motion,
) -> impl Iterator<Item = &'a (Watch, Functional)> {
    mode.watched.iter().zip(motion.are_unwatched()).filter(|(_, is_still)| *is_still).map(|(own, _)| own)
}

impl Differentiated {
    /// Advances the motion to a time or to the next event, whose law is not yet applied.
    pub(super) fn follow(&mut self, end: f64, extremes: &mut [Extremes]) -> Result<Reached, Error> {
        let begin = self.motion.time();
        let outcome = self.motion.advance_flight(end, &mut |_| ());
        let (mut from, now) = (begin, self.motion.time());
        for touch in self.motion.take_touches() {
            let time = touch.time.clamp(from, now);
            self.look_along((from, time), extremes);
            self.touch(touch.place, (from, time));
            from = time;
        }
        if now > begin {
            self.look_along((from, now), extremes);
            self.fly(now - begin, now - from);
        }
        outcome
    }

    /// Updates the extreme values with the turning points of a flight.
    fn look_along(&mut self, (from, to): (f64, f64), extremes: &mut [Extremes]) {
        let Self { machine, mode, deltas, lost, memory, vectors, .. } = self;
        let mut carry = |varied: &mut Columns, time: f64| mode.carry(*vectors, varied, memory, time);
        for own in extremes.iter_mut().filter(|_| to > from) {
            own.fly(machine, mode, (from, deltas, lost), to - from, &mut carry);
        }
    }

    /// Carries the derivatives over a flight to a touch; ends the columns that vary the touch.
    fn touch(&mut self, place: usize, (from, time): (f64, f64)) {
        let Self { machine, motion, mode, deltas, scales, lost, memory, vectors, .. } = self;
        mode.carry(*vectors, deltas, memory, time - from);
        if !machine.is_touchy(mode.watched[place].0) {
            return;
        }
        let z = deltas.state();
        let (rates, sizes) = (mode.rates(&z), machine.widened(&motion.sizes().0));
        let at = Instant { mode, z: &z, rates: &rates, sizes: &sizes, time };
        for (p, found) in lost.iter_mut().enumerate().filter(|(_, lost)| lost.is_none()) {
            let delta = deltas.column(p);
            let scale = scales.column(p).sup(&delta.abs());
            *found = machine.check_touch(Varied { p, delta: &delta, scale: &scale }, &at, place).err();
            if found.is_some() {
                deltas.put(p, &DVector::zeros(delta.len()));
            }
        }
    }

    /// Carries the derivatives over the remaining time `rest` of a flight of length `span`.
    fn fly(&mut self, span: f64, rest: f64) {
        let Self { machine, motion, mode, deltas, scales, lost, memory, met, vectors, .. } = self;
        let time = motion.time();
        if mode.parts_instants(time, span) {
            met.clear();
        }
        if !lost.is_empty() {
            mode.carry(*vectors, deltas, memory, rest);
        }
        let z = machine.widened(motion.state());
        deltas.put_state(z.as_slice());
        let fills = !motion.is_event_due();
        let is_still = throughout(mode, motion).next().is_some();
        if mode.mode.contacts().next().is_none() && !(fills && machine.varies_signals()) && !is_still {
            scales.include(deltas);
            return;
        }
        let (rates, sizes) = (mode.rates(&z), machine.widened(&motion.sizes().0));
        let at = Instant { mode, z: &z, rates: &rates, sizes: &sizes, time };
        for (p, place) in lost.iter_mut().enumerate().filter(|(_, lost)| lost.is_none()) {
            let mut delta = deltas.column(p);
            if fills {
                machine.fill(p, time, &z, &mut delta);
            }
            let scale = scales.column(p).sup(&delta.abs());
            *place = machine.keep(p, &mut delta, &scale, &at).err();
            if place.is_none() && is_still {
                // A column that varies these functions leads out of the mode.
                let still: Vec<_> = throughout(mode, motion).collect();
                *place = machine.check(Varied { p, delta: &delta, scale: &scale }, &at, &still).err();
            }
            if place.is_some() {
                delta.fill(0.0);
            }
            deltas.put(p, &delta);
        }
        scales.include(deltas);
    }
}
