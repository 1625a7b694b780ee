//! Arguments of `vibro assembly`.

use crate::ranges::{Share, whole};
use clap::{Args, Subcommand};
use std::path::PathBuf;
use vibro_analysis::assembly::{Measure, NamedQuantity};
use vibro_analysis::design_sweep::DesignMachine as _;
use vibro_impact::quantities::quantity_in;

/// What to do with a machine.
#[derive(Debug, Subcommand)]
pub enum AssemblyCommand {
    /// Says what the machine consists of: bodies, elements, degrees of freedom, modes at the start,
    /// equilibrium, natural frequencies
    Check {
        /// The machine's file (TOML); docs/assemblies.md says what may stand in it
        #[arg(value_name = "FILE")]
        file: PathBuf,
    },
    /// Draws the machine as an engineer sketches it: bodies in a row, springs, dashpots, stops,
    /// friction, loads, as SVG and PNG
    Draw {
        /// The machine's file (TOML); docs/assemblies.md says what may stand in it
        #[arg(value_name = "FILE")]
        file: PathBuf,
    },
    /// Follows the machine's motion, exactly from event to event: states.csv, events.csv,
    /// contacts.csv, a picture and an account
    Run(Motion),
    /// Bifurcation diagram: local maxima of a quantity over a parameter, both directions, with
    /// periods and classes
    ///
    /// Each value starts from the last state of the value before. A motion is looked at after each
    /// common period of what drives the machine; --period and --section say otherwise. A motion
    /// that has settled is not followed further.
    Bifurcation(Bifurcation),
    /// The largest Lyapunov exponent, through impacts, sticking and sliding: of the machine itself,
    /// or over a parameter
    ///
    /// One variation is carried exactly through flights and events (saltation matrices).
    Lyapunov(Lyapunov),
    /// Amplitudes, forces, impacts, losses and more of many designs: a grid or a Sobol sequence
    ///
    /// The table has a row for each design, in SI, as CSV and Parquet. Outputs are named by the
    /// machine's own bodies and elements: --list tells them.
    Sweep(Sweep),
}

/// Arguments of `assembly run`.
#[derive(Args, Debug)]
pub struct Motion {
    /// The machine's file (TOML); docs/assemblies.md says what may stand in it
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// End of the motion, in s or with a unit (2s, 500 ms)
    #[arg(long, value_name = "TIME", value_parser = time, required_unless_present = "times", allow_hyphen_values = true)]
    pub until: Option<f64>,
    /// Rows of states.csv after that of time 0, at even distances
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = whole(1..=u32::MAX))]
    pub samples: u32,
    /// Times of the rows instead: a number in s a line
    #[arg(long, value_name = "FILE", conflicts_with_all = ["samples", "until"])]
    pub times: Option<PathBuf>,
    /// List the knots of signals in events.csv too: a record has one at each of its times
    #[arg(long)]
    pub knots: bool,
}

/// The machine, and where its motions are looked at.
#[derive(Args, Debug)]
pub struct Which {
    /// The machine's file (TOML); docs/assemblies.md says what may stand in it
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Look at the motion after whole multiples of this time, in s or with a unit
    /// [default: the common period of all harmonics]
    #[arg(long, value_name = "TIME", value_parser = time, conflicts_with = "section", allow_hyphen_values = true)]
    pub period: Option<f64>,
    /// Look at the motion at each impact or first touch of a stop, or each time that a friction
    /// begins to stick
    /// [default of a machine without harmonics: its first stop, else its first friction]
    #[arg(long, value_name = "ELEMENT")]
    pub section: Option<String>,
}

/// Arguments of `assembly bifurcation`.
#[derive(Args, Debug)]
pub struct Bifurcation {
    #[command(flatten)]
    pub which: Which,
    /// Parameter and range, such as stop.upper.gap=1mm:8mm:200. Repeated for planes
    #[arg(long, value_name = "NAME=FROM:TO[:COUNT]", allow_hyphen_values = true, required = true)]
    pub vary: Vec<String>,
    #[command(flatten)]
    pub drawn: Drawn,
    /// For many machines.
    #[command(flatten)]
    pub share: Share,
}

