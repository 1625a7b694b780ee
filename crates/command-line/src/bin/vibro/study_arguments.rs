//! Arguments of `bifurcation`, `lyapunov` and `response`, of studies of the paper's machine, and
//! of `merge`, `template`, `new`, `fmu` and `reproduce`.

use crate::common_arguments::{
    ConstantLoads, START_VALUE, SectionArguments, WITH_FILE, WITHOUT_FILE, start_help,
};
use crate::orbits_arguments::ResponseOfFile;
use crate::ranges::{ParameterPair, ParameterRange, ParameterValues, Share, real, whole, whole_of};
use clap::builder::ArgPredicate::IsPresent;
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use vibro_studies::paper::maxima::Displacement;
use vibro_studies::paper::plane::Method;
use vibro_studies::paper::start::StartRule;

/// Arguments of `bifurcation`.
#[derive(Args, Debug)]
pub struct Bifurcation {
    /// Machine file (TOML), described in docs/machine-file.md. Without FILE, the paper's machine
    #[arg(value_name = "FILE")]
    pub file: Option<PathBuf>,
    /// Parameter and its range, e.g. f10=0.5:5 or, with FILE, stop.steel.gap=1mm:8mm:200. Repeated
    /// for planes [default without FILE: f10=0.5:5]
    #[arg(id = "range", long = "vary", visible_alias = "range", value_name = "NAME=FROM:TO[:COUNT]")]
    #[arg(allow_hyphen_values = true)]
    pub vary: Vec<String>,
    /// Number of values of a range without a count [default: 451; with FILE 200, of a plane 60]
    #[arg(long, value_name = "N", default_value = "451")]
    #[arg(default_value_ifs = [("pair", IsPresent, "60"), ("file", IsPresent, "200")])]
    #[arg(hide_default_value = true, value_parser = whole::<u16>(2..=20_000))]
    pub resolution: u16,
    /// Periods discarded at each value; with FILE fewer if the motion settles earlier [default:
    /// 400; with FILE 300]
    #[arg(long, value_name = "N", default_value = "400", default_value_if("file", IsPresent, "300"))]
    #[arg(hide_default_value = true, value_parser = whole(0..=u32::MAX))]
    pub discard: u32,
    /// Periods recorded at each value [default: 800; with FILE 100]
    #[arg(long, value_name = "N", default_value = "800", default_value_if("file", IsPresent, "100"))]
    #[arg(hide_default_value = true, value_parser = whole(1..=u32::MAX))]
    pub keep: u32,
    /// Coordinate whose local maxima are drawn: x1, x2, x3 or w; with FILE any quantity, e.g.
    /// box.s, box.a or steel.f [default: x2; with FILE the coordinate of the first free body]
    #[arg(long, value_name = "NAME", default_value = "x2")]
    #[arg(default_value_if("file", IsPresent, None::<&str>), hide_default_value = true)]
    pub of: Option<String>,
    /// Start of the first motion in each direction; with --anew or --pair, start of every motion.
    #[arg(long, help = start_help!("Start of the motion at the first value of either direction, and of each motion that does not continue another"), value_name = START_VALUE, allow_hyphen_values = true)]
    #[arg(default_value = "v2=1", default_value_if("file", IsPresent, None::<&str>), hide_default_value = true)]
    pub start: Vec<String>,
    /// Also draw the exact branches of periodic orbits, stable and unstable, with their
    /// bifurcations, and list which rows of the diagram lie on them. `vibro orbits --tree` draws
    /// the branches alone and has more options
    #[arg(long, conflicts_with_all = ["pair", "at_section"])]
    pub orbits: bool,
    /// Part of the study for this computer.
    #[command(flatten)]
    pub share: Share,
    /// Options of a machine's file.
    #[command(flatten, next_help_heading = WITH_FILE)]
    pub of_file: DiagramOfFile,
    /// Options of the paper's machine.
    #[command(flatten, next_help_heading = WITHOUT_FILE)]
    pub of_paper: DiagramOfPaper,
}

/// Options of a diagram of a machine's file.
#[derive(Args, Debug)]
pub struct DiagramOfFile {
    /// Poincaré section at which motions are observed.
    #[command(flatten)]
    pub section: SectionArguments,
    /// Draw the values at the section (Poincaré section) instead of local maxima
    #[arg(long)]
    pub at_section: bool,
    /// Draw classes and contacts over a plane of two parameters, e.g.
    /// stop.steel.gap,body.block.mass, with the ranges of --vary. Each motion has the same start.
    /// May be repeated
    #[arg(long, value_name = "NAME,NAME", conflicts_with_all = ["of", "at_section", "keep"])]
    pub pair: Vec<String>,
    /// Start every motion as the file or --start says, instead of from the last state at the
    /// previous value. Needed for step signals and records that do not repeat. The diagram then
    /// has one direction
    #[arg(long, conflicts_with = "pair")]
    pub anew: bool,
}

