//! Stiffness that steps in time: cosine maps, a solver in 40 digits, energies and differences.

use crate::common::*;
use std::sync::Arc;
use vibro_machine::derivative::Gradient;
use vibro_machine::motion::{Event, EventKind, Reached};
use vibro_machine::{Assembly, Differentiated, Motion, Quantity, What};

/// Roundings of some turns.
const ROUNDING: f64 = 1e-12;
/// Step of central differences; their error is its square plus rounding over the step.
const CHANGE: f64 = 1e-6;
const DIFFERENCE: f64 = 2e-8;

#[track_caller]
fn near(a: f64, b: f64, allowed: f64) {
    assert!((a - b).abs() < allowed * (1.0 + b.abs()), "{a} instead of {b}");
}

/// A gear mesh: stiffness `k` for `share` of the period, then `k` + `step`.
fn mesh([k, step]: [f64; 2], [share, period]: [f64; 2], rest: &str) -> String {
    let time = share * period;
    format!(
        "name = \"Mesh\"\n[body.gear]\nmass = 1.0\nstart = {{ s = 0.3, v = -0.2 }}\n[spring.mesh]\n\
         between = [\"ground\", \"gear\"]\n\
         stiffness = {{ constant = {k:?}, steps = [[{time:?}, {step:?}]], repeat = {period:?} }}\n{rest}"
    )
}

type Map = [[f64; 2]; 2];

/// The map of a state over a time at stiffness k and mass 1.
fn cosine(k: f64, time: f64) -> Map {
    if k == 0.0 {
        return [[1.0, time], [0.0, 1.0]];
    }
    let omega = k.sqrt();
    let (s, c) = (omega * time).sin_cos();
    [[c, s / omega], [-omega * s, c]]
}

fn times(a: Map, b: Map) -> Map {
    [0, 1].map(|i| [0, 1].map(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j]))
}

fn along(map: Map, [s, v]: [f64; 2]) -> [f64; 2] {
    map.map(|row| row[0] * s + row[1] * v)
}

fn state(motion: &Motion) -> [f64; 2] {
    [motion.coordinate(0), motion.rate(0)]
}

/// Checks that kinetic plus stored energy equals the initial energy plus the accounts.
fn balance(motion: &Motion, start: f64) {
    let (kinetic, stored) = motion.kinetic_and_stored();
    near(kinetic + stored - start, motion.energy().balance(), ROUNDING);
}

fn energy(motion: &Motion) -> f64 {
    let (kinetic, stored) = motion.kinetic_and_stored();
    kinetic + stored
}

#[test]
fn closed_form_a_period_is_the_product_of_two_cosine_maps() {
    // In the last case, the second stiffness is 0 except for rounding of the sum.
    for (k, period) in [([4.0, -3.0], 1.7), ([1.0, 2.5], 0.9), ([4.0, -4.0 + 1e-13], 1.1)] {
        let share = 0.375;
        let second = if k[0] + k[1] < 1e-12 { 0.0 } else { k[0] + k[1] };
        let map = times(cosine(second, (1.0 - share) * period), cosine(k[0], share * period));
        let mut motion = Motion::new(assembled(&mesh(k, [share, period], ""))).unwrap();
        let (begun, mut exact) = (energy(&motion), state(&motion));
        for turn in 1..=20 {
            motion.advance_to(f64::from(turn) * period).unwrap();
            exact = along(map, exact);
            let found = state(&motion);
            near(found[0], exact[0], 30.0 * ROUNDING);
            near(found[1], exact[1], 30.0 * ROUNDING);
        }
        assert!(motion.energy().switched.value().abs() > 1e-3);
        balance(&motion, begun);
    }
}

