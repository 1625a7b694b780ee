//! The event indicators, as variables.

use super::{Quantity, Role, VariableTable, slides};
use vibro_machine::description::StopLaw;
use vibro_machine::{Description, Element, What};

impl VariableTable {
    /// Adds the event indicators in the order of `Motion::indicators`.
    pub(super) fn indicators(&mut self, machine: &Description) {
        let mut push = |name: String, meaning: &str| {
            let place = self.indicators.len();
            self.push(name, meaning, "1", Role::Local, Quantity::Indicator(place));
            self.indicators.push(self.rows.len() as u32);
        };
        for stop in &machine.stops {
            let name = format!("{}.indicator", stop.name);
            match stop.law {
                StopLaw::Rigid { .. } => push(name, "Negative where the stop is to close or to open"),
                StopLaw::Compliant { .. } => {
                    push(
                        format!("{name}.edge"),
                        "Negative where the stop is met or left, or its force capped",
                    );
                    push(format!("{name}.force"), "Negative where the force ends or begins");
                }
            }
        }
        for contact in &machine.contacts {
            let name = format!("{}.indicator", contact.name);
            push(format!("{name}.edge"), "Negative where the contact closes or opens");
            push(format!("{name}.force"), "Negative where the force ends or begins");
        }
        for spring in &machine.springs {
            for corner in 1..spring.points.len().saturating_sub(1) {
                let name = format!("{}.indicator.points[{corner}]", spring.name);
                push(name, "Negative where the corner is to be passed");
            }
        }
        for (place, is_upper) in machine.limits_of_outputs() {
            let side = if is_upper { "upper" } else { "lower" };
            let name = format!("{}.indicator.{side}", machine.name_of_output(place));
            push(name, "Negative where the output comes to the limit or leaves it");
        }
        for wheel in &machine.freewheels {
            let name = format!("{}.indicator", wheel.name);
            push(name, "Negative where the freewheel is to engage or to let go");
        }
        for friction in &machine.frictions {
            let name = format!("{}.indicator", friction.name);
            push(format!("{name}.up"), "Negative where slipping ends, or begins upwards");
            push(format!("{name}.down"), "Negative where slipping begins downwards");
            push(format!("{name}.level"), "Negative where friction begins or ceases to act");
        }
        for spring in machine.springs.iter().filter(|spring| slides(Element::Spring(spring))) {
            let name = format!("{}.indicator", spring.name);
            push(format!("{name}.up"), "Negative where slipping ends, or begins upwards");
            push(format!("{name}.down"), "Negative where slipping begins downwards");
        }
        for contact in &machine.contacts {
            for k in Element::Contact(contact).branches() {
                let name = format!("{}.{}.indicator", contact.name, What::Slider(k).word());
                push(format!("{name}.up"), "Negative where slipping ends, or begins upwards");
                push(format!("{name}.down"), "Negative where slipping begins downwards");
            }
        }
    }
}
