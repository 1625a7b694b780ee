//! Sub-steps of any kind (short sub-steps, rest, motion under loads). Each either has a proof that
//! it contains no event, or ends at its first event. The code in `flight.rs` is faster for flight
//! without loads; the sub-steps for which it finds no proof are computed here.
//!
//! # Why it is so
//!
//! An interval is skipped only if the samples at its ends are farther from the event's limit than
//! the functional can bend between them: |g''| h²/8. All other intervals are searched on a series
//! by [`first_crossing`], which finds the first passage or proves that none exists. So each
//! sub-step ends with an event or with a proof (docs/numerics.md, "Events").
//!
//! Three starts need more than this:
//! - A departure from a stop: the functional is zero at the start. The known power of u is divided
//!   out, so that a return is found however soon it comes (`first_event_from_start`).
//! - A contact force that is within rounding at the start, while its first certain derivative
//!   presses the block to the stop. The known power of u is divided out here, too
//!   (`divide_where_pressed`).
//! - A departure whose direction is uncertain. The step is shortened to a quarter of an interval,
//!   and a return found in it means that the block stays (`substep_within_interval`).
//!
//! # What must not change without proof
//!
//! - The order of operations: this code runs without vectors, so that its bits are equal on all
//!   instruction sets (`tests/state_bits.rs`). Both stops are searched over the whole way, so that
//!   a motion and its mirror image have the same bits.
//! - [`MAX_REACH`] and [`SHORT`]: docs/numerics.md, sections 1 and 2.
//! - The places at which the time is set to exactly `end`: a step that reaches `end` sets the
//!   time, since a sum would drift.
//!
//! # Changes
//!
//! - Another reason to shorten a step: the condition in `general_substep` that chooses
//!   `substep_within_interval`.
//! - Another event functional: `Series::functional`, the samples of `flow::SubstepTable` with
//!   their bound, and the limit in `substep_by_tables` and `search_intervals`.

use super::points::{SeriesPoint, SubstepStart};
use super::{Contact, Simulator};
use crate::flow::{ANCHORED, CENTRED, INTERVALS, Series, SubstepTable};
use crate::model::{Augmented, RELATIVE, RELATIVE_RATE, SmoothMode};
use std::sync::Arc;
use vibro_numerics::double_double::DoubleDouble;
use vibro_numerics::events::first_crossing;
use vibro_numerics::simd::value;

/// Tolerance for a block past a stop at the start of a search, relative to path and gap; checked
/// in debug builds only.
const START_ROUNDING: f64 = 1e-9;

/// Fraction of an interval below which a step is short. The change of state in a short step is
/// summed separately, so that the roundings of many short steps do not add up (docs/numerics.md,
/// section 1).
pub(super) const SHORT: f64 = 1.0 / 1024.0;

/// Limit for the block's path in an interval, in gaps; up to it the interval is searched as a
/// whole. For longer paths steps are shortened, so that a root is resolved to 10⁻¹² of the gap.
pub(super) const MAX_REACH: f64 = 4.0;

impl Simulator {
    /// A sub-step of at most `remaining` s from `z`: the state at its end and the stop of its
    /// event, if it reached one. Compiled once, for all instruction sets.
    #[inline(never)]
    pub(super) fn general_substep<const LOADS: usize>(
        &mut self,
        mut z: Augmented,
        remaining: f64,
        end: DoubleDouble,
    ) -> (Augmented, Option<f64>) {
        if self.hybrid.contact != Contact::Flight && !self.rest.core_ready {
            let rest = Arc::make_mut(&mut self.rest);
            rest.core.fill(pulp::Scalar, &self.model, SmoothMode::Rest, self.substep);
            rest.core_ready = true;
        }
        let mut bound = self.tables().core.curvature(&z);
        let forces = [(); LOADS].map(|()| self.forces_now());
        let mut start = SubstepStart { z, forces, bound };
        if let Some(columns) = start.columns() {
            bound += self.tables().load.curvature(&columns);
            start.bound = bound;
        }
        let interval = self.interval();
        let wild = self.hybrid.contact == Contact::Flight && self.exceeds_reach(&z, start.bound);
        let doubtful = self.is_doubtful();
        let side = if remaining <= interval || wild || doubtful {
            // In a doubtful departure all derivatives up to the eighth are within rounding. In a
            // quarter of an interval the higher derivatives have a negligible effect.
            let longest = if doubtful { 0.25 * interval } else { interval };
            self.substep_within_interval(&mut z, &start, remaining.min(longest), remaining, end)
        } else {
            self.substep_by_tables(&mut z, &start, remaining, end)
        };
        (z, side)
    }

