//! Groups of contacts that share coordinates. Contacts of different groups do not interact: their
//! compliance matrix G = WᵀM⁻¹W has a block for each group (docs/assembly-law.md (A5)). Work
//! therefore grows with the sizes of the groups and not with the number of all contacts.

use super::box_qp::{independent, triangle};
use crate::mode::{Contact, ElementState, Mode};
use crate::system::{Elongation, System};
use nalgebra::DMatrix;

/// Contacts that share coordinates, directly or through others.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    /// Indices of the contacts in a list of contacts, ascending.
    pub(crate) places: Vec<usize>,
    /// The coordinates on which they act, ascending.
    pub(crate) reach: Vec<usize>,
}

impl Group {
    /// Returns L⁻¹ w of the group's contacts, as columns over the group's coordinates.
    pub(crate) fn columns(&self, system: &System, contacts: &[Contact]) -> DMatrix<f64> {
        self.of_each(system, contacts, |e, k| e.column[k])
    }

    /// Returns a vector of each contact's elongation, as columns over the group's coordinates.
    pub(crate) fn of_each(
        &self,
        system: &System,
        contacts: &[Contact],
        entry: impl Fn(&Elongation, usize) -> f64,
    ) -> DMatrix<f64> {
        DMatrix::from_fn(self.reach.len(), self.places.len(), |row, column| {
            entry(system.elongation_of(contacts[self.places[column]]), self.reach[row])
        })
    }
}

/// The upper triangle R with RᵀR = G of independent contacts, by groups.
#[derive(Clone, Debug, Default)]
pub struct Triangle(Vec<(Vec<usize>, DMatrix<f64>)>);

impl Triangle {
    /// Combines the triangles of groups, each with the indices of its contacts.
    pub(crate) fn of(groups: Vec<(Vec<usize>, DMatrix<f64>)>) -> Self {
        Self(groups)
    }

    /// Solves G x = b in place for the first `b.len()` contacts of the list.
    pub(crate) fn solve(&self, b: &mut [f64]) {
        for (places, r) in &self.0 {
            let m = places.iter().take_while(|place| **place < b.len()).count();
            for j in 0..m {
                let known: f64 = (0..j).map(|i| r[(i, j)] * b[places[i]]).sum();
                b[places[j]] = (b[places[j]] - known) / r[(j, j)];
            }
            for j in (0..m).rev() {
                let known: f64 = (j + 1..m).map(|k| r[(j, k)] * b[places[k]]).sum();
                b[places[j]] = (b[places[j]] - known) / r[(j, j)];
            }
        }
    }

    /// Number of stored values.
    pub(crate) fn numbers(&self) -> usize {
        self.0.iter().map(|(places, r)| places.len() + r.len()).sum()
    }
}

impl System {
    /// Returns the groups of contacts, in the order of their first contacts.
    pub(crate) fn groups(&self, contacts: &[Contact]) -> Vec<Group> {
        // For each coordinate, its first contact; for each contact, an earlier contact of its
        // group, or itself.
        let mut first: Vec<Option<usize>> = vec![None; self.coordinates];
        let mut joined: Vec<usize> = (0..contacts.len()).collect();
        let root = |joined: &[usize], mut place: usize| {
            while joined[place] != place {
                place = joined[place];
            }
            place
        };
        for (place, &contact) in contacts.iter().enumerate() {
            for &k in &self.elongation_of(contact).reach {
                let [a, b] = [*first[k].get_or_insert(place), place].map(|own| root(&joined, own));
                joined[a.max(b)] = a.min(b);
            }
        }
        let mut groups: Vec<Group> = Vec::new();
        let mut group_of: Vec<Option<usize>> = vec![None; contacts.len()];
        for (place, &contact) in contacts.iter().enumerate() {
            let own = *group_of[root(&joined, place)].get_or_insert_with(|| {
                groups.push(Group { places: Vec::new(), reach: Vec::new() });
                groups.len() - 1
            });
            groups[own].places.push(place);
            groups[own].reach.extend(&self.elongation_of(contact).reach);
        }
        for group in &mut groups {
            group.reach.sort_unstable();
            group.reach.dedup();
        }
        groups
    }

    /// Returns the largest independent subset of contacts given in order of preference; the result
    /// is sorted.
    pub fn independent(&self, contacts: &[Contact]) -> Vec<Contact> {
        let mut basis: Vec<Contact> = Vec::new();
        for group in self.groups(contacts) {
            let places: Vec<usize> = (0..group.places.len()).collect();
            let own = independent(&group.columns(self, contacts), &places);
            basis.extend(own.into_iter().map(|k| contacts[group.places[k]]));
        }
        basis.sort();
        basis
    }

    /// Returns L⁻¹ w of contacts, as columns.
    pub fn columns(&self, contacts: &[Contact]) -> DMatrix<f64> {
        let mut columns = DMatrix::zeros(self.coordinates, contacts.len());
        for (k, &contact) in contacts.iter().enumerate() {
            columns.set_column(k, &self.elongation_of(contact).column);
        }
        columns
    }

    /// Returns the triangle of independent contacts.
    pub fn triangle(&self, contacts: &[Contact]) -> Triangle {
        let of = |group: Group| {
            let r = triangle(&group.columns(self, contacts));
            (group.places, r)
        };
        Triangle(self.groups(contacts).into_iter().map(of).collect())
    }

    /// Returns the mode that differs from `mode` by the state of an element.
    pub fn with_element(&self, mode: &Mode, element: ElementState) -> Mode {
        let mut mode = mode.clone();
        match element {
            ElementState::Stop(i, state) => mode.stops[i] = state,
            ElementState::Friction(i, state) => mode.frictions[i] = state,
            ElementState::Slider(i, state) => mode.sliders[i] = state,
        }
        mode.basis = self.independent(&mode.contacts().collect::<Vec<_>>());
        mode
    }
}
