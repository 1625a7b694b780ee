//! Motions with prescribed rate or acceleration, compared with closed forms, with the same motion
//! as a prescribed position, and with differences.

use crate::common::*;
use std::f64::consts::TAU;
use std::sync::Arc;
use vibro_machine::derivative::Gradient;
use vibro_machine::file::{no_records, parse};
use vibro_machine::motion::{Event, EventKind};
use vibro_machine::{Assembly, Differentiated, Motion};

/// Roundings of numbers of order one, through events.
const ROUNDING: f64 = 1e-12;
/// Step of central differences, whose error is proportional to its square.
const CHANGE: f64 = 1e-6;
const DIFFERENCE: f64 = 2e-8;

/// A base alone; a spring to ground keeps the machine valid, because each body needs an element.
fn base(motion: &str) -> Motion {
    moving(&format!(
        "name = \"Base\"\n[body.base]\nmotion = {{ {motion} }}\n[spring.k]\nbetween = [\"ground\", \"base\"]\nstiffness = 1.0\n"
    ))
}

/// Coordinate, rate and acceleration at a time.
fn at(m: &mut Motion, time: f64) -> [f64; 3] {
    m.advance_to(time).unwrap();
    m.body(0)
}

#[test]
fn closed_form_the_integral_of_each_part() {
    let steps = "steps = [[0.5, 2.0], [1.25, -3.0]]";
    let mut once = base(&format!("rate = {{ constant = 0.5, {steps} }}, s = 0.25"));
    let mut twice = base(&format!("acceleration = {{ constant = 0.5, {steps} }}, s = 0.25, v = -1.0"));
    let ramp = |t: f64, from: f64| (t - from).max(0.0);
    for time in [0.25_f64, 0.5, 1.0, 1.25, 1.5, 4.0] {
        let [a, b] = [ramp(time, 0.5), ramp(time, 1.25)];
        let first = 0.5 * time + 2.0 * a - 3.0 * b;
        let second = 0.25 * time * time + a * a - 1.5 * b * b;
        let level = 0.5 + if time >= 0.5 { 2.0 } else { 0.0 } - if time >= 1.25 { 3.0 } else { 0.0 };
        let [s, v, _] = at(&mut once, time);
        near(s, 0.25 + first, ROUNDING);
        near(v, level, ROUNDING);
        let [s, v, a] = at(&mut twice, time);
        near(s, 0.25 - time + second, ROUNDING);
        near(v, first - 1.0, ROUNDING);
        near(a, level, ROUNDING);
    }
}

/// Records are straight: the integral of a cubic through knots would not be exact.
#[test]
fn closed_form_the_integral_of_straight_records_before_and_after_time_0() {
    let table = "table = [[-0.5, 1.0], [0.5, 3.0], [1.0, -1.0]]";
    let mut once = base(&format!("rate = {{ {table} }}"));
    let mut twice = base(&format!("acceleration = {{ {table} }}"));
    let level = |t: f64| match t {
        _ if t < 0.5 => 2.0 + 2.0 * t,
        _ if t < 1.0 => 3.0 - 8.0 * (t - 0.5),
        _ => -1.0,
    };
    for time in [0.25_f64, 0.75, 1.0, 3.0] {
        // Three-point rules are exact on each piece.
        let ends = [0.0, 0.5f64.min(time), 1.0f64.min(time), time];
        let (mut first, mut second) = (0.0, 0.0);
        for pair in ends.windows(2) {
            let h = pair[1] - pair[0];
            let (a, c) = (level(pair[0]), level(pair[1] - 1e-15 * h.signum()));
            let middle = level(0.5 * (pair[0] + pair[1]));
            second += h * first + h * h * (a + 2.0 * middle) / 6.0;
            first += h * (a + 4.0 * middle + c) / 6.0;
        }
        near(at(&mut once, time)[0], first, ROUNDING);
        let [s, v, _] = at(&mut twice, time);
        near(s, second, ROUNDING);
        near(v, first, ROUNDING);
    }
}