/// What a diagram shows.
#[derive(Args, Debug)]
pub struct Drawn {
    /// Quantity that is drawn: box.s, box.v, box.a, upper.e, upper.rate, upper.f
    /// [default: the first free body's coordinate]
    #[arg(long, value_name = "NAME")]
    pub of: Option<NamedQuantity>,
    /// Draw its values where the motion is looked at (a Poincaré section) instead of its local
    /// maxima
    #[arg(long)]
    pub at_section: bool,
    /// Draw classes and contacts over a plane of two parameters instead, of which --vary tells the
    /// ranges: stop.upper.gap,body.block.mass. Each motion starts as the file says. May be repeated
    #[arg(long, value_name = "NAME,NAME", conflicts_with_all = ["of", "at_section", "keep"])]
    pub pair: Vec<String>,
    /// Values in a range without a count [default: 200; of a plane 60]
    #[arg(long, value_name = "N", value_parser = whole::<u16>(2..=20_000))]
    pub resolution: Option<u16>,
    /// Periods discarded at each value, unless the motion has settled before
    #[arg(long, value_name = "N", default_value_t = 300, value_parser = whole(0..=u32::MAX))]
    pub discard: u32,
    /// Periods kept at each value
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = whole(1..=u32::MAX))]
    pub keep: u32,
    /// Start each value as the file says, at time 0, and not from the last state of the value
    /// before: for a machine with steps or records that go on. There is then one direction
    #[arg(long, conflicts_with = "pair")]
    pub anew: bool,
}

/// Arguments of `assembly lyapunov`.
#[derive(Args, Debug)]
pub struct Lyapunov {
    #[command(flatten)]
    pub which: Which,
    /// Parameter and range, such as stop.upper.gap=1mm:8mm:200. Repeated for planes
    /// [default: the machine as it is]
    #[arg(long, value_name = "NAME=FROM:TO[:COUNT]", allow_hyphen_values = true)]
    pub vary: Vec<String>,
    #[command(flatten)]
    pub drawn: Drawn,
    /// Periods over which the exponent is counted, after 32 in which the variation turns into its
    /// direction
    #[arg(long, value_name = "N", default_value_t = 400, value_parser = whole::<u32>(8..=1_000_000))]
    pub periods: u32,
    /// For many machines.
    #[command(flatten)]
    pub share: Share,
}

/// Arguments of `assembly sweep`.
#[derive(Args, Debug)]
pub struct Sweep {
    #[command(flatten)]
    pub which: Which,
    /// A parameter and its values, as a range or a list. May be repeated; all combinations are run,
    /// the last parameter fastest
    #[arg(long, value_name = "NAME=FROM:TO[:COUNT]|V,V,…", allow_hyphen_values = true)]
    pub vary: Vec<String>,
    /// Number of values of a range without a count
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = whole::<u32>(2..=1_000_000))]
    pub resolution: u32,
    /// Run the first N points of the Sobol sequence in the ranges of --vary instead of all
    /// combinations
    #[arg(long, visible_alias = "sobol", value_name = "N", value_parser = whole::<u32>(1..=1_000_000))]
    pub samples: Option<u32>,
    /// A parameter over which each design is measured as a whole, e.g. a load's frequency in a
    /// band; between the values of a range is looked for designs that may be the best. May be
    /// repeated
    #[arg(long, value_name = "NAME=FROM:TO[:COUNT]|V,V,…", allow_hyphen_values = true)]
    pub over: Vec<String>,
    /// What is measured: names from --list, separated by commas. May be repeated
    /// [default: amplitudes of the free bodies, impacts and their speeds, power lost, class]
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    pub output: Vec<Measure>,
    /// Periods discarded before a motion is measured, unless it has settled before
    #[arg(long, value_name = "N", default_value_t = 300, value_parser = whole(0..=u32::MAX))]
    pub discard: u32,
    /// Periods over which a motion is measured; 60 are whole periods of 1T to 6T, 10T and 12T
    /// motions
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = whole::<u32>(1..=1_000_000))]
    pub periods: u32,
    /// Periods of motion that may be spent on measuring again, longer and between the values of
    /// --over, the designs that may have the least of the first output, until one is the best by
    /// its error bar; 0 for none
    #[arg(long, value_name = "N", default_value_t = vibro_analysis::assembly::Machine::AGAIN, value_parser = whole::<u64>(0..=u64::MAX))]
    pub again: u64,
    /// List the names of all outputs of the machine, with unit and meaning
    #[arg(long)]
    pub list: bool,
    /// For many machines.
    #[command(flatten)]
    pub share: Share,
}

/// A time above 0, in s.
fn time(text: &str) -> std::result::Result<f64, String> {
    let found = quantity_in("s", text.trim()).map(|q| q.value).filter(|t| t.is_finite() && *t > 0.0);
    found.ok_or_else(|| {
        "allowed is a finite time above 0, in s, with a unit of s, ms, us, min, h, e.g. 2s".into()
    })
}
