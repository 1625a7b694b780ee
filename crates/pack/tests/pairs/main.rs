//! Every kind of element with every kind of body, and with every other element: run, draw, FMU and
//! derivatives. `crates/command-line/tests/pairs.rs` has the same machines for `vibro check`.

mod machines;

use fmi_doors::log::{Category, Log};
use fmi_doors::{Bases, Component, EventHandling, Interface, Life, Model, Version};
use machines::{BODIES, ELEMENTS, PLANE, element_at, machine};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use vibro_machine::description::Description;
use vibro_machine::motion::EventKind;
use vibro_machine::{Assembly, Differentiated, Motion, file};
use vibro_machine_component::{Machine, Plan};

/// Length of a motion, s.
const END: f64 = 1.0;
/// Largest difference of the two forms, relative to the size of a kind of quantity: rounding,
/// magnified by a second of impacts.
const WRITINGS: f64 = 1e-9;
/// Largest error of the energy balance, relative to the work put in: rounding.
const BALANCE: f64 = 1e-11;

fn described(text: &str) -> Description {
    file::parse(text, "machine.toml", &file::no_records).unwrap_or_else(|refusal| panic!("{refusal}\n{text}"))
}

/// The machines in both forms.
fn all() -> impl Iterator<Item = (usize, [Description; 2])> {
    (0..ELEMENTS.len()).map(|number| (number, machine(number).map(|text| described(&text))))
}

/// A motion from start to end, with the number of impacts by name.
fn followed(d: &Description) -> (Motion, BTreeMap<String, usize>) {
    let assembly = Arc::new(Assembly::new(d.clone()).unwrap());
    let (mut impacts, mut motion) = (BTreeMap::new(), Motion::new(assembly.clone()).unwrap());
    let met = motion.advance_observed(END, &mut |event| {
        if let EventKind::Impact { stop, .. } = event.kind {
            *impacts.entry(assembly.name_of_stop(stop)).or_default() += 1;
        }
    });
    met.unwrap();
    (motion, impacts)
}

#[test]
fn invariant_each_pair_of_elements_and_of_element_and_body_is_in_one_machine() {
    let mut pairs = BTreeSet::new();
    for number in 0..ELEMENTS.len() {
        for (a, b) in (0..BODIES.len()).flat_map(|a| (0..a).map(move |b| (a, b))) {
            let [one, other] = [a, b].map(|body| element_at(number, body));
            assert!(pairs.insert((one.min(other), one.max(other))), "{one} and {other}");
        }
    }
    assert_eq!(pairs.len(), ELEMENTS.len() * (ELEMENTS.len() - 1) / 2);
    assert_eq!(PLANE.len(), BODIES.len());
}

/// Whether a quantity exists in both forms: the hub's, or an element's at a body.
fn is_common(name: &str) -> bool {
    let owner = name.split('.').next().unwrap_or_default();
    owner == "hub"
        || owner.starts_with('e') && !owner.ends_with(|c: char| c.is_ascii_digit())
        || is_element(owner)
}

/// Whether a name belongs to an element at a body, such as `e3`.
fn is_element(name: &str) -> bool {
    name.len() == 2 && name.starts_with('e')
}

#[test]
fn second_method_bodies_written_in_another_way_have_the_same_motion_and_energy() {
    for (number, writings) in all() {
        let [one, other] = writings.map(|d| followed(&d));
        let values = |motion: &Motion| -> BTreeMap<String, f64> {
            let quantities = motion.assembly().description.named_quantities();
            let common = quantities.into_iter().filter(|own| is_common(&own.name));
            common.map(|own| (own.name, motion.value(own.quantity))).collect()
        };
        let [found, exact] = [&one.0, &other.0].map(values);
        assert_eq!(one.1, other.1, "machine {number}: impacts");
        for (name, value) in &found {
            let exact = exact[name];
            let near = (value - exact).abs() <= WRITINGS * (1.0 + exact.abs());
            assert!(near, "machine {number}: {name} is {value} or {exact}");
        }
        assert!(found.len() > 8, "{found:?}");
        for motion in [&one.0, &other.0] {
            let (kinetic, stored) = motion.kinetic_and_stored();
            let energy = motion.energy();
            let work = energy.loads.iter().fold(energy.motions.value().abs(), |sum, x| sum + x.value().abs());
            let begun = Motion::new(motion.assembly().clone()).unwrap().kinetic_and_stored();
            let missing = kinetic + stored - begun.0 - begun.1 - energy.balance();
            assert!(missing.abs() <= BALANCE * (work + kinetic), "machine {number}: {missing} J of {work} J");
        }
    }
}

#[test]
fn invariant_sketches_name_every_element_and_body() {
    for (number, writings) in all() {
        for d in writings {
            let svg = vibro_figures::canvas::svg(&vibro_sketch::Sketch::new(&d)).unwrap();
            let sources = d.sources.len();
            let named = d.elements().filter(|own| own.arms().is_some()).map(|own| own.name().to_owned());
            let blocks = d.blocks.iter().map(|own| own.name.clone());
            for name in named.chain(blocks).chain(["hub".into(), "driven".into()]) {
                // An element between two parts of one body is not drawn.
                let inner = name == "base_tip" || name.ends_with("_ground");
                assert!(inner || svg.contains(&name), "machine {number} with {sources} signals: {name}");
            }
            assert!(vibro_figures::canvas::svg(&vibro_sketch::Sketch::icon(&d)).is_ok());
        }
    }
}

