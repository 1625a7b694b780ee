//! Numbers of the motions under way, in rows: each row holds one number of every motion.

use super::LaneSet;
use super::transition::LaneTransitions;
use crate::flow::{CORE, INTERVALS, SubstepTable};
use crate::model::{Augmented, DRIVE_COS, DRIVE_SIN, ImpactFactors};
use crate::parameters::Parameters;
use crate::simulator::batch::vectors::{LaneRow, ROW, Wide};
use crate::simulator::general::MAX_REACH;
use crate::simulator::step::AdvanceState;
use crate::simulator::tables::ModeTables;
use crate::simulator::{Contact, Simulator};
use pulp::Simd;
use std::sync::Arc;
use vibro_numerics::double_double::DoubleDouble;

/// Value of `departing` for a motion that lanes cannot advance: a motion in rest, or within
/// rounding of a departure. It is larger than any order of departure.
const GROUNDED: f64 = f64::INFINITY;

/// Numbers that are constant while a motion is under way.
pub(super) struct LaneSystems {
    /// Parameters for which each lane is filled. A motion with equal parameters need not fill it
    /// again.
    parameters: [Option<Parameters>; ROW],
    /// Tables of the motion in each lane.
    tables: [Option<Arc<ModeTables>>; ROW],
    /// Weights of the coordinates in w at the end of each interval.
    pub(super) sample: [[LaneRow; 8]; INTERVALS],
    /// Transition matrix over a whole sub-step.
    pub(super) full: LaneTransitions,
    /// Weights of the coordinates' sizes in the bound on |w''| over a sub-step.
    pub(super) bound: [LaneRow; 8],
    /// End of the advance, leading and trailing part, s.
    pub(super) end: [LaneRow; 2],
    /// Length of a sub-step, s.
    pub(super) substep: LaneRow,
    /// Length of an interval, s.
    pub(super) interval: LaneRow,
    /// Gap L, m.
    pub(super) gap: LaneRow,
    /// Limit for the block's path in an interval, m, as in `Simulator::exceeds_reach`; up to it
    /// the interval is searched as a whole.
    pub(super) reach: LaneRow,
    /// Limit for the squared rebound speed over the acceleration, m, below which a chatter run is
    /// closed: `Simulator::chatter_closing_limit`.
    pub(super) closing: LaneRow,
    /// Coefficient of restitution κ.
    pub(super) restitution: LaneRow,
    /// Change of the box's velocity divided by the approach speed, as in `Model::impact_factors`.
    pub(super) kick: LaneRow,
    /// Impulse divided by the approach speed, kg, as in `Model::impact_factors`.
    pub(super) impulse: LaneRow,
    /// Energy lost divided by the squared approach speed, kg, as in `Model::impact_factors`.
    pub(super) loss: LaneRow,
    /// Half an interval, s: the unit of time of the coefficients below, the coefficients of
    /// docs/theory.md (6) and the drive's frequency.
    pub(super) radius: LaneRow,
    pub(super) k1: LaneRow,
    pub(super) c1: LaneRow,
    pub(super) drive: LaneRow,
    pub(super) k2: LaneRow,
    pub(super) k3: LaneRow,
    pub(super) c3: LaneRow,
    pub(super) k32: LaneRow,
    pub(super) omega: LaneRow,
}

impl LaneSystems {
    pub(super) fn zero() -> Self {
        let row = LaneRow::ZERO;
        Self {
            parameters: [None; ROW],
            tables: [const { None }; ROW],
            sample: [[row; 8]; INTERVALS],
            full: LaneTransitions::ZERO,
            bound: [row; 8],
            end: [row; 2],
            substep: row,
            interval: row,
            gap: row,
            reach: row,
            closing: row,
            restitution: row,
            kick: row,
            impulse: row,
            loss: row,
            radius: row,
            k1: row,
            c1: row,
            drive: row,
            k2: row,
            k3: row,
            c3: row,
            k32: row,
            omega: row,
        }
    }

