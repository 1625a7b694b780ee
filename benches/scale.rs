//! Growth with the number of bodies: cost per body of a machine's matrices, its motion and its
//! natural frequencies, for uncoupled oscillators and for a chain; as ratios in one run.
//! `cargo bench -p benches --bench scale`

use std::fmt::Write as _;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;
use vibro_machine::file::{no_records, parse};
use vibro_machine::{Assembly, Motion};
use vibro_studies::natural::natural;

/// Numbers of bodies; the others are compared with the first.
const COUNTS: [usize; 4] = [100, 400, 2_000, 10_000];
/// Number of rounds of each machine; the smallest time counts.
const ROUNDS: usize = 3;
/// Number of rows of a motion, and the time between them, s.
const ROWS: (usize, f64) = (100, 1e-3);

/// Oscillators, each connected to ground or to the previous one.
fn text(count: usize, is_chain: bool) -> String {
    let mut text = String::from("name = \"Many\"\n");
    for i in 0..count {
        let from = if is_chain && i > 0 { format!("b{}", i - 1) } else { "ground".into() };
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "[body.b{i}]\nmass = 1.0\nstart = {{ s = {:?} }}\n[spring.k{i}]\nbetween = [\"{from}\", \"b{i}\"]\n\
             stiffness = 1e3\ndamping = 0.5",
            1e-3 * (i % 7 + 1) as f64
        );
    }
    text
}

/// Times of the matrices with the start, the motion's rows, and the natural frequencies, s.
fn times(count: usize, is_chain: bool) -> [f64; 3] {
    let machine = parse(&text(count, is_chain), "many.toml", &no_records).expect("a machine");
    let mut least = [f64::INFINITY; 3];
    for _ in 0..ROUNDS {
        let mut begin = Instant::now();
        let mut taken = |place: usize| {
            let now = Instant::now();
            least[place] = least[place].min((now - begin).as_secs_f64());
            begin = now;
        };
        let assembly = Arc::new(Assembly::new(machine.clone()).expect("matrices"));
        let mut motion = Motion::new(assembly.clone()).expect("a motion");
        taken(0);
        for row in 1..=ROWS.0 {
            motion.advance_to(row as f64 * ROWS.1).expect("a motion");
            (0..count).for_each(|i| {
                black_box(motion.body(i));
            });
        }
        taken(1);
        let (system, places) = (assembly.system(), (0..assembly.system().states()).collect::<Vec<_>>());
        black_box(natural(system, &system.linear(motion.mode()), &places));
        taken(2);
    }
    least
}

fn main() {
    println!("time for each body, relative to the time with {} bodies (µs there)", COUNTS[0]);
    println!("{:>12} {:>8} {:>10} {:>10} {:>12}", "", "bodies", "matrices", "rows", "frequencies");
    for (name, is_chain) in [("uncoupled", false), ("chain", true)] {
        let mut first = [0.0; 3];
        for count in COUNTS {
            let each = times(count, is_chain).map(|time| 1e6 * time / count as f64);
            if count == COUNTS[0] {
                first = each;
                println!("{name:>12} {count:>8} {:>10.1} {:>10.1} {:>12.1}", each[0], each[1], each[2]);
            } else {
                let [a, b, c] = [0, 1, 2].map(|k| each[k] / first[k]);
                println!("{name:>12} {count:>8} {a:>9.2}× {b:>9.2}× {c:>11.2}×");
            }
        }
    }
}
