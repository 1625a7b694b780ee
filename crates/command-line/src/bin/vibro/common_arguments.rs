//! Arguments that commands share: arguments of every command, arguments of a machine's FILE, and
//! constant loads.
//!
//! Commands with an optional FILE take two machines: the machine of the FILE or, without FILE, the
//! paper's machine. An option that only one of the two has is under the heading [`WITH_FILE`] or
//! [`WITHOUT_FILE`]; by these headings [`crate::arguments::check_options`] refuses it for the
//! other machine.

use crate::ranges::whole;
use clap::Args;
use std::path::PathBuf;
use vibro::load_file::LoadArgument;
use vibro::manifest::Invocation;
use vibro_numerics::quantities::quantity_in;

/// Heading of the options of a machine's file.
pub const WITH_FILE: &str = "Options with FILE";
/// Heading of the options of the paper's machine.
pub const WITHOUT_FILE: &str = "Options without FILE";

/// Smallest and largest width of a picture, mm: labels need some room, and PNG files have 24 dots
/// in each millimetre.
const NARROWEST: f64 = 50.0;
const WIDEST: f64 = 400.0;

/// The folder of results unless another one is named.
pub const DEFAULT_OUT: &str = "vibro-out";

/// Name of the argument for a machine's file.
pub const FILE: &str = "file";

/// How numbers of a machine's file are read.
pub const NUMBERS: &str = "\
NUMBERS
  A number without a unit is read in the unit that the file or an earlier --set uses for that parameter, and the program
  reports this unit. If there is none, the number is in SI. Times without a unit are in s. Tables are in SI.
  Parameters have the names of the file: docs/machine-file.md.";

/// Help of `--start`, for either machine, after the words that name the motion.
macro_rules! start_help {
    ($of:literal) => {
        concat!(
            $of,
            ": coordinates and rates of bodies in SI or with a unit, e.g. block.s=5mm,block.v=1. \
             With FILE also the time (time=0.2s), or a start file such as end.toml of a run, \
             followed by values that replace its values (end.toml,block.v=0); all other values are \
             those of the machine file. Without FILE also x1 x2 x3 in L, v1 v2 v3 in L omega10; \
             all other values are zero; \"orbit\" starts on the exact orbit if it is stable \
             [default: v2=1; with FILE the start of the machine file]"
        )
    };
}
pub(crate) use start_help;

/// Form of the value of `--start`.
pub const START_VALUE: &str = "NAME=VALUE,…";

/// The names in lists that are separated by commas. A comma within brackets is part of a name:
/// `block.pid.a[0,1]`.
pub fn names(lists: &[String]) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for part in lists.iter().flat_map(|list| list.split(',')) {
        match all.last_mut().filter(|name| name.contains('[') && !name.contains(']')) {
            Some(begun) => *begun += &format!(",{part}"),
            None => all.push(part.to_owned()),
        }
    }
    all
}

/// Whether a command takes a machine's file.
pub fn has_file(command: &clap::Command) -> bool {
    command.get_arguments().any(|arg| arg.get_id() == FILE)
}

/// Adds notes to the end of a command's help.
pub fn with_notes(command: clap::Command, notes: &[&str]) -> clap::Command {
    let own = command.get_after_help().map(ToString::to_string);
    let notes: Vec<String> = own.into_iter().chain(notes.iter().map(|note| (*note).into())).collect();
    command.after_help(notes.join("\n\n"))
}

