//! First zero passage of an event function within a sub-step (docs/assembly-law.md, section 2).
//!
//! A motion is exact only if no passage is missed. Each event function is therefore either proved
//! to stay below its limit, or searched. The proofs go from cheap to expensive:
//!
//! 1. Over the whole span: value + slope t + bend t²/2, with a bound of the second derivative.
//! 2. Over each of eight intervals: samples at both ends, and bend h²/8 between them.
//! 3. In the remaining intervals: the root of the local Taylor polynomial, the earliest first.
//!
//! The first step mostly ends the search. An event function that starts at zero with a high order
//! is only rounding at the ends of the first intervals. It is searched over the whole span, after
//! the zero at its start is divided out.
//!
//! A change must keep the following:
//!
//! - Bounds are proofs: a cheaper one has to hold for every state, rounding included.
//! - The zero tolerance is relative to [`Sizes`](crate::law::Sizes), never absolute. The limit of
//!   an event function that is zero throughout the mode is above its rounding, not zero.
//! - The order of summation, here and in [`flow`](crate::flow), decides the last bits of event
//!   times, and with them the golden files. Inlining is measured for speed and changes no bits.
//!
//! A new kind of [`Watch`] has to be added to `short_limit` (whether it may leave zero within a
//! sub-step), `within_reach` (whether it shortens the span) and `only_touches` (whether a touch is
//! an event). A change is tested by `tests/second_method.rs`, `tests/rounding.rs`,
//! `tests/random.rs` and unchanged golden files.

use super::contact::DOUBTFUL;
use super::{Hybrid, Scratch};
use crate::flow::{Ahead, FlowTable, Group, Head, INTERVALS, LOCAL, ORDERS, Series, TERMS, head_of};
use crate::mode::{StopState, Watch};
use vibro_numerics::events::{crossing_after_start, first_crossing};

/// A span is halved while the bound of a stop's travel exceeds this multiple of its largest size
/// so far; beyond it, roots would lose more than a digit. Halving is limited to [`HALVINGS`],
/// since an elongation that begins at zero has no size yet.
const REACH: f64 = 9.0;
/// Largest number of halvings of a span for [`REACH`].
const HALVINGS: i32 = 6;
/// Fraction of a sub-step before a knot within which a passage counts as simultaneous with the
/// knot, if nothing at the knot is beyond its limit by more than the zero tolerance.
const AT_KNOT: f64 = 1e-7;
/// An event function that was zero throughout the mode is watched again beyond this multiple of
/// its zero tolerance.
pub(super) const LEAVES_ZERO: f64 = 16.0;
/// Limit of an event function that is zero throughout the mode, in multiples of its zero
/// tolerance: at its passage it is surely beyond [`LEAVES_ZERO`].
const PASSES: f64 = LEAVES_ZERO + 1.0;
/// After a passage, this fraction of a span is searched for the end of a mere touch.
const WINDOW: f64 = 0.125;
/// Orders of departure from this one on are high: the event function is then below 0.375⁶/6! <
/// 4e-6 of its size at the end of the first interval.
const HIGH_ORDER: usize = 6;

/// An instant within a sub-step, given by its interval.
#[derive(Clone, Copy)]
pub(super) struct StepPoint {
    /// The interval.
    pub(super) interval: usize,
    /// Time from the interval's start, s.
    pub(super) dt: f64,
}

impl StepPoint {
    /// The instant at the end of a span that begins with the sub-step.
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

/// Passage of an event function through its limit in a sub-step.
pub(super) struct Passage {
    pub(super) at: StepPoint,
    /// Index of the event function.
    pub(super) place: usize,
}

/// Whether an event function with this order of zero at the start is searched in one piece.
fn is_high_order(order: usize) -> bool {
    (HIGH_ORDER..ORDERS).contains(&order)
}

/// The search for passages from a state in a mode.
pub(super) struct PassageSearch<'a> {
    pub(super) table: &'a FlowTable,
    pub(super) hybrid: &'a Hybrid,
}

