//! Values of a run are never -0, NaN or infinite.

use crate::plans;
use crate::solver::{Silent, Solver, get};
use fmi_doors::{Bases, Component, Interface, Model};
use std::sync::Arc;
use vibro_machine_component::{Machine, Plan};

/// Steps of a run.
const STEPS: usize = 120;

fn check(what: &str, plan: &Plan, time: f64, values: &[f64]) {
    for (k, value) in values.iter().enumerate() {
        let good = value.is_finite() && value.to_bits() != (-0.0f64).to_bits();
        assert!(good, "{}: {what} {k} at {time} is {value:?}", plan.name());
    }
}

/// Reads all variables of a machine, and derivatives of some outputs.
fn read(machine: &mut Machine, plan: &Plan, outputs: &[u32]) {
    let time = machine.time();
    for (reference, row) in (1..).zip(&plan.table.rows).filter(|(_, row)| row.dimensions.is_empty()) {
        check(&row.name, plan, time, &[get(machine, reference).unwrap()]);
    }
    for order in 1..=3 {
        for &output in outputs {
            let mut value = 0.0;
            // Energies and discrete outputs have no derivatives.
            if machine.output_derivatives(&[output], &[order], |_, x| value = x).is_ok() {
                check("derivative of an output", plan, time, &[value]);
            }
        }
    }
}

fn outputs(plan: &Plan) -> Vec<u32> {
    plan.description().outputs.iter().map(|unknown| unknown.reference).collect()
}

#[test]
fn invariant_no_value_of_a_run_is_minus_zero() {
    for plan in plans() {
        let outputs = outputs(&plan);
        let h = plan.description().experiment.step_size;
        let mut machine = Solver::instance(&plan, Interface::CoSimulation);
        machine.set_experiment(None, 0.0, None).unwrap();
        machine.enter_initialization();
        read(&mut machine, &plan, &outputs);
        machine.exit_initialization(&mut Silent).unwrap();
        for k in 0..STEPS {
            machine.step_as_agreed(h * k as f64, h, &mut Silent).unwrap();
            read(&mut machine, &plan, &outputs);
        }
        let mut solver = Solver::new(&plan);
        for _ in 0..STEPS {
            solver.step(h / 4.0);
            let time = solver.time;
            read(&mut solver.machine, &plan, &[]);
            check("state", &plan, time, solver.machine.continuous_states().unwrap().as_ref());
            check("slope", &plan, time, solver.machine.state_derivatives().unwrap().as_ref());
            check("indicator", &plan, time, solver.machine.event_indicators().unwrap().as_ref());
        }
    }
}

/// Values set by hosts, and matrices, never read as -0 either.
#[test]
fn invariant_a_zero_that_was_set_with_a_sign_is_read_without() {
    for plan in plans().into_iter().filter(|plan| !plan.table.inputs.is_empty()) {
        let plan = Arc::new(Arc::into_inner(plan).unwrap().with_arrays());
        let outputs = outputs(&plan);
        let mut machine = Solver::instance(&plan, Interface::CoSimulation);
        machine.set_experiment(None, -0.0, None).unwrap();
        machine.enter_initialization();
        for &input in &plan.table.inputs {
            machine.set(Bases::REAL, &[input], |_| -0.0).unwrap();
        }
        let gravity = plan.table.reference("gravity").unwrap();
        machine.set(Bases::REAL, &[gravity], |_| -0.0).unwrap();
        read(&mut machine, &plan, &outputs);
        machine.exit_initialization(&mut Silent).unwrap();
        machine.step_as_agreed(0.0, 0.01, &mut Silent).unwrap();
        read(&mut machine, &plan, &outputs);
        for (reference, row) in (1..).zip(&plan.table.rows).filter(|(_, row)| !row.dimensions.is_empty()) {
            let mut values = Vec::new();
            machine.get(Bases::REAL, &[reference], |_, value| values.push(value)).unwrap();
            assert_eq!(values.len(), row.dimensions.iter().product());
            check(&row.name, &plan, 0.01, &values);
        }
    }
}
