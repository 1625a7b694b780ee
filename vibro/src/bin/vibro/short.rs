//! Studies of seconds, which need no parts on disk: from their arguments to the library's studies.

use crate::arguments::{Command, Compare, Manifold, Plane, Planes, Response, ResponseKind, Stability};
use crate::groups::{GroupPair, GroupRange};
use crate::progress::Progress;
use vibro::studies::{self, Study};
use vibro::{Error, Result};
use vibro_analysis::plane::{PAIRS, ParameterAxis};
use vibro_analysis::{Group, ParameterSet, find_group};

/// The last given range of a group, or the default.
fn range_of(given: &[GroupRange], name: &str, default: (f64, f64)) -> (f64, f64) {
    given.iter().rev().find(|range| range.group.name == name).map_or(default, |range| range.ends)
}

/// Refuses the first group that is none of the useful ones.
fn check_useful<'a>(
    given: impl IntoIterator<Item = &'a &'static Group>,
    useful: &[&str],
    expected: &'static str,
) -> Result<()> {
    match given.into_iter().find(|group| !useful.contains(&group.name)) {
        Some(useless) => Err(Error::form(useless.name, expected)),
        None => Ok(()),
    }
}

/// Whether a figure was asked for; all are where none is named.
fn wants(figures: &[String], figure: &str) -> bool {
    figures.is_empty() || figures.iter().any(|f| f == figure)
}

/// The results of a command whose names are known before it has worked; those of long studies are looked at with their parts.
/// The result for figure 19 has parameters of its own and is looked at when it is there.
pub fn names(command: &Command) -> Vec<String> {
    let figures = |stem: &str, all: &[&str], asked: &[String]| {
        all.iter().filter(|f| wants(asked, f)).map(|f| format!("{stem}-{f}")).collect()
    };
    match command {
        Command::Steady => vec!["steady".into()],
        Command::Plane(_) => vec!["plane".into()],
        Command::Response(a) => match a.kind {
            ResponseKind::Frequency => vec!["response-frequency".into()],
            ResponseKind::Force => vec!["response-force".into()],
            ResponseKind::Both => vec!["response-frequency".into(), "response-force".into()],
        },
        Command::Manifold(a) => figures("manifold", &["2", "7", "9"], &a.figure),
        Command::Stability(a) => figures("stability", &["5", "6"], &a.figure),
        Command::Compare(a) => figures("compare", &["8", "16", "17"], &a.figure),
        _ => Vec::new(),
    }
}

pub fn response(set: &ParameterSet, a: &Response) -> Result<Vec<Study>> {
    let values = || a.values.iter().map(|list| &list.group);
    check_useful(a.range.iter().map(|r| &r.group), &["sigma1", "f10"], "a range of sigma1 or f10")?;
    check_useful(values(), &["f10", "gamma1", "sigma1"], "values of f10, gamma1 or sigma1")?;
    let list = |name: &str, default: &[f64]| {
        a.values.iter().rev().find(|l| l.group.name == name).map_or(default.to_vec(), |l| l.values.clone())
    };
    let mut found = Vec::new();
    if a.kind != ResponseKind::Force {
        let range = range_of(&a.range, "sigma1", (-2.5, 2.5));
        let (forces, dampings) = (list("f10", &[1.0, 1.5, 2.0, 2.5]), list("gamma1", &[0.2, 0.5, 1.0, 1.5]));
        found.push(studies::frequency(set, range, &forces, &dampings)?);
    }
    if a.kind != ResponseKind::Frequency {
        let all = list("sigma1", &[0.2, 0.4, 0.8, 1.2, -0.2, -0.5, -0.8, -1.2]);
        let (above, below): (Vec<_>, Vec<_>) = all.into_iter().partition(|s| *s >= 0.0);
        found.push(studies::force(set, range_of(&a.range, "f10", (0.0, 4.0)), &above, &below)?);
    }
    Ok(found)
}

pub fn manifold(set: &ParameterSet, a: &Manifold) -> Result<Vec<Study>> {
    let mut found = Vec::new();
    if wants(&a.figure, "2") {
        found.push(studies::shapes(set)?);
    }
    if wants(&a.figure, "7") {
        found.push(studies::branches(set)?);
    }
    if wants(&a.figure, "9") {
        found.push(studies::families(set, a.values.group.name, &a.values.values)?);
    }
    Ok(found)
}

pub fn stability(set: &ParameterSet, a: &Stability) -> Result<Vec<Study>> {
    let mut found = Vec::new();
    if wants(&a.figure, "5") {
        found.push(studies::regions(set)?);
    }
    if wants(&a.figure, "6") {
        found.push(studies::masri(set)?);
    }
    Ok(found)
}

/// The axes of planes, horizontal first.
pub fn axes(a: &Planes, resolution: u16) -> Result<Vec<(ParameterAxis, ParameterAxis)>> {
    let pairs = if a.pair.is_empty() {
        let pair = |&(x, y): &(&str, &str)| Ok(GroupPair { x: find_group(x)?, y: find_group(y)? });
        PAIRS.iter().map(pair).collect::<Result<Vec<_>>>()?
    } else {
        a.pair.clone()
    };
    let drawn: Vec<_> = pairs.iter().flat_map(|pair| [pair.x.name, pair.y.name]).collect();
    check_useful(a.range.iter().map(|r| &r.group), &drawn, "a range of a group that is on an axis")?;
    let axis = |group: &'static Group| {
        ParameterAxis::new(group, range_of(&a.range, group.name, group.shown), resolution.into())
    };
    pairs.iter().map(|pair| Ok((axis(pair.x)?, axis(pair.y)?))).collect()
}

pub fn plane(set: &ParameterSet, a: &Plane) -> Result<Study> {
    let axes = axes(&a.planes, a.resolution)?;
    let progress = Progress::new(axes.len() * usize::from(a.resolution), "rows");
    studies::planes(set, &axes, a.method.into(), &|| progress.step())
}

/// `strong` makes the parameter set of figures 18 and 19.
pub fn compare(
    set: &ParameterSet,
    strong: &dyn Fn() -> Result<ParameterSet>,
    a: &Compare,
) -> Result<Vec<Study>> {
    check_useful([&a.range.group], &["f10"], "a range of f10")?;
    check_useful([&a.values.group], &["epsilon"], "values of epsilon")?;
    let mut found = Vec::new();
    if wants(&a.figure, "8") {
        found.push(studies::histories(set)?);
    }
    if wants(&a.figure, "16") {
        // Eight values are a part, each direction has its own.
        let progress = Progress::new(2 * usize::from(a.resolution).div_ceil(8), "parts of figure 16");
        let done = || progress.step();
        found.push(studies::force_overlay(set, a.range.ends, a.resolution.into(), &done)?);
    }
    if wants(&a.figure, "17") {
        found.push(studies::accuracy(set, &a.values.values)?);
    }
    if wants(&a.figure, "19") {
        found.push(studies::strong_case(&strong()?)?);
    }
    Ok(found)
}
