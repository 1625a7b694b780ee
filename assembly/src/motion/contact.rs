//! What happens at an event: impacts, the mode that follows, and what is reported.

use super::event::{Event, EventKind};
use super::{Hybrid, Motion, Observer};
use crate::error::Error;
use crate::flow::ORDERS;
use crate::law::box_qp::{Jam, triangle};
use crate::law::impact::{Impacts, Instant};
use crate::law::selection::{Selection, Touching};
use crate::law::{Sizes, ZERO};
use crate::mode::{Contact, FrictionState, Mode, StopState, Watch};
use crate::system::{Elongation, System};
use nalgebra::DVector;

/// A stop whose bounces would be lower than this part of its largest e so far is closed.
const LEAST_BOUNCE: f64 = 1e-12;

/// Where stops are met late, bounces under this many times the lateness are too low to matter.
const LATE_BOUNCES: f64 = 100.0;

/// A watched functional's coefficient that is positive where the law says negative is rounding up to this many times the size under
/// which it counts as zero; beyond, the modes would change without end, which is told.
const DOUBTFUL: f64 = 1e3;

/// What an event says of the elements that take part.
#[derive(Clone, Default)]
struct Flags {
    stops: Vec<bool>,
    resting: Vec<bool>,
    edges: Vec<bool>,
    limits: Vec<bool>,
}

impl Flags {
    /// What is left of it after impacts that changed the velocities by `kick`: friction whose rate they changed no longer rests,
    /// and the force of a compliant stop with a dashpot is no longer at a limit.
    fn after(&self, kick: &DVector<f64>, system: &System, sizes: &Sizes) -> Self {
        let mut flags = self.clone();
        let moved = |e: &Elongation| e.w.dot(kick).abs() > sizes.zero_of(&e.rate_terms);
        let frictions = flags.resting.iter_mut().zip(&system.frictions);
        frictions.for_each(|(rests, friction)| *rests &= !moved(&friction.elongation));
        let stops = flags.limits.iter_mut().zip(&system.stops);
        stops.for_each(|(limit, stop)| *limit &= !moved(&stop.elongation));
        flags
    }
}

/// Whether a bounce with a speed against an acceleration stays below the `least` height that is followed, by (A15).
pub(super) fn is_low(rebound: f64, acceleration: f64, least: f64) -> bool {
    rebound * rebound < 2.0 * acceleration * least
}

impl Motion {
    /// Impacts and the mode that follow the present state, where the functionals `ended` have passed zero.
    pub(super) fn settle(&mut self, ended: &[Watch], observer: &mut Observer) -> Result<(), Error> {
        if let [Watch::Meets(stop)] = *ended
            && self.lone_impact(stop, observer)
        {
            return Ok(());
        }
        let flags = self.flags(ended);
        self.place_on_contacts(&flags);
        let before = self.hybrid.mode.clone();
        let touching: Vec<usize> = (0..flags.stops.len()).filter(|&i| flags.stops[i]).collect();
        let velocities = self.velocities();
        let (impacts, closing) = self.collide(&touching, &flags)?;
        self.report_impacts(&impacts, observer);
        let kick = self.velocities() - velocities;
        let mode = self.select(&flags.after(&kick, &self.assembly.system, &self.hybrid.sizes))?;
        self.enter(mode);
        self.report_changes(&before, &closing, observer);
        Ok(())
    }

    /// A knot of a signal: prescribed bodies may have jumped.
    pub(super) fn knot(&mut self, observer: &mut Observer) -> Result<(), Error> {
        self.hybrid.sizes.include(&self.hybrid.z);
        self.check_jumps()?;
        report(observer, self.time(), EventKind::Knot);
        self.settle(&[], observer)
    }

    /// A jump of a prescribed body must not violate a rigid stop.
    fn check_jumps(&self) -> Result<(), Error> {
        let (system, z) = (&self.assembly.system, &self.hybrid.z);
        for (i, stop) in system.stops.iter().enumerate() {
            let excess = stop.excess.dot(z);
            let jumps = stop.excess.rows_range(system.signals.one + 1..).iter().any(|&x| x != 0.0);
            if jumps && stop.restitution().is_some() && excess > self.hybrid.sizes.zero(&stop.excess) {
                let stop = self.assembly.description.stops[i].name.clone();
                return Err(Error::Violated { stop, time: self.time(), excess });
            }
        }
        Ok(())
    }

    fn velocities(&self) -> DVector<f64> {
        let n = self.assembly.system.coordinates;
        self.hybrid.z.rows(n, n).into_owned()
    }

