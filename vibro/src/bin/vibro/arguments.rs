//! What can be asked for.

use crate::assembly::AssemblyCommand;
use crate::orbits_arguments::{Loci, OneOrbit, Orbits};
use crate::ranges::{ParameterPair, ParameterRange, ParameterValues, Share};
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

const ABOUT: &str =
    "A 3-DOF vibro-impact model: steady states, response curves, stability, bifurcations, exponents, basins";

const PARAMETERS: &str = "\
PARAMETERS
  Groups:  epsilon kappa f10 sigma1 gamma1 alpha23 beta2 sigma30 gamma3 mu13
  SI:      box.m box.k box.c block.m secondary.m secondary.k secondary.c coupling.k
           stop.gap stop.restitution drive.amplitude drive.frequency drive.phase
  Loads:   load.box load.block load.secondary, constant forces in N, none unless set: gravity, a gap off its centre
  Symbols are names too: m1 k1 c1 m2 m3 k3 c3 k23 L F10 omega1, κ ε σ1 …; F10 is the force in N, f10 its group.
  Values may have a unit of the parameter's dimension: 12kg, 350 g, 48 kN/m, 48 N/mm, 2.5mm, 10Hz, 600rpm, 30deg.
  One rule for a number without a unit, in --set and on every axis (--vary, --range, --over, --values, --at, --mark, columns of
  --design): it is in the unit in which the file or an earlier --set wrote that parameter, and the program says so; else in SI, an
  angular frequency in rad/s. Screen and pictures show that unit; a table keeps its columns in SI and has one more for each, at its
  end, as `drive.frequency [Hz]`.
  What is not set has the value of the default set: a reconstruction, not the paper's own data.
  A parameter file is TOML with a table [si], a table [groups], or both ([groups] is applied last);
  --set comes after the file. `vibro template` writes a file with every parameter.

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

/// What the model has not.
const LIMITS: &str = "\
LIMITS
  Three bodies on one line: box, block, secondary oscillator. Both stops are rigid and have one coefficient of restitution.
  No friction; springs and dampers are linear.";

/// The command line as clap has it. What the model has not is said in the help of every command.
pub fn command() -> clap::Command {
    let with_limits = |command: clap::Command| {
        let own = command.get_after_help().map(|help| format!("{help}\n\n")).unwrap_or_default();
        command.after_help(format!("{own}{LIMITS}"))
    };
    with_limits(Arguments::command()).mut_subcommands(|command| match command.get_name() {
        // Its machines are of another class.
        "assembly" => command,
        _ => with_limits(command),
    })
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
    /// Sets one parameter, e.g. kappa=0.6 or box.k=48kN/m; may be repeated
    #[arg(long, global = true, value_name = "NAME=VALUE")]
    pub set: Vec<String>,
    /// Folder for pictures (SVG, PNG) and tables (CSV)
    ///
    /// A folder that is named here and holds results or parts of another run (other parameters, other options) is refused. In
    /// the default folder such a run gets a folder of its own, named after the command and a digest of its parameters.
    #[arg(long, global = true, value_name = "FOLDER", default_value = DEFAULT_OUT)]
    pub out: PathBuf,
    /// Overwrites finished results of other parameters in the folder
    #[arg(long, global = true)]
    pub replace: bool,
    /// Deletes unfinished parts of other parameters in the folder
    #[arg(long, global = true)]
    pub discard_unfinished: bool,
    /// Number of threads; all cores unless given. Results do not depend on it
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// What was given, for manifests.
    #[arg(skip)]
    pub invocation: Invocation,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// All steady-state values of one parameter set, by all theories (figure 8)
    Steady,
    /// A machine of your own from a text file: bodies, springs, links, stops, friction, loads; its check and its exact motion
    #[command(subcommand)]
    Assembly(AssemblyCommand),
    /// A motion of the machine: table, impacts, picture and account; with loads from files
    Run(Run),
    /// Frequency and force response curves (figures 10, 11)
    Response(Response),
    /// The slow invariant manifold (figures 2, 7, 9)
    Manifold(Manifold),
    /// Stability of the periodic motion (figures 5, 6)
    Stability(Stability),
    /// Existence and stability over planes of two parameters (figure 12)
    Plane(Plane),
    /// Theory against simulation (figures 8, 16, 17, 18 and 19)
    Compare(Compare),
    /// Local maxima of X2, or of another coordinate, over a parameter, both directions, with periods and windows (figure 14)
    ///
    /// A value starts from the last state of the value before, so the motion from value to value is one chain that cannot be
    /// divided: every shard repeats it, about a fifth of the work. Only what is computed at the values is shared, so that more
    /// than some four shards hardly help; `lyapunov` and the planes, where that is nearly all, gain from more.
    Bifurcation(Bifurcation),
    /// The same with all Lyapunov exponents (figure 14, table 2)
    Lyapunov(Lyapunov),
    /// Basins of attraction over two initial values
    Basin(Basin),
    /// Simulated motion over planes of two parameters: period, impacts, chaos, beside the exact orbit
    Isoperiodic(Isoperiodic),
    /// Amplitudes, impacts, losses and more over any number of parameters: a grid, listed designs or a Sobol sequence
    ///
    /// A row for each design, in SI, as CSV and Parquet. A design is judged by one motion or by many: from several starts, and
    /// over an axis such as the drive's frequency in a band, of which least, mean and largest values are told. What makes no
    /// machine or no motion is a row with its reason.
    #[command(after_help = crate::sweep_arguments::EXAMPLES)]
    Sweep(Box<Sweep>),
    /// Branches of periodic orbits over a parameter, stable or not, with folds, period doublings, touches and more
    ///
    /// Without --tree one branch: of the settled motion, or of the orbits with a word. `special-points.csv` lists what lies on the
    /// branches: LP fold, BP branch point, PD period doubling, NS Neimark-Sacker, GR touch, EP end of the range, CH chatter, MX not
    /// followed on; `vibro locus` follows the first five and CH over two parameters. With --tree `orbits-search.csv` tells at which
    /// values, and from how many starts, orbits were sought.
    Orbits(Box<Orbits>),
    /// One periodic orbit: impacts, multipliers, history, portrait, start values
    Orbit(OneOrbit),
    /// Curves of special points of `vibro orbits` over two parameters
    Locus(Loci),
    /// Draws a study whose shards were computed apart
    Merge(Merge),
    /// Writes a parameter file with every parameter, its unit, range and default, to standard output
    Template(Template),
    /// All figures of the paper and a report that sets its statements beside what is found
    Reproduce(Reproduce),
}

