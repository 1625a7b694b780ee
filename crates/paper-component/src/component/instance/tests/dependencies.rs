//! The lists of dependencies compared with numbers: an unlisted value must not change, and a
//! listed value must change somewhere.

use super::*;
use crate::component::closed_form::ClosedForm;
use crate::component::continuous::Continuous;
use crate::component::settings::SolutionMode;
use crate::component::structure::Unknown;
use crate::component::values::OutputValues;
use crate::component::variables::{Access, DependencyKind, Initial, Variable};
use vibro_impact::Parameters;
use vibro_impact::parameters::FIELDS;
use vibro_impact::simulator::{Contact, State};
use vibro_impact::steady::exact_orbit;

/// The coordinates are x1 and x2 - x1, so setting one displacement changes the last digits of
/// another.
const ROUNDING: f64 = 1e-13;

fn moved(a: f64, b: f64) -> bool {
    (a - b).abs() > ROUNDING * (1.0 + a.abs().max(b.abs()))
}

/// A start, given by the values that differ from the start values.
type Start = (&'static str, Interface, Vec<(&'static str, f64)>);

/// Starts that together show every dependency.
fn starts() -> Vec<Start> {
    use Interface::{CoSimulation, ModelExchange};
    let moving = [
        ("time", 0.3),
        ("box.s", 0.1),
        ("box.v", 0.4),
        ("block.s", 0.3),
        ("block.v", -0.2),
        ("secondary.s", 0.2),
        ("secondary.v", 0.5),
    ];
    let loaded: Vec<_> =
        moving.iter().copied().chain([("box.f", 0.1), ("block.f", 0.05), ("secondary.f", 0.02)]).collect();
    let orbit: Vec<_> = loaded.iter().copied().chain([("startOnOrbit", 1.0)]).collect();
    let scales: Vec<_> = moving.iter().copied().chain([("mode", 2.0)]).collect();
    let exact: Vec<_> = moving.iter().copied().chain([("mode", 3.0)]).collect();
    // Only spring and drive press the block on the stop, so that a closed form can be chosen.
    let resting = vec![
        ("time", 0.3),
        ("box.s", 0.5),
        ("box.v", 0.1),
        ("block.s", 1.5),
        ("block.v", 0.1),
        ("secondary.s", 0.2),
        ("secondary.v", 0.5),
    ];
    // No load presses: the secondary oscillator's motion decides the direction of the block.
    let balanced = vec![("drive.amplitude", 0.0), ("block.s", 1.0), ("secondary.s", 1.0)];
    let pushed: Vec<_> = balanced.iter().copied().chain([("secondary.f", 0.1)]).collect();
    // With this x3' the accelerations of box and block change at the same rate: the third
    // derivative of w is zero, and the dampers act in the fourth.
    let driven = vec![
        ("drive.amplitude", 0.25),
        ("drive.frequency", 1.0),
        ("block.s", 1.0),
        ("block.m", 0.125),
        ("coupling.k", 0.125),
        ("secondary.s", 1.0),
        ("secondary.v", 0.25),
        ("secondary.f", 0.1),
    ];
    // Undamped at resonance the secondary oscillator has no bound, and there is no steady state.
    let singular = vec![("secondary.c", 0.0), ("coupling.k", 0.008)];
    let nearly = vec![("secondary.c", 1e-18), ("coupling.k", 0.008)];
    let detuned = vec![("secondary.k", 0.12)];
    // This orbit of plastic impacts passes through the stops: a motion that starts on it at an
    // impact comes to rest.
    let parameters = Parameters { stop_restitution: 0.0, drive_amplitude: 0.4, ..Parameters::default() };
    let phase = exact_orbit::solve(&parameters).unwrap().upper.unwrap().drive_phase();
    let plastic = vec![
        ("stop.restitution", 0.0),
        ("drive.amplitude", 0.4),
        ("drive.phase", phase),
        ("startOnOrbit", 1.0),
    ];
    // With another restitution the steady state does not exist, or is on the other branch.
    let weak = vec![("drive.amplitude", 0.06)];
    let left = vec![("drive.amplitude", 0.085)];
    vec![
        ("flight", CoSimulation, loaded.clone()),
        ("flight for a solver", ModelExchange, loaded),
        ("on the orbit", CoSimulation, orbit.clone()),
        ("on the orbit for a solver", ModelExchange, orbit),
        ("multiple scales", CoSimulation, scales),
        ("exact orbit", CoSimulation, exact),
        ("rest", CoSimulation, resting.clone()),
        ("rest for a solver", ModelExchange, resting),
        ("balanced", CoSimulation, balanced),
        ("balanced and pushed", CoSimulation, pushed),
        ("balanced and driven", CoSimulation, driven),
        ("without a steady state", CoSimulation, singular),
        ("hardly without one", CoSimulation, nearly),
        ("detuned", CoSimulation, detuned),
        ("plastic", CoSimulation, plastic),
        ("near the fold", CoSimulation, weak),
        ("on the left branch", CoSimulation, left),
    ]
}

