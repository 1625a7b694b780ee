//! The command line: commands, options and their help.
//!
//! Each command is a variant of [`Command`]; its options are a struct that derives clap's `Args`.
//! Some commands take either the machine of a FILE or the paper's machine:
//!
//! * An option for both machines is in the command's struct. If its default depends on the
//!   machine, the default for a FILE is a `default_value_if` on `file`, and the help text states
//!   both.
//! * An option for one machine only is in the struct `…OfFile` or `…OfPaper`. The help lists it
//!   under a heading of its own; [`check_options`] refuses options under this heading for the
//!   other machine.
//! * An axis, quantity or measure is text to clap; [`Command::read_axes`] and `machine_studies`
//!   parse it, since its form depends on the machine.
//!
//! Identifiers of options are keys of manifests and are never changed; a new name is added as an
//! alias.

use crate::common_arguments::{Common, FILE, WITH_FILE, WITHOUT_FILE, has_file};
use crate::design_arguments::DesignArguments;
use crate::fit_arguments::FitArguments;
use crate::missing_file;
use crate::orbits_arguments::{Loci, OneOrbit, Orbits};
use crate::paper;
use crate::plane_arguments::{Basin, SectionOfFile};
use crate::ranges::{in_option, texts};
use crate::reduce_arguments::ReduceArguments;
use crate::run::RunArguments;
use crate::study_arguments::{
    Bifurcation, Compare, Fmu, Isoperiodic, Lyapunov, Manifold, Merge, New, Plane, Reproduce, Response,
    Stability, Template,
};
use crate::sweep_arguments::Sweep;
use clap::parser::ValueSource;
use clap::{Arg, ArgMatches, CommandFactory, Parser, Subcommand};
use std::path::{Path, PathBuf};
use vibro::{Error, Result};
use vibro_studies::paper::start::StartRule;

const ABOUT: &str = "\
Vibro-impact machines, simulated exactly from event to event: motions, bifurcations, Lyapunov exponents, designs
A machine is described by a FILE; `new` writes one as a starting point. `paper` contains the commands for the machine of one paper; closed-form solutions exist for this machine.";

const PARAMETERS: &str = "\
EXAMPLES
  vibro new damper_with_buffer machine.toml
  vibro check machine.toml
  vibro draw machine.toml
  vibro run machine.toml --until 2s --samples 1000 --out my-machine
  vibro sweep machine.toml --vary stop.steel.gap=1mm:8mm:40 --vary body.block.mass=0.2kg:0.5kg:25
  vibro design machine.toml --minimize amplitude.box.s --vary stop.steel.gap=1mm:8mm,body.block.mass=0.2kg:0.5kg
  vibro fit machine.toml --data record.csv --free stop.steel.gap,spring.mount.stiffness
  vibro bifurcation machine.toml --vary stop.steel.gap=1mm:8mm:200 --of box.s
  vibro lyapunov machine.toml --vary stop.steel.gap=1mm:8mm:200
  vibro response machine.toml --vary load.shaker.frequency=8Hz:12Hz --of amplitude.box.s
  vibro basin machine.toml --start block.s=-4mm:4mm --start block.v=-1:1
  vibro section machine.toml --section steel
  vibro orbit machine.toml --period 1T
  vibro orbits machine.toml --tree --vary stop.steel.gap=1mm:8mm
  vibro locus machine.toml --from vibro-out/special-points.csv:PD --vary stop.steel.gap=1mm:8mm --vary body.block.mass=0.2kg:0.5kg
  vibro fmu machine.toml
  vibro reduce blade.sti blade.mas blade.dof --units N,mm,t,s --clamp root.csv --interface tip=428.y --modes 20
  vibro basin machine.toml --start block.s=-4mm:4mm --start block.v=-1:1 --shard 1/2 --out one    (another computer: --shard 2/2)
  vibro merge one two
  Examples for the paper's machine (see `vibro paper --help`):
  vibro paper steady --set kappa=0.6 --set f10=2
  vibro paper bifurcation --vary f10=2:3:101 --orbits
  vibro paper template > parameters.toml";

