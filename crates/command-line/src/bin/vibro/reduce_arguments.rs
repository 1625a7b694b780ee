//! Arguments of `vibro reduce`.

use crate::common_arguments::time;
use crate::ranges::whole;
use clap::Args;
use std::path::PathBuf;
use vibro_numerics::quantities::quantity_in;

/// Largest number of coordinates of a machine.
const MOST_COORDINATES: usize = 500;

/// Arguments of `reduce`.
#[derive(Args, Debug)]
pub struct ReduceArguments {
    /// Stiffness, mass and names of dofs: .sti .mas .dof (CalculiX), .mtx (Abaqus, Matrix Market),
    /// .pch (Nastran DMIG), .rsa .hb .matrix and .mapping (Harwell-Boeing of Ansys)
    #[arg(value_name = "FILES")]
    pub files: Vec<PathBuf>,
    /// Units of the files, which no file states: SI, or units of force, length, mass and time, e.g.
    /// N,mm,t,s or kN,mm,kg,ms
    #[arg(long, value_name = "UNITS")]
    pub units: String,
    /// File of the stiffness matrix, if its name does not tell
    #[arg(long, value_name = "FILE")]
    pub stiffness: Option<PathBuf>,
    /// File of the mass matrix, if its name does not tell
    #[arg(long, value_name = "FILE")]
    pub mass: Option<PathBuf>,
    /// File of a damping matrix, whose damping between different modes is left out
    #[arg(long, value_name = "FILE", conflicts_with_all = ["damping_ratio", "damping_table", "rayleigh"])]
    pub damping: Option<PathBuf>,
    /// Names of the dofs in the order of the rows: node.direction on each line
    #[arg(long, value_name = "FILE")]
    pub dofs: Option<PathBuf>,
    /// Clamped nodes: a list such as 1,2,7.xz, or a file (.csv, .txt) with one on each line. May be
    /// repeated
    #[arg(long, value_name = "NODES|FILE")]
    pub clamp: Vec<String>,
    /// Node of the body where others are attached, with all or some directions, e.g. tip=428 or
    /// tip=428.xz. May be repeated
    #[arg(long, value_name = "NAME=NODE")]
    pub interface: Vec<String>,
    /// Number of modes; rubin and craig-bampton add one for each dof of the interface
    #[arg(long, value_name = "N", value_parser = whole(1..=MOST_COORDINATES))]
    pub modes: usize,
    /// Kept: free modes and residual flexibility; free modes and residual shapes; fixed-interface
    /// modes and constraint modes
    #[arg(long, value_name = "METHOD", default_value = "macneal", value_parser = ["macneal", "rubin", "craig-bampton"])]
    pub method: String,
    /// Damping ratio of every mode [default: 0]
    #[arg(long, value_name = "RATIO", value_parser = ratio, conflicts_with_all = ["damping_table", "rayleigh"])]
    pub damping_ratio: Option<f64>,
    /// File with frequencies in Hz and damping ratios, two numbers on each line
    #[arg(long, value_name = "FILE", conflicts_with = "rayleigh")]
    pub damping_table: Option<PathBuf>,
    /// Damping α M + β K, with α in 1/s and β in s
    #[arg(long, value_name = "ALPHA,BETA", value_delimiter = ',', num_args = 1, value_parser = ratio)]
    pub rayleigh: Vec<f64>,
    /// Direction in which the machine's gravity acts on the body, e.g. -z
    #[arg(long, value_name = "DIRECTION", allow_hyphen_values = true)]
    pub gravity: Option<String>,
    /// Stiffness of the contacts, for the error statement, in N/m or with a unit
    #[arg(long, value_name = "STIFFNESS", value_parser = stiffness)]
    pub contact_stiffness: Option<f64>,
    /// Highest frequency of the loads, for the error statement, in Hz or with a unit
    #[arg(long, value_name = "FREQUENCY", value_parser = frequency)]
    pub load_frequency: Option<f64>,
    /// Machine file without the body, with which its error is measured: the machine moves until
    /// --until with the body and with one of 1.5 times as many modes. Positions and events of both
    /// are compared
    #[arg(long, value_name = "FILE", requires = "until")]
    pub verify: Option<PathBuf>,
    /// End of the motions of --verify
    #[arg(long, value_name = "TIME", value_parser = time, requires = "verify")]
    pub until: Option<f64>,
    /// Name of the body [default: the name of --out]
    #[arg(long, value_name = "NAME")]
    pub name: Option<String>,
}

fn ratio(text: &str) -> std::result::Result<f64, String> {
    let found = text.trim().parse().ok().filter(|x: &f64| x.is_finite() && *x >= 0.0);
    found.ok_or_else(|| "expected a finite number >= 0".into())
}

fn stiffness(text: &str) -> std::result::Result<f64, String> {
    let found = quantity_in("N/m", text.trim()).map(|q| q.value).filter(|x| x.is_finite() && *x > 0.0);
    found.ok_or_else(|| "expected a finite stiffness > 0 in N/m, N/mm, kN/m, e.g. 20kN/mm".into())
}

fn frequency(text: &str) -> std::result::Result<f64, String> {
    let found = quantity_in("Hz", text.trim()).map(|q| q.value).filter(|x| x.is_finite() && *x > 0.0);
    found.ok_or_else(|| "expected a finite frequency > 0 in Hz or kHz".into())
}