/// Loads that do not change.
#[derive(Args, Clone, Debug, Default)]
pub struct ConstantLoads {
    /// Constant force on box, block or secondary, in N or with a unit: gravity on a vertical machine, --load block=-5.9N for 0.6 kg.
    /// May be repeated; forces on one body add. A gap off its centre by d is the pair block=-k23*d, secondary=k23*d. As an axis it
    /// is the parameter load.block. Files are for `vibro run`
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
    #[arg(long, value_name = "N", default_value_t = 451, value_parser = clap::value_parser!(u16).range(2..=20_000))]
    pub resolution: u16,
    /// Drive periods discarded at each value
    #[arg(long, value_name = "N", default_value_t = 400)]
    pub discard: u32,
    /// Displacement whose local maxima are drawn: x1, x2, x3 or w
    #[arg(long, value_name = "NAME", default_value_t = Displacement::X2)]
    pub of: Displacement,
    /// Where the motion at the first value of either direction starts: x1 x2 x3 in L, v1 v2 v3 in L omega10, box.s block.s
    /// secondary.s box.v block.v secondary.v in SI, each also with a unit (block.s=5mm), what is not named zero; or "orbit"
    #[arg(long, value_name = "NAME=VALUE,…", default_value_t = StartRule::default(), allow_hyphen_values = true)]
    pub start: StartRule,
    /// Draws the exact branches of periodic orbits over the points too, stable and unstable, with their bifurcations, and tells
    /// which rows of the diagram lie on them. `vibro orbits --tree` follows them alone, with more options
    #[arg(long)]
    pub orbits: bool,
    /// Drive periods kept at each value
    #[arg(long, value_name = "N", default_value_t = 800, value_parser = clap::value_parser!(u32).range(1..))]
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
    #[arg(long, value_name = "N", default_value_t = 1500, value_parser = clap::value_parser!(u32).range(1..))]
    pub periods: u32,
    /// Ends a spectrum when the running exponents' standard deviation over 200 periods, per unit of tau, is under this
    #[arg(long, value_name = "X", default_value_t = 0.0, allow_negative_numbers = true)]
    pub threshold: f64,
    /// Values of which spectra are listed and running exponents shown [default: 0.6,1.5,2.45,3.6 of f10; the value that
    /// was set; of other parameters the quarters of the range]
    #[arg(long, value_name = "V,V,…", value_delimiter = ',', allow_hyphen_values = true)]
    pub at: Vec<String>,
}

