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

/// The commands with FILE as a required argument.
fn with_required_file(command: clap::Command) -> clap::Command {
    command.mut_subcommands(|command| match has_file(&command) {
        true => command.mut_arg(FILE, |file| file.required(true)),
        false => command,
    })
}

/// The error without a list of commands, which has hidden ones, and without a hidden option as a
/// tip.
fn without_hidden(mut error: clap::Error, words: &[String]) -> clap::Error {
    if error.kind() == ErrorKind::MissingSubcommand {
        let problem = "a command is required, such as check, run or sweep; `vibro --help` lists all\n";
        return clap::Error::raw(ErrorKind::MissingSubcommand, problem);
    }
    if let Some(ContextValue::String(tip)) = error.get(ContextKind::SuggestedArg) {
        let all = command();
        let own = words.iter().find_map(|word| all.find_subcommand(word)).unwrap_or(&all);
        let is_hidden = |arg: &clap::Arg| arg.is_hide_set() && arg.get_long() == Some(&tip[2..]);
        if tip.starts_with("--") && own.get_arguments().any(is_hidden) {
            error.remove(ContextKind::SuggestedArg);
        }
    }
    error
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
    } else {
        return error;
    };
    clap::Error::raw(ErrorKind::InvalidSubcommand, format!("{problem}\n"))
}
