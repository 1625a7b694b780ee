//! Derivatives at the start of a motion (docs/assembly-law.md (A37)).

use super::by::By;
use super::lost::{Cause, Lost};
use super::machine::{BESIDE, Instant, Machine, STILL, TOUCH, Varied};
use super::rest::equilibrium;
use super::samples::actions;
use crate::functional::Functional;
use crate::law::ZERO;
use crate::mode::{Contact, StopState, Watch};
use crate::motion::{Event, EventKind, Impulse};
use crate::system::Part;
use nalgebra::DVector;

/// Relative tolerance for the rounding of a stretch kept by the start.
const MOVED: f64 = 1e-12;

/// Source of the initial state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Given {
    /// The machine's own numbers.
    Machine,
    /// A given state, which no parameter varies.
    State,
    /// A motion under way: its state follows the constraints of held contacts.
    Motion,
}

/// The start of a motion.
pub(super) struct Start<'a> {
    pub machine: &'a Machine,
    pub given: Given,
    /// The state before the law is applied.
    pub begun: &'a DVector<f64>,
    /// The events of the law at the start.
    pub events: &'a [Event],
    /// The instant after the law is applied.
    pub at: Instant<'a, 'a>,
    /// Elements with an event function that is zero throughout the mode.
    pub throughout: Vec<Contact>,
}

