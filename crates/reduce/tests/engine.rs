//! A reduced body in the engine against the same body as single masses, and the written files.

mod common;

use common::Solid;
use std::fmt::Write;
use std::path::Path;
use vibro_machine::file::{no_records, parse};
use vibro_machine::{Assembly, Motion};
use vibro_reduce::damping::Damping;
use vibro_reduce::import::files::Sources;
use vibro_reduce::job::{Job, Made};
use vibro_reduce::reduction::Method;
use vibro_reduce::statement::Given;

/// Motions through impacts of a body by its modes and by its masses: both round by their rates.
const SAME: f64 = 1e-9;
const MASSES: usize = 30;

/// Writes lower triangles as CalculiX does, with names of dofs.
fn calculix(folder: &Path, k: &common::Triplets, m: &common::Triplets, dofs: &[String]) -> Sources {
    let lines = |list: &common::Triplets| {
        list.iter().map(|(i, j, x)| format!("{} {} {x:.17e}\n", i + 1, j + 1)).collect::<String>()
    };
    let write = |name: &str, text: String| {
        let path = folder.join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let files = vec![
        write("b.sti", lines(k)),
        write("b.mas", lines(m)),
        write("b.dof", dofs.iter().map(|dof| format!("{dof}\n")).collect()),
    ];
    Sources { files, ..Sources::default() }
}

fn job(sources: Sources, interfaces: &[&str], method: Method, modes: usize) -> Job {
    Job {
        sources,
        units: "N,mm,t,s".into(),
        clamp: vec![],
        interfaces: interfaces.iter().map(|text| (*text).into()).collect(),
        method,
        modes,
        damping: Damping::Ratio(0.0),
        gravity: None,
        given: Given::default(),
        name: "rod".into(),
    }
}

/// A chain to ground of 0.2 kg and 1e5 N/m, in N, mm, t.
fn chain(folder: &Path) -> Sources {
    let k = |i: usize| if i + 1 == MASSES { 100.0 } else { 200.0 };
    let mut stiffness: common::Triplets = (0..MASSES).map(|i| (i, i, k(i))).collect();
    stiffness.extend((1..MASSES).map(|i| (i, i - 1, -100.0)));
    let mass = (0..MASSES).map(|i| (i, i, 2e-4)).collect();
    let dofs: Vec<String> = (1..=MASSES).map(|i| format!("{i}.1")).collect();
    calculix(folder, &stiffness, &mass, &dofs)
}

fn motion(text: &str) -> Motion {
    let machine = parse(text, "rod.toml", &no_records).unwrap();
    Motion::new(std::sync::Arc::new(Assembly::new(machine).unwrap())).unwrap()
}

fn place(motion: &Motion, name: &str) -> usize {
    motion.assembly().description.bodies.iter().position(|body| body.name == name).unwrap()
}

/// What acts: a drive and a compliant stop at the last mass, a spring in the middle.
fn elements(end: &str, middle: &str) -> String {
    format!(
        "[stop.end]\nbetween = [\"ground\", \"{end}\"]\ngap = \"0.2 mm\"\nstiffness = 2e6\ndamping = 100.0\n\
         [spring.support]\nbetween = [\"ground\", \"{middle}\"]\nstiffness = 2e4\ndamping = 30.0\n\
         [load.shaker]\non = \"{end}\"\namplitude = 40.0\nfrequency = 9.0\n"
    )
}

#[test]
fn second_method_a_body_with_all_its_modes_moves_as_its_masses() {
    let folder = tempfile::tempdir().unwrap();
    for method in [Method::MacNeal, Method::CraigBampton] {
        let modes = if method == Method::MacNeal { MASSES } else { MASSES - 2 };
        let job = job(chain(folder.path()), &["end=30", "middle=15.x"], method, modes);
        let made = job.run().unwrap();
        assert_eq!(made.reduced.values.len(), MASSES);
        let mut reduced = motion(&(made.toml + &elements("rod.end", "rod.middle")));
        let mut text = String::from("name = \"Rod\"\n");
        for i in 1..=MASSES {
            let before = if i == 1 { "ground".into() } else { format!("m{}", i - 1) };
            let _ = writeln!(
                text,
                "[body.m{i}]\nmass = 0.2\n[spring.k{i}]\nbetween = [\"{before}\", \"m{i}\"]\nstiffness = 1e5"
            );
        }
        let mut full = motion(&(text + &elements("m30", "m15")));
        let mut times = [Vec::new(), Vec::new()];
        for (own, times) in [&mut reduced, &mut full].into_iter().zip(&mut times) {
            own.advance_observed(0.25, &mut |event| times.push(event.time)).unwrap();
        }
        assert!(times[0].len() > 4, "{}", times[0].len());
        assert_eq!(times[0].len(), times[1].len());
        for (one, other) in times[0].iter().zip(&times[1]) {
            assert!((one - other).abs() < SAME, "{one} {other}");
        }
        for (own, other) in [("rod.end", "m30"), ("rod.middle", "m15")] {
            let (one, other) = (reduced.body(place(&reduced, own)), full.body(place(&full, other)));
            assert!(
                (one[0] - other[0]).abs() < SAME && (one[1] - other[1]).abs() < 100.0 * SAME,
                "{one:?} {other:?}"
            );
        }
    }
}

/// A file with α M + β K, in kN, mm, ms, names its dofs in the order of CalculiX and includes a clamped
/// one: the body is that of `--rayleigh`, with α and β in seconds.
#[test]
fn closed_form_a_file_of_proportional_damping_is_rayleigh() {
    let folder = tempfile::tempdir().unwrap();
    let (alpha, beta) = (0.3, 2e-7);
    let of = |damping: Damping, matrix: bool| {
        let mut own = job(chain(folder.path()), &["end=30"], Method::MacNeal, 8);
        (own.units, own.clamp, own.damping) = ("kN,mm,kg,ms".into(), vec!["7".into()], damping);
        if matrix {
            // α in 1/ms and β in ms.
            let (alpha, beta) = (1e-3 * alpha, 1e3 * beta);
            let k = |i: usize| if i + 1 == MASSES { 100.0 } else { 200.0 };
            let own_entries = (1..=MASSES).map(|i| (i, i, alpha * 2e-4 + beta * k(i - 1)));
            let others = (2..=MASSES).map(|i| (i, i - 1, -100.0 * beta));
            let lines: Vec<String> =
                own_entries.chain(others).map(|(i, j, x)| format!("{i} {j} {x:.17e}\n")).collect();
            let path = folder.path().join("c.sti");
            std::fs::write(&path, lines.concat()).unwrap();
            own.sources.damping = Some(path);
        }
        own.run().unwrap()
    };
    let [one, other] = [of(Damping::Rayleigh(alpha, beta), false), of(Damping::Ratio(0.0), true)];
    let ratios = |made: &Made| {
        let text = parse(&format!("{}\n", made.toml), "rod.toml", &no_records).unwrap();
        text.modals[0].damping_ratios.clone()
    };
    let (rayleigh, by_file) = (ratios(&one), ratios(&other));
    assert_eq!(by_file.len(), 8);
    for (a, b) in rayleigh.iter().zip(&by_file) {
        assert!(*a > 1e-3 && (a - b).abs() < SAME * a, "{a} {b}");
    }
    let said = other.said.last().unwrap();
    assert!(said.starts_with("damping ratios: 0.0") && other.report.contains(said.as_str()), "{said}");
}

/// A cantilever of steel in N, mm, t, clamped by the option.
fn cantilever(folder: &Path) -> (Solid, Job) {
    let solid = Solid::steel([10, 2, 2], [0.2, 0.03, 0.02]);
    let (k, m) = solid.triplets();
    let scaled = |list: common::Triplets| list.into_iter().map(|(i, j, x)| (i, j, x * 1e-3)).collect();
    let dofs: Vec<String> = solid.dofs().list().iter().map(ToString::to_string).collect();
    let sources = calculix(folder, &scaled(k), &scaled(m), &dofs);
    let root: Vec<String> = (0..3)
        .flat_map(|z| (0..3).map(move |y| (y, z)))
        .map(|(y, z)| (solid.node([0, y, z]) + 1).to_string())
        .collect();
    std::fs::write(folder.join("root.csv"), format!("node\n{}\n", root.join("\n"))).unwrap();
    let tip = solid.node([10, 1, 1]) + 1;
    let mut own = job(sources, &[], Method::MacNeal, 8);
    own.interfaces = vec![format!("tip={tip}.zy"), format!("push={tip}.x")];
    own.clamp = vec![folder.join("root.csv").display().to_string()];
    (solid, own)
}

fn number(lines: &[String], start: &str) -> f64 {
    let line =
        lines.iter().find(|line| line.starts_with(start)).unwrap_or_else(|| panic!("{start}: {lines:?}"));
    let rest = line.split_once(": ").unwrap().1;
    rest.split_whitespace().next().unwrap().parse().unwrap()
}

#[test]
fn closed_form_mass_frequency_and_sag_of_a_cantilever() {
    let folder = tempfile::tempdir().unwrap();
    let (solid, mut job) = cantilever(folder.path());
    // The tip hangs by its neutral fibre, whose sag beam theory gives.
    job.gravity = Some("-z".into());
    let Made { said, toml, .. } = job.run().unwrap();
    let [length, width, height] = solid.size;
    let [e, _, rho] = solid.material;
    // What is at clamped nodes does not move: a quarter of an element's mass and more.
    let mass = rho * length * width * height;
    let moving = number(&said, "mass that moves");
    assert!((0.9 * mass..mass).contains(&moving), "{moving} {mass}");
    // A beam of solid elements is too stiff in bending, by some percent for bricks of this length.
    let stiffness = e * width * height.powi(3) / 12.0;
    let first = 1.875_104_f64.powi(2) / length.powi(2) * (stiffness / (rho * width * height)).sqrt()
        / (2.0 * std::f64::consts::PI);
    let own = number(&said, "first frequency");
    assert!((1.0..1.3).contains(&(own / first)), "{own} {first}");
    let sag = rho * width * height * 9.80665 * length.powi(4) / (8.0 * stiffness);
    let own = number(&said, "sag under 1 g (9.80665 m/s²) along z");
    assert!((0.6..1.01).contains(&(own / sag)), "{own} {sag}");
    assert!(toml.contains("gravity = ["), "{toml}");
}

#[test]
fn golden_the_written_file_has_nodes_residual_and_heading() {
    let folder = tempfile::tempdir().unwrap();
    let (_, job) = cantilever(folder.path());
    let made = job.run().unwrap();
    let lines: Vec<&str> = made.toml.lines().collect();
    assert!(
        lines[0].starts_with("# Made by vibro reduce") && lines[0].ends_with("from b.sti, b.mas, b.dof"),
        "{}",
        lines[0]
    );
    assert!(
        lines[1].contains("N,mm,t,s; here SI. 297 dofs, 27 of them clamped; macneal, 8 coordinates"),
        "{}",
        lines[1]
    );
    let found = |start: &str| lines.iter().any(|line| line.starts_with(start));
    for start in [
        "name = \"rod\"",
        "[modal.rod]",
        "frequencies = [",
        "damping_ratio = 0.0",
        "residual = { nodes = [\"tip.z\", \"tip.y\", \"push\"], flexibility = [[",
        "[modal.rod.nodes]",
        "tip = { z = [",
        "push = [",
    ] {
        assert!(found(start), "{start}\n{}", made.toml);
    }
    for text in ["  tip.z ", "Motions use the residual flexibility", "no mode is missed"] {
        assert!(made.report.contains(text), "{text}\n{}", made.report);
    }
}

/// A change of a job, and what is said about it.
type Refused<'a> = (&'a dyn Fn(&mut Job), &'a str);

#[test]
fn invariant_options_that_do_not_fit_are_refused_by_words() {
    let folder = tempfile::tempdir().unwrap();
    let (_, good) = cantilever(folder.path());
    let said = |change: &dyn Fn(&mut Job)| {
        let mut job = good.clone();
        change(&mut job);
        job.run().unwrap_err().to_string()
    };
    let cases: [Refused; 11] = [
        (&|job| job.interfaces = vec!["tip".into()], "expected NAME=NODE"),
        (&|job| job.interfaces = vec!["tip=9999".into()], "9999: no such node; did you mean"),
        (&|job| job.interfaces = vec!["tip=11.w".into()], "w: expected directions such as x"),
        (&|job| job.interfaces = vec!["tip=11.rx".into()], "has no dof in rx; expected some of x, y, z"),
        (&|job| job.interfaces = vec!["tip=1".into()], "all dofs of node 1 are clamped"),
        (&|job| job.interfaces = vec!["2nd=11".into()], "begins with a letter"),
        (
            &|job| job.interfaces = vec!["a=11".into(), "b=11.x".into()],
            "dof 11.x also belongs to another interface node",
        ),
        (&|job| job.clamp = vec!["1,2000".into()], "2000: no such node"),
        (&|job| job.clamp = vec!["none.csv".into()], "none.csv: No such file"),
        (&|job| job.gravity = Some("q".into()), "expected one of x, y, z"),
        (&|job| job.name = "a b".into(), "--name a b"),
    ];
    for (change, expected) in cases {
        let text = said(change);
        assert!(text.contains(expected), "{expected}: {text}");
    }
}
