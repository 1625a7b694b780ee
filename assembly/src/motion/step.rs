//! Advancing: sub-steps in which no event happens, proved, and the way to the first event.

use super::{Due, Hybrid, Motion, Observer, Outcome, Scratch};
use crate::energy::Samples;
use crate::error::Error;
use crate::flow::{INTERVALS, LOCAL, ORDERS, Series, Table, WatchTable};
use crate::mode::Watch;
use crate::system::System;
use vibro_impact::events::first_crossing;
use vibro_impact::numerics::double_double::DoubleDouble;

/// A sub-step is halved while a stop's e may move by more than this many times its largest size so far: beyond, the roots would
/// lose digits. Not more often than [`HALVINGS`], since what begins at zero has no size yet.
const REACH: f64 = 4.0;
/// Halvings of a sub-step for its reach.
const HALVINGS: i32 = 6;
/// Sub-steps in one call, and for each sub-step's length of time.
const WORK: (u64, f64) = (20_000, 64.0);
/// Events at one instant without progress, for each element and one more.
const CHAIN: usize = 100;
/// From this order on a functional that leaves zero is at the first interval's end under 0.25⁶/6! < 4e-7 of its size.
const LATE: usize = 6;
/// Parts of a mode's sub-step that count as progress of time: a few roundings.
const PROGRESS: f64 = 1e-15;
/// A functional that was zero throughout is watched again beyond this many times the size under which it counts as zero.
const LEAVES_ZERO: f64 = 16.0;

/// What an advance does at an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Pause {
    Never,
    AfterEvent,
    BeforeEvent,
}

/// Where a sub-step ends, or is searched: a part of an interval.
#[derive(Clone, Copy)]
struct Point {
    /// The interval.
    interval: usize,
    /// Time from its start, s.
    dt: f64,
}

impl Point {
    /// The end of a span of a sub-step.
    fn end(span: f64, table: &Table) -> Self {
        let step = table.interval();
        let interval = ((span / step).ceil() as usize).clamp(1, INTERVALS) - 1;
        Self { interval, dt: span - interval as f64 * step }
    }

    /// Time from the sub-step's start, s.
    fn time(&self, table: &Table) -> f64 {
        self.interval as f64 * table.interval() + self.dt
    }
}

/// The first passage of a watched functional in a sub-step.
struct Passage {
    at: Point,
    /// The functional's place.
    place: usize,
}

impl Motion {
    /// Advances to a time.
    ///
    /// # Errors
    /// [`Error::Step`] for an end before the present or not finite; [`Error::Jammed`], [`Error::Violated`] and [`Error::Stuck`]
    /// where the motion cannot go on: the state then stands at the time reached.
    pub fn advance_to(&mut self, end: f64) -> Result<(), Error> {
        self.advance(end, Pause::Never, &mut None).map(drop)
    }

    /// Advances to a time and reports every event on the way.
    ///
    /// # Errors
    /// As [`advance_to`](Self::advance_to).
    pub fn advance_observed(
        &mut self,
        end: f64,
        observer: &mut dyn FnMut(&super::Event),
    ) -> Result<(), Error> {
        self.advance(end, Pause::Never, &mut Some(observer)).map(drop)
    }

    /// Advances to a time or, if it is earlier, to the state after the next event.
    ///
    /// # Errors
    /// As [`advance_to`](Self::advance_to).
    pub fn advance_to_event(
        &mut self,
        end: f64,
        observer: &mut dyn FnMut(&super::Event),
    ) -> Result<Outcome, Error> {
        self.advance(end, Pause::AfterEvent, &mut Some(observer))
    }

    /// Advances to a time or, if it is earlier, to the next event, before its law: [`apply_event`](Self::apply_event) or any further
    /// advance applies it.
    ///
    /// # Errors
    /// As [`advance_to`](Self::advance_to).
    pub fn advance_before_event(
        &mut self,
        end: f64,
        observer: &mut dyn FnMut(&super::Event),
    ) -> Result<Outcome, Error> {
        self.advance(end, Pause::BeforeEvent, &mut Some(observer))
    }

    /// Whether it stands at an event whose law is still to be applied.
    pub fn is_event_due(&self) -> bool {
        self.hybrid.due.is_some()
    }

    /// Applies the law of the event before which the last advance has paused; without one nothing happens.
    ///
    /// # Errors
    /// [`Error::Jammed`], [`Error::Violated`] and [`Error::Stuck`] where the motion cannot go on.
    pub fn apply_event(&mut self, observer: &mut dyn FnMut(&super::Event)) -> Result<(), Error> {
        self.pass_event(&mut Some(observer))
    }

