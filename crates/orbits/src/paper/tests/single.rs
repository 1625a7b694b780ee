//! One orbit against the closed form, differences, the identity of the determinants, and the
//! simulator.

use crate::paper::cycle::{Cycle, Functional};
use crate::paper::orbit::unfolded_phases;
use crate::paper::system::Anchor;
use crate::paper::{Orbit, OrbitWord, System};
use nalgebra::{DMatrix, Matrix6};
use std::f64::consts::PI;
use vibro_impact::parameters::{Groups, Parameters, Scales};
use vibro_impact::steady::exact_orbit::{self, Vector6};
use vibro_impact::{Simulator, State};

/// Tolerance for Newton's method against the closed form: rounding of a flight times the orbit's
/// sensitivity.
const CLOSED_FORM: f64 = 1e-13;

fn parameters(f10: f64) -> Parameters {
    Groups { f10, ..Groups::basic() }.to_parameters(Scales::default()).unwrap()
}

fn word(text: &str, closing: i8, half_periods: u32) -> OrbitWord {
    OrbitWord::new(text, closing, half_periods).unwrap()
}

/// A symmetric orbit with its closed form.
fn symmetric(f10: f64) -> (Orbit, exact_orbit::ExactOrbit) {
    let p = parameters(f10);
    let exact = exact_orbit::solve(&p).unwrap().upper.unwrap();
    let guess = [exact.drive_phase() + 0.05];
    (Orbit::find(&System::new(&p).unwrap(), &word("U", -1, 1), &guess).unwrap(), exact)
}

/// Largest difference of two states, in units where L = 1 and ω1 is about 1.
fn apart(a: &State, b: &State) -> f64 {
    let pairs = a.x.iter().chain(&a.v).zip(b.x.iter().chain(&b.v));
    pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
}

#[test]
fn closed_form_of_the_symmetric_orbit() {
    for f10 in [1.0, 1.5, 2.0, 3.0, 4.5] {
        let (orbit, exact) = symmetric(f10);
        assert!((orbit.phases()[0] - exact.drive_phase()).abs() < CLOSED_FORM, "f10 = {f10}");
        assert_eq!(
            (orbit.is_certified(), orbit.is_stable()),
            (exact.is_clear(), exact.spectral_radius() < 1.0)
        );
        for (own, closed) in orbit.multipliers().iter().zip(exact.multipliers()) {
            assert!((own - closed).norm() < 10.0 * CLOSED_FORM, "{own} {closed}");
        }
        for theta in [0.0, 1.0, 2.5, 4.0, 6.0] {
            assert!(apart(&orbit.state(theta), &exact.state(theta)) < CLOSED_FORM);
        }
        let tops = orbit.maxima([0.0, 1.0, 0.0]).into_iter().fold(0.0, f64::max);
        assert!((tops - exact.amplitudes()[1]).abs() < 10.0 * CLOSED_FORM);
    }
}

#[test]
fn closed_form_of_the_motion_without_impacts() {
    let system = System::new(&parameters(0.1)).unwrap();
    let orbit = Orbit::find(&system, &word("", -1, 1), &[]).unwrap();
    assert!(orbit.is_certified() && orbit.is_stable());
    // The box oscillates alone.
    let p = system.parameters();
    let w = p.drive_frequency;
    let amplitude = p.drive_amplitude / (p.box_stiffness - p.box_mass * w * w).hypot(p.box_damping * w);
    assert!((orbit.maxima([1.0, 0.0, 0.0])[0] - amplitude).abs() < CLOSED_FORM);
    let mut simulator = Simulator::new(p, &orbit.start_state(), 0.0).unwrap();
    simulator.advance_to(100.0 * p.period()).unwrap();
    assert!(apart(&simulator.state(), &orbit.start_state()) < CLOSED_FORM);
    // The product of the multipliers is the determinant of exp(π A): the trace of A is minus the
    // damping.
    let product: nalgebra::Complex<f64> = orbit.multipliers().iter().product();
    let divergence = (p.box_damping / p.box_mass + p.secondary_damping / p.secondary_mass) / w;
    assert!((product.re - (-std::f64::consts::PI * divergence).exp()).abs() < CLOSED_FORM);
}

