//! The standard work of performance.md by every way that this repository has, in one run, as ratios; writes its table
//! to `benches/README.md`. `cargo bench --bench standard_work`

use fmu_build::archive;
use fmu_build::compile::{PLATFORM, SHARED_LIBRARY};
use fmu_build::host::Binary;
use std::fmt::Write as _;
use std::time::Instant;
use vibro_impact::fmi2::description::{self, MODEL_IDENTIFIER};
use vibro_impact::fmi2::variables;
use vibro_impact::parameters::FIELDS;
use vibro_impact::reference::{Reference, Tolerance};
use vibro_impact::simulator::advance_together;
use vibro_impact::{Groups, Parameters, Scales, Simulator, State};

#[path = "../tests/common/golden.rs"]
#[allow(dead_code, missing_docs)]
mod golden;

/// Rounds: in each every way runs once, so that a change of the machine's speed meets all alike.
const ROUNDS: usize = 15;
/// Drive periods of a timed run; the reference method, hundreds of times slower, runs fewer.
const PERIODS: f64 = 2000.0;
const REFERENCE_PERIODS: f64 = 100.0;

/// Motions of a sweep, each from its own start, and the periods that each runs when timed.
const MOTIONS: usize = 16;
const SWEPT_PERIODS: f64 = 200.0;

/// A run of n periods that returns the end state, set up already.
type Run<'a> = Box<dyn FnOnce(f64) -> State + 'a>;

/// One way to do the work: its name, the periods it runs when timed, and what sets up a run, untimed.
struct Way<'a> {
    name: String,
    periods: f64,
    run: Box<dyn Fn() -> Run<'a> + 'a>,
}

fn standard() -> (Parameters, State) {
    let p = Groups::weak(0.1, 0.75, 1.5, 0.0, 0.4, 0.2, 0.0, 0.4)
        .to_parameters(Scales::default())
        .expect("valid");
    (p, State { x: [0.0, 0.9, 0.0], v: [0.0, 0.5, 0.0] })
}

