//! One sub-step of all active lanes: free flight over a whole sub-step, or through its first
//! impact.

use super::centres::Centres;
use super::passage::{CentredFlights, REACH};
use super::rows::{LaneStates, LaneSystems, SubstepStarts};
use super::{LaneSet, lanes_of};
use crate::flow::INTERVALS;
use crate::model::{BOX, BOX_RATE, DRIVE_COS, DRIVE_SIN, RELATIVE, RELATIVE_RATE, SECONDARY, SECONDARY_RATE};
use crate::simulator::batch::vectors::{LaneRow, Mask, Wide, WideDoubleDouble};
use pulp::Simd;

/// Results of a sub-step of all lanes, and the lanes that it leaves to the code for a single
/// motion.
pub(super) struct Progress {
    /// Lanes that have moved.
    pub(super) moved: LaneSet,
    /// Lanes that have moved up to an impact and had its law applied.
    pub(super) through: LaneSet,
    /// Lanes that have not moved, as the proof of the common case failed.
    pub(super) unproved: LaneSet,
    /// Lanes that have moved to an impact that may end in rest; its law is not yet applied.
    pub(super) at_stop: LaneSet,
}

/// Advances each of the `active` motions by a sub-step, to its end or through its first impact.
/// `starts` receives the starts of the motions that are in `reading` and move.
#[inline(always)]
pub(super) fn flight_substep<S: Simd>(
    simd: S,
    systems: &LaneSystems,
    states: &mut LaneStates,
    searched: &mut SearchedIntervals,
    (active, reading): (LaneSet, LaneSet),
    starts: &mut SubstepStarts,
) -> Progress {
    let lanes = S::F64_LANES;
    let (mut ready, mut near, mut near_start) = (0, 0, 0);
    // Lanes of the first vector.
    let part: LaneSet = (1 << lanes) - 1;
    for v in 0..LaneRow::vectors::<S>() {
        if active >> (v * lanes) & part == 0 {
            continue;
        }
        let samples = sample_displacement(simd, systems, states, v, searched);
        ready |= samples.ready.bits() << (v * lanes);
        near |= samples.near.bits() << (v * lanes);
        near_start |= samples.near_start.bits() << (v * lanes);
    }
    ready &= active;
    let passing = ready & !near;
    let searching = near & ready;
    for lane in lanes_of(searching & !near_start) {
        let interval = searched.index.0[lane] as usize;
        searched.centres.put(simd, systems, lane, interval, &states.z);
    }
    let (mut arrived, mut at_stop, mut through) = (0, 0, 0);
    for v in 0..LaneRow::vectors::<S>() {
        if (passing | searching) & reading & part << (v * lanes) != 0 {
            starts.copy(simd, states, v);
        }
        if passing >> (v * lanes) & part != 0 {
            advance_whole_substep(simd, systems, states, v, passing >> (v * lanes) & part);
        }
        if searching >> (v * lanes) & part != 0 {
            let chosen = (searching >> (v * lanes) & part, near_start >> (v * lanes) & part);
            let found = advance_in_interval(simd, systems, states, v, searched, chosen);
            arrived |= found.moved << (v * lanes);
            at_stop |= found.at_stop << (v * lanes);
            through |= found.through << (v * lanes);
        }
    }
    let unproved = active & !ready | searching & !arrived;
    Progress { moved: passing | arrived, through, unproved, at_stop }
}

/// Interval to be searched, for each motion: the first one with its block near a stop.
pub(super) struct SearchedIntervals {
    /// Index of the interval; [`INTERVALS`] if there is none.
    index: LaneRow,
    /// Stop, +1 or -1.
    pub(super) side: LaneRow,
    /// State at the interval's centre.
    centres: Centres,
}

impl SearchedIntervals {
    pub(super) fn zero<S: Simd>(simd: S) -> Self {
        Self { index: LaneRow::ZERO, side: LaneRow::ZERO, centres: Centres::new(simd) }
    }
}

/// Findings from the samples of w over a sub-step.
struct DisplacementSamples<S: Simd> {
    /// Flight that starts inside or has just left a stop, with at least a sub-step and an interval
    /// left.
    ready: Mask<S>,
    /// An interval is to be searched, since w at one of its ends is near a stop.
    near: Mask<S>,
    /// The search begins at the start of the sub-step.
    near_start: Mask<S>,
}

