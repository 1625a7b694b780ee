//! The motions under way, number by number: the same number of all motions lies side by side.

use super::Places;
use crate::flow::INTERVALS;
use crate::numerics::double_double::DoubleDouble;
use crate::simulator::batch::vectors::{ROW, Row, Wide};
use crate::simulator::step::{AdvanceState, MAX_REACH};
use crate::simulator::tables::ModeTables;
use crate::simulator::{Contact, Simulator};
use pulp::Simd;
use std::sync::Arc;

/// `departing` of a motion that is not in flight.
const GROUNDED: f64 = f64::INFINITY;

/// What stays while a motion is under way.
pub(super) struct LaneSystems {
    /// Of the motion in each lane, to see when the rows must be filled anew.
    pub(super) tables: [Option<Arc<ModeTables>>; ROW],
    pub(super) sample: [[Row; 8]; INTERVALS],
    pub(super) full: [[Row; 8]; 8],
    pub(super) bound: [Row; 8],
    pub(super) end: [Row; 2],
    pub(super) substep: Row,
    pub(super) interval: Row,
    pub(super) gap: Row,
    /// The path that `Simulator::exceeds_reach` allows in an interval.
    pub(super) reach: Row,
    /// A run of impacts is not closed while the rebound's square is over this times a bound on the acceleration.
    pub(super) closing: Row,
    /// κ, and what the approach speed is multiplied by for the box's change of speed, the impulse and (its square) the loss.
    pub(super) restitution: Row,
    pub(super) kick: Row,
    pub(super) impulse: Row,
    pub(super) loss: Row,
    /// The equations of motion in the time unit of half an interval.
    pub(super) radius: Row,
    pub(super) k1: Row,
    pub(super) c1: Row,
    pub(super) drive: Row,
    pub(super) k2: Row,
    pub(super) k3: Row,
    pub(super) c3: Row,
    pub(super) k32: Row,
    pub(super) turn: Row,
}

impl LaneSystems {
    pub(super) fn zero() -> Self {
        let row = Row::ZERO;
        Self {
            tables: [const { None }; ROW],
            sample: [[row; 8]; INTERVALS],
            full: [[row; 8]; 8],
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
            turn: row,
        }
    }

    /// Fills a lane for a motion.
    pub(super) fn load_system(&mut self, lane: usize, simulator: &Simulator, end: DoubleDouble) {
        (self.end[0].0[lane], self.end[1].0[lane]) = (end.hi, end.lo);
        if self.tables[lane].as_ref().is_some_and(|tables| Arc::ptr_eq(tables, &simulator.flight)) {
            return;
        }
        self.tables[lane] = Some(Arc::clone(&simulator.flight));
        let core = &simulator.flight.core;
        for j in 0..8 {
            for i in 0..INTERVALS {
                self.sample[i][j].0[lane] = core.sample[j][i];
            }
            for i in 0..8 {
                self.full[i][j].0[lane] = core.full[j][i];
            }
            self.bound[j].0[lane] = core.bound[j];
        }
        let interval = simulator.interval();
        let r = 0.5 * interval;
        let m = &simulator.model;
        let [kick, impulse, loss] = m.impact_factors();
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
            (&mut self.turn, r * m.omega),
        ] {
            row.0[lane] = value;
        }
    }
}

/// What changes from sub-step to sub-step; counts are whole numbers.
pub(super) struct LaneStates {
    pub(super) z: [Row; 8],
    pub(super) time: [Row; 2],
    pub(super) departing: Row,
    /// Sub-steps since cos θ and sin θ were taken anew.
    pub(super) since: Row,
    /// Energy lost at impacts.
    pub(super) lost: [Row; 2],
    pub(super) upper: Row,
    pub(super) lower: Row,
    pub(super) last_time: Row,
    pub(super) last_speed: Row,
    pub(super) last_impulse: Row,
    pub(super) total_impulse: Row,
    /// WorkCounters.
    pub(super) substeps: Row,
    pub(super) expansions: Row,
    pub(super) iterations: Row,
}

