//! Held contacts of a mode: closed stops and sticking frictions of its basis, which keep e'' at
//! zero. Their forces λ and the remaining accelerations are computed group by group
//! (docs/assembly-law.md (A5)).

use crate::kernel::{Sparse, SparseMatrix};
use crate::law::ZERO;
use crate::law::box_qp::{groups_by_columns, triangle};
use crate::law::groups::{Group, Triangle};
use crate::mode::Contact;
use crate::system::{Elongation, System};
use nalgebra::{DMatrix, DVector};

/// The contacts of a mode's basis.
pub(super) struct Held<'a> {
    system: &'a System,
    basis: &'a [Contact],
    groups: Vec<HeldGroup>,
    /// For each coordinate: the group that holds it, and its row in the group.
    holders: Vec<Option<(usize, usize)>>,
}

/// A group with its matrices over its own coordinates.
struct HeldGroup {
    group: Group,
    /// The directions w, as columns.
    directions: DMatrix<f64>,
    /// L⁻¹ w of each contact, as columns.
    columns: DMatrix<f64>,
    /// The upper triangle R with RᵀR = WᵀM⁻¹W.
    triangle: DMatrix<f64>,
    /// M⁻¹ w of each contact, as columns.
    mobility: DMatrix<f64>,
    /// The projection of velocities and accelerations past the contacts, 1 - M⁻¹ W G⁻¹ Wᵀ, with
    /// rounding errors replaced by zero.
    loose: DMatrix<f64>,
}

/// The system z' = A z with the reaction of the contacts.
pub(super) struct Reaction {
    /// A with the contacts' forces.
    pub(super) a: SparseMatrix,
    /// For each entry of A: the sum of the sizes of its terms.
    pub(super) terms: SparseMatrix,
    /// The contacts' forces, in the order of the basis.
    pub(super) lambda: Vec<Sparse>,
}

/// A group's part of a [`Reaction`]: rows of its coordinates' accelerations and of its forces,
/// with entries in some columns.
struct GroupReaction {
    columns: Vec<usize>,
    accelerations: DMatrix<f64>,
    terms: DMatrix<f64>,
    forces: DMatrix<f64>,
}

impl GroupReaction {
    fn row<'a>(&'a self, rows: &'a DMatrix<f64>, i: usize) -> impl Iterator<Item = (usize, f64)> + 'a {
        self.columns.iter().enumerate().map(move |(place, &j)| (j, rows[(i, place)]))
    }
}

impl HeldGroup {
    fn new(system: &System, basis: &[Contact], group: Group) -> Self {
        let columns = group.columns(system, basis);
        let triangle = triangle(&columns);
        let directions = group.of_each(system, basis, |e, k| e.w[k]);
        let mobility = group.of_each(system, basis, |e, k| e.mobility[k]);
        let mut shares = directions.transpose();
        triangle.tr_solve_upper_triangular_mut(&mut shares);
        triangle.solve_upper_triangular_mut(&mut shares);
        let one = DMatrix::identity(group.reach.len(), group.reach.len());
        let sizes = &one + mobility.abs() * shares.abs();
        let left = one - &mobility * shares;
        let loose = left.zip_map(&sizes, |x, size| if x.abs() <= ZERO * size { 0.0 } else { x });
        Self { group, directions, columns, triangle, mobility, loose }
    }

    /// Contact forces that keep e'' at zero against given accelerations, by columns of the
    /// augmented state; `drift` holds the parts of e'' due to prescribed bodies.
    fn demand(&self, accelerations: &DMatrix<f64>, drift: &DMatrix<f64>) -> DMatrix<f64> {
        let mut demand = self.directions.tr_mul(accelerations) + drift;
        // Sizes of the terms: the sum of the terms may be rounding, as for bodies in free fall.
        let sizes = self.directions.abs().tr_mul(&accelerations.abs()) + drift.abs();
        self.triangle.tr_solve_upper_triangular_mut(&mut demand);
        self.triangle.solve_upper_triangular_mut(&mut demand);
        zero_rounding(&mut demand, &self.columns, &sizes);
        demand
    }

