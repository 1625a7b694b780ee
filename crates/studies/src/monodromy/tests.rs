use super::*;
use crate::tests::{OSCILLATOR, example, text};
use crate::{Machine, SectionRule, Start};

/// Tolerance for the rounding of small matrices.
const ROUNDING: f64 = 1e-12;

#[test]
fn closed_form_the_largest_modulus_of_multipliers() {
    let of = |size: usize, entries: &[f64]| largest_multiplier(DMatrix::from_row_slice(size, size, entries));
    for (found, expected) in [
        (of(2, &[0.3, 5.0, 0.0, -0.7]), 0.7),
        // 0.9 e^(±iφ).
        (of(2, &[0.9 * 0.6, -0.9 * 0.8, 0.9 * 0.8, 0.9 * 0.6]), 0.9),
        (of(3, &[2.0, 0.0, 0.0, 0.0, 0.6, -0.8, 0.0, 0.8, 0.6]), 2.0),
        (of(1, &[1e-9]), 1e-9),
    ] {
        assert!((found.unwrap() - expected).abs() < ROUNDING * expected.max(1.0), "{found:?} {expected}");
    }
    // Rounding relative to one, and relative to the largest variation.
    assert_eq!(of(1, &[1e-11]), None);
    assert_eq!(of(2, &[1e-3, 1e9, 0.0, 1e-3]), None);
    assert_eq!((of(2, &[0.0; 4]), of(1, &[f64::NAN]), of(1, &[f64::INFINITY])), (None, None, None));
}

#[test]
fn closed_form_the_way_to_a_fixed_point() {
    let of = |m: &[f64], basis: &[DVector<f64>], r: [f64; 2]| {
        offset(&DMatrix::from_row_slice(2, 2, m), basis, &DVector::from_row_slice(&r), 1e-10)
    };
    let near = |found: Option<DVector<f64>>, expected: [f64; 2]| {
        let found = found.unwrap();
        assert!((found[0] - expected[0]).hypot(found[1] - expected[1]) < ROUNDING, "{found} {expected:?}");
    };
    // (1 - M) x = r: 0.5 x - 0.2 y = 0.3, 0.1 x + 1.2 y = 1.3.
    near(of(&[0.5, 0.2, -0.1, -0.2], &[], [0.3, 1.3]), [1.0, 1.0]);
    // A neutral direction is left out.
    let neutral = [DVector::from_row_slice(&[1.0, 0.0])];
    near(of(&[0.0, 0.0, 0.0, 0.5], &neutral, [0.0, 1.0]), [0.0, 2.0]);
    // In a direction in which M is 1, only rounding is permitted.
    let family = [1.0, 0.0, 0.0, 0.5];
    near(of(&family, &[], [1e-11, 1.0]), [0.0, 2.0]);
    assert_eq!((of(&family, &[], [1e-9, 1.0]), of(&family, &[], [-1e-9, 1.0])), (None, None));
    near(of(&[-1.0, 0.0, 0.0, 0.5], &neutral, [1e-11, 1e-11]), [0.0, 0.0]);
}

#[test]
fn closed_form_exponents_are_logarithms_a_second_and_marginal_ones_zero() {
    let of = |multiplier| Period { distance: 0.0, multiplier, time: 0.5 }.exponent();
    assert_eq!(
        (of(None), of(Some(1.0)), of(Some(1.0 - 5e-7)), of(Some(1.0 + 5e-7))),
        (None, Some(0.0), Some(0.0), Some(0.0))
    );
    for exponent in [-4.0f64, 3.0, -1e-5] {
        assert!((of(Some((0.5 * exponent).exp())).unwrap() - exponent).abs() < ROUNDING);
    }
}

/// The motion of a machine, observed each second if it has no drive.
fn started(machine: &Machine) -> (Motion, Section) {
    let is_driven = crate::common_period(&machine.description).is_some();
    let section = if is_driven { SectionRule::Auto } else { SectionRule::Period(1.0) };
    Machine { section, ..machine.clone() }.motion(&Start::default()).unwrap()
}