/// The integral adds the exact contribution of each period, after any number of periods.
#[test]
fn closed_form_the_integral_of_what_repeats() {
    // +1 for a quarter of the period, then 0: 0.25 T per period.
    let part = "steps = [[0.0, 1.0], [0.125, -1.0]], repeat = 0.5";
    let mut once = base(&format!("rate = {{ {part} }}"));
    let mut twice = base(&format!("acceleration = {{ {part} }}"));
    for (turns, into) in [(0.0_f64, 0.0625_f64), (1.0, 0.25), (4.0, 0.0625), (1000.0, 0.375)] {
        let time = 0.5 * turns + into;
        let pushed = into.min(0.125);
        let first = 0.125 * turns + pushed;
        // In each turn: half the speed on average during the push, then the full speed.
        let turn = 0.125 * 0.125 / 2.0 + 0.125 * 0.375;
        let before = turns * turn + 0.125 * 0.5 * turns * (turns - 1.0) / 2.0;
        let second = before + 0.125 * turns * into + 0.5 * pushed * pushed + pushed * (into - pushed);
        near(at(&mut once, time)[0], first, ROUNDING);
        let [s, v, _] = at(&mut twice, time);
        near(s, second, ROUNDING * second.max(1.0));
        near(v, first, ROUNDING * first.max(1.0));
    }
}

/// A machine whose base moves, with impacts and friction.
fn rig(motion: &str) -> Arc<Assembly> {
    assembled(&format!(
        "name = \"Rig\"\n[body.b]\nmass = 1.0\nstart = {{ s = 0.01, v = 0.2 }}\n[body.base]\nmotion = {{ {motion} }}\n\
         [spring.k]\nbetween = [\"base\", \"b\"]\nstiffness = 80.0\ndamping = 0.3\n[stop.r]\nbetween = [\"base\", \"b\"]\ngap = 0.03\n\
         restitution = 0.7\n[friction.f]\nbetween = [\"base\", \"b\"]\nforce = 0.1\n"
    ))
}

fn moved(motion: &str, end: f64) -> (Motion, Vec<Event>) {
    let mut m = Motion::new(rig(motion)).unwrap();
    let all = events(&mut m, end);
    (m, all)
}

#[track_caller]
fn same(one: &str, other: &str) {
    let ((a, these), (b, those)) = (moved(one, 4.0), moved(other, 4.0));
    assert!(these.len() > 10, "{}", these.len());
    assert_eq!(these.len(), those.len(), "{one}");
    for (a, b) in these.iter().zip(&those) {
        assert_eq!(std::mem::discriminant(&a.kind), std::mem::discriminant(&b.kind), "{one}");
        near(a.time, b.time, 100.0 * ROUNDING);
    }
    for body in 0..2 {
        (0..2).for_each(|k| near(a.body(body)[k], b.body(body)[k], 100.0 * ROUNDING));
    }
}

#[test]
fn second_method_a_harmonic_as_place_rate_and_acceleration() {
    let (amplitude, frequency, phase) = (0.02_f64, 1.3_f64, 0.4_f64);
    let omega = TAU * frequency;
    let place = format!("amplitude = {amplitude:?}, frequency = {frequency:?}, phase = {phase:?}");
    let quarter = TAU / 4.0;
    let rate = format!(
        "rate = {{ amplitude = {:?}, frequency = {frequency:?}, phase = {:?} }}, s = {:?}",
        amplitude * omega,
        phase + quarter,
        amplitude * phase.sin()
    );
    let acceleration = format!(
        "acceleration = {{ amplitude = {:?}, frequency = {frequency:?}, phase = {phase:?} }}, s = {:?}, v = {:?}",
        -amplitude * omega * omega,
        amplitude * phase.sin(),
        amplitude * omega * phase.cos()
    );
    same(&rate, &place);
    same(&acceleration, &place);
}

