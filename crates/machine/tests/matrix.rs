//! Bodies with mass and stiffness matrices.

use crate::common::*;
use nalgebra::{Cholesky, DMatrix, DVector, SymmetricEigen};
use std::f64::consts::TAU;
use std::io;
use vibro_machine::Motion;
use vibro_machine::file::{no_records, parse};

/// Rounding of an eigenproblem whose eigenvalues spread over a factor of 1e7.
const EIGEN: f64 = 1e-8;

/// A thousand roundings of numbers of order one.
const ROUNDING: f64 = 1e-11;

fn of(m: &Motion, name: &str) -> [f64; 3] {
    m.body(m.assembly().description.bodies.iter().position(|body| body.name == name).unwrap())
}

/// Times and kinds of the events up to a time.
fn events(m: &mut Motion, end: f64) -> Vec<(f64, String)> {
    let mut all = Vec::new();
    m.advance_observed(end, &mut |event| all.push((event.time, format!("{:?}", event.kind)))).unwrap();
    all
}

/// A time before the stop's bounces end, s: the number of the last bounces depends on rounding.
const BEFORE_CHATTER: f64 = 1.0;

/// Three masses in a row with dashpots that couple their modes, and a stop and a friction on the
/// last mass.
const CHAIN: &str = r#"
    name = "Chain"
    gravity = 9.81
    matrix.chain = { mass = [[2, 0, 0], [0, 1, 0], [0, 0, 0.5]], stiffness = [[900, -400, 0], [-400, 700, -300], [0, -300, 300]], damping = [[3, -2, 0], [-2, 2, 0], [0, 0, 0]], gravity = [1, 1, 1], start = { v = [0, 0, 0.8] }, nodes = { first = 0, second = [0, 1, 0], last = { "2" = 1 } } }
    stop.end = { between = ["ground", "chain.last"], gap = "35 mm", restitution = 0.95 }
    friction.pad = { between = ["ground", "chain.second"], force = 0.4 }
    load.shaker = { on = "chain.first", amplitude = 6.0, frequency = 2.3 }
"#;

const BODIES: &str = r#"
    name = "Chain"
    gravity = 9.81
    body.first = { mass = 2, gravity = 1 }
    body.second = { mass = 1, gravity = 1 }
    body.last = { mass = 0.5, gravity = 1, start = { v = 0.8 } }
    spring.a = { between = ["ground", "first"], stiffness = 500, damping = 1 }
    spring.b = { between = ["first", "second"], stiffness = 400, damping = 2 }
    spring.c = { between = ["second", "last"], stiffness = 300 }
    stop.end = { between = ["ground", "last"], gap = "35 mm", restitution = 0.95 }
    friction.pad = { between = ["ground", "second"], force = 0.4 }
    load.shaker = { on = "first", amplitude = 6.0, frequency = 2.3 }
"#;

#[test]
fn second_method_matrices_are_bodies_with_springs() {
    let mut both = [CHAIN, BODIES].map(|text| motion(machine(text)));
    let found = both.each_mut().map(|m| events(m, BEFORE_CHATTER));
    assert!(found[0].len() > 5, "{}", found[0].len());
    assert_eq!(found[0].len(), found[1].len());
    for (one, other) in found[0].iter().zip(&found[1]) {
        assert!((one.0 - other.0).abs() < ROUNDING && one.1[..4] == other.1[..4], "{one:?} {other:?}");
    }
    for name in ["first", "second", "last"] {
        let (one, other) = (of(&both[0], &format!("chain.{name}")), of(&both[1], name));
        assert!((0..2).all(|k| (one[k] - other[k]).abs() < 100.0 * ROUNDING), "{name} {one:?} {other:?}");
    }
    let lost = both.each_ref().map(|m| m.energy().dashpots.iter().map(|x| x.value()).sum::<f64>());
    assert!((lost[0] - lost[1]).abs() < ROUNDING, "{lost:?}");
    let stored = both.each_ref().map(|m| m.kinetic_and_stored());
    assert!((stored[0].0 - stored[1].0).abs() < ROUNDING && (stored[0].1 - stored[1].1).abs() < ROUNDING);
}

