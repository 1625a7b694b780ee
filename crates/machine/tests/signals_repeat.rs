//! Repeating steps and records, compared with written-out ones, closed forms and differences.

use crate::common::*;
use std::fmt::Write;
use std::sync::Arc;
use vibro_machine::file::{no_records, parse};
use vibro_machine::motion::{Event, EventKind};
use vibro_machine::{Assembly, Differentiated, Motion};

/// Rounding of times of turns, amplified by impacts.
const ROUNDING: f64 = 1e-11;
const PERIOD: f64 = 0.32;
const KNOTS: [(f64, f64); 5] = [(0.05, 0.0), (0.1, 1.0), (0.17, 0.4), (0.2, -0.7), (0.29, 0.2)];
const STEPS: [(f64, f64); 3] = [(0.0, 0.5), (0.12, -1.25), (0.25, 0.5)];
/// Step of central differences, whose error is proportional to its square.
const CHANGE: f64 = 1e-6;
const DIFFERENCE: f64 = 1e-8;

fn list(pairs: impl IntoIterator<Item = (f64, f64)>) -> String {
    let mut list = String::from("[");
    for (time, value) in pairs {
        let _ = write!(list, "[{time:?}, {value:?}], ");
    }
    list + "]"
}

/// The knots of some turns.
fn turns(knots: &[(f64, f64)], from: i32, to: i32) -> Vec<(f64, f64)> {
    let turn = |k: i32| knots.iter().map(move |&(t, y)| (f64::from(k).mul_add(PERIOD, t), y));
    (from..to).flat_map(turn).collect()
}

/// Written-out steps: each turn reverses all steps except the ones at time 0.
fn stairs(count: i32) -> Vec<(f64, f64)> {
    let back: f64 = STEPS.iter().skip(1).map(|step| step.1).sum();
    let turn = |k: i32| {
        STEPS.iter().enumerate().map(move |(i, &(t, height))| {
            let height = if k > 0 && i == 0 { -back } else { height };
            (f64::from(k).mul_add(PERIOD, t), height)
        })
    };
    (0..count).flat_map(turn).collect()
}

fn rig(signal: &str) -> Assembly {
    let toml = format!(
        "name = \"Rig\"\n[body.b]\nmass = 1.0\n[spring.k]\nbetween = [\"ground\", \"b\"]\nstiffness = 150.0\ndamping = 0.4\n\
         [stop.r]\nbetween = [\"ground\", \"b\"]\ngap = 0.002\nrestitution = 0.6\n\
         [friction.f]\nbetween = [\"ground\", \"b\"]\nforce = 0.05\n[load.l]\non = \"b\"\n{signal}\n"
    );
    Assembly::new(parse(&toml, "rig.toml", &no_records).unwrap_or_else(|e| panic!("{e}"))).unwrap()
}

fn moved(signal: &str, end: f64) -> (Motion, Vec<Event>) {
    let mut m = Motion::new(Arc::new(rig(signal))).unwrap();
    let all = events(&mut m, end);
    (m, all)
}

#[track_caller]
fn same(repeated: &str, written: &str, knots: usize) {
    let end = 5.0 * PERIOD - 1e-3;
    let ((one, these), (other, those)) = (moved(repeated, end), moved(written, end));
    assert_eq!(times(&these, |kind| *kind == EventKind::Knot).len(), knots, "{repeated}");
    assert_eq!(these.len(), those.len(), "{repeated}");
    for (a, b) in these.iter().zip(&those) {
        assert_eq!(std::mem::discriminant(&a.kind), std::mem::discriminant(&b.kind), "{repeated}");
        near(a.time, b.time, ROUNDING);
    }
    (0..2).for_each(|k| near(one.body(0)[k], other.body(0)[k], ROUNDING));
}

#[test]
fn second_method_what_repeats_is_what_is_written_out() {
    for word in ["straight", "cubic", "hold"] {
        let repeated = list(KNOTS);
        let repeated = format!("table = {repeated}\ninterpolation = \"{word}\"\nrepeat = \"320 ms\"");
        // Two turns before time 0, so that the first slopes are slopes of inner knots.
        let written = format!("table = {}\ninterpolation = \"{word}\"", list(turns(&KNOTS, -2, 7)));
        same(&repeated, &written, 25);
    }
    let repeated = format!("steps = {}\nrepeat = {PERIOD:?}", list(STEPS));
    // The step at time 0 belongs to the start, and each turn has its own knot.
    same(&repeated, &format!("steps = {}", list(stairs(5))), 14);
}

#[test]
fn second_method_a_record_with_both_ends_of_its_period() {
    let ends = [[(0.0, 0.2)].as_slice(), &KNOTS, &[(PERIOD, 0.2)]].concat();
    let without = &ends[..ends.len() - 1];
    for word in ["straight", "cubic", "hold"] {
        let repeated =
            format!("table = {}\ninterpolation = \"{word}\"\nrepeat = {PERIOD:?}", list(ends.clone()));
        let written = format!("table = {}\ninterpolation = \"{word}\"", list(turns(without, -2, 7)));
        // A value that is held across the turn does not change there.
        same(&repeated, &written, if word == "hold" { 25 } else { 29 });
    }
}

