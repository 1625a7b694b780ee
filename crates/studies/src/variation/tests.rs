use super::*;
use crate::flight::Flows;
use crate::tests::{OSCILLATOR, example, text};
use crate::{Machine, Start, now};

/// Tolerance for the rounding of a few operations.
const ROUNDING: f64 = 1e-12;

#[test]
fn closed_form_lengths_and_units_of_a_metric() {
    assert_eq!(Metric::by_frequency(1, 2, 10.0).0, [0.1, 1.0, 0.1, 0.1]);
    let metric = Metric::by_frequency(2, 0, 10.0);
    assert_eq!(metric.0, [0.1, 0.1, 1.0, 1.0]);
    let v = [0.2, -0.1, 2.0, 4.0];
    assert!((metric.length(&v) - 5.0).abs() < ROUNDING);
    assert!((metric.scaled(&v) - DVector::from_row_slice(&[2.0, -1.0, 2.0, 4.0])).amax() < ROUNDING);
}

#[test]
fn invariant_a_basis_is_orthonormal_spans_its_directions_and_is_taken_away_whole() {
    let metric = Metric(vec![0.1, 2.0, 1.0]);
    let directions = [vec![0.1, 0.0, 3.0], vec![0.2, 2.0, 0.0], vec![0.3, 2.0, 3.0], vec![0.0; 3]];
    let basis = metric.basis(directions.clone());
    assert_eq!(basis.len(), 2, "the third is the sum of the first two");
    for (i, a) in basis.iter().enumerate() {
        for (j, b) in basis.iter().enumerate() {
            assert!((a.dot(b) - f64::from(u8::from(i == j))).abs() < ROUNDING);
        }
    }
    for mut direction in directions {
        metric.remove(&basis, &mut direction);
        assert!(metric.length(&direction) < ROUNDING, "{direction:?}");
    }
    let mut other = vec![0.5, 7.0, -2.0];
    let before = other.clone();
    metric.remove(&basis, &mut other);
    assert!(metric.length(&other) > 0.1);
    for b in &basis {
        assert!(b.dot(&metric.scaled(&other)).abs() < ROUNDING, "{other:?}");
    }
    // The component along the basis is removed: remainder and removed part make the whole.
    let taken: Vec<f64> = before.iter().zip(&other).map(|(a, b)| a - b).collect();
    let mut rest = taken.clone();
    metric.remove(&basis, &mut rest);
    assert!(metric.length(&rest) < ROUNDING * metric.length(&taken));
}

/// A ball that lies on a floor next to an oscillator.
const LYING: &str = "name = \"L\"\ngravity = 10.0\n[body.ball]\nmass = 0.5\ngravity = 1.0\n[stop.floor]\nbetween = [\"ground\", \"ball\"]\n\
    gap = 0.0\nrestitution = 0.5\n";

#[test]
fn closed_form_what_a_contact_holds_is_no_variation_from_the_start_on() {
    let (motion, _) = Machine::new(text(LYING).description).motion(&Start::default()).unwrap();
    let system = motion.assembly().system();
    let metric = Metric::by_frequency(system.coordinates, 0, 3.0);
    let frame = Frame::new(system, motion.mode(), &metric);
    assert_eq!(frame.columns.len(), 2);
    assert!(frame.columns.iter().flatten().all(|x| *x == 0.0), "{frame:?}");
    let mut variation = Variation::new(system, motion.mode(), metric, &Neutral::of(system));
    assert_eq!(variation.grown(None), f64::NEG_INFINITY);
    assert!(variation.v[0].iter().all(|x| *x == 0.0));
}

#[test]
fn closed_form_what_is_neutral_is_taken_away_whole() {
    // A free body alone: position and rate are neutral, so no variation remains.
    let machine = text(
        "name = \"F\"\n[body.a]\nmass = 1.0\nstart = { v = 1.0 }\n[load.f]\non = \"a\"\namplitude = 1.0\nfrequency = 1.0\n",
    );
    let (motion, _) = machine.motion(&Start::default()).unwrap();
    let system = motion.assembly().system();
    let metric = Metric::by_frequency(1, 0, 3.0);
    let mut variation = Variation::new(system, motion.mode(), metric.clone(), &Neutral::of(system));
    assert_eq!(variation.grown(None), f64::NEG_INFINITY);
    // An oscillator has no neutral directions. Along a shift, the remainder has length one and is
    // orthogonal to the shift.
    let (motion, _) = text(OSCILLATOR).motion(&Start::default()).unwrap();
    let system = motion.assembly().system();
    let mut variation = Variation::new(system, motion.mode(), metric.clone(), &Neutral::of(system));
    // The numbers begin as sin(1 + 0.7 k), in units of the metric.
    let [x, y] = [1.0f64.sin(), 1.7f64.sin()];
    let first = variation.grown(None);
    assert!((first - x.hypot(y).ln()).abs() < ROUNDING, "{first}");
    assert!((metric.length(&variation.v[0]) - 1.0).abs() < ROUNDING);
    assert_eq!(variation.growth, 0.0);
    let left = variation.grown(Some(vec![1.0, 0.0]));
    assert!((left - (y / x.hypot(y)).ln()).abs() < ROUNDING, "{left}");
    assert!(variation.v[0][0].abs() < ROUNDING && (variation.v[0][1] - 1.0).abs() < ROUNDING);
}

/// A machine's motion after some returns.
fn on_its_way(machine: &Machine, returns: u32) -> (vibro_machine::Motion, crate::Section) {
    let (mut motion, section) = machine.motion(&Start::default()).unwrap();
    for _ in 0..returns {
        section.advance(&mut motion, &mut |_| ()).unwrap();
    }
    (motion, section)
}

