//! Speed of machines from text files, as ratios within one run: against the 3-DOF core on the
//! 3-DOF machine, over the number of bodies, with stiff contacts, with stiff springs.
//! `cargo bench -p benches --bench assembly`

use std::fmt::Write as _;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;
use vibro_impact::{Groups, Scales, Simulator, State};
use vibro_machine::derivative::Gradient;
use vibro_machine::file::{no_records, parse};
use vibro_machine::{Assembly, Differentiated, Motion, Quantity, What};

/// Number of rounds of most machines; the smallest time counts. Some machines are timed once.
const ROUNDS: usize = 7;
/// Number of rounds of the 3-DOF machine, so short that many are not interrupted. Each times all
/// three variants once, so that changes of the computer's speed affect all alike.
const TURNS: usize = 200;

/// The 3-DOF machine as the text of a file.
fn paper_machine(p: &vibro_impact::Parameters) -> String {
    let spring = |name: &str, ends: &str, k: f64, c: f64| {
        format!("[spring.{name}]\nbetween = {ends}\nstiffness = {k:?}\ndamping = {c:?}\n")
    };
    let stop = |name: &str, ends: &str| {
        format!(
            "[stop.{name}]\nbetween = {ends}\ngap = {:?}\nrestitution = {:?}\n",
            p.stop_gap, p.stop_restitution
        )
    };
    let body =
        |name: &str, m: f64, start: &str| format!("[body.{name}]\nmass = {m:?}\nstart = {{ {start} }}\n");
    [
        "name = \"Paper\"\n".into(),
        body("box", p.box_mass, "s = 0.0"),
        body("block", p.block_mass, "s = 0.9, v = 0.5"),
        body("secondary", p.secondary_mass, "s = 0.0"),
        spring("mount", "[\"ground\", \"box\"]", p.box_stiffness, p.box_damping),
        spring("second", "[\"ground\", \"secondary\"]", p.secondary_stiffness, p.secondary_damping),
        spring("coupling", "[\"block\", \"secondary\"]", p.coupling_stiffness, 0.0),
        stop("upper", "[\"box\", \"block\"]"),
        stop("lower", "[\"block\", \"box\"]"),
        format!(
            "[load.drive]\non = \"box\"\namplitude = {:?}\nfrequency = \"{:?} rad/s\"\nphase = {:?}\n",
            p.drive_amplitude, p.drive_frequency, p.drive_phase
        ),
    ]
    .concat()
}

/// A driven chain like a gear train: bodies are joined alternately by a clearance (two opposite
/// stops with the keys `law`) and by a spring, the first spring with the keys `keys`.
fn chain_of(bodies: usize, law: &str, keys: &str) -> String {
    let mut text = String::from("name = \"Chain\"\n");
    for i in 0..bodies {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "[body.b{i}]\nmass = 1.0");
        let _ = writeln!(
            text,
            "[spring.g{i}]\nbetween = [\"ground\", \"b{i}\"]\nstiffness = 20.0\ndamping = 0.2"
        );
        if i == 0 {
            continue;
        }
        let ends = format!("\"b{}\", \"b{i}\"", i - 1);
        let back = format!("\"b{i}\", \"b{}\"", i - 1);
        let _ = if i % 2 == 1 {
            writeln!(
                text,
                "[stop.u{i}]\nbetween = [{ends}]\ngap = 0.05\n{law}\n\
                 [stop.l{i}]\nbetween = [{back}]\ngap = 0.05\n{law}"
            )
        } else {
            let keys = if i == 2 { keys } else { SPRING };
            writeln!(text, "[spring.k{i}]\nbetween = [{ends}]\n{keys}")
        };
    }
    text + "[load.drive]\non = \"b0\"\namplitude = 10.0\nfrequency = 1.0\n"
}

/// A buffer 50 times as stiff as the springs of a chain.
const BUFFER: &str = "stiffness = 2e4";

/// The springs of a chain.
const SPRING: &str = "stiffness = 400.0\ndamping = 0.1";

/// A chain with rigid stops.
fn chain(bodies: usize) -> String {
    chain_of(bodies, "restitution = 0.6", SPRING)
}

/// A row of bodies with springs between them, each on ground with friction, two of them driven.
fn frictions(bodies: usize) -> String {
    let mut text = String::from("name = \"Frictions\"\n");
    for i in 0..bodies {
        let (speed, force) = (0.1 * ((i * 7) % 11) as f64 - 0.5, 1.0 + 0.1 * ((i * 5) % 7) as f64);
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "[body.b{i}]\nmass = 1.0\nstart = {{ v = {speed:?} }}\n\
             [friction.f{i}]\nbetween = [\"ground\", \"b{i}\"]\nforce = {force:?}"
        );
        if i > 0 {
            let _ = writeln!(text, "[spring.k{i}]\nbetween = [\"b{}\", \"b{i}\"]\nstiffness = 400.0", i - 1);
        }
    }
    let amplitude = 6.0 * (bodies as f64).sqrt();
    for (name, body, frequency) in [("a", 0, 1.0), ("b", bodies / 2, 1.3)] {
        let _ = writeln!(
            text,
            "[load.{name}]\non = \"b{body}\"\namplitude = {amplitude:?}\nfrequency = {frequency:?}"
        );
    }
    text
}

