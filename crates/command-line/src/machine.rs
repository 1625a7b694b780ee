//! Described machines: reading a file with `--set`, the summary of `vibro check`, and a motion as
//! tables, picture and account. Physics and the file's grammar are in `vibro-machine`.

mod columns;
mod derivatives;
mod fit_record;
mod fitted_file;
mod picture;
mod start;
mod summary;

pub use columns::Chosen;
pub use derivatives::{DerivativeRecord, check_parameters};
pub use fit_record::{check_record, read_record};
pub use fitted_file::write_with_numbers;
pub use picture::figure;
pub use start::read_start;
pub use summary::{steep, summary};

use crate::table::{CsvRows, exact};
use crate::{Error, Result, parameter_file};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use vibro_machine::description::Description;
use vibro_machine::motion::{Event, EventKind};
use vibro_machine::quantity::NamedQuantity;
use vibro_machine::{Assembly, Element, Motion, Quantity, Start, What};
use vibro_numerics::quantities::{self, Unit};
use vibro_studies::{
    ContactRecorder, Extreme, Extremes, Followed, Machine, NamedEvent, StopContact, columns, named, values,
};

/// Error text for a parameter file in place of a machine's file.
const PARAMETER_FILE: &str = "is a parameter file of the paper's machine: expected a machine's \
                              file; use it with the commands for the paper's machine, e.g. `vibro \
                              paper run --config FILE`";

/// Largest number of samples of a motion; this many make a table of a few gigabytes.
const MOST: usize = 10_000_000;

/// Reads a machine's file and replaces parameters, each as `NAME=VALUE`. A value without a unit is
/// in the unit that the file or an earlier value used for the parameter; `note` is called if that
/// unit is not SI. The machine with the new values is checked, not the file's.
///
/// # Errors
/// [`Error::Refused`] if a text of `set` is not valid; [`Error::Refusal`] with all problems if the
/// file or the machine with the new values is not valid.
pub fn read(path: &Path, set: &[String], note: &mut dyn FnMut(String)) -> Result<Machine> {
    let read = if set.is_empty() { Machine::read } else { Machine::read_draft };
    let mut machine = read(path).map_err(|error| match parameter_file::is_at(path) {
        true => Error::Config { path: path.into(), problem: PARAMETER_FILE.into() },
        false => error.into(),
    })?;
    let mut changes = Vec::new();
    for text in set {
        let Some((name, value)) = text.split_once('=').filter(|(name, _)| !name.trim().is_empty()) else {
            let problem = "expected NAME=VALUE, e.g. stop.steel.gap=5mm".into();
            return Err(Error::Refused { what: format!("--set {text}"), problem });
        };
        let name = name.trim();
        let read = machine
            .quantity(name, value)
            .map_err(|error| Error::Refused { what: "--set".into(), problem: error.to_string() })?;
        note_if_not_si(&[value], &read, text).into_iter().for_each(&mut *note);
        machine.note_unit(name, value);
        changes.push((name, read.value));
    }
    let mut machine = machine.with(changes.iter().copied()).map_err(|error| placed(error, path))?;
    for (name, value) in changes {
        let name = machine.description.parameter(name)?.name;
        let words = machine.told(&name, value);
        machine.changes.insert(name, words);
    }
    Ok(machine)
}

/// If the file has the same problems itself, adds their line numbers to the refusal.
fn placed(error: vibro_studies::Error, path: &Path) -> vibro_studies::Error {
    use vibro_studies::Error::Refusal;
    match (error, Machine::read(path)) {
        (Refusal(mut own), Err(Refusal(before))) => {
            for problem in &mut own.problems {
                let known = before.problems.iter().find(|known| known.name == problem.name);
                problem.line = known.and_then(|known| known.line);
            }
            Refusal(vibro_machine::Refusal { file: before.file, ..own })
        }
        (error, _) => error,
    }
}

