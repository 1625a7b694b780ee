//! The component as used by a door.

use super::*;
use crate::component::log::{Category, Log};
use crate::component::structure;
use crate::component::variables::{
    Base, Bases, Causality, Edition, VARIABLES, Variability, place, reference,
};
use fmi_doors::{Component as _, EventHandling, Model as _, StepOutcome};

mod announced;
mod closed;
mod dependencies;
mod derivative;
mod exchange;
mod finite;
mod memory;
mod momentum;
mod prediction;
mod sensitivity;
mod step;
mod values;

/// All types.
const ANY: Bases =
    Bases::new("any", &[Base::Real, Base::Integer, Base::Boolean, Base::Enumeration, Base::Clock]);

/// Keeps the log messages.
#[derive(Default)]
struct Messages(Vec<(Category, String)>);

impl Log for Messages {
    fn wants(&self, _: Category) -> bool {
        true
    }
    fn log(&mut self, category: Category, message: &str) {
        self.0.push((category, message.to_owned()));
    }
}

/// A log without any enabled category.
struct Silence;

impl Log for Silence {
    fn wants(&self, _: Category) -> bool {
        false
    }
    fn log(&mut self, category: Category, message: &str) {
        panic!("not wanted: {category:?} {message}");
    }
}

fn instance() -> Instance {
    Instance::new(Interface::CoSimulation)
}

fn initialized() -> Instance {
    initialize(instance())
}

fn initialize(mut instance: Instance) -> Instance {
    instance.set_experiment(None, 0.0, None).unwrap();
    instance.enter_initialization();
    instance.exit_initialization(&mut Messages::default()).unwrap();
    instance
}

/// A component with the given start values, for a host that may handle events and may accept early
/// returns; in Step Mode.
fn with_handling(event_mode: bool, early_return: bool, start: &[(&str, f64)]) -> Instance {
    let handling = EventHandling { event_mode, early_return };
    stepping(Protocol { handling, ..Protocol::default() }, start)
}

/// A component of a protocol with the given start values; in Step Mode.
fn stepping(protocol: Protocol, start: &[(&str, f64)]) -> Instance {
    let mut fmu = Instance::of_protocol(Interface::CoSimulation, protocol);
    for (name, value) in start {
        set(&mut fmu, name, *value).unwrap();
    }
    let mut fmu = initialize(fmu);
    if protocol.handling.event_mode {
        fmu.handle_events(&mut Silence).unwrap();
        fmu.leave_event(&mut Silence).unwrap();
    }
    fmu
}

fn get(instance: &mut Instance, name: &str) -> f64 {
    let mut value = f64::NAN;
    instance.get(ANY, &[reference(name)], |_, v| value = v).unwrap();
    value
}

fn set(instance: &mut Instance, name: &str, value: f64) -> Outcome {
    instance.set(ANY, &[reference(name)], |_| value)
}

fn step(instance: &mut Instance, point: f64, size: f64) -> Outcome<StepOutcome> {
    instance.step_without_event_mode(point, size, &mut Messages::default())
}

/// Outputs that show the state of a run.
const MOTION: [&str; 12] = [
    "time",
    "box.s",
    "box.v",
    "box.a",
    "block.s",
    "block.v",
    "secondary.s",
    "stop.s",
    "impacts.upper",
    "impacts.lower",
    "energy.input",
    "energy.impact",
];

fn motion(instance: &mut Instance) -> Vec<u64> {
    MOTION.map(|name| get(instance, name).to_bits()).to_vec()
}

fn restore_bytes(instance: &mut Instance, bytes: &[u8]) -> Outcome {
    instance.restore(&SavedState::deserialize(bytes)?)
}
