//! Derivatives with respect to numbers of a machine, compared with closed forms; missing ones.

use crate::common::*;
use std::f64::consts::TAU;
use std::sync::Arc;
use vibro_machine::derivative::Cause;
use vibro_machine::motion::EventKind;
use vibro_machine::{Assembly, Differentiated, Error, Motion, Quantity, What, file};

/// Relative rounding of some hundred operations.
const ROUNDING: f64 = 1e-12;

fn differentiated(text: &str, parameters: &[&str]) -> Differentiated {
    Differentiated::new(assembled(text), parameters).unwrap()
}

/// The derivative of a quantity by its name.
fn of(motion: &Differentiated, name: &str, parameter: usize) -> Option<f64> {
    let all = motion.motion().assembly().description.named_quantities();
    motion.derivative(all.iter().find(|q| q.name == name).unwrap().quantity, parameter)
}

#[track_caller]
fn close(found: Option<f64>, exact: f64) {
    let found = found.unwrap();
    assert!((found - exact).abs() <= ROUNDING * exact.abs().max(1.0), "{found} instead of {exact}");
}

const BALL: &str = "name = \"Ball\"\ngravity = 9.0\n[body.ball]\nmass = 0.5\ngravity = 1.0\n\
    [stop.floor]\nbetween = [\"ground\", \"ball\"]\ngap = 2.0\nrestitution = 0.75\n";

#[test]
fn closed_form_the_impact_times_of_a_bouncing_ball() {
    // t_n = √(2h/g) (1 + 2 (ε + … + εⁿ⁻¹)), and (1 + ε)/(1 - ε) for all impacts. At the last
    // impacts, with 1e-6 m/s, an error of a position becomes an error 1e6 times as large in time.
    const LATE: f64 = 1e-8;
    let (h, g, e) = (2.0_f64, 9.0_f64, 0.75_f64);
    let mut ball =
        differentiated(BALL, &["stop.floor.gap", "gravity", "stop.floor.restitution", "body.ball.mass"]);
    let mut all = Vec::new();
    ball.advance_observed(6.0, &mut |event, by| all.push((event.clone(), by.to_vec()))).unwrap();
    assert!(all.len() > 40 && matches!(all.last().unwrap().0.kind, EventKind::Close { .. }));
    let fall = (2.0 * h / g).sqrt();
    for (n, (event, by)) in all.iter().enumerate() {
        let powers = (1..=n as i32).map(|k| e.powi(k)).sum::<f64>();
        let slopes = (1..=n as i32).map(|k| f64::from(k) * e.powi(k - 1)).sum::<f64>();
        let (sum, slope) = match event.kind {
            EventKind::Close { .. } => ((1.0 + e) / (1.0 - e), 2.0 / (1.0 - e).powi(2)),
            _ => (1.0 + 2.0 * powers, 2.0 * slopes),
        };
        let exact = [0.5 * fall / h * sum, -0.5 * fall / g * sum, fall * slope, 0.0];
        for (by, exact) in by.iter().zip(exact) {
            let error = (by.unwrap() - exact).abs();
            assert!(error <= LATE * exact.abs().max(0.1), "{n} at {}: {by:?} {exact}", event.time);
        }
    }
    // At rest on the floor, the ball is at the gap and presses with its weight.
    close(of(&ball, "ball.s", 0), 1.0);
    close(of(&ball, "floor.f", 1), 0.5);
    close(of(&ball, "floor.f", 3), 9.0);
}

#[test]
fn closed_form_free_vibration() {
    // s = s₀ cos ωt; derivative by c at c = 0: s₀ (sin ωt/(2mω) - t cos ωt/(2m)).
    let text = "name = \"V\"\n[body.a]\nmass = 0.5\nstart = { s = 0.3 }\n\
                [spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 8.0\n";
    let (m, k, s, end) = (0.5_f64, 8.0_f64, 0.3, 100.0);
    let parameters =
        ["spring.k.stiffness", "body.a.mass", "spring.k.damping", "body.a.start.s", "body.a.start.v"];
    let mut motion = differentiated(text, &parameters);
    motion.advance_to(end).unwrap();
    let omega = (k / m).sqrt();
    let (sine, cosine) = (omega * end).sin_cos();
    let by_rate = -s * end * sine;
    let by_damping = s * (sine / (2.0 * m * omega) - end * cosine / (2.0 * m));
    let exact = [by_rate * omega / (2.0 * k), -by_rate * omega / (2.0 * m), by_damping, cosine, sine / omega];
    for (p, exact) in exact.into_iter().enumerate() {
        // A hundred turns magnify roundings of the time.
        let found = of(&motion, "a.s", p).unwrap();
        assert!(
            (found - exact).abs() < 1e-11 * (1.0 + by_damping.abs()),
            "{}: {found} {exact}",
            parameters[p]
        );
    }
}

