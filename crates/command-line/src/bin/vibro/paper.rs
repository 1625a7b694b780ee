//! `vibro paper COMMAND`, the commands for the paper's machine, and the help of the other
//! commands, which describes a machine's file alone.
//!
//! Commands with an optional FILE take either machine (see [`crate::common_arguments`]).
//! `vibro COMMAND FILE` and `vibro paper COMMAND` are the two spellings of such a command. Both
//! parse into one [`crate::arguments::Command`]; only their help differs.

use crate::common_arguments::{FILE, NUMBERS, WITH_FILE, WITHOUT_FILE, has_file, with_notes};
use crate::design_arguments;
use crate::paper_words::{Of, words};
use crate::sweep_arguments::{EXAMPLES, EXAMPLES_OF_PAPER, TABLE};
use clap::builder::Resettable;
use clap::{Arg, ArgMatches, Command};
use std::path::Path;
use vibro::{Error, Result};

/// Name of the group of commands.
const PAPER: &str = "paper";

const ABOUT: &str = "\
Commands for the paper's machine, of 3 degrees of freedom: closed forms, motions, orbits, planes, the paper's figures
Figure numbers refer to Nonlinear Dynamics 106 (2021) 81-103.";

const PARAMETERS: &str = "\
PARAMETERS
  Groups:  epsilon kappa f10 sigma1 gamma1 alpha23 beta2 sigma30 gamma3 mu13
  SI:      box.m box.k box.c block.m secondary.m secondary.k secondary.c coupling.k
           stop.gap stop.restitution drive.amplitude drive.frequency drive.phase
  Loads:   load.box load.block load.secondary: constant forces in N, 0 unless set, for gravity or an off-centre gap
  Symbols work as names too: m1 k1 c1 m2 m3 k3 c3 k23 L F10 omega1, κ ε σ1 …; F10 is the force in N, f10 its group.
  Values may have a unit of the parameter's dimension: 12kg, 350 g, 48 kN/m, 48 N/mm, 2.5mm, 10Hz, 600rpm, 30deg.
  A number without a unit is read in the unit that the file or an earlier --set uses for that parameter, and the program
  reports this unit. If there is none, the number is in SI, an angular frequency in rad/s. This holds in --set and on every axis
  (--vary, --over, --values, --at, --mark, columns of --design). Screen and pictures show that unit. Tables are in SI, with
  one more column for each such parameter at the end, e.g. `drive.frequency [Hz]`.
  A parameter that is not set has its default, which is a reconstruction and not the paper's own data.
  A parameter file is TOML with a table [si], a table [groups], or both; [groups] is applied after [si], and --set after the file.
  `vibro paper template` writes a file with every parameter.

EXAMPLES
  vibro paper steady --set kappa=0.6 --set f10=2
  vibro paper run --config parameters.toml --start x1=0.2,v2=1 --load box=record.csv
  vibro paper response --values f10=1,1.5,2 --vary sigma1=-1:1
  vibro paper plane --pair sigma1,f10 --resolution 1000 --method exact-orbit
  vibro paper compare --figure 17 --values epsilon=0.1,0.05,0.02,0.01
  vibro paper lyapunov --vary f10=1.9:4 --resolution 1051
  vibro paper isoperiodic --pair sigma1,f10 --resolution 200
  vibro paper template > parameters.toml    (fill it in; texts with a unit in quotation marks)
  vibro paper bifurcation --config parameters.toml --vary drive.frequency=9Hz:11Hz:200
  vibro paper plane --config parameters.toml --pair block.m,stop.gap --vary stop.gap=1mm:20mm
  vibro paper orbits --tree --vary f10=0.5:5
  vibro paper bifurcation --orbits --vary f10=2:3:101
  vibro paper orbit --word UUL --set f10=2.7
  vibro paper locus --from vibro-out/special-points.csv:PD@2.373 --vary f10=0.5:3 --vary kappa=0.5:0.9
  vibro paper basin --set f10=2.45 --shard 1/2 --out one    (another computer: --shard 2/2 --out two; then vibro merge one two)";

/// Limits of the paper's machine.
const LIMITS: &str = "\
LIMITS of the paper's machine; a machine's FILE describes machines of any bodies, with friction, links and compliant stops
  Three bodies on one line: box, block, secondary oscillator. Both stops are rigid and have one coefficient of restitution.
  No friction; springs and dampers are linear.";

/// Whether a command takes the paper's machine.
fn takes_paper(command: &Command) -> bool {
    let needs_file = command.get_arguments().any(|arg| arg.get_id() == FILE && arg.is_required_set());
    !needs_file && !["new", "merge", "reduce"].contains(&command.get_name())
}

