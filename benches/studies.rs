//! Whole studies, as ratios to the paper's method (RKF45 with bisection, 1e-12) on the bare motion
//! in the same run; motions side by side as ratios to one by one; and the work of a drive period
//! as counts, which do not require a quiet machine. Writes its tables to `benches/STUDIES.md`.
//! `cargo bench --bench studies`, or only a part, which writes nothing: `-- studies`, `-- lanes`,
//! `-- work`
//!
//! Targets: the diagram of 451 values × 1200 periods with its maxima ≤ 2 s on two cores, the
//! diagram of 1051 values ≤ 5 s, a spectrum of seven exponents over 1500 periods ≤ 10 ms.

use std::fmt::Write as _;
use std::hint::black_box;
use std::time::Instant;
use vibro_impact::reference::{Reference, Tolerance};
use vibro_impact::simulator::{LaneUse, Way};
use vibro_impact::{Groups, Parameters, Scales, Simulator};
use vibro_studies::OBSERVED;
use vibro_studies::diagram::diagram;
use vibro_studies::isoperiodic::isoperiodic;
use vibro_studies::paper::bifurcation::Sweep;
use vibro_studies::paper::isoperiodic::IsoperiodicRequest;
use vibro_studies::paper::maxima::Displacement;
use vibro_studies::paper::plane::ParameterAxis;
use vibro_studies::paper::start::StartRule;
use vibro_studies::paper::stroboscopic::{dimensional, moving_block};
use vibro_studies::paper::trajectories::{Program, Start, Workspace, propagate};
use vibro_studies::paper::{ParameterSet, find_group, lyapunov};
use vibro_studies::parts::Task;

const ROUNDS: usize = 5;
/// Resolution of the processors' clock, s.
const TICK: f64 = 0.01;
const THREADS: usize = 2;
/// The paper's transient, in drive periods.
const DISCARD: u32 = 400;
/// The paper's record, in drive periods.
const KEEP: u32 = 800;
/// Periods of the reference method at each value; it is hundreds of times slower.
const REFERENCE_PERIODS: f64 = 25.0;

/// Smallest wall time and smallest processor time of the rounds, s (outside Linux, the wall time
/// for both).
fn timed(mut run: impl FnMut()) -> (f64, f64) {
    let mut best = (f64::INFINITY, f64::INFINITY);
    for _ in 0..ROUNDS {
        let (begin, used) = (Instant::now(), processor());
        run();
        let wall = begin.elapsed().as_secs_f64();
        let spent = match (used, processor()) {
            (Some(a), Some(b)) => b - a,
            _ => wall,
        };
        best = (best.0.min(wall), best.1.min(spent));
    }
    best
}

/// Processor time of this process so far, s, in hundredths.
fn processor() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    // Fields 14 and 15, counted after the name in parentheses, which may contain spaces.
    let fields: Vec<&str> = text.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks: f64 = fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?;
    Some(ticks * TICK)
}

/// Name of the processors (Linux) and their widest vectors.
fn machine() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    let name = name.map_or("an unnamed processor", |(_, name)| name.trim());
    #[cfg(target_arch = "x86_64")]
    let vectors = if is_x86_feature_detected!("avx512f") { "AVX-512" } else { "AVX2 or less" };
    #[cfg(not(target_arch = "x86_64"))]
    let vectors = std::env::consts::ARCH;
    format!("{name} ({vectors})")
}

fn at(f10: f64) -> Parameters {
    let group = find_group("f10").expect("a group");
    *ParameterSet::basic().with(group, f10).expect("allowed").parameters()
}

/// Mean time of a drive period by the reference method over the values of the diagram, s.
fn reference() -> f64 {
    let values = [0.6, 1.5, 2.45, 2.7, 3.1, 3.6, 4.5];
    let mut sum = 0.0;
    for f10 in values {
        let p = at(f10);
        let (wall, _) = timed(|| {
            let start = moving_block(&p);
            let mut r = Reference::new(&p, &start, 0.0, Tolerance::new(1e-12)).expect("valid");
            r.advance_to(REFERENCE_PERIODS * p.period()).expect("it arrives");
            black_box(r.state());
        });
        sum += wall / REFERENCE_PERIODS;
    }
    sum / values.len() as f64
}

