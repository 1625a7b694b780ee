//! Arguments of `vibro design`.

use crate::common_arguments::{START_VALUE, SectionArguments, start_help};
use crate::ranges::whole;
use clap::{ArgGroup, Args};
use std::path::PathBuf;

/// Examples.
pub const EXAMPLES: &str = "\
EXAMPLES
  vibro design machine.toml --minimize amplitude.box.s --vary stop.steel.gap=1mm:20mm,body.block.mass=0.2kg:0.8kg
  vibro design machine.toml --minimize amplitude.box.s --vary stop.steel.gap=1mm:20mm \\
    --over load.shaker.frequency=9Hz:11Hz --subject-to 'impact.speed.steel<=0.5 m/s' --robust 5%
  (`vibro sweep machine.toml --list` names all outputs)";

/// The files that the command writes.
pub const FILES: &str = "\
FILES
  best.toml     the machine file with the parameters of the best design
  design.csv    a row for each evaluated design, in order of evaluation: its parameters, its goal and limited outputs with the
                ends of their error bars (in SI), the motion with the worst goal, and the reason if values are missing
  design.svg    the goal over the evaluations and over the varied parameters";

/// Arguments of `design`.
#[derive(Args, Debug)]
#[command(group = ArgGroup::new("goal").required(true).args(["minimize", "maximize"]))]
pub struct DesignArguments {
    /// Machine file (TOML); the first evaluated design has its values, as changed by --set
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Output to minimize; the worst motion of a design counts
    #[arg(long, visible_alias = "minimise", value_name = "OUTPUT")]
    pub minimize: Option<String>,
    /// Output to maximize; the worst motion of a design counts
    #[arg(long, visible_alias = "maximise", value_name = "OUTPUT")]
    pub maximize: Option<String>,
    /// Parameters to vary, each with its range, e.g. stop.steel.gap=1mm:20mm. May be repeated
    #[arg(long, required = true, value_name = "NAME=LOW:HIGH,…", allow_hyphen_values = true)]
    pub vary: Vec<String>,
    /// Parameter, e.g. the drive frequency; a design is measured at all its values, and the worst
    /// value counts. Peaks between the values of a range are also found. May be repeated
    #[arg(long, value_name = "NAME=FROM:TO[:COUNT]|V,V,…", allow_hyphen_values = true)]
    pub over: Vec<String>,
    /// Number of values of a range of --over without a count
    #[arg(long, value_name = "N", default_value_t = 11, value_parser = whole::<u32>(2..=1_000))]
    pub resolution: u32,
    /// Limit of an output that every motion of a design must keep: OUTPUT<=VALUE or OUTPUT>=VALUE,
    /// in SI or with a unit, e.g. 'impact.speed.steel<=0.5 m/s'. May be repeated
    #[arg(long, value_name = "OUTPUT<=VALUE", allow_hyphen_values = true)]
    pub subject_to: Vec<String>,
    /// Relative tolerance of the varied parameters, e.g. 5%: a design is measured at the corners
    /// of its tolerance box (at 16 corners for more than four parameters), the best design also at
    /// 32 points inside the box; the worst value counts
    #[arg(long, value_name = "PERCENT", default_value = "0%", value_parser = percent)]
    pub robust: f64,
    /// Number of designs to evaluate; local searches in three basins may add about ten each
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = whole::<u32>(10..=1_000_000))]
    pub evaluations: u32,
    /// Periods discarded before a motion is measured, fewer if it settles earlier
    #[arg(long, value_name = "N", default_value_t = 300, value_parser = whole::<u32>(0..=u32::MAX))]
    pub discard: u32,
    /// Periods over which a motion is measured
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = whole::<u32>(1..=1_000_000))]
    pub periods: u32,
    /// Cap on additional periods for the best designs. They are measured until their error bars
    /// show which one is the best
    #[arg(long, value_name = "N", default_value_t = 300_000, value_parser = whole::<u64>(0..=u64::MAX))]
    pub again: u64,
    /// Starts: every design is run from each.
    #[arg(long, help = start_help!("Start of each design; may be repeated, and every design is evaluated from each start"), value_name = START_VALUE, allow_hyphen_values = true)]
    pub start: Vec<String>,
    /// Section at which motions are sampled.
    #[command(flatten)]
    pub section: SectionArguments,
}

/// A fraction, written as `5%` or `0.05`.
fn percent(text: &str) -> Result<f64, String> {
    let (number, unit) = match text.trim().strip_suffix('%') {
        Some(number) => (number.trim(), 0.01),
        None => (text.trim(), 1.0),
    };
    let part = number.parse::<f64>().ok().map(|x| x * unit).filter(|x| (0.0..=0.5).contains(x));
    part.ok_or_else(|| "expected 0% to 50%, e.g. 5%".into())
}