/// The commands as shown to the user: commands with a FILE on their own, and commands for the
/// paper's machine in a group. The old spellings of the paper's commands are hidden.
pub fn grouped(all: Command) -> Command {
    let papers: Vec<Command> =
        all.get_subcommands().filter(|command| takes_paper(command)).cloned().map(of_paper).collect();
    let group = Command::new(PAPER).about(ABOUT.lines().next()).long_about(ABOUT).after_help(PARAMETERS);
    let group = group.arg_required_else_help(true).subcommand_required(true).subcommands(papers);
    let shown = all.mut_subcommands(|command| match command.get_name() {
        _ if has_file(&command) => of_file(command),
        _ if takes_paper(&command) => old_spelling(of_paper(command)),
        _ => command,
    });
    shown.subcommand(with_notes(group, &[LIMITS]))
}

/// A command for the paper's machine that is called without the group. Its help names the new
/// spelling.
fn old_spelling(command: Command) -> Command {
    let spelled = format!("vibro {PAPER} {}", command.get_name());
    let usage = command.clone().bin_name(&spelled).render_usage().to_string();
    let usage = usage.trim_start_matches("Usage: ").to_owned();
    let note = format!("{}.", note_of_old_spelling(command.get_name(), ""));
    command.hide(true).override_usage(usage).before_help(note)
}

/// Note on a command that is called without `paper`.
fn note_of_old_spelling(name: &str, without: &str) -> String {
    format!("`vibro {name}`{without} is now `vibro {PAPER} {name}`; the old spelling works until 0.5")
}

/// A command whose help describes a machine's file alone.
fn of_file(command: Command) -> Command {
    let table = TABLE.replace("drive.frequency", "load.shaker.frequency");
    let notes: &[&str] = match command.get_name() {
        "sweep" => &[EXAMPLES, &table, NUMBERS],
        "design" => &[design_arguments::EXAMPLES, design_arguments::FILES, NUMBERS],
        _ => &[NUMBERS],
    };
    let usage = command.clone().bin_name(format!("vibro {}", command.get_name())).render_usage().to_string();
    let usage = usage.trim_start_matches("Usage: ").replace("[FILE]", "<FILE>");
    described(command, Of::File, WITHOUT_FILE, notes).override_usage(usage)
}

/// A command whose help describes the paper's machine alone.
fn of_paper(command: Command) -> Command {
    let notes: &[&str] =
        if command.get_name() == "sweep" { &[EXAMPLES_OF_PAPER, TABLE, LIMITS] } else { &[LIMITS] };
    let command = command.mut_args(|arg| if arg.get_id() == FILE { arg.hide(true) } else { arg });
    described(command, Of::Paper, WITH_FILE, notes)
}

/// A command whose help has the words and options of one machine; options under the other
/// machine's heading are hidden.
fn described(command: Command, of: Of, other: &str, notes: &[&str]) -> Command {
    let (about, long) = (words(command.get_about(), of), words(command.get_long_about(), of));
    let command = command.mut_args(|arg: Arg| {
        if arg.get_help_heading() == Some(other) {
            return arg.hide(true);
        }
        let (help, long) = (words(arg.get_help(), of), words(arg.get_long_help(), of));
        arg.help(help).long_help(long).help_heading(None)
    });
    with_notes(command.about(about).long_about(long).after_help(Resettable::Reset), notes)
}

/// The matches without the group, and whether the group was named.
pub fn without_group(matches: ArgMatches) -> (ArgMatches, bool) {
    match matches.subcommand() {
        Some((PAPER, inner)) => (inner.clone(), true),
        _ => (matches, false),
    }
}

/// The words of a command: `paper steady`, or `run` for a machine's file.
pub fn spelled(command: &Command, file: Option<&Path>) -> String {
    let name = command.get_name();
    if file.is_none() && takes_paper(command) { format!("{PAPER} {name}") } else { name.into() }
}

/// Refuses a FILE behind `vibro paper`. Notes the new spelling of a command for the paper's
/// machine that was called without `paper`, as in version 0.3.
///
/// # Errors
/// [`Error::Refused`] with the spelling for a machine's file.
pub fn check_spelling(command: &Command, file: Option<&Path>, grouped: bool) -> Result<()> {
    let name = command.get_name();
    match file {
        Some(file) if grouped => {
            let file = file.display();
            let problem = format!("`vibro {PAPER}` does not take a machine file: use `vibro {name} {file}`");
            return Err(Error::Refused { what: format!("{PAPER} {name} {file}"), problem });
        }
        None if !grouped && takes_paper(command) => {
            let without = if has_file(command) { " without a machine's FILE" } else { "" };
            crate::note(&note_of_old_spelling(name, without));
        }
        _ => {}
    }
    Ok(())
}
