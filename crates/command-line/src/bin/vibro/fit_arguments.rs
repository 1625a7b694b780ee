//! Arguments of `vibro fit`.

use crate::common_arguments::{START_VALUE, start_help};
use crate::ranges::whole;
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use vibro_numerics::quantities::quantity_in;
use vibro_studies::fit::{Loss, Segments};

/// Arguments of `fit`.
#[derive(Args, Debug)]
pub struct FitArguments {
    /// Machine file (TOML); its parameters, with --set, are the initial values of the fit
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Record: a table whose first line names `time` and columns, in SI or with units, e.g. time
    /// [ms],box.s [mm]. Several records are fitted together; each gets a folder with the name of its
    /// table
    #[arg(long, value_name = "TABLE,…", value_delimiter = ',', required_unless_present = "events")]
    pub data: Vec<PathBuf>,
    /// Times of impacts and first touches of stops: a table with the columns `element` and `time`;
    /// with several records, one table for each
    #[arg(long, value_name = "TABLE,…", value_delimiter = ',')]
    pub events: Vec<PathBuf>,
    /// Parameters to fit: parameters of the machine, of the start (body.box.start.s or
    /// start.box.s), record.shift, record.offset.COLUMN
    #[arg(long, required_unless_present = "own", value_name = "NAME,…")]
    pub free: Vec<String>,
    /// Parameters to fit with a separate value for each of several records, for example
    /// body.box.start.v; record.shift and record.offset.COLUMN always have separate values
    #[arg(long, value_name = "NAME,…")]
    pub own: Vec<String>,
    /// Set a parameter for one of several records, by the name of its table without extension,
    /// e.g. run2:load.shaker.frequency=11Hz. May be repeated
    #[arg(long, value_name = "RECORD:NAME=VALUE")]
    pub set_in: Vec<String>,
    /// Range of a free parameter [default: its valid range]. May be repeated
    #[arg(long, value_name = "NAME=LOW:HIGH", allow_hyphen_values = true)]
    pub within: Vec<String>,
    /// Standard deviation of the noise: a number for each column in the record's order, then one
    /// for the contact times; or COLUMN=VALUE with a unit, `contacts=1ms` [default: from the
    /// residuals]
    #[arg(long, value_name = "VALUE,…|COLUMN=VALUE", value_delimiter = ',')]
    pub sigma: Vec<String>,
    /// Butterworth low-pass filter of a column's sensor, by order and corner frequency. A column
    /// of accelerations, for example box.a, requires one. May be repeated
    #[arg(long, value_name = "COLUMN=ORDER,FREQUENCY")]
    pub filter: Vec<String>,
    /// Loss function of the residuals
    #[arg(long, value_name = "LOSS", default_value = "linear")]
    pub loss: LossArgument,
    /// Divide the motion into segments with their own initial states: auto, only if a single
    /// motion does not lead to the record; none, never; a time (e.g. 1s), segments of about this
    /// length
    #[arg(long, value_name = "auto|none|TIME", default_value = "auto", value_parser = segments)]
    pub segments: Segments,
    /// Number of further starts of the fit, spread over --within
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = whole::<u32>(0..=10_000))]
    pub starts: u32,
    /// Start of the motion.
    #[arg(long, help = start_help!("Start of the motion"), value_name = START_VALUE, allow_hyphen_values = true)]
    pub start: Vec<String>,
}

/// Parses the value of --segments.
fn segments(text: &str) -> Result<Segments, String> {
    let time = || text.parse::<f64>().ok().or_else(|| Some(quantity_in("s", text)?.value));
    match text {
        "auto" => Ok(Segments::Auto),
        "none" => Ok(Segments::None),
        _ => time()
            .filter(|length| *length > 0.0 && length.is_finite())
            .map(Segments::Length)
            .ok_or_else(|| "expected auto, none, or a time > 0 such as 1s".into()),
    }
}

/// Loss function of the residuals.
#[derive(Clone, Copy, Debug, ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum LossArgument {
    /// Square of each residual
    Linear,
    /// Square of small residuals, absolute value of large ones, with a smooth transition
    #[value(name = "soft_l1")]
    SoftL1,
    /// Square of small residuals, absolute value of large ones
    Huber,
}

impl From<LossArgument> for Loss {
    fn from(loss: LossArgument) -> Self {
        match loss {
            LossArgument::Linear => Self::Linear,
            LossArgument::SoftL1 => Self::SoftL1,
            LossArgument::Huber => Self::Huber,
        }
    }
}
