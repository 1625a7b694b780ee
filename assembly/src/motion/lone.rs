//! The impact of one stop while nothing else is at its limit: by far the commonest event, with a closed formula. It changes no
//! mode; wherever that is not certain the general law decides.

use super::event::EventKind;
use super::{Motion, Observer, contact};
use crate::law::ZERO;
use crate::mode::{StopState, Watch};
use crate::system::Elongation;

impl Motion {
    /// The impact of the stop `i` at its gap, if it is a lone one; tells whether it was.
    ///
    /// It is one where its impulse (A7) moves no closed stop and no sticking friction, and where after it every watched
    /// functional but its own is below what counts as zero. Then no other open stop touches, the closed ones close with no speed, and by
    /// (A11) the mode in force follows: all its conditions hold with a margin, and the mode that follows is unique.
    pub(super) fn lone_impact(&mut self, i: usize, observer: &mut Observer) -> bool {
        let assembly = self.assembly.clone();
        let system = &assembly.system;
        let stop = &system.stops[i];
        let Some(restitution) = stop.restitution().filter(|&e| e > 0.0) else { return false };
        let least = self.least_bounce(restitution);
        let hybrid = &mut self.hybrid;
        let n = system.coordinates;
        let mobility = &stop.elongation.mobility;
        let couples = |e: &Elongation| e.w.dot(mobility) != 0.0;
        let stops = hybrid.mode.stops.iter().zip(&system.stops);
        let frictions = hybrid.mode.frictions.iter().zip(&system.frictions);
        let held = stops.filter(|(s, _)| **s == StopState::Closed).any(|(_, s)| couples(&s.elongation))
            || frictions.filter(|(s, _)| s.sticks()).any(|(_, f)| couples(&f.elongation));
        let (e, w) = (&stop.elongation, &stop.elongation.w);
        let compliance = w.dot(&e.mobility);
        let speed = e.rate_terms.dot(hybrid.z.as_slice());
        if held || compliance <= 0.0 || speed <= hybrid.sizes.zero_of(&e.rate_terms) {
            return false;
        }
        // On its gap, then away from it.
        let before = &mut self.scratch.start;
        before.copy_from_slice(hybrid.z.as_slice());
        let off = stop.excess_terms.dot(before) / compliance;
        let impulse = (1.0 + restitution) * speed / compliance;
        let z = hybrid.z.as_mut_slice();
        for (k, m) in e.mobility.iter().enumerate() {
            z[k] -= off * m;
            z[n + k] -= impulse * m;
        }
        let sizes = hybrid.sizes.0.as_mut_slice();
        z.iter().zip(sizes.iter_mut()).for_each(|(x, size)| *size = size.max(x.abs()));
        let others = self.table.watched.iter().filter(|w| w.watch != Watch::Meets(i));
        let mut inside = others.map(|w| w.terms.dot(z) < -ZERO * w.terms.size(sizes));
        let pressed = hybrid.mode.stops.iter().zip(&system.stops).all(|(state, stop)| match state {
            StopState::Pressed | StopState::Free | StopState::Capped => {
                stop.excess_terms.dot(z) > ZERO * stop.excess_terms.size(sizes)
            }
            StopState::Open | StopState::Closed | StopState::Below => true,
        });
        let rebound = -e.rate_terms.dot(z);
        let alone = pressed
            && inside.all(|x| x)
            && rebound > ZERO * e.rate_terms.size(sizes)
            && !self.table.watched.iter().any(|own| {
                // A bounce too low to be followed, by (A15).
                own.watch == Watch::Meets(i) && {
                    let a = own.bow.dot(z);
                    a > 0.0 && contact::is_low(rebound, a, least * own.terms.size(sizes))
                }
            });
        if !alone {
            z.copy_from_slice(before);
            return false;
        }
        let prescribed = speed - w.iter().zip(&before[n..]).map(|(w, v)| w * v).sum::<f64>();
        hybrid.energy.impact(0.5 * (1.0 - restitution) * speed * impulse, impulse * prescribed);
        let record = &mut hybrid.impacts[i];
        *record = (record.0 + 1, impulse);
        let own = self.table.watched.iter().map(|w| usize::from(w.watch == Watch::Meets(i)));
        hybrid.departing.clear();
        hybrid.departing.extend(own);
        contact::report(observer, self.time(), EventKind::Impact { stop: i, speed, impulse, stops: 1 });
        true
    }
}