/// Whole turns of the drive's phase at time 0 change nothing, even many turns.
#[test]
fn invariant_turns_of_the_drives_phase_leave_the_settled_orbit() {
    /// Tolerance for a phase of 1e9, rad.
    const KNOWN: f64 = 1e-6;
    const MANY: f64 = 1e9;
    let settled = |drive_phase: f64| {
        let p = Parameters { drive_phase, ..parameters(2.0) };
        let system = System::new(&p).unwrap();
        let start = vibro_studies::paper::stroboscopic::moving_block(&p);
        crate::paper::orbit_of(&system, &crate::paper::settle(&system, &start, 500).unwrap()).unwrap()
    };
    let (turned, same) = (settled(MANY), settled(MANY.sin().atan2(MANY.cos())));
    assert!(turned.is_same(&same, KNOWN), "{:?} {:?}", turned.phases(), same.phases());
    // The orbit's start is where the simulator begins.
    let (start, begin) = (turned.start_state(), turned.state(MANY.sin().atan2(MANY.cos())));
    assert!((start.x[1] - begin.x[1]).abs() < CLOSED_FORM, "{start:?} {begin:?}");
}

/// Contact determines the position of one of two free bodies; the error names the spring of the
/// other one.
#[test]
fn a_body_that_no_spring_holds_is_named() {
    for (field, stiffness) in [("box.k", 1e-18), ("secondary.k", 0.0)] {
        let mut p = Parameters { coupling_stiffness: 0.0, ..parameters(2.0) };
        *(if field == "box.k" { &mut p.box_stiffness } else { &mut p.secondary_stiffness }) = stiffness;
        let error = Orbit::find(&System::new(&p).unwrap(), &word("UL", 1, 2), &[1.0, 4.1]).unwrap_err();
        assert!(error.to_string().starts_with(&format!("{field} = {stiffness}")), "{error}");
    }
}

/// A machine under constant loads.
pub(super) fn under(p: &Parameters, constant_loads: [f64; 3]) -> vibro_studies::Result<System> {
    System::new(&Parameters { constant_loads, ..*p })
}

#[test]
fn second_method_jacobian_by_differences() {
    /// Step of central differences, whose error is its square.
    const STEP: f64 = 1e-5;
    const TOLERANCE: f64 = 1e-8;
    let free = Parameters { coupling_stiffness: 0.0, ..parameters(2.2) };
    let box_free = Parameters { box_stiffness: 0.0, ..parameters(2.2) };
    let pair_free = Parameters { secondary_stiffness: 0.0, ..parameters(2.2) };
    let systems = [parameters(2.2), free, box_free, pair_free].map(|p| System::new(&p).unwrap());
    let words = [
        (word("U", -1, 1), vec![5.6]),
        (word("ULL", 1, 2), vec![0.4, 3.0, 4.6]),
        (word("UUL", -1, 3), vec![0.4, 3.0, 6.6]),
        (word("ULULL", 1, 4), vec![0.4, 3.0, 6.6, 9.9, 11.0]),
    ];
    let falling = under(&free, [0.01, -0.02, 0.003]).unwrap();
    let all = words.iter().flat_map(|case| systems.iter().map(move |system| (*system, case)));
    // One case with a block that falls.
    let more = words[1..2].iter().map(|case| (falling, case));
    for (system, (word, phases)) in all.chain(more) {
        let cycle = Cycle::new(&system, word, phases).unwrap();
        for functional in [Functional::Gap, Functional::Rate] {
            let exact = cycle.derivative(functional, 1.0).unwrap();
            let values = |phases: &[f64]| {
                let cycle = Cycle::new(&system, word, phases).unwrap();
                if functional == Functional::Gap { cycle.residual } else { cycle.rates }
            };
            for k in 0..phases.len() {
                let moved = |by: f64| {
                    let mut phases = phases.clone();
                    phases[k] += by;
                    values(&phases)
                };
                for (i, (a, b)) in moved(STEP).iter().zip(moved(-STEP)).enumerate() {
                    let difference = (a - b) / (2.0 * STEP);
                    assert!((difference - exact[(i, k)]).abs() < TOLERANCE, "{word} {functional:?} {i} {k}");
                }
            }
        }
    }
}

