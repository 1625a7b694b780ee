//! Checks of a record: finite values of sensible size at increasing times within the motion.

use super::beside::stops_of;
use super::{FitRequest, Free, Measured, Segments};
use crate::error::{Error, Result};
use vibro_machine::Start;
use vibro_machine::description::Description;

/// Smallest and largest magnitude of fitted values, SI: squares of values and of derivatives, and
/// their products, stay within double precision.
const SIZES: (f64, f64) = (1e-60, 1e60);
/// Latest begin of a record after the motion's start: in multiples of the record's duration, and
/// in seconds. The motion is simulated from its start, which takes that long.
const LATE: f64 = 1000.0;
const LATE_SECONDS: f64 = 1e8;
/// How far a record may begin before the motion, relative to its duration: rounding of times.
pub(super) const EARLY: f64 = 1e-9;

fn refused<T>(problem: String) -> Result<T> {
    Err(Error::Described { problem })
}

/// Error if times do not increase; `row` is the word for one entry.
fn rising(name: &str, row: &str, times: &[f64]) -> Result<()> {
    match times.windows(2).position(|pair| pair[1] <= pair[0]) {
        Some(at) => refused(format!(
            "{name}: {row} {} has the time {:?} s after {:?} s; times must increase",
            at + 2,
            times[at + 1],
            times[at]
        )),
        None => Ok(()),
    }
}

/// Error if values are not finite, too large, or all too small.
fn sizes(name: &str, row: &str, values: &[f64]) -> Result<()> {
    let (least, most) = SIZES;
    if let Some(at) = values.iter().position(|x| !x.is_finite()) {
        return refused(format!("{name}: {row} {} is {}; expected a finite number", at + 1, values[at]));
    }
    if let Some(at) = values.iter().position(|x| x.abs() > most) {
        let value = values[at];
        return refused(format!(
            "{name}: {row} {} is {value:e}; expected at most {most:e} in size, SI",
            at + 1
        ));
    }
    let largest = values.iter().enumerate().max_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs()));
    match largest {
        Some((at, value)) if *value != 0.0 && value.abs() < least => refused(format!(
            "{name}: {row} {} is {value:e}, the largest number of the column; expected a number of \
             at least {least:e} in size, SI",
            at + 1
        )),
        _ => Ok(()),
    }
}

/// Error if the first time is before the motion's start and no free record shift or start time can
/// move it inside; also if it is long after the start.
fn begin(name: &str, row: &str, times: &[f64], start: &Start, free: &[Free]) -> Result<()> {
    let (Some(first), Some(last)) = (times.first(), times.last()) else { return Ok(()) };
    let (from, duration) = (start.time, last - first);
    let moves = |own: &Free| match (own.name.as_str(), own.within) {
        ("record.shift", within) => within.is_none_or(|(_, high)| first + high >= from),
        ("start.time", within) => within.is_none_or(|(low, _)| low <= *first),
        _ => false,
    };
    // A record that lies wholly before the start gives no information on its shift.
    let is_moved = *last > from && free.iter().any(moves);
    if *first < from - EARLY * duration && !is_moved {
        return refused(format!(
            "{name}: {row} 1 is {first:?} s, before the start of the motion at {from:?} s; \
             expected times after the start, or record.shift as a free parameter"
        ));
    }
    // A single sample or a short series of contacts may come late.
    let is_late = row == ROW && duration > 0.0 && first - from > LATE * duration;
    if is_late || first - from > LATE_SECONDS {
        return refused(format!(
            "{name}: {row} 1 is {first:?} s, too long after the start of the motion at {from:?} s: \
             expected a record that begins within {LATE} times its own duration and within \
             {LATE_SECONDS:e} s after the start; use a start at a later time, or subtract a \
             constant from all times of the record"
        ));
    }
    Ok(())
}

/// Words for one entry of a column and of a list of contacts.
const ROW: &str = "row";
const CONTACT: &str = "contact";

