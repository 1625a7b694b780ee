//! Machines of the user's own, from the text file that describes them: what such a machine is, and
//! its motion as tables, a picture and an account. Physics and the file's grammar are in
//! `vibro-assembly`.

mod picture;
mod summary;

pub use picture::figure;
pub use summary::summary;

use crate::table::{CsvRows, exact};
use crate::{Error, Result};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use vibro_analysis::assembly::{
    self, Contact, Contacts, Extreme, Extremes, Followed, Machine, NamedEvent, Place, What, columns, named,
    values,
};
use vibro_assembly::description::Description;
use vibro_assembly::motion::{Event, EventKind};
use vibro_assembly::{Assembly, Motion};
use vibro_impact::quantities::{Quantity, Unit};

/// Most samples of a motion, a few gigabytes of a table.
const MOST: usize = 10_000_000;

/// Reads a machine's file and replaces parameters, each as `NAME=VALUE`. A value without a unit is
/// in that in which the file or a value before it writes the parameter; `note` hears where it makes
/// a difference.
///
/// # Errors
/// [`Error::Refusal`], with every problem of the file, or of the new values.
pub fn read(path: &Path, set: &[String], note: &mut dyn FnMut(String)) -> Result<Machine> {
    let mut machine = Machine::read(path)?;
    let mut changes = Vec::new();
    for text in set {
        let Some((name, value)) = text.split_once('=') else {
            return Err(Error::form(text, "NAME=VALUE, e.g. stop.upper.gap=5mm"));
        };
        let name = name.trim();
        let read = machine.quantity(name, value)?;
        taken(&[value], &read, text).into_iter().for_each(&mut *note);
        machine.note_unit(name, value);
        changes.push((name, read.value));
    }
    Ok(machine.with(changes)?)
}

/// Words that say in which unit numbers without one were read, where it makes a difference; `read`
/// is one of them.
pub fn taken(numbers: &[&str], read: &Quantity, typed: &str) -> Option<String> {
    let bare = |number: &&str| number.trim().parse::<f64>().is_ok_and(|x| x != 0.0);
    let unit = read.unit.filter(|unit| !unit.is_si() && numbers.iter().any(bare))?;
    Some(read_in(typed, unit))
}

/// Words that say in which unit a number without one was read.
pub fn read_in(typed: &str, unit: &Unit) -> String {
    format!("{typed} is read in {}, the unit in which that parameter was written", unit.symbol())
}

/// The instants 0, end/count, …, end.
///
/// # Errors
/// [`Error::Refused`] for more than ten million of them.
pub fn even_times(end: f64, count: usize) -> Result<Vec<f64>> {
    check_count(count)?;
    Ok((0..=count).map(|k| if k == count { end } else { end * k as f64 / count as f64 }).collect())
}

fn check_count(count: usize) -> Result<()> {
    if count <= MOST {
        return Ok(());
    }
    Err(Error::Refused { what: format!("{count} samples"), problem: format!("allowed are up to {MOST}") })
}

/// Instants from a file: a number in s a line, not before 0 and none before the one above; empty
/// lines and those that begin with `#` are skipped.
///
/// # Errors
/// [`Error::File`]; [`Error::Config`] with the line.
pub fn times_of(path: &Path) -> Result<Vec<f64>> {
    let text = std::fs::read_to_string(path).map_err(Error::file("reading", path))?;
    let mut times: Vec<f64> = Vec::new();
    for (i, line) in text.lines().map(str::trim).enumerate() {
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let least = times.last().copied().unwrap_or(0.0);
        match line.parse::<f64>() {
            Ok(time) if time.is_finite() && time >= least => times.push(time),
            _ => {
                let problem = format!("line {}: {line}: allowed is a time in s, not before {least:?}", i + 1);
                return Err(Error::Config { path: path.into(), problem });
            }
        }
    }
    if times.is_empty() {
        return Err(Error::Config {
            path: path.into(),
            problem: "has no times; allowed are one or more".into(),
        });
    }
    check_count(times.len())?;
    Ok(times)
}

/// A motion at instants, and its events.
pub struct MotionRecord {
    /// The machine.
    pub assembly: Arc<Assembly>,
    /// Names of the columns of `rows`, after `time`: of each body `.s`, `.v`, `.a`, of each element
    /// `.e`, `.rate`, `.f`.
    pub columns: Vec<String>,
    /// Time and values.
    pub rows: Vec<Vec<f64>>,
    /// What happened up to the last instant.
    pub events: Vec<Event>,
    /// Contacts and extremes of the flow.
    pub followed: Followed,
    /// The motion where it ended.
    pub motion: Motion,
    /// Kinetic and stored energy at the start, J.
    pub start: f64,
    /// Why it ended before the last instant, if it did.
    pub ended: Option<Ended>,
}

/// Why a record ended early; what was computed until then is in it.
#[derive(Clone, Debug, PartialEq)]
pub enum Ended {
    /// The motion cannot go on.
    Error(vibro_assembly::Error),
    /// Somebody asked it to.
    Stopped,
}

