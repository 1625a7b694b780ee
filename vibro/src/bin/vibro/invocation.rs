//! What was asked for, as manifests keep it: the command, its options with their defaults, and the command line.

use crate::arguments::Arguments;
use clap::{ArgMatches, CommandFactory};
use vibro::manifest::Invocation;

/// Options on which the numbers of a result do not depend. `figure` and `kind` choose which results are made, and
/// `folders` are those of `merge`; `list` only tells names.
const APART: [&str; 5] = ["shard", "figure", "kind", "folders", "list"];
/// Arguments that a manifest's command line leaves out: where, how fast, and which share.
const LEFT_OUT: [&str; 3] = ["--out", "--threads", "--shard"];
/// The same for those without a value.
const LEFT_OUT_FLAGS: [&str; 2] = ["--replace", "--discard-unfinished"];

/// The invocation that was parsed into `matches`.
pub fn invocation(matches: &ArgMatches) -> Invocation {
    let given: Vec<String> = std::env::args().skip(1).collect();
    let mut found = Invocation { command_line: command_line(&given), ..Invocation::default() };
    let Some((name, matches)) = matches.subcommand() else { return found };
    found.command = name.into();
    let all = Arguments::command();
    let Some(command) = all.find_subcommand(name) else { return found };
    let ids = command.get_arguments().map(|a| a.get_id().as_str()).filter(|id| !APART.contains(id));
    for id in ids {
        if let Ok(Some(values)) = matches.try_get_raw(id) {
            let values: Vec<_> = values.map(|v| v.to_string_lossy()).collect();
            found.options.insert(id.into(), values.join(" "));
        }
    }
    found
}

/// The command line of these arguments without those on which results do not depend.
fn command_line(given: &[String]) -> String {
    let mut words = vec!["vibro".to_owned()];
    let mut arguments = given.iter();
    while let Some(argument) = arguments.next() {
        let name = argument.split('=').next().unwrap_or_default();
        if LEFT_OUT.contains(&name) {
            if name == argument {
                arguments.next();
            }
        } else if !LEFT_OUT_FLAGS.contains(&argument.as_str()) {
            words.push(quoted(argument));
        }
    }
    words.join(" ")
}

/// The command line of this process, to be typed again.
pub fn as_typed() -> String {
    std::env::args().map(|a| quoted(&a)).collect::<Vec<_>>().join(" ")
}

/// An argument as a shell reads it.
fn quoted(argument: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_=.,:/+@%\\".contains(c);
    if !argument.is_empty() && argument.chars().all(plain) {
        argument.into()
    } else {
        format!("'{}'", argument.replace('\'', "'\\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn command_lines_leave_out_what_results_do_not_depend_on() {
        let given =
            "basin --out a --threads=2 --set f10=2 --shard 1/2 --replace".split(' ').map(String::from);
        assert_eq!(command_line(&given.collect::<Vec<_>>()), "vibro basin --set f10=2");
        assert_eq!(
            command_line(&["--config".into(), "my file.toml".into()]),
            "vibro --config 'my file.toml'"
        );
    }

    #[test]
    fn options_have_their_defaults_and_no_shard() {
        let given = ["vibro", "basin", "--resolution", "24", "--shard", "1/2", "--set", "f10=2"];
        let found = invocation(&Arguments::command().get_matches_from(given));
        let options: Vec<_> = found.options.iter().map(|(k, v)| (k.as_str(), v.as_str())).collect();
        assert_eq!(options, [("discard", "300"), ("resolution", "24"), ("x", "x1=-1:1"), ("y", "v2=-2:2")]);
    }
}