/// Note of the unit of numbers without one; `None` if the unit makes no difference. `read` is one
/// of the numbers.
pub fn note_if_not_si(numbers: &[&str], read: &quantities::Quantity, typed: &str) -> Option<String> {
    let bare = |number: &&str| number.trim().parse::<f64>().is_ok_and(|x| x != 0.0);
    let unit = read.unit.filter(|unit| !unit.is_si() && numbers.iter().any(bare))?;
    Some(note_of_unit(typed, unit))
}

/// Note of the unit of a number without one.
pub fn note_of_unit(typed: &str, unit: &Unit) -> String {
    format!("{typed} is read in {}, the unit in which that parameter was written", unit.symbol())
}

/// `count` + 1 evenly spaced times from `begin` to `end`, in s.
///
/// # Errors
/// [`Error::Refused`] if there are more than ten million instants, or `end` is not after `begin`.
pub fn even_times((begin, end): (f64, f64), count: usize) -> Result<Vec<f64>> {
    check_count(count)?;
    if end <= begin {
        let problem = format!("must be after {begin:?} s, the time of the start");
        return Err(Error::Refused { what: format!("--until {end:?}"), problem });
    }
    let instant = |k: usize| begin + (end - begin) * k as f64 / count as f64;
    Ok((0..=count).map(|k| if k == count { end } else { instant(k) }).collect())
}

fn check_count(count: usize) -> Result<()> {
    if count <= MOST {
        return Ok(());
    }
    Err(Error::Refused { what: format!("{count} samples"), problem: format!("expected at most {MOST}") })
}

/// Times in s, one per line, not before `begin` and not decreasing. Empty lines and lines that
/// begin with `#` are skipped.
///
/// # Errors
/// [`Error::File`] if the file cannot be read; [`Error::Config`] with the line if a line is not
/// valid; `Config` also for a file without times; [`Error::Refused`] for too many.
pub fn times_of(path: &Path, begin: f64) -> Result<Vec<f64>> {
    let text = std::fs::read_to_string(path).map_err(Error::file("reading", path))?;
    let mut times: Vec<f64> = Vec::new();
    for (i, line) in text.lines().map(str::trim).enumerate() {
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let least = times.last().copied().unwrap_or(begin);
        match line.parse::<f64>() {
            Ok(time) if time.is_finite() && time >= least => times.push(time),
            _ => {
                let problem = match line.parse::<f64>() {
                    Ok(_) => format!("line {}: {line}: expected a time in s, not before {least:?}", i + 1),
                    Err(_) => format!(
                        "line {}: `{line}` is not a number; expected a time in s on each line, without a heading",
                        i + 1
                    ),
                };
                return Err(Error::Config { path: path.into(), problem });
            }
        }
    }
    if times.is_empty() {
        return Err(Error::Config {
            path: path.into(),
            problem: "has no times; expected one or more".into(),
        });
    }
    check_count(times.len())?;
    Ok(times)
}

/// A motion at given instants, with its events and contacts.
pub struct MotionRecord {
    /// The machine.
    pub assembly: Arc<Assembly>,
    /// Names of the columns of `rows` after `time`: `.s`, `.v`, `.a` of each body, then `.e`,
    /// `.rate`, `.f` of each element, then further requested columns.
    pub columns: Vec<String>,
    /// Time and values.
    pub rows: Vec<Vec<f64>>,
    /// Events up to the last instant.
    pub events: Vec<Event>,
    /// Contacts and extremes of the flow.
    pub followed: Followed,
    /// The motion at its end.
    pub motion: Motion,
    /// The start.
    pub start: Start,
    /// Kinetic and stored energy at the start, J.
    pub energy: f64,
    /// Reason why the record ended before the last instant, if it did.
    pub ended: Option<Ended>,
}

/// Reason why a record ended early. The record holds everything computed until then.
#[derive(Clone, Debug, PartialEq)]
pub enum Ended {
    /// The motion cannot continue.
    Error(vibro_machine::Error),
    /// It was asked to stop.
    Stopped,
}

