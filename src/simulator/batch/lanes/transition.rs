//! Transition matrices over a whole sub-step, of all motions in lanes, without the entries that
//! are zero.

use crate::model::{
    Augmented, BOX, BOX_RATE, DRIVE_COS, DRIVE_SIN, RELATIVE, RELATIVE_RATE, SECONDARY, SECONDARY_RATE,
};
use crate::simulator::batch::vectors::LaneRow;

/// Nonzero entries of the matrix that gives the state after a whole sub-step; for each body one
/// row for its displacement and one for its rate. In free flight, docs/theory.md (6), the box
/// depends only on itself and the drive, w = x2 - x1 depends on all coordinates, and the secondary
/// oscillator does not depend on the drive.
pub(super) struct LaneTransitions {
    /// x1 and v1, from x1, v1, cos θ and sin θ.
    pub(super) driven: [[LaneRow; 4]; 2],
    /// w and its rate, from all coordinates.
    pub(super) relative: [[LaneRow; 8]; 2],
    /// x3 and v3, from all displacements and rates.
    pub(super) secondary: [[LaneRow; 6]; 2],
    /// cos θ and sin θ, from cos θ and sin θ.
    pub(super) drive: [[LaneRow; 2]; 2],
}

impl LaneTransitions {
    pub(super) const ZERO: Self = {
        let row = LaneRow::ZERO;
        Self {
            driven: [[row; 4]; 2],
            relative: [[row; 8]; 2],
            secondary: [[row; 6]; 2],
            drive: [[row; 2]; 2],
        }
    };

    /// Fills a lane from the columns of a table.
    pub(super) fn load(&mut self, lane: usize, columns: &[Augmented; 8]) {
        fill(&mut self.driven, lane, columns, &[BOX, BOX_RATE], &[BOX, BOX_RATE, DRIVE_COS, DRIVE_SIN]);
        fill(&mut self.relative, lane, columns, &[RELATIVE, RELATIVE_RATE], &[0, 1, 2, 3, 4, 5, 6, 7]);
        fill(&mut self.secondary, lane, columns, &[SECONDARY, SECONDARY_RATE], &[0, 1, 2, 3, 4, 5]);
        fill(&mut self.drive, lane, columns, &[DRIVE_COS, DRIVE_SIN], &[DRIVE_COS, DRIVE_SIN]);
    }
}

/// Fills a lane with the entries that lead from the N coordinates `of` to the two coordinates
/// `into`.
fn fill<const N: usize>(
    rows: &mut [[LaneRow; N]; 2],
    lane: usize,
    columns: &[Augmented; 8],
    into: &[usize; 2],
    of: &[usize; N],
) {
    for (rows, i) in rows.iter_mut().zip(into) {
        for (row, j) in rows.iter_mut().zip(of) {
            row.0[lane] = columns[*j][*i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Parameters;
    use crate::simulator::{Simulator, State};

    #[test]
    fn invariant_entries_that_are_left_out_are_zero() {
        let p = Parameters { drive_phase: 0.3, secondary_damping: 0.1, ..Parameters::default() };
        let simulator = Simulator::new(&p, &State { x: [0.0; 3], v: [0.0; 3] }, 0.0).unwrap();
        let columns = &simulator.flight.core.full;
        let mut loaded = LaneTransitions::ZERO;
        loaded.load(0, columns);
        let sum = |rows: &[LaneRow]| rows.iter().map(|row| row.0[0].abs()).sum::<f64>();
        let LaneTransitions { driven, relative, secondary, drive } = &loaded;
        let kept = sum(driven.as_flattened())
            + sum(relative.as_flattened())
            + sum(secondary.as_flattened())
            + sum(drive.as_flattened());
        let all: f64 = columns.as_flattened().iter().map(|entry| entry.abs()).sum();
        /// Tolerance: rounding of sums in another order.
        const ROUNDING: f64 = 1e-12;
        assert!((kept - all).abs() <= ROUNDING * all, "{kept} {all}");
    }
}
