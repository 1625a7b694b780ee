//! Bifurcation diagrams of described machines against closed forms and invariants.

use super::*;
use crate::axis::ParameterAxis;
use crate::diagram::diagram;
use crate::parts::Task;
use crate::tests::{OSCILLATOR, text};

#[test]
fn closed_form_values_are_counted_to_seven_digits_of_the_largest() {
    let near = |found: Vec<(f64, u32)>, expected: &[(f64, u32)]| {
        assert_eq!(found.len(), expected.len(), "{found:?}");
        for (found, expected) in found.iter().zip(expected) {
            assert!((found.0 - expected.0).abs() < 1e-9 && found.1 == expected.1, "{found:?} {expected:?}");
        }
    };
    near(counted(vec![2.0, 1.0, -3.0, 1.0 + 1e-7, 2.0], 3), &[(-3.0, 3), (1.0, 6), (2.0, 6)]);
    near(counted(vec![2.0, 2.000002], 1), &[(2.0, 1), (2.000002, 1)]);
    near(counted(vec![-20.0, -20.000002], 1), &[(-20.0, 2)]);
    near(counted(vec![0.0, 0.0, -0.0], 2), &[(0.0, 6)]);
    near(counted(Vec::new(), 2), &[]);
}

/// A block that flies between impacts: its coordinate has a maximum where its velocity changes
/// sign, once per period, and none where an impact makes it faster. The diagram at 20,000 periods,
/// where times are rounded to 2e-13 s, equals the first one.
#[test]
fn invariant_maxima_do_not_depend_on_the_clock() {
    let text = "name = \"Rattle\"\n[body.frame]\nmotion = { amplitude = \"5 mm\", frequency = \"10 Hz\" }\n\
        [body.block]\nmass = 1.0\n[stop.upper]\nbetween = [\"block\", \"frame\"]\ngap = \"2 mm\"\nrestitution = 0.7\n\
        [stop.lower]\nbetween = [\"frame\", \"block\"]\ngap = \"2 mm\"\nrestitution = 0.7\n";
    let machine = Machine::parse(text, "rattle.toml", &vibro_machine::file::no_records).unwrap();
    let axis = ParameterAxis::of("body.frame.motion.amplitude".to_owned(), (4.9e-3, 5.1e-3), 9).unwrap();
    for time in [0.0, 2000.0] {
        let start = Start { time, ..Start::default() };
        let request = DiagramRequest {
            axis: axis.clone(),
            of: "block.s".parse().unwrap(),
            at_section: false,
            keep: 60,
            start,
            ..request(9)
        };
        for (_, own, point) in Direction::new(machine.clone(), request, true).unwrap() {
            let (own, point) = (own.unwrap(), point.unwrap());
            // The state reads back as a start, without the prescribed frame.
            assert_eq!(Start::parse(&own.to_toml(), "start", &machine.description), Ok(own));
            assert_eq!((point.settled.period, point.maxima.len()), (Some(1), 1), "{time}: {point:?}");
        }
    }
}

fn request(count: usize) -> DiagramRequest<Machine> {
    let axis = ParameterAxis::of("spring.k.damping".to_owned(), (8.0, 9.0), count).unwrap();
    let of = "a.s".parse().unwrap();
    let start = Start::default();
    DiagramRequest { axis, of, at_section: true, discard: 400, keep: 4, exponents: None, anew: false, start }
}

/// An oscillator at whole periods of its drive.
#[test]
fn closed_form_values_at_the_section_are_the_steady_motions() {
    let machine = text(OSCILLATOR);
    let found = diagram(&machine, &request(5), &Task::ALL).unwrap().unwrap();
    for point in found.up.iter().chain(&found.down).map(|p| p.as_ref().unwrap()) {
        // (800 - 2 ω² + i c ω) s = 10 with the drive's 10 sin(ω t): -10 c ω/|…|² at its zeros.
        let w = 10.0 * std::f64::consts::PI;
        let (k, c) = (800.0 - 2.0 * w * w, point.value * w);
        let expected = -10.0 * c / (k * k + c * c);
        let [(value, count)] = point.maxima[..] else { panic!("{point:?}") };
        assert!((value - expected).abs() < 1e-6 * expected.abs() && count == 4, "{value} {expected} {count}");
    }
    assert_eq!(found.up.len(), 5);
    // A direction, value by value, equals the diagram.
    for (upward, points) in [(true, &found.up), (false, &found.down)] {
        for (i, start, point) in Direction::new(machine.clone(), request(5), upward).unwrap() {
            assert!(start.is_some() && point == points[i]);
        }
    }
    // Observed twice per period, the motion is 2T, and each maximum is counted half as often.
    let twice = Machine { section: crate::SectionRule::Period(0.1), ..machine };
    let found = diagram(&twice, &request(2), &Task::ALL).unwrap().unwrap();
    let point = found.up[0].as_ref().unwrap();
    let counts: Vec<u32> = point.maxima.iter().map(|m| m.1).collect();
    assert_eq!((counts, point.settled.period), (vec![2, 2], Some(2)));
}

#[test]
fn what_no_value_could_do_without_is_refused_first() {
    let machine = text(OSCILLATOR);
    request(5).check(&machine).unwrap();
    assert!(DiagramRequest { keep: 0, ..request(5) }.check(&machine).is_err());
    request(MOST_VALUES).check(&machine).unwrap();
    assert!(request(MOST_VALUES + 1).check(&machine).is_err());
    let axis = ParameterAxis::of("spring.k.damping".to_owned(), (-1.0, 8.0), 3).unwrap();
    assert!(DiagramRequest { axis, ..request(3) }.check(&machine).is_err());
}

/// Between soft stops resonance bends to higher frequencies: a motion coming from below stays in
/// contact where a motion from above has none.
#[test]
fn invariant_each_direction_goes_on_from_the_value_before() {
    let stop = |name: &str, a: &str, b: &str| {
        format!("[stop.{name}]\nbetween = [\"{a}\", \"{b}\"]\ngap = 0.02\nstiffness = 3e3\n")
    };
    let file =
        OSCILLATOR.replace("damping = 8.0", "damping = 1.0").replace("amplitude = 10.0", "amplitude = 2.0");
    let machine = text(&format!("{file}{}{}", stop("r", "ground", "a"), stop("l", "a", "ground")));
    let axis = ParameterAxis::of("load.f.frequency".to_owned(), (3.0, 5.0), 9).unwrap();
    let request = DiagramRequest { axis, at_section: false, ..request(9) };
    let found = diagram(&machine, &request, &Task::ALL).unwrap().unwrap();
    let contacts = |points: &[Option<DescribedPoint>]| -> Vec<f64> {
        points.iter().map(|point| point.as_ref().unwrap().settled.contacts).collect()
    };
    let (up, down) = (contacts(&found.up), contacts(&found.down));
    let apart = (0..9).filter(|&i| up[i] > 0.0 && down[i] == 0.0).count();
    assert!(apart > 0 && found.hysteresis().iter().any(|h| *h), "{up:?} {down:?}");
    assert!(up[8] == down[8] && up[0] == down[0], "{up:?} {down:?}");
}
