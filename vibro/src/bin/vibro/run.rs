//! `vibro run`: from its arguments to the library's study.

use clap::{Args, ValueEnum};
use vibro::load_file::LoadFile;
use vibro::studies::{self, RunLength, RunRequest, Study};
use vibro::{Error, Result};
use vibro_analysis::ParameterSet;
use vibro_analysis::isoperiodic::StartRule;
use vibro_impact::load::Interpolation;

/// Arguments of `run`.
#[derive(Args, Debug)]
pub struct Run {
    /// Drive periods recorded; 20 unless this or --duration is given, with loads up to their last sample
    #[arg(long, value_name = "N", conflicts_with = "duration", value_parser = clap::value_parser!(u32).range(1..))]
    pub periods: Option<u32>,
    /// Time recorded, s
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub duration: Option<f64>,
    /// Drive periods discarded before the record begins, without loads; 400 unless given, 0 with --start or --load
    #[arg(long, value_name = "N")]
    pub discard: Option<u32>,
    /// Start (x1 x2 x3 in L, v1 v2 v3 in L omega10, what is not named zero), or "orbit": on the exact orbit where that is
    /// stable; v2=1 unless given
    #[arg(long, value_name = "NAME=VALUE,…", allow_hyphen_values = true)]
    pub start: Option<StartRule>,
    /// Load on box, block or secondary from a CSV file of time (s) and force (N); time 0 is the beginning of the record. May
    /// be repeated; loads on one body add
    #[arg(long, value_name = "BODY=FILE")]
    pub load: Vec<LoadFile>,
    /// What the force is between two samples
    #[arg(long, value_enum, default_value_t = InterpolationName::Linear)]
    pub interpolation: InterpolationName,
    /// Rows of the table in a drive period
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u16).range(1..=10_000))]
    pub samples: u16,
}

/// Interpolations.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum InterpolationName {
    /// Straight lines
    Linear,
    /// Cubics that never pass beyond the samples (PCHIP)
    Cubic,
}

pub fn run(set: &ParameterSet, a: &Run) -> Result<Study> {
    let length = match (a.periods, a.duration) {
        (Some(n), _) => RunLength::Periods(n),
        (None, Some(s)) if s > 0.0 && s.is_finite() => RunLength::Seconds(s),
        (None, Some(s)) => return Err(Error::form(format!("--duration {s}"), "a finite time above 0, in s")),
        (None, None) => RunLength::Default,
    };
    let interpolation = match a.interpolation {
        InterpolationName::Linear => Interpolation::Linear,
        InterpolationName::Cubic => Interpolation::Cubic,
    };
    let loads = a.load.iter().map(|file| file.read(interpolation)).collect::<Result<Vec<_>>>()?;
    let request = RunRequest { length, discard: a.discard, start: a.start, samples: a.samples.into(), loads };
    studies::run(set, &request)
}
