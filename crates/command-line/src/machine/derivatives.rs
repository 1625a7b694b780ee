//! Derivatives of a motion with respect to parameters of its machine, as tables.

use super::MotionRecord;
use crate::table::{CsvRows, exact};
use crate::{Error, Result};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use vibro_machine::motion::{Event, EventKind};
use vibro_machine::{Assembly, Description, Start};
use vibro_studies::columns;

/// The derivatives of a record's values and of its events' times.
pub struct DerivativeRecord {
    parameters: Vec<String>,
    /// Time and the derivatives, by column and then by parameter.
    rows: Vec<(f64, Vec<Option<f64>>)>,
    /// For each event its kind and the derivatives of its time, by parameter.
    events: Vec<(EventKind, Vec<Option<f64>>)>,
    /// Parameters without derivatives after some time, with the reason.
    lost: Vec<String>,
}

/// Refuses names that are neither parameters of a machine nor numbers of its start, and names that
/// occur twice.
///
/// # Errors
/// [`Error::Refusal`] with the nearest name if a name is unknown; [`Error::Refused`] if a name
/// occurs twice.
pub fn check_parameters(machine: &Description, start: &Start, names: &[String]) -> Result<()> {
    if !names.is_empty() {
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        start.columns(&Assembly::new(machine.clone())?, &names)?;
    }
    for (i, name) in names.iter().enumerate() {
        if names[..i].contains(name) {
            let problem = "is listed twice; list each parameter once".into();
            return Err(Error::Refused { what: format!("--derivatives {name}"), problem });
        }
    }
    Ok(())
}

impl DerivativeRecord {
    /// Derivatives with respect to parameters at the instants and events of a record. Once `asked`
    /// is set, the rest is left out.
    ///
    /// # Errors
    /// As [`check_parameters`].
    pub fn new(record: &MotionRecord, names: &[String], asked: &Arc<AtomicBool>) -> Result<Self> {
        check_parameters(&record.assembly.description, &record.start, names)?;
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let mut events = Vec::new();
        let mut tell = |event: &Event, by: &[Option<f64>]| {
            events.extend(event.is_listed().then(|| (event.kind, by.to_vec())));
        };
        let motion = record.start.differentiated(record.assembly.clone(), &names, &mut tell)?;
        let mut motion = motion.with_interruption(asked.clone());
        let quantities: Vec<_> = record.assembly.description.quantities().collect();
        let mut rows = Vec::new();
        for row in &record.rows {
            // The record gives the reason why it ended. The derivatives until then are kept.
            if motion.advance_observed(row[0], &mut tell).is_err() {
                break;
            }
            let values = quantities.iter().flat_map(|&q| (0..names.len()).map(move |p| (q, p)));
            rows.push((row[0], values.map(|(q, p)| motion.derivative(q, p)).collect()));
        }
        events.truncate(record.events.len());
        let lost = (0..names.len()).filter_map(|p| Some(format!("by {}: {}", names[p], motion.lost(p)?)));
        let lost = lost.collect();
        Ok(Self { parameters: names.into_iter().map(String::from).collect(), rows, events, lost })
    }

    /// One line for each parameter without derivatives after some time.
    pub fn lost(&self) -> &[String] {
        &self.lost
    }

    /// The text of `derivatives.csv`: `time`, then `COLUMN/PARAMETER` for each column of
    /// `states.csv` and each parameter. A cell is empty if the derivative does not exist.
    ///
    /// # Errors
    /// [`Error::Output`].
    pub fn states(&self, record: &MotionRecord) -> Result<Vec<u8>> {
        let names = columns(&record.assembly.description);
        let names = names.iter().flat_map(|name| self.parameters.iter().map(move |p| format!("{name}/{p}")));
        let mut csv = CsvRows::new(std::iter::once("time".into()).chain(names).collect::<Vec<String>>())?;
        for (time, row) in &self.rows {
            csv.push(std::iter::once(exact(*time)).chain(row.iter().copied().map(cell)))?;
        }
        csv.text()
    }

    /// The text of `event-derivatives.csv`: the row of `events.csv`, counted from 1, then for each
    /// parameter the derivative of the event's time. A cell is empty if the derivative does not
    /// exist.
    ///
    /// # Errors
    /// [`Error::Output`].
    pub fn events(&self, knots: bool) -> Result<Vec<u8>> {
        let mut csv = CsvRows::new(std::iter::once("row").chain(self.parameters.iter().map(String::as_str)))?;
        let listed = self.events.iter().filter(|event| knots || event.0 != EventKind::Knot);
        for (row, (_, by)) in listed.enumerate() {
            csv.push(std::iter::once((row + 1).to_string()).chain(by.iter().copied().map(cell)))?;
        }
        csv.text()
    }
}

fn cell(value: Option<f64>) -> String {
    value.map_or(String::new(), exact)
}