/// Every initial unknown, by its index; `None` if the start is not possible.
fn initial(interface: Interface, values: &[(&str, f64)]) -> Option<Vec<f64>> {
    let mut fmu = Instance::new(interface);
    let mut time = 0.0;
    for (name, value) in values {
        match *name {
            "time" => time = *value,
            name => set(&mut fmu, name, *value).ok()?,
        }
    }
    fmu.set_experiment(None, time, None).ok()?;
    fmu.enter_initialization();
    let unknowns = structure::initial_unknowns(Edition::Clocked);
    let mut read = vec![0.0; VARIABLES.len()];
    for Unknown { place, .. } in &unknowns {
        fmu.get(ANY, &[VARIABLES[*place].reference], |_, value| read[*place] = value).ok()?;
    }
    // The motion starts with the values shown in initialization.
    fmu.exit_initialization(&mut Messages::default()).ok()?;
    for unknown in unknowns {
        let name = VARIABLES[unknown.place].name;
        let shown = read[unknown.place];
        assert!(!moved(get(&mut fmu, name), shown), "{name} on leaving initialization");
    }
    Some(read)
}

/// Other values to try.
fn others(name: &str, value: f64) -> Vec<f64> {
    match name {
        "mode" => vec![1.0, 2.0, 3.0],
        "startOnOrbit" | "stopAtImpact" => vec![0.0, 1.0],
        "time" => vec![value + 0.25, value + 2.0],
        name if FIELDS.iter().any(|field| field.name == name) => {
            vec![
                0.0,
                0.5 * value,
                0.99 * value,
                1.01 * value,
                2.0 * value,
                10.0 * value,
                100.0 * value,
                value + 0.25,
            ]
        }
        _ => vec![value + 0.01, value - 0.01, value + 0.5, value - 0.5, value + 5.0, 0.0],
    }
}

fn knowns_of_initialization() -> impl Iterator<Item = (usize, &'static str, f64)> {
    let known = |v: &Variable| {
        v.initial == Some(Initial::Exact) || matches!(v.causality, Causality::Input | Causality::Independent)
    };
    let knowns = VARIABLES.iter().enumerate().filter(move |(_, v)| known(v));
    knowns.map(|(i, v)| (i, v.name, v.start().unwrap_or(0.0)))
}

