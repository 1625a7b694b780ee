//! Constant loads of commands, and the commands that refuse them.

use crate::arguments::Command;
use crate::common_arguments::ConstantLoads;
use vibro::load_file::{LoadArgument, files};
use vibro::{Error, Result};
use vibro_studies::paper::{Name, ParameterSet};

/// The loads of a command's `--load`. Only `vibro paper run` takes loads from files.
///
/// # Errors
/// An error if a load is from a file.
pub fn of(command: &Command) -> Result<Vec<LoadArgument>> {
    let ConstantLoads { load } = match command {
        Command::Run(a) => return Ok(a.of_paper.load.clone()),
        Command::Bifurcation(a) => &a.of_paper.loads,
        Command::Lyapunov(a) => &a.sweep.of_paper.loads,
        Command::Basin(a) => &a.of_paper.loads,
        Command::Isoperiodic(a) => &a.loads,
        Command::Sweep(a) => &a.of_paper.loads,
        Command::Orbits(a) => &a.of_paper.which.loads,
        Command::Orbit(a) => &a.loads,
        Command::Locus(a) => &a.loads,
        _ => return Ok(Vec::new()),
    };
    match files(load).next() {
        None => Ok(load.clone()),
        Some(file) => Err(Error::form(
            format!("--load {}={}", file.body.name(), file.path.display()),
            "a constant force, e.g. block=-3.4N; only `vibro paper run` takes loads from files",
        )),
    }
}

/// Refuses constant loads for the commands of the theories, which hold only for the symmetric
/// machine.
///
/// # Errors
/// An error that names the load.
pub fn check_theory(set: &ParameterSet, command: &Command) -> Result<()> {
    let varied: Vec<Name> = match command {
        Command::Response(a) => {
            let a = &a.of_paper;
            a.range.iter().map(|r| r.name).chain(a.values.iter().map(|v| v.name)).collect()
        }
        Command::Manifold(a) => a.values.iter().map(|v| v.name).collect(),
        Command::Plane(a) => a.planes.pair.iter().flat_map(|pair| [pair.x, pair.y]).collect(),
        Command::Steady | Command::Stability(_) | Command::Compare(_) | Command::Reproduce(_) => Vec::new(),
        _ => return Ok(()),
    };
    Ok(set.check_symmetric(varied)?)
}
