//! `vibro assembly COMMAND FILE`, the alias of `vibro COMMAND FILE` of version 0.2. Its help
//! describes only commands with a machine's file.

use crate::common_arguments::{FILE, NUMBERS, WITHOUT_FILE, has_file, with_notes};
use crate::sweep_arguments::{EXAMPLES, TABLE};
use clap::builder::{Resettable, StyledStr};
use clap::{ArgMatches, Command};

/// Name of the alias.
const ALIAS: &str = "assembly";

/// Parts of help texts that describe both machines, and their replacements for a command with a
/// FILE. A default is written `[default: A; with FILE B]`.
const WORDS: [(&str, &str); 14] = [
    (". Without it the paper's machine", ""),
    (", e.g. kappa=0.6, box.k=48kN/m, or of a machine's FILE ", ", e.g. "),
    (" [default without FILE: f10=0.5:5]", ""),
    ("f10=0.5:5 or, with FILE, ", ""),
    ("in each drive period, at most 10000; with FILE in all", "in all"),
    ("; with FILE, unless", ", unless"),
    ("; with FILE 8 to", ", 8 to"),
    (
        "Coordinate whose local maxima are drawn: x1, x2, x3 or w; with FILE any quantity",
        "Quantity whose local maxima are drawn",
    ),
    (". With FILE also the time", ", the time"),
    (
        " Without FILE also x1 x2 x3 in L, v1 v2 v3 in L omega10; what is not named is zero; \"orbit\" starts on the exact orbit \
         where it is stable",
        "",
    ),
    (" (figure 14)", ""),
    (" (figure 14, table 2): all of them, or with FILE the largest", ": the largest"),
    ("With FILE one variation", "One variation"),
    ("(--over), and from several starts", "(--over)"),
];

/// The alias, with every command that takes a machine's file.
pub fn alias(all: &Command) -> Command {
    let commands = all.get_subcommands().filter(|command| has_file(command)).cloned();
    Command::new(ALIAS)
        .about("Alias of the commands with a machine's FILE: `vibro assembly run FILE` is `vibro run FILE`")
        .hide(true)
        .arg_required_else_help(true)
        .subcommand_required(true)
        .subcommands(commands.map(of_file))
}

/// A command whose help describes it only with a FILE.
fn of_file(command: Command) -> Command {
    let (about, long) = (words(command.get_about()), words(command.get_long_about()));
    let notes: &[&str] = if command.get_name() == "sweep" { &[EXAMPLES, TABLE, NUMBERS] } else { &[NUMBERS] };
    let command = command.mut_args(|arg| {
        if arg.get_help_heading() == Some(WITHOUT_FILE) {
            return arg.hide(true);
        }
        let (help, long, required) =
            (words(arg.get_help()), words(arg.get_long_help()), arg.get_id() == FILE);
        let arg = if required { arg.required(true) } else { arg };
        arg.help(help).long_help(long).help_heading(None)
    });
    with_notes(command.about(about).long_about(long).after_help(Resettable::Reset), notes)
}

/// A help text without its statements on the paper's machine.
fn words(text: Option<&StyledStr>) -> Resettable<StyledStr> {
    let Some(text) = text else { return Resettable::Reset };
    let mut text = text.to_string();
    for (of_both, of_file) in WORDS {
        text = text.replace(of_both, of_file);
    }
    const OF_FILE: &str = "; with FILE ";
    if let (Some(default), Some(own)) = (text.find("[default: "), text.find(OF_FILE)) {
        text.replace_range(default + "[default: ".len()..own + OF_FILE.len(), "");
    }
    Resettable::Value(text.into())
}

/// The matches without the alias.
pub fn without_alias(matches: ArgMatches) -> ArgMatches {
    match matches.subcommand() {
        Some((ALIAS, inner)) => inner.clone(),
        _ => matches,
    }
}