/// `moves[unknown][known]` must agree with the lists.
fn check(
    unknowns: &[Unknown],
    listed: impl Fn(&Unknown, usize) -> bool,
    moves: impl Fn(usize, usize) -> bool,
    knowns: &[usize],
) {
    let mut wrong = Vec::new();
    for unknown in unknowns {
        for &known in knowns {
            let (says, moves) = (listed(unknown, known), moves(unknown.place, known));
            if says != moves {
                let [unknown, known] = [unknown.place, known].map(|i| VARIABLES[i].name);
                let what = if says { "is listed and never moves" } else { "moves and is not listed" };
                wrong.push(format!("{unknown} by {known} {what}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn second_method_initial_unknowns_move_with_what_they_list_alone() {
    let mut moves = vec![vec![false; VARIABLES.len()]; VARIABLES.len()];
    for (what, interface, start) in starts() {
        let base = initial(interface, &start).unwrap_or_else(|| panic!("{what}"));
        for (known, name, default) in knowns_of_initialization() {
            let value = start.iter().find(|(n, _)| *n == name).map_or(default, |(_, value)| *value);
            for other in others(name, value) {
                let mut values: Vec<_> = start.iter().copied().filter(|(n, _)| *n != name).collect();
                values.push((name, other));
                let Some(read) = initial(interface, &values) else { continue };
                for (unknown, moves) in moves.iter_mut().enumerate() {
                    moves[known] |= moved(base[unknown], read[unknown]);
                }
            }
        }
    }
    let knowns: Vec<_> = knowns_of_initialization().map(|(known, ..)| known).collect();
    let listed = |unknown: &Unknown, known| unknown.dependencies.iter().any(|(i, _)| *i == known);
    let moves = |unknown: usize, known: usize| moves[unknown][known];
    check(&structure::initial_unknowns(Edition::Clocked), listed, moves, &knowns);
}

/// The outputs of a motion in a given contact at time 0 and later, with given states, as a solver
/// would see them.
fn held(parameters: &Parameters, contact: Contact) -> Vec<OutputValues> {
    let w = if contact == Contact::Flight { 0.3 } else { contact.side() };
    let start = State { x: [0.1, 0.1 + w, 0.2], v: [0.4, 0.4, 0.5] };
    let mut motion = Continuous::at(parameters, start, 0.0, contact, [0.3, 0.5, 0.2]).unwrap();
    let mut read = vec![motion.values()];
    motion.set_time(0.25).unwrap();
    motion.set_state(State { x: [0.2, 0.2 + w, 0.3], v: [0.3, 0.3, 0.4] });
    read.push(motion.values());
    read
}

/// The outputs after an event at the upper stop: an impact after which the block rests or not,
/// with hardly any pressure.
fn after_event(parameters: &Parameters) -> OutputValues {
    const PRESSURE: f64 = 1e-6;
    let state = State { x: [0.1, 1.1, 0.2], v: [0.1, 0.4, 0.5] };
    let forces = |load| [0.3, load, 0.2];
    let merged = (state.v[0] + 0.1 * state.v[1]) / 1.1; // the block has a tenth of the box's mass
    let together = State { v: [merged, merged, state.v[2]], ..state };
    let free = |load| {
        let flight = Continuous::at(&plastic(), together, 0.25, Contact::Flight, forces(load)).unwrap();
        let [a1, a2, _] = flight.values().acceleration;
        a2 - a1
    };
    // Relative acceleration is linear in the load on the block.
    let load = (PRESSURE - free(0.0)) / (free(1.0) - free(0.0));
    let mut motion = Continuous::at(parameters, state, 0.25, Contact::Flight, forces(load)).unwrap();
    motion.handle_event(&mut |_| ());
    motion.values()
}

/// The parameters, with impacts that can end in rest.
fn plastic() -> Parameters {
    Parameters { drive_phase: 0.25, stop_restitution: 0.0, ..Parameters::default() }
}

/// A standard may count parameters among the knowns of outputs.
#[test]
fn second_method_outputs_move_with_the_parameters_they_list_alone() {
    let value = |variable: &Variable, values: &OutputValues| match variable.access {
        Access::Output(reading) | Access::Start { now: reading, .. } => (reading.value)(values),
        Access::Elements(get) => (0..3).map(|i| f64::from(1 << i) * get(values, i)).sum(),
        _ => 0.0,
    };
    let standard = Parameters { drive_phase: 0.25, ..Parameters::default() };
    let closed = |parameters: &Parameters| {
        ClosedForm::new(SolutionMode::MultipleScales, parameters, 0.75).map(|form| form.values()).ok()
    };
    let by_scales = ["box.a", "block.a", "motion.a"];
    assert_eq!(closed(&standard).map(|values| values.acceleration[1]), Some(0.0), "the sawtooth is straight");
    let mut moves = vec![vec![false; VARIABLES.len()]; VARIABLES.len()];
    for field in FIELDS {
        let mut other = standard;
        (field.set)(&mut other, 1.01 * (field.get)(&standard));
        let events = [0.9, 1.1].map(|factor| {
            let mut other = plastic();
            let value = (field.get)(&other);
            (field.set)(&mut other, if value == 0.0 { factor - 0.9 } else { factor * value });
            (after_event(&plastic()), after_event(&other))
        });
        let mut pairs = Vec::new();
        for contact in [Contact::Flight, Contact::RestUpper, Contact::RestLower] {
            pairs.extend(held(&standard, contact).into_iter().zip(held(&other, contact)));
        }
        for (unknown, variable) in VARIABLES.iter().enumerate() {
            let seen = &mut moves[unknown][place(field.name)];
            *seen = pairs.iter().any(|(a, b)| moved(value(variable, a), value(variable, b)));
            // With another gap the event does not occur; earlier counts are kept.
            let counted = variable.name != "stop.state" && field.name == "stop.gap";
            if variable.variability == Variability::Discrete && !counted {
                *seen |= events.iter().any(|(a, b)| moved(value(variable, a), value(variable, b)));
            }
            // Accelerations that do not come from the states but from the closed form.
            if by_scales.contains(&variable.name) {
                let [a, b] =
                    [closed(&standard), closed(&other)].map(|values| value(variable, &values.unwrap()));
                *seen |= moved(a, b);
            }
        }
    }
    // In multiple scales x3'' = -ω1² x3 depends on the drive's frequency, unlike in the
    // simulation.
    let values = closed(&standard).unwrap();
    let square = standard.drive_frequency * standard.drive_frequency;
    assert!((values.acceleration[2] + square * values.x[2]).abs() < ROUNDING);
    moves[place("secondary.a")][place("drive.frequency")] = true;
    for name in ["box.a", "block.a", "secondary.a", "motion.a"] {
        moves[place(name)][place("mode")] = true; // as seen: another law in another mode
    }
    let parameters = VARIABLES.iter().filter(|v| v.causality == Causality::Parameter);
    let knowns: Vec<_> = parameters.map(|v| place(v.name)).collect();
    let listed = |unknown: &Unknown, known| unknown.dependencies.iter().any(|(i, _)| *i == known);
    let moves = |unknown: usize, known: usize| moves[unknown][known];
    check(&structure::outputs(Edition::Clocked), listed, moves, &knowns);
    check(&structure::derivatives(Edition::Clocked), listed, moves, &knowns);
    check(&structure::event_indicators(), listed, moves, &knowns);
}

/// Before the law of an event is applied, the values after the event are shown, with the
/// dependencies after the event.
#[test]
fn dependencies_at_an_event_are_those_after_it() {
    let start = [("stop.restitution", 0.0), ("drive.amplitude", 1.0), ("stopAtImpact", 1.0)];
    let mut fmu = with_handling(true, true, &start);
    let mut rests = 0;
    while rests < 3 {
        let now = fmu.time();
        fmu.step_as_agreed(now, 100.0, &mut Silence).unwrap();
        fmu.enter_event().unwrap();
        let shown = (get(&mut fmu, "stop.state"), fmu.dependencies(reference("block.a")).unwrap());
        fmu.handle_events(&mut Silence).unwrap();
        let after = (get(&mut fmu, "stop.state"), fmu.dependencies(reference("block.a")).unwrap());
        assert_eq!(shown, after);
        rests += usize::from(shown.0 != 1.0);
        fmu.leave_event(&mut Silence).unwrap();
    }
}

/// A point of a motion: displacements, velocities, loads, time.
#[derive(Clone, Copy)]
struct Point {
    x: [f64; 3],
    v: [f64; 3],
    forces: [f64; 3],
    time: f64,
}

impl Point {
    /// The number of a known, if it belongs to a point.
    fn of(&mut self, known: &str) -> Option<&mut f64> {
        let body = ["box.", "block.", "secondary."].iter().position(|body| known.starts_with(body));
        match (known.rsplit('.').next(), body) {
            (Some("s"), Some(body)) => Some(&mut self.x[body]),
            (Some("v"), Some(body)) => Some(&mut self.v[body]),
            (Some("f"), Some(body)) => Some(&mut self.forces[body]),
            _ if known == "time" => Some(&mut self.time),
            _ => None,
        }
    }
}

/// All values that the motion shows in a contact that is held.
fn shown(parameters: &Parameters, contact: Contact, at: Point) -> OutputValues {
    let start = State { x: at.x, v: at.v };
    Continuous::at(parameters, start, at.time, contact, at.forces).unwrap().values()
}

/// A factor of kind discrete is the same at all states, loads and times. A factor of kind tunable
/// is also the same in all contacts, of kind fixed also for all tunable parameters: second
/// derivatives vanish, including mixed ones. All unknowns and knowns come from the table.
#[test]
fn second_method_kinds_by_second_derivatives() {
    const STEP: f64 = 0.25;
    const PRESSED: f64 = 5.0;
    let here = Point { x: [0.1, 0.4, 0.2], v: [0.4, -0.3, 0.5], forces: [0.3, 0.5, 0.2], time: 0.25 };
    let there = Point { x: [-0.4, 0.3, 0.7], v: [-0.2, 0.6, 0.1], forces: [0.1, -0.4, 0.6], time: 1.5 };
    let standard = Parameters { drive_phase: 0.25, ..Parameters::default() };
    let mut tuned = standard;
    for field in FIELDS {
        if VARIABLES[place(field.name)].variability == Variability::Tunable {
            (field.set)(&mut tuned, 1.1 * (field.get)(&standard));
        }
    }
    let every = Edition::Clocked;
    let lists =
        [structure::outputs(every), structure::derivatives(every), structure::event_indicators()].concat();
    let (mut checked, mut wrong) = (std::collections::BTreeSet::new(), Vec::new());
    for Unknown { place: unknown, dependencies } in lists {
        let read = |values: &OutputValues| -> Vec<f64> {
            match VARIABLES[unknown].access {
                Access::Output(reading) | Access::Start { now: reading, .. } => vec![(reading.value)(values)],
                Access::Elements(get) => (0..3).map(|i| get(values, i)).collect(),
                _ => Vec::new(),
            }
        };
        for (known, kind) in dependencies {
            let name = VARIABLES[known].name;
            if kind == DependencyKind::Dependent || here.clone().of(name).is_none() {
                continue;
            }
            let mut factors: Vec<(Contact, bool, Vec<f64>)> = Vec::new();
            for contact in [Contact::Flight, Contact::RestUpper, Contact::RestLower] {
                for (is_tuned, parameters) in [(false, &standard), (true, &tuned)] {
                    for mut base in [here, there] {
                        // In rest the block is pressed on the stop: a stop's force never pulls.
                        base.forces[1] +=
                            PRESSED * if contact == Contact::Flight { 0.0 } else { contact.side() };
                        let middle = *base.of(name).unwrap();
                        let values = [-1.0, 0.0, 1.0].map(|by| {
                            let mut at = base;
                            *at.of(name).unwrap() = middle + by * STEP;
                            read(&shown(parameters, contact, at))
                        });
                        let [low, middle, high] = &values;
                        let slope = |i: usize| (high[i] - low[i]) / (2.0 * STEP);
                        let bend = |i: usize| high[i] - 2.0 * middle[i] + low[i];
                        if (0..middle.len()).any(|i| bend(i).abs() > ROUNDING * (1.0 + middle[i].abs())) {
                            wrong.push(format!("{} by {name}, {kind:?}, bends", VARIABLES[unknown].name));
                        }
                        factors.push((contact, is_tuned, (0..middle.len()).map(slope).collect()));
                    }
                }
            }
            for (i, one) in factors.iter().enumerate() {
                for other in &factors[..i] {
                    let same = match kind {
                        DependencyKind::Discrete => one.0 == other.0 && one.1 == other.1,
                        DependencyKind::Tunable => one.1 == other.1,
                        _ => true,
                    };
                    if same && one.2.iter().zip(&other.2).any(|(a, b)| moved(*a, *b)) {
                        wrong.push(format!(
                            "{} by {name}, {kind:?}: {one:?}, {other:?}",
                            VARIABLES[unknown].name
                        ));
                    }
                }
            }
            checked.insert(kind.name());
        }
    }
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
    assert_eq!(checked.into_iter().collect::<Vec<_>>(), ["constant", "discrete", "fixed", "tunable"]);
}
