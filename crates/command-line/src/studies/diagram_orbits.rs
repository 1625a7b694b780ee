//! The branches of periodic orbits over a bifurcation diagram of a described machine, and the rows
//! of the diagram that lie on them.

use super::Study;
use super::branches::{branch_layers, list, listed, marks, or_empty};
use super::design_sweep::Labelled;
use super::orbits::{special_table, words};
use super::panels::{DIRECTIONS, reach, shaded};
use crate::Result;
use crate::table::{CsvRows, exact};
use crate::wording;
use rayon::prelude::*;
use std::collections::BTreeMap;
use vibro_figures::chart::{Axis, Figure, Panel};
use vibro_orbits::{
    Branch, Family, KeptPaths, Label, Orbit, OrbitPoint, PathOptions, Stability, TreeOptions, tree_on,
};
use vibro_studies::diagram::{DescribedPoint, DiagramRequest};
use vibro_studies::{Diagram, Machine, Maxima, Settled, Watcher, settled};

/// Limits of the number of values per direction that start branches.
const SEEDS: (usize, usize) = (24, 200);

/// The family of machines over the axis of a diagram.
///
/// # Errors
/// As [`Family::new`], for machines and parameters over which orbits cannot be followed.
pub fn diagram_family(machine: &Machine, request: &DiagramRequest<Machine>) -> Result<Family> {
    Ok(Family::new(machine, &request.axis.name, (request.axis.from, request.axis.to))?)
}

/// A periodic row of a diagram, with the branch on which it lies.
struct Row {
    direction: usize,
    value: f64,
    class: String,
    branch: Option<usize>,
}

/// A stable orbit at a value, with its motion as classified in a diagram.
struct Seen {
    branch: usize,
    settled: Settled,
}

/// The branches over the axis of a diagram, using the stored paths. `told` receives the number of
/// branches, and this number plus the known remaining starts.
///
/// # Errors
/// As [`diagram_family`].
pub fn diagram_branches(
    machine: &Machine,
    request: &DiagramRequest<Machine>,
    kept: &dyn KeptPaths,
    told: &dyn Fn(usize, usize),
) -> Result<(Family, Vec<Branch>)> {
    let family = diagram_family(machine, request)?;
    let options = TreeOptions {
        start: request.start.clone(),
        seeds: request.axis.count.clamp(SEEDS.0, SEEDS.1),
        discard: request.discard,
        path: PathOptions::default(),
        ..TreeOptions::default()
    };
    let branches = tree_on(&family, &options, kept, &mut |found, all| {
        told(found.len(), all);
        true
    })?;
    Ok((family, branches))
}

/// The study of the branches over a diagram: tables of the drawn curves, of special points and of
/// the diagram's periodic rows, and a picture.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output).
pub fn diagram_orbits(
    machine: &Machine,
    request: &DiagramRequest<Machine>,
    diagram: &Diagram<DescribedPoint>,
    (family, branches): (&Family, &[Branch]),
    name: &str,
) -> Result<Study> {
    let rows = rows(family, branches, diagram);
    let maxima = maxima(machine, request, branches)?;
    let parameter = &request.axis.name;
    let (of, what) = (request.of.to_string(), "branches of periodic orbits over the local maxima of");
    let what = format!("{} {what} {of} over {parameter}", branches.len());
    let d = &machine.description;
    let figure = Figure {
        title: format!("{}: periodic orbits over {}", wording::title(&d.name), wording::parameter(parameter)),
        caption: vec![
            "Orbits: full where stable, dashed where unstable; one colour for each period. Cells: motions of the diagram.".into(),
            format!("Elsewhere {}", machine.caption_but(std::slice::from_ref(parameter))),
        ],
        panels: vec![panel(machine, request, diagram, (branches, &maxima))?],
        columns: 1,
        panel: (2900, 1700),
        shared_legend: false,
    };
    Ok(Study {
        tables: vec![
            (name.into(), curve_table(family, &of, branches, &maxima)?),
            (format!("{name}-special-points"), special_table(family, branches)?),
            (format!("{name}-rows"), row_table(family, branches, &rows)?),
        ],
        figure: Some(figure),
        subject: machine.caption_of_all(std::slice::from_ref(parameter)),
        ..Study::without_figure(name, what).with_remarks(remarks(machine, parameter, &rows))
    })
}

