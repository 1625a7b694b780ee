//! Arguments that commands share: those of every command, and constant loads.

use crate::ranges::whole;
use clap::Args;
use std::path::PathBuf;
use vibro::load_file::LoadArgument;
use vibro::manifest::Invocation;

/// The folder of results unless another one is named.
pub const DEFAULT_OUT: &str = "vibro-out";

/// Arguments of every command.
#[derive(Args, Debug)]
pub struct Common {
    /// Parameter file (TOML) with a table "si", a table "groups" or both
    #[arg(long, global = true, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Set one parameter, e.g. kappa=0.6 or box.k=48kN/m. May be repeated
    #[arg(long, global = true, value_name = "NAME=VALUE")]
    pub set: Vec<String>,
    /// Folder for pictures (SVG, PNG) and tables (CSV)
    ///
    /// A folder with results or parts of another run (other parameters, other options) is refused
    /// if it is named here. In the default folder the new run gets a folder of its own, named after
    /// the command and a digest of its parameters.
    #[arg(long, global = true, value_name = "FOLDER", default_value = DEFAULT_OUT)]
    pub out: PathBuf,
    /// Overwrite finished results of other parameters in the folder
    #[arg(long, global = true)]
    pub replace: bool,
    /// Delete unfinished parts of other parameters in the folder
    #[arg(long, global = true)]
    pub discard_unfinished: bool,
    /// Number of threads [default: all cores]. Results do not depend on it
    #[arg(long, global = true, value_name = "N", value_parser = whole(1..=u16::MAX))]
    pub threads: Option<u16>,
    /// What was given, for manifests.
    #[arg(skip)]
    pub invocation: Invocation,
}

/// Loads that do not change.
#[derive(Args, Clone, Debug, Default)]
pub struct ConstantLoads {
    /// Constant force on box, block or secondary, in N or with a unit. May be repeated; forces on
    /// one body add. Gravity on a block of 0.6 kg in a vertical machine is block=-5.9N. A gap that
    /// is off centre by d is the pair block=-k23*d, secondary=k23*d. As an axis the force is the
    /// parameter load.block. Loads from files: `vibro run`
    #[arg(long, value_name = "BODY=FORCE", allow_hyphen_values = true)]
    pub load: Vec<LoadArgument>,
}
