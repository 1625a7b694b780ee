//! Chains of bodies with cubic springs, a drive and a rigid stop at the last body: microseconds of
//! a simulated second, with and without energy accounts. `cargo bench -p benches --bench curved`
//!
//! `python benches/curved_beside_heyoka.py` follows the same chains with heyoka.

use std::fmt::Write as _;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;
use vibro_machine::file::{no_records, parse};
use vibro_machine::{Assembly, Motion};

/// Number of rounds; the smallest time counts.
const ROUNDS: usize = 30;
/// End of the motions, s.
const END: f64 = 100.0;

/// The chain of this number of bodies.
fn chain(bodies: usize) -> Arc<Assembly> {
    let mut text = String::from("name = \"Chain\"\n");
    for i in 0..bodies {
        let before = if i == 0 { "ground".to_owned() } else { format!("b{}", i - 1) };
        let start = if i + 1 == bodies { ", start = { s = 0.5 }" } else { "" };
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "body.b{i} = {{ mass = 1.0{start} }}\nspring.k{i} = {{ between = [\"{before}\", \"b{i}\"], \
             stiffness = 1.0, cubic = 1.0, damping = 0.02 }}"
        );
    }
    let _ = writeln!(
        text,
        "stop.s = {{ between = [\"ground\", \"b{}\"], gap = 0.9, restitution = 0.8 }}\n\
         load.l = {{ on = \"b0\", amplitude = 0.8, frequency = \"0.9 rad/s\" }}",
        bodies - 1
    );
    let description = parse(&text, "chain.toml", &no_records).expect("a machine");
    Arc::new(Assembly::new(description).expect("an assembly"))
}

fn main() {
    println!("| bodies | events | µs a second, accounts off | accounts on |\n|---|---|---|---|");
    for bodies in [1, 2, 5, 20] {
        let assembly = chain(bodies);
        let (mut best, mut events) = ([f64::INFINITY; 2], 0);
        for _ in 0..ROUNDS {
            for (kept, best) in [false, true].into_iter().zip(&mut best) {
                let mut motion = Motion::new(assembly.clone()).expect("a motion");
                if !kept {
                    motion = motion.without_energy_accounts();
                }
                events = 0;
                let begin = Instant::now();
                motion.advance_observed(END, &mut |_| events += 1).expect("an end");
                *best = best.min(1e6 * begin.elapsed().as_secs_f64() / END);
                black_box(motion.state());
            }
        }
        println!("| {bodies} | {events} | {:.2} | {:.2} |", best[0], best[1]);
    }
}
