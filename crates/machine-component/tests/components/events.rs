//! Messages of events: every state of a contact that changes at an event is reported by name, but
//! not turns of stops without a dashpot in the rebound, and friction that follows a stop.

use crate::plans;
use crate::solver::{Silent, get, set};
use fmi_doors::log::{Category, Log};
use fmi_doors::{Component, EventHandling, Interface, Life, Model};
use std::collections::HashSet;
use std::sync::Arc;
use vibro_machine_component::{FILE, Machine, Plan, Quantity};

/// Largest number of events of a machine.
const EVENTS: usize = 60;

#[derive(Default)]
struct Told(Vec<String>);

impl Log for Told {
    fn wants(&self, category: Category) -> bool {
        category == Category::Events
    }

    fn log(&mut self, _: Category, message: &str) {
        self.0.push(message.to_owned());
    }
}

/// The states of stops and frictions, with their names in messages.
fn states(machine: &mut Machine, plan: &Plan) -> Vec<(String, f64)> {
    let own = |quantity| match quantity {
        Quantity::StopState(i) => Some(plan.assembly.name_of_stop(i)),
        Quantity::FrictionState(i) => Some(plan.assembly.name_of_friction(i)),
        Quantity::SliderState(i) => Some(plan.assembly.name_of_branch(i)),
        _ => None,
    };
    let rows =
        (1..).zip(&plan.table.rows).filter_map(|(reference, row)| Some((reference, row, own(row.quantity)?)));
    rows.map(|(reference, row, name)| {
        assert!(row.name.ends_with(".state"));
        (format!("{name} "), get(machine, reference).unwrap())
    })
    .collect()
}

#[test]
fn invariant_every_state_that_changes_at_an_event_is_told_by_name() {
    let mut changes = HashSet::new();
    for plan in plans() {
        let handling = EventHandling { event_mode: true, early_return: true };
        let mut machine = Machine::new(plan.clone(), Life::new(Interface::CoSimulation, handling));
        let end = plan.description().experiment.stop_time;
        machine.set_experiment(None, 0.0, None).unwrap();
        machine.enter_initialization();
        machine.exit_initialization(&mut Silent).unwrap();
        machine.leave_event(&mut Silent).unwrap();
        for _ in 0..EVENTS {
            let now = machine.time();
            let before = states(&mut machine, &plan);
            let mut told = Told::default();
            if now >= end || !machine.step_as_agreed(now, end - now, &mut told).unwrap().event {
                break;
            }
            assert_eq!(states(&mut machine, &plan), before, "{} at {}", plan.name(), machine.time());
            machine.enter_event().unwrap();
            machine.handle_events(&mut told).unwrap();
            for ((name, was), (_, is)) in before.into_iter().zip(states(&mut machine, &plan)) {
                let is_told = told.0.iter().any(|text| text.starts_with(&name));
                // Pressed (4) and rebounding (7).
                let turns = [was.min(is), was.max(is)] == [4.0, 7.0];
                // A friction that follows a stop starts and stops acting with the stop's force.
                let with_stop = name.starts_with("friction.rub") && was.min(is) == 1.0;
                // The sliders of two tangents are told with the contact that closes or opens (1).
                let contact = name.split_once('[').map(|own| format!("{} ", own.0));
                let with_contact = contact.filter(|_| was.min(is) == 1.0);
                let with_contact =
                    with_contact.is_some_and(|of| told.0.iter().any(|text| text.starts_with(&of)));
                let is_told = is_told
                    || with_contact
                    || with_stop && told.0.iter().any(|text| text.starts_with("stop.pad "));
                // A contact that leaves its gap (3) after its force has ended (5) was reported
                // when the force ended.
                let leaves = (was, is) == (5.0, 3.0);
                assert!(
                    was == is || is_told || turns || leaves,
                    "{}: {name}{was} to {is}: {:?}",
                    plan.name(),
                    told.0
                );
                changes.extend((was != is).then_some((name.starts_with("stop"), was as u8, is as u8)));
            }
            machine.leave_event(&mut Silent).unwrap();
        }
    }
    // The changes include an `ElastoGap`: pressed (4) and capped (6).
    assert!(changes.contains(&(true, 4, 6)) || changes.contains(&(true, 6, 4)), "{changes:?}");
    assert!(changes.len() > 12, "{changes:?}");
}

/// The first sample reads an input that is set in initialization; samples are not lines of the
/// log.
#[test]
fn closed_form_the_first_sample_reads_the_inputs_of_initialization() {
    let text = r#"
        name = "Sampled"
        body.mass = { mass = 1.0 }
        spring.k = { between = ["ground", "mass"], stiffness = 100.0 }
        signal.level = { input = true }
        block.c = { inputs = ["level"], d = [[1.5]], outputs = ["y"], sample = 0.1 }
        load.push = { on = "mass", from = "c.y" }
    "#;
    let plan = Arc::new(Plan::new(text.into(), FILE).unwrap());
    let place = |name: &str| 1 + plan.table.rows.iter().position(|row| row.name == name).unwrap() as u32;
    for interface in [Interface::CoSimulation, Interface::ModelExchange] {
        let mut machine = Machine::new(plan.clone(), Life::new(interface, EventHandling::default()));
        machine.set_experiment(None, 0.0, None).unwrap();
        machine.enter_initialization();
        assert!(set(&mut machine, place("signal.level.input"), 4.0));
        let mut told = Told::default();
        machine.exit_initialization(&mut told).unwrap();
        assert_eq!(get(&mut machine, place("c.y")), Some(6.0));
        if interface == Interface::CoSimulation {
            machine.step_as_agreed(0.0, 0.35, &mut told).unwrap();
            assert!(told.0.is_empty(), "{:?}", told.0);
        }
    }
}
