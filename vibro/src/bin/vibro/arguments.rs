//! The command line: commands, options and their help.

use crate::assembly::AssemblyCommand;
use crate::orbits_arguments::{Loci, OneOrbit, Orbits};
use crate::ranges::{ParameterPair, ParameterRange, ParameterValues, Share, real, whole};
use crate::run::Run;
use crate::sweep_arguments::Sweep;
use clap::{Args, CommandFactory, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;
use vibro::load_file::LoadArgument;
use vibro::manifest::Invocation;
use vibro_analysis::basin::InitialValueRange;
use vibro_analysis::maxima::Displacement;
use vibro_analysis::plane::Method;
use vibro_analysis::start::StartRule;

/// The folder of results unless another one is named.
pub const DEFAULT_OUT: &str = "vibro-out";

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
LIMITS
  Three bodies on one line: box, block, secondary oscillator. Both stops are rigid and have one coefficient of restitution.
  No friction; springs and dampers are linear.";

/// The command line as clap has it. The help of every command ends with the model's limits.
pub fn command() -> clap::Command {
    let with_limits = |command: clap::Command| {
        let own = command.get_after_help().map(|help| format!("{help}\n\n")).unwrap_or_default();
        command.after_help(format!("{own}{LIMITS}"))
    };
    with_negative_numbers(with_limits(Arguments::command())).mut_subcommands(|command| {
        match command.get_name() {
            // Its machines are of another class.
            "assembly" => command,
            _ => with_limits(command),
        }
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

/// Arguments of every command.
#[derive(Args, Debug)]
pub struct Common {
    /// Parameter file (TOML) with a table "si", a table "groups" or both
    #[arg(long, global = true, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Set one parameter, e.g. kappa=0.6 or box.k=48kN/m. May be repeated
    #[arg(long, global = true, value_name = "NAME=VALUE")]
    pub set: Vec<String>,
    /// Folder for pictures (SVG, PNG) and tables (CSV)
    ///
    /// A folder with results or parts of another run (other parameters, other options) is refused if it is named here. In the
    /// default folder the new run gets a folder of its own, named after the command and a digest of its parameters.
    #[arg(long, global = true, value_name = "FOLDER", default_value = DEFAULT_OUT)]
    pub out: PathBuf,
    /// Overwrite finished results of other parameters in the folder
    #[arg(long, global = true)]
    pub replace: bool,
    /// Delete unfinished parts of other parameters in the folder
    #[arg(long, global = true)]
    pub discard_unfinished: bool,
    /// Number of threads [default: all cores]. Results do not depend on it
    #[arg(long, global = true, value_name = "N", value_parser = whole(1..=u16::MAX))]
    pub threads: Option<u16>,
    /// What was given, for manifests.
    #[arg(skip)]
    pub invocation: Invocation,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// All steady-state values of one parameter set, by three theories (figure 8)
    Steady,
    /// A machine of your own from a text file: bodies, springs, links, stops, friction, loads; its check and its exact motion
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
    /// Theory against simulation: histories, maxima, errors over the mass ratio (figures 8, 16 to 19)
    Compare(Compare),
    /// Bifurcation diagram: local maxima of X2 or of another coordinate over a parameter, both directions (figure 14)
    ///
    /// Each value starts from the last state of the value before. This chain cannot be divided, so every shard repeats it, which is
    /// about a fifth of the work. Only what is computed at each value is divided, so that more than about four shards hardly help.
    /// `lyapunov` and the planes gain from more.
    Bifurcation(Bifurcation),
    /// Bifurcation diagram with all Lyapunov exponents (figure 14, table 2)
    Lyapunov(Lyapunov),
    /// Basins of attraction over two initial values
    Basin(Basin),
    /// Simulated motion over two parameters: period, impacts, chaos, beside the exact orbit
    Isoperiodic(Isoperiodic),
    /// Amplitudes, impacts, losses and more of many designs: a grid, a list or a Sobol sequence
    ///
    /// The table has a row for each design, in SI, as CSV and Parquet. A design may be measured in several motions: from several
    /// starts, and over a band such as that of the drive's frequency (--over). The row then has the least, mean and largest values.
    /// A design that cannot be simulated has a row with the reason.
    #[command(after_help = crate::sweep_arguments::EXAMPLES)]
    Sweep(Box<Sweep>),
    /// Branches of periodic orbits over a parameter, stable or not, with their bifurcations
    ///
    /// Without --tree it follows one branch, which begins at the settled motion or at the orbit with a given word (--word).
    /// `special-points.csv` lists the special points of the branches: LP fold, BP branch point, PD period doubling, NS
    /// Neimark-Sacker, GR touch, CH chatter, EP end of the range, MX not followed further. `vibro locus` follows the first six over
    /// two parameters. With --tree `orbits-search.csv` lists at which values, and from how many starts, orbits were sought.
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

/// Loads that do not change.
#[derive(Args, Clone, Debug, Default)]
pub struct ConstantLoads {
    /// Constant force on box, block or secondary, in N or with a unit. May be repeated; forces on one body add. Gravity on a block
    /// of 0.6 kg in a vertical machine is block=-5.9N. A gap that is off centre by d is the pair block=-k23*d, secondary=k23*d. As
    /// an axis the force is the parameter load.block. Loads from files: `vibro run`
    #[arg(long, value_name = "BODY=FORCE", allow_hyphen_values = true)]
    pub load: Vec<LoadArgument>,
}

/// Arguments of `bifurcation`.
#[derive(Args, Debug)]
pub struct Bifurcation {
    /// Parameter and range [default: f10=0.5:5]
    #[arg(long, visible_alias = "vary", value_name = "NAME=FROM:TO[:COUNT]", allow_hyphen_values = true)]
    pub range: Option<ParameterRange>,
    /// Values in the range
    #[arg(long, value_name = "N", default_value_t = 451, value_parser = whole::<u16>(2..=20_000))]
    pub resolution: u16,
    /// Drive periods discarded at each value
    #[arg(long, value_name = "N", default_value_t = 400, value_parser = whole(0..=u32::MAX))]
    pub discard: u32,
    /// Displacement whose local maxima are drawn: x1, x2, x3 or w
    #[arg(long, value_name = "NAME", default_value_t = Displacement::X2)]
    pub of: Displacement,
    /// Start of the motion at the first value of either direction: x1 x2 x3 in L, v1 v2 v3 in L omega10; box.s block.s
    /// secondary.s box.v block.v secondary.v in SI; each also with a unit (block.s=5mm). A coordinate that is not named is
    /// zero. "orbit" starts on the exact orbit where it is stable
    #[arg(long, value_name = "NAME=VALUE,…", default_value_t = StartRule::default(), allow_hyphen_values = true)]
    pub start: StartRule,
    /// Also draw the exact branches of periodic orbits, stable and unstable, with their bifurcations, and list which rows of the
    /// diagram lie on them. `vibro orbits --tree` draws the branches alone and has more options
    #[arg(long)]
    pub orbits: bool,
    /// Drive periods kept at each value
    #[arg(long, value_name = "N", default_value_t = 800, value_parser = whole(1..=u32::MAX))]
    pub keep: u32,
    /// Constant loads.
    #[command(flatten)]
    pub loads: ConstantLoads,
    /// For many machines.
    #[command(flatten)]
    pub share: Share,
}

/// Arguments of `lyapunov`.
#[derive(Args, Debug)]
pub struct Lyapunov {
    /// The sweep.
    #[command(flatten)]
    pub sweep: Bifurcation,
    /// Most drive periods over which exponents are computed
    #[arg(long, value_name = "N", default_value_t = 1500, value_parser = whole(1..=u32::MAX))]
    pub periods: u32,
    /// End a spectrum once the standard deviation of the running exponents over 200 periods is below this, per unit of tau
    #[arg(long, value_name = "X", default_value_t = 0.0, value_parser = real(0.0..=f64::MAX, "a finite number >= 0"))]
    pub threshold: f64,
    /// Values at which spectra are listed and running exponents shown [default: of f10 0.6,1.5,2.45,3.6 or the value that was set;
    /// of other parameters the quarters of the range]
    #[arg(long, value_name = "V,V,…", value_delimiter = ',', allow_hyphen_values = true)]
    pub at: Vec<String>,
}

/// Arguments of `basin`.
#[derive(Args, Debug)]
pub struct Basin {
    /// Initial value on the horizontal axis: x1 x2 x3 in L, v1 v2 v3 in L omega10; box.s block.s secondary.s box.v block.v
    /// secondary.v in SI; each also with a unit (block.s=-20mm:20mm)
    #[arg(long, value_name = "NAME=FROM:TO", default_value = "x1=-1:1", allow_hyphen_values = true)]
    pub x: InitialValueRange,
    /// Initial value on the vertical axis
    #[arg(long, value_name = "NAME=FROM:TO", default_value = "v2=-2:2", allow_hyphen_values = true)]
    pub y: InitialValueRange,
    /// Cells on each axis
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = whole::<u16>(2..=5_000))]
    pub resolution: u16,
    /// Initial values of the other coordinates, e.g. block.s=5mm,v1=1; zero unless named
    #[arg(long, value_name = "NAME=VALUE,…", allow_hyphen_values = true)]
    pub start: Option<StartRule>,
    /// Drive periods discarded. A motion that has not settled then is followed for up to 8192 more
    #[arg(long, value_name = "N", default_value_t = 300, value_parser = whole(0..=u32::MAX))]
    pub discard: u32,
    /// Constant loads.
    #[command(flatten)]
    pub loads: ConstantLoads,
    /// For many machines.
    #[command(flatten)]
    pub share: Share,
}

/// Arguments of `isoperiodic`.
#[derive(Args, Debug)]
pub struct Isoperiodic {
    /// The planes.
    #[command(flatten)]
    pub planes: Planes,
    /// Values on each axis
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = whole::<u16>(2..=3_000))]
    pub resolution: u16,
    /// Start of every motion: x1 x2 x3 in L, v1 v2 v3 in L omega10; box.s block.s secondary.s box.v block.v secondary.v in SI;
    /// each also with a unit (block.s=5mm). A coordinate that is not named is zero. "orbit" starts on the exact orbit where it is
    /// stable
    #[arg(long, value_name = "NAME=VALUE,…", default_value_t = StartRule::default(), allow_hyphen_values = true)]
    pub start: StartRule,
    /// Drive periods discarded. A motion that has settled earlier is not simulated further
    #[arg(long, value_name = "N", default_value_t = 300, value_parser = whole(0..=u32::MAX))]
    pub discard: u32,
    /// Most drive periods over which the largest exponent of a motion without a period is computed at a time. The computation ends
    /// once the class is decided. 0 leaves the exponents out
    #[arg(long, value_name = "N", default_value_t = 4000, value_parser = whole(0..=u32::MAX))]
    pub periods: u32,
    /// Constant loads.
    #[command(flatten)]
    pub loads: ConstantLoads,
    /// For many machines.
    #[command(flatten)]
    pub share: Share,
}

/// Arguments of `merge`.
#[derive(Args, Debug)]
pub struct Merge {
    /// The folders given to the shards as --out
    #[arg(required = true, value_name = "FOLDER")]
    pub folders: Vec<PathBuf>,
}

/// Arguments of `template`.
#[derive(Args, Debug)]
pub struct Template {
    /// The machine in SI (the default)
    #[arg(long, conflicts_with = "groups")]
    pub si: bool,
    /// The dimensionless groups
    #[arg(long)]
    pub groups: bool,
}

/// Arguments of `reproduce`.
#[derive(Args, Debug)]
pub struct Reproduce {
    /// Fewer values and periods: a first look within a minute
    #[arg(long)]
    pub quick: bool,
}

/// Arguments of `response`.
#[derive(Args, Debug)]
pub struct Response {
    /// Which curves
    #[arg(long, value_enum, default_value_t = ResponseKind::Both)]
    pub kind: ResponseKind,
    /// Range of sigma1 (frequency response) or f10 (force response). The range of another parameter draws the response along it
    #[arg(long, visible_alias = "vary", value_name = "NAME=FROM:TO[:COUNT]", allow_hyphen_values = true)]
    pub range: Vec<ParameterRange>,
    /// Values that differ between curves: of f10 and gamma1 for the frequency response, of sigma1 for the force response, of any
    /// parameter along another one. A value that was set is added; without a list it is the only one
    #[arg(long, value_name = "NAME=V,V,…", allow_hyphen_values = true)]
    pub values: Vec<ParameterValues>,
    /// Coordinate whose amplitude is drawn: x1 (the box), x2 (the block), x3, w = x2 - x1 [default: the paper's C and A3]
    #[arg(long, value_name = "NAME")]
    pub of: Option<Displacement>,
}

/// Kinds of response.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ResponseKind {
    /// Over sigma1 (figure 10)
    Frequency,
    /// Over f10 (figure 11)
    Force,
    /// Both
    Both,
}

