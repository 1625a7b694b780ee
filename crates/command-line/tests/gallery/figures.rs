//! Numbers of tables on pages of the gallery, from the pages' commands, against closed forms.

use super::{commands, folder, root};
use nalgebra::{Complex, Matrix2, Vector2};
use std::f64::consts::{PI, TAU};
use std::path::Path;
use std::process::Command;

/// Rounding of a number with four digits on a page.
const FOUR_DIGITS: f64 = 6e-4;

/// Rows of the table on a page that begin with a number, as numbers; NaN for words.
fn rows(page: &str) -> Vec<Vec<f64>> {
    let cells = |line: &str| {
        line.trim_matches('|').split('|').map(|cell| cell.trim().parse().unwrap_or(f64::NAN)).collect()
    };
    let all: Vec<Vec<f64>> = page.lines().filter(|line| line.starts_with('|')).map(cells).collect();
    all.into_iter().filter(|row| row[0].is_finite()).collect()
}

fn page(name: &str) -> String {
    std::fs::read_to_string(root().join("docs/gallery").join(name).with_extension("md")).unwrap()
}

fn performed(line: &str, out: &Path) {
    let mut vibro = Command::new(env!("CARGO_BIN_EXE_vibro"));
    let output =
        vibro.args(line.split_whitespace()).arg("--out").arg(out).current_dir(root()).output().unwrap();
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
}

#[track_caller]
fn near(one: f64, other: f64, allowed: f64) {
    assert!((one / other - 1.0).abs() < allowed, "{one} {other}");
}

/// Two blades against each other move the block along y only, and each blade has half of it.
struct Blade;

impl Blade {
    const TIP: [f64; 2] = [2.4, -2.2];
    const X: [f64; 2] = [0.3, -0.8];
    const Y: [f64; 2] = [-0.06, 0.2];

    /// Displacements of both modes by harmonic forces on them, with a stiffness along x.
    fn modes(w: f64, along: f64, force: Vector2<Complex<f64>>) -> Vector2<Complex<f64>> {
        let (mass, press) = (0.02, Complex::new(6e6, 25.0 * w));
        let normal = -press * w * w * mass / (press * 2.0 - w * w * mass);
        let entry = |i: usize, j: usize| {
            let own = TAU * [180.0, 1100.0][i];
            let alone = if i == j { Complex::new(own * own - w * w, 0.01 * own * w) } else { Complex::ZERO };
            alone + Self::X[i] * Self::X[j] * along + normal * Self::Y[i] * Self::Y[j]
        };
        Matrix2::from_fn(entry).try_inverse().unwrap() * force
    }

    /// The place of a node by displacements of both modes.
    fn at(row: [f64; 2], modes: &Vector2<Complex<f64>>) -> Complex<f64> {
        modes[0] * row[0] + modes[1] * row[1]
    }

    /// Forces on both modes by a force at a node.
    fn on(row: [f64; 2], force: Complex<f64>) -> Vector2<Complex<f64>> {
        Vector2::new(force * row[0], force * row[1])
    }

    fn stuck(w: f64, level: f64) -> f64 {
        Self::at(Self::TIP, &Self::modes(w, 4e6, Self::on(Self::TIP, level.into()))).norm()
    }

    /// Friction as 4 μ N/π against the platform's rate.
    fn slipping(w: f64, level: f64, friction: f64) -> f64 {
        let mut modes = Self::modes(w, 0.0, Self::on(Self::TIP, level.into()));
        for _ in 0..50 {
            let rate = Self::at(Self::X, &modes) * Complex::I;
            let force = Self::on(Self::X, -rate / rate.norm() * (4.0 / PI * friction));
            modes = Self::modes(w, 0.0, Self::on(Self::TIP, level.into()) + force);
        }
        Self::at(Self::TIP, &modes).norm()
    }
}

/// Of the linear responses: transients that have not decayed yet, and further harmonics in slip.
const STUCK: f64 = 1e-5;
const SLIPPING: f64 = 1e-3;

