//! Arguments of `vibro sweep`, and the axes of its designs.

use crate::common_arguments::{
    ConstantLoads, START_VALUE, SectionArguments, WITH_FILE, WITHOUT_FILE, start_help,
};
use crate::ranges::{InWrittenUnit, ParameterRange, ParameterValues, Share, whole};
use clap::Args;
use clap::builder::ArgPredicate::IsPresent;
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;
use vibro::{Error, Result};
use vibro_studies::AxisName;
use vibro_studies::design_sweep::{ParameterInterval, SampledAxis};
use vibro_studies::paper::start::StartRule;
use vibro_studies::paper::{Name, Unit};

/// Default measures of the paper's machine.
const DEFAULT: &str =
    "amplitude.x1,amplitude.without_block,amplitude.w,impacts,impact.speed,power.impact,class";

/// Examples with a machine's file.
pub const EXAMPLES: &str = "\
EXAMPLES
  vibro sweep machine.toml --list
  vibro sweep machine.toml --vary stop.steel.gap=1mm:8mm:40 --vary body.block.mass=0.2kg:0.5kg:25";

/// Examples of the paper's machine.
pub const EXAMPLES_OF_PAPER: &str = "\
EXAMPLES of the paper's machine
  vibro paper sweep --config parameters.toml --vary stop.gap=2mm:24mm:100 --output amplitude.x1,impacts
  1188 designs, each by its largest amplitude over a band of drive frequencies and two starts:
    vibro paper sweep --config parameters.toml --vary block.m=0.4kg:1.6kg:11 --vary stop.gap=2mm:24mm:12 \\
      --vary stop.restitution=0.5:0.9:9 --over drive.frequency=9Hz:11Hz:21 --start v2=1 --start x1=1,v2=-1 \\
      --output amplitude.x1,impact.impulse
  vibro paper sweep --vary m2=0.8kg,1.2kg,1.6kg --vary L=5mm:10mm:6 --config parameters.toml
  vibro paper sweep --vary block.m=0.4kg:1.6kg --vary stop.gap=2mm:24mm --sobol 256 --config parameters.toml
  vibro paper sweep --design rows.csv    (a header with names of parameters, then numbers, with or without units)";

/// Description of the tables of a sweep.
pub const TABLE: &str = "\
THE TABLE (sweep.csv, sweep.parquet) has a row for each design: parameters and outputs in SI, the reason if values are missing,
and at the end each parameter that was written in another unit, in that unit (`drive.frequency [Hz]`). With one motion per design,
the column of an output has its name. With several motions there are NAME.min, NAME.mean, NAME.max, and the place of the largest
value: NAME.max.drive.frequency, NAME.max.start. After the reason come NAME.spread (the scatter of a value from one window of the
motion to the next; 0 except for rounding if the motion repeats), the number of periods in the window, and `between` (the number
of values between the values of --over). A design that may be the best has the values of its longest window.";

/// Arguments of `sweep`.
#[derive(Args, Debug)]
pub struct Sweep {
    /// Machine file (TOML), described in docs/machine-file.md. Without FILE, the paper's machine
    #[arg(value_name = "FILE")]
    pub file: Option<PathBuf>,
    /// Parameter and its values, as a range or a list. May be repeated; all combinations are
    /// measured, the last parameter fastest
    #[arg(long, value_name = "NAME=FROM:TO[:COUNT]|V,V,…", allow_hyphen_values = true)]
    pub vary: Vec<String>,
    /// Number of values of a range without a count
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = whole::<u32>(2..=1_000_000))]
    pub resolution: u32,
    /// Measure the first N points of the Sobol sequence in the ranges of --vary instead of all
    /// combinations
    #[arg(long, visible_alias = "samples", value_name = "N", value_parser = whole::<u32>(1..=1_000_000))]
    pub sobol: Option<u32>,
    /// Parameter over which each design is measured as a whole, e.g. the drive frequency in a
    /// band. Designs that may be the best are also measured between the values of a range. May be
    /// repeated
    #[arg(long, value_name = "NAME=FROM:TO[:COUNT]|V,V,…", allow_hyphen_values = true)]
    pub over: Vec<String>,
    /// Outputs to measure: names from --list, separated by commas. May be repeated [default:
    /// amplitudes, impacts, impact speeds, power losses, class]
    #[arg(long, value_name = "NAME,…", value_delimiter = ',', default_value = DEFAULT)]
    #[arg(default_value_if("file", IsPresent, None::<&str>), hide_default_value = true)]
    pub output: Vec<String>,
    /// Periods discarded before a motion is measured; with FILE fewer if the motion settles
    /// earlier [default: 400; with FILE 300]
    #[arg(long, value_name = "N", default_value = "400", default_value_if("file", IsPresent, "300"))]
    #[arg(hide_default_value = true, value_parser = whole(0..=u32::MAX))]
    pub discard: u32,
    /// Periods over which a motion is measured; 60 contain whole periods of 1T to 6T, 10T and 12T
    /// motions
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = whole::<u32>(1..=1_000_000))]
    pub periods: u32,
    /// Cap on additional periods for the designs that may have the smallest first output. They are
    /// measured for longer, and between the values of --over, until the error bars show which one
    /// is the best; 0 adds none [default: 5000000; with FILE 300000]
    #[arg(long, value_name = "N", default_value = "5000000")]
    #[arg(default_value_if("file", IsPresent, "300000"), hide_default_value = true)]
    #[arg(value_parser = whole::<u64>(0..=u64::MAX))]
    pub again: u64,
    /// Starts: every design is run from each.
    #[arg(long, help = start_help!("Start of each design; may be repeated, and every design is measured from each start"), value_name = START_VALUE, allow_hyphen_values = true)]
    pub start: Vec<String>,
    /// List the names of all outputs of the machine, with unit and meaning
    #[arg(long)]
    pub list: bool,
    /// For many machines.
    #[command(flatten)]
    pub share: Share,
    /// Options of a machine's file.
    #[command(flatten, next_help_heading = WITH_FILE)]
    pub section: SectionArguments,
    /// Options of the paper's machine.
    #[command(flatten, next_help_heading = WITHOUT_FILE)]
    pub of_paper: SweepOfPaper,
}

