//! Cost of a described machine's packaged FMU compared with the engine's own work: a step, an
//! instance, an archive; in one run. `cargo bench -p benches --bench machine`

use fmu_build::kit;
use fmu_build::version::{MODEL_DESCRIPTION, Version};
use fmu_build::{archive, assembly, host};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;
use vibro_machine::Motion;
use vibro_machine_component::Plan;

/// Number of rounds; each runs every way once, and the smallest time of each way counts.
const ROUNDS: usize = 25;
/// Number of steps in a round.
const STEPS: u32 = 4000;
/// Step size, s: much less than the fastest period, so that the flow takes little of the time.
const STEP: f64 = 1.0 / 1024.0;

/// Ten bodies on springs, with a clearance between the first two, a buffer, dry friction, a load
/// and an input.
fn chain() -> String {
    let mut text = String::from("name = \"Chain\"\n");
    for i in 0..10 {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "[body.b{i}]\nmass = 1.0");
        let _ = writeln!(
            text,
            "[spring.g{i}]\nbetween = [\"ground\", \"b{i}\"]\nstiffness = 20.0\ndamping = 0.2"
        );
        if i > 1 {
            let _ = writeln!(text, "[spring.k{i}]\nbetween = [\"b{}\", \"b{i}\"]\nstiffness = 40.0", i - 1);
        }
    }
    text + "[stop.u]\nbetween = [\"b0\", \"b1\"]\ngap = 0.05\nrestitution = 0.6\n\
            [stop.l]\nbetween = [\"b1\", \"b0\"]\ngap = 0.05\nrestitution = 0.6\n\
            [stop.buffer]\nbetween = [\"ground\", \"b9\"]\ngap = 0.1\nstiffness = 400.0\ndamping = 1.0\n\
            [friction.guide]\nbetween = [\"ground\", \"b5\"]\nforce = 0.1\n\
            [load.drive]\non = \"b0\"\namplitude = 1.0\nfrequency = 1.0\n\
            [load.push]\non = \"b2\"\ninput = true\n"
}

/// Time of some work, s.
fn timed(work: &mut dyn FnMut()) -> f64 {
    let begin = Instant::now();
    work();
    begin.elapsed().as_secs_f64()
}

/// Name of a way to make all steps, and the function, which returns its time, s.
type Way<'a> = (&'a str, Box<dyn FnMut() -> f64 + 'a>);

/// Time of all steps, s; calls `step` with the start time of each.
fn steps(mut step: impl FnMut(f64)) -> f64 {
    timed(&mut || (0..STEPS).for_each(|k| step(f64::from(k) * STEP)))
}

/// An unpacked archive, so that its library finds its resources.
struct Unpacked {
    library: PathBuf,
    token: String,
}

impl Unpacked {
    fn new(fmu: &Path, version: Version, folder: &Path) -> Self {
        let content = archive::read_all(fmu).expect("an archive");
        for (name, bytes) in &content {
            archive::write_file(&folder.join(name), bytes).expect("a file there");
        }
        let text = String::from_utf8_lossy(&content[MODEL_DESCRIPTION]);
        let key = if version == Version::Fmi2 { "guid=\"" } else { "instantiationToken=\"" };
        let token = text.split(key).nth(1).and_then(|rest| rest.split('"').next()).expect("a token");
        let library = version.own_binary().replace("VibroImpact3DOF", "Chain");
        Self { library: folder.join(library), token: token.to_owned() }
    }
}

/// Time of all steps by the engine alone, s; with `talks`, each step sets the input.
fn native(plan: &Plan, talks: bool) -> f64 {
    let mut motion = Motion::new(plan.assembly.clone()).expect("it has a start");
    steps(|point| {
        if talks {
            motion.set_input(0, [point.sin(), 0.0, 0.0, 0.0]).expect("a finite number");
        }
        motion.advance_to(point + STEP).expect("it moves");
    })
}

fn main() {
    let folder = tempfile::tempdir().expect("a folder for such files");
    let source = folder.path().join("chain.toml");
    std::fs::write(&source, chain()).expect("a file there");
    let plan = Plan::of(&vibro_machine::file::read(&source).expect("a machine")).expect("a machine");
    let kit = kit::own().expect("the library that serves all machines");
    let output = folder.path().join("Chain.fmu");
    let pack = || drop(assembly::write(&source, Some(&output), false, &kit).expect("archives"));
    let packed = (0..ROUNDS).map(|_| timed(&mut || pack())).fold(f64::INFINITY, f64::min);
    let [two, three] = Version::USUAL
        .map(|version| Unpacked::new(&version.beside(&output), version, &folder.path().join(version.name())));

    let mut library = None;
    let load = || host::Binary::load(&two.library).expect("a library");
    let loaded = timed(&mut || {
        let binary = library.insert(load());
        binary.instantiate(&two.token).expect("an instance").initialize(0.0).expect("it begins");
    });
    let library = library.expect("it was loaded");
    let library3 = host::fmi3::Binary::load(&three.library).expect("a library");
    let begun = || {
        let mut instance = library.instantiate(&two.token).expect("an instance");
        instance.initialize(0.0).expect("it begins");
        instance
    };
    let reference = |name: &str| plan.table.reference(name).expect("a variable");
    let input = [reference("load.push.input")];
    let outputs: [u32; 10] = std::array::from_fn(|i| reference(&format!("b{i}.s")));
    let mut ways: [Way<'_>; 5] = [
        ("the engine alone", Box::new(|| native(&plan, false))),
        (
            "`fmi2DoStep`",
            Box::new(|| {
                let mut instance = begun();
                steps(|point| instance.step(point, STEP).expect("a step"))
            }),
        ),
        (
            "`fmi3DoStep`",
            Box::new(|| {
                let mut instance = library3.instantiate(&three.token).expect("an instance");
                instance.initialize(0.0).expect("it begins");
                steps(|point| instance.step(point, STEP).expect("a step"))
            }),
        ),
        ("the engine alone, its input set at every step", Box::new(|| native(&plan, true))),
        (
            "`fmi2SetReal` of it, `fmi2DoStep`, `fmi2GetReal` of ten",
            Box::new(|| {
                let mut instance = begun();
                steps(|point| {
                    instance.set_real(&input, &[point.sin()]).expect("an input");
                    instance.step(point, STEP).expect("a step");
                    instance.real(&outputs).expect("outputs");
                })
            }),
        ),
    ];
    let mut least = [f64::INFINITY; 5];
    for _ in 0..ROUNDS {
        for (least, (_, way)) in least.iter_mut().zip(&mut ways) {
            *least = least.min(way());
        }
    }
    println!("| a step of 1/1024 s of a machine of ten bodies | µs | µs beside the engine |\n|---|---|---|");
    for (k, (name, _)) in ways.iter().enumerate() {
        let engine = least[if k < 3 { 0 } else { 3 }];
        let micros = |seconds: f64| seconds * 1e6 / f64::from(STEPS);
        println!("| {name} | {:.2} | {:.2} |", micros(least[k]), micros(least[k] - engine));
    }
    let made = (0..ROUNDS).map(|_| timed(&mut || drop(begun()))).fold(f64::INFINITY, f64::min);
    println!("\n| work | ms |\n|---|---|");
    println!("| the library loaded and an instance initialized, the first time | {:.2} |", 1e3 * loaded);
    println!("| a further instance, initialized | {:.2} |", 1e3 * made);
    println!("| both archives packed, the library being there | {:.0} |", 1e3 * packed);
}