/// Arguments of every command.
#[derive(Args, Clone, Debug)]
pub struct Common {
    /// Set one parameter of a machine's FILE, e.g. stop.steel.gap=5mm, or of the paper's machine,
    /// e.g. kappa=0.6, box.k=48kN/m. May be repeated
    #[arg(long, global = true, value_name = "NAME=VALUE")]
    pub set: Vec<String>,
    /// Folder for pictures (SVG, PNG) and tables (CSV)
    ///
    /// A folder that is given here must not contain results or parts of another run (with other
    /// parameters or options). In the default folder, such a run gets its own folder, named after
    /// the command and a digest of its parameters.
    #[arg(long, global = true, value_name = "FOLDER", default_value = DEFAULT_OUT)]
    pub out: PathBuf,
    /// Width of pictures in print, with letters of 7 points and lines and marks of fixed sizes,
    /// e.g. 84mm for one column of a journal, 174mm for two [default: pictures for a screen]
    #[arg(long, global = true, value_name = "WIDTH", value_parser = width, allow_hyphen_values = true)]
    pub width: Option<f64>,
    /// Overwrite finished results of other parameters in the folder
    #[arg(long, global = true)]
    pub replace: bool,
    /// Delete unfinished parts of other parameters in the folder
    #[arg(long, global = true)]
    pub discard_unfinished: bool,
    /// Number of threads [default: all cores]. Results do not depend on it
    #[arg(long, global = true, value_name = "N", value_parser = whole(1..=u16::MAX))]
    pub threads: Option<u16>,
    /// Parameter file of the paper's machine (TOML) with a table "si", a table "groups" or both
    #[arg(long, global = true, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// The invocation, for manifests.
    #[arg(skip)]
    pub invocation: Invocation,
}

/// Section of the motions of a machine's file.
#[derive(Args, Debug)]
#[group(skip)]
pub struct SectionArguments {
    /// Period at which the motion is sampled, in s or with a unit [default: the common period of
    /// all harmonics]
    #[arg(long, value_name = "TIME", value_parser = time, conflicts_with = "section", allow_hyphen_values = true)]
    pub period: Option<f64>,
    /// Sample the motion at each impact or first touch of this stop or contact, or each time that
    /// this friction begins to stick [default of a machine without harmonics: its first stop, else
    /// its first contact, else its first friction]
    #[arg(long, value_name = "ELEMENT")]
    pub section: Option<String>,
}

/// A time above 0, in s.
pub fn time(text: &str) -> std::result::Result<f64, String> {
    let found = quantity_in("s", text.trim()).map(|q| q.value).filter(|t| t.is_finite() && *t > 0.0);
    found.ok_or_else(|| "expected a finite time > 0 in s, ms, us, min or h, e.g. 2s".into())
}

/// A width of pictures, in mm.
fn width(text: &str) -> std::result::Result<f64, String> {
    let found = quantity_in("m", text.trim()).map(|own| 1e3 * own.value);
    let found = found.filter(|mm| (NARROWEST..=WIDEST).contains(mm));
    found.ok_or_else(|| format!("expected a length from {NARROWEST}mm to {WIDEST}mm, e.g. 84mm"))
}

/// An angle, in rad.
pub fn angle(text: &str) -> std::result::Result<f64, String> {
    let found = quantity_in("rad", text.trim()).map(|q| q.value).filter(|x| x.is_finite());
    found.ok_or_else(|| "expected a finite angle in rad or deg, e.g. 90deg".into())
}

/// Constant loads.
#[derive(Args, Clone, Debug, Default)]
pub struct ConstantLoads {
    /// Constant force on box, block or secondary, in N or with a unit. May be repeated; forces on
    /// one body add. Gravity on a block of 0.6 kg in a vertical machine is block=-5.9N. For a gap
    /// that is off centre by d, use block=-k23*d and secondary=k23*d. To vary the force, use the
    /// parameter load.block. `vibro paper run` also takes loads from files
    #[arg(long, value_name = "BODY=FORCE", allow_hyphen_values = true)]
    pub load: Vec<LoadArgument>,
}

#[cfg(test)]
mod tests {
    use super::names;

    #[test]
    fn golden_a_comma_within_brackets_is_part_of_a_name() {
        let lists = ["kp,block.pd.d[0,0],block.pd.x[1]".to_owned(), "block.pd.a[1,2]=-1:2,T=1:3".to_owned()];
        let found = ["kp", "block.pd.d[0,0]", "block.pd.x[1]", "block.pd.a[1,2]=-1:2", "T=1:3"];
        assert_eq!(names(&lists), found);
    }
}