#[test]
fn closed_form_a_start_at_rest() {
    // A mass hangs on a spring and presses on a buffer; another rests on a stop.
    let text = "name = \"R\"\ngravity = 10.0\nstart = \"rest\"\n[body.a]\nmass = 2.0\ngravity = 1.0\n\
                [body.b]\nmass = 3.0\ngravity = 1.0\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 30.0\n\
                [stop.buffer]\nbetween = [\"ground\", \"a\"]\ngap = 0.1\nstiffness = 50.0\n\
                [stop.floor]\nbetween = [\"ground\", \"b\"]\ngap = 0.4\nrestitution = 0.5\n\
                [load.push]\non = \"a\"\nconstant = 5.0\n";
    let parameters = [
        "spring.k.stiffness",
        "stop.buffer.gap",
        "stop.buffer.stiffness",
        "gravity",
        "body.a.mass",
        "load.push.constant",
        "stop.floor.gap",
        "spring.k.preload",
        "body.b.mass",
    ];
    let mut motion = differentiated(text, &parameters);
    motion.advance_to(0.5).unwrap();
    // 80 s = 25 + 50·0.1.
    let s = 30.0 / 80.0;
    let exact = [
        -s / 80.0,
        50.0 / 80.0,
        -(s - 0.1) / 80.0,
        2.0 / 80.0,
        10.0 / 80.0,
        1.0 / 80.0,
        0.0,
        -1.0 / 80.0,
        0.0,
    ];
    for (p, exact) in exact.into_iter().enumerate() {
        close(of(&motion, "a.s", p), exact);
        close(of(&motion, "a.v", p), 0.0);
    }
    close(of(&motion, "b.s", 6), 1.0);
    close(of(&motion, "floor.f", 3), 3.0);
    close(of(&motion, "floor.f", 8), 10.0);
}

#[test]
fn closed_form_frequency_phase_and_amplitude() {
    // Two loads of the same frequency; one varies: v = A (cos φ - cos(ωt + φ))/(mω).
    let text = "name = \"F\"\n[body.a]\nmass = 2.0\n[body.b]\nmass = 2.0\n\
                [load.p]\non = \"a\"\namplitude = 3.0\nfrequency = 0.7\nphase = 0.4\n\
                [load.q]\non = \"b\"\namplitude = 3.0\nfrequency = 0.7\nphase = 0.4\n";
    let (m, a, f, phase, t) = (2.0, 3.0, 0.7, 0.4_f64, 2.3);
    let parameters = ["load.p.frequency", "load.p.phase", "load.p.amplitude", "body.a.mass"];
    let mut motion = differentiated(text, &parameters);
    motion.advance_to(t).unwrap();
    let omega = TAU * f;
    let (sine, cosine) = (omega * t + phase).sin_cos();
    let v = a * (phase.cos() - cosine) / (m * omega);
    close(of(&motion, "a.v", 0), -v / f + a * TAU * t * sine / (m * omega));
    close(of(&motion, "a.v", 1), a * (sine - phase.sin()) / (m * omega));
    close(of(&motion, "a.v", 2), v / a);
    close(of(&motion, "a.v", 3), -v / m);
    close(of(&motion, "p.f", 0), a * TAU * t * cosine);
    close(of(&motion, "b.v", 0), 0.0);
    close(of(&motion, "q.f", 0), 0.0);
}