fn studies() -> String {
    rayon::ThreadPoolBuilder::new().num_threads(THREADS).build_global().expect("threads");
    let base = reference();
    let mut table = String::from(
        "| study | wall, s | processors, s | by the reference method, processors, s | ratio of processor times |\n|---|---|---|---|---|\n",
    );
    let mut row = |name: &str, periods: f64, (wall, spent): (f64, f64)| {
        let slow = base * periods;
        // The clock is too coarse for short work; it runs on one thread, where both times are
        // equal.
        let spent = if spent < 20.0 * TICK { wall.max(spent) } else { spent };
        writeln!(table, "| {name} | {wall:.4} | {spent:.4} | {slow:.2} | {:.0} |", slow / spent)
            .expect("memory");
    };
    let group = find_group("f10").expect("a group");
    for (range, count) in [((0.5, 5.0), 451), ((1.9, 4.0), 1051)] {
        let axis = ParameterAxis::new(group, range, count).expect("an axis");
        let sweep = Sweep::new(axis, Displacement::X2, (DISCARD, KEEP));
        let time = timed(|| {
            let found = diagram(&ParameterSet::basic(), &sweep, &Task::ALL);
            black_box(found.expect("allowed"));
        });
        let periods = 2.0 * count as f64 * f64::from(DISCARD + KEEP);
        row(
            &format!("bifurcation diagram, {count} values × {} periods, maxima, up and down", DISCARD + KEEP),
            periods,
            time,
        );
    }
    for f10 in [1.5, 2.45, 3.6] {
        let p = at(f10);
        let mut settled =
            Simulator::new(&p, &moving_block(&p), 0.0).expect("valid").without_energy_accounts();
        settled.advance_to(400.0 * p.period()).expect("it arrives");
        let options = lyapunov::SpectrumOptions { align: 0, ..lyapunov::SpectrumOptions::default() };
        let time = timed(|| {
            black_box(lyapunov::spectrum(&mut settled.clone(), &options).expect("valid"));
        });
        row(&format!("seven exponents, 1500 periods, one thread, f10 = {f10}"), 1500.0, time);
    }
    let p = at(1.5);
    let starts = vec![Start { parameters: p, state: moving_block(&p) }; 4000];
    let time = timed(|| {
        black_box(propagate(&starts, 400, &|| ()));
    });
    row("4000 independent motions, 400 periods each", 1_600_000.0, time);
    let axis = |name| {
        let group = find_group(name).expect("a group");
        ParameterAxis::new(group, group.shown, 100).expect("an axis")
    };
    let (x, y) = (axis("sigma1"), axis("f10"));
    for (exponents, what) in [(None, "classified"), (Some(400), "classified, with largest exponents")] {
        let plane = IsoperiodicRequest { x, y, start: StartRule::default(), discard: 300, exponents };
        let time = timed(|| {
            let found = isoperiodic(&ParameterSet::basic(), &plane, &Task::ALL);
            black_box(found.expect("allowed"));
        });
        let periods = plane.discard + OBSERVED;
        row(
            &format!("plane of 100 × 100 motions over (sigma1, f10), up to {periods} periods each, {what}"),
            1e4 * f64::from(periods),
            time,
        );
    }
    format!(
        "The reference method is the paper's own\n(RKF45 with bisection, 1e-12), for the bare motion: without maxima and without variations; its mean time over\nthe diagram's values is {:.0} µs a period. Wall times hold for a quiet machine only; processor times hold anyway.\n\n{table}",
        1e6 * base
    )
}

/// Motions of a study and the program of each.
struct Work {
    name: &'static str,
    starts: Vec<Start>,
    program: Program,
}