/// A mass on a mount against a contact.
fn contact(keys: &str) -> String {
    format!(
        "name = \"Contact\"\n[body.a]\nmass = 1.0\n[spring.mount]\nbetween = [\"ground\", \"a\"]\nstiffness = 40.0\ndamping = 0.5\n\
         [stop.c]\nbetween = [\"ground\", \"a\"]\ngap = 0.1\n{keys}\n[load.drive]\non = \"a\"\namplitude = 20.0\nfrequency = 1.0\n"
    )
}

/// Two coupled oscillators whose frequencies have the ratio `ratio`.
fn stiff(ratio: f64) -> String {
    format!(
        "name = \"Stiff\"\n[body.a]\nmass = 1.0\nstart = {{ s = 0.04, v = 1.0 }}\n[body.b]\nmass = 1.0\n[spring.soft]\nbetween = [\"ground\", \"a\"]\n\
         stiffness = 39.5\n[spring.stiff]\nbetween = [\"ground\", \"b\"]\nstiffness = {:?}\ndamping = 10.0\n[spring.between]\n\
         between = [\"a\", \"b\"]\nstiffness = 1.0\n[stop.c]\nbetween = [\"ground\", \"a\"]\ngap = 0.05\nrestitution = 0.5\n",
        39.5 * ratio * ratio
    )
}

/// A beam of 60 modes with two stops, or 60 bodies on springs with the same frequencies and
/// inertias, two of them with a stop.
fn of_60(is_one: bool) -> String {
    let frequency = |k: usize| 2.0 + 1.5 * k as f64;
    let stops = |a: &str, b: &str, gap: f64| {
        format!(
            "stop.a = {{ between = [\"ground\", \"{a}\"], gap = {gap}, restitution = 0.7 }}\n\
             stop.b = {{ between = [\"ground\", \"{b}\"], gap = {gap}, restitution = 0.7 }}\n\
             load.drive = {{ on = \"{a}\", amplitude = 3.0, frequency = 2.1 }}\n"
        )
    };
    if is_one {
        let list = |f: &dyn Fn(usize) -> f64| (0..60).map(f).collect::<Vec<_>>();
        let row = |at: f64| list(&|k| (at * (k + 1) as f64).sin());
        return format!(
            "name = \"Beam\"\nmodal.beam = {{ frequencies = {:?}, damping_ratio = 0.01, nodes = {{ a = {:?}, b = {:?} }} }}\n{}",
            list(&frequency),
            row(0.8),
            row(1.9),
            stops("beam.a", "beam.b", 4e-3)
        );
    }
    let mut text = String::from("name = \"Bodies\"\n");
    for k in 0..60 {
        let omega = std::f64::consts::TAU * frequency(k);
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "body.b{k} = {{ mass = 1.0 }}\nspring.k{k} = {{ between = [\"ground\", \"b{k}\"], stiffness = {:?}, damping = {:?} }}",
            omega * omega,
            0.02 * omega
        );
    }
    text + &stops("b0", "b1", 4e-3)
}

/// A mass on a spring under a record of `knots` values, one every 0.4 ms, held or linear.
fn recorded(knots: usize, interpolation: &str) -> String {
    let value = |k: usize| ((k * 7919) % 1000) as f64 / 500.0 - 1.0;
    let knots: Vec<String> = (0..knots).map(|k| format!("[{:?}, {:?}]", k as f64 * 4e-4, value(k))).collect();
    format!(
        "name = \"Held\"\nbody.a = {{ mass = 1.0 }}\nspring.k = {{ between = [\"ground\", \"a\"], stiffness = 400.0, damping = 0.5 }}\n\
         load.p = {{ on = \"a\", table = [{}], interpolation = \"{interpolation}\" }}\n",
        knots.join(", ")
    )
}

fn machine(text: &str) -> Arc<Assembly> {
    let description = parse(text, "bench", &no_records).unwrap_or_else(|e| panic!("{e}"));
    Arc::new(Assembly::new(description).expect("a machine"))
}