/// An asymmetric orbit, from the symmetric one at another force.
fn unequal() -> Orbit {
    // Between the symmetry breaking at 2.0396 and its end.
    let (orbit, _) = symmetric(2.1);
    let mut phases = unfolded_phases(orbit.word(), orbit.phases());
    (phases[0], phases[1]) = (phases[0] + 0.15, phases[1] - 0.15);
    let found = Orbit::find(orbit.system(), &orbit.word().unfolded(), &phases).unwrap();
    assert!((found.phases()[1] - found.phases()[0] - std::f64::consts::PI).abs() > 0.01);
    found
}

#[test]
fn invariant_determinants_of_the_monodromy_and_of_the_residual() {
    /// Relative tolerance for determinants with a few factors of order one.
    const TOLERANCE: f64 = 1e-11;
    let with_spring = [symmetric(1.5).0, symmetric(3.0).0, unequal(), unequal().unfolded().unwrap()];
    let anchored = [Anchor::Box, Anchor::Block, Anchor::Pair].into_iter().flat_map(|anchor| {
        with_spring.iter().map(move |orbit| (orbit.system().anchored(Some(anchor)), orbit.clone()))
    });
    let free = [(&[0.0][..], -1), (&[0.0, std::f64::consts::PI], 1)].map(|(turns, closing)| {
        let p = Parameters { coupling_stiffness: 0.0, ..parameters(1.5) };
        let first = exact_orbit::solve(&p).unwrap().upper.unwrap().drive_phase();
        let text = if closing < 0 { "U" } else { "UL" };
        let guess: Vec<f64> = turns.iter().map(|turn| first + turn).collect();
        let system = System::new(&p).unwrap();
        (system, Orbit::find(&system, &word(text, closing, turns.len() as u32), &guess).unwrap())
    });
    let plain = with_spring.iter().map(|orbit| (*orbit.system(), orbit.clone()));
    for (system, orbit) in plain.chain(anchored).chain(free) {
        let cycle = Cycle::new(&system, orbit.word(), orbit.phases()).unwrap();
        let (sigma, speeds) = (f64::from(orbit.word().closing()), cycle.rates.iter().product::<f64>());
        for factor in [1.0, -1.0] {
            let sign = if orbit.word().len() % 2 == 1 { factor } else { -factor };
            let left = (cycle.monodromy() - Matrix6::identity() * factor).determinant() * speeds;
            let closed = if system.anchor().is_some() {
                cycle.anchor(factor)
            } else {
                (Matrix6::identity() * (factor * sigma) - cycle.map()).determinant()
            };
            let right = sign * cycle.derivative(Functional::Gap, factor).unwrap().determinant() * closed;
            assert!(
                (left - right).abs() < TOLERANCE * left.abs().max(1e-3),
                "{} {factor}: {left} {right}",
                orbit.word()
            );
        }
        // For a real factor the complex derivative is the real one.
        let real: DMatrix<f64> = cycle.derivative(Functional::Gap, -1.0).unwrap();
        let complex = cycle.complex_derivative(nalgebra::Complex::new(-1.0, 0.0)).unwrap();
        assert!(complex.iter().zip(real.iter()).all(|(a, b)| (a - b).norm() < TOLERANCE));
    }
}

#[test]
fn invariant_an_unfolded_orbit_is_the_same_orbit() {
    for orbit in [symmetric(1.5).0, unequal()] {
        let unfolded = orbit.unfolded().unwrap();
        assert!(unfolded.is_certified() == orbit.is_certified());
        for theta in [0.3, 2.0, 5.0, 7.0, 11.0] {
            assert!(apart(&orbit.state(theta), &unfolded.state(theta)) < CLOSED_FORM);
        }
        let square = orbit.multipliers()[0] * orbit.multipliers()[0];
        assert!((unfolded.spectral_radius() - square.norm()).abs() < 1e-10);
        assert!(unfolded.is_same(&unfolded.clone(), 1e-9) && !unfolded.is_same(&orbit, 1e-9));
    }
}

