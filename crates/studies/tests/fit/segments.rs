//! Chaotic records, fitted by segments.

use super::*;
use vibro_machine::Differentiated;
use vibro_machine::derivative::By;

/// An impact oscillator whose motion is chaotic: driven near twice its frequency, with a stop.
fn chaotic() -> Machine {
    let text = "name = \"Chaotic\"\n\
                body.a = { mass = 1.0, start = { s = -0.3, v = 0.2 } }\n\
                spring.k = { between = [\"ground\", \"a\"], stiffness = 1.0, damping = 0.02 }\n\
                stop.wall = { between = [\"ground\", \"a\"], gap = 0.02, restitution = 0.8 }\n\
                load.drive = { on = \"a\", amplitude = 1.0, frequency = \"2.8 rad/s\" }\n";
    Machine::parse(text, "chaotic.toml", &no_records).unwrap()
}

const PERIOD: f64 = TAU / 2.8;
const NOISE: f64 = 2e-3;
/// Defect of a segment in a motion of size 1: the rounding of some periods.
const CONTINUOUS: f64 = 1e-10;

#[test]
fn made_chaotic_record_of_sixty_periods() {
    let m = chaotic();
    let measured = record(&m, &[("a.s", NOISE)], 60.0 * PERIOD, 60 * 40 + 1, &mut Noise(21));
    let free =
        ["stop.wall.gap", "stop.wall.restitution", "spring.k.stiffness", "body.a.start.s", "body.a.start.v"];
    for factors in [[1.0; 5], [1.1, 0.95, 1.03, 1.05, 0.9], [1.25, 0.75, 1.25, 0.75, 1.25]] {
        let begin = off(&m, &free, |i| factors[i]);
        let found = fitted(&request(begin, measured.clone(), &free));
        check_chaotic(&m, &found);
    }
}

/// Requires a continuous motion, in segments or not, with the truth within three errors.
fn check_chaotic(m: &Machine, found: &Fitted) {
    assert_eq!(found.verdict, Verdict::Fits);
    assert!(found.uncertainty.undetermined.is_empty(), "{:?}", found.uncertainty.undetermined);
    let most = found.segments.iter().flat_map(|own| &own.defect).fold(0.0, |most: f64, d| most.max(d.abs()));
    assert!(most < CONTINUOUS, "{most}");
    assert!((found.rms[0].1 / NOISE - 1.0).abs() < 0.1, "{:?}", found.rms);
    for ((name, value), error) in found.values.iter().zip(&found.uncertainty.errors) {
        let truth = m.description.get(name).unwrap();
        assert!((value - truth).abs() < 3.0 * error.unwrap(), "{name} {value} ± {error:?}, true {truth}");
    }
}

#[test]
fn second_method_segments_of_a_length_come_to_the_point_of_one_motion() {
    let m = example("damper_with_buffer.toml");
    let measured = record(&m, &[("box.s", 1e-5), ("block.s", 2e-5)], 2.0, 500, &mut Noise(22));
    let free = ["stop.steel.gap", "stop.steel.restitution", "friction.guide.force"];
    let begin = off(&m, &free, |i| [1.1, 0.9, 1.1][i]);
    let by = |segments| fitted(&FitRequest { segments, ..request(begin.clone(), measured.clone(), &free) });
    // Appearing and disappearing impacts create minima a fraction of an error apart.
    let (one, many) = (by(Segments::None), by(Segments::Length(0.3)));
    assert!(one.segments.is_empty() && many.segments.len() >= 4, "{}", many.segments.len());
    // Errors of the curvature: the profile includes nearby impacts that appear or disappear.
    let pairs = one.values.iter().zip(&many.values).zip(&one.uncertainty.white).zip(&many.uncertainty.white);
    for ((((name, a), (_, b)), x), y) in pairs {
        let (x, y) = (x.unwrap(), y.unwrap());
        assert!(
            (a - b).abs() < x && (x / y - 1.0).abs() < 0.01,
            "{name}: {a} ± {x}, {b} ± {y}; costs {} {}",
            one.cost,
            many.cost
        );
    }
}