    /// A step within one interval, on a series about its start.
    #[inline(always)]
    fn substep_within_interval<const LOADS: usize>(
        &mut self,
        z: &mut Augmented,
        start: &SubstepStart<LOADS>,
        mut span: f64,
        remaining: f64,
        end: DoubleDouble,
    ) -> Option<f64> {
        let gap = self.model.gap;
        let mut near = [true; 2];
        self.work.expansions += 1;
        let mut series = Series::<ANCHORED>::expand(&self.model, self.mode(), z, start.forces(), span);
        if self.hybrid.contact == Contact::Flight {
            // The coefficients bound the block's path. The step is halved until this path is at
            // most MAX_REACH gaps.
            let reach =
                |u: f64| series.states[1..].iter().rev().fold(0.0, |sum, c| (sum + c[RELATIVE].abs()) * u);
            let mut part = 1.0;
            while reach(part) > MAX_REACH * gap {
                part *= 0.5;
            }
            let path = reach(part);
            near = [z[RELATIVE] + path >= gap, path - z[RELATIVE] >= gap];
            if part < 1.0 {
                span *= part;
                self.work.expansions += 1;
                series = Series::<ANCHORED>::expand(&self.model, self.mode(), z, start.forces(), span);
            }
        }
        // At a departure the derivatives below the order of departure are zero. Their rounding
        // could move the block in either direction.
        let order = self.hybrid.departing;
        let zero = usize::from(order);
        series.states.iter_mut().take(zero).skip(1).for_each(|state| state[RELATIVE] = 0.0);
        series.states.iter_mut().take(zero.saturating_sub(1)).for_each(|state| state[RELATIVE_RATE] = 0.0);
        let passage = self.first_event_from_start(&series, start, near, span);
        // A block whose departure is doubtful, and which returns, stays at the stop.
        let stays = self.is_doubtful() && passage.is_some();
        let (u, side) = passage.filter(|_| !stays).map_or((1.0, None), |(u, side)| (u, Some(side)));
        let arrival = SeriesPoint { series: &series, base: 0.0, radius: span, u, interval: None };
        self.advance_to_point(z, start, &arrival);
        if stays {
            (z[RELATIVE], z[RELATIVE_RATE]) = (start.z[RELATIVE], 0.0);
            self.hybrid.departing = order;
        }
        if side.is_none() && span >= remaining {
            self.hybrid.time = end;
        }
        side
    }

    /// A sub-step by the tables: 16 samples of the event functional and the bound between them.
    /// Intervals that these do not clear are searched.
    #[inline(always)]
    fn substep_by_tables<const LOADS: usize>(
        &mut self,
        z: &mut Augmented,
        start: &SubstepStart<LOADS>,
        remaining: f64,
        end: DoubleDouble,
    ) -> Option<f64> {
        let interval = self.interval();
        let (flight, gap) = (self.hybrid.contact == Contact::Flight, self.model.gap);
        let tables = self.tables();
        let mut g = [0.0; INTERVALS];
        tables.core.samples(z, &mut g);
        if let Some(columns) = start.columns() {
            tables.load.samples(&columns, &mut g);
        }
        let margin = start.bound * interval * interval * 0.125;
        let whole = remaining >= self.substep;
        // A functional that is at least `margin` away from its limit at both ends of an interval
        // does not reach the limit in the interval.
        let (first, clear) = if flight {
            let limit = gap - margin;
            let most = g.iter().fold(0.0f64, |most, x| most.max(x.abs()));
            let leaves = self.clears_first_interval(z, start.bound, limit);
            (leaves, leaves && most < limit)
        } else {
            let side = self.hybrid.contact.side();
            let f = start.forces().map(|f| f.map(|d| d[0]));
            let now = side * self.model.acceleration(SmoothMode::Rest, z, f).free;
            let least = g.iter().fold(f64::INFINITY, |least, x| least.min(side * x));
            (now > margin, now > margin && least > margin)
        };
        if !clear && let Some(side) = self.search_intervals(z, start, &g, margin, first, remaining) {
            return Some(side);
        }
        if whole {
            self.advance_whole_substep(z, start);
        } else {
            let index = ((remaining / interval) as usize).min(INTERVALS - 1);
            let (series, base) = self.centred(start, index);
            let u = (remaining - base) / (0.5 * interval);
            let arrival =
                SeriesPoint { series: &series, base, radius: 0.5 * interval, u, interval: Some(index) };
            self.advance_to_point(z, start, &arrival);
            self.hybrid.time = end;
        }
        None
    }

