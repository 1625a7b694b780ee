//! Derivatives over an event (docs/assembly-law.md (A35)). δt is the derivative of an event's time
//! by a parameter.

mod carried;

use super::columns::Columns;
use super::lost::{Cause, Lost};
use super::machine::{Instant, Machine, STILL, TOUCH, Varied};
use crate::functional::Functional;
use crate::mode::{Contact, SliderState, StopState, Watch};
use crate::motion::{Event, EventKind, Impulse};
use nalgebra::DVector;

/// An event that a motion has passed.
pub(super) struct Crossing<'a> {
    /// The machine with the rows of the mode before the event.
    pub machine: &'a Machine,
    /// The machine with the rows of the mode after the event.
    pub next: &'a Machine,
    /// The instant before the law is applied.
    pub before: Instant<'a, 'a>,
    /// The instant after the law is applied.
    pub after: Instant<'a, 'a>,
    /// The event function that has passed zero; `None` at a knot.
    pub due: Option<(Watch, &'a Functional)>,
    pub impulses: &'a [Impulse],
    pub events: &'a [Event],
    /// Earlier events of the same instant.
    pub earlier: &'a [Met],
    /// Event functions that reach zero at this instant.
    pub together: Vec<&'a (Watch, Functional)>,
    /// Event functions that are zero throughout the following mode, but may vary with a parameter.
    pub still: Vec<&'a (Watch, Functional)>,
}

/// Record of an event for later events at the same instant.
#[derive(Clone, Debug)]
pub(super) struct Met {
    watch: Watch,
    /// The event's δt by each parameter; `None` if it does not exist.
    later: Vec<Option<f64>>,
    /// Event functions that reached zero together with the event's own.
    together: Vec<Watch>,
    /// Whether forces or velocities jump at the event.
    jumps: bool,
}

/// δt of an event, and of other elements' events at the same instant.
#[derive(Clone, Debug)]
pub(super) struct Later {
    pub event: f64,
    own: Vec<(Contact, f64)>,
}

impl Later {
    /// The common δt of all elements; `None` if they differ.
    pub fn only(&self) -> Option<f64> {
        Some(self.event).filter(|event| self.own.iter().all(|own| !differ(own.1, *event)))
    }
}

fn stop_of(contact: Contact) -> Option<usize> {
    if let Contact::Stop(i) = contact { Some(i) } else { None }
}

fn differ(a: f64, b: f64) -> bool {
    (a - b).abs() > STILL * (a.abs() + b.abs())
}