    fn flags(&self, ended: &[Watch]) -> Flags {
        let (system, hybrid) = (&self.assembly.system, &self.hybrid);
        let mut flags = Flags {
            stops: vec![false; system.stops.len()],
            resting: vec![false; system.frictions.len()],
            edges: vec![false; system.stops.len()],
            limits: vec![false; system.stops.len()],
        };
        for (i, stop) in system.stops.iter().enumerate() {
            if stop.restitution().is_some() {
                let near =
                    stop.excess_terms.dot(hybrid.z.as_slice()) >= -hybrid.sizes.zero_of(&stop.excess_terms);
                flags.stops[i] = near || hybrid.mode.stops.get(i) == Some(&StopState::Closed);
            }
        }
        for (i, state) in hybrid.mode.frictions.iter().enumerate() {
            flags.resting[i] = state.sticks();
        }
        for &watch in ended {
            match watch {
                Watch::Meets(i) => flags.stops[i] = true,
                Watch::Stops(i) => flags.resting[i] = true,
                Watch::Presses(i) | Watch::Leaves(i) => flags.edges[i] = true,
                Watch::Changes(i) => {
                    let stop = &system.stops[i];
                    let edge = stop.excess.dot(&hybrid.z).abs() <= hybrid.sizes.zero(&stop.excess);
                    if edge { flags.edges[i] = true } else { flags.limits[i] = true }
                }
                Watch::Opens(_) | Watch::Slips(..) | Watch::Level(_) => {}
            }
        }
        flags
    }

    /// The rows that are zero by the law: e - gap and e' of closed stops, e' of sticking friction, moved onto zero by the least
    /// change in the inertia's metric.
    pub(super) fn keep_contacts(&mut self) {
        let basis = self.hybrid.mode.basis.clone();
        if basis.is_empty() {
            return;
        }
        let stops: Vec<Contact> = basis.iter().copied().filter(|c| matches!(c, Contact::Stop(_))).collect();
        self.project(&stops, false);
        self.project(&basis, true);
    }

    /// Puts touching stops exactly on their gap.
    fn place_on_contacts(&mut self, flags: &Flags) {
        let contacts: Vec<Contact> =
            (0..flags.stops.len()).filter(|&i| flags.stops[i]).map(Contact::Stop).collect();
        let independent = self.assembly.system.independent(&contacts);
        self.project(&independent, false);
    }

    fn project(&mut self, contacts: &[Contact], rates: bool) {
        if contacts.is_empty() {
            return;
        }
        let system = &self.assembly.system;
        let (n, m) = (system.coordinates, contacts.len());
        let z = &self.hybrid.z;
        let mut off = DVector::from_fn(m, |k, _| match (contacts[k], rates) {
            (Contact::Stop(i), false) => system.stops[i].excess.dot(z),
            (contact, _) => system.elongation_of(contact).rate.dot(z),
        });
        let r = triangle(&system.columns(contacts));
        r.tr_solve_upper_triangular_mut(&mut off);
        r.solve_upper_triangular_mut(&mut off);
        let mut sum = DVector::zeros(n);
        for (k, &contact) in contacts.iter().enumerate() {
            sum.axpy(off[k], &system.elongation_of(contact).w, 1.0);
        }
        let change = system.inertia.solve(&sum);
        let first = if rates { n } else { 0 };
        let mut part = self.hybrid.z.rows_mut(first, n);
        part -= change;
    }

    fn jammed(&self, jam: &Jam) -> Error {
        let names = jam.contacts.iter().map(|&i| format!("stop.{}", self.assembly.description.stops[i].name));
        Error::Jammed { time: self.time(), stops: names.collect::<Vec<_>>().join(", ") }
    }

    /// Impacts of the touching stops; those whose bounces would be too low to matter end at once. Returns the impacts, and the
    /// stops that close with the time until their bounces would have accumulated.
    fn collide(&mut self, touching: &[usize], flags: &Flags) -> Result<(Impacts, Vec<(usize, f64)>), Error> {
        let assembly = self.assembly.clone();
        let system = &assembly.system;
        let mut restitution: Vec<f64> = system.stops.iter().map(|s| s.restitution().unwrap_or(0.0)).collect();
        let before = self.hybrid.z.clone();
        let mut closing: Vec<(usize, f64)> = Vec::new();
        loop {
            let mut z = before.clone();
            let instant = Instant { system, sizes: &self.hybrid.sizes, touching, restitution: &restitution };
            let impacts = instant.collide(&mut z).map_err(|jam| self.jammed(&jam))?;
            self.hybrid.z = z;
            self.hybrid.sizes.include(&self.hybrid.z);
            if impacts.sequence.is_empty() {
                return Ok((impacts, closing));
            }
            let kick = self.velocities() - before.rows(system.coordinates, system.coordinates);
            let after = flags.after(&kick, system, &self.hybrid.sizes);
            let found = self.plastic(&impacts, &restitution, &after)?;
            if found.is_empty() {
                return Ok((impacts, closing));
            }
            for (stop, left) in found {
                restitution[stop] = 0.0;
                closing.push((stop, left));
            }
        }
    }

    /// The stops of an impact whose bounces are too low to matter, with the time until they would have accumulated.
    fn plastic(
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
        let linear = self.table_of(&mode);
        let system = &self.assembly.system;
        let n = system.coordinates;
        let z = self.hybrid.z.as_slice();
        let acceleration = linear.a.rows_times(n..2 * n, z);
        let mut found = Vec::new();
        for i in candidates {
            let stop = &system.stops[i];
            let rebound = -stop.elongation.rate.dot(&self.hybrid.z);
            let a = stop.elongation.w.dot(&acceleration) + stop.elongation.drift.dot(&self.hybrid.z);
            let scale = self.hybrid.sizes.of(&stop.excess);
            let least = self.least_bounce(restitution[i]) * scale;
            if a > 0.0 && rebound >= 0.0 && is_low(rebound, a, least) {
                let left =
                    if restitution[i] < 1.0 { 2.0 * rebound / (a * (1.0 - restitution[i])) } else { 0.0 };
                found.push((i, left));
            }
        }
        Ok(found)
    }

