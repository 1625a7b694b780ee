use super::*;
use crate::tests::{OSCILLATOR, example, text};
use crate::{Machine, Start};

/// Tolerance for the rounding of a time of some periods, s.
const ROUNDING: f64 = 1e-14;

fn with_frequencies(frequencies: &[f64]) -> Machine {
    let harmonic = |f: &f64| format!("{{amplitude = 1.0, frequency = {f:?}}}");
    let all: Vec<String> = frequencies.iter().map(harmonic).collect();
    let harmonics = format!("harmonics = [{}]", all.join(", "));
    text(&OSCILLATOR.replace("amplitude = 10.0\nfrequency = \"5 Hz\"", &harmonics))
}

#[test]
fn closed_form_common_periods() {
    for (frequencies, period) in [
        (&[5.0][..], Some(0.2)),
        (&[6.0, 10.0, 15.0], Some(1.0)),
        (&[4.0, 0.5], Some(2.0)),
        // 1000 periods of the slowest, and 10,000.
        (&[1.0, 1.001], Some(1000.0)),
        (&[1.0, 1.0001], None),
    ] {
        let found = common_period(&with_frequencies(frequencies).description);
        assert_eq!(found.map(|t| (t * 1e12).round()), period.map(|t: f64| t * 1e12), "{frequencies:?}");
    }
}

#[test]
fn closed_form_what_repeats_counts_in_the_common_period_and_a_sweep_has_none() {
    let with = |signal: &str| text(&OSCILLATOR.replace("amplitude = 10.0\nfrequency = \"5 Hz\"", signal));
    for (signal, period) in [
        // Exactly the written period, without the rounding of a frequency.
        ("steps = [[0.1, 1.0]]\nrepeat = 0.49", Some(0.49)),
        ("steps = [[0.1, 1.0]]\nrepeat = 0.49\namplitude = 1.0\nfrequency = 5.0", Some(9.8)),
        ("table = [[0.1, 0.0], [0.2, 1.0]]\nrepeat = 0.3\namplitude = 1.0\nfrequency = 5.0", Some(0.6)),
    ] {
        let machine = with(signal);
        let found = common_period(&machine.description);
        assert_eq!(found.map(|t| (t * 1e12).round()), period.map(|t: f64| t * 1e12), "{signal}");
        assert!(!is_steady(&machine.description));
    }
    assert_eq!(common_period(&with("steps = [[0.1, 1.0]]\nrepeat = 0.49").description), Some(0.49));
    let swept = with("sweep = { amplitude = 1.0, from = 1.0, to = 5.0, duration = 2.0 }").description;
    assert!(common_period(&swept).is_none() && !is_steady(&swept));
    let error = Section::of(&swept, &SectionRule::Auto).unwrap_err().to_string();
    assert!(
        error.contains("load.f is a sweep, so the loads have no common period; give a period (--period)"),
        "{error}"
    );
}

#[test]
fn closed_form_a_period_ends_at_the_next_whole_multiple() {
    for (section, times) in [
        (Section::Period(0.2), &[(0.0, 0.2), (0.05, 0.2), (0.2, 0.4), (0.2 - 1e-12, 0.4), (0.39, 0.4)][..]),
        (Section::Shifted(0.2, 0.05), &[(0.0, 0.05), (0.05, 0.25), (0.04, 0.05), (0.26, 0.45)]),
    ] {
        for (time, end) in times {
            let found = section.end(*time).unwrap();
            assert!((found - end).abs() < ROUNDING, "{section:?} {time}: {found}");
        }
    }
    assert_eq!((Section::Stop(0).end(1.0), Section::Friction(0).end(1.0)), (None, None));
}

#[test]
fn a_section_holds_what_turns_a_whole_number_of_times() {
    for section in [Section::Period(0.2), Section::Shifted(0.2, 0.05)] {
        let held = [5.0, 10.0, 1.0, 2.5, 7.0, 1e-10].map(|frequency| section.holds(frequency));
        assert_eq!(held, [true, true, false, false, false, false]);
    }
    assert!(!Section::Stop(0).holds(5.0) && !Section::Friction(0).holds(5.0));
}

#[test]
fn a_section_beside_one_of_times_is_neither_it_nor_half_a_period_from_it() {
    let Some(Section::Shifted(period, shift)) = Section::Period(0.2).beside() else { panic!() };
    assert_eq!(period, 0.2);
    assert!((0.3..0.45).contains(&(shift / period)), "{shift}");
    assert_eq!((Section::Stop(0).beside(), Section::Shifted(0.2, 0.1).beside()), (None, None));
}

