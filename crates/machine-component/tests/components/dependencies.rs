//! Dependencies in descriptions, compared with numerical derivatives. An unlisted known must not
//! change the unknown. If a factor is listed as unchanging, the first derivative is the same at
//! all points of the mode, so that all second derivatives are zero, mixed ones too.

use crate::plans;
use crate::solver::{Silent, Solver, get, set};
use fmi_doors::description::Unknown;
use fmi_doors::{Component, DependencyKind, Interface, Model, Phase};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;
use vibro_machine_component::{FILE, Plan, Quantity, Role, SavedState};

/// Rounding relative to the terms of a value after some dozen operations; in stiff machines terms
/// cancel.
const ROUNDING: f64 = 1e-9;
/// Number of steps of the solver.
const STEPS: usize = 300;
/// Largest number of modes to examine.
const MODES: usize = 6;

/// Whether a machine has residual flexibility, which couples all elements on its nodes.
fn is_flexible(plan: &Plan) -> bool {
    plan.assembly.description.modals.iter().any(|modal| modal.residual.is_some())
}

/// The machines whose dependencies are listed.
fn listed() -> Vec<Arc<Plan>> {
    plans().into_iter().filter(|plan| !is_flexible(plan)).collect()
}

/// Without a list an unknown depends on every known.
#[test]
fn golden_residual_flexibility_has_no_lists_of_dependencies() {
    let plan =
        plans().into_iter().find(|plan| is_flexible(plan)).expect("a machine with residual flexibility");
    let description = plan.description();
    let lists = [
        &description.outputs,
        &description.derivatives,
        &description.event_indicators,
        &description.initial_unknowns,
    ];
    for unknown in lists.into_iter().flatten() {
        assert!(unknown.dependencies.is_none(), "{}", plan.table.rows[unknown.reference as usize - 1].name);
    }
}

/// The listed dependency kinds, by unknown and known.
fn told(lists: &[&[Unknown]]) -> HashMap<u32, HashMap<u32, DependencyKind>> {
    let rows = lists.iter().flat_map(|list| list.iter());
    rows.map(|row| (row.reference, row.dependencies.iter().flatten().copied().collect())).collect()
}

/// States, inputs and time, each with the size of its variation.
fn knowns(plan: &Plan, solver: &mut Solver) -> Vec<(u32, f64)> {
    let (states, nominals) = (&plan.states, &plan.nominals);
    let mut all = Vec::new();
    for (reference, row) in (1..).zip(&plan.table.rows) {
        let size = match row.quantity {
            Quantity::Column(column) => states.iter().position(|[state, _]| *state == column).map(|k| {
                let now = get(&mut solver.machine, reference).unwrap().abs();
                1e-3 * nominals[k].max(now)
            }),
            Quantity::Input(_) => Some(1e-3),
            Quantity::Time => Some(1e-4 * plan.description().experiment.stop_time),
            _ => None,
        };
        all.extend(size.map(|size| (reference, size)));
    }
    all
}

/// All values at a point displaced from a saved one.
struct Probe<'a> {
    plan: &'a Plan,
    solver: &'a mut Solver,
    saved: SavedState,
    unknowns: Vec<u32>,
}

impl Probe<'_> {
    fn at(&mut self, moves: &[(u32, f64)]) -> Vec<f64> {
        self.solver.restore(&self.saved);
        for &(known, by) in moves {
            if self.plan.table.rows[known as usize - 1].quantity == Quantity::Time {
                let time = self.solver.time + by;
                self.solver.machine.set_time(time).unwrap();
            } else {
                let now = get(&mut self.solver.machine, known).unwrap();
                assert!(set(&mut self.solver.machine, known, now + by), "{known}");
            }
        }
        let machine = &mut self.solver.machine;
        self.unknowns.iter().map(|&unknown| get(machine, unknown).unwrap()).collect()
    }

    /// Returns first derivatives times the step, second derivatives times its square, and the
    /// sizes of the values. Time varies forwards only.
    fn along(&mut self, base: &[(u32, f64)], known: u32, by: f64) -> Vec<[f64; 3]> {
        let moved = |by: f64| [base, &[(known, by)]].concat();
        let is_time = self.plan.table.rows[known as usize - 1].quantity == Quantity::Time;
        let from = if is_time { by } else { 0.0 };
        let [low, middle, high] = [from - by, from, from + by].map(|by| self.at(&moved(by)));
        let one = |i: usize| {
            let (a, b, c) = (low[i], middle[i], high[i]);
            [0.5 * (c - a), c - 2.0 * b + a, a.abs() + b.abs() + c.abs()]
        };
        (0..middle.len()).map(one).collect()
    }
}

