use super::*;
use crate::tests::{OSCILLATOR, text};
use crate::{Machine, Start};
use vibro_machine::Motion;

/// An undamped oscillation of 2.5 s with a ripple of `frequency` Hz: a window contains four
/// oscillations, 10 s.
fn slow(frequency: f64) -> (Motion, Section) {
    slow_machine(frequency).motion(&Start::default()).unwrap()
}

fn slow_machine(frequency: f64) -> Machine {
    // (2π/2.5)² N/m for a kilogram.
    let stiffness = (std::f64::consts::TAU / 2.5).powi(2);
    let file = format!(
        "name = \"S\"\n[body.a]\nmass = 1.0\nstart = {{ s = 1.0 }}\n[spring.k]\nbetween = [\"ground\", \"a\"]\n\
         stiffness = {stiffness:?}\n[load.f]\non = \"a\"\namplitude = 1e-9\nfrequency = {frequency:?}\n"
    );
    text(&file)
}

/// Tolerance for the rounding of the eigenvalues that give the period.
const ROUNDING: f64 = 1e-9;

#[test]
fn closed_form_a_window_lasts_four_periods_of_the_slowest_own_oscillation() {
    let (motion, section) = slow(100.0);
    assert!((needed(&motion, &section, 11).unwrap() - 10.0).abs() < ROUNDING);
    // 10 periods of 10 ms times a hundred are 10 s, but 9 periods are not enough.
    let error = needed(&motion, &section, 9).unwrap_err().to_string();
    assert!(error.contains("9 periods (measured, --periods) last 0.09 s"), "{error}");
    assert!(
        error.contains("natural oscillation, 2.5 s each") && error.contains("use at least 1000 periods"),
        "{error}"
    );
    // With events as the section the time is not known in advance.
    assert!((needed(&motion, &Section::Stop(0), 1).unwrap() - 10.0).abs() < ROUNDING);
}

#[test]
fn closed_form_what_comes_before_a_window_lasts_as_long() {
    let (mut motion, section) = slow(100.0);
    settle(&mut motion, &section, 11).unwrap();
    assert!((10.0..10.5).contains(&motion.time()), "{}", motion.time());
    let (mut motion, section) = slow(100.0);
    let error = settle(&mut motion, &section, 9).unwrap_err().to_string();
    assert!(error.contains("9 periods (discarded, --discard)"), "{error}");
    // A longer request is followed exactly, or less far if the motion repeats.
    let (mut motion, section) = slow(10.0);
    settle(&mut motion, &section, 150).unwrap();
    assert!((10.0..15.0 + ROUNDING).contains(&motion.time()), "{}", motion.time());
    // If the motion begins later, time is counted from there.
    let later = Start { time: 7.0, ..Start::default() };
    let (mut motion, section) = slow_machine(100.0).motion(&later).unwrap();
    settle(&mut motion, &section, 11).unwrap();
    assert!((17.0..17.5).contains(&motion.time()), "{}", motion.time());
    let (mut motion, section) = slow(10.0);
    settle(&mut motion, &section, 0).unwrap();
    assert_eq!(motion.time(), 0.0);
}

/// Returns of a window of which 12 are requested, with `events` events in each of the first three.
fn returns(needed: f64, events: u32, repeats: bool) -> u32 {
    let (mut motion, section) = slow(10.0);
    // Time counts from the window's beginning.
    motion.advance_to(0.7).unwrap();
    let mut passed = Passed::new(&motion, needed, 12);
    for k in 1.. {
        section.advance(&mut motion, &mut |_| ()).unwrap();
        if passed.is_enough(&motion, (events * u32::from(k <= 3), repeats)).unwrap() {
            return k;
        }
    }
    0
}

#[test]
fn closed_form_a_window_has_its_returns_its_time_and_eight_events_or_ten_times_its_returns() {
    for ((needed, events, repeats), expected) in [
        ((0.0, 0, false), 12),
        ((1.2 - 1e-9, 0, false), 12),
        ((2.05, 0, false), 21),
        // Three, six and nine events in all: a window waits for eight.
        ((0.0, 1, false), 120),
        ((0.0, 2, false), 120),
        ((0.0, 3, false), 12),
        // For a repeating motion one slowest period is enough: a quarter of the time.
        ((0.0, 1, true), 1),
        ((2.0 - 1e-9, 0, true), 5),
    ] {
        assert_eq!(returns(needed, events, repeats), expected, "{needed} {events} {repeats}");
    }
}