/// One variation, rescaled on its way, is the sum of the frame's columns.
#[test]
fn second_method_a_variation_grows_as_the_columns_of_a_frame() {
    /// Tolerance for the rounding of some thousand sub-steps and a dozen impacts.
    const NEAR: f64 = 1e-9;
    let fast = text(
        &OSCILLATOR
            .replace("stiffness = 800.0", "stiffness = 8e6")
            .replace("damping = 8.0", "damping = 80.0"),
    );
    let slow = text(&OSCILLATOR.replace("5 Hz", "0.2 Hz"));
    for (machine, returns) in
        [(example("damper_with_buffer.toml"), 3), (example("impact_pair.toml"), 2), (fast, 2), (slow, 1)]
    {
        let (mut motion, section) = on_its_way(&machine, 3);
        let assembly = motion.assembly().clone();
        let system = assembly.system();
        let size = 2 * system.coordinates;
        let metric = Metric::by_frequency(system.coordinates, 0, 30.0);
        let mut frame = Frame::new(system, motion.mode(), &metric);
        let mut variation = Variation::new(system, motion.mode(), metric.clone(), &Neutral::of(system));
        let began = variation.v[0].clone();
        let mut flows = Flows::default();
        for _ in 0..returns {
            section.follow(&mut motion, &mut flows, &mut [&mut frame, &mut variation]).unwrap();
        }
        let sum: Vec<f64> =
            (0..size).map(|i| (0..size).map(|j| began[j] * frame.columns[j][i]).sum()).collect();
        let scale = variation.growth.exp();
        let apart: Vec<f64> = sum.iter().zip(&variation.v[0]).map(|(a, b)| a - scale * b).collect();
        assert!(metric.length(&apart) < NEAR * metric.length(&sum), "{sum:?} {:?} {scale}", variation.v[0]);
    }
}

/// A start with a small change of one body.
fn changed(start: &Start, body: &str, (s, v): (f64, f64)) -> Start {
    let mut start = start.clone();
    let own = start.bodies.get_mut(body).unwrap();
    (own.s, own.v) = (own.s.map(|x| x + s), own.v.map(|x| x + v));
    start
}

#[test]
fn second_method_columns_are_differences_of_motions() {
    /// Step of the differences, and tolerance for the error from its square and from rounding: a
    /// stop of 2 MN/m bends them most.
    const STEP: f64 = 1e-7;
    const NEAR: f64 = 2e-3;
    for (name, free) in [("damper_with_buffer.toml", &[0, 1, 2][..]), ("impact_pair.toml", &[0])] {
        let machine = example(name);
        let (motion, section) = on_its_way(&machine, 2);
        let system = motion.assembly().system();
        let n = system.coordinates;
        assert_eq!(n, free.len());
        let metric = Metric::by_frequency(n, 0, 30.0);
        let start = now(&motion);
        let after = |start: &Start| {
            let (mut motion, section) = machine.motion_on(start).unwrap();
            section.advance(&mut motion, &mut |_| ()).unwrap();
            motion.state().clone()
        };
        let (mut followed, _) = machine.motion_on(&start).unwrap();
        let mut frame = Frame::new(system, followed.mode(), &metric);
        section.follow(&mut followed, &mut Flows::default(), &mut [&mut frame]).unwrap();
        for (k, &body) in free.iter().enumerate() {
            let body = &machine.description.bodies[body].name;
            for (j, step) in [(k, (STEP, 0.0)), (n + k, (0.0, STEP))] {
                let back = (-step.0, -step.1);
                let apart = after(&changed(&start, body, step)) - after(&changed(&start, body, back));
                let difference: Vec<f64> = apart.iter().take(2 * n).map(|x| x / (2.0 * STEP)).collect();
                let off: Vec<f64> = difference.iter().zip(&frame.columns[j]).map(|(a, b)| a - b).collect();
                let size = metric.length(&difference);
                assert!(
                    metric.length(&off) < NEAR * size,
                    "{name} {j}: {difference:?} {:?}",
                    frame.columns[j]
                );
            }
        }
    }
}

/// A ball falls by 0.2 m, bounces and is at rest after 0.6 s: it ends there from any start.
#[test]
fn closed_form_what_an_event_takes_whole_is_no_variation_after_it() {
    let file = LYING.replace("gap = 0.0", "gap = 0.2");
    let (mut motion, _) = text(&file).motion(&Start::default()).unwrap();
    let assembly = motion.assembly().clone();
    let system = assembly.system();
    let metric = Metric::by_frequency(1, 0, 3.0);
    let mut frame = Frame::new(system, motion.mode(), &metric);
    let mut variation = Variation::new(system, motion.mode(), metric, &Neutral::of(system));
    let mut flows = Flows::default();
    let observers: &mut [&mut dyn Observer] = &mut [&mut frame, &mut variation];
    crate::flight::follow(&mut motion, &mut flows, 0.5, observers, &mut |_| false).unwrap();
    assert!(frame.columns.iter().flatten().any(|x| x.abs() > 0.1));
    let observers: &mut [&mut dyn Observer] = &mut [&mut frame, &mut variation];
    crate::flight::follow(&mut motion, &mut flows, 1.0, observers, &mut |_| false).unwrap();
    assert!(frame.columns.iter().flatten().all(|x| *x == 0.0), "{frame:?}");
    assert_eq!(variation.grown(None), f64::NEG_INFINITY);
}
