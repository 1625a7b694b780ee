use super::*;
use crate::tests::{OSCILLATOR, example, text};
use vibro_machine::motion::EventKind;

/// Relative tolerance for the rounding of a sum of some thousand logarithms.
const ROUNDING: f64 = 1e-10;

/// Two coupled bodies: one hits a rigid wall, the other a rigid stop between them.
const HITTING: &str = r#"name = "C"
[body.a]
mass = 1.0
[body.b]
mass = 0.5
[spring.k]
between = ["ground", "a"]
stiffness = 400.0
damping = 1.5
[spring.s]
between = ["a", "b"]
stiffness = 120.0
damping = 0.4
[stop.wall]
between = ["ground", "a"]
gap = 0.005
restitution = 0.9
[stop.inner]
between = ["a", "b"]
gap = 0.01
restitution = 0.7
[load.f]
on = "a"
amplitude = 8.0
frequency = "2.3 Hz"
"#;

fn found(machine: &Machine, discard: u32, keep: u32) -> Spectrum {
    spectrum(machine, &Start::default(), (discard, keep), &mut || true).unwrap()
}

#[test]
fn closed_form_the_sum_is_the_dampers_rate_and_the_impacts_share() {
    let (machine, keep) = (text(HITTING), 300u32);
    let exponents = found(&machine, 0, keep).exponents;
    assert_eq!(exponents.len(), 4);
    assert!(exponents.windows(2).all(|w| w[0].value >= w[1].value));
    // tr(M⁻¹ C): each coordinate's dampers over its mass.
    let trace = (1.5 + 0.4) / 1.0 + 0.4 / 0.5;
    let (mut motion, section) = machine.motion(&Start::default()).unwrap();
    let (mut impacts, mut begin) = ([0.0; 2], 0.0);
    for k in 0..ALIGN as u32 + keep {
        if k == ALIGN as u32 {
            (impacts, begin) = ([0.0; 2], motion.time());
        }
        let mut count = |event: &vibro_machine::motion::Event| {
            if let EventKind::Impact { stop, .. } = event.kind {
                impacts[stop] += 1.0;
            }
        };
        section.advance(&mut motion, &mut count).unwrap();
    }
    assert!(impacts[0] > 50.0 && impacts[1] > 50.0, "{impacts:?}");
    // A rigid impact multiplies the closing speed and the position in its direction by -ε each.
    let lost = 2.0 * (impacts[0] * 0.9f64.ln() + impacts[1] * 0.7f64.ln()) / (motion.time() - begin);
    let sum: f64 = exponents.iter().map(|e| e.value).sum();
    assert!((sum / (lost - trace) - 1.0).abs() < ROUNDING, "{sum} {}", lost - trace);
}

/// Relative tolerance for an exponent from its multiplier: for a linear machine, and for an orbit
/// with impacts that the motion has approached to 1e-9.
const EXACT: f64 = 1e-11;
const SETTLED: f64 = 1e-8;

#[test]
fn closed_form_exponents_of_a_linear_machine_are_the_real_parts_of_its_roots() {
    // c/(2 m) = 2/s, twice.
    let spectrum = found(&text(OSCILLATOR), 0, 40);
    assert_eq!(spectrum.period, Some(1));
    for exponent in spectrum.exponents {
        assert!((exponent.value + 2.0).abs() < EXACT, "{exponent:?}");
    }
    // m = 1 kg between 30 N/m and 20 N/m with 5 N s/m in series: the inner state y has 5 (x' - y')
    // = 20 y, and s³ + 4 s² + 50 s + 120 has one real root and a pair.
    let series = "name = \"S\"\n[body.m]\nmass = 1.0\n[spring.k]\nbetween = [\"ground\", \"m\"]\nstiffness = 30.0\n\
        [spring.s]\nbetween = [\"ground\", \"m\"]\nstiffness = 20.0\nseries_damping = 5.0\n\
        [load.f]\non = \"m\"\namplitude = 1.0\nfrequency = \"0.5 Hz\"\n";
    let spectrum = found(&text(series), 0, 40);
    let mut real = -2.5f64;
    for _ in 0..50 {
        let p = ((real + 4.0) * real + 50.0) * real + 120.0;
        real -= p / ((3.0 * real + 8.0) * real + 50.0);
    }
    let pair = (-4.0 - real) / 2.0;
    let expected = [pair, pair, real];
    assert!(pair > real, "{expected:?}");
    for (exponent, expected) in spectrum.exponents.iter().zip(expected) {
        assert!((exponent.value / expected - 1.0).abs() < EXACT, "{spectrum:?} {expected}");
    }
}

#[test]
fn closed_form_a_pair_of_multipliers_of_an_impact_oscillator_has_half_the_sum_each() {
    let text = text(
        "name = \"I\"\n[body.m]\nmass = 1.0\n[spring.k]\nbetween = [\"ground\", \"m\"]\nstiffness = 1.0\ndamping = 0.1\n\
        [stop.d]\nbetween = [\"ground\", \"m\"]\ngap = 0.2\nrestitution = 0.8\n\
        [load.f]\non = \"m\"\namplitude = 1.0\nfrequency = \"0.45 Hz\"\n",
    );
    let spectrum = found(&text, 300, 16);
    // Two impacts in four drive periods.
    assert_eq!(spectrum.period, Some(4));
    let expected = 0.5 * (-0.1 + 0.45 * 0.8f64.ln());
    for exponent in &spectrum.exponents {
        assert!((exponent.value / expected - 1.0).abs() < SETTLED, "{spectrum:?} {expected}");
    }
}

#[test]
fn second_method_the_largest_is_that_of_one_variation() {
    // Chaos over different returns: tolerance of three standard errors of each.
    let machine = example("two_blocks.toml");
    let all = found(&machine, 300, 2000);
    let (mut motion, section) = machine.motion(&Start::default()).unwrap();
    settle(&mut motion, &section, 300).unwrap();
    let one = crate::settled(&mut motion, &section, Some(2000)).unwrap().exponent.unwrap();
    let error = 3.0 * (all.exponents[0].error + one.error);
    assert!((all.exponents[0].value - one.value).abs() < error, "{:?} {one:?}", all.exponents[0]);
    assert_eq!(all.running.len(), 2000);
}

#[test]
fn closed_form_what_a_contact_holds_is_lost() {
    let lying = "name = \"L\"\ngravity = 10.0\n[body.a]\nmass = 2.0\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 800.0\n\
        damping = 8.0\n[load.f]\non = \"a\"\namplitude = 10.0\nfrequency = \"5 Hz\"\n[body.ball]\nmass = 0.5\ngravity = 1.0\n\
        [stop.floor]\nbetween = [\"ground\", \"ball\"]\ngap = 0.0\nrestitution = 0.5\n";
    let exponents = found(&text(lying), 0, 50).exponents;
    let lost = exponents.iter().filter(|e| e.value == f64::NEG_INFINITY).count();
    assert_eq!((exponents.len(), lost), (4, 2), "{exponents:?}");
}
