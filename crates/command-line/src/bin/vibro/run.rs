//! `vibro run`: its arguments, and their conversion for the paper's machine.

use crate::common_arguments::{START_VALUE, WITH_FILE, WITHOUT_FILE, start_help, time};
use crate::ranges::{in_option, whole};
use clap::builder::ArgPredicate::IsPresent;
use clap::{Args, ValueEnum};
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;
use vibro::load_file::{LoadArgument, LoadFile, files};
use vibro::studies::paper::{RunLength, RunRequest};
use vibro::studies::{self, Study};
use vibro::{Error, Result};
use vibro_impact::load::Interpolation;
use vibro_studies::paper::start::StartRule;
use vibro_studies::paper::{ParameterSet, quantity_in};

/// Largest number of rows of the table per drive period.
const MOST_SAMPLES: u32 = 10_000;

/// Arguments of `run`.
#[derive(Args, Debug)]
pub struct RunArguments {
    /// Machine file (TOML), described in docs/machine-file.md. Without FILE, the paper's machine
    #[arg(value_name = "FILE")]
    pub file: Option<PathBuf>,
    /// Rows of the table: per drive period, at most 10000; with FILE in total, evenly spaced from
    /// the start to --until [default: 100; with FILE 1000]
    #[arg(long, value_name = "N", default_value = "100", default_value_if("file", IsPresent, "1000"))]
    #[arg(hide_default_value = true, value_parser = whole(1..=u32::MAX))]
    pub samples: u32,
    /// Start of the motion.
    #[arg(long, help = start_help!("Start of the motion"), value_name = START_VALUE, allow_hyphen_values = true)]
    pub start: Vec<String>,
    /// Options of a machine's file.
    #[command(flatten, next_help_heading = WITH_FILE)]
    pub of_file: RunOfFile,
    /// Options of the paper's machine.
    #[command(flatten, next_help_heading = WITHOUT_FILE)]
    pub of_paper: RunOfPaper,
}

/// Options of a motion of a machine's file.
#[derive(Args, Debug)]
pub struct RunOfFile {
    /// End of the motion, in s or with a unit (2s, 500 ms)
    #[arg(long, value_name = "TIME", value_parser = time, allow_hyphen_values = true)]
    pub until: Option<f64>,
    /// File with the times of the rows, one number in s per line. With --until, the table has one
    /// more row at that time
    #[arg(long, value_name = "FILE", conflicts_with = "samples")]
    pub times: Option<PathBuf>,
    /// Columns of states.csv, in this order: a quantity (box.s), a body or element for all its
    /// quantities (box, stop.steel), a coordinate of a body with several (tube.q[3].s), or a state
    /// of a block (pid.x[0], pid.u.held) [default: all columns except such coordinates and states
    /// of blocks]
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    pub columns: Vec<String>,
    /// Also list the knots of signals in events.csv; a record has a knot at each of its times
    #[arg(long)]
    pub knots: bool,
    /// Write the exact derivatives of all columns (derivatives.csv) and of event times
    /// (event-derivatives.csv) with respect to these parameters, e.g.
    /// stop.steel.gap,friction.guide.force, or initial values: start.box.s, start.box.v, start.time
    #[arg(long, value_name = "NAME,…")]
    pub derivatives: Vec<String>,
}