#[test]
fn second_method_a_chaotic_record_has_errors_by_growth_and_by_a_length() {
    // A mass between two stops of a shaken box, over 36 periods: changes grow by a factor of 1e9.
    let text = "name = \"Box\"\nparameters = { g = 0.2, e = 0.7 }\n\
                body.box = { motion = { amplitude = 0.02, frequency = 3.0 } }\n\
                body.b = { mass = 0.3, start = { v = 0.5 } }\n\
                damper.d = { between = [\"box\", \"b\"], damping = 0.2 }\n\
                stop.u = { between = [\"box\", \"b\"], gap = \"= g\", restitution = \"= e\" }\n\
                stop.l = { between = [\"b\", \"box\"], gap = \"= g\", restitution = \"= e\" }\n";
    let m = Machine::parse(text, "box.toml", &no_records).unwrap();
    let measured = record(&m, &[("b.s", 2e-4)], 12.0, 400, &mut Noise(63));
    let begin = off(&m, &["g", "e"], |i| [1.01, 0.98][i]);
    let mut all = Vec::new();
    for segments in [Segments::Auto, Segments::Length(1.0)] {
        let found = fitted(&FitRequest { segments, ..request(begin.clone(), measured.clone(), &["g", "e"]) });
        assert_eq!(found.verdict, Verdict::Fits, "{segments:?}");
        for ((name, value), error) in found.values.iter().zip(&found.uncertainty.errors) {
            let (truth, error) = (m.description.get(name).unwrap(), error.unwrap());
            assert!(
                (value - truth).abs() < FAR * error && error < 1e-4,
                "{segments:?} {name} {value} ± {error}"
            );
            all.push(error);
        }
    }
    let [g, e, same_g, same_e] = all[..] else { panic!("{all:?}") };
    assert!((g / same_g - 1.0).abs() < 0.02 && (e / same_e - 1.0).abs() < 0.02, "{all:?}");
}

/// Relative difference of derivatives that rounding explains after some ten contacts.
const ROUNDING: f64 = 1e-9;

/// Segments use the machine and the modes of another segment: the motion and its derivatives must
/// be the ones of a motion made anew.
#[test]
fn closed_form_a_motion_begun_again_equals_a_motion_made_anew() {
    let machine = example("damper_with_buffer.toml");
    let assembly = Arc::new(Assembly::new(machine.description).unwrap());
    let mut columns = vec![By::from("stop.steel.restitution"), By::from("stop.buffer.stiffness")];
    columns.extend((0..assembly.system().states()).map(By::Start));
    let rest = vec![0.0; assembly.system().states()];
    let mut first = Differentiated::from_state(assembly.clone(), 0.0, &rest, &columns).unwrap();
    first.advance_to(0.5).unwrap();
    let state = first.motion().states();
    let [mut of_anew, mut of_again] = [Vec::new(), Vec::new()];
    let mut anew = Differentiated::from_state(assembly, 0.5, &state, &columns).unwrap();
    let mut again = first.again_observed(0.5, &state, &mut |_, _| ()).unwrap();
    anew.advance_observed(0.7, &mut |event, _| of_anew.push((event.time, event.kind))).unwrap();
    again.advance_observed(0.7, &mut |event, _| of_again.push((event.time, event.kind))).unwrap();
    assert!(of_anew.len() > 10 && of_anew == of_again, "{of_anew:?} {of_again:?}");
    assert_eq!(again.motion().states(), anew.motion().states());
    for p in 0..columns.len() {
        let [own, other] = [&again, &anew].map(|motion| motion.state_derivative(p).unwrap());
        let size = other.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        assert!(own.iter().zip(&other).all(|(a, b)| (a - b).abs() <= ROUNDING * size), "{own:?} {other:?}");
    }
}
