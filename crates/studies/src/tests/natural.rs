//! Eigenvalues of chains against closed forms, and sparse against dense computations.

use super::text;
use crate::natural::{Natural, SHOWN, natural, natural_above};
use std::f64::consts::PI;
use std::fmt::Write;
use vibro_machine::{Assembly, Motion};

/// Relative tolerance: bracket of ω², and rounding of the largest ω² of a chain of 320, which is
/// 2e5 times the lowest one.
const COUNTED: f64 = 2e-9;
/// Tolerance for the rounding of an eigenvalue whose iteration has settled, and of a dense
/// matrix's eigenvalue.
const REFINED: f64 = 1e-9;

const STIFFNESS: f64 = 1e4;

/// The eigenvalues of a chain of bodies of 1 kg from the ground, with the damping of each spring.
fn chain(count: usize, damping: impl Fn(usize) -> f64, dense: Option<usize>) -> Natural {
    let mut file = "name = \"C\"\n".to_owned();
    for i in 0..count {
        let before = if i == 0 { "ground".into() } else { format!("b{}", i - 1) };
        let _ = write!(
            file,
            "[body.b{i}]\nmass = 1.0\n[spring.k{i}]\nbetween = [\"{before}\", \"b{i}\"]\nstiffness = {STIFFNESS:?}\ndamping = {:?}\n",
            damping(i)
        );
    }
    let assembly = std::sync::Arc::new(Assembly::new(text(&file).description).unwrap());
    let motion = Motion::new(assembly.clone()).unwrap();
    let system = assembly.system();
    let (linear, places) = (system.linear(motion.mode()), (0..system.states()).collect::<Vec<_>>());
    match dense {
        Some(dense) => natural_above(system, &linear, &places, dense),
        None => natural(system, &linear, &places),
    }
}

#[test]
fn closed_form_a_long_chain_has_its_lowest_and_highest_oscillations() {
    let (count, damping) = (320, 5.0);
    let found = chain(count, |_| damping, None);
    let [span] = &found.spans[..] else { panic!("{found:?}") };
    assert!(found.values.is_empty() && span.still == 0 && span.between() == count - 2 * SHOWN);
    let [low, high] = &span.shown;
    for (k, own) in (1..).zip(low).chain((count - SHOWN + 1..).zip(high)) {
        let omega = 2.0 * STIFFNESS.sqrt() * (PI * (2 * k - 1) as f64 / (2 * (2 * count + 1)) as f64).sin();
        assert!((own.undamped / omega - 1.0).abs() < COUNTED, "{k}: {} {omega}", own.undamped);
        let value = own.damped.expect("a single value");
        let ratio = damping * omega / (2.0 * STIFFNESS);
        assert!((-value.re / value.norm() / ratio - 1.0).abs() < 4.0 * COUNTED, "{k}: {value} {ratio}");
    }
}

#[test]
fn second_method_damping_that_is_not_proportional_has_the_values_of_the_dense_matrix() {
    let damping = |i: usize| if i == 3 { 30.0 } else { 0.0 };
    let dense = chain(24, damping, Some(usize::MAX)).values;
    let found = chain(24, damping, Some(0));
    let [span] = &found.spans[..] else { panic!("{found:?}") };
    for own in span.shown.iter().flatten() {
        let value = own.damped.expect("a single value");
        let nearest = dense.iter().map(|other| (other - value).norm()).fold(f64::MAX, f64::min);
        assert!(nearest < REFINED * value.norm(), "{value}: {nearest}");
    }
}

#[test]
fn invariant_parts_have_the_values_of_the_whole() {
    // Two separate chains, of two bodies each, from the ground.
    let cut = |file: &str| {
        let assembly = std::sync::Arc::new(Assembly::new(text(file).description).unwrap());
        let motion = Motion::new(assembly.clone()).unwrap();
        let system = assembly.system();
        let places: Vec<usize> = (0..system.states()).collect();
        let linear = system.linear(motion.mode());
        let whole = nalgebra::DMatrix::from_fn(places.len(), places.len(), |i, j| linear.a.entry(i, j));
        (natural(system, &linear, &places).values, whole.complex_eigenvalues())
    };
    let mut file = "name = \"C\"\n".to_owned();
    for i in 0..4 {
        let _ = write!(
            file,
            "[body.b{i}]\nmass = 1.5\n[spring.k{i}]\nbetween = [\"{}\", \"b{i}\"]\nstiffness = {:?}\ndamping = 2.0\n",
            if i % 2 == 0 { "ground".into() } else { format!("b{}", i - 1) },
            1e3 * (i + 1) as f64
        );
    }
    let (parts, whole) = cut(&file);
    assert_eq!(parts.len(), whole.len());
    for value in &parts {
        let nearest = whole.iter().map(|other| (other - value).norm()).fold(f64::MAX, f64::min);
        assert!(nearest < REFINED * value.norm(), "{value}: {nearest}");
    }
}