/// The command line as clap's command, with the commands for the paper's machine in a group. The
/// help of each command names only the options of that command.
pub fn command() -> clap::Command {
    paper::grouped(ungrouped())
}

/// Every command with its options. An option for one of the two machines only is under the heading
/// of that machine.
fn ungrouped() -> clap::Command {
    let all = with_negative_numbers(Arguments::command());
    let shared: Vec<Arg> = all.get_arguments().cloned().collect();
    all.mut_subcommands(|command| with_shared(command, &shared))
}

/// Shared options that a command does not use: its help leaves them out, and [`check_options`]
/// refuses them. Only a study computed in parts can have unfinished parts.
fn unused(command: &str) -> &'static [&'static str] {
    match command {
        "check" => &["config", "out", "width", "replace", "discard_unfinished", "threads"],
        "draw" => &["config", "replace", "discard_unfinished", "threads"],
        "fmu" => &["config", "width", "replace", "discard_unfinished", "threads"],
        "section" | "fit" => &["config", "discard_unfinished", "threads"],
        "design" => &["config", "discard_unfinished"],
        "template" | "new" => &["config", "set", "out", "width", "replace", "discard_unfinished", "threads"],
        "merge" => &["config", "set"],
        "reduce" => &["config", "set", "width", "discard_unfinished"],
        "run" | "steady" | "response" | "manifold" | "stability" | "plane" | "compare" | "orbit"
        | "locus" => &["discard_unfinished"],
        _ => &[],
    }
}

/// A shared option with its help for `reduce`, which writes files of one name and no folder.
fn of_reduce(arg: Arg) -> Arg {
    let help = match arg.get_id().as_str() {
        "out" => {
            "Path of the written files without their ending: OUT.toml, OUT.npz, OUT.txt [default: the name of the \
             first file]"
        }
        "replace" => "Overwrite an OUT.toml that another program or a person wrote",
        _ => "Number of threads [default: all cores]. Last digits depend on it",
    };
    let arg = arg.help(help).long_help(help);
    if arg.get_id() == "out" { arg.value_name("OUT").hide_default_value(true) } else { arg }
}

/// Display order of the first shared option.
const LAST: usize = 900;

/// A command with its shared options. An option that the command does not use is hidden. An option
/// for the paper's machine only is under the heading of that machine, such as `--threads` of
/// `run`: with a FILE, `run` simulates one motion, on one thread.
fn with_shared(command: clap::Command, shared: &[Arg]) -> clap::Command {
    let (name, of_file) = (command.get_name().to_owned(), has_file(&command));
    // Shared options follow the command's own options.
    let shared = shared.iter().enumerate().map(|(i, arg)| arg.clone().display_order(LAST + i));
    let own = shared.map(|arg| match arg.get_id().as_str() {
        id if unused(&name).contains(&id) => arg.hide(true),
        "config" if of_file => arg.help_heading(WITHOUT_FILE),
        "out" | "replace" | "threads" if name == "reduce" => of_reduce(arg),
        "out" if name == "draw" || name == "fmu" => {
            let help = match name.as_str() {
                "draw" => "Folder for the sketch, NAME.svg and NAME.png with the name of the machine",
                _ => "Folder for the FMU",
            };
            arg.help(help).long_help(help)
        }
        "width" if name == "draw" => {
            let help = "Width of the sketch in print, with names of 7 points, e.g. 84mm for one column of a \
                        journal [default: a sketch for a screen]";
            let more = "A sketch that is too wide for this gets smaller names, and a note tells their size.";
            arg.help(help).long_help(format!("{help}\n\n{more}"))
        }
        "threads" if name == "run" => arg.help_heading(WITHOUT_FILE),
        _ => arg,
    });
    own.fold(command, clap::Command::arg)
}

/// The machine's file, if one was named.
pub fn file(matches: &ArgMatches) -> Option<&Path> {
    matches.subcommand()?.1.try_get_one::<PathBuf>(FILE).ok()?.map(PathBuf::as_path)
}

/// Largest number of commands that the refusal of an option names.
const OTHERS: usize = 3;

