//! The first event in a sub-step: bounds of the watched functionals between samples prove that
//! there is none, or select the intervals to search for the first root.
//!
//! No event is missed: every interval that is skipped needs a bound that proves it (see
//! `near_intervals`). A change must keep that proof, and the bits of the golden motions.

use super::contact::DOUBTFUL;
use super::{Hybrid, Scratch};
use crate::flow::{Ahead, Group, Head, INTERVALS, LOCAL, ORDERS, Series, Table, head_of};
use crate::mode::Watch;
use vibro_impact::events::{crossing_after_start, first_crossing};

/// Reach of a sub-step: it is halved while the bound of a stop's change of e exceeds this many
/// times the size of e - gap, beyond which roots would lose more than a digit. The bound mostly
/// overestimates several times. At most [`HALVINGS`] times, since what begins at zero has no size
/// yet.
const REACH: f64 = 9.0;
/// Limit of halvings of a sub-step by [`REACH`].
const HALVINGS: i32 = 6;
/// Fraction of a sub-step before a knot within which a passage counts as one at the knot if no
/// functional exceeds zero there by more than rounding.
const AT_KNOT: f64 = 1e-7;
/// Multiple of the size under which a functional counts as zero beyond which one that was zero
/// throughout is watched again.
pub(super) const LEAVES_ZERO: f64 = 16.0;
/// Limit of a functional that is zero throughout, in the unit of [`LEAVES_ZERO`]: a little more, so
/// that at this limit it is beyond `LEAVES_ZERO` despite rounding.
const PASSES: f64 = LEAVES_ZERO + 1.0;
/// Order of departure from zero from which on the whole span is searched in one piece: at the first
/// interval's end such a functional is still under 0.375⁶/6! < 4e-6 of its size.
const LATE: usize = 6;

/// A time in a sub-step, by interval.
#[derive(Clone, Copy)]
pub(super) struct Point {
    /// The interval.
    pub(super) interval: usize,
    /// Time from its start, s.
    pub(super) dt: f64,
}

impl Point {
    /// The end of a span of a sub-step.
    pub(super) fn end(span: f64, table: &Table) -> Self {
        let step = table.interval();
        if span == table.length {
            return Self { interval: INTERVALS - 1, dt: step };
        }
        let interval = table.interval_of(span);
        Self { interval, dt: span - interval as f64 * step }
    }

    /// Time from the sub-step's start, s.
    pub(super) fn time(&self, table: &Table) -> f64 {
        self.interval as f64 * table.interval() + self.dt
    }
}

/// Passage of a watched functional through its limit in a sub-step.
pub(super) struct Passage {
    pub(super) at: Point,
    /// Index of the functional.
    pub(super) place: usize,
}

/// Whether a functional leaves zero with so high an order that it is searched in one piece.
fn is_late(order: usize) -> bool {
    (LATE..ORDERS).contains(&order)
}

/// Start of a sub-step: the mode's table and the state.
pub(super) struct Flight<'a> {
    pub(super) table: &'a Table,
    pub(super) hybrid: &'a Hybrid,
}

