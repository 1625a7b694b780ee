//! Sampled blocks: their state is discrete, and is not a state of a host's solver.

use crate::plans;
use crate::solver::{Silent, Solver, get};
use fmi_doors::description::{Kind, Variability};
use fmi_doors::{Component, EventHandling, Interface, Life, Model};
use std::sync::Arc;
use vibro_machine_component::{FILE, Machine, Plan, Role};

/// A cart under a sampled controller with one state, whose output acts 3 ms after its sample.
const CART: &str = r#"
    name = "Cart"
    body.cart = { mass = 2.0, start = { s = 0.1 } }
    block.pd = { inputs = ["cart.s", "cart.v"], states = 1, a = [[0.5]], b = [[1.0, 0.0]], c = [[-30.0]], d = [[-60.0, -9.0]], outputs = ["u"], sample = "10 ms", delay = "3 ms" }
    load.motor = { on = "cart", from = "pd.u" }
"#;
/// Sample and delay of [`CART`], s.
const TIMES: [f64; 2] = [0.01, 0.003];
/// Error of the solver's fourth order at 0.25 ms.
const ORDER: f64 = 1e-9;

fn cart() -> Arc<Plan> {
    Arc::new(Plan::new(CART.into(), FILE).unwrap())
}

fn begun(plan: &Arc<Plan>, handling: EventHandling) -> Machine {
    let mut machine = Machine::new(plan.clone(), Life::new(Interface::CoSimulation, handling));
    machine.set_experiment(None, 0.0, None).unwrap();
    machine.enter_initialization();
    machine.exit_initialization(&mut Silent).unwrap();
    machine
}

/// References of all discrete states of the cart's block.
fn kept(plan: &Plan) -> Vec<u32> {
    ["pd.u", "pd.x[0]", "pd.u.held", "pd.u.next[0]"].map(|name| plan.table.reference(name).unwrap()).to_vec()
}

#[test]
fn golden_what_a_sampled_block_keeps_is_discrete_with_its_times() {
    let plan = cart();
    let description = plan.description();
    for reference in kept(&plan) {
        let variable = &description.variables[reference as usize - 1];
        let Kind::Real { derivative_of, reinit, .. } = variable.kind else { panic!("{variable:?}") };
        assert_eq!(
            (variable.variability, derivative_of, reinit),
            (Variability::Discrete, None, false),
            "{}",
            variable.name
        );
        let times = "; sampled at multiples of `block.pd.sample` (0.01 s), outputs act `block.pd.delay` (0.003 s) later";
        assert!(variable.description.ends_with(times), "{}", variable.description);
        // No list has it as a known: the force that it holds depends on time.
        for list in [&description.outputs, &description.derivatives, &description.event_indicators] {
            let mut knowns = list.iter().flat_map(|unknown| unknown.dependencies.iter().flatten());
            assert!(knowns.all(|known| known.0 != reference), "{}", variable.name);
        }
    }
    assert!(
        plan.table.reference("pd.x[0].rate").is_none() && plan.table.reference("pd.u.held.rate").is_none()
    );
    // A solver only integrates the cart.
    assert_eq!((description.derivatives.len(), plan.nominals.len()), (2, 2));
}

#[test]
fn second_method_a_solver_without_their_states_follows_the_exact_motion() {
    let plan = cart();
    let mut exact = begun(&plan, EventHandling::default());
    let mut solver = Solver::new(&plan);
    let references = [kept(&plan), vec![plan.table.reference("cart.s").unwrap()]].concat();
    let is_event = |from: f64, to: f64| {
        let nearest = |time: f64| (time / TIMES[0]).round() * TIMES[0];
        let is_within = |event: f64| event > from + 1e-12 && event <= to + 1e-12;
        is_within(nearest(to)) || is_within(nearest(to - TIMES[1]) + TIMES[1])
    };
    let read = |machine: &mut Machine| -> Vec<f64> {
        references.iter().map(|&reference| get(machine, reference).unwrap()).collect()
    };
    let (mut steps, mut events) = (0, 0);
    let saved = (0..2).map(|_| {
        let saved = solver.machine.save().unwrap();
        let begin = solver.time;
        for _ in 0..400 {
            let (from, before) = (solver.time, read(&mut solver.machine));
            solver.step(2.5e-4);
            let after = read(&mut solver.machine);
            let changed = before[..4] != after[..4];
            assert!(!changed || is_event(from, solver.time), "changed from {from} to {}", solver.time);
            (steps, events) = (steps + 1, events + usize::from(changed));
        }
        exact.step_as_agreed(begin, solver.time - begin, &mut Silent).unwrap();
        for (own, other) in read(&mut solver.machine).iter().zip(read(&mut exact)) {
            assert!((own - other).abs() < ORDER * other.abs().max(1.0), "{own} {other} at {}", solver.time);
        }
        (saved, begin, read(&mut solver.machine))
    });
    let saved: Vec<_> = saved.collect();
    assert!(events > 10 && steps > 5 * events, "{events} of {steps}");
    // The states are part of a saved state: the second half is repeated, bit for bit.
    let (state, begin, end) = &saved[1];
    solver.restore(state);
    solver.time = *begin;
    (0..400).for_each(|_| solver.step(2.5e-4));
    assert_eq!(&read(&mut solver.machine), end);
}

/// Values that change only at events keep their old values until the host has handled the event.
#[test]
fn invariant_what_samples_change_is_shown_after_the_event_is_handled() {
    let mut changes = 0;
    for plan in plans().into_iter().chain([cart()]).filter(|plan| plan.assembly.has_samples()) {
        let is_real = |quantity| matches!(quantity, vibro_machine_component::Quantity::Column(_));
        let rows = (1..).zip(&plan.table.rows);
        let discrete = rows.filter(|(_, row)| row.role == Role::Discrete && is_real(row.quantity));
        let references: Vec<u32> = discrete.map(|(reference, _)| reference).collect();
        let read = |machine: &mut Machine| -> Vec<f64> {
            references.iter().map(|&reference| get(machine, reference).unwrap()).collect()
        };
        let mut machine = begun(&plan, EventHandling { event_mode: true, early_return: true });
        machine.leave_event(&mut Silent).unwrap();
        for _ in 0..40 {
            let (now, before) = (machine.time(), read(&mut machine));
            machine.step_as_agreed(now, 1.0, &mut Silent).unwrap();
            assert_eq!(read(&mut machine), before, "{} at {}", plan.name(), machine.time());
            machine.enter_event().unwrap();
            machine.handle_events(&mut Silent).unwrap();
            changes += usize::from(read(&mut machine) != before);
            machine.leave_event(&mut Silent).unwrap();
        }
        // Without early return a step passes many samples, and shows the last one at its end.
        let mut machine = begun(&plan, EventHandling { event_mode: true, early_return: false });
        machine.leave_event(&mut Silent).unwrap();
        let before = read(&mut machine);
        machine.step_as_agreed(0.0, 0.0205, &mut Silent).unwrap();
        assert_eq!(read(&mut machine), before, "{}", plan.name());
        machine.enter_event().unwrap();
        machine.handle_events(&mut Silent).unwrap();
        assert_ne!(read(&mut machine), before, "{}", plan.name());
    }
    assert!(changes > 30, "{changes}");
}
