//! Orbits of described machines against closed forms, others' numbers, the 3-DOF machine's own
//! orbits, and the machines' own motions.

mod closed_forms;
mod curves;
mod freewheels;
mod knots;
mod motions;
mod paper;
mod series;
mod steps;

use super::*;
use std::path::Path;
use vibro_analysis::assembly::Machine;
use vibro_assembly::file::no_records;

fn machine(text: &str) -> Machine {
    Machine::parse(text, "machine.toml", &no_records).unwrap()
}

/// A machine of the gallery.
fn example(name: &str) -> Machine {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/assembly");
    Machine::read(&Path::new(folder).join(name)).unwrap()
}

fn grown(family: &Family, seeds: usize, depth: u32) -> Vec<Branch> {
    let options = TreeOptions { seeds, depth, ..TreeOptions::default() };
    tree(family, &options, &mut |_, _| true).unwrap()
}

/// The values of the special points of a kind on branches with a number of events.
fn specials(branches: &[Branch], events: usize, kind: &str) -> Vec<f64> {
    let own = branches.iter().filter(|b| b.word().len() == events);
    let all = own.flat_map(|b| b.points.iter());
    let of_kind = |p: &&OrbitPoint| p.special.as_ref().is_some_and(|s| s.kind.name() == kind);
    all.filter(of_kind).map(|p| p.value).collect()
}

/// Distance of a value from the nearest of some.
fn nearest(values: &[f64], value: f64) -> f64 {
    values.iter().map(|x| (x - value).abs()).fold(f64::INFINITY, f64::min)
}