#[test]
fn closed_form_it_grows_within_the_tongue_and_stays_bounded_outside() {
    // Square wave about 1 with the amplitude 0.4: the trace of the period map decides stability.
    let k = [1.4, -0.8];
    for (period, grows) in [(std::f64::consts::PI, true), (2.2, false)] {
        let map = times(cosine(0.6, 0.5 * period), cosine(1.4, 0.5 * period));
        assert_eq!((map[0][0] + map[1][1]).abs() > 2.0, grows);
        let mut motion = Motion::new(assembled(&mesh(k, [0.5, period], ""))).unwrap();
        motion.advance_to(60.0 * period).unwrap();
        let [s, v] = state(&motion);
        assert_eq!(s.hypot(v) > 100.0, grows, "{s} {v}");
        assert_eq!(motion.energy().switched.value() > 100.0, grows);
    }
}

#[test]
fn closed_form_a_step_puts_in_half_its_height_times_the_square() {
    let text = "name = \"One\"\n[body.b]\nmass = 2.0\nstart = { s = 0.5 }\n[spring.k]\nbetween = [\"ground\", \"b\"]\n\
                stiffness = { constant = 8.0, steps = [[0.25, 10.0], [0.5, -18.0]] }\npreload = 3.0\ndamping = 0.7\n";
    let mut motion = Motion::new(assembled(text)).unwrap();
    let begun = energy(&motion);
    let [at_rest, force] = [motion.coordinate(0), motion.spring(0)[2]];
    near(force, 3.0 + 8.0 * at_rest, ROUNDING);
    motion.advance_to(0.25).unwrap();
    let first = motion.coordinate(0);
    near(motion.spring(0)[2], 3.0 + 18.0 * first + 0.7 * motion.rate(0), ROUNDING);
    near(motion.energy().switched.value(), 0.5 * 10.0 * first * first, ROUNDING);
    let mut knots = Vec::new();
    motion.advance_observed(0.6, &mut |event| knots.push(event.clone())).unwrap();
    assert_eq!(knots, [Event { time: 0.5, kind: EventKind::Knot }]);
    balance(&motion, begun);
    // Without stiffness, only the preload and the dashpot act.
    let quantity = Quantity::of_element(0, What::F);
    near(motion.value(quantity), 3.0 + 0.7 * motion.rate(0), ROUNDING);
}

/// A body that bounces on a stop whose stiffness steps.
fn buffer(damping: &str, stiffness: &str) -> String {
    format!(
        "name = \"Buffer\"\ngravity = 9.81\n[body.ball]\nmass = 1.0\ngravity = 1.0\nstart = {{ v = 1.0 }}\n[stop.floor]\n\
         between = [\"ground\", \"ball\"]\ngap = 0.1\n{damping}stiffness = {stiffness}\n"
    )
}

#[test]
fn closed_form_a_stop_steps_while_it_is_pressed() {
    let text = buffer("", "{ constant = 400.0, steps = [[0.12, 500.0]] }");
    let mut motion = Motion::new(assembled(&text)).unwrap();
    let begun = energy(&motion);
    let mut events = Vec::new();
    motion.advance_observed(0.12, &mut |event| events.push(event.clone())).unwrap();
    let [s, v] = state(&motion);
    assert!(s > 0.1 && matches!(motion.stop_state(0), vibro_machine::mode::StopState::Pressed));
    near(motion.stop(0)[2], 900.0 * (s - 0.1), ROUNDING);
    // A cosine about its equilibrium at g/k, by energy up to the velocity at which it leaves.
    motion.advance_observed(0.3, &mut |event| events.push(event.clone())).unwrap();
    let contacts = events.iter().filter(|event| event.kind != EventKind::Knot);
    assert_eq!(contacts.count(), 2, "{events:?}");
    let x = s - 0.1;
    let speed = (v * v + 900.0 * x * x - 2.0 * 9.81 * x).sqrt();
    let left = events.iter().find(|event| matches!(event.kind, EventKind::Free { stop: 0, .. })).unwrap();
    let after = motion.time() - left.time;
    near(motion.rate(0), -speed + 9.81 * after, ROUNDING);
    near(motion.energy().switched.value(), 250.0 * x * x, ROUNDING);
    balance(&motion, begun);
}

