//! Points of a motion within a sub-step: its start, and a point on a series.

use crate::flow::{LOAD, Series, shifted};
use crate::model::{Augmented, Forces};

/// Point on a series: an event or the step's end.
pub(super) struct SeriesPoint<'a, const N: usize> {
    pub(super) series: &'a Series<N>,
    /// Time from the sub-step's start to the series' centre, s.
    pub(super) base: f64,
    pub(super) radius: f64,
    pub(super) u: f64,
    /// Interval at the centre of the series; `None` for a series about the sub-step's start.
    pub(super) interval: Option<usize>,
}

/// Start of a sub-step: state, loads and the bound on the functional's second derivative. `LOADS`
/// is 0 or 1, so that motion without loads is compiled without them.
pub(super) struct SubstepStart<const LOADS: usize> {
    pub(super) z: Augmented,
    pub(super) forces: [Forces; LOADS],
    pub(super) bound: f64,
}

impl<const LOADS: usize> SubstepStart<LOADS> {
    #[inline(always)]
    pub(super) fn forces(&self) -> Option<&Forces> {
        self.forces.first()
    }

    #[inline(always)]
    pub(super) fn forces_after(&self, dt: f64) -> Option<Forces> {
        self.forces.first().map(|f| shifted(f, dt))
    }

    /// Forces as columns of the load tables.
    #[inline(always)]
    pub(super) fn columns(&self) -> Option<[f64; LOAD]> {
        self.forces.first().map(|f| std::array::from_fn(|c| f[c / 4][c % 4]))
    }
}