/// Factors that are constant in all modes, by unknown and known.
type Factors = HashMap<(u32, u32), f64>;

#[derive(Default)]
struct Found {
    wrong: HashSet<String>,
    moved: HashSet<(u32, u32)>,
    constant: Factors,
}

fn compare(probe: &mut Probe, lists: &HashMap<u32, HashMap<u32, DependencyKind>>, found: &mut Found) {
    let (plan, knowns) = (probe.plan, knowns(probe.plan, probe.solver));
    let alternate = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
    let is_time = |known: u32| plan.table.rows[known as usize - 1].quantity == Quantity::Time;
    let elsewhere: Vec<(u32, f64)> = knowns
        .iter()
        .enumerate()
        .map(|(k, &(known, by))| (known, if is_time(known) { 3.0 * by } else { alternate(k) * 3.7 * by }))
        .collect();
    let values = [probe.at(&[]), probe.at(&elsewhere)];
    let scale: Vec<f64> = values[0].iter().zip(&values[1]).map(|(a, b)| a.abs() + b.abs()).collect();
    for &(known, by) in &knowns {
        let others: Vec<_> = elsewhere.iter().copied().filter(|other| other.0 != known).collect();
        let (here, there) = (probe.along(&[], known, by), probe.along(&others, known, by));
        for (i, unknown) in probe.unknowns.clone().into_iter().enumerate() {
            let name = |reference: u32| &plan.table.rows[reference as usize - 1].name;
            let mut wrong = |what: &str| {
                let text = format!("{}: {} by {} {what}", plan.name(), name(unknown), name(known));
                found.wrong.insert(text);
            };
            let ([first, second, size], [other, _, size_there]) = (here[i], there[i]);
            let zero = ROUNDING * (size + size_there + scale[i]);
            let kind = lists[&unknown].get(&known);
            if first != 0.0 || other != 0.0 {
                found.moved.insert((unknown, known));
            }
            match kind {
                None if first.abs() > zero || second.abs() > zero || other.abs() > zero => {
                    wrong("moves and is not listed");
                }
                None | Some(DependencyKind::Dependent) => {}
                Some(kind) => {
                    if second.abs() > zero {
                        wrong(&format!("is {kind:?} and bends by {second} of {size}"));
                    }
                    if (first - other).abs() > zero {
                        wrong(&format!("is {kind:?} by {first}, and by {other} elsewhere"));
                    }
                    if *kind != DependencyKind::Discrete {
                        let factor = found.constant.entry((unknown, known)).or_insert(first / by);
                        if (*factor * by - first).abs() > zero {
                            wrong(&format!("is {kind:?} by {factor}, and by {} in another mode", first / by));
                        }
                    }
                }
            }
        }
    }
}

/// The states of all stops and frictions.
fn mode(plan: &Plan, solver: &mut Solver) -> Vec<i64> {
    let is_state =
        |q| matches!(q, Quantity::StopState(_) | Quantity::FrictionState(_) | Quantity::SliderState(_));
    let rows = (1..).zip(&plan.table.rows).filter(|(_, row)| is_state(row.quantity));
    let references: Vec<u32> = rows.map(|(reference, _)| reference).collect();
    references.into_iter().map(|reference| get(&mut solver.machine, reference).unwrap() as i64).collect()
}