#[test]
fn second_method_steps_of_the_rate_are_a_straight_record() {
    // Speed 0.1, then -0.2, then 0, with impacts where the speed jumps.
    let place = "table = [[0.0, 0.0], [0.5, 0.05], [1.0, -0.05], [4.0, -0.05]]";
    let rate = "rate = { constant = 0.1, steps = [[0.5, -0.3], [1.0, 0.2]] }";
    let ((a, these), (b, those)) = (moved(rate, 4.0), moved(place, 3.9));
    let of = |all: &[Event]| {
        all.iter().filter(|e| e.kind != EventKind::Knot && e.time < 3.5).cloned().collect::<Vec<_>>()
    };
    let (these, those) = (of(&these), of(&those));
    assert!(these.len() > 3 && these.len() == those.len());
    these.iter().zip(&those).for_each(|(a, b)| near(a.time, b.time, 100.0 * ROUNDING));
    near(a.body(1)[0], b.body(1)[0], ROUNDING);
}

/// A jump of the rate hits a closed stop; a jump of the acceleration causes no impact.
#[test]
fn closed_form_what_jumps_of_rate_and_acceleration_do() {
    let machine = |motion: &str| {
        moving(&format!(
            "name = \"Push\"\n[body.b]\nmass = 2.0\n[body.base]\nmotion = {{ {motion} }}\n[stop.r]\nbetween = [\"b\", \"base\"]\n\
             gap = 0.0\nrestitution = 0.5\n"
        ))
    };
    let mut hit = machine("rate = { steps = [[0.25, 1.0]] }");
    let all = events(&mut hit, 1.0);
    let impulses: Vec<f64> = all
        .iter()
        .filter_map(|e| if let EventKind::Impact { impulse, .. } = e.kind { Some(impulse) } else { None })
        .collect();
    assert_eq!(impulses.len(), 1);
    near(impulses[0], 3.0, ROUNDING);
    near(hit.body(0)[1], 1.5, ROUNDING);
    let mut pushed = machine("acceleration = { steps = [[0.25, 1.0], [0.75, -2.0]] }");
    let all = events(&mut pushed, 1.5);
    assert!(times(&all, |k| matches!(k, EventKind::Impact { .. })).is_empty());
    // The contact opens where the base decelerates.
    assert_eq!(times(&all, |k| matches!(k, EventKind::Open { .. })), [0.75]);
    near(pushed.body(0)[0], 0.125 + 0.5 * 0.75, ROUNDING);
    near(pushed.body(0)[1], 0.5, ROUNDING);
}

/// Steps at time 0 belong to the start: the body rests on a base that already moves.
#[test]
fn closed_form_steps_at_time_0_belong_to_the_start() {
    let mut m = moving(
        "name = \"Start\"\n[body.b]\nmass = 1.0\nstart = { v = 2.0 }\n[body.base]\nmotion = { rate = { steps = [[0.0, 2.0]] } }\n\
         [stop.r]\nbetween = [\"b\", \"base\"]\ngap = 0.0\nrestitution = 0.5\n",
    );
    assert_eq!(m.body(1), [0.0, 2.0, 0.0]);
    assert!(times(&events(&mut m, 1.0), |k| matches!(k, EventKind::Impact { .. })).is_empty());
}

/// An input of the rate continues the motion from the current position; so do parameter changes.
#[test]
fn closed_form_integrals_go_on_from_where_they_are() {
    let mut m = base("rate = { constant = 1.0, input = true }, s = 0.5");
    m.advance_to(1.0).unwrap();
    m.set_input(0, [2.0, 0.0, 6.0, 0.0]).unwrap();
    near(at(&mut m, 2.0)[0], 1.5 + 3.0 + 1.0, ROUNDING);
    m.set_input(0, [-1.0, 0.0, 0.0, 0.0]).unwrap();
    near(m.body(0)[0], 5.5, ROUNDING);
    near(at(&mut m, 4.0)[0], 5.5, ROUNDING);
    let changed = m.assembly().description.under_way([("body.base.motion.rate.constant", 3.0)]).unwrap();
    let mut m = m.changed(Arc::new(Assembly::new(changed).unwrap())).unwrap();
    near(m.body(0)[0], 5.5, ROUNDING);
    near(at(&mut m, 5.0)[0], 7.5, ROUNDING);

    let mut m = base("acceleration = { input = true }, v = 1.0");
    m.set_input(0, [2.0, 0.0, 0.0, 0.0]).unwrap();
    m.advance_to(1.0).unwrap();
    m.set_input(0, [0.0; 4]).unwrap();
    let [s, v, a] = at(&mut m, 2.0);
    near(s, 2.0 + 3.0, ROUNDING);
    near(v, 3.0, ROUNDING);
    near(a, 0.0, ROUNDING);
    let changed =
        m.assembly().description.under_way([("body.base.motion.acceleration.constant", 1.0)]).unwrap();
    let mut m = m.changed(Arc::new(Assembly::new(changed).unwrap())).unwrap();
    near(m.body(0)[0], 5.0, ROUNDING);
    near(at(&mut m, 3.0)[0], 8.5, ROUNDING);
}

