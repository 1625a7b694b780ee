//! The way to the first event within a sub-step: samples and bounds prove that there is none, or
//! name the intervals to search.

use super::contact::DOUBTFUL;
use super::{Hybrid, Scratch};
use crate::flow::{Ahead, FlowTable, Group, Head, INTERVALS, LOCAL, ORDERS, Series, head_of};
use crate::mode::Watch;
use vibro_impact::events::{crossing_after_start, first_crossing};

/// A sub-step is halved while a stop's e may move by more than this many times its largest size so
/// far: beyond, the roots would lose more than a digit. By how much it may move is a bound, mostly
/// some times too large. It is not halved more often than [`HALVINGS`], since what begins at zero
/// has no size yet.
const REACH: f64 = 9.0;
/// Halvings of a sub-step for its reach.
const HALVINGS: i32 = 6;
/// What passes in this part of a sub-step before a knot, and is no further beyond there than what
/// counts as zero, passes at the knot.
const AT_KNOT: f64 = 1e-7;
/// A functional that was zero throughout is watched again beyond this many times the size under
/// which it counts as zero.
pub(super) const LEAVES_ZERO: f64 = 16.0;
/// It is followed up to a little more, so that it is beyond that where it has come there.
const PASSES: f64 = LEAVES_ZERO + 1.0;
/// From this order on a functional that leaves zero is at the first interval's end under 0.375⁶/6!
/// < 4e-6 of its size.
const HIGH_ORDER: usize = 6;

/// Where a sub-step ends, or is searched: a part of an interval.
#[derive(Clone, Copy)]
pub(super) struct StepPoint {
    /// The interval.
    pub(super) interval: usize,
    /// Time from its start, s.
    pub(super) dt: f64,
}

impl StepPoint {
    /// The end of a span of a sub-step.
    pub(super) fn end(span: f64, table: &FlowTable) -> Self {
        let step = table.interval();
        if span == table.length {
            return Self { interval: INTERVALS - 1, dt: step };
        }
        let interval = table.interval_of(span);
        Self { interval, dt: span - interval as f64 * step }
    }

    /// Time from the sub-step's start, s.
    pub(super) fn time(&self, table: &FlowTable) -> f64 {
        self.interval as f64 * table.interval() + self.dt
    }
}

/// The first passage of a watched functional in a sub-step.
pub(super) struct Passage {
    pub(super) at: StepPoint,
    /// The functional's place.
    pub(super) place: usize,
}

/// Whether a functional leaves zero so late that it is searched in one piece.
fn is_high_order(order: usize) -> bool {
    (HIGH_ORDER..ORDERS).contains(&order)
}

/// A sub-step's start in a mode.
pub(super) struct PassageSearch<'a> {
    pub(super) table: &'a FlowTable,
    pub(super) hybrid: &'a Hybrid,
}

