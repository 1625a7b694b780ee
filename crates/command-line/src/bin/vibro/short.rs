//! Short studies, without parts on disk: conversion of arguments to the library's studies.

use crate::arguments::Command;
use crate::progress::Progress;
use crate::ranges::{ParameterPair, ParameterRange, ParameterValues, shown};
use crate::study_arguments::{
    Compare, Manifold, Plane, Planes, Response, ResponseKind, ResponseOfPaper, Stability,
};
use crate::sweep_arguments::AxisArgument;
use std::ops::RangeInclusive;
use vibro::studies::{self, Study};
use vibro::{Error, Result};
use vibro_studies::paper::plane::{PAIRS, ParameterAxis};
use vibro_studies::paper::{Name, ParameterSet, Unit};

/// Allowed numbers of values on an axis of a plane.
const PLANE: RangeInclusive<usize> = 2..=10_000;

/// The last given range of a parameter; without one, the default range, widened to contain the
/// value that was set.
fn range_of(set: &ParameterSet, given: &[ParameterRange], name: Name, default: (f64, f64)) -> ParameterRange {
    let found = given.iter().rev().find(|range| range.name == name);
    found.copied().unwrap_or_else(|| shown(set, name, default))
}

/// Values of a family of curves: the value that was set and the listed values, or the default if
/// there are neither.
fn members<'a>(
    set: &ParameterSet,
    name: Name,
    given: impl IntoIterator<Item = &'a ParameterValues>,
    default: &[f64],
) -> Vec<f64> {
    let listed = given.into_iter().filter(|list| list.name == name).last();
    let mut values = listed.map_or(Vec::new(), |list| list.values.clone());
    if set.is_set(name) {
        let own = name.value(set);
        if !values.iter().any(|v| (v - own).abs() <= 1e-12 * own.abs()) {
            values.insert(0, own);
        }
    } else if values.is_empty() {
        values = default.to_vec();
    }
    values
}

/// Refuses the first parameter that is not one of the useful parameters.
fn check_useful(
    option: &str,
    given: impl IntoIterator<Item = Name>,
    useful: &[&str],
    expected: &'static str,
) -> Result<()> {
    match given.into_iter().find(|name| !useful.contains(&name.name())) {
        Some(useless) => Err(Error::form(format!("{option} {}", useless.name()), expected)),
        None => Ok(()),
    }
}

/// Refuses a set value of a group if the figure has its own values.
pub fn check_used(set: &ParameterSet, figure: &str, unused: &[&str], instead: &str) -> Result<()> {
    match set.first_set(unused) {
        Some(name) => Err(Error::Refused {
            what: format!("{} = {}", name.name(), name.with_unit(name.value(set))),
            problem: format!("{figure} does not use this value: {instead}"),
        }),
        None => Ok(()),
    }
}

/// Whether a figure was requested; an empty list requests all figures.
fn wants(figures: &[String], figure: &str) -> bool {
    figures.is_empty() || figures.iter().any(|f| f == figure)
}

/// Names of the results of a short command. Results of long studies are checked with their parts,
/// and the result for figure 19, which has its own parameters, when it is written.
pub fn names(command: &Command) -> Vec<String> {
    let figures = |stem: &str, all: &[&str], asked: &[String]| {
        all.iter().filter(|f| wants(asked, f)).map(|f| format!("{stem}-{f}")).collect()
    };
    match command {
        Command::Steady => vec!["steady".into()],
        Command::Run(_) => vec!["run".into()],
        Command::Plane(_) => vec!["plane".into()],
        Command::Orbits(a) if !a.tree => vec!["orbits".into()],
        Command::Orbit(_) => vec!["orbit".into()],
        Command::Locus(_) => vec!["locus".into()],
        Command::Response(a) => {
            let kinds: &[&str] = match a.of_paper.kind {
                ResponseKind::Frequency => &["frequency"],
                ResponseKind::Force => &["force"],
                ResponseKind::Both => &["frequency", "force"],
            };
            let of = a.of_paper.of.map_or(String::new(), |of| format!("-{of}"));
            kinds.iter().map(|kind| format!("response-{kind}{of}")).collect()
        }
        Command::Manifold(a) => figures("manifold", &["2", "7", "9"], &a.figure),
        Command::Stability(a) => figures("stability", &["5", "6"], &a.figure),
        Command::Compare(a) => figures("compare", &["8", "16", "17"], &a.figure),
        _ => Vec::new(),
    }
}