/// Samples w at the ends of the intervals, as `Simulator::sample_displacement` does. If a block is
/// farther from the stops at both ends of an interval than its path can bend, it does not reach
/// them in the interval.
#[inline(always)]
fn sample_displacement<S: Simd>(
    simd: S,
    systems: &LaneSystems,
    states: &LaneStates,
    v: usize,
    searched: &mut SearchedIntervals,
) -> DisplacementSamples<S> {
    let load = |row: &LaneRow| Wide::load(simd, row, v);
    let splat = |x| Wide::splat(simd, x);
    let zero = splat(0.0);
    let z = Wide::load_each(simd, &states.z, v);
    let bound = acceleration_bound(simd, systems, v, &z);
    let interval = load(&systems.interval);
    // Largest change of w' within half an interval.
    let change = splat(0.5) * bound * interval;
    let limit = (change * interval).neg_mul_add(splat(0.25), load(&systems.gap));
    let departing = load(&states.departing);
    let inside = departing.at_most(zero);
    let speed = z[RELATIVE_RATE].abs();
    let leaving = !inside & departing.at_most(splat(1.0));
    let within_reach = (speed * interval + change * interval).at_most(load(&systems.reach));
    let remaining =
        (load(&systems.end[0]) - load(&states.time[0])) + (load(&systems.end[1]) - load(&states.time[1]));
    // One interval more than the sub-step, since a search may carry the motion past the sub-step's
    // end.
    let whole = (load(&systems.substep) + interval).at_most(remaining);

    let mut index = splat(INTERVALS as f64);
    let mut gap = zero;
    for i in (0..INTERVALS).rev() {
        let g = Wide::dot(simd, &systems.sample[i], v, &z);
        let near = limit.at_most(g.abs());
        index = near.select(splat(i as f64), index);
        gap = near.select(g, gap);
    }
    index.store(&mut searched.index, v);
    // The search begins at the start if the block leaves a stop so slowly that it may return in
    // the first interval or is still near the stop at the interval's end.
    let near_start = (leaving & (speed.at_most(change) | index.at_most(zero)))
        | (inside & limit.at_most(z[RELATIVE].abs()));
    let nearest = near_start.select(z[RELATIVE], gap);
    zero.less_than(nearest).select(splat(1.0), splat(-1.0)).store(&mut searched.side, v);
    DisplacementSamples {
        ready: (leaving | inside) & within_reach & whole,
        near: near_start | index.less_than(splat(INTERVALS as f64)),
        near_start,
    }
}

/// Bound on |w''| over a sub-step from the state `z`.
#[inline(always)]
fn acceleration_bound<S: Simd>(simd: S, systems: &LaneSystems, v: usize, z: &[Wide<S>; 8]) -> Wide<S> {
    let mut sizes = *z;
    for size in &mut sizes {
        *size = size.abs();
    }
    Wide::dot(simd, &systems.bound, v, &sizes)
}

/// Advances the motions `chosen` in vector `v` by a whole sub-step without an impact.
#[inline(always)]
fn advance_whole_substep<S: Simd>(
    simd: S,
    systems: &LaneSystems,
    states: &mut LaneStates,
    v: usize,
    chosen: LaneSet,
) {
    let load = |row: &LaneRow| Wide::load(simd, row, v);
    let chosen = Mask::from_bits(simd, chosen);
    let z = Wide::load_each(simd, &states.z, v);
    let driven = [z[BOX], z[BOX_RATE], z[DRIVE_COS], z[DRIVE_SIN]];
    let moving = [z[0], z[1], z[2], z[3], z[4], z[5]];
    let drive = [z[DRIVE_COS], z[DRIVE_SIN]];
    let full = &systems.full;
    for (k, [a, b, c]) in
        [[BOX, RELATIVE, SECONDARY], [BOX_RATE, RELATIVE_RATE, SECONDARY_RATE]].into_iter().enumerate()
    {
        chosen.select(Wide::dot(simd, &full.driven[k], v, &driven), z[a]).store(&mut states.z[a], v);
        chosen.select(Wide::dot(simd, &full.relative[k], v, &z), z[b]).store(&mut states.z[b], v);
        chosen.select(Wide::dot(simd, &full.secondary[k], v, &moving), z[c]).store(&mut states.z[c], v);
    }
    for (k, j) in [DRIVE_COS, DRIVE_SIN].into_iter().enumerate() {
        chosen.select(Wide::dot(simd, &full.drive[k], v, &drive), z[j]).store(&mut states.z[j], v);
    }
    let time = WideDoubleDouble::load(simd, &states.time, v);
    let later = time.plus(load(&systems.substep));
    later.store_where(chosen, time, &mut states.time, v);
    let zero = Wide::splat(simd, 0.0);
    chosen.select(zero, load(&states.departing)).store(&mut states.departing, v);
    count_substep(simd, states, v, chosen);
}

