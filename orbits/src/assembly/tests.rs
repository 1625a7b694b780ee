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

#[test]
fn try_wall() {
    let m = machine(WALL);
    let t = std::time::Instant::now();
    let orbit = Orbit::settled(&m, &Start::default(), 500);
    println!("{:?}", t.elapsed());
    match orbit {
        Ok(o) => println!(
            "{:?} {:?} {:?} {:?} {} {:?} {:?} {:?}",
            o.word().in_words(&o.place().assembly),
            o.times(),
            o.state(),
            o.multipliers(),
            o.stability(),
            o.is_certified(),
            o.violation(),
            o.check_by_motion()
        ),
        Err(e) => println!("{e}"),
    }
}

#[test]
fn try_wall_tree() {
    let m = machine(WALL);
    let family = Family::new(&m, "load.drive.frequency", (0.11, 0.15)).unwrap();
    let t = std::time::Instant::now();
    let options = TreeOptions { seeds: 8, depth: 2, ..TreeOptions::default() };
    let found = tree(&family, &options, &mut |n| {
        println!("{n} branches");
        n < 40
    })
    .unwrap();
    println!("{:?}", t.elapsed());
    for b in &found {
        println!(
            "{} from {:?} depth {} [{}] {:?} points {} closed {}",
            b.id,
            b.parent,
            b.depth,
            b.word().in_words(&family.place(0.12).unwrap().assembly),
            b.word().periods,
            b.points.len(),
            b.closed
        );
        for p in b.points.iter().filter(|p| p.special.is_some()) {
            let s = p.special.as_ref().unwrap();
            println!(
                "    {} {} {:.12} {}",
                s.kind.name(),
                s.element,
                p.value * std::f64::consts::TAU,
                p.stability
            );
        }
    }
}