    /// The group's reaction in a system without the group's forces.
    fn react(&self, system: &System, basis: &[Contact], a: &SparseMatrix) -> GroupReaction {
        let (n, reach) = (system.coordinates, &self.group.reach);
        let drift = |place: usize| &system.elongation_of(basis[place]).drift;
        let mut columns: Vec<usize> =
            reach.iter().flat_map(|k| a.row(n + k).iter().map(|term| term.0)).collect();
        let (own, signals) = (&self.group.places, n..system.signals.size);
        columns.extend(signals.filter(|&j| own.iter().any(|&place| drift(place)[j] != 0.0)));
        columns.sort_unstable();
        columns.dedup();
        let mut accelerations = DMatrix::zeros(reach.len(), columns.len());
        for (row, k) in reach.iter().enumerate() {
            let mut place = 0;
            for &(j, x) in a.row(n + k) {
                place += columns[place..].iter().take_while(|column| **column < j).count();
                accelerations[(row, place)] = x;
            }
        }
        let drift = DMatrix::from_fn(own.len(), columns.len(), |c, j| drift(own[c])[columns[j]]);
        let forces = self.demand(&accelerations, &drift);
        let terms = accelerations.abs() + self.mobility.abs() * forces.abs();
        accelerations -= &self.mobility * &forces;
        // Coordinates that the contacts hold completely move as prescribed bodies require, without
        // the rounding error of cancelling forces.
        let held = |row: &usize| self.loose.row(*row).iter().all(|x| *x == 0.0);
        let held: Vec<usize> = (0..reach.len()).filter(held).collect();
        let moves = !held.is_empty() && drift.iter().any(|x| *x != 0.0);
        let prescribed = moves.then(|| self.demand(&DMatrix::zeros(reach.len(), columns.len()), &drift));
        for row in held {
            match &prescribed {
                Some(prescribed) => accelerations.set_row(row, &-(self.mobility.row(row) * prescribed)),
                None => accelerations.row_mut(row).fill(0.0),
            }
        }
        GroupReaction { columns, accelerations, terms, forces }
    }
}

impl<'a> Held<'a> {
    pub(super) fn new(system: &'a System, basis: &'a [Contact]) -> Self {
        let groups: Vec<HeldGroup> =
            system.groups(basis).into_iter().map(|group| HeldGroup::new(system, basis, group)).collect();
        let mut holders = vec![None; system.coordinates];
        for (place, own) in groups.iter().enumerate() {
            own.group.reach.iter().enumerate().for_each(|(row, &k)| holders[k] = Some((place, row)));
        }
        Self { system, basis, groups, holders }
    }

    /// The reaction of all contacts in a system without their forces.
    pub(super) fn react(&self, a: &SparseMatrix) -> Reaction {
        let n = self.system.coordinates;
        let reactions: Vec<GroupReaction> =
            self.groups.iter().map(|group| group.react(self.system, self.basis, a)).collect();
        let with = |value: fn(f64) -> f64, rows: fn(&GroupReaction) -> &DMatrix<f64>| {
            a.with_rows(value, |i| {
                let (group, row) = self.holders.get(i.checked_sub(n)?).copied().flatten()?;
                Some(reactions[group].row(rows(&reactions[group]), row))
            })
        };
        let mut lambda = vec![Sparse::default(); self.basis.len()];
        for (own, reaction) in self.groups.iter().zip(&reactions) {
            for (c, &place) in own.group.places.iter().enumerate() {
                lambda[place] = Sparse::from_terms(reaction.row(&reaction.forces, c));
            }
        }
        Reaction { a: with(|x| x, |own| &own.accelerations), terms: with(f64::abs, |own| &own.terms), lambda }
    }