#[test]
fn closed_form_gap_and_arm_of_a_held_contact() {
    // Held at arm·s = gap by the force F: s = gap/arm, λ = F/arm.
    let text = "name = \"H\"\n[body.a]\nmass = 2.0\n[stop.s]\narms = { a = 2.5 }\ngap = 0.5\nrestitution = 0.0\n\
                [load.push]\non = \"a\"\nconstant = 4.0\n";
    let mut motion = differentiated(text, &["stop.s.gap", "stop.s.arms.a", "load.push.constant"]);
    let mut times = Vec::new();
    motion.advance_observed(2.0, &mut |_, by| times.push(by.to_vec())).unwrap();
    let (arm, gap, force) = (2.5, 0.5, 4.0);
    close(of(&motion, "a.s", 0), 1.0 / arm);
    close(of(&motion, "a.s", 1), -gap / (arm * arm));
    close(of(&motion, "s.f", 1), -force / (arm * arm));
    close(of(&motion, "s.f", 2), 1.0 / arm);
    // The stop is hit at √(2 s m/F).
    let time = (2.0_f64 * gap / arm * 2.0 / force).sqrt();
    close(times[0][0], 0.5 * time / gap);
    close(times[0][1], -0.5 * time / arm);
}

#[test]
fn closed_form_times_and_heights_of_steps() {
    // The force is F from t₁ on: s = F (t - t₁)²/(2m). A second load steps at the same time.
    let text = "name = \"S\"\n[body.a]\nmass = 2.0\n[load.p]\non = \"a\"\nsteps = [[0.5, 3.0]]\n\
                [load.q]\non = \"a\"\nsteps = [[0.5, 1.0]]\n";
    let mut motion = differentiated(text, &["load.p.steps[0].time", "load.p.steps[0].height"]);
    let mut knots = Vec::new();
    motion.advance_observed(2.0, &mut |event, by| knots.push((event.clone(), by.to_vec()))).unwrap();
    close(of(&motion, "a.s", 0), -3.0 / 2.0 * 1.5);
    close(of(&motion, "a.v", 0), -3.0 / 2.0);
    close(of(&motion, "a.s", 1), 1.5 * 1.5 / 4.0);
    assert!(knots[0].0.kind == EventKind::Knot && knots[0].1 == [Some(1.0), Some(0.0)], "{knots:?}");
}

#[test]
fn closed_form_a_prescribed_body_that_carries_others() {
    // Behind a link s_b = a s_p; p steps by h at 0.5. From then on, c, which b drags by friction
    // F, moves no more than before. And a belt at rate 0, which varies.
    let text = "name = \"P\"\n[body.p]\nmotion = { amplitude = 0.2, frequency = 1.0 }\n[body.b]\nmass = 1.0\nstart = { v = 2.5132741228718345 }\n\
                [link.l]\narms = { b = 1.0, p = -2.0 }\n\
                [body.belt]\nmotion = { rate = 0.5 }\n[body.sled]\nmass = 2.0\n\
                [friction.f]\nbetween = [\"belt\", \"sled\"]\nforce = 4.0\n";
    let parameters = [
        "link.l.arms.p",
        "body.p.motion.frequency",
        "body.belt.motion.rate",
        "friction.f.force",
        "body.sled.mass",
    ];
    let mut motion = differentiated(text, &parameters);
    let mut stuck = Vec::new();
    let t = 0.8;
    let watch = &mut |event: &vibro_machine::motion::Event, by: &[Option<f64>]| {
        if matches!(event.kind, EventKind::Stick { .. }) {
            stuck.push((event.time, by.to_vec()));
        }
    };
    motion.advance_observed(t, watch).unwrap();
    let (sine, cosine) = (TAU * t).sin_cos();
    close(of(&motion, "b.s", 0), -0.2 * sine);
    close(of(&motion, "b.v", 1), 2.0 * 0.2 * TAU * (cosine - TAU * t * sine));
    close(of(&motion, "b.a", 0), 0.2 * TAU * TAU * sine);
    // It sticks at m r/F, at r t - m r²/(2F).
    let (m, r, f) = (2.0, 0.5, 4.0);
    let (time, by) = &stuck[0];
    assert!((time - m * r / f).abs() < ROUNDING);
    [m / f, -m * r / (f * f), r / f].into_iter().zip(&by[2..]).for_each(|(exact, by)| close(*by, exact));
    close(of(&motion, "sled.s", 2), t - m * r / f);
    close(of(&motion, "sled.s", 3), m * r * r / (2.0 * f * f));
    close(of(&motion, "sled.s", 4), -r * r / (2.0 * f));
    close(of(&motion, "sled.v", 2), 1.0);
}

