//! A sub-step of all motions under way at once.

use super::passage::{Flights, REACH};
use super::rows::{LaneStates, LaneSystems};
use super::{Places, places};
use crate::flow::INTERVALS;
use crate::model::{GAP, GAP_RATE};
use crate::numerics::simd::product;
use crate::simulator::batch::vectors::{Mask, Row, Wide, WideDoubleDouble};
use pulp::Simd;

/// What a sub-step leaves to the motions' own code.
pub(super) struct Left {
    /// They stay where they are: the proof of the common case fails.
    pub(super) behind: Places,
    /// They stand before an impact that ends in rest, or may.
    pub(super) touching: Places,
    /// The stop that they touch.
    pub(super) side: Row,
}

/// Takes each of the motions at `live` a sub-step on, to its end or through its first impact.
#[inline(always)]
pub(super) fn substep<S: Simd>(
    simd: S,
    systems: &LaneSystems,
    moving: &mut LaneStates,
    live: Places,
) -> Left {
    let lanes = S::F64_LANES;
    let mut aim = LocatedImpact { first: Row::ZERO, side: Row::ZERO, centre: [Row::ZERO; 8] };
    let (mut ready, mut near, mut close) = (0, 0, 0);
    let part = (1 << lanes) - 1;
    for v in 0..Row::vectors::<S>() {
        if live >> (v * lanes) & part == 0 {
            continue;
        }
        let seen = sample_gap(simd, systems, moving, v, &mut aim);
        ready |= seen.ready.bits() << (v * lanes);
        near |= seen.near.bits() << (v * lanes);
        close |= seen.close.bits() << (v * lanes);
    }
    ready &= live;
    let aiming = near & ready;
    let passing = ready & !near;
    for lane in places(aiming & !close) {
        let Some(tables) = &systems.tables[lane] else { continue };
        let mut z = [0.0; 8];
        for (z, row) in z.iter_mut().zip(&moving.z) {
            *z = row.0[lane];
        }
        let there = product(simd, &tables.core.centre[aim.first.0[lane] as usize % INTERVALS], &z);
        for (row, there) in aim.centre.iter_mut().zip(there) {
            row.0[lane] = there;
        }
    }
    let (mut arrived, mut touching) = (0, 0);
    for v in 0..Row::vectors::<S>() {
        if passing >> (v * lanes) & part != 0 {
            advance_whole_substep(simd, systems, moving, v, passing >> (v * lanes) & part);
        }
        if aiming >> (v * lanes) & part != 0 {
            let (bits, close) = (aiming >> (v * lanes) & part, close >> (v * lanes) & part);
            let (there, touch) = impact(simd, systems, moving, v, &aim, bits, close);
            arrived |= there << (v * lanes);
            touching |= touch << (v * lanes);
        }
    }
    Left { behind: live & !(passing | arrived), touching, side: aim.side }
}

/// Where the gap comes near a stop first.
struct LocatedImpact {
    /// The interval.
    first: Row,
    side: Row,
    /// The state at its centre.
    centre: [Row; 8],
}

/// What the samples of a sub-step tell.
struct GapSamples<S: Simd> {
    /// Flight from inside or just off a stop, with a whole sub-step to go.
    ready: Mask<S>,
    /// There is an interval with a near end.
    near: Mask<S>,
    /// The start is such an end.
    close: Mask<S>,
}