/// The periodic rows of both directions with their branches.
fn rows(family: &Family, branches: &[Branch], diagram: &Diagram<DescribedPoint>) -> Vec<Row> {
    let mut at: BTreeMap<u64, Vec<(usize, &DescribedPoint)>> = BTreeMap::new();
    for (direction, points) in [&diagram.up, &diagram.down].into_iter().enumerate() {
        for point in points.iter().flatten().filter(|point| point.settled.class.is_periodic()) {
            at.entry(point.value.to_bits()).or_default().push((direction, point));
        }
    }
    let of = |points: &Vec<(usize, &DescribedPoint)>| -> Vec<Row> {
        let seen = seen(family, branches, points[0].1.value);
        let row = |(direction, point): &(usize, &DescribedPoint)| {
            let covers = |seen: &&Seen| seen.settled.differs(&point.settled) == Some(false);
            let branch = seen.iter().find(covers).map(|seen| seen.branch);
            Row { direction: *direction, value: point.value, class: point.settled.class.name(), branch }
        };
        points.iter().map(row).collect()
    };
    let all: Vec<&Vec<(usize, &DescribedPoint)>> = at.values().collect();
    let mut rows: Vec<Row> = all.into_par_iter().flat_map_iter(of).collect();
    rows.sort_by(|a, b| a.direction.cmp(&b.direction).then(a.value.total_cmp(&b.value)));
    rows
}

/// The stable orbits of all branches at a value, as motions that begin on them.
fn seen(family: &Family, branches: &[Branch], value: f64) -> Vec<Seen> {
    let of = |branch: &Branch, orbit: Orbit| {
        let (mut motion, section) = family.at(value).and_then(|m| m.motion(&orbit.start())).ok()?;
        Some(Seen { branch: branch.id, settled: settled(&mut motion, &section, None).ok()? })
    };
    let stable = |orbit: &Orbit| orbit.stability() == Stability::Stable;
    branches
        .iter()
        .filter(|branch| branch.is_somewhere_stable())
        .flat_map(|branch| {
            let orbits = branch.orbits_at(value).into_iter().filter(stable);
            orbits.filter_map(|orbit| of(branch, orbit)).collect::<Vec<_>>()
        })
        .collect()
}

/// The local maxima of the diagram's quantity along each branch, the largest first.
fn maxima(
    machine: &Machine,
    request: &DiagramRequest<Machine>,
    branches: &[Branch],
) -> Result<Vec<Vec<Vec<f64>>>> {
    let quantity = request.of.find(&machine.description)?.quantity;
    let of = |orbit: Orbit| -> Vec<f64> {
        let mut watcher = Watcher::of(&[], orbit.place().assembly.system().stops.len());
        watcher.maxima = Some(Maxima::new(quantity));
        // The first period shows whether the quantity is rising where the second one begins.
        orbit.observe(&mut [&mut watcher]);
        watcher.maxima.iter_mut().for_each(|m| m.found.clear());
        orbit.observe(&mut [&mut watcher]);
        let mut found = watcher.maxima.map_or(Vec::new(), |m| m.found);
        found.sort_by(|a, b| b.total_cmp(a));
        found
    };
    let along = |branch: &Branch| -> Vec<Vec<f64>> {
        let point = |point: &OrbitPoint| branch.orbit(point).map_or(Vec::new(), of);
        branch.points.iter().map(point).collect()
    };
    Ok(branches.par_iter().map(along).collect())
}

