//! What depends on what, by the machine's topology and never by its numbers (FMI 2.0, 2.2.8; FMI
//! 3.0.2, 2.4.8).
//!
//! Between events every coordinate, elongation and force is linear in states and inputs, by factors
//! that change with the mode. Bodies that links, rigid stops or friction may hold to one another
//! make a group: a force on one of them accelerates all.

mod groups;
mod initial;
mod knowns;

use crate::plan::Plan;
use crate::table::{Energy, Quantity, Role};
use fmi_doors::DependencyKind;
use fmi_doors::DependencyKind::{Constant, Dependent, Discrete, Fixed, Tunable};
use fmi_doors::description::Unknown;
use groups::{Group, groups, is_free};
use knowns::{Knowns, join, put};
use std::collections::HashMap;
use vibro_assembly::description::{Arms, BodyKind, Description, Signal, StopLaw};

/// Entries of all lists of one kind together, at most, so that a description stays readable: about
/// 10 bytes each. Lists of an unknown that depends on most of a large machine are left out first,
/// which stands for everything.
const ENTRIES: usize = 200_000;

/// The dependencies of a machine's variables.
pub(crate) struct Structure<'a> {
    plan: &'a Plan,
    machine: &'a Description,
    /// By section and name, as `body.box`: value references of parameters, and what follows that in
    /// their names.
    parameters: HashMap<&'a str, Vec<(u32, &'a str)>>,
    references: HashMap<Quantity, u32>,
    inputs: HashMap<&'a str, u32>,
    group_of: Vec<usize>,
    /// The groups that links alone make.
    linked: Vec<usize>,
    groups: HashMap<usize, Group>,
}

impl<'a> Structure<'a> {
    pub(crate) fn new(plan: &'a Plan) -> Self {
        let machine = &plan.assembly.description;
        let (mut parameters, mut inputs) = (HashMap::<_, Vec<_>>::new(), HashMap::new());
        let mut references = HashMap::new();
        for (reference, row) in (1..).zip(&plan.table.rows) {
            references.insert(row.quantity, reference);
            match row.quantity {
                Quantity::Parameter(_) => {
                    let second = row.name.match_indices('.').nth(1).map_or(row.name.len(), |dot| dot.0);
                    let (section, rest) = row.name.split_at(second);
                    parameters.entry(section).or_default().push((reference, rest));
                }
                Quantity::Input(_) => _ = inputs.insert(row.name.as_str(), reference),
                _ => {}
            }
        }
        let links: Vec<&Arms> = machine.links.iter().map(|link| &link.arms).collect();
        let rigid = machine.stops.iter().filter(|stop| matches!(stop.law, StopLaw::Rigid { .. }));
        let holding = rigid.map(|stop| &stop.arms).chain(machine.frictions.iter().map(|f| &f.arms));
        let holding: Vec<&Arms> = links.iter().copied().chain(holding).collect();
        let (linked, group_of) = (groups(machine, &links), groups(machine, &holding));
        let groups = HashMap::new();
        let mut structure = Self { plan, machine, parameters, references, inputs, group_of, linked, groups };
        structure.find_groups();
        structure
    }

    /// Lists of the unknowns, none where they are too long together.
    pub(crate) fn unknowns(&self, unknowns: &[(u32, Quantity)], initially: bool) -> Vec<Unknown> {
        let list = |&(reference, quantity): &(u32, Quantity)| {
            let knowns = if initially { self.initially(quantity) } else { self.of(quantity) };
            (reference, knowns)
        };
        let lists: Vec<(u32, Knowns)> = unknowns.iter().map(list).collect();
        let total: usize = lists.iter().map(|(_, knowns)| knowns.len()).sum();
        let most = if total > ENTRIES { ENTRIES / unknowns.len() } else { total };
        let unknown = |(reference, knowns): (u32, Knowns)| Unknown {
            reference,
            dependencies: (knowns.len() <= most).then(|| knowns.into_iter().collect()),
        };
        lists.into_iter().map(unknown).collect()
    }