/// Follows a machine to each of the instants, until `asked` is set; `done` hears of each instant
/// and of each event, as the part of the time that is over. Where coordinates become too large for
/// numbers, the record ends with the instant before.
///
/// # Errors
/// [`Error::Assembly`] for a machine without a motion from its start.
pub fn record(
    machine: Description,
    times: &[f64],
    asked: &Arc<AtomicBool>,
    done: &mut dyn FnMut(f64),
) -> Result<MotionRecord> {
    let assembly = Arc::new(Assembly::new(machine)?);
    let mut events = Vec::new();
    let motion = Motion::new_observed(assembly.clone(), &mut |event| events.push(event.clone()))?;
    let motion = motion.with_interruption(asked.clone());
    let (kinetic, stored) = motion.kinetic_and_stored();
    let start = kinetic + stored - motion.energy().balance();
    let columns = columns(&assembly.description);
    let end = times.last().copied().unwrap_or(0.0);
    let extremes =
        Extremes::new(&watched(&assembly.description)?, (times.first().copied().unwrap_or(0.0), end));
    let followed = Followed::new(Contacts::new(&motion, &events)?, extremes);
    let mut record =
        MotionRecord { assembly, columns, rows: Vec::new(), events, followed, motion, start, ended: None };
    for &time in times {
        record.ended = record.advance(time, &mut |now| done(now / end));
        if record.ended.is_some() {
            return Ok(record);
        }
        let row = std::iter::once(record.motion.time()).chain(values(&record.motion)).collect();
        record.rows.push(row);
        done(time / end);
        if asked.load(Ordering::Relaxed) {
            record.ended = Some(Ended::Stopped);
            return Ok(record);
        }
    }
    Ok(record)
}

/// The quantities whose extremes are told or drawn: coordinates and rates of bodies, forces of
/// stops and friction.
fn watched(d: &Description) -> Result<Vec<Place>> {
    let of = |name: &String, what| assembly::Quantity { of: name.clone(), what };
    let contacts = d.stops.iter().map(|s| &s.name).chain(d.frictions.iter().map(|f| &f.name));
    let all = d.bodies.iter().map(|b| of(&b.name, What::S));
    let all = all.chain(contacts.map(|name| of(name, What::F)));
    let all = all.chain(d.bodies.iter().map(|b| of(&b.name, What::V)));
    all.map(|quantity| Ok(quantity.place(d)?)).collect()
}

/// Kind, element and value of an event, and how many stops took part: the columns of `events.csv`
/// after the time.
pub fn event_in_words(d: &Description, kind: &EventKind) -> [String; 4] {
    let NamedEvent { kind, element, value, stops } = named(d, kind);
    [kind.into(), element, value.map_or(String::new(), exact), stops.map_or(String::new(), |n| n.to_string())]
}

impl MotionRecord {
    /// To an instant; why it ended before, if it did.
    fn advance(&mut self, time: f64, met: &mut dyn FnMut(f64)) -> Option<Ended> {
        let (before, told) = (self.motion.save(), self.events.len());
        let events = &mut self.events;
        let mut tell = |event: &Event| events.push(event.clone());
        match self.followed.advance(&mut self.motion, time, &mut tell, met) {
            Ok(()) => None,
            Err(vibro_assembly::Error::Interrupted { .. }) => Some(Ended::Stopped),
            Err(error) => {
                if let vibro_assembly::Error::Beyond { .. } = error {
                    self.motion.restore(&before);
                    self.events.truncate(told);
                    self.followed.contacts.cut(self.motion.time());
                }
                Some(Ended::Error(error))
            }
        }
    }

    /// The extremes of a body's coordinate or rate.
    fn body(&self, i: usize, what: What) -> &Extreme {
        let d = &self.assembly.description;
        let first = if what == What::S { 0 } else { d.bodies.len() + d.stops.len() + d.frictions.len() };
        &self.followed.extremes.all[first + i]
    }

    /// The extremes of the force of a stop or, after all stops, of a friction.
    fn force(&self, i: usize) -> &Extreme {
        &self.followed.extremes.all[self.assembly.description.bodies.len() + i]
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
            let Contact { begin, end, peak, impulse, speed, lost, .. } = contact;
            let element = contact.element(&self.assembly.description);
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

    /// The text of `states.csv`: every number reads back to the same double.
    ///
    /// # Errors
    /// [`Error::Output`].
    pub fn states(&self) -> Result<Vec<u8>> {
        let mut csv = CsvRows::new(std::iter::once("time").chain(self.columns.iter().map(String::as_str)))?;
        for row in &self.rows {
            csv.push(row.iter().map(|&x| exact(x)))?;
        }
        csv.text()
    }

    /// The text of `events.csv`, with the knots of signals or without.
    ///
    /// # Errors
    /// [`Error::Output`].
    pub fn events(&self, knots: bool) -> Result<Vec<u8>> {
        let mut csv = CsvRows::new(["time", "kind", "element", "value", "stops"])?;
        for event in self.events.iter().filter(|event| knots || event.kind != EventKind::Knot) {
            let [kind, element, value, stops] = event_in_words(&self.assembly.description, &event.kind);
            csv.push([exact(event.time), kind, element, value, stops])?;
        }
        csv.text()
    }

    /// Extents, contacts, events and energies, line by line; `knots` tells whether
    /// [`events`](Self::events) has the knots.
    pub fn account(&self, knots: bool) -> Vec<String> {
        summary::account(self, knots)
    }
}