#[test]
fn the_motion_has_the_bits_that_it_has_alone() {
    let mut alone = Motion::new(assembled(BALL)).unwrap();
    let mut ball = differentiated(BALL, &["stop.floor.gap", "gravity"]);
    for time in [0.3, 1.1, 2.0, 4.0, 5.5] {
        alone.advance_to(time).unwrap();
        ball.advance_to(time).unwrap();
        assert_eq!(alone.save(), ball.motion().save(), "{time}");
    }
}

/// Two balls that one stop couples, each above its own floor.
const TWO: &str = "name = \"T\"\ngravity = 10.0\n[body.a]\nmass = 1.0\ngravity = 1.0\n[body.b]\nmass = 2.0\ngravity = 1.0\n\
    [stop.fa]\nbetween = [\"ground\", \"a\"]\ngap = 0.2\nrestitution = 0.5\n\
    [stop.fb]\nbetween = [\"ground\", \"b\"]\ngap = 0.2\nrestitution = 0.5\n";

#[test]
fn two_impacts_at_one_instant_have_a_derivative_where_their_order_does_not_matter() {
    let mut alone = differentiated(TWO, &["stop.fa.gap", "gravity", "stop.fb.gap"]);
    let mut times = Vec::new();
    alone.advance_observed(0.3, &mut |_, by| times.push(by.to_vec())).unwrap();
    // √(2h/g) for each ball, and for both with respect to g.
    assert!(alone.lost(0).is_none(), "{:?}", alone.lost(0));
    close(times[0][0], 0.5);
    close(times[1][0], 0.0);
    close(times[1][2], 0.5);
    close(times[0][1], -0.01);
    // a: h - ε u (t - t₁) + g (t - t₁)²/2 with u = √(2gh), t₁ = u/g.
    close(of(&alone, "a.s", 0), 1.0 - 0.5 * 5.0 * 0.1 + 0.5 * 2.0 * 0.5 - 10.0 * 0.1 * 0.5);
    close(of(&alone, "b.s", 0), 0.0);
    // Given a dashpot between the balls, the order of impacts matters, unless both shift together.
    let text = format!("{TWO}[damper.c]\nbetween = [\"a\", \"b\"]\ndamping = 1.0\n");
    let mut coupled = differentiated(&text, &["stop.fa.gap", "gravity"]);
    coupled.advance_to(0.3).unwrap();
    let lost = coupled.lost(0).unwrap();
    assert!(lost.element.starts_with("stop.f") && lost.cause == Cause::Together, "{lost}");
    assert!((lost.time - 0.2).abs() < ROUNDING && of(&coupled, "b.s", 0).is_none());
    assert!(coupled.lost(1).is_none() && of(&coupled, "b.s", 1).is_some());
    assert_eq!(
        lost.to_string(),
        format!(
            "no derivative from t = {} s on: {} has an event together with another, and their order matters",
            lost.time, lost.element
        )
    );
}

#[test]
fn a_value_at_its_limit_has_no_derivative() {
    // A block that lies on its stop at the start, next to a block with a friction level of 0.
    let text = "name = \"L\"\ngravity = 10.0\n[body.a]\nmass = 1.0\ngravity = 1.0\nstart = { s = 0.2 }\n\
                [stop.floor]\nbetween = [\"ground\", \"a\"]\ngap = 0.2\nrestitution = 0.5\n\
                [body.b]\nmass = 1.0\nstart = { v = 1.0 }\n[friction.f]\nbetween = [\"ground\", \"b\"]\nforce = 0.0\n";
    let motion =
        differentiated(text, &["stop.floor.gap", "body.a.start.s", "friction.f.force", "body.a.start.v"]);
    for (p, element) in [(0, "stop.floor"), (1, "stop.floor"), (2, "friction.f")] {
        let lost = motion.lost(p).unwrap();
        assert_eq!((lost.time, lost.element.as_str(), lost.cause), (0.0, element, Cause::Limit));
    }
    // In the limit, bounces that take no time remove the velocity.
    close(of(&motion, "a.v", 3), 0.0);
    // A plastic impact has no derivative with respect to its restitution, which is 0.
    let text = BALL.replace("0.75", "0.0");
    let mut plastic = differentiated(&text, &["stop.floor.restitution", "stop.floor.gap"]);
    plastic.advance_to(2.0).unwrap();
    assert_eq!(plastic.lost(0).unwrap().cause, Cause::Limit);
    close(of(&plastic, "ball.s", 1), 1.0);
}