    /// The parameters of a section, without starts.
    fn of_section(&self, section: &str, into: &mut Knowns) {
        let all = self.parameters.get(section).into_iter().flatten();
        all.filter(|(_, rest)| !rest.starts_with(".start."))
            .for_each(|(reference, _)| put(into, *reference, Dependent));
    }

    fn of_body_section(&self, body: usize, into: &mut Knowns) {
        self.of_section(&format!("body.{}", self.machine.bodies[body].name), into);
        if is_free(self.machine, body) {
            self.of_section("gravity", into);
        }
    }

    /// A signal's time derivative of an order; its parameters are the section's.
    fn signal(&self, signal: &Signal, rate: f64, input: &str, order: usize, into: &mut Knowns) {
        let cubic = signal.table.as_ref().is_some_and(|table| table.cubic);
        let moves = match order {
            0 => !signal.harmonics.is_empty() || !signal.steps.is_empty() || rate != 0.0,
            _ => !signal.harmonics.is_empty(),
        };
        if moves || signal.table.is_some() && (cubic || order == 0) {
            put(into, self.references[&Quantity::Time], Dependent);
        }
        if let Some(&reference) = self.inputs.get(input).filter(|_| order == 0) {
            put(into, reference, Constant);
        }
    }

    fn prescribed(&self, body: usize, order: usize) -> Knowns {
        let mut knowns = Knowns::new();
        let name = &self.machine.bodies[body].name;
        if let BodyKind::Prescribed { motion, rate } = &self.machine.bodies[body].kind {
            self.signal(motion, *rate, &format!("body.{name}.motion.input"), order, &mut knowns);
            self.of_body_section(body, &mut knowns);
        }
        knowns
    }

    fn load(&self, i: usize) -> Knowns {
        let (mut knowns, load) = (Knowns::new(), &self.machine.loads[i]);
        self.signal(&load.force, 0.0, &format!("load.{}.input", load.name), 0, &mut knowns);
        self.of_section(&format!("load.{}", load.name), &mut knowns);
        knowns
    }

    fn levels(&self, i: usize) -> Knowns {
        let (mut knowns, friction) = (Knowns::new(), &self.machine.frictions[i]);
        let section = format!("friction.{}", friction.name);
        self.signal(&friction.force, 0.0, &format!("{section}.force.input"), 0, &mut knowns);
        if let Some(level) = &friction.static_force {
            self.signal(level, 0.0, &format!("{section}.static.input"), 0, &mut knowns);
        }
        self.of_section(&section, &mut knowns);
        knowns
    }

    /// A body's coordinate (order 0) or rate (1).
    fn coordinate(&self, body: usize, order: usize) -> Knowns {
        if !is_free(self.machine, body) {
            return self.prescribed(body, order);
        }
        let mut knowns = Knowns::new();
        let states = self.plan.assembly.states();
        if states.contains(&body) {
            put(&mut knowns, self.references[&Quantity::Body(body, order)], Constant);
        } else {
            self.by_links(body, order, &mut knowns);
        }
        if let Some(group) = self.groups.get(&self.group_of[body]).filter(|g| order == 1 || g.is_tied) {
            join(&mut knowns, &group.jumps, Dependent);
        }
        knowns
    }

    /// What links make of the others' coordinates.
    fn by_links(&self, body: usize, order: usize, knowns: &mut Knowns) {
        let own = self.linked[body];
        for &state in self.plan.assembly.states().iter().filter(|&&state| self.linked[state] == own) {
            put(knowns, self.references[&Quantity::Body(state, order)], Fixed);
        }
        for link in &self.machine.links {
            let mut bodies = link.arms.terms.iter().map(|term| term.0);
            if bodies.any(|body| is_free(self.machine, body) && self.linked[body] == own) {
                self.of_section(&format!("link.{}", link.name), knowns);
                let all = link.arms.terms.iter().map(|term| term.0);
                for other in all.filter(|&body| !is_free(self.machine, body)) {
                    join(knowns, &self.prescribed(other, order), Fixed);
                }
            }
        }
    }