/// Parameters of the command's ranges and lists with their typed units, for labels; the last of
/// several applies.
pub fn units(command: &Command) -> Vec<(Name, Option<&'static Unit>)> {
    let (ranges, values): (&[ParameterRange], &[ParameterValues]) = match command {
        Command::Response(a) => (&a.of_paper.range, &a.of_paper.values),
        Command::Manifold(a) => (&[], a.values.as_slice()),
        Command::Plane(a) => (&a.planes.range, &[]),
        Command::Isoperiodic(a) => (&a.planes.range, &[]),
        Command::Compare(a) => (a.range.as_slice(), a.values.as_slice()),
        Command::Bifurcation(a) => (a.of_paper.range.as_slice(), &[]),
        Command::Lyapunov(a) => (a.sweep.of_paper.range.as_slice(), &[]),
        Command::Sweep(a) => {
            return a.of_paper.vary.iter().chain(&a.of_paper.over).map(AxisArgument::written).collect();
        }
        _ => (&[], &[]),
    };
    values.iter().map(|v| (v.name, v.unit)).chain(ranges.iter().map(|r| (r.name, r.unit))).collect()
}

pub fn response(set: &ParameterSet, Response { of_paper: a, .. }: &Response) -> Result<Vec<Study>> {
    let (sigma1, f10, gamma1) = (Name::find("sigma1")?, Name::find("f10")?, Name::find("gamma1")?);
    let others: Vec<_> = a.range.iter().filter(|r| ![sigma1, f10].contains(&r.name)).collect();
    if !others.is_empty() {
        return others.into_iter().map(|range| along(set, range, a)).collect();
    }
    let members = |name, default: &[f64]| members(set, name, &a.values, default);
    let listed = || a.values.iter().map(|list| list.name);
    if let Some(range) = a.range.iter().find(|r| r.count.is_some()) {
        return Err(Error::form(range.name.name(), COUNT));
    }
    let (frequency, force) = (a.kind != ResponseKind::Force, a.kind != ResponseKind::Frequency);
    let (useful, expected): (&[&str], _) = match (frequency, force) {
        (true, true) => (&["f10", "gamma1", "sigma1"], "values of f10, gamma1 or sigma1"),
        (true, false) => (&["f10", "gamma1"], "values of f10 or gamma1 for the frequency response"),
        _ => (&["sigma1"], "values of sigma1 for the force response"),
    };
    check_useful("--values", listed(), useful, expected)?;
    let mut found = Vec::new();
    if frequency {
        let range = range_of(set, &a.range, sigma1, (-2.5, 2.5));
        let (forces, dampings) =
            (members(f10, &[1.0, 1.5, 2.0, 2.5]), members(gamma1, &[0.2, 0.5, 1.0, 1.5]));
        found.push(studies::paper::frequency(set, range.ends, (&forces, &dampings), a.of)?);
    }
    if force {
        let all = members(sigma1, &[0.2, 0.4, 0.8, 1.2, -0.2, -0.5, -0.8, -1.2]);
        let (above, below): (Vec<_>, Vec<_>) = all.into_iter().partition(|s| *s >= 0.0);
        let range = range_of(set, &a.range, f10, (0.0, 4.0));
        found.push(studies::paper::force(set, range.ends, (&above, &below), a.of)?);
    }
    Ok(found)
}

const COUNT: &str = "name=from:to without a count: the steps along a curve are chosen by the program";

/// The response along any parameter, for the listed values of one other parameter.
fn along(set: &ParameterSet, range: &ParameterRange, a: &ResponseOfPaper) -> Result<Study> {
    if range.count.is_some() {
        return Err(Error::form(range.name.name(), COUNT));
    }
    let (name, values) = match &a.values[..] {
        // The set itself is the only member.
        [] => {
            let [force, restitution] =
                if set.is_si() { ["drive.amplitude", "stop.restitution"] } else { ["f10", "kappa"] };
            let along_force = range.name.is_same_quantity(Name::find("f10")?);
            let name = Name::find(if along_force { restitution } else { force })?;
            (name, vec![name.value(set)])
        }
        [one] if !one.name.is_same_quantity(range.name) => (one.name, members(set, one.name, [one], &[])),
        [one] => return Err(Error::form(one.name.name(), "values of a parameter that is not the axis")),
        [_, other, ..] => return Err(Error::form(other.name.name(), "values of one parameter only")),
    };
    studies::paper::along(set, range.name, range.ends, (name, &values), a.of)
}