/// Counts a sub-step of the motions `chosen`.
#[inline(always)]
fn count_substep<S: Simd>(simd: S, states: &mut LaneStates, v: usize, chosen: Mask<S>) {
    let zero = Wide::splat(simd, 0.0);
    let one = chosen.select(Wide::splat(simd, 1.0), zero);
    add(simd, &mut states.since_renewal, v, one);
    add(simd, &mut states.substeps, v, one);
}

/// Adds to vector `v` of a row.
#[inline(always)]
fn add<S: Simd>(simd: S, row: &mut LaneRow, v: usize, more: Wide<S>) {
    (Wide::load(simd, row, v) + more).store(row, v);
}

/// Advances the motions `chosen` in vector `v` through the impact in their searched interval if it
/// is proved to be the first, or past the interval if it is proved free of impacts. For motions in
/// `near_start` the search begins at the start of the sub-step.
#[inline(always)]
fn advance_in_interval<S: Simd>(
    simd: S,
    systems: &LaneSystems,
    states: &mut LaneStates,
    v: usize,
    searched: &SearchedIntervals,
    (chosen, near_start): (LaneSet, LaneSet),
) -> IntervalProgress {
    let load = |row: &LaneRow| Wide::load(simd, row, v);
    let splat = |x| Wide::splat(simd, x);
    let (zero, half, one) = (splat(0.0), splat(0.5), splat(1.0));
    let now = Wide::load_each(simd, &states.z, v);
    let departing = load(&states.departing);
    let arrival = arrive(simd, systems, v, searched, (chosen, near_start), &now, departing);
    let side = load(&searched.side);
    let rebound = rebound(simd, systems, v, side, &arrival.z);
    // Rest, and chatter that may have to be closed, are left to `Simulator::apply_event_law`.
    let slow = load(&systems.closing) * acceleration_bound(simd, systems, v, &rebound.z);
    let through = arrival.found & slow.less_than(rebound.speed * rebound.speed);
    let moved = arrival.found | arrival.stays_inside;
    for (j, row) in states.z.iter_mut().enumerate() {
        moved.select(through.select(rebound.z[j], arrival.z[j]), now[j]).store(row, v);
    }
    let interval = load(&systems.interval);
    let time = WideDoubleDouble::load(simd, &states.time, v);
    let centre = arrival.about_start.select(zero, (load(&searched.index) + half) * interval);
    let later = time.plus(centre).plus(arrival.u * (half * interval));
    later.store_where(moved, time, &mut states.time, v);
    moved.select(through.select(one, zero), departing).store(&mut states.departing, v);
    count_substep(simd, states, v, moved);
    add(simd, &mut states.expansions, v, moved.select(one, zero));
    add(simd, &mut states.iterations, v, arrival.found.select(arrival.iterations, zero));
    record_impact(simd, systems, states, v, through, (side, rebound.approach), later);
    IntervalProgress {
        moved: moved.bits(),
        through: through.bits(),
        at_stop: (arrival.found & !through).bits(),
    }
}

/// Results of the search of an interval, as in [`Progress`], for the lanes of one vector.
struct IntervalProgress {
    moved: LaneSet,
    through: LaneSet,
    at_stop: LaneSet,
}

/// Arrivals of the flights in a searched interval.
struct Arrival<S: Simd> {
    /// The flight is expanded about the start of the sub-step instead of the interval's centre.
    about_start: Mask<S>,
    /// An impact is found, and proved to be the first.
    found: Mask<S>,
    /// Whether it is proved that no impact occurs.
    stays_inside: Mask<S>,
    /// Time of arrival since the centre of the expansion, in half intervals.
    u: Wide<S>,
    /// State at the arrival, before the law of an impact.
    z: [Wide<S>; 8],
    /// Numbers of Newton steps.
    iterations: Wide<S>,
}