    /// An elongation (order 0) or its rate (1) of an element of this section.
    fn elongation(&self, arms: &Arms, section: &str, order: usize, knowns: &mut Knowns) {
        for &(body, _) in &arms.terms {
            let times = if arms.levers { Fixed } else { Constant };
            join(knowns, &self.coordinate(body, order), times);
        }
        let parameters = self.parameters.get(section).into_iter().flatten();
        let levers = parameters.filter(|(_, rest)| rest.starts_with(".arms."));
        levers.for_each(|(reference, _)| put(knowns, *reference, Dependent));
    }

    /// The force of a spring or of a compliant stop, by what its factors change with.
    fn elastic(&self, arms: &Arms, section: &str, times: DependencyKind) -> Knowns {
        let (mut own, mut knowns) = (Knowns::new(), Knowns::new());
        (0..2).for_each(|order| self.elongation(arms, section, order, &mut own));
        join(&mut knowns, &own, times);
        self.of_section(section, &mut knowns);
        knowns
    }

    /// The force of a rigid stop or of a friction: what holds the accelerations of those whom it
    /// touches.
    fn holding(&self, arms: &Arms, section: &str) -> Knowns {
        let mut knowns = Knowns::new();
        for &(body, _) in &arms.terms {
            match self.groups.get(&self.group_of[body]) {
                Some(group) => join(&mut knowns, &group.forces, Discrete),
                None => join(&mut knowns, &self.prescribed(body, 2), Discrete),
            }
        }
        self.of_section(section, &mut knowns);
        knowns
    }

    fn stop(&self, i: usize) -> Knowns {
        let stop = &self.machine.stops[i];
        let section = format!("stop.{}", stop.name);
        match stop.law {
            StopLaw::Rigid { .. } => self.holding(&stop.arms, &section),
            StopLaw::Compliant { .. } => self.elastic(&stop.arms, &section, Discrete),
        }
    }

    fn spring(&self, i: usize) -> Knowns {
        let spring = &self.machine.springs[i];
        self.elastic(&spring.arms, &format!("spring.{}", spring.name), Tunable)
    }

    fn friction(&self, i: usize) -> Knowns {
        let friction = &self.machine.frictions[i];
        let mut knowns = self.holding(&friction.arms, &format!("friction.{}", friction.name));
        join(&mut knowns, &self.levels(i), Discrete);
        knowns
    }

    /// What a variable depends on.
    pub(crate) fn of(&self, quantity: Quantity) -> Knowns {
        let mut knowns = Knowns::new();
        let section = |kind: &str, name: &str| format!("{kind}.{name}");
        match quantity {
            Quantity::Body(body, 2) if is_free(self.machine, body) => {
                return self.groups[&self.group_of[body]].forces.clone();
            }
            Quantity::Body(body, 2) => return self.prescribed(body, 2),
            Quantity::Body(body, order) => return self.coordinate(body, order),
            Quantity::Spring(i, 2) => return self.spring(i),
            Quantity::Stop(i, 2) => return self.stop(i),
            Quantity::Friction(i, 2) => return self.friction(i),
            Quantity::Load(i) => return self.load(i),
            Quantity::Spring(i, order) => {
                let spring = &self.machine.springs[i];
                self.elongation(&spring.arms, &section("spring", &spring.name), order, &mut knowns);
            }
            Quantity::Stop(i, order) => {
                let stop = &self.machine.stops[i];
                self.elongation(&stop.arms, &section("stop", &stop.name), order, &mut knowns);
            }
            Quantity::Friction(i, order) => {
                let friction = &self.machine.frictions[i];
                self.elongation(&friction.arms, &section("friction", &friction.name), order, &mut knowns);
            }
            Quantity::StopState(i) | Quantity::Impacts(i) | Quantity::Impulse(i) => {
                (0..3).for_each(|k| join(&mut knowns, &self.of(Quantity::Stop(i, k)), Dependent));
            }
            Quantity::FrictionState(i) => {
                (1..3).for_each(|k| join(&mut knowns, &self.of(Quantity::Friction(i, k)), Dependent));
            }
            Quantity::Energy(energy) => self.energy(energy, &mut knowns),
            Quantity::Indicator(place) => self.indicator(place, &mut knowns),
            Quantity::Time
            | Quantity::Parameter(_)
            | Quantity::Input(_)
            | Quantity::Transition
            | Quantity::Response => {}
        }
        knowns
    }