impl PassageSearch<'_> {
    /// Whether a functional is zero throughout the mode.
    #[inline(always)]
    pub(super) fn is_unwatched(&self, place: usize) -> bool {
        self.hybrid.departing[place] == ORDERS
    }

    /// The order of the zero from which a functional goes: none where it is zero throughout the
    /// mode.
    #[inline(always)]
    pub(super) fn order(&self, place: usize) -> usize {
        self.hybrid.departing[place] % ORDERS
    }

    /// What a functional passes: zero or, where it is zero throughout the mode, that beyond which
    /// it is so no longer. What an event has left beyond that, as the rounding of a law that says
    /// otherwise, passes what is no rounding.
    #[inline(always)]
    pub(super) fn limit(&self, place: usize) -> f64 {
        if !self.is_unwatched(place) {
            return 0.0;
        }
        let row = &self.table.watched[place].row;
        let zero = self.hybrid.sizes.zero_of(row);
        let is_left = row.at(self.hybrid.z.as_slice()) > LEAVES_ZERO * zero;
        (zero * if is_left { DOUBTFUL + 1.0 } else { PASSES }).max(f64::MIN_POSITIVE)
    }

    /// The same within a short sub-step. There no place or speed that is zero throughout passes
    /// anything: what a flight makes of it is looked at where the sub-step ends, with the flight
    /// taken into the sizes. Before that, what begins at nothing, of which any multiple is nothing,
    /// would leave zero again and again.
    #[inline(always)]
    fn short_limit(&self, place: usize) -> f64 {
        match self.table.watched[place].watch {
            Watch::Meets(_) | Watch::Presses(_) | Watch::Leaves(_) | Watch::Stops(_)
                if self.is_unwatched(place) =>
            {
                f64::INFINITY
            }
            _ => self.limit(place),
        }
    }

    /// The longest span of `span`, `span`/2, … in which the watched stops' e stay within reach.
    #[inline(always)]
    pub(super) fn within_reach(&self, mut span: f64, heads: &[Group]) -> f64 {
        let least = span * 0.5f64.powi(HALVINGS);
        for (place, w) in self.table.watched.iter().enumerate() {
            if !matches!(w.watch, Watch::Meets(_) | Watch::Presses(_)) {
                continue;
            }
            let head = head_of(heads, place);
            let path = |span: f64| span * (head.slope.abs() + 0.5 * head.bend * span);
            if path(span) <= REACH * head.value.abs() {
                continue; // its size is at least its value's
            }
            let size = w.row.size(self.hybrid.sizes.0.as_slice());
            while path(span) > REACH * size && span > least {
                span *= 0.5;
            }
        }
        span
    }

    /// The first passage of a watched functional from below zero to above within a span, or the
    /// proof that there is none.
    #[inline(always)]
    pub(super) fn first_passage(&self, span: f64, scratch: &mut Scratch) -> Option<Passage> {
        let (table, z) = (self.table, self.hybrid.z.as_slice());
        let has_high_order = self.hybrid.departing.iter().copied().any(is_high_order);
        let high = if has_high_order { self.high_order_passage(span, scratch.ahead.memory()) } else { None };
        let Scratch { heads, near, start, interval: begun, ahead, .. } = scratch;
        let start = start.as_mut_slice();
        near.clear();
        let mut any = 0;
        for place in 0..self.hybrid.departing.len() {
            let (order, limit, mut head) =
                (self.order(place), self.short_limit(place), head_of(heads, place));
            head.value -= limit;
            let samples = || table.samples(place, z, ahead).map(|value| value - limit);
            let intervals = near_intervals(order, &head, table.interval(), samples);
            any |= intervals;
            near.push(intervals);
        }
        let end = StepPoint::end(span, table);
        for interval in (0..=end.interval).filter(|i| any & (1 << i) != 0) {
            table.at_interval_start(interval, z, ahead, start);
            table.begin_interval(start, ahead);
            *begun = Some(interval);
            let from = &start[..];
            let length = if interval == end.interval { end.dt } else { table.interval() };
            // A root early in the interval is found anew in a shorter one, of which the
            // coefficients' rounding is smaller.
            let (mut found, mut length, mut again) = (None, length, true);
            while again && let Some((dt, place)) = self.passage_within(near, from, ahead, (interval, length))
            {
                again = interval == 0 && found.is_none() && dt > 0.0 && dt < 0.25 * length;
                found = Some((dt, place));
                length = 2.0 * dt;
            }
            let Some((dt, place)) = found else { continue };
            let at = StepPoint { interval, dt };
            let first = Passage { at, place };
            return Some(high.filter(|high| high.at.time(table) < at.time(table)).unwrap_or(first));
        }
        high
    }

    /// Whether a passage is one at the knot at the end of its span, but for rounding: there nothing
    /// watched is beyond its limit by more than what counts as zero, or the clock shows the knot's
    /// time.
    #[inline(never)]
    pub(super) fn is_at_knot(
        &self,
        passage: &Passage,
        (span, knot): (f64, f64),
        scratch: &mut Scratch,
    ) -> bool {
        let Self { table, hybrid } = self;
        let time = passage.at.time(table);
        if hybrid.time.plus(time).value() >= knot {
            return true;
        }
        if span - time > AT_KNOT * table.length {
            return false;
        }
        let (end, Scratch { start, interval, ahead, .. }) = (StepPoint::end(span, table), scratch);
        let (start, mut there) = (start.as_mut_slice(), hybrid.z.as_slice().to_vec());
        table.at_interval_start(end.interval, &there, ahead, start);
        table.begin_interval(start, ahead);
        *interval = Some(end.interval);
        table.within(start, end.dt, true, ahead, &mut there);
        table.watched.iter().all(|w| w.row.at(&there) <= hybrid.sizes.zero_of(&w.row))
    }

    /// The first passage of a functional that leaves zero with a high order: at the ends of the
    /// first intervals it may still be rounding, so that it is searched in one piece, with the zero
    /// at its start divided out.
    #[inline(never)]
    fn high_order_passage(&self, span: f64, series: &mut Series) -> Option<Passage> {
        let table = self.table;
        let last = StepPoint::end(span, table).interval;
        let z = self.hybrid.z.as_slice();
        series.expand(table, z, span, table.orders_to(last));
        let mut first: Option<(f64, usize)> = None;
        for (place, (w, &order)) in table.watched.iter().zip(&self.hybrid.departing).enumerate() {
            if is_high_order(order) {
                let mut c = [0.0; ORDERS];
                let coefficients = series.terms().skip(order).map(|z| w.row.at(z));
                c.iter_mut().zip(coefficients).for_each(|(c, x)| *c = x);
                c[0] = c[0].min(-f64::MIN_POSITIVE);
                let hi = first.map_or(1.0, |(u, _)| u);
                first = first_crossing(&c, 0.0, hi, &mut 0).map(|u| (u, place)).or(first);
            }
        }
        first.map(|(u, place)| Passage { at: StepPoint::end(u * span, table), place })
    }

    /// The first passage within a time `length` from the start of an interval, with its time, among
    /// the functionals that may have one there.
    #[inline(always)]
    fn passage_within(
        &self,
        near: &[u8],
        from: &[f64],
        ahead: &Ahead,
        (interval, length): (usize, f64),
    ) -> Option<(f64, usize)> {
        let mut first: Option<(f64, usize)> = None;
        let ratio = length / self.table.interval();
        for (place, _) in near.iter().enumerate().filter(|(_, near)| **near & (1 << interval) != 0) {
            let order = if interval == 0 { self.order(place) } else { 0 };
            let mut c = self.table.local(place, from, ahead);
            c[0] -= self.short_limit(place);
            let begin = c[0];
            if ratio != 1.0 {
                let mut scale = 1.0;
                for ck in &mut c {
                    *ck *= scale;
                    scale *= ratio;
                }
            }
            if order > 0 {
                c.copy_within(order.., 0);
                c[LOCAL - order..].fill(0.0);
                c[0] = c[0].min(-f64::MIN_POSITIVE);
            } else {
                c[0] = c[0].min(0.0);
            }
            if c[0] + sum_behind(&c, f64::abs) < 0.0 {
                continue;
            }
            let hi = first.map_or(1.0, |(dt, _)| dt / length);
            if let Some(u) = crossing_after_start(&c, hi, &mut 0)
                && !(order == 0 && self.only_touches(place, begin, &c))
            {
                first = Some((u * length, place));
            }
        }
        first
    }

    /// Whether a functional, by its value at the begin and its coefficients over a span, goes no
    /// further beyond zero than what counts as zero: a stop that is just touched, without speed, is
    /// not hit, a level that is zero for an instant stays, and what is held up to its limit is
    /// held. Rounding in the place would make of it the root of this as a speed. A stop or a level
    /// that slowly passes zero has an event as soon as it is so far beyond; of what is known better
    /// than that, as a force is, it is one at once.
    #[inline(never)]
    fn only_touches(&self, place: usize, begin: f64, c: &[f64; LOCAL]) -> bool {
        let w = &self.table.watched[place];
        let zero = self.hybrid.sizes.zero_of(&w.row);
        let turns = match w.watch {
            Watch::Meets(_) | Watch::Level(_) => true,
            Watch::Opens(_) | Watch::Presses(_) | Watch::Slips(..) => turns_round(begin, c, zero),
            Watch::Changes(_) | Watch::Leaves(_) | Watch::Stops(_) => false,
        };
        let lower = begin - zero;
        // Where it is beyond at the end, as mostly, it has passed.
        turns && lower + sum_behind(c, |x| x) < 0.0 && {
            let mut c = *c;
            c[0] = lower;
            crossing_after_start(&c, 1.0, &mut 0).is_none()
        }
    }
}