    /// Releases the tables of the motion in a lane, so that its simulator can refill them for
    /// another system without a copy.
    pub(super) fn release_tables(&mut self, lane: usize) {
        self.tables[lane] = None;
    }

    /// Table of flight of the motion in a lane, if there is a motion.
    #[inline(always)]
    pub(super) fn table(&self, lane: usize) -> Option<&SubstepTable<CORE>> {
        self.tables[lane].as_deref().map(|tables| &tables.core)
    }

    /// Fills a lane for a motion to `end`.
    pub(super) fn load_system(&mut self, lane: usize, simulator: &Simulator, end: DoubleDouble) {
        (self.end[0].0[lane], self.end[1].0[lane]) = (end.hi, end.lo);
        self.tables[lane] = Some(Arc::clone(&simulator.flight));
        if self.parameters[lane] == Some(simulator.parameters) {
            return;
        }
        self.parameters[lane] = Some(simulator.parameters);
        let core = &simulator.flight.core;
        for j in 0..8 {
            for i in 0..INTERVALS {
                self.sample[i][j].0[lane] = core.sample[j][i];
            }
            self.bound[j].0[lane] = core.bound[j];
        }
        self.full.load(lane, &core.full);
        let interval = simulator.interval();
        let r = 0.5 * interval;
        let m = &simulator.model;
        let ImpactFactors { kick, impulse, loss } = m.impact_factors();
        for (row, value) in [
            (&mut self.substep, simulator.substep),
            (&mut self.interval, interval),
            (&mut self.gap, m.gap),
            (&mut self.reach, MAX_REACH * m.gap),
            (&mut self.closing, simulator.chatter_closing_limit()),
            (&mut self.restitution, m.restitution),
            (&mut self.kick, kick),
            (&mut self.impulse, impulse),
            (&mut self.loss, loss),
            (&mut self.radius, r),
            (&mut self.k1, r * r * m.k1),
            (&mut self.c1, r * m.c1),
            (&mut self.drive, r * r * m.drive),
            (&mut self.k2, r * r * m.k2),
            (&mut self.k3, r * r * m.k3),
            (&mut self.c3, r * m.c3),
            (&mut self.k32, r * r * m.k32),
            (&mut self.omega, r * m.omega),
        ] {
            row.0[lane] = value;
        }
    }
}

/// Numbers that change from sub-step to sub-step. Counts are whole numbers, exact in a double.
pub(super) struct LaneStates {
    /// Augmented state: x1, w, x3, their rates, cos θ and sin θ.
    pub(super) z: [LaneRow; 8],
    /// Time, leading and trailing part, s.
    pub(super) time: [LaneRow; 2],
    /// Order of departure, as `HybridState::departing`, or [`GROUNDED`].
    pub(super) departing: LaneRow,
    /// Sub-steps since cos θ and sin θ were last computed from the phase.
    pub(super) since_renewal: LaneRow,
    /// Energy lost at impacts, leading and trailing part, J.
    pub(super) lost: [LaneRow; 2],
    /// Impacts at the upper stop since the motion came into the lane.
    pub(super) upper: LaneRow,
    /// Impacts at the lower stop since the motion came into the lane.
    pub(super) lower: LaneRow,
    /// Time of the last impact, s; this and the next four rows are fields of `ImpactRecord`.
    pub(super) last_time: LaneRow,
    pub(super) last_speed: LaneRow,
    pub(super) last_impulse: LaneRow,
    pub(super) total_impulse: LaneRow,
    pub(super) box_impulse: LaneRow,
    /// Sub-steps since the motion came into the lane, as in `WorkCounters`.
    pub(super) substeps: LaneRow,
    /// Taylor expansions since the motion came into the lane, as in `WorkCounters`.
    pub(super) expansions: LaneRow,
    /// Root iterations since the motion came into the lane, as in `WorkCounters`.
    pub(super) iterations: LaneRow,
    /// Time of the next sample, s; infinite if there is none.
    pub(super) next_sample: LaneRow,
}