    /// Applies the law of an event that is due.
    pub(super) fn pass_event(&mut self, observer: &mut Observer) -> Result<(), Error> {
        match self.hybrid.due.take() {
            Some(Due::Passage(watch)) => self.settle(&[watch], observer),
            Some(Due::Knot) => {
                self.refill();
                self.knot(observer)
            }
            None => Ok(()),
        }
    }

    fn advance(&mut self, end: f64, pause: Pause, observer: &mut Observer) -> Result<Outcome, Error> {
        if !(end.is_finite() && end >= self.time()) {
            return Err(Error::Step { time: self.time(), end });
        }
        self.pass_event(observer)?;
        let target = DoubleDouble::new(end);
        let (mut work, mut from) = (WORK.0 as f64, self.time());
        loop {
            let remaining = target.minus(self.hybrid.time).value();
            if remaining <= 0.0 {
                self.hybrid.time = target;
                return Ok(Outcome::End);
            }
            let knot = self.assembly.system.signals.next_knot(self.time()).filter(|&t| t <= end);
            let (goal, at_knot) = knot.map_or((target, false), |t| (DoubleDouble::new(t), true));
            self.hybrid.due = self.vectors.dispatch(Substep { motion: self, goal, at_knot })?;
            if self.hybrid.due.is_some() {
                if pause != Pause::BeforeEvent {
                    self.pass_event(observer)?;
                }
                if pause != Pause::Never {
                    return Ok(Outcome::Event);
                }
            }
            work -= 1.0;
            work += WORK.1 * (self.time() - from) / self.table.length;
            from = self.time();
            if work < 0.0 {
                return Err(self.stuck("the limit of work in one call is reached"));
            }
        }
    }

    pub(super) fn stuck(&self, cause: &str) -> Error {
        let last = self.hybrid.last.map(|watch| self.assembly.name_of(watch));
        let cause = match last {
            Some(name) => format!("{cause}; events follow one another at {name}"),
            None => cause.into(),
        };
        Error::Stuck { time: self.time(), cause }
    }

    /// A sub-step of at most the table's length towards `goal`, or to the event before which it ends.
    #[inline(always)]
    fn substep(&mut self, goal: DoubleDouble, at_knot: bool) -> Result<Option<Due>, Error> {
        let Self { table, hybrid, scratch, assembly, .. } = self;
        let table = &**table;
        let remaining = goal.minus(hybrid.time).value();
        scratch.look(table, hybrid);
        let flight = Flight { table, hybrid };
        let span = flight.within_reach(table.length.min(remaining), &scratch.heads);
        let passage = flight.first_passage(span, scratch);
        let whole = span == table.length && passage.is_none();
        let end = passage.as_ref().map_or_else(|| Point::end(span, table), |p| p.at);
        let dt = if passage.is_none() { span } else { end.time(table) };
        if hybrid.energy.are_kept() {
            account(&assembly.system, table, hybrid, whole.then_some(dt).ok_or((end.interval, dt)), scratch);
        }
        let z = hybrid.z.as_mut_slice();
        let Scratch { start, series, .. } = scratch;
        if whole {
            table.at_interval_end(INTERVALS - 1, z, series, start);
            z.copy_from_slice(start);
        } else {
            // From the nearer end of the interval.
            let later = end.dt > 0.5 * table.interval();
            let (passed, dt) =
                if later { (end.interval + 1, end.dt - table.interval()) } else { (end.interval, end.dt) };
            match passed.checked_sub(1) {
                Some(last) => table.at_interval_end(last, z, series, start),
                None => start.copy_from_slice(z),
            }
            table.near(start, dt, at_knot, series, z);
        }
        let reaches = passage.is_none() && span >= remaining;
        self.hybrid.time = if reaches { goal } else { self.hybrid.time.plus(dt) };
        if dt > PROGRESS * self.table.length {
            self.hybrid.chain = 0;
        }
        let knot = reaches && at_knot;
        if !knot {
            self.refill();
        }
        self.hybrid.sizes.include(&self.hybrid.z);
        self.keep_contacts();
        if let Some(passage) = passage {
            let watch = self.table.watched[passage.place].watch;
            self.hybrid.chain += 1;
            self.hybrid.last = Some(watch);
            if self.hybrid.chain > CHAIN * (self.hybrid.departing.len() + 1) {
                return Err(self.stuck("the modes change without end"));
            }
            return Ok(Some(Due::Passage(watch)));
        }
        self.watch_again();
        Ok(knot.then_some(Due::Knot))
    }

