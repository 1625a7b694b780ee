//! How a motion's state at a later time changes with a small change of its state, or of an input,
//! now.
//!
//! Between events a variation δ of the augmented state follows z' = A z as the state does. At an
//! event, which comes where h·z = 0, the changed motion meets it by δt = -h·δ / h·f⁻ later, with f
//! = A z on either side, so that δ⁺ = J (δ + f⁻ δt) - f⁺ δt: the saltation matrix, with J the
//! derivative of the impact law, and the identity where no velocity jumps (docs/assembly-law.md
//! (A21)). What a closed stop or a sticking friction takes away is gone: the variation lies in what
//! is left.

use super::projection::project;
use super::{Event, EventKind, Motion, Reached};
use crate::error::Error;
use crate::law::Sizes;
use crate::law::box_qp::triangle;
use crate::law::impact::Instant;
use crate::mode::{Contact, Mode, StopState};
use crate::system::System;
use nalgebra::DVector;

/// The impact law is linear as long as the same stops take part: where there are several, its
/// derivative is a difference over this part of the velocities.
const STEP: f64 = 1e-6;
/// A passage slower than this part of the sizes of its terms is a touch, at which there is no
/// derivative.
const TOUCH: f64 = 1e-12;

fn dot(row: &[f64], z: &[f64]) -> f64 {
    row.iter().zip(z).map(|(a, b)| a * b).sum()
}

/// Takes from a variation what contacts hold: e of closed stops, e' of these and of sticking
/// friction.
pub fn keep(system: &System, basis: &[Contact], variation: &mut [f64]) {
    if basis.is_empty() {
        return;
    }
    let r = triangle(&system.columns(basis));
    // Stops come first, and so does their part of the triangle.
    let stops = basis.iter().take_while(|contact| matches!(contact, Contact::Stop(_))).count();
    project(system, &basis[..stops], &r, false, variation, &mut Vec::new());
    project(system, basis, &r, true, variation, &mut Vec::new());
}

/// An event that a motion passes.
#[derive(Clone, Copy, Debug)]
pub struct Crossing<'a> {
    /// The mode before and the mode after it.
    pub modes: [&'a Mode; 2],
    /// The state before and after its law.
    pub states: [&'a [f64]; 2],
    /// z' before and after it.
    pub rates: [&'a [f64]; 2],
    /// The functional that has passed zero; none at a signal's knot, whose time does not vary.
    pub row: Option<&'a [f64]>,
    /// What was told of it.
    pub events: &'a [Event],
}

/// What impacts do to small changes of the velocities.
enum Jump {
    /// There are none.
    Nothing,
    /// One stop alone, with 1 + its restitution.
    Lone(usize, f64),
    /// Several: those that touch, with the restitutions in force.
    Several(Vec<usize>, Vec<f64>),
}

impl Crossing<'_> {
    /// Carries variations over the event. Where several stops are hit at one instant there may be
    /// no derivative; that of the impacts which take place is then taken.
    pub fn carry<'v>(&self, system: &System, variations: impl IntoIterator<Item = &'v mut [f64]>) {
        let (jump, own) = (self.jump(system), 2 * system.coordinates);
        let [incoming, outgoing] = self.rates;
        let passage = self.row.map(|row| {
            let terms: f64 = row.iter().zip(incoming).map(|(a, b)| (a * b).abs()).sum();
            (row, dot(row, incoming), TOUCH * terms)
        });
        for variation in variations {
            let later = match passage {
                Some((row, speed, touch)) if speed.abs() > touch => -dot(row, variation) / speed,
                _ => 0.0,
            };
            let mut met: Vec<f64> = variation.iter().zip(incoming).map(|(v, f)| v + f * later).collect();
            self.through_impacts(system, &jump, &mut met);
            // Signals are functions of time, and no event changes them.
            let (changed, _) = variation.split_at_mut(own);
            changed.iter_mut().zip(met.iter().zip(outgoing)).for_each(|(v, (m, f))| *v = m - f * later);
            keep(system, &self.modes[1].basis, variation);
        }
    }

    fn jump(&self, system: &System) -> Jump {
        let mut restitution: Vec<f64> = system.stops.iter().map(|s| s.restitution().unwrap_or(0.0)).collect();
        let mut hit = Vec::new();
        for event in self.events {
            match event.kind {
                EventKind::Impact { stop, .. } => hit.push(stop),
                // What closes has lost its last bounces.
                EventKind::Close { stop } => restitution[stop] = 0.0,
                _ => {}
            }
        }
        if hit.is_empty() {
            return Jump::Nothing;
        }
        let stops = self.modes[0].stops.iter().enumerate();
        hit.extend(stops.filter(|(_, state)| **state == StopState::Closed).map(|(i, _)| i));
        hit.sort_unstable();
        hit.dedup();
        match *hit {
            [stop] => Jump::Lone(stop, 1.0 + restitution[stop]),
            _ => Jump::Several(hit, restitution),
        }
    }

    /// What impacts make of a small change of the state before them.
    fn through_impacts(&self, system: &System, jump: &Jump, change: &mut [f64]) {
        let n = system.coordinates;
        match jump {
            Jump::Nothing => {}
            Jump::Lone(stop, factor) => {
                let e = &system.stops[*stop].elongation;
                let compliance = e.w.dot(&e.mobility);
                // A stop between prescribed bodies moves nothing.
                if compliance > 0.0 {
                    let impulse = factor * dot(e.rate.as_slice(), change) / compliance;
                    change[n..].iter_mut().zip(e.mobility.iter()).for_each(|(v, m)| *v -= impulse * m);
                }
            }
            Jump::Several(touching, restitution) => {
                let rows = touching.iter().map(|&i| system.stops[i].elongation.rate.as_slice());
                let rows: Vec<&[f64]> = rows.collect();
                let size = |z: &[f64]| {
                    let speeds = rows.iter().map(|row| dot(row, z).abs());
                    speeds.chain(z[n..2 * n].iter().map(|x| x.abs())).fold(0.0, f64::max)
                };
                let scale = size(change);
                if scale == 0.0 {
                    return;
                }
                let before = DVector::from_column_slice(self.states[0]);
                let step = STEP * size(self.states[0]).max(f64::MIN_POSITIVE) / scale;
                let sizes = Sizes(before.abs());
                let instant = Instant { system, sizes: &sizes, touching, restitution };
                let (mut plain, mut changed) = (before.clone(), before);
                changed.iter_mut().zip(&*change).for_each(|(z, d)| *z += step * d);
                // A jam has ended the motion before.
                if instant.collide(&mut plain).and(instant.collide(&mut changed)).is_ok() {
                    (n..2 * n).for_each(|k| change[k] = (changed[k] - plain[k]) / step);
                }
            }
        }
    }
}

