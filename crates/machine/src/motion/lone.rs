//! Shortcut for events at which a single element comes to a limit, by far the commonest, and for
//! knots of signals, at which usually no element does.
//!
//! The next mode is guessed and then verified. It is certain if every event function is inside its
//! limit by more than rounding, since the next mode is unique (docs/assembly-law.md (A11)).
//! Otherwise nothing is changed and the general law decides. Modes agree with the general law; a
//! change must keep the comparisons with [`Motion::by_general_law`] green.

use super::event::EventKind;
use super::report::report;
use super::{Motion, Observer, contact};
use crate::law::ZERO;
use crate::mode::{Contact, ElementState, FrictionState, SliderState, StopState, Watch};
use crate::system::Elongation;

impl Motion {
    /// Applies the law after `watch` has passed zero if only its element is concerned; returns
    /// whether this is so.
    pub(super) fn lone_event(&mut self, watch: Watch, observer: &mut Observer) -> bool {
        if self.is_general || self.table().is_curved() || !self.hybrid.mode.is_independent() {
            return false;
        }
        match watch {
            Watch::Meets(i) => self.lone_impact(i, observer),
            _ => self
                .followers(watch)
                .into_iter()
                .flatten()
                .any(|next| self.lone_change(watch, next, observer)),
        }
    }

    /// Keeps the present mode at a knot of a signal if that is certain; returns whether it is.
    /// Only signals may have jumped. Closed rigid stops are left to the general law, which moves
    /// bodies back onto their gaps.
    pub(super) fn lone_knot(&mut self) -> bool {
        let mode = &self.hybrid.mode;
        if self.is_general
            || self.table().is_curved()
            || !mode.is_independent()
            || mode.stops.contains(&StopState::Closed)
        {
            return false;
        }
        self.scratch.start.copy_from(&self.hybrid.z);
        self.keep_contacts();
        self.include_contacts();
        if self.departs_alone(None, None) {
            self.note_standing();
            return true;
        }
        self.hybrid.z.copy_from(&self.scratch.start);
        false
    }

    /// Returns candidate states of the element after the passage of `watch`, the likelier first.
    fn followers(&self, watch: Watch) -> [Option<ElementState>; 2] {
        let (system, hybrid) = (&self.assembly.system, &self.hybrid);
        // If another sticking friction has a static level, the mode is not unique: (A12) decides
        // which friction leaves first.
        let others_are_static = |i: usize| {
            let frictions = hybrid.mode.frictions.iter().zip(&system.frictions).enumerate();
            frictions
                .into_iter()
                .any(|(j, (state, friction))| j != i && state.sticks() && friction.has_static)
        };
        let stop = |i: usize, state| [Some(ElementState::Stop(i, state)), None];
        if let Contact::Stop(i) = watch.contact()
            && system.stops[i].is_followed
        {
            // The friction that follows the stop may change its state as well.
            return [None, None];
        }
        match watch {
            Watch::Presses(i) => stop(i, system.stops[i].entered()),
            Watch::Leaves(i) => stop(i, StopState::Below),
            Watch::Opens(i) => stop(i, StopState::Open),
            Watch::Changes(i) => {
                let (rows, z) = (&system.stops[i], hybrid.z.as_slice());
                let capped = rows.is_elastogap() && rows.force.at(z) > rows.spring.at(z);
                let inside = rows.excess.at(z) > hybrid.sizes.zero_of(&rows.excess);
                stop(
                    i,
                    match hybrid.mode.stops[i] {
                        StopState::Pressed if capped => StopState::Capped,
                        StopState::Pressed if inside => StopState::Free,
                        StopState::Pressed => StopState::Below,
                        _ => StopState::Pressed,
                    },
                )
            }
            Watch::Turns(i) => stop(
                i,
                match hybrid.mode.stops[i] {
                    StopState::Pressed => StopState::Rebounding,
                    _ => StopState::Pressed,
                },
            ),
            Watch::Stops(i) if !others_are_static(i) => {
                let (friction, stuck) =
                    (&system.frictions[i], ElementState::Friction(i, FrictionState::Stuck));
                if friction.has_static {
                    return [Some(stuck), None];
                }
                let turned = match hybrid.mode.frictions[i] {
                    FrictionState::Up => FrictionState::Down,
                    _ => FrictionState::Up,
                };
                let turned = ElementState::Friction(i, turned);
                // The friction probably sticks if its force can fall from its level to the force
                // that keeps e' at zero, which is at most twice the level away.
                let Elongation { w, mobility, .. } = &friction.elongation;
                let level = friction.at(&hybrid.mode.stops).map_or(0.0, |own| own.level.dot(&hybrid.z));
                let room = 2.0 * level * w.dot(mobility);
                let own = self.table().watched.iter().find(|own| own.watch == watch);
                if own.is_some_and(|own| own.slope.dot(hybrid.z.as_slice()) > room) {
                    [Some(turned), Some(stuck)]
                } else {
                    [Some(stuck), Some(turned)]
                }
            }
            Watch::Slips(i, up) if !others_are_static(i) => {
                let state = if up { FrictionState::Up } else { FrictionState::Down };
                [Some(ElementState::Friction(i, state)), None]
            }
            Watch::Yields(i, up) => {
                let state = if up { SliderState::Up } else { SliderState::Down };
                [Some(ElementState::Slider(i, state)), None]
            }
            Watch::Reverses(i) => [Some(ElementState::Slider(i, SliderState::Held)), None],
            Watch::Meets(_) | Watch::Level(_) | Watch::Stops(_) | Watch::Slips(..) => [None, None],
        }
    }