#[test]
fn second_method_derivatives_of_integrals() {
    let rate = "rate = { constant = 0.02, amplitude = 0.2, frequency = 0.9, phase = 0.3, \
                steps = [[0.3, 0.1], [1.2, -0.2]] }, s = 0.001";
    let acceleration = "acceleration = { constant = 0.02, amplitude = 1.0, frequency = 0.9, phase = 0.3, \
                        steps = [[0.3, 0.1], [1.2, -0.2]], table = [[0.1, 0.0], [0.4, 1.0], [0.8, 0.0]], \
                        interpolation = \"cubic\", scale = 0.4 }, s = 0.001, v = 0.01";
    for (level, motion) in [("rate", rate), ("acceleration", acceleration)] {
        let rig = rig(motion);
        let all = rig.description.parameters();
        let names: Vec<String> =
            all.iter().map(|p| p.name.clone()).filter(|name| name.starts_with("body.base.")).collect();
        assert!(names.contains(&format!("body.base.motion.{level}.steps[1].time")), "{names:?}");
        let end = 2.0;
        let mut varied = Differentiated::new(rig.clone(), &names).unwrap();
        varied.advance_to(end).unwrap();
        for (p, name) in names.iter().enumerate() {
            let value = rig.description.get(name).unwrap();
            let at = |value: f64| {
                let mut m = motion_of(&rig, name, value);
                m.advance_to(end).unwrap();
                m.body(0)
            };
            let (more, less) = (at(value + CHANGE), at(value - CHANGE));
            let found = varied.state_derivative(p).unwrap_or_else(|| panic!("{name}"));
            for (k, found) in found.iter().enumerate() {
                let exact = (more[k] - less[k]) / (2.0 * CHANGE);
                assert!((found - exact).abs() < DIFFERENCE * exact.abs().max(1.0), "{name}: {found} {exact}");
            }
        }
    }
}

#[test]
fn second_method_gradients_of_integrals_are_sums_of_columns() {
    let part = "amplitude = 0.5, frequency = 0.9, steps = [[0.3, 0.1], [0.5, -0.2]], \
                table = [[0.1, 0.0], [0.4, 1.0], [0.6, 0.0]], scale = 0.4, repeat = 0.7";
    for motion in [
        format!("rate = {{ {part} }}, s = 0.001"),
        format!("acceleration = {{ {part} }}, s = 0.001, v = 0.01"),
    ] {
        let rig = rig(&motion);
        let all = rig.description.parameters().into_iter().map(|p| p.name);
        let names: Vec<String> = all.filter(|name| !name.ends_with(".repeat")).collect();
        let mut sum = Gradient::new(rig.clone(), &names).unwrap();
        let mut columns = Differentiated::new(rig.clone(), &names).unwrap();
        let quantities: Vec<_> = rig.description.quantities().take(3).collect();
        let mut exact = vec![0.0; names.len()];
        for time in [0.9, 1.7] {
            sum.advance_to(time).unwrap();
            columns.advance_to(time).unwrap();
            for &quantity in &quantities {
                sum.add(quantity, time);
                for (p, exact) in exact.iter_mut().enumerate() {
                    *exact += time * columns.derivative(quantity, p).unwrap();
                }
            }
        }
        for ((found, exact), name) in sum.gradient().unwrap().iter().zip(exact).zip(&names) {
            let found = found.as_ref().unwrap_or_else(|lost| panic!("{name}: {lost}"));
            assert!((found - exact).abs() < 1e3 * ROUNDING * exact.abs().max(1.0), "{name}: {found} {exact}");
        }
    }
}