pub fn manifold(set: &ParameterSet, a: &Manifold) -> Result<Vec<Study>> {
    let mut found = Vec::new();
    if wants(&a.figure, "2") {
        found.push(studies::paper::shapes(set)?);
    }
    if wants(&a.figure, "7") {
        found.push(studies::paper::branches(set)?);
    }
    if wants(&a.figure, "9") {
        let name = a.values.as_ref().map_or_else(|| Name::find("f10"), |list| Ok(list.name))?;
        let values = members(set, name, &a.values, &[0.6, 1.2, 1.5, 2.5]);
        found.push(studies::paper::families(set, name, &values)?);
    }
    Ok(found)
}

pub fn stability(set: &ParameterSet, a: &Stability) -> Result<Vec<Study>> {
    let mut found = Vec::new();
    if wants(&a.figure, "5") {
        found.push(studies::paper::regions(set)?);
    }
    if wants(&a.figure, "6") {
        found.push(studies::paper::masri(set)?);
    }
    Ok(found)
}

/// The axes of planes, horizontal first.
pub fn axes(
    set: &ParameterSet,
    a: &Planes,
    resolution: u16,
    allowed: RangeInclusive<usize>,
) -> Result<Vec<(ParameterAxis, ParameterAxis)>> {
    let pairs = if a.pair.is_empty() {
        let pair = |&(x, y): &(&str, &str)| Ok(ParameterPair { x: Name::find(x)?, y: Name::find(y)? });
        PAIRS.iter().map(pair).collect::<Result<Vec<_>>>()?
    } else {
        a.pair.clone()
    };
    let drawn: Vec<_> = pairs.iter().flat_map(|pair| [pair.x.name(), pair.y.name()]).collect();
    let expected = "a range of a parameter that is on an axis";
    check_useful("--vary", a.range.iter().map(|r| r.name), &drawn, expected)?;
    let axis =
        |name: Name| range_of(set, &a.range, name, name.shown(set)).axis(resolution.into(), allowed.clone());
    pairs.iter().map(|pair| Ok((axis(pair.x)?, axis(pair.y)?))).collect()
}

pub fn plane(set: &ParameterSet, a: &Plane) -> Result<Study> {
    let axes = axes(set, &a.planes, a.resolution, PLANE)?;
    let progress = Progress::new(axes.iter().map(|(_, y)| y.count).sum(), "rows");
    studies::paper::planes(set, &axes, a.method.into(), &|| progress.step())
}

/// Comparisons of theory and simulation; `strong` makes the parameter set of figures 18 and 19.
pub fn compare(
    set: &ParameterSet,
    strong: &dyn Fn() -> Result<ParameterSet>,
    a: &Compare,
) -> Result<Vec<Study>> {
    check_useful("--vary", a.range.iter().map(|r| r.name), &["f10"], "a range of f10")?;
    check_useful("--values", a.values.iter().map(|v| v.name), &["epsilon"], "values of epsilon")?;
    let mut found = Vec::new();
    if wants(&a.figure, "8") {
        found.push(studies::paper::histories(set)?);
    }
    if wants(&a.figure, "16") {
        let given: Vec<_> = a.range.into_iter().collect();
        let range = range_of(set, &given, Name::find("f10")?, (0.5, 3.0));
        let axis = range.axis(a.resolution.into(), PLANE)?;
        // A part has eight values in one direction.
        let progress = Progress::new(2 * axis.count.div_ceil(8), "parts of the simulated maxima");
        let done = || progress.step();
        found.push(studies::paper::force_overlay(set, range.ends, axis.count, &done)?);
    }
    if wants(&a.figure, "17") {
        let values = members(set, Name::find("epsilon")?, &a.values, &[0.1, 0.05, 0.02, 0.01, 0.005]);
        found.push(studies::paper::accuracy(set, &values)?);
    }
    if wants(&a.figure, "19") {
        found.push(studies::paper::strong_case(&strong()?)?);
    }
    Ok(found)
}