/// Pseudo-random numbers in [0, 1), the same on all machines.
fn numbers(mut seed: u64) -> impl FnMut() -> f64 {
    move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Motions that the studies run side by side, fewer than in a study but of all kinds.
fn works() -> Vec<Work> {
    const PLANE: usize = 20;
    let axis = |name| {
        let group = find_group(name).expect("a group");
        ParameterAxis::new(group, group.shown, PLANE).expect("an axis")
    };
    let (x, y) = (axis("sigma1"), axis("f10"));
    let start = |parameters: Parameters| Start { parameters, state: moving_block(&parameters) };
    let point = |k: usize| {
        let set = ParameterSet::basic().with(x.name, x.value(k % PLANE)).expect("allowed");
        start(*set.with(y.name, y.value(k / PLANE)).expect("allowed").parameters())
    };
    let whole = Program { discard: 300, observed: true, ..Program::default() };
    let settled = Program { until_settled: true, ..whole };
    let p = at(2.45);
    let cell = |k: usize| {
        let part = |i: usize| (i as f64 + 0.5) / PLANE as f64;
        let state = [2.0 * part(k % PLANE) - 1.0, 0.0, 0.0, 0.0, 4.0 * part(k / PLANE) - 2.0, 0.0];
        Start { parameters: p, state: dimensional(&p, &state) }
    };
    let mut next = numbers(16);
    let mut random = |k: usize| {
        let mut between = |low: f64, high: f64| low + (high - low) * next();
        let restitution = between(0.2, 0.95);
        let groups = Groups::weak(
            between(0.02, 0.3),
            if k.is_multiple_of(10) { 0.0 } else { restitution },
            between(0.5, 5.0),
            between(-0.5, 0.5),
            between(0.1, 1.0),
            between(0.05, 1.0),
            between(-0.5, 0.5),
            between(0.1, 1.0),
        );
        start(groups.to_parameters(Scales::default()).expect("allowed"))
    };
    let keep = Program { maxima: Some((Displacement::X2, KEEP)), observed: true, ..Program::default() };
    let all = PLANE * PLANE;
    vec![
        Work {
            name: "classified plane over (sigma1, f10)",
            starts: (0..all).map(point).collect(),
            program: settled,
        },
        Work {
            name: "the same with largest exponents",
            starts: (0..all).map(point).collect(),
            program: Program { exponent: Some(400), ..settled },
        },
        Work {
            name: "the same motions to their ends, 428 periods",
            starts: (0..all).map(point).collect(),
            program: whole,
        },
        Work { name: "basins at f10 = 2.45", starts: (0..all).map(cell).collect(), program: settled },
        Work {
            name: "maxima of 800 periods over f10, observed",
            starts: (0..96).map(|k| start(at(0.5 + 4.5 * k as f64 / 95.0))).collect(),
            program: keep,
        },
        Work {
            name: "random systems, a tenth with kappa = 0",
            // So many that the last ones, which leave lanes empty, are a small part.
            starts: (0..800).map(&mut random).collect(),
            program: Program { discard: 400, ..Program::default() },
        },
        Work {
            name: "eight motions of the plane",
            starts: (0..8).map(|k| point(50 * k)).collect(),
            program: settled,
        },
    ]
}

/// Motions side by side and one by one, alternating on one thread, with the widest vectors of the
/// machine and with AVX2.
fn lanes() -> String {
    let mut table = String::from(
        "| work | motions | vectors | single path, µs a motion | one by one | side by side | single path / side by side | one by one / side by side | lanes occupied | lanes that moved | sub-steps for each passed on |\n|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    let vectors =
        [("widest", (Way::OneByOne, Way::Together)), ("AVX2", (Way::OneByOneAvx2, Way::TogetherAvx2))];
    for Work { name, starts, program } in works() {
        for (vectors, ways) in vectors {
            let mut spaces = [ways.0, ways.0, ways.1].map(|way| {
                let mut space = Workspace::default();
                space.way = way;
                space
            });
            let to_its_end = Program { until_settled: false, ..program };
            let mut best = [f64::INFINITY; 3];
            for _ in 0..ROUNDS {
                let programs = [&to_its_end, &program, &program];
                for ((space, best), program) in spaces.iter_mut().zip(&mut best).zip(programs) {
                    space.used = LaneUse::default();
                    let begin = Instant::now();
                    space.run(&mut starts.iter().copied(), program, &mut |_, outcome| {
                        let _ = black_box(outcome);
                    });
                    *best = best.min(begin.elapsed().as_secs_f64());
                }
            }
            let used = spaces[2].used;
            let [single, alone, together] = best.map(|time| 1e6 * time / starts.len() as f64);
            let each = used.substeps as f64 / used.handed_over.max(1) as f64;
            let (count, gain, ratio) = (starts.len(), single / together, alone / together);
            let (occupied, moved) = (used.occupation(), used.utilisation());
            writeln!(
                table,
                "| {name} | {count} | {vectors} | {single:.1} | {alone:.1} | {together:.1} | {gain:.2} | {ratio:.2} | {occupied:.2} | {moved:.2} | {each:.0} |"
            )
            .expect("memory");
        }
    }
    format!(
        "## Side by side and one by one\n\nThe same motions with the same reports on one thread, tables and the recognition of periods included: least times of {ROUNDS} rounds in \
         which all ways run in turns.\nThe single path simulates each motion to its end, as `attractor::observe` does; one by one and side by side end it once it is known \
         what it has settled on.\nA lane is occupied while it has a motion; in a round it moves it, or hands it over to the code for a single one.\n\n{table}"
    )
}

/// Counts of the work of a drive period, one by one; equal in every run on one instruction set.
fn work() -> String {
    const PERIODS: f64 = 200.0;
    let mut table =
        String::from("| motion | sub-steps | expansions | iterations | events |\n|---|---|---|---|---|\n");
    let basic = |f10, kappa| {
        Groups { f10, kappa, ..Groups::basic() }.to_parameters(Scales::default()).expect("allowed")
    };
    for (name, p) in [
        ("few impacts, f10 = 0.3", basic(0.3, 0.75)),
        ("two impacts, f10 = 1.5", basic(1.5, 0.75)),
        ("chaos, f10 = 3.6", basic(3.6, 0.75)),
        ("rest, f10 = 3, kappa = 0", basic(3.0, 0.0)),
        ("low restitution, f10 = 2, kappa = 0.3", basic(2.0, 0.3)),
    ] {
        let mut s = Simulator::new(&p, &moving_block(&p), 0.0).expect("valid").without_energy_accounts();
        s.advance_to(PERIODS * p.period()).expect("it arrives");
        let w = s.work_counters();
        let [a, b, c, d] = [w.substeps, w.expansions, w.iterations, w.events].map(|n| n as f64 / PERIODS);
        writeln!(table, "| {name} | {a:.2} | {b:.2} | {c:.2} | {d:.2} |").expect("memory");
    }
    format!(
        "## Work of a drive period\n\nOne by one, over the first {PERIODS} periods; counts, so that a loss shows on any machine.\n\n{table}"
    )
}

fn main() {
    let asked: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let on = |name: &str| asked.is_empty() || asked.iter().any(|a| a == name);
    let mut text = format!(
        "# Studies\n\nWritten by `cargo bench --bench studies` on {THREADS} threads of {}: least times of {ROUNDS} rounds. ",
        machine()
    );
    for (name, part) in [("studies", studies as fn() -> String), ("lanes", lanes), ("work", work)] {
        if on(name) {
            let part = part();
            println!("{part}");
            text += &part;
            text += "\n";
        }
    }
    if asked.is_empty() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/STUDIES.md");
        std::fs::write(path, text.trim_end().to_owned() + "\n").unwrap_or_else(|e| panic!("{path}: {e}"));
    }
}