    /// Puts the element in the state `next` if that is certain; otherwise changes nothing.
    fn lone_change(&mut self, watch: Watch, next: ElementState, observer: &mut Observer) -> bool {
        let system = &self.assembly.system;
        if self.is_at_corner(next, watch) {
            return false;
        }
        if self.tables.known_after(self.place, next).is_none() && self.tables.make_room() {
            self.place = self.tables.place_of(&self.hybrid.mode, system);
        }
        let place = self.tables.place_after(self.place, next, system);
        let mode = &self.tables.at(place).mode;
        if !mode.is_independent() {
            return false;
        }
        let (was, before) = (self.hybrid.mode.state_of(next), self.place);
        self.hybrid.mode.assign(mode);
        self.take_rows();
        self.place = place;
        self.scratch.start.copy_from(&self.hybrid.z);
        self.keep_contacts();
        self.include_contacts();
        // A stop just entered is at its edge, so it is exempt from the test of pressing stops.
        let entered = if let Watch::Presses(i) = watch { Some(i) } else { None };
        if self.departs_alone(Some(next), entered) {
            self.note_standing();
            self.report_change(was, 0.0, observer);
            return true;
        }
        self.place = before;
        self.hybrid.mode.assign(&self.tables.at(before).mode);
        self.take_rows();
        self.hybrid.z.copy_from(&self.scratch.start);
        false
    }

    /// Whether, at the passage of `watch`, another event function of its element is also at zero,
    /// or so near that the general law may take it for rounding. An example is a friction whose
    /// level vanishes. An `ElastoGap` has two event functions with the same `watch`. When a
    /// friction comes to rest, which may lead to two modes, event functions of other elements
    /// count as well. [`departs_alone`](Self::departs_alone) would refuse both cases.
    fn is_at_corner(&self, element: ElementState, watch: Watch) -> bool {
        let (z, sizes) = (self.hybrid.z.as_slice(), &self.hybrid.sizes);
        let (all, mut passed) = (matches!(watch, Watch::Stops(_)), false);
        self.table().watched.iter().any(|w| {
            let is_own = w.watch.is_of(element);
            let near = if is_own { contact::DOUBTFUL } else { 1.0 };
            (is_own || all)
                && w.row.dot(z) >= -near * sizes.zero_of(&w.row)
                && (w.watch != watch || std::mem::replace(&mut passed, true))
        })
    }

