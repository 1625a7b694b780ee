//! Derivatives at the start of a motion (docs/assembly-law.md (A32)).

use super::by::By;
use super::columns::Columns;
use super::impulse::Impulse;
use super::lost::{Cause, Lost};
use super::machine::{Instant, Machine, STILL, TOUCH, Varied};
use super::rest::equilibrium;
use crate::mode::{StopState, Watch};
use crate::motion::{Event, EventKind};
use nalgebra::DVector;

/// The start of a motion.
pub(super) struct Start<'a> {
    pub machine: &'a Machine,
    /// Whether its state was given, so that no parameter moves it.
    pub is_given: bool,
    /// The state before the law.
    pub begun: &'a DVector<f64>,
    /// What the law has done.
    pub events: &'a [Event],
    /// The instant after the law.
    pub at: Instant<'a, 'a>,
}

impl Start<'_> {
    /// The derivative of column `p` after the law at the start.
    pub fn derivative(&self, p: usize) -> Result<DVector<f64>, Lost> {
        let (machine, at) = (self.machine, &self.at);
        let (system, tangent) = (&machine.system, &machine.tangents[p]);
        self.check_steps(p)?;
        let mut delta = self.before(p)?;
        let scale = delta.abs();
        self.check_touching(Varied { p, delta: &delta, scale: &scale })?;
        for impulse in &Impulse::all(system, self.events, self.begun) {
            if let Some(stop) = impulse.at_limit(system, tangent) {
                return Err(self.limit(machine.assembly.name_of_stop(stop)));
            }
            let mut alone = Columns::zeros(delta.len(), 1);
            alone.put(0, &delta);
            impulse.carry(system, &machine.tangents[p..=p], &mut alone);
            delta = alone.column(0);
        }
        machine.keep(p, &mut delta, &scale, at)?;
        let mut still = machine.still(at, true);
        still.retain(|(watch, _)| !matches!(*watch, Watch::Meets(i) if self.leaves(i)));
        machine.check(Varied { p, delta: &delta, scale: &scale }, at, &still)?;
        if machine.columns[p] == By::Time {
            delta -= at.rates;
            machine.fill(p, at.time, at.z, &mut delta);
        }
        Ok(delta)
    }

    /// The derivative before the law. A later start finds the signals as they are then.
    fn before(&self, p: usize) -> Result<DVector<f64>, Lost> {
        let (machine, at) = (self.machine, &self.at);
        let (tangent, n, one) =
            (&machine.tangents[p], machine.system.coordinates, machine.system.signals.one);
        let mut delta = DVector::zeros(machine.system.signals.size);
        machine.fill(p, at.time, at.z, &mut delta);
        match machine.columns[p] {
            By::Start(place) => delta[place] = 1.0,
            By::Time => delta.rows_range_mut(one..).copy_from(&at.rates.rows_range(one..)),
            By::Parameter(_) if self.is_given => {}
            By::Parameter(_) => {
                if machine.assembly.description.starts_at_rest {
                    equilibrium(machine, p, &mut delta, at)?;
                }
                for (k, &(s, v)) in tangent.starts.iter().enumerate() {
                    delta[k] += s;
                    delta[n + k] += v;
                }
            }
        }
        Ok(delta)
    }

    fn limit(&self, element: String) -> Lost {
        Lost { time: self.at.time, element, cause: Cause::Limit }
    }

    /// Refuses a step at the time of the start where one of both varies.
    fn check_steps(&self, p: usize) -> Result<(), Lost> {
        let (machine, time) = (self.machine, self.at.time);
        let moves = machine.tangents[p].signals.later(time).is_some();
        let passes = machine.columns[p] == By::Time && machine.system.signals.knots_at(time) > 0;
        if moves || passes { Err(self.limit(format!("the step at {time} s"))) } else { Ok(()) }
    }

    /// Whether a rigid stop, whose state was given, touches and stays closed or separates: the
    /// start then varies as the contact allows. A stop that is hit has an event on one side only.
    fn leaves(&self, i: usize) -> bool {
        let (rows, at) = (&self.machine.system.stops[i], &self.at);
        let is_hit = |event: &Event| matches!(event.kind, EventKind::Impact { stop, .. } if stop == i);
        let separates = || rows.excess.dot(at.rates) < -self.machine.speed_size(&rows.excess, at) * TOUCH;
        let is_held = at.mode.mode.stops[i] == StopState::Closed;
        self.is_given
            && rows.restitution().is_some()
            && !self.events.iter().any(is_hit)
            && (is_held || separates())
    }

    /// Refuses a rigid stop that touches at the start, and a damped compliant one at its gap, whose
    /// gap varies: it then has an event on one side only.
    fn check_touching(&self, column: Varied) -> Result<(), Lost> {
        let (machine, at) = (self.machine, &self.at);
        for (i, stop) in machine.system.stops.iter().enumerate() {
            let rests = !self.is_given && machine.assembly.description.starts_at_rest;
            let is_held = rests && at.mode.mode.stops[i] == StopState::Closed;
            let is_smooth = machine.is_smooth(Watch::Presses(i)) && stop.restitution().is_none();
            if is_held || is_smooth || self.leaves(i) {
                continue;
            }
            let (row, by) = (&stop.excess, &machine.tangents[column.p].stops[i].excess);
            let point = machine.point(column, at);
            if machine.is_zero(row, at) && point.of(row, by).abs() > STILL * point.size(row, by) {
                return Err(self.limit(machine.assembly.name_of_stop(i)));
            }
        }
        Ok(())
    }
}