#[test]
fn invariant_energies_and_states_of_stops_with_all_laws() {
    // Also through stiffnesses of 0, and with the general law alone.
    let wave = "{ constant = 0.0, table = [[0.0, 400.0], [0.03, 0.0], [0.05, 900.0]], interpolation = \"hold\", repeat = 0.07 }";
    for law in ["no-pull", "elastogap", "pull", "undamped-rebound"] {
        for damping in [0.0, 3.0] {
            let text = buffer(&format!("damping = {damping}\nlaw = \"{law}\"\n"), wave);
            let start = Motion::new(assembled(&text)).unwrap();
            let (begun, general) = (energy(&start), start.clone().by_general_law());
            let found = [start, general].map(|mut motion| {
                for k in 1..200 {
                    motion.advance_to(0.01 * f64::from(k) + 1e-4).unwrap();
                    let (excess, force) = (motion.stop(0)[0] - 0.1, motion.stop(0)[2]);
                    let stiffness = [400.0, 0.0, 900.0]
                        [usize::from(motion.time() % 0.07 > 0.03) + usize::from(motion.time() % 0.07 > 0.05)];
                    if damping == 0.0 {
                        near(force, stiffness * excess.max(0.0), ROUNDING);
                        let pressed = motion.stop_state(0) == vibro_machine::mode::StopState::Pressed;
                        assert_eq!(pressed, excess > 0.0, "{law} {}", motion.time());
                    }
                    let stored = 0.5 * stiffness * excess.max(0.0).powi(2) - 9.81 * motion.coordinate(0);
                    near(motion.kinetic_and_stored().1, stored, ROUNDING);
                    balance(&motion, begun);
                }
                state(&motion)
            });
            near(found[0][0], found[1][0], ROUNDING);
            near(found[0][1], found[1][1], ROUNDING);
        }
    }
}

/// A friction that follows a stepping stop, a rigid stop, and a mesh next to them.
const ALL: &str = include_str!("data/stepped.toml");

fn with(text: &str, name: &str, value: f64) -> Arc<Assembly> {
    let changed = machine(text).with([(name, value)]).unwrap_or_else(|problem| panic!("{problem}"));
    Arc::new(Assembly::new(changed).unwrap())
}

const END: f64 = 0.83;

/// Rounding over two seconds, some 60 knots and 25 events.
const DIGITS: f64 = 1e-12;

#[test]
fn second_method_a_mesh_and_a_buffer_in_40_digits() {
    let wall = ALL.find("[stop.wall]").unwrap();
    let text = ALL[..wall]
        .replace("[body.table]\nmotion = { amplitude = 0.01, frequency = 3.0 }\n", "")
        .replace("\"table\"", "\"ground\"");
    let mut motion = Motion::new(assembled(&text)).unwrap();
    let (mut expected, mut presses, mut count) = (Vec::new(), false, 0);
    for line in include_str!("data/stepped.txt").lines().filter(|line| !line.starts_with('#')) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let time: f64 = words[1].parse().unwrap();
        if words[0] == "event" {
            // The body passes the gap later, without a force.
            if words[2] != "below" || presses {
                presses = words[2] == "pressed";
                expected.push((time, presses));
            }
            continue;
        }
        let mut found = Vec::new();
        motion.advance_observed(time, &mut |event| found.push(event.clone())).unwrap();
        let met = found.iter().filter(|event| event.kind != EventKind::Knot);
        let (all, met): (Vec<_>, Vec<_>) = (std::mem::take(&mut expected), met.collect());
        assert_eq!(met.len(), all.len(), "{met:?} {all:?}");
        for (event, (time, presses)) in met.iter().zip(all) {
            near(event.time, time, DIGITS);
            assert_eq!(matches!(event.kind, EventKind::Press { stop: 0, .. }), presses, "{event:?}");
            count += 1;
        }
        let numbers: Vec<f64> = words[2..].iter().map(|x| x.parse().unwrap()).collect();
        let own = [motion.body(0), motion.body(1)];
        let own = [own[0][0], own[0][1], own[1][0], own[1][1], motion.energy().switched.value()];
        own.iter().zip(&numbers).for_each(|(own, exact)| near(*own, *exact, DIGITS));
    }
    assert!(count >= 15, "{count}");
}

