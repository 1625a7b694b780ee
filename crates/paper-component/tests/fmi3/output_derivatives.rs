//! `fmi3GetOutputDerivatives` (FMI 3.0.2, 4.1.2).

use super::derivatives::CONTACTS;
use super::host::*;
use vibro_paper_component::component::variables::{Causality, VARIABLES, Variability};
use vibro_paper_component::fmi3::abi::*;

/// Names of all continuous outputs.
fn continuous_outputs() -> Vec<&'static str> {
    let outputs = VARIABLES.iter().filter(|v| {
        v.causality == Causality::Output && v.variability == Variability::Continuous && v.unit().is_some()
    });
    outputs.map(|v| v.name).collect()
}

fn output_derivatives(fmu: &Fmu, name: &str) -> [f64; 4] {
    let (r, mut values) = ([vr(name); 3], [f64::NAN; 3]);
    // SAFETY: three of each.
    let status =
        unsafe { fmi3GetOutputDerivatives(fmu.c, r.as_ptr(), 3, [1, 2, 3].as_ptr(), values.as_mut_ptr(), 3) };
    assert_eq!(status, OK, "{name}: {}", fmu.last());
    [fmu.get(name), values[0], values[1], values[2]]
}

/// Each derivative is the derivative of the previous one: along the motion in flight, at rest,
/// under loads, and for closed forms.
#[test]
fn second_method_output_derivatives_of_all_outputs() {
    const STEP: f64 = 1e-3;
    // Central differences are off by a sixth of the square of the step times the third derivative.
    const SAME: f64 = 3e-5;
    let names = continuous_outputs();
    assert!(names.len() > 10 && names.contains(&"coupling.f"), "{names:?}");
    let loads: &[(&str, f64)] = &[("box.f", 0.1), ("block.f", -0.05), ("secondary.f", 0.2)];
    let flight = [CONTACTS[0], loads].concat();
    for start in [&flight, CONTACTS[1], CONTACTS[2], &[("mode", 2.0)], &[("mode", 3.0)]] {
        let fmu = Fmu::started(FF, start);
        fmu.step(0.0, 0.1);
        let read = |time: f64| {
            fmu.step(time, STEP);
            names.iter().map(|name| output_derivatives(&fmu, name)).collect::<Vec<_>>()
        };
        let rows = [read(0.1), read(0.1 + STEP), read(0.1 + 2.0 * STEP)];
        for (i, name) in names.iter().enumerate() {
            for order in 0..3 {
                let difference = (rows[2][i][order] - rows[0][i][order]) / (2.0 * STEP);
                let exact = rows[1][i][order + 1];
                assert!(
                    (exact - difference).abs() <= SAME * (1.0 + exact.abs()),
                    "{name} {}: {exact} {difference} from {start:?}",
                    order + 1
                );
            }
        }
        assert_eq!(fmu.get("impacts.upper") + fmu.get("impacts.lower"), 0.0, "a smooth piece");
    }
}

/// Left-sided derivatives before the event, right-sided ones in Event Mode.
#[test]
fn output_derivatives_on_both_sides_of_an_impact() {
    let fmu = Fmu::started(TT, &[("block.s", 0.9), ("block.v", 0.5)]);
    fmu.step(0.0, 50.0);
    let left = output_derivatives(&fmu, "box.s");
    assert_eq!(left[1], fmu.get("box.v"));
    fmu.enter_event_mode();
    let right = output_derivatives(&fmu, "box.s");
    assert_eq!(right[1], fmu.get("box.v"));
    assert!((left[1] - right[1]).abs() > 1e-3);
    for (name, order) in [("box.s", 0), ("box.s", 4), ("impacts.lastTime", 1), ("box.f", 1)] {
        let other = Fmu::started(FF, &[]);
        // SAFETY: one of each.
        let got = unsafe { fmi3GetOutputDerivatives(other.c, &vr(name), 1, &order, &mut 0.0, 1) };
        assert_eq!(got, ERROR, "{name} {order}: {}", other.last());
    }
}
