//! Dependencies of signals, and of the motions that they prescribe.

use super::Structure;
use super::knowns::{Knowns, join, put};
use crate::table::Quantity;
use fmi_doors::DependencyKind::{Constant, Dependent};
use vibro_machine::Element;
use vibro_machine::description::{BodyKind, Friction, Interpolation, Signal};

impl Structure<'_> {
    /// Adds the time and input on which a signal's time derivative of an `order` depends. The
    /// caller adds the signal's parameters, which are in its section.
    pub(super) fn signal(&self, signal: &Signal, rate: f64, input: &str, order: usize, into: &mut Knowns) {
        let cubic = signal.table.as_ref().is_some_and(|table| table.interpolation == Interpolation::Cubic);
        let moves = match order {
            0 => !signal.harmonics.is_empty() || !signal.steps.is_empty() || rate != 0.0,
            _ => !signal.harmonics.is_empty(),
        };
        let moves = moves || !signal.sweeps.is_empty();
        if moves || signal.table.is_some() && (cubic || order == 0) {
            put(into, self.references[&Quantity::Time], Dependent);
        }
        if let Some(&reference) = self.inputs.get(input).filter(|_| order == 0) {
            put(into, reference, Constant);
        }
    }

    pub(super) fn prescribed(&self, body: usize, order: usize) -> Knowns {
        let mut knowns = Knowns::new();
        let name = &self.machine.bodies[body].name;
        match &self.machine.bodies[body].kind {
            BodyKind::Free(_) | BodyKind::Node(_) => return knowns,
            BodyKind::Prescribed { motion, rate } => {
                self.signal(motion, *rate, &format!("body.{name}.motion.input"), order, &mut knowns);
            }
            // An integral depends on time and, since the last point of a solver, on the input.
            BodyKind::Integrated(own) if order < own.level.order() => {
                put(&mut knowns, self.references[&Quantity::Time], Dependent);
                let input = format!("body.{name}.motion.{}.input", own.level.key());
                if let Some(&reference) = self.inputs.get(input.as_str()) {
                    put(&mut knowns, reference, Dependent);
                }
            }
            BodyKind::Integrated(own) => {
                let input = format!("body.{name}.motion.{}.input", own.level.key());
                self.signal(&own.signal, 0.0, &input, order - own.level.order(), &mut knowns);
            }
        }
        self.of_body_section(body, &mut knowns);
        knowns
    }

    /// Returns the knowns of an element's signals, including its parameters.
    pub(super) fn signals(&self, element: Element) -> Knowns {
        let (mut knowns, section) = (Knowns::new(), element.dotted());
        for (key, signal) in element.signals() {
            self.signal(signal, 0.0, &format!("{section}{key}.input"), 0, &mut knowns);
        }
        self.of_section(&section, &mut knowns);
        if let Element::Friction(Friction { follows: Some(follows), .. }) = element {
            let stop = self.force(Element::Stop(&self.machine.stops[follows.stop]));
            join(&mut knowns, &stop, Dependent);
        }
        knowns
    }
}
