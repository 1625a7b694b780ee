//! `vibro`: arguments, files and printing. The library `vibro` contains the studies.

mod arguments;
mod common_arguments;
mod design_arguments;
mod destination;
mod earlier_fit;
mod fit_arguments;
mod interruption;
mod invocation;
mod loads;
mod loci;
mod long;
mod machine;
mod machine_basin;
mod machine_design;
mod machine_fit;
mod machine_orbits;
mod machine_studies;
mod missing_file;
mod orbits;
mod orbits_arguments;
mod output;
mod packing;
mod paper;
mod paper_words;
mod parsed;
mod plane_arguments;
mod progress;
mod ranges;
mod reduce_arguments;
mod reducing;
mod run;
mod short;
mod study_arguments;
mod sweep;
mod sweep_arguments;
#[cfg(feature = "reduce")]
mod verifying;
mod written_units;

use arguments::{Arguments, Command};
use clap::FromArgMatches;
use common_arguments::Common;
use destination::Destination;
use std::path::Path;
use std::process::ExitCode;
use vibro::{Error, Result, load_file, parameter_file, studies};
use vibro_studies::paper::{Name, ParameterSet, number, typed_unit};

/// Exit code for refused input, equal to clap's.
const USAGE: u8 = 2;

fn main() -> ExitCode {
    let (matches, grouped) = paper::without_group(parsed::matches());
    let mut arguments = Arguments::from_arg_matches(&matches).unwrap_or_else(|e| e.exit());
    arguments.common.invocation = invocation::invocation(&matches);
    let file = arguments::file(&matches);
    let clock = progress::Clock::start();
    let done = arguments::check_options(&matches, grouped).and_then(|()| run(&mut arguments, file));
    drop(clock);
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(interruption::INTERRUPTED as u8),
        Err(error) => {
            eprintln!("error: {error}");
            if error.is_usage() { ExitCode::from(USAGE) } else { ExitCode::FAILURE }
        }
    }
}

/// Carries out the command. Returns `false` if the computation was interrupted.
fn run(arguments: &mut Arguments, file: Option<&Path>) -> Result<bool> {
    if let Some(threads) = arguments.common.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into());
        pool.build_global().map_err(Error::output("threads"))?;
    }
    if let Some(file) = file {
        return machine::run(file, &arguments.command, &arguments.common);
    }
    arguments.command.read_axes()?;
    study(arguments).map(|()| true)
}