    fn energy(&self, energy: Energy, knowns: &mut Knowns) {
        let free = (0..self.machine.bodies.len()).filter(|&body| is_free(self.machine, body));
        match energy {
            Energy::Kinetic | Energy::Stored => {
                let order = usize::from(energy == Energy::Kinetic);
                for body in free {
                    join(knowns, &self.coordinate(body, order), Dependent);
                    self.of_body_section(body, knowns);
                }
                if order == 0 {
                    (0..self.machine.springs.len())
                        .for_each(|i| join(knowns, &self.of(Quantity::Spring(i, 0)), Dependent));
                    (0..self.machine.stops.len())
                        .for_each(|i| join(knowns, &self.of(Quantity::Stop(i, 0)), Dependent));
                    let springs = self.machine.springs.iter().map(|x| format!("spring.{}", x.name));
                    let stops = self.machine.stops.iter().map(|x| format!("stop.{}", x.name));
                    springs.chain(stops).for_each(|section| self.of_section(&section, knowns));
                }
            }
            // Accounts of all that happens.
            Energy::Work | Energy::Lost | Energy::Residual => {
                let states = self.plan.assembly.states().iter();
                let states = states.flat_map(|&body| [0, 1].map(|order| Quantity::Body(body, order)));
                states.for_each(|state| put(knowns, self.references[&state], Dependent));
                self.anything_set(knowns);
                put(knowns, self.references[&Quantity::Time], Dependent);
            }
        }
    }

    /// Inputs and all parameters but starts.
    fn anything_set(&self, knowns: &mut Knowns) {
        self.inputs.values().for_each(|&input| put(knowns, input, Dependent));
        self.parameters.keys().for_each(|section| self.of_section(section, knowns));
    }

    /// An indicator is measured by the sizes of what it watches, which follow from all numbers and
    /// from what inputs have been.
    fn indicator(&self, place: usize, knowns: &mut Knowns) {
        let stops = self.machine.stops.iter().enumerate().flat_map(|(i, stop)| {
            let count = if let StopLaw::Rigid { .. } = stop.law { 1 } else { 2 };
            vec![(Quantity::Stop(i, 0), [Quantity::Stop(i, 1), Quantity::Stop(i, 2)]); count]
        });
        let frictions = (0..self.machine.frictions.len()).flat_map(|i| {
            vec![(Quantity::Friction(i, 1), [Quantity::Friction(i, 1), Quantity::Friction(i, 2)]); 3]
        });
        if let Some((first, others)) = stops.chain(frictions).nth(place) {
            let times = if self.inputs.is_empty() { Discrete } else { Dependent };
            [first].iter().chain(&others).for_each(|q| join(knowns, &self.of(*q), times));
        }
        self.anything_set(knowns);
    }
}

/// The unknowns of roles, in the table's order.
pub(crate) fn of_roles(plan: &Plan, roles: &[Role]) -> Vec<(u32, Quantity)> {
    let rows = (1..).zip(&plan.table.rows).filter(|(_, row)| roles.contains(&row.role));
    rows.map(|(reference, row)| (reference, row.quantity)).collect()
}
