//! The standard work (benches/README.md) in every way of this repository, in one run, as ratios.
//! Writes its table to `benches/README.md`. `cargo bench --bench standard_work`

use fmu_build::archive;
use fmu_build::compile::{PLATFORM, Product, SHARED_LIBRARY};
use fmu_build::host::Binary;
use fmu_build::version::Version;
use fmu_build::{package, platforms};
use std::fmt::Write as _;
use std::time::Instant;
use vibro_impact::parameters::FIELDS;
use vibro_impact::reference::{Reference, Tolerance};
use vibro_impact::simulator::advance_together;
use vibro_impact::{Simulator, State};
use vibro_paper_component::component::variables;
use vibro_paper_component::fmi2::description::{self, MODEL_IDENTIFIER};

#[path = "../tests/common/golden.rs"]
#[allow(dead_code, missing_docs)]
mod golden;

use golden::{standard, weak};

/// Number of rounds. Each runs every way once, so that changes of the machine's speed affect all
/// ways alike.
const ROUNDS: usize = 15;
/// Length of a timed run in drive periods.
const PERIODS: f64 = 2000.0;
/// Length of a timed run of the reference method in drive periods; it is hundreds of times slower.
const REFERENCE_PERIODS: f64 = 100.0;

/// Number of motions of a sweep of one system over starts; the first is the standard work.
const STARTS: usize = 16;
/// Number of motions of a sweep over systems from one start, with this many drives and four
/// restitutions; the first is the standard work.
const SYSTEMS: usize = 64;
/// Length of each motion of a timed sweep in drive periods.
const SWEPT_PERIODS: f64 = 200.0;
/// Marks in benches/README.md that enclose the written text.
const BEGIN: &str = "<!-- standard work -->";
const END: &str = "<!-- /standard work -->";

/// A prepared run of n periods that returns the end state.
type Run<'a> = Box<dyn FnOnce(f64) -> State + 'a>;

/// A way to do the work: its name, number of motions, drive periods of a timed run, and the
/// untimed setup of a run.
struct Way<'a> {
    name: String,
    motions: usize,
    periods: f64,
    run: Box<dyn Fn() -> Run<'a> + 'a>,
}

/// One way with one motion.
fn single<'a>(name: &str, periods: f64, run: Box<dyn Fn() -> Run<'a> + 'a>) -> Way<'a> {
    Way { name: name.into(), motions: 1, periods, run }
}

/// Smallest time: nearest to the time on an otherwise idle machine.
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
    // The library in its distributed form.
    let binaries = platforms::own(Product::Vibro).expect("the library is compiled");
    package::write(&archive_path, &Version::USUAL, &binaries, None).expect("the FMU is packed");
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
    let native = |energy: bool| {
        move || -> Run<'_> {
            let mut s = Simulator::new(&p, &start, 0.0).expect("valid");
            if !energy {
                s = s.without_energy_accounts();
            }
            Box::new(move |n| {
                s.advance_to(n * period).expect("it arrives");
                s.state()
            })
        }
    };
    let starts: Vec<Simulator> = (0..STARTS)
        .map(|i| {
            let x = [0.0, start.x[1] - 0.01 * i as f64, 0.0];
            Simulator::new(&p, &State { x, ..start }, 0.0).expect("valid").without_energy_accounts()
        })
        .collect();
    let systems: Vec<Simulator> = (0..SYSTEMS)
        .map(|i| {
            let (kappa, drive) = ([0.75, 0.6, 0.7, 0.9][i % 4], 0.5 + 4.5 * i as f64 / (SYSTEMS - 1) as f64);
            let drive = if i == 0 { 1.5 } else { drive };
            let p = weak(kappa, drive);
            Simulator::new(&p, &start, 0.0).expect("valid").without_energy_accounts()
        })
        .collect();
    let swept = |motions: &Vec<Simulator>, together: bool| {
        let motions = motions.clone();
        move || -> Run<'_> {
            let mut all = motions.clone();
            Box::new(move |n| {
                let end = n / all.len() as f64 * period;
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
                let reference = variables::find(field.name).expect("a parameter").reference;
                instance.set_real(&[reference], &[(field.get)(&p)]).expect("it is allowed");
            }
            let names = ["box.s", "block.s", "secondary.s", "box.v", "block.v", "secondary.v"];
            let references = names.map(|n| variables::find(n).expect("a variable").reference);
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
    let sweep = |what: &str, motions: &Vec<Simulator>, together: bool| {
        let count = motions.len();
        let how = if together { "together on one thread" } else { "one by one" };
        Way {
            name: format!("library, {count} {what}, {how}"),
            motions: count,
            periods: SWEPT_PERIODS * count as f64,
            run: Box::new(swept(motions, together)),
        }
    };
    let ways = [
        single("reference method (RKF45 + bisection), 1e-12", REFERENCE_PERIODS, Box::new(reference(1e-12))),
        single("reference method, 1e-9", REFERENCE_PERIODS, Box::new(reference(1e-9))),
        single("library, energy accounts off", PERIODS, Box::new(native(false))),
        single("library, energy accounts on", PERIODS, Box::new(native(true))),
        sweep("starts of one system", &starts, false),
        sweep("starts of one system", &starts, true),
        sweep("systems of a sweep over drive and restitution", &systems, false),
        sweep("systems of a sweep over drive and restitution", &systems, true),
        single("packaged FMU, one `fmi2DoStep` for the whole run", PERIODS, Box::new(packaged(0.0))),
        single("packaged FMU, a step per period", PERIODS, Box::new(packaged(1.0))),
        single("packaged FMU, 100 steps per period", PERIODS, Box::new(packaged(100.0))),
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
        let error = golden::distance(&(way.run)()(20.0 * way.motions as f64), &truth, 1.0, 1.0);
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
        "{BEGIN}\nWritten by `cargo bench --bench standard_work`: least times of {ROUNDS} rounds in which every way runs once.\nThe work: {PERIODS} drive periods of the dimensionless standard case ({REFERENCE_PERIODS} for the reference \
         method), from the start on,\nwithout setting up; the error is the largest one of any coordinate against a 60-digit \
         solution\n(`tests/data/standard_double_periods.csv`), of several motions that of the first. The systems of the sweep have \
         some three impacts\na period.\n\n{table}\nA simulator for new parameters, tables included: {tables:.0} µs.\n\n\
         `cargo bench --bench steady` times the closed forms.\n"
    );
    print!("{text}");
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/README.md");
    // The rest of the page is kept.
    let old = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{path}: {e}"));
    let parts = old.split_once(BEGIN).and_then(|(before, rest)| Some((before, rest.split_once(END)?.1)));
    let (before, after) = parts.unwrap_or_else(|| panic!("{path} must have {BEGIN} and {END}"));
    let text = format!("{before}{text}{END}{after}");
    std::fs::write(path, text).unwrap_or_else(|e| panic!("{path}: {e}"));
}
