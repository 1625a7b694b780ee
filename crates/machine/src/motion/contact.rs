//! The law at an event: impacts, the mode that follows, and the reports.

use super::event::EventKind;
use super::jump::{BeforeJump, Parted};
use super::projection::project;
use super::report::report;
use super::{Hybrid, Motion, Observer, Scratch};
use crate::error::Error;
use crate::flow::ORDERS;
use crate::law::Sizes;
use crate::law::box_qp::Jam;
use crate::law::impact::{Impacts, Instant};
use crate::law::selection::{EventVerdict, Selection, SliderFlag};
use crate::mode::{Contact, Mode, StopState, Watch};
use crate::system::{BranchLaw, Elongation, Part, System};
use nalgebra::DVector;

/// Up to this multiple of the zero tolerance, a derivative that is positive where the law requires
/// a negative one counts as rounding. A larger derivative may change modes without end, which is
/// an error.
pub(super) const DOUBTFUL: f64 = 1e3;

/// Fraction of (time × change of rate by the forces' sizes) that counts as distance travelled
/// (docs/assembly-law.md (A18)): less than a moving body travels, and at least the rounding of a
/// body at rest.
const STANDING: f64 = 0.01;

/// The owned form of an [`EventVerdict`].
#[derive(Clone, Default)]
pub(super) struct Flags {
    stops: Vec<bool>,
    resting: Vec<bool>,
    edges: Vec<bool>,
    limits: Vec<bool>,
    sliders: Vec<SliderFlag>,
}

impl Flags {
    /// Returns the verdict for the law; the stops `open` count as open at any speed.
    pub(super) fn verdict<'a>(&'a self, open: &'a [usize]) -> EventVerdict<'a> {
        let Self { stops, resting, edges, limits, sliders } = self;
        EventVerdict { stops, resting, edges, limits, sliders, open }
    }

    /// Whether the event has brought a compliant stop to its edge.
    pub(super) fn edge(&self, stop: usize) -> bool {
        self.edges[stop]
    }

    /// The flag of a branch's slider.
    pub(super) fn slider(&self, branch: usize) -> SliderFlag {
        self.sliders[branch]
    }

    /// Returns the verdict after impacts that changed the velocities by `kick`. A friction whose
    /// rate has changed no longer rests. The force of a compliant stop whose rate has changed is
    /// no longer at a limit.
    fn after(&self, kick: &DVector<f64>, system: &System, sizes: &Sizes) -> Self {
        let mut flags = self.clone();
        let moved = |e: &Elongation| e.w.dot(kick).abs() > sizes.zero_of(&e.rate);
        let frictions = flags.resting.iter_mut().zip(&system.frictions);
        frictions.for_each(|(rests, friction)| *rests &= !moved(&friction.elongation));
        for wheel in system.freewheels() {
            flags.stops[wheel] &= !moved(&system.stops[wheel].elongation);
        }
        let stops = flags.limits.iter_mut().zip(&system.stops);
        stops.for_each(|(limit, stop)| *limit &= !moved(&stop.elongation));
        let sliders = flags.sliders.iter_mut().zip(&system.branches);
        sliders.for_each(|(flag, branch)| {
            let presses = branch.stop().is_some_and(|stop| moved(&system.stops[stop].elongation));
            flag.turns &= !presses && !moved(&branch.elongation);
        });
        flags
    }
}

/// The slider of a contact over a jump.
struct Carried {
    /// The stretch of the contact's spring after the jump.
    stretch: f64,
    /// The direction of a slider at its level; 0 below the level.
    direction: f64,
    /// The energy loss over the tangential stiffness.
    lost: f64,
}

