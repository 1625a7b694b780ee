//! The start of a motion as given on the command line.

use super::note_of_unit;
use crate::{Error, Result};
use std::path::Path;
use vibro_machine::{Assembly, Start};
use vibro_studies::Machine;

/// Reads a start: numbers as `NAME=VALUE,…`, a start's file, or a file followed by numbers that
/// replace its own. Numbers are read as in `--set`; `note` is called with the unit of a number
/// that was read in a unit other than SI.
///
/// # Errors
/// [`Error::Refused`] for a number that is out of range or given twice; [`Error::Refusal`] for a
/// file that is not a start of this machine; an error if the machine cannot be built.
pub fn read_start(machine: &Machine, given: &str, note: &mut dyn FnMut(String)) -> Result<Start> {
    const FORM: &str = "NAME=VALUE,…, a start's file, or FILE,NAME=VALUE,…, e.g. box.s=5mm,box.v=1,time=0.2s or end.toml,box.v=0";
    let refused = |what: &str, problem: String| Error::Refused { what: format!("--start {what}"), problem };
    let description = &machine.description;
    let mut start = Start::default();
    let mut named: Vec<&str> = Vec::new();
    for (i, part) in given.split(',').enumerate() {
        let Some((name, value)) = part.split_once('=') else {
            if i > 0 || part.trim().is_empty() {
                return Err(Error::form(given, FORM));
            }
            if !Path::new(part).exists() {
                let text = "no such file; expected a start file, or NAME=VALUE, such as box.s=1mm";
                return Err(refused(part, text.into()));
            }
            start = Start::read(Path::new(part), description)?;
            continue;
        };
        let name = name.trim();
        let plain = name.strip_prefix("body.").unwrap_or(name);
        if named.contains(&plain) {
            return Err(refused(given, format!("{plain} is given twice; give it once")));
        }
        named.push(plain);
        let set = machine.set_start(&mut start, name, value);
        if let Some(unit) = set.map_err(|error| refused(part, error.to_string()))? {
            note(note_of_unit(part, unit));
        }
    }
    start.state(&Assembly::new(description.clone())?)?;
    Ok(start)
}
