//! Orbits of machines with sampled controllers and with limits of continuous blocks.

use super::*;
use nalgebra::{DVector, SMatrix, SVector};
use vibro_machine::Start;
use vibro_studies::Measure;

/// Tolerance for numbers of size one over a period.
const ROUNDING: f64 = 1e-11;
/// Tolerance for multipliers, from the power of a matrix.
const MULTIPLIER: f64 = 1e-10;

const SAMPLE: f64 = 0.05;
const DELAY: f64 = 0.02;
/// Samples in a period of the load.
const COUNT: usize = 40;
const GAINS: [f64; 2] = [9.0, 0.8];
const PUSH: f64 = 2.0;

/// A mass of 1 under a harmonic load, held in place by a sampled P-D controller. The controller
/// computes the velocity from two readings, and its force is delayed.
fn controlled(rest: &str, limits: &str) -> Machine {
    let [p, d] = GAINS;
    machine(&format!(
        "name = \"Held\"\n[parameters]\nT = {SAMPLE}\nkp = {p}\nkd = {d}\npush = {PUSH}\nlate = {DELAY}\n\
         [body.a]\nmass = 1.0\n{rest}[block.control]\ninputs = [\"a.s\"]\nstates = 1\na = [[0.0]]\nb = [[1.0]]\n\
         c = [[\"= kd/T\"]]\nd = [[\"= -kp - kd/T\"]]\noutputs = [\"u\"]\nsample = \"= T\"\ndelay = \"= late\"\n{limits}\
         [load.motor]\non = \"a\"\nfrom = \"control.u\"\n\
         [load.shaker]\non = \"a\"\namplitude = \"= push\"\nfrequency = \"= 1/({COUNT}*T)\"\n"
    ))
}

/// (s, v, last reading, present force, next force, cosine, sine of the load).
type Map = SMatrix<f64, 7, 7>;

/// The map from just after a force takes effect to just after the next one does.
fn over_one_sample() -> Map {
    let omega = std::f64::consts::TAU / (COUNT as f64 * SAMPLE);
    let mut a = Map::zeros();
    (a[(0, 1)], a[(1, 3)], a[(1, 6)], a[(5, 6)], a[(6, 5)]) = (1.0, 1.0, PUSH, -omega, omega);
    let mut reads = Map::identity();
    let [p, d] = GAINS.map(|gain| gain);
    let slope = d / SAMPLE;
    reads.row_mut(4).fill(0.0);
    (reads[(4, 0)], reads[(4, 2)]) = (-p - slope, slope);
    reads.row_mut(2).fill(0.0);
    reads[(2, 0)] = 1.0;
    let mut acts = Map::identity();
    acts.row_mut(3).fill(0.0);
    acts.row_mut(4).fill(0.0);
    acts[(3, 4)] = 1.0;
    acts * (a * DELAY).exp() * reads * (a * (SAMPLE - DELAY)).exp()
}

/// The fixed point of the map just after the force of the sample at time 0 takes effect.
fn exact() -> (SVector<f64, 5>, SMatrix<f64, 5, 5>) {
    let one = over_one_sample();
    let whole = (0..COUNT).fold(Map::identity(), |whole, _| one * whole);
    let omega = std::f64::consts::TAU / (COUNT as f64 * SAMPLE);
    let (sine, cosine) = (omega * DELAY).sin_cos();
    let own = whole.fixed_view::<5, 5>(0, 0).into_owned();
    let driven = whole.fixed_view::<5, 2>(0, 5) * SVector::<f64, 2>::new(cosine, sine);
    ((SMatrix::<f64, 5, 5>::identity() - own).try_inverse().unwrap() * driven, own)
}

#[test]
fn closed_form_a_sampled_controller_by_the_matrix_of_one_sample() {
    let orbit = Orbit::settled(&controlled("", ""), &Start::default(), 400).unwrap();
    assert_eq!(orbit.word().in_words(&orbit.place().assembly), format!("sample control ×{}", 2 * COUNT));
    assert!(orbit.is_certified(), "{:?}", orbit.violation());
    assert!(orbit.check_by_motion().unwrap() < ROUNDING);
    let (state, map) = exact();
    assert!((orbit.times()[0] - DELAY).abs() < ROUNDING, "{:?}", orbit.times());
    for (own, exact) in orbit.state().iter().zip(state.iter()) {
        assert!((own - exact).abs() < ROUNDING, "{:?} {state}", orbit.state());
    }
    let own = DMatrix::from_column_slice(5, 5, map.as_slice()).complex_eigenvalues();
    assert_eq!(orbit.multipliers().len(), 5);
    for mu in orbit.multipliers() {
        assert!(own.iter().any(|own| (own - mu).norm() < MULTIPLIER), "{:?} {own}", orbit.multipliers());
    }
}

const STOP: &str = "[stop.wall]\nbetween = [\"ground\", \"a\"]\ngap = 0.12\nrestitution = 0.6\n";

