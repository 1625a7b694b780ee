//! Runs the real `vibro assembly bifurcation|lyapunov|sweep`: against the library, in shards, and what it refuses.

#[path = "common/mod.rs"]
mod command;

use command::{command, drawn, folder, refused, table};
use std::path::Path;
use vibro_analysis::assembly::{Machine, Start, discard, measure};

const DAMPER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/assembly/damper_with_buffer.toml");
const SWEEP: [&str; 12] = [
    "assembly",
    "sweep",
    DAMPER,
    "--vary",
    "stop.steel.gap=4mm:5mm:2",
    "--vary",
    "stop.buffer.gap=6mm,-20mm",
    "--output",
    "amplitude.box.s,impacts.steel,power.buffer,class",
    "--discard",
    "60",
    "--periods=6",
];

fn read(out: &Path, name: &str) -> Vec<u8> {
    std::fs::read(out.join(name)).expect("a file")
}

#[test]
fn second_method_a_sweep_has_the_librarys_numbers_and_shards_make_the_whole() {
    let (out, parts) = (folder("assembly-sweep"), folder("assembly-sweep-shards"));
    let said = drawn(&out, &SWEEP);
    assert!(said.contains("4 designs over stop.steel.gap, stop.buffer.gap"), "{said}");
    assert!(said.contains("amplitude.box.s: least"), "{said}");
    let rows = table(&out, "assembly-sweep.csv");
    assert_eq!(rows.len(), 4);
    let measures: Vec<_> = SWEEP[8].split(',').map(|name| name.parse().unwrap()).collect();
    let machine = Machine::new(vibro_assembly::file::read(DAMPER.as_ref()).unwrap());
    for row in rows.iter().take(1) {
        let value = |name: &str| row[name].parse::<f64>().unwrap();
        let names = ["stop.steel.gap", "stop.buffer.gap"];
        let own = machine.with(names.map(|name| (name, value(name)))).unwrap();
        let (mut motion, section) = own.motion(&Start::default()).unwrap();
        discard(&mut motion, &section, 60).unwrap();
        let found = measure(&mut motion, &section, &measures, 6).unwrap();
        for (name, number) in ["amplitude.box.s", "impacts.steel", "power.buffer"].iter().zip(&found.numbers)
        {
            assert_eq!(value(name).to_bits(), number.unwrap().to_bits(), "{name}");
        }
        assert_eq!(row["class"], found.class.unwrap().name());
        // Written in mm, the gap has a column in mm.
        assert_eq!(value("stop.steel.gap [mm]"), 4.0);
    }
    // The buffer pressed far in from the start is a design without an equilibrium; it has a row that says why.
    assert!(rows.iter().all(|row| row["reason"].is_empty() != row["amplitude.box.s"].is_empty()));
    for share in ["1/2", "2/2"] {
        drawn(&parts.join(share.replace('/', "-")), &[&SWEEP[..], &["--shard", share]].concat());
    }
    let merged = parts.join("merged");
    let folders = ["1-2", "2-2"].map(|name| parts.join(name).display().to_string());
    // Four designs are one part, which the first share has.
    if parts.join("1-2/assembly-sweep.csv").exists() {
        assert_eq!(read(&parts.join("1-2"), "assembly-sweep.csv"), read(&out, "assembly-sweep.csv"));
    } else {
        drawn(&merged, &["merge", &folders[0], &folders[1]]);
        assert_eq!(read(&merged, "assembly-sweep.csv"), read(&out, "assembly-sweep.csv"));
    }
}