    /// Searches the intervals that the samples `g` do not clear, and moves to the first event.
    /// Returns its stop. Without an event the result is `None` and `z` is unchanged.
    #[inline(always)]
    fn search_intervals<const LOADS: usize>(
        &mut self,
        z: &mut Augmented,
        start: &SubstepStart<LOADS>,
        g: &[f64; INTERVALS],
        margin: f64,
        first_clear: bool,
        remaining: f64,
    ) -> Option<f64> {
        let interval = self.interval();
        let side = self.hybrid.contact.side();
        // A sample is near (within the margin of a limit or past it) if this value is ≥ 0.
        let limit = self.model.gap - margin;
        let excess = |x: f64| if side == 0.0 { x.abs() - limit } else { margin - side * x };
        if !first_clear || excess(g[0]) >= 0.0 {
            let span = interval.min(remaining);
            self.work.expansions += 1;
            let series = Series::<ANCHORED>::expand(&self.model, self.mode(), z, start.forces(), span);
            if let Some((u, side)) = self.first_event_from_start(&series, start, [true; 2], span) {
                let arrival = SeriesPoint { series: &series, base: 0.0, radius: span, u, interval: None };
                self.advance_to_point(z, start, &arrival);
                return Some(side);
            }
        }
        // Number of intervals in the step. An interval is searched if a sample at one of its ends
        // is near.
        let count = ((remaining / interval).ceil() as usize).min(INTERVALS);
        let nearest = g.iter().position(|&x| excess(x) >= 0.0)?;
        for i in nearest.max(1)..count {
            if excess(g[i]) < 0.0 && excess(g[i - 1]) < 0.0 {
                continue;
            }
            let (series, base) = self.centred(start, i);
            let radius = 0.5 * interval;
            let hi = ((remaining - base) / radius).min(1.0);
            let near = [g[i - 1].max(g[i]) >= limit, g[i - 1].min(g[i]) <= -limit];
            if let Some((u, side)) = self.first_event(&series.functional(self.mode()), -1.0, hi, near) {
                let arrival = SeriesPoint { series: &series, base, radius, u, interval: Some(i) };
                self.advance_to_point(z, start, &arrival);
                return Some(side);
            }
        }
        None
    }

    /// Series about the centre of an interval, and the time from the sub-step's start to it.
    #[inline(never)]
    pub(super) fn centred<const LOADS: usize>(
        &mut self,
        start: &SubstepStart<LOADS>,
        index: usize,
    ) -> (Series<CENTRED>, f64) {
        self.work.expansions += 1;
        let interval = self.interval();
        let base = (index as f64 + 0.5) * interval;
        let tables = self.tables();
        let mut z = [0.0; 8];
        SubstepTable::transit(&tables.core.centre[index], &start.z, &mut z);
        let forces = start.forces_after(base);
        if let Some(columns) = start.columns() {
            SubstepTable::transit(&tables.load.centre[index], &columns, &mut z);
        }
        if self.hybrid.contact != Contact::Flight {
            (z[RELATIVE], z[RELATIVE_RATE]) = (start.z[RELATIVE], 0.0);
        }
        (Series::expand(&self.model, self.mode(), &z, forces.as_ref(), 0.5 * interval), base)
    }

    /// First event between `lo` and `hi`, with its stop, from the coefficients of the event
    /// functional. `near` has the stops, upper and lower, that may be reached.
    #[inline(never)]
    fn first_event<const N: usize>(
        &mut self,
        functional: &[f64; N],
        lo: f64,
        hi: f64,
        near: [bool; 2],
    ) -> Option<(f64, f64)> {
        let iterations = &mut self.work.iterations;
        let side = self.hybrid.contact.side();
        if side != 0.0 {
            let p = functional.map(|a| -side * a);
            return first_crossing(&p, lo, hi, iterations).map(|u| (u, side));
        }
        let mut found: Option<(f64, f64)> = None;
        for (side, near) in [(1.0, near[0]), (-1.0, near[1])] {
            if near {
                let mut p = functional.map(|w| side * w);
                p[0] -= self.model.gap;
                // Rest has no such check, because forces may cancel and their difference has no
                // scale.
                debug_assert!(
                    value(&p, lo)
                        <= START_ROUNDING * (self.model.gap + p.iter().map(|x| x.abs()).sum::<f64>()),
                    "the block is beyond a stop where a search begins: {p:?}"
                );
                // The search goes up to `hi` even beyond a passage of the other stop, so that a
                // motion and its mirror image have the same bits.
                if let Some(u) = first_crossing(&p, lo, hi, iterations)
                    && found.is_none_or(|(first, _)| u < first)
                {
                    found = Some((u, side));
                }
            }
        }
        found
    }