/// Carries the stretch of a contact's spring over a jump. The elongation grows steadily by `jump`,
/// and the largest stretch from `from` to `to`; the contact is open where the latter is negative.
fn carried(stretch: f64, jump: f64, [from, to]: [f64; 2]) -> Carried {
    let growth = to - from;
    if from.max(to) <= 0.0 {
        return Carried { stretch: 0.0, direction: 0.0, lost: 0.0 };
    }
    // The parts of the jump at which the contact closes and opens.
    let closes = if from < 0.0 { -from / growth } else { 0.0 };
    let opens = if to < 0.0 { -from / growth } else { 1.0 };
    let begun = if from < 0.0 { 0.0 } else { stretch };
    let most = |at: f64| (from + growth * at).max(0.0);
    let slip = |direction: f64| {
        // The slider slips once the distance to its limit is used up.
        let (room, closing) = (most(closes) - direction * begun, direction * jump - growth);
        let at = if closing > 0.0 { closes + room.max(0.0) / closing } else { f64::INFINITY };
        (at < opens).then_some((direction, at, closing * (opens - at)))
    };
    let found = [1.0, -1.0].into_iter().filter_map(slip).min_by(|a, b| a.1.total_cmp(&b.1));
    let Some((direction, at, way)) = found else {
        let stretch = if opens < 1.0 { 0.0 } else { begun + jump * (1.0 - closes) };
        return Carried { stretch, direction: 0.0, lost: 0.0 };
    };
    let reached = if opens < 1.0 { 0.0 } else { most(1.0) };
    let lost = 0.5 * (most(at) + reached) * way;
    Carried { stretch: direction * reached, direction, lost }
}

/// Whether a bounce with speed `rebound` against an acceleration is lower than `least`, by (A19).
pub(super) fn is_low(rebound: f64, acceleration: f64, least: f64) -> bool {
    rebound * rebound < 2.0 * acceleration * least
}

/// The order of an event function's zero, from its first nonzero derivative. The law makes this
/// derivative negative: slightly positive values count as zero.
fn order_of(departure: Option<(usize, f64)>) -> usize {
    match departure {
        None => ORDERS,
        Some((0, _)) => 0,
        // If the derivative is positive, a passage is imminent. The order is then one less, so
        // that this passage is not divided out.
        Some((order, value)) => order - usize::from(value > 0.0),
    }
}

impl Motion {
    /// Applies the law at the present state: impacts, then the next mode. The event functions
    /// `ended` have passed zero; a jump has separated the contacts `parted`.
    pub(super) fn settle(
        &mut self,
        ended: &[Watch],
        parted: &Parted,
        observer: &mut Observer,
    ) -> Result<(), Error> {
        self.include_flight();
        if let [watch] = *ended
            && self.lone_event(watch, observer)
        {
            return Ok(());
        }
        self.take_rows_of_state(parted);
        let mut flags = self.flags(ended, parted);
        self.place_at_start(&mut flags, parted);
        let before = self.hybrid.mode.clone();
        let gaps = self.assembly.system.first_freewheel;
        let touching: Vec<usize> = (0..gaps).filter(|&i| flags.stops[i]).collect();
        let velocities = self.velocities();
        let (impacts, closing) = self.collide(&touching, &flags)?;
        self.report_impacts(&impacts, observer);
        let kick = self.velocities() - velocities;
        let mode = self.select(&flags.after(&kick, &self.assembly.system, &self.hybrid.sizes))?;
        self.enter(mode);
        self.report_changes(&before, &closing, observer);
        Ok(())
    }

    /// Updates the largest sizes of velocities and coordinates by the terms since the mode began
    /// (docs/assembly-law.md (A18)).
    pub(super) fn include_flight(&mut self) {
        let time = self.time();
        let (n, one) = (self.assembly.system.coordinates, self.assembly.system.states());
        let hybrid = &mut self.hybrid;
        if time <= hybrid.since {
            return;
        }
        let Scratch { start, rates, second, .. } = &mut self.scratch;
        let (sizes, start) = (hybrid.sizes.0.as_mut_slice(), start.as_mut_slice());
        start.copy_from_slice(sizes);
        for (size, x) in start.iter_mut().zip(hybrid.z.as_slice()).take(one) {
            *size = x.abs();
        }
        // Sizes of curved forces follow from these. Their largest sizes depend on the sizes raised
        // here, which would then grow without end.
        self.assembly.system.set_curved_sizes(hybrid.z.as_slice(), start);
        rates.resize(start.len(), 0.0);
        let flight_sizes = &mut rates[..one - n];
        let table = &self.tables.at(self.place).table;
        let flight = (time - hybrid.since).min(table.length_for(hybrid.z.as_slice(), sizes));
        table.flight_sizes(start, flight, second, flight_sizes);
        let flight = STANDING * flight;
        let (places, rates) = sizes.split_at_mut(n);
        for (place, flight_sizes) in places.iter_mut().zip(&*flight_sizes) {
            *place = place.max(flight * *flight_sizes);
        }
        for (rate, flight_sizes) in rates.iter_mut().zip(flight_sizes) {
            *rate = rate.max(*flight_sizes);
        }
        hybrid.since = time;
    }