/// Time of the last four fifths of a motion, ns, and their number of events.
fn follow(assembly: &Arc<Assembly>, end: f64, accounts: bool) -> (f64, usize) {
    let mut m = Motion::new(assembly.clone()).expect("a motion");
    if !accounts {
        m = m.without_energy_accounts();
    }
    // The tables of the modes, computed once per motion, are not timed.
    m.advance_to(0.2 * end).expect("it moves");
    let (begin, mut events) = (Instant::now(), 0);
    m.advance_observed(end, &mut |_| events += 1).expect("it moves");
    (begin.elapsed().as_nanos() as f64, events)
}

/// As [`follow`], with derivatives with respect to five parameters.
fn follow_varied(assembly: &Arc<Assembly>, end: f64) -> (f64, usize) {
    let all = assembly.description.parameters();
    let names: Vec<&str> = all.iter().step_by(all.len() / 5).take(5).map(|p| p.name.as_str()).collect();
    let mut m = Differentiated::new(assembly.clone(), &names).expect("a motion");
    m.advance_to(0.2 * end).expect("it moves");
    let (begin, mut events) = (Instant::now(), 0);
    m.advance_observed(end, &mut |_, _| events += 1).expect("it moves");
    (begin.elapsed().as_nanos() as f64, events)
}

/// Two times, ns: of a motion sampled at 200 times, and of the same motion with the gradient of
/// the sum of squared samples with respect to at most thirty parameters.
fn follow_gradient(assembly: &Arc<Assembly>, end: f64) -> [f64; 2] {
    let all = assembly.description.parameters();
    let names: Vec<&str> = all.iter().take(30).map(|p| p.name.as_str()).collect();
    let place = Quantity::of_body(0, What::S);
    let times = || (1..=200).map(|k| end * f64::from(k) / 200.0);
    let begin = Instant::now();
    let mut m = Motion::new(assembly.clone()).expect("a motion");
    for time in times() {
        m.advance_to(time).expect("it moves");
        black_box(m.value(place));
    }
    let alone = begin.elapsed().as_nanos() as f64;
    let begin = Instant::now();
    let mut sum = Gradient::new(assembly.clone(), &names).expect("a motion");
    for time in times() {
        sum.advance_to(time).expect("it moves");
        sum.add(place, 2.0 * sum.motion().value(place));
    }
    black_box(sum.gradient().expect("a gradient"));
    [alone, begin.elapsed().as_nanos() as f64]
}

/// Time of a motion over 10 s from its start, ns.
fn follow_record(mut m: Motion) -> (f64, usize) {
    let begin = Instant::now();
    m.advance_to(10.0).expect("it moves");
    (begin.elapsed().as_nanos() as f64, 0)
}

fn least(mut way: impl FnMut() -> (f64, usize)) -> (f64, usize) {
    (0..ROUNDS).map(|_| way()).min_by(|a, b| a.0.total_cmp(&b.0)).expect("a round")
}