/// Time in a lane, from the rows of its two parts.
#[inline(always)]
fn time_in(time: &[LaneRow; 2], lane: usize) -> DoubleDouble {
    DoubleDouble { hi: time[0].0[lane], lo: time[1].0[lane] }
}

/// State in a lane of the `rows`, read number by number so that the rows are not copied.
#[inline(always)]
pub(super) fn state_in(rows: &[LaneRow; 8], lane: usize) -> Augmented {
    let mut z = [0.0; 8];
    for (z, row) in z.iter_mut().zip(rows) {
        *z = row.0[lane];
    }
    z
}

/// Start of the latest sub-step of each motion that reports.
pub(super) struct SubstepStarts {
    /// Augmented state.
    pub(super) z: [LaneRow; 8],
    /// Time, leading and trailing part, s.
    pub(super) time: [LaneRow; 2],
}

impl SubstepStarts {
    pub(super) const ZERO: Self = Self { z: [LaneRow::ZERO; 8], time: [LaneRow::ZERO; 2] };

    /// Copies the motions of vector `v`.
    #[inline(always)]
    pub(super) fn copy<S: Simd>(&mut self, simd: S, states: &LaneStates, v: usize) {
        for (row, z) in self.z.iter_mut().zip(&states.z) {
            Wide::load(simd, z, v).store(row, v);
        }
        for (row, time) in self.time.iter_mut().zip(&states.time) {
            Wide::load(simd, time, v).store(row, v);
        }
    }

    /// The state in a lane.
    #[inline(always)]
    pub(super) fn state(&self, lane: usize) -> Augmented {
        state_in(&self.z, lane)
    }

    /// The time in a lane.
    #[inline(always)]
    pub(super) fn time(&self, lane: usize) -> DoubleDouble {
        time_in(&self.time, lane)
    }
}

impl LaneStates {
    pub(super) fn zero() -> Self {
        let row = LaneRow::ZERO;
        Self {
            z: [row; 8],
            time: [row; 2],
            departing: row,
            since_renewal: row,
            lost: [row; 2],
            upper: row,
            lower: row,
            last_time: row,
            last_speed: row,
            last_impulse: row,
            total_impulse: row,
            box_impulse: row,
            substeps: row,
            expansions: row,
            iterations: row,
            next_sample: LaneRow([f64::INFINITY; ROW]),
        }
    }

    /// Copies a motion from its simulator into a lane.
    #[inline(always)]
    pub(super) fn load_state(&mut self, lane: usize, simulator: &Simulator, advance: &AdvanceState) {
        let hybrid = &simulator.hybrid;
        for (row, z) in self.z.iter_mut().zip(advance.z) {
            row.0[lane] = z;
        }
        (self.time[0].0[lane], self.time[1].0[lane]) = (hybrid.time.hi, hybrid.time.lo);
        self.departing.0[lane] = match hybrid.contact {
            Contact::Flight if hybrid.departure.is_none() => f64::from(hybrid.departing),
            _ => GROUNDED,
        };
        self.since_renewal.0[lane] = f64::from(advance.since_renewal);
        (self.lost[0].0[lane], self.lost[1].0[lane]) = (hybrid.sums.impact.hi, hybrid.sums.impact.lo);
        self.last_time.0[lane] = hybrid.record.last_time;
        self.last_speed.0[lane] = hybrid.record.last_speed;
        self.last_impulse.0[lane] = hybrid.record.last_impulse;
        self.total_impulse.0[lane] = hybrid.record.total_impulse;
        self.box_impulse.0[lane] = hybrid.record.box_impulse;
        let counts = [
            &mut self.upper,
            &mut self.lower,
            &mut self.substeps,
            &mut self.expansions,
            &mut self.iterations,
        ];
        for row in counts {
            row.0[lane] = 0.0;
        }
    }