/// A body on a spring whose other end moves uniformly at 0.25 m/s.
const DRAGGED: &str = "name = \"D\"\n[body.end]\nmotion = { rate = 0.25 }\n[body.a]\nmass = 2.0\nstart = { s = 0.01, v = 0.1 }\n\
    [spring.k]\nbetween = [\"end\", \"a\"]\nstiffness = 800.0\n";

#[test]
fn closed_form_a_shift_in_time_is_the_motion_less_what_is_carried_along() {
    let (motion, _) = started(&text(DRAGGED));
    // v = 0.1 m/s relative to 0.25 m/s; a = -400 · 0.01.
    let found = shift(&motion).unwrap();
    assert!((found[0] + 0.15).abs() < ROUNDING && (found[1] + 4.0).abs() < ROUNDING, "{found:?}");
    // From 4 to 5 s the end has moved by 0.25 m, and z' is the rate itself.
    let (system, z) = (motion.assembly().system(), motion.state());
    let rate = carried(system, z.as_slice(), true).unwrap();
    assert!((rate[0] - 0.25).abs() < ROUNDING, "{rate}");
    let mut later = motion.clone();
    later.advance_to(1.0).unwrap();
    let change = later.state() - z;
    assert!((carried(system, change.as_slice(), false).unwrap()[0] - 0.25).abs() < ROUNDING);
    // A dashpot alone does not hold.
    let free = text(&DRAGGED.replace("stiffness = 800.0", "stiffness = 0.0\ndamping = 3.0"));
    let (motion, _) = started(&free);
    assert_eq!(carried(motion.assembly().system(), motion.state().as_slice(), true).unwrap()[0], 0.0);
    // Two ends that separate do not allow a uniform motion.
    let parted = "[body.other]\nmotion = { rate = -0.25 }\n[spring.other]\nbetween = [\"other\", \"a\"]\nstiffness = 1.0\n";
    assert_eq!(shift(&started(&text(&format!("{DRAGGED}{parted}"))).0), None);
    // A drive distinguishes times.
    assert_eq!(shift(&started(&text(OSCILLATOR)).0), None);
}

/// The record of a motion over `returns` returns.
fn record(motion: &mut Motion, section: &Section, returns: u32) -> ReturnRecord {
    let mut record = ReturnRecord::new(motion, section);
    record.arrive(motion, false);
    for _ in 0..returns {
        section.advance(motion, &mut |event| record.event(event)).unwrap();
        record.arrive(motion, false);
    }
    record
}

#[test]
fn closed_form_the_metric_is_the_sizes_of_each_dimension() {
    let file = format!(
        "{OSCILLATOR}[body.r]\ninertia = 0.5\nstart = {{ v = 3.0 }}\n[spring.t]\nbetween = [\"ground\", \"r\"]\nstiffness = 50.0\n\
         [body.free]\nmass = 1.0\n[load.g]\non = \"free\"\nconstant = 0.0\n"
    );
    let (mut motion, section) = started(&text(&file));
    let record = record(&mut motion, &section, 9);
    let [length, angle, rate, spin] = record.sizes();
    assert!(
        length > 0.0 && angle > 10.0 * length && rate > 0.0 && spin > 10.0 * rate,
        "{:?}",
        record.sizes()
    );
    assert_eq!(metric(&motion, &record).0, [length, angle, length, rate, spin, rate]);
    // A quantity that has not moved has the unit one.
    let (still, section) = started(&text(
        "name = \"S\"\n[body.a]\nmass = 1.0\n[load.f]\non = \"a\"\nconstant = 0.0\namplitude = 0.0\nfrequency = 1.0\n",
    ));
    assert_eq!(metric(&still, &ReturnRecord::new(&still, &section)).0, [1.0, 1.0]);
}