/// Stiffness and mass of a cantilever of `count` Euler-Bernoulli elements with EI = ρA = L = 1;
/// coordinates are deflection and slope from the first free node on.
pub fn cantilever(count: usize) -> [DMatrix<f64>; 2] {
    let h = 1.0 / count as f64;
    let k = [
        [12.0, 6.0 * h, -12.0, 6.0 * h],
        [6.0 * h, 4.0 * h * h, -6.0 * h, 2.0 * h * h],
        [-12.0, -6.0 * h, 12.0, -6.0 * h],
        [6.0 * h, 2.0 * h * h, -6.0 * h, 4.0 * h * h],
    ];
    let m = [
        [156.0, 22.0 * h, 54.0, -13.0 * h],
        [22.0 * h, 4.0 * h * h, 13.0 * h, -3.0 * h * h],
        [54.0, 13.0 * h, 156.0, -22.0 * h],
        [-13.0 * h, -3.0 * h * h, -22.0 * h, 4.0 * h * h],
    ];
    let assembled = |element: [[f64; 4]; 4], factor: f64| {
        let mut all = DMatrix::zeros(2 * count + 2, 2 * count + 2);
        for first in (0..count).map(|e| 2 * e) {
            (0..16).for_each(|k| all[(first + k / 4, first + k % 4)] += factor * element[k / 4][k % 4]);
        }
        all.view((2, 2), (2 * count, 2 * count)).into_owned()
    };
    [assembled(k, h.powi(-3)), assembled(m, h / 420.0)]
}

fn rows(a: &DMatrix<f64>) -> String {
    let row = |row: usize| format!("{:?}", a.row(row).iter().copied().collect::<Vec<f64>>());
    format!("[{}]", (0..a.nrows()).map(row).collect::<Vec<_>>().join(", "))
}

/// A cantilever with a load at its tip and a damping ratio of one percent.
fn beam(count: usize, rest: &str) -> String {
    let [k, m] = cantilever(count);
    let (tip, all) = (2 * count - 2, 2 * count);
    let start: Vec<f64> = (0..all).map(|i| if i == tip { 0.3 } else { 0.0 }).collect();
    let start = if rest.is_empty() { format!(", start = {{ v = {start:?} }}") } else { String::new() };
    format!(
        "name = \"Beam\"\n{rest}\n[matrix.beam]\nmass = {}\nstiffness = {}\ndamping_ratio = 0.01{}\nnodes = {{ tip = {tip}, slope = {{ row = {}, dimension = \"rotation\" }} }}\n",
        rows(&m),
        rows(&k),
        start.replace(", start", "\nstart"),
        tip + 1
    )
}

/// The tip deflects by P L³/(3EI) and rotates by P L²/(2EI); cubic elements are exact there.
#[test]
fn closed_form_static_deflection_of_a_cantilever() {
    let text = beam(10, "start = \"rest\"") + "[load.weight]\non = \"beam.tip\"\nconstant = 0.06\n";
    let m = motion(machine(&text));
    let [s, slope] = ["beam.tip", "beam.slope"].map(|name| of(&m, name)[0]);
    assert!((s / 0.02 - 1.0).abs() < EIGEN && (slope / 0.03 - 1.0).abs() < EIGEN, "{s} {slope}");
}

/// ω = (β L)² with cos βL cosh βL = -1: 1.8751, 4.6941, 7.8548. Elements are too stiff: ω² is too
/// large by the order (βL/count)⁴/720 (Strang and Fix 1973, section 6.3).
#[test]
fn published_frequencies_of_a_cantilever() {
    let d = machine(&beam(10, ""));
    let m = motion(d);
    let springs = &m.assembly().system().springs;
    for (i, beta) in
        [1.875_104_068_711_961_f64, 4.694_091_132_974_175, 7.854_757_438_237_613].into_iter().enumerate()
    {
        let omega = springs[i].stiffness.sqrt();
        let bound = (beta / 10.0).powi(4) / 720.0;
        let error = omega / (beta * beta) - 1.0;
        assert!(error > -EIGEN && error < bound + EIGEN, "{i} {error} {bound}");
    }
}

/// A beam with a stop to ground, as a matrix and as its modes, which the test computes.
#[test]
fn second_method_a_beam_with_a_stop_is_its_modes() {
    let count = 6;
    let stop = "[stop.tip]\nbetween = [\"ground\", \"beam.tip\"]\ngap = 0.02\nrestitution = 0.8\n";
    let [k, m] = cantilever(count);
    let l = Cholesky::new(m.clone()).unwrap().l();
    let inverse = l.clone().try_inverse().unwrap();
    let found = SymmetricEigen::new(&inverse * &k * inverse.transpose());
    let modes = inverse.transpose() * &found.eigenvectors;
    let list = |all: Vec<f64>| format!("{all:?}");
    let tip = 2 * count - 2;
    let frequencies = list(found.eigenvalues.iter().map(|x| x.sqrt() / TAU).collect());
    let row = list(modes.row(tip).iter().copied().collect());
    let mut v = DVector::zeros(2 * count);
    v[tip] = 0.3;
    let v = list((modes.transpose() * m * v).iter().copied().collect());
    let modal = format!(
        "name = \"Beam\"\n[modal.beam]\nfrequencies = {frequencies}\ndamping_ratio = 0.01\nnodes = {{ tip = {row} }}\nstart = {{ v = {v} }}\n{stop}"
    );
    let mut both = [beam(count, "") + stop, modal].map(|text| motion(machine(&text)));
    let all = both.each_mut().map(|m| events(m, 0.5));
    assert!(all[0].len() > 3 && all[0].len() == all[1].len(), "{:?} {:?}", all[0].len(), all[1].len());
    for (one, other) in all[0].iter().zip(&all[1]) {
        assert!((one.0 - other.0).abs() < EIGEN, "{one:?} {other:?}");
    }
    let [one, other] = both.each_ref().map(|m| of(m, "beam.tip"));
    assert!(
        (one[0] - other[0]).abs() < EIGEN && (one[1] - other[1]).abs() < 1000.0 * EIGEN,
        "{one:?} {other:?}"
    );
}