impl Flight<'_> {
    /// Whether a functional is zero throughout the mode.
    #[inline(always)]
    pub(super) fn is_unwatched(&self, place: usize) -> bool {
        self.hybrid.departing[place] == ORDERS
    }

    /// Order of the zero that a functional leaves; 0 where it is zero throughout the mode.
    #[inline(always)]
    pub(super) fn order(&self, place: usize) -> usize {
        self.hybrid.departing[place] % ORDERS
    }

    /// Limit of a functional: zero or, where it is zero throughout the mode, the value beyond which
    /// it counts as nonzero. Where rounding at an event has left it beyond that value already, the
    /// limit is the larger value beyond which it is no rounding ([`DOUBTFUL`]).
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

    /// Limit of a functional within a sub-step that is not long: [`limit`](Self::limit), but none
    /// for a coordinate or rate that is zero throughout. That is tested at the sub-step's end, with
    /// the flight included in the sizes; before, a quantity without a size of its own would leave
    /// zero again and again.
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

    /// The longest of `span`, `span`/2, … in which the e of all watched stops stays within
    /// [`REACH`].
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
                continue; // a size is at least the present value
            }
            let size = w.row.size(self.hybrid.sizes.0.as_slice());
            while path(span) > REACH * size && span > least {
                span *= 0.5;
            }
        }
        span
    }

    /// The first passage of a watched functional upwards through its limit within a span; `None` is
    /// proved.
    #[inline(always)]
    pub(super) fn first_passage(&self, span: f64, scratch: &mut Scratch) -> Option<Passage> {
        let (table, z) = (self.table, self.hybrid.z.as_slice());
        let has_late = self.hybrid.departing.iter().copied().any(is_late);
        let late = if has_late { self.late_passage(span, scratch.ahead.memory()) } else { None };
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
        let end = Point::end(span, table);
        for interval in (0..=end.interval).filter(|i| any & (1 << i) != 0) {
            table.at_interval_start(interval, z, ahead, start);
            table.begin_interval(start, ahead);
            *begun = Some(interval);
            let from = &start[..];
            let length = if interval == end.interval { end.dt } else { table.interval() };
            // A root early in the first interval is computed again in a shorter one, in which the
            // rounding of the coefficients is smaller.
            let (mut found, mut length, mut again) = (None, length, true);
            while again && let Some((dt, place)) = self.passage_within(near, from, ahead, (interval, length))
            {
                again = interval == 0 && found.is_none() && dt > 0.0 && dt < 0.25 * length;
                found = Some((dt, place));
                length = 2.0 * dt;
            }
            let Some((dt, place)) = found else { continue };
            let at = Point { interval, dt };
            let first = Passage { at, place };
            return Some(late.filter(|late| late.at.time(table) < at.time(table)).unwrap_or(first));
        }
        late
    }

    /// Whether a passage coincides with the knot at the end of its span up to rounding: its time
    /// rounds to the knot's, or no watched functional exceeds zero there by more than rounding.
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
        let (end, Scratch { start, interval, ahead, .. }) = (Point::end(span, table), scratch);
        let (start, mut there) = (start.as_mut_slice(), hybrid.z.as_slice().to_vec());
        table.at_interval_start(end.interval, &there, ahead, start);
        table.begin_interval(start, ahead);
        *interval = Some(end.interval);
        table.within(start, end.dt, true, ahead, &mut there);
        table.watched.iter().all(|w| w.row.at(&there) <= hybrid.sizes.zero_of(&w.row))
    }

    /// The first passage of a functional that leaves zero with a high order. At the ends of the
    /// first intervals it may still be rounding, so that the whole span is searched in one piece,
    /// with the zero at its start divided out.
    #[inline(never)]
    fn late_passage(&self, span: f64, series: &mut Series) -> Option<Passage> {
        let table = self.table;
        let last = Point::end(span, table).interval;
        let z = self.hybrid.z.as_slice();
        series.expand(table, z, span, table.orders_to(last));
        let mut first: Option<(f64, usize)> = None;
        for (place, (w, &order)) in table.watched.iter().zip(&self.hybrid.departing).enumerate() {
            if is_late(order) {
                let mut c = [0.0; ORDERS];
                let coefficients = series.terms().skip(order).map(|z| w.row.at(z));
                c.iter_mut().zip(coefficients).for_each(|(c, x)| *c = x);
                c[0] = c[0].min(-f64::MIN_POSITIVE);
                let hi = first.map_or(1.0, |(u, _)| u);
                first = first_crossing(&c, 0.0, hi, &mut 0).map(|u| (u, place)).or(first);
            }
        }
        first.map(|(u, place)| Passage { at: Point::end(u * span, table), place })
    }

    /// Time and index of the first passage within `length` from the start of an interval, among the
    /// functionals that `near` marks there.
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

    /// Whether a functional, with value `begin` at the start and coefficients `c` over the span,
    /// exceeds zero by no more than rounding: a stop that is touched without speed is not hit, a
    /// level that is zero for an instant does not change sign, and a contact held up to its limit
    /// holds. Taken as events, rounding of the coordinate would become a speed of its square root.
    /// A stop or a level that passes zero slowly has its event once it exceeds the rounding; a
    /// force, which is known better, at the root itself.
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
        // Mostly it exceeds the rounding at the end, which settles it without a search.
        turns && lower + sum_behind(c, |x| x) < 0.0 && {
            let mut c = *c;
            c[0] = lower;
            crossing_after_start(&c, 1.0, &mut 0).is_none()
        }
    }
}

/// Whether a functional that exceeds zero in a span returns: it is not positive at the end, falls
/// there, or by slope and second derivative there rises by no more than `zero` to its vertex.
fn turns_round(begin: f64, c: &[f64; LOCAL], zero: f64) -> bool {
    let (mut slope, mut bend) = (0.0, 0.0);
    for (k, x) in c.iter().enumerate().skip(1) {
        let k = k as f64;
        slope += k * x;
        bend += k * (k - 1.0) * x;
    }
    begin + sum_behind(c, |x| x) <= 0.0 || slope <= 0.0 || slope * slope <= -2.0 * bend * zero
}

/// Bits of the intervals in which a functional may pass zero; in the others it is proved to stay
/// negative. Between samples a distance h apart it lies within M h²/8 of their chord, where M
/// bounds its second derivative. With `order` > 0 it leaves zero at the start.
#[inline(always)]
fn near_intervals(order: usize, head: &Head, step: f64, samples: impl FnOnce() -> [f64; INTERVALS]) -> u8 {
    if order >= LATE {
        return 0; // searched in one piece
    }
    let Head { value, slope, bend } = *head;
    let length = step * INTERVALS as f64;
    // The bound value + slope t + bend t²/2 is convex: negative at both ends, it is negative
    // throughout.
    let begins = if order == 0 { value < 0.0 } else { order == 1 };
    let start = if order == 0 { value } else { 0.0 };
    if begins && start + length * (slope + 0.5 * bend * length) < 0.0 {
        return 0;
    }
    let margin = bend * step * step * 0.125;
    // From zero it falls throughout the first interval if the slope outweighs the second
    // derivative.
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

/// Sum of `part` of the coefficients except the first, in four partial sums for vector registers.
#[inline(always)]
fn sum_behind(c: &[f64; LOCAL], part: impl Fn(f64) -> f64) -> f64 {
    let mut sums = [-part(c[0]), 0.0, 0.0, 0.0];
    for four in c.as_chunks::<4>().0 {
        sums.iter_mut().zip(four).for_each(|(sum, x)| *sum += part(*x));
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}