#[test]
fn only_what_no_signal_changes_is_steady() {
    let file = OSCILLATOR.replace("amplitude = 10.0\nfrequency = \"5 Hz\"", "SIGNAL");
    for (signal, steady) in [
        ("constant = 3.0", true),
        ("amplitude = 1.0\nfrequency = 2.0", false),
        ("steps = [[1.0, 2.0]]", false),
        ("constant = 1.0\nsteps = [[1.0, 2.0]]\namplitude = 1.0\nfrequency = 2.0", false),
    ] {
        assert_eq!(is_steady(&text(&file.replace("SIGNAL", signal)).description), steady, "{signal}");
    }
    let turned =
        "[body.belt]\nmotion = { rate = 0.1 }\n[friction.g]\nbetween = [\"belt\", \"a\"]\nforce = 0.1\n";
    let machine = text(&format!("{}{turned}", file.replace("SIGNAL", "constant = 3.0")));
    assert!(is_steady(&machine.description), "it moves evenly");
    for (motion, steady) in [("rate = { constant = 0.1 }", true), ("acceleration = 0.1", false)] {
        let turned = turned.replace("rate = 0.1", motion);
        let machine = text(&format!("{}{turned}", file.replace("SIGNAL", "constant = 3.0")));
        assert_eq!(is_steady(&machine.description), steady, "{motion}");
    }
}

#[test]
fn a_period_is_a_finite_time_above_zero() {
    let d = text(OSCILLATOR).description;
    for period in [0.0, -1.0, f64::INFINITY, f64::NAN] {
        let error = Section::of(&d, &SectionRule::Period(period)).unwrap_err().to_string();
        assert!(error.contains("expected a finite time > 0"), "{error}");
    }
}

/// Two balls that fall by 0.2 m at 10 m/s² onto two floors reach them together: each floor's event
/// is a return.
#[test]
fn closed_form_an_event_among_others_of_its_instant_is_a_return() {
    let ball = |name: &str| {
        format!(
            "[body.{name}]\nmass = 0.5\ngravity = 1.0\n[stop.{name}]\nbetween = [\"ground\", \"{name}\"]\ngap = 0.2\n\
             restitution = 0.5\n"
        )
    };
    let mut machine = text(&format!("name = \"B\"\ngravity = 10.0\n{}{}", ball("a"), ball("b")));
    for (place, name) in ["a", "b"].into_iter().enumerate() {
        machine.section = SectionRule::Element(format!("stop.{name}"));
        let (mut motion, section) = machine.motion(&Start::default()).unwrap();
        assert_eq!(section, Section::Stop(place));
        let mut followed = motion.clone();
        // The fall takes 0.2 s, and so does the flight after it.
        for time in [0.2, 0.4] {
            section.advance(&mut motion, &mut |_| ()).unwrap();
            section.follow(&mut followed, &mut Flows::default(), &mut []).unwrap();
            assert!((motion.time() - time).abs() < 1e-12, "{name}: {}", motion.time());
            assert_eq!(followed.time(), motion.time());
        }
    }
}

#[test]
fn harmonics_without_a_common_period_beside_constant_signals_are_refused() {
    let friction = "[friction.g]\nbetween = [\"ground\", \"a\"]\nforce = 0.1\n";
    let two = with_frequencies(&[1.0, 1.0001]);
    let machine = text(&format!("{}{friction}", two.description.to_toml()));
    let error = Section::of(&machine.description, &SectionRule::Auto).unwrap_err().to_string();
    assert!(error.contains("no common period"), "{error}");
    // Without harmonics: the first stop, else the first contact, else the first friction.
    let steady = OSCILLATOR.replace("amplitude = 10.0\nfrequency = \"5 Hz\"", "constant = 1.0");
    let stop = "[stop.s]\nbetween = [\"ground\", \"a\"]\ngap = 1.0\nrestitution = 0.5\n";
    let of = |more: &str| Section::of(&text(&format!("{steady}{more}")).description, &SectionRule::Auto);
    assert_eq!(of(friction).unwrap(), Section::Friction(0));
    assert_eq!(of(&format!("{friction}{stop}")).unwrap(), Section::Stop(0));
    let contact = "[body.t]\nmass = 1.0\n[contact.c]\nnormal = [\"ground\", \"a\"]\ntangent = [\"ground\", \"t\"]\n\
                   gap = 1.0\nstiffness = 1e3\ntangential_stiffness = 1e3\nfriction = 0.5\n";
    let sections = [(String::new(), Section::Stop(0)), (stop.to_string(), Section::Stop(1))];
    for (others, section) in sections {
        let machine = text(&format!("{steady}{friction}{others}{contact}"));
        let rule = SectionRule::Element("contact.c".into());
        let found = Section::of(&machine.description, &rule).unwrap();
        assert_eq!((found, found.in_words(&machine.description).as_str()), (section, "events of contact.c"));
    }
    assert_eq!(of(&format!("{friction}{contact}")).unwrap(), Section::Stop(0));
    assert!(of("").unwrap_err().to_string().contains("give a period"));
}

#[test]
fn an_element_without_events_is_waited_for_a_hundred_seconds() {
    let mut machine = example("bouncing_ball.toml");
    machine.description = machine.description.with([("stop.floor.gap", 1e6)]).unwrap();
    let (mut motion, section) = machine.motion(&Start::default()).unwrap();
    let mut followed = motion.clone();
    let error = section.advance(&mut motion, &mut |_| ()).unwrap_err().to_string();
    assert!(error.contains("events of stop.floor: none in the last 100 s, until t = 100.0 s"), "{error}");
    assert!(section.follow(&mut followed, &mut Flows::default(), &mut []).is_err());
    assert_eq!((motion.time(), followed.time()), (100.0, 100.0));
}