    /// Updates the largest sizes by the contacts of the present mode.
    pub(super) fn include_contacts(&mut self) {
        let Hybrid { sizes, mode, .. } = &mut self.hybrid;
        mode.basis.iter().for_each(|&contact| sizes.include_contact(&self.assembly.system, contact));
    }

    /// Applies a signal's knot, at which prescribed bodies may have jumped.
    pub(super) fn apply_knot(
        &mut self,
        stood: Option<BeforeJump>,
        observer: &mut Observer,
    ) -> Result<(), Error> {
        self.include_state();
        report(observer, self.time(), EventKind::Knot);
        self.apply_jump(stood, observer)
    }

    /// Applies the law after signals have been set: jumps, then impacts and the mode that follows.
    pub(super) fn apply_jump(
        &mut self,
        stood: Option<BeforeJump>,
        observer: &mut Observer,
    ) -> Result<(), Error> {
        if stood.is_none() && !self.assembly.system.has_levels() {
            self.include_flight();
            if self.lone_knot() {
                return Ok(());
            }
        }
        let (mut parted, mut switched) = (Parted::default(), 0.0);
        let moved = stood.as_ref().map(|stood| self.jump(stood));
        if self.assembly.system.has_levels() {
            switched = self.assembly.system.switched(&self.hybrid.mode.stops, &self.hybrid.z);
            self.hybrid.energy.switch(switched);
        }
        if let (Some(stood), Some(moved)) = (stood, moved) {
            parted = moved;
            self.take_rows_of_state(&parted);
            self.check_jump(&stood)?;
            let lost = self.slide(&stood);
            let work = self.work_of_jump(&stood) - switched + lost;
            self.hybrid.energy.impact(0.0, work);
        }
        self.settle(&[], &parted, observer)
    }

    /// Moves sliders after a jump until no force exceeds its level; returns their energy loss, J.
    fn slide(&mut self, before: &BeforeJump) -> f64 {
        let pressed = self.slide_contacts(before);
        let ways = self.clamp();
        let Self { assembly, hybrid, .. } = self;
        let mut all: f64 = pressed.iter().map(|own| own.1).sum();
        for (i, lost) in pressed {
            hybrid.energy.slide(i, lost);
        }
        for (i, (branch, way)) in assembly.system.branches.iter().zip(ways).enumerate() {
            if let (BranchLaw::Slider(slip), true) = (branch.law, way != 0.0) {
                hybrid.energy.slide(i, slip * way.abs());
                all += slip * way.abs();
            }
        }
        all
    }

    /// Moves the sliders of contacts in a jump, as if both elongations of each contact moved
    /// steadily from their values before the jump (docs/assembly-law.md (A67)). Returns each
    /// contact's slider with its energy loss, J.
    fn slide_contacts(&mut self, before: &BeforeJump) -> Vec<(usize, f64)> {
        let Self { assembly, hybrid, .. } = self;
        let (system, z) = (&assembly.system, &mut hybrid.z);
        let (mut all, mut ways) = (Vec::new(), vec![0.0; system.branches.len()]);
        for (i, branch) in system.branches.iter().enumerate() {
            let BranchLaw::Contact { stop, friction } = branch.law else { continue };
            // The check refuses jumps of contacts with friction on residual flexibility.
            if system.is_residual(Part::Branch(i)) {
                continue;
            }
            let rows = &system.stops[stop];
            let jump = branch.elongation.e.at(z.as_slice()) - before.branches[i];
            let jump = if jump.abs() > hybrid.sizes.zero_of(&branch.elongation.e) { jump } else { 0.0 };
            let [was, is] = [before.excess[stop], rows.excess.at(z.as_slice())];
            let factor = friction * rows.stiffness() / branch.stiffness;
            let limits = [was, is].map(|x| factor * x);
            let Carried { stretch, direction, lost } = carried(z[branch.place] - jump, jump, limits);
            let level = direction * branch.most(z.as_slice()).unwrap_or_default();
            let stretch = if direction == 0.0 { stretch } else { level };
            ways[i] = z[branch.place] - stretch;
            z[branch.place] = stretch;
            all.push((i, branch.stiffness * lost));
        }
        self.forget_moved(&ways);
        all
    }

