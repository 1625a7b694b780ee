//! The command line: commands, options and their help.

use crate::assembly_arguments::AssemblyCommand;
use crate::common_arguments::Common;
use crate::orbits_arguments::{Loci, OneOrbit, Orbits};
use crate::run::Run;
use crate::study_arguments::{
    Basin, Bifurcation, Compare, Isoperiodic, Lyapunov, Manifold, Merge, Plane, Reproduce, Response,
    Stability, Template,
};
use crate::sweep_arguments::Sweep;
use clap::{CommandFactory, Parser, Subcommand};

const ABOUT: &str = "\
A 3-DOF vibro-impact model: steady states, response curves, stability, bifurcations, exponents, basins
Figure numbers are those of Nonlinear Dynamics 106 (2021) 81-103.";

const PARAMETERS: &str = "\
PARAMETERS
  Groups:  epsilon kappa f10 sigma1 gamma1 alpha23 beta2 sigma30 gamma3 mu13
  SI:      box.m box.k box.c block.m secondary.m secondary.k secondary.c coupling.k
           stop.gap stop.restitution drive.amplitude drive.frequency drive.phase
  Loads:   load.box load.block load.secondary: constant forces in N, 0 unless set, for gravity or an off-centre gap
  Symbols work as names too: m1 k1 c1 m2 m3 k3 c3 k23 L F10 omega1, κ ε σ1 …; F10 is the force in N, f10 its group.
  Values may have a unit of the parameter's dimension: 12kg, 350 g, 48 kN/m, 48 N/mm, 2.5mm, 10Hz, 600rpm, 30deg.
  A number without a unit is in the unit in which the file or an earlier --set wrote that parameter, and the program says so.
  Where none was written, it is in SI; an angular frequency is then in rad/s. The rule holds in --set and on every axis (--vary,
  --range, --over, --values, --at, --mark, columns of --design). Screen and pictures show that unit. Tables are in SI, with one
  more column for each such parameter at the end, e.g. `drive.frequency [Hz]`.
  A parameter that is not set has its default, which is a reconstruction and not the paper's own data.
  A parameter file is TOML with a table [si], a table [groups], or both; [groups] is applied after [si], and --set after the file.
  `vibro template` writes a file with every parameter.

EXAMPLES
  vibro steady --set kappa=0.6 --set f10=2
  vibro run --config machine.toml --start x1=0.2,v2=1 --load box=record.csv
  vibro response --values f10=1,1.5,2 --range sigma1=-1:1
  vibro plane --pair sigma1,f10 --resolution 1000 --method exact-orbit
  vibro compare --figure 17 --values epsilon=0.1,0.05,0.02,0.01
  vibro lyapunov --range f10=1.9:4 --resolution 1051
  vibro isoperiodic --pair sigma1,f10 --resolution 200
  vibro template > machine.toml    (fill it in; texts with a unit in quotation marks)
  vibro bifurcation --config machine.toml --vary drive.frequency=9Hz:11Hz:200
  vibro plane --config machine.toml --pair block.m,stop.gap --vary stop.gap=1mm:20mm
  vibro sweep --config machine.toml --vary block.m=0.4kg:1.6kg:11 --vary stop.gap=2mm:24mm:12 --over drive.frequency=9Hz:11Hz:21
  vibro orbits --tree --vary f10=0.5:5
  vibro bifurcation --orbits --vary f10=2:3:101
  vibro orbit --word UUL --set f10=2.7
  vibro locus --from vibro-out/special-points.csv:PD@2.373 --vary f10=0.5:3 --vary kappa=0.5:0.9
  vibro assembly run my_machine.toml --until 2s --samples 1000 --out my-machine
  vibro basin --set f10=2.45 --shard 1/2 --out one    (another machine: --shard 2/2 --out two)
  vibro merge one two";

/// What the model does not have.
const LIMITS: &str = "\
LIMITS of the 3-DOF machine; `vibro assembly` takes machines of any bodies, with friction, links and compliant stops
  Three bodies on one line: box, block, secondary oscillator. Both stops are rigid and have one coefficient of restitution.
  No friction; springs and dampers are linear.";

/// What is said of the numbers of described machines.
const DESCRIBED: &str = "\
NUMBERS
  A number without a unit is in the unit in which the file or an earlier --set wrote that parameter, and the program says so.
  Where none was written, it is in SI. Times without a unit (--until, --period) are in s. Tables are in SI.
  Names of parameters are the file's own: docs/assemblies.md.";

/// The command line as clap has it. The help of every command names what that command takes; those
/// of the 3-DOF machine end with its limits.
pub fn command() -> clap::Command {
    let with_limits = |command: clap::Command| {
        let own = command.get_after_help().map(|help| format!("{help}\n\n")).unwrap_or_default();
        command.after_help(format!("{own}{LIMITS}"))
    };
    let all = with_negative_numbers(with_limits(Arguments::command()));
    let shared: Vec<clap::Arg> = all.get_arguments().cloned().collect();
    all.mut_subcommands(|command| match command.get_name() {
        // Its machines are of another class.
        "assembly" => of_described_machines(command, &shared),
        "template" => {
            let unused = ["config", "set", "out", "replace", "discard_unfinished", "threads"];
            with_limits(without(command, &shared, &unused))
        }
        "merge" => with_limits(without(command, &shared, &["config", "set"])),
        _ => with_limits(command),
    })
}

