//! Advancing: sub-steps in which no event happens, proved, and the way to the first event.

use super::{Due, Hybrid, Motion, Observer, Outcome, Scratch};
use crate::energy::NODES;
use crate::error::Error;
use crate::flow::{INTERVALS, LOCAL, ORDERS, Series, Table, WatchTable};
use crate::mode::Watch;
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
            self.hybrid.due = self.substep(goal, at_knot)?;
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

    fn stuck(&self, cause: &str) -> Error {
        let last = self.hybrid.last.map(|watch| self.assembly.name_of(watch));
        let cause = match last {
            Some(name) => format!("{cause}; events follow one another at {name}"),
            None => cause.into(),
        };
        Error::Stuck { time: self.time(), cause }
    }

    /// A sub-step of at most the table's length towards `goal`, or to the event before which it ends.
    fn substep(&mut self, goal: DoubleDouble, at_knot: bool) -> Result<Option<Due>, Error> {
        let table = self.table.clone();
        let remaining = goal.minus(self.hybrid.time).value();
        let mut scratch = std::mem::take(&mut self.scratch);
        let sizes = &mut scratch.sizes;
        sizes.clear();
        sizes.extend(self.hybrid.z.iter().map(|x| x.abs()));
        let span = self.within_reach(table.length.min(remaining), sizes);
        let passage = self.first_passage(span, &mut scratch);
        let whole = span == table.length && passage.is_none();
        let end = passage.as_ref().map_or_else(|| Point::end(span, &table), |p| p.at);
        let dt = if passage.is_none() { span } else { end.time(&table) };
        self.account(&table, whole, (end.interval, dt), &mut scratch);
        let z = self.hybrid.z.as_mut_slice();
        let Scratch { start, series, .. } = &mut scratch;
        if whole {
            table.at_interval_end(INTERVALS - 1, z, series, start);
            z.copy_from_slice(start);
        } else {
            if end.interval > 0 {
                table.at_interval_end(end.interval - 1, z, series, start);
            } else {
                start.copy_from_slice(z);
            }
            series.expand(&table, start, end.dt, 0);
            series.at(1.0, z);
        }
        self.scratch = scratch;
        let reaches = passage.is_none() && span >= remaining;
        self.hybrid.time = if reaches { goal } else { self.hybrid.time.plus(dt) };
        if dt > PROGRESS * table.length {
            self.hybrid.chain = 0;
        }
        let knot = reaches && at_knot;
        if !knot {
            self.refill();
        }
        self.hybrid.sizes.include(&self.hybrid.z);
        self.keep_contacts();
        if let Some(passage) = passage {
            let watch = table.watched[passage.place].watch;
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

    /// The energy accounts of a flight over a time from the present state, which ends in a certain interval.
    fn account(&mut self, table: &Table, whole: bool, (last, dt): (usize, f64), scratch: &mut Scratch) {
        let Hybrid { energy, mode, z, .. } = &mut self.hybrid;
        if !energy.are_kept() {
            return;
        }
        let Scratch { series, point, .. } = scratch;
        let nodes = if whole { table.nodes() } else { &[] };
        if nodes.is_empty() {
            series.expand(table, z.as_slice(), dt, last);
        }
        energy.add((&self.assembly.system, mode, table), dt, point, |k, to| match nodes.get(k) {
            Some(node) => node.times(z.as_slice(), to),
            None => series.at(NODES[k].0, to),
        });
    }

    /// Watched functionals begin the next sub-step away from zero, but for those that are zero throughout the mode, of which every
    /// coefficient is rounding.
    fn watch_again(&mut self) {
        let Hybrid { departing, z, sizes, .. } = &mut self.hybrid;
        for (order, w) in departing.iter_mut().zip(&self.table.watched) {
            let stays =
                *order == ORDERS && w.terms.dot(z.as_slice()).abs() <= LEAVES_ZERO * sizes.zero_of(&w.terms);
            *order = if stays { ORDERS } else { 0 };
        }
    }

    /// The longest span of `span`, `span`/2, … in which the watched stops' e stay within reach.
    fn within_reach(&self, mut span: f64, sizes: &[f64]) -> f64 {
        let (table, z) = (&self.table, self.hybrid.z.as_slice());
        let least = span * 0.5f64.powi(HALVINGS);
        for w in &table.watched {
            if !matches!(w.watch, Watch::Meets(_) | Watch::Presses(_)) {
                continue;
            }
            let size = w.terms.size(self.hybrid.sizes.0.as_slice());
            let slope = w.slope.dot(z).abs();
            let curvature = w.bend(sizes);
            while span * (slope + 0.5 * curvature * span) > REACH * size && span > least {
                span *= 0.5;
            }
        }
        span
    }

    /// The first passage of a watched functional from below zero to above within a span, or the proof that there is none.
    fn first_passage(&self, span: f64, scratch: &mut Scratch) -> Option<Passage> {
        let (table, z) = (&*self.table, self.hybrid.z.as_slice());
        let late = self.late_passage(span, &mut scratch.series);
        let Scratch { sizes, near, start, series, .. } = scratch;
        near.clear();
        let mut any = 0;
        for (w, &order) in table.watched.iter().zip(&self.hybrid.departing) {
            let intervals = near_intervals(w, order, z, sizes, table.interval());
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
    fn late_passage(&self, span: f64, series: &mut Series) -> Option<Passage> {
        let table = &*self.table;
        let late = |order: usize| (LATE..ORDERS).contains(&order);
        if !self.hybrid.departing.iter().copied().any(late) {
            return None;
        }
        series.expand(table, self.hybrid.z.as_slice(), span, Point::end(span, table).interval);
        let mut first: Option<(f64, usize)> = None;
        for (place, (w, &order)) in table.watched.iter().zip(&self.hybrid.departing).enumerate() {
            if late(order) {
                let mut c = [0.0; ORDERS];
                let coefficients = series.terms().skip(order).map(|z| w.terms.dot(z));
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
fn near_intervals(w: &WatchTable, order: usize, z: &[f64], sizes: &[f64], step: f64) -> u8 {
    if order >= LATE {
        return 0; // zero throughout, or searched in one piece
    }
    let (value, slope, bend) = (w.terms.dot(z), w.slope.dot(z), w.bend(sizes));
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
