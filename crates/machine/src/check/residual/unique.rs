//! Uniqueness of the forces on residual flexibility: all principal minors of C + G are positive, for
//! every direction of every slip (docs/assembly-law.md (A71)).

use super::friction_of;
use crate::check::refused;
use crate::description::{Description, ResidualForces, ResidualMaker};
use crate::refusal::Problem;
use nalgebra::DMatrix;

/// Largest number of coupled contacts whose principal minors are all computed.
const MOST: usize = 8;
/// Least principal minor of the matrix scaled to a diagonal of 1: far above rounding, and far below
/// what measured flexibilities leave.
const LEAST: f64 = 1e-9;
/// Number of halvings of the interval of the largest coefficient of friction.
const HALVINGS: usize = 30;

/// Forces that depend on one another.
struct Group<'a> {
    all: &'a ResidualForces,
    /// C + G.
    matrix: DMatrix<f64>,
    /// Forces that always act.
    springs: Vec<usize>,
    /// Forces along normals, each with the force along its tangent and the coefficient of friction.
    contacts: Vec<(usize, Option<(usize, f64)>)>,
}

/// Adds the problems of uniqueness.
pub(super) fn check(machine: &Description, all: &ResidualForces, problems: &mut Vec<Problem>) {
    for group in groups(machine, all) {
        if !group.is_definite() {
            let (place, text) = (group.contacts.first().map_or(0, |own| own.0), "no force");
            let name = name_of(machine, all.forces.get(place).map(|own| own.by));
            let text = format!(
                "the residual flexibility at its nodes leaves {text} unique: elements without stiffness act in \
                 the same direction, or the flexibility there is zero; give them a `stiffness`"
            );
            problems.push(Problem::new(name, None, text));
        } else if !group.is_unique() {
            refuse_friction(machine, group, problems);
        }
    }
}

fn name_of(machine: &Description, by: Option<ResidualMaker>) -> String {
    match by {
        Some(ResidualMaker::Spring(i)) => format!("spring.{}", machine.springs[i].name),
        Some(ResidualMaker::Stop(i)) => format!("stop.{}", machine.stops[i].name),
        Some(ResidualMaker::Normal(i) | ResidualMaker::Tangent(i)) => {
            format!("contact.{}", machine.contacts[i].name)
        }
        None => "modal".into(),
    }
}

/// Refuses the friction of a contact, with the largest coefficient that passes.
fn refuse_friction(machine: &Description, mut group: Group, problems: &mut Vec<Problem>) {
    let frictions: Vec<f64> = group.contacts.iter().map(|own| own.1.map_or(0.0, |own| own.1)).collect();
    let slides: Vec<usize> = (0..frictions.len()).filter(|&k| frictions[k] > 0.0).collect();
    // The first contact whose friction alone is too large; otherwise all together.
    let mut sets: Vec<Vec<usize>> = slides.iter().map(|&k| vec![k]).collect();
    sets.push(slides);
    for set in sets {
        let mut with = |factor: f64| {
            for &k in &set {
                if let Some(own) = &mut group.contacts[k].1 {
                    own.1 = factor * frictions[k];
                }
            }
            let passes = group.is_unique();
            for &k in &set {
                if let Some(own) = &mut group.contacts[k].1 {
                    own.1 = frictions[k];
                }
            }
            passes
        };
        if !with(0.0) {
            continue;
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if with(middle) { low = middle } else { high = middle }
        }
        let first = set[0];
        let ResidualMaker::Normal(contact) = group.all.forces[group.contacts[first].0].by else { continue };
        let most = low * frictions[first];
        let others = if set.len() > 1 { " (all contacts on this body in the same ratio)" } else { "" };
        let text = format!(
            "the force would not be unique: friction presses the contact through the residual flexibility; expected \
             at most {most:.6}{others}, or a smaller `stiffness`"
        );
        let name = format!("contact.{}.friction", machine.contacts[contact].name);
        return problems.push(refused(name, friction_of(machine, contact), text));
    }
}

/// The groups of forces that depend on one another.
fn groups<'a>(machine: &Description, all: &'a ResidualForces) -> Vec<Group<'a>> {
    let (mut matrix, count) = (all.between(), all.forces.len());
    // The tangent of a contact depends on its normal.
    let depends = |i: usize, j: usize| {
        matrix[(i, j)] != 0.0 || all.normal_of(i) == Some(j) || all.normal_of(j) == Some(i)
    };
    let mut group_of: Vec<usize> = (0..count).collect();
    for i in 0..count {
        for j in (0..i).filter(|&j| depends(i, j)) {
            let (from, to) = (group_of[i], group_of[j]);
            group_of.iter_mut().filter(|own| **own == from).for_each(|own| *own = to);
        }
    }
    for (i, own) in all.forces.iter().enumerate() {
        matrix[(i, i)] += own.compliance;
    }
    let mut known = Vec::new();
    for group in group_of.iter().copied() {
        if !known.contains(&group) {
            known.push(group);
        }
    }
    let of = |group: usize| {
        let (mut springs, mut contacts) = (Vec::new(), Vec::new());
        for i in (0..count).filter(|&i| group_of[i] == group) {
            match all.forces[i].by {
                ResidualMaker::Spring(_) => springs.push(i),
                ResidualMaker::Stop(_) => contacts.push((i, None)),
                ResidualMaker::Normal(contact) => {
                    let tangent = (0..count).find(|&t| all.normal_of(t) == Some(i));
                    contacts.push((i, tangent.map(|t| (t, friction_of(machine, contact)))));
                }
                ResidualMaker::Tangent(_) => {}
            }
        }
        Group { all, matrix: matrix.clone(), springs, contacts }
    };
    known.into_iter().map(of).collect()
}

