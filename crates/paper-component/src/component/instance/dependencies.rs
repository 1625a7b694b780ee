//! Dependencies of variables in the present contact.

use super::events::Present;
use super::{Engine, Instance, Outcome};
use crate::component::continuous::Continuous;
use crate::component::settings::Settings;
use crate::component::structure::{self, Unknown};
use crate::component::values::OutputValues;
use crate::component::variables::{Access, Causality, VARIABLES, Variable};
use fmi_doors::Dependency;
use vibro_impact::parameters::FIELDS;
use vibro_impact::simulator::{Contact, State};

/// Contacts, flight first.
const CONTACTS: [Contact; 3] = [Contact::Flight, Contact::RestUpper, Contact::RestLower];

impl Instance {
    /// Dependencies of a variable in the present contact, or, before the end of initialization,
    /// dependencies of its initial value. The result is a subset of the declared dependencies: box
    /// and block depend on each other's loads in rest, but not in flight.
    ///
    /// # Errors
    /// [`Reference`](fmi_doors::Problem::Reference) if no variable has the reference.
    pub(super) fn present_dependencies(&self, reference: u32) -> Outcome<Vec<Dependency>> {
        let variable = self.variable_of(reference)?;
        let place = self.numbering.place(reference);
        let initial = matches!(self.engine, Engine::None);
        let declared = if initial {
            structure::initial_unknowns(self.edition)
        } else {
            let derivatives = structure::derivatives(self.edition);
            let further = derivatives.into_iter().chain(structure::event_indicators());
            structure::outputs(self.edition).into_iter().chain(further).collect()
        };
        let list = match declared.into_iter().find(|unknown| unknown.place == place) {
            Some(Unknown { dependencies, .. }) => dependencies,
            None if variable.dimensions.is_empty() => Vec::new(),
            None => structure::declared(variable),
        };
        // At an event the contact after the event applies, since that is shown.
        let contact = match self.present() {
            Ok(Present::Simulation(simulator)) => Some(simulator.contact()),
            Ok(Present::Continuous(continuous)) => Some(continuous.contact()),
            _ => None,
        };
        let mut found = Vec::new();
        for (known, kind) in list {
            let Some(reference) = self.numbering.reference(known) else { continue };
            let entry = |element| Dependency { element, reference, kind };
            match (variable.access, contact) {
                (Access::Elements(get), _) => {
                    let contact = contact.unwrap_or_default();
                    let depends = |i| matters(&|values| get(values, i), &VARIABLES[known], contact);
                    found.extend((0..variable.size()).filter(|i| depends(*i)).map(|i| entry(i + 1)));
                }
                (Access::Output(reading), Some(contact)) => {
                    let depends = |contact| matters(&reading.value, &VARIABLES[known], contact);
                    // A dependency that does not exist in any contact at a given time comes from
                    // accumulation in time, and is kept.
                    if depends(contact) || !CONTACTS.into_iter().any(depends) {
                        found.push(entry(0));
                    }
                }
                _ => found.push(entry(0)),
            }
        }
        Ok(found)
    }
}

/// Whether a value changes with a known in a contact, evaluated at a point without accidental
/// cancellation.
fn matters(value: &dyn Fn(&OutputValues) -> f64, known: &Variable, contact: Contact) -> bool {
    const NUDGE: f64 = 0.01;
    const ROUNDING: f64 = 1e-10; // all factors at that point are above 0.01
    let (mut settings, mut time) = (generic(contact), 0.37);
    let before = evaluate(&settings, time, contact);
    if known.causality == Causality::Independent {
        time += NUDGE;
    } else if let Access::Setting { get, set } | Access::Start { get, set, .. } = known.access {
        let nudged = get(&settings) + NUDGE;
        set(&mut settings, nudged);
    }
    match (before, evaluate(&settings, time, contact)) {
        (Some(before), Some(after)) => (value(&before) - value(&after)).abs() > ROUNDING,
        _ => true,
    }
}

/// Parameters, states and loads without zeros or equal numbers; in rest the block presses on the
/// stop.
fn generic(contact: Contact) -> Settings {
    let mut settings = Settings::default();
    for (i, field) in FIELDS.iter().enumerate() {
        (field.set)(&mut settings.parameters, 0.61 + 0.023 * i as f64);
    }
    settings.start = State { x: [0.11, 0.23, -0.31], v: [0.43, -0.53, 0.67] };
    let press = 20.0 * contact.side();
    for (load, value) in settings.loads.derivatives.iter_mut().zip([0.071, 0.083 + press, -0.097]) {
        load[0] = value;
    }
    settings
}

fn evaluate(settings: &Settings, time: f64, contact: Contact) -> Option<OutputValues> {
    let forces = settings.loads.derivatives.map(|load| load[0]);
    Some(Continuous::at(&settings.parameters, settings.start, time, contact, forces).ok()?.values())
}