impl LaneStates {
    pub(super) fn zero() -> Self {
        let row = Row::ZERO;
        Self {
            z: [row; 8],
            time: [row; 2],
            departing: row,
            since: row,
            lost: [row; 2],
            upper: row,
            lower: row,
            last_time: row,
            last_speed: row,
            last_impulse: row,
            total_impulse: row,
            substeps: row,
            expansions: row,
            iterations: row,
        }
    }

    /// Takes a motion over from its simulator.
    #[inline(always)]
    pub(super) fn take(&mut self, lane: usize, simulator: &Simulator, advance: &AdvanceState) {
        let hybrid = &simulator.hybrid;
        for (row, z) in self.z.iter_mut().zip(advance.z) {
            row.0[lane] = z;
        }
        (self.time[0].0[lane], self.time[1].0[lane]) = (hybrid.time.hi, hybrid.time.lo);
        self.departing.0[lane] = match hybrid.contact {
            Contact::Flight => f64::from(hybrid.departing),
            _ => GROUNDED,
        };
        self.since.0[lane] = f64::from(advance.since_renewal);
        (self.lost[0].0[lane], self.lost[1].0[lane]) = (hybrid.sums.impact.hi, hybrid.sums.impact.lo);
        self.last_time.0[lane] = hybrid.record.last_time;
        self.last_speed.0[lane] = hybrid.record.last_speed;
        self.last_impulse.0[lane] = hybrid.record.last_impulse;
        self.total_impulse.0[lane] = hybrid.record.total_impulse;
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

    /// Gives a motion in flight back to its simulator.
    #[inline(always)]
    pub(super) fn give(&self, lane: usize, simulator: &mut Simulator, advance: &mut AdvanceState) {
        let hybrid = &mut simulator.hybrid;
        for (z, row) in advance.z.iter_mut().zip(&self.z) {
            *z = row.0[lane];
        }
        hybrid.time = DoubleDouble { hi: self.time[0].0[lane], lo: self.time[1].0[lane] };
        advance.since_renewal = self.since.0[lane] as u32;
        let departing = self.departing.0[lane];
        if departing < GROUNDED {
            hybrid.departing = departing as u8;
        }
        hybrid.sums.impact = DoubleDouble { hi: self.lost[0].0[lane], lo: self.lost[1].0[lane] };
        hybrid.record.last_time = self.last_time.0[lane];
        hybrid.record.last_speed = self.last_speed.0[lane];
        hybrid.record.last_impulse = self.last_impulse.0[lane];
        hybrid.record.total_impulse = self.total_impulse.0[lane];
        let (upper, lower) = (self.upper.0[lane] as u64, self.lower.0[lane] as u64);
        hybrid.record.upper += upper;
        hybrid.record.lower += lower;
        simulator.work.substeps += self.substeps.0[lane] as u64;
        simulator.work.iterations += self.iterations.0[lane] as u64;
        simulator.work.expansions += self.expansions.0[lane] as u64;
        simulator.work.events += upper + lower;
    }

    /// The motions whose cos θ and sin θ have been rotated `often` times.
    #[inline(always)]
    pub(super) fn stale<S: Simd>(&self, simd: S, often: f64) -> Places {
        let mut stale = 0;
        for v in 0..Row::vectors::<S>() {
            let due = Wide::splat(simd, often).at_most(Wide::of(simd, &self.since, v));
            stale |= due.bits() << (v * S::F64_LANES);
        }
        stale
    }

    /// Takes cos θ and sin θ anew.
    #[inline(never)]
    pub(super) fn renew(&mut self, lane: usize, simulator: &Simulator) {
        let time = DoubleDouble { hi: self.time[0].0[lane], lo: self.time[1].0[lane] };
        let (sin, cos) = simulator.hybrid.phase.angle(simulator.model.omega, time).sin_cos();
        (self.z[6].0[lane], self.z[7].0[lane]) = (cos, sin);
        self.since.0[lane] = 0.0;
    }
}
