//! Bodies that may be held to one another, and the forces on them.

use super::Structure;
use super::knowns::{Knowns, join};
use crate::table::Quantity;
use fmi_doors::DependencyKind::{Dependent, Discrete, Tunable};
use std::collections::HashMap;
use vibro_assembly::description::{Arms, BodyKind, Description, StopLaw};

/// Bodies that may be held to one another, by the number of their group.
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

/// What the bodies of a group have in common.
#[derive(Default)]
pub(super) struct Group {
    /// What their accelerations depend on.
    pub(super) forces: Knowns,
    /// What may let them jump at an event: prescribed bodies that they are tied to or touch.
    pub(super) jumps: Knowns,
    /// Whether a link ties them to a prescribed body, so that they jump in place, too.
    pub(super) is_tied: bool,
    /// Whether they may hit one another.
    pub(super) hits: bool,
}

impl<'a> Structure<'a> {
    /// What ties or touches bodies: arms, section, and whether it is a link or a rigid stop.
    fn ties(&self) -> impl Iterator<Item = (&'a Arms, String, bool, bool)> {
        let links = self.machine.links.iter().map(|x| (&x.arms, format!("link.{}", x.name), true, false));
        let rigid = self.machine.stops.iter().filter(|stop| matches!(stop.law, StopLaw::Rigid { .. }));
        let stops = rigid.map(|x| (&x.arms, format!("stop.{}", x.name), false, true));
        let frictions =
            self.machine.frictions.iter().map(|x| (&x.arms, format!("friction.{}", x.name), false, false));
        links.chain(stops).chain(frictions)
    }

    /// The groups of the free bodies that elongations have in common.
    pub(super) fn groups_at(&self, arms: &Arms) -> Vec<usize> {
        let bodies = arms.terms.iter().map(|term| term.0).filter(|&body| is_free(self.machine, body));
        let mut groups: Vec<usize> = bodies.map(|body| self.group_of[body]).collect();
        groups.sort_unstable();
        groups.dedup();
        groups
    }

    pub(super) fn find_groups(&mut self) {
        let free = (0..self.machine.bodies.len()).filter(|&body| is_free(self.machine, body));
        // Numbers first: those of the bodies, and of what ties and touches them.
        let mut groups: HashMap<usize, Group> = HashMap::new();
        for body in free {
            self.of_body_section(body, &mut groups.entry(self.group_of[body]).or_default().forces);
        }
        let mut discrete = Vec::new();
        for (arms, section, is_link, is_rigid) in self.ties() {
            for place in self.groups_at(arms) {
                let group = groups.entry(place).or_default();
                self.of_section(&section, &mut group.forces);
                group.hits |= is_rigid;
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

    /// What the forces on groups depend on, each with its group.
    fn forces(&self) -> Vec<(usize, Knowns)> {
        let mut forces: Vec<(usize, Knowns)> = Vec::new();
        for (i, spring) in self.machine.springs.iter().enumerate() {
            let knowns = self.spring(i);
            forces.extend(self.groups_at(&spring.arms).into_iter().map(|group| (group, knowns.clone())));
        }
        for (i, stop) in self.machine.stops.iter().enumerate() {
            if let StopLaw::Compliant { .. } = stop.law {
                let knowns = self.stop(i);
                forces.extend(self.groups_at(&stop.arms).into_iter().map(|group| (group, knowns.clone())));
            }
        }
        for (i, friction) in self.machine.frictions.iter().enumerate() {
            let knowns = self.levels(i);
            forces.extend(self.groups_at(&friction.arms).into_iter().map(|group| (group, knowns.clone())));
        }
        for (i, load) in self.machine.loads.iter().enumerate() {
            if is_free(self.machine, load.body) {
                forces.push((self.group_of[load.body], self.load(i)));
            }
        }
        forces
    }
}
