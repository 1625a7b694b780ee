//! Long studies: the sweep compared with the exact orbit and known windows of the default set,
//! figures compared with their tables, and the real `vibro` interrupted, resumed, sharded, merged,
//! on any number of threads.

#[path = "common/mod.rs"]
mod command;

use command::{DAMPER, begun, command, drawn, files, killed, parts, pixels};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use vibro::studies;
use vibro_figures::chart::Shape;
use vibro_impact::steady::exact_orbit;
use vibro_impact::{Simulator, State};
use vibro_studies::basin::{BasinCell, BasinRequest, StartAxis, basins};
use vibro_studies::diagram::diagram;
use vibro_studies::paper::attractor::observe;
use vibro_studies::paper::basin::{InitialValueRange, in_the_middle};
use vibro_studies::paper::bifurcation::{Diagram, Sweep, SweepPoint};
use vibro_studies::paper::maxima::Displacement;
use vibro_studies::paper::plane::ParameterAxis;
use vibro_studies::paper::{ParameterSet, find_group, lyapunov};
use vibro_studies::parts::Task;
use vibro_studies::{MotionClass, Relation};

/// Transient at values away from bifurcations, in units of L; maxima are kept to 1e-6.
const SETTLED: f64 = 2e-6;

fn sweep(range: (f64, f64), count: usize, exponents: Option<lyapunov::SpectrumOptions>) -> (Sweep, Diagram) {
    let axis = ParameterAxis::new(find_group("f10").unwrap(), range, count).unwrap();
    let sweep = Sweep { exponents, ..Sweep::new(axis, Displacement::X2, (300, 60)) };
    let all = diagram(&ParameterSet::basic(), &sweep, &Task::ALL).unwrap();
    (sweep, all.unwrap())
}

fn near(points: &[Option<SweepPoint>], value: f64) -> &SweepPoint {
    let distance = |p: &&SweepPoint| (p.value - value).abs();
    points.iter().flatten().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap()
}

#[test]
fn golden_windows_of_the_default_set() {
    let options = lyapunov::SpectrumOptions { periods: 300, ..lyapunov::SpectrumOptions::default() };
    let (_, found) = sweep((0.6, 4.8), 85, Some(options)); // every 0.05
    let class = |value: f64| near(&found.up, value).class;
    // Windows with rising f10, away from their ends, as found by an independent prototype.
    for value in [0.6, 0.7, 0.8, 3.55, 3.7, 4.1, 4.8] {
        assert_eq!(class(value), MotionClass::Chaotic, "{value}");
    }
    for (values, period, impacts) in [
        (vec![1.0, 1.3, 1.6, 1.9, 2.2], 1, 2.0),
        (vec![2.45], 2, 2.0),
        (vec![2.65, 2.7], 1, 3.0),
        (vec![3.0, 3.1, 3.25], 2, 3.0),
        (vec![3.9, 3.95], 1, 3.0),
    ] {
        for value in values {
            let p = near(&found.up, value);
            assert_eq!(p.class, MotionClass::Periodic(period), "{value}");
            assert_eq!(p.attractor.impacts[0] + p.attractor.impacts[1], impacts, "{value}");
            let s = p.spectrum.as_ref().unwrap();
            assert!(s.exponents[0].abs() < 1e-3 && s.exponents[1] < -1e-3, "{value}: {s:?}");
        }
    }
    for p in found.up.iter().flatten() {
        let s = p.spectrum.as_ref().unwrap();
        assert!(s.exponents[2] < 0.0, "the third is always negative: {}", p.value);
    }
}

#[test]
fn second_method_maxima_are_the_exact_orbits_amplitude() {
    let (sweep, found) = sweep((1.0, 2.0), 11, None);
    for p in found.up.iter().chain(&found.down).flatten() {
        let set = ParameterSet::basic().with(sweep.axis.name, p.value).unwrap();
        let orbit = exact_orbit::solve(set.parameters()).unwrap().upper.unwrap();
        assert!(orbit.is_stable());
        let expected = orbit.amplitudes()[1];
        assert!(p.maxima.iter().all(|m| (m.0 - expected).abs() < SETTLED), "{}: {:?}", p.value, p.maxima);
        assert_eq!(p.maxima.iter().map(|m| m.1).sum::<u32>(), sweep.keep, "one maximum a period");
        assert!(p.attractor.is_symmetric(), "{}", p.value);
    }
}