    fn velocities(&self) -> DVector<f64> {
        let n = self.assembly.system.coordinates;
        self.hybrid.z.rows(n, n).into_owned()
    }

    /// Derives the flags from the state and the event functions `ended`, which have passed zero.
    fn flags(&self, ended: &[Watch], parted: &Parted) -> Flags {
        let (system, hybrid) = (&self.assembly.system, &self.hybrid);
        let mut flags = Flags {
            stops: vec![false; system.stops.len()],
            resting: vec![false; system.frictions.len()],
            edges: vec![false; system.stops.len()],
            limits: vec![false; system.stops.len()],
            sliders: vec![SliderFlag::default(); system.branches.len()],
        };
        for (flag, state) in flags.sliders.iter_mut().zip(&hybrid.mode.sliders).filter(|_| !parted.sliders) {
            flag.level = state.direction();
        }
        for (i, stop) in system.stops.iter().enumerate() {
            if stop.restitution().is_some() {
                // A freewheel's rate decides on its own, unless it counts as zero.
                let near = !stop.is_freewheel
                    && stop.excess.at(hybrid.z.as_slice()) >= -hybrid.sizes.zero_of(&stop.excess);
                let is_closed = hybrid.mode.stops.get(i) == Some(&StopState::Closed);
                flags.stops[i] = near || (is_closed && !parted.stops.contains(&i));
            }
        }
        for (i, state) in hybrid.mode.frictions.iter().enumerate() {
            flags.resting[i] = state.sticks() && !parted.frictions.contains(&i);
        }
        for &watch in ended {
            match watch {
                Watch::Meets(i) => flags.stops[i] = true,
                Watch::Stops(i) => flags.resting[i] = true,
                Watch::Presses(i) | Watch::Leaves(i) => flags.edges[i] = true,
                Watch::Turns(i) => flags.limits[i] = true,
                Watch::Changes(i) => {
                    let (stop, z) = (&system.stops[i], &hybrid.z);
                    // A stop reaches a cap only on the way in, even close to the edge. A stop that
                    // counted as being at its edge would be entered again.
                    let cap = hybrid.mode.stops[i] == StopState::Capped
                        || (stop.is_elastogap() && stop.force.dot(z) > stop.spring.dot(z));
                    // A pressed stop whose e still grows is past its edge. If it counted as being
                    // at its edge, it would be entered again.
                    let rate = &stop.elongation.rate;
                    let enters = hybrid.mode.stops[i] == StopState::Pressed
                        && rate.at(z.as_slice()) > hybrid.sizes.zero_of(rate);
                    let is_near = stop.excess.dot(z).abs() <= hybrid.sizes.zero(&stop.excess);
                    let edge = is_near && !cap && !enters;
                    if edge { flags.edges[i] = true } else { flags.limits[i] = true }
                }
                Watch::Yields(i, up) => flags.sliders[i].level = if up { 1.0 } else { -1.0 },
                Watch::Reverses(i) => flags.sliders[i].turns = true,
                Watch::Opens(_) | Watch::Slips(..) | Watch::Level(_) => {}
            }
        }
        flags
    }

    /// Projects touching stops onto their gap. Other stops that this brings to their gap touch as
    /// well, and take part in the impacts.
    pub(super) fn place_on_contacts(&mut self, flags: &mut Flags, parted: &Parted) {
        loop {
            let contacts: Vec<Contact> = (0..self.assembly.system.first_freewheel)
                .filter(|&i| flags.stops[i])
                .map(Contact::Stop)
                .collect();
            let system = &self.assembly.system;
            let independent = system.independent(&contacts);
            let r = system.triangle(&independent);
            project(system, &independent, &r, false, self.hybrid.z.as_mut_slice(), &mut self.scratch.off);
            system.fill_curved(self.hybrid.z.as_mut_slice());
            let stops = self.flags(&[], parted).stops;
            let touching = flags.stops.iter_mut().zip(stops).filter(|(touches, now)| *now && !**touches);
            if touching.map(|(touches, _)| *touches = true).count() == 0 {
                return;
            }
        }
    }

