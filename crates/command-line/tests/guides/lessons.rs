//! The lessons of docs/lessons/: their machines and commands are run, and the numbers of their
//! answers are compared with closed forms and with the results.

use crate::guide::{Guide, rows, texts};
use std::f64::consts::{PI, TAU};

/// Relative tolerance for a closed form: some thousands of rounding errors.
const ROUNDING: f64 = 1e-12;
const G: f64 = 9.81;

/// Runs a lesson. Returns its page and what its commands have said.
fn lesson(name: &str) -> (Guide, String) {
    let page = Guide::read(&format!("lessons/{name}.md"));
    let said = page.perform(&format!("lesson-{name}"), &[]).concat();
    (page, said)
}

fn assert_near(found: f64, expected: f64) {
    assert!((found / expected - 1.0).abs() < ROUNDING, "{found} is not {expected}");
}

/// Asserts that the page states a number with this many digits after the point.
fn assert_stated(page: &Guide, value: f64, digits: usize, unit: &str) {
    let said = format!("{value:.digits$} {unit}");
    assert!(page.text().contains(&said), "the page does not say {said}");
}

#[test]
fn closed_form_the_ball_of_the_lesson_rests() {
    let (page, _) = lesson("restitution");
    let (fall, speed) = ((2.0 / G).sqrt(), (2.0 * G).sqrt());
    let events = texts("lesson-restitution", "ball/events.csv");
    let last = events.last().expect("events");
    assert_eq!(last[1], "close");
    let rest = (1.0 + 0.8) / (1.0 - 0.8) * fall;
    assert_near(last[0].parse().expect("a time"), rest);
    assert_near(events[0][3].parse().expect("a speed"), speed);
    assert_stated(&page, rest, 4, "s");
    assert_stated(&page, speed, 4, "m/s");
}

#[test]
fn closed_form_the_oscillator_of_the_lesson_has_two_motions() {
    let (page, _) = lesson("resonance");
    let (k, c, force, omega) = (1e3f64, 2.0, 3.0, TAU * 6.0);
    assert_stated(&page, k.sqrt() / TAU, 3, "Hz");
    assert_stated(&page, 1e3 * force / (c * k.sqrt()), 1, "mm");
    assert_stated(&page, 1e3 * force / (k - omega * omega).hypot(c * omega), 2, "mm");
    let points = texts("lesson-resonance", "response/special-points.csv");
    let at = |label: &str| {
        let own = points.iter().filter(|row| row[0] == label);
        own.map(|row| row[4].parse::<f64>().expect("a frequency")).collect::<Vec<_>>()
    };
    // Without contact the amplitude is the stop's distance.
    let square = |f: f64| {
        let omega = TAU * f;
        (force / (k - omega * omega).hypot(c * omega) / 0.01).powi(2)
    };
    let touches = at("GR");
    touches.iter().for_each(|f| assert_near(square(*f), 1.0));
    let most = at("LP").into_iter().fold(0.0, f64::max);
    let least = touches.iter().copied().fold(f64::INFINITY, f64::min);
    let upper = touches.iter().copied().fold(0.0, f64::max);
    [least, upper, most].into_iter().for_each(|f| assert_stated(&page, f, 3, "Hz"));
    let curve = rows("lesson-resonance", "response/response.csv");
    let heights = curve.iter().flat_map(|row| row.iter().copied());
    assert!(heights.clone().any(|x| (x - 0.045_514).abs() < 1e-6), "no point of 45.51 mm");
}

#[test]
fn closed_form_the_block_of_the_lesson_sticks_and_slips() {
    let (page, _) = lesson("stick-slip");
    let events = texts("lesson-stick-slip", "belt/events.csv");
    let times = |kind: &str| {
        let own = events.iter().filter(|row| row[1] == kind);
        own.map(|row| row[0].parse::<f64>().expect("a time")).collect::<Vec<_>>()
    };
    let (sticks, slips) = (times("stick"), times("slip"));
    let slip = 2.0 / 10.0 * (PI - (0.5 * 10.0 / (100.0 * 0.1f64)).atan());
    assert_near(slips[1] - sticks[1], 0.1);
    assert_near(sticks[2] - slips[1], slip);
    assert_stated(&page, slip, 4, "s");
}

#[test]
fn closed_form_the_ball_of_the_lesson_doubles_its_period() {
    let (page, said) = lesson("rattle");
    let (e, omega) = (0.8f64, TAU * 20.0);
    let first = PI * (1.0 - e) / (1.0 + e);
    let doubling = G * first.hypot(2.0 * (1.0 + e * e) / (1.0 + e).powi(2)) / omega.powi(2);
    let points = texts("lesson-rattle", "branch/special-points.csv");
    let found = points.iter().find(|row| row[0] == "PD").expect("a doubling");
    assert_near(found[4].parse().expect("an amplitude"), doubling);
    assert_stated(&page, 1e3 * doubling, 4, "mm");
    assert_stated(&page, 1e3 * G * first / omega.powi(2), 4, "mm");
    let exponent = 20.0 * e.ln();
    assert_stated(&page, exponent, 3, "1/s");
    assert!(said.contains(&format!("exponent −{:.5}", -exponent)), "{said}");
}

#[test]
fn second_method_the_fit_of_the_lesson_has_honest_errors() {
    let (page, said) = lesson("fit");
    assert!(said.contains("verdict: fits"), "{said}");
    for (name, truth, digits) in [("restitution", 0.72, 4), ("gap", 0.55, 4)] {
        let line = said.lines().find(|line| line.contains(&format!("stop.floor.{name} ="))).expect("a value");
        let numbers: Vec<f64> = line.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        let [value, error] = numbers[..] else { panic!("{line}") };
        assert!((value - truth).abs() < 2.0 * error, "{line}");
        let stated = format!("{value:.digits$} ± {error:.digits$}");
        assert!(page.text().contains(&stated), "the page does not say {stated}");
    }
}