/// Arguments of `basin`.
#[derive(Args, Debug)]
pub struct Basin {
    /// Initial value on the horizontal axis: x1 x2 x3 in L, v1 v2 v3 in L omega10, box.s block.s secondary.s box.v block.v
    /// secondary.v in SI, each also with a unit (block.s=-20mm:20mm)
    #[arg(long, value_name = "NAME=FROM:TO", default_value = "x1=-1:1", allow_hyphen_values = true)]
    pub x: InitialValueRange,
    /// Initial value on the vertical axis
    #[arg(long, value_name = "NAME=FROM:TO", default_value = "v2=-2:2", allow_hyphen_values = true)]
    pub y: InitialValueRange,
    /// Cells on each axis
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u16).range(2..=5_000))]
    pub resolution: u16,
    /// The initial values that are on no axis: as on the axes, what is not named zero (block.s=5mm,v1=1)
    #[arg(long, value_name = "NAME=VALUE,…", allow_hyphen_values = true)]
    pub start: Option<StartRule>,
    /// Drive periods discarded; a motion of which nothing is decided then is followed for up to 8192 more
    #[arg(long, value_name = "N", default_value_t = 300)]
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
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u16).range(2..=3_000))]
    pub resolution: u16,
    /// Where every motion starts: x1 x2 x3 in L, v1 v2 v3 in L omega10, box.s block.s secondary.s box.v block.v secondary.v in SI,
    /// each also with a unit (block.s=5mm), what is not named zero; or "orbit": on the exact orbit where it is stable
    #[arg(long, value_name = "NAME=VALUE,…", default_value_t = StartRule::default(), allow_hyphen_values = true)]
    pub start: StartRule,
    /// Drive periods discarded; a motion that has settled on a period before is not simulated further
    #[arg(long, value_name = "N", default_value_t = 300)]
    pub discard: u32,
    /// Most drive periods over which the largest exponent of a motion with impacts and without a period is computed at a time: it ends
    /// when the class is decided; 0: not at all
    #[arg(long, value_name = "N", default_value_t = 4000)]
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
    /// Fewer values and periods: a look within a minute
    #[arg(long)]
    pub quick: bool,
}

/// Arguments of `response`.
#[derive(Args, Debug)]
pub struct Response {
    /// Which curves
    #[arg(long, value_enum, default_value_t = ResponseKind::Both)]
    pub kind: ResponseKind,
    /// Range of sigma1 (frequency response) or f10 (force response); of any other parameter: the response along it
    #[arg(long, visible_alias = "vary", value_name = "NAME=FROM:TO[:COUNT]", allow_hyphen_values = true)]
    pub range: Vec<ParameterRange>,
    /// Values that differ between curves: f10 and gamma1 (frequency), sigma1 (force), any along another parameter. A value
    /// that was set is one of them, and the only one where none is listed
    #[arg(long, value_name = "NAME=V,V,…", allow_hyphen_values = true)]
    pub values: Vec<ParameterValues>,
    /// Coordinate whose amplitude is drawn: x1 (the box), x2, x3 or w [default: the paper's C and A3]
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
    /// Figure of the paper: 2, 7 or 9; all unless given
    #[arg(long, value_name = "N", value_parser = ["2", "7", "9"])]
    pub figure: Vec<String>,
    /// The parameter that differs between the panels of figure 9, and its values [default: f10=0.6,1.2,1.5,2.5, or the
    /// f10 that was set]
    #[arg(long, value_name = "NAME=V,V,…", allow_hyphen_values = true)]
    pub values: Option<ParameterValues>,
}

/// Arguments of `stability`.
#[derive(Args, Debug)]
pub struct Stability {
    /// Figure of the paper: 5 or 6; both unless given
    #[arg(long, value_name = "N", value_parser = ["5", "6"])]
    pub figure: Vec<String>,
}

/// Planes of two parameters.
#[derive(Args, Debug)]
pub struct Planes {
    /// Two parameters, horizontal first, e.g. sigma1,f10 or block.m,stop.gap; the six pairs of figure 12 unless given
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
    #[arg(long, value_name = "N", default_value_t = 300, value_parser = clap::value_parser!(u16).range(2..=10_000))]
    pub resolution: u16,
    /// The theory by which existence and stability are decided
    #[arg(long, value_enum, default_value_t = MethodName::MultipleScales)]
    pub method: MethodName,
}

/// Theories.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum MethodName {
    /// Paper section 3
    MultipleScales,
    /// Paper section 5
    StrongCoupling,
    /// Exact, without a small parameter
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
    /// Figure of the paper: 8, 16, 17 or 19 (with 18); all unless given. What is not set for 19 is a set of ours
    #[arg(long, value_name = "N", value_parser = ["8", "16", "17", "19"])]
    pub figure: Vec<String>,
    /// Range of f10 in figure 16 [default: f10=0.5:3]
    #[arg(long, visible_alias = "vary", value_name = "NAME=FROM:TO[:COUNT]", allow_hyphen_values = true)]
    pub range: Option<ParameterRange>,
    /// Values of f10 in figure 16
    #[arg(long, value_name = "N", default_value_t = 251, value_parser = clap::value_parser!(u16).range(2..=10_000))]
    pub resolution: u16,
    /// Mass ratios of figure 17 [default: epsilon=0.1,0.05,0.02,0.01,0.005, or the epsilon that was set]
    #[arg(long, value_name = "NAME=V,V,…")]
    pub values: Option<ParameterValues>,
}