    /// Returns the freewheels that were engaged or have reached e' = 0, but not by a jump.
    fn engaged(&self, flags: &Flags) -> Vec<usize> {
        self.assembly.system.freewheels().filter(|&i| flags.stops[i]).collect()
    }

    pub(super) fn jammed(&self, jam: &Jam) -> Error {
        let names = jam.contacts.iter().map(|&i| self.assembly.name_of_stop(i));
        Error::Jammed { time: self.time(), stops: names.collect::<Vec<_>>().join(", ") }
    }

    /// Applies impacts of the touching stops; stops whose bounces would be too low close at once.
    /// Returns the impacts, and the closing stops with the time until their bounces would have
    /// accumulated.
    fn collide(&mut self, touching: &[usize], flags: &Flags) -> Result<(Impacts, Vec<(usize, f64)>), Error> {
        let assembly = self.assembly.clone();
        let system = &assembly.system;
        let mut restitution: Vec<f64> = system.stops.iter().map(|s| s.restitution().unwrap_or(0.0)).collect();
        let before = self.hybrid.z.clone();
        let engaged = self.engaged(flags);
        let mut closing: Vec<(usize, f64)> = Vec::new();
        loop {
            let mut z = before.clone();
            let instant = Instant {
                system,
                sizes: &self.hybrid.sizes,
                touching,
                restitution: &restitution,
                engaged: &engaged,
            };
            let mut stay_closed = |z: &DVector<f64>, stops: &[usize], closing: &[usize], before_it: usize| {
                // Stops that forces keep closed stay closed; in the first impact, so do all stops
                // that were not open before.
                let was_open = |i: usize| self.hybrid.mode.stops.get(i) == Some(&StopState::Open);
                if before_it == 0 && !stops.iter().any(|&i| was_open(i)) {
                    return Ok(vec![true; stops.len()]);
                }
                let kick = (z - &before).rows(system.coordinates, system.coordinates).into_owned();
                let after = flags.after(&kick, system, &self.hybrid.sizes);
                let mode = Selection::select(system, z, &self.hybrid.sizes, &after.verdict(closing))?;
                let stays = |i: usize| mode.stops[i] == StopState::Closed || (before_it == 0 && !was_open(i));
                Ok(stops.iter().map(|&i| stays(i)).collect())
            };
            let collided = instant.collide(&mut z, &mut stay_closed);
            let mut impacts = collided.map_err(|jam| self.jammed(&jam))?;
            system.fill_curved(z.as_mut_slice());
            self.hybrid.z = z;
            self.include_state();
            self.hybrid.sizes.include_from(system.coordinates, &impacts.shares);
            if impacts.sequence.is_empty() {
                return Ok((impacts, closing));
            }
            let kick = self.velocities() - before.rows(system.coordinates, system.coordinates);
            let after = flags.after(&kick, system, &self.hybrid.sizes);
            let found = self.low_bounces(&impacts, &restitution, &after)?;
            if found.is_empty() {
                closing.extend(self.hold_low(touching, &after, &mut impacts)?);
                return Ok((impacts, closing));
            }
            for (stop, left) in found {
                restitution[stop] = 0.0;
                closing.push((stop, left));
            }
        }
    }