#[test]
fn unknown_parameters_are_refused_with_the_nearest() {
    let refused = Differentiated::new(assembled(BALL), &["stop.flor.gap"]).map(drop).unwrap_err();
    assert!(
        matches!(refused, Error::Refused(_)) && refused.to_string().contains("stop.floor.gap"),
        "{refused}"
    );
    assert!(differentiated(BALL, &[]).derivative(Quantity::of_body(0, What::S), 0).is_none());
}

#[test]
fn invariant_energy_that_is_kept_has_the_derivative_of_its_start() {
    // Elastic impacts, springs with preload and compliant stops without dashpots. The energy is a
    // function of state and number: its derivative by differences is accurate to a few digits less
    // than rounding.
    const STEP: f64 = 1e-5;
    const DIFFERENCE: f64 = 1e-9;
    let text = "name = \"E\"\n[body.a]\nmass = 1.0\nstart = { s = 0.3, v = 1.0 }\n[body.b]\nmass = 2.5\nstart = { v = -0.5 }\n\
        [spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 30.0\npreload = 2.0\n[spring.c]\narms = { a = 1.0, b = -1.4 }\nstiffness = 12.0\n\
        [stop.r]\nbetween = [\"a\", \"b\"]\ngap = 0.2\nrestitution = 1.0\n\
        [stop.s]\nbetween = [\"ground\", \"b\"]\ngap = 0.1\nstiffness = 200.0\n";
    let machine = file::parse(text, "machine.toml", &file::no_records).unwrap();
    let names: Vec<String> = machine.parameters().into_iter().map(|p| p.name).collect();
    let names: Vec<&str> =
        names.iter().map(String::as_str).filter(|name| !name.contains("damping")).collect();
    let mut motion = Differentiated::new(assembled(text), &names).unwrap();
    // Derivative along the motion, compared with differences of the energy as a function.
    let varied = |motion: &Differentiated, p: usize| {
        let (state, delta) =
            (motion.motion().state().as_slice()[..4].to_vec(), motion.state_derivative(p).unwrap());
        let at = |step: f64| {
            let value = machine.get(names[p]).unwrap();
            let changed = machine.with([(names[p], value + step)]).ok()?;
            let changed = Arc::new(Assembly::new(changed).unwrap());
            let moved: Vec<f64> = state.iter().zip(&delta).map(|(x, by)| x + step * by).collect();
            let (kinetic, stored) =
                Motion::from_state(changed, motion.motion().time(), &moved).unwrap().kinetic_and_stored();
            Some(kinetic + stored)
        };
        let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|k| at(k * STEP));
        Some((8.0 * (c? - b?) - (d? - a?)) / (12.0 * STEP))
    };
    let begun: Vec<Option<f64>> = (0..names.len()).map(|p| varied(&motion, p)).collect();
    let (mut impacts, mut compared) = (0, 0);
    for time in [0.35, 0.9, 1.7, 2.6] {
        let mut count = |event: &vibro_machine::motion::Event, _: &[Option<f64>]| {
            impacts += usize::from(event.contact().is_some());
        };
        motion.advance_observed(time, &mut count).unwrap();
        for (p, begun) in begun.iter().enumerate() {
            if let Some((now, begun)) = varied(&motion, p).zip(*begun) {
                let size = motion
                    .state_derivative(p)
                    .unwrap()
                    .iter()
                    .fold(1.0f64, |most, x| most.max(30.0 * x.abs()));
                assert!((now - begun).abs() < DIFFERENCE * size, "{} at {time}: {now} {begun}", names[p]);
                compared += 1;
            }
        }
    }
    assert!(impacts > 3 && compared > 40, "{impacts} {compared}");
}
