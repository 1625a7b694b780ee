//! Groups of bodies that may be held to each other, and the forces on them.

use super::Structure;
use super::knowns::{Knowns, join};
use crate::table::Quantity;
use fmi_doors::DependencyKind::{Dependent, Discrete, Tunable};
use std::collections::HashMap;
use vibro_assembly::Element;
use vibro_assembly::description::{Arms, BodyKind, Description};
use vibro_assembly::elements::Action;

/// The group of each body: bodies that elements with these arms connect share a number.
pub(super) fn groups(machine: &Description, arms: &[&Arms]) -> Vec<usize> {
    let mut group: Vec<usize> = (0..machine.bodies.len()).collect();
    for arms in arms {
        let mut bodies = arms.terms.iter().map(|term| term.0).filter(|&body| is_free(machine, body));
        let Some(first) = bodies.next() else { continue };
        for body in bodies {
            let (from, to) = (group[body], group[first]);
            group.iter_mut().filter(|group| **group == from).for_each(|group| *group = to);
        }
    }
    group
}

pub(super) fn is_free(machine: &Description, body: usize) -> bool {
    matches!(machine.bodies[body].kind, BodyKind::Free(_))
}

/// Whether an element may keep its elongation, or the rate of it, constant.
pub(super) fn holds(action: Action) -> bool {
    matches!(action, Action::Tying | Action::Hitting | Action::Rubbing)
}

/// Dependencies that the bodies of a group share.
#[derive(Default)]
pub(super) struct Group {
    /// Dependencies of their accelerations.
    pub(super) forces: Knowns,
    /// Dependencies of jumps at events, caused by prescribed bodies that links or contacts join to
    /// the group.
    pub(super) jumps: Knowns,
    /// Whether a link ties them to a prescribed body, so that their coordinates may jump, too.
    pub(super) is_tied: bool,
    /// Whether impacts may occur between them.
    pub(super) hits: bool,
}

impl<'a> Structure<'a> {
    /// The groups of the free bodies on which an element acts.
    pub(super) fn groups_of(&self, element: Element) -> Vec<usize> {
        let load = if let Element::Load(load) = element { Some(load.body) } else { None };
        let bodies = element.arms().into_iter().flat_map(|arms| &arms.terms).map(|term| term.0).chain(load);
        let free = bodies.filter(|&body| is_free(self.machine, body));
        let mut groups: Vec<usize> = free.map(|body| self.group_of[body]).collect();
        groups.sort_unstable();
        groups.dedup();
        groups
    }

    pub(super) fn find_groups(&mut self) {
        let free = (0..self.machine.bodies.len()).filter(|&body| is_free(self.machine, body));
        // Parameters of the bodies, and of links and contacts on them.
        let mut groups: HashMap<usize, Group> = HashMap::new();
        for body in free {
            self.of_body_section(body, &mut groups.entry(self.group_of[body]).or_default().forces);
        }
        let mut discrete = Vec::new();
        for &element in self.elements.iter().filter(|element| holds(element.action())) {
            let Some(arms) = element.arms() else { continue };
            let is_link = element.action() == Action::Tying;
            for place in self.groups_of(element) {
                let group = groups.entry(place).or_default();
                self.of_section(&element.dotted(), &mut group.forces);
                group.hits |= element.action() == Action::Hitting;
                discrete.extend((!is_link).then_some(place));
                for &(body, _) in arms.terms.iter().filter(|term| !is_free(self.machine, term.0)) {
                    group.is_tied |= is_link;
                    join(&mut group.jumps, &self.prescribed(body, 0), Dependent);
                    join(&mut group.forces, &self.prescribed(body, 2), Dependent);
                }
            }
        }
        let time = self.references[&Quantity::Time];
        for group in groups.values_mut().filter(|group| !group.jumps.is_empty()) {
            group.jumps.remove(&time); // between events there are no jumps
            let parameters = group.forces.clone();
            join(&mut group.jumps, &parameters, Dependent);
            group.jumps.remove(&time);
        }
        self.groups = groups;
        for (place, knowns) in self.forces() {
            let times = if discrete.contains(&place) { Discrete } else { Tunable };
            join(&mut self.groups.entry(place).or_default().forces, &knowns, times);
        }
    }

    /// The dependencies of the forces on groups, each with its group.
    fn forces(&self) -> Vec<(usize, Knowns)> {
        let mut forces: Vec<(usize, Knowns)> = Vec::new();
        for &element in &self.elements {
            let knowns = match element.action() {
                Action::Linear | Action::Switching => self.force(element),
                Action::Rubbing | Action::Driving => self.signals(element),
                Action::Hitting | Action::Tying => continue,
            };
            forces.extend(self.groups_of(element).into_iter().map(|group| (group, knowns.clone())));
        }
        forces
    }
}
