//! Drive work in closed form against the Gramians; the Gramians against a quadrature in time.

use super::*;
use crate::model::Model;
use crate::parameters::{Groups, Scales};

/// Tolerance: rounding of sums of some dozens of terms.
const ROUNDING: f64 = 1e-14;

fn basic() -> Parameters {
    Groups::weak(0.1, 0.75, 1.5, 0.3, 0.4, 0.2, 0.1, 0.4).to_parameters(Scales::default()).unwrap()
}

fn systems() -> Vec<Parameters> {
    let p = basic();
    vec![
        p,
        Parameters { box_damping: 0.0, ..p },
        Parameters { box_stiffness: 0.0, ..p },
        Parameters { box_stiffness: 0.0, box_damping: 0.0, coupling_stiffness: 0.0, ..p },
        Parameters { drive_frequency: 1e-3, ..p },
        Parameters { drive_frequency: 300.0, ..p },
        Parameters { box_damping: 40.0, ..p },
        Parameters { drive_amplitude: 0.0, ..p },
    ]
}

fn states() -> [Augmented; 3] {
    let at = |angle: f64, y: [f64; 6]| {
        let [a, b, c, d, e, f] = y;
        [a, b, c, d, e, f, angle.cos(), angle.sin()]
    };
    [
        at(0.0, [0.0, 0.9, 0.0, 0.0, 0.5, 0.0]),
        at(2.0, [0.4, -0.3, 0.2, -1.1, 0.7, 0.9]),
        at(-1.2, [-1.3, 0.1, -0.6, 0.2, -0.4, 0.1]),
    ]
}

fn tables(p: &Parameters, mode: SmoothMode) -> (Model, f64, SubstepTable<CORE>, Gramians) {
    let model = Model::new(p).unwrap();
    let h = crate::flow::substep(&model);
    let mut core = SubstepTable::<CORE>::zero();
    core.fill(pulp::Scalar, &model, mode, h);
    let mut energy = Gramians::zero();
    energy.set_powers(p, &model, mode);
    energy.work = None; // fills both parts
    energy.fill(&core, &model, mode, h);
    (model, h, core, energy)
}

/// The error of a rule on [0, 1] is e/n! times the n-th derivative of the power, where n is the
/// first degree that the rule does not integrate and e its error for uⁿ. Along a motion of size 1
/// the k-th derivative of a rate is at most max(1, k) rᵏ⁺¹. So the n-th derivative of its square
/// is at most Σ C(n, k) max(1, k) max(1, n-k) rⁿ⁺², and that of the drive's power at most Σ C(n,
/// k) max(1, k) rⁿ⁺¹.
#[test]
fn closed_form_errors_of_the_rules() {
    const LOBATTO: f64 = 0.276_393_202_250_021;
    let lobatto = Rule {
        nodes: [0.0, LOBATTO, 1.0 - LOBATTO, 1.0],
        weights: [1.0 / 12.0, 5.0 / 12.0, 5.0 / 12.0, 1.0 / 12.0],
    };
    fn error<const N: usize>(rule: &Rule<N>, degree: i32) -> f64 {
        let sum: f64 = rule.nodes.iter().zip(&rule.weights).map(|(u, weight)| weight * u.powi(degree)).sum();
        (sum - 1.0 / f64::from(degree + 1)).abs()
    }
    let bound = |e: f64, n: i32, reach: f64| {
        let (mut choose, mut factorial, mut squares, mut products) = (1.0, 1.0, 0.0, 0.0);
        for k in 0..=n {
            let (own, other) = (f64::from(k.max(1)), f64::from((n - k).max(1)));
            squares += choose * own * other;
            products += choose * own;
            choose *= f64::from(n - k) / f64::from(k + 1);
            factorial *= own;
        }
        [squares, products].map(|derivative| e / factorial * derivative * reach.powi(n))
    };
    for degree in 0..10 {
        assert!(error(&FIVE, degree) < ROUNDING, "{degree}");
        assert!(degree > 7 || error(&FOUR, degree) < ROUNDING, "{degree}");
        assert!(degree > 5 || error(&lobatto, degree) < ROUNDING, "{degree}");
    }
    // Bounds of the table in docs/numerics.md, section 4.
    let [five, half] = [0.15, 0.075].map(|reach| bound(error(&FIVE, 10), 10, reach)[0]);
    assert!(five < 6e-17 && half < 1e-19, "{five:e} {half:e}");
    let [damped, driven] = bound(error(&FOUR, 8), 8, 0.075);
    assert!(damped < 3e-15 && driven < damped, "{damped:e} {driven:e}");
    let [last, _] = bound(error(&lobatto, 6), 6, 0.075);
    assert!(last < 7e-11, "{last:e}");
}