/// The least time: what the machine does when nothing else runs on it.
fn least(times: &[f64]) -> f64 {
    times.iter().copied().fold(f64::INFINITY, f64::min)
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() {
    let (p, start) = standard();
    let period = p.period();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let archive_path = folder.path().join("model.fmu");
    fmu_build::package::build(&archive_path).expect("the FMU builds");
    let name = format!("{MODEL_IDENTIFIER}{SHARED_LIBRARY}");
    let library = folder.path().join(&name);
    let bytes =
        archive::read(&archive_path, &format!("binaries/{PLATFORM}/{name}")).expect("it holds the binary");
    archive::write_file(&library, &bytes).expect("it can be written");
    let binary = Binary::load(&library).expect("the packaged binary loads");

    let reference = |tolerance: f64| {
        move || -> Run<'_> {
            let mut r = Reference::new(&p, &start, 0.0, Tolerance::new(tolerance)).expect("valid");
            Box::new(move |n| {
                r.advance_to(n * period).expect("it arrives");
                r.state()
            })
        }
    };
    let native = |ledger: bool| {
        move || -> Run<'_> {
            let mut s = Simulator::new(&p, &start, 0.0).expect("valid");
            if !ledger {
                s = s.without_ledger();
            }
            Box::new(move |n| {
                s.advance_to(n * period).expect("it arrives");
                s.state()
            })
        }
    };
    let swept = |together: bool| {
        move || -> Run<'_> {
            let first = Simulator::new(&p, &start, 0.0).expect("valid").without_ledger();
            let mut all: Vec<Simulator> = (0..MOTIONS)
                .map(|i| {
                    let x = [0.0, start.x[1] - 0.01 * i as f64, 0.0];
                    first.another(&State { x, ..start }, 0.0).expect("valid")
                })
                .collect();
            Box::new(move |n| {
                let end = n / MOTIONS as f64 * period;
                if together {
                    for result in advance_together(&mut all, |_| end) {
                        result.expect("it arrives");
                    }
                } else {
                    all.iter_mut().for_each(|s| s.advance_to(end).expect("it arrives"));
                }
                all[0].state()
            })
        }
    };
    let packaged = |steps_per_period: f64| {
        let (binary, guid) = (&binary, description::guid());
        move || -> Run<'_> {
            let mut instance = binary.instantiate(&guid).expect("it instantiates");
            for field in &FIELDS {
                let reference = variables::find(field.name).expect("a parameter").0;
                instance.set_real(&[reference], &[(field.get)(&p)]).expect("it is allowed");
            }
            let names = ["box.s", "block.s", "secondary.s", "box.v", "block.v", "secondary.v"];
            let references = names.map(|n| variables::find(n).expect("a variable").0);
            let [x, v] = [start.x, start.v];
            instance.set_real(&references, &[x[0], x[1], x[2], v[0], v[1], v[2]]).expect("it is allowed");
            instance.initialize(0.0).expect("it initializes");
            Box::new(move |n| {
                let steps = (n * steps_per_period).round().max(1.0);
                let size = n * period / steps;
                for k in 0..steps as u64 {
                    instance.step(k as f64 * size, size).expect("it steps");
                }
                let r = instance.real(&references).expect("it reads");
                State { x: [r[0], r[1], r[2]], v: [r[3], r[4], r[5]] }
            })
        }
    };
    let ways = [
        Way {
            name: "reference method (RKF45 + bisection), 1e-12".into(),
            periods: REFERENCE_PERIODS,
            run: Box::new(reference(1e-12)),
        },
        Way {
            name: "reference method, 1e-9".into(),
            periods: REFERENCE_PERIODS,
            run: Box::new(reference(1e-9)),
        },
        Way { name: "library, energy accounts off".into(), periods: PERIODS, run: Box::new(native(false)) },
        Way { name: "library, energy accounts on".into(), periods: PERIODS, run: Box::new(native(true)) },
        Way {
            name: format!("library, {MOTIONS} motions of a sweep, one by one"),
            periods: SWEPT_PERIODS * MOTIONS as f64,
            run: Box::new(swept(false)),
        },
        Way {
            name: format!("library, {MOTIONS} motions of a sweep, together on one thread"),
            periods: SWEPT_PERIODS * MOTIONS as f64,
            run: Box::new(swept(true)),
        },
        Way {
            name: "packaged FMU, one `fmi2DoStep` for the whole run".into(),
            periods: PERIODS,
            run: Box::new(packaged(0.0)),
        },
        Way {
            name: "packaged FMU, a step per period".into(),
            periods: PERIODS,
            run: Box::new(packaged(1.0)),
        },
        Way {
            name: "packaged FMU, 100 steps per period".into(),
            periods: PERIODS,
            run: Box::new(packaged(100.0)),
        },
    ];

    let mut times = vec![Vec::with_capacity(ROUNDS); ways.len()];
    for round in 0..=ROUNDS {
        for (way, times) in ways.iter().zip(&mut times) {
            let run = (way.run)();
            let begin = Instant::now();
            std::hint::black_box(run(way.periods));
            if round > 0 {
                times.push(begin.elapsed().as_secs_f64() * 1e9 / way.periods);
            }
        }
    }
    let truth = golden::table("standard_double_periods.csv").last().expect("20 periods").state("");
    let mut table = String::from(
        "| way | ns per drive period | times the reference method at 1e-12 | error after 20 periods |\n|---|---|---|---|\n",
    );
    let base = least(&times[0]);
    for (way, times) in ways.iter().zip(&times) {
        let motions = if way.name.contains("sweep") { MOTIONS as f64 } else { 1.0 };
        let error = golden::distance(&(way.run)()(20.0 * motions), &truth, 1.0, 1.0);
        let ns = least(times);
        let ratio = base / ns;
        writeln!(table, "| {} | {ns:.0} | {ratio:.1} | {error:.1e} |", way.name).expect("memory");
    }
    let mut news: Vec<f64> = (0..200)
        .map(|_| {
            let begin = Instant::now();
            std::hint::black_box(Simulator::new(&p, &start, 0.0).expect("valid"));
            begin.elapsed().as_secs_f64() * 1e6
        })
        .collect();
    let tables = median(&mut news);
    let text = format!(
        "# Benches\n\nWritten by `cargo bench --bench standard_work`: least times of {ROUNDS} rounds in which every way runs once.\nThe work: {PERIODS} drive periods of the dimensionless standard case ({REFERENCE_PERIODS} for the reference \
         method), from the start on,\nwithout setting up; the error is the largest one of any coordinate against a 60-digit \
         solution\n(`tests/data/standard_double_periods.csv`).\n\n{table}\nA simulator for new parameters, tables included: {tables:.0} µs.\n\n\
         `cargo bench --bench steady` times the closed forms.\n"
    );
    print!("{text}");
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/README.md");
    // What other benches say stands below its first heading and stays.
    let old = std::fs::read_to_string(path).unwrap_or_default();
    let text = text + old.find("\n## ").map_or("", |place| &old[place..]);
    std::fs::write(path, text).unwrap_or_else(|e| panic!("{path}: {e}"));
}