/// Refuses a FILE after `vibro paper`, a shared option that the command does not use, options of
/// the paper's machine if a FILE is given, and options of a machine file if no FILE is given.
///
/// # Errors
/// [`Error::Refused`] with the option and the valid options.
pub fn check_options(matches: &ArgMatches, grouped: bool) -> Result<()> {
    let (all, file) = (ungrouped(), file(matches));
    let Some((name, matches)) = matches.subcommand() else { return Ok(()) };
    let Some(command) = all.find_subcommand(name) else { return Ok(()) };
    if file.is_none() && has_file(command) {
        missing_file::check(command, matches, grouped)?;
    }
    paper::check_spelling(command, file, grouped)?;
    let words = paper::spelled(command, file);
    let is_given = |arg: &&Arg| matches.value_source(arg.get_id().as_str()) == Some(ValueSource::CommandLine);
    let option = |arg: &Arg| format!("--{}", arg.get_long().unwrap_or_default());
    let is_unused = |arg: &&Arg| unused(name).contains(&arg.get_id().as_str());
    if let Some(given) = command.get_arguments().filter(is_unused).find(is_given) {
        let taken = all.get_arguments().filter(|arg| !is_unused(arg) && arg.get_long() != Some("help"));
        let taken: Vec<String> = taken.map(option).collect();
        let taken = if taken.is_empty() { "none".into() } else { format!("only {}", taken.join(", ")) };
        let problem =
            format!("`vibro {words}` does not use this option; of the common options it accepts {taken}");
        return Err(Error::Refused { what: option(given), problem });
    }
    if !has_file(command) {
        return Ok(());
    }
    let refused = if file.is_some() { WITHOUT_FILE } else { WITH_FILE };
    let mut under = command.get_arguments().filter(move |a| a.get_help_heading() == Some(refused));
    let Some(given) = under.find(is_given) else { return Ok(()) };
    let others = with_file(&all, given);
    let whose = match file {
        Some(_) if !others.is_empty() => {
            let shown = &others[..others.len().min(OTHERS)];
            let more = match others.len() - shown.len() {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            format!("not an option of `vibro {name}` for a machine file, but of {}{more}", shown.join(", "))
        }
        Some(file) => format!("an option of the paper's machine, but {} is a machine file", file.display()),
        None => format!("an option of a machine's file: `vibro {name} FILE {} …`", option(given)),
    };
    let problem = format!("is {whose}; `vibro {words} --help` lists the options");
    Err(Error::Refused { what: option(given), problem })
}

/// The commands that take an option for a machine file.
fn with_file(all: &clap::Command, option: &Arg) -> Vec<String> {
    let takes = |command: &&clap::Command| {
        let is_own =
            |arg: &Arg| arg.get_long() == option.get_long() && arg.get_help_heading() != Some(WITHOUT_FILE);
        has_file(command)
            && !unused(command.get_name()).contains(&option.get_id().as_str())
            && command.get_arguments().any(is_own)
    };
    all.get_subcommands().filter(takes).map(|command| format!("`vibro {}`", command.get_name())).collect()
}

/// Reads numbers below zero as values, so that an option can refuse them with a reason.
fn with_negative_numbers(command: clap::Command) -> clap::Command {
    let taken = |arg: clap::Arg| {
        let takes = arg.get_action().takes_values() && !arg.is_positional();
        if takes { arg.allow_negative_numbers(true) } else { arg }
    };
    command.mut_args(taken).mut_subcommands(with_negative_numbers)
}

/// The command line.
#[derive(Debug, Parser)]
#[command(name = "vibro", version, about = ABOUT, after_help = PARAMETERS, arg_required_else_help = true)]
pub struct Arguments {
    /// Options of every command.
    #[command(flatten)]
    pub common: Common,
    /// The command.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Summarise a machine file: bodies, elements, degrees of freedom, state at the start,
    /// equilibrium, natural frequencies
    Check {
        /// Machine file (TOML), described in docs/machine-file.md
        #[arg(value_name = "FILE")]
        file: PathBuf,
    },
    /// Draw a sketch of a machine file as SVG and PNG: bodies in a row, springs, dashpots, stops,
    /// friction, loads
    Draw {
        /// Machine file (TOML), described in docs/machine-file.md
        #[arg(value_name = "FILE")]
        file: PathBuf,
    },
    /// Write the file of a gallery machine, with comments, as a starting point; without a name,
    /// list all gallery machines
    New(New),
    /// Write an FMU of a machine file for Co-Simulation and Model Exchange, using the prebuilt
    /// library
    ///
    /// The library, `machine-kit.zip`, is given by --kit, or is found in the folder that the
    /// environment variable VIBRO_IMPACT_ARCHIVES names, next to the program, or one folder above
    /// it. In the repository, `cargo run --bin fmu-build` builds it.
    Fmu(Fmu),
    /// Reduce the matrices of a finite-element program to a body of a machine file, with an error
    /// statement
    ///
    /// OUT.toml has the body `[modal.NAME]` with its nodes, OUT.npz the displacements of all dofs by
    /// each coordinate, OUT.txt what was reduced and how far it is right. Part of a program that was
    /// built with `--features reduce`.
    Reduce(Box<ReduceArguments>),
    /// Simulate a motion exactly from event to event: tables of states, events and contacts, a
    /// picture, an energy balance
    Run(RunArguments),
    /// Make a table of many designs with their amplitudes, forces, impacts and losses: all
    /// combinations of parameters, or points of a Sobol sequence
    ///
    /// The table has a row for each design, in SI, as CSV and Parquet. A design can be evaluated
    /// for several motions, for example over a band of drive frequencies (--over), and from
    /// several starts. The row then has the smallest, mean and largest values. A design that
    /// cannot be simulated has a row with the reason.
    Sweep(Box<Sweep>),
    /// Optimise parameters of a machine file: minimise or maximise an output, also over a band of
    /// a parameter, with limits and tolerances
    ///
    /// The search is global (Sobol sequence, then differential evolution) and local (exact
    /// derivatives of periodic orbits). It reports the best parameters, the error of the output,
    /// whether other designs can be distinguished from the best one, and other motions of the best
    /// design.
    Design(DesignArguments),
    /// Fit parameters of a machine file to a record: values with errors, undetermined parameters,
    /// residuals, the fitted machine file
    ///
    /// Nonlinear least squares with exact derivatives through impacts and friction. The fit begins
    /// with the time over which the motion stays near the record, and continues with longer times.
    Fit(FitArguments),
    /// Draw a bifurcation diagram: local maxima of a coordinate or quantity over a parameter, both
    /// directions, with periods and classes (figure 14)
    ///
    /// Each value starts from the last state of the previous value. This chain of motions cannot
    /// be divided among shards: every shard repeats it, and it is about a fifth of the work. More
    /// than about four shards therefore hardly help. `lyapunov` and planes gain from more shards.
    ///
    /// The motion of a FILE is sampled once per common period of its drives; --period and
    /// --section change this.
    Bifurcation(Bifurcation),
    /// Draw a bifurcation diagram with Lyapunov exponents (figure 14, table 2); for a FILE without
    /// --vary, compute the largest exponent of the machine as given
    ///
    /// The diagram shows all exponents of the paper's machine, or the largest exponent for a FILE.
    /// For a FILE one variation is carried exactly through flights and events (saltation
    /// matrices); --spectrum computes all exponents of the machine as given.
    Lyapunov(Lyapunov),
    /// Compute all steady-state values of one parameter set, by three theories (figure 8)
    Steady,
    /// Draw response curves with stable and unstable parts, folds and ends: of a FILE over any
    /// parameter; of the paper's machine by theory (figures 10, 11)
    ///
    /// For a FILE, motions are simulated until they settle, while the parameter rises and falls.
    /// Each orbit on which a motion settles is followed over the whole range, stable or not.
    Response(Response),
    /// Draw the slow invariant manifold and its fixed points (figures 2, 7, 9)
    Manifold(Manifold),
    /// Draw the stability limits of the periodic motion (figures 5, 6)
    Stability(Stability),
    /// Draw the regions of two parameters in which a stable motion exists, by theory (figure 12)
    Plane(Plane),
    /// Compare theory with simulation: histories, maxima, errors over the mass ratio (figures 8,
    /// 16 to 19)
    Compare(Compare),
    /// Draw basins of attraction over two initial values
    ///
    /// For a FILE, attractors are distinguished by class, period and states at the section, and
    /// named by the events of their orbits. All motions of one class without a period count as one
    /// attractor.
    Basin(Basin),
    /// Draw a Poincaré section of the settled motion of a machine file, at a phase of the period
    /// or at each event of an element
    Section(SectionOfFile),
    /// Draw the simulated motion over two parameters: period, impacts, chaos, compared with the
    /// exact orbit
    Isoperiodic(Isoperiodic),
    /// Follow branches of periodic orbits over a parameter, stable or not, with their bifurcations
    ///
    /// Without --tree, one branch is followed, from the settled motion or from the orbit of a
    /// given word (--word). `special-points.csv` lists the special points of the branches: LP
    /// fold, BP branch point, PD period doubling, NS Neimark-Sacker, GR touch (grazing), CH
    /// chatter, EP end of the range, MX not followed further. For a FILE also ST one more sticking
    /// phase or slip, CC another order of two events, SA a limit of a block's output.
    /// `vibro locus` follows all kinds but EP and MX over two parameters. With --tree,
    /// `orbits-search.csv` lists the parameter values of the search and the number of starts at
    /// each.
    Orbits(Box<Orbits>),
    /// Compute one periodic orbit: impacts, multipliers, history, portrait, start values
    Orbit(OneOrbit),
    /// Follow curves of special points of `vibro orbits` over two parameters
    Locus(Loci),
    /// Draw a study from parts that were computed separately (--shard)
    Merge(Merge),
    /// Print a parameter file to fill in: every parameter with unit, range and default
    Template(Template),
    /// Draw all figures of the paper, and write a report that compares its statements with the
    /// results
    Reproduce(Reproduce),
}

impl Command {
    /// Parses the axes of a command without a file as parameters of the paper's machine.
    ///
    /// # Errors
    /// An error if an axis is not valid.
    pub fn read_axes(&mut self) -> Result<()> {
        match self {
            Self::Run(a) => a.of_paper.start = one_start(&a.start)?,
            Self::Sweep(a) => {
                a.of_paper.start = texts("--start", &a.start)?;
                (a.of_paper.vary, a.of_paper.over) = (texts("--vary", &a.vary)?, texts("--over", &a.over)?);
            }
            Self::Bifurcation(a) | Self::Lyapunov(Lyapunov { sweep: a, .. }) => {
                if a.vary.len() > 1 {
                    let what = format!("--vary {}", a.vary.join(" --vary "));
                    let problem = "expected one parameter; use `vibro paper isoperiodic` for \
                                   planes of two parameters"
                        .into();
                    return Err(Error::Refused { what, problem });
                }
                a.of_paper.range = texts("--vary", &a.vary)?.pop();
                a.of_paper.start = one_start(&a.start)?.unwrap_or_default();
            }
            Self::Basin(a) => a.of_paper.start = one_start(&a.start)?,
            Self::Response(a) => {
                a.of_paper.range = texts("--vary", &a.range)?;
                let of = a.of.as_ref().map(|of| of.parse().map_err(in_option("--of")));
                a.of_paper.of = of.transpose()?;
            }
            Self::Orbits(a) => {
                if a.vary.len() > 1 {
                    let what = format!("--vary {}", a.vary.join(" --vary "));
                    return Err(Error::Refused { what, problem: "expected one parameter".into() });
                }
                a.range = texts("--vary", &a.vary)?.pop();
            }
            Self::Locus(a) => a.ranges = texts("--vary", &a.vary)?,
            _ => {}
        }
        Ok(())
    }
}

/// The start of the paper's machine, if it is given.
fn one_start(given: &[String]) -> Result<Option<StartRule>> {
    one_of(given)?;
    Ok(texts("--start", given)?.pop())
}

/// Refuses several starts of one motion.
pub fn one_of(given: &[String]) -> Result<Option<&String>> {
    if given.len() > 1 {
        let what = format!("--start {}", given.join(" --start "));
        let problem = "expected one start, with commas between its values".into();
        return Err(Error::Refused { what, problem });
    }
    Ok(given.first())
}

#[cfg(test)]
mod tests;