/// The distance is the distance to the settled motion, and the multiplier is e^(-δT).
#[test]
fn second_method_the_distance_is_what_a_long_motion_goes() {
    /// Tolerance: squares of the distance to the orbit, and 1e-9 of the remainder after 60
    /// periods.
    const NEAR: f64 = 1e-6;
    let dragged = OSCILLATOR.replace(
        "[spring.k]\nbetween = [\"ground\"",
        "[body.end]\nmotion = { rate = 0.25 }\n[spring.k]\nbetween = [\"end\"",
    );
    for (file, returns) in [(OSCILLATOR, 1), (OSCILLATOR, 3), (&dragged, 1), (&dragged, 2)] {
        let (mut motion, section) = started(&text(file));
        let record = record(&mut motion, &section, 12);
        let mut settled = motion.clone();
        for _ in 0..60 {
            section.advance(&mut settled, &mut |_| ()).unwrap();
        }
        // In 60 periods of 0.2 s the end has moved by 3 m.
        let carried = if file == OSCILLATOR { 0.0 } else { 3.0 };
        let period = Period::follow(&mut motion, &section, &record, returns).unwrap();
        let time = 0.2 * f64::from(returns);
        assert!((period.time - time).abs() < 1e-9);
        assert!((period.multiplier.unwrap() - (-2.0 * time).exp()).abs() < 1e-9, "{period:?}");
        assert!((period.exponent().unwrap() + 2.0).abs() < 1e-8, "{period:?}");
        // The distance at the start of the period, which the motion has left.
        let (mut start, _) = started(&text(file));
        for _ in 0..12 {
            section.advance(&mut start, &mut |_| ()).unwrap();
        }
        let change = settled.state() - start.state();
        let expected = record.size_of_change(&[change[0] - carried, change[1]]);
        assert!((period.distance - expected).abs() < NEAR * expected, "{period:?} {expected}");
    }
}

#[test]
fn second_method_a_small_distance_is_as_exact() {
    /// Tolerance: 64 roundings of the state relative to the remaining distance, e^(-18) of the
    /// state.
    const NEAR: f64 = 1e-3;
    let (mut motion, section) = started(&text(OSCILLATOR));
    let record = record(&mut motion, &section, 45);
    let start = motion.state().clone();
    let period = Period::follow(&mut motion, &section, &record, 1).unwrap();
    for _ in 0..60 {
        section.advance(&mut motion, &mut |_| ()).unwrap();
    }
    let change = motion.state() - start;
    let expected = record.size_of_change(&change.as_slice()[..2]);
    assert!(expected > 1e-9 && expected < 1e-7, "{expected}");
    assert!((period.distance - expected).abs() < NEAR * expected, "{period:?} {expected}");
}

/// A drive of 0.2 s under a controller that samples every 0.02 s and acts 0.03 s later.
const CONTROLLED: &str = "name = \"C\"\n[body.m]\nmass = 1.0\nstart = { s = 0.1 }\n\
    [spring.k]\nbetween = [\"ground\", \"m\"]\nstiffness = 100.0\ndamping = 3.0\n\
    [load.drive]\non = \"m\"\namplitude = 1.0\nfrequency = 5.0\n\
    [block.c]\ninputs = [\"m.s\", \"m.v\"]\na = [[0.3]]\nb = [[1.0, 0.2]]\nc = [[5.0]]\nd = [[-10.0, 0.1]]\n\
    outputs = [\"u\"]\nsample = 0.02\ndelay = 0.03\n[load.l]\non = \"m\"\nfrom = \"c.u\"\n";

/// States of blocks count like other states. The multiplier agrees with a separate program that
/// uses the matrix exponential between samples.
#[test]
fn second_method_the_period_of_a_sampled_controller() {
    /// Tolerance for the remainder of a period's derivative from 1e-9 of the differences.
    const NEAR: f64 = 1e-9;
    let (mut motion, section) = started(&text(CONTROLLED));
    let record = record(&mut motion, &section, 12);
    let (start, mut settled) = (motion.state().clone(), motion.clone());
    for _ in 0..200 {
        section.advance(&mut settled, &mut |_| ()).unwrap();
    }
    let period = Period::follow(&mut motion, &section, &record, 1).unwrap();
    assert!((period.multiplier.unwrap() - 0.842_416_966_391_2).abs() < NEAR, "{period:?}");
    let expected = record.size_of_change(&(settled.state() - start).as_slice()[..6]);
    assert!((period.distance - expected).abs() < 1e-6 * expected, "{period:?} {expected}");
}

