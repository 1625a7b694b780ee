use super::diagram::{self, DiagramRequest};
use super::*;
use crate::axis::ParameterAxis;
use crate::class::MotionClass;
use crate::paper::lyapunov::{SpectrumOptions, spectrum};
use crate::parts::Task;
use std::sync::Arc;
use vibro_impact::{Parameters, Simulator, State};
use vibro_machine::{Assembly, What, file};

mod measured;
mod natural;
mod starts;
pub(super) mod verdicts;

/// Tolerance for the rounding of a motion that has settled to 1e-9 of its size.
const SETTLED: f64 = 1e-8;
/// Tolerance for the swing of the length of a turning variation: the logarithm of its ratio of
/// axes is divided by 74 s and compared with an exponent of -2/s.
const SWING: f64 = 1e-3;
/// Tolerance for an exponent of a settled motion over a few hundred periods: the variation has
/// aligned to e^(-16), or to a few powers of the multipliers' ratio.
const TURNED: f64 = 1e-4;
/// Relative tolerance: three standard errors of an exponent of chaos over 400 periods; the motions
/// part after a few tens of periods.
const CHAOS: f64 = 0.2;

pub(super) fn example(name: &str) -> Machine {
    let path =
        std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/assembly")).join(name);
    Machine::new(file::read(&path).unwrap())
}

pub(super) fn text(text: &str) -> Machine {
    Machine::new(file::parse(text, "m.toml", &file::no_records).unwrap())
}

pub(super) const OSCILLATOR: &str = "name = \"O\"\n[body.a]\nmass = 2.0\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 800.0\n\
    damping = 8.0\n[load.f]\non = \"a\"\namplitude = 10.0\nfrequency = \"5 Hz\"\n";

/// Measures over 12 returns after 400 discarded ones.
fn measured(machine: &Machine, names: &[&str]) -> Vec<f64> {
    let measures: Vec<Measure> = names.iter().map(|n| n.parse().unwrap()).collect();
    let (mut motion, section) = machine.motion(&Start::default()).unwrap();
    discard(&mut motion, &section, 400).unwrap();
    let found = measure(&mut motion, &section, &measures, 12).unwrap();
    found.numbers.into_iter().map(|x| x.unwrap_or(f64::NAN)).collect()
}

#[test]
fn closed_form_measures_of_a_linear_oscillator() {
    let names = [
        "amplitude.a.s",
        "rms.a.v",
        "maximum.a.a",
        "peak_to_peak.k.f",
        "power.k",
        "power.f",
        "power.lost",
        "exponent",
    ];
    let found = measured(&text(OSCILLATOR), &names);
    let w = 10.0 * std::f64::consts::PI;
    let (k, c) = (800.0 - 2.0 * w * w, 8.0 * w);
    let amplitude = 10.0 / k.hypot(c);
    let power = 0.5 * 8.0 * (w * amplitude).powi(2);
    let force = 2.0 * amplitude * (800.0f64).hypot(8.0 * w);
    let expected = [
        amplitude,
        w * amplitude / 2.0f64.sqrt(),
        w * w * amplitude,
        force,
        power,
        power,
        power,
        // δ'' + 4 δ' + 400 δ = 0.
        -2.0,
    ];
    for ((name, found), expected) in names.iter().zip(found).zip(expected) {
        let near = if *name == "exponent" { SWING } else { SETTLED };
        assert!((found - expected).abs() <= near * expected.abs(), "{name}: {found} {expected}");
    }
}

#[test]
fn closed_form_exponent_beside_a_drive_hundreds_of_times_slower_than_the_damper() {
    // Over one return a variation shrinks by e⁻²⁰⁰⁰, below the range of a double.
    let machine = text(&OSCILLATOR.replace("5 Hz", "1 mHz"));
    let (mut motion, section) = machine.motion(&Start::default()).unwrap();
    let found = settled(&mut motion, &section, Some(16)).unwrap();
    let exponent = found.exponent.unwrap();
    assert_eq!((found.class, exponent.periods), (MotionClass::Periodic(1), 16));
    assert!((exponent.value + 2.0).abs() < SWING, "{exponent:?}");
}