    /// Copies the motion in a lane back to its simulator. The lanes never change its mode.
    #[inline(always)]
    pub(super) fn store_state(&self, lane: usize, simulator: &mut Simulator, advance: &mut AdvanceState) {
        let hybrid = &mut simulator.hybrid;
        for (z, row) in advance.z.iter_mut().zip(&self.z) {
            *z = row.0[lane];
        }
        hybrid.time = self.time(lane);
        advance.since_renewal = self.since_renewal.0[lane] as u32;
        let departing = self.departing.0[lane];
        if departing < GROUNDED {
            hybrid.departing = departing as u8;
        }
        hybrid.sums.impact = DoubleDouble { hi: self.lost[0].0[lane], lo: self.lost[1].0[lane] };
        hybrid.record.last_time = self.last_time.0[lane];
        hybrid.record.last_speed = self.last_speed.0[lane];
        hybrid.record.last_impulse = self.last_impulse.0[lane];
        hybrid.record.total_impulse = self.total_impulse.0[lane];
        hybrid.record.box_impulse = self.box_impulse.0[lane];
        let (upper, lower) = (self.upper.0[lane] as u64, self.lower.0[lane] as u64);
        hybrid.record.upper += upper;
        hybrid.record.lower += lower;
        simulator.work.substeps += self.substeps.0[lane] as u64;
        simulator.work.iterations += self.iterations.0[lane] as u64;
        simulator.work.expansions += self.expansions.0[lane] as u64;
        simulator.work.events += upper + lower;
    }

    /// Sub-steps since the motion came into the lane.
    pub(super) fn substeps(&self, lane: usize) -> u64 {
        self.substeps.0[lane] as u64
    }

    /// Lanes that have reached the time of their next sample.
    #[inline(always)]
    pub(super) fn due_for_sample<S: Simd>(&self, simd: S) -> LaneSet {
        let mut due = 0;
        for v in 0..LaneRow::vectors::<S>() {
            let load = |row: &LaneRow| Wide::load(simd, row, v);
            let reached = load(&self.next_sample).at_most(load(&self.time[0]) + load(&self.time[1]));
            due |= reached.bits() << (v * S::F64_LANES);
        }
        due
    }

    /// Lanes whose next sample is at most two sub-steps away, which is farther than one sub-step
    /// reaches.
    #[inline(always)]
    pub(super) fn near_sample<S: Simd>(&self, simd: S, systems: &LaneSystems) -> LaneSet {
        let mut near = 0;
        for v in 0..LaneRow::vectors::<S>() {
            let load = |row: &LaneRow| Wide::load(simd, row, v);
            let substep = load(&systems.substep);
            let reached = load(&self.next_sample).at_most(load(&self.time[0]) + (substep + substep));
            near |= reached.bits() << (v * S::F64_LANES);
        }
        near
    }

    /// The state in a lane.
    #[inline(always)]
    pub(super) fn state(&self, lane: usize) -> Augmented {
        state_in(&self.z, lane)
    }

    /// The time in a lane.
    #[inline(always)]
    pub(super) fn time(&self, lane: usize) -> DoubleDouble {
        time_in(&self.time, lane)
    }

    /// Lanes whose cos θ and sin θ have been rotated `often` times or more.
    #[inline(always)]
    pub(super) fn due_for_renewal<S: Simd>(&self, simd: S, often: f64) -> LaneSet {
        let mut due = 0;
        for v in 0..LaneRow::vectors::<S>() {
            let reached = Wide::splat(simd, often).at_most(Wide::load(simd, &self.since_renewal, v));
            due |= reached.bits() << (v * S::F64_LANES);
        }
        due
    }

    /// Renews cos θ and sin θ of a lane from the extended phase.
    #[inline(never)]
    pub(super) fn renew_phase(&mut self, lane: usize, simulator: &Simulator) {
        let time = self.time(lane);
        let (sin, cos) = simulator.hybrid.phase.angle(simulator.model.omega, time).sin_cos();
        (self.z[DRIVE_COS].0[lane], self.z[DRIVE_SIN].0[lane]) = (cos, sin);
        self.since_renewal.0[lane] = 0.0;
    }
}
