//! The stiffness with a proximal weight in the inertia's metric.

use super::factor::Factor;
use super::{Direction, Holding, RestSpring};
use crate::sparse_factor::{Pattern, SymmetricSparse};
use crate::system::RowMatrix;
use nalgebra::DMatrix;
use vibro_numerics::double_double::DoubleDouble;

/// The factored stiffness with a proximal weight, and the contacts' directions scaled by the
/// inverse factor.
pub(super) struct Weighted<'p> {
    pub(super) factor: Factor<'p>,
    pub(super) columns: DMatrix<f64>,
}

impl Holding {
    /// Pattern of the coordinates that a spring or the inertia couples.
    pub(super) fn pattern(&self, mass: &RowMatrix) -> Pattern {
        let n = self.force.len();
        let by_mass = (0..n).flat_map(|i| mass.entries(i).iter().map(move |entry| (i, entry.0)));
        let of = |w: &Direction| {
            let pairs = |&(i, _): &(usize, f64)| w.iter().map(move |&(j, _)| (i, j));
            w.iter().flat_map(pairs).collect::<Vec<_>>()
        };
        Pattern::of(n, by_mass.chain(self.springs.iter().flat_map(|s| of(&s.w))))
    }

    /// The factored stiffness with a proximal weight; `None` if it is not positive definite.
    pub(super) fn weighted<'p>(
        &self,
        weight: f64,
        mass: &RowMatrix,
        pattern: &'p Pattern,
    ) -> Option<Weighted<'p>> {
        let (n, m) = (self.force.len(), self.contacts.len());
        let wide = DoubleDouble::new;
        let mut stiffness = SymmetricSparse::zeros(pattern);
        let mut add = |i: usize, j: usize, x: DoubleDouble| {
            if let Some(sum) = stiffness.entry_mut(i, j).filter(|_| i >= j) {
                *sum = *sum + x;
            }
        };
        for i in 0..n {
            mass.entries(i).iter().for_each(|&(j, inertia)| add(i, j, wide(inertia).times(wide(weight))));
        }
        for RestSpring { w, stiffness: k, .. } in &self.springs {
            for &(i, a) in w {
                let row = wide(a).times(wide(*k));
                w.iter().for_each(|&(j, b)| add(i, j, row.times(wide(b))));
            }
        }
        let factor = Factor::new(stiffness)?;
        // A compliant contact has a coordinate of its own, whose entry squared is its compliance.
        let mut columns = DMatrix::zeros(n + m, m);
        for (k, contact) in self.contacts.iter().enumerate() {
            let mut w = vec![DoubleDouble::default(); n];
            contact.w.iter().for_each(|&(i, a)| w[i] = wide(a));
            columns.view_mut((0, k), (n, 1)).copy_from_slice(&factor.half(w));
            columns[(n + k, k)] = contact.compliance.sqrt();
        }
        Some(Weighted { factor, columns })
    }
}
