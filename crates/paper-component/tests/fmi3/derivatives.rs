//! Partial derivatives (FMI 3.0.2, 2.2.12).

use super::host::*;
use vibro_paper_component::fmi3::abi::*;

const RATES: [&str; 6] =
    ["der(box.s)", "der(block.s)", "der(secondary.s)", "box.a", "block.a", "secondary.a"];
const OUTPUTS: [&str; 6] =
    ["stop.s", "stop.v", "stop.force", "coupling.f", "energy.mechanical", "energy.input"];
pub const INPUTS: [&str; 3] = ["box.f", "block.f", "secondary.f"];
const TUNABLE: [&str; 9] = [
    "box.k",
    "box.c",
    "secondary.k",
    "secondary.c",
    "coupling.k",
    "stop.restitution",
    "drive.amplitude",
    "drive.frequency",
    "drive.phase",
];

fn unknowns() -> Vec<&'static str> {
    RATES.into_iter().chain(OUTPUTS).collect()
}

fn knowns() -> Vec<&'static str> {
    MOTION.into_iter().chain(INPUTS).chain(TUNABLE).chain(["time"]).collect()
}

fn references(names: &[&str]) -> Vec<u32> {
    names.iter().map(|name| vr(name)).collect()
}

/// The directional derivative.
pub fn forward(fmu: &Fmu, unknowns: &[&str], knowns: &[&str], seed: &[f64]) -> Vec<f64> {
    let (u, k, mut y) = (references(unknowns), references(knowns), vec![f64::NAN; unknowns.len()]);
    // SAFETY: the stated numbers of elements.
    let status = unsafe {
        fmi3GetDirectionalDerivative(
            fmu.c,
            u.as_ptr(),
            u.len(),
            k.as_ptr(),
            k.len(),
            seed.as_ptr(),
            seed.len(),
            y.as_mut_ptr(),
            y.len(),
        )
    };
    assert_eq!(status, OK, "{}", fmu.last());
    y
}

/// The adjoint derivative.
fn backward(fmu: &Fmu, unknowns: &[&str], knowns: &[&str], seed: &[f64]) -> Vec<f64> {
    let (u, k, mut x) = (references(unknowns), references(knowns), vec![f64::NAN; knowns.len()]);
    // SAFETY: the stated numbers of elements.
    let status = unsafe {
        fmi3GetAdjointDerivative(
            fmu.c,
            u.as_ptr(),
            u.len(),
            k.as_ptr(),
            k.len(),
            seed.as_ptr(),
            seed.len(),
            x.as_mut_ptr(),
            x.len(),
        )
    };
    assert_eq!(status, OK, "{}", fmu.last());
    x
}

/// Column of a known.
fn column(fmu: &Fmu, known: &str) -> Vec<f64> {
    forward(fmu, &unknowns(), &[known], &[1.0])
}

/// Starts in flight and at rest at either stop.
pub const CONTACTS: [&[(&str, f64)]; 3] = [
    &[
        ("box.s", 0.1),
        ("block.s", 0.4),
        ("secondary.s", -0.2),
        ("box.v", 0.3),
        ("block.v", -0.6),
        ("secondary.v", 0.7),
    ],
    &[
        ("box.s", 0.1),
        ("block.s", 1.1),
        ("secondary.s", -0.2),
        ("box.v", 0.3),
        ("block.v", 0.3),
        ("block.f", 5.0),
    ],
    &[
        ("box.s", 0.1),
        ("block.s", -0.9),
        ("secondary.s", 0.2),
        ("box.v", 0.3),
        ("block.v", 0.3),
        ("block.f", -5.0),
    ],
];

pub fn in_event_mode(start: &[(&str, f64)], exchange: bool) -> Fmu {
    let fmu = if exchange { Fmu::exchange() } else { Fmu::new(TT) };
    for (name, value) in start.iter().chain(&[("drive.phase", 0.7), ("secondary.f", 0.3)]) {
        assert_eq!(fmu.set(name, *value), OK);
    }
    fmu.initialize();
    fmu.update();
    fmu
}

/// All except the drive is linear or quadratic in the varied values, so a small step leaves only
/// rounding.
const DIFFERENCE: f64 = 1e-7;

fn assert_column(name: &str, exact: &[f64], differences: &[f64]) {
    for ((unknown, a), b) in unknowns().iter().zip(exact).zip(differences) {
        assert!((a - b).abs() <= DIFFERENCE * (1.0 + a.abs()), "d {unknown} / d {name}: {a} {b}");
    }
}