    /// The part of a stop's largest e so far under which a bounce is too low to matter. Where stops are met late by a depth d, a ball
    /// falls on by it, and its bounces do not get lower than d e²/(1 - e²).
    pub(super) fn least_bounce(&self, restitution: f64) -> f64 {
        let lost = 1.0 - restitution * restitution;
        if self.late == 0.0 || lost == 0.0 {
            return LEAST_BOUNCE;
        }
        self.late * (LATE_BOUNCES + 2.0 * restitution * restitution / lost)
    }

    fn select(&self, flags: &Flags) -> Result<Mode, Error> {
        let touching = Touching {
            stops: &flags.stops,
            resting: &flags.resting,
            edges: &flags.edges,
            limits: &flags.limits,
        };
        Selection::select(&self.assembly.system, &self.hybrid.z, &self.hybrid.sizes, &touching)
            .map_err(|jam| self.jammed(&jam))
    }

    /// Puts a mode in force, and finds the order with which each watched functional leaves zero.
    fn enter(&mut self, mode: Mode) {
        self.table = self.table_of(&mode);
        self.hybrid.mode = mode;
        self.keep_contacts();
        let Hybrid { departing, sizes, z, .. } = &mut self.hybrid;
        let (z, sizes) = (z.as_slice(), sizes.0.as_slice());
        // The law says that the first derivative is negative; what rounding has made positive counts as zero.
        let leaves = |value: f64, size: f64| value < -ZERO * size || value > DOUBTFUL * ZERO * size;
        departing.clear();
        departing.extend(self.table.watched.iter().map(|w| {
            if leaves(w.terms.dot(z), w.terms.size(sizes)) {
                return 0;
            }
            let slope = w.slope.dot(z);
            if slope < 0.0 && leaves(slope, w.slope_sizes.size(sizes)) {
                return 1;
            }
            match self.table.first_derivative(&w.row, 1, z, sizes, leaves) {
                None => ORDERS,
                // A positive one follows one of the last order but for rounding: the passage is at hand and must not be divided out.
                Some((order, value)) => order - usize::from(value > 0.0),
            }
        }));
    }

    fn report_impacts(&mut self, impacts: &Impacts, observer: &mut Observer) {
        let time = self.time();
        for impact in &impacts.sequence {
            self.hybrid.energy.impact(impact.lost, impact.work);
            for &(stop, speed, impulse) in &impact.stops {
                let record = &mut self.hybrid.impacts[stop];
                *record = (record.0 + 1, impulse);
                report(observer, time, EventKind::Impact { stop, speed, impulse, stops: impact.stops.len() });
            }
        }
        self.hybrid.energy.impact(impacts.projected_loss, 0.0);
    }

    fn report_changes(&self, before: &Mode, closing: &[(usize, f64)], observer: &mut Observer) {
        let time = self.time();
        for (i, &now) in self.hybrid.mode.stops.iter().enumerate() {
            let Some(&was) = before.stops.get(i) else { continue };
            let kind = match (was, now) {
                (a, b) if a == b => continue,
                (_, StopState::Closed) => {
                    let left = closing.iter().find(|c| c.0 == i).map_or(0.0, |c| c.1);
                    report(observer, time + left, EventKind::Close { stop: i });
                    continue;
                }
                (StopState::Closed, StopState::Open) => EventKind::Open { stop: i },
                (StopState::Below, _) => EventKind::Press { stop: i, speed: self.stop(i)[1] },
                (_, StopState::Below | StopState::Free) => EventKind::Free { stop: i },
                (StopState::Free, _) => EventKind::Press { stop: i, speed: self.stop(i)[1] },
                _ => continue,
            };
            report(observer, time, kind);
        }
        for (i, &now) in self.hybrid.mode.frictions.iter().enumerate() {
            let Some(&was) = before.frictions.get(i) else { continue };
            if was == now || (was.sticks() && now.sticks()) {
                continue;
            }
            let level = |acts| EventKind::Level { friction: i, acts };
            match (was, now) {
                (_, FrictionState::Off) => report(observer, time, level(false)),
                (FrictionState::Off, _) => report(observer, time, level(true)),
                _ => {}
            }
            match now {
                _ if now.sticks() => report(observer, time, EventKind::Stick { friction: i }),
                FrictionState::Up | FrictionState::Down if was != FrictionState::Off => {
                    let (direction, force) = (now.direction(), self.friction(i)[2]);
                    report(observer, time, EventKind::Slip { friction: i, direction, force });
                }
                _ => {}
            }
        }
    }
}

pub(super) fn report(observer: &mut Observer, time: f64, kind: EventKind) {
    if let Some(observer) = observer {
        observer(&Event { time, kind });
    }
}
