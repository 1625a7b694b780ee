//! The instance as a host would use it, without the C interface.

use super::*;
use crate::fmi2::logging::{Category, Status};
use crate::fmi2::variables::{Base, Causality, VARIABLES, Variability, find, reference};

mod closed;
mod derivative;
mod exchange;
mod memory;
mod step;
mod values;

/// Keeps what is logged.
#[derive(Default)]
struct Messages(Vec<(Status, Category, String)>);

impl Log for Messages {
    fn log(&mut self, status: Status, category: Category, message: &str) {
        self.0.push((status, category, message.to_owned()));
    }
}

fn instance() -> Instance {
    Instance::new("test", Interface::CoSimulation, &description::guid(), true).unwrap()
}

fn initialized() -> Instance {
    initialize(instance())
}

fn initialize(mut instance: Instance) -> Instance {
    instance.setup_experiment(None, 0.0, None).unwrap();
    instance.enter_initialization_mode().unwrap();
    instance.exit_initialization_mode(&mut Messages::default()).unwrap();
    instance
}

fn get(instance: &mut Instance, name: &str) -> f64 {
    let reference = [find(name).unwrap().0];
    let mut value = f64::NAN;
    instance.get(VARIABLES[reference[0] as usize].base(), &reference, |_, v| value = v).unwrap();
    value
}

fn set(instance: &mut Instance, name: &str, value: f64) -> Outcome {
    let reference = [find(name).unwrap().0];
    instance.set(VARIABLES[reference[0] as usize].base(), &reference, |_| value)
}

fn step(instance: &mut Instance, point: f64, size: f64) -> Outcome {
    instance.do_step(point, size, &mut Messages::default())
}

/// Outputs that show where a run is.
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
    let saved = instance.deserialize(bytes)?;
    instance.set_fmu_state(&saved)
}
