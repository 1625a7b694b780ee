//! The current motion, and the sketch at an instant.

use crate::file::{cannot, described, read};
use serde_json::json;
use std::collections::HashMap;
use std::sync::Arc;
use vibro_figures::canvas::{Drawing, flat};
use vibro_machine::mode::{FrictionState, StopState};
use vibro_machine::motion::{Event, EventKind, Reached};
use vibro_machine::system::Part;
use vibro_machine::{Assembly, Motion, Start};
use vibro_machine_component::experiment;
use vibro_sketch::Sketch;
use vibro_studies::{NamedEvent, named, values};
use wasm_bindgen::prelude::*;

/// Memory of the tables of modes, bytes: a page has less memory than a program.
const TABLES: usize = 16 << 20;
/// Sub-steps in one call, after which the worker checks for messages.
const WORK: u64 = 500_000;
/// Number of values in a row before the columns: time, kind, energies and losses.
pub const HEAD: usize = 8;

/// Kinds of an instant: an ordinary one, the last before an event's law, the first after it.
const PLAIN: f64 = 0.0;
const BEFORE: f64 = 1.0;
const AFTER: f64 = 2.0;

/// A machine with its motion.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Bench {
    text: String,
    machine: vibro_studies::Machine,
    assembly: Arc<Assembly>,
    motion: Motion,
    events: Vec<Event>,
    sketch: Sketch,
    /// Index of the body or element of a drawn item, by name.
    bodies: HashMap<String, usize>,
    elements: HashMap<String, usize>,
}

fn begun(assembly: &Arc<Assembly>, events: &mut Vec<Event>) -> Result<Motion, vibro_machine::Error> {
    let motion = Motion::new_observed(assembly.clone(), &mut |event| events.push(event.clone()))?;
    Ok(motion.with_table_memory(TABLES).with_most_work(WORK))
}

#[wasm_bindgen]
impl Bench {
    /// Reads a machine and starts its motion at time 0. Records are passed as names and texts.
    ///
    /// # Errors
    /// The problems of the text, as JSON.
    #[wasm_bindgen(constructor)]
    pub fn new(text: &str, names: Vec<String>, texts: Vec<String>) -> Result<Bench, JsError> {
        let machine = read(text, &names, &texts)?;
        let told = |e: vibro_machine::Error| cannot(text, &e.to_string());
        let assembly = Arc::new(Assembly::new(machine.description.clone()).map_err(told)?);
        let mut events = Vec::new();
        let motion = begun(&assembly, &mut events).map_err(told)?;
        let d = &machine.description;
        let sketch = Sketch::new(d);
        let mut bodies: HashMap<String, usize> = HashMap::new();
        for (i, body) in d.bodies.iter().enumerate().filter(|(_, body)| !body.is_inner()) {
            // A body with several coordinates is drawn as one item that moves with its first node.
            let whole = body.name.split('.').next().unwrap_or_default();
            bodies.entry(whole.to_owned()).or_insert(i);
            bodies.insert(body.name.clone(), i);
        }
        let elements = d.elements().enumerate().map(|(i, element)| (element.name().to_owned(), i)).collect();
        Ok(Self { text: text.to_owned(), machine, assembly, motion, events, sketch, bodies, elements })
    }

    /// The machine as JSON: `name`, `numbers`, `columns`, `bodies`, `elements`, `period`, `stop`
    /// (length of the default experiment, s), `sketch` (`width`, `height`, `names`), `head`
    /// (number of values in a row before the columns).
    pub fn described(&self) -> String {
        let mut all = described(&self.machine, &self.text);
        let told = experiment(&self.assembly);
        let (width, height) = self.sketch.size();
        all["stop"] = json!(told.stop_time);
        all["step"] = json!(told.step_size);
        all["sketch"] =
            json!({ "width": width, "height": height, "names": self.sketch.names().collect::<Vec<_>>() });
        all["head"] = json!(HEAD);
        all.to_string()
    }

    /// Time of the motion, s.
    pub fn time(&self) -> f64 {
        self.motion.time()
    }

    /// The present row: time, kind of the instant (0 ordinary, 1 before an event, 2 after it),
    /// kinetic energy, stored energy, work put in, lost in dashpots and soft stops, lost in
    /// frictions and sliders, lost at impacts (J); the columns; then for each element 1 if it
    /// sticks or is a closed or pressed stop, otherwise 0.
    pub fn now(&self) -> Vec<f64> {
        self.row(PLAIN)
    }

