//! The invocation stored in manifests: command, options with their defaults, command line.

use crate::arguments::Arguments;
use crate::ranges::{ParameterPair, ParameterRange, ParameterValues};
use crate::run::Duration;
use clap::{ArgMatches, CommandFactory};
use std::fmt::Display;
use std::str::FromStr;
use vibro::load_file::LoadArgument;
use vibro::manifest::Invocation;
use vibro_studies::paper::basin::InitialValueRange;
use vibro_studies::paper::start::StartRule;
use vibro_studies::paper::{Name, number};

/// Options that do not affect the numbers of a result. `width` is the width of pictures, `figure`
/// and `kind` choose which results are made, `folders` are the folders of `merge`, and `list` only
/// prints names.
const APART: [&str; 6] = ["shard", "width", "figure", "kind", "folders", "list"];
/// Options that a manifest's command line leaves out: destination, threads, share.
const LEFT_OUT: [&str; 3] = ["--out", "--threads", "--shard"];
/// Flags that a manifest's command line leaves out.
const LEFT_OUT_FLAGS: [&str; 2] = ["--replace", "--discard-unfinished"];

/// The invocation that was parsed into `matches`.
pub fn invocation(matches: &ArgMatches) -> Invocation {
    let given: Vec<String> = std::env::args().skip(1).collect();
    let mut found = Invocation { command_line: command_line(&given), ..Invocation::default() };
    let Some((name, matches)) = matches.subcommand() else { return found };
    found.command = name.into();
    if matches.try_contains_id("file").is_ok_and(|is_file| is_file) {
        // The studies of a machine's file add their options themselves.
        return found;
    }
    let all = Arguments::command();
    let Some(command) = all.find_subcommand(name) else { return found };
    let ids = command.get_arguments().map(|a| a.get_id().as_str()).filter(|id| !APART.contains(id));
    let given = |id: &str| matches.try_get_raw(id).ok().flatten().and_then(Iterator::last);
    let range = given("range").and_then(|text| text.to_str()?.parse::<ParameterRange>().ok());
    // The parameter of the values of `--at`.
    let at = range.map(|range| range.name).or_else(|| Name::find("f10").ok());
    for id in ids {
        if let Ok(Some(values)) = matches.try_get_raw(id) {
            let values: Vec<_> = values.map(|v| canonical(id, &v.to_string_lossy(), at)).collect();
            found.options.insert(id.into(), values.join(" "));
        }
    }
    found
}

/// Canonical text of an option's value: `2:3` and `2.0:3` are one range, and so are 5mm:30mm and
/// 0.005:0.03. A file is represented by its contents. Other values stay as typed.
fn canonical(id: &str, text: &str, at: Option<Name>) -> String {
    fn read<T: FromStr + Display>(text: &str) -> Option<String> {
        text.parse::<T>().ok().map(|value| value.to_string())
    }
    let found = match id {
        "range" => read::<ParameterRange>(text),
        "values" => read::<ParameterValues>(text),
        "pair" => read::<ParameterPair>(text),
        "x" | "y" => read::<InitialValueRange>(text),
        "start" => read::<StartRule>(text),
        "duration" => read::<Duration>(text),
        "load" => text.parse().ok().and_then(|load: LoadArgument| load.in_words()),
        "at" => at.and_then(|name| number(name, text).ok()).map(|value| value.to_string()),
        _ => read::<f64>(text),
    };
    found.unwrap_or_else(|| text.into())
}

/// The command line without the options that do not affect results.
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

/// The command line of this process, quoted for a shell.
pub fn as_typed() -> String {
    std::env::args().map(|a| quoted(&a)).collect::<Vec<_>>().join(" ")
}

/// An argument, quoted for a shell where needed.
pub fn quoted(argument: &str) -> String {
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
    fn options_are_compared_by_their_values() {
        let options = |line: &str| {
            let given = std::iter::once("vibro").chain(line.split(' '));
            invocation(&Arguments::command().get_matches_from(given)).options
        };
        for (one, other) in [
            ("bifurcation --range f10=2:3", "bifurcation --vary f10=2.0:3.00 --keep 0800"),
            ("bifurcation --vary L=5mm:30mm:9", "bifurcation --vary stop.gap=0.005:0.03:9"),
            ("response --values f10=1,1.5", "response --values f10=1.0,15e-1"),
            ("plane --pair σ1,f10", "plane --pair sigma1,f10"),
            ("basin --x x1=-1:1", "basin --x x1=-1.0:1"),
            ("isoperiodic --start v2=1", "isoperiodic --start v2=1.0"),
            ("run --duration 2s --start block.s=5mm", "run --duration 2000ms --start x2=0.005m"),
            ("lyapunov --vary L=1mm:9mm --at 2mm,3mm", "lyapunov --vary L=1mm:9mm --at 0.002,0.003"),
        ] {
            assert_eq!(options(one), options(other), "{one}");
        }
        assert!(options("run --duration 2") != options("run --duration 2periods"));
        assert!(options("bifurcation --range f10=2:3") != options("bifurcation --range f10=2:3.1"));
    }

    #[test]
    fn options_have_their_defaults_and_no_shard() {
        let given = ["vibro", "basin", "--resolution", "24", "--shard", "1/2", "--set", "f10=2"];
        let found = invocation(&Arguments::command().get_matches_from(given));
        let options: Vec<_> = found.options.iter().map(|(k, v)| (k.as_str(), v.as_str())).collect();
        assert_eq!(options, [("discard", "300"), ("resolution", "24"), ("x", "x1=-1:1"), ("y", "v2=-2:2")]);
    }
}