/// Options of a motion of the paper's machine.
#[derive(Args, Debug)]
pub struct RunOfPaper {
    /// Drive periods recorded [default: 20, or up to the last sample of a load from a file]
    #[arg(long, value_name = "N", conflicts_with = "duration", value_parser = whole(1..=u32::MAX))]
    pub periods: Option<u32>,
    /// Time recorded, in s, with a unit (2s, 500 ms) or in drive periods ("200 periods")
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    pub duration: Option<Duration>,
    /// Drive periods discarded before the record begins, without the loads from files
    /// [default: 400; 0 with --start or a load from a file]
    #[arg(long, value_name = "N", value_parser = whole(0..=u32::MAX))]
    pub discard: Option<u32>,
    /// The parsed start.
    #[arg(skip)]
    pub start: Option<StartRule>,
    /// Load on box, block or secondary: a constant force (block=-3.4N), or a CSV file of time (s)
    /// and force (N). A constant force acts from the start on; time 0 of a file is the beginning
    /// of the record. May be repeated; loads on one body add
    #[arg(long, value_name = "BODY=FORCE|FILE", allow_hyphen_values = true)]
    pub load: Vec<LoadArgument>,
    /// Interpolation of the force between two samples
    #[arg(long, value_enum, default_value_t = InterpolationName::Linear)]
    pub interpolation: InterpolationName,
}

/// Length of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Duration {
    /// In s.
    Seconds(f64),
    /// In drive periods, not necessarily a whole number.
    Periods(f64),
}

impl FromStr for Duration {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        const FORM: &str = "a finite time > 0 in s, ms, us, min or h, or in drive periods, e.g. 2s \
                            or 200 periods";
        let words = text.trim();
        let periods = words.strip_suffix("periods").or_else(|| words.strip_suffix("period"));
        let found = match periods {
            Some(number) => number.trim().parse().ok().map(Self::Periods),
            None => quantity_in("s", words).map(|time| Self::Seconds(time.value)),
        };
        let allowed = |found: &Self| {
            let (Self::Seconds(value) | Self::Periods(value)) = *found;
            value > 0.0 && value.is_finite()
        };
        found.filter(allowed).ok_or_else(|| Error::form(text, FORM))
    }
}

impl fmt::Display for Duration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Seconds(s) => write!(f, "{s} s"),
            Self::Periods(n) => write!(f, "{n} periods"),
        }
    }
}

/// Interpolations.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum InterpolationName {
    /// Straight lines
    Linear,
    /// Cubics that never pass beyond the samples (PCHIP)
    Cubic,
}

/// Computes a run; constant loads are among the parameters of the set.
pub fn run(set: &ParameterSet, RunArguments { samples, of_paper: a, .. }: &RunArguments) -> Result<Study> {
    if *samples > MOST_SAMPLES {
        let problem = format!("expected 1 to {MOST_SAMPLES} in each drive period");
        return Err(Error::Refused { what: format!("--samples {samples}"), problem });
    }
    let length = match (a.periods, a.duration) {
        (Some(n), _) => RunLength::Periods(n.into()),
        (None, Some(Duration::Seconds(s))) => RunLength::Seconds(s),
        (None, Some(Duration::Periods(n))) => RunLength::Periods(n),
        (None, None) => RunLength::Default,
    };
    let interpolation = match a.interpolation {
        InterpolationName::Linear => Interpolation::Linear,
        InterpolationName::Cubic => Interpolation::Cubic,
    };
    let read = |file: &LoadFile| file.read(interpolation).map_err(in_option("--load"));
    let loads = files(&a.load).map(read).collect::<Result<Vec<_>>>()?;
    let request = RunRequest { length, discard: a.discard, start: a.start, samples: *samples, loads };
    studies::paper::run(set, &request)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_have_units() {
        for (text, expected) in [
            ("2", Duration::Seconds(2.0)),
            ("2s", Duration::Seconds(2.0)),
            ("500 ms", Duration::Seconds(0.5)),
            ("1.5min", Duration::Seconds(90.0)),
            ("200 periods", Duration::Periods(200.0)),
            ("1period", Duration::Periods(1.0)),
        ] {
            assert_eq!(text.parse::<Duration>().unwrap(), expected, "{text}");
            assert_eq!(expected.to_string().parse::<Duration>().unwrap(), expected);
        }
        for text in ["", "-1", "0", "nan", "inf s", "2 Hz", "periods", "-3 periods"] {
            assert!(text.parse::<Duration>().unwrap_err().to_string().contains("200 periods"), "{text}");
        }
    }
}
