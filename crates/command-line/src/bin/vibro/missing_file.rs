//! Commands for a machine's file without the FILE: finds options and names that only a machine's
//! file has.

use crate::common_arguments::{WITH_FILE, time};
use clap::parser::ValueSource;
use clap::{ArgMatches, Command};
use vibro::{Error, Result};
use vibro_studies::Measure;
use vibro_studies::paper::{Name, maxima::Displacement, measures};

/// Options with values that may belong to a machine's file, by identifier and shown name.
const OPTIONS: [(&str, &str); 8] = [
    ("range", "vary"),
    ("vary", "vary"),
    ("over", "over"),
    ("set", "set"),
    ("of", "of"),
    ("output", "output"),
    ("period", "period"),
    ("start", "start"),
];

/// Whether a name is a dotted name of a machine's file, such as `stop.steel.gap`. Names of the
/// paper's machine have two parts at most.
fn is_parameter_of_file(name: &str) -> bool {
    name.split('.').filter(|part| !part.is_empty()).count() >= 3 && Name::find(name).is_err()
}

/// Whether a name is an output or a quantity of a machine's file alone, such as `amplitude.box.s`
/// or `box.s`.
fn is_output_of_file(name: &str) -> bool {
    let of_file = match name.split('.').collect::<Vec<_>>()[..] {
        [_, "s" | "v" | "a" | "e" | "f" | "rate"] => true,
        [_, _, _, ..] => name.parse::<Measure>().is_ok(),
        _ => false,
    };
    of_file && name.parse::<measures::Measure>().is_err() && name.parse::<Displacement>().is_err()
}

/// Whether a start has something that only a machine's file has: a range, a time, a file.
fn is_start_of_file(text: &str) -> bool {
    let is_own =
        |part: &str| part.contains(':') || part.trim().starts_with("time=") || part.ends_with(".toml");
    text.split(',').any(is_own)
}

/// Whether a value of an option belongs to a machine's file.
fn is_of_file(id: &str, text: &str) -> bool {
    match id {
        "of" | "output" => is_output_of_file(text.trim()),
        "period" => text.trim().parse::<u32>().is_err() && (text.trim().ends_with('T') || time(text).is_ok()),
        "start" => is_start_of_file(text),
        _ => is_parameter_of_file(text.split('=').next().unwrap_or_default().trim()),
    }
}

/// The refusal of an option or value of a machine's file in a command without FILE.
fn error(command: &Command, given: String) -> Error {
    let name = command.get_name();
    let problem = format!("requires a machine's FILE: use `vibro {name} FILE {given} …`");
    Error::Refused { what: given, problem }
}

/// Refuses options and values of a machine's file in a command without FILE. After `vibro paper`
/// the options are refused together with the valid options.
///
/// # Errors
/// [`Error::Refused`] with the first such option, and how to write FILE.
pub fn check(command: &Command, matches: &ArgMatches, grouped: bool) -> Result<()> {
    let is_given = |id: &str| matches.value_source(id) == Some(ValueSource::CommandLine);
    let of_file = |arg: &&clap::Arg| !grouped && arg.get_help_heading() == Some(WITH_FILE);
    if let Some(arg) = command.get_arguments().filter(of_file).find(|arg| is_given(arg.get_id().as_str())) {
        return Err(error(command, format!("--{}", arg.get_long().unwrap_or_default())));
    }
    for (id, option) in OPTIONS {
        let own = command.get_arguments().any(|arg| arg.get_id() == id) || id == "set";
        let values = if own && is_given(id) { matches.get_raw(id) } else { None };
        let found = values.into_iter().flatten().filter_map(|value| value.to_str());
        if let Some(value) = found.into_iter().find(|value| is_of_file(id, value)) {
            return Err(error(command, format!("--{option} {value}")));
        }
    }
    Ok(())
}
