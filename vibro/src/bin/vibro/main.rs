//! `vibro`: arguments and printing; the studies are the library's (`vibro_impact::analysis`).

mod arguments;
mod long;
mod output;
mod progress;

use arguments::{Arguments, Command, Common, Kind};
use clap::Parser;
use progress::Progress;
use std::process::ExitCode;
use vibro::studies::{self, Study};
use vibro::words;
use vibro_analysis::plane::{PAIRS, PlaneAxis};
use vibro_analysis::{Error, Group, Result, Settings, find_group};

/// Exit code for input that is refused, as clap has it.
const USAGE: u8 = 2;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            if error.is_usage() { ExitCode::from(USAGE) } else { ExitCode::FAILURE }
        }
    }
}

fn run(arguments: &Arguments) -> Result<()> {
    let common = &arguments.common;
    if let Some(threads) = common.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into());
        pool.build_global().map_err(Error::output("threads"))?;
    }
    let settings = configured(Settings::basic(), common)?;
    let studies = match &arguments.command {
        Command::Steady => vec![studies::steady(&settings)?],
        Command::Response(a) => response(&settings, a)?,
        Command::Manifold(a) => manifold(&settings, a)?,
        Command::Stability(a) => stability(&settings, a)?,
        Command::Plane(a) => vec![plane(&settings, a)?],
        Command::Compare(a) => compare(&settings, common, a)?,
        Command::Bifurcation(a) => return long::bifurcation(&settings, common, a),
        Command::Lyapunov(a) => return long::lyapunov(&settings, common, a),
        Command::Basin(a) => return long::basin(&settings, common, a),
        Command::Isoperiodic(a) => {
            return long::isoperiodic(&settings, common, a, &axes(&a.planes, a.resolution)?);
        }
        Command::Merge(a) => return long::merge(common, a),
        Command::Reproduce(a) => return long::reproduce(&settings, common, a),
    };
    output::write(&studies, &common.out)?;
    output::print(&studies, &settings, &common.out)
}

fn configured(base: Settings, common: &Common) -> Result<Settings> {
    let mut settings = base;
    if let Some(path) = &common.config {
        settings.read(path)?;
    }
    settings.apply(&common.set)?;
    Ok(settings)
}

/// The last given range of a group, or the default.
fn range_of(given: &[(&Group, (f64, f64))], name: &str, default: (f64, f64)) -> (f64, f64) {
    given.iter().rev().find(|g| g.0.name == name).map_or(default, |g| g.1)
}

fn only(given: impl Iterator<Item = &'static str>, useful: &[&str], expected: &'static str) -> Result<()> {
    for name in given {
        if !useful.contains(&name) {
            return Err(Error::Form { text: name.into(), expected });
        }
    }
    Ok(())
}

fn response(settings: &Settings, a: &arguments::Response) -> Result<Vec<Study>> {
    let ranges = a.range.iter().map(|t| words::range(t)).collect::<Result<Vec<_>>>()?;
    let lists = a.values.iter().map(|t| words::values(t)).collect::<Result<Vec<_>>>()?;
    only(ranges.iter().map(|r| r.0.name), &["sigma1", "f10"], "a range of sigma1 or f10")?;
    only(lists.iter().map(|l| l.0.name), &["f10", "gamma1", "sigma1"], "values of f10, gamma1 or sigma1")?;
    let list = |name: &str, default: &[f64]| {
        lists.iter().rev().find(|l| l.0.name == name).map_or(default.to_vec(), |l| l.1.clone())
    };
    let mut found = Vec::new();
    if a.kind != Kind::Force {
        let range = range_of(&ranges, "sigma1", (-2.5, 2.5));
        let (forces, dampings) = (list("f10", &[1.0, 1.5, 2.0, 2.5]), list("gamma1", &[0.2, 0.5, 1.0, 1.5]));
        found.push(studies::frequency(settings, range, &forces, &dampings)?);
    }
    if a.kind != Kind::Frequency {
        let all = list("sigma1", &[0.2, 0.4, 0.8, 1.2, -0.2, -0.5, -0.8, -1.2]);
        let (above, below): (Vec<_>, Vec<_>) = all.into_iter().partition(|s| *s >= 0.0);
        found.push(studies::force(settings, range_of(&ranges, "f10", (0.0, 4.0)), &above, &below)?);
    }
    Ok(found)
}