/// Options of a diagram of the paper's machine.
#[derive(Args, Debug)]
pub struct DiagramOfPaper {
    /// The parsed start.
    #[arg(skip)]
    pub start: StartRule,
    /// Constant loads.
    #[command(flatten)]
    pub loads: ConstantLoads,
    /// The parsed range of --vary.
    #[arg(skip)]
    pub range: Option<ParameterRange>,
}

/// Arguments of `lyapunov`.
#[derive(Args, Debug)]
pub struct Lyapunov {
    /// Largest number of periods over which exponents are computed. For a FILE: 8 to 1000000; 32
    /// further periods come first, in which the perturbation aligns with the direction of fastest
    /// growth [default: 1500; with FILE 400]
    #[arg(long, value_name = "N", default_value = "1500", default_value_if("file", IsPresent, "400"))]
    #[arg(hide_default_value = true)]
    #[arg(value_parser = whole_of(1..=u32::MAX, "a whole number of at least 1; with FILE from 8 to 1000000"))]
    pub periods: u32,
    /// The diagram.
    #[command(flatten)]
    pub sweep: Bifurcation,
    /// Compute all exponents of the machine as given, over --periods periods of the section. Every
    /// variation is carried through flights and events
    #[arg(long, conflicts_with_all = ["range", "pair"], help_heading = WITH_FILE)]
    pub spectrum: bool,
    /// Threshold, per unit of tau: the computation of a spectrum ends when the standard deviation
    /// of every running exponent over the last 200 periods is below it; 0 counts all periods
    #[arg(long, value_name = "X", default_value_t = 0.0)]
    #[arg(value_parser = real(0.0..=f64::MAX, "a finite number >= 0"), help_heading = WITHOUT_FILE)]
    pub threshold: f64,
    /// Values at which spectra are listed and running exponents shown [default: the value that was
    /// set, otherwise 0.6,1.5,2.45,3.6 for f10 and the quarters of the range for other parameters]
    #[arg(long, value_name = "V,V,…", value_delimiter = ',', allow_hyphen_values = true)]
    #[arg(help_heading = WITHOUT_FILE)]
    pub at: Vec<String>,
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
    /// Start of every motion: x1 x2 x3 in L, v1 v2 v3 in L omega10; box.s block.s secondary.s
    /// box.v block.v secondary.v in SI; each also with a unit (block.s=5mm). A coordinate that is
    /// not given is zero. "orbit" starts on the exact orbit if it is stable
    #[arg(long, value_name = "NAME=VALUE,…", default_value_t = StartRule::default(), allow_hyphen_values = true)]
    pub start: StartRule,
    /// Drive periods discarded, fewer if the motion settles earlier
    #[arg(long, value_name = "N", default_value_t = 300, value_parser = whole(0..=u32::MAX))]
    pub discard: u32,
    /// Largest number of drive periods for each computation of the largest exponent, for motions
    /// without a period. The computation ends as soon as the class is decided. 0 leaves out the
    /// exponents
    #[arg(long, value_name = "N", default_value_t = 4000, value_parser = whole(0..=u32::MAX))]
    pub periods: u32,
    /// Constant loads.
    #[command(flatten)]
    pub loads: ConstantLoads,
    /// Part of the study for this computer.
    #[command(flatten)]
    pub share: Share,
}

/// Arguments of `merge`.
#[derive(Args, Debug)]
pub struct Merge {
    /// Folders of the shards (their --out)
    #[arg(required = true, value_name = "FOLDER")]
    pub folders: Vec<PathBuf>,
}

/// Arguments of `template`.
#[derive(Args, Debug)]
pub struct Template {
    /// Print the machine in SI (the default)
    #[arg(long, conflicts_with = "groups")]
    pub si: bool,
    /// Print the dimensionless groups
    #[arg(long)]
    pub groups: bool,
}

/// Arguments of `new`.
#[derive(Args, Debug)]
pub struct New {
    /// Machine of the gallery, e.g. damper_with_buffer or gear_backlash; without it, all are
    /// listed
    #[arg(value_name = "NAME")]
    pub name: Option<String>,
    /// File to write, which must not exist [default: NAME.toml]
    #[arg(value_name = "TO")]
    pub to: Option<PathBuf>,
}

/// Arguments of `fmu`.
#[derive(Args, Debug)]
pub struct Fmu {
    /// Machine file (TOML), described in docs/machine-file.md
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Version of FMI: 2 writes NAME.fmu, 3 writes NAME-FMI3.fmu
    #[arg(long, value_name = "2|3", default_value = "3", value_parser = ["2", "3"])]
    pub fmi: String,
    /// Prebuilt library for machine files (machine-kit.zip)
    #[arg(long, value_name = "FILE")]
    pub kit: Option<PathBuf>,
}

/// Arguments of `reproduce`.
#[derive(Args, Debug)]
pub struct Reproduce {
    /// Compute fewer values and periods, for a first look within a minute
    #[arg(long)]
    pub quick: bool,
}

