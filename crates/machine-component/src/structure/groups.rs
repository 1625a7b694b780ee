//! Groups of bodies that constraints may hold together, and the forces on each group.

use super::Structure;
use super::knowns::{Knowns, join};
use crate::table::Quantity;
use fmi_doors::DependencyKind::{Dependent, Discrete, Tunable};
use std::collections::HashMap;
use vibro_machine::Element;
use vibro_machine::description::{Arms, BodyKind, Description};
use vibro_machine::elements::Action;

/// Returns the group number of each body, if each of `arms` may hold its free bodies together.
pub(super) fn groups(machine: &Description, arms: &[&Arms]) -> Vec<usize> {
    let mut group: Vec<usize> = (0..machine.bodies.len()).collect();
    for arms in arms {
        let mut bodies = bodies_of(machine, arms).filter(|&body| is_free(machine, body));
        let Some(first) = bodies.next() else { continue };
        for body in bodies {
            let (from, to) = (group[body], group[first]);
            group.iter_mut().filter(|group| **group == from).for_each(|group| *group = to);
        }
    }
    group
}

/// Returns the bodies of an elongation; nodes are replaced by their coordinates.
pub(super) fn bodies_of(machine: &Description, arms: &Arms) -> impl Iterator<Item = usize> {
    arms.terms.iter().flat_map(|term| machine.behind(term.0))
}

pub(super) fn is_free(machine: &Description, body: usize) -> bool {
    matches!(machine.bodies[body].kind, BodyKind::Free(_))
}

/// Whether an element may constrain its elongation or its rate.
pub(super) fn holds(action: Action) -> bool {
    matches!(action, Action::Tying | Action::Hitting | Action::Rubbing)
}

/// The dependencies that the bodies of a group share.
#[derive(Default)]
pub(super) struct Group {
    /// Knowns of the accelerations.
    pub(super) forces: Knowns,
    /// Knowns of the bodies' jumps at events, from prescribed bodies that are tied to them or
    /// touch them.
    pub(super) jumps: Knowns,
    /// Whether a link ties the bodies to a prescribed body, so that coordinates and rates jump.
    pub(super) is_tied: bool,
    /// Whether a rigid stop acts on the bodies.
    pub(super) hits: bool,
}

impl<'a> Structure<'a> {
    /// Returns the groups of the free bodies on which an element acts.
    pub(super) fn groups_of(&self, element: Element) -> Vec<usize> {
        let load =
            if let Element::Load(load) = element { self.machine.behind(load.body) } else { Vec::new() };
        let bodies = element.all_arms().flat_map(|arms| bodies_of(self.machine, arms)).chain(load);
        let free = bodies.filter(|&body| is_free(self.machine, body));
        let mut groups: Vec<usize> = free.map(|body| self.group_of[body]).collect();
        groups.sort_unstable();
        groups.dedup();
        groups
    }

    pub(super) fn find_groups(&mut self) {
        let free = (0..self.machine.bodies.len()).filter(|&body| is_free(self.machine, body));
        // First the parameters of the bodies, and of the elements that hold or hit them.
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
                for body in bodies_of(self.machine, arms).filter(|&body| !is_free(self.machine, body)) {
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

    /// Returns the knowns of the forces among the coordinates of one body, by group.
    fn forces_within(&self, element: Element) -> Vec<(usize, Knowns)> {
        let coordinates = element.coordinates();
        // Damping and gyroscopic forces may couple the coordinates of a body with matrices.
        let couples = matches!(element, Element::Matrix(_));
        let beside = |body: usize| if couples { coordinates.clone() } else { body..body + 1 };
        let force = |body: usize| {
            let (mut own, mut knowns) = (Knowns::new(), Knowns::new());
            for other in beside(body) {
                (0..2).for_each(|order| join(&mut own, &self.coordinate(other, order), Tunable));
            }
            join(&mut knowns, &own, Tunable);
            self.of_section(&element.dotted(), &mut knowns);
            (self.group_of[body], knowns)
        };
        coordinates.clone().map(force).collect()
    }

    /// Returns the knowns of each force that acts on a group, with the group's number.
    fn forces(&self) -> Vec<(usize, Knowns)> {
        let mut forces: Vec<(usize, Knowns)> = Vec::new();
        for &element in &self.elements {
            let knowns = match element.action() {
                Action::Linear | Action::Switching | Action::Pressing => self.force(element),
                Action::Driving => self.driving(element),
                Action::Rubbing => {
                    let (mut rate, mut knowns) = (Knowns::new(), self.signals(element));
                    // Friction that depends on the rate may not be linear in it.
                    if element.rubs_by_rate() {
                        self.elongation(element, 1, &mut rate);
                        join(&mut knowns, &rate, Dependent);
                    }
                    knowns
                }
                Action::Flexing => {
                    forces.extend(self.forces_within(element));
                    continue;
                }
                Action::Hitting | Action::Tying | Action::Giving | Action::Computing => continue,
            };
            forces.extend(self.groups_of(element).into_iter().map(|group| (group, knowns.clone())));
        }
        forces
    }
}