    /// Watched functionals begin the next sub-step away from zero, but for those that are zero throughout the mode, of which every
    /// coefficient is rounding.
    #[inline(always)]
    fn watch_again(&mut self) {
        let Hybrid { departing, z, sizes, .. } = &mut self.hybrid;
        for (order, w) in departing.iter_mut().zip(&self.table.watched) {
            let stays =
                *order == ORDERS && w.terms.dot(z.as_slice()).abs() <= LEAVES_ZERO * sizes.zero_of(&w.terms);
            *order = if stays { ORDERS } else { 0 };
        }
    }
}

/// A sub-step, compiled for each kind of vectors that a computer may have. Products are not fused, so that all give the same bits.
struct Substep<'a> {
    motion: &'a mut Motion,
    goal: DoubleDouble,
    at_knot: bool,
}

impl pulp::WithSimd for Substep<'_> {
    type Output = Result<Option<Due>, Error>;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Self::Output {
        self.motion.substep(self.goal, self.at_knot)
    }
}

/// A watched functional where a sub-step begins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Head {
    value: f64,
    slope: f64,
    /// A bound of its second derivative throughout the sub-step.
    bend: f64,
}

impl Scratch {
    /// Takes in the state at a sub-step's start.
    #[inline(always)]
    fn look(&mut self, table: &Table, hybrid: &Hybrid) {
        let z = hybrid.z.as_slice();
        self.sizes.iter_mut().zip(z).for_each(|(size, x)| *size = x.abs());
        self.heads.clear();
        self.heads.extend(table.watched.iter().map(|w| Head {
            value: w.terms.dot(z),
            slope: w.slope.dot(z),
            bend: w.bend(&self.sizes),
        }));
    }
}

/// The energy accounts of a flight over a whole sub-step of a length, or into an interval and over a time.
#[inline(always)]
fn account(
    system: &System,
    table: &Table,
    hybrid: &mut Hybrid,
    flight: Result<f64, (usize, f64)>,
    scratch: &mut Scratch,
) {
    let Hybrid { energy, mode, z, .. } = hybrid;
    let Scratch { series, point, states, .. } = scratch;
    let nodes = if flight.is_ok() { table.nodes() } else { &[] };
    let (last, dt) = flight.map_or_else(|partial| partial, |dt| (INTERVALS - 1, dt));
    let size = z.len();
    let samples = if nodes.is_empty() {
        series.expand(table, z.as_slice(), dt, table.orders_to(last));
        Samples::Series(series.terms(), size)
    } else {
        states.resize(nodes.len() * size, 0.0);
        for (node, state) in nodes.iter().zip(states.chunks_mut(size)) {
            node.times(z.as_slice(), state);
        }
        Samples::States(states, size)
    };
    energy.add((system, mode, table), dt, &samples, point);
}

/// A sub-step's start in a mode.
struct Flight<'a> {
    table: &'a Table,
    hybrid: &'a Hybrid,
}

