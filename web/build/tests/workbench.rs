//! The workbench: its results equal the native library's, and the page works in Chromium.

mod common;

use common::{node, workspace};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use vibro_machine::motion::{Event, EventKind, Reached};
use vibro_machine::{Assembly, Motion, file};
use vibro_studies::{columns, named, values};

/// Largest difference relative to a column's largest value, without magnification. Sine and cosine
/// differ in the last digit between C libraries, and WebAssembly has no fused multiply-add.
const TOLERANCE: f64 = 1e-13;
/// Unit roundoffs of a displacement in the force of a contact and in the acceleration of a mode,
/// which have the displacement times a stiffness or a squared frequency: one of the displacement
/// itself and one of each factor.
const ROUNDOFFS: f64 = 4.0;
/// Relative change of the initial state for measuring the magnification.
const SHIFT: f64 = 1e-14;
/// Largest magnification for a comparison of motions.
const MOST: f64 = 1e9;
/// Number of instants of the default experiment.
const ROWS: usize = 60;
/// Smallest fraction of all instants of the gallery with a comparison; the rest exceed [`MOST`].
const COMPARED: f64 = 0.5;

/// The build folder with the page in it; built once.
fn built() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| common::built("workbench"))
}

/// Advances a native motion as the page does: to an event, over it, and further.
fn advance(motion: &mut Motion, end: f64, events: &mut Vec<Event>) {
    while motion.advance_before_event(end, &mut |e| events.push(e.clone())).unwrap() == Reached::Event {
        motion.apply_event(&mut |e| events.push(e.clone())).unwrap();
    }
}

/// Number of compared instants of a machine's motion.
fn compared(told: &serde_json::Value) -> usize {
    let name = told["file"].as_str().unwrap();
    let machine = file::read(&workspace().join("examples/assembly").join(name)).unwrap();
    let assembly = Arc::new(Assembly::new(machine.clone()).unwrap());
    let mut events = Vec::new();
    let mut motion = Motion::new_observed(assembly.clone(), &mut |e| events.push(e.clone())).unwrap();
    let own: Vec<_> = (0..machine.bodies.len()).map(|i| (motion.coordinate(i), motion.rate(i))).collect();
    // If bodies touch and move together, only the size of their motion changes. A body at rest at
    // zero gets a velocity of 1e-14 mm/s.
    let least = |s: f64, v: f64| if s == 0.0 && v == 0.0 { SHIFT * 1e-3 } else { 0.0 };
    let starts = own.iter().map(|(s, v)| (s * (1.0 + SHIFT), v * (1.0 - SHIFT) + least(*s, *v)));
    let beside = Assembly::new(machine.clone()).unwrap().starting_from(starts.collect());
    let mut other = Motion::new(Arc::new(beside)).unwrap();
    let stop = told["stop"].as_f64().unwrap();
    let names = columns(&machine);
    let kind = |i: usize| names[i].rsplit('.').next().unwrap_or_default();
    let highest = machine.modals.iter().flat_map(|of| &of.frequencies).copied().fold(0.0, f64::max);
    let system = assembly.system();
    let stiffnesses = system.stops.iter().map(|own| own.stiffness());
    let stiffest = stiffnesses.chain(system.branches.iter().map(|own| own.stiffness)).fold(0.0, f64::max);
    // By the last word of a column's name.
    let by_displacement = |kind: &str| match kind {
        "a" => (std::f64::consts::TAU * highest).powi(2),
        "f" | "ft" if highest > 0.0 => stiffest,
        _ => 0.0,
    };
    // Grouped by the last word of a column's name: a force of zero is compared with other forces.
    let mut largest: HashMap<&str, f64> = HashMap::new();
    let mut growth = 1.0f64;
    for (i, row) in told["rows"].as_array().unwrap().iter().enumerate() {
        let end = stop * (i + 1) as f64 / ROWS as f64;
        advance(&mut motion, end, &mut events);
        advance(&mut other, end, &mut Vec::new());
        let (own, others) = (values(&motion), values(&other));
        for (i, x) in own.iter().enumerate() {
            let most = largest.entry(kind(i)).or_insert(f64::MIN_POSITIVE);
            *most = most.max(x.abs());
        }
        for (i, (a, b)) in own.iter().zip(&others).enumerate() {
            growth = growth.max((a - b).abs() / (SHIFT * largest[kind(i)]));
        }
        if growth > MOST {
            return i;
        }
        for (k, (x, own)) in row.as_array().unwrap().iter().zip(&own).enumerate() {
            let place = largest.get("s").copied().unwrap_or_default();
            let rounded = ROUNDOFFS * f64::EPSILON * by_displacement(kind(k)) * place;
            let (x, allowed) = (x.as_f64().unwrap(), TOLERANCE * growth * largest[kind(k)] + rounded);
            let what = &names[k];
            assert!((x - own).abs() <= allowed, "{name}, {what} at {end} s: {x} {own}, allowed {allowed:e}");
        }
        let met = events.iter().filter(|event| event.is_listed() && event.kind != EventKind::Knot);
        for (event, told) in met.zip(told["events"].as_array().unwrap()) {
            let own = named(&assembly, &event.kind);
            let off = (told[0].as_f64().unwrap() - event.time).abs();
            assert_eq!((told[1].as_str(), told[2].as_str()), (Some(own.kind), Some(&*own.element)), "{name}");
            assert!(off <= TOLERANCE * growth * stop, "{name}: {} off by {off:e}", event.time);
        }
    }
    ROWS
}