impl Crossing<'_> {
    /// Whether forces, velocities or places jump at the event.
    fn jumps(&self) -> bool {
        let all = [(self.before.rates, self.after.rates), (self.before.z, self.after.z)];
        let differ = |(was, is): (&DVector<f64>, &DVector<f64>)| {
            // States of first order are left out: if a spring in series begins to stretch, its
            // force does not jump.
            let inner = self.machine.system.places_of_first_order();
            let all = was.iter().zip(is.iter()).enumerate().filter(|(i, _)| !inner.contains(i));
            all.into_iter().any(|(_, (a, b))| (a - b).abs() > STILL * (a.abs() + b.abs()))
        };
        !self.impulses.is_empty() || all.into_iter().any(differ)
    }

    /// Whether blocks are sampled.
    pub(super) fn is_sample(&self) -> bool {
        self.events.iter().any(|event| matches!(event.kind, EventKind::Sample { .. }))
    }

    /// Returns the stops that were open and are hit, except the stop whose event function is due.
    fn hit(&self) -> impl Iterator<Item = usize> {
        let due = match &self.due {
            Some((Watch::Meets(i), _)) => Some(*i),
            _ => None,
        };
        let was_open = |i: usize| self.before.mode.mode.stops[i] == StopState::Open;
        let all = self.events.iter().filter_map(|event| match event.kind {
            // A freewheel that an impact engages had no event time of its own.
            EventKind::Impact { stop, .. } => {
                Some(stop).filter(|&stop| self.machine.system.keeps_place(Contact::Stop(stop)))
            }
            _ => None,
        });
        // A redundant stop takes no impulse, but is hit all the same.
        let met = self.together.iter().filter_map(|(watch, _)| match watch {
            Watch::Meets(i) if self.due.is_some() => Some(*i),
            _ => None,
        });
        let all = all.chain(met);
        let mut all: Vec<usize> = all.filter(|&i| was_open(i) && due != Some(i)).collect();
        all.sort_unstable();
        all.dedup();
        all.into_iter()
    }

    /// Carries all columns over the event. Returns by column the δt of the event and of the other
    /// elements' events; `None` for a lost column.
    pub fn carry(
        &self,
        deltas: &mut Columns,
        scales: &Columns,
        lost: &mut [Option<Lost>],
    ) -> Vec<Option<Later>> {
        let mut all: Vec<Option<Later>> = vec![None; lost.len()];
        let alive: Vec<usize> = (0..lost.len()).filter(|&p| lost[p].is_none()).collect();
        let is_alone =
            self.is_alone() && !self.impulses.iter().any(|impulse| impulse.is_plastic(&self.machine.system));
        let mut times = vec![0.0; deltas.width];
        let mut apart = Vec::new();
        let tight = Impulse::all_tight(&self.machine.system, self.impulses, self.before.sizes);
        let is_tight = tight.iter().any(|stops| !stops.is_empty());
        for &p in &alive {
            let mut found = match &self.due {
                Some((_, row)) if is_alone => Ok((self.alone(p, row, deltas), false)),
                _ => self.later(p, &deltas.column(p), &scales.column(p)),
            };
            if let (true, Ok((later, false))) = (is_tight, &found)
                && let Err(lost) = self.check_tight(p, later.event, [deltas, scales], &tight)
            {
                found = Err(lost);
            }
            match found {
                Ok((later, is_apart)) => {
                    times[p + 1] = later.event;
                    if is_apart {
                        apart.push((p, deltas.column(p)));
                    }
                    all[p] = Some(later);
                }
                Err(found) => lost[p] = Some(found),
            }
        }
        let single: Vec<usize> = apart.iter().map(|own: &(usize, DVector<f64>)| own.0).collect();
        self.at_once(times, deltas, lost, &single);
        for (p, mut delta) in apart {
            let own = all[p].as_ref().map_or(&[][..], |later| &later.own);
            self.one_by_one(p, own, &mut delta);
            deltas.put(p, &delta);
        }
        for &p in alive.iter().filter(|_| !self.machine.system.curved.is_empty()) {
            let mut delta = deltas.column(p);
            self.next.vary_curved(p, self.after.z, &mut delta);
            deltas.put(p, &delta);
        }
        for p in alive {
            if let Err(found) = self.finish(p, deltas, scales, lost[p].take()) {
                (lost[p], all[p]) = (Some(found), None);
                deltas.put(p, &DVector::zeros(self.before.z.len()));
            }
        }
        deltas.put_state(self.after.z.as_slice());
        all
    }

    /// Applies a column's conditions on signals, contacts and event functions after the event.
    fn finish(
        &self,
        p: usize,
        deltas: &mut Columns,
        scales: &Columns,
        lost: Option<Lost>,
    ) -> Result<(), Lost> {
        if let Some(lost) = lost {
            return Err(lost);
        }
        let (machine, after) = (self.next, &self.after);
        if let Some(contact) = self.closed_by_jump() {
            return Err(Lost { time: after.time, element: machine.name_of(contact), cause: Cause::Jump });
        }
        let fills = machine.tangents[p].signals.varies();
        let holds = after.mode.mode.contacts().next().is_some();
        let slides = !machine.system.branches.is_empty();
        if !fills && !holds && !slides && self.still.is_empty() {
            return Ok(());
        }
        let (mut delta, scale) = (deltas.column(p), scales.column(p));
        machine.fill(p, after.time, after.z, &mut delta);
        machine.returns(Varied { p, delta: &delta, scale: &scale.sup(&delta.abs()) }, after)?;
        machine.keep(p, &mut delta, &scale, after)?;
        let moved = |i: usize| machine.system.was_moved(i, self.before.z.as_slice(), after.z.as_slice());
        machine.keep_levels(p, &mut delta, after, moved);
        machine.vary_curved(p, after.z, &mut delta);
        deltas.put(p, &delta);
        machine.check(Varied { p, delta: &delta, scale: &scale }, after, &self.still)
    }

    /// A contact with friction that a jump of a prescribed body has closed without a slip. Its
    /// slider depends on the part of the jump before the contact closed, and this part has no
    /// derivative here.
    fn closed_by_jump(&self) -> Option<Contact> {
        let [before, after] = [&self.before, &self.after].map(|at| &at.mode.mode.sliders);
        let is_closed = |i: &usize| before[*i] == SliderState::Off && after[*i] == SliderState::Held;
        let jumps = self.due.is_none() && self.machine.system.has_motions;
        (0..before.len()).find(|i| jumps && is_closed(i)).map(Contact::Slider)
    }

    /// Refuses a column that moves a stop off u⁺ = -ε u if the stop lies exactly on this equality.
    fn check_tight(
        &self,
        p: usize,
        later: f64,
        [deltas, scales]: [&Columns; 2],
        tight: &[Vec<usize>],
    ) -> Result<(), Lost> {
        let (machine, mut delta) = (self.machine, deltas.column(p));
        if self.due.is_some() {
            delta.axpy(later, self.before.rates, 1.0);
        } else {
            self.at_knot(p, later, &mut delta)?;
        }
        let scale = scales.column(p).sup(&delta.abs());
        let impacts = (self.impulses, tight);
        let found = Impulse::carry_one(&machine.system, &machine.tangents[p], impacts, (&delta, &scale));
        found.map(drop).map_err(|stop| Lost {
            time: self.before.time,
            element: machine.assembly.name_of_stop(stop),
            cause: Cause::Limit,
        })
    }

    /// Whether an event function passes zero with speed and nothing else comes to a limit.
    pub fn is_alone(&self) -> bool {
        let Some((watch, row)) = self.due else { return false };
        let terms: f64 = row.iter().zip(self.before.rates.iter()).map(|(a, b)| (a * b).abs()).sum();
        let is_touch = row.dot(self.before.rates).abs() <= TOUCH * terms;
        let others = self.together.iter().any(|(other, _)| other.contact() != watch.contact());
        !is_touch && !others && self.earlier.is_empty() && self.hit().next().is_none()
    }

    /// Whether an event function that is zero after the event is independent of all parameters.
    /// This applies to the place or rate of a contact that was held before, or that has come to
    /// its limit.
    pub(super) fn stays_still(&self, watch: Watch) -> bool {
        let contact = watch.contact();
        let is_due = self.due.is_some_and(|due| due.0.contact() == contact);
        let is_kept = is_due || self.before.mode.mode.contacts().any(|held| held == contact);
        match watch {
            // A rate that also reaches zero at this instant does not stay zero.
            Watch::Stops(_) | Watch::Turns(_) => {
                is_kept || self.together.iter().any(|own| own.0.contact() == contact)
            }
            Watch::Meets(_) | Watch::Presses(_) | Watch::Leaves(_) => is_kept,
            // The force was at its level while the slider slipped.
            Watch::Yields(i, _) => self.before.mode.mode.sliders[i] != SliderState::Held,
            _ => false,
        }
    }

    /// The δt of an isolated event.
    fn alone(&self, p: usize, row: &Functional, deltas: &Columns) -> Later {
        let (machine, before) = (self.machine, &self.before);
        let own = |&(j, h): &(usize, f64)| h * deltas.numbers[j * deltas.width + p + 1];
        let mut varied: f64 = row.terms().iter().map(own).sum();
        let tangent = &machine.tangents[p];
        if let Some((watch, _)) = self.due.filter(|_| !tangent.is_zero) {
            varied += before.mode.row_by(&machine.system, tangent, p, watch, row).dot(before.z);
        }
        Later { event: -varied / row.dot(before.rates), own: Vec::new() }
    }

    /// Returns the δt of the event and of the other elements' events by parameter `p`, and whether
    /// each of these elements changes the motion separately.
    fn later(&self, p: usize, delta: &DVector<f64>, scale: &DVector<f64>) -> Result<(Later, bool), Lost> {
        let lost = |element, cause| Lost { time: self.before.time, element, cause };
        let (machine, tangent) = (self.machine, &self.machine.tangents[p]);
        if let Some(stop) = self.impulses.iter().find_map(|i| i.at_limit(&machine.system, tangent)) {
            return Err(lost(machine.name_of(Contact::Stop(stop)), Cause::Limit));
        }
        let column = Varied { p, delta, scale };
        let event = match self.due {
            Some((watch, row)) => {
                let by = self.before.mode.row_by(&machine.system, tangent, p, watch, row);
                let touch = |()| lost(machine.assembly.name_of(watch), Cause::Touch);
                machine.later(column, &self.before, (row, &by)).map_err(touch)?
            }
            None if self.is_sample() => match machine.moves_steps(&column, self.before.time) {
                true => return Err(lost("a step at a sample".into(), Cause::Together)),
                false => 0.0,
            },
            None => tangent.signals.later(self.before.time).map_or(0.0, |knot| knot.later),
        };
        let (own, apart) = self.others(column, event)?;
        Ok((Later { event, own }, apart))
    }

    /// Compares the event with the other events of the instant. Returns their elements with their
    /// δt, and whether they are impacts with different δt on uncoupled stops.
    fn others(&self, column: Varied, later: f64) -> Result<(Vec<(Contact, f64)>, bool), Lost> {
        let lost = |element, cause| Lost { time: self.before.time, element, cause };
        self.check_earlier(column.p, later)?;
        let mut times = self.changed_with(column, later)?;
        let (machine, mode) = (self.machine, self.before.mode);
        let first = times.len();
        for i in self.hit() {
            let rows = (&*machine.system.stops[i].excess, &machine.tangents[column.p].stops[i].excess);
            let own = machine.later(column, &self.before, rows);
            let touch = |()| lost(machine.name_of(Contact::Stop(i)), Cause::Touch);
            times.push((Contact::Stop(i), own.map_err(touch)?));
        }
        if times[first..].iter().all(|&(_, time)| !differ(time, later)) {
            return Ok((times, false));
        }
        if let Some((Watch::Meets(i), _)) = self.due {
            times.push((Contact::Stop(i), later));
        }
        let stays = self.before.mode.mode == self.after.mode.mode;
        let e = |contact| machine.system.elongation_of(contact);
        let hit = &times[first..];
        let mut stops: Vec<usize> = self.impulses.iter().flat_map(|impulse| impulse.stops.clone()).collect();
        stops.sort_unstable();
        let mut own: Vec<usize> = hit.iter().filter_map(|hit| stop_of(hit.0)).collect();
        own.sort_unstable();
        let alone = stops == own;
        let coupled = |&&(a, _): &&(Contact, f64)| {
            hit.iter().any(|&(b, _)| a != b && machine.are_coupled(mode, e(a), e(b)))
        };
        match hit.iter().find(coupled) {
            None if alone && stays && self.due.is_some() => Ok((times, true)),
            found => Err(lost(machine.name_of(found.unwrap_or(&hit[0]).0), Cause::Together)),
        }
    }

    /// Refuses an event that was due together with an earlier one of this instant if their δt
    /// differ and their order matters.
    fn check_earlier(&self, p: usize, later: f64) -> Result<(), Lost> {
        let Some((watch, _)) = &self.due else { return Ok(()) };
        let (machine, time) = (self.machine, self.before.time);
        let e = machine.elongation(*watch, p).0;
        for met in self.earlier.iter().filter(|met| met.together.contains(watch)) {
            let other = machine.elongation(met.watch, p).0;
            let same = met.later[p].is_none_or(|time| !differ(time, later));
            if !same && (met.jumps || self.jumps()) && machine.are_coupled(self.before.mode, e, other) {
                return Err(Lost { time, element: machine.assembly.name_of(*watch), cause: Cause::Together });
            }
        }
        Ok(())
    }

    /// Returns other elements that come to their limits at this instant, with their δt: all of
    /// them at a knot, otherwise the elements that change state. Refuses an element with a
    /// different δt if forces or velocities jump.
    fn changed_with(&self, column: Varied, later: f64) -> Result<Vec<(Contact, f64)>, Lost> {
        let (machine, mode) = (self.machine, self.before.mode);
        let due = self.due.as_ref().map(|due| due.0.contact());
        let changes = |contact| match contact {
            Contact::Stop(i) => self.after.mode.mode.stops[i] != mode.mode.stops[i],
            Contact::Friction(i) => self.after.mode.mode.frictions[i] != mode.mode.frictions[i],
            Contact::Slider(i) => self.after.mode.mode.sliders[i] != mode.mode.sliders[i],
        };
        let mut times = Vec::new();
        for (watch, row) in self.together.iter().copied() {
            let contact = watch.contact();
            let is_hit = matches!(watch, Watch::Meets(_)) && due.is_some();
            if Some(contact) == due || is_hit || (due.is_some() && !changes(contact)) {
                continue;
            }
            let by = mode.row_by(&machine.system, &machine.tangents[column.p], column.p, *watch, row);
            let Ok(own) = machine.later(column, &self.before, (row, &by)) else { continue };
            if differ(own, later) && self.jumps() {
                let element = machine.name_of(contact);
                return Err(Lost { time: self.before.time, element, cause: Cause::Together });
            }
            times.push((contact, own));
        }
        Ok(times)
    }

    /// Returns the derivative of a reported event's time; for a closing stop it uses `delta`, the
    /// derivative of the state before the event. A stop closes when its bounces accumulate, at the
    /// time 2 ε u/(a (1 - ε)) after the last impact that is simulated.
    pub fn time_of(
        &self,
        p: usize,
        event: &Event,
        later: &Later,
        delta: Option<&DVector<f64>>,
    ) -> Option<f64> {
        let own = event.contact().and_then(|contact| later.own.iter().find(|own| own.0 == contact));
        let later = own.map_or(later.event, |own| own.1);
        let EventKind::Close { stop } = event.kind else { return Some(later) };
        let e = self.machine.system.stops[stop].restitution()?;
        let bounce = event.time - self.before.time;
        if bounce <= 0.0 {
            // Without bounces the stop closes at the impact. For ε = 1 the sum of the bounces'
            // durations diverges.
            return (e < 1.0).then_some(later);
        }
        let delta = delta?;
        let (rows, own) = self.machine.contact(Contact::Stop(stop), p);
        let (speed, push) = (rows.rate.dot(self.before.z), rows.rate.dot(self.before.rates));
        let met = delta + self.before.rates * later;
        let dspeed = rows.rate.dot(&met) + own.rate.dot(self.before.z);
        let bent = self.before.mode.rates_by(p, self.before.z, &met);
        let dpush = rows.rate.dot(&bent) + own.rate.dot(self.before.rates);
        let de = self.machine.tangents[p].stops[stop].restitution;
        let relative = dspeed / speed - dpush / push + de / (e * (1.0 - e));
        Some(later + bounce * relative).filter(|time| time.is_finite())
    }

    /// Returns a record of this event for later events at the same instant; `None` at a knot.
    pub fn met(&self, later: Vec<Option<f64>>) -> Option<Met> {
        let (watch, _) = self.due.as_ref()?;
        let together = self.together.iter().map(|(watch, _)| *watch).collect();
        Some(Met { watch: *watch, later, together, jumps: self.jumps() })
    }
}
