//! Derivatives with respect to the numbers of fifty random machines, compared with central
//! differences of a second method in 72 digits (tests/data/make_derivatives.py).

use std::collections::BTreeMap;
use std::sync::Arc;
use vibro_machine::description::BodyKind;
use vibro_machine::{Assembly, Description, Differentiated, Motion, Quantity, What, file};

const KNOWN: &str = include_str!("data/derivatives.txt");
/// Error relative to the size of the derivative, which is the largest number of its column.
const ERROR: f64 = 1e-9;
/// Amplification of errors beyond which roundings dominate: errors of derivatives grow with its
/// square, relative sizes only linearly.
const MAGNIFIED: f64 = 1e4;
/// Perturbation of a start, which measures how much a motion amplifies errors.
const OFF: f64 = 1e-10;
/// Smallest size of a column: columns with smaller numbers are compared with this size.
const LEAST: f64 = 1e-6;

struct Known {
    name: String,
    machine: Description,
    /// For each number, the derivatives of s and v of every body at each time.
    derivatives: BTreeMap<String, Vec<(f64, Vec<f64>)>>,
}

fn machines() -> Vec<Known> {
    let known = |block: &str| {
        let (name, text) = block.split_once('\n').unwrap();
        let toml: String = text.lines().filter(|l| !l.starts_with("##")).flat_map(|l| [l, "\n"]).collect();
        let mut derivatives: BTreeMap<String, Vec<(f64, Vec<f64>)>> = BTreeMap::new();
        for line in text.lines().filter_map(|line| line.strip_prefix("## derivative ")) {
            let (number, values) = line.split_once(' ').unwrap();
            let values: Vec<f64> = values.split_whitespace().map(|x| x.parse().unwrap()).collect();
            derivatives.entry(number.to_owned()).or_default().push((values[0], values[1..].to_vec()));
        }
        let machine = file::parse(&toml, name, &file::no_records).unwrap_or_else(|e| panic!("{e}"));
        Known { name: name.to_owned(), machine, derivatives }
    };
    KNOWN.split("## machine ").skip(1).map(known).collect()
}

fn quantities(machine: &Description) -> impl Iterator<Item = Quantity> {
    (0..machine.bodies.len()).flat_map(|i| [What::S, What::V].map(|what| Quantity::of_body(i, what)))
}

/// Amplification of a change of the start until a time.
fn magnification(machine: &Description, time: f64) -> f64 {
    let mut off = machine.clone();
    for body in &mut off.bodies {
        if let BodyKind::Free(free) = &mut body.kind {
            free.v += OFF;
        }
    }
    let [one, other] = [machine, &off].map(|machine| {
        let mut motion = Motion::new(Arc::new(Assembly::new(machine.clone()).unwrap())).unwrap();
        motion.advance_to(time).unwrap();
        quantities(machine).map(|quantity| motion.value(quantity)).collect::<Vec<f64>>()
    });
    one.iter().zip(&other).fold(0.0, |most: f64, (x, y)| most.max((x - y).abs())) / OFF
}

#[test]
fn second_method_derivatives_of_fifty_machines_in_60_digits() {
    let all = machines();
    let (mut worst, mut compared, mut lost) = (0.0f64, 0, Vec::new());
    for Known { name, machine, derivatives } in &all {
        let names: Vec<&str> = derivatives.keys().map(String::as_str).collect();
        let assembly = Arc::new(Assembly::new(machine.clone()).unwrap());
        let mut motion = Differentiated::new(assembly, &names).unwrap();
        let times: Vec<f64> = derivatives.values().next().unwrap().iter().map(|row| row.0).collect();
        for (k, &time) in times.iter().enumerate() {
            motion.advance_to(time).unwrap();
            let magnified = (magnification(machine, time) / MAGNIFIED).max(1.0);
            for (p, number) in names.iter().enumerate() {
                if let Some(found) = motion.lost(p) {
                    lost.push(format!("machine {name}, {number}: {found}"));
                    continue;
                }
                let exact = &derivatives[*number][k].1;
                let size = exact.iter().fold(LEAST, |most, x| most.max(x.abs()));
                for (quantity, exact) in quantities(machine).zip(exact) {
                    let found = motion.derivative(quantity, p).unwrap();
                    let error = (found - exact).abs() / (size * magnified);
                    assert!(error < ERROR, "machine {name}, {number} at {time}: {found} {exact}, {error:e}");
                    worst = worst.max(error);
                }
                compared += 1;
            }
        }
    }
    println!("{compared} columns compared, largest error {worst:e}; lost: {lost:#?}");
    assert!(all.len() >= 50 && compared > 500 && lost.len() < 10);
}
