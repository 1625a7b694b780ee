//! Arguments of `basin` and `section`: the attractors of motions from many starts, and the points
//! of one motion at its section.

use crate::common_arguments::{
    ConstantLoads, START_VALUE, SectionArguments, WITH_FILE, WITHOUT_FILE, angle, start_help,
};
use crate::ranges::{Share, whole};
use clap::Args;
use clap::builder::ArgPredicate::IsPresent;
use std::path::PathBuf;
use vibro_studies::paper::basin::InitialValueRange;
use vibro_studies::paper::start::StartRule;

/// Arguments of `basin`.
#[derive(Args, Debug)]
pub struct Basin {
    /// Machine file (TOML), described in docs/machine-file.md. Without FILE, the paper's machine
    #[arg(value_name = "FILE")]
    pub file: Option<PathBuf>,
    /// With FILE two ranges of initial values, each as NAME=FROM:TO[:COUNT], e.g. block.s=-4mm:4mm
    /// and block.v=-1:1, the first on the horizontal axis; a range of time varies the phase of the
    /// drive. A further --start gives the other initial values, as in `vibro run`. Without FILE
    /// initial values that are not on an axis, e.g. block.s=5mm,v1=1; zero unless given
    #[arg(long, value_name = "NAME=VALUE|FROM:TO", allow_hyphen_values = true)]
    pub start: Vec<String>,
    /// Number of cells on each axis [default: 100; with FILE 60]
    #[arg(long, value_name = "N", default_value = "100", default_value_if("file", IsPresent, "60"))]
    #[arg(hide_default_value = true, value_parser = whole::<u16>(2..=5_000))]
    pub resolution: u16,
    /// Periods discarded; with FILE fewer if the motion settles earlier. An undecided motion is
    /// simulated for up to 8192 more periods
    #[arg(long, value_name = "N", default_value_t = 300, value_parser = whole(0..=u32::MAX))]
    pub discard: u32,
    /// For many machines.
    #[command(flatten)]
    pub share: Share,
    /// Options for a machine file.
    #[command(flatten, next_help_heading = WITH_FILE)]
    pub section: SectionArguments,
    /// Options for the paper's machine.
    #[command(flatten, next_help_heading = WITHOUT_FILE)]
    pub of_paper: BasinOfPaper,
}

/// Options of basins of the paper's machine.
#[derive(Args, Debug)]
#[group(skip)]
pub struct BasinOfPaper {
    /// Initial value on the horizontal axis: x1 x2 x3 in L, v1 v2 v3 in L omega10; box.s block.s
    /// secondary.s box.v block.v secondary.v in SI; each also with a unit (block.s=-20mm:20mm)
    #[arg(long, value_name = "NAME=FROM:TO", default_value = "x1=-1:1", allow_hyphen_values = true)]
    pub x: InitialValueRange,
    /// Initial value on the vertical axis
    #[arg(long, value_name = "NAME=FROM:TO", default_value = "v2=-2:2", allow_hyphen_values = true)]
    pub y: InitialValueRange,
    /// Constant loads.
    #[command(flatten)]
    pub loads: ConstantLoads,
    /// The parsed start.
    #[arg(skip)]
    pub start: Option<StartRule>,
}

/// Arguments of `section`.
#[derive(Args, Debug)]
pub struct SectionOfFile {
    /// Machine file (TOML), described in docs/machine-file.md
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Start of the motion.
    #[arg(long, help = start_help!("Start of the motion"), value_name = START_VALUE, allow_hyphen_values = true)]
    pub start: Vec<String>,
    /// Section of the motion.
    #[command(flatten)]
    pub section: SectionArguments,
    /// Sample the motion at this phase of each period, in rad or with a unit, e.g. 90deg
    #[arg(long, value_name = "ANGLE", default_value = "0", value_parser = angle, allow_hyphen_values = true)]
    pub phase: f64,
    /// Periods discarded, fewer if the motion settles earlier
    #[arg(long, value_name = "N", default_value_t = 300, value_parser = whole(0..=u32::MAX))]
    pub discard: u32,
    /// Number of points of the section
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = whole::<u32>(1..=10_000_000))]
    pub keep: u32,
    /// Horizontal and vertical axis: two columns, e.g. box.s,box.v, or time, phase, and at the
    /// events of a stop its closing speed (speed) [default: position and velocity of the first
    /// free body; at the events of an element phase,speed]
    #[arg(long, value_name = "NAME,NAME")]
    pub of: Option<String>,
}