/// The simulator's map over an orbit's period from mid-flight, by central differences.
pub(super) fn simulated_map(orbit: &Orbit, theta: f64) -> Matrix6<f64> {
    const STEP: f64 = 1e-5;
    let p = orbit.system().parameters();
    let start = orbit.state(theta);
    let time = (theta - p.drive_phase) / p.drive_frequency;
    let end = |state: &State| {
        let mut simulator = Simulator::new(p, state, time).unwrap();
        simulator.set_loads(&orbit.system().loads().loads()).unwrap();
        simulator.advance_to(time + f64::from(orbit.word().period()) * p.period()).unwrap();
        let end = simulator.state();
        Vector6::from_iterator(end.x.into_iter().chain(end.v))
    };
    Matrix6::from_columns(&[0, 1, 2, 3, 4, 5].map(|i| {
        let moved = |by: f64| {
            let mut state = start;
            if i < 3 {
                state.x[i] += by
            } else {
                state.v[i - 3] += by
            }
            end(&state)
        };
        (moved(STEP) - moved(-STEP)) / (2.0 * STEP)
    }))
}

#[test]
fn second_method_multipliers_by_differences_of_the_simulator() {
    /// Tolerance for central differences with a step of 1e-5.
    const TOLERANCE: f64 = 1e-8;
    for orbit in [symmetric(1.5).0.unfolded().unwrap(), unequal()] {
        // From mid-flight, where no perturbed motion has passed an impact.
        let phases = orbit.phases();
        let map = simulated_map(&orbit, 0.5 * (phases[0] + phases[1]));
        let mut found: Vec<f64> = map.complex_eigenvalues().iter().map(|m| m.norm()).collect();
        found.sort_by(|a, b| b.total_cmp(a));
        for (simulated, own) in found.iter().zip(orbit.multipliers()) {
            assert!((simulated - own.norm()).abs() < TOLERANCE, "{simulated} {own}");
        }
    }
}

#[test]
fn second_method_orbits_return_in_the_simulator() {
    /// Tolerance for the rounding of one period times multipliers of a few units.
    const ROUNDING: f64 = 1e-12;
    for orbit in [symmetric(1.5).0, symmetric(3.0).0, unequal()] {
        let p = orbit.system().parameters();
        let start = orbit.start_state();
        let mut simulator = Simulator::new(p, &start, 0.0).unwrap();
        simulator.advance_to(f64::from(orbit.word().period()) * p.period()).unwrap();
        assert!(apart(&simulator.state(), &start) < ROUNDING, "{}", orbit.word());
    }
}

#[test]
fn second_method_orbit_under_constant_loads() {
    /// Tolerance for the remaining difference after hundreds of periods: rounding, since the orbit
    /// is stable.
    const ROUNDING: f64 = 1e-11;
    let forces = [0.004, -0.0005, 0.0003];
    let p = parameters(1.5);
    let system = under(&p, forces).unwrap();
    let (symmetric, _) = symmetric(1.5);
    let guess = unfolded_phases(symmetric.word(), symmetric.phases());
    let orbit = Orbit::find(&system, &word("UL", 1, 2), &guess).unwrap();
    assert!(orbit.is_certified() && orbit.is_stable());
    let mut simulator = Simulator::new(&p, &orbit.start_state(), 0.0).unwrap();
    simulator.set_loads(&system.loads().loads()).unwrap();
    simulator.advance_to(6000.0 * p.period()).unwrap();
    assert!(apart(&simulator.state(), &orbit.start_state()) < ROUNDING);
    // Loads with the same offset cause the same impacts; the opposite offset, their mirror image.
    let offset = system.offset();
    let boxed = under(&p, [-offset * p.box_stiffness, 0.0, 0.0]).unwrap();
    let same = Orbit::find(&boxed, orbit.word(), orbit.phases()).unwrap();
    assert!((same.phases()[0] - orbit.phases()[0]).abs() < 1e-12);
    let opposite = under(&p, forces.map(|f| -f)).unwrap();
    let mirror: Vec<f64> = orbit.phases().iter().map(|phase| phase + std::f64::consts::PI).collect();
    let mirror = Orbit::find(&opposite, &word("LU", 1, 2), &mirror).unwrap();
    assert!((mirror.speeds()[0] - orbit.speeds()[0]).abs() < 1e-12);
}

