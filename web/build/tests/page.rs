//! The live page: its results against the native library, its modules' types, and the page in
//! Chromium. Run on request, since the tests need the target wasm32-unknown-unknown, node with
//! npm, and Chromium; a message names what is missing.

mod common;

use common::{node, workspace};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use vibro_impact::Simulator;
use vibro_studies::paper::{Name, ParameterSet};

/// Largest difference without magnification: about ten last digits in twenty periods. Sine and
/// cosine differ in the last digit between C libraries, and WebAssembly has no fused multiply-add.
const TOLERANCE: f64 = 1e-12;
/// Chaos amplifies rounding, by orders of magnitude at a slow impact. The amplification is
/// measured on the native motion, whose last digits change when its advances are split. Both kinds
/// of differences agree within this factor.
const ALIKE: f64 = 30.0;
/// Number of pieces of a drive period, as in the page's histories.
const PIECES: u32 = 120;
const PERIODS: u32 = 20;

/// The build folder with the page in it; built once.
fn built() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| common::built("--quick"))
}

#[test]
#[ignore = "needs the target wasm32-unknown-unknown and node"]
fn second_method_the_native_library_over_twenty_periods() {
    // One and three impacts a period, chaos, chatter with rest, plastic impacts, strong coupling,
    // a machine in SI.
    let cases = [
        "f10=1.5",
        "f10=3.6",
        "f10=3.9",
        "kappa=0.3;f10=3.4",
        "kappa=0;f10=3",
        "beta2=0.3;mu13=1;sigma30=0.5",
        "box.m=12;box.k=48000;box.c=60;block.m=1.1;stop.gap=0.002;drive.amplitude=14;drive.frequency=63.5",
    ];
    let folder = built();
    let script = workspace().join("web/explorer/page/test/core.mjs");
    let (done, printed) = node(&[&script, &folder.join("core")], &(cases.join("\n") + "\n"));
    assert!(done, "{printed}");
    let lines: Vec<&str> = printed.lines().collect();
    assert_eq!(lines.len(), cases.len());
    for (case, line) in cases.iter().zip(lines) {
        let numbers: Vec<f64> = line.split(' ').map(|word| word.parse().unwrap()).collect();
        let mut set = ParameterSet::basic();
        for part in case.split(';').filter(|part| !part.is_empty()) {
            let (name, value) = part.split_once('=').unwrap();
            set.assign(&[(Name::find(name).unwrap(), value.parse().unwrap())]).unwrap();
        }
        let p = *set.parameters();
        let start = vibro_impact::State { x: [0.0; 3], v: [0.0, 1.0, 0.0] };
        let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
        let speed = p.stop_gap * p.drive_frequency;
        let (mut split, mut growth) = (simulator.clone(), 0.0f64);
        for (i, row) in (1..=PERIODS).zip(numbers.chunks(7)) {
            simulator.advance_to(f64::from(i) * p.period()).unwrap();
            for k in 1..=PIECES {
                let periods = f64::from(i - 1) + f64::from(k) / f64::from(PIECES);
                split.advance_to(periods * p.period()).unwrap();
            }
            let (state, other) = (simulator.state(), split.state());
            for b in 0..3 {
                growth = growth.max((state.x[b] - other.x[b]).abs() / p.stop_gap);
                growth = growth.max((state.v[b] - other.v[b]).abs() / speed);
            }
            let allowed = TOLERANCE.max(ALIKE * growth);
            // The tolerance still distinguishes chaotic motions.
            assert!(allowed < 1e-6, "{case}: {allowed}");
            assert!(
                (row[0] - simulator.time()).abs() <= 4.0 * f64::EPSILON * row[0],
                "{case}: time {}",
                row[0]
            );
            for b in 0..3 {
                let (x, v) = ((row[1 + b] - state.x[b]) / p.stop_gap, (row[4 + b] - state.v[b]) / speed);
                assert!(
                    x.abs() < allowed && v.abs() < allowed,
                    "{case}, period {i}, body {b}: {x:e} {v:e}, allowed {allowed:e}"
                );
            }
        }
        let impacts = (simulator.impacts().upper + simulator.impacts().lower) as f64;
        // A chatter run is closed at round-off, so the number of its last bounces differs.
        let counted = numbers[numbers.len() - 1];
        assert!(
            (counted - impacts).abs() <= if case.contains("kappa") { 0.02 * impacts } else { 0.0 },
            "{case}"
        );
    }
}

#[test]
#[ignore = "needs node"]
fn the_modules_keep_to_their_types() {
    let compiler = built().join("npm/node_modules/typescript/bin/tsc");
    let project = workspace().join("web/explorer/page/tsconfig.json");
    let (done, printed) = node(&[&compiler, Path::new("-p"), &project], "");
    assert!(done, "{printed}");
}

/// Largest page, bytes: a hundredth above the page's 658,140 when this limit was set.
const LARGEST: u64 = 665_000;

#[test]
#[ignore = "needs node and Chromium (Debian: apt install nodejs npm chromium)"]
fn chromium_opens_plays_and_links_the_page() {
    let folder = built();
    let page = folder.join("explorer.html");
    assert!(std::fs::metadata(&page).unwrap().len() <= LARGEST);
    let shown = folder.join("shown");
    let script = workspace().join("web/explorer/page/test/page.mjs");
    let (done, printed) = node(&[&script, &folder.join("npm"), &page, &shown], "");
    println!("{printed}");
    assert!(done, "{printed}");
    // `vibro` reads the file that the page writes for it.
    let mut set = ParameterSet::basic();
    vibro::parameter_file::apply(&mut set, &std::fs::read_to_string(shown.join("machine.toml")).unwrap())
        .unwrap();
    assert!((set.groups().f10 - 2.2).abs() < 1e-14);
    assert_eq!(set.parameters().stop_restitution, 0.75);
}