impl Group<'_> {
    /// All forces of the group.
    fn members(&self) -> Vec<usize> {
        let contacts = self.contacts.iter().flat_map(|own| std::iter::once(own.0).chain(own.1.map(|t| t.0)));
        self.springs.iter().copied().chain(contacts).collect()
    }

    /// The determinant of some forces, with slips (tangent, normal, signed coefficient), for a
    /// matrix scaled to a diagonal of 1.
    fn determinant(&self, active: &[usize], slips: &[(usize, usize, f64)]) -> f64 {
        let scale = |i: usize| self.matrix[(i, i)].sqrt();
        let entry = |row: usize, column: usize| {
            let (i, j) = (active[row], active[column]);
            let slipping = slips.iter().filter(|own| own.1 == j);
            let slipping: f64 = slipping.map(|&(t, _, factor)| factor * self.matrix[(i, t)]).sum();
            (self.matrix[(i, j)] + slipping) / (scale(i) * scale(j))
        };
        DMatrix::from_fn(active.len(), active.len(), entry).determinant()
    }

    /// Whether C + G without friction is positive definite.
    fn is_definite(&self) -> bool {
        let members = self.members();
        let diagonal = members.iter().all(|&i| self.matrix[(i, i)] > 0.0 && self.matrix[(i, i)].is_finite());
        let leading = |count: usize| self.determinant(&members[..count], &[]) > LEAST;
        diagonal && (1..=members.len()).all(leading)
    }

    /// Whether the forces are unique for every direction of every slip.
    fn is_unique(&self) -> bool {
        let slides = self.contacts.iter().any(|own| own.1.is_some_and(|tangent| tangent.1 > 0.0));
        match self.contacts.len() {
            _ if !slides => true,
            count if count <= MOST => self.minors(0, &mut self.springs.clone(), &mut Vec::new()),
            _ => self.is_definite_by_norm(),
        }
    }

    /// Whether all principal minors that contain the given forces and slips, and no contact before
    /// `next`, are positive.
    fn minors(&self, next: usize, active: &mut Vec<usize>, slips: &mut Vec<(usize, usize, f64)>) -> bool {
        let Some(&(normal, tangent)) = self.contacts.get(next) else {
            return active.is_empty() || self.determinant(active, slips) > LEAST;
        };
        // Open.
        if !self.minors(next + 1, active, slips) {
            return false;
        }
        active.push(normal);
        let mut passes = true;
        match tangent {
            None => passes = self.minors(next + 1, active, slips),
            Some((tangent, friction)) => {
                active.push(tangent);
                passes &= self.minors(next + 1, active, slips);
                active.pop();
                for direction in [1.0, -1.0] {
                    slips.push((tangent, normal, direction * friction));
                    passes = passes && self.minors(next + 1, active, slips);
                    slips.pop();
                }
            }
        }
        active.pop();
        passes
    }

    /// Whether every one of these matrices is positive definite, by the least eigenvalue of C + G
    /// and the norm of what slips add, both scaled to a diagonal of 1. This is sufficient for
    /// positive principal minors.
    fn is_definite_by_norm(&self) -> bool {
        let members = self.members();
        let scale = |i: usize| self.matrix[(i, i)].sqrt();
        let scaled = |i: usize, j: usize| self.matrix[(i, j)] / (scale(i) * scale(j));
        let count = members.len();
        let all = DMatrix::from_fn(count, count, |i, j| scaled(members[i], members[j]));
        let least = all.symmetric_eigenvalues().min();
        let slides: Vec<_> = self.contacts.iter().filter_map(|own| Some((own.0, own.1?))).collect();
        // A slip acts on all other forces, but not on its own tangent, which it replaces.
        let entry = |i: usize, j: usize| {
            let (row, (normal, (tangent, friction))) = (members[i], slides[j]);
            let own = if row == tangent { 0.0 } else { scaled(row, tangent) };
            own * friction * scale(tangent) / scale(normal)
        };
        let added = DMatrix::from_fn(count, slides.len(), entry);
        least - added.singular_values().max() > LEAST
    }
}