/// Returns all values after each of some parameter values is set at one event, with the states
/// held; `None` if a value is refused.
fn after_event(probe: &mut Probe, parameter: u32, values: &[f64]) -> Option<Vec<f64>> {
    probe.solver.restore(&probe.saved);
    let machine = &mut probe.solver.machine;
    let states = machine.continuous_states().unwrap().as_ref().to_vec();
    machine.enter_event().unwrap();
    machine.handle_events(&mut Silent).unwrap();
    if values.iter().any(|&value| !set(machine, parameter, value)) {
        return None;
    }
    machine.enter_continuous().unwrap();
    machine.set_continuous_states(&states).unwrap();
    Some(probe.unknowns.iter().map(|&unknown| get(machine, unknown).unwrap()).collect())
}

/// Checks that unlisted tunable parameters, set at an event, change nothing. A jump of states is
/// not a dependency.
fn parameters(probe: &mut Probe, lists: &HashMap<u32, HashMap<u32, DependencyKind>>, found: &mut Found) {
    let plan = probe.plan;
    for (parameter, row) in (1..).zip(&plan.table.rows).filter(|(_, row)| row.role == Role::Tunable) {
        let Quantity::Parameter(place) = row.quantity else { continue };
        let now = plan.table.parameters[place].value;
        let other = if now == 0.0 { 0.125 } else { 0.99 * now };
        let before = after_event(probe, parameter, &[other, now]);
        let Some((before, after)) = before.zip(after_event(probe, parameter, &[other])) else { continue };
        for (k, &unknown) in probe.unknowns.iter().enumerate() {
            let moved = (after[k] - before[k]).abs() > ROUNDING * (after[k].abs() + before[k].abs());
            // Energy accounts restart with a changed machine.
            let is_sum = matches!(plan.table.rows[unknown as usize - 1].quantity, Quantity::Energy(_));
            if moved && !is_sum && !lists[&unknown].contains_key(&parameter) {
                let name = &plan.table.rows[unknown as usize - 1].name;
                found.wrong.insert(format!(
                    "{}: {name} by {} moves and is not listed",
                    plan.name(),
                    row.name
                ));
            }
        }
    }
}

#[test]
fn second_method_dependencies_by_differences_in_every_mode_that_is_met() {
    let mut kinds = HashSet::new();
    for plan in listed() {
        let description = plan.description();
        let lists = [&description.outputs, &description.derivatives, &description.event_indicators];
        let lists = told(&lists.map(Vec::as_slice));
        // Every output of the table is listed.
        for (reference, row) in (1..).zip(&plan.table.rows) {
            let listed = matches!(row.role, Role::Output | Role::Discrete | Role::Local);
            assert_eq!(lists.contains_key(&reference), listed, "{} {}", plan.name(), row.name);
        }
        let mut unknowns: Vec<u32> = lists.keys().copied().collect();
        unknowns.sort_unstable();
        let mut solver = Solver::new(&plan);
        let h = description.experiment.step_size / 4.0;
        let (mut modes, mut found) = (HashSet::new(), Found::default());
        for _ in 0..STEPS {
            if modes.len() < MODES && modes.insert(mode(&plan, &mut solver)) {
                let saved = solver.machine.save().unwrap();
                let mut probe = Probe {
                    plan: &plan,
                    solver: &mut solver,
                    saved: saved.clone(),
                    unknowns: unknowns.clone(),
                };
                compare(&mut probe, &lists, &mut found);
                parameters(&mut probe, &lists, &mut found);
                solver.restore(&saved);
            }
            solver.step(h);
        }
        kinds.extend(lists.values().flat_map(|list| list.values().map(|kind| kind.name())));
        let mut wrong: Vec<_> = found.wrong.into_iter().collect();
        wrong.sort();
        assert!(wrong.is_empty(), "{} wrong in {} modes:\n{}", wrong.len(), modes.len(), wrong.join("\n"));
    }
    assert_eq!(kinds.len(), 5, "{kinds:?}");
}

