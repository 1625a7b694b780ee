//! The energy balance while a host sets inputs and parameters.

use crate::solver::{Silent, Solver, get, set};
use fmi_doors::{Component, EventHandling, Interface, Life};
use std::sync::Arc;
use vibro_machine_component::{FILE, Machine, Plan};

/// Rounding of some hundred sub-steps, relative to the converted energies.
const ROUNDING: f64 = 1e-9;

/// A block that swings on a table whose place the host sets; it starts with energy.
const SHAKEN: &str = "name = \"Shaken\"\n[body.table]\nmotion = { amplitude = 0.01, frequency = 3.0, input = true }\n[body.block]\n\
    mass = 2.0\nstart = { s = 0.1, v = 1.0 }\n[spring.k]\nbetween = [\"table\", \"block\"]\nstiffness = 800.0\ndamping = 3.0\n\
    [load.push]\non = \"block\"\ninput = true\n";

fn plan() -> Arc<Plan> {
    Arc::new(Plan::new(SHAKEN.into(), FILE).unwrap())
}

fn named<const N: usize>(plan: &Plan, names: [&str; N]) -> [u32; N] {
    names.map(|name| plan.table.reference(name).unwrap())
}

/// Returns the mechanical energy, and the residual that work and losses do not explain.
fn balance(machine: &mut Machine, plan: &Plan) -> (f64, f64) {
    let names = ["energy.kinetic", "energy.stored", "energy.residual"];
    let [kinetic, stored, residual] = named(plan, names).map(|reference| get(machine, reference).unwrap());
    (kinetic + stored, residual)
}

/// Steps of stiffness between and within a host's steps; the host changes one of them.
#[test]
fn invariant_what_steps_of_stiffness_put_in_is_accounted_for() {
    let plan = Arc::new(Plan::new(include_str!("../common/stepped.toml").into(), FILE).unwrap());
    let mut machine =
        Machine::new(plan.clone(), Life::new(Interface::CoSimulation, EventHandling::default()));
    machine.set_experiment(None, 0.0, None).unwrap();
    machine.enter_initialization();
    machine.exit_initialization(&mut Silent).unwrap();
    let names = ["energy.work", "energy.lost", "energy.switched", "spring.mesh.stiffness.steps[0].height"];
    let [work, lost, switched, height] = named(&plan, names);
    let (first, _) = balance(&mut machine, &plan);
    for k in 0..30 {
        machine.step_as_agreed(0.1 * f64::from(k), 0.1, &mut Silent).unwrap();
        let (energy, residual) = balance(&mut machine, &plan);
        assert!(residual.abs() < ROUNDING, "{k}: {residual} of {energy}");
        if k < 15 {
            let [work, lost, switched] = [work, lost, switched].map(|own| get(&mut machine, own).unwrap());
            assert!((energy - first - work - switched + lost).abs() < ROUNDING, "{k}");
            assert!(k < 1 || switched.abs() > 1e-4, "{switched}");
        } else if k == 15 {
            assert!(set(&mut machine, height, 25.0));
        }
    }
}

#[test]
fn invariant_energy_is_accounted_for_whatever_a_host_sets_between_steps() {
    let plan = plan();
    let mut machine =
        Machine::new(plan.clone(), Life::new(Interface::CoSimulation, EventHandling::default()));
    machine.set_experiment(None, 0.0, None).unwrap();
    machine.enter_initialization();
    machine.exit_initialization(&mut Silent).unwrap();
    let [place, push, mass] = named(&plan, ["body.table.motion.input", "load.push.input", "body.block.mass"]);
    let (first, residual) = balance(&mut machine, &plan);
    // ½ · 2 · 1² + ½ · 800 · 0.1².
    assert!((first - 5.0).abs() < ROUNDING && residual.abs() < ROUNDING, "{first} {residual}");
    let mut largest = first;
    for k in 0..40 {
        let value = f64::from(k);
        if k % 3 == 1 {
            assert!(set(&mut machine, place, 0.01 * (1.3 * value).sin()));
        }
        if k % 4 == 2 {
            assert!(set(&mut machine, push, 20.0 * (0.7 * value).cos()));
        }
        if k % 5 == 3 {
            assert!(set(&mut machine, mass, 2.0 + 0.5 * value.sin()));
        }
        machine.step_as_agreed(0.05 * value, 0.05, &mut Silent).unwrap();
        let (energy, residual) = balance(&mut machine, &plan);
        largest = energy.max(largest);
        assert!(residual.abs() < ROUNDING * largest, "{k}: {residual} of {energy}");
    }
    // Losses and work are not zero.
    let [work, lost] = named(&plan, ["energy.work", "energy.lost"]).map(|r| get(&mut machine, r).unwrap());
    assert!(lost > 0.1 && work.abs() > 0.1, "{work} {lost}");
}

#[test]
fn invariant_a_hosts_solver_sees_no_energy_come_by_inputs() {
    let plan = plan();
    let [place, push] = named(&plan, ["body.table.motion.input", "load.push.input"]);
    let mut solver = Solver::new(&plan);
    let before = balance(&mut solver.machine, &plan);
    assert!(before.1.abs() < ROUNDING);
    for value in [5.0, -3.0, 0.0] {
        assert!(set(&mut solver.machine, push, value));
        let now = balance(&mut solver.machine, &plan);
        assert!((now.0 - before.0).abs() < ROUNDING && now.1.abs() < ROUNDING, "{value}: {now:?}");
    }
    // The table's place is the spring's end: stored energy changes, but not the residual.
    for value in [0.02, -0.01] {
        assert!(set(&mut solver.machine, place, value));
        let now = balance(&mut solver.machine, &plan);
        let stored = 0.5 * 800.0 * (0.1 - value) * (0.1 - value);
        assert!(
            (now.0 - 1.0 - stored).abs() < ROUNDING && now.1.abs() < ROUNDING,
            "{value}: {now:?} {stored}"
        );
    }
}
