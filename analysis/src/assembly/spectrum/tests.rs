use super::*;
use crate::assembly::tests::{OSCILLATOR, example, text};
use vibro_assembly::motion::EventKind;

/// Rounding of the sum of some thousand logarithms, relative.
const ROUNDING: f64 = 1e-10;

/// Two coupled bodies, of which one hits a rigid wall and the other a rigid stop between them.
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
        let mut count = |event: &vibro_assembly::motion::Event| {
            if let EventKind::Impact { stop, .. } = event.kind {
                impacts[stop] += 1.0;
            }
        };
        section.advance(&mut motion, &mut count).unwrap();
    }
    assert!(impacts[0] > 50.0 && impacts[1] > 50.0, "{impacts:?}");
    // A rigid impact multiplies the closing speed and the place in its direction by -ε each.
    let lost = 2.0 * (impacts[0] * 0.9f64.ln() + impacts[1] * 0.7f64.ln()) / (motion.time() - begin);
    let sum: f64 = exponents.iter().map(|e| e.value).sum();
    assert!((sum / (lost - trace) - 1.0).abs() < ROUNDING, "{sum} {}", lost - trace);
}

#[test]
fn closed_form_exponents_of_a_linear_machine_are_its_decay() {
    /// Swing of the variations' lengths over the time counted, 1/s.
    const SWING: f64 = 1e-2;
    // c/(2 m) = 2/s, twice.
    for exponent in found(&text(OSCILLATOR), 0, 200).exponents {
        assert!((exponent.value + 2.0).abs() < SWING && exponent.error > 0.0, "{exponent:?}");
    }
}

#[test]
fn second_method_the_largest_is_that_of_one_variation() {
    // Both count chaos, over other returns: three standard errors of either.
    let machine = example("two_blocks.toml");
    let all = found(&machine, 300, 2000);
    let (mut motion, section) = machine.motion(&Start::default()).unwrap();
    settle(&mut motion, &section, 300).unwrap();
    let one = crate::assembly::settled(&mut motion, &section, Some(2000)).unwrap().exponent.unwrap();
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