    /// Whether all conditions of the present mode hold with a margin (docs/assembly-law.md (A11));
    /// if so, stores the orders of departure. Event functions of `own` must be negative or leave
    /// zero downwards; all others must be negative by more than rounding. Pressing stops except
    /// `entered` must be beyond their gap by more than rounding.
    fn departs_alone(&mut self, own: Option<ElementState>, entered: Option<usize>) -> bool {
        let (hybrid, scratch, table) =
            (&mut self.hybrid, &mut self.scratch, &self.tables.at(self.place).table);
        let (z, sizes) = (hybrid.z.as_slice(), hybrid.sizes.0.as_slice());
        let stops = hybrid.mode.stops.iter().zip(&self.assembly.system.stops).enumerate();
        let mut pressing =
            stops.filter(|(i, (state, own))| state.is_inside() && Some(*i) != entered && !own.is_gapless());
        if pressing.any(|(_, (_, s))| s.excess.at(z) <= ZERO * s.excess.size(sizes)) {
            return false;
        }
        hybrid.departing.clear();
        for w in &table.watched {
            match table.departure(w, z, sizes, 1.0, &mut scratch.rows) {
                Some((0, value)) if value < 0.0 => hybrid.departing.push(0),
                Some((order, value)) if value < 0.0 && own.is_some_and(|own| w.watch.is_of(own)) => {
                    hybrid.departing.push(order);
                }
                _ => return false,
            }
        }
        true
    }

    /// Applies the impact of stop `i` at its gap if it is isolated; returns whether it is.
    ///
    /// The impulse (A7) of an isolated impact moves no closed stop and no sticking friction. After
    /// it every event function, except the stop's own, is negative by more than rounding. Then no
    /// other open stop touches and closed stops have no closing speed. The mode continues: its
    /// conditions hold with a margin, and by (A11) the next mode is unique.
    fn lone_impact(&mut self, i: usize, observer: &mut Observer) -> bool {
        let restitution = self.assembly.system.stops[i].restitution().filter(|&e| e > 0.0);
        let Some(restitution) = restitution else { return false };
        let least = self.least_bounce(restitution);
        let Self { assembly, hybrid, scratch, .. } = self;
        let system = &assembly.system;
        let (stop, n) = (&system.stops[i], system.coordinates);
        let e = &stop.elongation;
        let couples =
            |other: &Elongation| other.reach.iter().map(|&k| other.w[k] * e.mobility[k]).sum::<f64>() != 0.0;
        let held = hybrid.mode.basis.iter().any(|&contact| couples(system.elongation_of(contact)));
        let compliance = e.w.along(&e.mobility);
        let speed = e.rate.at(hybrid.z.as_slice());
        if held || compliance <= 0.0 || speed <= hybrid.sizes.zero_of(&e.rate) {
            return false;
        }
        // Projection onto e = gap, then the impulse.
        let before = scratch.start.as_mut_slice();
        before.copy_from_slice(hybrid.z.as_slice());
        let off = stop.excess.at(before) / compliance;
        let impulse = (1.0 + restitution) * speed / compliance;
        let z = hybrid.z.as_mut_slice();
        for &(k, m) in e.mobility.terms() {
            z[k] -= off * m;
            z[n + k] -= impulse * m;
        }
        hybrid.sizes.include(z);
        let prescribed = speed - e.w.at(&before[n..]);
        if self.is_low_bounce(i, least)
            || !self.departs_alone(Some(ElementState::Stop(i, StopState::Open)), None)
        {
            self.hybrid.z.copy_from(&self.scratch.start);
            return false;
        }
        let hybrid = &mut self.hybrid;
        let system = &self.assembly.system;
        let mobility = &system.stops[i].elongation.mobility;
        let carried = system.carried(&hybrid.z).map_or(0.0, |carried| carried.dot(mobility));
        let work = impulse * (prescribed - carried);
        hybrid.energy.impact(0.5 * (1.0 - restitution) * speed * impulse, work);
        hybrid.impacts[i].add(impulse);
        report(observer, self.time(), EventKind::Impact { stop: i, speed, impulse, stops: 1 });
        true
    }

    /// Whether the bounce that begins at open stop `i` is too low to be simulated, by (A19).
    fn is_low_bounce(&self, i: usize, least: f64) -> bool {
        let (stop, z) = (&self.assembly.system.stops[i], self.hybrid.z.as_slice());
        let rebound = -stop.elongation.rate.at(z);
        let scale = stop.excess.size(self.hybrid.sizes.0.as_slice());
        let table = self.table();
        let own = table.watched.iter().find(|own| own.watch == Watch::Meets(i));
        own.is_some_and(|own| {
            let a = table.bow(own, z);
            a > 0.0 && contact::is_low(rebound, a, least * scale)
        })
    }
}