/// A spring in series, an end that moves on uniformly and a block that reads neither.
#[test]
fn what_an_even_motion_carries_beside_blocks() {
    let file = format!(
        "{}[spring.m]\nbetween = [\"end\", \"a\"]\nstiffness = 10.0\nseries_damping = 2.0\n\
         [block.f]\ninputs = [\"k.rate\"]\na = [[-1.0]]\nb = [[1.0]]\nc = [[-1.0]]\noutputs = [\"y\"]\n\
         [load.l]\non = \"a\"\nfrom = \"f.y\"\n",
        DRAGGED
    );
    let (mut motion, section) = started(&text(&file));
    let record = record(&mut motion, &section, 8);
    let period = Period::follow(&mut motion, &section, &record, 1).unwrap();
    assert!(period.distance.is_finite() && period.multiplier.is_some_and(|m| m < 1.0), "{period:?}");
}

#[test]
fn what_no_even_motion_carries_has_no_period() {
    let parted = OSCILLATOR.replace(
        "[spring.k]\nbetween = [\"ground\"",
        "[body.end]\nmotion = { rate = 0.25 }\n[spring.other]\nbetween = [\"ground\", \"a\"]\nstiffness = 1.0\n[spring.k]\nbetween = [\"end\"",
    );
    let (mut motion, section) = started(&text(&parted));
    let record = record(&mut motion, &section, 4);
    let period = Period::follow(&mut motion, &section, &record, 1).unwrap();
    assert_eq!((period.distance, period.multiplier), (f64::INFINITY, None));
}

/// Without a drive, the stick-slip of a block on a belt is one cycle, whatever its phase: the
/// shift in time is left out of the derivative.
#[test]
fn invariant_a_shift_in_time_is_no_distance_to_a_cycle() {
    let mut belt = example("brake_squeal.toml");
    belt.section = SectionRule::Auto;
    let (mut motion, section) = belt.motion(&Start::default()).unwrap();
    // The multiplier is 0.78.
    for _ in 0..160 {
        section.advance(&mut motion, &mut |_| ()).unwrap();
    }
    let record = record(&mut motion, &section, 8);
    let period = Period::follow(&mut motion, &section, &record, 1).unwrap();
    assert!(period.distance < 1e-9, "{period:?}");
}

/// Two ends that swing by hundreds of metres return up to the rounding of such distances, which is
/// not a motion that separates them.
#[test]
fn invariant_roundings_of_large_motions_are_no_change() {
    let file = "name = \"L\"\n[body.p]\nmotion = { amplitude = 1000.0, frequency = 5.0, phase = \"20 deg\" }\n\
        [body.q]\nmotion = { amplitude = 700.0, frequency = 5.0, phase = \"70 deg\" }\n[body.a]\nmass = 2.0\n\
        [spring.p]\nbetween = [\"p\", \"a\"]\nstiffness = 800.0\ndamping = 8.0\n[spring.q]\nbetween = [\"q\", \"a\"]\nstiffness = 80.0\n";
    let (mut motion, section) = started(&text(file));
    for _ in 0..200 {
        section.advance(&mut motion, &mut |_| ()).unwrap();
    }
    let record = record(&mut motion, &section, 12);
    let period = Period::follow(&mut motion, &section, &record, 1).unwrap();
    assert!(period.distance < 1e-7 && (period.exponent().unwrap() + 2.0).abs() < 1e-8, "{period:?}");
}

/// Tolerance for the rounding of the drive's phase after 600 periods, times 2π.
const PHASE: f64 = 1e-9;

/// If all sliders of a joint are held, its motion is linear and returns to itself, within a family
/// of orbits: rounding of the drive's phase does not hide this.
#[test]
fn closed_form_a_joint_that_is_held_returns() {
    let mut machine = example("iwan_joint.toml");
    machine.description = machine.description.with([("body.table.motion.frequency", 25.0)]).unwrap();
    let (mut motion, section) = started(&machine);
    let mut record = ReturnRecord::new(&motion, &section);
    for _ in 0..600 {
        section.advance(&mut motion, &mut |event| record.event(event)).unwrap();
        record.arrive(&motion, false);
    }
    let period = Period::follow(&mut motion, &section, &record, 1).unwrap();
    assert!(period.distance < PHASE, "{period:?}");
    assert!((period.multiplier.unwrap() - 1.0).abs() < ROUNDING, "{period:?}");
}
