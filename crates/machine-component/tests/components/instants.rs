//! Steps and points of a solver at times that differ from a sample's by rounding; and the force of
//! a slipping slider over many steps.

use crate::solver::{Silent, Solver, get};
use fmi_doors::{Component, Interface, Model};
use std::sync::Arc;
use vibro_machine_component::{FILE, Machine, Plan};

/// Samples and acting outputs are farther apart than this, s; rounding is smaller.
const APART: f64 = 1e-9;

/// A mass on a belt behind a slipping bristle, and a block that counts its samples.
const MACHINE: &str = r#"
    name = "Belt"
    body.belt = { motion = { rate = "1 m/s" } }
    body.block = { mass = "2 kg" }
    spring.hold = { between = ["ground", "block"], stiffness = "5 kN/m", damping = "20 N s/m" }
    spring.bristle = { between = ["block", "belt"], stiffness = "1e7 N/m", slip = "10 N" }
    signal.one = { constant = 1.0 }
    [block.count]
    inputs = ["one"]
    states = 1
    a = [[1.0]]
    b = [[1.0]]
    c = [[1.0]]
    outputs = ["y"]
    sample = "2 ms"
    delay = "0.7 ms"
"#;

fn plan() -> Arc<Plan> {
    Arc::new(Plan::new(MACHINE.into(), FILE).unwrap())
}

fn value(machine: &mut Machine, plan: &Plan, name: &str) -> f64 {
    let place = plan.table.rows.iter().position(|row| row.name == name);
    get(machine, place.unwrap_or_else(|| panic!("no {name}")) as u32 + 1).unwrap()
}

/// The number of samples whose outputs have acted by a time.
fn acted(time: f64) -> f64 {
    ((time - 0.7e-3) / 2e-3 + APART).floor().max(0.0)
}

#[test]
fn closed_form_steps_of_any_length_end_after_the_samples_of_their_end() {
    let plan = plan();
    for step in [0.7e-3, 1e-3, 3e-3] {
        let mut machine = Solver::instance(&plan, Interface::CoSimulation);
        machine.set_experiment(None, 0.0, None).unwrap();
        machine.enter_initialization();
        machine.exit_initialization(&mut Silent).unwrap();
        for k in 0..700u32 {
            let (now, end) = (f64::from(k) * step, f64::from(k + 1) * step);
            machine.step_as_agreed(now, end - now, &mut Silent).unwrap();
            assert_eq!(value(&mut machine, &plan, "count.y"), acted(end), "{end}");
            let slips = machine.time() > 0.5;
            assert!(!slips || value(&mut machine, &plan, "bristle.f") == 10.0, "{end}");
        }
    }
}

#[test]
fn invariant_no_event_is_announced_within_rounding_behind_a_point_of_a_solver() {
    let plan = plan();
    for interval in [0.5e-3, 1e-3, 2e-3, 3e-3] {
        let mut solver = Solver::new(&plan);
        for k in 1..60u32 {
            let output = f64::from(k) * interval;
            while solver.time < output {
                solver.step(output - solver.time);
                let next = solver.machine.next_event_time().unwrap();
                assert!(next - solver.time > APART, "{next:?} at {:?}", solver.time);
            }
            assert_eq!(value(&mut solver.machine, &plan, "count.y"), acted(output), "{output}");
        }
    }
}