#[test]
fn second_method_a_sampled_controller_beside_a_stop() {
    let machine = controlled(STOP, "");
    let orbit = Orbit::settled(&machine, &Start::default(), 800).unwrap();
    let words = orbit.word().in_words(&orbit.place().assembly);
    assert!(words.contains("impact wall"), "{words}");
    assert!(orbit.is_certified(), "{:?}", orbit.violation());
    assert!(orbit.check_by_motion().unwrap() < ROUNDING);
    let own = moduli_by_motion(&orbit);
    for (mu, own) in orbit.multipliers().iter().zip(&own) {
        assert!((mu.norm() - own).abs() < MULTIPLIER, "{:?} {own:?}", orbit.multipliers());
    }
    for by in [("kp", 1.0), ("kd", 0.1), ("T", 0.005), ("late", 0.01), ("stop.wall.restitution", 0.1)] {
        let apart = column_apart(&machine, &orbit, by);
        assert!(apart < COLUMN, "{}: {apart:e}", by.0);
    }
}

/// Tolerance for difference quotients of the equations.
const COLUMN: f64 = 1e-7;
/// Relative tolerance for a derivative from differences of recomputed orbits.
const GRADIENT: f64 = 1e-6;

#[test]
fn second_method_gradients_by_gains_and_times_of_samples_are_those_of_differences() {
    let machine = controlled(STOP, "");
    let orbit = Orbit::settled(&machine, &Start::default(), 800).unwrap();
    let measure: Measure = "rms.a.v".parse().unwrap();
    let gradient = orbit.gradient(&measure).unwrap();
    for (name, step) in [("kp", 1e-4), ("kd", 1e-4), ("T", 1e-6), ("late", 1e-6), ("push", 1e-4)] {
        let own = gradient.iter().find(|own| own.parameter == name).unwrap();
        let at = |by: f64| {
            let family =
                Family::new(&machine, name, (own.value - 10.0 * step, own.value + 10.0 * step)).unwrap();
            let orbit = Orbit::settled_at(&family, own.value + by, &orbit.start(), 800).unwrap();
            orbit.measure(&measure).unwrap()
        };
        let difference = (at(step) - at(-step)) / (2.0 * step);
        let found = own.derivative.clone().unwrap();
        assert!((found - difference).abs() < GRADIENT * difference.abs(), "{name}: {found} {difference}");
    }
}

/// The largest unlimited output is proportional to the push. The branch has SA at the push for
/// which it is 1.5, the limit.
#[test]
fn closed_form_a_branch_ends_where_a_sample_comes_to_a_limit() {
    let (mut z, one) = (DVector::zeros(7), over_one_sample());
    let omega = std::f64::consts::TAU / (COUNT as f64 * SAMPLE);
    z.rows_mut(0, 5).copy_from(&exact().0);
    (z[5], z[6]) = ((omega * DELAY).cos(), (omega * DELAY).sin());
    let forces = (0..COUNT).map(|_| {
        z = &DMatrix::from_column_slice(7, 7, one.as_slice()) * &z;
        z[3]
    });
    let most = forces.fold(0.0_f64, |most, force| most.max(force.abs()));
    let push = 1.5 * PUSH / most;
    let machine = controlled("", "limits = { u = [-1.5, 1.5] }\n");
    let family = Family::new(&machine, "push", (0.2 * push, 3.0 * push)).unwrap();
    let branches = grown(&family, 6, 0);
    let all = branches.iter().flat_map(|b| &b.points).filter_map(|p| Some((p.special.clone()?, p.value)));
    let own: Vec<f64> = all
        .filter(|(special, _)| special.label == Label::Saturation && special.element == "block.control.u")
        .map(|(_, value)| value)
        .collect();
    assert!(nearest(&own, push) < SPECIAL, "{own:?} {push}");
    assert!(own.len() > 2, "{own:?}");
    for branch in &branches {
        for point in branch.points.iter().filter(|p| p.special.is_none()).step_by(5) {
            assert!(branch.orbit(point).unwrap().check_by_motion().unwrap() < ROUNDING, "{}", point.value);
        }
    }
}

/// Largest error of a special point against its closed form, in the parameter's unit.
const SPECIAL: f64 = 1e-9;

#[test]
fn refused_a_controller_that_rounds_what_it_reads() {
    let refused = Orbit::settled(&example("servo.toml"), &Start::default(), 1).unwrap_err().to_string();
    assert!(refused.contains("block.control") && refused.contains("remove `quantum`"), "{refused}");
}

/// A mass on a dashpot, driven along a harmonic by a limited PI controller of its velocity.
const DRIVE: &str = r#"
name = "Drive"
[body.a]
mass = 1.0
[damper.d]
between = ["ground", "a"]
damping = 0.4
[spring.k]
between = ["ground", "a"]
stiffness = 2.0
[signal.wanted]
amplitude = 1.0
frequency = 0.3
[block.pi]
inputs = ["a.v", "wanted"]
states = 1
a = [[-0.05]]
b = [[-1.0, 1.0]]
c = [[2.0]]
d = [[-3.0, 3.0]]
outputs = ["u"]
limits = { u = [-1.2, 1.5] }
[load.motor]
on = "a"
from = "pi.u"
"#;