/// Whether what is beyond zero at the end of a span is on its way back there, or comes to its
/// vertex before it is further beyond by `zero`.
fn turns_round(begin: f64, c: &[f64; LOCAL], zero: f64) -> bool {
    let (mut slope, mut bend) = (0.0, 0.0);
    for (k, x) in c.iter().enumerate().skip(1) {
        let k = k as f64;
        slope += k * x;
        bend += k * (k - 1.0) * x;
    }
    begin + sum_behind(c, |x| x) <= 0.0 || slope <= 0.0 || slope * slope <= -2.0 * bend * zero
}

/// The intervals of a sub-step in which a functional may pass zero, as bits: of the others it is
/// proved that it stays below zero. Between two samples a distance h apart it lies within M h²/8 of
/// their chord, where M bounds its second derivative. With `order` it leaves zero at the start.
#[inline(always)]
fn near_intervals(order: usize, head: &Head, step: f64, samples: impl FnOnce() -> [f64; INTERVALS]) -> u8 {
    if order >= HIGH_ORDER {
        return 0; // searched in one piece
    }
    let Head { value, slope, bend } = *head;
    let length = step * INTERVALS as f64;
    // What bounds it, value + slope t + bend t²/2, is convex: it is below zero throughout if it is
    // at both ends.
    let begins = if order == 0 { value < 0.0 } else { order == 1 };
    let start = if order == 0 { value } else { 0.0 };
    if begins && start + length * (slope + 0.5 * bend * length) < 0.0 {
        return 0;
    }
    let margin = bend * step * step * 0.125;
    // From zero it goes down throughout the first interval if the slope outweighs what the second
    // derivative adds.
    let leaves = order == 1 && slope + 0.5 * bend * step < 0.0;
    let mut ends = 0u64;
    for (k, sample) in samples().into_iter().enumerate() {
        let is_below = (sample + margin).to_bits() >> 63;
        ends |= (is_below ^ 1) << k;
    }
    // An interval is near where one of its ends is.
    let near = ends | ends << 1 | u64::from(order > 0 || value >= -margin);
    (if leaves { near & !1 } else { near }) as u8
}

/// The sum of what is made of the coefficients behind the first one, in four sums side by side.
#[inline(always)]
fn sum_behind(c: &[f64; LOCAL], part: impl Fn(f64) -> f64) -> f64 {
    let mut sums = [-part(c[0]), 0.0, 0.0, 0.0];
    for four in c.as_chunks::<4>().0 {
        sums.iter_mut().zip(four).for_each(|(sum, x)| *sum += part(*x));
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}
