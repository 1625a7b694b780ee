//! Whole studies, as ratios to the paper's method (RKF45 with bisection, 1e-12) on the bare motion in the same run; writes
//! its table to `benches/STUDIES.md`. `cargo bench --bench studies`
//!
//! Targets: the diagram of 451 values × 1200 periods with its maxima ≤ 2 s on two cores, that of 1051 values
//! ≤ 5 s, a spectrum of seven exponents over 1500 periods ≤ 10 ms.

use std::fmt::Write as _;
use std::hint::black_box;
use std::time::Instant;
use vibro_analysis::attractor::OBSERVED;
use vibro_analysis::bifurcation::{Sweep, diagram};
use vibro_analysis::isoperiodic::{Request, StartRule, isoperiodic};
use vibro_analysis::maxima::Displacement;
use vibro_analysis::parts::Task;
use vibro_analysis::plane::ParameterAxis;
use vibro_analysis::stroboscopic::moving_block;
use vibro_analysis::trajectories::{Start, propagate};
use vibro_analysis::{ParameterSet, find_group, lyapunov};
use vibro_impact::reference::{Reference, Tolerance};
use vibro_impact::{Parameters, Simulator};

const ROUNDS: usize = 5;
/// Resolution of the processors' clock, s.
const TICK: f64 = 0.01;
const THREADS: usize = 2;
/// The paper's transient and its record, in drive periods.
const DISCARD: u32 = 400;
const KEEP: u32 = 800;
/// Periods of the reference method, hundreds of times slower, at each of some values.
const REFERENCE_PERIODS: f64 = 25.0;

/// Least wall time of the rounds, and the processors' time in it (Linux; else the wall time), s.
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
    // After the name in brackets, which may hold blanks: fields 14 and 15 of all.
    let fields: Vec<&str> = text.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks: f64 = fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?;
    Some(ticks * TICK)
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

fn main() {
    rayon::ThreadPoolBuilder::new().num_threads(THREADS).build_global().expect("threads");
    let base = reference();
    let mut table = String::from(
        "| study | wall, s | processors, s | by the reference method, processors, s | ratio of processor times |\n|---|---|---|---|---|\n",
    );
    let mut row = |name: &str, periods: f64, (wall, spent): (f64, f64)| {
        let slow = base * periods;
        // What is too short for the processors' clock runs on one thread: there both times are one.
        let spent = if spent < 20.0 * TICK { wall.max(spent) } else { spent };
        writeln!(table, "| {name} | {wall:.4} | {spent:.4} | {slow:.2} | {:.0} |", slow / spent)
            .expect("memory");
    };
    let group = find_group("f10").expect("a group");
    for (range, count) in [((0.5, 5.0), 451), ((1.9, 4.0), 1051)] {
        let axis = ParameterAxis::new(group, range, count).expect("an axis");
        let sweep = Sweep { axis, discard: DISCARD, keep: KEEP, exponents: None, of: Displacement::X2 };
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
    let plane = Request { x, y, start: StartRule::default(), discard: 300, exponents: None };
    let time = timed(|| {
        let found = isoperiodic(&ParameterSet::basic(), &plane, &Task::ALL);
        black_box(found.expect("allowed"));
    });
    let periods = plane.discard + OBSERVED;
    row(
        &format!("plane of 100 × 100 motions over (sigma1, f10), {periods} periods each, classified"),
        1e4 * f64::from(periods),
        time,
    );
    let text = format!(
        "# Studies\n\nWritten by `cargo bench --bench studies` on {THREADS} threads: least times of {ROUNDS} rounds. The reference method is the \
         paper's own\n(RKF45 with bisection, 1e-12), for the bare motion: without maxima and without variations; its mean time over\nthe diagram's values is {:.0} µs a period. Wall times hold for a quiet machine only; processor times hold anyway.\n\n{table}",
        1e6 * base
    );
    print!("{text}");
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/STUDIES.md");
    std::fs::write(path, text).unwrap_or_else(|e| panic!("{path}: {e}"));
}