#[test]
fn second_method_drive_work_in_closed_form_and_by_quadrature() {
    for p in systems() {
        let (model, h, core, energy) = tables(&p, SmoothMode::Flight);
        let work = DriveWork::new(p.drive_amplitude, &model).expect("not at an undamped resonance");
        for z in states() {
            let mut end = [0.0; COORDINATES];
            SubstepTable::transit(&core.full, &z, &mut end);
            let found = work.value(&end) - work.value(&z) + work.mean() * h;
            let expected = energy.input_up_to(pulp::Scalar, INTERVALS, &z);
            let size = work.value(&end).abs() + work.value(&z).abs() + expected.abs();
            assert!((found - expected).abs() <= ROUNDING * size, "{found:e} {expected:e} of {size:e}, {p:?}");
            let mut struck = end;
            struck[3] += 0.7;
            let jump = work.jump(&end, 0.7);
            assert!((work.value(&struck) - work.value(&end) - jump).abs() <= ROUNDING * (size + jump.abs()));
        }
    }
}

#[test]
fn second_method_gramians_and_a_plain_quadrature() {
    /// Pieces of the quadrature in time; with so many, it differs from the Gramians by rounding.
    const PIECES: usize = 64;
    for mode in [SmoothMode::Flight, SmoothMode::Rest] {
        for p in systems() {
            let (model, h, _, energy) = tables(&p, mode);
            for z in states() {
                // To the centre of interval 5 and to the end.
                for (index, span) in [(5, h * 5.5 / 16.0), (INTERVALS, h)] {
                    let (mut input, mut damped, mut passed) = (0.0, 0.0, 0.0);
                    let series = Series::<30>::expand(&model, mode, &z, None, span);
                    for piece in 0..PIECES {
                        for (node, weight) in FIVE.nodes.iter().zip(&FIVE.weights) {
                            let at = series.at((piece as f64 + node) / PIECES as f64);
                            let weight = weight * span / PIECES as f64;
                            input += weight * p.drive_amplitude * at[7] * at[3];
                            damped += weight
                                * (p.box_damping * at[3] * at[3] + p.secondary_damping * at[5] * at[5]);
                            passed += weight * (p.drive_amplitude * at[7] * at[3]).abs();
                        }
                    }
                    let (i, d) = (
                        energy.input_up_to(pulp::Scalar, index, &z),
                        energy.damped_up_to(pulp::Scalar, index, &z),
                    );
                    /// Tolerance: rounding of sums of large entries of either sign, with drives of
                    /// up to 300 times the natural frequency.
                    const CANCELLATION: f64 = 1e-13;
                    let size = passed + damped;
                    assert!((i - input).abs() <= CANCELLATION * size, "input {i:e} {input:e} {mode:?} {p:?}");
                    assert!(
                        (d - damped).abs() <= CANCELLATION * size,
                        "damped {d:e} {damped:e} {mode:?} {p:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn closed_form_no_drive_work_by_differences_at_an_undamped_resonance() {
    let p = basic();
    let omega = (p.box_stiffness / p.box_mass).sqrt();
    let at = |damping: f64, detuning: f64| {
        let p = Parameters { box_damping: damping, drive_frequency: omega * (1.0 + detuning), ..p };
        DriveWork::new(p.drive_amplitude, &Model::new(&p).unwrap())
    };
    assert_eq!(at(0.0, 0.0), None);
    assert_eq!(at(1e-9, 1e-12), None);
    assert!(at(0.0, 0.01).is_some() && at(0.01, 0.0).is_some());
}
