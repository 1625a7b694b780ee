//! Derivatives by the numbers of random machines, compared with differences of motions.

use std::collections::BTreeMap;
use std::sync::Arc;
use vibro_machine::motion::Event;
use vibro_machine::{Assembly, Description, Differentiated, Motion, What, file};

/// Machines with known motions in 50 digits (tests/second_method.rs).
const MACHINES: &str = include_str!("data/motions.txt");
/// Only every second parameter of a machine is compared, alternating between machines.
const EVERY: usize = 2;
/// Steps of fourth-order differences, relative to a number or to 0.1. The best difference counts:
/// a step may be so long that other events happen, or so short that rounding dominates.
const STEPS: [f64; 4] = [1e-3, 1e-4, 1e-5, 1e-6];
/// Error of the best difference relative to the largest derivative of its kind: a rounding of
/// 1e-15 over 1e-6, amplified up to a thousandfold.
const DIFFERENCE: f64 = 2e-6;
/// Largest number of events of a compared motion: many impacts amplify a rounding more.
const MOST: usize = 100;
/// Smallest size, relative to the largest value of its kind or to 1, to which an error is related.
const SMALL: f64 = 1e-3;

/// An event with the derivatives of its time.
type VariedEvent = (Event, Vec<Option<f64>>);

/// Values of all quantities, and the events.
struct Followed {
    values: Vec<f64>,
    events: Vec<Event>,
}

fn follow(machine: Description, end: f64) -> Followed {
    let quantities: Vec<_> = machine.quantities().collect();
    let assembly = Arc::new(Assembly::new(machine).unwrap());
    let mut events = Vec::new();
    let mut motion = Motion::new_observed(assembly, &mut |event| events.push(event.clone())).unwrap();
    motion.advance_observed(end, &mut |event| events.push(event.clone())).unwrap();
    Followed { values: quantities.iter().map(|&q| motion.value(q)).collect(), events }
}

/// Examples with links, prescribed bodies and static levels, with the times until which they are
/// compared.
const EXAMPLES: [(&str, f64); 5] = [
    ("msl_coupled_clutches", 1.3),
    ("rack_and_pinion", 0.3),
    ("belt_friction", 0.7),
    ("impact_on_spring", 0.2),
    ("paper_machine", 3.0),
];

fn examples() -> impl Iterator<Item = (String, Description, f64)> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/assembly");
    EXAMPLES.into_iter().map(move |(name, end)| {
        (name.to_owned(), file::read(&folder.join(name).with_extension("toml")).unwrap(), end)
    })
}

/// The machines with the times until which they are compared.
fn machines() -> impl Iterator<Item = (String, Description, f64)> {
    MACHINES.split("## machine ").skip(1).map(|block| {
        let (name, text) = block.split_once('\n').unwrap();
        let toml: String = text.lines().filter(|l| !l.starts_with("##")).flat_map(|l| [l, "\n"]).collect();
        let states = text.lines().filter_map(|line| line.strip_prefix("## state "));
        let times: Vec<f64> = states.map(|l| l.split_whitespace().next().unwrap().parse().unwrap()).collect();
        let machine = file::parse(&toml, name, &file::no_records).unwrap();
        (name.to_owned(), machine, times[times.len() / 2])
    })
}

/// The kind of a parameter: its name without the names of elements and bodies.
fn kind(name: &str) -> String {
    let parts: Vec<&str> = name.split('.').collect();
    let own = parts.iter().enumerate().filter(|(i, _)| *i != 1 && !(*i == 3 && parts[2] == "arms"));
    own.map(|(_, part)| *part).collect::<Vec<_>>().join(".")
}

/// The largest error of a difference with steps of a size; `None` if the varied machines are
/// refused or have other events.
fn error_of_differences(
    (machine, end): (&Description, f64),
    (motion, times, p): (&Differentiated, &[VariedEvent], usize),
    size: f64,
) -> Option<f64> {
    let name = motion.parameters()[p].as_str();
    let value = machine.get(name).unwrap();
    let step = size * value.abs().max(0.1);
    let at = |k: f64| machine.with([(name, value + k * step)]).ok().map(|changed| follow(changed, end));
    let [a, b, c, d] = [at(-2.0)?, at(-1.0)?, at(1.0)?, at(2.0)?];
    let contacts = |events: &[Event]| events.iter().map(|event| event.contact()).collect::<Vec<_>>();
    let own: Vec<_> = times.iter().map(|(event, _)| event.contact()).collect();
    if [&a, &b, &c, &d].iter().any(|motion| contacts(&motion.events) != own) {
        return None;
    }
    let difference =
        |of: &dyn Fn(&Followed) -> f64| (8.0 * (of(&c) - of(&b)) - (of(&d) - of(&a))) / (12.0 * step);
    let quantities: Vec<_> = machine.quantities().collect();
    let mut worst = 0.0f64;
    for what in What::ALL {
        let of_kind = quantities.iter().enumerate().filter(|(_, q)| q.what == what);
        let exact: Vec<_> = of_kind.map(|(i, &q)| (i, motion.derivative(q, p).unwrap())).collect();
        let size = exact.iter().fold(1.0, |most: f64, x| most.max(a.values[x.0].abs()));
        let largest = exact.iter().fold(SMALL * size, |most, x| most.max(x.1.abs()));
        for (i, exact) in exact {
            worst = worst.max((exact - difference(&|motion| motion.values[i])).abs() / largest);
        }
    }
    let largest = times.iter().filter_map(|(_, by)| by[p]).fold(SMALL, |most, x| most.max(x.abs()));
    for (k, (_, by)) in times.iter().enumerate() {
        if let Some(exact) = by[p] {
            worst = worst.max((exact - difference(&|motion| motion.events[k].time)).abs() / largest);
        }
    }
    Some(worst)
}

#[test]
fn second_method_random_machines_against_differences() {
    let (mut kinds, mut lost): (BTreeMap<String, usize>, usize) = (BTreeMap::new(), 0);
    for (number, (name, machine, end)) in machines().chain(examples()).enumerate() {
        let all = machine.parameters().into_iter().map(|parameter| parameter.name).enumerate();
        let names: Vec<String> = all.filter(|(i, _)| i % EVERY == number % EVERY).map(|(_, n)| n).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let mut times = Vec::new();
        let assembly = Arc::new(Assembly::new(machine.clone()).unwrap());
        let mut note = |event: &Event, by: &[Option<f64>]| times.push((event.clone(), by.to_vec()));
        let mut motion = Differentiated::new_observed(assembly, &names, &mut note).unwrap();
        motion.advance_observed(end, &mut note).unwrap();
        for (p, parameter) in names.iter().enumerate().filter(|_| times.len() <= MOST) {
            if motion.lost(p).is_some() {
                lost += 1;
                continue;
            }
            let mut best: Option<f64> = None;
            for size in STEPS {
                let error = error_of_differences((&machine, end), (&motion, &times, p), size);
                best = best.into_iter().chain(error).reduce(f64::min);
                if best.is_some_and(|best| best < DIFFERENCE) {
                    break;
                }
            }
            if let Some(best) = best {
                assert!(best < DIFFERENCE, "machine {name}, {parameter}: {best:e}");
                *kinds.entry(kind(parameter)).or_default() += 1;
            }
        }
    }
    let compared: usize = kinds.values().sum();
    println!("{compared} compared, {lost} without a derivative: {kinds:?}");
    assert!(compared > 900 && lost < compared / 10);
}
