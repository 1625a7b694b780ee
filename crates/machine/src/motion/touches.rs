//! Touches: event functions that reach their limit and turn round without passing it. Touches are
//! not events (docs/assembly-law.md, section 6). But afterwards a motion has no derivative with
//! respect to a parameter that moves the touch (section 14).

use super::Motion;
use super::passage::{PassageSearch, StepPoint, shortened};
use crate::flow::Ahead;
use crate::mode::{StopState, Watch};
use vibro_numerics::events::turns;

/// A turning point is a touch within this multiple of the zero tolerance.
const BESIDE: f64 = 4.0;
/// The search continues beyond an interval's end by this fraction of the interval, so that no
/// turning point is missed between two intervals.
const BEYOND: f64 = 1.0 / 64.0;

/// A series that stays below zero by more than this fraction of its first value is not examined
/// for touches: a quick test before the zero tolerance is computed.
const BELOW: f64 = 1e-9;

/// A touch: its time, s, and the event function's index in its mode.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touch {
    pub(crate) time: f64,
    pub(crate) place: usize,
}

/// The touches since they were last taken.
#[derive(Clone, Debug, Default)]
pub(super) struct Touches {
    found: Vec<Touch>,
    /// State at the start of an interval.
    state: Vec<f64>,
}

impl Motion {
    /// Makes the motion record its later touches.
    #[must_use]
    pub(crate) fn noting_touches(mut self) -> Self {
        self.scratch.touches = Some(Touches::default());
        self
    }

    /// Returns the touches since the last call, ordered by time, each once.
    pub(crate) fn take_touches(&mut self) -> Vec<Touch> {
        let Some(touches) = self.scratch.touches.as_mut().filter(|own| !own.found.is_empty()) else {
            return Vec::new();
        };
        let mut found = std::mem::take(&mut touches.found);
        found.sort_by(|a, b| a.time.total_cmp(&b.time));
        found
    }

    /// Returns for each event function of the mode whether it is zero throughout the mode.
    pub(crate) fn are_unwatched(&self) -> impl Iterator<Item = bool> {
        self.hybrid.departing.iter().map(|&order| order == crate::flow::ORDERS)
    }
}

impl PassageSearch<'_> {
    /// Records the touches of a sub-step by tables, in the intervals `near`, which may contain a
    /// passage of a limit. `goes_on` is true if the mode holds beyond `end`.
    #[inline(never)]
    pub(super) fn note_touches(&self, near: &[u8], (end, goes_on): (StepPoint, bool), to: &mut Touches) {
        let (table, step) = (self.table, self.table.interval());
        let any = near.iter().fold(0, |all, own| all | own);
        for interval in (0..=end.interval).filter(|i| any & (1 << i) != 0) {
            to.state.resize(self.hybrid.z.len(), 0.0);
            table.at_interval_start(interval, self.hybrid.z.as_slice(), &mut to.state);
            let is_last = interval == end.interval;
            let length = if is_last { end.dt / step } else { 1.0 };
            let length = if is_last && !goes_on { length } else { length + BEYOND };
            let is_near = |&place: &usize| near[place] & (1 << interval) != 0 && self.may_touch(place);
            for place in (0..near.len()).filter(is_near) {
                let from = self.hybrid.time.value() + interval as f64 * step;
                let c = shortened(&table.local(place, &to.state), length);
                self.note(place, &c, |u| from + u * length * step, &mut to.found);
            }
        }
    }

    /// Records the touches of a part of a sub-step by its series.
    #[inline(never)]
    pub(super) fn note_touches_ahead(&self, (part, goes_on): (f64, bool), ahead: &Ahead, to: &mut Touches) {
        let length = if goes_on { part * (1.0 + BEYOND) } else { part };
        for (place, w) in self.table.watched.iter().enumerate() {
            let head = ahead.head(place);
            let most = head.value.max(head.value + head.slope) + head.behind;
            if most >= -BELOW * head.value.abs()
                && self.may_touch(place)
                && most >= -BESIDE * self.hybrid.sizes.zero_of(&w.row)
            {
                let c = shortened(&ahead.way(&w.row), length);
                let from = self.hybrid.time.value();
                self.note(place, &c, |u| from + u * length * ahead.span, &mut to.found);
            }
        }
    }

    /// Whether a touch of an event function could matter.
    fn may_touch(&self, place: usize) -> bool {
        let watch = self.table.watched[place].watch;
        let is_met = match watch {
            Watch::Meets(_) | Watch::Presses(_) | Watch::Stops(_) | Watch::Slips(..) => true,
            Watch::Leaves(i) => self.hybrid.mode.stops[i] == StopState::Pressed,
            _ => false,
        };
        is_met && !self.is_unwatched(place)
    }

    /// Records the points at which an event function's series, after being below, has a maximum
    /// that counts as zero.
    fn note<const N: usize>(
        &self,
        place: usize,
        c: &[f64; N],
        time: impl Fn(f64) -> f64,
        to: &mut Vec<Touch>,
    ) {
        let row = &self.table.watched[place].row;
        let mut rate = [0.0; N];
        (1..N).for_each(|k| rate[k - 1] = k as f64 * c[k]);
        if rate[0].abs() > rate[1..].iter().map(|x| x.abs()).sum() {
            return; // It does not turn.
        }
        let zero = BESIDE * self.hybrid.sizes.zero_of(row);
        let (mut lowest, mut rising) = (c[0], rate[0] > 0.0);
        turns(&rate, (0.0, 1.0), &mut rising, |u, is_highest| {
            let value = c.iter().rev().fold(0.0, |sum, c| sum * u + c);
            if is_highest && lowest < -zero && value.abs() <= zero {
                to.push(Touch { time: time(u), place });
            }
            lowest = lowest.min(value);
        });
    }
}