impl Flight<'_> {
    /// The longest span of `span`, `span`/2, … in which the watched stops' e stay within reach.
    #[inline(always)]
    fn within_reach(&self, mut span: f64, heads: &[Head]) -> f64 {
        let least = span * 0.5f64.powi(HALVINGS);
        for (w, head) in self.table.watched.iter().zip(heads) {
            if !matches!(w.watch, Watch::Meets(_) | Watch::Presses(_)) {
                continue;
            }
            let path = |span: f64| span * (head.slope.abs() + 0.5 * head.bend * span);
            if path(span) <= REACH * head.value.abs() {
                continue; // its size is at least its value's
            }
            let size = w.terms.size(self.hybrid.sizes.0.as_slice());
            while path(span) > REACH * size && span > least {
                span *= 0.5;
            }
        }
        span
    }

    /// The first passage of a watched functional from below zero to above within a span, or the proof that there is none.
    #[inline(always)]
    fn first_passage(&self, span: f64, scratch: &mut Scratch) -> Option<Passage> {
        let (table, z) = (self.table, self.hybrid.z.as_slice());
        let late = self.late_passage(span, &mut scratch.series);
        let Scratch { heads, near, start, series, .. } = scratch;
        near.clear();
        let mut any = 0;
        for ((w, &order), head) in table.watched.iter().zip(&self.hybrid.departing).zip(heads.iter()) {
            let intervals = near_intervals(w, order, z, head, table.interval());
            any |= intervals;
            near.push(intervals);
        }
        let end = Point::end(span, table);
        for interval in (0..=end.interval).filter(|i| any & (1 << i) != 0) {
            let from = if interval == 0 {
                z
            } else {
                table.at_interval_end(interval - 1, z, series, start);
                &start[..]
            };
            let length = if interval == end.interval { end.dt } else { table.interval() };
            let Some((mut dt, mut place)) = self.passage_within(near, from, interval, length) else {
                continue;
            };
            // A root early in the interval is found anew in a shorter one, of which the coefficients' rounding is smaller.
            if interval == 0
                && dt > 0.0
                && dt < 0.25 * length
                && let Some(again) = self.passage_within(near, from, interval, 2.0 * dt)
            {
                (dt, place) = again;
            }
            let at = Point { interval, dt };
            let first = Passage { at, place };
            return Some(late.filter(|late| late.at.time(table) < at.time(table)).unwrap_or(first));
        }
        late
    }

    /// The first passage of a functional that leaves zero with a high order: at the ends of the first intervals it may still be rounding, so
    /// that it is searched in one piece, with the zero at its start divided out.
    #[inline(never)]
    fn late_passage(&self, span: f64, series: &mut Series) -> Option<Passage> {
        let table = self.table;
        let late = |order: usize| (LATE..ORDERS).contains(&order);
        if !self.hybrid.departing.iter().copied().any(late) {
            return None;
        }
        let last = Point::end(span, table).interval;
        let z = self.hybrid.z.as_slice();
        series.expand(table, z, span, table.orders_to(last));
        let mut first: Option<(f64, usize)> = None;
        for (place, (w, &order)) in table.watched.iter().zip(&self.hybrid.departing).enumerate() {
            if late(order) {
                let mut c = [0.0; ORDERS];
                let coefficients = series.terms().chunks_exact(z.len()).skip(order).map(|z| w.terms.dot(z));
                c.iter_mut().zip(coefficients).for_each(|(c, x)| *c = x);
                c[0] = c[0].min(-f64::MIN_POSITIVE);
                let hi = first.map_or(1.0, |(u, _)| u);
                first = first_crossing(&c, 0.0, hi, &mut 0).map(|u| (u, place)).or(first);
            }
        }
        first.map(|(u, place)| Passage { at: Point::end(u * span, table), place })
    }

    /// The first passage within a time `length` from the start of an interval, with its time, among the functionals that may have one
    /// there.
    #[inline(always)]
    fn passage_within(
        &self,
        near: &[u8],
        from: &[f64],
        interval: usize,
        length: f64,
    ) -> Option<(f64, usize)> {
        let mut first: Option<(f64, usize)> = None;
        let ratio = length / self.table.interval();
        for (place, w) in
            self.table.watched.iter().enumerate().filter(|(place, _)| near[*place] & (1 << interval) != 0)
        {
            let order = if interval == 0 { self.hybrid.departing[place] } else { 0 };
            let mut c = w.local(from);
            let mut scale = 1.0;
            for ck in &mut c {
                *ck *= scale;
                scale *= ratio;
            }
            if order > 0 {
                c.copy_within(order.., 0);
                c[LOCAL - order..].fill(0.0);
                c[0] = c[0].min(-f64::MIN_POSITIVE);
            } else {
                c[0] = c[0].min(0.0);
            }
            let rest: f64 = c[1..].iter().map(|x| x.abs()).sum();
            if c[0] + rest < 0.0 {
                continue;
            }
            let hi = first.map_or(1.0, |(dt, _)| dt / length);
            if let Some(u) = first_crossing(&c, 0.0, hi, &mut 0) {
                first = Some((u * length, place));
            }
        }
        first
    }
}

/// The intervals of a sub-step in which a functional may pass zero, as bits: of the others it is proved that it stays below zero.
/// Between two samples a distance h apart it lies within M h²/8 of their chord, where M bounds its second derivative. With
/// `order` it leaves zero at the start.
#[inline(always)]
fn near_intervals(w: &WatchTable, order: usize, z: &[f64], head: &Head, step: f64) -> u8 {
    if order >= LATE {
        return 0; // zero throughout, or searched in one piece
    }
    let Head { value, slope, bend } = *head;
    let length = step * INTERVALS as f64;
    if order == 0 && value + length * (slope.max(0.0) + 0.5 * bend * length) < 0.0 {
        return 0;
    }
    let margin = bend * step * step * 0.125;
    // From zero it goes down throughout the first interval if the slope outweighs what the second derivative adds.
    let leaves = order == 1 && slope + 0.5 * bend * step < 0.0;
    let (mut near, mut before) = (0, !leaves && (order > 0 || value >= -margin));
    for (k, sample) in w.samples(z).into_iter().enumerate() {
        let here = sample >= -margin;
        if before || here {
            near |= 1 << k;
        }
        before = here;
    }
    if leaves { near & !1 } else { near }
}
