//! The dependencies of `ModelStructure` (FMI 2.0, 2.2.8; FMI 3.0.2, 2.4.8). The dependencies
//! follow from the machine's topology and never from its numbers, which a host may change.
//!
//! Between events every coordinate, elongation and force is linear in states and inputs, with
//! factors that depend on the mode; curved forces are the exception. Bodies that links, rigid
//! stops or friction may hold together form a group: a force on one of them accelerates all.

mod blocks;
mod energy;
mod groups;
mod indicators;
mod initial;
mod knowns;
mod signals;

use crate::plan::Plan;
use crate::table::{Quantity, Role, SLIDERS, slides};
use fmi_doors::DependencyKind;
use fmi_doors::DependencyKind::{Constant, Dependent, Discrete, Fixed, Tunable};
use fmi_doors::description::Unknown;
use groups::{Group, bodies_of, groups, holds, is_free};
use knowns::{Knowns, join, put};
use std::collections::HashMap;
use vibro_machine::description::{Arms, BodyKind, Description, Spring, Stop};
use vibro_machine::elements::Action;
use vibro_machine::system::Part;
use vibro_machine::{Element, Owner, What};

/// Largest number of entries of all dependency lists of one kind, at about 10 bytes each. If there
/// are more, lists longer than the average are left out, which in FMI means a dependency on every
/// known.
const ENTRIES: usize = 200_000;