fn study(arguments: &mut Arguments) -> Result<()> {
    let common = &mut arguments.common;
    if let Command::Template(a) = &arguments.command {
        return output::say(parameter_file::template(a.groups).trim_end());
    }
    if let Command::New(a) = &arguments.command {
        return packing::begin(a);
    }
    if let Command::Reduce(a) = &arguments.command {
        return reducing::reduce(a, common);
    }
    if let Command::Sweep(a) = &arguments.command
        && a.list
    {
        return output::say(sweep::list().trim_end());
    }
    let mut set = configured(ParameterSet::basic(), common)?;
    print_notes(&unit_notes(common)?);
    if !set.not_given().is_empty() {
        progress::clear();
        eprintln!(
            "warning: the machine is given in SI, but not {}; these are the default machine's values. `vibro paper template` \
             writes a file with every parameter",
            set.not_given_values()
        );
    }
    let words = written_units::read_in(&mut arguments.command, &set)?;
    print_notes(&words.iter().filter_map(|w| w.remark.clone()).collect::<Vec<_>>());
    for option in words {
        common.invocation.options.insert(option.name.into(), option.words);
    }
    load_file::apply_constant(&mut set, &loads::of(&arguments.command)?)?;
    let common = &arguments.common;
    loads::check_theory(&set, &arguments.command)?;
    short::units(&arguments.command).into_iter().for_each(|(name, unit)| set.show_in(name, unit));
    // The folder is checked before work begins.
    let destination = Destination::new(common, &common.invocation, &set);
    let names = short::names(&arguments.command);
    destination.place(&names.iter().map(|name| destination.result(name)).collect::<Vec<_>>())?;
    let studies = match &arguments.command {
        Command::Steady => vec![studies::paper::steady(&set)?],
        Command::Run(a) => vec![run::run(&set, a)?],
        Command::Response(a) => short::response(&set, a)?,
        Command::Manifold(a) => short::manifold(&set, a)?,
        Command::Stability(a) => short::stability(&set, a)?,
        Command::Plane(a) => vec![short::plane(&set, a)?],
        Command::Compare(a) => short::compare(&set, &|| configured(ParameterSet::strong()?, common), a)?,
        Command::Bifurcation(a) => return long::bifurcation(&set, common, a),
        Command::Lyapunov(a) => return long::lyapunov(&set, common, a),
        Command::Basin(a) => return long::basin(&set, common, a),
        Command::Isoperiodic(a) => {
            let axes = short::axes(&set, &a.planes, a.resolution, 2..=3_000)?;
            return long::isoperiodic(&set, common, a, &axes);
        }
        Command::Sweep(a) => return sweep::sweep(&set, common, a),
        Command::Orbits(a) => match orbits::orbits(&set, common, a)? {
            Some(study) => vec![study],
            None => return Ok(()),
        },
        Command::Orbit(a) => vec![orbits::orbit(&set, a)?],
        Command::Locus(a) => vec![orbits::loci(&set, a)?],
        Command::Merge(a) => return long::merge(common, a),
        Command::Check { .. }
        | Command::Design(_)
        | Command::Draw { .. }
        | Command::Fit(_)
        | Command::Fmu(_)
        | Command::New(_)
        | Command::Reduce(_)
        | Command::Section(_)
        | Command::Template(_) => {
            return Ok(());
        }
        Command::Reproduce(a) => {
            let instead = "figures 6, 9, 10, 11 and 17 have the paper's values; leave out the \
                           value, or use the other commands for your machine";
            short::check_used(&set, "reproduce", &["f10", "gamma1", "sigma1", "epsilon", "mu13"], instead)?;
            return long::reproduce(&set, common, a);
        }
    };
    let held = destination::hold(&common.out);
    let out = destination.write(&studies)?;
    drop(held);
    output::print(&studies, &set, &out, common)
}

/// A parameter set with the changes of the parameter file and then the changes of `--set`.
fn configured(mut set: ParameterSet, common: &Common) -> Result<ParameterSet> {
    if let Some(path) = &common.config {
        parameter_file::read(&mut set, path)?;
    }
    if let Some(text) = common.set.iter().find(|text| text.trim_start().starts_with('=')) {
        return Err(Error::form(text, "NAME=VALUE, e.g. kappa=0.6"));
    }
    set.apply(&common.set)?;
    Ok(set)
}

/// Notes on the values of `--set` without a unit. Such a value is in the parameter's unit in the
/// file or in an earlier value.
fn unit_notes(common: &Common) -> Result<Vec<String>> {
    let mut set = ParameterSet::basic();
    if let Some(path) = &common.config {
        parameter_file::read(&mut set, path)?;
    }
    let mut told = Vec::new();
    for text in &common.set {
        let parts =
            text.split_once('=').and_then(|(name, value)| Some((Name::find(name.trim()).ok()?, value)));
        let Some((name, value)) = parts else { continue };
        match (typed_unit(name, value), set.unit(name)) {
            (None, Some(own)) if !own.is_si() && number(name, value).is_ok_and(|v| v != 0.0) => {
                told.push(ranges::note_of_unit(text, own))
            }
            (typed, _) => set.show_in(name, typed),
        }
    }
    Ok(told)
}

/// Prints notes on how input was read.
fn print_notes(words: &[String]) {
    words.iter().for_each(|words| note(words));
}

/// Prints a note.
fn note(words: &str) {
    progress::clear();
    eprintln!("note: {words}");
}