/// Inputs and tunable parameters, set in Event Mode, where getters see them; in both interface
/// types and all contacts.
#[test]
fn second_method_inputs_and_parameters_by_differences() {
    const STEP: f64 = 1e-4;
    for start in CONTACTS {
        for exchange in [true, false] {
            let fmu = in_event_mode(start, exchange);
            for name in INPUTS.into_iter().chain(TUNABLE) {
                let exact = column(&fmu, name);
                let value = fmu.get(name);
                let at = |shift: f64| {
                    assert_eq!(fmu.set(name, value + shift), OK, "{name}: {}", fmu.last());
                    unknowns().iter().map(|unknown| fmu.get(unknown)).collect::<Vec<f64>>()
                };
                let (high, low) = (at(STEP), at(-STEP));
                at(0.0);
                let mut differences: Vec<f64> =
                    high.iter().zip(&low).map(|(a, b)| (a - b) / (2.0 * STEP)).collect();
                if name.starts_with("drive.f") || name == "drive.phase" {
                    // They change the drive's phase; energies accumulated before are the same.
                    differences.truncate(unknowns().len());
                }
                assert_column(name, &exact, &differences);
            }
        }
    }
}

/// States and time, between events of a host's solver.
#[test]
fn second_method_states_and_time_by_differences() {
    const STEP: f64 = 1e-4;
    for start in CONTACTS {
        let fmu = in_event_mode(start, true);
        // SAFETY: a live instance; six elements.
        let (time, states) = unsafe {
            assert_eq!(fmi3EnterContinuousTimeMode(fmu.c), OK);
            let mut x = [0.0; 6];
            assert_eq!(fmi3GetContinuousStates(fmu.c, x.as_mut_ptr(), 6), OK);
            (0.05, x)
        };
        let at = |time: f64, states: &[f64; 6]| {
            // SAFETY: as above.
            unsafe {
                assert_eq!(fmi3SetTime(fmu.c, time), OK);
                assert_eq!(fmi3SetContinuousStates(fmu.c, states.as_ptr(), 6), OK);
            }
            unknowns().iter().map(|unknown| fmu.get(unknown)).collect::<Vec<f64>>()
        };
        let difference = |high: Vec<f64>, low: Vec<f64>| -> Vec<f64> {
            high.iter().zip(&low).map(|(a, b)| (a - b) / (2.0 * STEP)).collect()
        };
        at(time, &states);
        let exact = column(&fmu, "time");
        assert_column("time", &exact, &difference(at(time + STEP, &states), at(time - STEP, &states)));
        for (i, name) in MOTION.iter().enumerate() {
            at(time, &states);
            let exact = column(&fmu, name);
            let [high, low] = [STEP, -STEP].map(|shift| {
                let mut there = states;
                there[i] += shift;
                at(time, &there)
            });
            let (mut exact, mut differences) = (exact, difference(high, low));
            if fmu.get("stop.state") != 1.0 {
                // At rest the solver's states may leave the stop by its errors; the stop is shown.
                (exact[6], differences[6]) = (0.0, 0.0);
            }
            assert_column(name, &exact, &differences);
        }
    }
}

/// ⟨w, J v⟩ = ⟨Jᵀ w, v⟩, and the rows of one are the columns of the other.
#[test]
fn invariant_adjoint_identity() {
    const ROUNDING: f64 = 1e-14;
    let mut seed = 1_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    for (start, exchange) in CONTACTS.into_iter().flat_map(|start| [(start, true), (start, false)]) {
        let fmu = in_event_mode(start, exchange);
        let (u, k) = (unknowns(), knowns());
        for _ in 0..20 {
            let v: Vec<f64> = k.iter().map(|_| random()).collect();
            let w: Vec<f64> = u.iter().map(|_| random()).collect();
            let (y, x) = (forward(&fmu, &u, &k, &v), backward(&fmu, &u, &k, &w));
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let size: f64 = y.iter().chain(&x).map(|x| x.abs()).sum();
            assert!((dot(&w, &y) - dot(&x, &v)).abs() <= ROUNDING * (1.0 + size));
        }
        for (i, unknown) in u.iter().enumerate() {
            let row = backward(&fmu, &[unknown], &k, &[1.0]);
            for (known, entry) in k.iter().zip(row) {
                assert_eq!(entry, column(&fmu, known)[i], "{unknown} {known}");
            }
        }
    }
}

