//! Dependencies in initialization, when the states follow from start values (FMI 3.0.2, 2.4.8,
//! `InitialUnknown`).

use super::Structure;
use super::knowns::{Knowns, put};
use crate::table::{Quantity, slides};
use fmi_doors::DependencyKind::Dependent;
use vibro_machine::Quantity as Column;
use vibro_machine::elements::Action;
use vibro_machine::{Element, Owner, What};

impl Structure<'_> {
    /// Returns the knowns of a variable in initialization: its knowns by [`of`](Self::of), with
    /// each state replaced by the knowns of its start.
    pub(super) fn initially(&self, quantity: Quantity) -> Knowns {
        let mut knowns = Knowns::new();
        if let Quantity::Column(Column { owner: Owner::Element(i), what: What::SliderRate(k) }) = quantity {
            // The start of the slider decides whether the slider slips.
            self.start_of_slider(i, k, &mut knowns);
        }
        for (known, _) in self.of(quantity) {
            let quantity = self.plan.table.rows[known as usize - 1].quantity;
            match (quantity.as_body(), quantity) {
                (Some((body, order)), _) => self.start(body, order, &mut knowns),
                (None, Quantity::Column(Column { what: What::State(_), .. })) => {
                    self.start_of_block(&mut knowns);
                }
                (None, Quantity::Column(Column { owner: Owner::Element(i), what: What::Slider(k) })) => {
                    self.start_of_slider(i, k, &mut knowns);
                }
                _ => put(&mut knowns, known, Dependent),
            }
        }
        knowns
    }

    /// Adds the knowns of an inner place's initial value: its start value, or the elongation in
    /// equilibrium.
    fn start_of_slider(&self, i: usize, k: Option<usize>, knowns: &mut Knowns) {
        if self.machine.starts_at_rest {
            return self.parameters.keys().for_each(|section| self.of_section(section, knowns));
        }
        let section = self.elements[i].dotted();
        let all = self.parameters.get(section.as_str()).into_iter().flatten();
        let is_own = |rest: &str| rest.strip_prefix('.') == Some(What::Slider(k).word());
        all.filter(|(_, rest)| is_own(rest)).for_each(|(known, _)| put(knowns, *known, Dependent));
        if slides(self.elements[i]) {
            // The slider is moved until the force does not exceed its level.
            self.of_section(&section, knowns);
            let mut of_elongation = Knowns::new();
            self.elongation(self.elements[i], 0, &mut of_elongation);
            self.tangent(self.elements[i], k, 0, &mut of_elongation);
            for known in of_elongation.into_keys() {
                match self.plan.table.rows[known as usize - 1].quantity.as_body() {
                    Some((body, order)) => self.start_alone(body, order, knowns),
                    None => put(knowns, known, Dependent),
                }
            }
        }
    }

    /// Adds the knowns of a state's initial value: its start value, or equilibrium under all
    /// loads. For a rate, adds the impacts of the first instant as well.
    fn start(&self, body: usize, order: usize, knowns: &mut Knowns) {
        self.start_alone(body, order, knowns);
        let group = &self.groups[&self.group_of[body]];
        if order == 0 || !group.hits {
            return;
        }
        let mut of_impacts = group.forces.clone();
        let may_touch = |e: &&Element| matches!(e.action(), Action::Hitting | Action::Switching);
        for &stop in self.elements.iter().filter(may_touch) {
            if self.groups_of(stop).contains(&self.group_of[body]) {
                (0..2).for_each(|order| self.elongation(stop, order, &mut of_impacts));
            }
        }
        for known in of_impacts.into_keys() {
            match self.plan.table.rows[known as usize - 1].quantity.as_body() {
                Some((body, order)) => self.start_alone(body, order, knowns),
                None => put(knowns, known, Dependent),
            }
        }
    }

    fn start_alone(&self, body: usize, order: usize, knowns: &mut Knowns) {
        if self.machine.starts_at_rest {
            self.parameters
                .keys()
                .filter(|_| order == 0)
                .for_each(|section| self.of_section(section, knowns));
            return;
        }
        let (section, own) = (self.section_of(body), &self.machine.bodies[body]);
        let place = own.name.split_once(".q").filter(|_| own.is_inner()).map_or("", |(_, place)| place);
        let words = if own.is_inner() { [".start.q", ".start.v"] } else { [".start.s", ".start.v"] };
        let name = format!("{}{place}", words[order]);
        let all = self.parameters.get(section.as_str()).into_iter().flatten();
        all.filter(|(_, rest)| *rest == name).for_each(|(known, _)| put(knowns, *known, Dependent));
    }
}
