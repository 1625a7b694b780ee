//! Orbits of described machines against closed forms, published numbers, the 3-DOF machine's own
//! orbits, and the machines' own motions.

mod between;
mod box_cone;
mod closed_forms;
mod closing;
mod curved;
mod curves;
mod freewheels;
mod kept;
mod knots;
mod known;
mod motions;
mod paper;
mod residual;
mod resonances;
mod samples;
mod series;
mod sides;
mod steps;
mod sticking;
mod together;
mod touches;

use super::problem::Problem;
use super::*;
use crate::curve::Equations;
use nalgebra::DMatrix;
use std::path::Path;
use std::sync::Arc;
use vibro_machine::Differentiated;
use vibro_machine::derivative::By;
use vibro_machine::file::no_records;
use vibro_studies::Machine;

fn machine(text: &str) -> Machine {
    Machine::parse(text, "machine.toml", &no_records).unwrap()
}

/// A machine of the gallery.
fn example(name: &str) -> Machine {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/assembly");
    Machine::read(&Path::new(folder).join(name)).unwrap()
}

fn grown(family: &Family, seeds: usize, depth: u32) -> Vec<Branch> {
    let options = TreeOptions { seeds, depth, ..TreeOptions::default() };
    tree(family, &options, &mut |_, _| true).unwrap()
}

/// The values of the special points of a kind on branches with a given number of events.
fn specials(branches: &[Branch], events: usize, kind: &str) -> Vec<f64> {
    let own = branches.iter().filter(|b| b.word().len() == events);
    let all = own.flat_map(|b| b.points.iter());
    let of_kind = |p: &&OrbitPoint| p.special.as_ref().is_some_and(|s| s.label.name() == kind);
    all.filter(of_kind).map(|p| p.value).collect()
}

/// Moduli of the eigenvalues of the motion's own transition over a period, largest first.
fn moduli_by_motion(orbit: &Orbit) -> Vec<f64> {
    let (assembly, (time, state)) = (orbit.place().assembly.clone(), orbit.middle_state());
    let columns: Vec<By> = (0..state.len()).map(By::Start).collect();
    let mut motion = Differentiated::from_state(assembly, time, &state, &columns).unwrap();
    motion.advance_to(time + orbit.period()).unwrap();
    let column = |p: usize| motion.state_derivative(p).unwrap_or_else(|| panic!("{:?}", motion.lost(p)));
    let all: Vec<f64> = (0..state.len()).flat_map(|p| column(p)[..state.len()].to_vec()).collect();
    let map = DMatrix::from_vec(state.len(), state.len(), all);
    let mut own: Vec<f64> = map.complex_eigenvalues().iter().map(|m| m.norm()).collect();
    own.sort_by(|a, b| b.total_cmp(a));
    own
}

/// Largest errors of an orbit that is examined: of the moduli of multipliers and of a simulation of
/// the orbit, and of the columns of parameters, relative.
struct Allowed {
    rounding: f64,
    apart: f64,
}

/// Examines an orbit by the motion: the orbit itself, the moduli of its multipliers, and the columns
/// of parameters, which vary by a tenth of their values.
fn examine(machine: &Machine, orbit: &Orbit, parameters: &[&str], allowed: &Allowed) {
    let words = orbit.word().in_words(&orbit.place().assembly);
    assert!(orbit.check_by_motion().unwrap() < allowed.rounding, "{words}");
    let mut moduli: Vec<f64> = orbit.multipliers().iter().map(|m| m.norm()).collect();
    moduli.sort_by(|a, b| b.total_cmp(a));
    let by_motion = moduli_by_motion(orbit);
    for (own, other) in moduli.iter().zip(&by_motion) {
        assert!((own - other).abs() < allowed.rounding, "{words}: {moduli:?} {by_motion:?}");
    }
    for parameter in parameters {
        let present = machine.description.get(parameter).unwrap();
        let apart = column_apart(machine, orbit, (parameter, 0.1 * present));
        assert!(apart < allowed.apart, "{words}, {parameter}: {apart:e}");
    }
}

/// Asserts that each point of a branch from an orbit on is a motion, up to a part of its period.
fn points_are_motions(machine: &Machine, orbit: &Orbit, (name, span): (&str, (f64, f64)), allowed: f64) {
    let family = Family::new(machine, name, span).unwrap();
    let found = branch(&family, orbit, &Default::default()).unwrap();
    assert!(found.points.len() > 3, "{}", found.points.len());
    for point in found.points.iter().filter(|point| point.special.is_none()) {
        let orbit = found.orbit(point).unwrap();
        assert!(orbit.check_by_motion().unwrap() < allowed * orbit.period(), "{}", point.value);
    }
}

/// Relative error of the parameter's column at an orbit, against a difference of the equations.
fn column_apart(machine: &Machine, orbit: &Orbit, (parameter, span): (&str, f64)) -> f64 {
    let present = machine.description.get(parameter).unwrap_or_else(|e| panic!("{parameter}: {e:?}"));
    let family = Family::new(machine, parameter, (present - span, present + span)).unwrap();
    let problem = Problem { family: Arc::new(family), ..orbit.problem.clone() };
    let u = problem.point(orbit.place(), &problem.numbers(orbit.place(), &orbit.u), present);
    let own = problem.linearize(&u, None).unwrap().matrix.column(problem.size()).into_owned();
    let at = |by: f64| {
        let mut moved = u.clone();
        moved[problem.size()] += by;
        problem.residual(&problem.place(&moved).unwrap(), &moved, false).unwrap().value
    };
    ((at(DIFFERENCE) - at(-DIFFERENCE)) / (2.0 * DIFFERENCE) - &own).norm() / own.norm()
}

/// Step of the differences in [`column_apart`], in the parameter's unit.
const DIFFERENCE: f64 = 1e-5;

/// Distance of a value from the nearest of some values.
fn nearest(values: &[f64], value: f64) -> f64 {
    values.iter().map(|x| (x - value).abs()).fold(f64::INFINITY, f64::min)
}