/// Derivatives with respect to numbers, compared with differences of motions; the gradient
/// compared with both.
fn differ(text: &str, names: &[&str]) {
    let mut motion = Differentiated::new(assembled(text), names).unwrap();
    motion.advance_to(END).unwrap();
    let place = Quantity::of_body(0, What::S);
    let mut gradient = Gradient::new(assembled(text), names).unwrap();
    gradient.advance_to(END).unwrap();
    gradient.add(place, 1.0);
    let gradient = gradient.gradient().unwrap();
    for (p, name) in names.iter().enumerate() {
        let value = machine(text).get(name).unwrap();
        let change = CHANGE * value.abs().max(0.1);
        let end = |value: f64| {
            let mut motion = Motion::new(with(text, name, value)).unwrap();
            motion.advance_to(END).unwrap();
            state(&motion)
        };
        let (below, above) = (end(value - change), end(value + change));
        for (k, what) in [What::S, What::V].into_iter().enumerate() {
            let by = motion.derivative(Quantity::of_body(0, what), p);
            let by = by.unwrap_or_else(|| panic!("{name}: {:?}", motion.lost(p)));
            let difference = (above[k] - below[k]) / (2.0 * change);
            near(by, difference, 100.0 * DIFFERENCE);
            assert!(by != 0.0, "{name}");
        }
        near(*gradient[p].as_ref().unwrap(), motion.derivative(place, p).unwrap(), ROUNDING);
    }
}

#[test]
fn second_method_derivatives_by_heights_constants_and_times() {
    let k = "spring.mesh.stiffness";
    let names = [".constant", ".steps[0].height", ".steps[0].time"].map(|end| format!("{k}{end}"));
    let names = names.each_ref().map(String::as_str);
    differ(&mesh([4.0, 9.0], [0.375, 0.31], "preload = 0.7\ndamping = 0.05\n"), &names);
    let stop = "stop.floor.stiffness";
    let names = [".constant", ".steps[0].height", ".steps[0].time"].map(|end| format!("{stop}{end}"));
    let names = names.each_ref().map(String::as_str);
    for damping in ["", "damping = 2.0\n", "damping = 2.0\nlaw = \"pull\"\n"] {
        differ(&buffer(damping, "{ constant = 400.0, steps = [[0.12, 500.0]] }"), &names);
    }
}

#[test]
fn second_method_derivatives_through_steps_friction_and_impacts() {
    differ(
        ALL,
        &[
            "spring.mesh.stiffness.constant",
            "spring.mesh.stiffness.steps[0].height",
            "spring.mesh.stiffness.steps[1].height",
            "spring.mesh.stiffness.steps[1].time",
            "stop.buffer.stiffness.constant",
            "stop.buffer.stiffness.table.scale",
            "stop.buffer.gap",
            "stop.buffer.damping",
            "friction.pad.coefficient",
        ],
    );
}

#[test]
fn invariant_energy_with_prescribed_bodies_friction_and_impacts() {
    let mut motion = Motion::new(assembled(ALL)).unwrap();
    let begun = energy(&motion);
    for k in 1..=300 {
        motion.advance_to(0.01 * f64::from(k)).unwrap();
        balance(&motion, begun);
    }
    let accounts = motion.energy();
    assert!(accounts.frictions[0].value() > 0.01 && accounts.switched.value().abs() > 0.01);
}

