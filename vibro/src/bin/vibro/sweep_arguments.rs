//! Arguments of `vibro sweep`.

use crate::common_arguments::ConstantLoads;
use crate::ranges::{InWrittenUnit, ParameterRange, ParameterValues, Share, whole};
use clap::Args;
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;
use vibro::{Error, Result};
use vibro_analysis::design_sweep::{DesignMachine, ParameterInterval, SampledAxis};
use vibro_analysis::measures::Measure;
use vibro_analysis::start::StartRule;
use vibro_analysis::{Name, ParameterSet, Unit};

/// What is measured unless told otherwise.
const DEFAULT: &str =
    "amplitude.x1,amplitude.without_block,amplitude.w,impacts,impact.speed,power.impact,class";

pub const EXAMPLES: &str = "\
EXAMPLES
  vibro sweep --list
  vibro sweep --config machine.toml --vary stop.gap=2mm:24mm:100 --output amplitude.x1,impacts
  1188 designs, each by its largest amplitude over a band of drive frequencies and two starts:
    vibro sweep --config machine.toml --vary block.m=0.4kg:1.6kg:11 --vary stop.gap=2mm:24mm:12 \\
      --vary stop.restitution=0.5:0.9:9 --over drive.frequency=9Hz:11Hz:21 --start v2=1 --start x1=1,v2=-1 \\
      --output amplitude.x1,impact.impulse
  vibro sweep --vary m2=0.8kg,1.2kg,1.6kg --vary L=5mm:10mm:6 --config machine.toml
  vibro sweep --vary block.m=0.4kg:1.6kg --vary stop.gap=2mm:24mm --sobol 256 --config machine.toml
  vibro sweep --design rows.csv    (a header with names of parameters, then numbers, with or without units)

THE TABLE (sweep.csv, sweep.parquet) has a row for each design: the parameters and outputs in SI, the reason if values are
missing, and at the end each parameter that was written in another unit, in that unit (`drive.frequency [Hz]`). With one motion a
design the column of an output has its name. With several there are NAME.min, NAME.mean, NAME.max, and where the largest was
found: NAME.max.drive.frequency, NAME.max.start. After the reason stand NAME.spread, by how much a number would scatter from one
window of the motion to the next (but for rounding 0 where it repeats), the periods of the window, and `between`: how many
values between those of --over were looked at. A design that may be the best has the numbers of its longest window.";

/// Arguments of `sweep`.
#[derive(Args, Debug)]
pub struct Sweep {
    /// A parameter and its values, as a range or a list. May be repeated; all combinations are run,
    /// the last parameter fastest
    #[arg(long, value_name = "NAME=FROM:TO[:COUNT]|V,V,…", allow_hyphen_values = true)]
    pub vary: Vec<AxisArgument>,
    /// Number of values of a range without a count
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = whole::<u32>(2..=1_000_000))]
    pub resolution: u32,
    /// Run the first N points of the Sobol sequence in the ranges of --vary instead of all
    /// combinations
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=1_000_000))]
    pub sobol: Option<u32>,
    /// Designs from a CSV file: a header with names of parameters, a row for each design
    #[arg(long, value_name = "FILE", conflicts_with_all = ["vary", "sobol"])]
    pub design: Option<PathBuf>,
    /// A parameter over which each design is measured as a whole, e.g. the drive's frequency in a
    /// band; between the values of a range is looked for designs that may be the best. May be
    /// repeated
    #[arg(long, value_name = "NAME=FROM:TO[:COUNT]|V,V,…", allow_hyphen_values = true)]
    pub over: Vec<AxisArgument>,
    /// What is measured: names from `vibro sweep --list`, separated by commas. May be repeated
    #[arg(long, value_name = "NAME,…", value_delimiter = ',', default_value = DEFAULT)]
    pub output: Vec<Measure>,
    /// Start of the motions: x1 x2 x3 in L, v1 v2 v3 in L omega10; box.s block.s secondary.s box.v
    /// block.v secondary.v in SI; each also with a unit (block.s=5mm). A coordinate that is not
    /// named is zero. "orbit" starts on the exact orbit where it is stable. May be repeated: every
    /// design is run from each start [default: v2=1]
    #[arg(long, value_name = "NAME=VALUE,…", allow_hyphen_values = true)]
    pub start: Vec<StartRule>,
    /// Number of further starts, spread evenly over displacements up to 2 L and velocities up to 2
    /// L omega10
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = whole::<u32>(0..=10_000))]
    pub starts: u32,
    /// Drive periods discarded before a motion is measured
    #[arg(long, value_name = "N", default_value_t = 400, value_parser = whole(0..=u32::MAX))]
    pub discard: u32,
    /// Drive periods over which a motion is measured; 60 are whole periods of 1T to 6T, 10T and 12T
    /// motions
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = whole::<u32>(1..=1_000_000))]
    pub periods: u32,
    /// Periods of motion that may be spent on measuring again, longer and between the values of
    /// --over, the designs that may have the least of the first output, until one is the best by
    /// its error bar; 0 for none
    #[arg(long, value_name = "N", default_value_t = ParameterSet::AGAIN, value_parser = whole::<u64>(0..=u64::MAX))]
    pub again: u64,
    /// List the names of all outputs, with unit and meaning
    #[arg(long)]
    pub list: bool,
    /// Constant loads.
    #[command(flatten)]
    pub loads: ConstantLoads,
    /// For many machines.
    #[command(flatten)]
    pub share: Share,
}

/// A parameter with a range or a list of values.
#[derive(Clone, Debug)]
pub enum AxisArgument {
    Range(ParameterRange),
    List(ParameterValues),
}

impl FromStr for AxisArgument {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        if text.contains(':') { Ok(Self::Range(text.parse()?)) } else { Ok(Self::List(text.parse()?)) }
    }
}

impl fmt::Display for AxisArgument {
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
    /// Whether its values stand for the interval between them.
    pub fn is_range(&self) -> bool {
        matches!(self, Self::Range(_))
    }

    /// The parameter, and the unit in which its values were written.
    pub fn written(&self) -> (Name, Option<&'static Unit>) {
        match self {
            Self::Range(range) => (range.name, range.unit),
            Self::List(list) => (list.name, list.unit),
        }
    }

    /// Its values.
    ///
    /// # Errors
    /// When a count is out of range.
    pub fn sampled(&self, resolution: u32) -> Result<SampledAxis> {
        let values = match self {
            Self::Range(range) => {
                let axis = range.axis(resolution as usize, 2..=1_000_000)?;
                (0..axis.count).map(|i| axis.value(i)).collect()
            }
            Self::List(list) => list.values.clone(),
        };
        Ok(SampledAxis { name: self.name(), values })
    }

    /// Its ends, for a Sobol sequence.
    ///
    /// # Errors
    /// For a list, and for a range with a count.
    pub fn interval(&self) -> Result<ParameterInterval> {
        const EXPECTED: &str = "name=from:to without a count: --sobol decides on the number of points";
        match self {
            Self::Range(ParameterRange { name, ends, count: None, .. }) => {
                Ok(ParameterInterval { name: *name, from: ends.0, to: ends.1 })
            }
            other => Err(Error::form(other.to_string(), EXPECTED)),
        }
    }
}
