//! Arguments of `vibro orbits`, `vibro orbit`, `vibro locus`, and of a file's response.

use crate::common_arguments::{
    ConstantLoads, START_VALUE, SectionArguments, WITH_FILE, WITHOUT_FILE, start_help,
};
use crate::ranges::{ParameterRange, real, whole};
use clap::Args;
use clap::builder::ArgPredicate::IsPresent;
use std::path::PathBuf;
use vibro::special_points::Selection;
use vibro_orbits::paper::PathOptions;

/// Choice of the orbit.
#[derive(Args, Debug)]
#[group(skip)]
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

/// Motion that leads to the orbits of a machine's file.
#[derive(Args, Debug)]
#[group(skip)]
pub struct Settling {
    /// Start of the motion.
    #[arg(long, help = start_help!("Start of the motion that settles on the orbit"), value_name = START_VALUE, allow_hyphen_values = true)]
    pub start: Vec<String>,
    /// Periods discarded, fewer if the motion settles earlier
    #[arg(long, value_name = "N", default_value_t = 400, value_parser = whole::<u32>(0..=10_000_000))]
    pub discard: u32,
    /// Sample the motion at each impact or first touch of this stop or contact, or each time that
    /// this friction begins to stick [default of a machine without harmonics: its first stop, else
    /// its first contact, else its first friction]
    #[arg(long, value_name = "ELEMENT")]
    pub section: Option<String>,
}

impl Settling {
    pub fn section(&self) -> SectionArguments {
        SectionArguments { period: None, section: self.section.clone() }
    }
}

/// Arguments of `orbit`.
#[derive(Args, Debug)]
pub struct OneOrbit {
    /// Machine file (TOML), described in docs/machine-file.md. Without FILE, the paper's machine
    #[arg(value_name = "FILE")]
    pub file: Option<PathBuf>,
    /// Events of the orbit in order [default: the orbit of the settled motion]. With FILE kinds
    /// and elements, "impact steel, press buffer"; kinds that the word does not mention are left
    /// out, except impact, chatter and press. Without FILE impacts as U (upper stop) and L
    /// (lower stop); a word that ends in "-" is half of a symmetric orbit: U- is the motion with
    /// two symmetric impacts a period
    #[arg(long, value_name = "WORD", allow_hyphen_values = true)]
    pub word: Option<String>,
    /// Period of the orbit: with FILE in common periods of the drive, 2T, or a time, 0.1s; without
    /// FILE the number of drive periods, with --word [default without FILE: 1]
    #[arg(long, value_name = "PERIOD", allow_hyphen_values = true)]
    pub period: Option<String>,
    /// Options for a machine file.
    #[command(flatten, next_help_heading = WITH_FILE)]
    pub settling: Settling,
    /// Number of random starts for the search with --word or --period, if the motion from the
    /// start does not pass near the orbit
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = whole::<u32>(0..=100_000), help_heading = WITH_FILE)]
    pub starts: u32,
    /// Also write gradient.csv: the derivatives of this output of the orbit, e.g. amplitude.box.s
    /// or impact.speed.steel, with respect to every parameter of the file
    #[arg(long, value_name = "NAME", help_heading = WITH_FILE)]
    pub gradient: Option<String>,
    /// Constant loads.
    #[command(flatten, next_help_heading = WITHOUT_FILE)]
    pub loads: ConstantLoads,
}

impl OneOrbit {
    /// The requested orbit of the paper's machine.
    ///
    /// # Errors
    /// [`Error::Refused`](vibro::Error::Refused) for a period outside 1 to 32.
    pub fn which(&self) -> vibro::Result<Which> {
        let read = |text: &String| {
            whole::<u32>(1..=32)(text).map_err(|problem| vibro::Error::Refused {
                what: format!("--period {text}"),
                problem: problem.to_string(),
            })
        };
        let period = self.period.as_ref().map(read).transpose()?.unwrap_or(1);
        Ok(Which { word: self.word.clone(), period, loads: self.loads.clone() })
    }
}