impl PassageSearch<'_> {
    /// Whether an event function is zero throughout the mode.
    #[inline(always)]
    pub(super) fn is_unwatched(&self, place: usize) -> bool {
        self.hybrid.departing[place] == ORDERS
    }

    /// Returns the order of a zero at the start; also 0 for a function zero throughout the mode.
    #[inline(always)]
    pub(super) fn order(&self, place: usize) -> usize {
        self.hybrid.departing[place] % ORDERS
    }

    /// Returns the value at which an event function has an event. It is zero, or a multiple of its
    /// rounding if the event function is zero throughout the mode. If an event has left it beyond
    /// [`LEAVES_ZERO`] against the law, the multiple is [`DOUBTFUL`] + 1.
    #[inline(always)]
    pub(super) fn limit(&self, place: usize) -> f64 {
        if !self.is_unwatched(place) {
            return 0.0;
        }
        let row = &self.table.watched[place].row;
        let zero = self.hybrid.sizes.zero_of(row);
        let is_left = row.dot(self.hybrid.z.as_slice()) > LEAVES_ZERO * zero;
        (zero * if is_left { DOUBTFUL + 1.0 } else { PASSES }).max(f64::MIN_POSITIVE)
    }

    /// Returns the [`limit`](Self::limit) within a single sub-step. It is infinite for coordinates
    /// and rates that are zero throughout the mode: `watch_again` examines them at the sub-step's
    /// end, with sizes that include it. A quantity that begins at zero has no size before that.
    /// Any multiple of its rounding would be zero, and it would leave zero again and again.
    #[inline(always)]
    pub(super) fn short_limit(&self, place: usize) -> f64 {
        match self.table.watched[place].watch {
            Watch::Meets(_)
            | Watch::Presses(_)
            | Watch::Leaves(_)
            | Watch::Stops(_)
            | Watch::Turns(_)
            | Watch::Reverses(_)
                if self.is_unwatched(place) =>
            {
                f64::INFINITY
            }
            _ => self.limit(place),
        }
    }

    /// Returns the longest of `span`, `span`/2, … during which all watched stops travel at most
    /// [`REACH`], but at least `span`/64.
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

    /// Returns the first passage of an event function within a span. `None` is a proof that there
    /// is none.
    #[inline(always)]
    pub(super) fn first_passage(&self, span: f64, scratch: &mut Scratch) -> Option<Passage> {
        let (table, z) = (self.table, self.hybrid.z.as_slice());
        let has_high_order = self.hybrid.departing.iter().copied().any(is_high_order);
        let high = if has_high_order { self.high_order_passage(span, scratch.ahead.memory()) } else { None };
        let Scratch { heads, near, start, interval: begun, .. } = scratch;
        let start = start.as_mut_slice();
        near.clear();
        let mut any = 0;
        for place in 0..self.hybrid.departing.len() {
            let (order, limit, mut head) =
                (self.order(place), self.short_limit(place), head_of(heads, place));
            head.value -= limit;
            let samples = || table.samples(place, z).map(|value| value - limit);
            let intervals = near_intervals(order, &head, table.interval(), samples);
            any |= intervals;
            near.push(intervals);
        }
        let end = StepPoint::end(span, table);
        for interval in (0..=end.interval).filter(|i| any & (1 << i) != 0) {
            table.at_interval_start(interval, z, start);
            *begun = Some(interval);
            let from = &start[..];
            let length = if interval == end.interval { end.dt } else { table.interval() };
            // An early root is found again within twice its time, where the coefficients' rounding
            // is smaller.
            let (mut found, mut length, mut again) = (None, length, true);
            while again && let Some((dt, place)) = self.passage_within(near, from, (interval, length)) {
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

    /// Returns the longest part of a span, 1, 1/2, … 1/64, that keeps the watched stops' e within
    /// reach.
    #[inline(always)]
    pub(super) fn part_within_reach(&self, ahead: &Ahead) -> f64 {
        let (mut part, least) = (1.0, 0.5f64.powi(HALVINGS));
        for (place, w) in self.table.watched.iter().enumerate() {
            if !matches!(w.watch, Watch::Meets(_) | Watch::Presses(_)) {
                continue;
            }
            let head = ahead.head(place);
            if head.slope.abs() + head.behind > REACH * head.value.abs() {
                let way = ahead.way(&w.row);
                let path = |part: f64| way[1..].iter().rev().fold(0.0, |sum, c| (sum + c.abs()) * part);
                let size = w.row.size(self.hybrid.sizes.0.as_slice());
                while path(part) > REACH * size && part > least {
                    part *= 0.5;
                }
            }
        }
        part
    }

    /// Returns the first passage of an event function from below zero to above within a part of a
    /// span, as the fraction of the span and the event function's index. `None` is a proof that
    /// there is none.
    #[inline(always)]
    pub(super) fn passage_ahead(&self, part: f64, ahead: &Ahead) -> Option<(f64, usize)> {
        let mut first: Option<(f64, usize)> = None;
        for place in 0..self.table.watched.len() {
            let (order, head) = (self.order(place), ahead.head(place));
            let begin = head.value - self.short_limit(place);
            let stays = match order {
                0 => begin < 0.0 && begin.max(begin + head.slope) + head.behind < 0.0,
                1 => head.slope + head.behind < 0.0,
                _ => false,
            };
            if stays {
                continue;
            }
            // The series before this one may have ended within the tolerance of a touch.
            if self.table.is_curved() && order == 0 && begin > 0.0 && head.slope > 0.0 {
                let row = &self.table.watched[place].row;
                if begin > self.hybrid.sizes.zero_of(row) {
                    return Some((0.0, place));
                }
            }
            let mut c = ahead.way(&self.table.watched[place].row);
            c[0] = begin.min(0.0);
            if order > 0 {
                c.copy_within(order.., 0);
                c[TERMS - order..].fill(0.0);
                c[0] = c[0].min(-f64::MIN_POSITIVE);
            }
            let hi = first.map_or(part, |(part, _)| part);
            // Trailing zeros cost time and change nothing.
            let found = match ahead.coefficients() {
                ..=16 => passage_of::<16>(first_of(&c), hi),
                17..=24 => passage_of::<24>(first_of(&c), hi),
                25..=32 => passage_of::<32>(first_of(&c), hi),
                _ => passage_of(&c, hi),
            };
            if let Some(u) = found
                && !(order == 0 && self.only_touches(place, begin, &shortened(&c, (u + WINDOW).min(hi))))
            {
                first = Some((u, place));
            }
        }
        first
    }

    /// Whether a passage counts as simultaneous with the knot at the end of its span, as
    /// [`is_at_knot`](Self::is_at_knot).
    pub(super) fn is_at_knot_ahead(
        &self,
        (part, _): (f64, usize),
        (end, knot): (f64, f64),
        ahead: &Ahead,
    ) -> bool {
        let Self { table, hybrid } = self;
        if hybrid.time.plus(part * ahead.span).value() >= knot {
            return true;
        }
        if (end - part) * ahead.span
            > AT_KNOT * table.length_for(hybrid.z.as_slice(), hybrid.sizes.0.as_slice())
        {
            return false;
        }
        let mut there = hybrid.z.as_slice().to_vec();
        ahead.series.at(end, &mut there);
        table.watched.iter().all(|w| w.row.dot(&there) <= hybrid.sizes.zero_of(&w.row))
    }

    /// Whether a passage counts as simultaneous with the knot at the end of its span: the clock
    /// shows the knot's time, or the passage is within [`AT_KNOT`] of the knot and no event
    /// function exceeds zero there by more than the zero tolerance.
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
        table.at_interval_start(end.interval, &there, start);
        *interval = Some(end.interval);
        table.within(start, end.dt, true, ahead, &mut there);
        table.watched.iter().all(|w| w.row.dot(&there) <= hybrid.sizes.zero_of(&w.row))
    }

    /// Returns the first passage of an event function that starts at zero with a high order. The
    /// search covers the whole span, with the zero at its start divided out: at the ends of the
    /// first intervals the event function may still be only rounding.
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
                let coefficients = series.terms().skip(order).map(|z| w.row.dot(z));
                c.iter_mut().zip(coefficients).for_each(|(c, x)| *c = x);
                c[0] = c[0].min(-f64::MIN_POSITIVE);
                let hi = first.map_or(1.0, |(u, _)| u);
                first = first_crossing(&c, 0.0, hi, &mut 0).map(|u| (u, place)).or(first);
            }
        }
        first.map(|(u, place)| Passage { at: StepPoint::end(u * span, table), place })
    }

    /// Returns time and event function of the first passage within `length` from the start of an
    /// interval, among the event functions that `near` marks.
    #[inline(always)]
    fn passage_within(
        &self,
        near: &[u8],
        from: &[f64],
        (interval, length): (usize, f64),
    ) -> Option<(f64, usize)> {
        let mut first: Option<(f64, usize)> = None;
        let ratio = length / self.table.interval();
        for (place, _) in near.iter().enumerate().filter(|(_, near)| **near & (1 << interval) != 0) {
            let order = if interval == 0 { self.order(place) } else { 0 };
            let mut c = self.table.local(place, from);
            c[0] -= self.short_limit(place);
            let begin = c[0];
            if ratio != 1.0 {
                c = shortened(&c, ratio);
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

    /// Whether an event function exceeds zero within a span by no more than the zero tolerance,
    /// judged by its value at the start and its coefficients. Such a touch is not an event: a stop
    /// touched without speed is not hit, a level that is zero for an instant stays, a contact held
    /// up to its limit stays held. If it were one, a rounding error δ of the coordinate would give
    /// a speed of order √δ.
    ///
    /// A stop or a level that passes zero slowly has its event as soon as it exceeds the zero
    /// tolerance. Forces of contacts, and edges, only touch if they turn round. All others have an
    /// event at every passage.
    #[inline(never)]
    fn only_touches<const N: usize>(&self, place: usize, begin: f64, c: &[f64; N]) -> bool {
        let w = &self.table.watched[place];
        let zero = self.hybrid.sizes.zero_of(&w.row);
        let turns = match w.watch {
            Watch::Meets(_) | Watch::Level(_) => true,
            Watch::Opens(_) | Watch::Presses(_) | Watch::Slips(..) | Watch::Yields(..) => {
                turns_round(begin, c, zero)
            }
            // The force of a pressed stop that may pull jumps where it is left.
            Watch::Leaves(i) if self.hybrid.mode.stops[i] == StopState::Pressed => {
                turns_round(begin, c, zero)
            }
            Watch::Changes(_) | Watch::Leaves(_) | Watch::Stops(_) | Watch::Turns(_) | Watch::Reverses(_) => {
                false
            }
        };
        let lower = begin - zero;
        // Most event functions exceed the tolerance at the end: they have passed.
        turns && lower + sum_behind(c, |x| x) < 0.0 && {
            let mut c = *c;
            c[0] = lower;
            crossing_after_start(&c, 1.0, &mut 0).is_none()
        }
    }
}

/// Rescales a series' coefficients to a part of its span.
#[inline(always)]
pub(super) fn shortened<const N: usize>(c: &[f64; N], part: f64) -> [f64; N] {
    let (mut c, mut scale) = (*c, 1.0);
    for ck in &mut c {
        *ck *= scale;
        scale *= part;
    }
    c
}

/// Returns the first root of a series in [0, `hi`]. An early root is found again over a shorter
/// span, whose coefficients have less rounding.
#[inline(always)]
fn passage_of<const N: usize>(c: &[f64; N], hi: f64) -> Option<f64> {
    let u = match passage_from_below(c, hi) {
        Some(found) => found?,
        None => crossing_after_start(c, hi, &mut 0)?,
    };
    if !(u > 0.0 && u < 0.25) {
        return Some(u);
    }
    let part = 2.0 * u;
    crossing_after_start(&shortened(c, part), 1.0, &mut 0).map_or(Some(u), |again| Some(again * part))
}

/// Number of parts of a span, examined one after another.
const PARTS: usize = 8;
/// Largest number of steps of [`passage_from_below`] within a part.
const CAUTIOUS: usize = 8;

/// Returns the first root in [0, `hi`] of a series that starts below zero and is not proved to
/// rise. `None` if this method does not decide.
///
/// A part of the span has no root if its ends are below -M h²/8, with a bound M of |p''| up to
/// there. The other parts are crossed by steps that cannot pass a root: no root is nearer than the
/// root of p + p' s + M s²/2. The last step is Newton's, Δ: if 2 M Δ < p' the root is within 2 Δ,
/// and the step's error is at most 2 M Δ²/p'.
#[inline(always)]
fn passage_from_below<const N: usize>(c: &[f64; N], hi: f64) -> Option<Option<f64>> {
    let (mut slopes, mut bends, mut slope_sum) = ([0.0; N], [0.0; N], 0.0);
    for k in 1..N {
        slopes[k - 1] = k as f64 * c[k];
        slope_sum += slopes[k - 1].abs();
    }
    (2..N).for_each(|k| bends[k - 2] = (k - 1) as f64 * slopes[k - 1].abs());
    // If the series rises throughout, Newton's method of the caller takes two steps.
    if c[0] >= 0.0 || 2.0 * c[1] > slope_sum {
        return None;
    }
    let ends: [f64; PARTS] = std::array::from_fn(|i| hi * ((i + 1) as f64 / PARTS as f64));
    let (values, bends) = (at_parts(c, &ends), at_parts(&bends, &ends));
    let margin = (hi / PARTS as f64).powi(2) / 8.0;
    let mut before = c[0];
    for i in 0..PARTS {
        let (value, bend) = (values[i], bends[i]);
        if before.max(value) + margin * bend >= 0.0 {
            let begin = if i == 0 { 0.0 } else { ends[i - 1] };
            if let Some(root) = root_within(c, &slopes, (begin, ends[i]), bend)? {
                return Some((root < hi).then_some(root));
            }
        }
        before = value;
    }
    Some(None)
}

/// Returns the first root from the beginning of a part to its end, as [`passage_from_below`].
#[inline(always)]
fn root_within<const N: usize>(
    c: &[f64; N],
    slopes: &[f64; N],
    (begin, end): (f64, f64),
    bend: f64,
) -> Option<Option<f64>> {
    let mut u = begin;
    for _ in 0..CAUTIOUS {
        let (p, slope) = (by_fours(c, u), by_fours(slopes, u));
        if p >= 0.0 {
            return None;
        }
        let newton = -p / slope;
        let least = slope - 2.0 * bend * newton;
        if slope > 0.0 && least > 0.0 && bend * newton * newton <= 0.25 * f64::EPSILON * u * least {
            return Some((u + newton <= end).then_some(u + newton));
        }
        u += -2.0 * p / (slope + (slope * slope - 2.0 * bend * p).sqrt());
        if u >= end {
            return Some(None);
        }
    }
    None
}

/// Evaluates a series at several places.
#[inline(always)]
fn at_parts<const N: usize>(c: &[f64; N], parts: &[f64; PARTS]) -> [f64; PARTS] {
    let squares = parts.map(|u| u * u);
    let (mut even, mut odd) = ([0.0; PARTS], [0.0; PARTS]);
    for two in c.as_chunks::<2>().0.iter().rev() {
        (0..PARTS).for_each(|i| even[i] = even[i] * squares[i] + two[0]);
        (0..PARTS).for_each(|i| odd[i] = odd[i] * squares[i] + two[1]);
    }
    std::array::from_fn(|i| even[i] + parts[i] * odd[i])
}

/// Evaluates p(u) as four sums side by side, each over every fourth order.
#[inline(always)]
fn by_fours<const N: usize>(c: &[f64; N], u: f64) -> f64 {
    let square = u * u;
    let (fourth, mut sums) = (square * square, [0.0; 4]);
    for four in c.as_chunks::<4>().0.iter().rev() {
        (0..4).for_each(|k| sums[k] = sums[k] * fourth + four[k]);
    }
    (sums[0] + sums[1] * u) + (sums[2] + sums[3] * u) * square
}

/// The first coefficients of a series.
#[inline(always)]
fn first_of<const N: usize>(c: &[f64; TERMS]) -> &[f64; N] {
    c.first_chunk().expect("N is at most TERMS")
}

/// Whether an event function is not above zero at the end of a span, falls there, or will rise by
/// at most `zero` more up to its vertex.
fn turns_round<const N: usize>(begin: f64, c: &[f64; N], zero: f64) -> bool {
    let (mut slope, mut bend) = (0.0, 0.0);
    for (k, x) in c.iter().enumerate().skip(1) {
        let k = k as f64;
        slope += k * x;
        bend += k * (k - 1.0) * x;
    }
    begin + sum_behind(c, |x| x) <= 0.0 || slope <= 0.0 || slope * slope <= -2.0 * bend * zero
}

/// Returns the intervals of a sub-step with a possible zero of an event function, as bits. In the
/// others the function is proved to stay below zero. Between two samples at a distance h it lies
/// within M h²/8 of their chord, where M bounds its second derivative. Its zero at the start has
/// the order `order`.
#[inline(always)]
fn near_intervals(order: usize, head: &Head, step: f64, samples: impl FnOnce() -> [f64; INTERVALS]) -> u8 {
    if order >= HIGH_ORDER {
        return 0; // searched in one piece
    }
    let Head { value, slope, bend } = *head;
    let length = step * INTERVALS as f64;
    // The bound value + slope t + bend t²/2 is convex: it is negative throughout if it is negative
    // at both ends.
    let begins = if order == 0 { value < 0.0 } else { order == 1 };
    let start = if order == 0 { value } else { 0.0 };
    if begins && start + length * (slope + 0.5 * bend * length) < 0.0 {
        return 0;
    }
    let margin = bend * step * step * 0.125;
    // An event function that starts at zero falls throughout the first interval if the slope
    // outweighs the second derivative.
    let leaves = order == 1 && slope + 0.5 * bend * step < 0.0;
    let mut ends = 0u64;
    for (k, sample) in samples().into_iter().enumerate() {
        let is_below = (sample + margin).to_bits() >> 63;
        ends |= (is_below ^ 1) << k;
    }
    // An interval is searched unless both of its ends are proved to be below.
    let near = ends | ends << 1 | u64::from(order > 0 || value >= -margin);
    (if leaves { near & !1 } else { near }) as u8
}

/// Σ part(c_k) over k ≥ 1, in four partial sums for vector instructions.
#[inline(always)]
fn sum_behind<const N: usize>(c: &[f64; N], part: impl Fn(f64) -> f64) -> f64 {
    let mut sums = [-part(c[0]), 0.0, 0.0, 0.0];
    for four in c.as_chunks::<4>().0 {
        sums.iter_mut().zip(four).for_each(|(sum, x)| *sum += part(*x));
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

#[cfg(test)]
mod tests;