/// Options of a sweep of the paper's machine.
#[derive(Args, Debug)]
pub struct SweepOfPaper {
    /// Designs from a CSV file: a header with names of parameters, a row for each design
    #[arg(long, value_name = "FILE", conflicts_with_all = ["vary", "sobol"])]
    pub design: Option<PathBuf>,
    /// The parsed starts.
    #[arg(skip)]
    pub start: Vec<StartRule>,
    /// Number of further starts, spread evenly over displacements up to 2 L and velocities up to 2
    /// L omega10
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = whole::<u32>(0..=10_000))]
    pub starts: u32,
    /// Constant loads.
    #[command(flatten)]
    pub loads: ConstantLoads,
    /// The parsed axes of --vary.
    #[arg(skip)]
    pub vary: Vec<AxisArgument>,
    /// The parsed axes of --over.
    #[arg(skip)]
    pub over: Vec<AxisArgument>,
}

/// A parameter with a range or a list of values.
#[derive(Clone, Debug)]
pub enum AxisArgument<N = Name> {
    Range(ParameterRange<N>),
    List(ParameterValues<N>),
}

impl FromStr for AxisArgument {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        if text.contains(':') { Ok(Self::Range(text.parse()?)) } else { Ok(Self::List(text.parse()?)) }
    }
}

impl<N: AxisName> fmt::Display for AxisArgument<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range(range) => range.fmt(f),
            Self::List(list) => list.fmt(f),
        }
    }
}

impl InWrittenUnit for AxisArgument {
    fn name(&self) -> Name {
        self.written().0
    }

    fn unit(&mut self) -> &mut Option<&'static Unit> {
        match self {
            Self::Range(range) => range.unit(),
            Self::List(list) => list.unit(),
        }
    }

    fn values(&mut self) -> Vec<&mut f64> {
        match self {
            Self::Range(range) => range.values(),
            Self::List(list) => list.values(),
        }
    }
}

impl AxisArgument {
    /// The parameter, and the unit of its typed values.
    pub fn written(&self) -> (Name, Option<&'static Unit>) {
        match self {
            Self::Range(range) => (range.name, range.unit),
            Self::List(list) => (list.name, list.unit),
        }
    }
}

impl<N: AxisName> AxisArgument<N> {
    /// The range, whose values sample an interval; `None` for a list.
    pub fn range(&self) -> Option<&ParameterRange<N>> {
        match self {
            Self::Range(range) => Some(range),
            Self::List(_) => None,
        }
    }

    /// Its values.
    ///
    /// # Errors
    /// An error if the number of values is out of range.
    pub fn sampled(&self, resolution: u32) -> Result<SampledAxis<N>> {
        Ok(match self {
            Self::Range(range) => {
                let axis = range.axis(resolution as usize, 2..=1_000_000)?;
                SampledAxis { values: (0..axis.count).map(|i| axis.value(i)).collect(), name: axis.name }
            }
            Self::List(list) => SampledAxis { values: list.values.clone(), name: list.name.clone() },
        })
    }

    /// The ends of the axis that was given as `typed`.
    ///
    /// # Errors
    /// An error with the `expected` form if the axis is a list, or a range with a count.
    pub fn interval(&self, typed: &str, expected: &'static str) -> Result<ParameterInterval<N>> {
        match self {
            Self::Range(ParameterRange { name, ends, count: None, .. }) => {
                Ok(ParameterInterval { name: name.clone(), from: ends.0, to: ends.1 })
            }
            _ => Err(Error::form(typed, expected)),
        }
    }
}