#[test]
fn closed_form_exponent_and_impacts_of_the_impact_pair() {
    let machine = example("impact_pair.toml");
    let (mut motion, section) = machine.motion(&Start::default()).unwrap();
    let found = settled(&mut motion, &section, Some(200)).unwrap();
    assert_eq!((found.class, found.contacts), (MotionClass::Periodic(1), 2.0));
    // The map from one impact to the next, of their times and of the speeds after them. With y the
    // base and v the speed after the impact at t: dt' = ((y'(t) - v) dt + π dv)/(y'(t') - v), dv'
    // = -ε dv + (1 + ε) y''(t') dt'. The second half of a period is its mirror image.
    let (e, v) = (0.5, 1.505_573_953_117_26);
    let c = -(1.0 - e) / (1.0 + e) * v;
    let sine = 0.5 * (std::f64::consts::PI * v - 3.0);
    let (a, b) = ((c + v) / (v - c), std::f64::consts::PI / (v - c));
    let half = [[a, b], [-(1.0 + e) * sine * a, e - (1.0 + e) * sine * b]];
    let (trace, det) = (half[0][0] + half[1][1], half[0][0] * half[1][1] - half[0][1] * half[1][0]);
    let root = (trace * trace - 4.0 * det).sqrt();
    let largest = if root.is_nan() { det.sqrt() } else { 0.5 * (trace.abs() + root) };
    let expected = largest.ln() / std::f64::consts::PI;
    let exponent = found.exponent.unwrap().value;
    assert!((exponent - expected).abs() < TURNED, "{exponent} {expected}");
}

/// The paper's machine as a description and as parameters of the 3-DOF core.
fn paper(amplitude: f64) -> (Machine, Simulator) {
    let machine = example("paper_machine.toml").with([("load.drive.amplitude", amplitude)]).unwrap();
    let p = Parameters { drive_amplitude: amplitude, ..Parameters::default() };
    let start = State { x: [0.0, 0.9, 0.0], v: [0.0, 0.5, 0.0] };
    (machine, Simulator::new(&p, &start, 0.0).unwrap().without_energy_accounts())
}

#[test]
fn second_method_exponents_are_the_3_dof_cores() {
    let p = Parameters::default();
    // With one impact at each stop: to the accuracy to which both have settled. In chaos: to the
    // scatter of two windows.
    for (amplitude, near) in [(p.drive_amplitude, 5e-3), (p.drive_amplitude * 3.6 / 1.5, CHAOS)] {
        let (machine, mut core) = paper(amplitude);
        let period = 2.0 * std::f64::consts::PI / core.parameters().drive_frequency;
        core.advance_to(400.0 * period).unwrap();
        let options = SpectrumOptions { periods: 400, ..SpectrumOptions::default() };
        let exponents = spectrum(&mut core, &options).unwrap().exponents;
        let (mut motion, section) = machine.motion(&Start::default()).unwrap();
        discard(&mut motion, &section, 400).unwrap();
        let found = settled(&mut motion, &section, Some(400)).unwrap();
        // One of the core's seven exponents is the zero of the drive's phase.
        let is_chaos = found.class == MotionClass::Chaotic;
        let expected = if is_chaos { exponents[0] } else { exponents[1] };
        let own = found.exponent.unwrap().value;
        assert!((own - expected).abs() < near * expected.abs(), "{own} {exponents:?} {:?}", found.class);
        assert_eq!(is_chaos, near == CHAOS);
    }
}

#[test]
fn second_method_measures_are_the_3_dof_cores() {
    let (machine, mut core) = paper(Parameters::default().drive_amplitude);
    let period = core.parameters().period();
    core.advance_to(400.0 * period).unwrap();
    let of_core: Vec<crate::paper::measures::Measure> =
        ["amplitude.x1", "rms.x2", "amplitude.w", "impacts", "impact.speed", "impact.impulse"]
            .map(|n| n.parse().unwrap())
            .into();
    let theirs = crate::paper::measures::measure(&mut core, &of_core, 12).unwrap();
    let names = [
        "amplitude.box.s",
        "rms.block.s",
        "amplitude.upper.e",
        "impacts",
        "impact.speed.upper",
        "impact.impulse.upper",
    ];
    for ((name, own), core) in names.iter().zip(measured(&machine, &names)).zip(theirs.numbers) {
        let core = core.unwrap();
        assert!((own - core).abs() < 1e-6 * core, "{name}: {own} {core}");
    }
}

#[test]
fn invariant_what_loads_put_in_is_lost_in_the_elements() {
    let machine = example("damper_with_buffer.toml");
    let names = ["power.shaker", "power.lost", "power.mount", "power.steel", "power.buffer", "power.guide"];
    let found = measured(&machine, &names);
    assert!((found[0] - found[1]).abs() < 1e-6 * found[0], "{found:?}");
    assert!((found[2..].iter().sum::<f64>() - found[1]).abs() < 1e-12 * found[1]);
    assert!(found[2..].iter().all(|p| *p > 0.0), "{found:?}");
}