    /// Returns the stops whose bounces would be too low, by (A19), with the time until the bounces
    /// would have accumulated.
    fn low_bounces(
        &mut self,
        impacts: &Impacts,
        restitution: &[f64],
        flags: &Flags,
    ) -> Result<Vec<(usize, f64)>, Error> {
        let hit = impacts.sequence.iter().flat_map(|impact| impact.stops.iter().map(|s| s.0));
        let candidates: Vec<usize> = hit.filter(|&i| restitution[i] > 0.0).collect();
        if candidates.is_empty() {
            return Ok(Vec::new());
        }
        let mode = self.select(flags)?;
        let system = &self.assembly.system;
        let place = self.tables.place_of(&mode, system);
        let table = &self.tables.at(place).table;
        let n = system.coordinates;
        let z = self.hybrid.z.as_slice();
        let acceleration = table.a.rows_times(n..2 * n, z);
        let mut found = Vec::new();
        for i in candidates {
            let stop = &system.stops[i];
            let rebound = -stop.elongation.rate.dot(&self.hybrid.z);
            // If a stop has several impacts at this instant, the fastest counts.
            let speed = impacts.fastest(i);
            let a = stop.elongation.w.dot(&acceleration) + stop.elongation.drift.dot(&self.hybrid.z);
            let scale = self.hybrid.sizes.of(&stop.excess);
            let least = self.least_bounce(restitution[i]) * scale;
            if a > 0.0 && rebound >= 0.0 && is_low(rebound.max(restitution[i] * speed), a, least) {
                let left =
                    if restitution[i] < 1.0 { 2.0 * rebound / (a * (1.0 - restitution[i])) } else { 0.0 };
                found.push((i, left));
            }
        }
        Ok(found)
    }

    /// Selects the mode that follows the present state.
    pub(super) fn select(&self, flags: &Flags) -> Result<Mode, Error> {
        let (system, hybrid) = (&self.assembly.system, &self.hybrid);
        if let Some(residual) = &system.residual {
            return self.select_configured(residual, flags);
        }
        Selection::select(system, &hybrid.z, &hybrid.sizes, &flags.verdict(&[]))
            .map_err(|jam| self.jammed(&jam))
    }

    /// Enters a mode, and finds the order with which each event function leaves zero.
    fn enter(&mut self, mode: Mode) {
        self.tables.make_room();
        self.hybrid.mode = mode;
        self.take_rows();
        self.place = self.tables.place_of(&self.hybrid.mode, &self.assembly.system);
        self.keep_contacts();
        self.note_standing();
        self.include_contacts();
        self.find_departures();
        if self.rest_at_edges() {
            self.find_departures();
        }
    }

    /// Finds the order of each event function's zero at the present state; [`ORDERS`] for an event
    /// function that is zero throughout the mode.
    fn find_departures(&mut self) {
        let Hybrid { departing, sizes, z, .. } = &mut self.hybrid;
        let (z, sizes) = (z.as_slice(), sizes.0.as_slice());
        let (table, rows) = (&self.tables.at(self.place).table, &mut self.scratch.rows);
        departing.clear();
        if table.is_curved() {
            let all = table.curved_departures(z, sizes, DOUBTFUL).into_iter();
            departing.extend(all.map(order_of));
            return;
        }
        let all = table.watched.iter().map(|w| table.departure(w, z, sizes, DOUBTFUL, rows));
        departing.extend(all.map(order_of));
    }

    /// Sets to zero the rates of compliant stops that cage a body: the body stays at the stops'
    /// edges throughout the mode, entering one stop means leaving another, and the rates count as
    /// zero. It would otherwise drift between them without end. Returns whether there was such a
    /// cage. A body that may drift into a single stop keeps its rate.
    fn rest_at_edges(&mut self) -> bool {
        let Hybrid { departing, z, mode, sizes, .. } = &mut self.hybrid;
        let (system, watched) = (&self.assembly.system, &self.tables.at(self.place).table.watched);
        let mut edges = Vec::new();
        let (mut inwards, mut outwards) = (false, false);
        for (w, &order) in watched.iter().zip(departing.iter()) {
            if let Watch::Presses(i) = w.watch
                && order == ORDERS
                && !system.is_limit(i)
            {
                let row = &system.stops[i].elongation.rate;
                let rate = row.at(z.as_slice());
                if rate.abs() <= sizes.zero_of(row) {
                    edges.push(Contact::Stop(i));
                    inwards |= rate > 0.0;
                    outwards |= rate < 0.0;
                }
            }
        }
        if !(inwards && outwards) {
            return false;
        }
        let all: Vec<Contact> = mode.basis.iter().copied().chain(edges).collect();
        let held = system.independent(&all);
        if held.len() == all.len() {
            return false;
        }
        let r = system.triangle(&held);
        project(system, &held, &r, true, z.as_mut_slice(), &mut self.scratch.off);
        system.fill_curved(z.as_mut_slice());
        true
    }
}

#[cfg(test)]
mod tests;