/// A cam's lift as a position: neither position nor rate jumps, even after many turns.
#[test]
fn invariant_a_repeated_cubic_is_smooth_after_ten_thousand_turns() {
    let mut m = motion(
        parse(
            "name = \"Cam\"\n[body.cam]\nmotion = { table = [[0.0, 0.0], [0.005, 0.001], [0.01, 0.0]], interpolation = \"cubic\", repeat = \"20 ms\" }\n\
             [body.b]\nmass = 0.1\nstart = { s = 0.0 }\n[spring.k]\nbetween = [\"ground\", \"b\"]\nstiffness = 1e5\npreload = 100.0\n\
             [stop.r]\nbetween = [\"b\", \"cam\"]\ngap = 0.0\nrestitution = 0.3\n",
            "cam.toml",
            &no_records,
        )
        .unwrap(),
    );
    let all = events(&mut m, 200.0);
    // The follower is pressed onto the cam throughout.
    let others: Vec<_> = all.iter().filter(|event| event.kind != EventKind::Knot).take(5).collect();
    assert!(others.is_empty(), "{others:?}");
    assert_eq!(all.len(), 30_000, "three knots a turn");
    for (k, event) in all.iter().enumerate() {
        let (turn, place) = ((k + 1) / 3, (k + 1) % 3);
        assert_eq!(event.time, (turn as f64).mul_add(0.02, 0.005 * place as f64));
    }
}

#[test]
fn closed_form_knots_are_whole_periods_and_a_time_rounded_once() {
    let mut m = Motion::new(Arc::new(rig("steps = [[0.0, 1.0], [0.07, -1.0]]\nrepeat = 0.1"))).unwrap();
    let all = times(&events(&mut m, 1000.05), |kind| *kind == EventKind::Knot);
    assert_eq!(all.len(), 20_000);
    for (k, time) in all.iter().enumerate() {
        let (turn, place) = (k.div_ceil(2), (k + 1) % 2);
        assert_eq!(*time, (turn as f64).mul_add(0.1, 0.07 * place as f64));
    }
}

#[test]
fn second_method_derivatives_by_steps_and_scale_of_what_repeats() {
    let signal = format!(
        "steps = {}\ntable = {}\nscale = 0.5\ninterpolation = \"straight\"\nrepeat = {PERIOD:?}",
        list(STEPS),
        list(KNOTS)
    );
    let assembly = Arc::new(rig(&signal));
    let names =
        ["load.l.steps[1].height", "load.l.steps[1].time", "load.l.steps[2].time", "load.l.table.scale"];
    let mut varied = Differentiated::new(assembly.clone(), &names).unwrap();
    let end = 4.9 * PERIOD;
    varied.advance_to(end).unwrap();
    for (p, name) in names.into_iter().enumerate() {
        let value = assembly.description.get(name).unwrap();
        let at = |value: f64| {
            let mut m = motion(assembly.description.with([(name, value)]).unwrap());
            m.advance_to(end).unwrap();
            m.body(0)
        };
        let (more, less) = (at(value + CHANGE), at(value - CHANGE));
        let found = varied.state_derivative(p).unwrap_or_else(|| panic!("{name}"));
        assert!(found.iter().any(|x| x.abs() > 1e-4), "{name}: {found:?}");
        for (k, found) in found.iter().enumerate() {
            near(*found, (more[k] - less[k]) / (2.0 * CHANGE), DIFFERENCE);
        }
    }
}

#[test]
fn invariant_what_is_refused_of_repeat() {
    let refused = |signal: &str| {
        let toml = format!("name = \"R\"\n[body.b]\nmass = 1.0\n[load.l]\non = \"b\"\n{signal}\n");
        parse(&toml, "r.toml", &no_records).unwrap_err().to_string()
    };
    for (signal, text) in [
        (
            "steps = [[0.1, 1.0], [0.3, 2.0]]\nrepeat = 0.3",
            "r.toml:6: load.l.steps[1].time = 0.3: must be at least 0 s and less than repeat = 0.3 s",
        ),
        (
            "steps = [[-0.1, 1.0]]\nrepeat = 0.3",
            "r.toml:6: load.l.steps[0].time = -0.1: must be at least 0 s and less than repeat = 0.3 s",
        ),
        (
            "table = [[0.1, 1.0], [0.4, 2.0]]\nrepeat = 0.3",
            "r.toml:6: load.l.table[1] = [0.4, 2.0]: the time must be from 0 s to repeat = 0.3 s",
        ),
        (
            "table = [[0.0, 1.0], [0.3, 2.0]]\nrepeat = 0.3",
            "r.toml:6: load.l.table[1] = [0.3, 2.0]: the value at repeat = 0.3 s must equal the value at 0 s, 1.0",
        ),
        ("steps = [[0.1, 1.0]]\nrepeat = 0", "r.toml:7: load.l.repeat = 0: must be greater than 0"),
        (
            "constant = 1.0\nrepeat = \"20 ms\"",
            "r.toml:7: load.l.repeat = \"20 ms\": requires `steps` or `table`, which it repeats",
        ),
    ] {
        assert_eq!(refused(signal), text);
    }
    let assembly = Arc::new(rig("steps = [[0.0, 1.0], [0.07, -1.0]]\nrepeat = 0.1"));
    let refused = Differentiated::new(assembly, &["load.l.repeat"]).map(drop).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "load.l.repeat: a motion has no derivative with respect to a period, a time between samples or an exponent; use one of the \
         machine's other numbers"
    );
}