#[test]
fn sections_are_common_periods_or_events() {
    let of = |machine: &Machine| Section::of(&machine.description, &machine.section);
    let mut machine = text(OSCILLATOR);
    assert_eq!(of(&machine).unwrap(), Section::Period(0.2));
    machine.section = SectionRule::Period(0.7);
    assert_eq!(of(&machine).unwrap(), Section::Period(0.7));
    machine.section = SectionRule::Element("stop.x".into());
    assert!(of(&machine).unwrap_err().to_string().contains("no stop, contact or friction has this name"));
    let two = OSCILLATOR.replace(
        "amplitude = 10.0\nfrequency = \"5 Hz\"",
        "harmonics = [{amplitude = 1.0, frequency = 5.0}, {amplitude = 1.0, frequency = 7.5}]",
    );
    assert_eq!(of(&text(&two)).unwrap(), Section::Period(0.4));
    let none = two.replace("7.5", "7.071067811865475");
    assert!(of(&text(&none)).unwrap_err().to_string().contains("no common period"));
    assert_eq!(of(&example("bouncing_ball.toml")).unwrap(), Section::Stop(0));
    // A belt drags a block until it slips and sticks again: one return per cycle.
    let mut belt = example("brake_squeal.toml");
    belt.section = SectionRule::Auto;
    let (mut motion, section) = belt.motion(&Start::default()).unwrap();
    discard(&mut motion, &section, 50).unwrap();
    let found = settled(&mut motion, &section, None).unwrap();
    assert_eq!(found.class, MotionClass::Periodic(1), "{found:?}");
}

#[test]
fn second_method_a_diagram_is_its_motions_one_by_one_and_its_parts_are_the_whole() {
    let machine = example("damper_with_buffer.toml");
    let axis = ParameterAxis::of("stop.steel.gap".to_owned(), (4e-3, 6e-3), 3).unwrap();
    let of = "block.s".parse().unwrap();
    let request = DiagramRequest {
        axis,
        of,
        at_section: false,
        discard: 150,
        keep: 12,
        exponents: None,
        anew: false,
        start: Start::default(),
    };
    let found = diagram::diagram(&machine, &request, &Task::ALL).unwrap().unwrap();
    let first = found.up[0].as_ref().unwrap();
    let top = measured(&machine.with([("stop.steel.gap", 4e-3)]).unwrap(), &["maximum.block.s"])[0];
    let largest = first.maxima.last().unwrap().0;
    assert!((largest - top).abs() < 1e-6 * top.abs(), "{largest} {top}");
    let again = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let one = again.install(|| diagram::diagram(&machine, &request, &Task::ALL)).unwrap().unwrap();
    assert_eq!(one, found);
    let wrong = DiagramRequest { of: "blok.s".parse().unwrap(), ..request };
    let error = diagram::diagram(&machine, &wrong, &Task::ALL).unwrap_err().to_string();
    assert!(error.contains("did you mean `block.s`?"), "{error}");
}

/// Tolerance for the rounding of motions that repeat.
const REPEATS: f64 = 1e-6;

/// Measures of the unchanged machine, by a sweep.
fn swept(machine: &Machine, names: &[&str], discard: u32, periods: u32) -> crate::design_sweep::DesignRow {
    let measures = names.iter().map(|n| n.parse().unwrap()).collect();
    let request =
        crate::design_sweep::SweepRequest::<Machine> { measures, discard, periods, ..Default::default() };
    crate::design_sweep::row(machine, &request, 0)
}

#[test]
fn invariant_a_motion_that_repeats_after_some_returns_has_no_spread() {
    // At a section every 0.2/3 s the motion of 0.2 s is 3T, and parts of ten returns are not a
    // multiple of it.
    let mut machine = text(OSCILLATOR);
    machine.section = SectionRule::Period(0.2 / 3.0);
    let row = swept(&machine, &["rms.a.s", "power.k", "maximum.a.s", "class"], 400, 60);
    assert_eq!(row.classes, [MotionClass::Periodic(3)]);
    for output in row.outputs.iter().flatten() {
        assert!(output.is_exact, "{output:?}");
    }
    assert_eq!(row.reason, None);
}

#[test]
fn closed_form_measures_last_four_periods_of_the_slowest_own_oscillation() {
    // Undamped at 1 Hz, from a start of 1 m: cos(2 pi t). A ripple defines the section of 1 ms, so
    // ten returns are 10 ms.
    let slow = "name = \"S\"\n[body.a]\nmass = 1.0\nstart = { s = 1.0 }\n[spring.k]\nbetween = [\"ground\", \"a\"]\n\
        stiffness = 39.47841760435743\n[load.f]\non = \"a\"\namplitude = 1e-9\nfrequency = \"1 kHz\"\n";
    let machine = text(slow);
    let row = swept(&machine, &["peak_to_peak.a.s", "rms.a.s"], 60, 60);
    let number = |i: usize| row.outputs[i].unwrap_or_else(|| panic!("{row:?}")).largest;
    assert!((number(0) - 2.0).abs() < REPEATS, "{row:?}");
    assert!((number(1) - 0.5f64.sqrt()).abs() < 1e-3, "{row:?}");
    // A window is refused if it must last more than a hundred times as long as requested.
    let row = swept(&machine, &["peak_to_peak.a.s"], 60, 10);
    let reason = row.reason.unwrap();
    assert!(
        reason.contains("slowest natural oscillation, 1 s each") && reason.contains("at least 4000 periods"),
        "{reason}"
    );
}

