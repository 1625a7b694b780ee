//! Branches of orbits of machines from files: time per point, compared with the 3-DOF machine's
//! own orbits on its branch, and growth with the number of bodies; as ratios in one run.
//! `cargo bench -p benches --bench machine_orbits`

use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;
use vibro_machine::Start;
use vibro_machine::file::no_records;
use vibro_orbits::paper::{Label, PathOptions};
use vibro_orbits::{Family, Orbit, TreeOptions, branch, tree};
use vibro_studies::Machine;
use vibro_studies::paper::{ParameterSet, find_group};

/// Number of values for comparing settled orbits with a branch.
const ROWS: usize = 161;
/// Number of rounds; the smallest time counts.
const ROUNDS: usize = 5;

fn least(work: impl Fn() -> usize) -> (f64, usize) {
    let mut best = (f64::INFINITY, 0);
    for _ in 0..ROUNDS {
        let begin = Instant::now();
        let points = work();
        best = (best.0.min(begin.elapsed().as_secs_f64()), points);
    }
    best
}

fn example(name: &str) -> Machine {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/assembly");
    Machine::read(&Path::new(folder).join(name)).expect("an example")
}

/// Time, number of points and events of the branch of a machine's settled motion.
fn followed(machine: &Machine, parameter: &str, range: (f64, f64)) -> (f64, usize, usize) {
    let family = Family::new(machine, parameter, range).expect("a range");
    let orbit = Orbit::settled(machine, &Start::default(), 500).expect("an orbit");
    let events = orbit.word().len();
    let (time, points) =
        least(|| branch(&family, &orbit, &PathOptions::default()).expect("a branch").points.len());
    (time, points, events)
}

/// A driven chain whose first body strikes a wall.
fn chain(bodies: usize) -> Machine {
    let mut text = String::from("name = \"Chain\"\n");
    for i in 0..bodies {
        let before = if i == 0 { "ground".into() } else { format!("b{}", i - 1) };
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "body.b{i} = {{ mass = 1.0 }}\n\
             spring.g{i} = {{ between = [\"{before}\", \"b{i}\"], stiffness = 20.0, damping = 0.4 }}"
        );
    }
    text.push_str(
        "stop.wall = { between = [\"ground\", \"b0\"], gap = 0.0, restitution = 0.6 }\n\
         load.drive = { on = \"b0\", amplitude = 4.0, frequency = 0.6 }\n",
    );
    Machine::parse(&text, "chain.toml", &no_records).expect("a machine")
}

/// Orbits on which motions settle at parameter values of a family, each from the file's start.
fn settled_rows(family: &Family) -> Vec<Orbit> {
    let (from, to) = family.range;
    let value = |i: usize| from + (to - from) * i as f64 / (ROWS - 1) as f64;
    let settled = |i: usize| Orbit::settled_at(family, value(i), &Start::default(), 400).ok();
    (0..ROWS).filter_map(settled).collect()
}

fn main() {
    let paper = example("paper_machine.toml");
    let (time, points, events) = followed(&paper, "load.drive.amplitude", (0.1, 0.3));
    let span =
        vibro_orbits::paper::Span::new(find_group("f10").expect("a group"), 1.0, 3.0).expect("a range");
    let family = vibro_orbits::paper::Family::new(&ParameterSet::basic(), span).expect("a family");
    let system = family.system(&[1.5]).expect("a machine");
    let word = vibro_orbits::paper::OrbitWord::new("UL", 1, 2).expect("a word");
    let orbit = vibro_orbits::paper::Orbit::find(&system, &word, &[5.5, 8.6]).expect("an orbit");
    let (core, core_points) = least(|| {
        let options = PathOptions::default();
        let found = vibro_orbits::paper::branch(&family, &word, orbit.phases(), 1.5, &options, &[]);
        found.expect("a branch").points.len()
    });
    let per = |time: f64, points: usize| 1e3 * time / points as f64;
    println!(
        "the paper's machine, {events} events: {points} points, {:.3} ms each; 3-DOF orbits {core_points} points, {:.3} ms each; ratio {:.1}",
        per(time, points),
        per(core, core_points),
        per(time, points) / per(core, core_points)
    );
    let damper = example("damper_with_buffer.toml");
    let (time, points, events) = followed(&damper, "load.shaker.frequency", (9.8, 10.4));
    println!("damper_with_buffer, {events} events: {points} points, {:.3} ms each", per(time, points));
    let family = Family::new(&damper, "load.shaker.frequency", (8.0, 12.0)).expect("a range");
    let rows = settled_rows(&family);
    for depth in [0, 1] {
        let options = TreeOptions { depth, ..TreeOptions::default() };
        let begin = Instant::now();
        let found = tree(&family, &options, &mut |_, _| true).expect("branches");
        let time = begin.elapsed().as_secs_f64();
        let points: usize = found.iter().map(|b| b.points.len()).sum();
        let missed: Vec<f64> = rows
            .iter()
            .filter(|row| !found.iter().any(|branch| branch.passes(row)))
            .map(Orbit::value)
            .collect();
        let ends = found.iter().filter(|b| !b.closed).flat_map(|b| [b.points.first(), b.points.last()]);
        let unnamed = ends
            .flatten()
            .filter(|p| p.special.as_ref().is_none_or(|special| special.label == Label::NoConvergence));
        println!(
            "its branches from 8 to 12 Hz, depth {depth}: {} branches, {points} points, {time:.1} s; {} of {} \
             settled orbits on none, at {missed:.4?} Hz; {} ends without a name",
            found.len(),
            missed.len(),
            rows.len(),
            unnamed.count()
        );
    }
    let (three, points, _) = followed(&chain(3), "load.drive.amplitude", (3.0, 6.0));
    let three = three / points as f64;
    for bodies in [3, 6, 12] {
        let (time, points, events) = followed(&chain(bodies), "load.drive.amplitude", (3.0, 6.0));
        let point = time / points as f64;
        println!(
            "chain of {bodies}, {events} events: {points} points, {:.3} ms each, {:.1} times three bodies",
            1e3 * point,
            point / three
        );
    }
}