/// Parameters changed during a motion act from then on: the position stays, and its future varies.
#[test]
fn second_method_derivatives_under_way_go_on_from_the_place() {
    let rate = "rate = { constant = 0.1, amplitude = 0.2, frequency = 0.9, steps = [[0.3, 0.1]], \
                sweep = { amplitude = 0.1, from = 1.0, to = 2.0, duration = 1.0 } }";
    for motion in [rate.to_owned(), rate.replace("rate", "acceleration")] {
        let rig = rig(&motion);
        let all = rig.description.parameters().into_iter().map(|p| p.name);
        let ends = [".constant", ".amplitude", ".phase", ".height"];
        let names: Vec<String> = all
            .filter(|name| name.starts_with("body.base") && ends.iter().any(|end| name.ends_with(end)))
            .collect();
        assert_eq!(names.len(), 6, "{names:?}");
        let mut begun = Motion::new(rig.clone()).unwrap();
        begun.advance_to(0.8).unwrap();
        let mut varied = Differentiated::from_motion(begun.clone(), &names).unwrap();
        varied.advance_to(1.3).unwrap();
        let place =
            rig.description.named_quantities().into_iter().find(|q| q.name == "base.s").unwrap().quantity;
        for (p, name) in names.iter().enumerate() {
            let value = rig.description.get(name).unwrap();
            let at = |value: f64| {
                let changed = rig.description.under_way([(name.as_str(), value)]).unwrap();
                let mut m = begun.changed(Arc::new(Assembly::new(changed).unwrap())).unwrap();
                m.advance_to(1.3).unwrap();
                m.body(1)[0]
            };
            let exact = (at(value + CHANGE) - at(value - CHANGE)) / (2.0 * CHANGE);
            near(varied.derivative(place, p).unwrap(), exact, DIFFERENCE);
        }
    }
}

fn motion_of(rig: &Assembly, name: &str, value: f64) -> Motion {
    motion(rig.description.with([(name, value)]).unwrap())
}

#[test]
fn invariant_what_is_refused_beside_a_rate_or_an_acceleration() {
    let refused = |motion: &str| {
        let toml = format!(
            "name = \"R\"\n[body.b]\nmass = 1.0\n[body.p]\nmotion = {{ {motion} }}\n[spring.k]\nbetween = [\"p\", \"b\"]\nstiffness = 1.0\n"
        );
        parse(&toml, "r.toml", &no_records).unwrap_err().to_string()
    };
    for (motion, text) in [
        (
            "rate = { constant = 1.0 }, amplitude = 0.1, frequency = 1.0",
            "r.toml:5: body.p.motion.amplitude = 0.1: cannot be combined with `rate`, which determines the motion: use `s` for the start\n\
             r.toml:5: body.p.motion.frequency = 1.0: cannot be combined with `rate`, which determines the motion: use `s` for the start",
        ),
        (
            "rate = { constant = 1.0 }, v = 2.0",
            "r.toml:5: body.p.motion.v = 2.0: cannot be combined with `rate`, which determines the motion: use `s` for the start",
        ),
        (
            "acceleration = 9.81, rate = 1.0",
            "r.toml:5: body.p.motion.rate = 1.0: cannot be combined with `acceleration`, which determines the motion: use `s` and `v` for the start",
        ),
        (
            "acceleration = 9.81, s = 1.0, offset = 1.0",
            "r.toml:5: body.p.motion.offset = 1.0: the position at time 0 is given twice; use one of `s`, `constant` and `offset`",
        ),
        (
            "acceleration = \"9.81 m/s\"",
            "r.toml:5: body.p.motion.acceleration = \"9.81 m/s\": cannot be in `m/s`; expected one of m/s2, mm/s2, cm/s2, g",
        ),
    ] {
        assert_eq!(refused(motion), text);
    }
    let turns = parse(
        "name = \"R\"\n[body.b]\ninertia = 1.0\n[body.p]\nmotion = { acceleration = \"2 rad/s2\" }\n[spring.k]\narms = { b = 1.0, p = -1.0 }\nstiffness = 1.0\n",
        "r.toml",
        &no_records,
    );
    assert_eq!(turns.unwrap().bodies[1].dimension, vibro_machine::description::Dimension::Rotation);
}