#[test]
fn second_method_hysteresis_and_mirror_images() {
    let (_, found) = sweep((2.0, 2.8), 41, None); // every 0.02
    let apart = found.hysteresis();
    let at =
        |value: f64| found.up.iter().position(|p| (p.as_ref().unwrap().value - value).abs() < 1e-9).unwrap();
    for value in [2.2, 2.3, 2.7] {
        assert!(!apart[at(value)], "{value}");
    }
    // Two impacts per period on the way up, three on the way down.
    let i = at(2.5);
    let (up, down) = (found.up[i].as_ref().unwrap(), found.down[i].as_ref().unwrap());
    assert!(apart[i]);
    assert_eq!((up.attractor.impacts, down.attractor.impacts.iter().sum::<f64>()), ([1.0, 1.0], 3.0));
    // Beyond the symmetry breaking the motion differs from its mirror image, and a start from the
    // image stays there.
    let p = found.up[at(2.2)].as_ref().unwrap();
    assert!(!p.attractor.is_symmetric());
    let set = ParameterSet::basic().with(find_group("f10").unwrap(), 2.2).unwrap();
    let image = p.attractor.mirror_states[0];
    let mut state = State { x: [image[0], image[1], image[2]], v: [image[3], image[4], image[5]] };
    state.x[1] = state.x[0] + (state.x[1] - state.x[0]).clamp(-1.0, 1.0);
    let mut other = Simulator::new(set.parameters(), &state, 0.0).unwrap();
    let other = observe(&mut other).unwrap();
    assert_eq!(p.attractor.relation(&other), Relation::Mirror);
    assert_eq!(other.relation(&p.attractor), Relation::Mirror);
    assert_eq!(other.relation(&other), Relation::Same);
}

#[test]
fn figures_show_what_their_tables_hold() {
    let (sweep, found) = sweep((2.3, 3.6), 27, None);
    let study = studies::diagram(&ParameterSet::basic(), &sweep, &found, "sweep").unwrap();
    let figure = study.figure.as_ref().unwrap();
    let shape = figure.panels[0].layers.iter().find(|l| matches!(l.shape, Shape::Cells { .. })).unwrap();
    let Shape::Cells { x, y, columns, cells, .. } = &shape.shape else { unreachable!() };
    let rows = cells.len() / columns;
    let mut filled: Vec<bool> = cells.iter().map(|c| *c > 0).collect();
    assert!(filled.iter().any(|f| *f));
    let apart: HashMap<String, bool> = {
        let mut reader = csv::Reader::from_reader(study.tables[1].1.as_slice());
        let rows = reader.deserialize::<HashMap<String, String>>().map(|r| r.unwrap());
        rows.map(|r| (r["f10"].clone(), r["hysteresis"] == "true")).collect()
    };
    let mut seen = vec![false; filled.len()];
    for row in csv::Reader::from_reader(study.tables[0].1.as_slice()).deserialize::<HashMap<String, String>>()
    {
        let row = row.unwrap();
        if row["direction"] == "falling" && !apart[&row["f10"]] {
            continue;
        }
        let number = |name: &str| row[name].parse::<f64>().unwrap();
        let column = ((number("f10") - x.0) / (x.1 - x.0) * *columns as f64) as usize;
        let line = ((number("X2_maximum") - y.0) / (y.1 - y.0) * rows as f64) as usize;
        assert!(filled[line * columns + column], "{row:?}");
        seen[line * columns + column] = true;
    }
    filled.iter_mut().zip(&seen).for_each(|(f, s)| *f &= !s);
    assert!(!filled.iter().any(|f| *f), "a cell that no row of the table accounts for");
}

fn initial(range: &str, cells: usize) -> StartAxis {
    range.parse::<InitialValueRange>().unwrap().cells(cells)
}

#[test]
fn second_method_cells_of_a_basin_by_direct_simulation() {
    let set = ParameterSet::basic().with(find_group("f10").unwrap(), 2.48).unwrap();
    let p = set.parameters();
    let (x, y) = (initial("x1=-1:1", 6), initial("v2=-2:2", 5));
    let request = BasinRequest { x: x.clone(), y: y.clone(), discard: 300, start: in_the_middle() };
    let found = basins(&set, &request, &Task::ALL).unwrap().unwrap();
    assert_eq!(found.cells.len(), 30);
    let both = found.shares(0);
    assert!(both[0] > 0.0 && both[1] > 0.0, "a pair of mirror images: {both:?}");
    let total: f64 = (0..found.attractors.len() as u16).flat_map(|n| found.shares(n)).sum();
    assert!((total - 1.0).abs() < 1e-12);
    for (i, destination) in found.cells.iter().enumerate().step_by(7) {
        let state = State { x: [x.value(i % 6), 0.0, 0.0], v: [0.0, y.value(i / 6), 0.0] };
        // One simulator in one run; the basin uses two.
        let mut simulator = Simulator::new(p, &state, 0.0).unwrap();
        simulator.advance_to(300.0 * p.period()).unwrap();
        let ends = observe(&mut simulator).unwrap();
        let (number, relation) = match destination {
            BasinCell::Attractor(n) => (*n, Relation::Same),
            BasinCell::Mirror(n) => (*n, Relation::Mirror),
            other => panic!("cell {i}: {other:?}"),
        };
        assert_eq!(found.attractors[usize::from(number)].attractor.relation(&ends), relation, "cell {i}");
    }
    let outside = BasinRequest { x: initial("x2=-3:3", 6), ..request };
    let found = basins(&set, &outside, &Task::ALL).unwrap().unwrap();
    assert_eq!(found.cells.iter().filter(|g| **g == BasinCell::Outside).count(), 20);
}