#[test]
fn second_method_a_limited_continuous_controller() {
    let machine = machine(&DRIVE.replace("amplitude = 1.0", "amplitude = 2.0"));
    let orbit = Orbit::settled(&machine, &Start::default(), 800).unwrap();
    let words = orbit.word().in_words(&orbit.place().assembly);
    assert!(words.contains("limit u"), "{words}");
    assert!(orbit.is_certified(), "{:?}", orbit.violation());
    assert_eq!(orbit.stability(), Stability::Stable);
    assert!(orbit.check_by_motion().unwrap() < ROUNDING);
    let own = moduli_by_motion(&orbit);
    for (mu, own) in orbit.multipliers().iter().zip(&own) {
        assert!((mu.norm() - own).abs() < MULTIPLIER, "{:?} {own:?}", orbit.multipliers());
    }
    for by in
        [("block.pi.limits.u[1]", 0.1), ("signal.wanted.amplitude", 0.1), ("signal.wanted.frequency", 0.05)]
    {
        let apart = column_apart(&machine, &orbit, by);
        assert!(apart < COLUMN, "{}: {apart:e}", by.0);
    }
}

/// Without limits the drive's force is harmonic, with an amplitude given by the transfer function.
/// It equals the upper limit at one reference amplitude, where a branch has SA.
#[test]
fn closed_form_a_branch_ends_where_a_continuous_output_comes_to_its_limit() {
    use nalgebra::Complex;
    let s = Complex::new(0.0, std::f64::consts::TAU * 0.3);
    let controller = 3.0 + 2.0 / (s + 0.05);
    let plant = s / (s * s + 0.4 * s + 2.0);
    let force = (controller / (1.0 + controller * plant)).norm();
    let amplitude = 1.2 / force;
    let machine = machine(&DRIVE.replace("amplitude = 1.0", &format!("amplitude = {}", 0.5 * amplitude)));
    let family =
        Family::new(&machine, "signal.wanted.amplitude", (0.4 * amplitude, 1.2 * amplitude)).unwrap();
    let branches = grown(&family, 4, 0);
    let own = [specials(&branches, 0, "SA"), specials(&branches, 2, "SA")].concat();
    assert!(nearest(&own, amplitude) < SPECIAL, "{own:?} {amplitude}");
    assert!(branches.iter().any(|b| b.word().len() == 2), "{}", branches.len());
}

/// The servo axis without the encoder's steps: 1600 samples per period without unknowns.
#[test]
fn second_method_a_servo_axis_with_play_is_its_motion() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/assembly/servo.toml");
    let text = std::fs::read_to_string(folder).unwrap();
    let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with("quantum")).collect();
    let orbit = Orbit::settled(&machine(&lines.join("\n")), &Start::default(), 60).unwrap();
    let words = orbit.word().in_words(&orbit.place().assembly);
    assert!(orbit.word().len() > 3200 && words.contains("press backward"), "{words}");
    assert!(orbit.is_certified(), "{:?}", orbit.violation());
    assert_eq!(orbit.stability(), Stability::Stable);
    assert!(orbit.check_by_motion().unwrap() < ROUNDING);
}

/// The SA curve of a linear machine over the amplitude and the limit is a straight line.
#[test]
fn closed_form_curves_of_limits_over_two_parameters() {
    let (limited, drive) = (controlled("", "limits = { u = [-1.5, 2.0] }\n"), machine(DRIVE));
    for (machine, first, second, range, events) in [
        (limited, "push", "block.control.limits.u[0]", [-1.6, -1.4], 2 * COUNT),
        (drive, "signal.wanted.amplitude", "block.pi.limits.u[0]", [-1.3, -1.1], 0),
    ] {
        let present = machine.description.get(first).unwrap();
        let family = Family::new(&machine, first, (0.05 * present, 3.0 * present)).unwrap();
        let branches = grown(&family, 12, 0);
        let second = Family::new(&machine, second, (range[0], range[1])).unwrap();
        let own = branches.iter().filter(|b| b.word().len() == events);
        let all = own.flat_map(|b| b.points.iter().enumerate().map(move |(k, p)| (b, k, p)));
        let is_limit = |p: &OrbitPoint| p.special.as_ref().is_some_and(|s| s.label == Label::Saturation);
        let least = all.filter(|own| is_limit(own.2)).min_by(|a, b| a.2.value.total_cmp(&b.2.value));
        let start = least.and_then(|(branch, k, _)| branch.locus_start(k)).unwrap();
        let points = locus(&start, &second).unwrap();
        assert!(points.len() > 4, "{points:?}");
        let slope = points[0].values[0] / points[0].values[1];
        for point in &points {
            assert!((point.values[0] - slope * point.values[1]).abs() < SPECIAL, "{points:?}");
        }
        for end in range {
            assert!(points.iter().any(|p| (p.values[1] - end).abs() < SPECIAL), "{points:?}");
        }
    }
}