fn wants(figures: &[String], figure: &str) -> bool {
    figures.is_empty() || figures.iter().any(|f| f == figure)
}

fn manifold(settings: &Settings, a: &arguments::Manifold) -> Result<Vec<Study>> {
    let (group, values) = words::values(&a.values)?;
    let mut found = Vec::new();
    if wants(&a.figure, "2") {
        found.push(studies::shapes(settings)?);
    }
    if wants(&a.figure, "7") {
        found.push(studies::branches(settings)?);
    }
    if wants(&a.figure, "9") {
        found.push(studies::families(settings, group.name, &values)?);
    }
    Ok(found)
}

fn stability(settings: &Settings, a: &arguments::Stability) -> Result<Vec<Study>> {
    let mut found = Vec::new();
    if wants(&a.figure, "5") {
        found.push(studies::regions(settings)?);
    }
    if wants(&a.figure, "6") {
        found.push(studies::masri(settings)?);
    }
    Ok(found)
}

/// The axes of planes, horizontal first.
fn axes(a: &arguments::Planes, resolution: u16) -> Result<Vec<(PlaneAxis, PlaneAxis)>> {
    let ranges = a.range.iter().map(|t| words::range(t)).collect::<Result<Vec<_>>>()?;
    let pairs = if a.pair.is_empty() {
        PAIRS.iter().map(|(x, y)| Ok((find_group(x)?, find_group(y)?))).collect::<Result<Vec<_>>>()?
    } else {
        a.pair.iter().map(|t| words::pair(t)).collect::<Result<Vec<_>>>()?
    };
    let drawn: Vec<_> = pairs.iter().flat_map(|(x, y)| [x.name, y.name]).collect();
    only(ranges.iter().map(|r| r.0.name), &drawn, "a range of a group that is on an axis")?;
    let axis = |group: &'static Group| {
        let shown = range_of(&ranges, group.name, group.shown);
        PlaneAxis::new(group, shown, resolution.into())
    };
    pairs.iter().map(|&(x, y)| Ok((axis(x)?, axis(y)?))).collect()
}

fn plane(settings: &Settings, a: &arguments::Plane) -> Result<Study> {
    let axes = axes(&a.planes, a.resolution)?;
    let progress = Progress::new(axes.len() * usize::from(a.resolution), "rows");
    studies::planes(settings, &axes, a.method.into(), &|| progress.step())
}

fn compare(settings: &Settings, common: &Common, a: &arguments::Compare) -> Result<Vec<Study>> {
    let (along, range) = words::range(&a.range)?;
    let (group, epsilons) = words::values(&a.values)?;
    only([along.name].into_iter(), &["f10"], "a range of f10")?;
    only([group.name].into_iter(), &["epsilon"], "values of epsilon")?;
    let mut found = Vec::new();
    if wants(&a.figure, "8") {
        found.push(studies::histories(settings)?);
    }
    if wants(&a.figure, "16") {
        // Eight values are a part, each direction has its own.
        let progress = Progress::new(2 * usize::from(a.resolution).div_ceil(8), "parts of figure 16");
        found.push(studies::force_overlay(settings, range, a.resolution.into(), &|| progress.step())?);
    }
    if wants(&a.figure, "17") {
        found.push(studies::accuracy(settings, &epsilons)?);
    }
    if wants(&a.figure, "19") {
        found.push(studies::strong_case(&configured(Settings::strong()?, common)?)?);
    }
    Ok(found)
}
