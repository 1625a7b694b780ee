//! Dependencies of event indicators.

use super::Structure;
use super::knowns::{Knowns, join};
use crate::table::slides;
use fmi_doors::DependencyKind::{Dependent, Discrete};
use vibro_machine::description::{Description, Stop, StopLaw};
use vibro_machine::elements::Action;
use vibro_machine::{Element, What};

impl<'a> Structure<'a> {
    /// Adds the knowns of an event indicator. An indicator is divided by the size of its event
    /// function, which depends on all parameters and on past inputs.
    pub(super) fn indicator(&self, place: usize, knowns: &mut Knowns) {
        let of_element = |element: &Element<'a>| {
            let (count, first) = match element.action() {
                Action::Switching if matches!(element, Element::Spring(_)) => (0, 0),
                Action::Hitting => (1, 0),
                Action::Switching | Action::Pressing => (2, 0),
                Action::Rubbing => (3, 1),
                Action::Linear if slides(*element) => (2, 0),
                Action::Linear | Action::Flexing | Action::Tying | Action::Driving => (0, 0),
                Action::Giving | Action::Computing => (0, 0),
            };
            vec![(*element, first); count]
        };
        // Corners come after all stops and contacts, then freewheels, then friction.
        let corners = self.elements.iter().flat_map(|element| match element {
            Element::Spring(spring) => vec![(*element, 0); spring.points.len().saturating_sub(2)],
            _ => Vec::new(),
        });
        let blocks = self.elements.len() - self.machine.blocks.len();
        let limits = self.machine.limits_of_outputs();
        let contacts = 2 * self.machine.contacts.len();
        let first = contacts + stops_before(self.machine, self.machine.stops.len() + self.machine.corners());
        if let Some(((block, output), _)) = place.checked_sub(first).and_then(|own| limits.get(own)) {
            join(knowns, &self.of_block(blocks + block, What::Output(*output)), Dependent);
            return self.anything_set(knowns);
        }
        let place = if place >= first { place - limits.len() } else { place };
        // Slider indicators come last.
        let is_spring = |element: &&Element| matches!(element, Element::Spring(_));
        let rubs = |element: &&Element| element.action() == Action::Rubbing;
        let is_stop = |element: &&Element| matches!(element, Element::Stop(_));
        let is_contact = |element: &&Element| matches!(element, Element::Contact(_));
        let is_wheel = |element: &&Element| matches!(element, Element::Freewheel(_));
        let all = self.elements.iter();
        let stops = all.clone().filter(is_stop).flat_map(of_element);
        let wheels = all.clone().filter(is_wheel).flat_map(of_element);
        let frictions = all.clone().filter(|own| rubs(own) && !is_spring(own)).flat_map(of_element);
        let contacts = all.clone().filter(is_contact).flat_map(of_element);
        let of_tangents = |own: &Element<'a>| own.tangents().len() * 2;
        let rubbing = all.clone().flat_map(|own| vec![(*own, 0); of_tangents(own)]);
        let sliders = all.filter(is_spring).flat_map(of_element).chain(rubbing);
        if let Some((element, first)) =
            stops.chain(contacts).chain(corners).chain(wheels).chain(frictions).chain(sliders).nth(place)
        {
            let is_curved = self.elements.iter().any(|own| own.is_curved());
            let times = if self.inputs.is_empty() && !is_curved { Discrete } else { Dependent };
            (first..3).for_each(|order| join(knowns, &self.of_element(element, order), times));
        }
        self.anything_set(knowns);
    }
}

/// Returns the number of indicators of all stops and corners, `count` in total.
fn stops_before(machine: &Description, count: usize) -> usize {
    let compliant = |stop: &&Stop| matches!(stop.law, StopLaw::Compliant { .. });
    count + machine.stops.iter().filter(compliant).count()
}