fn main() {
    let p = Groups::weak(0.1, 0.75, 1.5, 0.0, 0.4, 0.2, 0.0, 0.4)
        .to_parameters(Scales::default())
        .expect("valid");
    let start = State { x: [0.0, 0.9, 0.0], v: [0.0, 0.5, 0.0] };
    let periods = 100.0;
    let paper = machine(&paper_machine(&p));
    let mut times = [f64::INFINITY; 3];
    for _ in 0..TURNS {
        let mut s = Simulator::new(&p, &start, 0.0).expect("a simulator");
        s.advance_to(0.2 * periods * p.period()).expect("it moves");
        let begin = Instant::now();
        s.advance_to(periods * p.period()).expect("it moves");
        let core = begin.elapsed().as_nanos() as f64;
        let [off, on] = [false, true].map(|accounts| follow(&paper, periods * p.period(), accounts).0);
        times.iter_mut().zip([core, off, on]).for_each(|(least, t)| *least = least.min(t));
    }
    println!("| work | µs | ratio |\n|---|---|---|");
    let names = [
        "the 3-DOF core, a drive period",
        "the same machine from a file, energy accounts off",
        "the same, energy accounts on",
    ];
    for (name, t) in names.iter().zip(times) {
        println!("| {name} | {:.2} | {:.1} |", t / (0.8 * periods) / 1e3, t / times[0]);
    }
    let mut before = None;
    for bodies in [5, 10, 20, 40] {
        let (t, events) = least(|| follow(&machine(&chain(bodies)), 10.0, false));
        let growth = before.map_or(String::new(), |b: f64| format!("{:.1} of half as many", t / b));
        println!(
            "| {bodies} bodies, {} clearances, 8 s, {events} events | {:.0} | {growth} |",
            bodies / 2,
            t / 1e3
        );
        before = Some(t);
    }
    let rigid = least(|| follow(&machine(&contact("restitution = 0.8")), 20.0, false));
    println!("| a rigid stop, 16 s, {} events | {:.0} | 1 |", rigid.1, rigid.0 / 1e3);
    for ratio in [1e2f64, 1e4, 1e6] {
        let keys = format!("stiffness = {:?}\ndamping = {:?}", 40.0 * ratio, 0.14 * (40.0 * ratio).sqrt());
        let (t, events) = least(|| follow(&machine(&contact(&keys)), 20.0, false));
        println!(
            "| a buffer of {ratio:e} times the mount's stiffness, {events} events | {:.0} | {:.1} |",
            t / 1e3,
            t / rigid.0
        );
    }
    let soft = follow(&machine(&stiff(1.0)), 10.0, false).0;
    for ratio in [1e2, 1e3, 1e4] {
        let (t, _) = follow(&machine(&stiff(ratio)), 10.0, false);
        println!("| frequencies in the ratio {ratio:e}, 8 s | {:.0} | {:.0} |", t / 1e3, t / soft);
    }
    let stiff = chain_of(20, BUFFER, "stiffness = 4e8\ndamping = 4e4");
    let [off, on] = [false, true].map(|accounts| least(|| follow(&machine(&stiff), 2.0, accounts)));
    println!("| 20 bodies, stiffness 1e6 apart, 1.6 s, {} events | {:.0} | |", off.1, off.0 / 1e3);
    println!("| the same, energy accounts on | {:.0} | {:.1} |", on.0 / 1e3, on.0 / off.0);
    for (name, few, many) in [
        ("bodies, buffers between them", chain_of(20, BUFFER, SPRING), chain_of(200, BUFFER, SPRING)),
        ("bodies, each with friction", frictions(10), frictions(100)),
    ] {
        let [few, many] = [few, many].map(|text| {
            let (time, events) = least(|| follow(&machine(&text), 10.0, false));
            time / events as f64 / 1e3
        });
        println!(
            "| {name}, an event | {few:.1} | 1 |\n| ten times as many, an event | {many:.1} | {:.1} |",
            many / few
        );
    }
    let [bodies, beam] = [false, true].map(|is_one| {
        let (time, events) = least(|| follow(&machine(&of_60(is_one)), 5.0, true));
        (time, events)
    });
    println!("| 60 bodies, two stops, 4 s, {} events | {:.0} | 1 |", bodies.1, bodies.0 / 1e3);
    println!(
        "| a body of 60 modes, two stops, {} events | {:.0} | {:.1} |",
        beam.1,
        beam.0 / 1e3,
        beam.0 / bodies.0
    );
    let record = machine(&recorded(25_000, "hold"));
    let (time, _) = least(|| follow_record(Motion::new(record.clone()).expect("a motion")));
    println!("| a record of 25000 held values, 10 s | {:.0} | |", time / 1e3);
    let record = machine(&recorded(25_000, "straight"));
    let motion = || Motion::new(record.clone()).expect("a motion");
    let direct = least(|| follow_record(motion())).0;
    let general = least(|| follow_record(motion().by_general_law())).0;
    println!("| the same, joined by lines | {:.0} | 1 |", direct / 1e3);
    println!("| the same, with the law at each knot | {:.0} | {:.1} |", general / 1e3, general / direct);
    let varied = least(|| {
        let begin = Instant::now();
        let names = ["spring.k.stiffness", "spring.k.damping", "body.a.mass"];
        let mut m = Differentiated::new(record.clone(), &names).expect("a motion");
        m.advance_to(10.0).expect("it moves");
        (begin.elapsed().as_nanos() as f64, 0)
    });
    println!("| the same, three derivative columns | {:.0} | {:.1} |", varied.0 / 1e3, varied.0 / direct);
    for (name, text, end) in [
        ("the 3-DOF machine", paper_machine(&p), periods * p.period()),
        ("a rigid stop", contact("restitution = 0.8"), 20.0),
        ("a chain of 5", chain(5), 10.0),
        ("a chain of 20", chain(20), 10.0),
    ] {
        let machine = machine(&text);
        let mut times = [f64::INFINITY; 2];
        for _ in 0..ROUNDS {
            let own = [follow(&machine, end, true).0, follow_varied(&machine, end).0];
            times.iter_mut().zip(own).for_each(|(least, t)| *least = least.min(t));
        }
        let mut least = [f64::INFINITY; 2];
        for _ in 0..ROUNDS {
            let own = follow_gradient(&machine, end);
            least.iter_mut().zip(own).for_each(|(least, t)| *least = least.min(t));
        }
        println!(
            "| the gradient of a sum of squares over motion alone, {name} | {:.0} | {:.1} |",
            least[1] / 1e3,
            least[1] / least[0]
        );
        println!(
            "| five derivative columns over motion alone, {name} | {:.0} | {:.1} |",
            times[1] / 1e3,
            times[1] / times[0]
        );
    }
}