    /// First event on a series about the sub-step's start, with its stop. If the block is leaving
    /// a stop at the start, the roots at the start are divided out, so that a return is found
    /// however soon it comes.
    #[inline(never)]
    pub(super) fn first_event_from_start<const LOADS: usize>(
        &mut self,
        series: &Series<ANCHORED>,
        start: &SubstepStart<LOADS>,
        near: [bool; 2],
        span: f64,
    ) -> Option<(f64, f64)> {
        let order = usize::from(self.hybrid.departing);
        if order == 0 {
            let mut functional = series.functional(self.mode());
            if self.hybrid.contact != Contact::Flight {
                self.divide_where_pressed(&mut functional, &start.z);
            }
            return self.first_event(&functional, 0.0, 1.0, near);
        }
        let side = start.z[RELATIVE].signum();
        let mut found = None;
        if order > 1 || start.z[RELATIVE_RATE].abs() <= 0.5 * start.bound * span {
            let p = series.excess_polynomial(side, self.model.gap);
            let mut q = [0.0; ANCHORED];
            q[..ANCHORED - order].copy_from_slice(&p[order..]);
            q[0] = q[0].min(-f64::MIN_POSITIVE); // it leaves, whatever round-off says
            found = first_crossing(&q, 0.0, 1.0, &mut self.work.iterations).map(|u| (u, side));
        }
        if near[usize::from(side > 0.0)] {
            let p = series.excess_polynomial(-side, self.model.gap);
            let hi = found.map_or(1.0, |(u, _)| u);
            let other = first_crossing(&p, 0.0, hi, &mut self.work.iterations);
            found = other.map(|u| (u, -side)).or(found);
        }
        found
    }

    /// Divides a contact force that is within rounding at the start by uᵏ, where k is the order of
    /// its first derivative beyond rounding. This is done if that derivative presses the block to
    /// the stop, since the force then does not fall through zero at the start. This order also
    /// decides on a departure, so that both decisions agree.
    fn divide_where_pressed(&self, functional: &mut [f64; ANCHORED], z: &Augmented) {
        let side = self.hybrid.contact.side();
        if side * functional[0] > functional[1..].iter().map(|a| a.abs()).sum() {
            return; // pressed throughout
        }
        let (series, certain) = self.flight_from_stop(z);
        if let Some(order) = certain
            && side * series.free[order - 2] > 0.0
        {
            functional.rotate_left(order - 2);
            functional[ANCHORED + 2 - order..].fill(0.0);
        }
    }

    /// Moves to a point of a series: state, time and energy accounts.
    #[inline(never)]
    pub(super) fn advance_to_point<const LOADS: usize, const N: usize>(
        &mut self,
        z: &mut Augmented,
        start: &SubstepStart<LOADS>,
        to: &SeriesPoint<N>,
    ) {
        if self.keeps_energy_accounts {
            self.account(start, to);
        }
        let short = to.interval.is_none() && to.radius < SHORT * self.interval();
        *z = if short { to.series.after_way(to.u) } else { to.series.at(to.u) };
        if self.hybrid.contact != Contact::Flight {
            (z[RELATIVE], z[RELATIVE_RATE]) = (start.z[RELATIVE], 0.0);
        }
        self.hybrid.time = self.hybrid.time.plus(to.base).plus(to.u * to.radius);
        self.hybrid.departing = 0;
    }

    /// Moves over a whole sub-step without event.
    #[inline(always)]
    pub(super) fn advance_whole_substep<const LOADS: usize>(
        &mut self,
        z: &mut Augmented,
        start: &SubstepStart<LOADS>,
    ) {
        if self.keeps_energy_accounts {
            self.account_whole(start);
        }
        let tables = self.tables();
        let mut next = [0.0; 8];
        SubstepTable::transit(&tables.core.full, &start.z, &mut next);
        if let Some(columns) = start.columns() {
            SubstepTable::transit(&tables.load.full, &columns, &mut next);
        }
        if self.hybrid.contact != Contact::Flight {
            (next[RELATIVE], next[RELATIVE_RATE]) = (start.z[RELATIVE], 0.0);
        }
        *z = next;
        self.hybrid.time = self.hybrid.time.plus(self.substep);
        self.hybrid.departing = 0;
    }
}