/// Arguments of `manifold`.
#[derive(Args, Debug)]
pub struct Manifold {
    /// What is drawn: the manifold (2), its admissible part (7), its fixed points (9), by the paper's figure numbers [default: all]
    #[arg(long, value_name = "N", value_parser = ["2", "7", "9"])]
    pub figure: Vec<String>,
    /// The parameter that differs between the panels of the fixed points (figure 9), and its values [default:
    /// f10=0.6,1.2,1.5,2.5, or the f10 that was set]
    #[arg(long, value_name = "NAME=V,V,…", allow_hyphen_values = true)]
    pub values: Option<ParameterValues>,
}

/// Arguments of `stability`.
#[derive(Args, Debug)]
pub struct Stability {
    /// What is drawn: limits over restitution and mass ratio (5), Masri's plane (6), by the paper's figure numbers [default: both]
    #[arg(long, value_name = "N", value_parser = ["5", "6"])]
    pub figure: Vec<String>,
}

/// Planes of two parameters.
#[derive(Args, Debug)]
pub struct Planes {
    /// Two parameters, horizontal first, e.g. sigma1,f10 or block.m,stop.gap [default: the six pairs of figure 12]
    #[arg(long, value_name = "X,Y")]
    pub pair: Vec<ParameterPair>,
    /// Range of a parameter on its axis
    #[arg(long, visible_alias = "vary", value_name = "NAME=FROM:TO[:COUNT]", allow_hyphen_values = true)]
    pub range: Vec<ParameterRange>,
}