/// q₁ + i q₂ = z with z'' - iγz' + κz = 0 has the whirls γ/2 ± √(γ²/4 + κ); no energy is lost.
#[test]
fn closed_form_gyroscopic_whirl() {
    let (gamma, kappa) = (3.0_f64, 40.0_f64);
    let text = r#"
        name = "Rotor"
        matrix.rotor = { mass = [[2, 0], [0, 2]], stiffness = [[80, 0], [0, 80]], gyroscopic = [[0, 6], [-6, 0]], nodes = { x = 0, y = 1 }, start = { q = [1, 0] } }
    "#;
    let mut m = motion(machine(text));
    let begin = m.kinetic_and_stored();
    m.advance_to(1.7).unwrap();
    let root = (gamma * gamma / 4.0 + kappa).sqrt();
    let (one, two) = (gamma / 2.0 + root, gamma / 2.0 - root);
    let part = |f: fn(f64) -> f64| (one * f(two * 1.7) - two * f(one * 1.7)) / (one - two);
    let (x, y) = (of(&m, "rotor.x")[0], of(&m, "rotor.y")[0]);
    assert!((x - part(f64::cos)).abs() < ROUNDING && (y - part(f64::sin)).abs() < ROUNDING, "{x} {y}");
    let end = m.kinetic_and_stored();
    assert!((begin.0 + begin.1 - end.0 - end.1).abs() < 80.0 * ROUNDING);
}

/// If a link moves a node, it also does the work of gyroscopic forces.
#[test]
fn invariant_energy_of_a_rotor_moved_by_a_link() {
    let text = r#"
        name = "Rotor"
        body.shaker = { motion = { amplitude = 0.1, frequency = 1.0 } }
        matrix.rotor = { mass = [[2, 0.5], [0.5, 2]], stiffness = [[80, 0], [0, 60]], gyroscopic = [[0, 6], [-6, 0]], damping = [[1, 0.2], [0.2, 0.3]], nodes = { x = [1, 0.2], y = 1 }, start = { q = [-0.02, 0.1], v = [0.6283185307179586, 0] } }
        link.hold = { between = ["shaker", "rotor.x"] }
    "#;
    let mut m = motion(machine(text));
    let begin = m.kinetic_and_stored();
    m.advance_to(1.3).unwrap();
    let end = m.kinetic_and_stored();
    let change = end.0 + end.1 - begin.0 - begin.1;
    assert!((change - m.energy().balance()).abs() < ROUNDING, "{change} {}", m.energy().balance());
    assert!(m.energy().motions.value().abs() > 0.01);
}

const FILES: &str = r#"
    name = "Files"
    [matrix.pair]
    mass = "data/M.mtx"
    stiffness = "K.mtx"
    damping = "C.csv"
    gyroscopic = "G.mtx"
    nodes = { tip = "tip.csv", other = [1, 0] }
"#;

fn files(path: &str) -> io::Result<String> {
    Ok(match path {
        "data/M.mtx" => {
            "%%MatrixMarket matrix coordinate real symmetric\n% masses\n2 2 3\n1 1 2.0\n2 2 1e0\n2 1 0.25\n"
        }
        "K.mtx" => "%%MatrixMarket matrix array real general\n2 2\n30.0\n-10.0\n-10.0\n10.0\n",
        "C.csv" => "# damping\n0.5,-0.5\n-0.5,0.5\n",
        "G.mtx" => "%%MatrixMarket matrix coordinate real skew-symmetric\n2 2 1\n2 1 0.5\n",
        "tip.csv" => "0\n1\n",
        "complex.mtx" => "%%MatrixMarket matrix coordinate complex general\n2 2 0\n",
        "pattern.mtx" => "%%MatrixMarket matrix coordinate pattern symmetric\n2 2 1\n1 1\n",
        "double.mtx" => "%%MatrixMarket matrix coordinate real general\n2 2 2\n1 1 2\n1 1 3\n",
        "short.mtx" => "%%MatrixMarket matrix coordinate real general\n2 2 2\n1 1 2\n",
        "three.mtx" => "%%MatrixMarket matrix array real symmetric\n3 3\n1\n0\n0\n1\n0\n1\n",
        _ => return Err(io::Error::other("it is not there")),
    }
    .into())
}

