//! Some 20,000 dofs: exact modes, and the time that a reduction takes. They are asked for by name,
//! in a release build.

mod common;

use common::{Solid, chain, grid};
use std::fmt::Write;
use std::time::{Duration, Instant};
use vibro_reduce::damping::Damping;
use vibro_reduce::import::files::Sources;
use vibro_reduce::job::Job;
use vibro_reduce::reduction::{Method, reduce};
use vibro_reduce::statement::Given;

/// Eigenvalues of solids: rounding of K by its condition, some 1e6.
const EXACT: f64 = 1e-10;
/// Eigenvalues of a long chain: rounding of K by its condition, some 1e8.
const LONG: f64 = 1e-8;
/// Time for 20 modes from files to files on two cores.
const LONGEST: Duration = Duration::from_secs(15);

#[test]
#[ignore = "asked for by name in a release build: 17,000 dofs"]
fn closed_form_thirty_modes_of_a_large_solid() {
    let solid = Solid::steel([19, 18, 17], [0.19, 0.17, 0.15]);
    let model = solid.between_mirrors();
    println!("{} dofs", model.dofs.len());
    let exact = solid.mirrored_values();
    let reduced = reduce(&model, &[], Method::MacNeal, 30).unwrap();
    for (k, (value, exact)) in reduced.values.iter().zip(&exact).enumerate() {
        assert!((value / exact - 1.0).abs() < EXACT, "{k} {value} {exact}");
    }
}

#[test]
#[ignore = "asked for by name in a release build: 20,000 dofs"]
fn closed_form_a_large_grid_and_a_long_chain() {
    let (model, exact) = grid(27);
    let count = 20_000;
    let long = chain(&vec![1.0; count], &vec![1.0; count]);
    let angle = |k: usize| std::f64::consts::PI * (2 * k + 1) as f64 / (2 * count + 1) as f64;
    // 2 - 2 cos x, without cancellation.
    let of_long = (0..count).map(|k| 4.0 * (0.5 * angle(k)).sin().powi(2)).collect();
    for (model, exact, wanted, tolerance) in
        [(&model, &exact, 20, EXACT), (&model, &exact, 100, EXACT), (&long, &of_long, 20, LONG)]
    {
        let start = Instant::now();
        let reduced = reduce(model, &[], Method::MacNeal, wanted).unwrap();
        println!("{} dofs, {wanted} modes: {:.1?}", exact.len(), start.elapsed());
        for (k, (value, exact)) in reduced.values.iter().zip(exact).enumerate() {
            assert!((value / exact - 1.0).abs() < tolerance, "{k} {value} {exact}");
        }
    }
}

#[test]
#[ignore = "asked for by name in a release build: it measures time"]
fn invariant_twenty_modes_of_twenty_thousand_dofs_take_seconds() {
    let folder = tempfile::tempdir().unwrap();
    for (elements, method, is_held) in [
        ([66, 9, 9], Method::MacNeal, true),
        ([27, 13, 16], Method::Rubin, true),
        ([66, 9, 9], Method::CraigBampton, true),
        ([66, 9, 9], Method::MacNeal, false),
    ] {
        let solid = Solid::steel(elements, [0.3, 0.06, 0.05]);
        let (k, m) = solid.triplets();
        let write = |name: &str, list: &common::Triplets| {
            let mut text = String::new();
            for (i, j, x) in list {
                let _ = writeln!(text, "{} {} {x:.15e}", i + 1, j + 1);
            }
            std::fs::write(folder.path().join(name), text).unwrap();
            folder.path().join(name)
        };
        let files = vec![write("b.sti", &k), write("b.mas", &m), folder.path().join("b.dof")];
        let dofs: String = solid.dofs().list().iter().map(|dof| format!("{dof}\n")).collect();
        std::fs::write(&files[2], dofs).unwrap();
        let root = solid.rows(&[0], |at| at[0] == 0);
        let root: Vec<String> = root.iter().map(|row| (row / 3 + 1).to_string()).collect();
        let tip = solid.node(elements) + 1;
        let job = Job {
            sources: Sources { files, ..Sources::default() },
            units: "SI".into(),
            clamp: if is_held { vec![root.join(",")] } else { vec![] },
            interfaces: vec![format!("tip={tip}"), format!("other={}", tip - elements[0] / 2)],
            method,
            modes: 20,
            damping: Damping::Ratio(0.002),
            gravity: None,
            given: Given::default(),
            name: "solid".into(),
        };
        // The shortest of three, as other programs run beside it.
        let timed = || {
            let start = Instant::now();
            let made = job.run().unwrap();
            println!(
                "{elements:?} {method:?} held {is_held}: {:.1?}, {} vectors",
                start.elapsed(),
                made.reduced.modes.steps
            );
            start.elapsed()
        };
        let taken = (0..3).map(|_| timed()).min().unwrap();
        assert!(taken < LONGEST, "{taken:?}");
    }
}