/// A step of the load to 1,600 N at a time. It moves the middle to 2 m.
fn stepped(time: &str) -> Machine {
    let with = format!("amplitude = 10.0\nfrequency = \"5 Hz\"\nsteps = [[\"{time}\", 1600.0]]");
    text(&OSCILLATOR.replace("amplitude = 10.0\nfrequency = \"5 Hz\"", &with))
}

#[test]
fn closed_form_what_does_not_repeat_is_measured_after_its_last_change_or_as_asked() {
    let names = ["maximum.a.s", "class"];
    let swing = measured(&text(OSCILLATOR), &["maximum.a.s"])[0];
    let number = |row: &crate::design_sweep::DesignRow| row.outputs[0].unwrap().largest;
    // A step before the end of the discarded returns: the motion after it is measured.
    let row = swept(&stepped("20 s"), &names, 300, 60);
    assert!((number(&row) - 2.0 - swing).abs() < REPEATS, "{row:?}");
    assert_eq!(row.classes, [MotionClass::Periodic(1)]);
    // A later step: the requested returns are measured, although the motion has settled long
    // before; it has no class.
    let row = swept(&stepped("62 s"), &names[..1], 300, 60);
    assert!(number(&row) > 2.0 + swing, "{row:?}");
    let row = swept(&stepped("200 s"), &names, 300, 60);
    assert!(
        row.reason.as_ref().is_some_and(|r| r.starts_with("class: load.f has a step at 200 s")),
        "{row:?}"
    );
    let row = swept(&stepped("200 s"), &names[..1], 300, 60);
    assert!((number(&row) - swing).abs() < REPEATS, "{row:?}");
}

#[test]
fn a_diagram_of_what_does_not_repeat_is_refused_by_name_or_starts_anew() {
    let axis = ParameterAxis::of("spring.k.damping".to_owned(), (8.0, 9.0), 5).unwrap();
    let of = "a.s".parse().unwrap();
    let request = DiagramRequest {
        axis,
        of,
        at_section: false,
        discard: 100,
        keep: 5,
        exponents: None,
        anew: false,
        start: Start::default(),
    };
    let machine = stepped("200 s");
    let error = diagram::diagram(&machine, &request, &Task::ALL).unwrap_err().to_string();
    assert!(error.starts_with("load.f has a step at 200 s, but ") && error.contains("--anew"), "{error}");
    let anew = DiagramRequest { anew: true, ..request.clone() };
    let found = diagram::diagram(&machine, &anew, &Task::ALL).unwrap().unwrap();
    assert!(found.down.iter().all(Option::is_none) && found.hysteresis().iter().all(|h| !h));
    // All values are observed before the step, and equal the values without it.
    for point in &found.up {
        let point = point.as_ref().unwrap();
        let own = text(OSCILLATOR).with([("spring.k.damping", point.value)]).unwrap();
        let swing = measured(&own, &["maximum.a.s"])[0];
        assert!((point.maxima[0].0 - swing).abs() < REPEATS && point.maxima.len() == 1, "{point:?}");
    }
    // A step within the discarded returns is over at the first value.
    let found = diagram::diagram(&stepped("10 s"), &request, &Task::ALL).unwrap().unwrap();
    assert!(found.up.iter().chain(&found.down).flatten().all(|p| p.maxima[0].0 > 1.9), "{found:?}");
    assert!(found.hysteresis().iter().all(|h| !h));
}

#[test]
fn golden_names_of_quantities_have_their_owners_and_kinds() {
    let named = |text: &str| text.parse::<QuantityName>().unwrap();
    for (text, of, what) in [
        ("block.s", "block", What::S),
        ("body.block.v", "block", What::V),
        ("signal.s", "signal", What::S),
        ("signal.reference", "reference", What::Value),
        ("block.pid.u", "pid.u", What::Value),
        ("pid.u", "pid.u", What::Value),
        ("tube.tip.s", "tube.tip", What::S),
        ("block.tip.s", "block.tip", What::S),
        ("tip.et[1]", "tip", What::TangentE(Some(1))),
        ("contact.tip.slider[0]", "tip", What::Slider(Some(0))),
        ("tip.ft", "tip", What::TangentF(None)),
    ] {
        let found = named(text);
        assert_eq!(found, QuantityName { of: of.into(), what }, "{text}");
        // A signal's name alone does not say that it is a signal.
        let is_value = what == What::Value;
        assert!(is_value || named(&found.to_string()) == found, "{found}");
    }
}