/// If a seed or a sum is not finite, or a wrong known follows a right one, nothing is written.
#[test]
fn adjoint_derivatives_that_are_no_finite_numbers_are_refused_by_name() {
    const UNTOUCHED: [f64; 2] = [7.0; 2];
    const TWO: [&str; 2] = ["box.a", "block.a"];
    let fmu = in_event_mode(CONTACTS[0], false);
    for (unknowns, known, seed, expected, text) in [
        (TWO, "block.f", [f64::NAN, 0.0], DISCARD, "seed of box.a = NaN: expected a finite number"),
        (TWO, "block.f", [0.0, f64::INFINITY], DISCARD, "seed of block.a = inf: expected a finite number"),
        (["box.a"; 2], "box.f", [f64::MAX; 2], DISCARD, "adjoint derivative by box.f = inf: expected"),
        (TWO, "stop.gap", [1.0; 2], ERROR, "stop.gap has no such derivative"),
    ] {
        let state = fmu.save();
        let (u, k, mut sums) = (references(&unknowns), references(&["secondary.f", known]), UNTOUCHED);
        // SAFETY: two elements each.
        let status = unsafe {
            fmi3GetAdjointDerivative(
                fmu.c,
                u.as_ptr(),
                2,
                k.as_ptr(),
                2,
                seed.as_ptr(),
                2,
                sums.as_mut_ptr(),
                2,
            )
        };
        assert_eq!((status, sums), (expected, UNTOUCHED), "{}", fmu.last());
        assert!(fmu.last().contains(text), "{}", fmu.last());
        // SAFETY: a state of this instance.
        assert_eq!(unsafe { fmi3SetFMUState(fmu.c, state) }, OK);
    }
}

/// Derivatives of a closed form: parameters by differences of another order, time by the motion
/// itself.
#[test]
fn second_method_of_a_closed_form() {
    const SAME: f64 = 1e-6;
    let fmu = Fmu::started(TT, &[("mode", 3.0)]);
    fmu.step(0.0, 1.0);
    for name in ["drive.amplitude", "box.c", "stop.restitution"] {
        fmu.enter_event_mode();
        let exact = column(&fmu, name);
        let (value, step) = (fmu.get(name), 1e-4 * fmu.get(name));
        let at = |shift: f64| {
            assert_eq!(fmu.set(name, value + shift), OK);
            ["box.a", "block.a", "secondary.a", "stop.s"].map(|unknown| fmu.get(unknown))
        };
        let (high, low) = (at(step), at(-step));
        at(0.0);
        for (i, exact) in exact[3..7].iter().enumerate() {
            let difference = (high[i] - low[i]) / (2.0 * step);
            assert!(
                (exact - difference).abs() <= SAME * (1.0 + exact.abs()),
                "{name} {i}: {exact} {difference}"
            );
        }
        fmu.update();
        fmu.enter_step_mode();
    }
    let exact = column(&fmu, "time");
    assert!((exact[0] - fmu.get("box.a")).abs() < 1e-12, "der(box.s) follows time alone");
    assert_eq!(column(&fmu, "box.f"), vec![0.0; unknowns().len()]);
}

#[test]
fn what_is_no_unknown_or_known_is_an_error() {
    for (unknown, known) in
        [("box.m", "box.f"), ("stop.indicator.rest", "box.f"), ("box.a", "box.m"), ("box.a", "box.a")]
    {
        let fmu = in_event_mode(CONTACTS[0], true);
        let mut y = 0.0;
        // SAFETY: one of each.
        let status = unsafe {
            fmi3GetDirectionalDerivative(fmu.c, &vr(unknown), 1, &vr(known), 1, &1.0, 1, &mut y, 1)
        };
        assert_eq!(status, ERROR, "{unknown} {known}");
        assert!(fmu.last().contains("has no such derivative"), "{}", fmu.last());
    }
    let fmu = in_event_mode(CONTACTS[0], true);
    // SAFETY: one of each.
    let status = unsafe {
        fmi3GetDirectionalDerivative(fmu.c, &vr("box.a"), 1, &vr("box.f"), 1, &f64::NAN, 1, &mut 0.0, 1)
    };
    assert_eq!(status, DISCARD, "a value that cannot be");
}

/// In initialization: the unknowns there, by differences of the shown values.
#[test]
fn second_method_in_initialization() {
    const STEP: f64 = 1e-5; // a mass of 0.1 enters by its inverse
    let fmu = Fmu::exchange();
    // SAFETY: a live instance.
    assert_eq!(unsafe { fmi3EnterInitializationMode(fmu.c, 0, 0.0, 0.0, 0, 0.0) }, OK);
    assert_eq!(fmu.set("block.s", 0.3), OK);
    for name in ["block.s", "box.v", "box.f", "box.k", "block.m", "coupling.k"] {
        let exact = forward(&fmu, &["box.a", "block.a", "coupling.f"], &[name], &[1.0]);
        let value = fmu.get(name);
        let at = |shift: f64| {
            assert_eq!(fmu.set(name, value + shift), OK);
            ["box.a", "block.a", "coupling.f"].map(|unknown| fmu.get(unknown))
        };
        let (high, low) = (at(STEP), at(-STEP));
        at(0.0);
        for (i, exact) in exact.iter().enumerate() {
            let difference = (high[i] - low[i]) / (2.0 * STEP);
            assert!(
                (exact - difference).abs() <= DIFFERENCE * (1.0 + exact.abs()),
                "{name}: {exact} {difference}"
            );
        }
    }
}