impl Motion {
    /// The variations by each state (coordinates, then rates), and then by value and derivatives 1
    /// to 3 of each input in turn, less what contacts hold: each a variation of the augmented
    /// state, to be carried on by [`advance_with`](Self::advance_with).
    pub fn unit_variations(&self) -> Vec<Vec<f64>> {
        let system = &self.assembly.system;
        let signals = &system.signals;
        let inputs = (0..signals.inputs).filter_map(|i| signals.place_of_input(i));
        let places = (0..2 * system.coordinates).chain(inputs.flat_map(|first| first..first + 4));
        let unit = |place: usize| {
            let mut variation = vec![0.0; signals.size];
            variation[place] = 1.0;
            keep(system, &self.hybrid.mode.basis, &mut variation);
            variation
        };
        places.map(unit).collect()
    }

    /// Advances to a time or, if it is earlier, to the next event, before its law, and carries
    /// variations along. An event that is due is passed first.
    ///
    /// # Errors
    /// As [`advance_to`](Self::advance_to).
    pub fn advance_with(&mut self, end: f64, variations: &mut [Vec<f64>]) -> Result<Reached, Error> {
        self.pass_event_with(variations)?;
        let (table, from) = (self.tables.at(self.place).table.clone(), self.time());
        let outcome = self.advance_before_event(end, &mut |_| ())?;
        let span = self.time() - from;
        for variation in variations.iter_mut().filter(|_| span > 0.0) {
            table.carry(variation, span);
            keep(&self.assembly.system, &self.hybrid.mode.basis, variation);
        }
        Ok(outcome)
    }

    /// Applies the law of the event before which the last advance has ended, and carries variations
    /// over it; without one nothing happens.
    ///
    /// # Errors
    /// As [`apply_event`](Self::apply_event).
    pub fn pass_event_with(&mut self, variations: &mut [Vec<f64>]) -> Result<(), Error> {
        if !self.is_event_due() {
            return Ok(());
        }
        let before = (self.hybrid.mode.clone(), self.hybrid.z.clone());
        let rate = |motion: &Self| {
            let z = motion.hybrid.z.as_slice();
            motion.table().a.rows_times(0..z.len(), z)
        };
        let incoming = rate(self);
        // Of two functionals with one name the one that is zero here.
        let due = self.due();
        let ended = self.table().watched.iter().filter(|w| Some(w.watch) == due);
        let off = |row: &DVector<f64>| row.dot(&before.1).abs();
        let row = ended.map(|w| &w.row).min_by(|a, b| off(a).total_cmp(&off(b))).cloned();
        let mut events = Vec::new();
        self.pass_event(&mut Some(&mut |event| events.push(event.clone())))?;
        let outgoing = rate(self);
        let crossing = Crossing {
            modes: [&before.0, &self.hybrid.mode],
            states: [before.1.as_slice(), self.hybrid.z.as_slice()],
            rates: [incoming.as_slice(), outgoing.as_slice()],
            row: row.as_ref().map(|row| row.as_slice()),
            events: &events,
        };
        crossing.carry(&self.assembly.system, variations.iter_mut().map(Vec::as_mut_slice));
        Ok(())
    }
}