fn folder(name: &str) -> PathBuf {
    command::folder(&format!("studies-{name}"))
}

fn assert_same(one: &Path, two: &Path) {
    let (a, b) = (files(one), files(two));
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    for (x, y) in a.iter().zip(&b) {
        assert!(x.1 == y.1, "{} differs", x.0);
    }
}

/// Not blank: ink in at least some percent of the picture.
fn check_picture(path: &Path) {
    let (_, _, pixels) = pixels(path);
    let inked = pixels.chunks(3).filter(|p| *p != [255, 255, 255]).count();
    assert!(inked * 100 > pixels.len() / 3, "{}: {inked} of {}", path.display(), pixels.len() / 3);
}

const SWEEP: [&str; 9] =
    ["bifurcation", "--range", "f10=2.3:2.9", "--resolution", "61", "--discard", "100", "--keep", "100"];
const EXPONENTS: [&str; 13] = [
    "lyapunov",
    "--range",
    "f10=2.3:2.9",
    "--resolution",
    "61",
    "--discard",
    "100",
    "--keep",
    "100",
    "--periods",
    "400",
    "--at",
    "1.5,2.88",
];
const ISOPERIODIC: [&str; 9] =
    ["isoperiodic", "--pair", "kappa,f10", "--pair", "sigma1,f10", "--resolution", "12", "--periods", "100"];
const ORBITS: [&str; 10] = [
    "bifurcation",
    "--orbits",
    "--range",
    "f10=2.3:2.45",
    "--resolution",
    "16",
    "--discard",
    "200",
    "--keep",
    "50",
];
// Studies of a machine's file.
const ASSEMBLY_EXPONENTS: [&str; 12] = [
    "lyapunov",
    DAMPER,
    "--vary",
    "stop.steel.gap=4mm:6mm:17",
    "--of",
    "block.s",
    "--discard",
    "20",
    "--keep",
    "6",
    "--periods",
    "16",
];
// Few rows are measured again, because shards do not affect how long that takes.
const ASSEMBLY_SWEEP: [&str; 14] = [
    "sweep",
    DAMPER,
    "--vary",
    "stop.steel.gap=4mm:6mm:20",
    "--vary",
    "body.block.mass=0.2kg:0.5kg:15",
    "--output",
    "amplitude.box.s,impacts.steel",
    "--discard",
    "3",
    "--periods",
    "2",
    "--again",
    "200",
];
// Three parts of at most 32 motions.
const ASSEMBLY_PLANE: [&str; 10] = [
    "bifurcation",
    DAMPER,
    "--vary",
    "stop.steel.gap=4mm:6mm:8",
    "--vary",
    "stop.buffer.gap=5mm:8mm:9",
    "--pair",
    "stop.steel.gap,stop.buffer.gap",
    "--discard",
    "60",
];
const BASIN: [&str; 7] = ["basin", "--set", "f10=2.48", "--resolution", "24", "--discard", "150"];

#[test]
fn second_method_shards_threads_and_an_interruption_give_the_same_bytes() {
    // The last element names the parts, for studies that are interrupted too.
    for (name, work, parts) in [
        ("sweep", &SWEEP[..], None),
        ("orbits", &ORBITS, None),
        ("exponents", &EXPONENTS, Some("lyapunov")),
        ("basin", &BASIN, None),
        ("isoperiodic", &ISOPERIODIC, None),
        ("assembly-exponents", &ASSEMBLY_EXPONENTS, Some("lyapunov")),
        ("assembly-sweep", &ASSEMBLY_SWEEP, Some("sweep")),
        ("assembly-plane", &ASSEMBLY_PLANE, Some("bifurcation-stop.steel.gap-stop.buffer.gap")),
    ] {
        let whole = folder(&format!("{name}-whole"));
        drawn(&whole, &[work, &["--threads", "1"]].concat());
        for name in files(&whole).keys().filter(|name| name.ends_with(".png")) {
            check_picture(&whole.join(name));
        }
        let shards: Vec<PathBuf> = (1..=3)
            .map(|i| {
                let out = folder(&format!("{name}-shard-{i}"));
                let share = format!("{i}/3");
                let text = drawn(&out, &[work, &["--shard", &share, "--threads", "3"]].concat());
                assert!(text.contains("parts of") && text.contains("vibro merge"), "{text}");
                out
            })
            .collect();
        let merged = folder(&format!("{name}-merged"));
        let paths: Vec<&str> = shards.iter().map(|s| s.to_str().unwrap()).collect();
        let lacking = command(&merged, &["merge", paths[0], paths[2]]).output().unwrap();
        let error = String::from_utf8_lossy(&lacking.stderr).into_owned();
        assert!(lacking.status.code() == Some(2) && error.contains("parts are missing"), "{error}");
        drawn(&merged, &[&["merge"], &paths[..]].concat());
        assert_same(&whole, &merged);
        if let Some(parts) = parts {
            interrupted_and_resumed(parts, work, &whole);
        }
    }
}