#[test]
fn closed_form_an_underplatform_damper_in_full_stick_and_in_full_slip() {
    let page = page("underplatform_damper");
    let (line, _) = commands(&page)[2].strip_prefix("vibro ").unwrap().split_once(" --out ").unwrap();
    let out = folder("gallery-levels");
    performed(line, &out);
    let mut reader = csv::Reader::from_path(out.join("sweep.csv")).unwrap();
    let names: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let place = |end: &str| names.iter().position(|name| name.ends_with(end)).unwrap();
    let (largest, at) = (place(".s.max"), place(".max.frequency"));
    let measured: Vec<[f64; 3]> = reader
        .records()
        .map(|row| row.map(|row| [0, at, largest].map(|k| row[k].parse().unwrap())).unwrap())
        .collect();
    let told = rows(&page);
    assert_eq!(measured.len(), told.len());
    for ([level, frequency, peaks], row) in measured.iter().zip(&told) {
        assert_eq!([*level, *frequency], row[..2]);
        near(row[2], 0.5e3 * peaks, FOUR_DIGITS);
        near(row[3], 0.5e3 * peaks / level, FOUR_DIGITS);
    }
    let [[low, at, peaks], .., [high, there, far]] = measured[..] else { panic!("{measured:?}") };
    near(0.5 * peaks, Blade::stuck(TAU * at, low), STUCK);
    near(0.5 * far, Blade::slipping(TAU * there, high, 0.3 * 60.0), SLIPPING);
    let free = Blade::at(Blade::TIP, &Blade::modes(TAU * 180.0, 0.0, Blade::on(Blade::TIP, 1e3.into())));
    assert!(page.contains(&format!("without the block {:.4} mm/N", free.norm())), "{}", free.norm());
}

/// Relative deviation of a bar of n modes from its waves, times n; and of its energy.
const OF_MODES: f64 = 0.06;
const ENERGY: f64 = 1e-12;

#[test]
fn closed_form_a_bar_leaves_the_wall_with_its_wave() {
    let examples = root().join("examples/assembly");
    let wave = 2.0 / (210e9f64 / 7850.0).sqrt();
    for row in rows(&page("bar_on_wall")) {
        let mut python = Command::new("python3");
        let python = python.arg("bar_on_wall.py").arg(format!("{}", row[0])).current_dir(&examples).output();
        let Ok(python) = python else {
            eprintln!("NOT RUN: python3 is missing");
            return;
        };
        assert!(python.status.success(), "{}", String::from_utf8_lossy(&python.stderr));
        let written = String::from_utf8(python.stdout).unwrap();
        let out = folder(&format!("gallery-bar-{}", row[0]));
        std::fs::create_dir_all(&out).unwrap();
        let file = out.join("bar.toml");
        std::fs::write(&file, &written).unwrap();
        if row[0] == 10.0 {
            assert_eq!(written, std::fs::read_to_string(examples.join("bar_on_wall.toml")).unwrap());
        }
        let out = out.join("run");
        performed(&format!("run {} --until 0.8ms --columns bar.q[0].v", file.display()), &out);
        let last = |table: &str| {
            let mut reader = csv::Reader::from_path(out.join(table)).unwrap();
            let row = reader.records().last().unwrap().unwrap();
            row.iter().map(|cell| cell.parse().unwrap_or(f64::NAN)).collect::<Vec<f64>>()
        };
        let (contact, speed) = (last("contacts.csv"), last("states.csv")[1]);
        let (length, lost) = ((contact[2] - contact[1]) / wave, contact[6]);
        near(row[1], length, FOUR_DIGITS);
        near(row[2], speed, FOUR_DIGITS);
        near(length, 1.0, OF_MODES / row[0]);
        near(speed, -1.0, OF_MODES / row[0]);
        assert!(lost.abs() < ENERGY && row[3] == 0.0, "{lost}");
    }
}
