//! Forces in Model Exchange, compared with the accelerations. A solver looks for an event on both
//! of its sides, so that it sees flanks, stops and contacts that are pulled.

use crate::plans;
use crate::solver::{Solver, get};
use fmi_doors::Model;
use vibro_machine::description::{BodyKind, Description};
use vibro_machine::{Element, What};
use vibro_machine_component::Plan;

/// Steps of a run; the states are displaced after each.
const STEPS: usize = 60;
/// Displacement of a state in nominal values, enough to end most contacts.
const BESIDE: f64 = 0.03;
/// Rounding relative to the largest force on a body.
const ROUNDING: f64 = 1e-9;

/// Whether all forces on bodies come from elements, not from links or matrices.
fn has_forces(machine: &Description) -> bool {
    machine.links.is_empty() && machine.bodies.iter().all(|body| !body.is_inner())
}

/// Returns mass times acceleration minus all forces of a free body, and the largest force.
fn unbalanced(plan: &Plan, solver: &mut Solver, body: usize) -> Option<[f64; 2]> {
    let machine = &plan.assembly.description;
    let BodyKind::Free(free) = &machine.bodies[body].kind else { return None };
    let mut value = |name: String| get(&mut solver.machine, plan.table.reference(&name).unwrap()).unwrap();
    let mut terms = vec![
        free.inertia * value(format!("{}.a", machine.bodies[body].name)),
        -free.inertia * free.gravity * machine.gravity,
    ];
    for element in machine.elements() {
        match element {
            Element::Load(load) if load.body == body => terms.push(-value(format!("{}.f", load.name))),
            _ => {
                // A contact has a further force along each tangent.
                let forces = std::iter::once(What::F).chain(element.branches().map(What::TangentF));
                for (arms, what) in element.all_arms().zip(forces) {
                    let what = what.word();
                    for (_, arm) in arms.terms.iter().filter(|term| term.0 == body) {
                        terms.push(arm * value(format!("{}.{what}", element.name())));
                    }
                }
            }
        }
    }
    Some([terms.iter().sum(), terms.iter().fold(0.0, |most: f64, term| most.max(term.abs()))])
}

#[test]
fn invariant_forces_are_the_accelerations_beyond_the_end_of_a_contact_too() {
    let mut pulled = 0;
    for plan in plans().into_iter().filter(|plan| has_forces(&plan.assembly.description)) {
        let mut solver = Solver::new(&plan);
        let h = plan.description().experiment.step_size / 4.0;
        for step in 0..STEPS {
            let saved = solver.machine.save().unwrap();
            let states = solver.machine.continuous_states().unwrap().as_ref().to_vec();
            let side = |k: usize| if (step + k).is_multiple_of(2) { BESIDE } else { -BESIDE };
            let beside = states.iter().zip(&plan.nominals).enumerate();
            let beside: Vec<f64> = beside.map(|(k, (x, nominal))| x + side(k) * nominal).collect();
            solver.machine.set_continuous_states(&beside).unwrap();
            for body in 0..plan.assembly.description.bodies.len() {
                let Some([sum, largest]) = unbalanced(&plan, &mut solver, body) else { continue };
                let name = &plan.assembly.description.bodies[body].name;
                assert!(sum.abs() <= ROUNDING * largest, "{} {name}: {sum} of {largest}", plan.name());
            }
            for stop in &plan.assembly.description.stops {
                let force = plan.table.reference(&format!("{}.f", stop.name)).unwrap();
                pulled += usize::from(get(&mut solver.machine, force).unwrap() < 0.0);
            }
            solver.restore(&saved);
            solver.step(h);
        }
    }
    assert!(pulled > 50, "{pulled}");
}