/// Partial derivatives by tunable parameters and time, with constant states and mode.
fn partial(probe: &mut Probe, found: &mut HashSet<String>) -> usize {
    // Relative step and error of a central difference.
    const STEP: f64 = 1e-4;
    const DIFFERENCE: f64 = 1e-6;
    // Rounding relative to a value, and to the largest value, since accelerations may be small
    // differences; change of a parameter that shows only rounding, and factor on this noise.
    const ROUNDING: (f64, f64) = (1e-12, 1e-11);
    const NOISE: (f64, f64) = (1e-12, 16.0);
    let plan = probe.plan;
    let is_column =
        |unknown: &u32| matches!(plan.table.rows[*unknown as usize - 1].quantity, Quantity::Column(_));
    let (unknowns, all) = (probe.unknowns.clone(), probe.unknowns.iter().copied().filter(is_column));
    let columns: Vec<u32> = all.collect();
    let mut moved = 0;
    for (known, row) in (1..).zip(&plan.table.rows) {
        let is_time = row.quantity == Quantity::Time;
        if row.role != Role::Tunable && !is_time {
            continue;
        }
        probe.solver.restore(&probe.saved);
        let before = mode(plan, probe.solver);
        let now = if is_time { 0.0 } else { get(&mut probe.solver.machine, known).unwrap() };
        let step = if is_time { 1e-6 } else { STEP * if now == 0.0 { 1.0 } else { now.abs() } };
        let mut along = vec![f64::NAN; columns.len()];
        let (machine, write) = (&mut probe.solver.machine, |i: usize, x: f64| along[i] = x);
        machine.directional_derivative(&columns, &[known], &[1.0], write).unwrap();
        let mut at = |by: f64| {
            let values = match is_time {
                true => Some(probe.at(&[(known, by)])),
                false => after_event(probe, known, &[now + by]),
            };
            values.filter(|_| mode(plan, probe.solver) == before)
        };
        // Time varies forwards only; values that must not be negative may be 0.
        let difference = match [at(0.0), at(step), at(2.0 * step), at(-step).filter(|_| !is_time)] {
            [_, Some(b), _, Some(d)] => {
                b.iter().zip(&d).map(|(b, d)| (b - d) / (2.0 * step)).collect::<Vec<_>>()
            }
            [Some(a), Some(b), Some(c), None] => {
                let all = a.iter().zip(&b).zip(&c);
                all.map(|((a, b), c)| (4.0 * b - 3.0 * a - c) / (2.0 * step)).collect()
            }
            _ => continue,
        };
        let still: Vec<_> = (0..4).filter_map(|k| at(f64::from(k) * NOISE.0 * step / STEP)).collect();
        let sizes = probe.at(&[]);
        let largest = sizes.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        for (exact, unknown) in along.iter().zip(&columns) {
            let i = unknowns.iter().position(|own| own == unknown).unwrap();
            moved += usize::from(*exact != 0.0);
            let noise = still.iter().map(|values| (values[i] - still[0][i]).abs()).fold(0.0, f64::max);
            let rounding =
                (ROUNDING.0 * sizes[i].abs() + ROUNDING.1 * STEP * largest + NOISE.1 * noise) / step;
            if (exact - difference[i]).abs() > DIFFERENCE * exact.abs() + rounding {
                let name = &plan.table.rows[*unknown as usize - 1].name;
                found.insert(format!("{}: {name} by {}: {exact} {}", plan.name(), row.name, difference[i]));
            }
        }
    }
    moved
}

#[test]
fn second_method_partial_derivatives_by_parameters_and_time_by_differences() {
    let mut moved = 0;
    for plan in listed() {
        let outputs = plan.description().outputs;
        let unknowns: Vec<u32> = outputs.iter().map(|unknown| unknown.reference).collect();
        let mut solver = Solver::new(&plan);
        let h = plan.description().experiment.step_size / 4.0;
        let (mut modes, mut wrong) = (HashSet::new(), HashSet::new());
        for _ in 0..STEPS {
            if modes.len() < MODES && modes.insert(mode(&plan, &mut solver)) {
                let saved = solver.machine.save().unwrap();
                let mut probe = Probe {
                    plan: &plan,
                    solver: &mut solver,
                    saved: saved.clone(),
                    unknowns: unknowns.clone(),
                };
                moved += partial(&mut probe, &mut wrong);
                solver.restore(&saved);
            }
            solver.step(h);
        }
        let mut wrong: Vec<_> = wrong.into_iter().collect();
        wrong.sort();
        assert!(wrong.is_empty(), "{} wrong in {} modes:\n{}", wrong.len(), modes.len(), wrong.join("\n"));
    }
    assert!(moved > 1000, "{moved}");
}

