use super::*;
use vibro_analysis::assembly::{Machine, Start};
use vibro_assembly::file::no_records;

fn machine(text: &str) -> Machine {
    Machine::parse(text, "machine.toml", &no_records).unwrap()
}

/// An oscillator with a wall: x'' + 0.04 x' + x = F cos ωt, x ≤ 1, ε = 0.9.
const WALL: &str = r#"
name = "Wall"
[body.block]
mass = 1.0
[spring.holder]
between = ["ground", "block"]
stiffness = 1.0
damping = 0.04
[stop.wall]
between = ["ground", "block"]
gap = 1.0
restitution = 0.9
[load.drive]
on = "block"
amplitude = 0.5
frequency = 0.13
phase = 1.5707963267948966
"#;

fn show(family: &Family, found: &[Branch]) {
    for b in found {
        println!(
            "{} from {:?} depth {} [{}] {:?} points {} closed {}",
            b.id,
            b.parent,
            b.depth,
            b.word().in_words(&family.place(family.range.0).unwrap().assembly),
            b.word().periods,
            b.points.len(),
            b.closed
        );
        for p in b.points.iter().filter(|p| p.special.is_some()) {
            let s = p.special.as_ref().unwrap();
            println!("    {} {} {:.12} {}", s.kind.name(), s.element, p.value, p.stability);
        }
    }
}

fn grown(family: &Family, seeds: usize, depth: u32) -> Vec<Branch> {
    let t = std::time::Instant::now();
    let options = TreeOptions { seeds, depth, ..TreeOptions::default() };
    let found = tree(family, &options, &mut |_| true).unwrap();
    println!("{:?} {} points", t.elapsed(), found.iter().map(|b| b.points.len()).sum::<usize>());
    show(family, &found);
    found
}

#[test]
fn try_wall() {
    let m = machine(&WALL.replace("frequency = 0.13", "frequency = \"0.81 rad/s\""));
    let family = Family::new(&m, "load.drive.amplitude", (0.33, 0.40)).unwrap();
    grown(&family, 8, 2);
    let m = machine(&WALL.replace("frequency = 0.13", "frequency = \"0.799 rad/s\""));
    let family = Family::new(&m, "load.drive.amplitude", (0.33, 0.40)).unwrap();
    grown(&family, 8, 2);
}

fn example(name: &str) -> Machine {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/assembly");
    Machine::read(&std::path::Path::new(folder).join(name)).unwrap()
}

#[test]
fn try_pair() {
    let m = example("impact_pair.toml");
    println!("{:?}", m.description.parameters().iter().map(|p| p.name.clone()).collect::<Vec<_>>());
    let family = Family::new(&m, "body.base.motion.amplitude", (0.4, 3.0)).unwrap();
    let found = grown(&family, 12, 2);
    for b in &found {
        for o in b.orbits_at(1.0) {
            println!("{} {:?} {} {}", b.id, o.state(), o.stability(), o.spectral_radius());
        }
    }
}

#[test]
fn try_ball() {
    let text = "name = \"Ball\"\ngravity = 10.0\n[body.ball]\nmass = 1.0\ngravity = -1.0\nstart = { s = 0.5, v = 5.0 }\n[body.table]\nmotion = { amplitude = 0.02, frequency = \"20 rad/s\" }\n[stop.floor]\nbetween = [\"ball\", \"table\"]\ngap = 0.0\nrestitution = 0.6\n";
    let m = machine(text);
    let family = Family::new(&m, "body.table.motion.amplitude", (0.018, 0.05)).unwrap();
    grown(&family, 12, 2);
    let (g, e, w): (f64, f64, f64) = (10.0, 0.6, 20.0);
    let fold = std::f64::consts::PI * g * (1.0 - e) / (1.0 + e);
    println!("LP {} PD {}", fold / w / w, fold.hypot(2.0 * g * (1.0 + e * e) / (1.0 + e).powi(2)) / w / w);
}

#[test]
fn try_paper() {
    let m = example("paper_machine.toml");
    let family = Family::new(&m, "load.drive.amplitude", (0.1, 0.4)).unwrap();
    grown(&family, 12, 2);
    let span = crate::Span::new(vibro_analysis::find_group("f10").unwrap(), 0.5, 4.0).unwrap();
    let own = crate::Family::new(&vibro_analysis::ParameterSet::basic(), span).unwrap();
    let few =
        crate::TreeOptions { seeds: 12, settle: 400, starts: 0, depth: 2, ..crate::TreeOptions::default() };
    let t = std::time::Instant::now();
    let found = crate::tree(&own, &few, &|_, _| ()).unwrap();
    println!(
        "{:?} {} points {:?}",
        t.elapsed(),
        found.branches.iter().map(|b| b.points.len()).sum::<usize>(),
        vibro_impact::Parameters::default()
    );
    for b in &found.branches {
        println!("{} {} {}", b.id, b.word, b.points.len());
        for p in b.points.iter().filter(|p| p.special.is_some()) {
            println!("    {} {:.12} {}", p.label().unwrap(), p.value, p.stable);
        }
    }
}

#[test]
fn try_damper() {
    let m = example("damper_with_buffer.toml");
    let family = Family::new(&m, "load.shaker.frequency", (8.0, 12.0)).unwrap();
    grown(&family, 24, 0);
}