#[test]
fn invariant_a_diagram_in_shards_is_the_diagram() {
    let arguments = [
        "assembly",
        "bifurcation",
        DAMPER,
        "--vary",
        "stop.steel.gap=4mm:5mm:3",
        "--of",
        "block.s",
        "--discard",
        "20",
        "--keep",
        "6",
    ];
    let (out, parts) = (folder("assembly-diagram"), folder("assembly-diagram-shards"));
    let said = drawn(&out, &arguments);
    assert!(said.contains("local maxima of block.s over stop.steel.gap, both directions"), "{said}");
    assert!(said.contains("stop.steel.gap 4 mm"), "{said}");
    let [one, two] = ["one", "two"].map(|name| parts.join(name));
    drawn(&one, &[&arguments[..], &["--shard", "1/2"]].concat());
    drawn(&two, &[&arguments[..], &["--shard", "2/2"]].concat());
    let merged = parts.join("merged");
    drawn(&merged, &["merge", &one.display().to_string(), &two.display().to_string()]);
    for name in ["", "-points", "-windows"] {
        let file = format!("assembly-bifurcation{name}.csv");
        assert_eq!(read(&merged, &file), read(&out, &file), "{file}");
    }
    assert_eq!(read(&merged, "assembly-bifurcation.svg"), read(&out, "assembly-bifurcation.svg"));
    // Another machine's parts and results are told apart.
    let other = [&arguments[..], &["--set", "body.box.mass=13kg"]].concat();
    let found = command(&out, &other).output().unwrap();
    let error = String::from_utf8_lossy(&found.stderr).into_owned();
    assert!(found.status.code() == Some(2) && error.contains("body.box.mass: 12 there, 13 here"), "{error}");
}

#[test]
fn closed_form_exponent_of_an_oscillator() {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("assembly-exponent.toml");
    let text = "name = \"O\"\n[body.a]\nmass = 2.0\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 800.0\ndamping = 8.0\n\
        [load.f]\non = \"a\"\namplitude = 10.0\nfrequency = \"5 Hz\"\n";
    std::fs::write(&path, text).unwrap();
    let out = folder("assembly-exponent");
    drawn(&out, &["assembly", "lyapunov", &path.display().to_string(), "--periods", "160"]);
    let row = &table(&out, "assembly-lyapunov.csv")[0];
    // δ'' + 4 δ' + 400 δ = 0 shrinks with e^-2t; its length swings by some percent of one e-fold in 25 s.
    let exponent: f64 = row["exponent"].parse().unwrap();
    assert!((exponent + 2.0).abs() < 4e-3 && row["class"] == "1T", "{row:?}");
}

#[test]
fn bad_ranges_names_and_sections_are_refused_before_work() {
    let sweep = |rest: &[&str]| refused(&[&["assembly", "sweep", DAMPER][..], rest].concat());
    let diagram = |rest: &[&str]| refused(&[&["assembly", "bifurcation", DAMPER][..], rest].concat());
    for ((code, error), words) in [
        (diagram(&["--vary", "stop.stel.gap=1mm:2mm"]), "the nearest is `stop.steel.gap`"),
        (diagram(&["--vary", "stop.steel.gap=2mm:1mm"]), "from < to"),
        (diagram(&["--vary", "stop.steel.gap=1:2mm"]), "a unit at every number"),
        (diagram(&["--vary", "stop.steel.gap=1mm:2mm:1"]), "allowed are 2 to 20000"),
        (diagram(&["--vary", "stop.steel.gap=1mm:2mm", "--of", "blok.s"]), "the nearest is `block.s`"),
        (
            diagram(&["--vary", "stop.steel.gap=1mm:2mm", "--section", "stop.x"]),
            "no stop or friction has this name",
        ),
        (diagram(&["--vary", "stop.steel.restitution=0.5:1.5"]), "allowed is a number from 0 to 1"),
        (sweep(&["--vary", "stop.steel.gap=1mm:2mm:3", "--samples", "4"]), "without a count"),
        (sweep(&["--output", "amplitude.bx.s"]), "the nearest is `box.s`"),
        (sweep(&["--output", "loudness"]), "amplitude.Q"),
        (sweep(&["--vary", "stop.steel.gap=1mm,2mm", "--vary", "stop.steel.gap=1mm,2mm"]), "each once"),
    ] {
        assert!(code == 2 && error.contains(words), "{words}: {error}");
    }
    let said = drawn(&folder("assembly-list"), &["assembly", "sweep", DAMPER, "--list"]);
    assert!(said.contains("impact.speed.steel") && said.contains("power.guide"), "{said}");
}