/// Returns the initial unknowns; `None` if the start is refused.
fn initial(
    (plan, unknowns): (&Arc<Plan>, &[u32]),
    interface: Interface,
    (time, values): (f64, &[(u32, f64)]),
) -> Option<Vec<f64>> {
    let mut machine = Solver::instance(plan, interface);
    machine.set_experiment(None, time, None).unwrap();
    machine.enter_initialization();
    for &(reference, value) in values {
        if !set(&mut machine, reference, value) {
            return None;
        }
    }
    let read = unknowns.iter().map(|&unknown| get(&mut machine, unknown)).collect::<Option<_>>()?;
    assert_eq!(machine.life().phase, Phase::Initialization);
    Some(read)
}

#[test]
fn second_method_initial_unknowns_by_differences() {
    for plan in listed() {
        let unknowns = plan.description().initial_unknowns;
        let lists = told(&[&unknowns]);
        let outputs: Vec<u32> = unknowns.iter().map(|unknown| unknown.reference).collect();
        for interface in [Interface::ModelExchange, Interface::CoSimulation] {
            let before = initial((&plan, &outputs), interface, (0.0, &[])).unwrap();
            for (reference, row) in (1..).zip(&plan.table.rows) {
                let value = match row.quantity {
                    Quantity::Parameter(i) => plan.table.parameters[i].value,
                    Quantity::Input(_) | Quantity::Time => 0.0,
                    _ => continue,
                };
                for value in [0.97 * value, value + 0.013] {
                    let (time, set) = if row.quantity == Quantity::Time {
                        (value, vec![])
                    } else {
                        (0.0, vec![(reference, value)])
                    };
                    let Some(after) = initial((&plan, &outputs), interface, (time, &set)) else { continue };
                    for (k, &unknown) in outputs.iter().enumerate() {
                        let (a, b) = (before[k], after[k]);
                        let name = &plan.table.rows[unknown as usize - 1].name;
                        assert!(
                            (a - b).abs() <= ROUNDING * (a.abs() + b.abs())
                                || lists[&unknown].contains_key(&reference),
                            "{}: {name} by {} moves from {a} to {b} and is not listed",
                            plan.name(),
                            row.name
                        );
                    }
                }
            }
        }
    }
}

/// A force does not change coordinates and rates at once: hosts that connect these find no
/// algebraic loop.
#[test]
fn closed_form_an_input_that_is_a_force_is_listed_by_forces_and_accelerations_alone() {
    let text = "name = \"Pair\"\n[body.a]\nmass = 1.0\n[body.b]\nmass = 1.0\n[spring.k]\nbetween = [\"a\", \"b\"]\n\
                stiffness = 9.0\n[load.push]\non = \"a\"\ninput = true\n[body.far]\nmass = 2.0\n[load.pull]\non = \"far\"\nconstant = 1.0\n";
    let plan = Plan::new(text.into(), FILE).unwrap();
    let input = plan.table.inputs[0];
    let description = plan.description();
    for list in [&description.outputs, &description.initial_unknowns] {
        let depending = list.iter().filter(|unknown| {
            let dependencies = unknown.dependencies.as_ref().unwrap();
            dependencies.iter().any(|(known, _)| *known == input)
        });
        let names: Vec<_> =
            depending.map(|unknown| plan.table.rows[unknown.reference as usize - 1].name.as_str()).collect();
        assert_eq!(names, ["a.a", "push.f", "energy.work", "energy.lost", "energy.residual"]);
    }
}