/// A study that is killed after its first part continues: no finished part is lost.
fn interrupted_and_resumed(name: &str, work: &[&str], whole: &Path) {
    let broken = folder(&format!("{name}-broken"));
    killed(begun(&broken, &[work, &["--threads", "1"]].concat(), name, 1));
    let finished = || parts(&broken, name);
    let kept = finished();
    assert!(!kept.is_empty() && kept.len() < 16, "{name}: {} parts", kept.len());
    // Another machine's parts are neither used nor deleted.
    let change = if work.contains(&DAMPER) { "body.box.mass=13kg" } else { "kappa=0.7" };
    let other = command(&broken, &[work, &["--set", change]].concat()).output().unwrap();
    let error = String::from_utf8_lossy(&other.stderr).into_owned();
    assert!(other.status.code() == Some(2) && error.contains("--discard-unfinished"), "{name}: {error}");
    assert_eq!(finished(), kept, "{name}");
    drawn(&broken, work);
    assert_same(whole, &broken);
}

#[test]
#[ignore = "makes the report twice: cargo test -p vibro --test studies -- --ignored"]
fn invariant_the_report_is_the_same_on_any_threads() {
    let [one, two] = ["1", "2"].map(|threads| {
        let out = folder(&format!("report-{threads}"));
        drawn(&out, &["reproduce", "--quick", "--threads", threads]);
        out
    });
    assert_same(&one, &two);
}

#[test]
fn the_report_is_whole() {
    let one = folder("report");
    let text = drawn(&one, &["reproduce", "--quick"]);
    assert!(text.contains("statements of the paper") && text.contains("[agrees]"), "{text}");
    // The branches cover the diagram's rows and bound its windows with more digits than the grid.
    assert!(
        text.contains("periodic rows of both directions whose transient has ended lie on a stable branch"),
        "{text}"
    );
    assert!(text.contains("0.95–2.85 (NS 0.9146596632 – PD 2.8022054392)"), "{text}");
    assert!(text.contains("PD of 1T at 2.3730753708, PD of 2T at 2.4930216604"), "{text}");
    let html = std::fs::read_to_string(one.join("report.html")).unwrap();
    assert!(
        html.contains("a reconstruction, not the paper&#39;s own data")
            || html.contains("a reconstruction, not the paper's own data")
    );
    // Self-contained: pictures are embedded, nothing is loaded.
    let pictures = html.matches("src=\"data:image/png;base64,").count();
    let drawn_files: Vec<_> = files(&one).into_iter().filter(|f| f.0.ends_with(".png")).collect();
    assert_eq!((pictures, html.matches("<img").count()), (drawn_files.len(), drawn_files.len()));
    assert!(!html.contains("src=\"http") && !html.contains("<script") && !html.contains("<link"));
    for name in [
        "figure-13",
        "figure-14",
        "figure-14-fine",
        "figure-14-orbits",
        "figure-15",
        "figure-16",
        "table-2",
        "basin",
    ] {
        assert!(html.contains(&format!("id=\"{name}\"")), "{name}");
        assert!(one.join(format!("{name}.csv")).exists(), "{name}");
    }
    for file in drawn_files {
        check_picture(&one.join(file.0));
    }
    // Each result has a manifest, and the names checked before the work equal the written names.
    let ending = ".manifest.toml";
    let mut written: Vec<_> =
        files(&one).iter().filter_map(|f| Some(f.0.strip_suffix(ending)?.to_owned())).collect();
    let plan = vibro::report::Plan::new(&ParameterSet::basic(), true).unwrap();
    let mut planned: Vec<_> = plan.results().unwrap().iter().map(|r| r.0.to_owned()).collect();
    planned.sort();
    written.sort();
    assert_eq!(written, planned);
    let mut contents: Vec<_> = files(&one).into_iter().map(|f| f.1).collect();
    contents.sort();
    assert!(contents.windows(2).all(|w| w[0] != w[1]), "the same file under two names");
    assert!(!one.join("reproduce.parts").exists());
}
