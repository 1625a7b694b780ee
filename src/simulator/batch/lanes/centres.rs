//! States at interval centres, computed motion by motion and read by vectors.

use super::rows::{LaneSystems, state_in};
use crate::flow::INTERVALS;
use crate::simulator::batch::vectors::{LaneRow, ROW, Wide};
use pulp::Simd;
use vibro_numerics::simd::product;

/// Number of coordinates in one transposition.
const GROUP: usize = 4;

/// States of some lanes at the centres of intervals. The interval, and so the transition matrix,
/// differs from lane to lane. So each state is computed by a separate product, written motion by
/// motion, and transposed into vectors when it is read.
#[repr(align(64))]
pub(super) struct Centres {
    /// Halves of the states: `[half][place][coordinate]`.
    halves: [[[f64; GROUP]; ROW]; 2],
    /// Place of each lane, which undoes the order of the transposed vectors.
    place: [u8; ROW],
}

impl Centres {
    #[inline(always)]
    pub(super) fn new<S: Simd>(simd: S) -> Self {
        let mut numbered = Self { halves: [[[0.0; GROUP]; ROW]; 2], place: [0; ROW] };
        for (place, state) in numbered.halves[0].iter_mut().enumerate() {
            *state = [place as f64; GROUP];
        }
        let mut there = LaneRow::ZERO;
        for v in 0..LaneRow::vectors::<S>() {
            numbered.load(simd, v)[0].store(&mut there, v);
        }
        for (place, there) in numbered.place.iter_mut().zip(there.0) {
            *place = there as u8;
        }
        numbered
    }

    /// Computes the state of a lane at the centre of an interval of the sub-step that begins with
    /// its state in `rows`.
    #[inline(always)]
    pub(super) fn put<S: Simd>(
        &mut self,
        simd: S,
        systems: &LaneSystems,
        lane: usize,
        interval: usize,
        rows: &[LaneRow; 8],
    ) {
        let Some(table) = systems.table(lane) else { return };
        let [a, b, c, d, e, f, g, h] =
            product(simd, &table.centre[interval % INTERVALS], &state_in(rows, lane));
        let place = usize::from(self.place[lane]) % ROW;
        (self.halves[0][place], self.halves[1][place]) = ([a, b, c, d], [e, f, g, h]);
    }

    /// States in vector `v`.
    #[inline(always)]
    pub(super) fn load<S: Simd>(&self, simd: S, v: usize) -> [Wide<S>; 8] {
        let lanes = v * S::F64_LANES..(v + 1) * S::F64_LANES;
        // Written out: a closure would be compiled without the instruction set.
        let [a, b, c, d] = Wide::transposed(simd, &self.halves[0][lanes.clone()]);
        let [e, f, g, h] = Wide::transposed(simd, &self.halves[1][lanes]);
        [a, b, c, d, e, f, g, h]
    }
}