struct Silent;

impl Log for Silent {
    fn wants(&self, _: Category) -> bool {
        false
    }

    fn log(&mut self, _: Category, _: &str) {}
}

#[test]
fn second_method_fmus_show_the_engine_s_motion_and_the_states_of_its_contacts() {
    const STEPS: u32 = 10;
    for (number, [d, _]) in all() {
        let plan = Arc::new(Plan::of(&d).unwrap());
        for version in [Version::Fmi2, Version::Fmi3] {
            assert!(plan.xml(version, None).contains("e5") || number == 12, "machine {number}");
        }
        let mut fmu =
            Machine::new(plan.clone(), Life::new(Interface::CoSimulation, EventHandling::default()));
        fmu.set_experiment(None, 0.0, None).unwrap();
        fmu.enter_initialization();
        fmu.exit_initialization(&mut Silent).unwrap();
        let mut motion = Motion::new(Arc::new(Assembly::new(d.clone()).unwrap())).unwrap();
        let mut impacts: BTreeMap<String, f64> = BTreeMap::new();
        for k in 1..=STEPS {
            let h = END / f64::from(STEPS);
            fmu.step_as_agreed(h * f64::from(k - 1), h, &mut Silent).unwrap();
            let assembly = motion.assembly().clone();
            let met = motion.advance_observed(fmu.time(), &mut |event| {
                if let EventKind::Impact { stop, .. } = event.kind {
                    *impacts.entry(assembly.name_of_stop(stop)).or_default() += 1.0;
                }
            });
            met.unwrap();
        }
        let mut get = |name: &str| {
            let place = plan.table.rows.iter().position(|row| row.name == name)?;
            let mut value = f64::NAN;
            fmu.get(Bases::ANY, &[place as u32 + 1], |_, x| value = x).unwrap();
            Some(value)
        };
        for own in d.named_quantities() {
            let (found, exact) = (get(&own.name).unwrap(), motion.value(own.quantity));
            assert!(
                (found - exact).abs() <= 1e-12 * (1.0 + exact.abs()),
                "machine {number}: {} {found} {exact}",
                own.name
            );
        }
        let rigid = d
            .stops
            .iter()
            .map(|own| ("stop", &own.name))
            .chain(d.freewheels.iter().map(|own| ("freewheel", &own.name)));
        for (section, name) in rigid {
            let Some(counted) = get(&format!("{name}.impacts")) else { continue };
            let met = impacts.get(&format!("{section}.{name}")).copied().unwrap_or(0.0);
            assert!((counted - met).abs() < 0.5, "machine {number}: {name} {counted} of {met}");
            // Closed is 1: an engaged freewheel has zero rate, and a free-running one has zero
            // force.
            if section == "freewheel" {
                let [state, rate, force] =
                    ["state", "rate", "f"].map(|what| get(&format!("{name}.{what}")).unwrap());
                assert_eq!(state > 0.5, rate.abs() < 1e-9, "machine {number}: {name} {state} {rate} {force}");
            }
        }
    }
}

#[test]
fn second_method_derivatives_by_a_number_of_each_element_against_differences() {
    // Relative change of a parameter; the error is its square, plus rounding divided by it.
    const CHANGE: f64 = 1e-6;
    const DIFFERENCE: f64 = 3e-5;
    let (mut compared, mut elements) = (0, BTreeSet::new());
    for (number, [d, _]) in all() {
        let parameters = d.parameters();
        let of = |place: usize| {
            let own = |name: &str| name.split('.').nth(1).is_some_and(|own| own == format!("e{place}"));
            let may =
                |name: &str| ![".repeat", ".sample", ".delay", ".time"].iter().any(|end| name.ends_with(end));
            let all = parameters.iter().filter(|by| own(&by.name) && may(&by.name) && by.value != 0.0);
            all.map(|by| by.name.clone()).nth(number % 2)
        };
        let names: Vec<(usize, String)> =
            (0..BODIES.len()).filter_map(|place| Some((place, of(place)?))).collect();
        let columns: Vec<&str> = names.iter().map(|own| own.1.as_str()).collect();
        let mut motion = Differentiated::new(Arc::new(Assembly::new(d.clone()).unwrap()), &columns).unwrap();
        motion.advance_to(END).unwrap();
        let hub = d.named_quantities().into_iter().find(|own| own.name == "hub.s").unwrap().quantity;
        for (p, (place, name)) in names.iter().enumerate() {
            let Some(found) = motion.derivative(hub, p) else { continue };
            let value = d.get(name).unwrap();
            let at = |change: f64| {
                let other = d.with([(name.as_str(), value * (1.0 + change))]).unwrap();
                let mut motion = Motion::new(Arc::new(Assembly::new(other).unwrap())).unwrap();
                motion.advance_to(END).unwrap();
                motion.value(hub)
            };
            let exact = (at(CHANGE) - at(-CHANGE)) / (2.0 * CHANGE * value);
            let size = found.abs().max(exact.abs()).max(1e-4 / value.abs());
            assert!(
                (found - exact).abs() < DIFFERENCE * size,
                "machine {number}: hub.s by {name}: {found} {exact}"
            );
            compared += 1;
            elements.insert(element_at(number, *place));
        }
    }
    assert!(compared > 90 && elements.len() > 22, "{compared} {elements:?}");
}