    fn row(&self, kind: f64) -> Vec<f64> {
        let (motion, energy) = (&self.motion, self.motion.energy());
        let (kinetic, stored) = motion.kinetic_and_stored();
        let sum = |all: &[vibro_numerics::double_double::DoubleDouble]| -> f64 {
            all.iter().map(|x| x.value()).sum()
        };
        let put_in = sum(&energy.loads) + energy.motions.value() + energy.switched.value();
        let (damped, rubbed) =
            (sum(&energy.dashpots) + sum(&energy.stops), sum(&energy.frictions) + sum(&energy.branches));
        let mut row =
            vec![motion.time(), kind, kinetic, stored, put_in, damped, rubbed, energy.impacts.value()];
        row.extend(values(motion));
        let (system, mode) = (self.assembly.system(), motion.mode());
        let acts = |parts: &Vec<Part>| {
            parts.iter().any(|part| match *part {
                Part::Stop(i) => matches!(
                    mode.stops[i],
                    StopState::Closed | StopState::Pressed | StopState::Capped | StopState::Rebounding
                ),
                Part::Friction(i) => {
                    !matches!(mode.frictions[i], FrictionState::Up | FrictionState::Down | FrictionState::Off)
                }
                _ => false,
            })
        };
        row.extend(system.parts.iter().map(|parts| f64::from(u8::from(acts(parts)))));
        row
    }

    /// Advances to `end` (s) and returns rows like [`now`](Self::now): `count` equally spaced
    /// instants, the last at `end`, and two rows for each event, before and after its law. At most
    /// about `most` rows are returned: the motion then stops at the last one.
    ///
    /// # Errors
    /// The reason if the motion cannot continue; it stays where the engine stopped.
    pub fn record(&mut self, end: f64, count: u32, most: u32) -> Result<Vec<f64>, JsError> {
        let (begin, mut rows, mut number) = (self.motion.time(), Vec::new(), 0);
        for i in 1..=count {
            let share = f64::from(i) / f64::from(count);
            let next = if i == count { end } else { begin + (end - begin) * share };
            loop {
                let events = &mut self.events;
                let mut tell = |event: &Event| events.push(event.clone());
                if self.motion.advance_before_event(next, &mut tell)? != Reached::Event {
                    break;
                }
                rows.extend(self.row(BEFORE));
                let events = &mut self.events;
                self.motion.apply_event(&mut |event| events.push(event.clone()))?;
                rows.extend(self.row(AFTER));
                number += 2;
                if number >= most {
                    return Ok(rows);
                }
            }
            rows.extend(self.row(PLAIN));
            number += 1;
        }
        Ok(rows)
    }

    /// The events since the last call, as lines of time, kind, element, value, number of stops and
    /// impulse (N s or N m s), separated by tabs. Knots of signals and samples of blocks are left
    /// out.
    pub fn take_events(&mut self) -> String {
        let mut text = String::new();
        let is_told = |event: &Event| event.is_listed() && event.kind != EventKind::Knot;
        for Event { time, kind } in self.events.drain(..).filter(is_told) {
            let NamedEvent { kind: word, element, value, stops } = named(&self.assembly, &kind);
            let impulse = match kind {
                EventKind::Impact { impulse, .. } => format!("{impulse:?}"),
                _ => String::new(),
            };
            let value = value.map_or(String::new(), |x| format!("{x:?}"));
            let stops = stops.map_or(String::new(), |n| n.to_string());
            text += &format!("{time:?}\t{word}\t{element}\t{value}\t{stops}\t{impulse}\n");
        }
        text
    }

    /// Restarts from the machine's own initial state, or from the text of a start file.
    ///
    /// # Errors
    /// The reason if no motion can begin there.
    pub fn restart(&mut self, start: &str) -> Result<(), JsError> {
        self.events.clear();
        self.motion = if start.is_empty() {
            begun(&self.assembly, &mut self.events)?
        } else {
            let start = Start::parse(start, "start", &self.machine.description)?;
            let (motion, _) = self.machine.motion_on(&start)?;
            motion.with_table_memory(TABLES).with_most_work(WORK)
        };
        Ok(())
    }

    /// The sketch with each body moved along the row by `shifts[body]`, and the plates of each
    /// stop apart by `openings[element]` (NaN: as drawn), in drawing units. Returns the numbers of
    /// `vibro_figures::canvas::flat`, in which items are named by `sketch.names`.
    ///
    /// # Errors
    /// If a number is not finite.
    pub fn sketch(&self, shifts: &[f64], openings: &[f64]) -> Result<Vec<f32>, JsError> {
        let shift = |name: &str| self.bodies.get(name).and_then(|&i| shifts.get(i).copied()).unwrap_or(0.0);
        let opening = |name: &str| {
            self.elements.get(name).and_then(|&i| openings.get(i).copied()).filter(|x| x.is_finite())
        };
        Ok(flat(&self.sketch.moved(&shift, &opening))?.numbers)
    }

    /// The words of the sketch, one per line.
    ///
    /// # Errors
    /// None for a machine that was read successfully.
    pub fn words(&self) -> Result<String, JsError> {
        Ok(flat(&self.sketch)?.words.join("\n"))
    }
}
