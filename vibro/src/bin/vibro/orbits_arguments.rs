//! Arguments of `vibro orbits`, `vibro orbit` and `vibro locus`.

use crate::common_arguments::ConstantLoads;
use crate::ranges::{ParameterRange, real, whole};
use clap::Args;
use vibro::special_points::Selection;
use vibro_orbits::PathOptions;

/// Which orbit.
#[derive(Args, Debug)]
pub struct Which {
    /// Impacts of the orbit in order: U (upper stop), L (lower stop)
    /// [default: the orbit of the settled motion]. A word that ends in "-" is half of a symmetric
    /// orbit: U- is the motion with two symmetric impacts a period
    #[arg(long, value_name = "WORD", allow_hyphen_values = true)]
    pub word: Option<String>,
    /// Period of the orbit in drive periods, with --word
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u32>(1..=32))]
    pub period: u32,
    /// Constant loads.
    #[command(flatten)]
    pub loads: ConstantLoads,
}

/// Arguments of `orbit`.
#[derive(Args, Debug)]
pub struct OneOrbit {
    /// The orbit.
    #[command(flatten)]
    pub which: Which,
}

/// Arguments of `orbits`.
#[derive(Args, Debug)]
pub struct Orbits {
    /// Parameter and range [default: f10=0.5:5]
    #[arg(long, visible_alias = "range", value_name = "NAME=FROM:TO", allow_hyphen_values = true)]
    pub vary: Option<ParameterRange>,
    /// The orbit with which a single branch begins, at the value that was set.
    #[command(flatten)]
    pub which: Which,
    /// Look for all branches. It starts from settled motions over the whole range, rising and
    /// falling, from orbits near which other motions pass, and from every special point
    #[arg(long, conflicts_with_all = ["word", "period"])]
    pub tree: bool,
    /// Most changes from one branch to another in a row
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = whole::<u32>(0..=40))]
    pub depth: u32,
    /// Number of parameter values at which settled motions are looked for, in each direction
    #[arg(long, value_name = "N", default_value_t = 91, value_parser = whole::<u32>(1..=10_000))]
    pub seeds: u32,
    /// Number of further motions, from starts spread over the visited states and over the range;
    /// half as many again are added where motions did not settle on a stable orbit. Stable branches
    /// near which these motions pass are followed too
    #[arg(long, value_name = "N", default_value_t = 512, value_parser = whole::<u32>(0..=1_000_000))]
    pub starts: u32,
    /// Most impacts in an orbit
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = whole::<u32>(1..=128))]
    pub letters: u32,
    /// Longest step along a branch; phases count in rad, the parameter in fifths of its range
    #[arg(long, value_name = "X", default_value_t = 0.05, value_parser = real(PathOptions::STEPS, "a length from 1e-5 to 0.2"))]
    pub step: f64,
    /// At a touch, also follow the orbits that touch only once in up to so many passages; they have
    /// a longer period
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u32>(1..=16))]
    pub repetitions: u32,
    /// Values of the parameter at which every branch gets a point, labelled UZ; separated by
    /// commas. May be repeated
    #[arg(long, value_name = "VALUE", value_delimiter = ',', allow_hyphen_values = true)]
    pub mark: Vec<String>,
}

/// Arguments of `locus`.
#[derive(Args, Debug)]
pub struct Loci {
    /// Special points from which curves start, in a table of `vibro orbits`. FILE:12 is row 12,
    /// counted from 1; FILE:LP all folds; FILE:LP@2.3041 the folds at this value, to the digits
    /// written; FILE all points. May be repeated. If no curve can be followed from a point, the
    /// program says so and goes on with the others
    #[arg(long, required = true, value_name = "FILE[:ROW|:LABEL@VALUE]")]
    pub from: Vec<Selection>,
    /// Follow only this kind: LP, BP, PD, NS, GR or CH
    #[arg(long, value_name = "LABEL")]
    pub label: Option<String>,
    /// The two parameters and their ranges. The first, on the horizontal axis, is that of the
    /// special points
    #[arg(
        long,
        visible_alias = "range",
        required = true,
        value_name = "NAME=FROM:TO",
        allow_hyphen_values = true
    )]
    pub vary: Vec<ParameterRange>,
    /// Constant loads.
    #[command(flatten)]
    pub loads: ConstantLoads,
}