/// Follows a machine from a start to each of the instants, or until `asked` is set. `done` is
/// called at each instant and event with the elapsed fraction of the time. If coordinates
/// overflow, the record ends at the previous instant.
///
/// # Errors
/// [`Error::Assembly`] if the machine has no motion from the start.
pub fn record(
    machine: Description,
    start: &Start,
    times: &[f64],
    asked: &Arc<AtomicBool>,
    done: &mut dyn FnMut(f64),
) -> Result<MotionRecord> {
    record_with(machine, start, (times, &[]), asked, done)
}

/// As [`record`], with further quantities in the rows.
///
/// # Errors
/// As [`record`].
pub fn record_with(
    machine: Description,
    start: &Start,
    (times, further): (&[f64], &[NamedQuantity]),
    asked: &Arc<AtomicBool>,
    done: &mut dyn FnMut(f64),
) -> Result<MotionRecord> {
    let assembly = Arc::new(Assembly::new(machine)?);
    let mut events = Vec::new();
    let motion = start.motion_observed(assembly.clone(), &mut |event| {
        // Sample events of sampled blocks are not listed in tables.
        events.extend(event.is_listed().then(|| event.clone()));
    })?;
    let motion = motion.with_interruption(asked.clone());
    let (kinetic, stored) = motion.kinetic_and_stored();
    let energy = kinetic + stored - motion.energy().balance();
    let mut columns = columns(&assembly.description);
    columns.extend(further.iter().map(|own| own.name.clone()));
    let ends = (times.first().copied().unwrap_or(0.0), times.last().copied().unwrap_or(0.0));
    let extremes = Extremes::new(&watched(&assembly.description), ends);
    let part = |time: f64| (time - start.time) / (ends.1 - start.time);
    let followed = Followed::new(ContactRecorder::new(&motion, &events), extremes);
    let mut record = MotionRecord {
        assembly,
        columns,
        rows: Vec::new(),
        events,
        followed,
        motion,
        start: start.clone(),
        energy,
        ended: None,
    };
    for &time in times {
        record.ended = record.advance(time, &mut |now| done(part(now)));
        if record.ended.is_some() {
            return Ok(record);
        }
        let motion = &record.motion;
        let more = further.iter().map(|own| motion.value(own.quantity) + 0.0);
        let row = std::iter::once(motion.time()).chain(values(motion)).chain(more).collect();
        record.rows.push(row);
        done(part(time));
        if asked.load(Ordering::Relaxed) {
            record.ended = Some(Ended::Stopped);
            return Ok(record);
        }
    }
    Ok(record)
}

/// The quantities whose extremes are printed or drawn: coordinates of bodies, forces of contacts,
/// rates of bodies.
fn watched(d: &Description) -> Vec<Quantity> {
    let bodies = |what| {
        (0..d.bodies.len()).filter(|&i| !d.bodies[i].is_inner()).map(move |i| Quantity::of_body(i, what))
    };
    let forces = d.elements().enumerate().filter(|(_, element)| is_contact(*element));
    let forces = forces.flat_map(|(i, element)| forces_of(i, element));
    bodies(What::S).chain(forces).chain(bodies(What::V)).collect()
}

/// Whether an element is a contact: a stop, a friction element, a contact with friction, or a
/// freewheel.
pub(crate) fn is_contact(element: Element) -> bool {
    matches!(element, Element::Stop(_) | Element::Friction(_) | Element::Contact(_) | Element::Freewheel(_))
}

/// The forces of an element that is a contact: against its elongation, and along its tangents.
pub(crate) fn forces_of(i: usize, element: Element) -> impl Iterator<Item = Quantity> {
    let tangents = element.branches().map(What::TangentF);
    [What::F].into_iter().chain(tangents).map(move |what| Quantity::of_element(i, what))
}

