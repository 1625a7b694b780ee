//! Derivatives of a motion by all numbers of its machine, compared with differences of motions.

use std::sync::Arc;
use vibro_machine::description::Description;
use vibro_machine::{Assembly, Differentiated, Motion};

/// Steps of fourth-order differences, relative to a number or to 0.1. The best difference counts:
/// a step may be so long that other events happen, or so short that rounding dominates.
const STEPS: [f64; 4] = [1e-3, 1e-4, 1e-5, 1e-6];
/// Error of the best difference relative to the derivative and to the value: rounding over the
/// step, amplified by the motion.
const DIFFERENCE: f64 = 2e-7;

/// Values of all quantities at the end.
fn follow(machine: Description, end: f64) -> Vec<f64> {
    let quantities: Vec<_> = machine.quantities().collect();
    let mut motion = Motion::new(Arc::new(Assembly::new(machine).unwrap())).unwrap();
    motion.advance_to(end).unwrap();
    quantities.iter().map(|&q| motion.value(q)).collect()
}

/// Compares the derivatives at the end by all numbers of a machine with differences; returns their
/// names, and the number of events.
pub fn compare(machine: &Description, end: f64) -> (Vec<String>, usize) {
    // A number at the end of its range has no difference.
    let inside = machine.parameters().into_iter().filter(|own| own.value > own.range().min);
    let names: Vec<String> = inside.map(|parameter| parameter.name).collect();
    let columns: Vec<&str> = names.iter().map(String::as_str).collect();
    let assembly = Arc::new(Assembly::new(machine.clone()).unwrap());
    let mut met = 0;
    let mut motion = Differentiated::new(assembly, &columns).unwrap();
    motion.advance_observed(end, &mut |_, _| met += 1).unwrap();
    let quantities: Vec<_> = machine.quantities().collect();
    for (p, name) in columns.iter().enumerate() {
        assert!(motion.lost(p).is_none(), "{name}: {:?}", motion.lost(p));
        let value = machine.get(name).unwrap();
        let exact: Vec<f64> = quantities.iter().map(|&q| motion.derivative(q, p).unwrap()).collect();
        let errors = STEPS.map(|size| {
            let step = size * value.abs().max(0.1);
            let at = |k: f64| follow(machine.with([(*name, value + k * step)]).unwrap(), end);
            let [a, b, c, d] = [at(-2.0), at(-1.0), at(1.0), at(2.0)];
            let error = |i: usize| {
                let difference = (8.0 * (c[i] - b[i]) - (d[i] - a[i])) / (12.0 * step);
                (exact[i] - difference).abs() / exact[i].abs().max(a[i].abs()).max(1.0)
            };
            (0..exact.len()).map(error).fold(0.0, f64::max)
        });
        let best = errors.into_iter().fold(f64::INFINITY, f64::min);
        assert!(best < DIFFERENCE, "{name}: {errors:?}, {exact:?}");
    }
    (names, met)
}