    /// Absolute values of the projection of velocities and first-order states past the contacts.
    pub(super) fn loose_sizes(&self) -> SparseMatrix {
        let mut sizes = SparseMatrix::default();
        for (k, holder) in self.holders.iter().enumerate() {
            match *holder {
                Some((group, row)) => {
                    let own = &self.groups[group];
                    let entries = own.group.reach.iter().enumerate();
                    sizes.push_row(entries.map(|(place, &j)| (j, own.loose[(row, place)].abs())));
                }
                None => sizes.push_row(std::iter::once((k, 1.0))),
            }
        }
        // No contact holds a state of first order.
        let inner = self.system.places_of_first_order().len();
        (0..inner).for_each(|i| sizes.push_row(std::iter::once((self.system.coordinates + i, 1.0))));
        sizes
    }

    /// Whether contacts hold a coordinate on which an element acts.
    pub(super) fn holds(&self, e: &Elongation) -> bool {
        e.reach.iter().any(|&k| self.holders[k].is_some())
    }

    /// The column that a unit of an element's force subtracts from z', with contacts' reaction:
    /// `loose` M⁻¹ w in the rows of the velocities, with rounding errors set to zero.
    pub(super) fn moved(&self, e: &Elongation) -> Sparse {
        let (n, mut groups, mut entries) = (self.system.coordinates, Vec::new(), Vec::new());
        for &k in &e.reach {
            match self.holders[k] {
                Some((group, _)) if groups.contains(&group) => {}
                Some((group, _)) => groups.push(group),
                None => entries.push((n + k, e.mobility[k])),
            }
        }
        for group in groups {
            let HeldGroup { group: Group { reach, .. }, loose, .. } = &self.groups[group];
            let mobility = DVector::from_iterator(reach.len(), reach.iter().map(|&k| e.mobility[k]));
            let sizes = loose.abs() * mobility.abs();
            let left =
                (loose * mobility).zip_map(&sizes, |x, size| if x.abs() <= ZERO * size { 0.0 } else { x });
            entries.extend(reach.iter().zip(left.iter()).map(|(&k, &x)| (n + k, x)));
        }
        entries.sort_unstable_by_key(|entry| entry.0);
        Sparse::from_terms(entries.into_iter())
    }

    /// The triangle of all contacts.
    pub(super) fn triangle(self) -> Triangle {
        Triangle::of(self.groups.into_iter().map(|own| (own.group.places, own.triangle)).collect())
    }
}

/// Replaces rounding errors in the rows of contact forces by zero, so that a force that vanishes
/// throughout is exactly zero. `demands` holds the sizes of what each contact holds against. A
/// contact's force is at most as large as the demands on contacts that share coordinates with it,
/// directly or through others.
fn zero_rounding(forces: &mut DMatrix<f64>, columns: &DMatrix<f64>, demands: &DMatrix<f64>) {
    let (m, size) = forces.shape();
    let norms: Vec<f64> = columns.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
    let group = groups_by_columns(columns);
    let mut largest = vec![0.0f64; m];
    for column in 0..size {
        largest.fill(0.0);
        for k in 0..m {
            largest[group[k]] = largest[group[k]].max(demands[(k, column)] / norms[k]);
        }
        for k in 0..m {
            if forces[(k, column)].abs() <= ZERO * largest[group[k]] / norms[k] {
                forces[(k, column)] = 0.0;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_a_force_is_rounding_beside_what_its_group_holds_against() {
        // The first two contacts share a coordinate, the third has its own. Columns of demands: 1
        // at the first contact (which counts for the second by 1/√2, not for the third); 1 at the
        // third, whose column has length 2; none.
        let columns = DMatrix::from_row_slice(3, 3, &[1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 2.0]);
        let demands = DMatrix::from_row_slice(3, 3, &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        let (small, more) = (0.2 * ZERO, 0.8 * ZERO);
        for (second, is_rounding) in [(small, true), (more, false)] {
            let forces = [0.5, small, small, second, small, small, small, small, small];
            let mut cleaned = DMatrix::from_row_slice(3, 3, &forces);
            zero_rounding(&mut cleaned, &columns, &demands);
            let kept = if is_rounding { 0.0 } else { second };
            let exact = [0.5, small, small, kept, small, small, small, 0.0, small];
            assert_eq!(cleaned, DMatrix::from_row_slice(3, 3, &exact));
        }
    }
}