/// Kind, element and value of an event, and the number of stops that took part: the columns of
/// `events.csv` after the time.
pub fn event_in_words(assembly: &Assembly, kind: &EventKind) -> [String; 4] {
    let NamedEvent { kind, element, value, stops } = named(assembly, kind);
    [kind.into(), element, value.map_or(String::new(), exact), stops.map_or(String::new(), |n| n.to_string())]
}

impl MotionRecord {
    /// Advances to an instant. Returns the reason if the motion ended before it.
    fn advance(&mut self, time: f64, met: &mut dyn FnMut(f64)) -> Option<Ended> {
        let (before, told) = (self.motion.save(), self.events.len());
        let events = &mut self.events;
        let mut tell = |event: &Event| events.extend(event.is_listed().then(|| event.clone()));
        match self.followed.advance(&mut self.motion, time, &mut tell, met) {
            Ok(()) => None,
            Err(vibro_machine::Error::Interrupted { .. }) => Some(Ended::Stopped),
            Err(error) => {
                if let vibro_machine::Error::Beyond { .. } = error {
                    self.motion.restore(&before);
                    self.events.truncate(told);
                    self.followed.contacts.cut(self.motion.time());
                }
                Some(Ended::Error(error))
            }
        }
    }

    /// The extremes of an observed quantity.
    fn extreme(&self, quantity: Quantity) -> Option<&Extreme> {
        self.followed.extremes.all.iter().find(|extreme| extreme.quantity == quantity)
    }

    /// The text of `contacts.csv`.
    ///
    /// # Errors
    /// [`Error::Output`].
    pub fn contacts(&self) -> Result<Vec<u8>> {
        let names = ["element", "begin", "end", "peak_force", "impulse", "closing_speed", "energy_lost"];
        let mut csv = CsvRows::new(names)?;
        let cell = |value: Option<f64>| value.map_or(String::new(), exact);
        for contact in self.followed.contacts.all() {
            let StopContact { begin, end, peak, impulse, speed, lost, .. } = contact;
            let element = contact.element(&self.assembly);
            csv.push([
                element,
                exact(begin),
                cell(end),
                cell(peak),
                cell(impulse),
                exact(speed),
                cell(lost),
            ])?;
        }
        csv.text()
    }

    /// The text of `states.csv`. Every number reads back to the same double. `chosen` are the
    /// columns after the time; all columns if it is empty.
    ///
    /// # Errors
    /// [`Error::Output`].
    pub fn states(&self, chosen: &[String]) -> Result<Vec<u8>> {
        let place = |name: &String| self.columns.iter().position(|own| own == name);
        let places: Vec<usize> = match chosen.is_empty() {
            true => (0..self.columns.len()).collect(),
            false => chosen.iter().filter_map(place).collect(),
        };
        let names = places.iter().map(|&k| self.columns[k].as_str());
        let mut csv = CsvRows::new(std::iter::once("time").chain(names))?;
        for row in &self.rows {
            csv.push(std::iter::once(0).chain(places.iter().map(|k| k + 1)).map(|k| exact(row[k])))?;
        }
        csv.text()
    }

    /// The text of `events.csv`; `knots` is whether it includes the knots of signals.
    ///
    /// # Errors
    /// [`Error::Output`].
    pub fn events(&self, knots: bool) -> Result<Vec<u8>> {
        let mut csv = CsvRows::new(["time", "kind", "element", "value", "stops"])?;
        let listed = self.events.iter().filter(|event| event.is_listed());
        for event in listed.filter(|event| knots || event.kind != EventKind::Knot) {
            let [kind, element, value, stops] = event_in_words(&self.assembly, &event.kind);
            csv.push([exact(event.time), kind, element, value, stops])?;
        }
        csv.text()
    }

    /// Extents, contacts, events and energies, line by line; `knots` is whether
    /// [`events`](Self::events) includes the knots.
    pub fn account(&self, knots: bool) -> Vec<String> {
        summary::account(self, knots)
    }
}