impl Start<'_> {
    /// Returns column `p` of the derivative after the law at the start.
    pub fn derivative(&self, p: usize) -> Result<DVector<f64>, Lost> {
        let (machine, at) = (self.machine, &self.at);
        let (system, tangent) = (&machine.system, &machine.tangents[p]);
        self.check_steps(p)?;
        let delta = self.before(p)?;
        let scale = delta.abs();
        self.check_touching(Varied { p, delta: &delta, scale: &scale })?;
        let impacts = Impulse::all(system, self.events, self.begun);
        if let Some(stop) = impacts.iter().find_map(|impulse| impulse.at_limit(system, tangent)) {
            return Err(self.limit(machine.assembly.name_of_stop(stop)));
        }
        let tight = Impulse::all_tight(system, &impacts, at.sizes);
        let found = Impulse::carry_one(system, tangent, (&impacts, &tight), (&delta, &scale));
        let mut delta = found.map_err(|stop| self.limit(machine.assembly.name_of_stop(stop)))?;
        self.sample(p, &mut delta)?;
        let mut scale = scale.sup(&delta.abs());
        // An impact that removes a rate may leave the rounding error of the rate's change.
        let kicks: f64 = impacts.iter().map(|impulse| impulse.kick_size(system, tangent)).sum();
        scale.rows_mut(system.coordinates, system.coordinates).add_scalar_mut(kicks);
        machine.returns(Varied { p, delta: &delta, scale: &scale }, at)?;
        let begun = delta.clone();
        machine.keep(p, &mut delta, &scale, at)?;
        // Inner places keep their given values.
        let still = DVector::zeros(delta.len());
        machine.stretch(p, &still, &(&delta - begun), &mut delta);
        machine.keep_levels(p, &mut delta, at, |i| self.is_moved(i));
        let mut still = machine.still(at, true);
        still.extend(at.mode.watched.iter().filter(|own| self.is_at_level(own)));
        still.retain(|(watch, _)| !matches!(*watch, Watch::Meets(i) if self.separates(i)));
        machine.check(Varied { p, delta: &delta, scale: &scale }, at, &still)?;
        if machine.columns[p] == By::Time {
            delta -= at.rates;
            machine.fill(p, at.time, at.z, &mut delta);
        }
        Ok(delta)
    }

    /// Carries a derivative over the samples at the start.
    fn sample(&self, p: usize, delta: &mut DVector<f64>) -> Result<(), Lost> {
        let (system, sampled) = (&self.machine.system, actions(self.events));
        if sampled.is_empty() {
            return Ok(());
        }
        // The velocities after impacts, with the states that blocks keep before the samples.
        let mut z = self.at.z.clone();
        let kept = 2 * system.coordinates + system.branches.len()..system.states();
        z.rows_range_mut(kept.clone()).copy_from(&self.begun.rows_range(kept));
        self.machine.sample(p, (self.at.time, &sampled), &z, delta)
    }

    /// Adds the derivative of a start at rest, including outputs of the samples at time 0.
    fn rest(&self, p: usize, delta: &mut DVector<f64>) -> Result<(), Lost> {
        let system = &self.machine.system;
        let (n, branches) = (system.coordinates, system.branches.len());
        let starts = self.machine.tangents[p].inner.iter().enumerate().skip(branches);
        let mut sampled = delta.clone();
        starts.for_each(|(k, by)| sampled[2 * n + k] += by);
        self.sample(p, &mut sampled)?;
        equilibrium(self.machine, p, &mut sampled, &self.at)?;
        let found = 0..2 * n + branches;
        delta.rows_range_mut(found.clone()).copy_from(&sampled.rows_range(found));
        Ok(())
    }

    /// Returns the derivative before the law. A later start uses the signals at its own time.
    fn before(&self, p: usize) -> Result<DVector<f64>, Lost> {
        let (machine, at) = (self.machine, &self.at);
        let (tangent, n, one) =
            (&machine.tangents[p], machine.system.coordinates, machine.system.signals.one);
        let mut delta = DVector::zeros(machine.system.signals.size);
        machine.fill(p, at.time, at.z, &mut delta);
        match machine.columns[p] {
            By::Start(place) => delta[place] = 1.0,
            By::Time => delta.rows_range_mut(one..).copy_from(&at.rates.rows_range(one..)),
            By::Parameter(_) if self.given != Given::Machine => {}
            By::Parameter(_) => {
                if machine.assembly.description.starts_at_rest {
                    self.rest(p, &mut delta)?;
                }
                for (k, &(s, v)) in tangent.starts.iter().enumerate() {
                    delta[k] += s;
                    delta[n + k] += v;
                }
                for (k, slider) in tangent.inner.iter().enumerate() {
                    delta[2 * n + k] += slider;
                }
            }
        }
        machine.take_given(p, at.z, &mut delta);
        machine.vary_curved(p, at.z, &mut delta);
        Ok(delta)
    }

    /// Returns the direction of a branch's force if the start has moved its slider to its level.
    fn is_moved(&self, i: usize) -> Option<f64> {
        let (machine, z) = (self.machine, self.begun);
        let branch = &machine.system.branches[i];
        if machine.system.is_residual(Part::Branch(i)) {
            return None;
        }
        let given = machine.assembly.inner[branch.place - 2 * machine.system.coordinates];
        let stretch = branch.elongation.e.at(z.as_slice()) - given;
        // After the start the place of a branch has its stretch.
        let shorter = stretch.abs() > (1.0 + MOVED) * self.at.z[branch.place].abs();
        let is_moved = self.given == Given::Machine && shorter;
        is_moved.then(|| stretch.signum())
    }

    /// Whether a slider is held at its level, so that a varied force moves it on one side only. In
    /// a start at rest the slider has come to its level from zero, which does not count.
    fn is_at_level(&self, (watch, row): &(Watch, Functional)) -> bool {
        let rests = self.given == Given::Machine && self.machine.assembly.description.starts_at_rest;
        match *watch {
            Watch::Yields(i, _) => {
                !rests && self.is_moved(i).is_none() && self.machine.is_zero(row, &self.at)
            }
            _ => false,
        }
    }

    fn limit(&self, element: String) -> Lost {
        Lost { time: self.at.time, element, cause: Cause::Limit }
    }

    /// Refuses a step or sample at the time of the start if the column varies either time.
    fn check_steps(&self, p: usize) -> Result<(), Lost> {
        let (machine, time) = (self.machine, self.at.time);
        let moves = machine.tangents[p].signals.later(time).is_some();
        let passes = machine.columns[p] == By::Time && machine.system.signals.knots_at(time) > 0;
        let samples = machine.columns[p] == By::Time && !actions(self.events).is_empty();
        if moves || passes || samples { Err(self.limit(format!("the step at {time} s"))) } else { Ok(()) }
    }

    fn is_hit(&self, i: usize) -> bool {
        self.events.iter().any(|event| matches!(event.kind, EventKind::Impact { stop, .. } if stop == i))
    }

    /// Whether a rigid stop of a given state touches and separates: the start then varies as if
    /// the stop did not exist.
    fn separates(&self, i: usize) -> bool {
        let (rows, at) = (&self.machine.system.stops[i], &self.at);
        let leaves = || rows.excess.dot(at.rates) < -self.machine.speed_size(&rows.excess, at) * TOUCH;
        self.given != Given::Machine && rows.restitution().is_some() && !self.is_hit(i) && leaves()
    }

    /// Refuses a stop that touches at the start if the column moves it to either side.
    fn check_touching(&self, column: Varied) -> Result<(), Lost> {
        let (machine, at) = (self.machine, &self.at);
        for (i, stop) in machine.system.stops.iter().enumerate() {
            // A freewheel has no place, and its rate counts after the law: see `returns`, `still`.
            if stop.is_freewheel || !machine.is_zero(&stop.excess, at) {
                continue;
            }
            let (point, by) = (machine.point(column, at), &machine.tangents[column.p].stops[i]);
            let moves = |row, by| point.of(row, by).abs() > STILL * point.size(row, by);
            let place = moves(&stop.excess, &by.excess);
            let rate = moves(&stop.elongation.rate, &by.elongation.rate);
            let differs = match stop.restitution() {
                Some(_) => (place && !self.follows(i, column.p)) || (rate && self.turns(i)),
                // Its force begins with a jump, or on one side only.
                None => {
                    let is_edge = self.throughout.contains(&Contact::Stop(i));
                    (place && !machine.is_smooth(Watch::Presses(i))) || ((place || rate) && is_edge)
                }
            };
            if differs {
                return Err(self.limit(machine.assembly.name_of_stop(i)));
            }
        }
        Ok(())
    }

    /// Whether the start varies with the place of a rigid stop that touches: if the stop
    /// separates, or if it is held and the motion is under way or begins at rest, for a parameter.
    fn follows(&self, i: usize, p: usize) -> bool {
        let is_held = self.at.mode.mode.stops[i] == StopState::Closed && !self.is_hit(i);
        let varies = || match self.given {
            Given::Machine => {
                let rests = self.machine.assembly.description.starts_at_rest;
                rests && matches!(self.machine.columns[p], By::Parameter(_))
            }
            Given::State => false,
            Given::Motion => true,
        };
        (is_held && varies()) || self.separates(i)
    }

    /// Whether a rigid stop that touches without a closing speed is hit on one side only when its
    /// rate varies. A held stop comes to rest again ([`Machine::returns`]), unless an impact at
    /// the start moves it.
    fn turns(&self, i: usize) -> bool {
        let (system, at) = (&self.machine.system, &self.at);
        let own = &system.stops[i].elongation;
        let zero = BESIDE * ZERO * own.rate.size(at.sizes.as_slice());
        if self.is_hit(i) && own.rate.at(self.begun.as_slice()).abs() > zero {
            return false;
        }
        let is_kicked = |event: &Event| match event.kind {
            EventKind::Impact { stop, .. } => own.w.dot(&system.stops[stop].elongation.mobility) != 0.0,
            _ => false,
        };
        let is_still = own.rate.at(self.begun.as_slice()).abs() <= zero;
        let is_held = at.mode.mode.stops[i] == StopState::Closed;
        is_still && (!is_held || self.events.iter().any(is_kicked))
    }
}