#[test]
#[ignore = "needs the target wasm32-unknown-unknown and node"]
fn second_method_every_machine_of_the_gallery_moves_as_natively() {
    let script = workspace().join("web/workbench/page/test/core.mjs");
    let (done, printed) = node(&[&script, &built().join("core"), Path::new(&ROWS.to_string())], "");
    assert!(done, "{printed}");
    let mut all = 0;
    let lines: Vec<serde_json::Value> =
        printed.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    for told in &lines {
        let compared = compared(told);
        println!("{}: {compared} of {ROWS} instants", told["file"]);
        all += compared;
    }
    let toml = |entry: std::io::Result<std::fs::DirEntry>| {
        entry.unwrap().path().extension().is_some_and(|ending| ending == "toml")
    };
    let gallery = std::fs::read_dir(workspace().join("examples/assembly")).unwrap();
    assert_eq!(lines.len(), gallery.map(toml).filter(|is| *is).count());
    assert!(all as f64 >= COMPARED * (lines.len() * ROWS) as f64, "{all}");
}

#[test]
#[ignore = "needs node"]
fn the_modules_keep_to_their_types() {
    let compiler = built().with_file_name("explorer").join("npm/node_modules/typescript/bin/tsc");
    let project = workspace().join("web/workbench/page/tsconfig.json");
    let (done, printed) = node(&[&compiler, Path::new("-p"), &project], "");
    assert!(done, "{printed}");
}

/// Largest page without libraries, bytes. The goal of 1.1 MB is missed since the core has curved
/// forces, contacts with friction, and residual flexibility with its derivatives: 1,276,962 bytes in
/// November 2026, 1,291,674 with pictures that grow over several frames, and 1,293,710 with fits
/// that test segments. The rest is room for small changes.
const LARGEST: u64 = 1_300_000;

#[test]
#[ignore = "needs node and Chromium (Debian: apt install nodejs npm chromium)"]
fn chromium_opens_edits_shares_and_stops_the_workbench() {
    let folder = built();
    let page = folder.join("workbench.html");
    assert!(std::fs::metadata(&page).unwrap().len() <= LARGEST);
    let script = workspace().join("web/workbench/page/test/page.mjs");
    let npm = folder.with_file_name("explorer").join("npm");
    let (done, printed) = node(&[&script, &npm, &page, &folder.join("shown")], "");
    println!("{printed}");
    assert!(done, "{printed}");
}
