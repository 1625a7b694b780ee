//! Designs of which the best is known in closed form.

use vibro_design::{Control, DesignRequest, Goal, Stage, Verdict, design};
use vibro_machine::file::{no_records, parse};
use vibro_studies::Machine;
use vibro_studies::design_sweep::{ParameterInterval, SampledAxis};

const CONTROL: Control = Control { go_on: &|| true, progress: &|_, _| () };

fn machine(text: &str) -> Machine {
    Machine::new(parse(text, "m.toml", &no_records).unwrap())
}

fn interval(name: &str, from: f64, to: f64) -> ParameterInterval<String> {
    ParameterInterval { name: name.into(), from, to }
}

/// Mass ratio of the absorber.
const RATIO: f64 = 0.1;
/// Natural frequency of the body without absorber, Hz.
const NATURAL: f64 = 10.0;

/// An undamped body with an absorber, driven by a load.
fn absorber() -> String {
    let k = (std::f64::consts::TAU * NATURAL).powi(2);
    format!(
        "name = \"Absorber\"\n[body.box]\nmass = 1.0\n[body.tuned]\nmass = {RATIO}\n\
         [spring.mount]\nbetween = [\"ground\", \"box\"]\nstiffness = {k}\n\
         [spring.absorber]\nbetween = [\"box\", \"tuned\"]\nstiffness = 300.0\ndamping = 1.0\n\
         [load.shaker]\non = \"box\"\namplitude = 1.0\nfrequency = {NATURAL}\n"
    )
}

/// The exact absorber of the least largest amplitude of an undamped body: ratio of the natural
/// frequencies, damping ratio, largest amplitude over the static one (O. Nishihara and T. Asami,
/// J. Vib. Acoust. 124 (2002) 576–582).
fn exact_absorber(mu: f64) -> [f64; 3] {
    let root = (4.0 + 3.0 * mu).sqrt();
    let inner = 2.0 * (16.0 + 23.0 * mu + 9.0 * mu * mu + 2.0 * (2.0 + mu) * root)
        / (3.0 * (64.0 + 80.0 * mu + 27.0 * mu * mu));
    let tuning = 2.0 / (1.0 + mu) * inner.sqrt();
    let damping = 0.25 * ((8.0 + 9.0 * mu - 4.0 * root) / (1.0 + mu)).sqrt();
    let square =
        ((8.0 + 9.0 * mu).powi(2) * (16.0 + 9.0 * mu) - 128.0 * root.powi(3)) / (3.0 * (32.0 + 27.0 * mu));
    [tuning, damping, square.sqrt() / (3.0 * mu)]
}

fn absorber_request() -> DesignRequest {
    let machine = machine(&absorber());
    let goal = Goal { measure: "amplitude.box.s".parse().unwrap(), maximize: false };
    let vary = vec![
        interval("spring.absorber.stiffness", 150.0, 600.0),
        interval("spring.absorber.damping", 0.5, 6.0),
    ];
    let values = (0..7).map(|k| NATURAL * (0.7 + 0.1 * f64::from(k))).collect();
    DesignRequest {
        over: vec![SampledAxis { name: "load.shaker.frequency".into(), values }],
        between: vec!["load.shaker.frequency".into()],
        evaluations: 30,
        ..DesignRequest::new(machine, goal, vary)
    }
}

/// Error of the largest amplitude: of the peaks of orbits, and the square of that of the numbers.
const AMPLITUDE: f64 = 1e-8;
/// Error of the numbers, whose square is the error of the amplitude.
const NUMBERS: f64 = 1e-4;

#[test]
fn closed_form_den_hartogs_absorber() {
    let found = design(&absorber_request(), &CONTROL).unwrap();
    let best = found.best.as_ref().unwrap();
    let [tuning, damping, largest] = exact_absorber(RATIO);
    let w = std::f64::consts::TAU * NATURAL;
    let exact = [RATIO * (tuning * w).powi(2), 2.0 * damping * RATIO * tuning * w];
    let size = largest / (w * w);
    assert!((best.goal.value / size - 1.0).abs() < AMPLITUDE, "{best:?} {size}");
    for (own, exact) in best.values.iter().zip(exact) {
        assert!((own / exact - 1.0).abs() < NUMBERS, "{best:?} {exact}");
    }
    assert_eq!((&found.verdict, found.has_gradients), (&Verdict::Decided, true));
    assert!(best.at_ends.is_empty() && found.rivals.iter().all(|own| own.is_told_apart), "{found:?}");
    // Without the exact peaks the search between the values of the band sees up to 1 % less.
    let sampled = found.evaluations.iter().filter(|own| own.stage == Stage::Gradient);
    assert!(sampled.filter_map(|own| own.goal).all(|goal| goal.value > 0.99 * size));
}