/// Arguments of `plane`.
#[derive(Args, Debug)]
pub struct Plane {
    /// The planes.
    #[command(flatten)]
    pub planes: Planes,
    /// Values on each axis
    #[arg(long, value_name = "N", default_value_t = 300, value_parser = whole::<u16>(2..=10_000))]
    pub resolution: u16,
    /// Theory that decides existence and stability
    #[arg(long, value_enum, default_value_t = MethodName::MultipleScales)]
    pub method: MethodName,
}

/// Theories.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum MethodName {
    /// Approximation for small mass ratios (paper, section 3)
    MultipleScales,
    /// Approximation for strong coupling (paper, section 5)
    StrongCoupling,
    /// Exact closed form, without a small parameter
    ExactOrbit,
}

impl From<MethodName> for Method {
    fn from(theory: MethodName) -> Self {
        match theory {
            MethodName::MultipleScales => Self::MultipleScales,
            MethodName::StrongCoupling => Self::StrongCoupling,
            MethodName::ExactOrbit => Self::ExactOrbit,
        }
    }
}

/// Arguments of `compare`.
#[derive(Args, Debug)]
pub struct Compare {
    /// What is compared, by the paper's figure numbers: histories and phase portraits (8), the force response with simulated maxima
    /// (16), errors over the mass ratio (17), strong coupling (19, with 18) [default: all]. Numbers that are not set for 19 are
    /// chosen here
    #[arg(long, value_name = "N", value_parser = ["8", "16", "17", "19"])]
    pub figure: Vec<String>,
    /// Range of the force f10 for the simulated maxima (figure 16) [default: f10=0.5:3]
    #[arg(long, visible_alias = "vary", value_name = "NAME=FROM:TO[:COUNT]", allow_hyphen_values = true)]
    pub range: Option<ParameterRange>,
    /// Number of values of f10 for the simulated maxima (figure 16)
    #[arg(long, value_name = "N", default_value_t = 251, value_parser = whole::<u16>(2..=10_000))]
    pub resolution: u16,
    /// Mass ratios for the errors (figure 17) [default: epsilon=0.1,0.05,0.02,0.01,0.005, or the epsilon that was set]
    #[arg(long, value_name = "NAME=V,V,…")]
    pub values: Option<ParameterValues>,
}

#[cfg(test)]
mod tests;