#[test]
fn second_method_variations_are_differences_of_motions() {
    let assembly = assembled(ALL);
    let end = |start: &[f64]| {
        let mut motion = Motion::from_state(assembly.clone(), 0.0, start).unwrap();
        motion.advance_to(END).unwrap();
        motion.states().to_vec()
    };
    let start = Motion::new(assembly.clone()).unwrap().states().to_vec();
    let mut motion = Motion::from_state(assembly.clone(), 0.0, &start).unwrap();
    let mut variations = motion.unit_variations();
    while motion.advance_with(END, &mut variations).unwrap() == Reached::Event {}
    motion.pass_event_with(&mut variations).unwrap();
    for column in 0..start.len() {
        let at = |change: f64| {
            let mut start = start.clone();
            start[column] += change;
            end(&start)
        };
        let (below, above) = (at(-CHANGE), at(CHANGE));
        for row in 0..start.len() {
            near(variations[column][row], (above[row] - below[row]) / (2.0 * CHANGE), 100.0 * DIFFERENCE);
        }
    }
}

#[test]
fn a_change_under_way_keeps_places_and_takes_the_new_heights() {
    let text = mesh([4.0, 9.0], [0.375, 0.31], "");
    let mut motion = Motion::new(assembled(&text)).unwrap();
    motion.advance_to(0.2).unwrap();
    let was = state(&motion);
    let motion = motion.changed(with(&text, "spring.mesh.stiffness.steps[0].height", 2.0)).unwrap();
    assert_eq!(state(&motion), was);
    near(motion.spring(0)[2], 6.0 * was[0], ROUNDING);
}

#[test]
fn closed_form_a_start_at_rest_has_the_stiffness_of_time_0() {
    let text = "name = \"Rest\"\ngravity = 10.0\nstart = \"rest\"\n[body.b]\nmass = 2.0\ngravity = 1.0\n[spring.k]\n\
                between = [\"ground\", \"b\"]\nstiffness = { constant = 50.0, steps = [[0.0, 30.0], [1.0, 20.0]] }\n\
                [stop.buffer]\nbetween = [\"ground\", \"b\"]\ngap = 0.05\n\
                stiffness = { constant = 10.0, steps = [[-1.0, 40.0], [2.0, 5.0]] }\n";
    let motion = Motion::new(assembled(text)).unwrap();
    // 80 e + 50 (e - 0.05) = 20.
    near(motion.coordinate(0), 22.5 / 130.0, ROUNDING);
    let mut differentiated =
        Differentiated::new(assembled(text), &["spring.k.stiffness.steps[0].height"]).unwrap();
    differentiated.advance_to(0.5).unwrap();
    let by = differentiated.derivative(Quantity::of_body(0, What::S), 0).unwrap();
    near(by, -22.5 / (130.0 * 130.0), ROUNDING);
}

/// A machine with more coordinates than tables support uses series: next to 14 other oscillators,
/// which do not act on it.
#[test]
fn second_method_machines_with_and_without_tables() {
    let mut large = ALL.to_owned();
    for k in 0..14 {
        large += &format!(
            "[body.x{k}]\nmass = 1.0\nstart = {{ v = 0.1 }}\n[spring.x{k}]\nbetween = [\"ground\", \"x{k}\"]\nstiffness = {k}.5\n"
        );
    }
    let [small, large] = [ALL, &large].map(|text| {
        let mut motion = Motion::new(assembled(text)).unwrap();
        let begun = energy(&motion);
        motion.advance_to(1.5).unwrap();
        balance(&motion, begun);
        [motion.coordinate(0), motion.rate(0), motion.coordinate(1), motion.rate(1)]
    });
    for (a, b) in small.iter().zip(large) {
        near(*a, b, 100.0 * ROUNDING);
    }
}

#[test]
fn invariant_a_saved_motion_goes_on_and_fits_its_machine() {
    let mut motion = Motion::new(assembled(ALL)).unwrap();
    motion.advance_to(0.2).unwrap();
    let saved = motion.save();
    assert!(saved.fits(&assembled(ALL)));
    motion.advance_to(0.7).unwrap();
    let mut again = Motion::resumed(assembled(ALL), &saved).unwrap();
    again.advance_to(0.7).unwrap();
    assert_eq!(state(&again), state(&motion));
}
