//! Springs in series and their states of first order: derivatives by one parameter
//! (docs/assembly-law.md, section 15).

use super::tangent::{ElongationTangent, Tangent};
use super::weights::Weights;
use crate::description::{Description, SeriesLaw};
use crate::system::{StateRow, System, in_series};
use nalgebra::DMatrix;

/// Derivatives of the rows of a spring in series.
#[derive(Clone, Debug)]
pub(super) struct BranchTangent {
    pub elongation: ElongationTangent,
    pub force: StateRow,
    /// Of the row of the inner place's rate, where it moves.
    pub rate: StateRow,
}

impl Tangent {
    pub(super) fn put_branches(&mut self, system: &System, d: &Description, along: &Description) {
        let springs = in_series(d).zip(in_series(along));
        for (rows, ((spring, series), (by, change))) in system.branches.iter().zip(springs) {
            let own = self.elongation(system, &spring.arms, &by.arms);
            let e = &rows.elongation;
            let force = by.stiffness * rows.stretch() + rows.stiffness * &own.e;
            let rate = match (series.law, change.law) {
                (SeriesLaw::Dashpot { damping }, SeriesLaw::Dashpot { damping: dc }) => {
                    (1.0 / damping) * &force - (dc / (damping * damping)) * &*rows.force
                }
            };
            self.forces.ger(-1.0, &own.w, &rows.force, 1.0);
            self.forces.ger(-1.0, &e.w, &force, 1.0);
            self.branches.push(BranchTangent { elongation: own, force, rate });
            self.inner.push(change.slider);
        }
    }

    /// The derivatives of the rows of states of first order, with their places.
    pub(super) fn first_order<'a>(
        &'a self,
        system: &'a System,
    ) -> impl Iterator<Item = (usize, &'a StateRow)> + 'a {
        system.branches.iter().zip(&self.branches).map(|(rows, own)| (rows.place, &own.rate))
    }
}

impl Weights {
    /// Adds what the rows of states of first order depend on: `by_a` is by the rows of A from the
    /// accelerations on.
    pub(super) fn add_first_order(&mut self, system: &System, by_a: &DMatrix<f64>) {
        for (rows, own) in system.branches.iter().zip(&mut self.branches) {
            own.rate += by_a.row(rows.place - system.coordinates).transpose();
        }
    }
}
