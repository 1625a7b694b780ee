//! Springs and dashpots with curved forces: motions in closed form, energies, events.

use std::f64::consts::PI;
use std::sync::Arc;
use vibro_machine::Assembly;
use vibro_machine::file::{no_records, parse};
use vibro_machine::motion::Motion;

fn machine(text: &str) -> Arc<Assembly> {
    let description = parse(text, "m.toml", &no_records).expect("a machine");
    Arc::new(Assembly::new(description).expect("an assembly"))
}

/// Complete elliptic integral of the first kind by the arithmetic-geometric mean.
fn complete(m: f64) -> f64 {
    let (mut a, mut b) = (1.0, (1.0 - m).sqrt());
    for _ in 0..40 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    PI / (2.0 * a)
}

/// An undamped body on a hardening spring returns to its start after 4 K(m)/W.
#[test]
fn closed_form_period_of_a_hardening_spring() {
    // m q'' + k q + c q³ = 0 from q = A: W² = (k + c A²)/m, parameter c A²/(2 m W²).
    let (mass, k, c, amplitude) = (2.0, 30.0, 500.0, 0.7);
    let text = format!(
        "name = \"Duffing\"\nbody.b = {{ mass = {mass}, start = {{ s = {amplitude} }} }}\n\
         spring.k = {{ between = [\"ground\", \"b\"], stiffness = {k}, cubic = {c} }}\n"
    );
    let square = (k + c * amplitude * amplitude) / mass;
    let period = 4.0 * complete(c * amplitude * amplitude / (2.0 * mass * square)) / square.sqrt();
    let mut motion = Motion::new(machine(&text)).expect("a motion");
    for turn in 1..=20 {
        let began = std::time::Instant::now();
        motion.advance_to(f64::from(turn) * period).expect("an end");
        let [s, v, _] = motion.body(0);
        println!("{turn} {:e} {:e} {:?}", s - amplitude, v, began.elapsed());
    }
    let [s, v, _] = motion.body(0);
    assert!((s - amplitude).abs() < 1e-12 && v.abs() < 1e-9, "{s} {v}");
}

/// A chain with curved springs and dashpots, stops, friction and a drive: the energy accounts
/// balance, and the motion at half the sub-steps is the same.
#[test]
fn invariant_energy_accounts_balance() {
    let text = "name = \"Chain\"\ngravity = 9.81\n\
        body.a = { mass = 2.0, gravity = 1.0, start = { s = 0.02, v = 1.5 } }\n\
        body.b = { mass = 1.0, gravity = 1.0, start = { v = -2.0 } }\n\
        body.c = { mass = 0.5, start = { s = 0.01 } }\n\
        spring.a = { between = [\"ground\", \"a\"], stiffness = 200.0, quadratic = -300.0, cubic = 4e4, damping = 0.3 }\n\
        spring.b = { between = [\"a\", \"b\"], stiffness = -50.0, cubic = 2e4, quintic = 1e6, preload = 1.0 }\n\
        spring.c = { between = [\"b\", \"c\"], quartic = -1e3, cubic = 3e4, stiffness = 100.0 }\n\
        damper.d = { between = [\"ground\", \"b\"], damping = -0.2, cubic = 0.8 }\n\
        stop.rigid = { between = [\"ground\", \"b\"], gap = 0.12, restitution = 0.7 }\n\
        stop.soft = { between = [\"a\", \"ground\"], gap = 0.05, stiffness = 2e4, damping = 20.0 }\n\
        friction.f = { between = [\"ground\", \"c\"], force = 0.6, static = 0.9 }\n\
        load.l = { on = \"a\", amplitude = 30.0, frequency = 2.3 }\n";
    let mut motion = Motion::new(machine(text)).expect("a motion");
    let energy = |motion: &Motion| { let (k, p) = motion.kinetic_and_stored(); k + p };
    let first = energy(&motion);
    let mut count = 0;
    let began = std::time::Instant::now();
    motion.advance_observed(8.0, &mut |_| count += 1).expect("an end");
    let spent = began.elapsed();
    let off = energy(&motion) - first - motion.energy().balance();
    println!("{count} events, {spent:?}, off {off:e} of {first}");
    assert!(count > 100 && off.abs() < 1e-11 * first.abs(), "{count} events, {off}");
    // Pauses change the series, not the motion.
    let mut paused = Motion::new(machine(text)).expect("a motion");
    (1..=800).for_each(|i| paused.advance_to(0.01 * f64::from(i)).expect("an end"));
    for i in 0..3 {
        println!("{:e}", paused.body(i)[0] - motion.body(i)[0]);
    }
}

#[test]
fn speed_of_one() {
    for n in [1usize, 2, 5, 20] {
        let mut text = String::from("name = \"Chain\"\n");
        for i in 0..n {
            let before = if i == 0 { "ground".to_owned() } else { format!("b{}", i - 1) };
            let start = if i + 1 == n { ", start = { s = 0.5 }" } else { "" };
            text += &format!("body.b{i} = {{ mass = 1.0{start} }}\nspring.k{i} = {{ between = [\"{before}\", \"b{i}\"], stiffness = 1.0, cubic = 1.0, damping = 0.02 }}\n");
        }
        text += &format!("stop.s = {{ between = [\"ground\", \"b{}\"], gap = 0.9, restitution = 0.8 }}\nload.l = {{ on = \"b0\", amplitude = 0.8, frequency = {:?}, phase = 0.0 }}\n", n - 1, 0.9 / 6.283185307179586);
        for kept in [false, true] {
            let mut best = f64::INFINITY;
            let mut count = 0;
            for _ in 0..5 {
                let mut motion = Motion::new(machine(&text)).expect("a motion");
                if !kept { motion = motion.without_energy_accounts(); }
                count = 0;
                let began = std::time::Instant::now();
                motion.advance_observed(100.0, &mut |_| count += 1).expect("an end");
                best = best.min(began.elapsed().as_secs_f64());
            }
            println!("n {n} accounts {kept}: {:.2} us per s, {count} events", best * 1e4);
        }
    }
}
