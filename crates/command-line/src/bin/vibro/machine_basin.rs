//! `basin` with a machine's file: from arguments to the library's study.

use crate::common_arguments::Common;
use crate::long::perform_as;
use crate::machine_studies::{invocation, machine, start_of};
use crate::plane_arguments::Basin;
use crate::ranges::other_number;
use std::path::Path;
use vibro::long_study::{LongStudy, StudyKind};
use vibro::{Error, Result};
use vibro_machine::Start;
use vibro_studies::Machine;
use vibro_studies::basin::{BasinRequest, StartAxis};

/// Largest number of cells on an axis.
const MOST: usize = 5_000;
const FORM: &str = "NAME=FROM:TO or NAME=FROM:TO:COUNT with FROM < TO, where NAME is an initial \
                    value, e.g. block.s=-4mm:4mm:80";

/// Whether a `--start` is an axis: a value with a colon.
fn is_axis(text: &&String) -> bool {
    text.split_once('=').is_some_and(|(_, values)| values.contains(':'))
}

/// Reads an axis of a plane of starts.
fn axis(machine: &Machine, text: &str, resolution: u16) -> Result<StartAxis> {
    let named = text.split_once('=').filter(|(name, _)| !name.trim().is_empty());
    let (name, values) = named.ok_or_else(|| Error::form(text, FORM))?;
    let name = name.trim().strip_prefix("body.").unwrap_or(name.trim());
    let (from, to, count) = match values.split(':').map(str::trim).collect::<Vec<_>>()[..] {
        [from, to] => (from, to, usize::from(resolution)),
        [from, to, count] => (from, to, count.parse().map_err(|_| Error::form(text, FORM))?),
        _ => return Err(Error::form(text, FORM)),
    };
    if !(1..=MOST).contains(&count) {
        let problem = format!("expected 1 to {MOST} cells");
        return Err(Error::Refused { what: format!("--start {text}"), problem });
    }
    let end = |text: &str| -> Result<f64> {
        let mut start = Start::default();
        if let Some(unit) = machine.set_start(&mut start, name, text)? {
            crate::note(&vibro::machine::note_of_unit(&format!("--start {name}={text}"), unit));
        }
        let found = start.numbers().into_iter().find(|(own, _)| own == name);
        found.map(|(_, value)| value).ok_or_else(|| Error::form(text, FORM))
    };
    let (from, to) = (end(from)?, end(to)?);
    if from < to {
        Ok(StartAxis { name: name.into(), from, to, count })
    } else {
        Err(Error::form(text, FORM))
    }
}

/// The axis in SI, for manifests.
fn in_words(axis: &StartAxis) -> String {
    format!("{}={}:{}:{}", axis.name, axis.from, axis.to, axis.count)
}

/// Basins over a plane of starts.
pub fn basin(file: &Path, common: &Common, a: &Basin) -> Result<()> {
    let machine = machine(file, &a.section, common)?;
    let (ranges, given): (Vec<&String>, Vec<&String>) = a.start.iter().partition(is_axis);
    let [x, y] = ranges[..] else {
        let expected = "expected two ranges, e.g. --start block.s=-4mm:4mm --start block.v=-1:1";
        return Err(other_number("--start", expected, ranges.len()));
    };
    let (x, y) = (axis(&machine, x, a.resolution)?, axis(&machine, y, a.resolution)?);
    let given: Vec<String> = given.into_iter().cloned().collect();
    let request = BasinRequest { x, y, start: start_of(&machine, &given)?, discard: a.discard };
    let options = [
        ("start", format!("{} {} {}", in_words(&request.x), in_words(&request.y), request.start)),
        ("discard", a.discard.to_string()),
    ];
    let invocation = invocation(common, &options);
    let study = LongStudy::new("basin", StudyKind::Basin(request), &machine);
    perform_as(&study, common, &invocation, a.share.shard)
}
