//! The transition over a whole sub-step, of all motions in lanes: the entries of the matrix that
//! are not zero.

use crate::model::{
    Augmented, BOX, BOX_RATE, DRIVE_COS, DRIVE_SIN, RELATIVE, RELATIVE_RATE, SECONDARY, SECONDARY_RATE,
};
use crate::simulator::batch::vectors::LaneRow;

/// The entries, other than zero, of the matrix that gives the state after a whole sub-step, for
/// each body those of its displacement and of its rate. In free flight, docs/theory.md (6), the
/// drive moves the box, whatever the block does; both move w = x2 - x1; and the secondary body
/// follows the block alone.
pub(super) struct LaneTransitions {
    /// Of x1, v1, cos θ and sin θ in the box.
    pub(super) driven: [[LaneRow; 4]; 2],
    /// Of all in w.
    pub(super) relative: [[LaneRow; 8]; 2],
    /// Of displacements and rates in the secondary body.
    pub(super) secondary: [[LaneRow; 6]; 2],
    /// Of cos θ and sin θ in these.
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

    /// Fills a lane with a table's columns.
    pub(super) fn load(&mut self, lane: usize, columns: &[Augmented; 8]) {
        fill(&mut self.driven, lane, columns, &[BOX, BOX_RATE], &[BOX, BOX_RATE, DRIVE_COS, DRIVE_SIN]);
        fill(&mut self.relative, lane, columns, &[RELATIVE, RELATIVE_RATE], &[0, 1, 2, 3, 4, 5, 6, 7]);
        fill(&mut self.secondary, lane, columns, &[SECONDARY, SECONDARY_RATE], &[0, 1, 2, 3, 4, 5]);
        fill(&mut self.drive, lane, columns, &[DRIVE_COS, DRIVE_SIN], &[DRIVE_COS, DRIVE_SIN]);
    }
}

/// Fills a lane with the entries `of` N coordinates in two, `into` which they go.
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
        /// Sums in another order.
        const ROUNDING: f64 = 1e-12;
        assert!((kept - all).abs() <= ROUNDING * all, "{kept} {all}");
    }
}