impl Measured {
    /// Checks that the machine has each column's quantity, that no quantity has two columns, and
    /// that times and values are valid.
    ///
    /// # Errors
    /// [`Error::Described`] with the column, the row and the valid range; [`Error::Refusal`] for a
    /// name that the machine does not have.
    pub fn check_columns(&self, d: &Description, start: &Start, free: &[Free]) -> Result<()> {
        sizes("time", ROW, &self.times)?;
        rising("time", ROW, &self.times)?;
        let mut found = Vec::new();
        for (name, values) in &self.columns {
            let quantity = name.find(d)?.quantity;
            if found.contains(&quantity) {
                return refused(format!("{name} has two columns; expected one column of each quantity"));
            }
            found.push(quantity);
            sizes(&name.to_string(), ROW, values)?;
            if values.len() != self.times.len() {
                return refused(format!("{name}: {} values for {} times", values.len(), self.times.len()));
            }
        }
        if self.columns.is_empty() { Ok(()) } else { begin("time", ROW, &self.times, start, free) }
    }

    /// Checks that the machine has each stop, that no stop has two lists, and that the contact
    /// times are valid.
    ///
    /// # Errors
    /// The same errors as [`check_columns`](Self::check_columns).
    pub fn check_contacts(&self, d: &Description, start: &Start, free: &[Free]) -> Result<()> {
        let stops = stops_of(self, d)?;
        for (k, (name, times)) in self.contacts.iter().enumerate() {
            if stops[..k].contains(&stops[k]) {
                return refused(format!("{name} has two lists of contacts; expected one list for each stop"));
            }
            sizes(name, CONTACT, times)?;
            rising(name, CONTACT, times)?;
            begin(name, CONTACT, times, start, free)?;
        }
        Ok(())
    }

    /// Number of values and of contact times.
    pub fn samples(&self) -> usize {
        let contacts = self.contacts.iter().map(|(_, times)| times.len()).sum::<usize>();
        self.columns.len() * self.times.len() + contacts
    }
}

/// Error if the record is empty or invalid, or if segments are too short.
pub(super) fn check(request: &FitRequest) -> Result<()> {
    let FitRequest { machine, start, measured, free, .. } = request;
    if measured.samples() == 0 {
        return refused("the record has no samples; expected columns or times of contacts".into());
    }
    measured.check_columns(&machine.description, start, free)?;
    measured.check_contacts(&machine.description, start, free)?;
    check_sigma(request)?;
    check_starts(request)?;
    let Segments::Length(length) = request.segments else { return Ok(()) };
    let all = measured.times.iter().chain(measured.contacts.iter().flat_map(|(_, times)| times));
    let (low, high) =
        all.clone().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(*t), b.max(*t)));
    // A shorter segment has fewer samples than free parameters.
    let least = free.len() as f64 * (high - low) / all.count().max(2).saturating_sub(1) as f64;
    if length < least {
        return refused(format!(
            "segments of {length:?} s: must be at least {} s long, {} times the mean interval of samples",
            crate::significant(least),
            free.len()
        ));
    }
    Ok(())
}

/// Error if the square of a standard deviation overflows or underflows.
fn check_sigma(request: &FitRequest) -> Result<()> {
    let (least, most) = SIZES;
    let names = request.measured.columns.iter().map(|(name, _)| name.to_string());
    let names = names.chain(std::iter::once("contacts".to_owned()));
    let given = request.sigma.iter().flatten();
    match names.zip(given).find(|(_, sigma)| **sigma > 0.0 && !(least..=most).contains(*sigma)) {
        Some((name, sigma)) => refused(format!(
            "sigma of {name} = {sigma:e}: expected a standard deviation from {least:e} to {most:e}, SI"
        )),
        None => Ok(()),
    }
}

/// Refuses a free initial value of the machine's file if the start of the motion sets it: the motion
/// would not depend on the free number.
fn check_starts(request: &FitRequest) -> Result<()> {
    let set = request.start.numbers();
    for free in &request.free {
        let Some((body, what)) = free.name.strip_prefix("body.").and_then(|own| own.split_once(".start."))
        else {
            continue;
        };
        let own = format!("{body}.{what}");
        if let Some((_, value)) = set.iter().find(|(name, _)| *name == own) {
            return refused(format!(
                "{} is free, but the given start sets {own} = {value:?}; use start.{own} as the \
                 free parameter",
                free.name
            ));
        }
    }
    Ok(())
}