/// Finds the first impact in the searched interval, or proves that there is none. Without an
/// impact the flight continues up to [`REACH`].
#[inline(always)]
fn arrive<S: Simd>(
    simd: S,
    systems: &LaneSystems,
    v: usize,
    searched: &SearchedIntervals,
    (chosen, near_start): (LaneSet, LaneSet),
    now: &[Wide<S>; 8],
    departing: Wide<S>,
) -> Arrival<S> {
    let splat = |x| Wide::splat(simd, x);
    let zero = splat(0.0);
    // If the flight starts near a stop, it is expanded about the start. If the block leaves the
    // stop, the zero at the start is divided out.
    let about_start = Mask::from_bits(simd, near_start);
    let mut centre = searched.centres.load(simd, v);
    for (centre, now) in centre.iter_mut().zip(now) {
        *centre = about_start.select(*now, *centre);
    }
    let (side, gap) = (Wide::load(simd, &searched.side, v), Wide::load(simd, &systems.gap, v));
    let flights = CentredFlights::expand(simd, systems, v, &centre);
    let mut excess = flights.excess(side, gap);
    if near_start != 0 {
        excess.divide_by_u(about_start & zero.less_than(departing));
    }
    let from = about_start.select(zero, splat(-1.0));
    let crossing = excess.upward_crossing(from, gap);
    let mut stays = 0;
    if chosen & !crossing.found.bits() != 0 {
        stays = chosen & !crossing.found.bits() & excess.stays_negative(from, gap).bits();
    }
    let stays_inside = Mask::from_bits(simd, stays);
    let u = stays_inside.select(splat(REACH), crossing.u);
    let z = flights.state_at(systems, simd, v, u);
    let found = Mask::from_bits(simd, chosen) & crossing.found;
    Arrival { about_start, found, stays_inside, u, z, iterations: crossing.iterations }
}

/// Results of the impact law.
struct Rebound<S: Simd> {
    /// Approach speed |w'⁻|.
    approach: Wide<S>,
    /// Rebound speed |w'⁺|.
    speed: Wide<S>,
    /// State after the impact.
    z: [Wide<S>; 8],
}

/// Impact law, docs/theory.md (11), for states `z` at the stops `side`: `Model::impact` for
/// vectors of systems. `second_method_together_as_one_by_one` in tests/batch.rs compares the two.
#[inline(always)]
fn rebound<S: Simd>(simd: S, systems: &LaneSystems, v: usize, side: Wide<S>, z: &[Wide<S>; 8]) -> Rebound<S> {
    let load = |row: &LaneRow| Wide::load(simd, row, v);
    let mut z = *z;
    // An approach speed that is negative by round-off is set to zero: a touch.
    let approach = (side * z[RELATIVE_RATE]).max(Wide::splat(simd, 0.0));
    let speed = load(&systems.restitution) * approach;
    z[BOX_RATE] = (side * load(&systems.kick)).mul_add(approach, z[BOX_RATE]);
    z[RELATIVE_RATE] = -(side * speed);
    z[RELATIVE] = side * load(&systems.gap);
    Rebound { approach, speed, z }
}

/// Records the impacts of the motions `through` at `time`, with their stop and approach speed: the
/// energy lost, docs/theory.md (12), and the fields of `ImpactRecord`, as `ImpactRecord::count`.
#[inline(always)]
fn record_impact<S: Simd>(
    simd: S,
    systems: &LaneSystems,
    states: &mut LaneStates,
    v: usize,
    through: Mask<S>,
    (side, approach): (Wide<S>, Wide<S>),
    time: WideDoubleDouble<S>,
) {
    let load = |row: &LaneRow| Wide::load(simd, row, v);
    let (zero, one) = (Wide::splat(simd, 0.0), Wide::splat(simd, 1.0));
    let lost = WideDoubleDouble::load(simd, &states.lost, v);
    let more = lost.plus(load(&systems.loss) * approach * approach);
    more.store_where(through, lost, &mut states.lost, v);
    let impulse = load(&systems.impulse) * approach;
    through.select(time.hi + time.lo, load(&states.last_time)).store(&mut states.last_time, v);
    through.select(approach, load(&states.last_speed)).store(&mut states.last_speed, v);
    through.select(impulse, load(&states.last_impulse)).store(&mut states.last_impulse, v);
    add(simd, &mut states.total_impulse, v, through.select(impulse, zero));
    add(simd, &mut states.box_impulse, v, through.select(side * impulse, zero));
    let upper = zero.less_than(side);
    add(simd, &mut states.upper, v, (through & upper).select(one, zero));
    add(simd, &mut states.lower, v, (through & !upper).select(one, zero));
}