/// As `Simulator::sample_gap`.
#[inline(always)]
fn sample_gap<S: Simd>(
    simd: S,
    systems: &LaneSystems,
    moving: &LaneStates,
    v: usize,
    aim: &mut LocatedImpact,
) -> GapSamples<S> {
    let of = |row: &Row| Wide::of(simd, row, v);
    let splat = |x| Wide::splat(simd, x);
    let zero = splat(0.0);
    let z = Wide::of_each(simd, &moving.z, v);
    let bound = bound(simd, systems, v, &z);
    let interval = of(&systems.interval);
    let turned = splat(0.5) * bound * interval;
    let limit = (turned * interval).neg_mul_add(splat(0.25), of(&systems.gap));
    let departing = of(&moving.departing);
    let inside = departing.at_most(zero);
    let speed = z[GAP_RATE].abs();
    let leaving = !inside & departing.at_most(splat(1.0));
    let tame = (speed * interval + turned * interval).at_most(of(&systems.reach));
    let remaining = (of(&systems.end[0]) - of(&moving.time[0])) + (of(&systems.end[1]) - of(&moving.time[1]));
    // With an interval to spare: a passage may lie that far behind the sub-step.
    let whole = (of(&systems.substep) + interval).at_most(remaining);

    let mut index = splat(INTERVALS as f64);
    let mut gap = zero;
    for i in (0..INTERVALS).rev() {
        let g = Wide::dot(simd, &systems.sample[i], v, &z);
        let near = limit.at_most(g.abs());
        index = near.select(splat(i as f64), index);
        gap = near.select(g, gap);
    }
    index.put(&mut aim.first, v);
    // Off a stop it may be too slow to be sure of leaving the first interval, or of leaving its end far behind.
    let close =
        (leaving & (speed.at_most(turned) | index.at_most(zero))) | (inside & limit.at_most(z[GAP].abs()));
    let at = close.select(z[GAP], gap);
    zero.less(at).select(splat(1.0), splat(-1.0)).put(&mut aim.side, v);
    GapSamples {
        ready: (leaving | inside) & tame & whole,
        near: close | index.less(splat(INTERVALS as f64)),
        close,
    }
}

/// The bound on |w''| over a sub-step.
#[inline(always)]
fn bound<S: Simd>(simd: S, systems: &LaneSystems, v: usize, z: &[Wide<S>; 8]) -> Wide<S> {
    let mut sizes = *z;
    for size in &mut sizes {
        *size = size.abs();
    }
    Wide::dot(simd, &systems.bound, v, &sizes)
}

/// The motions among `bits` pass over a whole sub-step.
#[inline(always)]
fn advance_whole_substep<S: Simd>(
    simd: S,
    systems: &LaneSystems,
    moving: &mut LaneStates,
    v: usize,
    bits: Places,
) {
    let of = |row: &Row| Wide::of(simd, row, v);
    let chosen = Mask::of(simd, bits);
    let z = Wide::of_each(simd, &moving.z, v);
    for ((row, before), full) in moving.z.iter_mut().zip(z).zip(&systems.full) {
        chosen.select(Wide::dot(simd, full, v, &z), before).put(row, v);
    }
    let time = WideDoubleDouble { hi: of(&moving.time[0]), lo: of(&moving.time[1]) };
    let later = time.plus(of(&systems.substep));
    chosen.select(later.hi, time.hi).put(&mut moving.time[0], v);
    chosen.select(later.lo, time.lo).put(&mut moving.time[1], v);
    let zero = Wide::splat(simd, 0.0);
    chosen.select(zero, of(&moving.departing)).put(&mut moving.departing, v);
    count(simd, moving, v, chosen);
}

/// Counts a sub-step.
#[inline(always)]
fn count<S: Simd>(simd: S, moving: &mut LaneStates, v: usize, chosen: Mask<S>) {
    let zero = Wide::splat(simd, 0.0);
    let one = chosen.select(Wide::splat(simd, 1.0), zero);
    add(simd, &mut moving.since, v, one);
    add(simd, &mut moving.substeps, v, one);
}

#[inline(always)]
fn add<S: Simd>(simd: S, row: &mut Row, v: usize, more: Wide<S>) {
    (Wide::of(simd, row, v) + more).put(row, v);
}