/// Arguments of `response`.
#[derive(Args, Debug)]
pub struct Response {
    /// Machine file (TOML), described in docs/machine-file.md. Without FILE, the paper's machine
    #[arg(value_name = "FILE")]
    pub file: Option<PathBuf>,
    /// Range of the parameter over which the response is drawn: with FILE any parameter, e.g.
    /// load.shaker.frequency=8Hz:12Hz; without FILE sigma1 (frequency response), f10 (force
    /// response) or another parameter
    #[arg(id = "range", long = "vary", visible_alias = "range", value_name = "NAME=FROM:TO")]
    #[arg(allow_hyphen_values = true)]
    pub range: Vec<String>,
    /// Output to draw. With FILE an output of `vibro sweep`, e.g. amplitude.box.s or
    /// maximum.buffer.f, or a quantity, whose largest value is drawn; without FILE the amplitude
    /// of x1 (the box), x2 (the block), x3, w = x2 - x1 [default: with FILE the amplitude of the
    /// first free body; without FILE the paper's C and A3]
    #[arg(long, value_name = "NAME")]
    pub of: Option<String>,
    /// Options for a machine file.
    #[command(flatten, next_help_heading = WITH_FILE)]
    pub of_file: ResponseOfFile,
    /// Options for the paper's machine.
    #[command(flatten, next_help_heading = WITHOUT_FILE)]
    pub of_paper: ResponseOfPaper,
}

/// Options of a response of the paper's machine.
#[derive(Args, Debug)]
#[group(skip)]
pub struct ResponseOfPaper {
    /// Curves to draw
    #[arg(long, value_enum, default_value_t = ResponseKind::Both)]
    pub kind: ResponseKind,
    /// Values of the parameter that differs between curves: f10 or gamma1 for the frequency
    /// response, sigma1 for the force response, any other parameter for other responses. A value
    /// that was set is added to the list; without a list it is the only value
    #[arg(long, value_name = "NAME=V,V,…", allow_hyphen_values = true)]
    pub values: Vec<ParameterValues>,
    /// The parsed ranges.
    #[arg(skip)]
    pub range: Vec<ParameterRange>,
    /// The parsed coordinate.
    #[arg(skip)]
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
    /// Figures to draw, by the paper's numbers: the manifold (2), its admissible part (7), its
    /// fixed points (9) [default: all]
    #[arg(long, value_name = "N", value_parser = ["2", "7", "9"])]
    pub figure: Vec<String>,
    /// Parameter that differs between the panels of the fixed points (figure 9), and its values
    /// [default: f10=0.6,1.2,1.5,2.5, or the f10 that was set]
    #[arg(long, value_name = "NAME=V,V,…", allow_hyphen_values = true)]
    pub values: Option<ParameterValues>,
}

/// Arguments of `stability`.
#[derive(Args, Debug)]
pub struct Stability {
    /// Figures to draw, by the paper's numbers: limits over restitution and mass ratio (5),
    /// Masri's plane (6) [default: both]
    #[arg(long, value_name = "N", value_parser = ["5", "6"])]
    pub figure: Vec<String>,
}

/// Planes of two parameters.
#[derive(Args, Debug)]
pub struct Planes {
    /// Two parameters, horizontal first, e.g. sigma1,f10 or block.m,stop.gap
    /// [default: the six pairs of figure 12]
    #[arg(long, value_name = "X,Y")]
    pub pair: Vec<ParameterPair>,
    /// Range of a parameter on its axis
    #[arg(id = "range", long = "vary", visible_alias = "range", value_name = "NAME=FROM:TO[:COUNT]")]
    #[arg(allow_hyphen_values = true)]
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
    /// Figures to draw, by the paper's numbers: histories and phase portraits (8), the force
    /// response with simulated maxima (16), errors over the mass ratio (17), strong coupling (19,
    /// with 18) [default: all]. Parameters of figure 19 that are not set are chosen by the program
    #[arg(long, value_name = "N", value_parser = ["8", "16", "17", "19"])]
    pub figure: Vec<String>,
    /// Range of the force f10 for the simulated maxima (figure 16) [default: f10=0.5:3]
    #[arg(id = "range", long = "vary", visible_alias = "range", value_name = "NAME=FROM:TO[:COUNT]")]
    #[arg(allow_hyphen_values = true)]
    pub range: Option<ParameterRange>,
    /// Number of values of f10 for the simulated maxima (figure 16)
    #[arg(long, value_name = "N", default_value_t = 251, value_parser = whole::<u16>(2..=10_000))]
    pub resolution: u16,
    /// Mass ratios for the errors (figure 17)
    /// [default: epsilon=0.1,0.05,0.02,0.01,0.005, or the epsilon that was set]
    #[arg(long, value_name = "NAME=V,V,…")]
    pub values: Option<ParameterValues>,
}