#[test]
fn closed_form_of_a_gap_off_its_centre() {
    // A gap shifted by δ is a pair of loads, which displaces the block in the box by -δ.
    let (p, delta) = (parameters(1.5), 0.03);
    let pair = delta * p.coupling_stiffness;
    let system = under(&p, [0.0, -pair, pair]).unwrap();
    assert!((system.offset() + delta).abs() < 1e-15);
}

#[test]
fn singular_machines_are_refused_with_the_parameter() {
    let free = Parameters { box_stiffness: 0.0, ..parameters(1.5) };
    let error = under(&free, [0.1, 0.0, 0.0]).unwrap_err();
    assert!(error.to_string().contains("box.k"), "{error}");
    let error = under(&free, [f64::NAN, 0.0, 0.0]).unwrap_err();
    assert!(error.to_string().contains("load.box"), "{error}");
    let error = Orbit::find(&System::new(&parameters(1.5)).unwrap(), &word("UL", 1, 2), &[5.5]).unwrap_err();
    assert!(error.to_string().contains("word UL, closing +, period 1T"), "{error}");
}

/// The state at the phase of an impact is the state just after it, also for a loaded block without
/// a spring.
#[test]
fn invariant_states_at_impacts_are_those_after_them() {
    let (orbit, exact) = symmetric(1.5);
    let [phase, after] = [orbit.phases()[0], exact.drive_phase()];
    for (turn, sign) in [(0.0, 1.0), (PI, -1.0)] {
        let (state, expected) = (orbit.state(phase + turn), exact.state(after + turn));
        for i in 0..3 {
            assert!((state.x[i] - expected.x[i]).abs() < 1e-12, "{state:?} {expected:?}");
            assert!((state.v[i] - expected.v[i]).abs() < 1e-12, "{state:?} {expected:?}");
        }
        // The block has left the stop.
        assert!(sign * (state.v[1] - state.v[0]) < 0.0, "{state:?}");
    }
    let falling =
        Parameters { coupling_stiffness: 0.0, constant_loads: [0.0, -0.01, 0.0], ..parameters(1.5) };
    let system = System::new(&falling).unwrap();
    let z = Vector6::new(0.1, 0.2, 0.3, 0.4, 0.5, 0.6);
    assert_eq!(system.fly(0.0, &z), z);
}

/// With a strong damper or a stiff spring, half a period has thousands of Taylor pieces. Their
/// rounding must not be taken for an earlier contact. The orbits are certified and agree with the
/// closed form and the simulator.
#[test]
fn second_method_orbits_of_thousands_of_taylor_pieces_are_certified() {
    let p = Parameters {
        box_mass: 1.62,
        box_stiffness: 1.02,
        box_damping: 0.068,
        block_mass: 0.086,
        secondary_mass: 0.0219,
        secondary_stiffness: 0.131,
        coupling_stiffness: 0.0021,
        stop_restitution: 0.807,
        drive_amplitude: 0.192,
        drive_frequency: 0.566,
        ..Parameters::default()
    };
    let damped = (0..24).map(|k| Parameters { secondary_damping: 30.0 + 2.0 * f64::from(k), ..p });
    let stiff = (0..24).map(|k| Parameters {
        secondary_stiffness: 5e4 * (1.0 + f64::from(k)),
        secondary_damping: 0.05,
        ..p
    });
    for p in damped.chain(stiff) {
        let exact = exact_orbit::solve(&p).unwrap().upper.unwrap();
        assert!(exact.is_clear(), "{p:?}");
        let orbit =
            Orbit::find(&System::new(&p).unwrap(), &word("U", -1, 1), &[exact.drive_phase()]).unwrap();
        assert!(orbit.is_certified(), "{p:?}");
        // The simulator starts a tenth of half a period after the impact and meets the other stop
        // half a period after the impact.
        let start = orbit.phases()[0] + 0.1 * PI;
        let q = Parameters { drive_phase: start, ..p };
        let mut simulator = Simulator::new(&q, &orbit.state(start), 0.0).unwrap();
        let half = 0.5 * p.period();
        let begin = 0.1 * half;
        simulator.advance_to((1.0 - 1e-6) * half - begin).unwrap();
        assert_eq!(simulator.impacts().upper + simulator.impacts().lower, 0);
        simulator.advance_to((1.0 + 1e-6) * half - begin).unwrap();
        assert_eq!(simulator.impacts().lower, 1);
    }
}