/// A command whose help does not name some of the shared options. It refuses or ignores them as
/// before.
fn without(command: clap::Command, shared: &[clap::Arg], names: &[&str]) -> clap::Command {
    let hidden = shared.iter().filter(|arg| names.contains(&arg.get_id().as_str()));
    hidden.fold(command, |command, arg| command.arg(arg.clone().hide(true)))
}

/// `vibro assembly`, whose machine is the file that it names.
fn of_described_machines(command: clap::Command, shared: &[clap::Arg]) -> clap::Command {
    let set = shared.iter().filter(|arg| arg.get_id() == "set").map(|arg| {
        arg.clone()
            .help("Set one parameter of the machine by its name, e.g. stop.upper.gap=5mm. May be repeated")
    });
    let command = set.fold(without(command, shared, &["config"]), clap::Command::arg);
    command.after_help(DESCRIBED).mut_subcommands(|command| {
        let unused: &[&str] = match command.get_name() {
            "check" => &["out", "replace", "discard_unfinished", "threads"],
            "draw" => &["replace", "discard_unfinished", "threads"],
            "run" => &["discard_unfinished", "threads"],
            _ => &[],
        };
        without(command, shared, unused).after_help(DESCRIBED)
    })
}

/// Takes numbers below zero for values, so that an option which allows none says what it allows.
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
    /// For every command.
    #[command(flatten)]
    pub common: Common,
    /// The command.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// All steady-state values of one parameter set, by three theories (figure 8)
    Steady,
    /// A machine of your own from a text file: bodies, springs, links, stops, friction, loads; its
    /// check and its exact motion
    #[command(subcommand)]
    Assembly(AssemblyCommand),
    /// A motion of the machine, with loads from files: table, impacts, picture, powers
    Run(Run),
    /// Frequency and force response curves, stable and unstable parts (figures 10, 11)
    Response(Response),
    /// The slow invariant manifold and its fixed points (figures 2, 7, 9)
    Manifold(Manifold),
    /// Limits of stability of the periodic motion (figures 5, 6)
    Stability(Stability),
    /// Where a stable motion exists, over two parameters, by theory (figure 12)
    Plane(Plane),
    /// Theory against simulation: histories, maxima, errors over the mass ratio (figures 8, 16 to
    /// 19)
    Compare(Compare),
    /// Bifurcation diagram: local maxima of X2 or of another coordinate over a parameter, both
    /// directions (figure 14)
    ///
    /// Each value starts from the last state of the value before. This chain cannot be divided, so
    /// every shard repeats it, which is about a fifth of the work. Only what is computed at each
    /// value is divided, so that more than about four shards hardly help. `lyapunov` and the planes
    /// gain from more.
    Bifurcation(Bifurcation),
    /// Bifurcation diagram with all Lyapunov exponents (figure 14, table 2)
    Lyapunov(Lyapunov),
    /// Basins of attraction over two initial values
    Basin(Basin),
    /// Simulated motion over two parameters: period, impacts, chaos, beside the exact orbit
    Isoperiodic(Isoperiodic),
    /// Amplitudes, impacts, losses and more of many designs: a grid, a list or a Sobol sequence
    ///
    /// The table has a row for each design, in SI, as CSV and Parquet. A design may be measured in
    /// several motions: from several starts, and over a band such as that of the drive's frequency
    /// (--over). The row then has the least, mean and largest values. A design that cannot be
    /// simulated has a row with the reason.
    #[command(after_help = crate::sweep_arguments::EXAMPLES)]
    Sweep(Box<Sweep>),
    /// Branches of periodic orbits over a parameter, stable or not, with their bifurcations
    ///
    /// Without --tree it follows one branch, which begins at the settled motion or at the orbit
    /// with a given word (--word). `special-points.csv` lists the special points of the branches:
    /// LP fold, BP branch point, PD period doubling, NS Neimark-Sacker, GR touch, CH chatter, EP
    /// end of the range, MX not followed further. `vibro locus` follows the first six over two
    /// parameters. With --tree `orbits-search.csv` lists at which values, and from how many starts,
    /// orbits were sought.
    Orbits(Box<Orbits>),
    /// One periodic orbit: impacts, multipliers, history, portrait, start values
    Orbit(OneOrbit),
    /// Curves of special points of `vibro orbits` over two parameters
    Locus(Loci),
    /// Draws a study whose parts were computed apart (--shard)
    Merge(Merge),
    /// Prints a parameter file to fill in: every parameter, its unit, range and default
    Template(Template),
    /// All figures of the paper, and a report that compares its statements with the results
    Reproduce(Reproduce),
}

#[cfg(test)]
mod tests;