#[test]
fn a_window_is_refused_beyond_a_hundred_times_its_returns() {
    let (mut motion, section) = slow(10.0);
    let mut passed = Passed::new(&motion, 1e6, 2);
    for _ in 1..200 {
        section.advance(&mut motion, &mut |_| ()).unwrap();
        assert!(!passed.is_enough(&motion, (0, false)).unwrap());
    }
    section.advance(&mut motion, &mut |_| ()).unwrap();
    let error = passed.is_enough(&motion, (0, false)).unwrap_err().to_string();
    assert!(error.contains("200 periods (measured, --periods) last 20 s"), "{error}");
    assert!(error.contains("oscillation, 250000 s") || error.contains("oscillation, 2.5e5 s"), "{error}");
}

#[test]
fn the_last_change_is_the_latest_of_all_signals() {
    let with = |more: &str| text(&format!("{OSCILLATOR}{more}"));
    let body = "[body.p]\nmotion = { steps = [[1.0, 0.1], [7.0, 0.2]] }\n[spring.p]\nbetween = [\"p\", \"a\"]\nstiffness = 1.0\n";
    let force =
        "[friction.h]\nbetween = [\"ground\", \"a\"]\nforce = { constant = 1.0, steps = [[5.0, 1.0]] }\n";
    let fixed = "[friction.h]\nbetween = [\"ground\", \"a\"]\nforce = 1.0\nstatic = { constant = 2.0, steps = [[4.0, 1.0]] }\n";
    let load = "[load.g]\non = \"a\"\nsteps = [[6.0, 1.0]]\n";
    for (more, end, words) in [
        (body, 7.0, "body.p.motion has a step at 7 s"),
        (force, 5.0, "friction.h.force has a step at 5 s"),
        (fixed, 4.0, "friction.h.static has a step at 4 s"),
        (load, 6.0, "load.g has a step at 6 s"),
        (&format!("{body}{load}{force}"), 7.0, "body.p.motion has a step at 7 s"),
        (&format!("{force}{load}"), 6.0, "load.g has a step at 6 s"),
        (
            "[load.g]\non = \"a\"\nsweep = { amplitude = 1.0, from = 1.0, to = 2.0, duration = 6.0 }\n\
             steps = [[1.0, 1.0]]\nrepeat = 9.0\n",
            6.0,
            "load.g is a sweep up to 6 s",
        ),
    ] {
        let d = with(more).description;
        assert_eq!(runs_on(&d, end - 0.1).as_deref(), Some(words));
        assert_eq!(runs_on(&d, end), None, "{more}");
        // Periods of 0.2 s: this number of returns lasts from the start to the change.
        let returns = (end / 0.2).round() as u32;
        let section = Section::Period(0.2);
        assert_eq!(runs_on_beyond(&d, &section, 0.0, returns - 1).as_deref(), Some(words));
        assert_eq!(runs_on_beyond(&d, &section, 0.0, returns + 1), None);
        assert_eq!(runs_on_beyond(&d, &Section::Stop(0), 0.0, returns + 1).as_deref(), Some(words));
    }
    assert_eq!(runs_on(&with("").description, 0.0), None);
}

/// An oscillator with its drive and a step of the drive at 3 s.
fn stepped() -> Machine {
    let signal = "amplitude = 10.0\nfrequency = \"5 Hz\"";
    text(&OSCILLATOR.replace(signal, &format!("{signal}\nsteps = [[3.0, 1.0]]")))
}

#[test]
fn what_is_discarded_ends_after_the_last_change_or_after_as_many_returns_as_asked() {
    let (mut motion, section) = stepped().motion(&Start::default()).unwrap();
    settle(&mut motion, &section, 10).unwrap();
    assert!((motion.time() - 2.0).abs() < 1e-9, "{}", motion.time());
    // The change comes after 15 of 20 returns: 20 more returns follow.
    let (mut motion, section) = stepped().motion(&Start::default()).unwrap();
    settle(&mut motion, &section, 20).unwrap();
    assert!((motion.time() - 7.0).abs() < 1e-9, "{}", motion.time());
}