/// The curve of the k-th largest maximum along a branch (`k` from 0); NaN where there are fewer.
fn curve(maxima: &[Vec<f64>], k: usize) -> Vec<f64> {
    maxima.iter().map(|all| all.get(k).copied().unwrap_or(f64::NAN)).collect()
}

fn panel(
    machine: &Machine,
    request: &DiagramRequest<Machine>,
    diagram: &Diagram<DescribedPoint>,
    (branches, maxima): (&[Branch], &[Vec<Vec<f64>>]),
) -> Result<Panel> {
    let axis = &request.axis;
    let apart = diagram.apart();
    let range = reach(diagram, &|_, value| value, 0.0);
    let d = &machine.description;
    let (unit, of) = (request.of.find(d)?.unit, wording::quantity(d, &request.of));
    let mut layers = shaded((axis, request.keep), diagram, &apart, (range, &|_, value| value));
    let curves = branches.iter().zip(maxima).flat_map(|(branch, all)| {
        let most = all.iter().map(Vec::len).max().unwrap_or(0);
        (0..most).map(move |k| (branch, curve(all, k)))
    });
    layers.extend(branch_layers(curves));
    let tops: Vec<Vec<f64>> = maxima.iter().map(|all| curve(all, 0)).collect();
    layers.extend(marks(branches, &tops).layers);
    Ok(Panel {
        title: String::new(),
        x: Axis { range: Some(axis.edges()), ..machine.axis(&axis.name) },
        y: Axis { range: Some(range), ..wording::axis(&of, unit, range.0.abs().max(range.1.abs())) },
        layers,
    })
}

/// Table of the curves: the maxima of each orbit.
fn curve_table(family: &Family, of: &str, branches: &[Branch], maxima: &[Vec<Vec<f64>>]) -> Result<Vec<u8>> {
    let (parameter, column) = (family.parameter.as_str(), format!("{of}_maxima"));
    let header = ["branch", "point", "label", parameter, "periods", "stability", column.as_str()];
    let mut table = CsvRows::new(header)?;
    for (branch, maxima) in branches.iter().zip(maxima) {
        for (i, (point, maxima)) in branch.points.iter().zip(maxima).enumerate() {
            table.push([
                branch.id.to_string(),
                i.to_string(),
                point.label().map_or("", Label::name).into(),
                exact(point.value),
                or_empty(branch.periods),
                point.stability.to_string(),
                list(maxima.iter().copied()),
            ])?;
        }
    }
    table.text()
}

/// Table of the periodic rows with their branches.
fn row_table(family: &Family, branches: &[Branch], rows: &[Row]) -> Result<Vec<u8>> {
    let header = [family.parameter.as_str(), "direction", "class", "branch", "word", "not_covered"];
    let mut table = CsvRows::new(header)?;
    for row in rows {
        let branch = row.branch.map(|id| &branches[id]);
        table.push([
            exact(row.value),
            DIRECTIONS[row.direction].into(),
            row.class.clone(),
            or_empty(row.branch),
            or_empty(branch.map(|branch| words(family, branch))),
            if row.branch.is_some() { String::new() } else { "no branch".into() },
        ])?;
    }
    table.text()
}

/// Number of rows on a stable branch, and list of the others.
fn remarks(machine: &Machine, parameter: &str, rows: &[Row]) -> Vec<String> {
    let missing: Vec<&Row> = rows.iter().filter(|row| row.branch.is_none()).collect();
    let covered = rows.len() - missing.len();
    let told = |row: &&Row| {
        format!("{} {} ({})", machine.told(parameter, row.value), DIRECTIONS[row.direction], row.class)
    };
    let words =
        format!("{covered} of {} periodic rows of both directions lie on a stable branch", rows.len());
    let missing = listed("do not lie on a branch that was followed", missing.iter().map(told));
    [words].into_iter().chain(missing).collect()
}