/// Arguments of `orbits`.
#[derive(Args, Debug)]
pub struct Orbits {
    /// Machine file (TOML), described in docs/machine-file.md. Without FILE, the paper's machine
    #[arg(value_name = "FILE")]
    pub file: Option<PathBuf>,
    /// Parameter and its range, with FILE e.g. stop.steel.gap=1mm:8mm [default without FILE:
    /// f10=0.5:5]
    #[arg(long, visible_alias = "range", value_name = "NAME=FROM:TO", allow_hyphen_values = true)]
    pub vary: Vec<String>,
    /// The parsed range of the paper's machine.
    #[arg(skip)]
    pub range: Option<ParameterRange>,
    /// Search for all branches, from settled motions over the whole range (rising and falling),
    /// from orbits near which other motions pass, and from every special point
    #[arg(long, conflicts_with_all = ["word", "period"])]
    pub tree: bool,
    /// Largest number of changes from one branch to another in a row [default: 12; with FILE 3]
    #[arg(long, value_name = "N", default_value = "12", default_value_if("file", IsPresent, "3"))]
    #[arg(hide_default_value = true, value_parser = whole::<u32>(0..=40))]
    pub depth: u32,
    /// Number of parameter values for the search of settled motions, in each direction [default:
    /// 91; with FILE 24]
    #[arg(long, value_name = "N", default_value = "91", default_value_if("file", IsPresent, "24"))]
    #[arg(hide_default_value = true, value_parser = whole::<u32>(1..=10_000))]
    pub seeds: u32,
    /// Longest step along a branch, with phases in rad and the parameter in fifths of its range
    #[arg(long, value_name = "X", default_value_t = 0.05, value_parser = real(PathOptions::STEPS, "a number from 1e-5 to 0.2"))]
    pub step: f64,
    /// Options for a machine file.
    #[command(flatten, next_help_heading = WITH_FILE)]
    pub of_file: OrbitsOfFile,
    /// Options for the paper's machine.
    #[command(flatten, next_help_heading = WITHOUT_FILE)]
    pub of_paper: OrbitsOfPaper,
}

/// Options of the branches of a machine's file.
#[derive(Args, Debug)]
#[group(skip)]
pub struct OrbitsOfFile {
    /// Output to draw and list for each orbit: an output of `vibro sweep`, e.g. amplitude.box.s,
    /// maximum.buffer.f or impact.speed.steel, or a quantity, whose largest value is drawn
    /// [default: amplitude of the first free body]
    #[arg(long, value_name = "NAME")]
    pub of: Option<String>,
    /// The motion.
    #[command(flatten)]
    pub settling: Settling,
}

/// Options of the response of a machine's file.
#[derive(Args, Debug)]
#[group(skip)]
pub struct ResponseOfFile {
    /// The motion.
    #[command(flatten)]
    pub settling: Settling,
    /// Number of parameter values for the search of settled motions, rising and falling
    #[arg(long, value_name = "N", default_value_t = 24, value_parser = whole::<u32>(1..=10_000))]
    pub seeds: u32,
    /// Largest number of changes from one branch to another in a row, at bifurcations and touches
    /// of rigid stops
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = whole::<u32>(0..=40))]
    pub depth: u32,
    /// Longest step along a branch, with phases in rad and the parameter in fifths of its range
    #[arg(long, value_name = "X", default_value_t = 0.05, value_parser = real(PathOptions::STEPS, "a number from 1e-5 to 0.2"))]
    pub step: f64,
}

/// Options of the branches of the paper's machine.
#[derive(Args, Debug)]
#[group(skip)]
pub struct OrbitsOfPaper {
    /// The orbit with which a single branch begins, at the value that was set.
    #[command(flatten)]
    pub which: Which,
    /// Number of further motions, from starts spread over the visited states and over the range;
    /// half as many again are added where motions did not settle on a stable orbit. Stable
    /// branches near which these motions pass are also followed
    #[arg(long, value_name = "N", default_value_t = 512, value_parser = whole::<u32>(0..=1_000_000))]
    pub starts: u32,
    /// Largest number of impacts in an orbit
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = whole::<u32>(1..=128))]
    pub letters: u32,
    /// At a touch, also follow orbits that touch only once in up to this number of passages; they
    /// have a longer period
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u32>(1..=16))]
    pub repetitions: u32,
    /// Parameter values at which every branch gets a point, labelled UZ, separated by commas. May
    /// be repeated
    #[arg(long, value_name = "VALUE", value_delimiter = ',', allow_hyphen_values = true)]
    pub mark: Vec<String>,
}

/// Arguments of `locus`.
#[derive(Args, Debug)]
pub struct Loci {
    /// Machine file (TOML), described in docs/machine-file.md. Without FILE, the paper's machine
    #[arg(value_name = "FILE")]
    pub file: Option<PathBuf>,
    /// Special points from which curves start, in a table of `vibro orbits`. FILE:12 is row 12,
    /// counted from 1; FILE:LP all folds; FILE:LP@2.3041 the folds at this value, to the digits
    /// written; FILE all points. May be repeated. If no curve can be followed from a point, the
    /// program reports this and continues with the others
    #[arg(long, required = true, value_name = "FILE[:ROW|:LABEL@VALUE]")]
    pub from: Vec<Selection>,
    /// Follow only this kind: LP, BP, PD, NS, GR, CH, with FILE also ST, CC, SA
    #[arg(long, value_name = "LABEL")]
    pub label: Option<String>,
    /// Two parameters and their ranges. The first, on the horizontal axis, is the parameter of the
    /// special points
    #[arg(
        long,
        visible_alias = "range",
        required = true,
        value_name = "NAME=FROM:TO",
        allow_hyphen_values = true
    )]
    pub vary: Vec<String>,
    /// The parsed ranges of the paper's machine.
    #[arg(skip)]
    pub ranges: Vec<ParameterRange>,
    /// Constant loads.
    #[command(flatten, next_help_heading = WITHOUT_FILE)]
    pub loads: ConstantLoads,
}