/// The motions among `bits` go through their impact, if it is proved, or past the stop, if that is. Returns
/// those that are there, and those of them that have the law of the impact yet before them.
#[inline(always)]
fn impact<S: Simd>(
    simd: S,
    systems: &LaneSystems,
    moving: &mut LaneStates,
    v: usize,
    aim: &LocatedImpact,
    bits: Places,
    close: Places,
) -> (Places, Places) {
    let of = |row: &Row| Wide::of(simd, row, v);
    let splat = |x| Wide::splat(simd, x);
    let (zero, half) = (splat(0.0), splat(0.5));
    // From a start close to a stop the first part of the flight is expanded about the start itself; off the stop, the root
    // there is divided out.
    let start = Mask::of(simd, close);
    let mut departing = of(&moving.departing);
    let now = Wide::of_each(simd, &moving.z, v);
    let mut centre = Wide::of_each(simd, &aim.centre, v);
    for (centre, now) in centre.iter_mut().zip(now) {
        *centre = start.select(now, *centre);
    }
    let (side, gap) = (of(&aim.side), of(&systems.gap));
    let flights = Flights::expand(simd, systems, v, &centre);
    let mut paths = flights.paths(side, gap);
    if close != 0 {
        paths.divide(start & zero.less(departing));
    }
    let from = start.select(zero, splat(-1.0));
    let crossing = paths.crossing(from, gap);
    // Where there is none the flight goes on to the end of what is known of it.
    let mut stays = 0;
    if bits & !crossing.found.bits() != 0 {
        stays = bits & !crossing.found.bits() & paths.stay(from, gap).bits();
    }
    let (u, stays) = (crossing.u, Mask::of(simd, stays));
    let u = stays.select(splat(REACH), u);
    let mut z = flights.at(systems, simd, v, u);
    let before = z;
    // The law of `Model::impact`; a root whose speed round-off has turned negative is a touch.
    let speed = (side * z[GAP_RATE]).max(zero);
    let rebound = of(&systems.restitution) * speed;
    z[3] = (side * of(&systems.kick)).mul_add(speed, z[3]);
    z[GAP_RATE] = -(side * rebound);
    z[GAP] = side * gap;
    // Rest, and chatter that may be at its end, are left to `Simulator::apply_event_law`.
    let slow = of(&systems.closing) * bound(simd, systems, v, &z);
    let found = Mask::of(simd, bits) & crossing.found;
    let through = found & slow.less(rebound * rebound);
    let chosen = found | stays;
    for (j, row) in moving.z.iter_mut().enumerate() {
        chosen.select(through.select(z[j], before[j]), now[j]).put(row, v);
    }
    let interval = of(&systems.interval);
    let time = WideDoubleDouble { hi: of(&moving.time[0]), lo: of(&moving.time[1]) };
    let base = start.select(zero, (of(&aim.first) + half) * interval);
    let later = time.plus(base).plus(u * (half * interval));
    chosen.select(later.hi, time.hi).put(&mut moving.time[0], v);
    chosen.select(later.lo, time.lo).put(&mut moving.time[1], v);
    let one = splat(1.0);
    departing = chosen.select(through.select(one, zero), departing);
    departing.put(&mut moving.departing, v);
    count(simd, moving, v, chosen);
    add(simd, &mut moving.expansions, v, chosen.select(one, zero));
    add(simd, &mut moving.iterations, v, found.select(crossing.iterations, zero));

    let lost = WideDoubleDouble { hi: of(&moving.lost[0]), lo: of(&moving.lost[1]) };
    let more = lost.plus(of(&systems.loss) * speed * speed);
    through.select(more.hi, lost.hi).put(&mut moving.lost[0], v);
    through.select(more.lo, lost.lo).put(&mut moving.lost[1], v);
    let impulse = of(&systems.impulse) * speed;
    through.select(later.hi + later.lo, of(&moving.last_time)).put(&mut moving.last_time, v);
    through.select(speed, of(&moving.last_speed)).put(&mut moving.last_speed, v);
    through.select(impulse, of(&moving.last_impulse)).put(&mut moving.last_impulse, v);
    add(simd, &mut moving.total_impulse, v, through.select(impulse, zero));
    let above = zero.less(side);
    add(simd, &mut moving.upper, v, (through & above).select(one, zero));
    add(simd, &mut moving.lower, v, (through & !above).select(one, zero));
    (chosen.bits(), (found & !through).bits())
}
