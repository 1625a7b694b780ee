//! Dependencies of the energy balance.

use super::Structure;
use super::groups::is_free;
use super::knowns::{Knowns, join, put};
use crate::table::{Energy, Quantity};
use fmi_doors::DependencyKind::Dependent;
use vibro_machine::Element;
use vibro_machine::elements::Action;

impl Structure<'_> {
    pub(super) fn energy(&self, energy: Energy, knowns: &mut Knowns) {
        let free = (0..self.machine.bodies.len()).filter(|&body| is_free(self.machine, body));
        match energy {
            Energy::Kinetic | Energy::Stored => {
                let order = usize::from(energy == Energy::Kinetic);
                for body in free {
                    join(knowns, &self.coordinate(body, order), Dependent);
                    self.of_body_section(body, knowns);
                }
                if order == 0 {
                    let stores = |e: &&Element| {
                        matches!(
                            e.action(),
                            Action::Linear
                                | Action::Flexing
                                | Action::Switching
                                | Action::Pressing
                                | Action::Hitting
                        )
                    };
                    for &element in self.elements.iter().filter(stores) {
                        let mut own = self.of_element(element, 0);
                        for k in element.branches() {
                            self.tangent(element, k, 0, &mut own);
                            self.slider(element, k, &mut own);
                        }
                        self.steps(element, &mut own);
                        join(knowns, &own, Dependent);
                        self.of_section(&element.dotted(), knowns);
                    }
                }
            }
            // The accounts depend on the whole motion.
            Energy::Work | Energy::Lost | Energy::Switched | Energy::Residual => {
                for [state, _] in &self.plan.states {
                    put(knowns, self.references[&Quantity::Column(*state)], Dependent);
                }
                self.anything_set(knowns);
                put(knowns, self.references[&Quantity::Time], Dependent);
            }
        }
    }
}
