//! Parsing of the command line: help texts that show FILE as required, and errors for commands in
//! the wrong group.

use crate::arguments::command;
use crate::common_arguments::{FILE, has_file};
use crate::invocation::quoted;
use clap::ArgMatches;
use clap::error::{ContextKind, ContextValue, ErrorKind};

/// Words that request help.
const HELP: [&str; 3] = ["--help", "-h", "help"];
/// Group of commands with a machine's file in version 0.2.
const OLD_GROUP: &str = "assembly";

/// The matches of this process's arguments; ends the process with an error or a help text.
pub fn matches() -> ArgMatches {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let asks = words.iter().any(|word| HELP.contains(&word.as_str()));
    // Without FILE the old spellings for the paper's machine are parsed; the help does not
    // describe them.
    let command = if asks { with_required_file(command()) } else { command() };
    command.try_get_matches().unwrap_or_else(|error| explained(without_hidden(error, &words), &words).exit())
}

/// Options of other simulators, of which no command has a counterpart.
const STEPS: [&str; 6] = ["step", "dt", "solver", "tolerance", "rtol", "atol"];

/// The commands with FILE as a required argument.
fn with_required_file(command: clap::Command) -> clap::Command {
    command.mut_subcommands(|command| match has_file(&command) {
        true => command.mut_arg(FILE, |file| file.required(true)),
        false => command,
    })
}

/// The error of a value without the value a second time, of an unknown option with the commands
/// that have it; without a list of commands, which has hidden ones, and without a hidden option as
/// a tip.
fn without_hidden(mut error: clap::Error, words: &[String]) -> clap::Error {
    if let Some(shorter) = said_once(&error) {
        return shorter;
    }
    if error.kind() == ErrorKind::MissingSubcommand {
        let problem = "a command is required, such as check, run or sweep; `vibro --help` lists all\n";
        return clap::Error::raw(ErrorKind::MissingSubcommand, problem);
    }
    let all = command();
    if let Some(ContextValue::String(option)) = error.get(ContextKind::InvalidArg)
        && error.kind() == ErrorKind::UnknownArgument
    {
        let name = option.trim_start_matches("--");
        if STEPS.contains(&name) {
            let problem = format!(
                "unexpected argument '{option}': motions need no step size, solver or tolerance; '--samples N' sets \
                 the number of rows of 'vibro run'\n"
            );
            return clap::Error::raw(ErrorKind::UnknownArgument, problem);
        }
        let owners = owners(&all, name);
        let tip = format!("'{option}' is an option of {}", owners.join(", "));
        // Clap's tip is to pass the option as a value, which no command takes.
        error.remove(ContextKind::Suggested);
        if !owners.is_empty() && error.get(ContextKind::SuggestedArg).is_none() {
            error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
        }
    }
    if let Some(ContextValue::String(tip)) = error.get(ContextKind::SuggestedArg) {
        let own = words.iter().find_map(|word| all.find_subcommand(word)).unwrap_or(&all);
        let is_hidden = |arg: &clap::Arg| arg.is_hide_set() && arg.get_long() == Some(&tip[2..]);
        if tip.starts_with("--") && own.get_arguments().any(is_hidden) {
            error.remove(ContextKind::SuggestedArg);
        }
    }
    error
}

/// The error of a value whose parser repeats the value, which clap has named.
fn said_once(error: &clap::Error) -> Option<clap::Error> {
    let text = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => Some(text),
        _ => None,
    };
    let (value, option) = (text(ContextKind::InvalidValue)?, text(ContextKind::InvalidArg)?);
    let said = std::error::Error::source(error)?.to_string();
    let problem = said.strip_prefix(&format!("`{value}`: "))?;
    let message = format!("invalid value '{value}' for '{option}': {problem}\n");
    Some(clap::Error::raw(ErrorKind::ValueValidation, message))
}

/// The commands that show an option with this name.
fn owners(all: &clap::Command, name: &str) -> Vec<String> {
    let has = |command: &&clap::Command| {
        command.get_arguments().any(|own| own.get_long() == Some(name) && !own.is_hide_set())
    };
    let shown = all.get_subcommands().filter(|command| !command.is_hide_set());
    shown.filter(has).map(|command| format!("'vibro {}'", command.get_name())).collect()
}

/// Error for an unknown command. It names the spelling of a command in the wrong group.
fn explained(error: clap::Error, words: &[String]) -> clap::Error {
    let Some(ContextValue::String(name)) = error.get(ContextKind::InvalidSubcommand) else { return error };
    let after = words.iter().skip_while(|word| *word != name).skip(1);
    let rest: Vec<String> = after.map(|word| quoted(word)).collect();
    let problem = if name == OLD_GROUP {
        let right = if rest.is_empty() { "COMMAND FILE".into() } else { rest.join(" ") };
        format!("`vibro {name}` is not a group of commands: expected `vibro {right}`")
    } else if command().find_subcommand(name).is_some() {
        let right = std::iter::once(name.clone()).chain(rest).collect::<Vec<_>>().join(" ");
        format!("`vibro paper` has no command `{name}`: expected `vibro {right}`")
    } else if name == "simulate" {
        let right = if rest.is_empty() { "FILE".into() } else { rest.join(" ") };
        format!("vibro has no command `{name}`: expected `vibro run {right}`")
    } else {
        return error;
    };
    clap::Error::raw(ErrorKind::InvalidSubcommand, format!("{problem}\n"))
}