#[test]
fn golden_matrices_from_files_and_the_written_file() {
    let found = parse(FILES, "files.toml", &files).unwrap_or_else(|e| panic!("{e}"));
    let given = &found.matrices[0].given;
    assert_eq!(given.mass, DMatrix::from_row_slice(2, 2, &[2.0, 0.25, 0.25, 1.0]));
    assert_eq!(given.stiffness, DMatrix::from_row_slice(2, 2, &[30.0, -10.0, -10.0, 10.0]));
    assert_eq!(given.gyroscopic, Some(DMatrix::from_row_slice(2, 2, &[0.0, -0.5, 0.5, 0.0])));
    assert_eq!(given.nodes[0].row, DVector::from_vec(vec![0.0, 1.0]));
    for text in [found.to_toml(), machine(CHAIN).to_toml()] {
        let own = machine(&text);
        assert_eq!(own.to_toml(), text);
    }
    assert_eq!(machine(&found.to_toml()), found);
    assert_eq!(machine(CHAIN).parameters().len(), 8);
    let columns: Vec<_> = found.named_quantities().into_iter().map(|q| q.name).collect();
    assert_eq!(
        columns,
        ["pair.tip.s", "pair.tip.v", "pair.tip.a", "pair.other.s", "pair.other.v", "pair.other.a"]
    );
}

#[test]
fn errors_of_matrices_name_the_entry() {
    for (whole, wrong, text) in [
        (
            "[-400, 700, -300]",
            "[-401, 700, -300]",
            "matrix.chain.stiffness: is not symmetric: the entry in row 1 and column 0, counted from 0, is -401.0, but the entry in row 0 and column 1 is -400.0",
        ),
        (
            "[0, 0, 0.5]",
            "[0, 0, 0]",
            "matrix.chain.mass: row 2, counted from 0, is zero: the coordinate has no mass",
        ),
        (
            "[0, 0, 0.5]",
            "[0, 0, -0.5]",
            "matrix.chain.mass: is not positive definite: its smallest eigenvalue is -0.5; expected",
        ),
        ("[0, -300, 300]", "[0, -300, -300]", "matrix.chain.stiffness: its smallest eigenvalue is -"),
        (
            "damping = [[3, -2, 0], [-2, 2, 0], [0, 0, 0]]",
            "damping = [[-3, 0, 0], [0, 2, 0], [0, 0, 0]]",
            "matrix.chain.damping: its smallest eigenvalue is -",
        ),
        (
            "gravity = [1, 1, 1]",
            "rayleigh = [0.1, 1e-4]",
            "matrix.chain.rayleigh = [0.1, 1e-4]: cannot be combined with `damping`: use one of `damping`, `rayleigh` and `damping_ratio`",
        ),
        (
            "gravity = [1, 1, 1]",
            "gyroscopic = [[0, 1, 0], [1, 0, 0], [0, 0, 0]]",
            "matrix.chain.gyroscopic: is not skew",
        ),
        (
            "gravity = [1, 1, 1]",
            "gyroscopic = [[0, 1], [-1, 0]]",
            "has 2 rows and 2 columns; expected 3 of each, as in the mass matrix",
        ),
        ("first = 0", "first = 3", "expected the index of a coordinate, 0 to 2"),
        (
            "mass = [[2, 0, 0], [0, 1, 0], [0, 0, 0.5]]",
            "mass = [[2, 0], [0, 1, 0]]",
            "expected a Matrix Market file",
        ),
    ] {
        assert!(CHAIN.contains(whole), "{whole}");
        let refused =
            parse(&CHAIN.replacen(whole, wrong, 1), "matrix.toml", &no_records).unwrap_err().to_string();
        assert!(refused.contains(text), "{refused}");
    }
    for (file, text) in [
        ("complex.mtx", "= \"complex.mtx\": line 1: complex: expected real or integer entries"),
        ("pattern.mtx", "= \"pattern.mtx\": line 1: pattern: expected real or integer entries"),
        ("double.mtx", "= \"double.mtx\": line 4: 1 1 3: this entry is given twice"),
        ("short.mtx", "= \"short.mtx\": it has 1 entry; expected 2, the number in its line of sizes"),
        ("three.mtx", "has 3 rows and 3 columns; expected 2 of each, as in the mass matrix"),
        ("none.mtx", "cannot be read: it is not there"),
        ("/M.mtx", "expected a path below the file's folder"),
    ] {
        let refused = parse(&FILES.replace("K.mtx", file), "files.toml", &files).unwrap_err().to_string();
        assert!(refused.contains(text), "{refused}");
    }
}
