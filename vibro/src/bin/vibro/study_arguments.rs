//! Arguments of the studies of the 3-DOF machine that have no file of their own.

use crate::common_arguments::ConstantLoads;
use crate::ranges::{ParameterPair, ParameterRange, ParameterValues, Share, real, whole};
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use vibro_analysis::basin::InitialValueRange;
use vibro_analysis::maxima::Displacement;
use vibro_analysis::plane::Method;
use vibro_analysis::start::StartRule;

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
    /// Start of the motion at the first value of either direction: x1 x2 x3 in L, v1 v2 v3 in L
    /// omega10; box.s block.s secondary.s box.v block.v secondary.v in SI; each also with a unit
    /// (block.s=5mm). A coordinate that is not named is zero. "orbit" starts on the exact orbit
    /// where it is stable
    #[arg(long, value_name = "NAME=VALUE,…", default_value_t = StartRule::default(), allow_hyphen_values = true)]
    pub start: StartRule,
    /// Also draw the exact branches of periodic orbits, stable and unstable, with their
    /// bifurcations, and list which rows of the diagram lie on them. `vibro orbits --tree` draws
    /// the branches alone and has more options
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
    /// End a spectrum once the standard deviation of the running exponents over 200 periods is
    /// below this, per unit of tau
    #[arg(long, value_name = "X", default_value_t = 0.0, value_parser = real(0.0..=f64::MAX, "a finite number >= 0"))]
    pub threshold: f64,
    /// Values at which spectra are listed and running exponents shown
    /// [default: of f10 0.6,1.5,2.45,3.6 or the value that was set; of other parameters the quarters of the range]
    #[arg(long, value_name = "V,V,…", value_delimiter = ',', allow_hyphen_values = true)]
    pub at: Vec<String>,
}

/// Arguments of `basin`.
#[derive(Args, Debug)]
pub struct Basin {
    /// Initial value on the horizontal axis: x1 x2 x3 in L, v1 v2 v3 in L omega10; box.s block.s
    /// secondary.s box.v block.v secondary.v in SI; each also with a unit (block.s=-20mm:20mm)
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
    /// Start of every motion: x1 x2 x3 in L, v1 v2 v3 in L omega10; box.s block.s secondary.s box.v
    /// block.v secondary.v in SI; each also with a unit (block.s=5mm). A coordinate that is not
    /// named is zero. "orbit" starts on the exact orbit where it is stable
    #[arg(long, value_name = "NAME=VALUE,…", default_value_t = StartRule::default(), allow_hyphen_values = true)]
    pub start: StartRule,
    /// Drive periods discarded. A motion that has settled earlier is not simulated further
    #[arg(long, value_name = "N", default_value_t = 300, value_parser = whole(0..=u32::MAX))]
    pub discard: u32,
    /// Most drive periods over which the largest exponent of a motion without a period is computed
    /// at a time. The computation ends once the class is decided. 0 leaves the exponents out
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
    /// Range of sigma1 (frequency response) or f10 (force response). The range of another parameter
    /// draws the response along it
    #[arg(long, visible_alias = "vary", value_name = "NAME=FROM:TO[:COUNT]", allow_hyphen_values = true)]
    pub range: Vec<ParameterRange>,
    /// Values that differ between curves: of f10 and gamma1 for the frequency response, of sigma1
    /// for the force response, of any parameter along another one. A value that was set is added;
    /// without a list it is the only one
    #[arg(long, value_name = "NAME=V,V,…", allow_hyphen_values = true)]
    pub values: Vec<ParameterValues>,
    /// Coordinate whose amplitude is drawn: x1 (the box), x2 (the block), x3, w = x2 - x1
    /// [default: the paper's C and A3]
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
    /// What is drawn: the manifold (2), its admissible part (7), its fixed points (9), by the
    /// paper's figure numbers [default: all]
    #[arg(long, value_name = "N", value_parser = ["2", "7", "9"])]
    pub figure: Vec<String>,
    /// The parameter that differs between the panels of the fixed points (figure 9), and its values
    /// [default: f10=0.6,1.2,1.5,2.5, or the f10 that was set]
    #[arg(long, value_name = "NAME=V,V,…", allow_hyphen_values = true)]
    pub values: Option<ParameterValues>,
}

/// Arguments of `stability`.
#[derive(Args, Debug)]
pub struct Stability {
    /// What is drawn: limits over restitution and mass ratio (5), Masri's plane (6), by the paper's
    /// figure numbers [default: both]
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
    /// What is compared, by the paper's figure numbers: histories and phase portraits (8), the
    /// force response with simulated maxima (16), errors over the mass ratio (17), strong coupling
    /// (19, with 18) [default: all]. Numbers that are not set for 19 are chosen here
    #[arg(long, value_name = "N", value_parser = ["8", "16", "17", "19"])]
    pub figure: Vec<String>,
    /// Range of the force f10 for the simulated maxima (figure 16) [default: f10=0.5:3]
    #[arg(long, visible_alias = "vary", value_name = "NAME=FROM:TO[:COUNT]", allow_hyphen_values = true)]
    pub range: Option<ParameterRange>,
    /// Number of values of f10 for the simulated maxima (figure 16)
    #[arg(long, value_name = "N", default_value_t = 251, value_parser = whole::<u16>(2..=10_000))]
    pub resolution: u16,
    /// Mass ratios for the errors (figure 17)
    /// [default: epsilon=0.1,0.05,0.02,0.01,0.005, or the epsilon that was set]
    #[arg(long, value_name = "NAME=V,V,…")]
    pub values: Option<ParameterValues>,
}