/// The dependencies of a machine's variables.
pub(crate) struct Structure<'a> {
    plan: &'a Plan,
    machine: &'a Description,
    elements: Vec<Element<'a>>,
    /// Value references of the parameters of each section and name, such as `body.box`, with the
    /// rest of their names.
    parameters: HashMap<&'a str, Vec<(u32, &'a str)>>,
    references: HashMap<Quantity, u32>,
    inputs: HashMap<&'a str, u32>,
    group_of: Vec<usize>,
    /// Group of each body if only links hold bodies together.
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
                Quantity::Parameter(place) => {
                    let own = plan.table.parameters[place].name.as_str();
                    // A named parameter counts as all numbers that follow from it.
                    for name in std::iter::once(own).chain(machine.named.numbers_of(own)) {
                        let second = name.match_indices('.').nth(1).map_or(name.len(), |dot| dot.0);
                        let (section, rest) = name.split_at(second);
                        parameters.entry(section).or_default().push((reference, rest));
                    }
                }
                Quantity::Input(_) => _ = inputs.insert(row.name.as_str(), reference),
                _ => {}
            }
        }
        let elements: Vec<Element> = machine.elements().collect();
        let arms = |is: &dyn Fn(Action) -> bool| -> Vec<&Arms> {
            elements
                .iter()
                .filter(|element| is(element.action()))
                .filter_map(|element| element.arms())
                .collect()
        };
        let linked = groups(machine, &arms(&|action| action == Action::Tying));
        let group_of = groups(machine, &arms(&holds));
        let groups = HashMap::new();
        let mut structure =
            Self { plan, machine, elements, parameters, references, inputs, group_of, linked, groups };
        structure.find_groups();
        structure
    }

    /// Returns the dependency lists of unknowns, for initialization if `initially`. If all lists
    /// together exceed [`ENTRIES`], lists longer than an equal share of it are left out.
    pub(crate) fn unknowns(&self, unknowns: &[(u32, Quantity)], initially: bool) -> Vec<Unknown> {
        let list = |&(reference, quantity): &(u32, Quantity)| {
            let knowns =
                if initially { self.initially(quantity) } else { self.as_of_a_solver(self.of(quantity)) };
            (reference, knowns)
        };
        let lists: Vec<(u32, Knowns)> = unknowns.iter().map(list).collect();
        let total: usize = lists.iter().map(|(_, knowns)| knowns.len()).sum();
        let most = if total > ENTRIES { ENTRIES / unknowns.len() } else { total };
        // Residual flexibility couples all elements on its nodes: without a list, an unknown
        // depends on every known.
        let is_coupled = self.machine.modals.iter().any(|modal| modal.residual.is_some());
        let unknown = |(reference, knowns): (u32, Knowns)| Unknown {
            reference,
            dependencies: (knowns.len() <= most && !is_coupled).then(|| knowns.into_iter().collect()),
        };
        lists.into_iter().map(unknown).collect()
    }

    /// Returns the knowns for a solver: time replaces the states and outputs of sampled blocks,
    /// which are not continuous states.
    fn as_of_a_solver(&self, mut knowns: Knowns) -> Knowns {
        let before = knowns.len();
        knowns.retain(|known, _| self.plan.table.rows[*known as usize - 1].role != Role::Discrete);
        if knowns.len() < before {
            put(&mut knowns, self.references[&Quantity::Time], Dependent);
        }
        knowns
    }

    /// Adds the parameters of a section except start values.
    fn of_section(&self, section: &str, into: &mut Knowns) {
        let all = self.parameters.get(section).into_iter().flatten();
        all.filter(|(_, rest)| !rest.starts_with(".start") && !SLIDERS.contains(rest))
            .for_each(|(reference, _)| put(into, *reference, Dependent));
    }

    /// Returns the section of a body's numbers.
    fn section_of(&self, body: usize) -> String {
        let body = &self.machine.bodies[body];
        match body.name.split_once('.') {
            Some((of, _)) if body.is_inner() => format!("modal.{of}"),
            _ => format!("body.{}", body.name),
        }
    }

    fn of_body_section(&self, body: usize, into: &mut Knowns) {
        self.of_section(&self.section_of(body), into);
        if is_free(self.machine, body) {
            self.of_section("gravity", into);
        }
    }

    /// Returns the knowns of a body's coordinate (`order` 0) or rate (1).
    fn coordinate(&self, body: usize, order: usize) -> Knowns {
        if let BodyKind::Node(_) = self.machine.bodies[body].kind {
            return self.of_node(body, |coordinate| self.coordinate(coordinate, order));
        }
        if !is_free(self.machine, body) {
            return self.prescribed(body, order);
        }
        let mut knowns = Knowns::new();
        let states = self.plan.assembly.states();
        if states.contains(&body) {
            put(&mut knowns, self.references[&Quantity::of_body(body, order)], Constant);
        } else {
            self.by_links(body, order, &mut knowns);
        }
        if let Some(group) = self.groups.get(&self.group_of[body]).filter(|g| order == 1 || g.is_tied) {
            join(&mut knowns, &group.jumps, Dependent);
        }
        knowns
    }

    /// Returns the knowns of a node's quantity, from the knowns of its body's coordinates.
    fn of_node(&self, node: usize, of: impl Fn(usize) -> Knowns) -> Knowns {
        let mut knowns = Knowns::new();
        for coordinate in self.machine.behind(node) {
            join(&mut knowns, &of(coordinate), Constant);
        }
        knowns
    }

    /// Adds the knowns of the coordinate or rate of a body that links determine from other bodies.
    fn by_links(&self, body: usize, order: usize, knowns: &mut Knowns) {
        let own = self.linked[body];
        for &state in self.plan.assembly.states().iter().filter(|&&state| self.linked[state] == own) {
            put(knowns, self.references[&Quantity::of_body(state, order)], Fixed);
        }
        for &link in self.elements.iter().filter(|element| element.action() == Action::Tying) {
            let Some(arms) = link.arms() else { continue };
            let mut bodies = bodies_of(self.machine, arms);
            if bodies.any(|body| is_free(self.machine, body) && self.linked[body] == own) {
                self.of_section(&link.dotted(), knowns);
                let all = bodies_of(self.machine, arms);
                for other in all.filter(|&body| !is_free(self.machine, body)) {
                    join(knowns, &self.prescribed(other, order), Fixed);
                }
            }
        }
    }

    /// Adds the knowns of an element's elongation (`order` 0) or its rate (1).
    fn elongation(&self, element: Element, order: usize, knowns: &mut Knowns) {
        let Some(arms) = element.arms() else { return };
        self.along(element, arms, order, knowns);
    }

    /// Adds the knowns of a contact's elongation along a tangent, or of its rate.
    fn tangent(&self, element: Element, k: Option<usize>, order: usize, knowns: &mut Knowns) {
        if let Some(tangent) = element.tangents().get(k.unwrap_or_default()) {
            self.along(element, &tangent.arms, order, knowns);
        }
    }

    fn along(&self, element: Element, arms: &Arms, order: usize, knowns: &mut Knowns) {
        for &(body, _) in &arms.terms {
            let times = if arms.levers { Fixed } else { Constant };
            join(knowns, &self.coordinate(body, order), times);
        }
        let parameters = self.parameters.get(element.dotted().as_str()).into_iter().flatten();
        let levers = parameters.filter(|(_, rest)| rest.contains(".arms."));
        levers.for_each(|(reference, _)| put(knowns, *reference, Dependent));
    }

    /// Returns the knowns of an element's force.
    fn force(&self, element: Element) -> Knowns {
        match element.action() {
            Action::Linear if slides(element) => self.elastic(element, Discrete),
            Action::Linear if element.is_curved() => self.elastic(element, Dependent),
            Action::Linear => self.elastic(element, Tunable),
            Action::Switching => {
                let times = if element.is_curved() { Dependent } else { Discrete };
                let mut knowns = self.elastic(element, times);
                self.steps(element, &mut knowns);
                knowns
            }
            Action::Pressing => self.elastic(element, Discrete),
            Action::Hitting => self.holding(element),
            Action::Rubbing => {
                let mut knowns = self.holding(element);
                join(&mut knowns, &self.signals(element), Discrete);
                // Friction that depends on the rate is not linear in any of its knowns.
                if element.rubs_by_rate() {
                    knowns.values_mut().for_each(|kind| *kind = Dependent);
                }
                knowns
            }
            Action::Driving => self.driving(element),
            Action::Flexing | Action::Tying | Action::Giving | Action::Computing => self.signals(element),
        }
    }

    /// Returns the knowns of a force that depends on elongation and rate; `times` is the kind of
    /// its derivatives.
    fn elastic(&self, element: Element, times: DependencyKind) -> Knowns {
        self.elastic_along(element, element.branches(), times)
    }

    /// As [`elastic`](Self::elastic), with some of the element's inner places.
    fn elastic_along(
        &self,
        element: Element,
        branches: impl Iterator<Item = Option<usize>> + Clone,
        times: DependencyKind,
    ) -> Knowns {
        let (mut own, mut knowns) = (Knowns::new(), Knowns::new());
        // The force of a damper does not depend on its elongation.
        let first = usize::from(matches!(element, Element::Damper(_)));
        for order in first..2 {
            self.elongation(element, order, &mut own);
            branches.clone().for_each(|k| self.tangent(element, k, order, &mut own));
        }
        branches.for_each(|k| self.slider(element, k, &mut own));
        join(&mut knowns, &own, times);
        self.of_section(&element.dotted(), &mut knowns);
        knowns
    }

    /// Adds a dependency on time if the stiffness is switched in time.
    fn steps(&self, element: Element, knowns: &mut Knowns) {
        if let Element::Spring(Spring { stepped: Some(_), .. })
        | Element::Stop(Stop { stepped: Some(_), .. }) = element
        {
            put(knowns, self.references[&Quantity::Time], Dependent);
        }
    }

    /// Adds the inner place of a spring in series or of a contact.
    fn slider(&self, element: Element, k: Option<usize>, knowns: &mut Knowns) {
        if let Some(i) = self.elements.iter().position(|own| *own == element) {
            put(knowns, self.references[&slider_of(i, k)], Constant);
        }
    }

    /// Returns the knowns of an inner place's rate: with a dashpot, the knowns of the spring's
    /// force; with a slider, the knowns of e', which the place follows while the slider slips.
    fn slider_rate(&self, element: Element, k: Option<usize>) -> Knowns {
        let (mut own, mut knowns) = (Knowns::new(), Knowns::new());
        if slides(element) {
            self.elongation(element, 1, &mut own);
            self.tangent(element, k, 1, &mut own);
            join(&mut knowns, &own, Discrete);
            // These parameters determine whether the slider slips.
            self.of_section(&element.dotted(), &mut knowns);
            return knowns;
        }
        self.elongation(element, 0, &mut own);
        self.slider(element, k, &mut own);
        join(&mut knowns, &own, Tunable);
        self.of_section(&element.dotted(), &mut knowns);
        knowns
    }

    /// Returns the knowns of a constraint force: the knowns of its bodies' accelerations.
    fn holding(&self, element: Element) -> Knowns {
        let mut knowns = Knowns::new();
        for body in element.arms().into_iter().flat_map(|arms| bodies_of(self.machine, arms)) {
            match self.groups.get(&self.group_of[body]) {
                Some(group) => join(&mut knowns, &group.forces, Discrete),
                None => join(&mut knowns, &self.prescribed(body, 2), Discrete),
            }
        }
        self.of_section(&element.dotted(), &mut knowns);
        knowns
    }

    /// Returns the knowns of an element's elongation, rate or force, for `order` 0, 1 or 2.
    fn of_element(&self, element: Element, order: usize) -> Knowns {
        if order > 1 {
            return self.force(element);
        }
        let mut knowns = Knowns::new();
        self.elongation(element, order, &mut knowns);
        knowns
    }

    /// Returns the i-th element that satisfies a condition.
    fn nth(&self, is: fn(&Element) -> bool, i: usize) -> Option<Element<'a>> {
        self.elements.iter().copied().filter(is).nth(i)
    }

    /// Returns the knowns of a variable.
    pub(crate) fn of(&self, quantity: Quantity) -> Knowns {
        let mut knowns = Knowns::new();
        match quantity {
            Quantity::Column(column) => return self.column(column),
            Quantity::StopState(i) | Quantity::Impacts(i) | Quantity::Impulse(i) => {
                let place = self.plan.assembly.system().element_of(Part::Stop(i));
                let stop = self.elements.get(place).copied();
                let all = stop.into_iter().flat_map(|stop| (0..3).map(move |k| self.of_element(stop, k)));
                all.for_each(|of| join(&mut knowns, &of, Dependent));
            }
            Quantity::FrictionState(i) => {
                let friction = self.nth(|element| matches!(element, Element::Friction(_)), i);
                let all = friction.into_iter().flat_map(|own| (1..3).map(move |k| self.of_element(own, k)));
                all.for_each(|of| join(&mut knowns, &of, Dependent));
            }
            Quantity::Line(i) => {
                (0..2).for_each(|k| join(&mut knowns, &self.of_element(self.elements[i], k), Dependent));
                self.of_section(&self.elements[i].dotted(), &mut knowns);
            }
            Quantity::SliderState(i) => {
                let place = self.plan.assembly.system().element_of(Part::Branch(i));
                let own = self.elements.get(place).copied();
                let all = own.into_iter().flat_map(|own| (0..3).map(move |k| self.of_element(own, k)));
                all.for_each(|of| join(&mut knowns, &of, Dependent));
            }
            Quantity::Energy(energy) => self.energy(energy, &mut knowns),
            Quantity::Indicator(place) => self.indicator(place, &mut knowns),
            Quantity::Following(i) => {
                for name in self.machine.named.sources_of(&self.plan.table.following[i].name) {
                    let source = self.plan.table.reference(name);
                    source.into_iter().for_each(|source| put(&mut knowns, source, Dependent));
                }
            }
            Quantity::Time
            | Quantity::Parameter(_)
            | Quantity::Input(_)
            | Quantity::Transition
            | Quantity::Response
            | Quantity::ByParameters => {}
        }
        knowns
    }

    fn column(&self, column: vibro_machine::Quantity) -> Knowns {
        match (column.owner, column.what) {
            (Owner::Body(body), What::A) if is_free(self.machine, body) => {
                self.groups[&self.group_of[body]].forces.clone()
            }
            (Owner::Body(body), What::A) => match self.machine.bodies[body].kind {
                BodyKind::Node(_) => {
                    self.of_node(body, |own| self.groups[&self.group_of[own]].forces.clone())
                }
                _ => self.prescribed(body, 2),
            },
            (Owner::Body(body), what) => self.coordinate(body, usize::from(what == What::V)),
            (Owner::Element(i), What::E) => self.of_element(self.elements[i], 0),
            (Owner::Element(i), What::Rate) => self.of_element(self.elements[i], 1),
            (Owner::Element(i), What::TangentE(k)) => {
                let mut knowns = Knowns::new();
                self.tangent(self.elements[i], k, 0, &mut knowns);
                knowns
            }
            (Owner::Element(i), What::TangentF(k)) => {
                self.elastic_along(self.elements[i], std::iter::once(k), Discrete)
            }
            (Owner::Element(i), What::Slider(k)) => {
                let mut knowns = Knowns::new();
                self.slider(self.elements[i], k, &mut knowns);
                knowns
            }
            (Owner::Element(i), What::SliderRate(k)) => self.slider_rate(self.elements[i], k),
            (Owner::Element(i), What::Value) => self.signals(self.elements[i]),
            (Owner::Element(i), What::Output(_) | What::State(_) | What::StateRate(_)) => {
                self.of_block(i, column.what)
            }
            (Owner::Element(i), _) => self.of_element(self.elements[i], 2),
        }
    }

    /// Adds the inputs and all parameters except start values.
    fn anything_set(&self, knowns: &mut Knowns) {
        self.inputs.values().for_each(|&input| put(knowns, input, Dependent));
        self.parameters.keys().for_each(|section| self.of_section(section, knowns));
    }
}

/// Returns an inner place of an element, by the element's index.
fn slider_of(i: usize, k: Option<usize>) -> Quantity {
    Quantity::Column(vibro_machine::Quantity::of_element(i, What::Slider(k)))
}

/// Returns the variables of some roles, in the table's order.
pub(crate) fn of_roles(plan: &Plan, roles: &[Role]) -> Vec<(u32, Quantity)> {
    let rows = (1..).zip(&plan.table.rows).filter(|(_, row)| roles.contains(&row.role));
    rows.map(|(reference, row)| (reference, row.quantity)).collect()
}
